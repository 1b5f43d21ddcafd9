//! Visibility of an environment in f64: the weights of its samples in the lobes of a surface.

use core::f64::consts::{FRAC_1_PI, PI};

use texmap_math::float::sqrt;
use texmap_math::glam::DVec3;

use super::{Reflectance, ggx, wide, width};
use crate::EnvironmentSample;

impl Reflectance {
    /// Weights of a sample of an environment in the light of the diffuse base, the GGX lobe and the clear layer:
    /// [`ReflectanceLanes::sample_weights`](crate::lanes::ReflectanceLanes::sample_weights). The cosines are those of
    /// [`under_gathered`](Self::under_gathered).
    #[must_use]
    pub fn sample_weights(
        &self,
        (normal, smooth, view): (DVec3, DVec3, DVec3),
        (nv, cv): (f64, f64),
        sample: &EnvironmentSample,
    ) -> [f64; 3] {
        let toward = wide(sample.direction);
        let angle = f64::from(sample.solid_angle);
        let light = f64::from(sample.luminance) * angle;
        let length = (view + toward).length();
        let lobe = |normal: DVec3, cosine: f64, roughness: f32| {
            let nl = normal.dot(toward).max(0.0);
            let alpha = width(roughness);
            // A disk of a quarter of the solid angle, that of its half vectors, widens the lobe by its radius.
            let wider = sqrt(alpha * alpha + 0.25 * angle * FRAC_1_PI);
            let nh = ((cosine + nl) / length.max(1e-3)).min(1.0);
            ggx(wider, nh) * PI * nl * light
        };
        let coat = self.surface.clearcoat;
        [
            normal.dot(toward).max(0.0) * light,
            lobe(normal, nv, self.surface.roughness),
            coat.map_or(0.0, |coat| lobe(smooth, cv, coat.roughness)),
        ]
    }
}
