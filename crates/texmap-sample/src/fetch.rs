//! The f32 filters for sixteen lanes; the scalar twins are in `filter.rs`.

use super::{ANY, APART, At, Corners, Place, RGBA8_EXACT, RGBA16, View, packed::FootprintLanes};
use crate::{
    lod::{LOG2_POLYNOMIAL, TINY},
    sampler::Precision,
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
    lanes::{floor_to_i32, gather, gather_pairs, gather_quads},
};

/// Red, green, blue, alpha of sixteen lanes.
pub type Color<S> = [f32x16<S>; 4];

#[inline(always)]
fn to_float<S: Simd>(c: u32x16<S>) -> f32x16<S> {
    let c: i32x16<S> = c.bitcast();
    c.to_float()
}

/// The format of a kernel that has one, else the view's.
#[inline(always)]
fn of_view<const FORMAT: u8>(view: &View<'_>) -> u8 {
    debug_assert!(
        FORMAT == ANY || FORMAT == view.format,
        "the texels of a view"
    );
    if FORMAT == ANY { view.format } else { FORMAT }
}

#[inline(always)]
pub(crate) fn fetch<S: Simd, const FORMAT: u8>(s: S, view: &View<'_>, word: u32x16<S>) -> Color<S> {
    match of_view::<FORMAT>(view) {
        APART => apart(s, view, word),
        RGBA16 => color16(s, view, gather_pairs(s, view.words, word)),
        _ => color8(s, view, gather(s, view.words, word)),
    }
}

/// A texel, and the next in memory.
#[inline(always)]
pub(crate) fn fetch_two<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    word: u32x16<S>,
) -> [Color<S>; 2] {
    match of_view::<FORMAT>(view) {
        APART => [apart(s, view, word), apart(s, view, word + 1)],
        RGBA16 => {
            let (a, b) = match gather_quads(s, view.words, word) {
                Some([a, b, c, d]) => ([a, b], [c, d]),
                None => (
                    gather_pairs(s, view.words, word),
                    gather_pairs(s, view.words, word + 2),
                ),
            };
            [color16(s, view, a), color16(s, view, b)]
        }
        _ => {
            let [a, b] = gather_pairs(s, view.words, word);
            [color8(s, view, a), color8(s, view, b)]
        }
    }
}

/// A texel, and the next three in memory.
#[inline(always)]
pub(crate) fn fetch_four<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    word: u32x16<S>,
) -> [Color<S>; 4] {
    let format = of_view::<FORMAT>(view);
    if format == RGBA8_EXACT
        && let Some([a, b, c, d]) = gather_quads(s, view.words, word)
    {
        return [
            color8(s, view, a),
            color8(s, view, b),
            color8(s, view, c),
            color8(s, view, d),
        ];
    }
    let [a, b] = fetch_two::<S, FORMAT>(s, view, word);
    let two = if format == RGBA16 { 4 } else { 2 };
    let [c, d] = fetch_two::<S, FORMAT>(s, view, word + two);
    [a, b, c, d]
}

#[inline(always)]
fn apart<S: Simd>(s: S, view: &View<'_>, texel: u32x16<S>) -> Color<S> {
    let mut at = [0; 16];
    texel.store_slice(&mut at);
    let [r, g, b, a] = view.apart.fetch(&at);
    [
        f32x16::from_slice(s, &r),
        f32x16::from_slice(s, &g),
        f32x16::from_slice(s, &b),
        f32x16::from_slice(s, &a),
    ]
}

#[inline(always)]
fn color8<S: Simd>(s: S, view: &View<'_>, c: u32x16<S>) -> Color<S> {
    let alpha = if view.opaque {
        f32x16::splat(s, 255.0)
    } else {
        to_float(c >> 24)
    };
    [
        to_float(c & 255),
        to_float((c >> 8) & 255),
        to_float((c >> 16) & 255),
        alpha,
    ]
}

#[inline(always)]
fn color16<S: Simd>(s: S, view: &View<'_>, [a, b]: [u32x16<S>; 2]) -> Color<S> {
    let alpha = if view.opaque {
        f32x16::splat(s, 65535.0)
    } else {
        to_float(b >> 16)
    };
    [
        to_float(a & 65535),
        to_float(a >> 16),
        to_float(b & 65535),
        alpha,
    ]
}

