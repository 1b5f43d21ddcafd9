//! Report: figures that say how good a mapping is.

mod edges;
mod stretch;
mod triangles;
mod unmapped;

use alloc::vec::Vec;
use texmap_math::float;

use crate::mesh::Mesh;
use crate::overlap::{self, Flat};
use crate::uv_set::UvSet;
use crate::{Origin, TJunctions, UvError, parallel};
use edges::Edges;
use stretch::raw;
use triangles::each_triangle;

pub use unmapped::{Unmapped, unmapped};

/// Options of a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportOptions {
    /// The row at v = 0: it decides what counts as flipped.
    pub origin: Origin,
    /// Edge of the picture in texels, for the texel density.
    pub texture_size: u32,
    /// Look for the seams from 14 sides.
    pub views: bool,
}

impl Default for ReportOptions {
    /// Top-left origin, 1024 texels, with views.
    fn default() -> Self {
        Self {
            origin: Origin::TopLeft,
            texture_size: 1024,
            views: true,
        }
    }
}

/// One triangle of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleReport {
    /// The face of the triangle.
    pub face: u32,
    /// Indices of its corners in the list of corners.
    pub corners: [u32; 3],
    /// Root mean square stretch over all directions; 1 where the picture keeps lengths on average over the mesh,
    /// infinite where the triangle has no area in the picture.
    pub l2: f32,
    /// Largest stretch over all directions, in the same units.
    pub linf: f32,
    /// Largest over smallest stretch: 1 keeps angles.
    pub angle: f32,
    /// Area in space over area in the picture or its inverse, whichever is larger, relative to the whole mesh: 1
    /// keeps areas.
    pub area: f32,
    /// Texels per unit of length: the root of its area in the picture over that in space, times the picture's size.
    /// NaN without area in space.
    pub density: f32,
    /// The triangle has a corner outside [0, 1].
    pub outside: bool,
    /// The triangle's area in the picture is negative.
    pub flipped: bool,
    /// The triangle has area in space but none in the picture.
    pub collapsed: bool,
    /// The triangle lies on a triangle of another face.
    pub overlapping: bool,
}

/// The figures of a mapping. Lengths and areas "in space" are in object units.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of faces.
    pub faces: usize,
    /// One entry per triangle.
    pub triangles: Vec<TriangleReport>,
    /// Triangles without area in space; they count in nothing else.
    pub degenerate: usize,
    /// Area-weighted root mean square of the stretch; 1 is best. Infinite if a triangle has no area in the picture.
    pub stretch_l2: f64,
    /// Largest stretch.
    pub stretch_linf: f64,
    /// Area-weighted mean of the angle distortion, over triangles with area in the picture; 1 is best.
    pub angle_mean: f64,
    /// Largest angle distortion, likewise.
    pub angle_max: f64,
    /// Area-weighted mean of the area distortion, likewise.
    pub area_mean: f64,
    /// Largest area distortion, likewise.
    pub area_max: f64,
    /// Texels per unit: lowest, area-weighted mean, highest.
    pub density: [f64; 3],
    /// Triangles of negative area in the picture.
    pub flipped: usize,
    /// Triangles without area in the picture.
    pub collapsed: usize,
    /// Triangles that lie on one of another face.
    pub overlapping: usize,
    /// Pairs of such triangles.
    pub overlap_pairs: u64,
    /// Common area of these pairs in the picture, summed over pairs; the whole picture is 1.
    pub overlap_area: f64,
    /// So many triangles lie at one point that the overlap figures are lower bounds.
    pub overlap_at_least: bool,
    /// Triangles with a corner outside [0, 1].
    pub outside: usize,
    /// Triangles with a difference of u above 0.5, as one torn by a seam has.
    pub wide: usize,
    /// Area of the picture that triangles cover, overlaps counted as often as they occur.
    pub picture_area: f64,
    /// Area in space.
    pub surface_area: f64,
    /// Length in space of the edges where the picture is interrupted, each edge once.
    pub seam_length: f64,
    /// Mean share of that length which is seen, over 14 views from the axes and corners of a cube. NaN without
    /// views, 0 without seams.
    pub seam_seen: f64,
    /// Length in space of the mesh's own rim.
    pub rim_length: f64,
    /// Edges of more than two faces; they count as seams.
    pub non_manifold_edges: usize,
    /// Connected pieces of the picture with area in space.
    pub islands: usize,
    /// Vertices inside an edge of a face that does not have them, with the face.
    pub t_junctions: TJunctions,
}

