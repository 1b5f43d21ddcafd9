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
        let ([sc, tc, m], up) = raised(i, side.along(d));
        let per_m = i.f32(1.0) / m;
        let (u, v) = (sc * per_m, tc * per_m);
        // Half of what they are raised by before squaring, the rest after: neither leaves f32.
        let texels = per_m * (0.5 * self.table.width[0] as f32) * up;
        let dx = square_on_face(&side, ray.dx, u, v, texels);
        let dy = square_on_face(&side, ray.dy, u, v, texels);
        let place = [u * 0.5 + 0.5, v * 0.5 + 0.5];
        let square = dx.above(dy) * up * up;
        self.filtered::<I, true>(i, side.face(i), place, square)
    }

    /// Look-ups in other layouts. Out of line, so that kernels with cubes stay short.
    #[inline(never)]
    fn radiance_of_chart<I: Isa>(&self, i: I, ray: &RayLanes<I>) -> Vector<I> {
        i.vectorize(
            #[inline(always)]
            || {
                let (d, _) = usable(i, ray.direction);
                let (face, place) = self.layout.place(i, d);
                let most = d[0].abs().above(d[1].abs()).above(d[2].abs());
                let usual = most.simd_gt(1e-9) & most.simd_lt(1e9);
                let mut ray = *ray;
                if !usual.all_true() {
                    // Fourth powers of others leave f32.
                    let by = usual.select(i.f32(1.0), most);
                    for k in 0..3 {
                        ray.direction[k] = ray.direction[k] / by;
                        ray.dx[k] = ray.dx[k] / by;
                        ray.dy[k] = ray.dy[k] / by;
                    }
                }
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

/// Vectors are raised by a power of two below this length.
const SHORT: f32 = 1.0 / (1u64 << 62) as f32;

/// The square root of that power.
const RAISE: f32 = (1u64 << 50) as f32;

/// Components on a face, raised where one over the largest would leave f32, and the factor that is in them twice.
#[inline(always)]
fn raised<I: Isa>(i: I, [sc, tc, m]: Vector<I>) -> (Vector<I>, I::F32) {
    let (short, one) = (m.simd_lt(SHORT), i.f32(1.0));
    if !short.any_true() {
        return ([sc, tc, m], one);
    }
    let up = short.select(i.f32(RAISE), one);
    ([sc * up * up, tc * up * up, m * up * up], up)
}

/// Face of a cube and coordinates on it, 0 to 1. Zero and non-finite directions are +Z.
#[inline(always)]
fn face_coordinates<I: Isa>(i: I, direction: Vector<I>) -> (I::I32, I::F32, I::F32) {
    let (d, _) = usable(i, direction);
    let side = Side::<I>::of(d);
    let ([sc, tc, m], _) = raised(i, side.along(d));
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
mod tests;
