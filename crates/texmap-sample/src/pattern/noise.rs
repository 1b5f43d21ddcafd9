//! Gradient noise, for one point and for sixteen.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::float;
use texmap_math::lanes::floor_to_i32;

use super::{clamp, clamp_lanes};

/// Gradient noise at a point: -1 to 1, 0 at whole coordinates, features about one unit wide, twice continuously
/// differentiable (Perlin 2002, "Improving Noise": the twelve edge directions and 6t^5 - 15t^4 + 10t^3).
///
/// The gradients come from an integer hash of the cell and `seed`, so nothing repeats within 2^32 cells. A coordinate
/// that is not finite gives 0, as does one beyond 2^23, where floats have no fraction. Within 2e-6 of
/// [`reference::gradient_noise`](crate::reference::gradient_noise) of the same point.
pub fn gradient_noise(p: [f32; 3], seed: u32) -> f32 {
    if !in_reach(p) {
        return 0.0;
    }
    let cell = p.map(float::floor_f32);
    let at = [p[0] - cell[0], p[1] - cell[1], p[2] - cell[2]];
    let cell = cell.map(|c| c as i32);
    let [wx, wy, wz] = at.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |x: i32, y: i32, z: i32| {
        let from = [at[0] - x as f32, at[1] - y as f32, at[2] - z as f32];
        let [a, b] = edge(hash([cell[0] + x, cell[1] + y, cell[2] + z], seed));
        let along = |(axis, negative): (usize, bool)| {
            if negative { -from[axis] } else { from[axis] }
        };
        along(a) + along(b)
    };
    let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
    let row = |y: i32, z: i32| mix(corner(0, y, z), corner(1, y, z), wx);
    let slice = |z: i32| mix(row(0, z), row(1, z), wy);
    let value = mix(slice(0), slice(1), wz);
    clamp(value, -1.0, 1.0)
}

/// Whether floats have a fraction there.
pub(super) fn in_reach(p: [f32; 3]) -> bool {
    p.iter().all(|x| x.abs() < 8_388_608.0)
}

/// One of the twelve edge directions of a cube as two axes with their signs; four of them come twice.
pub(crate) fn edge(hash: u32) -> [(usize, bool); 2] {
    let (first, second) = (hash >> 31 != 0, hash >> 30 & 1 != 0);
    match hash >> 28 & 3 {
        0 => [(0, first), (1, second)],
        1 => [(0, first), (2, second)],
        2 => [(1, first), (2, second)],
        // (1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, -1, -1), as in the paper.
        _ if first => [(1, true), (2, second)],
        _ => [(0, second), (1, false)],
    }
}

/// Every bit depends on every coordinate: odd multipliers, then the finisher of MurmurHash3 (Appleby 2011).
pub(crate) fn hash([x, y, z]: [i32; 3], seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77).rotate_left(11)
        ^ (z as u32).wrapping_mul(0xc2b2_ae3d).rotate_left(22)
        ^ seed.wrapping_mul(0x27d4_eb2f);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// [`gradient_noise`] for sixteen. Out of line: compiled once a level, though asked for in many places.
#[inline(never)]
pub fn gradient_noise_lanes<S: Simd>(s: S, p: [f32x16<S>; 3], seed: u32) -> f32x16<S> {
    s.vectorize(
        #[inline(always)]
        || noise_lanes(s, p, seed),
    )
}

