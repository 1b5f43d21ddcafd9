//! Tone mapping: light without an upper end brought to 0 to 1, or kept for pictures of floats.

use core::fmt;
use core::str::FromStr;

use texmap_math::deterministic_f32;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::lanes::Vector;

/// A curve from light without an upper end to display light, before its encoding as sRGB. Display light ends at 1, but for
/// [`Unclipped`](Self::Unclipped).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ToneMap {
    /// Clipped at 1.
    #[default]
    None,
    /// Light as it is, for pictures of floats. Whole numbers clip it after samples are averaged and surfaces blended, so that edges of
    /// bright surfaces are not smooth in them.
    Unclipped,
    /// Khronos PBR Neutral (2024): colours whose channels stay below 0.76 are kept but for a small offset, brighter ones are
    /// compressed and fade to white.
    PbrNeutral,
    /// The fit of ACES by Stephen Hill, as three.js has it (exposure divided by 0.6).
    Aces,
    /// AgX (Troy Sobotka) with the polynomial contrast of Benjamin Wrensch, base look.
    Agx,
}

/// A name that is not a tone mapping's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownToneMap;

impl fmt::Display for UnknownToneMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown tone mapping: choose from")?;
        ToneMap::ALL
            .iter()
            .try_for_each(|map| write!(f, " {}", map.name()))
    }
}

impl core::error::Error for UnknownToneMap {}

impl FromStr for ToneMap {
    type Err = UnknownToneMap;

    fn from_str(name: &str) -> Result<Self, UnknownToneMap> {
        let mut all = Self::ALL.into_iter();
        all.find(|map| map.name() == name).ok_or(UnknownToneMap)
    }
}

/// Rows of linear sRGB to the space of ACES's fit, white balance included.
const ACES_IN: [[f32; 3]; 3] = [
    [0.597_19, 0.354_58, 0.048_23],
    [0.076_00, 0.908_34, 0.015_66],
    [0.028_40, 0.133_83, 0.837_77],
];
const ACES_OUT: [[f32; 3]; 3] = [
    [1.604_75, -0.531_08, -0.073_67],
    [-0.102_08, 1.108_13, -0.006_05],
    [-0.003_27, -0.072_76, 1.076_02],
];
/// Rows of linear sRGB to AgX's inset primaries, and back.
const AGX_IN: [[f32; 3]; 3] = [
    [0.842_479_06, 0.078_433_59, 0.079_223_745],
    [0.042_328_24, 0.878_468_6, 0.079_166_13],
    [0.042_375_654, 0.078_433_6, 0.879_143],
];
const AGX_OUT: [[f32; 3]; 3] = [
    [1.196_879, -0.098_020_88, -0.099_029_74],
    [-0.052_896_85, 1.151_903_2, -0.098_961_18],
    [-0.052_971_635, -0.098_043_45, 1.151_073_7],
];
/// Base-2 logarithms of the least and the largest light that AgX shows.
const AGX_RANGE: (f32, f32) = (-12.473_93, 4.026_069);
/// Coefficients of AgX's contrast polynomial, from the sixth power down.
const AGX_CONTRAST: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];

impl ToneMap {
    /// Every tone mapping.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Unclipped,
        Self::PbrNeutral,
        Self::Aces,
        Self::Agx,
    ];

    /// The name in files and flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Unclipped => "unclipped",
            Self::PbrNeutral => "pbr-neutral",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// The upper end of display light: 1, and 1e9 where it is not clipped.
    #[must_use]
    pub const fn limit(self) -> f32 {
        match self {
            Self::Unclipped => 1e9,
            _ => 1.0,
        }
    }

    /// Display light, linear, of light times `exposure`: 0 to [`limit`](Self::limit). Negative light and NaN give 0.
    #[must_use]
    pub fn apply(self, exposure: f32, light: [f32; 3]) -> [f32; 3] {
        self.apply_lanes(Scalar, exposure, light)
    }

    /// [`apply`](Self::apply) in lanes; outside of semantic versioning.
    #[inline(always)]
    pub fn apply_lanes<I: Isa>(self, i: I, exposure: f32, light: Vector<I>) -> Vector<I> {
        let (zero, limit) = (i.f32(0.0), i.f32(self.limit()));
        // Products stay finite.
        let most = i.f32(1e9);
        let mut c = light;
        for c in &mut c {
            *c = (*c * exposure).clamp(zero, most);
        }
        let mut out = match self {
            Self::None | Self::Unclipped => c,
            Self::PbrNeutral => neutral(i, c),
            Self::Aces => aces(i, c),
            Self::Agx => agx(i, c),
        };
        for out in &mut out {
            *out = out.clamp(zero, limit);
        }
        out
    }
}

