//! The falloff of lights in physical units, by distance and around the axis of a cone (glTF `KHR_lights_punctual`).

use texmap_math::deterministic_f64;
use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;
use crate::vector::{dot, is_zero, splat};

/// The cone of a light in physical units: full strength near its axis, none beyond the outer angle. Between them the strength is
/// the square of a line over the cosine: `((cos - cos_outer) / (cos_inner - cos_outer))^2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCone {
    /// Away from the light; any length but zero.
    pub direction: [f32; 3],
    /// Cosine of the angle between the axis and the cone of full strength.
    pub cos_inner: f32,
    /// Cosine of the angle between the axis and the cone of no strength; at most `cos_inner`.
    pub cos_outer: f32,
}

impl LightCone {
    /// A cone from its two angles to the axis in radians, as in glTF: `0 <= inner <= outer <= pi / 2`.
    #[must_use]
    pub fn new(direction: [f32; 3], inner: f32, outer: f32) -> Self {
        let cos = |angle: f32| deterministic_f64::cos(f64::from(angle)) as f32;
        Self {
            direction,
            cos_inner: cos(inner),
            cos_outer: cos(outer),
        }
    }

    /// True if the axis is finite and has a length, and the cosines are within -1 to 1 and in order.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let axis = self.direction != [0.0; 3] && self.direction.iter().all(|x| x.is_finite());
        let cones = self.cos_inner <= 1.0 && self.cos_outer <= self.cos_inner;
        axis && cones && self.cos_outer >= -1.0
    }
}

/// Least squared distance, a millionth of a unit. Lower ones count as this, so that strengths stay finite.
pub(crate) const LEAST_SQUARE: f32 = 1e-12;
/// Least difference of cosines, from the extension; lower ones count as this.
pub(crate) const LEAST_COSINE: f32 = 1e-3;

