//! Texels that a face touches, and their values.

use alloc::vec::Vec;
use core::ops::Range;

use texmap_math::float::sqrt;

use super::AtlasMesh;
use crate::coverage::edge::{Edge, ONE, Snapped, centre, edges};
use crate::{NO_PRIMITIVE, TILE, TargetSize};

/// A band of the atlas and the values to fill in.
pub(super) struct Values<'b> {
    /// First row of the band.
    pub(super) top: usize,
    pub(super) faces: &'b [u32],
    pub(super) barycentric: &'b mut [[f32; 3]],
    pub(super) positions: &'b mut [[f32; 3]],
    pub(super) normals: &'b mut [[f32; 3]],
}

impl Values<'_> {
    pub(super) fn fill(self, corners: &Corners<'_, '_>, width: usize) {
        let mesh = corners.mesh;
        // Neighbours mostly have one face.
        let (mut last, mut place) = (NO_PRIMITIVE, [[0.0; 2]; 3]);
        for (at, &face) in self
            .faces
            .iter()
            .enumerate()
            .filter(|(_, f)| **f != NO_PRIMITIVE)
        {
            if face != last {
                (last, place) = (face, corners.of(face));
            }
            let centre = [at % width, self.top + at / width].map(|v| v as f64 + 0.5);
            let weights = weights(&place, centre);
            self.barycentric[at] = weights.map(|w| w as f32);
            let vertices = mesh.indices[face as usize];
            if let Some(position) = self.positions.get_mut(at) {
                *position = blend(mesh.positions, vertices, weights).map(|v| v as f32);
            }
            if let Some(normal) = self.normals.get_mut(at) {
                let n = blend(mesh.normals, vertices, weights);
                let length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
                *normal = if length > 0.0 {
                    n.map(|v| (v / length) as f32)
                } else {
                    [0.0; 3]
                };
            }
        }
    }
}

fn blend(values: &[[f32; 3]], vertices: [u32; 3], weights: [f64; 3]) -> [f64; 3] {
    let v = vertices.map(|i| values[i as usize].map(f64::from));
    [0, 1, 2].map(|k| v[0][k] * weights[0] + v[1][k] * weights[1] + v[2][k] * weights[2])
}

/// Faces in texels.
pub(super) struct Corners<'m, 'a> {
    pub(super) mesh: &'m AtlasMesh<'a>,
    pub(super) size: TargetSize,
}

impl Corners<'_, '_> {
    /// Texel positions, y down.
    pub(super) fn of(&self, face: u32) -> [[f64; 2]; 3] {
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        self.mesh.indices[face as usize].map(|i| {
            let [u, v] = self.mesh.uvs[i as usize].map(f64::from);
            [
                u * width,
                if self.mesh.bottom_up {
                    height - v * height
                } else {
                    v * height
                },
            ]
        })
    }

    /// The texels that a face may touch: none far outside, where i32 could not hold them, and for a face without
    /// area the one in the middle of its box.
    pub(super) fn reach(&self, face: u32) -> Option<Reach> {
        let corners = self.of(face);
        if !corners.iter().flatten().all(|v| v.abs() < 16_384.0 * 2.0) {
            return None;
        }
        let snapped: [Snapped; 3] =
            corners.map(|p| p.map(|v| texmap_math::float::round_half_up(v * ONE as f64) as i32));
        let range = |k: usize, side: u32| {
            let lo = snapped[0][k].min(snapped[1][k]).min(snapped[2][k]);
            let hi = snapped[0][k].max(snapped[1][k]).max(snapped[2][k]);
            // A side that ends on a texel's border does not touch the next one.
            let last = if hi > lo { (hi - 1) >> 8 } else { hi >> 8 };
            (lo >> 8).max(0)..last.min(side as i32 - 1) + 1
        };
        let (x, y) = (range(0, self.size.width()), range(1, self.size.height()));
        if x.is_empty() || y.is_empty() {
            return None;
        }
        let edges = edges(&snapped);
        let middle = |r: Range<i32>| match edges {
            Some(_) => r,
            None => {
                let middle = (r.start + r.end - 1) / 2;
                middle..middle + 1
            }
        };
        Some(Reach {
            x: middle(x),
            y: middle(y),
            edges,
        })
    }

