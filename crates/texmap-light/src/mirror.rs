//! Mirrors: the light of an environment over the footprint of a mirrored ray.

mod on_face;

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*, u32x16};
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather};

use crate::Chart;
use crate::cube_face::{Side, along, face_of};
use crate::environment::Environment;
use crate::lanes::V3;
use crate::packed::{UNIT, unpack};
use crate::reflect::{Ray, RayLanes};
use crate::vector::{dot, dot_lanes, is_usable, usable_lanes};
use on_face::{LevelLanes, on_face, on_face_lanes};

/// Half of log2 of a square, off by 0.005 at most: a parabola through each power of two.
fn half_log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let e = ((bits >> 23) as i32 - 127) as f32;
    let m = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
    0.5 * (e + ((2.0 - m * (1.0 / 3.0)) * m - 5.0 / 3.0))
}

/// The largest square of a footprint, in texels, that is told from more.
const MOST: f32 = 1e30;

impl Environment {
    /// Light from the directions that a pixel sees: bilinear on the two levels around its footprint, if there are levels
    /// ([`with_mips`](Self::with_mips)), else on the only one. Zero and non-finite directions read as +Z.
    ///
    /// Places are f32, off by less than 4e-7 of a face; [`light`](Self::light) is the reference without a footprint. A cube's footprint is
    /// that of its face coordinates (Vulkan 1.4, section Cube Map Derivative Transformation), another chart's that of its mean solid
    /// angle per texel.
    #[must_use]
    pub fn light_across(&self, ray: &Ray) -> [f32; 3] {
        let d = if is_usable(ray.direction) {
            ray.direction
        } else {
            [0.0, 0.0, 1.0]
        };
        let (face, place, square) = match self.chart {
            Chart::Cube => self.on_cube(d, ray),
            chart => {
                let (face, place) = chart.place(d);
                (face, place, self.square_by_angle(ray))
            }
        };
        let lod = self.level_of(square);
        if self.packed.is_empty() {
            let texel = |at: usize| self.texels[at];
            return self.between(lod, |level| on_face(self.levels[level], face, place, texel));
        }
        let texel = |at: usize| unpack(self.packed[at]);
        let light = self.between(lod, |level| on_face(self.levels[level], face, place, texel));
        light.map(|c| c * UNIT)
    }

    /// Face, place and squared footprint of a ray along `d` on a cube.
    fn on_cube(&self, d: [f32; 3], ray: &Ray) -> (usize, [f32; 2], f32) {
        let face = face_of(d);
        let [s, t, m] = along(face, d);
        let per_m = 1.0 / m;
        let (u, v) = (s * per_m, t * per_m);
        let texels = 0.5 * self.levels[0].width as f32 * per_m;
        let square = |d: [f32; 3]| {
            let [ds, dt, dm] = along(face, d);
            let (du, dv) = ((ds - u * dm) * texels, (dt - v * dm) * texels);
            du * du + dv * dv
        };
        let (x, y) = (square(ray.dx), square(ray.dy));
        let place = [0.5 * u + 0.5, 0.5 * v + 0.5];
        (face, place, if x > y { x } else { y })
    }

    /// Level of detail of a squared footprint in texels, from 0 to the last level; NaN reads as 0.
    fn level_of(&self, square: f32) -> f32 {
        let square = if square > 1.0 { square } else { 1.0 };
        let lod = half_log2(if square < MOST { square } else { MOST });
        let last = (self.levels.len() - 1) as f32;
        if lod < last { lod } else { last }
    }

    fn square_by_angle(&self, ray: &Ray) -> f32 {
        let r = ray.direction;
        let square = |d: [f32; 3]| {
            let (rr, rd) = (dot(r, r), dot(r, d));
            (dot(d, d) - rd * rd / rr) / rr
        };
        let (x, y) = (square(ray.dx), square(ray.dy));
        (if x > y { x } else { y }) * self.texels_a_steradian()
    }

    fn texels_a_steradian(&self) -> f32 {
        let (width, height) = self.size();
        let texels = self.chart.faces() as f32 * width as f32 * height as f32;
        texels * (1.0 / (4.0 * core::f32::consts::PI))
    }

