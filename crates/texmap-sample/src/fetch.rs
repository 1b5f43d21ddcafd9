//! Texels as unscaled channels, for the kernels with f32 weights.

use crate::{
    address::texel::{Corners, LaneLevel, TexelAddress},
    bound_texture::{ANY, BLOCKS, BoundTexture, RGBA8_EXACT, RGBA16, SCALAR_FETCH},
    encoded::{Encoded, EncodedBytes},
    texel_data::{Chain, Format, Level},
};
use texmap_math::simd::{Isa, prelude::*};

/// Red, green, blue, alpha of each lane.
pub type Color<I> = [<I as Isa>::F32; 4];

/// The format of a kernel that has one, else the view's.
#[inline(always)]
fn of_view<const FORMAT: u8>(view: &BoundTexture<'_>) -> u8 {
    debug_assert!(
        FORMAT == ANY || FORMAT == view.format,
        "the texels of a view"
    );
    if FORMAT == ANY { view.format } else { FORMAT }
}

#[inline(always)]
pub(crate) fn fetch<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    word: I::U32,
) -> Color<I> {
    match of_view::<FORMAT>(view) {
        SCALAR_FETCH => view.apart.fetch(i, word),
        BLOCKS => fetch_in_blocks(i, view, word),
        RGBA16 => color16(i, view.opaque, i.gather_pairs(view.words, word)),
        _ => color8(i, view.opaque, i.gather(view.words, word)),
    }
}

/// Texels in block order: of blocks, or of the 16-bit levels behind them.
#[inline(always)]
fn fetch_in_blocks<I: Isa>(i: I, view: &BoundTexture<'_>, texel: I::U32) -> Color<I> {
    let Some(blocks) = &view.blocks else {
        return [i.f32(0.0); 4];
    };
    let texel = texel.to_i32();
    let made = texel.simd_ge(blocks.texels);
    if !made.any_true() {
        return blocks.decoded(i, texel);
    }
    let word = ((texel - blocks.texels) << 1).max(i.i32(0)).to_u32();
    let words = color16(i, view.opaque, i.gather_pairs(view.words, word));
    if made.all_true() {
        return words;
    }
    let last = i.i32(blocks.texels - 1);
    select::<I>(made, words, blocks.decoded(i, texel.min(last)))
}

/// A texel, and the next in memory.
#[inline(always)]
pub(crate) fn fetch_two<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    word: I::U32,
) -> [Color<I>; 2] {
    match of_view::<FORMAT>(view) {
        SCALAR_FETCH => [view.apart.fetch(i, word), view.apart.fetch(i, word + 1)],
        // Never asked for: neighbours in memory are none in the picture.
        BLOCKS => [
            fetch_in_blocks(i, view, word),
            fetch_in_blocks(i, view, word + 1),
        ],
        RGBA16 => {
            let (a, b) = match i.gather_quads(view.words, word) {
                Some([a, b, c, d]) => ([a, b], [c, d]),
                None => (
                    i.gather_pairs(view.words, word),
                    i.gather_pairs(view.words, word + 2),
                ),
            };
            [color16(i, view.opaque, a), color16(i, view.opaque, b)]
        }
        _ => {
            let [a, b] = i.gather_pairs(view.words, word);
            [color8(i, view.opaque, a), color8(i, view.opaque, b)]
        }
    }
}

/// [`fetch_two`] of addresses in memory.
#[inline(always)]
pub(crate) fn fetch_two_at<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    words: &[u32; 16],
) -> [Color<I>; 2] {
    match of_view::<FORMAT>(view) {
        RGBA16 => {
            if let Some([a, b, c, d]) = i.gather_quads_at(view.words, words) {
                let (a, b) = ([a, b], [c, d]);
                return [color16(i, view.opaque, a), color16(i, view.opaque, b)];
            }
        }
        RGBA8_EXACT => {
            let [a, b] = i.gather_pairs_at(view.words, words);
            return [color8(i, view.opaque, a), color8(i, view.opaque, b)];
        }
        _ => {}
    }
    fetch_two::<I, FORMAT>(i, view, i.load_u32(words))
}

/// A texel, and the next three in memory.
#[inline(always)]
pub(crate) fn fetch_four<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    word: I::U32,
) -> [Color<I>; 4] {
    let format = of_view::<FORMAT>(view);
    if format == RGBA8_EXACT
        && let Some([a, b, c, d]) = i.gather_quads(view.words, word)
    {
        return [
            color8(i, view.opaque, a),
            color8(i, view.opaque, b),
            color8(i, view.opaque, c),
            color8(i, view.opaque, d),
        ];
    }
    let [a, b] = fetch_two::<I, FORMAT>(i, view, word);
    let two = if format == RGBA16 { 4 } else { 2 };
    let [c, d] = fetch_two::<I, FORMAT>(i, view, word + two);
    [a, b, c, d]
}

