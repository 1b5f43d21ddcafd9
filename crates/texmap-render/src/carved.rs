//! Procedural bumps: the normal that a formula of heights in space leaves on a surface.

use core::f32::consts::TAU;

use texmap_light::bump_on;
use texmap_light::lanes::{V3, affine, bump_on as bump_lanes, cross, dot};
use texmap_math::det32;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::glam::{DMat4, DVec4};
use texmap_math::lanes::above;
use texmap_math::simd::X16;
use texmap_sample::gradient_noise;
use texmap_sample::lanes::gradient_noise_lanes;

use crate::lit::Site;
use texmap_scene::Carving;

/// A formula of heights, as the stages read it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carved {
    heights: Carving,
    /// World units.
    height: f32,
    /// Rows of solid space from world space.
    rows: [[f32; 4]; 3],
    /// Least step of the differences, world units.
    step: f32,
}

impl Carved {
    /// `height` in world units.
    pub(crate) fn new(heights: Carving, world_from_solid: DMat4, height: f32) -> Self {
        let inverse = world_from_solid.inverse();
        let m = inverse.transpose();
        let row = |r: DVec4| r.to_array().map(|c| c as f32);
        let sides = [0, 1, 2].map(|k| world_from_solid.col(k).truncate().length());
        let side = sides.into_iter().fold(f64::INFINITY, f64::min);
        Self {
            heights,
            height,
            rows: [row(m.x_axis), row(m.y_axis), row(m.z_axis)],
            // Fine beside every feature of the patterns, coarse beside the rounding of a value.
            step: (side / 512.0) as f32,
        }
    }

    /// The unit normal `n` turned by the slope of the heights along the surface (Perlin 1985), which is measured over half a pixel or
    /// the least step to each side.
    pub(crate) fn normal(&self, at: &Site, n: [f32; 3]) -> [f32; 3] {
        let squared = |d: [f32; 3]| d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        let (x, y) = (squared(at.position_dx), squared(at.position_dy));
        let pixel = (if x > y { x } else { y }).sqrt();
        let step = if 0.5 * pixel > self.step {
            0.5 * pixel
        } else {
            self.step
        };
        let [t, b] = along(n);
        if t == [0.0; 3] || !step.is_finite() {
            return n;
        }
        let slope = |axis: [f32; 3]| {
            let there = |way: f32| [0, 1, 2].map(|k| at.position[k] + way * axis[k]);
            let rise = self.value(there(step), pixel) - self.value(there(-step), pixel);
            self.height * rise / (2.0 * step)
        };
        bump_on(n, t, b, slope(t), slope(b))
    }

    /// The height at a world position, as a pixel of this width sees it.
    fn value(&self, p: [f32; 3], width: f32) -> f32 {
        let [x, y, z] = self
            .rows
            .map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
        // The least step is 1/512 of the shortest side of the unit.
        let width = width / (512.0 * self.step);
        match self.heights {
            Carving::Pattern(pattern) => pattern.value([x, y, z], width),
            Carving::Waves { around, fold } => {
                let around = f32::from(around);
                let noise = |seed| {
                    if fold == 0.0 {
                        0.0
                    } else {
                        fold * gradient_noise([x, y, z], seed)
                    }
                };
                let turns = det32::atan2(z, x) / TAU * around + noise(1);
                let radius = (x * x + z * z).sqrt();
                // Waves narrower than a pixel fade to their mean, as do all towards the axis.
                let narrow = width * around / (TAU * radius);
                let wave = |turns: f32, width: f32| {
                    let turns = turns - turns.floor();
                    seen(width) * det32::cos(TAU * turns)
                };
                0.5 + 0.5 * wave(turns, narrow) * wave(y + noise(2), width)
            }
        }
    }
}

impl Carved {
    /// [`normal`](Self::normal) for sixteen: unit normals at positions, which change by `moves` to the right and down.
    #[inline(always)]
    pub(crate) fn normals<S: Simd>(
        &self,
        s: S,
        position: V3<S>,
        [dx, dy]: [V3<S>; 2],
        n: V3<S>,
    ) -> V3<S> {
        let zero = f32x16::splat(s, 0.0);
        let pixel = above(dot(dx, dx), dot(dy, dy)).sqrt();
        let step = above(pixel * 0.5, f32x16::splat(s, self.step));
        let [t, b] = along_lanes(s, n);
        let flat = t[0].simd_eq(zero) & t[1].simd_eq(zero) & t[2].simd_eq(zero);
        let useful = !flat & step.abs().simd_lt(f32::INFINITY);
        let (b_u, b_v) = (
            self.slope(s, position, t, step, pixel),
            self.slope(s, position, b, step, pixel),
        );
        let turned = bump_lanes(X16(s), n, t, b, b_u, b_v);
        [
            useful.select(turned[0], n[0]),
            useful.select(turned[1], n[1]),
            useful.select(turned[2], n[2]),
        ]
    }

