//! Exact cameras as other programs have them: 4 x 4 poses, calibrated intrinsics, and JSON lists of both.

use serde::Deserialize;
use texmap_math::camera::{Camera, Lens};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};

/// The axes of a camera in its own space.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraAxes {
    /// x to the right, y up, looking along -z: OpenGL, Blender, NeRF files.
    #[default]
    OpenGl,
    /// x to the right, y down, looking along +z: OpenCV, COLMAP.
    OpenCv,
}

impl CameraAxes {
    /// Every kind and its word.
    pub const ALL: [(&'static str, Self); 2] = [("opengl", Self::OpenGl), ("opencv", Self::OpenCv)];
}

impl std::str::FromStr for CameraAxes {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.iter().find(|(name, _)| *name == word);
        found.map(|(_, axes)| *axes).ok_or("know opengl, opencv")
    }
}

/// Position and orientation of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Rows of the matrix from camera to world, or from world to camera.
    pub rows: [[f64; 4]; 4],
    /// The axes of its camera space.
    pub axes: CameraAxes,
    /// The matrix leads from world to camera space (extrinsics).
    pub world_to_camera: bool,
}

impl CameraPose {
    /// `camera` at this pose.
    ///
    /// # Errors
    /// One line with the fault of the matrix: not finite, a last row other than 0 0 0 1, axes that are not at right angles within a
    /// thousandth, not of one length, or left-handed.
    pub fn place(&self, camera: &Camera) -> Result<Camera, String> {
        let given = DMat4::from_cols_array_2d(&self.rows).transpose();
        if !given.is_finite() {
            return Err("a number is not finite".into());
        }
        if (given.row(3) - DMat4::IDENTITY.row(3)).abs().max_element() > 1e-9 {
            return Err(
                "the last row must be 0 0 0 1: give rows, translation in the last column".into(),
            );
        }
        let matrix = match self.world_to_camera {
            true if given.determinant() == 0.0 => return Err("the matrix has no inverse".into()),
            true => given.inverse(),
            false => given,
        };
        let [right, vertical, depth] =
            [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|c| c.truncate());
        let lengths = [right, vertical, depth].map(DVec3::length);
        let (least, most) = (
            lengths[0].min(lengths[1]).min(lengths[2]),
            lengths[0].max(lengths[1]).max(lengths[2]),
        );
        if !(least > 0.0 && most <= least * 1.001) {
            return Err(format!(
                "its axes have the lengths {:.6}, {:.6} and {:.6}, which must be equal",
                lengths[0], lengths[1], lengths[2]
            ));
        }
        let [right, vertical, depth] = [right, vertical, depth].map(DVec3::normalize);
        let skew = right
            .dot(vertical)
            .abs()
            .max(vertical.dot(depth).abs())
            .max(depth.dot(right).abs());
        if skew > 1e-3 {
            return Err("its axes are not at right angles".into());
        }
        if right.cross(vertical).dot(depth) < 0.0 {
            return Err("it mirrors: a camera turns and moves, nothing else".into());
        }
        let (up, forward) = match self.axes {
            CameraAxes::OpenGl => (vertical, -depth),
            CameraAxes::OpenCv => (-vertical, depth),
        };
        let eye = matrix.w_axis.truncate();
        // Far enough that a large position does not round the direction away.
        let ahead = eye.abs().max_element().max(1.0);
        Ok(Camera {
            eye,
            look: eye + forward * ahead,
            up,
            ..*camera
        })
    }
}

/// Calibrated intrinsics of a pinhole camera, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length over the width of a pixel.
    pub fx: f64,
    /// Focal length over the height of a pixel.
    pub fy: f64,
    /// The principal point from the upper left corner of the picture, to the right: half a width is the middle. (Conventions that count
    /// from the centre of the first pixel are half a pixel less.)
    pub cx: f64,
    /// The same downwards.
    pub cy: f64,
}

