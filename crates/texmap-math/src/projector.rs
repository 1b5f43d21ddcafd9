//! Projector: maps a world point to a point of its picture, homogeneously. Source: MIT 6.837, lecture 18, slides 21 to 25,
//! here with the picture's true aspect.

use glam::{DVec2, DVec3, DVec4};

use crate::camera::{Axes, CameraError, check_fov};
use crate::deterministic_f64;

/// A projector. It maps a world point X to `(q, s, t)`; the picture coordinates are `(q/t, s/t)`, (0, 0) at the picture's top
/// left and (1, 1) at its bottom right, v downwards; `t` is the distance along the line of projection, so `t <= 0` is behind the
/// projector.
///
/// Interpolate q, s, t like any attribute (times 1/w of the *eye's* camera) and divide last: the eye's w cancels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projector {
    /// Row of q.
    pub q: DVec4,
    /// Row of s.
    pub s: DVec4,
    /// Row of t.
    pub t: DVec4,
}

impl Projector {
    /// A projector at `eye` that points at `look`. The horizontal field of view is in radians; `aspect` is the picture's width /
    /// height.
    ///
    /// # Errors
    /// [`CameraError`], as for a camera.
    pub fn new(
        eye: DVec3,
        look: DVec3,
        up: DVec3,
        fov_x: f64,
        aspect: f64,
    ) -> Result<Self, CameraError> {
        let axes = Axes::new(eye, look, up)?;
        check_fov(fov_x)?;
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(CameraError::Aspect { aspect });
        }
        let focal = 0.5 / deterministic_f64::tan(0.5 * fov_x);
        let half = axes.forward * 0.5;
        let row = |n: DVec3| n.extend(-n.dot(eye));
        Ok(Self {
            q: row(axes.right * focal + half),
            s: row(axes.up * (-focal * aspect) + half),
            t: row(axes.forward),
        })
    }

    /// The three rows q, s, t.
    #[must_use]
    pub const fn rows(&self) -> [DVec4; 3] {
        [self.q, self.s, self.t]
    }

    /// `(q, s, t)` of a world point.
    #[must_use]
    pub fn project(&self, point: DVec3) -> DVec3 {
        let p = point.extend(1.0);
        DVec3::new(self.q.dot(p), self.s.dot(p), self.t.dot(p))
    }

    /// Picture coordinates of a world point, `None` if it is not in front of the projector. They may lie outside `[0, 1]`.
    #[must_use]
    pub fn uv(&self, point: DVec3) -> Option<DVec2> {
        projector_uv(self.project(point))
    }
}

/// `(q/t, s/t)`, None for `t <= 0` or NaN: nothing behind a projector is lit.
#[must_use]
pub fn projector_uv(qst: DVec3) -> Option<DVec2> {
    let uv = DVec2::new(qst.x / qst.z, qst.y / qst.z);
    (qst.z > 0.0 && uv.is_finite()).then_some(uv)
}