    #[inline(always)]
    fn slope<S: Simd>(
        &self,
        s: S,
        position: V3<S>,
        axis: V3<S>,
        step: f32x16<S>,
        pixel: f32x16<S>,
    ) -> f32x16<S> {
        let (mut there, mut back) = (position, position);
        for k in 0..3 {
            there[k] = position[k] + step * axis[k];
            back[k] = position[k] + -step * axis[k];
        }
        let rise = self.values(s, there, pixel) - self.values(s, back, pixel);
        rise * self.height / (step * 2.0)
    }

    /// [`value`](Self::value) for sixteen. Out of line: it is asked for four times.
    #[inline(never)]
    fn values<S: Simd>(&self, s: S, p: V3<S>, width: f32x16<S>) -> f32x16<S> {
        s.vectorize(
            #[inline(always)]
            || self.values_lanes(s, p, width),
        )
    }

    #[inline(always)]
    fn values_lanes<S: Simd>(&self, s: S, p: V3<S>, width: f32x16<S>) -> f32x16<S> {
        let place = affine(&self.rows, p);
        let width = width / (512.0 * self.step);
        let (around, fold) = match self.heights {
            Carving::Pattern(pattern) => return pattern.value_lanes(s, place, width),
            Carving::Waves { around, fold } => (f32::from(around), fold),
        };
        let mut noise = [f32x16::splat(s, 0.0); 2];
        if fold != 0.0 {
            noise = [
                gradient_noise_lanes(s, place, 1) * fold,
                gradient_noise_lanes(s, place, 2) * fold,
            ];
        }
        let [x, y, z] = place;
        let turns = det32::atan2_lanes(X16(s), z, x) / TAU * around + noise[0];
        let radius = (x * x + z * z).sqrt();
        let narrow = width * around / (radius * TAU);
        let wave = wave_lanes(s, turns, narrow) * 0.5;
        wave * wave_lanes(s, y + noise[1], width) + 0.5
    }
}

/// A wave of length 1, as a pixel of this width sees it.
#[inline(always)]
fn wave_lanes<S: Simd>(s: S, turns: f32x16<S>, width: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    let left = 1.5 - width * 2.0;
    let seen = left.simd_gt(zero).select(left, zero);
    let seen = left.simd_ge(one).select(one, seen);
    seen * det32::cos_lanes(X16(s), (turns - turns.floor()) * TAU)
}

/// [`along`] for sixteen.
#[inline(always)]
fn along_lanes<S: Simd>(s: S, n: V3<S>) -> [V3<S>; 2] {
    let ([x, y, z], zero) = (n, f32x16::splat(s, 0.0));
    let steep = x.abs().simd_gt(y.abs());
    let mut t = [
        steep.select(-z, zero),
        steep.select(zero, z),
        steep.select(x, -y),
    ];
    let length = dot(t, t).sqrt();
    let some = length.simd_gt(zero) & length.simd_lt(f32::INFINITY);
    for c in &mut t {
        *c = some.select(*c / length, zero);
    }
    [t, cross(n, t)]
}

/// Two unit vectors square to a unit vector and to each other; zero for none.
fn along(n: [f32; 3]) -> [[f32; 3]; 2] {
    let [x, y, z] = n;
    let t = if x.abs() > y.abs() {
        [-z, 0.0, x]
    } else {
        [0.0, z, -y]
    };
    let length = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return [[0.0; 3]; 2];
    }
    let t = t.map(|c| c / length);
    let b = [
        y * t[2] - z * t[1],
        z * t[0] - x * t[2],
        x * t[1] - y * t[0],
    ];
    [t, b]
}

/// What is left of a wave of length 1 that a pixel of this width averages: 1 up to a quarter, nothing from three quarters on.
fn seen(width: f32) -> f32 {
    let left = 1.5 - 2.0 * width;
    if left >= 1.0 {
        1.0
    } else if left > 0.0 {
        left
    } else {
        0.0
    }
}