/// Looks at a mapping. At most n log n steps for n corners on any input; the same bytes on any number of threads.
///
/// # Errors
/// A set that does not fit the mesh or is not finite.
pub fn report(mesh: &Mesh<'_>, set: &UvSet, options: &ReportOptions) -> Result<Report, UvError> {
    set.check(mesh)?;
    let faces = mesh.faces();
    // First the areas alone and the triangles of the picture: the stretch of each triangle is relative to the whole.
    let parts = parallel::map_chunks(faces.len(), |range| {
        let (mut areas, mut flats) = ([0.0; 2], Vec::with_capacity(range.len()));
        for face in range {
            for (index, corners) in faces.triangles_of(face) {
                let r = raw(mesh, set, corners, options);
                areas[0] += r.space;
                areas[1] += r.picture.abs();
                if r.picture != 0.0 {
                    flats.extend(Flat::new(set, face, index, corners));
                }
            }
        }
        (areas, flats)
    });
    let [space, picture] = parts.iter().fold([0.0; 2], |sum, (areas, _)| {
        [sum[0] + areas[0], sum[1] + areas[1]]
    });
    let flats: Vec<Flat> = parallel::concat(parts.into_iter().map(|(_, flats)| flats));
    // The mean scale of the map: what stretch 1 means.
    let scale = if space > 0.0 {
        float::sqrt(picture / space)
    } else {
        0.0
    };
    let (overlaps, (edges, each)) = parallel::join(
        || overlap::find(&flats, None),
        || {
            parallel::join(
                || Edges::new(mesh, set, options),
                || each_triangle(mesh, set, options, scale),
            )
        },
    );
    let (mut triangles, sums) = each;
    for &i in &overlaps.triangles {
        triangles[i as usize].overlapping = true;
    }
    let mean = |sum: f64, of: f64| if of > 0.0 { sum / of } else { f64::NAN };
    let size = f64::from(options.texture_size);
    let [least, most] = match sums.density_range {
        [low, high] if low <= high => [low * size, high * size],
        _ => [f64::NAN; 2],
    };
    let finite = |value: f64| {
        if sums.collapsed > 0 {
            f64::INFINITY
        } else {
            value
        }
    };
    Ok(Report {
        faces: faces.len(),
        degenerate: sums.degenerate,
        stretch_l2: finite(float::sqrt(mean(sums.l2, sums.space))),
        stretch_linf: finite(sums.linf_max),
        angle_mean: mean(sums.angle, sums.mapped),
        angle_max: sums.angle_max,
        area_mean: mean(sums.area, sums.mapped),
        area_max: sums.area_max,
        density: [least, mean(sums.density, sums.space) * size, most],
        flipped: sums.flipped,
        collapsed: sums.collapsed,
        overlapping: overlaps.triangles.len(),
        overlap_pairs: overlaps.pairs,
        overlap_area: overlaps.area,
        overlap_at_least: overlaps.at_least,
        outside: sums.outside,
        wide: sums.wide,
        picture_area: picture,
        surface_area: space,
        seam_length: edges.seam_length,
        seam_seen: edges.seam_seen,
        rim_length: edges.rim_length,
        non_manifold_edges: edges.non_manifold,
        islands: edges.islands,
        t_junctions: edges.t_joints,
        triangles,
    })
}
