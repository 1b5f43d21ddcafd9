//! Tangent frames after Mikkelsen (2008), by the crate bevy_mikktspace with texmap's arc cosine.

use alloc::vec;
use alloc::vec::Vec;
use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use texmap_math::glam::DVec3;
use texmap_math::{det, float};

use crate::UvError;
use crate::mesh::{Mesh, UvSet, unit_or_zero};

/// The tangent of every corner: a unit vector along growing u, square to the normal, and in the fourth place the
/// sign of the bitangent, `sign * cross(normal, tangent)`.
///
/// `normals` has one entry per corner; one of zero length is replaced by the normal of its face. Faces of more than
/// four corners are treated as their fan. Where the picture says nothing (no area, and no neighbour that has some)
/// the tangent is some unit vector square to the normal; never NaN. The bitangent points along growing v: down the
/// picture where v = 0 is the top.
///
/// # Errors
/// A set or normals that do not fit the mesh.
pub fn tangents(
    mesh: &Mesh<'_>,
    set: &UvSet,
    normals: &[[f32; 3]],
) -> Result<Vec<[f32; 4]>, UvError> {
    set.check(mesh)?;
    let corners = mesh.faces().corners().len();
    if normals.len() != corners {
        return Err(UvError::WrongLength {
            what: "the list of normals",
            found: normals.len(),
            expected: corners,
        });
    }
    let clean = clean_normals(mesh, normals);
    let mut pieces = Vec::new();
    for face in 0..mesh.faces().len() {
        let r = mesh.faces().range(face);
        if r.len() <= 4 {
            pieces.push(r.collect::<Vec<usize>>());
        } else {
            pieces.extend((r.start + 1..r.end - 1).map(|k| vec![r.start, k, k + 1]));
        }
    }
    let mut work = Work {
        mesh,
        set,
        normals: &clean,
        pieces,
        out: vec![None; corners],
    };
    // The only error of the generator is its own bookkeeping; the corners then keep their fallback.
    let _ = generate_tangents(&mut work);
    Ok(work
        .out
        .iter()
        .zip(&clean)
        .map(|(t, n)| {
            t.and_then(|t| square(t, *n))
                .unwrap_or_else(|| fallback(*n))
        })
        .collect())
}

fn clean_normals(mesh: &Mesh<'_>, normals: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut clean = Vec::with_capacity(normals.len());
    for face in 0..mesh.faces().len() {
        let own = unit_or_zero(mesh.face_normal(face));
        for k in mesh.faces().range(face) {
            let n = unit_or_zero(DVec3::from(normals[k].map(f64::from)));
            let n = if n != DVec3::ZERO {
                n
            } else if own != DVec3::ZERO {
                own
            } else {
                DVec3::Y
            };
            clean.push(n.to_array().map(|c| c as f32));
        }
    }
    clean
}

/// A tangent of unit length, if it is finite and not along the normal.
fn square(t: [f32; 4], n: [f32; 3]) -> Option<[f32; 4]> {
    let (v, n) = (
        DVec3::new(t[0].into(), t[1].into(), t[2].into()),
        DVec3::from(n.map(f64::from)),
    );
    let v = unit_or_zero(v - n * n.dot(v));
    (v != DVec3::ZERO).then(|| {
        [
            v.x as f32,
            v.y as f32,
            v.z as f32,
            if t[3] < 0.0 { -1.0 } else { 1.0 },
        ]
    })
}

/// Square to the normal, from the axis that it is farthest from.
fn fallback(n: [f32; 3]) -> [f32; 4] {
    let n = DVec3::from(n.map(f64::from));
    let a = n.abs();
    let axis = if a.x <= a.y && a.x <= a.z {
        DVec3::X
    } else if a.y <= a.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let t = unit_or_zero(axis - n * n.dot(axis));
    [t.x as f32, t.y as f32, t.z as f32, 1.0]
}

struct Exact;

impl Ops for Exact {
    fn sqrt(x: f32) -> f32 {
        float::sqrt_f32(x)
    }

    fn acos(x: f32) -> f32 {
        det::acos(f64::from(x)) as f32
    }
}

struct Work<'a> {
    mesh: &'a Mesh<'a>,
    set: &'a UvSet,
    normals: &'a [[f32; 3]],
    /// Corners of each triangle or quad.
    pieces: Vec<Vec<usize>>,
    out: Vec<Option<[f32; 4]>>,
}

impl Geometry<Exact> for Work<'_> {
    fn num_faces(&self) -> usize {
        self.pieces.len()
    }

    fn num_vertices_of_face(&self, face: usize) -> usize {
        self.pieces[face].len()
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions()[self.mesh.faces().corners()[self.pieces[face][vert]] as usize]
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.normals[self.pieces[face][vert]]
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.set.at(self.pieces[face][vert])
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, vert: usize) {
        // A corner of several fan triangles keeps the first.
        let corner = self.pieces[face][vert];
        if self.out[corner].is_none() {
            self.out[corner] = tangent.map(|t| t.tangent_encoded());
        }
    }
}
