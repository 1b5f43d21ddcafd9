//! Polygonises an implicit surface: naive surface nets (Gibson 1998), then relaxed on the surface itself.

use std::collections::BTreeMap;

use texmap_math::glam::DVec3;

use crate::cow::shape::gradient;
use crate::mesh::unit;

/// Corner lists of quads with outward counter-clockwise order, over shared points.
pub(crate) struct Net {
    pub(crate) points: Vec<DVec3>,
    pub(crate) quads: Vec<[usize; 4]>,
}

/// The zero set of `field` (negative inside) within the box from `low` on `counts` cells of size `cell`.
/// The surface must stay clear of the box's walls: then the net is closed.
pub(crate) fn net(field: &dyn Fn(DVec3) -> f64, low: DVec3, cell: f64, counts: [usize; 3]) -> Net {
    let [nx, ny, nz] = counts.map(|n| n + 1);
    let index = |x: usize, y: usize, z: usize| (z * ny + y) * nx + x;
    let at = |x: usize, y: usize, z: usize| low + DVec3::new(x as f64, y as f64, z as f64) * cell;
    let mut samples = Vec::with_capacity(nx * ny * nz);
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                samples.push(field(at(x, y, z)));
            }
        }
    }
    let mut net = Net {
        points: Vec::new(),
        quads: Vec::new(),
    };
    let mut cell_point = BTreeMap::new();
    for (z, y, x) in (0..counts[2])
        .flat_map(|z| (0..counts[1]).flat_map(move |y| (0..counts[0]).map(move |x| (z, y, x))))
    {
        let (mut sum, mut crossings) = (DVec3::ZERO, 0);
        for (axis, a, b) in (0..12).map(|k| (k / 4, k % 2, k / 2 % 2)) {
            // The four edges along `axis`, at the offsets (a, b) on the other two.
            let from = match axis {
                0 => [x, y + a, z + b],
                1 => [x + a, y, z + b],
                _ => [x + a, y + b, z],
            };
            let mut to = from;
            to[axis] += 1;
            let (f, g) = (
                samples[index(from[0], from[1], from[2])],
                samples[index(to[0], to[1], to[2])],
            );
            if (f < 0.0) != (g < 0.0) {
                let (p, q) = (at(from[0], from[1], from[2]), at(to[0], to[1], to[2]));
                sum += p + (q - p) * (f / (f - g));
                crossings += 1;
            }
        }
        if crossings > 0 {
            cell_point.insert((x, y, z), net.points.len());
            net.points.push(sum / f64::from(crossings));
        }
    }
    for (z, y, x) in (1..counts[2])
        .flat_map(|z| (1..counts[1]).flat_map(move |y| (1..counts[0]).map(move |x| (z, y, x))))
    {
        let here = samples[index(x, y, z)] < 0.0;
        // One quad around each lattice edge that crosses: the four cells that share the edge.
        let around = [
            (
                samples[index(x + 1, y, z)],
                [(x, y - 1, z - 1), (x, y, z - 1), (x, y, z), (x, y - 1, z)],
            ),
            (
                samples[index(x, y + 1, z)],
                [(x - 1, y, z - 1), (x - 1, y, z), (x, y, z), (x, y, z - 1)],
            ),
            (
                samples[index(x, y, z + 1)],
                [(x - 1, y - 1, z), (x, y - 1, z), (x, y, z), (x - 1, y, z)],
            ),
        ];
        for (there, cells) in around {
            if here != (there < 0.0) {
                let mut quad = cells.map(|c| cell_point[&c]);
                if !here {
                    quad.reverse();
                }
                net.quads.push(quad);
            }
        }
    }
    net
}

impl Net {
    /// Evens the points out along the surface and puts them back onto it, `rounds` times.
    pub(crate) fn relax(&mut self, field: &dyn Fn(DVec3) -> f64, rounds: usize) {
        let mut neighbours = vec![Vec::new(); self.points.len()];
        for quad in &self.quads {
            for k in 0..4 {
                neighbours[quad[k]].push(quad[(k + 1) % 4]);
            }
        }
        for _ in 0..rounds {
            let centres: Vec<DVec3> = neighbours
                .iter()
                .map(|around| {
                    around.iter().map(|&i| self.points[i]).sum::<DVec3>() / around.len() as f64
                })
                .collect();
            for (point, centre) in self.points.iter_mut().zip(centres) {
                let normal = unit(gradient(field, *point));
                let step = centre - *point;
                *point += (step - normal * step.dot(normal)) * 0.6;
                for _ in 0..2 {
                    let slope = gradient(field, *point);
                    *point -= slope * (field(*point) / slope.dot(slope).max(0.01));
                }
            }
        }
    }
}
