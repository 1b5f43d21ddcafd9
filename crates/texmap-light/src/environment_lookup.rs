//! Reflections: the light of an environment over the footprint of a mirrored ray.

mod on_face;

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::cube_face::Side;
use crate::environment::Environment;
use crate::environment::level::LevelTable;
use crate::lanes::Vector;
use crate::packed::UNIT;
use crate::reflect::RayLanes;
use crate::vector::{dot, usable};
use crate::{EnvironmentLayout, Ray};
use on_face::{Floats, LevelLanes, SharedExponent, Steps, Texels, on_face};

/// The largest square of a footprint, in texels, that is told from more.
const MOST: f32 = 1e30;

impl Environment {
    /// Light from the directions that a pixel sees: bilinear on the two levels around its footprint, if there are levels
    /// ([`with_mips`](Self::with_mips)), else on the only one. Zero and non-finite directions read as +Z.
    ///
    /// Coordinates are f32, off by less than 4e-7 of a face; [`radiance`](Self::radiance) is the reference without a footprint. A cube's
    /// footprint is that of its face coordinates (Vulkan 1.4, section Cube Map Derivative Transformation), another layout's that of its
    /// mean solid angle per texel.
    #[must_use]
    pub fn radiance_filtered(&self, ray: &Ray) -> [f32; 3] {
        self.radiance_lanes(Scalar, ray)
    }

    /// [`radiance_filtered`](Self::radiance_filtered) for the rays of a block; outside of semantic versioning.
    #[inline(always)]
    pub fn radiance_lanes<I: Isa>(&self, i: I, ray: &RayLanes<I>) -> Vector<I> {
        if self.layout == EnvironmentLayout::Cube {
            self.radiance_of_cube(i, ray)
        } else {
            self.radiance_of_chart(i, ray)
        }
    }

    #[inline(always)]
    fn radiance_of_cube<I: Isa>(&self, i: I, ray: &RayLanes<I>) -> Vector<I> {
        let (d, _) = usable(i, ray.direction);
        let side = Side::<I>::of(d);
        let [sc, tc, m] = side.along(d);
        let per_m = i.f32(1.0) / m;
        let (u, v) = (sc * per_m, tc * per_m);
        let texels = per_m * (0.5 * self.table.width[0] as f32);
        let dx = square_on_face(&side, ray.dx, u, v, texels);
        let dy = square_on_face(&side, ray.dy, u, v, texels);
        let place = [u * 0.5 + 0.5, v * 0.5 + 0.5];
        self.filtered::<I, true>(i, side.face(i), place, dx.above(dy))
    }

    /// Look-ups in other layouts. Out of line, so that kernels with cubes stay short.
    #[inline(never)]
    fn radiance_of_chart<I: Isa>(&self, i: I, ray: &RayLanes<I>) -> Vector<I> {
        i.vectorize(
            #[inline(always)]
            || {
                let (d, _) = usable(i, ray.direction);
                let (face, place) = self.layout.place(i, d);
                let rr = dot(ray.direction, ray.direction);
                let dx = square_of_angle(i, ray.direction, rr, ray.dx);
                let dy = square_of_angle(i, ray.direction, rr, ray.dy);
                let square = dx.above(dy) * self.texels_a_steradian();
                self.filtered::<I, false>(i, face, place, square)
            },
        )
    }

    fn texels_a_steradian(&self) -> f32 {
        let (width, height) = self.size();
        let texels = self.layout.faces() as f32 * width as f32 * height as f32;
        texels * (1.0 / (4.0 * core::f32::consts::PI))
    }

    /// The light at coordinates of faces, by squared footprints in texels. Faces are as wide as high if `SQUARE`.
    #[inline(always)]
    fn filtered<I: Isa, const SQUARE: bool>(
        &self,
        i: I,
        face: I::I32,
        [u, v]: [I::F32; 2],
        square: I::F32,
    ) -> Vector<I> {
        let packed = !self.packed.is_empty();
        let words = GatherTable::new(if packed {
            &self.packed[..]
        } else {
            bytemuck::cast_slice(self.texels.as_flattened())
        });
        let Some(words) = words else {
            return [i.f32(1.0); 3];
        };
        let square = square.clamp(i.f32(1.0), i.f32(MOST));
        let lod = half_log2(i, square).below(i.f32((self.levels.len() - 1) as f32));
        let level = lod.floor_to_i32();
        let k = lod - level.to_f32();
        if packed {
            let light = self
                .table
                .between::<I, SQUARE, Steps>(i, words, level, k, face, u, v);
            [light[0] * UNIT, light[1] * UNIT, light[2] * UNIT]
        } else {
            self.table
                .between::<I, SQUARE, Floats>(i, words, level, k, face, u, v)
        }
    }
}

