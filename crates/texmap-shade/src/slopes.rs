//! Bump and offset maps: their slopes over a batch, and the normals that these turn.

use texmap_light::NormalMapGreen;
use texmap_light::lanes::{Vector, bump_on};
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::Varyings;
use texmap_sample::{Origin, sample_soa};

use crate::Slot;
use crate::batch::{Colors, Columns, LANES, load, load_changes, parts, straight};
use crate::fetch::pixel_samples;
use crate::normal::{front_normal, store_normal};
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// Normals turned by a map of heights, or of slopes.
pub struct SlopeMap<'a> {
    /// The map of heights or of slopes.
    pub slot: &'a Slot<'a>,
    /// The height of a value of 1.
    pub rise: Rise,
    /// The direction of the slopes of a map of slopes; `None` for heights.
    pub slopes: Option<NormalMapGreen>,
    /// Normals turned away from the eye are brought back to the horizon.
    pub horizon_clamp: bool,
}

/// The height of a value of 1.
#[derive(Clone, Copy)]
pub struct Rise {
    /// Units of the object.
    pub height: f32,
    /// World units of one of them.
    pub unit: f32,
}

/// Slopes of a bump or offset map over a batch.
#[derive(Default)]
pub(crate) struct Slopes {
    /// Coordinates of the slot.
    placed: Varyings,
    /// Coordinates beside them.
    beside: Columns<2>,
    colors: Colors,
    /// Rise along u and v, world units.
    rise: Columns<2>,
}

impl Kernel for SlopeMap<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let (slot, rise, slopes) = (self.slot, &self.rise, &mut columns.slopes);
        let (level, blocks) = (inputs.level, inputs.batch.list.len());
        slopes.place(slot, inputs.uv_of(slot), blocks);
        let Some(green) = self.slopes else {
            return slopes.differences(level, slot, blocks, rise);
        };
        slopes.look_up(level, slot, blocks, false);
        // The slot counts v down the picture, or up it from a bottom-left origin.
        let bottom_left = slot.texture.origin() == Origin::BottomLeft;
        let up = (green == NormalMapGreen::Up) != bottom_left;
        dispatch_simd!(level, i => slopes.offsets(i, blocks, up, rise));
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.reached) {
            let back = part.mask(i, inputs.sides.back[part.index]);
            let mut normal = front_normal(i, back, part.at, columns);
            if let Some(position) = inputs.vectors.position {
                let changes = load_changes(i, position, part.at);
                normal = columns.slopes.bump(i, part.at, normal, changes);
            }
            store_normal(i, self.horizon_clamp, back, part.at, normal, columns);
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
            [at.u, at.v] = self.beside.columns(count);
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
