//! Summed-area tables (Crow 1984, "Summed-Area Tables for Texture Mapping"): the mean over any upright rectangle of texels by sums
//! that were made once.

use super::{FilterKernel, Input, LookUp, gl::Gl};
use crate::{
    address::wrap::Wrap,
    bound_texture::{ANY, BoundTexture},
    fetch::{Color, scaled},
    texel_data::Chain,
    texture::Texture2d,
};
use alloc::{sync::Arc, vec, vec::Vec};
use texmap_math::{
    deterministic_f64::{exp2, log2},
    float::floor,
    simd::{Isa, prelude::*},
};

/// Longest side of a rectangle, in texels.
const LONGEST: f64 = 1_048_576.0;

/// The sums of the texels of level 0 over `[0, x) x [0, y)` as they lie in memory, unscaled.
///
/// Sums of bytes and of 16-bit texels are whole numbers below 2^44, which f64 holds exactly; those of floats are off by at most 2^-53
/// of the largest sum for each texel.
#[derive(Debug)]
pub(crate) struct SummedArea {
    width: usize,
    height: usize,
    /// One more column and row than the texture.
    sums: Vec<[f64; 4]>,
}

impl Texture2d<'_> {
    /// The same texture with the table of [`Filter::SummedArea`](crate::Filter::SummedArea): 32 bytes a texel of level 0.
    #[must_use]
    pub fn with_summed_area(mut self) -> Self {
        if self.chain.sums.is_none() {
            self.chain.sums = Some(Arc::new(SummedArea::new(&self.chain)));
        }
        self
    }

    /// True if [`with_summed_area`](Self::with_summed_area) has made the table.
    #[must_use]
    pub fn has_summed_area(&self) -> bool {
        self.chain.sums.is_some()
    }
}

impl SummedArea {
    fn new(chain: &Chain<'_>) -> Self {
        let base = chain.levels[0];
        let (width, height) = (base.width as usize, base.height as usize);
        let mut sums = vec![[0.0; 4]; (width + 1) * (height + 1)];
        for y in 0..height {
            let row = if chain.flip { height - 1 - y } else { y };
            let mut line = [0.0_f64; 4];
            for x in 0..width {
                let c = chain.fetch(&base, x as i32, row as i32, 0);
                let above = sums[y * (width + 1) + x + 1];
                let sum = &mut sums[(y + 1) * (width + 1) + x + 1];
                for k in 0..4 {
                    line[k] += f64::from(c[k]);
                    sum[k] = above[k] + line[k];
                }
            }
        }
        Self {
            width,
            height,
            sums,
        }
    }

    /// The unscaled mean over a rectangle about `uv` with these sides in texels, in the endless plane that the wraps make of level 0.
    #[inline(never)]
    fn mean(&self, view: &BoundTexture<'_>, uv: [f32; 2], sides: [f64; 2]) -> [f32; 4] {
        let [x, y] = [
            Interval::new(view.axes[0].wrap, uv[0], sides[0], self.width),
            Interval::new(view.axes[1].wrap, uv[1], sides[1], self.height),
        ];
        let y = if view.flip { y.flipped(self.height) } else { y };
        let sum = y.sum(|row| x.sum(|column| self.sums[row * (self.width + 1) + column]));
        let area = x.length * y.length;
        // Nothing is left to the border if both axes lie within the image.
        let left = (area - x.inside * y.inside) / area;
        [0, 1, 2, 3].map(|k| {
            let mean = sum[k] / area;
            let border = f64::from(view.border[k]);
            (if left > 0.0 {
                mean + border * left
            } else {
                mean
            }) as f32
        })
    }
}

/// The part of one axis that a rectangle covers, as a sum over the table's columns: that of the image `turns` times, plus that up to
/// `high`, less that up to `low`.
#[derive(Clone, Copy, Debug)]
struct Interval {
    high: End,
    low: End,
    turns: f64,
    /// Columns of the whole image.
    whole: usize,
    length: f64,
    /// Texels of the length that are not the border's.
    inside: f64,
}

