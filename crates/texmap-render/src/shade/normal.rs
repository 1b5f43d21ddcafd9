//! Normals: bump and offset maps, normal maps and procedural bumps turn those of the vertices.

use texmap_light::lanes::{Vector, bump_on, clamp_to_horizon, unit};
use texmap_light::{NormalMap, NormalMapGreen};
use texmap_math::glam::DMat3;
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{Varying, Varyings};
use texmap_sample::{Origin, sample_soa};

use super::batch::{BatchUv, Colors, LANES, flip, load, load_changes, load_vector, straight};
use super::fetch::{PackedTexels, Texels, pixel_samples};
use super::procedural::ProceduralBump;
use crate::textures::Slot;

/// The normal detail of a surface.
pub(crate) enum NormalSource<'s> {
    /// A height map.
    Bump(Slot<'s>, Rise),
    /// A map of slopes.
    Offsets(Slot<'s>, Rise, NormalMapGreen),
    Procedural(ProceduralBump),
    Map(Slot<'s>, NormalMap, NormalSpace),
}

/// The height of a value of 1.
#[derive(Clone, Copy)]
pub(crate) struct Rise {
    /// Units of the object.
    pub(crate) height: f32,
    /// World units of one of them.
    pub(crate) unit: f32,
}

/// The space of the vectors of a normal map.
#[derive(Clone, Copy)]
pub(crate) enum NormalSpace {
    /// The object; normals go to the world by this.
    Object(DMat3),
    /// Tangent frames, which are attributes from here on.
    Tangent(usize),
}

/// The normal stage of a surface.
pub(crate) struct NormalStage<'a> {
    pub(crate) detail: Option<&'a NormalSource<'a>>,
    /// The texels of a normal map are the second of the pair: see [`TexturePair`](super::fetch::TexturePair).
    pub(crate) paired: bool,
    /// Normals turned away from the eye are brought back to the horizon.
    pub(crate) horizon_clamp: bool,
}

/// Vectors that normals are computed from, in columns.
pub(crate) struct Vectors<'a> {
    pub(crate) normal: &'a [Varying; 3],
    pub(crate) position: Option<&'a [Varying; 3]>,
    /// And the sign of the bitangent.
    pub(crate) tangent: &'a [Varying; 4],
}

/// Texels that normals are computed from.
#[derive(Default)]
pub(crate) struct NormalTexels {
    map: Texels,
    slopes: Slopes,
}

/// Slopes of a bump or offset map over a batch.
#[derive(Default)]
struct Slopes {
    /// Coordinates of the slot.
    placed: Varyings,
    /// Coordinates beside them.
    beside: BatchUv,
    colors: Colors,
    /// Rise along u and v, world units.
    rise: BatchUv,
}

