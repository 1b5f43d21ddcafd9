//! Addresses of texels in memory.

use super::wrap::fraction;
use crate::bound_texture::{ANY, BLOCKS, BoundTexture, EXACT_WORDS, RGBA16};
use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, prelude::*},
};

/// Addresses of the four texels of a bilinear look-up.
pub(crate) enum Corners<I: Isa> {
    /// The left ones of both rows. The right ones are the next texels in memory, and reading such pairs is the fast way.
    Pairs([I::U32; 2]),
    /// Upper left, upper right, lower left, lower right.
    Apart([TexelAddress<I>; 4]),
}

/// The mip level of each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneLevel<I: Isa> {
    offset: I::I32,
    pub(crate) width: I::I32,
    pub(crate) height: I::I32,
    /// Last row of a flipped texture, else 0.
    turn: I::I32,
    pub(crate) units_x: I::F32,
    units_y: I::F32,
    /// log2 of the width of a power of two where all lanes share the level.
    shift: Option<u32>,
}

impl<I: Isa> LaneLevel<I> {
    #[inline(always)]
    pub(crate) fn uniform(i: I, view: &BoundTexture<'_>, level: i32) -> Self {
        let level = view.level::<I>(level);
        Self {
            offset: i.i32(level.offset),
            width: i.i32(level.width),
            height: i.i32(level.height),
            turn: i.i32(level.turn),
            units_x: i.f32(level.units_x),
            units_y: i.f32(level.units_y),
            shift: Some(level.shift),
        }
    }

    #[inline(always)]
    fn per_lane(i: I, view: &BoundTexture<'_>, level: I::I32) -> Self {
        let (w, h) = view.size();
        let (w, h) = (i.i32(w) >> level, i.i32(h) >> level);
        let width = w.simd_gt(1).select(w, i.i32(1));
        let height = h.simd_gt(1).select(h, i.i32(1));
        let offset = match GatherTable::new(&view.offsets) {
            Some(offsets) => i.gather(offsets, level.to_u32()).to_i32(),
            None => i.i32(0),
        };
        Self {
            offset,
            width,
            height,
            turn: if view.flip { height - 1 } else { i.i32(0) },
            units_x: width.to_f32() * view.unit,
            units_y: height.to_f32() * view.unit,
            shift: None,
        }
    }

    /// The level of each lane, which are often one.
    #[inline(always)]
    pub(crate) fn of(i: I, view: &BoundTexture<'_>, level: I::I32) -> Self {
        let first = i.first(level);
        if I::LANES == 1 || level.simd_eq(first).all_true() {
            Self::uniform(i, view, first)
        } else {
            Self::per_lane(i, view, level)
        }
    }

    /// [`of`](Self::of) a level from 0 on, and of the next one where there is one.
    #[inline(always)]
    pub(crate) fn pair(i: I, view: &BoundTexture<'_>, fine: I::I32) -> [Self; 2] {
        let first = i.first(fine);
        if I::LANES == 1 || fine.simd_eq(first).all_true() {
            let next = if first < view.last { first + 1 } else { first };
            [Self::uniform(i, view, first), Self::uniform(i, view, next)]
        } else {
            let next = (fine + 1).min(i.i32(view.last));
            [Self::per_lane(i, view, fine), Self::per_lane(i, view, next)]
        }
    }

    /// First word of a texel counted within the level; the texel itself where it is fetched one by one.
    #[inline(always)]
    pub(crate) fn word<const FORMAT: u8>(&self, view: &BoundTexture<'_>, texel: I::I32) -> I::U32 {
        let word = match FORMAT {
            RGBA16 => texel << 1,
            ANY | EXACT_WORDS => texel << u32::from(view.format == RGBA16),
            _ => texel,
        };
        (word + self.offset).to_u32()
    }

    /// First word of the texel of column `x` and row `y` as they are stored; `row` texels stand before its row, where rows are stored.
    #[inline(always)]
    fn stored<const FORMAT: u8>(
        &self,
        view: &BoundTexture<'_>,
        [x, y]: [I::I32; 2],
        row: I::I32,
    ) -> I::U32 {
        if in_blocks::<FORMAT>(view) {
            let whole = (self.width + 3) & !3;
            let texel = (y & !3) * whole + ((y & 3) << 2) + ((x & !3) << 2) + (x & 3);
            return (texel + self.offset).to_u32();
        }
        self.word::<FORMAT>(view, row + x)
    }