/// The sum up to a place: `sign` times that between column `at` and the next, at `fraction`, which is outside of 0 to 1 where the
/// border texel goes on.
#[derive(Clone, Copy, Debug)]
struct End {
    sign: f64,
    at: usize,
    fraction: f64,
}

impl Interval {
    fn new(wrap: Wrap, u: f32, side: f64, whole: usize) -> Self {
        let n = whole as f64;
        let length = side.clamp(1.0, LONGEST);
        let u = if u.is_finite() { f64::from(u) } else { 0.0 };
        let centre = match wrap {
            Wrap::Repeat => u - floor(u),
            Wrap::MirroredRepeat => u - 2.0 * floor(0.5 * u),
            _ => u,
        } * n;
        // All that lies beyond the last change is alike: the rectangle may stand right behind it.
        let (first, last) = match wrap {
            Wrap::Repeat | Wrap::MirroredRepeat => (f64::NEG_INFINITY, f64::INFINITY),
            Wrap::ClampToEdge | Wrap::ClampToBorder => (0.0, n),
            Wrap::MirrorClampToEdge => (-n, n),
        };
        let low = (centre - 0.5 * length).clamp(first - length, last);
        let high = low + length;
        let inside = match wrap {
            Wrap::ClampToBorder if low < 0.0 || high > n => high.min(n) - low.max(0.0),
            _ => length,
        };
        let (low, below) = End::new(wrap, low, whole);
        let (high, above) = End::new(wrap, high, whole);
        Self {
            high,
            low,
            turns: above - below,
            whole,
            length,
            inside,
        }
    }

    /// The same rows counted from the other end.
    fn flipped(self, n: usize) -> Self {
        let turn = |end: End| End {
            sign: -end.sign,
            at: n - 1 - end.at,
            fraction: 1.0 - end.fraction,
        };
        Self {
            high: turn(self.high),
            low: turn(self.low),
            turns: self.turns + self.high.sign - self.low.sign,
            ..self
        }
    }

    #[inline(always)]
    fn sum(&self, at: impl Fn(usize) -> [f64; 4]) -> [f64; 4] {
        let between = |end: End| {
            let (a, b) = (at(end.at), at(end.at + 1));
            [0, 1, 2, 3].map(|k| end.sign * (a[k] + (b[k] - a[k]) * end.fraction))
        };
        let (high, low) = (between(self.high), between(self.low));
        let mut sum = [0, 1, 2, 3].map(|k| high[k] - low[k]);
        if self.turns != 0.0 {
            let whole = at(self.whole);
            (0..4).for_each(|k| sum[k] += self.turns * whole[k]);
        }
        sum
    }
}

impl End {
    /// The end at `x` texels, and how many times the sum of the image is added to it.
    fn new(wrap: Wrap, x: f64, whole: usize) -> (Self, f64) {
        let n = whole as f64;
        let plain = |sign: f64, x: f64| {
            let at = (x.clamp(0.0, n - 1.0) as usize).min(whole - 1);
            let fraction = x - at as f64;
            Self { sign, at, fraction }
        };
        match wrap {
            Wrap::Repeat => {
                let turns = floor(x / n);
                (plain(1.0, (x - turns * n).clamp(0.0, n)), turns)
            }
            Wrap::MirroredRepeat => {
                let turns = floor(x / (2.0 * n));
                let x = (x - turns * 2.0 * n).clamp(0.0, 2.0 * n);
                if x <= n {
                    (plain(1.0, x), 2.0 * turns)
                } else {
                    (plain(-1.0, 2.0 * n - x), 2.0 * turns + 2.0)
                }
            }
            Wrap::ClampToEdge => (plain(1.0, x), 0.0),
            Wrap::ClampToBorder => (plain(1.0, x.clamp(0.0, n)), 0.0),
            Wrap::MirrorClampToEdge if x < 0.0 => (plain(-1.0, -x), 0.0),
            Wrap::MirrorClampToEdge => (plain(1.0, x), 0.0),
        }
    }
}

