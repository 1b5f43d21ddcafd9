//! Packing: islands side by side in one atlas.

use alloc::vec;
use alloc::vec::Vec;
use core::cmp::Reverse;
use texmap_math::float;
use texmap_math::glam::DVec2;

use crate::UvError;
use crate::islands::{Islands, compact, separate};
use crate::mesh::{Mesh, length};
use crate::topology::Topology;
use crate::uv_set::UvSet;

/// A square atlas for islands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasSize {
    /// Edge in texels.
    pub size: u32,
    /// Least number of empty texels between islands, and between an island and the edge.
    pub gutter: u32,
}

impl Default for AtlasSize {
    /// 1024 texels, gutters of 4.
    fn default() -> Self {
        Self {
            size: 1024,
            gutter: 4,
        }
    }
}

/// Moves the islands of a set side by side into [0, 1], with one texel density for all. Every island is scaled to its area in
/// space, then all by the same factor, as large as the atlas allows. Islands stand on whole texels and lie on their longer side.
/// One without area, in space or in the picture, is one texel long.
///
/// # Errors
/// A set that does not fit the mesh, an atlas of zero size, more gutters than texels.
pub fn pack(mesh: &Mesh<'_>, set: &UvSet, atlas: AtlasSize) -> Result<UvSet, UvError> {
    set.check(mesh)?;
    let topology = Topology::new(mesh);
    let islands = Islands::new(mesh, set, &topology);
    let mut set = set.clone();
    separate(&topology, &islands, &mut set);
    let areas = areas(mesh, &set, &islands);
    let mut charts: Vec<Island> = vec![Island::EMPTY; islands.count];
    for (k, &index) in set.corners.iter().enumerate() {
        let chart = &mut charts[islands.of_face[topology.face[k] as usize] as usize];
        let p = DVec2::from(set.uvs[index as usize].map(f64::from));
        (chart.low, chart.high) = (chart.low.min(p), chart.high.max(p));
    }
    for (chart, [space, picture]) in charts.iter_mut().zip(areas) {
        // Rounding of f32 coordinates leaves this much of a line.
        let largest = chart.low.abs().max(chart.high.abs()).max_element();
        let least = chart.longest() * largest * 1e-7;
        chart.scale = (space > 0.0 && picture > least).then(|| float::sqrt(space / picture));
    }
    let (scale, corners) = best_scale(&charts, atlas)?;
    let texels = f64::from(atlas.size);
    let mut done = vec![false; set.uvs.len()];
    for (k, &index) in set.corners.iter().enumerate() {
        if core::mem::replace(&mut done[index as usize], true) {
            continue;
        }
        let island = islands.of_face[topology.face[k] as usize] as usize;
        let chart = &charts[island];
        let p = chart.lying(DVec2::from(set.uvs[index as usize].map(f64::from)))
            * chart.texels_per_unit(scale);
        let q = (corners[island] + p) / texels;
        set.uvs[index as usize] = [q.x as f32, q.y as f32];
    }
    Ok(compact(&set))
}

/// Area in space and in the picture of each island.
fn areas(mesh: &Mesh<'_>, set: &UvSet, islands: &Islands) -> Vec<[f64; 2]> {
    let mut areas = vec![[0.0; 2]; islands.count];
    for (face, corners) in mesh.faces().triangles() {
        let [a, b, c] = corners.map(|k| mesh.point(k));
        let [p, q, r] = corners.map(|k| DVec2::from(set.at(k).map(f64::from)));
        let area = &mut areas[islands.of_face[face] as usize];
        area[0] += length((b - a).cross(c - a)) * 0.5;
        area[1] += (q - p).perp_dot(r - p).abs() * 0.5;
    }
    areas
}

/// The bounding box of an island and the factor that gives it the common density; none if it has no area.
#[derive(Clone, Copy)]
struct Island {
    low: DVec2,
    high: DVec2,
    scale: Option<f64>,
}

