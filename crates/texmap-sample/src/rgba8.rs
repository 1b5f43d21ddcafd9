//! `Precision::Fast` on 8-bit texels: 8-bit weights, rounded to 8 bits after every blend.
//!
//! Two channels share a 32-bit word as 16-bit halves; `(a << 8) + (b - a) w + 128` stays below 2^16
//! whatever the sign of `b - a`, so wrapping 16-bit products are exact. The scalar form stands first. The functions over lanes want a
//! view whose format is [`RGBA8`], those of [`float`](super::float) the others: debug builds check it.

use super::{At, Corners, Place, RGBA8, View};
use crate::{
    filter::{axes, floor, gl_of},
    lod::{LIMIT, TINY, TexelFootprint, log2_sqrt_fixed},
    sampler::{Filter, Mip, Precision, Sampler, Texel},
    texels::{Chain, Format, Level, floats, scaled},
    wrap::{OUTSIDE, Wrap},
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, prelude::*, u16x32, u32x16},
    lanes::{above, below, floor_to_i32, gather, gather_pairs, lerp_bytes, look_up, store_tail},
};

const LOW: u32 = 0x00ff_00ff;

/// Whether a sampler takes this path on a texture: floats and 16-bit texels keep f32 weights.
pub(crate) fn applies(s: &Sampler, t: &Chain<'_>) -> bool {
    // A texel that is taken whole needs no weights; a border keeps its floats.
    let border = s.wrap_u == Wrap::ClampToBorder || s.wrap_v == Wrap::ClampToBorder;
    let whole = s.filter == Filter::Nearest && !border;
    (s.precision == Precision::Fast || whole)
        && t.format == Format::Rgba8
        && !matches!(s.filter, Filter::Bicubic(_) | Filter::Ewa { .. })
}

/// Bytes to 0..1.
pub(crate) fn unpack(c: u32) -> [f32; 4] {
    let bytes = [c & 255, c >> 8 & 255, c >> 16 & 255, c >> 24];
    scaled(floats(bytes), Format::Rgba8.scale())
}

/// Bytes to 0..1 for sixteen, channel by channel.
#[inline(always)]
pub fn unpack_lanes<S: Simd>(_s: S, c: u32x16<S>) -> [f32x16<S>; 4] {
    let scale = Format::Rgba8.scale();
    let of = [c & 255, (c >> 8) & 255, (c >> 16) & 255, c >> 24];
    [
        of[0].bitcast::<i32x16<S>>().to_float::<f32x16<S>>() * scale,
        of[1].bitcast::<i32x16<S>>().to_float::<f32x16<S>>() * scale,
        of[2].bitcast::<i32x16<S>>().to_float::<f32x16<S>>() * scale,
        of[3].bitcast::<i32x16<S>>().to_float::<f32x16<S>>() * scale,
    ]
}

/// [`unpack`] into columns.
pub(crate) fn unpack_columns<S: Simd>(s: S, words: &[u32], mut out: [&mut [f32]; 4]) {
    s.vectorize(
        #[inline(always)]
        || {
            let mut last = [0; 16];
            for (i, words) in words.chunks(16).enumerate() {
                last[..words.len()].copy_from_slice(words);
                let end = 16 * i + words.len();
                let c = unpack_lanes(s, u32x16::from_slice(s, &last));
                for (k, out) in out.iter_mut().enumerate() {
                    store_tail(c[k], &mut out[16 * i..end]);
                }
            }
        },
    );
}

/// A limited level of detail with 8 fraction bits.
pub(crate) fn fixed_lod(lod: f32) -> i32 {
    // Within +-64 levels, so that the conversion is in range.
    let lod = if lod > 64.0 { 64.0 } else { lod };
    let lod = if lod > -64.0 { lod } else { -64.0 };
    floor(lod * 256.0)
}

