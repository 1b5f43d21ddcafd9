//! Directional albedos of the microfacet lobes, by their roughness and the cosine to the eye. The split-sum tables are off by at
//! most 0.005, those of sheen by 0.012; `examples/albedo_table.rs` writes them.

mod table;

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::roughness_table::{TablePosition, mix, split};

/// Steps of roughness, and of the cosine's square root.
pub(crate) const SIDE: usize = 64;
/// Steps of a stored value.
const UNIT: f32 = 1.0 / 65535.0;

/// The GGX lobe under Schlick's Fresnel, as factors of the reflectances head on and at grazing incidence; both arguments within
/// 0 to 1.
#[inline(always)]
pub(crate) fn ggx<I: Isa>(i: I, roughness: I::F32, cosine: I::F32) -> [I::F32; 2] {
    let Some(words) = GatherTable::new(&table::GGX) else {
        return [i.f32(0.0); 2];
    };
    let position = TablePosition::new(i, roughness, cosine, [SIDE; 2]);
    let [a, b, c, d] = position.read(i, words);
    [
        position.mean([low::<I>(a), low::<I>(b), low::<I>(c), low::<I>(d)]) * UNIT,
        position.mean([high::<I>(a), high::<I>(b), high::<I>(c), high::<I>(d)]) * UNIT,
    ]
}

/// The table of the split sum: a GGX lobe returns of even light the reflectance head on times the first factor plus that at grazing
/// incidence times the second (Karis 2013, A and B). By perceptual roughness and the cosine to the eye, both cut to 0 to 1, NaN to 0;
/// off by 0.005 at most.
#[must_use]
pub fn split_sum(roughness: f32, cosine: f32) -> [f32; 2] {
    let unit = |x: f32| F32s::<Scalar>::clamp(if x.is_nan() { 0.0 } else { x }, 0.0, 1.0);
    ggx(Scalar, unit(roughness), unit(cosine))
}

/// The cosine-weighted mean of [`ggx`] over a hemisphere.
#[inline(always)]
pub(crate) fn ggx_average<I: Isa>(i: I, roughness: I::F32) -> [I::F32; 2] {
    pair(i, &table::GGX_AVERAGE, roughness)
}

/// The two values of a row of one column.
#[inline(always)]
fn pair<I: Isa>(i: I, words: &'static [u32; SIDE], roughness: I::F32) -> [I::F32; 2] {
    let Some(words) = GatherTable::new(words) else {
        return [i.f32(0.0); 2];
    };
    let (at, k) = split(i, roughness, SIDE);
    let [p, q] = i.gather_pairs(words, at.to_u32());
    [
        mix::<I>(low::<I>(p), low::<I>(q), k) * UNIT,
        mix::<I>(high::<I>(p), high::<I>(q), k) * UNIT,
    ]
}

/// Slopes of [`ggx`] by `(1 - c)^5`, times the mean of that, 1/21: as much as the factors weigh light at grazing incidence more than other light.
#[inline(always)]
pub(crate) fn ggx_grazing<I: Isa>(i: I, roughness: I::F32) -> [I::F32; 2] {
    let [fall, rise] = pair(i, &table::GGX_GRAZING, roughness);
    [(i.f32(0.5) - fall) * (2.0 / 21.0), rise * (1.0 / 21.0)]
}

/// White sheen; both arguments within 0 to 1.
#[inline(always)]
pub(crate) fn sheen<I: Isa>(i: I, roughness: I::F32, cosine: I::F32) -> I::F32 {
    let Some(words) = GatherTable::new(&table::SHEEN) else {
        return i.f32(0.0);
    };
    let position = TablePosition::new(i, roughness, cosine, [SIDE; 2]);
    let [a, b, c, d] = position.read(i, words);
    position.mean([low::<I>(a), low::<I>(b), low::<I>(c), low::<I>(d)]) * UNIT
}

#[inline(always)]
fn low<I: Isa>(word: I::U32) -> I::F32 {
    (word & 0xffff).to_i32().to_f32()
}

