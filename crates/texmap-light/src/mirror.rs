//! Mirrors: the light of an environment over the footprint of a mirrored ray.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*, u32x16};
use texmap_math::lanes::{
    Words, floor_to_i32, floor_to_i32_scalar, gather, gather_pairs, gather_triples,
};

use crate::Chart;
use crate::environment::{Environment, Level};
use crate::lanes::V3;
use crate::packed::{UNIT, unpack, unpack_lanes};
use crate::reflect::{Ray, RayLanes};
use crate::vector::dot;

/// Sides of a cube's face along its coordinates and its axis, by face: the component that each is, and its sign.
const SIDES: [[(usize, f32); 3]; 6] = [
    [(2, -1.0), (1, -1.0), (0, 1.0)],
    [(2, 1.0), (1, -1.0), (0, -1.0)],
    [(0, 1.0), (2, 1.0), (1, 1.0)],
    [(0, 1.0), (2, -1.0), (1, -1.0)],
    [(0, 1.0), (1, -1.0), (2, 1.0)],
    [(0, -1.0), (1, -1.0), (2, -1.0)],
];

fn along(face: usize, d: [f32; 3]) -> [f32; 3] {
    SIDES[face].map(|(component, sign)| d[component] * sign)
}

/// Face of a finite direction that is not zero: z before y before x where components tie.
fn face_of([x, y, z]: [f32; 3]) -> usize {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if az >= ax && az >= ay {
        if z > 0.0 { 4 } else { 5 }
    } else if ay >= ax {
        if y > 0.0 { 2 } else { 3 }
    } else if x > 0.0 {
        0
    } else {
        1
    }
}

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
    /// ([`with_mips`](Self::with_mips)), else [`light`](Self::light). Zero and non-finite directions read as +Z.
    ///
    /// A cube's footprint is that of its face coordinates (Vulkan 1.4, section Cube Map Derivative Transformation), another chart's
    /// that of its mean solid angle per texel.
    #[must_use]
    pub fn light_across(&self, ray: &Ray) -> [f32; 3] {
        if self.levels.len() == 1 {
            return self.light(ray.direction);
        }
        if self.chart != Chart::Cube {
            let lod = self.level_by_angle(ray);
            let (face, uv) = self.locate(ray.direction);
            let at = |level: usize| self.bilinear(self.levels[level], face, uv);
            return self.between(lod, at);
        }
        let usable = ray.direction.iter().all(|c| c.is_finite()) && ray.direction != [0.0; 3];
        let d = if usable {
            ray.direction
        } else {
            [0.0, 0.0, 1.0]
        };
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
        let lod = self.level_of(if x > y { x } else { y });
        if self.packed.is_empty() {
            let texel = |at: usize| self.texels[at];
            return self.between(lod, |level| on_face(self.levels[level], face, place, texel));
        }
        let texel = |at: usize| unpack(self.packed[at]);
        let light = self.between(lod, |level| on_face(self.levels[level], face, place, texel));
        light.map(|c| c * UNIT)
    }

    /// Level of detail of a squared footprint in texels, from 0 to the last level; NaN reads as 0.
    fn level_of(&self, square: f32) -> f32 {
        let square = if square > 1.0 { square } else { 1.0 };
        let lod = half_log2(if square < MOST { square } else { MOST });
        let last = (self.levels.len() - 1) as f32;
        if lod < last { lod } else { last }
    }

    fn level_by_angle(&self, ray: &Ray) -> f32 {
        let (width, height) = self.size();
        let texels = self.chart.faces() as f32 * width as f32 * height as f32;
        let r = ray.direction;
        let square = |d: [f32; 3]| {
            let (rr, rd) = (dot(r, r), dot(r, d));
            (dot(d, d) * rr - rd * rd) / (rr * rr)
        };
        let (x, y) = (square(ray.dx), square(ray.dy));
        self.level_of((if x > y { x } else { y }) * texels * (1.0 / (4.0 * core::f32::consts::PI)))
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

/// Four texels of a cube's face.
fn on_face(
    level: Level,
    face: usize,
    place: [f32; 2],
    texel: impl Fn(usize) -> [f32; 3],
) -> [f32; 3] {
    let n = level.width as f32;
    let [(x, a), (y, b)] = place.map(|c| {
        let c = c * n + 0.5;
        let low = floor_to_i32_scalar(c);
        let low = if low < level.width as i32 {
            low
        } else {
            level.width as i32
        };
        (low, c - low as f32)
    });
    let stride = level.width as usize + 2;
    let first = level.start + (face * stride + y as usize) * stride + x as usize;
    let row = |at: usize| {
        let (p, q) = (texel(at), texel(at + 1));
        [0, 1, 2].map(|i| p[i] * (1.0 - a) + q[i] * a)
    };
    let (p, q) = (row(first), row(first + stride));
    [0, 1, 2].map(|i| p[i] * (1.0 - b) + q[i] * b)
}

/// Where the texels of a level begin, and how wide its faces are.
struct LevelLanes<S: Simd> {
    start: i32x16<S>,
    width: i32x16<S>,
}

/// An environment prepared for lanes.
#[derive(Clone, Debug)]
pub struct MirrorView<'a> {
    words: Words<'a>,
    /// A word a texel; else three floats.
    packed: bool,
    /// First texel of each level.
    starts: [u32; 16],
    width: i32,
    last: f32,
}

