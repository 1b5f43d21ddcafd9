//! Triangles of polygons: the fan around the first corner, or for a polygon that the fan would leave, a triangulation by ears.

use earcut::Earcut;
use texmap_math::glam::{DVec2, DVec3};

use super::normals::fan_areas;

/// Ears take time in the square of the corners of some polygons: 0.15 s for as many as this.
const MOST_CORNERS: usize = 1 << 14;

/// Cuts polygons; its buffers serve one after another.
#[derive(Default)]
pub(super) struct Polygons {
    points: Vec<DVec3>,
    flat: Vec<[f64; 2]>,
    indices: Vec<u32>,
    ears: Earcut<f64>,
}

impl Polygons {
    /// Gives `triangle` the numbers of the corners of each triangle, with the orientation of the polygon. A polygon that crosses itself is
    /// a fan.
    ///
    /// A fan has two triangles less than the polygon has corners. Ears may be fewer, where corners lie on one line. False says that a
    /// polygon of more than [`MOST_CORNERS`] corners is a fan although that leaves it.
    pub(super) fn cut(
        &mut self,
        corners: impl ExactSizeIterator<Item = [f32; 3]>,
        mut triangle: impl FnMut([usize; 3]),
    ) -> bool {
        let (count, mut within) = (corners.len(), true);
        if count > 3 {
            self.points.clear();
            self.points
                .extend(corners.map(|point| DVec3::from(point.map(f64::from))));
            if let Some(normal) = normal_where_fans_fail(&self.points) {
                if count > MOST_CORNERS {
                    within = false;
                } else if self.ears(normal, &mut triangle) {
                    return true;
                }
            }
        }
        for k in 2..count {
            triangle([0, k - 1, k]);
        }
        within
    }

    /// False for a polygon that crosses itself: its ears do not have its area.
    fn ears(&mut self, normal: DVec3, triangle: &mut impl FnMut([usize; 3])) -> bool {
        let first = self.points[0];
        let flat = self.points.iter().map(|point| {
            let point = along(normal, *point - first);
            [point.x, point.y]
        });
        self.flat.clear();
        self.flat.extend(flat);
        self.ears.earcut_slice(&self.flat, &[], &mut self.indices);
        let ears = self.indices.as_chunks().0;
        let area = |ear: &[u32; 3]| {
            let [p, q, r] = ear.map(|k| DVec2::from(self.flat[k as usize]));
            (q - p).perp_dot(r - p)
        };
        let covered: f64 = ears.iter().map(|ear| area(ear).abs()).sum();
        // Twice the area of the outline as it is seen against that axis.
        let whole = normal.abs().max_element();
        if !((covered - whole).abs() <= 1e-6 * whole) || whole == 0.0 {
            return false;
        }
        for ear in ears {
            let [a, b, c] = ear.map(|k| k as usize);
            triangle(match area(ear) < 0.0 {
                true => [a, c, b],
                false => [a, b, c],
            });
        }
        true
    }
}

/// A vector seen against the largest axis of `normal`, so that counter-clockwise stays that.
fn along(normal: DVec3, v: DVec3) -> DVec2 {
    let size = normal.abs();
    let (sign, seen) = if size.z >= size.x.max(size.y) {
        (normal.z, DVec2::new(v.x, v.y))
    } else if size.x >= size.y {
        (normal.x, DVec2::new(v.y, v.z))
    } else {
        (normal.y, DVec2::new(v.z, v.x))
    };
    DVec2::new(seen.x, seen.y * sign.signum())
}