/// A texel, or the border.
#[inline(always)]
pub(crate) fn tap<S: Simd, const FORMAT: u8>(s: S, view: &View<'_>, place: Place<S>) -> Color<S> {
    let c = fetch::<S, FORMAT>(s, view, place.word);
    if !view.bordered {
        return c;
    }
    let [r, g, b, a] = view.border;
    let border = [
        f32x16::splat(s, r),
        f32x16::splat(s, g),
        f32x16::splat(s, b),
        f32x16::splat(s, a),
    ];
    select(place.outside(s), border, c)
}

/// Alphas are those of `a` if all are one: 255 + 0 w.
#[inline(always)]
pub(crate) fn mix<S: Simd>(view: &View<'_>, a: Color<S>, b: Color<S>, w: f32x16<S>) -> Color<S> {
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
pub(crate) fn mix_four<S: Simd>(
    view: &View<'_>,
    [a, b]: [Color<S>; 2],
    [c, d]: [Color<S>; 2],
    wx: f32x16<S>,
    wy: f32x16<S>,
) -> Color<S> {
    let (top, bottom) = (mix(view, a, b, wx), mix(view, c, d, wx));
    mix(view, top, bottom, wy)
}

#[inline(always)]
pub(crate) fn bilinear_at<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> Color<S> {
    let (x, y) = at.place(s, view, u, v);
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (floor_to_i32(s, x), floor_to_i32(s, y));
    let (wx, wy) = (x - i.to_float::<f32x16<S>>(), y - j.to_float::<f32x16<S>>());
    let [top, bottom] = match at.corners::<FORMAT>(s, view, i, j) {
        Corners::Pairs([top, bottom]) => [
            fetch_two::<S, FORMAT>(s, view, top),
            fetch_two::<S, FORMAT>(s, view, bottom),
        ],
        Corners::Apart([a, b, c, d]) => [
            [tap::<S, FORMAT>(s, view, a), tap::<S, FORMAT>(s, view, b)],
            [tap::<S, FORMAT>(s, view, c), tap::<S, FORMAT>(s, view, d)],
        ],
    };
    mix_four(view, top, bottom, wx, wy)
}

#[inline(always)]
pub(super) fn nearest_at<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> Color<S> {
    let (x, y) = at.place(s, view, u, v);
    let place = at.texel::<FORMAT>(s, view, floor_to_i32(s, x), floor_to_i32(s, y));
    tap::<S, FORMAT>(s, view, place)
}

/// The nearest texels of level 0, scaled.
#[inline(always)]
pub fn nearest_lanes<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> Color<S> {
    let at = At::uniform(s, view, 0);
    scaled(nearest_at::<S, FORMAT>(s, view, &at, u, v), view)
}

/// Bilinear on level 0, scaled. `FORMAT` is the view's.
#[inline(always)]
pub fn bilinear_lanes<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> Color<S> {
    let at = At::uniform(s, view, 0);
    scaled(bilinear_at::<S, FORMAT>(s, view, &at, u, v), view)
}

#[inline(always)]
pub(crate) fn scaled<S: Simd>(c: Color<S>, view: &View<'_>) -> Color<S> {
    [
        c[0] * view.scale,
        c[1] * view.scale,
        c[2] * view.scale,
        c[3] * view.scale,
    ]
}

/// Scalar `log2` for sixteen lanes.
#[inline(always)]
pub(crate) fn log2<S: Simd>(s: S, x: f32x16<S>) -> f32x16<S> {
    let tiny = f32x16::splat(s, TINY);
    let bits: u32x16<S> = x.simd_gt(tiny).select(x, tiny).bitcast();
    let exponent: i32x16<S> = (bits >> 23).bitcast();
    let exponent = (exponent - 127).to_float::<f32x16<S>>();
    let mantissa: f32x16<S> = ((bits & 0x007f_ffff) | 0x3f80_0000).bitcast();
    let t = mantissa - 1.0;
    let [c0, c1, c2, c3, c4, c5] = LOG2_POLYNOMIAL;
    let q = t * c5 + c4;
    let q = t * q + c3;
    let q = t * q + c2;
    let q = t * q + c1;
    let q = t * q + c0;
    exponent + t * q
}

/// Bias and limits, as `Sampler::limit_lod`.
#[inline(always)]
pub(crate) fn limit_lanes<S: Simd>(s: S, view: &View<'_>, lod: f32x16<S>) -> f32x16<S> {
    let lod = lod + view.bias;
    let (low, high) = (
        f32x16::splat(s, view.lod_min),
        f32x16::splat(s, view.lod_max),
    );
    let lod = lod.simd_lt(low).select(low, lod);
    lod.simd_gt(high).select(high, lod)
}

/// The level of detail of a footprint by the view's precision, limited.
#[inline(always)]
pub fn lod_lanes<S: Simd>(s: S, view: &View<'_>, d: &FootprintLanes<S>) -> f32x16<S> {
    let rho2 = d.rho_max_squared();
    let lod = match view.precision {
        Precision::Exact => log2(s, rho2) * 0.5,
        Precision::Fast => {
            let tiny = f32x16::splat(s, TINY);
            let bits: i32x16<S> = rho2.simd_gt(tiny).select(rho2, tiny).bitcast();
            ((bits - 0x3f80_0000) >> 16).to_float::<f32x16<S>>() * (1.0 / 256.0)
        }
    };
    limit_lanes(s, view, lod)
}

/// The scalar trilinear filter for sixteen lanes, scaled.
#[inline(always)]
pub fn trilinear_lanes<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    u: f32x16<S>,
    v: f32x16<S>,
    lod: f32x16<S>,
) -> Color<S> {
    let levels = Levels::new(s, view, lod);
    scaled(levels.sample::<FORMAT>(s, view, u, v), view)
}

