//! Tone mapping in f64.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat3, DVec3};

use crate::ToneMap;

/// Display light, linear, of light times `exposure`; see [`ToneMap::apply`].
#[must_use]
pub fn tone_map(map: ToneMap, exposure: f64, light: DVec3) -> DVec3 {
    let c = (light * exposure).clamp(DVec3::ZERO, DVec3::splat(1e9));
    let out = match map {
        ToneMap::None | ToneMap::Unclipped => c,
        ToneMap::PbrNeutral => neutral(c),
        ToneMap::Aces => aces(c),
        ToneMap::Agx => agx(c),
    };
    out.clamp(DVec3::ZERO, DVec3::splat(f64::from(map.limit())))
}

fn neutral(c: DVec3) -> DVec3 {
    let x = c.min_element();
    let c = c - if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let p = c.max_element();
    if p < 0.76 {
        return c;
    }
    let n = 1.0 - 0.24 * 0.24 / (p + 0.24 - 0.76);
    let g = 1.0 / (0.15 * (p - n) + 1.0);
    (c * (n / p)).lerp(DVec3::splat(n), 1.0 - g)
}

fn aces(c: DVec3) -> DVec3 {
    let input = DMat3::from_cols_array(&[
        0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777,
    ]);
    let output = DMat3::from_cols_array(&[
        1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602,
    ]);
    let v = input * c / 0.6;
    let a = v * (v + 0.024_578_6) - 0.000_090_537;
    let b = v * (0.983_729 * v + 0.432_951) + 0.238_081;
    output * (a / b)
}

fn agx(c: DVec3) -> DVec3 {
    let inset = DMat3::from_cols_array(&[
        0.842_479_062_253_094,
        0.042_328_242_261_012_3,
        0.042_375_654_905_705_1,
        0.078_433_599_999_999_2,
        0.878_468_636_469_772,
        0.078_433_6,
        0.079_223_745_147_764_3,
        0.079_166_127_460_543_4,
        0.879_142_973_793_104,
    ]);
    let outset = DMat3::from_cols_array(&[
        1.196_879_005_120_17,
        -0.052_896_851_757_456_2,
        -0.052_971_635_514_443_8,
        -0.098_020_881_140_136_8,
        1.151_903_129_904_17,
        -0.098_043_450_117_124_1,
        -0.099_029_744_079_720_5,
        -0.098_961_176_844_843_3,
        1.151_073_672_641_16,
    ]);
    let (low, high) = (-12.47393, 4.026069);
    let contrast = |c: f64| {
        let power = deterministic_f64::log2(c.max(1e-10));
        let x = ((power - low) / (high - low)).clamp(0.0, 1.0);
        let (x2, x4) = (x * x, x * x * x * x);
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x
            - 0.00232
    };
    let shown = outset * DVec3::from((inset * c).to_array().map(contrast));
    DVec3::from(
        shown
            .to_array()
            .map(|c| deterministic_f64::pow(c.max(0.0), 2.2)),
    )
}