    /// The faces that may touch each row of tiles, ascending.
    pub(super) fn by_band(&self) -> Vec<Vec<u32>> {
        let bands = self.size.height().div_ceil(TILE) as usize;
        let mut faces = alloc::vec![Vec::new(); bands];
        for face in 0..self.mesh.indices.len() as u32 {
            if let Some(reach) = self.reach(face) {
                let (first, last) = (reach.y.start as u32 / TILE, (reach.y.end - 1) as u32 / TILE);
                for band in &mut faces[first as usize..=last as usize] {
                    band.push(face);
                }
            }
        }
        faces
    }
}

/// A box of texels, and the edges of the face in it.
pub(super) struct Reach {
    pub(super) x: Range<i32>,
    pub(super) y: Range<i32>,
    /// `None` for a face without area, which touches all of its box.
    pub(super) edges: Option<[Edge; 3]>,
}

impl Reach {
    /// The texels of a row that the face touches.
    pub(super) fn row(&self, y: i32) -> Range<i32> {
        let mut row = i64::from(self.x.start)..i64::from(self.x.end);
        for edge in self.edges.iter().flatten() {
            let part = touched(*edge, y);
            row = row.start.max(part.start)..row.end.min(part.end);
        }
        // Ends within the box fit i32.
        let end = row.end.max(i64::from(self.x.start));
        row.start.min(end) as i32..end as i32
    }
}

/// Weights over the corners at a texel position, pulled into the face.
fn weights(corners: &[[f64; 2]; 3], [x, y]: [f64; 2]) -> [f64; 3] {
    let p = corners.map(|p| [p[0] - x, p[1] - y]);
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let b = [cross(p[1], p[2]), cross(p[2], p[0]), cross(p[0], p[1])];
    let area = b[0] + b[1] + b[2];
    if area == 0.0 || !area.is_finite() {
        return [1.0 / 3.0; 3];
    }
    let inside = b.map(|v| if v / area > 0.0 { v / area } else { 0.0 });
    let sum = inside[0] + inside[1] + inside[2];
    if sum > 0.0 {
        inside.map(|v| v / sum)
    } else {
        [1.0 / 3.0; 3]
    }
}

/// The texels of a row whose squares meet the open inner side of an edge: without the top-left rule, which is for points.
fn touched(edge: Edge, y: i32) -> Range<i64> {
    const ALL: Range<i64> = i32::MIN as i64..i32::MAX as i64;
    let half = ONE / 2;
    let top_left = edge.a > 0 || (edge.a == 0 && edge.b > 0);
    let c = edge.c + i64::from(!top_left);
    let at_0 = edge.a * centre(0) + edge.b * centre(y) + c + half * (edge.a.abs() + edge.b.abs());
    // at_0 + step x > 0 for whole x.
    let step = edge.a * ONE;
    match step {
        0 if at_0 > 0 => ALL,
        0 => 0..0,
        1.. => (-at_0).div_euclid(step) + 1..ALL.end,
        _ => ALL.start..-(-at_0).div_euclid(-step),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The touched part of a row is that of its texels one by one.
    #[test]
    fn rows_are_the_texels_that_a_face_touches() {
        let size = TargetSize::new(24, 20).unwrap();
        let mut seed = 5u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Often on borders and centres of texels, and outside.
            (seed >> 24) as f32 / 192.0 - 0.15
        };
        let uvs: Vec<[f32; 2]> = (0..900).map(|_| [next(), next()]).collect();
        let indices: Vec<[u32; 3]> = (0..300).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = AtlasMesh {
            uvs: &uvs,
            indices: &indices,
            ..AtlasMesh::default()
        };
        let corners = Corners { mesh: &mesh, size };
        let half = ONE / 2;
        let (mut touched, mut beside) = (0, 0);
        for face in 0..300 {
            let Some(reach) = corners.reach(face) else {
                continue;
            };
            for y in reach.y.clone() {
                let row = reach.row(y);
                for x in reach.x.clone() {
                    let alone = reach.edges.iter().flatten().all(|e| {
                        let top_left = e.a > 0 || (e.a == 0 && e.b > 0);
                        let at = e.a * centre(x) + e.b * centre(y) + e.c + i64::from(!top_left);
                        at + half * (e.a.abs() + e.b.abs()) > 0
                    });
                    assert_eq!(row.contains(&x), alone, "{face} {x} {y}");
                    touched += u32::from(alone);
                    beside += u32::from(!alone);
                }
            }
        }
        assert!(touched > 1000 && beside > 1000, "{touched} {beside}");
    }
}