impl<'a> MirrorView<'a> {
    /// `None` where there are no lanes: for charts other than cubes, and cubes without levels.
    #[must_use]
    pub fn new(environment: &'a Environment) -> Option<Self> {
        let levels = &environment.levels;
        if environment.chart != Chart::Cube || !(2..=16).contains(&levels.len()) {
            return None;
        }
        let mut starts = [0; 16];
        for (start, level) in starts.iter_mut().zip(levels) {
            *start = level.start as u32;
        }
        let packed = !environment.packed.is_empty();
        let words = if packed {
            &environment.packed[..]
        } else {
            bytemuck::cast_slice(environment.texels.as_flattened())
        };
        Some(Self {
            words: Words::new(words)?,
            packed,
            starts,
            width: levels[0].width as i32,
            last: (levels.len() - 1) as f32,
        })
    }

    /// [`Environment::light_across`] for sixteen.
    #[inline(always)]
    pub fn light_lanes<S: Simd>(&self, s: S, ray: &RayLanes<S>) -> V3<S> {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let most = f32x16::splat(s, f32::MAX);
        let [x, y, z] = ray.direction;
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let finite = ax.simd_le(most) & ay.simd_le(most) & az.simd_le(most);
        let some = ax.simd_gt(zero) | ay.simd_gt(zero) | az.simd_gt(zero);
        let usable = finite & some;
        let (x, y, z) = (
            usable.select(x, zero),
            usable.select(y, zero),
            usable.select(z, one),
        );
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let by_z = az.simd_ge(ax) & az.simd_ge(ay);
        let by_y = ay.simd_ge(ax) & !by_z;
        let major = by_z.select(z, by_y.select(y, x));
        let up = major.simd_gt(zero);
        let side = Side { by_z, by_y, up };
        let [sc, tc, m] = side.along(s, [x, y, z]);
        let per_m = one / m;
        let (u, v) = (sc * per_m, tc * per_m);
        let texels = per_m * (0.5 * self.width as f32);
        let dx = side.square(s, ray.dx, u, v, texels);
        let dy = side.square(s, ray.dy, u, v, texels);
        let square = dx.simd_gt(dy).select(dx, dy);
        let square = square.simd_gt(one).select(square, one);
        let cap = f32x16::splat(s, MOST);
        let square = square.simd_lt(cap).select(square, cap);
        let lod = half_log2_lanes::<S>(s, square);
        let last = f32x16::splat(s, self.last);
        let lod = lod.simd_lt(last).select(lod, last);
        let level = floor_to_i32(s, lod);
        let k = lod - level.to_float::<f32x16<S>>();
        let face = side.face(s);
        let (u, v) = (u * 0.5 + 0.5, v * 0.5 + 0.5);
        if self.packed {
            let [r, g, b] = self.between_lanes::<S, true>(s, level, k, face, u, v);
            [r * UNIT, g * UNIT, b * UNIT]
        } else {
            self.between_lanes::<S, false>(s, level, k, face, u, v)
        }
    }

