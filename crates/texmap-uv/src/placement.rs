//! The manipulator of a modelling tool: where a unit solid stands around the object.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat3, DVec3};

use crate::UvError;

/// Position, orientation and size of a unit solid in object space.
///
/// A point of the solid is scaled, rolled about z, pitched about x, yawed about y and moved, in that order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Middle of the solid, in object units.
    pub position: DVec3,
    /// Turn about y, radians.
    pub yaw: f64,
    /// Turn about x, radians.
    pub pitch: f64,
    /// Turn about z, radians.
    pub roll: f64,
    /// Edge lengths of the solid, in object units; none is zero.
    pub scale: DVec3,
}

impl Placement {
    /// A solid that stands upright.
    #[must_use]
    pub fn upright(position: DVec3, scale: DVec3) -> Self {
        Self {
            position,
            yaw: 0.0,
            pitch: 0.0,
            roll: 0.0,
            scale,
        }
    }

    pub(crate) fn placed(&self) -> Result<PlacedFrame, UvError> {
        let all = [
            self.position.to_array(),
            [self.yaw, self.pitch, self.roll],
            self.scale.to_array(),
        ];
        if let Some(value) = all.as_flattened().iter().find(|v| !v.is_finite()) {
            return Err(UvError::BadFrame { value: *value });
        }
        if let Some(value) = self
            .scale
            .to_array()
            .iter()
            .find(|s| (1.0 / **s).is_infinite())
        {
            return Err(UvError::BadFrame { value: *value });
        }
        let ((sy, cy), (sx, cx), (sz, cz)) = (
            deterministic_f64::sin_cos(self.yaw),
            deterministic_f64::sin_cos(self.pitch),
            deterministic_f64::sin_cos(self.roll),
        );
        let yaw = DMat3::from_cols_array_2d(&[[cy, 0.0, -sy], [0.0, 1.0, 0.0], [sy, 0.0, cy]]);
        let pitch = DMat3::from_cols_array_2d(&[[1.0, 0.0, 0.0], [0.0, cx, sx], [0.0, -sx, cx]]);
        let roll = DMat3::from_cols_array_2d(&[[cz, sz, 0.0], [-sz, cz, 0.0], [0.0, 0.0, 1.0]]);
        Ok(PlacedFrame {
            origin: self.position,
            rotation: yaw * pitch * roll,
            size: self.scale,
            flat: [false; 3],
        })
    }
}

/// A frame ready for use; `flat` axes have no extent and map to the middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedFrame {
    pub(crate) origin: DVec3,
    pub(crate) rotation: DMat3,
    pub(crate) size: DVec3,
    pub(crate) flat: [bool; 3],
}

impl PlacedFrame {
    /// A frame fitted to an object; an axis without extent becomes flat.
    pub(crate) fn fitted(origin: DVec3, size: DVec3, rotation: DMat3) -> Self {
        let flat = size.to_array().map(|s| s <= 0.0);
        let size = DVec3::from(core::array::from_fn(
            |i| if flat[i] { 1.0 } else { size[i] },
        ));
        Self {
            origin,
            rotation,
            size,
            flat,
        }
    }

    /// A point of object space in the space of the unit solid.
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.direction(p - self.origin)
    }

    /// A difference of points in the space of the unit solid.
    pub(crate) fn direction(&self, d: DVec3) -> DVec3 {
        let d = self.turn(d) / self.size;
        DVec3::from(core::array::from_fn(
            |i| if self.flat[i] { 0.0 } else { d[i] },
        ))
    }

    /// A direction turned, not scaled.
    pub(crate) fn turn(&self, d: DVec3) -> DVec3 {
        self.rotation.transpose() * d
    }

    /// A normal (not of unit length) in the space of the unit solid: by the inverse transpose of the frame.
    pub(crate) fn normal(&self, n: DVec3) -> DVec3 {
        self.turn(n) * self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_turn_about_their_axes_in_the_stated_order() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let frame = Placement {
            yaw: quarter,
            ..Placement::upright(DVec3::new(1.0, 2.0, 3.0), DVec3::splat(2.0))
        };
        let placed = frame.placed().unwrap();
        // A quarter turn about y brings the solid's +Z to +X.
        let p = placed.point(DVec3::new(2.0, 2.0, 3.0));
        assert!(
            (p - DVec3::new(0.0, 0.0, 0.5)).abs().max_element() < 1e-15,
            "{p}"
        );
        let tilted = Placement {
            pitch: quarter,
            roll: quarter,
            ..frame
        };
        let placed = tilted.placed().unwrap();
        // Roll brings x to y, pitch that y to z, yaw that z to x.
        let p = placed.point(DVec3::new(2.0, 2.0, 3.0));
        assert!(
            (p - DVec3::new(0.5, 0.0, 0.0)).abs().max_element() < 1e-15,
            "{p}"
        );
    }

    #[test]
    fn zero_and_infinite_sizes_are_refused() {
        for scale in [0.0, -0.0, f64::NAN, f64::INFINITY, 1e-320] {
            let frame = Placement::upright(DVec3::ZERO, DVec3::new(1.0, scale, 1.0));
            assert!(
                matches!(frame.placed(), Err(UvError::BadFrame { .. })),
                "{scale}"
            );
        }
        let mirrored = Placement::upright(DVec3::ZERO, DVec3::new(-1.0, 1.0, 1.0));
        assert!(mirrored.placed().is_ok());
    }
}
