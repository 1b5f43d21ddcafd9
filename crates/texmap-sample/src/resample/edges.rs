use texmap_math::glam::{DMat3, DVec2, DVec3};

/// The image of a rectangle under a homography, as the four half planes of the output that its sides bound.
///
/// A point maps to (X/Z, Y/Z) of the source, with X, Y and Z linear in the output's coordinates: where Z is above 0, `X >= 0` and
/// `width Z - X >= 0` are the left and right sides. Both together leave no point with Z below 0, so that the horizon needs no side of its
/// own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edges([DVec3; 4]);

impl Edges {
    /// `source_from_output` takes the visible side of the horizon to Z above 0.
    pub(super) fn new(source_from_output: &DMat3, size: DVec2) -> Self {
        let rows = source_from_output.transpose();
        let (x, y, z) = (rows.x_axis, rows.y_axis, rows.z_axis);
        Self([x, z * size.x - x, y, z * size.y - y])
    }

    /// The area of the image in the unit square around a position, and the middle of that area. Without area, the middle of the
    /// square.
    pub(super) fn cover(&self, centre: DVec2) -> (f64, DVec2) {
        let mut crossing = Polygon::SQUARE;
        let mut cut = false;
        for edge in &self.0 {
            let at = edge.dot(centre.extend(1.0));
            // The edge's value at the square's corners is within this of that at its centre.
            let reach = 0.5 * (edge.x.abs() + edge.y.abs());
            if !(at > -reach) {
                return (0.0, centre);
            }
            if at < reach {
                crossing.clip(edge.truncate(), at);
                cut = true;
            }
        }
        if !cut {
            return (1.0, centre);
        }
        let (area, middle) = crossing.area();
        (area, centre + middle)
    }
}

/// A convex polygon around a pixel's centre: each of four clips of a square adds a corner at most.
struct Polygon {
    corners: [DVec2; 8],
    count: usize,
}

impl Polygon {
    const SQUARE: Self = {
        let mut corners = [DVec2::ZERO; 8];
        corners[0] = DVec2::new(-0.5, -0.5);
        corners[1] = DVec2::new(0.5, -0.5);
        corners[2] = DVec2::new(0.5, 0.5);
        corners[3] = DVec2::new(-0.5, 0.5);
        Self { corners, count: 4 }
    };

    /// Keeps what lies where `slope . p + at >= 0` (Sutherland and Hodgman 1974).
    fn clip(&mut self, slope: DVec2, at: f64) {
        let mut out = Self {
            corners: [DVec2::ZERO; 8],
            count: 0,
        };
        for i in 0..self.count {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (before, after) = (slope.dot(a) + at, slope.dot(b) + at);
            if before >= 0.0 {
                out.push(a);
            }
            if (before >= 0.0) != (after >= 0.0) {
                out.push(a + (b - a) * (before / (before - after)));
            }
        }
        *self = out;
    }

    fn push(&mut self, corner: DVec2) {
        if let Some(free) = self.corners.get_mut(self.count) {
            *free = corner;
            self.count += 1;
        }
    }

    /// Area and centroid.
    fn area(&self) -> (f64, DVec2) {
        let (mut twice, mut sum) = (0.0, DVec2::ZERO);
        let first = self.corners[0];
        for i in 1..self.count.saturating_sub(1) {
            let (a, b) = (self.corners[i] - first, self.corners[i + 1] - first);
            let part = a.perp_dot(b);
            twice += part;
            sum += (a + b) * part;
        }
        if twice > 0.0 {
            (0.5 * twice, first + sum / (3.0 * twice))
        } else {
            (0.0, DVec2::ZERO)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(rows: [[f64; 3]; 3], size: [f64; 2]) -> Edges {
        let matrix = DMat3::from_cols_array_2d(&rows).transpose();
        Edges::new(&matrix, DVec2::from_array(size))
    }

    #[test]
    fn simple_cuts_have_their_area_and_middle() {
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let image = edges(identity, [3.0, 2.25]);
        let at = |x: f64, y: f64| image.cover(DVec2::new(x, y));
        assert_eq!(at(1.5, 1.5), (1.0, DVec2::new(1.5, 1.5)));
        assert_eq!(at(0.0, 1.5), (0.5, DVec2::new(0.25, 1.5)));
        assert_eq!(at(3.0, 2.0), (0.375, DVec2::new(2.75, 1.875)));
        assert_eq!(at(3.5, 1.0).0, 0.0);
        // Smaller than a pixel, and wholly within one.
        let dot = edges(identity, [0.5, 0.25]);
        assert_eq!(
            dot.cover(DVec2::splat(0.5)),
            (0.125, DVec2::new(0.25, 0.125))
        );
        // Half of a square by its diagonal.
        let slanted = edges(
            [[1.0, 1.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [9.0; 2],
        );
        let (area, middle) = slanted.cover(DVec2::splat(0.5));
        assert!((area - 0.5).abs() < 1e-15 && (middle - DVec2::splat(2.0 / 3.0)).length() < 1e-15);
    }

    #[test]
    fn numbers_without_a_plane_cover_nothing() {
        for bad in [f64::NAN, f64::INFINITY] {
            let image = edges(
                [[bad, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                [3.0; 2],
            );
            let (area, middle) = image.cover(DVec2::splat(1.5));
            assert!(area == 0.0 && middle.is_finite());
        }
    }
}