    fn between(&self, lod: f32, at: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let level = floor_to_i32_scalar(lod);
        let k = lod - level as f32;
        let near = at(level as usize);
        if k == 0.0 {
            return near;
        }
        let far = at(level as usize + 1);
        [0, 1, 2].map(|i| near[i] * (1.0 - k) + far[i] * k)
    }
}

/// An environment prepared for lanes.
#[derive(Clone, Debug)]
pub struct EnvironmentView<'a> {
    chart: Chart,
    words: &'a [u32],
    /// A word a texel; else three floats.
    packed: bool,
    /// First texel of each level.
    starts: [u32; 16],
    width: i32,
    height: i32,
    last: f32,
    texels_a_steradian: f32,
}

impl<'a> EnvironmentView<'a> {
    /// Prepares an environment.
    #[must_use]
    pub fn new(environment: &'a Environment) -> Self {
        let levels = &environment.levels;
        let mut starts = [0; 16];
        for (start, level) in starts.iter_mut().zip(levels) {
            *start = level.start as u32;
        }
        let packed = !environment.packed.is_empty();
        Self {
            chart: environment.chart,
            words: if packed {
                &environment.packed[..]
            } else {
                bytemuck::cast_slice(environment.texels.as_flattened())
            },
            packed,
            starts,
            width: levels[0].width as i32,
            height: levels[0].height as i32,
            last: (levels.len() - 1) as f32,
            texels_a_steradian: environment.texels_a_steradian(),
        }
    }

    /// [`Environment::light_across`] for sixteen.
    #[inline(always)]
    pub fn light_lanes<S: Simd>(&self, s: S, ray: &RayLanes<S>) -> V3<S> {
        if self.chart == Chart::Cube {
            self.cube_lanes(s, ray)
        } else {
            self.chart_lanes(s, ray)
        }
    }

    #[inline(always)]
    fn cube_lanes<S: Simd>(&self, s: S, ray: &RayLanes<S>) -> V3<S> {
        let (d, _) = usable_lanes(s, ray.direction);
        let side = Side::of(s, d);
        let [sc, tc, m] = side.along(d);
        let per_m = f32x16::splat(s, 1.0) / m;
        let (u, v) = (sc * per_m, tc * per_m);
        let texels = per_m * (0.5 * self.width as f32);
        let dx = square_lanes(&side, ray.dx, u, v, texels);
        let dy = square_lanes(&side, ray.dy, u, v, texels);
        let place = [u * 0.5 + 0.5, v * 0.5 + 0.5];
        self.texels::<S, true>(s, side.face(s), place, dx.simd_gt(dy).select(dx, dy))
    }