    /// A level, and `k` of the next; in the units of the texels.
    #[inline(always)]
    fn between_lanes<S: Simd, const PACKED: bool>(
        &self,
        s: S,
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
                self.levels(s, level + next)
            };
            let light = self.on_face_lanes::<S, PACKED>(s, &at, face, u, v);
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
        LevelLanes {
            start: i32x16::splat(s, start as i32),
            width: i32x16::splat(s, self.width >> level.clamp(0, 31)),
        }
    }

    /// A level in each lane.
    #[inline(always)]
    fn levels<S: Simd>(&self, s: S, level: i32x16<S>) -> LevelLanes<S> {
        LevelLanes {
            start: match Words::new(&self.starts) {
                Some(starts) => gather(s, starts, level.bitcast()).bitcast(),
                None => level,
            },
            width: i32x16::splat(s, self.width) >> level,
        }
    }

    #[inline(always)]
    fn on_face_lanes<S: Simd, const PACKED: bool>(
        &self,
        s: S,
        level: &LevelLanes<S>,
        face: i32x16<S>,
        u: f32x16<S>,
        v: f32x16<S>,
    ) -> V3<S> {
        let LevelLanes { start, width } = *level;
        let n = width.to_float::<f32x16<S>>();
        let (x, a) = place_lanes(s, u, n, width);
        let (y, b) = place_lanes(s, v, n, width);
        let stride = width + 2;
        let first = start + (face * stride + y) * stride + x;
        let one = f32x16::splat(s, 1.0);
        let (a1, b1) = (one - a, one - b);
        let [p, q] = self.two_lanes::<S, PACKED>(s, first);
        let mut top = p;
        for i in 0..3 {
            top[i] = p[i] * a1 + q[i] * a;
        }
        let [p, q] = self.two_lanes::<S, PACKED>(s, first + stride);
        let mut out = top;
        for i in 0..3 {
            let bottom = p[i] * a1 + q[i] * a;
            out[i] = top[i] * b1 + bottom * b;
        }
        out
    }

    /// A texel and the one to its right.
    #[inline(always)]
    fn two_lanes<S: Simd, const PACKED: bool>(&self, s: S, at: i32x16<S>) -> [V3<S>; 2] {
        if PACKED {
            let [left, right] = gather_pairs(s, self.words, at.bitcast());
            return [unpack_lanes(s, left), unpack_lanes(s, right)];
        }
        [self.texel_lanes(s, at), self.texel_lanes(s, at + 1)]
    }

    #[inline(always)]
    fn texel_lanes<S: Simd>(&self, s: S, at: i32x16<S>) -> V3<S> {
        let [r, g, b] = gather_triples(s, self.words, (at * 3).bitcast());
        [r.bitcast(), g.bitcast(), b.bitcast()]
    }
}

#[inline(always)]
fn place_lanes<S: Simd>(
    s: S,
    c: f32x16<S>,
    n: f32x16<S>,
    width: i32x16<S>,
) -> (i32x16<S>, f32x16<S>) {
    let c = c * n + 0.5;
    let low = floor_to_i32(s, c);
    let low = low.simd_lt(width).select(low, width);
    (low, c - low.to_float::<f32x16<S>>())
}

#[inline(always)]
fn half_log2_lanes<S: Simd>(s: S, x: f32x16<S>) -> f32x16<S> {
    let bits: u32x16<S> = x.bitcast();
    let e: i32x16<S> = (bits >> 23).bitcast();
    let e = (e - 127).to_float::<f32x16<S>>();
    let m: f32x16<S> = (bits & 0x007f_ffff | u32x16::splat(s, 0x3f80_0000)).bitcast();
    (e + ((2.0 - m * (1.0 / 3.0)) * m - 5.0 / 3.0)) * 0.5
}

/// The face of each lane.
#[derive(Clone, Copy)]
struct Side<S: Simd> {
    by_z: texmap_math::fearless_simd::mask32x16<S>,
    by_y: texmap_math::fearless_simd::mask32x16<S>,
    /// The positive one of two.
    up: texmap_math::fearless_simd::mask32x16<S>,
}

