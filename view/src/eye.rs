//! The eye: it orbits the point that it looks at, and walks.

use minifb::{Key, Window};
use texmap_math::camera::Camera;
use texmap_math::deterministic_f64::sin_cos;
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

/// Position, aim and up of the camera, and its first state.
#[derive(Clone, Debug)]
pub(crate) struct Eye {
    first: Camera,
    eye: DVec3,
    look: DVec3,
    up: DVec3,
}

impl Eye {
    pub(crate) fn of(camera: &Camera) -> Self {
        Self {
            first: *camera,
            eye: camera.eye,
            look: camera.look,
            up: camera.up.normalize_or(DVec3::Y),
        }
    }

    pub(crate) fn set(&self, scene: &mut Scene) {
        (scene.camera.eye, scene.camera.look) = (self.eye, self.look);
    }

    /// Back to the first view.
    pub(crate) fn home(&mut self) {
        *self = Self::of(&self.first);
    }

    /// The camera of a file that was read again is the first view from now on, and the present one if it changed and `show` is set.
    pub(crate) fn again(&mut self, camera: &Camera, show: bool) {
        if show && *camera != self.first {
            *self = Self::of(camera);
        } else {
            self.first = *camera;
        }
    }

    /// Turns about the point that is looked at, degrees; the pole is not passed.
    pub(crate) fn orbit(&mut self, around: f64, upwards: f64) {
        let away = self.eye - self.look;
        let away = turned(away, self.up, around);
        let across = away.cross(self.up).normalize_or_zero();
        let raised = turned(away, across, -upwards);
        // Steeper than 87 degrees the picture would spin.
        let steep = raised.normalize_or_zero().dot(self.up).abs() > 0.9986;
        let away = if steep { away } else { raised };
        self.eye = self.look + away;
    }

    /// Nearer or farther by a part of the distance.
    pub(crate) fn zoom(&mut self, part: f64) {
        self.eye = self.look + (self.eye - self.look) * (1.0 + part);
    }

    /// Moves eye and aim by a part of their distance.
    fn walk(&mut self, ahead: f64, right: f64, upwards: f64) {
        let way = self.look - self.eye;
        let across = way.cross(self.up).normalize_or_zero();
        let by =
            (way.normalize_or_zero() * ahead + across * right + self.up * upwards) * way.length();
        self.eye += by;
        self.look += by;
    }

    /// The keys that are held; true if one moved the eye.
    pub(crate) fn keys(&mut self, window: &Window) -> bool {
        const WALK: [(Key, [f64; 3]); 6] = [
            (Key::W, [1.0, 0.0, 0.0]),
            (Key::S, [-1.0, 0.0, 0.0]),
            (Key::D, [0.0, 1.0, 0.0]),
            (Key::A, [0.0, -1.0, 0.0]),
            (Key::E, [0.0, 0.0, 1.0]),
            (Key::Q, [0.0, 0.0, -1.0]),
        ];
        const ORBIT: [(Key, [f64; 2]); 4] = [
            (Key::Left, [-2.0, 0.0]),
            (Key::Right, [2.0, 0.0]),
            (Key::Up, [0.0, 2.0]),
            (Key::Down, [0.0, -2.0]),
        ];
        let mut moved = false;
        for (_, [ahead, right, upwards]) in WALK.iter().filter(|(key, _)| window.is_key_down(*key))
        {
            self.walk(0.02 * ahead, 0.02 * right, 0.02 * upwards);
            moved = true;
        }
        for (_, [around, upwards]) in ORBIT.iter().filter(|(key, _)| window.is_key_down(*key)) {
            self.orbit(*around, *upwards);
            moved = true;
        }
        for (key, part) in [
            (Key::Equal, -0.02),
            (Key::NumPadPlus, -0.02),
            (Key::Minus, 0.02),
            (Key::NumPadMinus, 0.02),
        ] {
            if window.is_key_down(key) {
                self.zoom(part);
                moved = true;
            }
        }
        moved
    }

    /// Frame `count` of the fixed walk: once around in 120 frames, a little up and down.
    pub(crate) fn script(&mut self, count: u32) {
        let (sin, _) = sin_cos(f64::from(count) / 60.0 * std::f64::consts::TAU);
        self.home();
        self.orbit(3.0 * f64::from(count), 6.0 * sin);
    }
}

/// A vector turned about a unit axis, counter-clockwise when the axis points at the viewer (Rodrigues).
fn turned(v: DVec3, axis: DVec3, degrees: f64) -> DVec3 {
    let (sin, cos) = sin_cos(degrees.to_radians());
    v * cos + axis.cross(v) * sin + axis * axis.dot(v) * (1.0 - cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbits_keep_the_distance_and_stop_before_the_pole() {
        let camera = Camera::look_at([0.0, 1.0, 4.0], [0.0, 1.0, 0.0]);
        let mut eye = Eye::of(&camera);
        eye.orbit(90.0, 0.0);
        assert!((eye.eye - DVec3::new(4.0, 1.0, 0.0)).length() < 1e-12);
        for _ in 0..100 {
            eye.orbit(1.0, 2.0);
        }
        assert!(((eye.eye - eye.look).length() - 4.0).abs() < 1e-9);
        assert!((eye.eye - eye.look).normalize().dot(DVec3::Y) < 0.9986);
        let turned = eye.eye;
        eye.again(&camera, true);
        assert_eq!(eye.eye, turned);
        eye.home();
        assert_eq!(eye.eye, camera.eye);
        let other = Camera::look_at([2.0, 0.0, 0.0], [0.0; 3]);
        eye.again(&other, true);
        assert_eq!(eye.eye, other.eye);
    }
}
