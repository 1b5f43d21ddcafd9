//! The truth of a frame: one ray through each pixel centre, in f64.
//!
//! A ray `eye + t d` meets the plane of a triangle where `t d = b0 (P0 - eye) + b1 (P1 - eye) + b2 (P2 - eye)`
//! with `b0 + b1 + b2 = 1`. For a fixed triangle the solution `g = M^-1 d`, `M = [P0 - eye, P1 - eye,
//! P2 - eye]`, is linear in `d`; `b = g / sum(g)` and `t = 1 / sum(g)`. That is the exact homography between
//! the screen and the triangle (Heckbert 1989, section 2.2; Olano and Greer 1997): no vertex is projected,
//! nothing is clipped or snapped, and a triangle that passes through the eye's plane needs no care.

use texmap_math::camera::{Camera, CameraError};
use texmap_math::glam::{DMat3, DVec2, DVec3};

/// A pinhole: the ray through position (x, y) of the picture has the direction `corner + x * right + y * down`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Origin of all rays.
    pub eye: DVec3,
    /// Direction through the top left corner of the picture, position (0, 0).
    pub corner: DVec3,
    /// Change of the direction for one pixel to the right.
    pub right: DVec3,
    /// Change of the direction for one pixel down.
    pub down: DVec3,
}

impl Pinhole {
    /// The rays of a camera for a picture of `width` by `height` pixels. Their component along the line of
    /// sight is 1, so that [`Hit::t`] is the clip w of the point met.
    ///
    /// # Errors
    /// If the camera has no view.
    pub fn of_camera(camera: &Camera, width: u32, height: u32) -> Result<Self, CameraError> {
        let (columns, rows) = (f64::from(width), f64::from(height));
        let corner = camera.ray(width, height, 0.0, 0.0)?;
        let right = (camera.ray(width, height, columns, 0.0)? - corner) / columns;
        let down = (camera.ray(width, height, 0.0, rows)? - corner) / rows;
        Ok(Self {
            eye: camera.eye,
            corner,
            right,
            down,
        })
    }

    /// Direction through position (x, y); a pixel centre has the fraction 0.5.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        self.corner + self.right * x + self.down * y
    }

    /// The hit of the ray through position (x, y) on a triangle given by its corners, at a positive distance. Its number is 0.
    pub fn meet(&self, x: f64, y: f64, corners: &[DVec3; 3]) -> Option<Hit> {
        let inverse = inverse(self, corners)?;
        self.through(&inverse, self.direction(x, y), 0)
    }

    /// The hit of a triangle of which the inverse of `[P0 - eye, P1 - eye, P2 - eye]` is known.
    fn through(&self, inverse: &DMat3, direction: DVec3, triangle: u32) -> Option<Hit> {
        let g = *inverse * direction;
        if !(g.x >= 0.0 && g.y >= 0.0 && g.z >= 0.0) {
            return None;
        }
        let sum = g.element_sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return None;
        }
        let weights = g / sum;
        let change = |step: DVec3| {
            let dg = *inverse * step;
            (dg - weights * dg.element_sum()) / sum
        };
        Some(Hit {
            triangle,
            weights,
            d_dx: change(self.right),
            d_dy: change(self.down),
            t: 1.0 / sum,
            front: inverse.determinant() < 0.0,
        })
    }
}

/// A triangle as seen from a pinhole.
#[derive(Clone, Copy, Debug)]
struct Lens {
    inverse: DMat3,
    /// Pixels that may see the triangle: columns and rows, exclusive at the end.
    columns: (u32, u32),
    rows: (u32, u32),
}

/// The hit of a ray on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentrics in space; they sum to 1.
    pub weights: DVec3,
    /// Change of the barycentrics for one pixel to the right.
    pub d_dx: DVec3,
    /// Change of the barycentrics for one pixel down.
    pub d_dy: DVec3,
    /// Distance along the ray in units of its direction's length.
    pub t: f64,
    /// The triangle is seen counter-clockwise.
    pub front: bool,
}

