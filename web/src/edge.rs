//! One edge seen from the side: equal steps on the screen against equal steps along the edge, and the curve s(t) (MIT 6.837,
//! lecture 18, slides 6 to 11).

use serde::Deserialize;
use texmap_math::affine_error::{error_at, max_error, max_error_at};
use texmap_math::interpolation::world_from_screen_z;
use texmap_truth::picture::Picture;

use crate::answer::Answer;
use crate::plot::{INK, PAPER, Plot, RIGHT, SOFT, WRONG};

/// An edge from (x1, z1) to (x2, z2) before an eye at the origin; the screen lies at z = 1.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Edge {
    size: [u32; 2],
    x1: f64,
    z1: f64,
    x2: f64,
    z2: f64,
    /// Fraction of the way over the screen, 0 to 1.
    t: f64,
    /// Equal steps on the screen.
    steps: u32,
}

/// Places at which the largest error is looked for.
const SAMPLES: u32 = 20_000;

impl Edge {
    pub(crate) fn answer(&self) -> Answer {
        let (z1, z2) = (self.z1.max(0.05), self.z2.max(0.05));
        let s = |t: f64| world_from_screen_z(t, z1, z2);
        let mut answer = Answer::default();
        answer.picture("the edge from the side, and s(t)", &self.picture(z1, z2));
        // s(t) = t w2 / (w1 + t (w2 - w1)): with w = 1/z the ratio of the closed forms is w2/w1 = z1/z2.
        let ratio = z1 / z2;
        let t = self.t.clamp(0.0, 1.0);
        let places = (0..=SAMPLES).map(|i| f64::from(i) / f64::from(SAMPLES));
        let measured = places.map(|t| (s(t) - t).abs()).fold(0.0, f64::max);
        answer.figure("s(t)", s(t), "");
        answer.expected("s(t) - t", s(t) - t, error_at(t, ratio), "");
        answer.expected("largest |s(t) - t|", measured, max_error(ratio), "");
        answer.figure("at t", max_error_at(ratio), "");
        answer
    }

    fn picture(&self, z1: f64, z2: f64) -> Picture {
        let [width, height] = self.size.map(|n| n.clamp(64, 2048));
        let mut picture = Picture::new(width, height, PAPER);
        let (w, h) = (f64::from(width), f64::from(height));
        let side = h.min(w / 2.0) - 40.0;
        let far = z1.max(z2).max(1.5) * 1.08;
        // Depth runs to the right, x upwards, one scale for both.
        let scene = Plot {
            place: [20.0, 20.0, w - side - 60.0, h - 40.0],
            view: [
                0.0,
                -far * (h - 40.0) / (w - side - 60.0) / 2.0,
                far,
                far * (h - 40.0) / (w - side - 60.0) / 2.0,
            ],
        };
        let (x1, x2) = (self.x1, self.x2);
        let s = |t: f64| world_from_screen_z(t, z1, z2);
        let (top, bottom) = (scene.view[3], scene.view[1]);
        scene.line(&mut picture, [1.0, bottom], [1.0, top], SOFT, 1);
        let steps = self.steps.clamp(1, 64);
        for i in 0..=steps {
            let t = f64::from(i) / f64::from(steps);
            let s = s(t);
            let (x, z) = (x1 + s * (x2 - x1), z1 + s * (z2 - z1));
            scene.line(&mut picture, [0.0, 0.0], [z, x], SOFT, 1);
        }
        scene.line(&mut picture, [z1, x1], [z2, x2], INK, 3);
        for i in 0..=steps {
            let t = f64::from(i) / f64::from(steps);
            let on_screen = x1 / z1 + t * (x2 / z2 - x1 / z1);
            scene.dot(&mut picture, [1.0, on_screen], 2, INK);
            for (part, color) in [(t, WRONG), (s(t), RIGHT)] {
                scene.dot(
                    &mut picture,
                    [z1 + part * (z2 - z1), x1 + part * (x2 - x1)],
                    3,
                    color,
                );
            }
        }
        scene.dot(&mut picture, [0.0, 0.0], 4, INK);
        let (x, y) = scene.at(1.0, top);
        picture.text(x + 4, y + 2, 1, INK, "z = 1");

        let curve = Plot {
            place: [w - side - 20.0, 20.0, side, side],
            view: [0.0, 0.0, 1.0, 1.0],
        };
        curve.frame(&mut picture, SOFT);
        curve.line(&mut picture, [0.0, 0.0], [1.0, 1.0], WRONG, 2);
        curve.curve(&mut picture, RIGHT, s);
        let t = self.t.clamp(0.0, 1.0);
        curve.line(&mut picture, [t, 0.0], [t, s(t)], SOFT, 1);
        curve.line(&mut picture, [0.0, s(t)], [t, s(t)], SOFT, 1);
        curve.dot(&mut picture, [t, s(t)], 4, RIGHT);
        curve.dot(&mut picture, [t, t], 4, WRONG);
        let worst = max_error_at(z1 / z2);
        curve.line(&mut picture, [worst, worst], [worst, s(worst)], INK, 1);
        let (x, y) = curve.at(0.0, 0.0);
        picture.text(x, y + 3, 1, INK, "t");
        let (x, y) = curve.at(0.0, 1.0);
        picture.text(x + 4, y + 2, 1, INK, "s");
        picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The measured figures agree with their closed forms, and an edge of equal depths has no error.
    #[test]
    fn the_largest_error_is_the_closed_form() {
        let edge = |z2| Edge {
            size: [320, 200],
            x1: -0.5,
            z1: 1.0,
            x2: 1.0,
            z2,
            t: 0.5,
            steps: 8,
        };
        let worst = |z2| edge(z2).answer().figures[2].clone();
        let figure = worst(4.0);
        assert!((figure.value - 1.0 / 3.0).abs() < 1e-6);
        assert!((figure.value - figure.expected.unwrap()).abs() < 1e-6);
        assert!(worst(1.0).value < 1e-12);
    }
}