/// Squared ratio of axes, in quarter octaves of the ratio, to the number of probes.
static PROBES: [u32; 16] = [1, 2, 2, 2, 2, 3, 3, 4, 4, 5, 6, 7, 8, 10, 12, 16];
/// 256 log2 of the number of probes, from 1 on.
static PROBE_LEVELS: [u32; 16] = [
    0, 256, 406, 512, 594, 662, 719, 768, 811, 850, 886, 918, 947, 975, 1000, 1024,
];

/// The footprint of one look-up: how many probes, how far apart (uv), on which level.
struct Probes {
    count: u32,
    step: [f32; 2],
    lod: i32,
}

/// `1 / sqrt(x)` within 0.2 %: the float's bits halved, and one Newton step.
fn rsqrt(x: f32) -> f32 {
    let y = f32::from_bits(0x5f37_59df_u32.wrapping_sub(x.to_bits() >> 1));
    y * (1.5 - 0.5 * x * y * y)
}

fn probes(s: &Sampler, t: &Chain<'_>, d: &TexelFootprint, most: u8) -> Probes {
    let p = d.ux * d.ux + d.uy * d.uy;
    let r = d.vx * d.vx + d.vy * d.vy;
    let q = d.ux * d.vx + d.uy * d.vy;
    let half = 0.5 * (p - r);
    let square = half * half + q * q;
    let root = square * rsqrt(square);
    let major2 = 0.5 * (p + r) + root;
    let det = d.ux * d.vy - d.uy * d.vx;
    let det2 = det * det;
    let log_major = log2_sqrt_fixed(major2);
    // ratio^2 = major2 / minor2 = major2^2 / det^2, in fixed-point logarithms of lengths; a short axis below a texel counts as one.
    let ratio = 2 * log_major - log2_sqrt_fixed(det2);
    let ratio = if ratio < log_major { ratio } else { log_major };
    let slot = if ratio < 0 {
        0
    } else if ratio > 1023 {
        15
    } else {
        ratio >> 6
    };
    let count = PROBES[slot as usize];
    let count = if count < u32::from(most) {
        count
    } else {
        u32::from(most)
    };
    let count = if major2 > 1.0 { count } else { 1 };
    let (x, y) = if half >= 0.0 {
        (half + root, q)
    } else {
        (q, root - half)
    };
    let length2 = x * x + y * y;
    // The square of what probes are spread over, as `Axes::spread` has it.
    let along2 = p + r - 1.0;
    let along2 = if along2 < major2 { along2 } else { major2 };
    let along2 = if along2 > 0.0 { along2 } else { 0.0 };
    let k = along2 * rsqrt(along2) * rsqrt(length2);
    let share = 1.0 / count as f32;
    let base = &t.levels[0];
    let lod = log_major - PROBE_LEVELS[count as usize - 1] as i32;
    Probes {
        count,
        step: [
            x * k * share * (1.0 / base.width as f32),
            y * k * share * (1.0 / base.height as f32),
        ],
        lod: fixed_lod(s.limit_lod(lod as f32 / 256.0)),
    }
}

pub(crate) fn sample_grad(s: &Sampler, t: &Chain<'_>, uv: [f32; 2], d: &TexelFootprint) -> u32 {
    let Filter::Anisotropic(most) = s.filter else {
        let lod = log2_sqrt_fixed(d.rho_max_squared()) as f32 / 256.0;
        return sample_lod(s, t, uv, fixed_lod(s.limit_lod(lod)));
    };
    let probes = probes(s, t, d, most.clamp(1, 16));
    let last = t.levels.len() as i32 - 1;
    let level = (probes.lod + 128) >> 8;
    let level = if level < 0 {
        0
    } else if level > last {
        last
    } else {
        level
    };
    let level = &t.levels[level as usize];
    let n = probes.count as f32;
    let (mut low, mut high) = (0, 0);
    for k in 0..probes.count {
        let at = k as f32 + 0.5 * (1.0 - n);
        let c = bilinear(
            s,
            t,
            level,
            [uv[0] + probes.step[0] * at, uv[1] + probes.step[1] * at],
        );
        low += c & LOW;
        high += c >> 8 & LOW;
    }
    let share = 1.0 / n;
    let mean = |sum: u32| (sum as f32 * share + 0.5) as u32;
    mean(low & 0xffff) | mean(high & 0xffff) << 8 | mean(low >> 16) << 16 | mean(high >> 16) << 24
}

