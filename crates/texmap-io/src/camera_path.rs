//! Camera paths: the walk of `--path CAMERA.json --frames N`.

use std::path::Path;

use serde::Deserialize;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;

use crate::keyframes::{self, Fields, Leg};
use crate::{FileSource, IoError};

/// One keyframe of a walk, as in the JSON file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Position of the eye.
    pub eye: [f64; 3],
    /// The point that the camera looks at.
    pub look: [f64; 3],
    /// The up direction; that of the scene if it is left out.
    pub up: Option<[f64; 3]>,
    /// Horizontal field of view in degrees; that of the scene if it is left out.
    pub fov: Option<f64>,
}

/// A walk of straight lines from keyframe to keyframe, with equal numbers of frames for each.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    keyframes: Vec<Keyframe>,
}

impl CameraPath {
    /// Reads a JSON list of keyframes, at least one.
    ///
    /// # Errors
    /// File errors, and [`IoError::BrokenPath`] with the position: no such list, a number that is not finite, a field of
    /// view outside of 0 to 180 degrees.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        Self::read_from(path, &FileSource::anywhere())
    }

    /// As [`CameraPath::read`], from a source of files.
    ///
    /// # Errors
    /// The same, and [`IoError::OutsideRoot`].
    pub fn read_from(path: &Path, files: &FileSource) -> Result<Self, IoError> {
        let keyframes: Vec<Keyframe> = keyframes::read(path, files, &FIELDS)?;
        let broken = |problem| keyframes::broken(path, problem);
        for (i, keyframe) in keyframes.iter().enumerate() {
            let numbers = [keyframe.eye, keyframe.look, keyframe.up.unwrap_or_default()];
            if !numbers.as_flattened().iter().all(|x| x.is_finite()) {
                return Err(broken(format!("keyframe {i}: a number is not finite")));
            }
            if keyframe.fov.is_some_and(|f| !(f > 0.0 && f < 180.0)) {
                return Err(broken(format!(
                    "keyframe {i}: fov must be more than 0 and less than 180 degrees"
                )));
            }
        }
        Ok(Self { keyframes })
    }

    /// The keyframes in order.
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// The camera of frame `frame` of `frames`; the first frame stands on the first keyframe, the last on the last.
    pub fn camera(&self, scene: &Camera, frame: u32, frames: u32) -> Camera {
        let Leg { from, to, t } = Leg::of(self.keyframes.len(), frame, frames);
        let (a, b) = (
            at(&self.keyframes[from], scene),
            at(&self.keyframes[to], scene),
        );
        let mix = |a: DVec3, b: DVec3| a * (1.0 - t) + b * t;
        Camera {
            eye: mix(a.eye, b.eye),
            look: mix(a.look, b.look),
            up: mix(a.up, b.up),
            fov_x: a.fov_x * (1.0 - t) + b.fov_x * t,
            ..*scene
        }
    }
}

const FIELDS: Fields = Fields {
    known: "a keyframe has the fields eye, look, up and fov, and no other",
    list: "not a list of keyframes",
};

fn at(keyframe: &Keyframe, scene: &Camera) -> Camera {
    Camera {
        eye: DVec3::from(keyframe.eye),
        look: DVec3::from(keyframe.look),
        up: keyframe.up.map_or(scene.up, DVec3::from),
        fov_x: keyframe.fov.map_or(scene.fov_x, f64::to_radians),
        ..*scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Camera {
        Camera {
            eye: DVec3::ZERO,
            look: DVec3::X,
            up: DVec3::Z,
            fov_x: 1.0,
            near: 1e-4,
            far: f64::INFINITY,
            lens: Default::default(),
        }
    }

    fn read(text: &str) -> Result<CameraPath, IoError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("walk.json");
        std::fs::write(&path, text).unwrap();
        CameraPath::read(&path)
    }

    #[test]
    fn frames_run_from_the_first_stop_to_the_last() {
        let walk = read(
            r#"[{"eye":[0,0,0],"look":[1,0,0]}, {"eye":[4,0,0],"look":[5,0,0],"fov":90},
                {"eye":[4,8,0],"look":[5,8,0],"up":[0,1,0]}]"#,
        )
        .unwrap();
        let eye = |i, n| walk.camera(&scene(), i, n).eye.to_array();
        assert_eq!(
            [eye(0, 5), eye(1, 5), eye(2, 5), eye(3, 5), eye(4, 5)],
            [
                [0.0, 0.0, 0.0],
                [2.0, 0.0, 0.0],
                [4.0, 0.0, 0.0],
                [4.0, 4.0, 0.0],
                [4.0, 8.0, 0.0]
            ]
        );
        assert_eq!(walk.camera(&scene(), 0, 1).fov_x, 1.0);
        assert_eq!(walk.camera(&scene(), 2, 5).fov_x, 90_f64.to_radians());
        assert_eq!(walk.camera(&scene(), 4, 5).up, DVec3::Y);
        let one = read(r#"[{"eye":[1,2,3],"look":[0,0,0]}]"#).unwrap();
        assert_eq!(one.camera(&scene(), 7, 9).eye.to_array(), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn broken_paths_are_refused() {
        for text in [
            "",
            "[]",
            "{}",
            r#"[{"eye":[0,0],"look":[1,0,0]}]"#,
            r#"[{"eye":[0,0,0],"look":[1,0,0],"fov":180}]"#,
        ] {
            assert_eq!(
                read(text).unwrap_err().code(),
                "broken-camera-path",
                "{text}"
            );
        }
        let error = read("[\n{\"eye\":[0,0,0],\"luck\":[1,0,0]}]").unwrap_err();
        assert_eq!(error.location().map(|p| p.line), Some(2));
        // A text that ends too soon ends on a line that it has.
        for (text, location) in [("", (1, 1)), ("\n", (1, 1)), ("[\n{\n", (2, 2))] {
            let error = read(text).unwrap_err();
            assert_eq!(
                error.location().map(|p| (p.line, p.column)),
                Some(location),
                "{text:?}"
            );
        }
    }
}
