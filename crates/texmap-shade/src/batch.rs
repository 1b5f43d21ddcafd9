//! A batch: up to 256 fragments of one surface, in the 4x4 blocks of the rasterizer, and its columns of values.

use texmap_math::simd::{Isa, prelude::*};
use texmap_raster::{
    BATCH_STRIDE, BinnedDraws, Cull, FragmentBlock, NO_PRIMITIVE, Tile, TileVisibility, Varying,
    Varyings,
};

/// Pixels of a 4x4 block.
pub const LANES: usize = 16;

/// The fragments of a batch and their attributes.
pub struct Batch<'a> {
    /// Draw calls after the front end.
    pub prepared: &'a BinnedDraws<'a>,
    /// The tile of the batch.
    pub tile: Tile,
    /// Depth and triangle of each pixel of the tile.
    pub blocks: &'a TileVisibility,
    /// The fragments, in blocks of 4 x 4 pixels.
    pub list: &'a [FragmentBlock],
    /// Values of the attributes that the surface reads, one column each.
    pub values: &'a Varyings,
}

impl Batch<'_> {
    /// The slot of the triangle that a pixel of a block shows.
    pub fn slot(&self, at: FragmentBlock, bit: usize) -> u32 {
        if at.slot == NO_PRIMITIVE {
            self.blocks.slot[usize::from(at.block) * LANES + bit]
        } else {
            at.slot
        }
    }

    /// The sample of a pixel of a block: column and row of the target.
    pub fn sample(&self, at: FragmentBlock, bit: usize) -> [u32; 2] {
        let (x, y) = (at.block as usize % 16 * 4, at.block as usize / 16 * 4);
        [
            self.tile.x0 + (x + bit % 4) as u32,
            self.tile.y0 + (y + bit / 4) as u32,
        ]
    }

    /// Reversed depth of the opaque surface at a pixel of a block.
    pub fn depth(&self, at: FragmentBlock, bit: usize) -> f32 {
        self.blocks.depth[usize::from(at.block) * LANES + bit]
    }

    /// The fragments: index in the columns, block, pixel of the block.
    pub fn fragments(&self) -> impl Iterator<Item = (usize, FragmentBlock, usize)> {
        self.list
            .iter()
            .enumerate()
            .flat_map(|(k, &at)| set_bits(at.mask).map(move |bit| (k * LANES + bit, at, bit)))
    }
}

/// The lanes of a block that a kernel computes at once: all sixteen, or a part.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    /// Index of the first pixel in the columns of the batch.
    pub(crate) at: usize,
    /// First pixel in the block.
    pub(crate) pixel: usize,
    pub(crate) block: FragmentBlock,
    /// Index of the block in the batch.
    pub(crate) index: usize,
}

/// The parts of the blocks of a list that have pixels.
#[inline(always)]
pub(crate) fn parts<I: Isa>(_: I, list: &[FragmentBlock]) -> impl Iterator<Item = Part> {
    let all = u32::MAX >> (32 - I::LANES);
    (0..list.len() * LANES)
        .step_by(I::LANES)
        .filter_map(move |at| {
            let (index, pixel) = (at / LANES, at % LANES);
            let block = list[index];
            let some = u32::from(block.mask) >> pixel & all != 0;
            some.then_some(Part {
                at,
                pixel,
                block,
                index,
            })
        })
}

impl Part {
    /// The lanes that are set in a mask of the block.
    #[inline(always)]
    pub(crate) fn mask<I: Isa>(&self, i: I, block: u16) -> I::Mask {
        i.mask_from_bits(u32::from(block) >> self.pixel)
    }
}

/// The triangle of a slot seen from its front or its back; asked once for pixels of one triangle in a row.
pub struct Facing {
    cull: Cull,
    last: (u32, bool),
}

impl Facing {
    /// Sides under a rule of culling; nothing is asked yet.
    pub fn new(cull: Cull) -> Self {
        Self {
            cull,
            last: (NO_PRIMITIVE, true),
        }
    }

    /// True if the triangle in `slot` shows its front; the answer for the last slot is kept.
    pub fn is_front(&mut self, batch: &Batch<'_>, slot: u32) -> bool {
        match self.cull {
            Cull::Back => return true,
            Cull::Front => return false,
            Cull::None => {}
        }
        if self.last.0 != slot {
            let id = batch.blocks.ids[slot as usize];
            self.last = (slot, batch.prepared.is_front(id));
        }
        self.last.1
    }
}

/// `N` numbers for each pixel of a batch, in columns.
pub struct Columns<const N: usize>(pub [[f32; BATCH_STRIDE]; N]);

/// Colors of a batch and their alpha; premultiplied, but for those between stages that say otherwise.
pub type Colors = Columns<4>;

impl<const N: usize> Default for Columns<N> {
    fn default() -> Self {
        Self([[0.0; BATCH_STRIDE]; N])
    }
}