/// `lod` has 8 fraction bits, bias and limits behind it.
pub(crate) fn sample_lod(s: &Sampler, t: &Chain<'_>, uv: [f32; 2], lod: i32) -> u32 {
    let (mag, min, mip) = gl_of(s.filter);
    if lod <= 0 {
        return in_level(s, t, 0, uv, mag);
    }
    let last = t.levels.len() as i32 - 1;
    let lod = if lod > last << 8 { last << 8 } else { lod };
    match mip {
        Mip::None => in_level(s, t, 0, uv, min),
        // ceil(lod + 1/2) - 1: halves go to the finer level.
        Mip::Nearest => in_level(s, t, (lod + 127) >> 8, uv, min),
        Mip::Linear => {
            let fine = in_level(s, t, lod >> 8, uv, min);
            let w = (lod & 255) as u32;
            if w == 0 {
                fine
            } else {
                lerp(fine, in_level(s, t, (lod >> 8) + 1, uv, min), w)
            }
        }
    }
}

fn in_level(s: &Sampler, t: &Chain<'_>, level: i32, uv: [f32; 2], texel: Texel) -> u32 {
    let level = &t.levels[level as usize];
    match texel {
        Texel::Nearest => {
            let [ax, ay] = axes(s, t);
            let x = ax.index(floor(ax.place(uv[0], level.width)), level.width);
            let y = ay.index(floor(ay.place(uv[1], level.height)), level.height);
            tap(s, t, level, x, y)
        }
        Texel::Linear => bilinear(s, t, level, uv),
    }
}

fn bilinear(s: &Sampler, t: &Chain<'_>, level: &Level, uv: [f32; 2]) -> u32 {
    let [ax, ay] = axes(s, t);
    let x = floor(ax.place(uv[0], level.width) * 256.0) - 128;
    let y = floor(ay.place(uv[1], level.height) * 256.0) - 128;
    let ([x0, x1], [y0, y1]) = (ax.pair(x >> 8, level.width), ay.pair(y >> 8, level.height));
    let (wx, wy) = ((x & 255) as u32, (y & 255) as u32);
    let top = lerp(tap(s, t, level, x0, y0), tap(s, t, level, x1, y0), wx);
    let bottom = lerp(tap(s, t, level, x0, y1), tap(s, t, level, x1, y1), wx);
    lerp(top, bottom, wy)
}

#[inline(always)]
fn tap(s: &Sampler, t: &Chain<'_>, level: &Level, x: i32, y: i32) -> u32 {
    if x == OUTSIDE || y == OUTSIDE {
        return border(s.border);
    }
    let y = if t.flip { level.height - 1 - y } else { y };
    t.words()[level.offset + (y as usize * level.width as usize) + x as usize]
}

/// A colour as packed bytes.
pub(super) fn border(c: [f32; 4]) -> u32 {
    let byte = |c: f32| {
        let c = c * 255.0;
        let c = if c > 0.0 { c } else { 0.0 };
        let c = if c < 255.0 { c } else { 255.0 };
        (c + 0.5) as u32
    };
    byte(c[0]) | byte(c[1]) << 8 | byte(c[2]) << 16 | byte(c[3]) << 24
}

/// `a + (b - a) w / 256` per byte, rounded: each in 16 bits of its own, which the sum does not leave.
#[inline(always)]
fn lerp(a: u32, b: u32, w: u32) -> u32 {
    const HALVES: u64 = 0x0080_0080_0080_0080;
    let (a, b) = (apart(a), apart(b));
    let sum = (a << 8)
        .wrapping_add(b.wrapping_sub(a).wrapping_mul(u64::from(w)))
        .wrapping_add(HALVES);
    let (low, high) = ((sum >> 8) as u32 & LOW, (sum >> 40) as u32 & LOW);
    low | high << 8
}