#[inline(always)]
fn high<I: Isa>(word: I::U32) -> I::F32 {
    (word >> 16).to_i32().to_f32()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::metallic_roughness::{
        ggx as distribution, ggx_albedo, sheen_albedo, smith,
    };
    use crate::vector::columns;
    use texmap_math::glam::DVec3;

    /// Integrals over `n x n` directions of light, which lie close to the horizon and to the mirrored eye.
    fn over_light(alpha: f64, nv: f64, n: u32) -> [f64; 2] {
        let view = DVec3::new((1.0 - nv * nv).sqrt(), 0.0, nv);
        let mut sum = [0.0; 2];
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [t, w] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            let (nl, angle) = (t * t, core::f64::consts::PI * w * w * w);
            let s = (1.0 - nl * nl).sqrt();
            let light = DVec3::new(-s * angle.cos(), s * angle.sin(), nl);
            let half = (view + light).normalize();
            // 2 t dt for nl, 3 pi w^2 dw for the angle, and the other half.
            let share = 12.0 * core::f64::consts::PI * t * w * w / f64::from(n * n);
            let value = distribution(alpha, half.z) * smith(alpha, nv, nl) * nl * share;
            let fresnel = (1.0 - view.dot(half)).powi(5);
            sum = [sum[0] + value * (1.0 - fresnel), sum[1] + value * fresnel];
        }
        sum
    }

    /// By another sum, at grazing incidence too.
    #[test]
    fn albedos_are_integrals_over_directions_of_light() {
        for (r, c) in [
            (0.4, 0.02),
            (0.3, 0.2),
            (0.5, 0.02),
            (0.8, 0.05),
            (1.0, 0.6),
        ] {
            let expected = over_light(r * r, c, 800);
            let got = ggx_albedo(r * r, c, 256);
            for (got, expected) in got.into_iter().zip(expected) {
                assert!((got - expected).abs() < 5e-3, "{r} {c}: {got} {expected}");
            }
        }
    }

    /// Between the steps too; below the first step of the cosine the albedo bends most.
    #[test]
    fn tables_hold_the_integrals() {
        let mut worst = [0.0f64; 2];
        for r in [0.2f32, 0.28, 0.31, 0.5, 0.64, 0.83, 1.0] {
            for c in [0.005f32, 0.01, 0.03, 0.09, 0.2, 0.37, 0.55, 0.8, 1.0] {
                let alpha = f64::from(r) * f64::from(r);
                let [a, b] = ggx_albedo(alpha, c.into(), 256);
                let got = ggx(Scalar, r, c);
                let off = (f64::from(got[0]) - a)
                    .abs()
                    .max((f64::from(got[1]) - b).abs());
                worst[0] = worst[0].max(off);
                let cloth = sheen_albedo(alpha, c.into(), 128);
                worst[1] = worst[1].max((f64::from(sheen(Scalar, r, c)) - cloth).abs());
            }
        }
        for (r, c) in [(0.05f32, 0.3f32), (0.1, 0.01), (0.1, 0.2), (0.15, 0.03)] {
            let [a, b] = ggx_albedo(f64::from(r) * f64::from(r), c.into(), 512);
            let [p, q] = ggx(Scalar, r, c).map(f64::from);
            worst[0] = worst[0].max((p - a).abs()).max((q - b).abs());
        }
        assert!(worst[0] < 5e-3 && worst[1] < 0.012, "{worst:?}");
    }

    #[test]
    fn averages_are_those_of_the_albedos() {
        for r in [0.0f32, 0.25, 0.6, 1.0] {
            let mut sum = [0.0; 2];
            for k in 0..4096 {
                let c = (k as f32 + 0.5) / 4096.0;
                let value = ggx(Scalar, r, c);
                sum = [0, 1].map(|j| sum[j] + value[j] * 2.0 * c / 4096.0);
            }
            let average = ggx_average(Scalar, r);
            assert!(
                (0..2).all(|j| (sum[j] - average[j]).abs() < 1.5e-3),
                "{sum:?} {average:?}"
            );
        }
    }

    /// Normal equations: what the slope leaves of a factor has nothing of `(1 - c)^5`.
    #[test]
    fn slopes_are_those_of_the_albedos() {
        for r in [0.03f32, 0.25, 0.6, 1.0] {
            let slopes = ggx_grazing(Scalar, r).map(|s| s * 21.0);
            for (j, slope) in slopes.into_iter().enumerate() {
                let left = |slope: f32| {
                    let mut sum = 0.0;
                    for k in 0..4096 {
                        let c = (k as f32 + 0.5) / 4096.0;
                        let power = (1.0 - c).powi(5) - 1.0 / 21.0;
                        sum += (ggx(Scalar, r, c)[j] - slope * power) * power * 2.0 * c / 4096.0;
                    }
                    // Over the variance of that power.
                    (sum / (1.0 / 66.0 - 1.0 / 441.0)).abs()
                };
                assert!(left(slope) < 0.01, "{r} {j}: {slope} {}", left(slope));
                assert!(left(slope + 0.05) > 0.03);
            }
        }
    }

    #[test]
    fn widths_agree() {
        every_width!(i => check(i));
        fn check<I: Isa>(i: I) {
            let r: [f32; 16] = core::array::from_fn(|k| k as f32 / 15.0);
            let c: [f32; 16] = core::array::from_fn(|k| (k * 7 % 16) as f32 / 15.0);
            for at in (0..16).step_by(I::LANES) {
                let (rs, cs) = (i.load_f32(&r[at..]), i.load_f32(&c[at..]));
                let ([a, b], [d, e]) = (ggx(i, rs, cs), ggx_average(i, rs));
                let [f, g] = ggx_grazing(i, rs);
                let got = columns(i, [a, b, d, e, f, g, sheen(i, rs, cs)]);
                for lane in 0..I::LANES {
                    let (r, c) = (r[at + lane], c[at + lane]);
                    let ([a, b], [d, e]) = (ggx(Scalar, r, c), ggx_average(Scalar, r));
                    let [f, g] = ggx_grazing(Scalar, r);
                    let one = [a, b, d, e, f, g, sheen(Scalar, r, c)];
                    assert_eq!(got.map(|g| g[lane].to_bits()), one.map(f32::to_bits));
                }
            }
        }
    }
}
