//! Procedural bumps: the normal that a formula of heights in space leaves on a surface.

use core::f32::consts::TAU;

use texmap_light::lanes::{Vector, affine, bump_on, cross, dot};
use texmap_math::deterministic_f32;
use texmap_math::glam::{DMat4, DVec4};
use texmap_math::simd::{Isa, prelude::*};
use texmap_sample::lanes::gradient_noise_lanes;

use texmap_scene::ProceduralHeight;

/// A formula of heights, as the stages read it.
#[derive(Clone, Copy, Debug)]
pub struct ProceduralBump {
    heights: ProceduralHeight,
    /// World units.
    height: f32,
    /// Rows of solid space from world space.
    rows: [[f32; 4]; 3],
    /// Least step of the differences, world units.
    step: f32,
}

impl ProceduralBump {
    /// `height` in world units.
    pub fn new(heights: ProceduralHeight, world_from_solid: DMat4, height: f32) -> Self {
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

    /// The unit normals `n` turned by the slope of the heights along the surface (Perlin 1985), which is measured over half a pixel or
    /// the least step to each side; positions change by `dx` and `dy` to the right and down.
    #[inline(always)]
    pub(crate) fn normal<I: Isa>(
        &self,
        i: I,
        position: Vector<I>,
        [dx, dy]: [Vector<I>; 2],
        n: Vector<I>,
    ) -> Vector<I> {
        let pixel = dot(dx, dx).above(dot(dy, dy)).sqrt();
        let step = (pixel * 0.5).above(i.f32(self.step));
        let [t, b] = tangents(i, n);
        let flat = t[0].simd_eq(0.0) & t[1].simd_eq(0.0) & t[2].simd_eq(0.0);
        let useful = !flat & step.abs().simd_lt(f32::INFINITY);
        let b_u = self.slope(i, position, t, step, pixel);
        let b_v = self.slope(i, position, b, step, pixel);
        let turned = bump_on(i, n, t, b, b_u, b_v);
        [
            useful.select(turned[0], n[0]),
            useful.select(turned[1], n[1]),
            useful.select(turned[2], n[2]),
        ]
    }

    #[inline(always)]
    fn slope<I: Isa>(
        &self,
        i: I,
        position: Vector<I>,
        axis: Vector<I>,
        step: I::F32,
        pixel: I::F32,
    ) -> I::F32 {
        let (mut there, mut back) = (position, position);
        for k in 0..3 {
            there[k] = position[k] + step * axis[k];
            back[k] = position[k] + -step * axis[k];
        }
        let rise = self.value(i, there, pixel) - self.value(i, back, pixel);
        rise * self.height / (step * 2.0)
    }

    /// The heights at world positions, as a pixel of this width sees them. Out of line: it is asked for four times.
    #[inline(never)]
    fn value<I: Isa>(&self, i: I, p: Vector<I>, width: I::F32) -> I::F32 {
        i.vectorize(
            #[inline(always)]
            || self.value_inline(i, p, width),
        )
    }

    #[inline(always)]
    fn value_inline<I: Isa>(&self, i: I, p: Vector<I>, width: I::F32) -> I::F32 {
        let place = affine(&self.rows, p);
        // The least step is 1/512 of the shortest side of the unit.
        let width = width / (512.0 * self.step);
        let (around, fold) = match self.heights {
            ProceduralHeight::Pattern(pattern) => return pattern.value_lanes(i, place, width),
            ProceduralHeight::Waves { around, fold } => (f32::from(around), fold),
        };
        let mut noise = [i.f32(0.0); 2];
        if fold != 0.0 {
            noise = [
                gradient_noise_lanes(i, place, 1) * fold,
                gradient_noise_lanes(i, place, 2) * fold,
            ];
        }
        let [x, y, z] = place;
        let turns = deterministic_f32::atan2_lanes(i, z, x) / TAU * around + noise[0];
        let radius = (x * x + z * z).sqrt();
        // Waves narrower than a pixel fade to their mean, as do all towards the axis.
        let narrow = width * around / (radius * TAU);
        let first = wave(i, turns, narrow) * 0.5;
        first * wave(i, y + noise[1], width) + 0.5
    }
}

/// A wave of length 1, as a pixel of this width sees it: whole up to a quarter, nothing from three quarters on.
#[inline(always)]
fn wave<I: Isa>(i: I, turns: I::F32, width: I::F32) -> I::F32 {
    let left = i.f32(1.5) - width * 2.0;
    let seen = left.above(i.f32(0.0));
    let seen = left.simd_ge(1.0).select(i.f32(1.0), seen);
    seen * deterministic_f32::cos_lanes(i, (turns - turns.floor()) * TAU)
}

/// Two unit vectors square to a unit vector and to each other; zero for none.
#[inline(always)]
fn tangents<I: Isa>(i: I, n: Vector<I>) -> [Vector<I>; 2] {
    let ([x, y, z], zero) = (n, i.f32(0.0));
    let steep = x.abs().simd_gt(y.abs());
    let mut t = [
        steep.select(-z, zero),
        steep.select(zero, z),
        steep.select(x, -y),
    ];
    let length = dot(t, t).sqrt();
    let some = length.simd_gt(0.0) & length.simd_lt(f32::INFINITY);
    for c in &mut t {
        *c = some.select(*c / length, zero);
    }
    [t, cross(n, t)]
}