    /// Texels before a row in memory.
    #[inline(always)]
    fn row_start(&self, y: I::I32) -> I::I32 {
        match self.shift {
            Some(shift) => y << shift,
            None => y * self.width,
        }
    }

    /// The scaled coordinates, whose floor holds a texel (and its fraction, where units are fractions).
    #[inline(always)]
    pub(crate) fn scale(&self, i: I, view: &BoundTexture<'_>, [u, v]: [I::F32; 2]) -> [I::F32; 2] {
        if view.masked {
            return self.scale_masked(i, view, [u, v]);
        }
        [
            view.axes[0].scale(i, u, self.units_x, view.reach),
            view.axes[1].scale(i, v, self.units_y, view.reach),
        ]
    }

    /// The unwrapped indices of the texels that hold coordinates; `1 << shift` units are a texel.
    #[inline(always)]
    pub(crate) fn nearest(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        [u, v]: [I::F32; 2],
        shift: u32,
    ) -> [I::I32; 2] {
        if view.masked {
            // Powers of two lose nothing.
            let [x, y] = self.scale_masked(i, view, [u, v]);
            return [x.floor_to_i32() >> shift, y.floor_to_i32() >> shift];
        }
        let scale = (shift, view.reach);
        [
            view.axes[0].texel(i, u, self.units_x, scale),
            view.axes[1].texel(i, v, self.units_y, scale),
        ]
    }

    /// [`scale`](Self::scale) where wraps are masks.
    #[inline(always)]
    pub(crate) fn scale_masked(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        [u, v]: [I::F32; 2],
    ) -> [I::F32; 2] {
        let (x, y) = (u * self.units_x, v * self.units_y);
        let (in_x, in_y) = (x.abs().simd_lt(view.reach), y.abs().simd_lt(view.reach));
        if (in_x & in_y).all_true() {
            return [x, y];
        }
        [
            in_x.select(x, fraction(i, u) * self.units_x),
            in_y.select(y, fraction(i, v) * self.units_y),
        ]
    }

