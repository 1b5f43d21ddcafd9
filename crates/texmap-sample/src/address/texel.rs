//! Where the texels of sixteen look-ups lie.

use super::{
    ANY, RGBA16, View,
    axis::{far_index, fraction, index, place},
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
    lanes::{Words, gather, has_pairs},
};

/// Where the four texels of a bilinear look-up are.
pub(crate) enum Corners<S: Simd> {
    /// The left ones of both rows: the right ones are the next texels in memory, and reading such pairs is the fast way.
    Pairs([u32x16<S>; 2]),
    /// Upper left, upper right, lower left, lower right.
    Apart([Place<S>; 4]),
}

/// The level of each lane.
#[derive(Clone, Copy)]
pub(crate) struct At<S: Simd> {
    offset: i32x16<S>,
    pub(crate) width: i32x16<S>,
    pub(crate) height: i32x16<S>,
    turn: i32x16<S>,
    pub(crate) units_x: f32x16<S>,
    units_y: f32x16<S>,
    /// log2 of the width of a power of two where all lanes share the level.
    shift: Option<u32>,
}

impl<S: Simd> At<S> {
    #[inline(always)]
    pub(crate) fn uniform(s: S, view: &View<'_>, level: i32) -> Self {
        let level = &view.levels[(level & 15) as usize];
        Self {
            offset: i32x16::splat(s, level.offset),
            width: i32x16::splat(s, level.width),
            height: i32x16::splat(s, level.height),
            turn: i32x16::splat(s, level.turn),
            units_x: f32x16::splat(s, level.units_x),
            units_y: f32x16::splat(s, level.units_y),
            shift: Some(level.shift),
        }
    }

    #[inline(always)]
    pub(crate) fn per_lane(s: S, view: &View<'_>, level: i32x16<S>) -> Self {
        let (zero, one) = (i32x16::splat(s, 0), i32x16::splat(s, 1));
        let (w, h) = view.size();
        let (w, h) = (i32x16::splat(s, w) >> level, i32x16::splat(s, h) >> level);
        let width = w.simd_gt(one).select(w, one);
        let height = h.simd_gt(one).select(h, one);
        let offset = match Words::new(&view.offsets) {
            Some(offsets) => gather(s, offsets, level.bitcast()).bitcast(),
            None => zero,
        };
        Self {
            offset,
            width,
            height,
            turn: if view.flip { height - 1 } else { zero },
            units_x: width.to_float::<f32x16<S>>() * view.unit,
            units_y: height.to_float::<f32x16<S>>() * view.unit,
            shift: None,
        }
    }

    /// The level of each lane, which are often one.
    #[inline(always)]
    pub(crate) fn of(s: S, view: &View<'_>, level: i32x16<S>) -> Self {
        if level.simd_eq(i32x16::splat(s, level[0])).all_true() {
            Self::uniform(s, view, level[0])
        } else {
            Self::per_lane(s, view, level)
        }
    }

    /// First word of a texel counted within the level; the texel itself where it is fetched apart.
    #[inline(always)]
    pub(crate) fn word<const FORMAT: u8>(&self, view: &View<'_>, texel: i32x16<S>) -> u32x16<S> {
        let word = match FORMAT {
            RGBA16 => texel << 1,
            ANY => texel << u32::from(view.format == RGBA16),
            _ => texel,
        };
        (word + self.offset).bitcast()
    }

    /// Texels before a row in memory.
    #[inline(always)]
    fn row_start(&self, y: i32x16<S>) -> i32x16<S> {
        match self.shift {
            Some(shift) => y << shift,
            None => y * self.width,
        }
    }

    /// The scaled coordinates, whose floor holds a texel (and its fraction, where units are fractions).
    #[inline(always)]
    pub(crate) fn place(
        &self,
        s: S,
        view: &View<'_>,
        u: f32x16<S>,
        v: f32x16<S>,
    ) -> (f32x16<S>, f32x16<S>) {
        if !view.masked {
            return (
                place(s, view, view.axes[0], u, self.units_x),
                place(s, view, view.axes[1], v, self.units_y),
            );
        }
        self.place_masked(s, view, u, v)
    }

    /// [`place`](Self::place) where wraps are masks.
    #[inline(always)]
    pub(crate) fn place_masked(
        &self,
        s: S,
        view: &View<'_>,
        u: f32x16<S>,
        v: f32x16<S>,
    ) -> (f32x16<S>, f32x16<S>) {
        let (x, y) = (u * self.units_x, v * self.units_y);
        let reach = f32x16::splat(s, view.reach);
        let (in_x, in_y) = (x.abs().simd_lt(reach), y.abs().simd_lt(reach));
        if (in_x & in_y).all_true() {
            return (x, y);
        }
        (
            in_x.select(x, fraction(s, u) * self.units_x),
            in_y.select(y, fraction(s, v) * self.units_y),
        )
    }

