//! Directions that stand for the light of an environment: importance sampling.

use alloc::vec::Vec;

use texmap_math::color::luminance_f64;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::hilbert;

use super::EnvironmentLight;
use crate::EnvironmentLayout;

/// Blocks a side of a face of the cube. A Hilbert curve goes through them, so that neighbours on it are neighbours on the sphere.
const BLOCKS: u32 = 16;

/// Least cosine between a sample and the plane of a triangle at which its shadow map is asked. Light from behind a triangle reaches its
/// smooth normals alone, as much of it as without shadows; and depths of planes almost along the light are no measure.
pub const LEAST_SAMPLE_COSINE: f32 = 0.05;

/// One direction, and the light of the part of the sphere around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSample {
    /// Unit vector towards the light.
    pub direction: [f32; 3],
    /// Mean luminance of the part (Rec. 709).
    pub luminance: f32,
    /// Solid angle of the part, steradians. Those of all samples add up to 4 pi.
    pub solid_angle: f32,
}

impl EnvironmentLight {
    /// Parts of the sphere of equal weight, each with a direction inside. Half of the weight is the luminance of the environment, the other half
    /// solid angle: bright lights have many directions, and no part is far from one. The same light gives the same samples; none for a
    /// `count` of 0.
    #[must_use]
    pub fn samples(&self, count: u32) -> Vec<EnvironmentSample> {
        let texels = self.texels_in_order();
        let all: DVec2 = texels.iter().map(|texel| texel.light_and_angle()).sum();
        let weight = |texel: &Texel| {
            let [light, angle] = texel.light_and_angle().to_array();
            let even = angle / all.y;
            match all.x > 0.0 {
                true => 0.5 * (light / all.x + even),
                false => even,
            }
        };
        // Directions lie anywhere inside of their parts: middles of all would be a grid, whose shadows fall together.
        const GOLDEN: f64 = 0.618_033_988_749_894_8;
        let mut samples = Vec::new();
        let (mut before, mut sum, mut direction) = (0.0, DVec2::ZERO, DVec3::Z);
        for texel in &texels {
            let own = weight(texel);
            let mut first = before;
            before += own;
            // A texel may hold the ends of several parts.
            loop {
                let number = samples.len() as f64;
                let inside = 0.5 + number * GOLDEN;
                let inside = inside - f64::from(inside as u32);
                let chosen = (number + inside) / f64::from(count);
                if (first..before).contains(&chosen) {
                    direction = texel.direction;
                }
                let end = (number + 1.0) / f64::from(count);
                if before < end || samples.len() + 1 >= count as usize {
                    break;
                }
                sum += texel.light_and_angle() * ((end - first) / own);
                samples.push(self.sample(direction, sum));
                (first, sum) = (end, DVec2::ZERO);
            }
            sum += texel.light_and_angle() * ((before - first) / own);
        }
        if count > 0 {
            samples.push(self.sample(direction, sum));
        }
        samples
    }

    /// A sample of a direction in the environment's own axes.
    fn sample(&self, own: DVec3, light_and_angle: DVec2) -> EnvironmentSample {
        let [cos, sin] = self.turn.map(f64::from);
        let (x, z) = (own.x * cos + own.z * sin, own.z * cos - own.x * sin);
        let world = match self.z_up {
            false => DVec3::new(x, own.y, z),
            true => DVec3::new(x, -z, own.y),
        };
        let [light, angle] = light_and_angle.to_array();
        EnvironmentSample {
            direction: world.normalize().to_array().map(|c| c as f32),
            luminance: (light / angle) as f32,
            solid_angle: angle as f32,
        }
    }

    /// The texels of the environment, face by face, block by block along a Hilbert curve.
    fn texels_in_order(&self) -> Vec<Texel> {
        let size = self.size();
        let mut texels = Vec::with_capacity(6 * size as usize * size as usize);
        let end = |block: u32| block * size / BLOCKS;
        for face in 0..6 {
            for (right, down) in (0..BLOCKS * BLOCKS).map(|at| hilbert::cell(at, BLOCKS)) {
                let rows = end(down)..end(down + 1);
                for (y, x) in rows.flat_map(|y| (end(right)..end(right + 1)).map(move |x| (y, x))) {
                    let uv = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / f64::from(size);
                    let direction = EnvironmentLayout::Cube.direction(face, uv);
                    // Of a cube of half side 1, seen from its middle.
                    let way = direction / direction.abs().max_element();
                    let length = way.length();
                    let angle = 4.0 / f64::from(size * size) / (length * length * length);
                    texels.push(Texel {
                        direction,
                        luminance: luminance_f64(self.rough.texel(face, x, y).map(f64::from)),
                        angle,
                    });
                }
            }
        }
        texels
    }
}