#[inline(always)]
fn to_f32<I: Isa>(c: I::U32) -> I::F32 {
    c.to_i32().to_f32()
}

/// The bytes of a texel.
#[inline(always)]
pub(crate) fn color8<I: Isa>(i: I, opaque: bool, c: I::U32) -> Color<I> {
    let alpha = if opaque {
        i.f32(255.0)
    } else {
        to_f32::<I>(c >> 24)
    };
    [
        to_f32::<I>(c & 255),
        to_f32::<I>((c >> 8) & 255),
        to_f32::<I>((c >> 16) & 255),
        alpha,
    ]
}

/// The four values of 16 bits of a texel.
#[inline(always)]
pub(crate) fn color16<I: Isa>(i: I, opaque: bool, [a, b]: [I::U32; 2]) -> Color<I> {
    let alpha = if opaque {
        i.f32(65535.0)
    } else {
        to_f32::<I>(b >> 16)
    };
    [
        to_f32::<I>(a & 65535),
        to_f32::<I>(a >> 16),
        to_f32::<I>(b & 65535),
        alpha,
    ]
}

/// A texel, or the border.
#[inline(always)]
pub(crate) fn tap<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    at: TexelAddress<I>,
) -> Color<I> {
    let c = fetch::<I, FORMAT>(i, view, at.word);
    if !view.bordered {
        return c;
    }
    let [r, g, b, a] = view.border;
    select::<I>(at.outside(), [i.f32(r), i.f32(g), i.f32(b), i.f32(a)], c)
}

/// The texels at unwrapped indices (x, y), (x + 1, y), and those of the next row.
#[inline(always)]
pub(crate) fn fetch_corners<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    at: [I::I32; 2],
) -> [[Color<I>; 2]; 2] {
    match level.corners::<FORMAT>(i, view, at) {
        Corners::Pairs([top, bottom]) => [
            fetch_two::<I, FORMAT>(i, view, top),
            fetch_two::<I, FORMAT>(i, view, bottom),
        ],
        // Rare where texels come in pairs, and much code: out of line there. Probes are many, and often at the edges of small levels.
        Corners::Apart(at) if i.has_pairs() && FORMAT != ANY => {
            corners_apart::<I, FORMAT>(i, view, at)
        }
        Corners::Apart([a, b, c, d]) => [
            [tap::<I, FORMAT>(i, view, a), tap::<I, FORMAT>(i, view, b)],
            [tap::<I, FORMAT>(i, view, c), tap::<I, FORMAT>(i, view, d)],
        ],
    }
}

/// Four texels, two of a row and two of the next, that do not lie side by side.
#[inline(never)]
fn corners_apart<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    at: [TexelAddress<I>; 4],
) -> [[Color<I>; 2]; 2] {
    i.vectorize(
        #[inline(always)]
        || {
            let mut texels = [[[i.f32(0.0); 4]; 2]; 2];
            for (texel, at) in texels.as_flattened_mut().iter_mut().zip(at) {
                *texel = tap::<I, FORMAT>(i, view, at);
            }
            texels
        },
    )
}

/// `a + (b - a) w`: exact where both are equal. Alphas are those of `a` if all are one: 255 + 0 w.
#[inline(always)]
pub(crate) fn mix<I: Isa>(
    view: &BoundTexture<'_>,
    a: Color<I>,
    b: Color<I>,
    w: I::F32,
) -> Color<I> {
    [
        a[0] + (b[0] - a[0]) * w,
        a[1] + (b[1] - a[1]) * w,
        a[2] + (b[2] - a[2]) * w,
        if view.opaque {
            a[3]
        } else {
            a[3] + (b[3] - a[3]) * w
        },
    ]
}

/// Two texels of a row and two of the next.
#[inline(always)]
pub(crate) fn mix_four<I: Isa>(
    view: &BoundTexture<'_>,
    [[a, b], [c, d]]: [[Color<I>; 2]; 2],
    [wx, wy]: [I::F32; 2],
) -> Color<I> {
    [
        mix_corners::<I>([a[0], b[0], c[0], d[0]], wx, wy),
        mix_corners::<I>([a[1], b[1], c[1], d[1]], wx, wy),
        mix_corners::<I>([a[2], b[2], c[2], d[2]], wx, wy),
        if view.opaque {
            a[3]
        } else {
            mix_corners::<I>([a[3], b[3], c[3], d[3]], wx, wy)
        },
    ]
}