#[inline(always)]
fn noise_lanes<S: Simd>(s: S, p: [f32x16<S>; 3], seed: u32) -> f32x16<S> {
    let zero = f32x16::splat(s, 0.0);
    let reach = in_reach_lanes(p);
    let (mut at, mut weight) = (p, p);
    let mut cell = [i32x16::splat(s, 0); 3];
    for k in 0..3 {
        let p = reach.select(p[k], zero);
        cell[k] = floor_to_i32(s, p);
        let t = p - cell[k].to_float::<f32x16<S>>();
        at[k] = t;
        weight[k] = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    }
    let parts = Parts::new(s, cell, seed);
    let [wx, wy, wz] = weight;
    let near = mix(
        mix(parts.corner(s, at, 0), parts.corner(s, at, 1), wx),
        mix(parts.corner(s, at, 2), parts.corner(s, at, 3), wx),
        wy,
    );
    let far = mix(
        mix(parts.corner(s, at, 4), parts.corner(s, at, 5), wx),
        mix(parts.corner(s, at, 6), parts.corner(s, at, 7), wx),
        wy,
    );
    let value = clamp_lanes(s, mix(near, far, wz), -1.0, 1.0);
    reach.select(value, zero)
}

#[inline(always)]
fn mix<S: Simd>(a: f32x16<S>, b: f32x16<S>, w: f32x16<S>) -> f32x16<S> {
    a + (b - a) * w
}

#[inline(always)]
pub(super) fn in_reach_lanes<S: Simd>(p: [f32x16<S>; 3]) -> mask32x16<S> {
    let reach = 8_388_608.0;
    p[0].abs().simd_lt(reach) & p[1].abs().simd_lt(reach) & p[2].abs().simd_lt(reach)
}

/// What each coordinate of a cell's two sides gives to the hash.
struct Parts<S: Simd> {
    x: [u32x16<S>; 2],
    y: [u32x16<S>; 2],
    z: [u32x16<S>; 2],
}

impl<S: Simd> Parts<S> {
    #[inline(always)]
    fn new(s: S, cell: [i32x16<S>; 3], seed: u32) -> Self {
        let [x, y, z] = cell;
        let seed = u32x16::splat(s, seed.wrapping_mul(0x27d4_eb2f));
        let [x, y, z] = [
            sides(x, 0x9e37_79b1),
            sides(y, 0x85eb_ca77),
            sides(z, 0xc2b2_ae3d),
        ];
        Self {
            x: [x[0] ^ seed, x[1] ^ seed],
            y: [rotate(y[0], 11), rotate(y[1], 11)],
            z: [rotate(z[0], 22), rotate(z[1], 22)],
        }
    }

    /// The gradient of a corner, its bits are x, y and z, times the way from it.
    #[inline(always)]
    fn corner(&self, s: S, at: [f32x16<S>; 3], corner: usize) -> f32x16<S> {
        let (i, j, k) = (corner & 1, corner >> 1 & 1, corner >> 2);
        let mut h = self.x[i] ^ self.y[j] ^ self.z[k];
        h = (h ^ (h >> 16)) * 0x85eb_ca6b;
        h = (h ^ (h >> 13)) * 0xc2b2_ae35;
        h ^= h >> 16;
        let from = [at[0] - i as f32, at[1] - j as f32, at[2] - k as f32];
        // As `edge` says.
        let (one, kind) = (u32x16::splat(s, 1), (h >> 28) & 3);
        let first = (h >> 31).simd_eq(one);
        let second = ((h >> 30) & 1).simd_eq(one);
        let (middle, last, other) = (kind.simd_eq(1), kind.simd_eq(2), kind.simd_eq(3));
        let turned = other & first;
        let a = (last | turned).select(from[1], from[0]);
        let b = (middle | last | turned).select(from[2], from[1]);
        let a = (first | (other & second)).select(-a, a);
        let b = (second & (!other | first)).select(-b, b);
        a + b
    }
}

/// A coordinate of a cell and the next one, times an odd number.
#[inline(always)]
fn sides<S: Simd>(c: i32x16<S>, k: u32) -> [u32x16<S>; 2] {
    let low = c.bitcast::<u32x16<S>>() * k;
    [low, low + k]
}

#[inline(always)]
fn rotate<S: Simd>(x: u32x16<S>, by: u32) -> u32x16<S> {
    (x << by) | (x >> (32 - by))
}
