//! An atlas for a whole surface: charts by facing direction, packed on shelves, and painted texel by texel
//! with the colour that the surface has in space.

use std::collections::{BTreeMap, BTreeSet};

use texmap_math::glam::{DVec2, DVec3};

use crate::mesh::unit;
use crate::picture::{Picture, Rgba};

/// Polygons over shared points; each face belongs to a part, and no chart spans two parts.
#[derive(Default)]
pub(crate) struct Surface {
    pub(crate) points: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) faces: Vec<Vec<usize>>,
    pub(crate) parts: Vec<usize>,
}

impl Surface {
    pub(crate) fn add(
        &mut self,
        part: usize,
        points: &[DVec3],
        normals: &[DVec3],
        faces: impl Iterator<Item = Vec<usize>>,
    ) {
        let base = self.points.len();
        self.points.extend(points);
        self.normals.extend(normals);
        for face in faces {
            self.faces
                .push(face.into_iter().map(|i| i + base).collect());
            self.parts.push(part);
        }
    }

    fn face_normal(&self, face: &[usize]) -> DVec3 {
        let p = |k: usize| self.points[face[k]];
        let last = face.len() - 1;
        unit(if last == 3 {
            (p(2) - p(0)).cross(p(3) - p(1))
        } else {
            (p(1) - p(0)).cross(p(2) - p(0))
        })
    }

    /// Faces that share an edge with each face, of the same part.
    fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut edges: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..face.len() {
                let (a, b) = (face[k], face[(k + 1) % face.len()]);
                edges.entry([a.min(b), a.max(b)]).or_default().push(f);
            }
        }
        let mut neighbours = vec![Vec::new(); self.faces.len()];
        for pair in edges.values() {
            for (&f, &g) in pair.iter().flat_map(|f| pair.iter().map(move |g| (f, g))) {
                if f != g && self.parts[f] == self.parts[g] {
                    neighbours[f].push(g);
                }
            }
        }
        neighbours
    }
}

/// A facing direction and the directions of u and v on its plane.
const SIDES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::Z, DVec3::Y],
    [DVec3::Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::Z],
    [DVec3::Z, DVec3::X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y],
];

struct Chart {
    side: usize,
    faces: Vec<usize>,
}

/// Places every corner of every face on a square of `size` texels, y downward, `gutter` texels between charts.
pub(crate) fn layout(surface: &Surface, size: f64, gutter: f64) -> Vec<Vec<DVec2>> {
    let charts = charts(surface);
    let flat = |chart: &Chart, i: usize| {
        let [_, u, v] = SIDES[chart.side];
        DVec2::new(surface.points[i].dot(u), -surface.points[i].dot(v))
    };
    let boxes: Vec<(DVec2, DVec2)> = charts
        .iter()
        .map(|chart| {
            let all = chart
                .faces
                .iter()
                .flat_map(|&f| &surface.faces[f])
                .map(|&i| flat(chart, i));
            all.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            })
        })
        .collect();
    let mut scale = size;
    let corners = loop {
        if let Some(corners) = shelves(&boxes, scale, size, gutter) {
            break corners;
        }
        scale *= 0.99;
    };
    let mut places = vec![Vec::new(); surface.faces.len()];
    for ((chart, corner), (low, _)) in charts.iter().zip(corners).zip(&boxes) {
        for &f in &chart.faces {
            places[f] = surface.faces[f]
                .iter()
                .map(|&i| corner + (flat(chart, i) - *low) * scale)
                .collect();
        }
    }
    places
}

/// Upper left corner of each box, highest first from left to right on shelves; None when they do not fit.
fn shelves(boxes: &[(DVec2, DVec2)], scale: f64, size: f64, gutter: f64) -> Option<Vec<DVec2>> {
    let extent = |i: usize| ((boxes[i].1 - boxes[i].0) * scale).ceil() + DVec2::splat(gutter);
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| extent(b).y.total_cmp(&extent(a).y).then(a.cmp(&b)));
    let mut corners = vec![DVec2::ZERO; boxes.len()];
    let (mut x, mut y, mut shelf) = (gutter, gutter, 0.0);
    for i in order {
        let e = extent(i);
        if x + e.x > size {
            (x, y, shelf) = (gutter, y + shelf, 0.0);
        }
        if x + e.x > size || y + e.y > size {
            return None;
        }
        corners[i] = DVec2::new(x, y);
        x += e.x;
        shelf = if e.y > shelf { e.y } else { shelf };
    }
    Some(corners)
}

/// Connected regions of one facing direction that do not overlap themselves when seen along it.
fn charts(surface: &Surface) -> Vec<Chart> {
    let neighbours = surface.neighbours();
    let normals: Vec<DVec3> = surface
        .faces
        .iter()
        .map(|f| surface.face_normal(f))
        .collect();
    let mut side: Vec<usize> = normals.iter().map(|n| facing(*n)).collect();
    // Faces that stand alone among another side's faces join them where that does not stretch them much.
    for _ in 0..6 {
        let before = side.clone();
        for f in 0..side.len() {
            for (s, axes) in SIDES.iter().enumerate() {
                let votes = neighbours[f].iter().filter(|&&g| before[g] == s).count();
                if s != before[f]
                    && votes * 3 >= neighbours[f].len() * 2
                    && normals[f].dot(axes[0]) > 0.3
                {
                    side[f] = s;
                }
            }
        }
    }
    let mut owner = vec![None; side.len()];
    let mut charts: Vec<Chart> = Vec::new();
    for seed in 0..side.len() {
        if owner[seed].is_some() {
            continue;
        }
        let mut chart = Chart {
            side: side[seed],
            faces: Vec::new(),
        };
        let mut covered = BTreeSet::new();
        let mut queue = std::collections::VecDeque::from([seed]);
        while let Some(f) = queue.pop_front() {
            if owner[f].is_some() || side[f] != chart.side {
                continue;
            }
            let cells = cells(surface, f, chart.side);
            if cells.iter().any(|c| covered.contains(c)) {
                continue;
            }
            covered.extend(cells);
            owner[f] = Some(charts.len());
            chart.faces.push(f);
            queue.extend(neighbours[f].iter().copied());
        }
        charts.push(chart);
    }
    charts
}

