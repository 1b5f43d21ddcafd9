//! JSON lists of exact cameras.

use std::path::Path;

use serde::Deserialize;
use texmap_math::camera::{Camera, CameraError, Lens};
use texmap_math::glam::DVec3;

use crate::camera_pose::{CameraAxes, CameraPose, Intrinsics};
use crate::keyframes::{self, Fields};
use crate::{FileSource, IoError};

/// One camera of a list.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedCamera {
    /// Name of the camera, if the list gives one.
    pub name: Option<String>,
    /// The camera itself.
    pub camera: Camera,
}

/// An entry as it stands in the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: Option<String>,
    matrix: Option<[[f64; 4]; 4]>,
    #[serde(default)]
    axes: CameraAxes,
    #[serde(default)]
    world_to_camera: bool,
    eye: Option<[f64; 3]>,
    look: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov: Option<f64>,
    fx: Option<f64>,
    fy: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    width: Option<f64>,
    height: Option<f64>,
    orthographic_width: Option<f64>,
}

/// A JSON list of exact cameras: `matrix` (four rows) with `axes` and `world_to_camera`, or `eye`, `look` and `up`; and `fov` in degrees,
/// `fx fy cx cy` with the `width` and `height` that they are for, or `orthographic_width`.
#[derive(Debug)]
pub struct CameraList {
    path: std::path::PathBuf,
    entries: Vec<Entry>,
}

impl CameraList {
    /// Reads a list of at least one camera.
    ///
    /// # Errors
    /// File errors, and [`IoError::BrokenPath`] with the position.
    pub fn read_from(path: &Path, files: &FileSource) -> Result<Self, IoError> {
        Ok(Self {
            path: path.to_owned(),
            entries: keyframes::read(path, files, &FIELDS)?,
        })
    }

    /// The cameras of the list for pictures of `width` x `height` pixels. Fields that an entry lacks are those of `base`.
    ///
    /// # Errors
    /// [`IoError::BrokenPath`] with the number of the entry.
    pub fn cameras(
        &self,
        base: &Camera,
        width: u32,
        height: u32,
    ) -> Result<Vec<NamedCamera>, IoError> {
        let entries = self.entries.iter().enumerate();
        let camera = |(number, entry): (usize, &Entry)| {
            let camera = entry
                .camera(base, f64::from(width), f64::from(height))
                .and_then(|camera| match camera.view() {
                    Ok(_) => Ok(camera),
                    Err(CameraError::NonFinite) => Err("a number is not finite".into()),
                    Err(e) => Err(e.to_string()),
                });
            let camera = camera.map_err(|e| self.broken(format!("camera {number}: {e}")))?;
            let name = entry.name.clone();
            Ok(NamedCamera { name, camera })
        };
        entries.map(camera).collect()
    }

    /// The names of the cameras, in order; `None` for those without a name.
    #[must_use]
    pub fn names(&self) -> Vec<Option<String>> {
        self.entries.iter().map(|e| e.name.clone()).collect()
    }

    fn broken(&self, problem: String) -> IoError {
        keyframes::broken(&self.path, problem)
    }
}

/// Message for an unknown field.
const FIELDS: Fields = Fields {
    known: "a camera has the fields name, matrix, axes, world_to_camera, eye, look, up, fov, fx, fy, cx, cy, width, height and orthographic_width, and no other",
    list: "not a list of cameras",
};

impl Entry {
    fn camera(&self, base: &Camera, width: f64, height: f64) -> Result<Camera, String> {
        let mut camera = match (self.matrix, self.eye) {
            (Some(rows), None) => CameraPose {
                rows,
                axes: self.axes,
                world_to_camera: self.world_to_camera,
            }
            .place(base)?,
            (None, Some(eye)) => Camera {
                eye: DVec3::from(eye),
                look: DVec3::from(self.look.ok_or("an eye needs a look")?),
                up: self.up.map_or(base.up, DVec3::from),
                ..*base
            },
            (None, None) => *base,
            (Some(_), Some(_)) => return Err("give a matrix or an eye, not both".into()),
        };
        camera.lens = Lens::default();
        if let Some(degrees) = self.fov {
            if !(degrees > 0.0 && degrees < 180.0) {
                return Err("fov must be more than 0 and less than 180 degrees".into());
            }
            camera.fov_x = degrees.to_radians();
        }
        if let Some(across) = self.orthographic_width {
            camera.lens.parallel_width = Some(across);
            camera.far = camera.far.min(1e6 * across.abs());
        }
        match [self.fx, self.fy, self.cx, self.cy] {
            [None, None, None, None] => Ok(camera),
            [Some(fx), fy, cx, cy] => {
                let (w, h) = (self.width.unwrap_or(width), self.height.unwrap_or(height));
                if ((w / h) / (width / height) - 1.0).abs() > 0.01 {
                    return Err(format!(
                        "intrinsics for {w} x {h} pixels and a picture of {width} x {height}: take a --resolution of the same shape"
                    ));
                }
                let intrinsics = Intrinsics {
                    fx,
                    fy: fy.unwrap_or(fx),
                    cx: cx.unwrap_or(0.5 * w),
                    cy: cy.unwrap_or(0.5 * h),
                };
                intrinsics.apply(&camera, w, h)
            }
            _ => Err("fy, cx and cy need an fx".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> Camera {
        Camera::look_at([0.0, 0.0, 5.0], [0.0; 3])
    }

    #[test]
    fn lists_are_read_and_faults_name_the_camera() {
        let read = |text: &str| {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("cameras.json");
            std::fs::write(&path, text).unwrap();
            CameraList::read_from(&path, &FileSource::anywhere())
                .and_then(|list| list.cameras(&base(), 640, 480))
        };
        let list = read(
            r#"[{"name":"a","matrix":[[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]],"fx":500},
                {"eye":[1,2,3],"look":[0,0,0],"fov":90,"axes":"opencv"},
                {"eye":[1,2,3],"look":[0,0,0],"orthographic_width":4},
                {"fx":1000,"fy":900,"cx":600,"cy":520,"width":1280,"height":960}]"#,
        )
        .unwrap();
        assert_eq!(list[0].name.as_deref(), Some("a"));
        assert_eq!(list[0].camera.eye, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(list[1].camera.fov_x, 90_f64.to_radians());
        assert_eq!(list[2].camera.lens.parallel_width, Some(4.0));
        let half = Intrinsics {
            fx: 500.0,
            fy: 450.0,
            cx: 300.0,
            cy: 260.0,
        };
        assert_eq!(list[3].camera, half.apply(&base(), 640.0, 480.0).unwrap());
        for (text, word) in [
            ("[]", "empty"),
            (r#"[{"eye":[0,0,0]}]"#, "camera 0: an eye needs a look"),
            (r#"[{"eye":[0,0,0],"look":[0,0,0]}]"#, "camera 0"),
            (r#"[{},{"cx":4}]"#, "camera 1: fy, cx and cy need an fx"),
            (r#"[{"fx":4,"width":10,"height":400}]"#, "same shape"),
            (r#"[{"focal":4}]"#, "a camera has the fields"),
            (r#"[{"matrix":[1,2]}]"#, "not a list of cameras"),
        ] {
            let error = read(text).unwrap_err();
            assert_eq!(error.code(), "broken-camera-path");
            assert!(error.to_string().contains(word), "{error}");
        }
    }
}