impl Island {
    const EMPTY: Self = Self {
        low: DVec2::INFINITY,
        high: DVec2::NEG_INFINITY,
        scale: None,
    };

    /// True if it is higher than wide, by more than rounding.
    fn upright(&self) -> bool {
        let e = self.high - self.low;
        e.y > e.x * (1.0 + 1e-6)
    }

    fn longest(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    /// Texels for a unit of the island's own coordinates, where those of its density are scaled by a common factor.
    fn texels_per_unit(&self, common: f64) -> f64 {
        match (self.scale, self.longest()) {
            (Some(scale), _) => scale * common,
            // Such an island has no density, and what it measures is in no unit of the others.
            (None, longest) if longest > 0.0 => 1.0 / longest,
            (None, _) => 0.0,
        }
    }

    /// Width and height in texels when it lies on its longer side.
    fn extent(&self, common: f64) -> DVec2 {
        let e = (self.high - self.low) * self.texels_per_unit(common);
        if self.upright() {
            DVec2::new(e.y, e.x)
        } else {
            e
        }
    }

    /// A point relative to the island's corner, turned by a quarter if the island was upright.
    fn lying(&self, p: DVec2) -> DVec2 {
        if self.upright() {
            DVec2::new(self.high.y - p.y, p.x - self.low.x)
        } else {
            p - self.low
        }
    }
}

/// The largest scale (texels per unit) at which shelves hold all islands, within 0.1 %, and the islands' corners.
fn best_scale(charts: &[Island], atlas: AtlasSize) -> Result<(f64, Vec<DVec2>), UvError> {
    let fault = UvError::DoesNotFit {
        charts: charts.len(),
        size: atlas.size,
        gutter: atlas.gutter,
    };
    let inner = f64::from(atlas.size) - 2.0 * f64::from(atlas.gutter);
    let longest = charts
        .iter()
        .filter(|c| c.scale.is_some())
        .map(|c| c.extent(1.0).max_element())
        .fold(0.0, |a: f64, b| if b > a { b } else { a });
    if inner < 1.0 {
        return Err(fault);
    }
    let mut order: Vec<usize> = (0..charts.len()).collect();
    let height = |i: usize| charts[i].scale.map(|_| charts[i].extent(1.0).y);
    let highest = (0..charts.len()).filter_map(height).fold(0.0, f64::max);
    // Heights that rounding alone tells apart are equal, so that the order is that of the numbers in any unit. Those without area
    // come last: a texel is no more than any other takes.
    let rank = |i: &usize| {
        let rank = height(*i).map(|height| float::round_half_up(4096.0 * height / highest) as u32);
        (Reverse(rank), *i)
    };
    order.sort_by_cached_key(rank);
    let try_at = |scale: f64| shelves(charts, &order, scale, atlas);
    let most = if longest > 0.0 { inner / longest } else { 1.0 };
    if let Some(corners) = try_at(most) {
        return Ok((most, corners));
    }
    // At a vanishing scale every island takes one texel: if that does not fit, nothing does.
    let (mut low, mut high) = (0.0, most);
    let mut best = try_at(f64::MIN_POSITIVE)
        .map(|corners| (f64::MIN_POSITIVE, corners))
        .ok_or(fault)?;
    while high - low > high * 1e-3 {
        let middle = (low + high) * 0.5;
        match try_at(middle) {
            Some(corners) => {
                low = middle;
                best = (middle, corners);
            }
            None => high = middle,
        }
    }
    Ok(best)
}

/// Lower left corners on shelves from left to right, the highest islands first. `None` if the atlas overflows.
fn shelves(charts: &[Island], order: &[usize], scale: f64, atlas: AtlasSize) -> Option<Vec<DVec2>> {
    let (size, gutter) = (f64::from(atlas.size), f64::from(atlas.gutter));
    let mut corners = vec![DVec2::ZERO; charts.len()];
    let (mut x, mut y, mut shelf) = (gutter, gutter, 0.0);
    for &i in order {
        let e = charts[i].extent(scale);
        let (wide, high) = (float::ceil(e.x), float::ceil(e.y));
        if x > gutter && x + wide + gutter > size {
            (x, y, shelf) = (gutter, y + shelf + gutter, 0.0);
        }
        // The widest island may reach the gutter exactly, before rounding.
        if x + e.x + gutter > size * (1.0 + 1e-12) || y + e.y + gutter > size * (1.0 + 1e-12) {
            return None;
        }
        corners[i] = DVec2::new(x, y);
        x += wide + gutter;
        shelf = if high > shelf { high } else { shelf };
    }
    Some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;

    /// Squares of different sizes, all mapped onto one another.
    fn stack(count: u32) -> (Vec<[f32; 3]>, Faces, Vec<[f32; 2]>) {
        let (mut positions, mut faces, mut values) = (Vec::new(), Faces::new(), Vec::new());
        for i in 0..count {
            let (x, s) = (10.0 * i as f32, 1.0 + (i % 3) as f32);
            let base = i * 4;
            positions.extend([
                [x, 0.0, 0.0],
                [x + s, 0.0, 0.0],
                [x + s, 0.5 * s, 0.0],
                [x, 0.5 * s, 0.0],
            ]);
            faces.push(&[base, base + 1, base + 2, base + 3]);
            values.extend([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]]);
        }
        (positions, faces, values)
    }