impl NormalStage<'_> {
    /// True if the detail reads columns of coordinates.
    pub(crate) fn reads_uv(&self) -> bool {
        match self.detail {
            Some(NormalSource::Bump(..) | NormalSource::Offsets(..)) => true,
            Some(NormalSource::Map(..)) => !self.paired,
            _ => false,
        }
    }

    /// True if vectors without further attributes and the texels of the pair suffice.
    pub(crate) fn is_short(&self) -> bool {
        self.detail.is_none() || self.paired
    }

    /// First attribute of the tangent frames.
    pub(crate) fn tangent(&self) -> Option<usize> {
        match self.detail {
            Some(NormalSource::Map(_, _, NormalSpace::Tangent(first))) => Some(*first),
            _ => None,
        }
    }

    /// Reads the texels of `blocks` blocks at columns 0 and 1 of `uv`.
    pub(crate) fn fetch(&self, level: Level, uv: &Varyings, blocks: usize, out: &mut NormalTexels) {
        match self.detail {
            Some(NormalSource::Map(slot, ..)) if !self.paired => {
                out.map.fetch(level, slot, uv, blocks);
            }
            Some(NormalSource::Bump(slot, rise)) => {
                out.slopes.place(slot, uv, blocks);
                out.slopes.differences(level, slot, blocks, rise);
            }
            Some(NormalSource::Offsets(slot, rise, green)) => {
                let slopes = &mut out.slopes;
                slopes.place(slot, uv, blocks);
                slopes.look_up(level, slot, blocks, false);
                // The slot counts v down the picture, or up it from a bottom-left origin.
                let up =
                    (*green == NormalMapGreen::Up) != (slot.texture.origin() == Origin::BottomLeft);
                dispatch_simd!(level, i => slopes.offsets(i, blocks, up, rise));
            }
            _ => {}
        }
    }

    /// Unit normals from the unit normals of the vertices on the side that is seen; `toward_eye` are unit directions.
    /// Without `ALL` the detail is none or a normal map of the pair.
    #[inline(always)]
    pub(crate) fn normal<I: Isa, const ALL: bool>(
        &self,
        i: I,
        at: usize,
        vectors: &Vectors<'_>,
        (pair, read): (&PackedTexels, &NormalTexels),
        back: I::Mask,
        smooth: Vector<I>,
        toward_eye: Vector<I>,
    ) -> Vector<I> {
        let normal = match self.detail {
            None => return smooth,
            Some(NormalSource::Map(_, map, space)) => {
                let texel = if !ALL || self.paired {
                    let [r, g, b, _] = pair.load(i, at);
                    [r, g, b]
                } else {
                    read.map.straight(i, at)
                };
                match space {
                    NormalSpace::Object(to_world) => {
                        let world = transform(i, to_world, map.decode(i, texel));
                        unit(i, flip(i, back, world))
                    }
                    NormalSpace::Tangent(_) => {
                        let [x, y, z, w] = vectors.tangent;
                        let tangent = [
                            load(i, &x.value, at),
                            load(i, &y.value, at),
                            load(i, &z.value, at),
                        ];
                        // The frame belongs to the front; on the back N and so B are flipped with it.
                        let sign = load(i, &w.value, at);
                        let sign = back.select(-sign, sign);
                        let sign = sign.simd_lt(0.0).select(i.f32(-1.0), i.f32(1.0));
                        map.apply(i, smooth, tangent, sign, texel)
                    }
                }
            }
            Some(_) if !ALL => smooth,
            Some(detail) => match (detail, vectors.position) {
                (NormalSource::Procedural(bump), Some(position)) => {
                    let changes = load_changes(i, position, at);
                    bump.normal(i, load_vector(i, position, at), changes, smooth)
                }
                (_, Some(position)) => {
                    let changes = load_changes(i, position, at);
                    read.slopes.bump(i, at, smooth, changes)
                }
                (_, None) => smooth,
            },
        };
        if self.horizon_clamp {
            clamp_to_horizon(i, normal, toward_eye)
        } else {
            normal
        }
    }
}

impl Slopes {
    /// The coordinates of the slot.
    fn place(&mut self, slot: &Slot<'_>, uv: &Varyings, blocks: usize) {
        self.placed.varyings.clear();
        let columns = uv.varyings.iter().take(2).cloned();
        self.placed.varyings.extend(columns);
        slot.place_columns(&mut self.placed, blocks * LANES);
    }

    /// The texels of a batch at its coordinates, or `beside` them.
    fn look_up(&mut self, level: Level, slot: &Slot<'_>, blocks: usize, beside: bool) {
        let count = blocks * LANES;
        let mut at = pixel_samples(slot, &self.placed, count);
        if beside {
            (at.u, at.v) = (&self.beside.u[..count], &self.beside.v[..count]);
        }
        let columns = self.colors.columns_mut(count);
        sample_soa(level, &slot.sampler, &slot.texture, &at, columns)
            .expect("the columns have one length");
    }

    #[inline(always)]
    fn offsets<I: Isa>(&mut self, i: I, blocks: usize, up: bool, rise: &Rise) {
        for at in (0..blocks * LANES).step_by(I::LANES) {
            let [r, g, _] = straight(i, self.colors.load(i, at));
            let (x, y) = (r * 2.0 - 1.0, g * 2.0 - 1.0);
            let y = if up { -y } else { y };
            self.rise.store(i, at, in_world([x, y], rise));
        }
    }

    /// Slopes of a height map over u and v: central differences over a texel to each side, or over the pixel where that is wider.
    fn differences(&mut self, level: Level, slot: &Slot<'_>, blocks: usize, rise: &Rise) {
        let (width, height) = (slot.texture.width(), slot.texture.height());
        for (axis, texels) in [width, height].into_iter().enumerate() {
            let texel = 1.0 / texels as f32;
            dispatch_simd!(level, i => self.step(i, blocks, axis, texel));
            self.look_up(level, slot, blocks, true);
            dispatch_simd!(level, i => self.step_back(i, blocks, axis, texel));
            self.look_up(level, slot, blocks, true);
            dispatch_simd!(level, i => self.difference(i, blocks, axis, texel));
        }
        dispatch_simd!(level, i => self.scale(i, blocks, rise));
    }