#[inline(always)]
fn neutral<I: Isa>(i: I, c: Vector<I>) -> Vector<I> {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    const REST: f32 = 1.0 - START;
    let one = i.f32(1.0);
    let least = c[0].below(c[1]).below(c[2]);
    let toe = least - least * least * 6.25;
    let offset = least.simd_lt(0.08).select(toe, i.f32(0.04));
    let c = [c[0] - offset, c[1] - offset, c[2] - offset];
    let peak = c[0].above(c[1]).above(c[2]);
    let bright = peak.simd_ge(START);
    if !bright.any_true() {
        return c;
    }
    let end = one - i.f32(REST * REST) / (peak + (REST - START));
    let white = one - one / ((peak - end) * DESATURATION + 1.0);
    let scale = end / peak;
    let mut out = c;
    for (out, c) in out.iter_mut().zip(c) {
        let c = c * scale;
        *out = bright.select(c + (end - c) * white, *out);
    }
    out
}

#[inline(always)]
fn aces<I: Isa>(i: I, c: Vector<I>) -> Vector<I> {
    let mut c = rows(i, &ACES_IN, c, 1.0 / 0.6);
    for c in &mut c {
        let x = *c;
        *c =
            (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (x * 0.983_729 + 0.432_951) + 0.238_081);
    }
    rows(i, &ACES_OUT, c, 1.0)
}

#[inline(always)]
fn agx<I: Isa>(i: I, c: Vector<I>) -> Vector<I> {
    let (low, high) = AGX_RANGE;
    let mut c = rows(i, &AGX_IN, c, 1.0);
    for c in &mut c {
        let power = deterministic_f32::log2_lanes(i, c.above(i.f32(1e-10)));
        let x = ((power - low) * (1.0 / (high - low))).clamp(i.f32(0.0), i.f32(1.0));
        let mut y = i.f32(0.0);
        for k in AGX_CONTRAST {
            y = y * x + k;
        }
        *c = y;
    }
    let mut out = rows(i, &AGX_OUT, c, 1.0);
    for out in &mut out {
        // The contrast is of display values.
        *out = deterministic_f32::pow_lanes(i, out.above(i.f32(0.0)), i.f32(2.2));
    }
    out
}

