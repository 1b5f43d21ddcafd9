//! The part of a surface that has no area in the picture.

use super::ReportOptions;
use super::stretch::raw;
use crate::mesh::Mesh;
use crate::uv_set::UvSet;
use crate::{UvError, parallel};

/// Triangles that have area in space and none in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unmapped {
    /// Number of such triangles.
    pub triangles: usize,
    /// These triangles' part of the surface, 0 to 1.
    pub fraction: f64,
    /// The first face that has one.
    pub face: Option<u32>,
}

/// Triangles that have area in space and none in the picture. Drawn, each is a streak of one texel, and baked light there is
/// lost. A triangle counts when its area in the picture is less than a millionth of that of an equal area elsewhere. The same
/// bytes on any number of threads.
///
/// # Errors
/// A set that does not fit the mesh or is not finite.
pub fn unmapped(mesh: &Mesh<'_>, set: &UvSet) -> Result<Unmapped, UvError> {
    set.check(mesh)?;
    let faces = mesh.faces();
    let options = ReportOptions::default();
    let areas = parallel::collect_chunks(faces.len(), |range| {
        let triangles =
            range.flat_map(|f| faces.triangles_of(f).map(move |(_, corners)| (f, corners)));
        let areas = triangles.map(|(f, corners)| {
            let r = raw(mesh, set, corners, &options);
            (f as u32, r.space, r.picture.abs())
        });
        areas.collect()
    });
    let sum = |of: fn(&(u32, f64, f64)) -> f64| areas.iter().fold(0.0, |sum, a| sum + of(a));
    let (space, picture) = (sum(|a| a.1), sum(|a| a.2));
    let mut out = Unmapped::default();
    let least = picture / space * 1e-6;
    let without = |&&(_, own, mapped): &&(u32, f64, f64)| own > 0.0 && mapped <= own * least;
    for (face, area, _) in areas.iter().filter(without) {
        out.triangles += 1;
        out.fraction += area / space;
        out.face = out.face.or(Some(*face));
    }
    Ok(out)
}