/// The even bytes and then the odd ones, 16 bits each.
#[inline(always)]
fn apart(c: u32) -> u64 {
    u64::from(c & LOW) | u64::from(c >> 8 & LOW) << 32
}

/// [`bilinear`] and its kin for sixteen lanes: the even and odd bytes apart.
#[derive(Clone, Copy)]
pub(super) struct Halves<S: Simd> {
    low: u16x32<S>,
    high: u16x32<S>,
}

#[inline(always)]
pub(super) fn halves<S: Simd>(c: u32x16<S>) -> Halves<S> {
    Halves {
        low: (c & LOW).bitcast(),
        high: c.bitcast::<u16x32<S>>() >> 8,
    }
}

#[inline(always)]
pub(super) fn join<S: Simd>(c: Halves<S>) -> u32x16<S> {
    let (low, high): (u32x16<S>, u32x16<S>) = (c.low.bitcast(), c.high.bitcast());
    low | (high << 8)
}

/// The weight in both halves of every word.
#[inline(always)]
pub(super) fn spread<S: Simd>(w: i32x16<S>) -> u16x32<S> {
    (w | (w << 16)).bitcast()
}

#[inline(always)]
pub(super) fn lerp_lanes<S: Simd>(s: S, a: Halves<S>, b: Halves<S>, w: u16x32<S>) -> Halves<S> {
    Halves {
        low: lerp_bytes(s, a.low, b.low, w),
        high: lerp_bytes(s, a.high, b.high, w),
    }
}

#[inline(always)]
fn tap_lanes<S: Simd>(s: S, view: &View<'_>, place: Place<S>) -> u32x16<S> {
    let c = gather(s, view.words, place.word);
    if view.bordered {
        return place
            .outside(s)
            .select(u32x16::splat(s, view.border_word), c);
    }
    c
}

/// The nearest texel of level 0 for each lane.
#[inline(always)]
pub fn nearest_lanes<S: Simd>(s: S, view: &View<'_>, u: f32x16<S>, v: f32x16<S>) -> u32x16<S> {
    nearest_at(s, view, &At::uniform(s, view, 0), u, v)
}

#[inline(always)]
pub(super) fn nearest_at<S: Simd>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> u32x16<S> {
    debug_assert_eq!(view.format, RGBA8, "bytes that are read whole");
    let (x, y) = at.place(s, view, u, v);
    let (i, j) = (floor_to_i32(s, x) >> 8, floor_to_i32(s, y) >> 8);
    tap_lanes(s, view, at.texel::<RGBA8>(s, view, i, j))
}

/// The finest level of a view whose wraps are masks, in lanes once for many look-ups.
#[derive(Clone, Copy)]
pub struct Masked<'v, S: Simd> {
    view: &'v View<'v>,
    at: At<S>,
}

impl<S: Simd> core::fmt::Debug for Masked<'_, S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Masked")
    }
}

impl<'v, S: Simd> Masked<'v, S> {
    /// `None` under other wraps, and for sides that are no powers of two.
    #[inline(always)]
    pub fn new(s: S, view: &'v View<'v>) -> Option<Self> {
        debug_assert_eq!(view.format, RGBA8, "bytes that are read whole");
        view.masked.then(|| Self {
            view,
            at: At::uniform(s, view, 0),
        })
    }

    /// [`nearest_lanes`] in a fraction of its code, which leaves registers to the loop around.
    #[inline(always)]
    pub fn nearest(&self, s: S, u: f32x16<S>, v: f32x16<S>) -> u32x16<S> {
        let Self { view, at } = self;
        let (x, y) = at.place_masked(s, view, u, v);
        let (i, j) = (floor_to_i32(s, x) >> 8, floor_to_i32(s, y) >> 8);
        gather(s, view.words, at.texel_masked::<RGBA8>(view, i, j).word)
    }
}