impl Hit {
    /// The attribute of the hit from its values at the three vertices.
    pub fn attribute(&self, at: [f64; 3]) -> f64 {
        self.weights.dot(DVec3::from_array(at))
    }

    /// A vector of the hit from its values at the three vertices.
    pub fn vector(&self, at: [DVec3; 3]) -> DVec3 {
        at[0] * self.weights.x + at[1] * self.weights.y + at[2] * self.weights.z
    }

    /// Change of a vector for one pixel to the right and for one pixel down.
    pub fn vector_changes(&self, at: [DVec3; 3]) -> [DVec3; 2] {
        [self.d_dx, self.d_dy].map(|d| at[0] * d.x + at[1] * d.y + at[2] * d.z)
    }

    /// Change of an attribute for one pixel to the right and for one pixel down.
    pub fn derivative(&self, at: [f64; 3]) -> DVec2 {
        let at = DVec3::from_array(at);
        DVec2::new(self.d_dx.dot(at), self.d_dy.dot(at))
    }
}

/// Triangles ready to be met by the rays of one picture.
#[derive(Clone, Debug)]
pub struct Caster {
    pinhole: Pinhole,
    lenses: Vec<Option<Lens>>,
}

impl Caster {
    /// Prepares triangles given by their corners. A triangle whose plane holds the eye, or that has a value
    /// that is not finite, is seen by no ray.
    pub fn new(pinhole: Pinhole, width: u32, height: u32, triangles: &[[DVec3; 3]]) -> Self {
        let lenses = triangles
            .iter()
            .map(|t| lens(&pinhole, width, height, t))
            .collect();
        Self { pinhole, lenses }
    }

    /// Every triangle met by the ray through position (x, y) at a positive distance, in the triangles' order.
    pub fn hits(&self, x: f64, y: f64) -> impl Iterator<Item = Hit> {
        let direction = self.pinhole.direction(x, y);
        let within =
            move |(from, to): (u32, u32), at: f64| at >= f64::from(from) && at <= f64::from(to);
        self.lenses
            .iter()
            .enumerate()
            .filter_map(move |(index, lens)| {
                let lens = lens
                    .as_ref()
                    .filter(|l| within(l.columns, x) && within(l.rows, y))?;
                self.pinhole.through(&lens.inverse, direction, index as u32)
            })
    }

    /// The nearest triangle met; among equals the first, or the last when `later_wins`.
    pub fn nearest(&self, x: f64, y: f64, later_wins: bool) -> Option<Hit> {
        self.hits(x, y).reduce(|best, hit| {
            let takes = if later_wins {
                hit.t <= best.t
            } else {
                hit.t < best.t
            };
            if takes { hit } else { best }
        })
    }
}

fn lens(pinhole: &Pinhole, width: u32, height: u32, corners: &[DVec3; 3]) -> Option<Lens> {
    let [a, b, c] = corners.map(|p| p - pinhole.eye);
    let inverse = inverse(pinhole, corners)?;
    let view = DMat3::from_cols(pinhole.right, pinhole.down, pinhole.corner).inverse();
    let (mut columns, mut rows) = ((0, width), (0, height));
    // The screen box of a triangle in front of the eye; any other may show anywhere.
    let screen = [a, b, c].map(|p| view * p);
    if screen.iter().all(|p| p.z > 1e-9 * p.length()) {
        let at = screen.map(|p| (p.x / p.z, p.y / p.z));
        columns = span(at.map(|p| p.0), width);
        rows = span(at.map(|p| p.1), height);
    }
    Some(Lens {
        inverse,
        columns,
        rows,
    })
}

/// The inverse of `[P0 - eye, P1 - eye, P2 - eye]`. None for a plane that holds the eye or a corner that is not finite.
fn inverse(pinhole: &Pinhole, corners: &[DVec3; 3]) -> Option<DMat3> {
    let [a, b, c] = corners.map(|p| p - pinhole.eye);
    let inverse = DMat3::from_cols(a, b, c).inverse();
    inverse.is_finite().then_some(inverse)
}