/// The mean over the footprint's bounding rectangle, whose sides have at least one texel: bilinear where the texture is magnified.
/// Turned footprints blur, as no rectangle that is not upright has a sum.
pub(crate) struct Rectangle;

impl FilterKernel for Rectangle {
    const FORMAT: u8 = ANY;
    const INPUT: Input = Input::Footprint;

    /// Lanes find their rectangles; the sums are f64 and are read one rectangle after the other.
    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        if view.chain.sums.is_none() {
            return Gl::color(i, view, at, i.f32(0.0));
        }
        let [w, h] = match &at.footprint {
            Some(d) => [d.ux.abs() + d.uy.abs(), d.vx.abs() + d.vy.abs()],
            // A level without a footprint is a square, whose limits were kept.
            None => [i.f32(exp2(f64::from(at.flat)).min(LONGEST) as f32); 2],
        };
        let limited = at.footprint.is_some();
        if const { I::LANES == 1 } {
            return means::<I, 1>(i, view, at.uv, [w, h], limited);
        }
        if const { I::LANES == 4 } {
            return means::<I, 4>(i, view, at.uv, [w, h], limited);
        }
        means::<I, 16>(i, view, at.uv, [w, h], limited)
    }
}

#[inline(always)]
fn means<I: Isa, const N: usize>(
    i: I,
    view: &BoundTexture<'_>,
    uv: [I::F32; 2],
    sides: [I::F32; 2],
    limited: bool,
) -> Color<I> {
    let mut given = [[0.0; 16]; 4];
    uv[0].store(&mut given[0]);
    uv[1].store(&mut given[1]);
    sides[0].store(&mut given[2]);
    sides[1].store(&mut given[3]);
    let [r, g, b, a] = each::<N>(view, &given, limited);
    let color = [
        i.load_f32(&r),
        i.load_f32(&g),
        i.load_f32(&b),
        i.load_f32(&a),
    ];
    scaled::<I>(color, view)
}

/// The means of the first `N`, channel by channel. One compiled form serves all levels.
#[inline(never)]
fn each<const N: usize>(
    view: &BoundTexture<'_>,
    given: &[[f32; 16]; 4],
    limited: bool,
) -> [[f32; N]; 4] {
    let mut out = [[0.0; N]; 4];
    let Some(sums) = &view.chain.sums else {
        return out;
    };
    for k in 0..N {
        let mut sides = [f64::from(given[2][k]), f64::from(given[3][k])];
        if limited && !view.plain_lod {
            sides = sides.map(|side| limited_side(view, side));
        }
        let color = sums.mean(view, [given[0][k], given[1][k]], sides);
        (0..4).for_each(|c| out[c][k] = color[c]);
    }
    out
}

/// A side under the bias and the limits of levels, which are those of its logarithm.
fn limited_side(view: &BoundTexture<'_>, side: f64) -> f64 {
    let range = &view.lod_range;
    let mut level = log2(side.max(1e-30)) + f64::from(range.bias);
    // Limits that are NaN limit nothing.
    if level < f64::from(range.min) {
        level = range.min.into();
    }
    if level > f64::from(range.max) {
        level = range.max.into();
    }
    exp2(level.clamp(-64.0, 64.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The length of an interval is what its ends leave, for every wrap.
    #[test]
    fn the_columns_of_an_interval_are_its_length() {
        for wrap in [
            Wrap::Repeat,
            Wrap::MirroredRepeat,
            Wrap::ClampToEdge,
            Wrap::MirrorClampToEdge,
        ] {
            for n in [1, 2, 7] {
                for (u, side) in [
                    (-3.3, 0.2),
                    (-0.4, 3.0),
                    (0.5, 1.0),
                    (0.9, 30.0),
                    (5.0, 2.5),
                ] {
                    let interval = Interval::new(wrap, u, side, n);
                    for interval in [interval, interval.flipped(n)] {
                        let ones = interval.sum(|column| [column as f64; 4]);
                        let off = (ones[0] - side.max(1.0)).abs();
                        assert!(off < 1e-12, "{wrap:?} {n} {u} {side} {ones:?}");
                    }
                }
            }
        }
    }
}