/// Bilinear on level 0 for each lane.
#[inline(always)]
pub fn bilinear_lanes<S: Simd>(s: S, view: &View<'_>, u: f32x16<S>, v: f32x16<S>) -> u32x16<S> {
    join(bilinear_at::<S>(s, view, &At::uniform(s, view, 0), u, v))
}

#[inline(always)]
pub(super) fn bilinear_at<S: Simd>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> Halves<S> {
    bilinear_of(s, view, at, steps_at(s, view, at, u, v))
}

/// Places in whole 256ths of texels of a level.
#[inline(always)]
fn steps_at<S: Simd>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> [i32x16<S>; 2] {
    let (x, y) = at.place(s, view, u, v);
    [floor_to_i32(s, x), floor_to_i32(s, y)]
}

/// [`bilinear_at`] such places.
#[inline(always)]
fn bilinear_of<S: Simd>(s: S, view: &View<'_>, at: &At<S>, [x, y]: [i32x16<S>; 2]) -> Halves<S> {
    debug_assert_eq!(view.format, RGBA8, "bytes that are read whole");
    let (x, y) = (x - 128, y - 128);
    let (wx, wy) = (spread(x & 255), spread(y & 255));
    let (i, j) = (x >> 8, y >> 8);
    let [a, b, c, d] = match at.corners::<RGBA8>(s, view, i, j) {
        Corners::Pairs([top, bottom]) => {
            let [a, b] = gather_pairs(s, view.words, top);
            let [c, d] = gather_pairs(s, view.words, bottom);
            [a, b, c, d]
        }
        Corners::Apart([a, b, c, d]) => [
            tap_lanes(s, view, a),
            tap_lanes(s, view, b),
            tap_lanes(s, view, c),
            tap_lanes(s, view, d),
        ],
    };
    let top = lerp_lanes(s, halves(a), halves(b), wx);
    let bottom = lerp_lanes(s, halves(c), halves(d), wx);
    lerp_lanes(s, top, bottom, wy)
}

/// Derivatives in texels of level 0, finite and within reach, of sixteen lanes.
#[derive(Clone, Copy)]
pub struct FootprintLanes<S: Simd> {
    pub(crate) ux: f32x16<S>,
    pub(crate) vx: f32x16<S>,
    pub(crate) uy: f32x16<S>,
    pub(crate) vy: f32x16<S>,
}

impl<S: Simd> core::fmt::Debug for FootprintLanes<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("FootprintLanes")
    }
}

impl<S: Simd> FootprintLanes<S> {
    /// From derivatives of uv.
    #[inline(always)]
    pub fn new(
        s: S,
        view: &View<'_>,
        ux: f32x16<S>,
        vx: f32x16<S>,
        uy: f32x16<S>,
        vy: f32x16<S>,
    ) -> Self {
        let (w, h) = view.size();
        let (w, h) = (w as f32, h as f32);
        let (ux, vx, uy, vy) = (ux * w, vx * h, uy * w, vy * h);
        // One test for all four: the sum is NaN or large where any of them is.
        let sum = (ux * ux + vx * vx) + (uy * uy + vy * vy);
        if sum.simd_lt(f32x16::splat(s, LIMIT)).all_true() {
            return Self { ux, vx, uy, vy };
        }
        Self {
            ux: tame(s, ux),
            vx: tame(s, vx),
            uy: tame(s, uy),
            vy: tame(s, vy),
        }
    }

    /// Scalar `TexelFootprint::times`.
    #[inline(always)]
    pub(crate) fn times(&self, by: f32) -> Self {
        Self {
            ux: self.ux * by,
            vx: self.vx * by,
            uy: self.uy * by,
            vy: self.vy * by,
        }
    }

    #[inline(always)]
    pub(crate) fn rho_max_squared(&self) -> f32x16<S> {
        let x = self.ux * self.ux + self.vx * self.vx;
        let y = self.uy * self.uy + self.vy * self.vy;
        above(x, y)
    }
}

