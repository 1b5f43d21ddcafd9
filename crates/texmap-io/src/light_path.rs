//! Light paths: the moving light of `--light-path LIGHT.json --frames N`.

use std::path::Path;

use serde::Deserialize;
use texmap_light::Light;
use texmap_math::glam::DVec3;

use crate::keyframes::{self, Fields, Leg};
use crate::{FileSource, IoError};

/// One keyframe of a moving light, as in the JSON file. A number that is left out is that of the scene's light.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightKeyframe {
    /// Position of a point or spot light.
    pub position: Option<[f64; 3]>,
    /// The point that a spot light shines at from its position.
    pub look: Option<[f64; 3]>,
    /// Direction of a spot or directional light; not together with `look`.
    pub direction: Option<[f64; 3]>,
    /// Linear light (raw values under raw colours), not negative.
    pub color: Option<[f64; 3]>,
}

/// A way of straight lines from keyframe to keyframe, with equal numbers of frames for each.
#[derive(Debug, Clone, PartialEq)]
pub struct LightPath {
    keyframes: Vec<LightKeyframe>,
}

const FIELDS: Fields = Fields {
    known: "a keyframe of a light has the fields position, look, direction and color, and no other",
    list: "not a list of keyframes",
};

impl LightPath {
    /// Reads a JSON list of keyframes, at least one.
    ///
    /// # Errors
    /// File errors, and [`IoError::BrokenPath`] with the position: no such list, a number that is not finite, a colour below 0, a
    /// direction of length 0, `look` and `direction` together.
    pub fn read_from(path: &Path, files: &FileSource) -> Result<Self, IoError> {
        let keyframes: Vec<LightKeyframe> = keyframes::read(path, files, &FIELDS)?;
        for (i, k) in keyframes.iter().enumerate() {
            let mut numbers = [k.position, k.look, k.direction, k.color]
                .into_iter()
                .flatten()
                .flatten();
            let problem = if !numbers.all(f64::is_finite) {
                "a number is not finite"
            } else if k.color.is_some_and(|c| c.iter().any(|c| *c < 0.0)) {
                "color must not be negative"
            } else if k.direction == Some([0.0; 3]) {
                "direction has no length"
            } else if k.look.is_some() && k.direction.is_some() {
                "look and direction stand together: give one"
            } else {
                continue;
            };
            return Err(keyframes::broken(path, format!("keyframe {i}: {problem}")));
        }
        Ok(Self { keyframes })
    }

    /// The light of frame `frame` of `frames`, made of the scene's light; the first frame stands on the first keyframe, the last on the
    /// last. `None` for an ambient light, which has no place.
    #[must_use]
    pub fn light(&self, resting: &Light, frame: u32, frames: u32) -> Option<Light> {
        let Leg { from, to, t } = Leg::of(self.keyframes.len(), frame, frames);
        let rest = Place::of(resting)?;
        let (a, b) = (rest.at(&self.keyframes[from]), rest.at(&self.keyframes[to]));
        let mix = |a: DVec3, b: DVec3| a * (1.0 - t) + b * t;
        let place = Place {
            position: mix(a.position, b.position),
            direction: mix(a.direction, b.direction),
            color: mix(a.color, b.color),
        };
        Some(place.put(resting))
    }
}

/// The numbers of a light that move.
#[derive(Clone, Copy)]
struct Place {
    position: DVec3,
    direction: DVec3,
    color: DVec3,
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

fn narrow(v: DVec3) -> [f32; 3] {
    v.to_array().map(|c| c as f32)
}

impl Place {
    fn of(light: &Light) -> Option<Self> {
        let (position, direction, color) = match *light {
            Light::Directional { color, direction } => ([0.0; 3], direction, color),
            Light::Point { color, position } => (position, [0.0; 3], color),
            Light::Spot {
                color,
                position,
                direction,
                ..
            } => (position, direction, color),
            Light::Punctual {
                intensity,
                position,
                cone,
                ..
            } => {
                let direction = cone.map_or([0.0; 3], |cone| cone.direction);
                (position, direction, intensity)
            }
            _ => return None,
        };
        Some(Self {
            position: wide(position),
            direction: wide(direction),
            color: wide(color),
        })
    }

    /// This place with the numbers of a keyframe.
    fn at(&self, keyframe: &LightKeyframe) -> Self {
        let position = keyframe.position.map_or(self.position, DVec3::from);
        let direction = match (keyframe.look, keyframe.direction) {
            (Some(look), _) => DVec3::from(look) - position,
            (None, Some(direction)) => DVec3::from(direction),
            (None, None) => self.direction,
        };
        Self {
            position,
            direction,
            color: keyframe.color.map_or(self.color, DVec3::from),
        }
    }

    /// A light of a kind with these numbers.
    fn put(&self, resting: &Light) -> Light {
        let (at, along, light) = (
            narrow(self.position),
            narrow(self.direction),
            narrow(self.color),
        );
        let mut moved = *resting;
        match &mut moved {
            Light::Directional { color, direction } => (*color, *direction) = (light, along),
            Light::Point { color, position } => (*color, *position) = (light, at),
            Light::Spot {
                color,
                position,
                direction,
                ..
            } => (*color, *position, *direction) = (light, at, along),
            Light::Punctual {
                intensity,
                position,
                cone,
                ..
            } => {
                (*intensity, *position) = (light, at);
                if let Some(cone) = cone {
                    cone.direction = along;
                }
            }
            _ => {}
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<LightPath, IoError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("light.json");
        std::fs::write(&path, text).unwrap();
        LightPath::read_from(&path, &FileSource::anywhere())
    }

    #[test]
    fn a_spot_goes_from_keyframe_to_keyframe_and_looks() {
        let text = r#"[{"position":[0,2,0],"look":[0,0,0]},{"position":[4,2,0],"look":[2,0,0],"color":[1,0,0]}]"#;
        let path = read(text).unwrap();
        let spot = Light::spot([0.0, 1.0, 0.0], [9.0; 3], [0.0, 0.0, 1.0], 0.1, 0.2);
        let at = |frame| match path.light(&spot, frame, 3) {
            Some(Light::Spot {
                color,
                position,
                direction,
                ..
            }) => (color, position, direction),
            other => panic!("{other:?}"),
        };
        assert_eq!(at(0), ([0.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0]));
        assert_eq!(at(1), ([0.5, 0.5, 0.0], [2.0, 2.0, 0.0], [-1.0, -2.0, 0.0]));
        assert_eq!(at(2).1, [4.0, 2.0, 0.0]);
        let ambient = Light::Ambient { color: [1.0; 3] };
        assert_eq!(path.light(&ambient, 0, 3), None);
    }

    #[test]
    fn bad_lists_say_why() {
        for (text, problem) in [
            ("[]", "the list is empty"),
            (
                r#"[{"eye":[0,0,0]}]"#,
                "position, look, direction and color",
            ),
            (r#"[{"color":[-1,0,0]}]"#, "must not be negative"),
            (r#"[{"direction":[0,0,0]}]"#, "no length"),
            (r#"[{"look":[0,0,0],"direction":[0,0,1]}]"#, "give one"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(problem), "{text}: {error}");
        }
    }
}