    /// The texel at unwrapped indices.
    #[inline(always)]
    pub(crate) fn texel<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> Place<S> {
        if view.masked {
            return self.texel_masked::<FORMAT>(view, i, j);
        }
        let (x, y) = self.wrapped(s, view, i, j);
        self.general::<FORMAT>(view, x, y)
    }

    /// [`texel`](Self::texel) where wraps are masks.
    #[inline(always)]
    pub(crate) fn texel_masked<const FORMAT: u8>(
        &self,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> Place<S> {
        let y = (j & (self.height - 1)) ^ self.turn;
        let x = i & (self.width - 1);
        Place {
            word: self.word::<FORMAT>(view, self.row_start(y) + x),
            sign: x,
        }
    }

    /// The texels at unwrapped indices (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1).
    #[inline(always)]
    pub(crate) fn corners<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> Corners<S> {
        if view.masked {
            let (x_mask, y_mask) = (self.width - 1, self.height - 1);
            let x0 = i & x_mask;
            let r0 = self.row_start((j & y_mask) ^ self.turn);
            let r1 = self.row_start(((j + 1) & y_mask) ^ self.turn);
            let left = [
                self.word::<FORMAT>(view, r0 + x0),
                self.word::<FORMAT>(view, r1 + x0),
            ];
            if has_pairs(s) && !x0.simd_eq(x_mask).any_true() {
                return Corners::Pairs(left);
            }
            let x1 = (i + 1) & x_mask;
            let right = [
                self.word::<FORMAT>(view, r0 + x1),
                self.word::<FORMAT>(view, r1 + x1),
            ];
            return Corners::Apart([
                Place {
                    word: left[0],
                    sign: x0,
                },
                Place {
                    word: right[0],
                    sign: x0,
                },
                Place {
                    word: left[1],
                    sign: x0,
                },
                Place {
                    word: right[1],
                    sign: x0,
                },
            ]);
        }
        let (x0, y0) = self.wrapped(s, view, i, j);
        let (x1, y1) = self.wrapped(s, view, i + 1, j + 1);
        let left = [
            self.general::<FORMAT>(view, x0, y0),
            self.general::<FORMAT>(view, x0, y1),
        ];
        if has_pairs(s) && !view.bordered && (x1 - x0).simd_eq(1).all_true() {
            return Corners::Pairs([left[0].word, left[1].word]);
        }
        Corners::Apart([
            left[0],
            self.general::<FORMAT>(view, x1, y0),
            left[1],
            self.general::<FORMAT>(view, x1, y1),
        ])
    }

    /// [`wrapped`](Self::wrapped) of a column, however far outside.
    #[inline(always)]
    pub(crate) fn far_column(&self, s: S, view: &View<'_>, i: i32x16<S>) -> i32x16<S> {
        far_index(s, view.axes[0], i, self.width)
    }

    /// [`wrapped`](Self::wrapped) of a row, however far outside.
    #[inline(always)]
    pub(crate) fn far_row(&self, s: S, view: &View<'_>, j: i32x16<S>) -> i32x16<S> {
        far_index(s, view.axes[1], j, self.height)
    }

    /// Wrapped indices; [`OUTSIDE`](crate::wrap::OUTSIDE) on the border.
    #[inline(always)]
    pub(crate) fn wrapped(
        &self,
        s: S,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> (i32x16<S>, i32x16<S>) {
        (
            index(s, view.axes[0], i, self.width),
            index(s, view.axes[1], j, self.height),
        )
    }

    /// The texel at wrapped indices of a volume.
    #[inline(always)]
    pub(crate) fn in_slice<const FORMAT: u8>(
        &self,
        view: &View<'_>,
        [x, y, z]: [i32x16<S>; 3],
    ) -> Place<S> {
        let turned = if view.flip { self.turn - y } else { y };
        let row = z * self.height + turned;
        Place {
            word: self.word::<FORMAT>(view, row * self.width + x),
            sign: x | y | z,
        }
    }

    /// The texel at wrapped indices.
    #[inline(always)]
    pub(crate) fn general<const FORMAT: u8>(
        &self,
        view: &View<'_>,
        x: i32x16<S>,
        y: i32x16<S>,
    ) -> Place<S> {
        let turned = if view.flip { self.turn - y } else { y };
        Place {
            word: self.word::<FORMAT>(view, turned * self.width + x),
            sign: x | y,
        }
    }
}

/// Where a tap reads.
#[derive(Clone, Copy)]
pub(crate) struct Place<S: Simd> {
    /// First word of the texel; anything where the tap reads the border.
    pub(crate) word: u32x16<S>,
    /// Negative where the tap reads the border.
    sign: i32x16<S>,
}

impl<S: Simd> Place<S> {
    /// Lanes that read the border instead of a texel.
    #[inline(always)]
    pub(crate) fn outside(&self, s: S) -> mask32x16<S> {
        self.sign.simd_lt(i32x16::splat(s, 0))
    }
}