#[inline(always)]
fn tame<S: Simd>(s: S, x: f32x16<S>) -> f32x16<S> {
    let limit = f32x16::splat(s, LIMIT);
    let x = x.simd_eq(x).select(x, f32x16::splat(s, 0.0));
    let x = x.simd_gt(limit).select(limit, x);
    x.simd_lt(-limit).select(-limit, x)
}

#[inline(always)]
fn log2_sqrt_lanes<S: Simd>(s: S, x: f32x16<S>) -> i32x16<S> {
    let tiny = f32x16::splat(s, TINY);
    let bits: i32x16<S> = above(x, tiny).bitcast();
    (bits - 0x3f80_0000) >> 16
}

/// Bias and limits in f32, as the scalar form has them, then 8 fraction bits.
#[inline(always)]
fn limit_lanes<S: Simd>(s: S, view: &View<'_>, lod: i32x16<S>) -> i32x16<S> {
    if view.plain_lod {
        return lod;
    }
    let lod = super::float::limit_lanes(s, view, lod.to_float::<f32x16<S>>() * (1.0 / 256.0));
    let (low, high) = (f32x16::splat(s, -64.0), f32x16::splat(s, 64.0));
    let lod = lod.simd_gt(high).select(high, lod);
    let lod = lod.simd_gt(low).select(lod, low);
    floor_to_i32(s, lod * 256.0)
}

/// Level of detail with 8 fraction bits, limited (to 0 and above only where that is not all of it).
#[inline(always)]
pub fn lod_lanes<S: Simd>(s: S, view: &View<'_>, d: &FootprintLanes<S>) -> i32x16<S> {
    limit_lanes(s, view, log2_sqrt_lanes(s, d.rho_max_squared()))
}

/// The scalar trilinear filter for sixteen lanes: vectors of one level take short cuts.
#[inline(always)]
pub fn trilinear_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    u: f32x16<S>,
    v: f32x16<S>,
    lod: i32x16<S>,
) -> u32x16<S> {
    let zero = i32x16::splat(s, 0);
    let top = i32x16::splat(s, view.last << 8);
    let lod = lod.simd_gt(top).select(top, lod);
    let lod = lod.simd_gt(zero).select(lod, zero);
    let (fine, weight) = (lod >> 8, lod & 255);
    let level = fine[0];
    let next = if level < view.last { level + 1 } else { level };
    let (a, b) = if fine.simd_eq(zero + level).all_true() {
        (At::uniform(s, view, level), At::uniform(s, view, next))
    } else {
        let last = i32x16::splat(s, view.last);
        let next = fine + 1;
        (
            At::per_lane(s, view, fine),
            At::per_lane(s, view, next.simd_gt(last).select(last, next)),
        )
    };
    let steps = steps_at(s, view, &a, u, v);
    let a = bilinear_of(s, view, &a, steps);
    if weight.simd_eq(zero).all_true() {
        return join(a);
    }
    // Powers of two times a coordinate are exact: a level of half the size has half the steps, rounded down. Where a side is one texel
    // long, all places on it are the same, and where there is no next level it weighs nothing.
    let steps = if view.masked {
        [steps[0] >> 1, steps[1] >> 1]
    } else {
        steps_at(s, view, &b, u, v)
    };
    let b = bilinear_of(s, view, &b, steps);
    join(lerp_lanes(s, a, b, spread(weight)))
}

#[inline(always)]
fn rsqrt_lanes<S: Simd>(s: S, x: f32x16<S>) -> f32x16<S> {
    let bits: u32x16<S> = x.bitcast();
    let y: f32x16<S> = (u32x16::splat(s, 0x5f37_59df) - (bits >> 1)).bitcast();
    y * (1.5 - x * 0.5 * y * y)
}

