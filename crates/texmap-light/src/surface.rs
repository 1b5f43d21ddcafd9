/// What a surface does with light: a colour and the four numbers of the MIT 6.837 `surf` command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Diffuse and ambient colour, linear light, 0..=1. The highlight does not take it.
    pub color: [f32; 3],
    /// Share of ambient light that is returned, usually 0..=1.
    pub ka: f32,
    /// Share of direct light that is returned in all directions, usually 0..=1.
    pub kd: f32,
    /// Strength of the highlight, usually 0..=1.
    pub ks: f32,
    /// Phong exponent of the highlight, `>= 0`; larger is smaller and sharper.
    pub ns: f32,
}

impl Default for Surface {
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

impl Surface {
    /// Whether every number is finite and none is negative.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let [r, g, b] = self.color;
        [r, g, b, self.ka, self.kd, self.ks, self.ns]
            .iter()
            .all(|x| x.is_finite() && *x >= 0.0)
    }
}

/// A light source. Colours are linear factors, `>= 0`; none is attenuated by distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// The same from everywhere.
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
        /// Where the light stands.
        position: [f32; 3],
    },
}

impl Light {
    /// Whether every number is finite, no intensity is negative, and a direction has a length.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let (color, vector) = match *self {
            Self::Ambient { color } => (color, [0.0; 3]),
            Self::Directional { direction, .. } if direction == [0.0; 3] => return false,
            Self::Directional { color, direction } => (color, direction),
            Self::Point { color, position } => (color, position),
        };
        color.iter().all(|x| x.is_finite() && *x >= 0.0) && vector.iter().all(|x| x.is_finite())
    }
}