impl LevelTable {
    /// Bilinear on a cube's levels around `lod`. Zero and non-finite directions read as +Z.
    #[inline(always)]
    pub(crate) fn level_lanes<I: Isa>(
        &self,
        i: I,
        words: GatherTable<'_>,
        lod: I::F32,
        direction: Vector<I>,
    ) -> Vector<I> {
        let (face, u, v) = face_coordinates(i, direction);
        let level = lod.floor_to_i32();
        let k = lod - level.to_f32();
        self.between::<I, true, SharedExponent>(i, words, level, k, face, u, v)
    }

    /// Bilinear on the first level of a cube and, if it is asked for, on the second of the same size, else the first again. Zero and
    /// non-finite directions read as +Z.
    #[inline(always)]
    pub(crate) fn first_two_lanes<I: Isa>(
        &self,
        i: I,
        words: GatherTable<'_>,
        direction: Vector<I>,
        second: bool,
    ) -> [Vector<I>; 2] {
        let (face, u, v) = face_coordinates(i, direction);
        let mut at = self.level(i, 0);
        let mut first = [i.f32(0.0); 3];
        for next in 0..2 {
            let light = on_face::<I, SharedExponent>(i, words, &at, face, u, v);
            if next == 1 {
                return [first, light];
            }
            first = light;
            if !second {
                break;
            }
            at.start = i.i32(self.start[1] as i32);
        }
        [first; 2]
    }

    /// A level, and `k` of the next; in the units of the texels.
    #[inline(always)]
    fn between<I: Isa, const SQUARE: bool, T: Texels>(
        &self,
        i: I,
        words: GatherTable<'_>,
        level: I::I32,
        k: I::F32,
        face: I::I32,
        u: I::F32,
        v: I::F32,
    ) -> Vector<I> {
        let mut levels = [0; 16];
        level.store(&mut levels);
        let first = levels[0];
        // Most vectors see one level.
        let same = level.simd_eq(first).all_true();
        let between = k.simd_gt(0.0);
        let mut out = [i.f32(0.0); 3];
        // A loop, so that the look-up is there once: twice as much code is not inlined whole.
        for next in 0..2 {
            let at = if same {
                self.level(i, first + next)
            } else {
                self.levels_of::<I, SQUARE>(i, level + next)
            };
            let light = on_face::<I, T>(i, words, &at, face, u, v);
            if next == 1 {
                for c in 0..3 {
                    let mixed = out[c] * (i.f32(1.0) - k) + light[c] * k;
                    out[c] = between.select(mixed, out[c]);
                }
            } else {
                out = light;
                if !between.any_true() {
                    break;
                }
            }
        }
        out
    }

    /// One level in all lanes.
    #[inline(always)]
    fn level<I: Isa>(&self, i: I, level: i32) -> LevelLanes<I> {
        let level = level as usize & 15;
        LevelLanes {
            start: i.i32(self.start[level] as i32),
            width: i.i32(self.width[level] as i32),
            height: i.i32(self.height[level] as i32),
        }
    }

    /// A level in each lane.
    #[inline(always)]
    fn levels_of<I: Isa, const SQUARE: bool>(&self, i: I, level: I::I32) -> LevelLanes<I> {
        let level = level.to_u32();
        let width = i.table16(&self.width, level).to_i32();
        LevelLanes {
            start: i.table16(&self.start, level).to_i32(),
            width,
            height: if SQUARE {
                width
            } else {
                i.table16(&self.height, level).to_i32()
            },
        }
    }
}

/// Face of a cube and coordinates on it, 0 to 1. Zero and non-finite directions are +Z.
#[inline(always)]
fn face_coordinates<I: Isa>(i: I, direction: Vector<I>) -> (I::I32, I::F32, I::F32) {
    let (d, _) = usable(i, direction);
    let side = Side::<I>::of(d);
    let [sc, tc, m] = side.along(d);
    let per_m = i.f32(0.5) / m;
    (side.face(i), sc * per_m + 0.5, tc * per_m + 0.5)
}

