//! Tubes: rings along a curve, closed at both ends; horns, ears, tail and balls are made of them.

use texmap_math::{deterministic_f64, glam::DVec3};

use crate::mesh::{length, unit};

/// One station of a tube: centre, half-width along `side` and half-width across it.
#[derive(Clone, Copy)]
pub(crate) struct Station {
    pub(crate) centre: DVec3,
    pub(crate) wide: f64,
    pub(crate) thick: f64,
}

/// Points, and polygons over them with outward counter-clockwise order.
pub(crate) struct Tube {
    pub(crate) points: Vec<DVec3>,
    pub(crate) faces: Vec<Vec<usize>>,
}

/// Sweeps ellipses through the stations (Catmull-Rom between them, `steps` each), `around` points per ring;
/// `side` is the direction of the wide axis, turned so that it stays square to the curve.
pub(crate) fn tube(stations: &[Station], side: DVec3, steps: usize, around: usize) -> Tube {
    let rings: Vec<Station> = (0..=(stations.len() - 1) * steps)
        .map(|k| {
            let (i, t) = if k == (stations.len() - 1) * steps {
                (stations.len() - 2, 1.0)
            } else {
                (k / steps, (k % steps) as f64 / steps as f64)
            };
            let pick = |j: isize| {
                stations[(i as isize + j).clamp(0, stations.len() as isize - 1) as usize]
            };
            let [a, b, c, d] = [pick(-1), pick(0), pick(1), pick(2)];
            Station {
                centre: spline(a.centre, b.centre, c.centre, d.centre, t),
                wide: b.wide + (c.wide - b.wide) * t * t * (3.0 - 2.0 * t),
                thick: b.thick + (c.thick - b.thick) * t * t * (3.0 - 2.0 * t),
            }
        })
        .collect();
    let last = rings.len() - 1;
    let mut tube = Tube {
        points: vec![rings[0].centre],
        faces: Vec::new(),
    };
    for i in 1..last {
        let ahead = unit(rings[i + 1].centre - rings[i - 1].centre);
        let across = unit(side - ahead * side.dot(ahead));
        let up = ahead.cross(across);
        for k in 0..around {
            let (sin, cos) =
                deterministic_f64::sin_cos(k as f64 / around as f64 * core::f64::consts::TAU);
            tube.points.push(
                rings[i].centre + across * (rings[i].wide * cos) + up * (rings[i].thick * sin),
            );
        }
    }
    close(tube, rings[last].centre, last, around)
}

/// A ball as a tube from its lowest to its highest point.
pub(crate) fn ball(centre: DVec3, radius: f64, rings: usize, around: usize) -> Tube {
    let mut tube = Tube {
        points: vec![centre - DVec3::Y * radius],
        faces: Vec::new(),
    };
    for i in 1..rings {
        let (sin, cos) =
            deterministic_f64::sin_cos(i as f64 / rings as f64 * core::f64::consts::PI);
        for k in 0..around {
            let (z, x) =
                deterministic_f64::sin_cos(k as f64 / around as f64 * core::f64::consts::TAU);
            tube.points
                .push(centre + DVec3::new(x * sin, -cos, -z * sin) * radius);
        }
    }
    close(tube, centre + DVec3::Y * radius, rings, around)
}

/// Adds the last point and the faces of a tube that holds its first point and the rings 1 to `last` - 1.
fn close(mut tube: Tube, tip: DVec3, last: usize, around: usize) -> Tube {
    let end = tube.points.len();
    tube.points.push(tip);
    let ring = |i: usize, k: usize| 1 + (i - 1) * around + k % around;
    for k in 0..around {
        tube.faces.push(vec![0, ring(1, k + 1), ring(1, k)]);
        for i in 1..last - 1 {
            tube.faces.push(vec![
                ring(i, k),
                ring(i, k + 1),
                ring(i + 1, k + 1),
                ring(i + 1, k),
            ]);
        }
        tube.faces
            .push(vec![ring(last - 1, k), ring(last - 1, k + 1), end]);
    }
    tube
}

fn spline(a: DVec3, b: DVec3, c: DVec3, d: DVec3, t: f64) -> DVec3 {
    (b * 2.0
        + (c - a) * t
        + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t)
        + (b * 3.0 - a - c * 3.0 + d) * (t * t * t))
        * 0.5
}

impl Tube {
    /// The mirror image in the plane z = 0, still facing outward.
    pub(crate) fn mirrored(&self) -> Self {
        let points = self
            .points
            .iter()
            .map(|p| DVec3::new(p.x, p.y, -p.z))
            .collect();
        Self {
            points,
            faces: self
                .faces
                .iter()
                .map(|f| f.iter().rev().copied().collect())
                .collect(),
        }
    }

    /// Area-weighted vertex normals.
    pub(crate) fn normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.points.len()];
        for face in &self.faces {
            let (a, c) = (self.points[face[0]], self.points[face[2]]);
            let (b, d) = (self.points[face[1]], self.points[face[face.len() - 1]]);
            let normal = if face.len() == 4 {
                (c - a).cross(d - b)
            } else {
                (b - a).cross(c - a)
            };
            for &i in face {
                normals[i] += normal;
            }
        }
        debug_assert!(
            normals.iter().all(|n| length(*n) > 0.0),
            "a vertex of a tube has no normal"
        );
        normals.into_iter().map(unit).collect()
    }
}
