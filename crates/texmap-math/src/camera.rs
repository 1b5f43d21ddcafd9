//! The camera: right-handed, looks along -Z of view space, +Y up, reversed depth.

use core::fmt;

use glam::{DMat4, DVec3, DVec4};

use crate::deterministic_f64;

/// A camera. Angles in radians, lengths in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    pub eye: DVec3,
    /// The point that the eye looks at.
    pub look: DVec3,
    /// A direction that appears upwards; any length, not parallel to the line of sight.
    pub up: DVec3,
    /// Horizontal field of view, in (0, pi); of the whole width of the picture where the principal point is its middle.
    pub fov_x: f64,
    /// Distance of the near plane, above 0.
    pub near: f64,
    /// Distance of the far plane, above `near`; may be infinite, but not in a parallel projection.
    pub far: f64,
    /// Projection and position of the picture before the eye.
    pub lens: Lens,
}

/// Projection of a camera and position of its picture. The default is a pinhole in front of the middle of square pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// A parallel (orthographic) projection: width of the picture in world units, above 0; `fov_x` says nothing then. `None` for a
    /// central one.
    pub parallel_width: Option<f64>,
    /// The principal point, where the line of sight meets the picture, from the middle of the picture to the right and up, in
    /// halves of its width and height.
    pub center: [f64; 2],
    /// Width of a pixel over its height, above 0: `fy / fx` of a calibrated camera.
    pub pixel_aspect: f64,
}

impl Default for Lens {
    fn default() -> Self {
        Self {
            parallel_width: None,
            center: [0.0; 2],
            pixel_aspect: 1.0,
        }
    }
}

impl Lens {
    fn check(&self, far: f64) -> Result<(), CameraError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let problem = if !self.center.iter().all(|c| c.is_finite()) {
            "its principal point must be finite"
        } else if !positive(self.pixel_aspect) {
            "its pixels must have a width over height that is finite and above 0"
        } else if self.parallel_width.is_some_and(|width| !positive(width)) {
            "the width of a parallel projection must be finite and above 0"
        } else if self.parallel_width.is_some() && !far.is_finite() {
            "a parallel projection needs a finite far plane"
        } else {
            return Ok(());
        };
        Err(CameraError::Lens { problem })
    }
}

/// Error of a camera or projector that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CameraError {
    /// A coordinate is NaN or infinite.
    NonFinite,
    /// `eye` and `look` are the same point.
    EyeIsLook {
        /// The common point.
        eye: DVec3,
    },
    /// `up` is zero or parallel to the line of sight.
    UpParallel {
        /// The given `up`.
        up: DVec3,
    },
    /// The field of view is not inside (0, pi).
    FieldOfView {
        /// The given angle, radians.
        fov_x: f64,
    },
    /// A projected picture without width or height.
    Aspect {
        /// The given width over height.
        aspect: f64,
    },
    /// Not `0 < near < far`.
    NearFar {
        /// The given near distance.
        near: f64,
        /// The given far distance.
        far: f64,
    },
    /// The lens cannot be used, or not for this.
    Lens {
        /// The fault and the allowed values.
        problem: &'static str,
    },
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite => write!(f, "camera: eye, look and up must be finite numbers"),
            Self::Aspect { aspect } => write!(
                f,
                "camera: the width over height of a projected picture is {aspect}; it must be finite and above 0"
            ),
            Self::EyeIsLook { eye } => write!(
                f,
                "camera: eye and look are the same point ({}, {}, {})",
                eye.x, eye.y, eye.z
            ),
            Self::UpParallel { up } => {
                write!(
                    f,
                    "camera: up ({}, {}, {}) is zero or parallel to the line of sight",
                    up.x, up.y, up.z
                )
            }
            Self::FieldOfView { fov_x } => {
                write!(
                    f,
                    "camera: a field of view of {} degrees is not between 0 and 180",
                    fov_x.to_degrees()
                )
            }
            Self::NearFar { near, far } => write!(
                f,
                "camera: need 0 < near < far, got near {near} and far {far}"
            ),
            Self::Lens { problem } => write!(f, "camera: {problem}"),
        }
    }
}

impl core::error::Error for CameraError {}

/// Unit vectors of a viewer: to the right, up and forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) forward: DVec3,
}

impl Axes {
    pub(crate) fn new(eye: DVec3, look: DVec3, up: DVec3) -> Result<Self, CameraError> {
        if !(eye.is_finite() && look.is_finite() && up.is_finite()) {
            return Err(CameraError::NonFinite);
        }
        let forward = unit(look - eye).ok_or(CameraError::EyeIsLook { eye })?;
        let parallel = CameraError::UpParallel { up };
        let side = forward.cross(unit(up).ok_or(parallel)?);
        // Below 1e-9 radians the direction of `side` is rounding.
        if side.length_squared() < 1e-18 {
            return Err(parallel);
        }
        let right = unit(side).ok_or(parallel)?;
        Ok(Self {
            right,
            up: right.cross(forward),
            forward,
        })
    }
}

/// `v` over its length; scaled first, so that neither 1e-200 nor 1e200 is lost. None for zero and for a difference that overflowed.
fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v / largest;
    Some(v / v.length())
}