    #[test]
    fn charts_keep_their_gutters_and_one_density() {
        let (positions, faces, values) = stack(23);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let set = UvSet::shared(&mesh, &values);
        let atlas = AtlasSize {
            size: 256,
            gutter: 5,
        };
        let packed = pack(&mesh, &set, atlas).unwrap();
        let boxes: Vec<(DVec2, DVec2)> = (0..faces.len())
            .map(|f| {
                let points = faces
                    .range(f)
                    .map(|k| DVec2::from(packed.at(k).map(f64::from)) * 256.0);
                points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| {
                    (l.min(p), h.max(p))
                })
            })
            .collect();
        for (i, (low, high)) in boxes.iter().enumerate() {
            assert!(
                low.min_element() > 4.999 && high.max_element() < 251.001,
                "{i}: {low} {high}"
            );
            let density = (high.x - low.x) / f64::from(1 + i as u32 % 3);
            assert!((density - (boxes[0].1.x - boxes[0].0.x)).abs() < 1e-3);
            for (l, h) in &boxes[..i] {
                let apart = (*l - *high).max(*low - *h).max_element();
                assert!(apart > 4.999, "charts {apart} texels apart");
            }
        }
    }

    /// A face without area in space, one on a line of the picture and one in a point of it leave the others their atlas.
    #[test]
    fn islands_without_area_take_a_texel() {
        let (positions, faces, values) = stack(5);
        let atlas = AtlasSize {
            size: 256,
            gutter: 2,
        };
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let alone = pack(&mesh, &UvSet::shared(&mesh, &values), atlas).unwrap();
        let extents = |mesh: &Mesh<'_>, set: &UvSet, face: usize| {
            let points = mesh.faces().range(face);
            let points = points.map(|k| DVec2::from(set.at(k).map(f64::from)) * 256.0);
            let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| {
                (l.min(p), h.max(p))
            });
            high - low
        };
        // In metres, and in units of a thousandth and a million of them, which uv coordinates know nothing of.
        for unit in [1.0, 1e3, 1e-6] {
            let (mut positions, mut faces) = (positions.clone(), faces.clone());
            let mut values = values.clone();
            let (flat, line) = ([0.0, 1.0, 2.0], [[0.0, 0.0], [3.0, 1.0], [0.7, 0.7 / 3.0]]);
            let square = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]];
            let corner = [[0.0, 90.0, 0.0], [1.0, 90.0, 0.0], [0.0, 91.0, 0.0]];
            for (space, picture) in [
                (flat.map(|x| [x, 70.0, 0.0]), square),
                (corner, line),
                (corner.map(|[x, y, _]| [x, y, 9.0]), [[0.5, 0.5]; 3]),
            ] {
                let first = positions.len() as u32;
                positions.extend(space);
                values.extend(picture);
                faces.push(&[first, first + 1, first + 2]);
            }
            let positions: Vec<_> = positions.iter().map(|p| p.map(|c| c * unit)).collect();
            let mesh = Mesh::new(&positions, &faces).unwrap();
            let packed = pack(&mesh, &UvSet::shared(&mesh, &values), atlas).unwrap();
            for face in 0..5 {
                let ratio = extents(&mesh, &packed, face) / extents(&mesh, &alone, face);
                assert!(
                    ratio.min_element() > 0.95,
                    "unit {unit}, face {face}: {ratio}"
                );
            }
            for (face, size) in [(5, 1.0), (6, 1.0), (7, 0.0)] {
                let long = extents(&mesh, &packed, face).max_element();
                assert!(
                    (long - size).abs() < 1e-3,
                    "unit {unit}, face {face}: {long}"
                );
            }
        }
    }

    /// Squares of one size up to rounding keep their order and are not turned, whichever is the largest and however it is rounded.
    #[test]
    fn rounding_moves_no_island() {
        let packed = |noise: &dyn Fn(u32) -> [f32; 2]| {
            let (mut positions, mut faces, mut values) = (Vec::new(), Faces::new(), Vec::new());
            for i in 0..30u32 {
                let [w, h] = noise(i).map(|n| 1.0 + n * f32::EPSILON);
                let base = 4 * i;
                let square = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]];
                positions.extend(square.map(|[x, y]| [x, y, i as f32]));
                values.extend(square);
                faces.push(&[base, base + 1, base + 2, base + 3]);
            }
            let mesh = Mesh::new(&positions, &faces).unwrap();
            let set = pack(&mesh, &UvSet::shared(&mesh, &values), AtlasSize::default()).unwrap();
            set.per_corner()
        };
        let exact = packed(&|_| [0.0, 0.0]);
        // One square fills the atlas, higher than wide or not.
        let one = |h: f32| {
            let positions = [[0.0, 0.0], [1.0, 0.0], [1.0, h], [0.0, h]];
            let set = UvSet {
                uvs: positions.to_vec(),
                corners: (0..4).collect(),
            };
            let mut faces = Faces::new();
            faces.push(&[0, 1, 2, 3]);
            let positions = positions.map(|[x, y]| [x, y, 0.0]);
            let mesh = Mesh::new(&positions, &faces).unwrap();
            pack(&mesh, &set, AtlasSize::default()).unwrap().at(2)
        };
        for h in [1.0 - f32::EPSILON, 1.0, 1.0 + f32::EPSILON] {
            let corner = one(h);
            assert!(
                corner.iter().all(|c| (c - 1020.0 / 1024.0).abs() < 1e-6),
                "{corner:?}"
            );
        }
        for k in 1..20 {
            let noise = |i: u32, m: u32| (i.wrapping_mul(m) >> 7 & 7) as f32;
            let rounded = packed(&|i| [noise(i + 31 * k, 747_796_405), noise(i + k, 277_803_737)]);
            for (p, q) in exact.iter().zip(&rounded) {
                assert!(
                    (p[0] - q[0]).abs() + (p[1] - q[1]).abs() < 1e-5,
                    "{p:?} {q:?}"
                );
            }
        }
    }

    #[test]
    fn too_many_gutters_are_refused() {
        let (positions, faces, values) = stack(40);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let set = UvSet::shared(&mesh, &values);
        for (size, gutter) in [(16, 8), (0, 0), (32, 7)] {
            let fault = pack(&mesh, &set, AtlasSize { size, gutter });
            assert_eq!(
                fault,
                Err(UvError::DoesNotFit {
                    charts: 40,
                    size,
                    gutter
                })
            );
        }
    }
}