/// The levels that each lane reads, found once and used by every probe.
pub(crate) struct Levels<S: Simd> {
    pub(crate) fine: At<S>,
    pub(crate) coarse: At<S>,
    pub(crate) weight: f32x16<S>,
    /// Some lane blends two levels.
    pub(crate) blends: bool,
}

impl<S: Simd> Levels<S> {
    #[inline(always)]
    pub(crate) fn new(s: S, view: &View<'_>, lod: f32x16<S>) -> Self {
        let (zero, zero_i) = (f32x16::splat(s, 0.0), i32x16::splat(s, 0));
        let magnified = lod.simd_le(zero);
        let top = f32x16::splat(s, view.last as f32);
        let lod = lod.simd_gt(top).select(top, lod);
        let lod = magnified.select(zero, lod);
        let fine = lod.to_int::<i32x16<S>>();
        let weight = lod - fine.to_float::<f32x16<S>>();
        let blends = weight.simd_gt(zero).any_true();
        let last = i32x16::splat(s, view.last);
        let level = fine[0];
        let (fine, coarse) = if fine.simd_eq(zero_i + level).all_true() {
            let next = if level < view.last { level + 1 } else { level };
            (At::uniform(s, view, level), At::uniform(s, view, next))
        } else {
            let next = fine + 1;
            let next = next.simd_gt(last).select(last, next);
            (At::per_lane(s, view, fine), At::per_lane(s, view, next))
        };
        Self {
            fine,
            coarse,
            weight,
            blends,
        }
    }

    #[inline(always)]
    fn sample<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        u: f32x16<S>,
        v: f32x16<S>,
    ) -> Color<S> {
        let c = bilinear_at::<S, FORMAT>(s, view, &self.fine, u, v);
        if !self.blends {
            return c;
        }
        let next = bilinear_at::<S, FORMAT>(s, view, &self.coarse, u, v);
        let two = self.weight.simd_gt(f32x16::splat(s, 0.0));
        select(two, mix(view, c, next, self.weight), c)
    }
}

#[inline(always)]
pub(crate) fn select<S: Simd>(mask: mask32x16<S>, a: Color<S>, b: Color<S>) -> Color<S> {
    [
        mask.select(a[0], b[0]),
        mask.select(a[1], b[1]),
        mask.select(a[2], b[2]),
        mask.select(a[3], b[3]),
    ]
}

/// Scalar `Axes` for sixteen lanes.
pub(crate) struct AxesLanes<S: Simd> {
    pub(crate) major: [f32x16<S>; 2],
    pub(crate) major2: f32x16<S>,
    pub(crate) minor2: f32x16<S>,
    trace: f32x16<S>,
}