fn facing(n: DVec3) -> usize {
    let a = n.abs();
    if a.z >= a.x && a.z >= a.y {
        if n.z < 0.0 { 5 } else { 4 }
    } else if a.y >= a.x {
        if n.y < 0.0 { 3 } else { 2 }
    } else {
        usize::from(n.x < 0.0)
    }
}

/// Cells of a fine grid whose middle lies inside the face as seen along `side`.
fn cells(surface: &Surface, f: usize, side: usize) -> Vec<(i32, i32)> {
    const CELLS_PER_UNIT: f64 = 200.0;
    let [_, u, v] = SIDES[side];
    let corners: Vec<DVec2> = surface.faces[f]
        .iter()
        .map(|&i| DVec2::new(surface.points[i].dot(u), surface.points[i].dot(v)) * CELLS_PER_UNIT)
        .collect();
    let mut cells = Vec::new();
    for k in 1..corners.len() - 1 {
        fill([corners[0], corners[k], corners[k + 1]], 0.0, |x, y, _| {
            cells.push((x, y));
        });
    }
    cells
}

/// Calls `hit` for every grid cell whose middle lies within `margin` of the triangle (either winding), with the
/// barycentric weights of its middle.
fn fill(t: [DVec2; 3], margin: f64, mut hit: impl FnMut(i32, i32, [f64; 3])) {
    let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
    if area.abs() < 1e-12 {
        return;
    }
    let (low, high) = (
        t[0].min(t[1]).min(t[2]) - margin,
        t[0].max(t[1]).max(t[2]) + margin,
    );
    for y in low.y.floor() as i32..=high.y.floor() as i32 {
        for x in low.x.floor() as i32..=high.x.floor() as i32 {
            let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let weights: [f64; 3] = core::array::from_fn(|i| {
                (t[(i + 2) % 3] - t[(i + 1) % 3]).perp_dot(p - t[(i + 1) % 3]) / area
            });
            // Distance to an edge is its weight times the height over that edge.
            let inside = (0..3).all(|i| {
                let edge = t[(i + 2) % 3] - t[(i + 1) % 3];
                weights[i] * area.abs() > -margin * (edge.x * edge.x + edge.y * edge.y).sqrt()
            });
            if inside {
                hit(x, y, weights);
            }
        }
    }
}

/// Paints the atlas: `color` gets the part, the point and the normal. Texels near a chart repeat its rim,
/// the rest is `ground`.
pub(crate) fn paint(
    surface: &Surface,
    places: &[Vec<DVec2>],
    size: u32,
    ground: Rgba,
    color: &dyn Fn(usize, DVec3, DVec3) -> [f64; 3],
) -> Picture {
    let mut texels: Vec<Option<[f64; 3]>> = vec![None; (size * size) as usize];
    // Rims first: what lies truly inside a face overwrites what only borders on another.
    for margin in [1.0, 0.0] {
        for (f, face) in surface.faces.iter().enumerate() {
            for k in 1..face.len() - 1 {
                let t = [0, k, k + 1];
                let flat = t.map(|c| places[f][c]);
                let step = gradients(flat);
                fill(flat, margin, |x, y, weights| {
                    let mut sum = [0.0; 3];
                    for (dx, dy) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
                        let w: [f64; 3] =
                            core::array::from_fn(|i| weights[i] + step[i].x * dx + step[i].y * dy);
                        let at =
                            |list: &[DVec3]| (0..3).map(|i| list[face[t[i]]] * w[i]).sum::<DVec3>();
                        let c = color(
                            surface.parts[f],
                            at(&surface.points),
                            unit(at(&surface.normals)),
                        );
                        sum = core::array::from_fn(|i| sum[i] + c[i] * 0.25);
                    }
                    texels[(y as u32 * size + x as u32) as usize] = Some(sum);
                });
            }
        }
    }
    for _ in 0..8 {
        grow(&mut texels, size as usize);
    }
    let quantise = |c: [f64; 3]| {
        let q = c.map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5).floor() as u8);
        [q[0], q[1], q[2], 255]
    };
    Picture {
        width: size,
        height: size,
        texels: texels
            .into_iter()
            .map(|t| t.map_or(ground, quantise))
            .collect(),
    }
}

/// Change of the three barycentric weights per texel.
fn gradients(t: [DVec2; 3]) -> [DVec2; 3] {
    let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
    core::array::from_fn(|i| {
        let edge = t[(i + 2) % 3] - t[(i + 1) % 3];
        DVec2::new(-edge.y, edge.x) / area
    })
}

/// Empty texels beside filled ones take their mean.
fn grow(texels: &mut [Option<[f64; 3]>], size: usize) {
    let before = texels.to_vec();
    for (i, texel) in texels.iter_mut().enumerate().filter(|(_, t)| t.is_none()) {
        let (x, y) = (i % size, i / size);
        let around = (y.saturating_sub(1)..(y + 2).min(size))
            .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(size)).map(move |x| y * size + x));
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for c in around.filter_map(|k| before[k]) {
            sum = core::array::from_fn(|k| sum[k] + c[k]);
            count += 1.0;
        }
        if count > 0.0 {
            *texel = Some(sum.map(|s| s / count));
        }
    }
}