    /// Coordinates beside those of the batch, along an axis.
    #[inline(always)]
    fn step<I: Isa>(&mut self, i: I, blocks: usize, axis: usize, texel: f32) {
        for at in (0..blocks * LANES).step_by(I::LANES) {
            let mut uv = self.uv(i, at);
            uv[axis] = uv[axis] + self.width(i, at, axis, texel);
            self.beside.store(i, at, uv);
        }
    }

    /// Keeps the heights there, and steps to the other side.
    #[inline(always)]
    fn step_back<I: Isa>(&mut self, i: I, blocks: usize, axis: usize, texel: f32) {
        for at in (0..blocks * LANES).step_by(I::LANES) {
            let [above, ..] = straight(i, self.colors.load(i, at));
            let mut slopes = self.rise.load(i, at);
            slopes[axis] = above;
            self.rise.store(i, at, slopes);
            let mut uv = self.uv(i, at);
            uv[axis] = uv[axis] - self.width(i, at, axis, texel);
            self.beside.store(i, at, uv);
        }
    }

    #[inline(always)]
    fn difference<I: Isa>(&mut self, i: I, blocks: usize, axis: usize, texel: f32) {
        for at in (0..blocks * LANES).step_by(I::LANES) {
            let [below, ..] = straight(i, self.colors.load(i, at));
            let mut slopes = self.rise.load(i, at);
            slopes[axis] = (slopes[axis] - below) / (self.width(i, at, axis, texel) * 2.0);
            self.rise.store(i, at, slopes);
        }
    }

    #[inline(always)]
    fn scale<I: Isa>(&mut self, i: I, blocks: usize, rise: &Rise) {
        for at in (0..blocks * LANES).step_by(I::LANES) {
            let slopes = self.rise.load(i, at);
            self.rise.store(i, at, in_world(slopes, rise));
        }
    }

    #[inline(always)]
    fn uv<I: Isa>(&self, i: I, at: usize) -> [I::F32; 2] {
        let columns = &self.placed.varyings;
        [
            load(i, &columns[0].value, at),
            load(i, &columns[1].value, at),
        ]
    }

    /// Changes of a coordinate to the right and down.
    #[inline(always)]
    fn changes<I: Isa>(&self, i: I, at: usize, axis: usize) -> [I::F32; 2] {
        let column = &self.placed.varyings[axis];
        [load(i, &column.ddx, at), load(i, &column.ddy, at)]
    }

    /// Half the width of the difference along an axis.
    #[inline(always)]
    fn width<I: Isa>(&self, i: I, at: usize, axis: usize, texel: f32) -> I::F32 {
        let [dx, dy] = self.changes(i, at, axis);
        dx.abs().above(dy.abs()).above(i.f32(texel))
    }

    /// Blinn's normal on unit normals `n`, with O_u and O_v from the changes of position and coordinates from pixel to pixel.
    #[inline(always)]
    fn bump<I: Isa>(&self, i: I, at: usize, n: Vector<I>, [px, py]: [Vector<I>; 2]) -> Vector<I> {
        let [ux, uy] = self.changes(i, at, 0);
        let [vx, vy] = self.changes(i, at, 1);
        let det = ux * vy - vx * uy;
        let useful = det.abs().simd_lt(f32::INFINITY) & !det.simd_eq(0.0);
        let (mut o_u, mut o_v) = (n, n);
        for k in 0..3 {
            o_u[k] = (px[k] * vy - py[k] * vx) / det;
            o_v[k] = (py[k] * ux - px[k] * uy) / det;
        }
        let [b_u, b_v] = self.rise.load(i, at);
        let bumped = bump_on(i, n, o_u, o_v, b_u, b_v);
        [
            useful.select(bumped[0], n[0]),
            useful.select(bumped[1], n[1]),
            useful.select(bumped[2], n[2]),
        ]
    }
}

#[inline(always)]
fn in_world<F: Number<f32>>([along_u, along_v]: [F; 2], rise: &Rise) -> [F; 2] {
    let (height, unit) = (rise.height, rise.unit);
    [along_u * height * unit, along_v * height * unit]
}

/// A matrix times vectors, in f64.
#[inline(always)]
fn transform<I: Isa>(i: I, matrix: &DMat3, v: Vector<I>) -> Vector<I> {
    let [x, y, z] = [i.widen(v[0]), i.widen(v[1]), i.widen(v[2])];
    let mut out = v;
    for (k, out) in out.iter_mut().enumerate() {
        let (a, b, c) = (matrix.x_axis[k], matrix.y_axis[k], matrix.z_axis[k]);
        *out = i.narrow(x * a + y * b + z * c);
    }
    out
}