/// The normal of a polygon of which some triangle of the fan is turned around: it has a corner that bends inwards.
fn normal_where_fans_fail(polygon: &[DVec3]) -> Option<DVec3> {
    let normal: DVec3 = fan_areas(polygon).sum();
    // Corners on one line, to the precision of their numbers, turn nothing around.
    let noise = -1e-9 * normal.length_squared();
    fan_areas(polygon)
        .any(|area| area.dot(normal) < noise)
        .then_some(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(polygon: &[[f32; 3]]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        Polygons::default().cut(polygon.iter().copied(), |t| triangles.push(t));
        triangles
    }

    /// The signed areas of the triangles about the normal of the plane.
    fn areas(polygon: &[[f32; 3]], normal: DVec3) -> Vec<f64> {
        let at = |k: usize| DVec3::from(polygon[k].map(f64::from));
        let area = |[a, b, c]: [usize; 3]| (at(b) - at(a)).cross(at(c) - at(a)).dot(normal) / 2.0;
        cut(polygon).into_iter().map(area).collect()
    }

    const ELL: [[f32; 2]; 6] = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];

    /// From each first corner, in each plane, either way round: triangles of one orientation that have the area of the polygon.
    #[test]
    fn concave_polygons_are_covered_once() {
        for first in 0..6 {
            for plane in 0..3 {
                for flip in [false, true] {
                    let mut polygon: Vec<[f32; 3]> = (0..6)
                        .map(|k| {
                            let [x, y] = ELL[(k + first) % 6];
                            let mut point = [x, y, 0.25 * x + 7.0];
                            point.rotate_right(plane);
                            point
                        })
                        .collect();
                    let mut normal = [-0.25, 0.0, 1.0];
                    normal.rotate_right(plane);
                    let mut normal = DVec3::from(normal).normalize();
                    if flip {
                        polygon.reverse();
                        normal = -normal;
                    }
                    let areas = areas(&polygon, normal);
                    let whole = 3.0 * (1.0_f64 + 0.0625).sqrt();
                    assert_eq!(areas.len(), 4, "{first} {plane} {flip}");
                    assert!(areas.iter().all(|a| *a > 0.0), "{areas:?}");
                    assert!(
                        (areas.iter().sum::<f64>() - whole).abs() < 1e-6,
                        "{areas:?}"
                    );
                }
            }
        }
        // The fan covers too much from the third corner on.
        let fan: f64 = (0..4)
            .map(|k| {
                let [p, q, r] = [2, k + 3, k + 4].map(|k| DVec2::from(ELL[k % 6].map(f64::from)));
                ((q - p).perp_dot(r - p) / 2.0).abs()
            })
            .sum();
        assert!(fan > 3.5, "{fan}");
    }

    #[test]
    fn convex_polygons_are_fans() {
        let fan = |n: usize| (2..n).map(|k| [0, k - 1, k]).collect::<Vec<_>>();
        for n in 3..9 {
            let corner = |k: usize| {
                let (sin, cos) = (k as f32 * std::f32::consts::TAU / n as f32).sin_cos();
                [1e6 + cos, sin, 0.1 * sin]
            };
            let polygon: Vec<_> = (0..n).map(corner).collect();
            assert_eq!(cut(&polygon), fan(n));
        }
        // Corners on an edge, a bent quad, and one without area.
        for polygon in [
            [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]],
            [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
        ] {
            assert_eq!(cut(&polygon), fan(4));
        }
    }

    #[test]
    fn polygons_that_cross_themselves_are_fans() {
        let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4]];
        // A star of one stroke, and one through a corner twice.
        let star = |k: usize| {
            let (sin, cos) = (k as f32 * 2.0 * std::f32::consts::TAU / 5.0).sin_cos();
            [cos, sin, 0.0]
        };
        assert_eq!(cut(&[0, 1, 2, 3, 4].map(star)), fan);
        let twice = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0; 3],
            [0.0, 1.0, 0.0],
            [1.0, 2.0, 0.0],
        ];
        assert_eq!(cut(&twice).len(), 3);
        let tie = [[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(cut(&tie), fan[..2]);
    }

    #[test]
    fn combs_of_many_teeth_are_cut_until_that_takes_long() {
        const TEETH: usize = MOST_CORNERS - 2;
        let tooth = |k: usize| {
            let y = if k.is_multiple_of(2) { 1.0 } else { 0.1 };
            [k as f32, y, 0.0]
        };
        let mut comb: Vec<_> = (0..TEETH).map(tooth).collect();
        comb.extend([[TEETH as f32, 0.0, 0.0], [-1.0, 0.0, 0.0]]);
        let areas = areas(&comb, DVec3::NEG_Z);
        assert!(areas.iter().all(|a| *a >= 0.0));
        assert_eq!(areas.len(), TEETH);
        assert!(Polygons::default().cut(comb.iter().copied(), |_| ()));
        comb.push([-1.0, 0.5, 0.0]);
        let mut count = 0;
        assert!(!Polygons::default().cut(comb.iter().copied(), |_| count += 1));
        assert_eq!(count, TEETH + 1);
    }
}
