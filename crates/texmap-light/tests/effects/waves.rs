//! A band-limited function of directions, and directions to ask it at.

use std::f64::consts::TAU;

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

/// Uniform numbers in [0, 1).
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.next() - 1.0;
        let (sin, cos) = deterministic_f64::sin_cos(self.next() * TAU);
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// `sqrt(2/64) sum cos(F k_i . d + p_i)`: 64 plane waves, unit RMS.
pub(crate) struct Waves(Vec<(DVec3, f64)>);

impl Waves {
    pub(crate) fn new(frequency: f64) -> Self {
        Self::draw(frequency, 0)
    }

    /// Another draw of the waves for each number.
    pub(crate) fn draw(frequency: f64, draw: u64) -> Self {
        let mut noise = Noise(7 + 1_000 * draw);
        Self(
            (0..64)
                .map(|_| (noise.direction() * frequency, noise.next() * TAU))
                .collect(),
        )
    }

    pub(crate) fn at(&self, d: DVec3) -> f64 {
        (2.0f64 / 64.0).sqrt()
            * self
                .0
                .iter()
                .map(|(k, p)| deterministic_f64::cos(k.dot(d) + p))
                .sum::<f64>()
    }
}