/// One channel of [`mix_four`].
#[inline(always)]
fn mix_corners<I: Isa>([a, b, c, d]: [I::F32; 4], wx: I::F32, wy: I::F32) -> I::F32 {
    let (top, bottom) = (a + (b - a) * wx, c + (d - c) * wx);
    top + (bottom - top) * wy
}

#[inline(always)]
pub(crate) fn scaled<I: Isa>(c: Color<I>, view: &BoundTexture<'_>) -> Color<I> {
    [
        c[0] * view.scale,
        c[1] * view.scale,
        c[2] * view.scale,
        c[3] * view.scale,
    ]
}

#[inline(always)]
pub(crate) fn select<I: Isa>(mask: I::Mask, a: Color<I>, b: Color<I>) -> Color<I> {
    [
        mask.select(a[0], b[0]),
        mask.select(a[1], b[1]),
        mask.select(a[2], b[2]),
        mask.select(a[3], b[3]),
    ]
}

#[inline(always)]
fn loaded<I: Isa>(i: I, [r, g, b, a]: [&[f32]; 4]) -> Color<I> {
    [i.load_f32(r), i.load_f32(g), i.load_f32(b), i.load_f32(a)]
}

/// Texels that lanes cannot gather: they are fetched one by one, counted through all levels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart<'a> {
    words: &'a [u32],
    format: Format,
    encoded: Option<&'a EncodedBytes>,
    /// Texels that are encoded: those of level 0.
    kept: usize,
    last: usize,
}

impl<'a> Apart<'a> {
    #[inline(always)]
    pub(crate) fn new(chain: &'a Chain<'_>) -> Self {
        let base = &chain.levels[0];
        let (encoded, kept) = match &chain.encoded {
            Some(Encoded::Bytes(bytes)) => {
                (Some(bytes), base.width as usize * base.height as usize)
            }
            // Blocks are fetched in lanes.
            Some(Encoded::Blocks(_)) | None => (None, 0),
        };
        let count = kept + chain.words().len() / chain.format.words();
        Self {
            words: chain.words(),
            format: chain.format,
            encoded,
            kept,
            last: count.saturating_sub(1),
        }
    }

    #[inline(always)]
    pub(crate) fn first_of(&self, level: &Level) -> usize {
        match level.offset {
            Level::ENCODED => 0,
            offset => self.kept + offset / self.format.words(),
        }
    }

    /// Unscaled texels; of those beyond the end, the last.
    #[inline(always)]
    fn fetch<I: Isa>(&self, i: I, texel: I::U32) -> Color<I> {
        let mut at = [0; 16];
        texel.store(&mut at);
        if const { I::LANES == 1 } {
            let [r, g, b, a] = self.texel((at[0] as usize).min(self.last));
            return [i.f32(r), i.f32(g), i.f32(b), i.f32(a)];
        }
        if const { I::LANES == 4 } {
            let [r, g, b, a] = self.several::<4>(&at);
            return loaded(i, [&r, &g, &b, &a]);
        }
        let [r, g, b, a] = self.several::<16>(&at);
        loaded(i, [&r, &g, &b, &a])
    }

    #[inline(always)]
    fn texel(&self, i: usize) -> [f32; 4] {
        match (self.encoded, i.checked_sub(self.kept)) {
            (Some(encoded), None) => encoded.fetch(i),
            (Some(_), Some(i)) => Format::Rgba16.fetch(self.words, 2 * i),
            (None, _) => self.format.fetch(self.words, i * self.format.words()),
        }
    }

    /// The first `N`, channel by channel. One compiled form serves all filters and levels.
    #[inline(never)]
    fn several<const N: usize>(&self, at: &[u32; 16]) -> [[f32; N]; 4] {
        let (words, kept) = (self.words, self.kept);
        // The kind of texel is asked once.
        match (self.encoded, self.format) {
            (Some(encoded), _) => self.each::<N>(at, |i| match i.checked_sub(kept) {
                None => encoded.decode(i),
                Some(i) => Format::Rgba16.fetch(words, 2 * i),
            }),
            (None, Format::Rgba32) => {
                let texels = words.as_chunks::<4>().0;
                self.each::<N>(at, |i| texels[i].map(f32::from_bits))
            }
            (None, format) => self.each::<N>(at, |i| format.fetch(words, i * format.words())),
        }
    }

    #[inline(always)]
    fn each<const N: usize>(
        &self,
        at: &[u32; 16],
        texel: impl Fn(usize) -> [f32; 4],
    ) -> [[f32; N]; 4] {
        let mut out = [[0.0; N]; 4];
        for (i, at) in at.iter().take(N).enumerate() {
            let [r, g, b, a] = texel((*at as usize).min(self.last));
            (out[0][i], out[1][i], out[2][i], out[3][i]) = (r, g, b, a);
        }
        out
    }
}
