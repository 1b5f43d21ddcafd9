//! Visibility of an environment: the fraction of its light that reaches each lobe of a surface past everything in its way.

use core::f32::consts::PI;

use texmap_math::simd::{Isa, prelude::*};

use super::ReflectanceLanes;
use crate::EnvironmentSample;
use crate::lanes::Vector;
use crate::vector::{dot, scale, splat};

/// Fractions of the light of an environment that reach the diffuse base, the GGX lobe and the clear layer of a surface, as sums over
/// [samples](crate::EnvironmentLight::samples).
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentVisibilityLanes<I: Isa> {
    reached: Vector<I>,
    all: Vector<I>,
}

impl<I: Isa> EnvironmentVisibilityLanes<I> {
    /// Without any samples, which is in full light.
    #[inline(always)]
    pub fn new(i: I) -> Self {
        Self {
            reached: splat(i, [0.0; 3]),
            all: splat(i, [0.0; 3]),
        }
    }

    /// Adds a sample by its [weights](ReflectanceLanes::sample_weights) and the fraction of its light that arrives.
    #[inline(always)]
    pub fn add(&mut self, weights: Vector<I>, visibility: I::F32) {
        for (k, weight) in weights.into_iter().enumerate() {
            self.reached[k] = self.reached[k] + weight * visibility;
            self.all[k] = self.all[k] + weight;
        }
    }

    /// The fractions, 1 for a lobe without any weight.
    #[inline(always)]
    pub fn fractions(&self, i: I) -> Vector<I> {
        let one = i.f32(1.0);
        let mut out = self.all;
        for (out, reached) in out.iter_mut().zip(self.reached) {
            let some = out.simd_gt(f32::MIN_POSITIVE) & out.simd_lt(f32::INFINITY);
            *out = some.select((reached / *out).below(one), one);
        }
        out
    }
}

/// Light as the lobes of a surface gather it.
pub(super) struct GatheredLanes<I: Isa> {
    /// Of the diffuse base.
    pub(super) diffuse: Vector<I>,
    /// Of an even hemisphere: irradiance over pi. Light that scatters between facets, and cloth.
    pub(super) irradiance: Vector<I>,
    /// Of the GGX lobe.
    pub(super) glossy: Vector<I>,
    /// Of the clear layer.
    pub(super) coating: Vector<I>,
}

impl<I: Isa> GatheredLanes<I> {
    /// Leaves the fractions of light that reach the diffuse base, the GGX lobe and the clear layer.
    #[inline(always)]
    pub(super) fn shadow(&mut self, [of_base, of_lobe, of_coat]: Vector<I>) {
        self.diffuse = scale(self.diffuse, of_base);
        self.irradiance = scale(self.irradiance, of_base);
        self.glossy = scale(self.glossy, of_lobe);
        self.coating = scale(self.coating, of_coat);
    }
}

impl<I: Isa> ReflectanceLanes<I> {
    /// Weights of a sample in the light of the diffuse base, the GGX lobe and the clear layer: its light times cosine and lobe, which is
    /// wider by the part of the sphere that the sample stands for. 0 behind the surface.
    #[inline(always)]
    pub fn sample_weights(&self, i: I, sample: &EnvironmentSample) -> Vector<I> {
        let toward = splat(i, sample.direction);
        let light = sample.luminance * sample.solid_angle;
        let across = (dot(self.view, toward) * 2.0 + 2.0).above(i.f32(1e-6));
        let nl = dot(self.normal, toward).above(i.f32(0.0));
        // Half vectors fill a quarter of the solid angle.
        let wider = sample.solid_angle / (4.0 * PI);
        let squared = self.alpha * self.alpha + wider;
        let glossy = lobe(i, self.nv, nl, across, squared);
        let coating = match &self.coat {
            Some(coat) => {
                let nl = dot(self.smooth, toward).above(i.f32(0.0));
                lobe(i, coat.nv, nl, across, coat.alpha * coat.alpha + wider)
            }
            None => i.f32(0.0),
        };
        [nl * light, glossy * light, coating * light]
    }
}

/// The GGX distribution times the cosine to the light and pi. `across` is the squared length of the sum of the directions to eye and
/// light, `squared` the squared width of the lobe.
#[inline(always)]
fn lobe<I: Isa>(i: I, nv: I::F32, nl: I::F32, across: I::F32, squared: I::F32) -> I::F32 {
    let cosine = nv + nl;
    let cosine = cosine * cosine;
    let ratio = across / ((across - cosine).above(i.f32(0.0)) + cosine * squared);
    nl * (squared * ratio * ratio)
}

#[cfg(test)]
mod tests {
    use texmap_math::glam::DVec3;
    use texmap_math::simd::Scalar;