impl Intrinsics {
    /// `camera` with these intrinsics for a picture of `width` x `height` pixels.
    ///
    /// # Errors
    /// One line: a number that is not finite, or a focal length that is not above 0.
    pub fn apply(&self, camera: &Camera, width: f64, height: f64) -> Result<Camera, String> {
        let Self { fx, fy, cx, cy } = *self;
        if ![fx, fy, cx, cy].iter().all(|x| x.is_finite()) {
            return Err("an intrinsic is not finite".into());
        }
        if !(fx > 0.0 && fy > 0.0) {
            return Err("focal lengths must be above 0".into());
        }
        Ok(Camera {
            fov_x: 2.0 * deterministic_f64::atan(width / (2.0 * fx)),
            lens: Lens {
                parallel_width: None,
                center: [2.0 * cx / width - 1.0, 1.0 - 2.0 * cy / height],
                pixel_aspect: fy / fx,
            },
            ..*camera
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> Camera {
        Camera::look_at([0.0, 0.0, 5.0], [0.0; 3])
    }

    /// One camera in five notations.
    #[test]
    fn poses_agree_whatever_their_axes_and_direction() {
        let wanted = Camera {
            eye: DVec3::new(3.0, 2.0, -1.0),
            look: DVec3::new(0.5, 0.25, 0.0),
            up: DVec3::new(0.1, 1.0, 0.2),
            ..base()
        };
        let to_camera = wanted.view().unwrap();
        let flip = DMat4::from_scale(DVec3::new(1.0, -1.0, -1.0));
        let rows = |m: DMat4| m.transpose().to_cols_array_2d();
        for (matrix, axes, world_to_camera) in [
            (to_camera.inverse(), CameraAxes::OpenGl, false),
            (to_camera, CameraAxes::OpenGl, true),
            (to_camera.inverse() * flip, CameraAxes::OpenCv, false),
            (flip * to_camera, CameraAxes::OpenCv, true),
        ] {
            let rows = rows(matrix);
            let pose = CameraPose {
                rows,
                axes,
                world_to_camera,
            };
            let view = pose.place(&base()).unwrap().view().unwrap();
            assert!(
                view.abs_diff_eq(to_camera, 1e-12),
                "{axes:?} {world_to_camera}"
            );
            // The other axes look the other way.
            let other = match axes {
                CameraAxes::OpenGl => CameraAxes::OpenCv,
                CameraAxes::OpenCv => CameraAxes::OpenGl,
            };
            let turned = CameraPose {
                axes: other,
                ..pose
            }
            .place(&base())
            .unwrap();
            assert!(!turned.view().unwrap().abs_diff_eq(to_camera, 0.1));
        }
    }

    #[test]
    fn matrices_that_are_no_poses_are_refused() {
        let with = |change: fn(&mut DMat4)| {
            let mut m = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0));
            change(&mut m);
            let rows = m.transpose().to_cols_array_2d();
            CameraPose {
                rows,
                axes: CameraAxes::OpenGl,
                world_to_camera: false,
            }
            .place(&base())
        };
        assert!(with(|_| ()).is_ok());
        assert!(with(|m| *m *= DMat4::from_scale(DVec3::splat(3.0))).is_ok());
        for (change, word) in [
            ((|m| m.x_axis.x = f64::NAN) as fn(&mut DMat4), "finite"),
            (|m| *m = m.transpose(), "last row"),
            (|m| m.x_axis.x = -1.0, "mirrors"),
            (|m| m.x_axis.x = 2.0, "lengths"),
            (
                |m| m.x_axis = (DVec3::new(0.8, 0.6, 0.0)).extend(0.0),
                "right angles",
            ),
            (|m| m.x_axis = DVec3::ZERO.extend(0.0), "lengths"),
        ] {
            let error = with(change).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn intrinsics_put_the_axis_at_the_principal_point() {
        let (width, height) = (640.0, 480.0);
        let k = Intrinsics {
            fx: 500.0,
            fy: 450.0,
            cx: 300.0,
            cy: 260.0,
        };
        let camera = k.apply(&base(), width, height).unwrap();
        let clip = camera.clip_from_world(width / height).unwrap();
        // OpenCV's formula for a point before the camera: x to the right, y down.
        for p in [[0.0, 0.0, 4.0], [1.0, 0.5, 4.0], [-2.0, 1.0, 9.0]] {
            let [x, y, z] = p;
            let wanted = [k.fx * x / z + k.cx, k.fy * y / z + k.cy];
            let c = clip * DVec3::new(x, -y, 5.0 - z).extend(1.0);
            let seen = [
                (c.x / c.w + 1.0) * 0.5 * width,
                (1.0 - c.y / c.w) * 0.5 * height,
            ];
            for i in 0..2 {
                assert!((seen[i] - wanted[i]).abs() < 1e-9, "{seen:?} {wanted:?}");
            }
        }
        assert!(
            Intrinsics { fx: 0.0, ..k }
                .apply(&base(), width, height)
                .is_err()
        );
        assert!(
            Intrinsics { cx: f64::NAN, ..k }
                .apply(&base(), width, height)
                .is_err()
        );
    }
}
