use texmap_math::deterministic_f64;

use crate::LightCone;

/// Falloff of a highlight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpecularModel {
    /// `max(0, V.R)^ns`, the angle between the eye and the mirrored light (Phong 1975, and MIT 6.837).
    #[default]
    Phong,
    /// `max(0, N.H)^ns`, the angle between the normal and the vector halfway to the light (Blinn 1977). For small angles as
    /// wide as Phong's with a fourth of the exponent.
    Blinn,
}

/// Reflectance of a surface: a colour and the four numbers of the MIT 6.837 `surf` command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongMaterial {
    /// Diffuse and ambient colour, linear light, 0..=1. The highlight does not take it.
    pub color: [f32; 3],
    /// Fraction of ambient light that is returned, usually 0..=1.
    pub ka: f32,
    /// Fraction of direct light that is returned in all directions, usually 0..=1.
    pub kd: f32,
    /// Strength of the highlight, usually 0..=1.
    pub ks: f32,
    /// Phong exponent of the highlight, `>= 0`; larger is smaller and sharper.
    pub ns: f32,
}

impl Default for PhongMaterial {
    /// The defaults of the MIT 6.837 scene format: grey 0.5, `ka = kd = ks = 1`, `ns = 5`.
    fn default() -> Self {
        Self {
            color: [0.5; 3],
            ka: 1.0,
            kd: 1.0,
            ks: 1.0,
            ns: 5.0,
        }
    }
}

impl PhongMaterial {
    /// True if every number is finite and none is negative.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let [r, g, b] = self.color;
        [r, g, b, self.ka, self.kd, self.ks, self.ns]
            .iter()
            .all(|x| x.is_finite() && *x >= 0.0)
    }
}

/// A light source. Colours are linear factors, `>= 0`: a white surface that faces a light of colour 1 has a radiance of 1. Only
/// [`Light::Punctual`] is attenuated by distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// Ambient light, the same from everywhere.
    Ambient {
        /// Linear intensity per channel.
        color: [f32; 3],
    },
    /// Parallel light from far away.
    Directional {
        /// Linear intensity per channel.
        color: [f32; 3],
        /// From the light TO the surface (the MIT `ld` command); any length but zero.
        direction: [f32; 3],
    },
    /// Light from one point.
    Point {
        /// Linear intensity per channel.
        color: [f32; 3],
        /// Position of the light.
        position: [f32; 3],
    },
    /// Light from one point into a cone; [`Light::spot`] makes it from angles.
    Spot {
        /// Linear intensity per channel on the axis.
        color: [f32; 3],
        /// Position of the light.
        position: [f32; 3],
        /// The cone's axis, away from the light; any length but zero.
        direction: [f32; 3],
        /// Cosine of half the angle of the full cone: inside of it the light has its whole strength.
        cos_inner: f32,
        /// Cosine of half the angle of the outer cone, beyond which there is no light; at most `cos_inner`. Between them the
        /// strength falls as `3x^2 - 2x^3` of the cosine.
        cos_outer: f32,
    },
    /// A point or spot light in physical units (glTF `KHR_lights_punctual`; its directional light of `E` lux is a
    /// [`Light::Directional`] of colour `E / pi`). At a distance of `d` it has the colour
    /// `intensity / (pi d^2) * max(0, 1 - (d / range)^4) * cone`: a white surface that faces it has that radiance.
    Punctual {
        /// Luminous intensity per channel, candela; distances are in metres.
        intensity: [f32; 3],
        /// Position of the light.
        position: [f32; 3],
        /// Distance from which on there is no light; above 0, infinite for none.
        range: f32,
        /// The cone of a spot light; a point light has none.
        cone: Option<LightCone>,
    },
}

impl Light {
    /// A spot light from half the angles of its two cones, in radians: full inside of `inner`, nothing outside of `outer`.
    #[must_use]
    pub fn spot(
        color: [f32; 3],
        position: [f32; 3],
        direction: [f32; 3],
        inner: f32,
        outer: f32,
    ) -> Self {
        let cos = |angle: f32| deterministic_f64::cos(f64::from(angle)) as f32;
        Self::Spot {
            color,
            position,
            direction,
            cos_inner: cos(inner),
            cos_outer: cos(outer),
        }
    }

    /// True if every number is finite, no intensity is negative, and a direction has a length.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let (color, vector) = match *self {
            Self::Ambient { color } => (color, [0.0; 3]),
            Self::Directional { direction, .. } if direction == [0.0; 3] => return false,
            Self::Directional { color, direction } => (color, direction),
            Self::Point { color, position } => (color, position),
            Self::Spot {
                color,
                position,
                direction,
                cos_inner,
                cos_outer,
            } => {
                let cones = cos_inner <= 1.0 && cos_outer <= cos_inner && cos_outer >= -1.0;
                let axis = direction != [0.0; 3] && direction.iter().all(|x| x.is_finite());
                if !(cones && axis) {
                    return false;
                }
                (color, position)
            }
            Self::Punctual {
                intensity,
                position,
                range,
                cone,
            } => {
                if !(range > 0.0 && cone.is_none_or(|cone| cone.is_valid())) {
                    return false;
                }
                (intensity, position)
            }
        };
        color.iter().all(|x| x.is_finite() && *x >= 0.0) && vector.iter().all(|x| x.is_finite())
    }
}
