//! Triangles of a report: figures of each of them, and their sums, counts and ranges.

use alloc::vec::Vec;
use texmap_math::float;

use super::stretch::{Raw, normalised, raw};
use super::{ReportOptions, TriangleReport};
use crate::mesh::Mesh;
use crate::parallel;
use crate::uv_set::UvSet;

/// All triangles, and their sums in the order of chunks.
pub(super) fn each_triangle(
    mesh: &Mesh<'_>,
    set: &UvSet,
    options: &ReportOptions,
    scale: f64,
) -> (Vec<TriangleReport>, Sums) {
    let faces = mesh.faces();
    let parts = parallel::map_chunks(faces.len(), |range| {
        let (mut triangles, mut sums) = (Vec::with_capacity(range.len()), Sums::NONE);
        for face in range {
            for (_, corners) in faces.triangles_of(face) {
                let r = raw(mesh, set, corners, options);
                let uv = corners.map(|k| set.at(k));
                let triangle = TriangleReport {
                    face: face as u32,
                    corners: corners.map(|k| k as u32),
                    density: (float::sqrt(r.picture.abs() / r.space)
                        * f64::from(options.texture_size)) as f32,
                    outside: !uv.as_flattened().iter().all(|c| (0.0..=1.0).contains(c)),
                    ..normalised(&r, scale)
                };
                sums.add(&r, &triangle);
                sums.wide += usize::from(wide(uv));
                triangles.push(triangle);
            }
        }
        (triangles, sums)
    });
    let sums = parts
        .iter()
        .fold(Sums::NONE, |sum, (_, part)| sum.joined(part));
    let triangles = parallel::concat(parts.into_iter().map(|(triangles, _)| triangles));
    (triangles, sums)
}

/// Sums, counts and ranges over triangles.
#[derive(Clone, Copy)]
pub(super) struct Sums {
    pub(super) degenerate: usize,
    pub(super) flipped: usize,
    pub(super) collapsed: usize,
    pub(super) outside: usize,
    pub(super) wide: usize,
    pub(super) space: f64,
    pub(super) l2: f64,
    pub(super) angle: f64,
    pub(super) area: f64,
    /// Area in space of the triangles with area in the picture.
    pub(super) mapped: f64,
    pub(super) density: f64,
    pub(super) linf_max: f64,
    pub(super) angle_max: f64,
    pub(super) area_max: f64,
    /// Lowest and highest root of the area in the picture over that in space. None yet when the first is the larger.
    pub(super) density_range: [f64; 2],
}

impl Sums {
    const NONE: Self = Self {
        degenerate: 0,
        flipped: 0,
        collapsed: 0,
        outside: 0,
        wide: 0,
        space: 0.0,
        l2: 0.0,
        angle: 0.0,
        area: 0.0,
        mapped: 0.0,
        density: 0.0,
        linf_max: 0.0,
        angle_max: 0.0,
        area_max: 0.0,
        density_range: [f64::INFINITY, 0.0],
    };

    fn add(&mut self, r: &Raw, t: &TriangleReport) {
        self.degenerate += usize::from(r.space == 0.0);
        self.flipped += usize::from(t.flipped);
        self.collapsed += usize::from(t.collapsed);
        self.outside += usize::from(t.outside);
        self.space += r.space;
        if r.space == 0.0 {
            return;
        }
        let w = r.space;
        let density = float::sqrt(r.picture.abs() / w);
        let [low, high] = self.density_range;
        self.density_range = [lower(low, density), higher(high, density)];
        if t.collapsed {
            return;
        }
        self.l2 += w * f64::from(t.l2) * f64::from(t.l2);
        self.angle += w * f64::from(t.angle);
        self.area += w * f64::from(t.area);
        self.mapped += w;
        self.density += w * density;
        self.linf_max = higher_finite(self.linf_max, t.linf);
        self.angle_max = higher_finite(self.angle_max, t.angle);
        self.area_max = higher_finite(self.area_max, t.area);
    }

    fn joined(&self, next: &Self) -> Self {
        let [low, high] = next.density_range;
        Self {
            degenerate: self.degenerate + next.degenerate,
            flipped: self.flipped + next.flipped,
            collapsed: self.collapsed + next.collapsed,
            outside: self.outside + next.outside,
            wide: self.wide + next.wide,
            space: self.space + next.space,
            l2: self.l2 + next.l2,
            angle: self.angle + next.angle,
            area: self.area + next.area,
            mapped: self.mapped + next.mapped,
            density: self.density + next.density,
            linf_max: higher(self.linf_max, next.linf_max),
            angle_max: higher(self.angle_max, next.angle_max),
            area_max: higher(self.area_max, next.area_max),
            density_range: [
                lower(self.density_range[0], low),
                higher(self.density_range[1], high),
            ],
        }
    }
}

fn lower(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

fn higher(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

fn higher_finite(a: f64, b: f32) -> f64 {
    if b.is_finite() {
        higher(a, b.into())
    } else {
        a
    }
}

fn wide(uv: [[f32; 2]; 3]) -> bool {
    (0..3).any(|k| (uv[k][0] - uv[(k + 1) % 3][0]).abs() > 0.5)
}