/// The scalar anisotropic filter for sixteen lanes.
#[inline(always)]
pub fn anisotropic_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    u: f32x16<S>,
    v: f32x16<S>,
    d: &FootprintLanes<S>,
) -> u32x16<S> {
    let (one_f, zero) = (f32x16::splat(s, 1.0), i32x16::splat(s, 0));
    let p = d.ux * d.ux + d.uy * d.uy;
    let r = d.vx * d.vx + d.vy * d.vy;
    // Where the squares of both axes add up to less than one (and the 0.2 % of the root below), there
    // is one probe on level 0.
    if view.plain_lod && (p + r).simd_lt(f32x16::splat(s, 0.99)).all_true() {
        let at = At::uniform(s, view, 0);
        return join(bilinear_at::<S>(s, view, &at, u, v));
    }
    let q = d.ux * d.vx + d.uy * d.vy;
    let half = (p - r) * 0.5;
    let square = half * half + q * q;
    let root = square * rsqrt_lanes(s, square);
    let major2 = (p + r) * 0.5 + root;
    let magnified = !major2.simd_gt(one_f);
    let log_major = log2_sqrt_lanes(s, major2);
    let det = d.ux * d.vy - d.uy * d.vx;
    let ratio = (log_major << 1) - log2_sqrt_lanes(s, det * det);
    let ratio = ratio.simd_lt(log_major).select(ratio, log_major);
    let slot = ratio.simd_lt(zero).select(zero, ratio >> 6);
    let last_slot = i32x16::splat(s, 15);
    let slot = slot.simd_gt(last_slot).select(last_slot, slot);
    let most = i32x16::splat(s, i32::from(view.most));
    let count: i32x16<S> = look_up(s, &PROBES, slot.bitcast()).bitcast();
    let count = count.simd_lt(most).select(count, most);
    let count = magnified.select(i32x16::splat(s, 1), count);
    let level_drop: i32x16<S> = look_up(s, &PROBE_LEVELS, (count - 1).bitcast()).bitcast();
    let steep = !half.simd_ge(f32x16::splat(s, 0.0));
    let x = steep.select(q, half + root);
    let y = steep.select(root - half, q);
    let length2 = x * x + y * y;
    let along2 = below((p + r) - 1.0, major2);
    let along2 = above(along2, f32x16::splat(s, 0.0));
    let k = along2 * rsqrt_lanes(s, along2) * rsqrt_lanes(s, length2);
    let n = count.to_float::<f32x16<S>>();
    let share = one_f / n;
    let (w, h) = view.size();
    let step_u = x * k * share * (1.0 / w as f32);
    let step_v = y * k * share * (1.0 / h as f32);
    let lod = limit_lanes(s, view, log_major - level_drop);
    let level = (lod + 128) >> 8;
    let level = level.simd_lt(zero).select(zero, level);
    let top = i32x16::splat(s, view.last);
    let level = level.simd_gt(top).select(top, level);
    let first = (one_f - n) * 0.5;
    let at = At::of(s, view, level);
    let mut low = u16x32::splat(s, 0);
    let mut high = u16x32::splat(s, 0);
    let mut k = 0;
    loop {
        let active = count.simd_gt(i32x16::splat(s, k));
        if !active.any_true() {
            break;
        }
        let place = first + k as f32;
        let c = bilinear_at::<S>(s, view, &at, u + step_u * place, v + step_v * place);
        // All ones where the probe counts.
        let mask: u16x32<S> = active.select(i32x16::splat(s, -1), zero).bitcast();
        low += c.low & mask;
        high += c.high & mask;
        k += 1;
    }
    let (low, high): (u32x16<S>, u32x16<S>) = (low.bitcast(), high.bitcast());
    let mean = MeanOf { share };
    mean.of(low & 0xffff)
        | mean.of(high & 0xffff) << 8
        | mean.of(low >> 16) << 16
        | mean.of(high >> 16) << 24
}

#[derive(Clone, Copy)]
struct MeanOf<S: Simd> {
    share: f32x16<S>,
}

impl<S: Simd> MeanOf<S> {
    #[inline(always)]
    fn of(self, sum: u32x16<S>) -> u32x16<S> {
        let sum: i32x16<S> = sum.bitcast();
        let mean: i32x16<S> = (sum.to_float::<f32x16<S>>() * self.share + 0.5).to_int();
        mean.bitcast()
    }
}