    /// Other charts. Out of line, so that kernels with cubes stay short.
    #[inline(never)]
    fn chart_lanes<S: Simd>(&self, s: S, ray: &RayLanes<S>) -> V3<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let (d, _) = usable_lanes(s, ray.direction);
                let (face, place) = self.chart.place_lanes(s, d);
                let rr = dot_lanes(ray.direction, ray.direction);
                let dx = square_by_angle_lanes(ray.direction, rr, ray.dx);
                let dy = square_by_angle_lanes(ray.direction, rr, ray.dy);
                let square = dx.simd_gt(dy).select(dx, dy) * self.texels_a_steradian;
                self.texels::<S, false>(s, face, place, square)
            },
        )
    }

    /// The light at places, by squared footprints in texels; faces are as wide as high if `SQUARE`.
    #[inline(always)]
    fn texels<S: Simd, const SQUARE: bool>(
        &self,
        s: S,
        face: i32x16<S>,
        [u, v]: [f32x16<S>; 2],
        square: f32x16<S>,
    ) -> V3<S> {
        let one = f32x16::splat(s, 1.0);
        let Some(words) = Words::new(self.words) else {
            return [one; 3];
        };
        let square = square.simd_gt(one).select(square, one);
        let cap = f32x16::splat(s, MOST);
        let square = square.simd_lt(cap).select(square, cap);
        let lod = half_log2_lanes::<S>(s, square);
        let last = f32x16::splat(s, self.last);
        let lod = lod.simd_lt(last).select(lod, last);
        let level = floor_to_i32(s, lod);
        let k = lod - level.to_float::<f32x16<S>>();
        if self.packed {
            let light = self.between::<S, SQUARE, true>(s, words, level, k, face, u, v);
            [light[0] * UNIT, light[1] * UNIT, light[2] * UNIT]
        } else {
            self.between::<S, SQUARE, false>(s, words, level, k, face, u, v)
        }
    }

    /// A level, and `k` of the next; in the units of the texels.
    #[inline(always)]
    fn between<S: Simd, const SQUARE: bool, const PACKED: bool>(
        &self,
        s: S,
        words: Words<'_>,
        level: i32x16<S>,
        k: f32x16<S>,
        face: i32x16<S>,
        u: f32x16<S>,
        v: f32x16<S>,
    ) -> V3<S> {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let first = level[0];
        // Most vectors see one level.
        let same = level.simd_eq(i32x16::splat(s, first)).all_true();
        let between = k.simd_gt(zero);
        let mut out = [zero; 3];
        // A loop, so that the look-up is there once: twice as much code is not inlined whole.
        for next in 0..2 {
            let at = if same {
                self.level(s, first + next)
            } else {
                self.levels::<S, SQUARE>(s, level + next)
            };
            let light = on_face_lanes::<S, PACKED>(s, words, &at, face, u, v);
            if next == 1 {
                for i in 0..3 {
                    let mixed = out[i] * (one - k) + light[i] * k;
                    out[i] = between.select(mixed, out[i]);
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
    fn level<S: Simd>(&self, s: S, level: i32) -> LevelLanes<S> {
        let start = self.starts.get(level as usize).copied().unwrap_or(0);
        let shift = level.clamp(0, 31);
        LevelLanes {
            start: i32x16::splat(s, start as i32),
            width: i32x16::splat(s, self.width >> shift),
            height: i32x16::splat(s, self.height >> shift),
        }
    }

    /// A level in each lane.
    #[inline(always)]
    fn levels<S: Simd, const SQUARE: bool>(&self, s: S, level: i32x16<S>) -> LevelLanes<S> {
        let width = i32x16::splat(s, self.width) >> level;
        LevelLanes {
            start: match Words::new(&self.starts) {
                Some(starts) => gather(s, starts, level.bitcast()).bitcast(),
                None => level,
            },
            width,
            height: if SQUARE {
                width
            } else {
                i32x16::splat(s, self.height) >> level
            },
        }
    }
}

#[inline(always)]
fn square_by_angle_lanes<S: Simd>(r: V3<S>, rr: f32x16<S>, d: V3<S>) -> f32x16<S> {
    let rd = dot_lanes(r, d);
    (dot_lanes(d, d) - rd * rd / rr) / rr
}

#[inline(always)]
fn half_log2_lanes<S: Simd>(s: S, x: f32x16<S>) -> f32x16<S> {
    let bits: u32x16<S> = x.bitcast();
    let e: i32x16<S> = (bits >> 23).bitcast();
    let e = (e - 127).to_float::<f32x16<S>>();
    let m: f32x16<S> = (bits & 0x007f_ffff | u32x16::splat(s, 0x3f80_0000)).bitcast();
    (e + ((2.0 - m * (1.0 / 3.0)) * m - 5.0 / 3.0)) * 0.5
}

/// The square of a change of direction on a face, in texels.
#[inline(always)]
fn square_lanes<S: Simd>(
    side: &Side<S>,
    d: V3<S>,
    u: f32x16<S>,
    v: f32x16<S>,
    texels: f32x16<S>,
) -> f32x16<S> {
    let [ds, dt, dm] = side.along(d);
    let du = (ds - u * dm) * texels;
    let dv = (dt - v * dm) * texels;
    du * du + dv * dv
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Footprints choose the level: a stripe pattern fades to its mean as pixels grow, on every chart, and not without levels.
    #[test]
    fn wide_footprints_read_the_mean() {
        for chart in Chart::ALL {
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
                    (environment.light_across(&ray)[0] - 0.5).abs()
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
        let packed = noise(Chart::Cube, 64).with_mips();
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
            let (a, b) = (packed.light_across(&ray), floats.light_across(&ray));
            for (a, b) in a.iter().zip(b) {
                largest = largest.max((a - b).abs());
            }
        }
        assert!(largest > 1e-5 && largest < 0.5 * UNIT + 1e-6, "{largest}");
    }

    fn noise(chart: Chart, size: u32) -> Environment {
        let mut seed = 3u32;
        let noise = Environment::from_fn(chart, size, |_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [8, 16, 24].map(|shift| f32::from((seed >> shift) as u8) / 255.0)
        });
        noise.unwrap()
    }

    /// Without levels it is the light of f64 places, but for what f32 ones lose.
    #[test]
    fn light_across_is_light_where_there_are_no_levels() {
        for chart in Chart::ALL {
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
                let (a, b) = (noise.light_across(&ray), noise.light(direction));
                for (a, b) in a.iter().zip(b) {
                    largest = largest.max((a - b).abs());
                }
            }
            // 4e-7 of 64 texels (128 of a lat-long chart), each up to 1 from the next, in two directions.
            assert!(largest > 0.0 && largest < 1.1e-4, "{chart:?}: {largest}");
        }
    }

    /// Lanes give the bits of [`Environment::light_across`] in every chart, where all see one level and where each sees its own, in packed
    /// texels and floats, without levels, at edges of faces, and along directions that are none.
    #[test]
    fn lanes_see_what_one_ray_sees() {
        for chart in Chart::ALL {
            let packed = noise(chart, 32).with_mips();
            let floats = Environment {
                packed: Vec::new(),
                ..packed.clone()
            };
            let odd = noise(chart, 21).with_mips();
            let flat = noise(chart, 9);
            assert!(!packed.packed.is_empty() && flat.packed.is_empty());
            for environment in [&packed, &floats, &odd, &flat] {
                check_lanes(environment);
            }
        }
    }

    fn check_lanes(environment: &Environment) {
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
                let of = |at: fn(&Ray) -> [f32; 3]| -> [[f32; 16]; 3] {
                    [0, 1, 2].map(|c| rays.map(|ray| at(&ray)[c]))
                };
                let columns = [of(|r| r.direction), of(|r| r.dx), of(|r| r.dy)];
                for level in [texmap_math::Level::new(), texmap_math::Level::baseline()] {
                    let mut got = [[0.0f32; 16]; 3];
                    texmap_math::on_level!(level, s => {
                        let [direction, dx, dy] =
                            columns.map(|v| v.map(|column| f32x16::from_slice(s, &column)));
                        let view = EnvironmentView::new(environment);
                        let light = view.light_lanes(s, &RayLanes { direction, dx, dy });
                        for (to, c) in got.iter_mut().zip(light) {
                            c.store_slice(to);
                        }
                    }, else continue);
                    for (i, ray) in rays.iter().enumerate() {
                        let one = environment.light_across(ray);
                        assert!(one.iter().all(|c| c.is_finite()), "{ray:?}");
                        assert_eq!(
                            got.map(|c| c[i].to_bits()),
                            one.map(f32::to_bits),
                            "{:?} {ray:?}",
                            environment.chart
                        );
                    }
                }
            }
        }
    }

    /// Neither zero nor what is not finite gives more than light of the map.
    #[test]
    fn bad_rays_read_something_finite() {
        let sky = Environment::from_fn(Chart::Cube, 16, |_| [0.5; 3]).unwrap();
        let sky = sky.with_mips();
        for bad in [0.0, f32::NAN, f32::INFINITY, 1e30] {
            let ray = Ray {
                direction: [bad; 3],
                dx: [bad, 0.0, -bad],
                dy: [bad; 3],
            };
            let light = sky.light_across(&ray);
            assert!(
                light.iter().all(|c| (c - 0.5).abs() < 1e-6),
                "{bad}: {light:?}"
            );
        }
    }
}