    /// The texel at unwrapped indices.
    #[inline(always)]
    pub(crate) fn texel<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        [x, y]: [I::I32; 2],
    ) -> TexelAddress<I> {
        if view.masked {
            return self.texel_masked::<FORMAT>(view, [x, y]);
        }
        self.wrapped_texel::<FORMAT>(view, self.wrapped(i, view, [x, y]))
    }

    /// [`texel`](Self::texel) where wraps are masks.
    #[inline(always)]
    pub(crate) fn texel_masked<const FORMAT: u8>(
        &self,
        view: &BoundTexture<'_>,
        [x, y]: [I::I32; 2],
    ) -> TexelAddress<I> {
        let y = (y & (self.height - 1)) ^ self.turn;
        let x = x & (self.width - 1);
        TexelAddress::new(self.stored::<FORMAT>(view, [x, y], self.row_start(y)), x)
    }

    /// The texels at unwrapped indices (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1).
    #[inline(always)]
    pub(crate) fn corners<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        [x, y]: [I::I32; 2],
    ) -> Corners<I> {
        let pairs = i.has_pairs() && !in_blocks::<FORMAT>(view);
        if view.masked {
            let (x_mask, y_mask) = (self.width - 1, self.height - 1);
            let x0 = x & x_mask;
            let (y0, y1) = ((y & y_mask) ^ self.turn, ((y + 1) & y_mask) ^ self.turn);
            let rows = [self.row_start(y0), self.row_start(y1)];
            let left = [
                self.stored::<FORMAT>(view, [x0, y0], rows[0]),
                self.stored::<FORMAT>(view, [x0, y1], rows[1]),
            ];
            if pairs && !x0.simd_eq(x_mask).any_true() {
                return Corners::Pairs(left);
            }
            let x1 = (x + 1) & x_mask;
            let right = [
                self.stored::<FORMAT>(view, [x1, y0], rows[0]),
                self.stored::<FORMAT>(view, [x1, y1], rows[1]),
            ];
            return Corners::Apart([
                TexelAddress::new(left[0], x0),
                TexelAddress::new(right[0], x0),
                TexelAddress::new(left[1], x0),
                TexelAddress::new(right[1], x0),
            ]);
        }
        let [x0, y0] = self.wrapped(i, view, [x, y]);
        let [x1, y1] = self.wrapped(i, view, [x + 1, y + 1]);
        let left = [
            self.wrapped_texel::<FORMAT>(view, [x0, y0]),
            self.wrapped_texel::<FORMAT>(view, [x0, y1]),
        ];
        if pairs && !view.bordered && (x1 - x0).simd_eq(1).all_true() {
            return Corners::Pairs([left[0].word, left[1].word]);
        }
        Corners::Apart([
            left[0],
            self.wrapped_texel::<FORMAT>(view, [x1, y0]),
            left[1],
            self.wrapped_texel::<FORMAT>(view, [x1, y1]),
        ])
    }

    /// [`wrapped`](Self::wrapped) of a column, however far outside.
    #[inline(always)]
    pub(crate) fn far_column(&self, i: I, view: &BoundTexture<'_>, x: I::I32) -> I::I32 {
        view.axes[0].far_index(i, x, self.width)
    }

    /// [`wrapped`](Self::wrapped) of a row, however far outside.
    #[inline(always)]
    pub(crate) fn far_row(&self, i: I, view: &BoundTexture<'_>, y: I::I32) -> I::I32 {
        view.axes[1].far_index(i, y, self.height)
    }

    /// Wrapped indices; [`OUTSIDE`](super::wrap::OUTSIDE) on the border.
    #[inline(always)]
    pub(crate) fn wrapped(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        [x, y]: [I::I32; 2],
    ) -> [I::I32; 2] {
        [
            view.axes[0].index(i, x, self.width),
            view.axes[1].index(i, y, self.height),
        ]
    }

    /// The texel at wrapped indices of a volume.
    #[inline(always)]
    pub(crate) fn in_slice<const FORMAT: u8>(
        &self,
        view: &BoundTexture<'_>,
        [x, y, z]: [I::I32; 3],
    ) -> TexelAddress<I> {
        let turned = if view.flip { self.turn - y } else { y };
        let row = z * self.height + turned;
        let word = self.word::<FORMAT>(view, row * self.width + x);
        TexelAddress::new(word, x | y | z)
    }

    /// The texel at wrapped indices.
    #[inline(always)]
    pub(crate) fn wrapped_texel<const FORMAT: u8>(
        &self,
        view: &BoundTexture<'_>,
        [x, y]: [I::I32; 2],
    ) -> TexelAddress<I> {
        let turned = if view.flip { self.turn - y } else { y };
        let word = self.stored::<FORMAT>(view, [x, turned], turned * self.width);
        TexelAddress::new(word, x | y)
    }
}

/// True where texels are addressed in block order.
#[inline(always)]
fn in_blocks<const FORMAT: u8>(view: &BoundTexture<'_>) -> bool {
    FORMAT == BLOCKS || FORMAT == ANY && view.format == BLOCKS
}

/// Address of a texel, or the border.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexelAddress<I: Isa> {
    /// First word of the texel; anything on the border.
    pub(crate) word: I::U32,
    /// Negative on the border.
    sign: I::I32,
}

impl<I: Isa> TexelAddress<I> {
    #[inline(always)]
    fn new(word: I::U32, sign: I::I32) -> Self {
        Self { word, sign }
    }

    /// As one word, which is negative on the border.
    #[inline(always)]
    pub(crate) fn stored(&self, i: I) -> I::U32 {
        self.outside()
            .select(i.i32(-1), self.word.to_i32())
            .to_u32()
    }

    /// Of a word as it was [`stored`](Self::stored).
    #[inline(always)]
    pub(crate) fn loaded(word: I::U32) -> Self {
        Self::new(word, word.to_i32())
    }

    /// Lanes that read the border instead of a texel.
    #[inline(always)]
    pub(crate) fn outside(&self) -> I::Mask {
        self.sign.simd_lt(0)
    }
}