/// A texel of the environment.
struct Texel {
    direction: DVec3,
    luminance: f64,
    /// Solid angle.
    angle: f64,
}

impl Texel {
    /// Luminance times solid angle, and solid angle.
    fn light_and_angle(&self) -> DVec2 {
        DVec2::new(self.luminance * self.angle, self.angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Environment;

    /// A dim sky with a round window of fourteen degrees, which holds most of the light.
    fn window() -> EnvironmentLight {
        let toward = DVec3::new(0.6, 0.64, 0.48);
        let light = |d: DVec3| [if d.dot(toward) > 0.97 { 400.0 } else { 0.25 }; 3];
        let environment = Environment::from_fn(EnvironmentLayout::LatLong, 64, light);
        EnvironmentLight::new(&environment.unwrap(), 64).unwrap()
    }

    fn wide(direction: [f32; 3]) -> DVec3 {
        DVec3::from(direction.map(f64::from))
    }

    /// The samples hold the whole sphere and all of its light, half of them in the window.
    #[test]
    fn samples_hold_all_light_and_follow_it() {
        let light = window();
        for count in [1, 7, 64, 500] {
            let samples = light.samples(count);
            assert_eq!(samples.len(), count as usize);
            let angle: f64 = samples.iter().map(|s| f64::from(s.solid_angle)).sum();
            assert!(
                (angle / (4.0 * core::f64::consts::PI) - 1.0).abs() < 1e-3,
                "{angle}"
            );
            let sum = |f: &dyn Fn(DVec3) -> f64| -> f64 {
                let each = samples
                    .iter()
                    .map(|s| f64::from(s.luminance * s.solid_angle) * f(wide(s.direction)));
                each.sum()
            };
            if count < 64 {
                continue;
            }
            // Irradiance by the samples is that of the map, for every normal.
            for n in [
                DVec3::X,
                DVec3::Y,
                DVec3::NEG_Z,
                DVec3::new(-0.6, 0.64, 0.48),
            ] {
                let found = sum(&|d| d.dot(n).max(0.0)) / core::f64::consts::PI;
                let [expected, ..] = light.irradiance(n.to_array().map(|c| c as f32));
                let error = (found - f64::from(expected)).abs();
                assert!(
                    error < 0.05 * light.irradiance([0.0, 1.0, 0.0])[0] as f64,
                    "{n} {found} {expected}"
                );
            }
            let bright = samples.iter().filter(|s| s.luminance > 10.0).count();
            assert!(
                (bright * 2).abs_diff(count as usize) <= 4 + count as usize / 5,
                "{bright} of {count}"
            );
        }
        assert!(light.samples(0).is_empty());
    }

    /// Samples turn with the light, as look-ups do.
    #[test]
    fn samples_turn_with_the_light() {
        for light in [window().turned(0.7), window().upright_on_z().turned(-2.0)] {
            let samples = light.samples(200);
            let brightest = samples.iter().filter(|s| s.luminance > 100.0);
            let mut met = 0;
            for sample in brightest {
                met += 1;
                assert!(
                    light.radiance(0.0, sample.direction)[0] > 20.0,
                    "{sample:?}"
                );
            }
            assert!(met > 50, "{met}");
        }
    }

    /// Without any light the samples are spread evenly.
    #[test]
    fn darkness_has_even_samples() {
        let dark = Environment::from_fn(EnvironmentLayout::Cube, 16, |_| [0.0; 3]).unwrap();
        let samples = EnvironmentLight::new(&dark, 16).unwrap().samples(50);
        let even = 4.0 * core::f32::consts::PI / 50.0;
        assert!(
            samples
                .iter()
                .all(|s| s.luminance == 0.0 && (s.solid_angle / even - 1.0).abs() < 0.01)
        );
    }
}
