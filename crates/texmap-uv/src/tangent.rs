//! Tangent frames of MikkTSpace. Source: Mikkelsen (2008), "Simulation of Wrinkled Surfaces Revisited".
//!
//! The same tangents as that program and its port bevy_mikktspace, which the tests hold against it, with texmap's arc cosine.
//! Neither of them is used: their time grows with the square of the triangles around a vertex and of those without area, and
//! their recursion ends in an overflow of the stack where very many triangles lie around one vertex.

mod groups;
mod sums;
mod triangles;

use alloc::vec::Vec;
use core::ops::Range;
use texmap_math::glam::DVec3;

use self::triangles::Input;
use crate::UvError;
use crate::mesh::{Mesh, unit_or_zero};
use crate::parallel::collect_chunks;
use crate::uv_set::UvSet;

/// The tangent of every corner: a unit vector along growing u, square to the normal, and as the fourth component the
/// sign of the bitangent, `sign * cross(normal, tangent)`.
///
/// `normals` has one entry per corner; one of zero length is replaced by the normal of its face. Faces of more than
/// four corners are treated as their fan. If the picture says nothing (no area, and no neighbour that has some)
/// the tangent is MikkTSpace's default, x with the sign -1, made square to the normal; never NaN. The bitangent points along
/// growing v: down the picture where v = 0 is the top. At most n log n steps on any input: around a vertex of more than 64
/// triangles, tangents that are exactly opposite are summed with the others, which MikkTSpace keeps apart.
///
/// At few corners of crumpled surfaces the rule of MikkTSpace is unstable: two triangles that lie in one plane and are folded over have
/// opposite tangents to the last bit or not, and are kept apart or summed accordingly. There the last bit of a normal turns the tangent
/// by up to a half circle, in bevy_mikktspace by itself as well (47 of 803,136 corners of a cow whose triangles were cut twice into four
/// and shaken, all of its normals one step larger). Programs agree there only if their normals are the same bits.
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
    let found = sums::corner_tangents(&Input {
        mesh,
        set,
        normals: &clean,
    });
    Ok(collect_chunks(corners, |chunk| {
        let corners = found[chunk.clone()].iter().zip(&clean[chunk]);
        corners
            .map(|(t, n)| {
                t.and_then(|(t, upright)| square(t.to_array(), *n, upright))
                    .unwrap_or_else(|| fallback(*n))
            })
            .collect()
    }))
}

/// Normals of unit length. One that is nearly that, as a file of few digits has it, stays as it is: the rule reads normals
/// without changing them, and where tangents all but cancel each other their last bits decide.
fn clean_normals(mesh: &Mesh<'_>, normals: &[[f32; 3]]) -> Vec<[f32; 3]> {
    collect_chunks(mesh.faces().len(), |chunk| {
        clean_normals_of(mesh, normals, chunk)
    })
}

fn clean_normals_of(mesh: &Mesh<'_>, normals: &[[f32; 3]], chunk: Range<usize>) -> Vec<[f32; 3]> {
    let mut clean = Vec::new();
    for face in chunk {
        let own = || unit_or_zero(mesh.face_normal(face));
        for k in mesh.faces().range(face) {
            let given = DVec3::from(normals[k].map(f64::from));
            clean.push(if (given.dot(given) - 1.0).abs() < 1.0 / 128.0 {
                normals[k]
            } else {
                let or = |a: DVec3, b: DVec3| if a == DVec3::ZERO { b } else { a };
                let n = or(or(unit_or_zero(given), own()), DVec3::Y);
                n.to_array().map(|c| c as f32)
            });
        }
    }
    clean
}

/// A tangent of unit length and square to the normal with its sign, if it is finite and not along the normal.
fn square(t: [f32; 3], n: [f32; 3], upright: bool) -> Option<[f32; 4]> {
    let v = DVec3::from(t.map(f64::from));
    let n = unit_or_zero(DVec3::from(n.map(f64::from)));
    let v = unit_or_zero(v - n * n.dot(v));
    let [x, y, z] = v.to_array().map(|c| c as f32);
    (v != DVec3::ZERO).then_some([x, y, z, if upright { 1.0 } else { -1.0 }])
}

/// The rule's own default, x and the sign -1, made square to the normal; y where the normal lies along x.
fn fallback(n: [f32; 3]) -> [f32; 4] {
    let along_x = n[1] * n[1] + n[2] * n[2] < 1e-6;
    let axis = if along_x {
        [0.0, 1.0, 0.0]
    } else {
        [1.0, 0.0, 0.0]
    };
    let [x, y, z] = axis;
    square(axis, n, false).unwrap_or([x, y, z, -1.0])
}