impl Camera {
    /// A camera at `eye` that looks at `look`, +Y up, with a horizontal field of view of 60 degrees. If it looks straight down or
    /// up, -Z is the picture's up. The near plane is at a thousandth of the distance, and there is no far plane. Vectors or
    /// arrays of three.
    #[must_use]
    pub fn look_at(eye: impl Into<DVec3>, look: impl Into<DVec3>) -> Self {
        let (eye, look) = (eye.into(), look.into());
        let along = look - eye;
        let upright = along.x != 0.0 || along.z != 0.0;
        Self {
            eye,
            look,
            up: if upright { DVec3::Y } else { DVec3::NEG_Z },
            fov_x: core::f64::consts::FRAC_PI_3,
            near: along.length() * 1e-3,
            far: f64::INFINITY,
            lens: Lens::default(),
        }
    }

    /// The matrix from world to view space.
    ///
    /// # Errors
    /// [`CameraError`] names what makes the camera unusable; all fields are checked.
    pub fn view(&self) -> Result<DMat4, CameraError> {
        let axes = self.axes()?;
        let (r, u, b) = (axes.right, axes.up, -axes.forward);
        Ok(DMat4::from_cols(
            DVec4::new(r.x, u.x, b.x, 0.0),
            DVec4::new(r.y, u.y, b.y, 0.0),
            DVec4::new(r.z, u.z, b.z, 0.0),
            DVec4::new(-r.dot(self.eye), -u.dot(self.eye), -b.dot(self.eye), 1.0),
        ))
    }

    /// The matrix from view to clip space for a picture of `aspect` = width / height in pixels. Clip w is the distance along the line
    /// of sight, or 1 in a parallel projection; clip z is w at the near plane and 0 at the far plane (or at infinity), so depth z/w
    /// is 1 near and 0 far.
    #[must_use]
    pub fn projection(&self, aspect: f64) -> DMat4 {
        let x = 1.0 / self.half_width(1.0);
        let y = x * aspect * self.lens.pixel_aspect;
        let [right, up] = self.lens.center;
        if self.lens.parallel_width.is_some() {
            let z = 1.0 / (self.far - self.near);
            return DMat4::from_cols(
                DVec4::new(x, 0.0, 0.0, 0.0),
                DVec4::new(0.0, y, 0.0, 0.0),
                DVec4::new(0.0, 0.0, z, 0.0),
                DVec4::new(right, up, z * self.far, 1.0),
            );
        }
        let (z, t) = if self.far.is_finite() {
            let z = self.near / (self.far - self.near);
            (z, z * self.far)
        } else {
            (0.0, self.near)
        };
        DMat4::from_cols(
            DVec4::new(x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, y, 0.0, 0.0),
            DVec4::new(0.0 - right, 0.0 - up, z, -1.0),
            DVec4::new(0.0, 0.0, t, 0.0),
        )
    }

    /// Half the width of what the picture shows, world units, at a distance from the eye along the line of sight.
    #[must_use]
    pub fn half_width(&self, distance: f64) -> f64 {
        match self.lens.parallel_width {
            Some(width) => 0.5 * width,
            None => deterministic_f64::tan(0.5 * self.fov_x) * distance,
        }
    }

    /// The point that light must reach to be seen: the eye, or, in a parallel projection, a point so far behind it that directions to
    /// it differ by a millionth over what is seen.
    #[must_use]
    pub fn viewpoint(&self) -> DVec3 {
        match self.lens.parallel_width {
            None => self.eye,
            Some(width) => {
                let back = (self.eye - self.look).normalize_or_zero();
                self.eye + back * (1_048_576.0 * (width + self.far.min(1e30)))
            }
        }
    }

    /// The matrix from world to clip space.
    ///
    /// # Errors
    /// As [`Camera::view`].
    pub fn clip_from_world(&self, aspect: f64) -> Result<DMat4, CameraError> {
        Ok(self.projection(aspect) * self.view()?)
    }

    /// World direction, not normalised, from the eye through the picture position (`x`, `y`) in pixels: y grows downwards, 0.5 is the
    /// centre of the first pixel. Its component along the line of sight is 1.
    ///
    /// # Errors
    /// As [`Camera::view`]; [`CameraError::Lens`] for a parallel projection, whose rays do not meet in the eye.
    pub fn ray(&self, width: u32, height: u32, x: f64, y: f64) -> Result<DVec3, CameraError> {
        let axes = self.axes()?;
        if self.lens.parallel_width.is_some() {
            let problem = "a parallel projection has no rays from one eye: use a central one";
            return Err(CameraError::Lens { problem });
        }
        let (width, height) = (f64::from(width), f64::from(height));
        let tan = deterministic_f64::tan(0.5 * self.fov_x);
        let [cx, cy] = self.lens.center;
        let right = tan * (2.0 * x / width - 1.0 - cx);
        let up = tan * ((1.0 - cy) * height - 2.0 * y) / (width * self.lens.pixel_aspect);
        Ok(axes.forward + axes.right * right + axes.up * up)
    }

    fn axes(&self) -> Result<Axes, CameraError> {
        let axes = Axes::new(self.eye, self.look, self.up)?;
        check_fov(self.fov_x)?;
        self.lens.check(self.far)?;
        if !(self.near > 0.0 && self.near < self.far && self.near.is_finite()) {
            return Err(CameraError::NearFar {
                near: self.near,
                far: self.far,
            });
        }
        Ok(axes)
    }
}

pub(crate) fn check_fov(fov_x: f64) -> Result<(), CameraError> {
    if fov_x > 0.0 && fov_x < core::f64::consts::PI {
        Ok(())
    } else {
        Err(CameraError::FieldOfView { fov_x })
    }
}
