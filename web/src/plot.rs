//! Axes in a picture: from the plane of a figure to its pixels.

use texmap_truth::picture::{Picture, Rgba};

pub(crate) const PAPER: Rgba = [250, 249, 246, 255];
pub(crate) const INK: Rgba = [38, 40, 48, 255];
pub(crate) const SOFT: Rgba = [150, 152, 160, 255];
pub(crate) const RIGHT: Rgba = [24, 110, 190, 255];
pub(crate) const WRONG: Rgba = [206, 60, 50, 255];

/// A rectangle of a picture that shows a rectangle of the plane, y upwards.
pub(crate) struct Plot {
    /// Left, top, width, height in pixels.
    pub(crate) place: [f64; 4],
    /// Least x, least y, largest x, largest y.
    pub(crate) view: [f64; 4],
}

impl Plot {
    /// The pixel of a point.
    pub(crate) fn at(&self, x: f64, y: f64) -> (i64, i64) {
        let [left, top, width, height] = self.place;
        let [x0, y0, x1, y1] = self.view;
        let px = left + (x - x0) / (x1 - x0) * width;
        let py = top + (y1 - y) / (y1 - y0) * height;
        (px.round() as i64, py.round() as i64)
    }

    /// A line of some thickness, pixels.
    pub(crate) fn line(
        &self,
        picture: &mut Picture,
        from: [f64; 2],
        to: [f64; 2],
        color: Rgba,
        thick: i64,
    ) {
        let (a, b) = (self.at(from[0], from[1]), self.at(to[0], to[1]));
        let steep = (b.1 - a.1).abs() > (b.0 - a.0).abs();
        for k in 0..thick {
            let k = k - thick / 2;
            let (dx, dy) = if steep { (k, 0) } else { (0, k) };
            picture.line((a.0 + dx, a.1 + dy), (b.0 + dx, b.1 + dy), color);
        }
    }

    /// A curve through y(x) over the whole width.
    pub(crate) fn curve(&self, picture: &mut Picture, color: Rgba, y: impl Fn(f64) -> f64) {
        let [x0, _, x1, _] = self.view;
        let steps = self.place[2] as usize;
        let x = |i: usize| x0 + (x1 - x0) * i as f64 / steps.max(1) as f64;
        for i in 0..steps {
            let (a, b) = (x(i), x(i + 1));
            self.line(picture, [a, y(a)], [b, y(b)], color, 2);
        }
    }

    /// A square dot of `2 r + 1` pixels.
    pub(crate) fn dot(&self, picture: &mut Picture, at: [f64; 2], r: i64, color: Rgba) {
        let (x, y) = self.at(at[0], at[1]);
        let side = (2 * r + 1) as u32;
        picture.fill(x - r, y - r, side, side, color);
    }

    /// The rectangle's frame.
    pub(crate) fn frame(&self, picture: &mut Picture, color: Rgba) {
        let [left, top, width, height] = self.place.map(f64::round);
        picture.frame(
            left as i64,
            top as i64,
            width as u32 + 1,
            height as u32 + 1,
            color,
        );
    }
}