#[inline(always)]
fn rows<I: Isa>(_: I, rows: &[[f32; 3]; 3], c: Vector<I>, scale: f32) -> Vector<I> {
    let mut out = c;
    for (out, [x, y, z]) in out.iter_mut().zip(rows) {
        *out = (c[0] * *x + c[1] * *y + c[2] * *z) * scale;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;
    use crate::vector::{columns, load};
    use texmap_math::glam::DVec3;

    fn colors() -> [[f32; 3]; 64] {
        core::array::from_fn(|k| {
            let x = |p: usize| ((k * p) % 17) as f32 / 11.0;
            let scale = [0.05, 0.5, 1.0, 30.0][k % 4];
            [x(3) * scale, x(5) * scale, x(7) * scale]
        })
    }

    /// Values of the specification's own text: the offset of 4 % and the knee.
    #[test]
    fn neutral_keeps_colours_below_its_knee() {
        let map = |c| ToneMap::PbrNeutral.apply(1.0, c);
        for (c, expected) in [
            ([0.5, 0.3, 0.2], [0.46, 0.26, 0.16]),
            // Below 0.08 the offset is x - 6.25 x^2.
            ([0.5, 0.3, 0.04], [0.47, 0.27, 0.01]),
            ([0.79, 0.1, 0.1], [0.75, 0.06, 0.06]),
            ([0.0; 3], [0.0; 3]),
        ] {
            for (got, expected) in map(c).into_iter().zip(expected) {
                assert!((got - expected).abs() < 1e-6, "{c:?}: {got} {expected}");
            }
        }
        // A grey of 1: its peak of 0.96 becomes 1 - 0.24^2 / (0.96 + 0.24 - 0.76).
        let grey = 1.0 - 0.0576 / 0.44;
        assert!((map([1.0; 3])[0] - grey).abs() < 1e-6);
        assert!(
            map([1e6, 0.0, 0.0])[1] > 0.99,
            "bright colours fade to white"
        );
    }

    /// 18 % grey and white, by the polynomials in a desk calculator.
    #[test]
    fn curves_pass_their_anchors() {
        let near = |map: ToneMap, c: f32, expected: f32| {
            let got = map.apply(1.0, [c; 3]);
            for got in got {
                assert!(
                    (got - expected).abs() < 2e-3,
                    "{map:?} {c}: {got} {expected}"
                );
            }
        };
        near(ToneMap::None, 0.18, 0.18);
        near(ToneMap::None, 3.0, 1.0);
        near(ToneMap::Unclipped, 0.18, 0.18);
        near(ToneMap::Unclipped, 3.0, 3.0);
        // x = 0.18 / 0.6 = 0.3: 0.097283 / 0.456502.
        near(ToneMap::Aces, 0.18, 0.2131);
        // x = 1 / 0.6: 2.818651 / 3.692250.
        near(ToneMap::Aces, 1.0, 0.7634);
    }

    #[test]
    fn exposure_multiplies_and_broken_light_is_black() {
        for map in ToneMap::ALL {
            assert_eq!(
                map.apply(2.0, [0.1, 0.2, 0.3]),
                map.apply(1.0, [0.2, 0.4, 0.6])
            );
            for broken in [f32::NAN, -1.0] {
                let got = map.apply(1.0, [broken; 3]);
                assert!(
                    got.iter().all(|c| (0.0..1e-2).contains(c)),
                    "{map:?} {got:?}"
                );
            }
            let got = map.apply(1.0, [f32::INFINITY; 3]);
            assert!(got.iter().all(|c| *c > 0.98), "{map:?} {got:?}");
            assert_eq!(map.name().parse(), Ok(map));
        }
        assert!("filmic".parse::<ToneMap>().is_err());
    }

    #[test]
    fn lanes_have_the_bits_of_one_colour_and_the_values_of_the_reference() {
        let colors = colors();
        for map in ToneMap::ALL {
            for c in colors {
                let right = reference::tone_map(map, 0.7, DVec3::from(c.map(f64::from)));
                let got = DVec3::from(map.apply(0.7, c).map(f64::from));
                assert!(
                    (got - right).abs().max_element() < 1e-5,
                    "{map:?} {c:?}: {got} {right}"
                );
            }
            every_width!(i => check(i, map, &colors));
        }
        fn check<I: Isa>(i: I, map: ToneMap, colors: &[[f32; 3]]) {
            for first in (0..colors.len()).step_by(I::LANES) {
                let got = columns(i, map.apply_lanes(i, 0.7, load(i, colors, first)));
                for lane in 0..I::LANES {
                    let one = map.apply(0.7, colors[first + lane]);
                    assert_eq!(got.map(|c| c[lane].to_bits()), one.map(f32::to_bits));
                }
            }
        }
    }

    /// Grey stays grey and rises.
    #[test]
    fn greys_rise() {
        for map in ToneMap::ALL {
            let mut before = -1.0;
            for k in 0..200 {
                let x = 0.02 * k as f32;
                let [r, g, b] = map.apply(1.0, [x; 3]);
                assert!((r - g).abs() < 2e-3 && (g - b).abs() < 2e-3, "{map:?} {x}");
                assert!(g >= before - 1e-4, "{map:?} {x}: {g} after {before}");
                before = g;
            }
        }
    }
}