    use super::*;
    use crate::lanes::{ClearcoatLanes, MetallicRoughnessLanes};
    use crate::reference::metallic_roughness::Reflectance;
    use crate::vector::{columns, load};

    fn surface<I: Isa>(i: I, roughness: f32) -> MetallicRoughnessLanes<I> {
        MetallicRoughnessLanes {
            clearcoat: Some(ClearcoatLanes {
                factor: i.f32(1.0),
                roughness: i.f32(0.1),
            }),
            ..MetallicRoughnessLanes::new(i, splat(i, [0.5; 3]), i.f32(0.0), i.f32(roughness))
        }
    }

    fn direction(k: u32) -> [f32; 3] {
        let [a, b] = [12.9898, 78.233].map(|step: f64| (f64::from(k) * step).sin());
        let c = (f64::from(k) * 37.719).sin();
        DVec3::new(a, b, c).normalize().as_vec3().to_array()
    }

    fn samples() -> impl Iterator<Item = EnvironmentSample> {
        (0..200).map(|k| EnvironmentSample {
            direction: direction(3 * k + 1),
            luminance: 0.2 + (k % 7) as f32,
            solid_angle: [0.2, 0.01, 1e-4][k as usize % 3],
        })
    }

    /// Weights are those of the reference, seen head on, aslant and at grazing incidence, of rough surfaces and mirrors.
    #[test]
    fn weights_agree_with_the_reference() {
        let normal = [0.0, 0.0, 1.0];
        let smooth = [0.0, 0.6, 0.8];
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let mut lobes = 0;
        for roughness in [0.05, 0.3, 0.6, 1.0] {
            let surface = surface(Scalar, roughness);
            let reference = Reflectance::new(&surface);
            for view in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.995, 0.0, 0.0999]] {
                let ready = ReflectanceLanes::new(Scalar, &surface, normal, smooth, view);
                let cosines = (wide(normal).dot(wide(view)), wide(smooth).dot(wide(view)));
                for sample in samples() {
                    let got = ready.sample_weights(Scalar, &sample);
                    let directions = (wide(normal), wide(smooth), wide(view));
                    let expected = reference.sample_weights(directions, cosines, &sample);
                    let light = f64::from(sample.luminance * sample.solid_angle);
                    for (got, expected) in got.into_iter().zip(expected) {
                        let error = (f64::from(got) - expected).abs();
                        assert!(error <= 2e-3 * expected + 1e-5 * light, "{got} {expected}");
                    }
                    lobes += u32::from(expected[1] > expected[0]);
                }
            }
        }
        assert!(lobes > 100, "{lobes}");
    }

    /// Fractions of light are weighted means, and 1 where nothing has a weight.
    #[test]
    fn fractions_are_weighted_means() {
        let mut sum = EnvironmentVisibilityLanes::new(Scalar);
        assert_eq!(sum.fractions(Scalar), [1.0; 3]);
        sum.add([1.0, 0.0, 2.0], 1.0);
        sum.add([3.0, 0.0, 2.0], 0.0);
        assert_eq!(sum.fractions(Scalar), [0.25, 1.0, 0.5]);
        sum.add([f32::INFINITY, f32::NAN, 0.0], 0.5);
        assert_eq!(sum.fractions(Scalar), [1.0, 1.0, 0.5]);
    }

    /// Every width has the bits of one lane.
    #[test]
    fn widths_agree() {
        fn weights<I: Isa>(i: I, views: &[[f32; 3]; 16], first: usize) -> [[f32; 16]; 3] {
            let surface = surface(i, 0.3);
            let (normal, smooth) = (splat(i, [0.0, 0.0, 1.0]), splat(i, [0.0, 0.6, 0.8]));
            let ready = ReflectanceLanes::new(i, &surface, normal, smooth, load(i, views, first));
            let mut sum = EnvironmentVisibilityLanes::new(i);
            for (k, sample) in samples().enumerate() {
                sum.add(ready.sample_weights(i, &sample), i.f32((k % 2) as f32));
            }
            columns(i, sum.fractions(i))
        }
        fn check<I: Isa>(i: I, views: &[[f32; 3]; 16], one: &[[f32; 3]; 16]) {
            for first in (0..16).step_by(I::LANES) {
                let got = weights(i, views, first);
                for (lane, at) in (first..first + I::LANES).enumerate() {
                    assert_eq!(
                        got.map(|column| column[lane].to_bits()),
                        one[at].map(f32::to_bits)
                    );
                }
            }
        }
        let views: [_; 16] = core::array::from_fn(|k| direction(k as u32));
        let one: [_; 16] =
            core::array::from_fn(|k| weights(Scalar, &views, k).map(|column| column[0]));
        assert!(
            one.iter().any(|f| f[1] > 0.6) && one.iter().any(|f| f[1] < 0.4),
            "{one:?}"
        );
        every_width!(i => check(i, &views, &one));
    }
}