impl<S: Simd> Side<S> {
    /// [`along`] for sixteen.
    #[inline(always)]
    fn along(&self, _s: S, [x, y, z]: V3<S>) -> V3<S> {
        let up = self.up;
        // z: (x, -y, z) and (-x, -y, -z); y: (x, z, y) and (x, -z, -y); x: (-z, -y, x) and (z, -y, -x).
        let sx = self.by_y.select(x, up.select(x, -x));
        let sc = (self.by_z | self.by_y).select(sx, up.select(-z, z));
        let tc = self.by_y.select(up.select(z, -z), -y);
        let major = self.by_z.select(z, self.by_y.select(y, x));
        [sc, tc, up.select(major, -major)]
    }

    #[inline(always)]
    fn square(&self, s: S, d: V3<S>, u: f32x16<S>, v: f32x16<S>, texels: f32x16<S>) -> f32x16<S> {
        let [ds, dt, dm] = self.along(s, d);
        let du = (ds - u * dm) * texels;
        let dv = (dt - v * dm) * texels;
        du * du + dv * dv
    }

    #[inline(always)]
    fn face(&self, s: S) -> i32x16<S> {
        let (four, two, zero) = (
            i32x16::splat(s, 4),
            i32x16::splat(s, 2),
            i32x16::splat(s, 0),
        );
        let first = self.by_z.select(four, self.by_y.select(two, zero));
        self.up.select(first, first + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut seed = 7u32;
        let noise = Environment::from_fn(Chart::Cube, 64, |_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [8, 16, 24].map(|shift| f32::from((seed >> shift) as u8) / 255.0)
        });
        let packed = noise.unwrap().with_mips();
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

    /// Lanes give the bits of [`Environment::light_across`], where all see one level and where each sees its own, in packed texels and floats,
    /// at edges of faces too.
    #[test]
    fn lanes_see_what_one_ray_sees() {
        let mut seed = 3u32;
        let noise = Environment::from_fn(Chart::Cube, 32, |_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [8, 16, 24].map(|shift| f32::from((seed >> shift) as u8) / 255.0)
        });
        let packed = noise.unwrap().with_mips();
        let floats = Environment {
            packed: Vec::new(),
            ..packed.clone()
        };
        for environment in [&packed, &floats] {
            for steps in [[0.0; 2], [0.02, 0.0], [0.15, 0.0], [9.0, 0.0], [0.01, 0.4]] {
                let rays: [Ray; 16] = core::array::from_fn(|i| {
                    let x = i as f32;
                    let step = steps[0] + steps[1] * x * 0.1;
                    let edge = if i % 3 == 0 { 1.0 } else { (x * 0.37).sin() };
                    Ray {
                        direction: [edge, 1.0 - 0.4 * (x * 0.9).sin().abs(), (x * 1.3).cos()],
                        dx: [step, 0.0, 0.3 * step],
                        dy: [0.0, step, 0.0],
                    }
                });
                let of = |at: fn(&Ray) -> [f32; 3]| -> [[f32; 16]; 3] {
                    [0, 1, 2].map(|c| rays.map(|ray| at(&ray)[c]))
                };
                let columns = [of(|r| r.direction), of(|r| r.dx), of(|r| r.dy)];
                for level in [texmap_math::Level::new(), texmap_math::Level::baseline()] {
                    let mut got = [[0.0f32; 16]; 3];
                    texmap_math::on_level!(level, s => {
                        let [direction, dx, dy] =
                            columns.map(|v| v.map(|column| f32x16::from_slice(s, &column)));
                        let view = MirrorView::new(environment).unwrap();
                        let light = view.light_lanes(s, &RayLanes { direction, dx, dy });
                        for (to, c) in got.iter_mut().zip(light) {
                            c.store_slice(to);
                        }
                    }, else continue);
                    for (i, ray) in rays.iter().enumerate() {
                        let one = environment.light_across(ray);
                        assert_eq!(
                            got.map(|c| c[i].to_bits()),
                            one.map(f32::to_bits),
                            "{i} {steps:?}"
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