/// The square of a change of direction, in radians.
#[inline(always)]
fn square_of_angle<I: Isa>(_: I, r: Vector<I>, rr: I::F32, d: Vector<I>) -> I::F32 {
    let rd = dot(r, d);
    (dot(d, d) - rd * rd / rr) / rr
}

/// The square of a change of direction on a face, in texels.
#[inline(always)]
fn square_on_face<I: Isa>(
    side: &Side<I>,
    d: Vector<I>,
    u: I::F32,
    v: I::F32,
    texels: I::F32,
) -> I::F32 {
    let [ds, dt, dm] = side.along(d);
    let du = (ds - u * dm) * texels;
    let dv = (dt - v * dm) * texels;
    du * du + dv * dv
}

/// Half of log2 of a square, off by 0.005 at most: a parabola through each power of two.
#[inline(always)]
fn half_log2<I: Isa>(i: I, x: I::F32) -> I::F32 {
    let bits = x.to_bits();
    let e = ((bits >> 23).to_i32() - 127).to_f32();
    let m = (bits & 0x007f_ffff | i.u32(0x3f80_0000)).to_f32_bits();
    (e + ((i.f32(2.0) - m * (1.0 / 3.0)) * m - 5.0 / 3.0)) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{columns, load};
    use alloc::vec::Vec;

    /// Footprints choose the level. A stripe pattern fades to its mean as pixels grow, on every layout, and not without levels.
    #[test]
    fn wide_footprints_read_the_mean() {
        for chart in EnvironmentLayout::ALL {
            let mut bright = false;
            let stripes = Environment::from_fn(chart, 64, |_| {
                bright = !bright;
                [if bright { 1.0 } else { 0.0 }; 3]
            });
            let sharp = stripes.unwrap();
            let soft = sharp.clone().with_mips();
            let contrast = |environment: &Environment, step: f32| {
                let look = |i: u16| {
                    let x = f32::from(i) * 0.003;
                    let ray = Ray {
                        direction: [0.3 + x, 0.1, 1.0],
                        dx: [step, 0.0, 0.0],
                        dy: [0.0, step, 0.0],
                    };
                    (environment.radiance_filtered(&ray)[0] - 0.5).abs()
                };
                (0..100).map(look).fold(0.0, f32::max)
            };
            let (near, far) = (contrast(&soft, 1e-4), contrast(&soft, 0.3));
            assert!((near - contrast(&sharp, 1e-4)).abs() < 1e-6, "{chart:?}");
            assert!(near > 0.2 && far < 0.1, "{chart:?}: {near} {far}");
            assert!(contrast(&sharp, 0.3) > 0.2, "{chart:?}");
        }
    }

    /// Packed texels and floats give the same light, but for half a step on the smaller levels.
    #[test]
    fn packed_texels_are_off_by_half_a_step_at_most() {
        let packed = noise(EnvironmentLayout::Cube, 64).with_mips();
        assert!(!packed.packed.is_empty());
        let floats = Environment {
            packed: Vec::new(),
            ..packed.clone()
        };
        let mut largest = 0.0f32;
        for i in 0..2_000u16 {
            let x = f32::from(i);
            let step = 0.2 * (x * 0.37).sin().abs();
            let ray = Ray {
                direction: [(x * 0.7).sin(), (x * 1.3).cos(), (x * 0.31).sin()],
                dx: [step, 0.0, 0.3 * step],
                dy: [0.0, step, 0.0],
            };
            let (a, b) = (
                packed.radiance_filtered(&ray),
                floats.radiance_filtered(&ray),
            );
            for (a, b) in a.iter().zip(b) {
                largest = largest.max((a - b).abs());
            }
        }
        assert!(largest > 1e-5 && largest < 0.5 * UNIT + 1e-6, "{largest}");
    }

    fn noise(chart: EnvironmentLayout, size: u32) -> Environment {
        let mut seed = 3u32;
        let noise = Environment::from_fn(chart, size, |_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [8, 16, 24].map(|shift| f32::from((seed >> shift) as u8) / 255.0)
        });
        noise.unwrap()
    }

    /// Without levels the light is that of f64 coordinates within the error of f32 ones.
    #[test]
    fn light_across_is_light_where_there_are_no_levels() {
        for chart in EnvironmentLayout::ALL {
            let noise = noise(chart, 64);
            let mut largest = 0.0f32;
            for i in 0..3_000u16 {
                let x = f32::from(i);
                let direction = [(x * 0.7).sin(), (x * 1.3).cos(), (x * 0.31).sin()];
                let ray = Ray {
                    direction,
                    dx: [0.3; 3],
                    dy: [0.0; 3],
                };
                let (a, b) = (noise.radiance_filtered(&ray), noise.radiance(direction));
                for (a, b) in a.iter().zip(b) {
                    largest = largest.max((a - b).abs());
                }
            }
            // 4e-7 of 64 texels (128 of a lat-long layout), each up to 1 from the next, in two directions.
            assert!(largest > 0.0 && largest < 1.1e-4, "{chart:?}: {largest}");
        }
    }

    /// Every width gives the bits of one ray in every layout. Rays see one level or each its own, in packed texels and
    /// floats, without levels, at edges of faces, and along directions that are none.
    #[test]
    fn widths_agree() {
        for chart in EnvironmentLayout::ALL {
            let packed = noise(chart, 32).with_mips();
            let floats = Environment {
                packed: Vec::new(),
                ..packed.clone()
            };
            let odd = noise(chart, 21).with_mips();
            let flat = noise(chart, 9);
            assert!(!packed.packed.is_empty() && flat.packed.is_empty());
            for environment in [&packed, &floats, &odd, &flat] {
                check_widths(environment);
            }
        }
    }

    fn check_widths(environment: &Environment) {
        for steps in [[0.0; 2], [0.02, 0.0], [0.15, 0.0], [9.0, 0.0], [0.01, 0.4]] {
            for turn in 0..9u8 {
                let mut rays: [Ray; 16] = core::array::from_fn(|i| {
                    let x = i as f32 + 0.7 * f32::from(turn);
                    let step = steps[0] + steps[1] * x * 0.1;
                    let edge = if i % 3 == 0 { 1.0 } else { (x * 0.37).sin() };
                    Ray {
                        direction: [edge, 1.0 - 1.9 * (x * 0.9).sin().abs(), (x * 1.3).cos()],
                        dx: [step, 0.0, 0.3 * step],
                        dy: [0.0, step, 0.0],
                    }
                });
                if turn == 8 {
                    rays[2].direction = [0.0; 3];
                    rays[5].direction = [f32::NAN, 1.0, 0.0];
                    rays[9].direction = [0.0, f32::NEG_INFINITY, 0.0];
                    rays[11].direction = [0.0, -0.0, -1.0];
                    rays[12].dx = [f32::INFINITY; 3];
                }
                every_width!(i => check_rays(i, environment, &rays));
            }
        }
    }

    fn check_rays<I: Isa>(i: I, environment: &Environment, rays: &[Ray; 16]) {
        for first in (0..16).step_by(I::LANES) {
            let all = RayLanes {
                direction: load(i, &rays.map(|ray| ray.direction), first),
                dx: load(i, &rays.map(|ray| ray.dx), first),
                dy: load(i, &rays.map(|ray| ray.dy), first),
            };
            let got = columns(i, environment.radiance_lanes(i, &all));
            for (lane, ray) in rays[first..].iter().take(I::LANES).enumerate() {
                let one = environment.radiance_filtered(ray);
                assert!(one.iter().all(|c| c.is_finite()), "{ray:?}");
                assert_eq!(
                    got.map(|c| c[lane].to_bits()),
                    one.map(f32::to_bits),
                    "{:?} {ray:?}",
                    environment.layout
                );
            }
        }
    }

    /// Directions that are zero or not finite give light of the map.
    #[test]
    fn bad_rays_read_something_finite() {
        let sky = Environment::from_fn(EnvironmentLayout::Cube, 16, |_| [0.5; 3]).unwrap();
        let sky = sky.with_mips();
        for bad in [0.0, f32::NAN, f32::INFINITY, 1e30] {
            let ray = Ray {
                direction: [bad; 3],
                dx: [bad, 0.0, -bad],
                dy: [bad; 3],
            };
            let light = sky.radiance_filtered(&ray);
            assert!(
                light.iter().all(|c| (c - 0.5).abs() < 1e-6),
                "{bad}: {light:?}"
            );
        }
    }
}