impl<S: Simd> AxesLanes<S> {
    #[inline(always)]
    pub(crate) fn new(s: S, d: &FootprintLanes<S>) -> Self {
        let zero = f32x16::splat(s, 0.0);
        let p = d.ux * d.ux + d.uy * d.uy;
        let r = d.vx * d.vx + d.vy * d.vy;
        let q = d.ux * d.vx + d.uy * d.vy;
        let half = (p - r) * 0.5;
        let root = (half * half + q * q).sqrt();
        let trace = p + r;
        let major2 = trace * 0.5 + root;
        let det = d.ux * d.vy - d.uy * d.vx;
        let minor2 = major2.simd_gt(zero).select(det * (det / major2), zero);
        let steep = !half.simd_ge(zero);
        let x = steep.select(q, half + root);
        let y = steep.select(root - half, q);
        let length2 = x * x + y * y;
        let length = major2.sqrt();
        let along = length2.simd_gt(zero);
        let k = length / length2.sqrt();
        Self {
            major: [along.select(x * k, length), along.select(y * k, zero)],
            major2,
            minor2,
            trace,
        }
    }

    /// Scalar `Axes::spread`.
    #[inline(always)]
    fn spread(&self, s: S) -> f32x16<S> {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let share = (self.trace - one) / self.major2;
        let share = share.simd_gt(zero).select(share, zero);
        share.simd_lt(one).select(share, one).sqrt()
    }
}

/// The scalar anisotropic filter for sixteen lanes, scaled.
#[inline(always)]
pub fn anisotropic_lanes<S: Simd, const FORMAT: u8>(
    s: S,
    view: &View<'_>,
    u: f32x16<S>,
    v: f32x16<S>,
    d: &FootprintLanes<S>,
) -> Color<S> {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    let axes = AxesLanes::new(s, d);
    let spread = axes.spread(s);
    let AxesLanes {
        major: [major_x, major_y],
        major2,
        minor2,
        ..
    } = axes;
    let n = probes(s, view, major2, minor2);
    let lod = limit_lanes(s, view, log2(s, major2 / (n * n)) * 0.5);
    let lod = match view.precision {
        Precision::Exact => lod,
        // One rounded level a pixel.
        Precision::Fast => floor_to_i32(s, bounded(s, lod) + 0.5).to_float::<f32x16<S>>(),
    };
    let (w, h) = view.size();
    let step_u = major_x * spread / (n * (w as f32));
    let step_v = major_y * spread / (n * (h as f32));
    let start = (one - n) * 0.5;
    let levels = Levels::new(s, view, lod);
    let (mut first, mut sum) = ([zero; 4], [zero; 4]);
    let mut k = 0.0;
    loop {
        let active = n.simd_gt(f32x16::splat(s, k));
        if !active.any_true() {
            break;
        }
        let at = start + k;
        let c = levels.sample::<FORMAT>(s, view, u + step_u * at, v + step_v * at);
        if k == 0.0 {
            first = c;
            k = 1.0;
            continue;
        }
        let more = [
            sum[0] + (c[0] - first[0]),
            sum[1] + (c[1] - first[1]),
            sum[2] + (c[2] - first[2]),
            sum[3] + (c[3] - first[3]),
        ];
        sum = select(active, more, sum);
        k += 1.0;
    }
    scaled(
        [
            first[0] + sum[0] / n,
            first[1] + sum[1] / n,
            first[2] + sum[2] / n,
            first[3] + sum[3] / n,
        ],
        view,
    )
}

/// Levels within reach of an integer.
#[inline(always)]
fn bounded<S: Simd>(s: S, lod: f32x16<S>) -> f32x16<S> {
    let (low, high) = (f32x16::splat(s, -64.0), f32x16::splat(s, 64.0));
    let lod = lod.simd_gt(high).select(high, lod);
    lod.simd_gt(low).select(lod, low)
}

#[inline(always)]
fn probes<S: Simd>(s: S, view: &View<'_>, major2: f32x16<S>, minor2: f32x16<S>) -> f32x16<S> {
    let one = f32x16::splat(s, 1.0);
    let most = f32x16::splat(s, f32::from(view.most));
    let ratio = (major2 / minor2.simd_gt(one).select(minor2, one)).sqrt();
    let ratio = ratio.simd_lt(most).select(ratio, most);
    let n = (-floor_to_i32(s, -ratio)).to_float::<f32x16<S>>();
    n.simd_gt(one).select(n, one)
}
