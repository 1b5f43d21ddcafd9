//! Gradient noise.

use texmap_math::simd::{Isa, Scalar, prelude::*};

use super::clamp;

/// Gradient noise at a point: -1 to 1, 0 at whole coordinates, features about one unit wide, twice continuously
/// differentiable (Perlin 2002, "Improving Noise": the twelve edge directions and 6t^5 - 15t^4 + 10t^3).
///
/// The gradients come from an integer hash of the cell and `seed`, so nothing repeats within 2^32 cells. A coordinate
/// that is not finite gives 0, as does one beyond 2^23, where floats have no fraction. Within 2e-6 of
/// [`reference::gradient_noise`](crate::reference::gradient_noise) of the same point.
pub fn gradient_noise(p: [f32; 3], seed: u32) -> f32 {
    noise_lanes(Scalar, p, seed)
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

/// [`gradient_noise`] for each lane. Out of line: compiled once a level, though asked for in many places.
#[inline(never)]
pub fn gradient_noise_lanes<I: Isa>(i: I, p: [I::F32; 3], seed: u32) -> I::F32 {
    i.vectorize(
        #[inline(always)]
        || noise_lanes(i, p, seed),
    )
}

#[inline(always)]
fn noise_lanes<I: Isa>(i: I, p: [I::F32; 3], seed: u32) -> I::F32 {
    let reach = in_reach::<I>(p);
    let (mut at, mut weight) = (p, p);
    let mut cell = [i.i32(0); 3];
    for k in 0..3 {
        let p = reach.select(p[k], i.f32(0.0));
        cell[k] = p.floor_to_i32();
        let t = p - cell[k].to_f32();
        at[k] = t;
        weight[k] = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    }
    let parts = HashParts::<I>::new(cell, seed);
    let [wx, wy, wz] = weight;
    let near = mix::<I>(parts.row(at, wx, 0, 0), parts.row(at, wx, 1, 0), wy);
    let far = mix::<I>(parts.row(at, wx, 0, 1), parts.row(at, wx, 1, 1), wy);
    let value = clamp(i, mix::<I>(near, far, wz), -1.0, 1.0);
    reach.select(value, i.f32(0.0))
}

#[inline(always)]
fn mix<I: Isa>(a: I::F32, b: I::F32, w: I::F32) -> I::F32 {
    a + (b - a) * w
}

/// Lanes where floats have a fraction.
#[inline(always)]
pub(super) fn in_reach<I: Isa>(p: [I::F32; 3]) -> I::Mask {
    let reach = 8_388_608.0;
    p[0].abs().simd_lt(reach) & p[1].abs().simd_lt(reach) & p[2].abs().simd_lt(reach)
}

/// The parts of [`hash`] that each coordinate of a cell's two sides gives.
struct HashParts<I: Isa> {
    x: [I::U32; 2],
    y: [I::U32; 2],
    z: [I::U32; 2],
}

impl<I: Isa> HashParts<I> {
    #[inline(always)]
    fn new([x, y, z]: [I::I32; 3], seed: u32) -> Self {
        let seed = seed.wrapping_mul(0x27d4_eb2f);
        let [x, y, z] = [
            sides::<I>(x, 0x9e37_79b1),
            sides::<I>(y, 0x85eb_ca77),
            sides::<I>(z, 0xc2b2_ae3d),
        ];
        Self {
            x: [x[0] ^ seed, x[1] ^ seed],
            y: [rotate::<I>(y[0], 11), rotate::<I>(y[1], 11)],
            z: [rotate::<I>(z[0], 22), rotate::<I>(z[1], 22)],
        }
    }

    /// Between two corners along x.
    #[inline(always)]
    fn row(&self, at: [I::F32; 3], wx: I::F32, y: usize, z: usize) -> I::F32 {
        let (left, right) = (self.corner(at, [0, y, z]), self.corner(at, [1, y, z]));
        mix::<I>(left, right, wx)
    }

    /// The gradient of a corner times the way from it.
    #[inline(always)]
    fn corner(&self, at: [I::F32; 3], [x, y, z]: [usize; 3]) -> I::F32 {
        let h = self.x[x] ^ self.y[y] ^ self.z[z];
        let h = (h ^ (h >> 16)) * 0x85eb_ca6b;
        let h = (h ^ (h >> 13)) * 0xc2b2_ae35;
        let h = h ^ (h >> 16);
        let from = [at[0] - x as f32, at[1] - y as f32, at[2] - z as f32];
        // As `edge` says.
        let kind = (h >> 28) & 3;
        let first = (h >> 31).simd_eq(1);
        let second = ((h >> 30) & 1).simd_eq(1);
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
fn sides<I: Isa>(c: I::I32, k: u32) -> [I::U32; 2] {
    let low = c.to_u32() * k;
    [low, low + k]
}

#[inline(always)]
fn rotate<I: Isa>(x: I::U32, by: u32) -> I::U32 {
    (x << by) | (x >> (32 - by))
}