/// The factor of an intensity in candela, `window / (pi d^2)` times the strength in the cone. `way` are the vectors from points to
/// the light, `window = max(0, 1 - (d / range)^4)`, 1 for an infinite range.
#[inline(always)]
pub(crate) fn falloff<I: Isa>(
    i: I,
    range: f32,
    cone: Option<&LightCone>,
    way: Vector<I>,
    toward: Vector<I>,
) -> I::F32 {
    let (zero, one) = (i.f32(0.0), i.f32(1.0));
    let square = dot(way, way);
    let mut share = i.f32(core::f32::consts::FRAC_1_PI) / square.above(i.f32(LEAST_SQUARE));
    if range < f32::INFINITY {
        let ratio = square.sqrt() / range;
        let ratio = ratio * ratio;
        share = share * (one - ratio * ratio).above(zero);
    }
    if let Some(cone) = cone {
        let along = -dot(splat(i, crate::unit(cone.direction)), toward);
        let width = (cone.cos_inner - cone.cos_outer).max(LEAST_COSINE);
        let part = ((along - cone.cos_outer) / width).clamp(zero, one);
        share = share * (part * part);
    }
    // A point in the light has no direction to it.
    is_zero(i, toward).select(zero, share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{columns, load};
    use crate::{Light, PhongMaterial, lighting, reference};
    use texmap_math::glam::DVec3;
    use texmap_math::simd::Scalar;

    const MATTE: PhongMaterial = PhongMaterial {
        color: [1.0; 3],
        ka: 0.0,
        kd: 1.0,
        ks: 0.0,
        ns: 1.0,
    };

    fn light(range: f32, cone: Option<LightCone>) -> Light {
        Light::Punctual {
            intensity: [core::f32::consts::PI * 8.0, 4.0, 1.0],
            position: [0.0, 0.0, 2.0],
            range,
            cone,
        }
    }

    /// Diffuse light of a floor below the light, at a distance from the foot of the perpendicular.
    fn floor(light: Light, x: f32) -> [f32; 3] {
        lighting(
            &MATTE,
            &[light],
            [x, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 9.0],
        )
        .diffuse
    }

    /// A white surface at two units under 8 pi candela has a radiance of 2: `I / (pi d^2)`.
    #[test]
    fn strength_falls_with_the_square_of_the_distance() {
        let near = floor(light(f32::INFINITY, None), 0.0)[0];
        assert!((near - 2.0).abs() < 1e-6, "{near}");
        // At 60 degrees: twice as far and half as steep.
        let far = floor(light(f32::INFINITY, None), 12f32.sqrt())[0];
        assert!((far - 0.25).abs() < 1e-6, "{far}");
        let flat = Light::Point {
            color: [2.0; 3],
            position: [0.0, 0.0, 2.0],
        };
        assert!((floor(flat, 12f32.sqrt())[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_passes_the_range() {
        let full = floor(light(f32::INFINITY, None), 0.0)[0];
        let window = floor(light(4.0, None), 0.0)[0] / full;
        assert!((window - 15.0 / 16.0).abs() < 1e-6, "{window}");
        assert_eq!(floor(light(2.0, None), 0.0), [0.0; 3]);
        assert_eq!(floor(light(1e-30, None), 0.0), [0.0; 3]);
    }

    #[test]
    fn cones_fall_as_the_square_of_a_line_over_the_cosine() {
        let cone = LightCone {
            direction: [0.0, 0.0, -5.0],
            cos_inner: 0.9,
            cos_outer: 0.5,
        };
        let part = |cos: f32| {
            let x = 2.0 * (1.0 - cos * cos).sqrt() / cos;
            let all = floor(light(f32::INFINITY, None), x)[0];
            floor(light(f32::INFINITY, Some(cone)), x)[0] / all
        };
        assert!((part(0.95) - 1.0).abs() < 1e-6);
        assert!((part(0.7) - 0.25).abs() < 1e-5, "{}", part(0.7));
        assert_eq!(part(0.45), 0.0);
    }

    #[test]
    fn numbers_outside_of_their_range_are_invalid() {
        let cone = LightCone::new([0.0, -1.0, 0.0], 0.2, 0.5);
        assert!(light(f32::INFINITY, Some(cone)).is_valid() && light(3.0, None).is_valid());
        for range in [0.0, -1.0, f32::NAN] {
            assert!(!light(range, None).is_valid(), "{range}");
        }
        for broken in [
            LightCone::new([0.0; 3], 0.2, 0.5),
            LightCone::new([0.0, -1.0, 0.0], 0.6, 0.5),
            LightCone::new([f32::NAN, -1.0, 0.0], 0.2, 0.5),
        ] {
            assert!(!light(3.0, Some(broken)).is_valid(), "{broken:?}");
        }
    }

    /// Points in the light, beside it and as far as f32 goes.
    #[test]
    fn strengths_are_finite() {
        for x in [0.0, 1e-30, 1e-4, 1e19, 3e38] {
            for range in [f32::INFINITY, 1e-30, 1e30] {
                let light = Light::Punctual {
                    intensity: [1e4; 3],
                    position: [0.0; 3],
                    range,
                    cone: None,
                };
                let normal = [1.0, 0.0, 0.0];
                let got = lighting(&MATTE, &[light], [-x, 0.0, 0.0], normal, [1.0, 1.0, 1.0]);
                assert!(got.diffuse.iter().all(|c| c.is_finite()), "{x} {range}");
            }
        }
    }

    #[test]
    fn lanes_have_the_bits_of_one_point_and_the_values_of_the_reference() {
        let ways: [[f32; 3]; 16] = core::array::from_fn(|k| match k {
            0 => [0.0; 3],
            1 => [1e-9, 0.0, 0.0],
            k => [3, 5, 7].map(|p| ((k * p) % 11) as f32 * 0.4 - 1.7),
        });
        let cone = LightCone::new([0.3, -0.2, 0.9], 0.3, 1.4);
        for (range, cone) in [(f32::INFINITY, None), (3.0, None), (2.5, Some(cone))] {
            for way in ways {
                let light = Light::Punctual {
                    intensity: [2.0; 3],
                    position: way,
                    range,
                    cone,
                };
                let got = lighting(&MATTE, &[light], [0.0; 3], way, [0.0, 0.0, 1.0]);
                let wide = DVec3::from(way.map(f64::from));
                let (right, _) = reference::lighting(&MATTE, &[light], DVec3::ZERO, wide, DVec3::Z);
                let off = (f64::from(got.diffuse[0]) - right.x).abs();
                assert!(
                    off <= 2e-6 * right.x.max(1.0),
                    "{way:?}: {off:e} of {right}"
                );
            }
            every_width!(i => check(i, &ways, range, cone.as_ref()));
        }
        fn check<I: Isa>(i: I, ways: &[[f32; 3]; 16], range: f32, cone: Option<&LightCone>) {
            for first in (0..16).step_by(I::LANES) {
                let way = load(i, ways, first);
                let got = falloff(i, range, cone, way, crate::lanes::unit(i, way));
                let [got] = columns(i, [got]);
                for lane in 0..I::LANES {
                    let way = ways[first + lane];
                    let one = falloff(Scalar, range, cone, way, crate::unit(way));
                    assert_eq!(got[lane].to_bits(), one.to_bits(), "{way:?}");
                }
            }
        }
    }
}