impl<const N: usize> Columns<N> {
    /// The numbers from pixel `at` of the batch on.
    #[inline(always)]
    pub fn load<I: Isa>(&self, i: I, at: usize) -> [I::F32; N] {
        let mut out = [i.f32(0.0); N];
        for (out, column) in out.iter_mut().zip(&self.0) {
            *out = load(i, column, at);
        }
        out
    }

    /// Stores numbers from pixel `at` of the batch on.
    #[inline(always)]
    pub(crate) fn store<I: Isa>(&mut self, _: I, at: usize, values: [I::F32; N]) {
        for (column, value) in self.0.iter_mut().zip(&values) {
            value.store(&mut column[at..at + I::LANES]);
        }
    }

    /// Sets the numbers of pixel `at`.
    pub(crate) fn set(&mut self, at: usize, values: [f32; N]) {
        for (column, value) in self.0.iter_mut().zip(values) {
            column[at] = value;
        }
    }

    /// The numbers of pixel `at`.
    pub fn get(&self, at: usize) -> [f32; N] {
        self.0.each_ref().map(|column| column[at])
    }

    /// The columns over the first `count` pixels.
    pub(crate) fn columns(&self, count: usize) -> [&[f32]; N] {
        self.0.each_ref().map(|column| &column[..count])
    }

    /// See [`columns`](Self::columns).
    pub(crate) fn columns_mut(&mut self, count: usize) -> [&mut [f32]; N] {
        self.0.each_mut().map(|column| &mut column[..count])
    }
}

/// Values of a column from pixel `at` of the batch on.
#[inline(always)]
pub fn load<I: Isa>(i: I, column: &[f32; BATCH_STRIDE], at: usize) -> I::F32 {
    i.load_f32(&column[at..at + I::LANES])
}

/// A vector from its three columns.
#[inline(always)]
pub(crate) fn load_vector<I: Isa>(i: I, [x, y, z]: &[Varying; 3], at: usize) -> [I::F32; 3] {
    [
        load(i, &x.value, at),
        load(i, &y.value, at),
        load(i, &z.value, at),
    ]
}

/// The changes of a vector from pixel to pixel, to the right and down.
#[inline(always)]
pub(crate) fn load_changes<I: Isa>(i: I, [x, y, z]: &[Varying; 3], at: usize) -> [[I::F32; 3]; 2] {
    [
        [
            load(i, &x.ddx, at),
            load(i, &y.ddx, at),
            load(i, &z.ddx, at),
        ],
        [
            load(i, &x.ddy, at),
            load(i, &y.ddy, at),
            load(i, &z.ddy, at),
        ],
    ]
}

/// The columns of `values` from this attribute on; zeros where there are none.
pub(crate) fn columns<const N: usize>(values: &Varyings, first: usize) -> &[Varying; N] {
    static ZEROS: [Varying; 4] = [Varying::ZERO; 4];
    let columns = values.varyings.get(first..).unwrap_or_default();
    let zeros = ZEROS.first_chunk();
    match columns.first_chunk().or(zeros) {
        Some(columns) => columns,
        None => unreachable!("vectors of at most four columns are asked for"),
    }
}

/// Premultiplied to straight color; black where alpha is 0 or NaN.
#[inline(always)]
pub fn straight<I: Isa>(i: I, [r, g, b, a]: [I::F32; 4]) -> [I::F32; 3] {
    let (zero, some) = (i.f32(0.0), a.simd_gt(0.0));
    [
        some.select(r / a, zero),
        some.select(g / a, zero),
        some.select(b / a, zero),
    ]
}

/// The opposite vector in some lanes.
#[inline(always)]
pub(crate) fn flip<I: Isa>(_: I, lanes: I::Mask, v: [I::F32; 3]) -> [I::F32; 3] {
    [
        lanes.select(-v[0], v[0]),
        lanes.select(-v[1], v[1]),
        lanes.select(-v[2], v[2]),
    ]
}

/// The positions of the bits that are set, from the lowest up.
pub fn set_bits(mut mask: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < LANES).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::Scalar;
    use texmap_math::{Level, dispatch_simd};

    /// Every pixel that a mask sets is in one part, on every width; parts without pixels are left out.
    #[test]
    fn parts_cover_the_pixels_that_are_set() {
        let list = [0, 1, 0x8000, 0xffff, 0x0f00, 0, 0x0440].map(|mask| FragmentBlock {
            block: 0,
            mask,
            slot: 0,
        });
        check(Scalar, &list);
        dispatch_simd!(Level::new(), i => check(i, &list));
        fn check<I: Isa>(i: I, list: &[FragmentBlock]) {
            let mut seen = [0u16; 7];
            for part in parts(i, list) {
                let lanes = part.mask(i, part.block.mask).to_bitmask();
                assert!(lanes != 0 && part.at == part.index * LANES + part.pixel);
                let lanes = (lanes as u16) << part.pixel;
                assert_eq!(seen[part.index] & lanes, 0);
                seen[part.index] |= lanes;
            }
            assert_eq!(seen, list.iter().map(|at| at.mask).collect::<Vec<_>>()[..]);
        }
    }
}