/// The pixels of 0..size that three positions span, one more on each side.
fn span(at: [f64; 3], size: u32) -> (u32, u32) {
    let low = at[0].min(at[1]).min(at[2]);
    let high = at[0].max(at[1]).max(at[2]);
    let cut = |v: f64| v.clamp(0.0, f64::from(size)) as u32;
    (cut(low.floor() - 1.0), cut(high.ceil() + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eye at the origin, looking along -z, one unit of direction across 100 pixels.
    fn pinhole() -> Pinhole {
        Pinhole {
            eye: DVec3::ZERO,
            corner: DVec3::new(-0.5, 0.5, -1.0),
            right: DVec3::X * 0.01,
            down: DVec3::NEG_Y * 0.01,
        }
    }

    fn slope(z: impl Fn(f64) -> f64) -> [DVec3; 3] {
        [
            DVec3::new(-9.0, -9.0, z(-9.0)),
            DVec3::new(9.0, -9.0, z(9.0)),
            DVec3::new(0.0, 9.0, z(0.0)),
        ]
    }

    #[test]
    fn a_hit_lies_on_the_ray_and_in_the_triangle() {
        let triangle = slope(|x| -3.0 + 0.2 * x);
        let caster = Caster::new(pinhole(), 100, 100, &[triangle]);
        let hit = caster.nearest(31.5, 62.5, false).unwrap();
        let point: DVec3 = (0..3).map(|i| triangle[i] * hit.weights[i]).sum();
        assert!((point - pinhole().direction(31.5, 62.5) * hit.t).length() < 1e-12);
        assert!((hit.weights.element_sum() - 1.0).abs() < 1e-15);
        assert!(hit.front);
    }

    #[test]
    fn derivatives_are_the_central_difference() {
        let caster = Caster::new(pinhole(), 100, 100, &[slope(|x| -3.0 + 0.3 * x)]);
        let u = [0.0, 7.0, 3.0];
        let at = |x, y| caster.nearest(x, y, false).unwrap();
        let h = 1e-4;
        let dx = (at(40.5 + h, 50.5).attribute(u) - at(40.5 - h, 50.5).attribute(u)) / (2.0 * h);
        let dy = (at(40.5, 50.5 + h).attribute(u) - at(40.5, 50.5 - h).attribute(u)) / (2.0 * h);
        assert!((at(40.5, 50.5).derivative(u) - DVec2::new(dx, dy)).length() < 1e-8);
    }

    #[test]
    fn nearest_wins_and_ties_go_by_the_rule() {
        let far = slope(|_| -4.0);
        let near = slope(|_| -2.0);
        let caster = Caster::new(pinhole(), 100, 100, &[far, near, near]);
        assert_eq!(caster.nearest(50.5, 50.5, false).unwrap().triangle, 1);
        assert_eq!(caster.nearest(50.5, 50.5, true).unwrap().triangle, 2);
        assert_eq!(caster.hits(50.5, 50.5).count(), 3);
    }

    #[test]
    fn a_triangle_through_the_eyes_plane_is_seen_only_in_front() {
        let floor = [
            DVec3::new(-50.0, -1.0, 60.0),
            DVec3::new(50.0, -1.0, 60.0),
            DVec3::new(0.0, -1.0, -200.0),
        ];
        let caster = Caster::new(pinhole(), 100, 100, &[floor]);
        assert!(
            caster.nearest(50.5, 10.5, false).is_none(),
            "above the horizon"
        );
        let hit = caster.nearest(50.5, 90.5, false).unwrap();
        assert!((hit.t - 1.0 / 0.405).abs() < 1e-12);
    }

    #[test]
    fn edge_on_behind_and_nan_triangles_are_not_seen() {
        let edge_on = [
            DVec3::new(0.0, -1.0, -2.0),
            DVec3::new(0.0, 1.0, -2.0),
            DVec3::new(0.0, 0.0, -5.0),
        ];
        let behind = slope(|_| 4.0);
        let nan = [DVec3::NAN; 3];
        let caster = Caster::new(pinhole(), 100, 100, &[edge_on, behind, nan]);
        assert_eq!(caster.hits(50.5, 50.5).count(), 0);
    }
}
