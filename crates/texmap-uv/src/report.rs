//! How good a mapping is, in figures.
//!
//! Stretch after Sander, Snyder, Gortler and Hoppe (2001): the singular values of the map from the picture to space.

use alloc::vec::Vec;
use texmap_math::float;
use texmap_math::glam::DVec2;

use crate::mesh::{Mesh, UvSet, length};
use crate::overlap::{self, Flat};
use crate::shells::Shells;
use crate::topology::{MANY, RIM, Topology, edge_length};
use crate::{Origin, TJoint, UvError, parallel, t_joint, views};

/// What to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportOptions {
    /// Which row is v = 0: it decides what counts as flipped.
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

/// One triangle of the fan of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleReport {
    /// Its face.
    pub face: u32,
    /// Places of its corners in the list of corners.
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
    /// It has a corner outside [0, 1].
    pub outside: bool,
    /// Its area in the picture is negative.
    pub flipped: bool,
    /// It has area in space but none in the picture.
    pub collapsed: bool,
    /// It lies on a triangle of another face.
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
    /// Their common area in the picture, summed over pairs; the whole picture is 1.
    pub overlap_area: f64,
    /// So many triangles lie in one place that the overlap figures are lower bounds.
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
    /// Mean share of that length which is seen, over 14 views from the axes and corners of a cube; NaN without
    /// views, 0 without seams.
    pub seam_seen: f64,
    /// Length in space of the mesh's own rim.
    pub rim_length: f64,
    /// Edges of more than two faces; they count as seams.
    pub non_manifold_edges: usize,
    /// Connected pieces of the picture with area in space.
    pub shells: usize,
    /// Vertices inside an edge of a face that does not have them, with the face.
    pub t_joints: Vec<TJoint>,
}

/// Sums, counts and ranges over triangles.
#[derive(Clone, Copy)]
struct Sums {
    degenerate: usize,
    flipped: usize,
    collapsed: usize,
    outside: usize,
    wide: usize,
    space: f64,
    l2: f64,
    angle: f64,
    area: f64,
    /// Area in space of the triangles with area in the picture.
    mapped: f64,
    density: f64,
    linf_max: f64,
    angle_max: f64,
    area_max: f64,
    /// Lowest and highest root of the area in the picture over that in space; none yet when the first is the larger.
    density_range: [f64; 2],
}

/// Stretch of one triangle before it is normalised.
#[derive(Clone, Copy)]
struct Raw {
    space: f64,
    /// Signed.
    picture: f64,
    high: f64,
    low: f64,
}

/// Looks at a mapping. Linear in the number of triangles unless very many lie in one place; the same bytes on any
/// number of threads.
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
            for (index, corners) in faces.fan(face) {
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
        || overlap::find(&flats, None, false),
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
        shells: edges.shells,
        t_joints: edges.t_joints,
        triangles,
    })
}

/// What the report says about edges.
struct Edges {
    seam_length: f64,
    seam_seen: f64,
    rim_length: f64,
    non_manifold: usize,
    shells: usize,
    t_joints: Vec<TJoint>,
}

impl Edges {
    fn new(mesh: &Mesh<'_>, set: &UvSet, options: &ReportOptions) -> Self {
        let topology = Topology::new(mesh);
        let seams = seams(mesh, set, &topology);
        let rim = (0..topology.twin.len()).filter(|&k| topology.twin[k] == RIM);
        Self {
            seam_length: lengths(mesh, &topology, seams.iter().copied()),
            seam_seen: if options.views {
                views::seen(mesh, &topology, &seams)
            } else {
                f64::NAN
            },
            rim_length: lengths(mesh, &topology, rim),
            non_manifold: non_manifold(mesh, &topology).len(),
            shells: shells(mesh, set, &topology),
            t_joints: t_joint::find(mesh, &topology),
        }
    }
}

/// All triangles, and their sums in the order of chunks.
fn each_triangle(
    mesh: &Mesh<'_>,
    set: &UvSet,
    options: &ReportOptions,
    scale: f64,
) -> (Vec<TriangleReport>, Sums) {
    let faces = mesh.faces();
    let parts = parallel::map_chunks(faces.len(), |range| {
        let (mut triangles, mut sums) = (Vec::with_capacity(range.len()), Sums::NONE);
        for face in range {
            for (_, corners) in faces.fan(face) {
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

fn raw(mesh: &Mesh<'_>, set: &UvSet, corners: [usize; 3], options: &ReportOptions) -> Raw {
    let [a, b, c] = corners.map(|k| mesh.point(k));
    let [p, q, r] = corners.map(|k| DVec2::from(set.at(k).map(f64::from)));
    let (e1, e2, f1, f2) = (b - a, c - a, q - p, r - p);
    let twice = f1.perp_dot(f2);
    let space = length(e1.cross(e2)) * 0.5;
    let sign = if options.origin == Origin::TopLeft {
        -1.0
    } else {
        1.0
    };
    // Rounding of f32 coordinates leaves a sliver where the exact triangle has no area.
    let longest = f1.dot(f1).max(f2.dot(f2)).max((f2 - f1).dot(f2 - f1));
    if space == 0.0 || twice.abs() <= longest * 1e-12 {
        return Raw {
            space,
            picture: 0.0,
            high: f64::INFINITY,
            low: 0.0,
        };
    }
    // Derivatives of the position along u and v, and the singular values of the pair.
    let (su, sv) = (
        (e1 * f2.y - e2 * f1.y) / twice,
        (e2 * f1.x - e1 * f2.x) / twice,
    );
    let (x, y, z) = (su.dot(su), su.dot(sv), sv.dot(sv));
    let root = float::sqrt((x - z) * (x - z) + 4.0 * y * y);
    let high = float::sqrt((x + z + root) * 0.5);
    // The smaller one by the area: the difference under its own root loses all digits on slivers.
    let low = space * 2.0 / twice.abs() / high;
    Raw {
        space,
        picture: sign * twice * 0.5,
        high,
        low,
    }
}

/// The stretch of a triangle where 1 is that of the whole mesh; its place is left open.
fn normalised(r: &Raw, scale: f64) -> TriangleReport {
    let (high, low) = (r.high * scale, r.low * scale);
    let area = high * low;
    let finite = r.high.is_finite();
    TriangleReport {
        face: 0,
        corners: [0; 3],
        l2: if finite {
            float::sqrt((high * high + low * low) * 0.5) as f32
        } else {
            f32::INFINITY
        },
        linf: if finite { high as f32 } else { f32::INFINITY },
        angle: if finite {
            (r.high / r.low) as f32
        } else {
            f32::INFINITY
        },
        area: if finite {
            (if area > 1.0 { area } else { 1.0 / area }) as f32
        } else {
            f32::INFINITY
        },
        density: f32::NAN,
        outside: false,
        flipped: r.picture < 0.0,
        collapsed: r.space > 0.0 && r.picture == 0.0,
        overlapping: false,
    }
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

/// Sum of the lengths of edges; a plain sum of none would be -0.
fn lengths(mesh: &Mesh<'_>, topology: &Topology, edges: impl Iterator<Item = usize>) -> f64 {
    edges.fold(0.0, |sum, k| sum + edge_length(mesh, topology, k))
}

/// The edges, each named by one corner, where two faces meet in space but not in the picture, or more than two meet.
fn seams(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> Vec<usize> {
    let mut torn = parallel::collect_chunks(topology.twin.len(), |range| {
        let seam = |k: usize| match topology.twin[k] {
            RIM | MANY => None,
            twin => ((k as u32) < twin && !meets(mesh, set, topology, k))
                .then(|| topology.name(mesh, k)),
        };
        range.filter_map(seam).collect()
    });
    // Torn on both sides of a face without area, it is one seam.
    torn.sort_unstable();
    torn.dedup();
    torn.extend(non_manifold(mesh, topology));
    torn
}

/// As [`Topology::joined`], but equal coordinates count as one whatever their index: the picture goes on there.
fn meets(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology, k: usize) -> bool {
    let here = [k, topology.next[k] as usize].map(|c| set.at(c));
    topology
        .across(mesh, k)
        .is_some_and(|there| there.map(|c| set.at(c)) == here)
}

/// One corner of each edge of more than two faces.
fn non_manifold(mesh: &Mesh<'_>, topology: &Topology) -> Vec<usize> {
    let mut edges: Vec<([u32; 2], usize)> = (0..topology.twin.len())
        .filter(|&k| topology.twin[k] == MANY)
        .map(|k| (topology.ends(mesh, k), k))
        .collect();
    edges.sort_unstable();
    edges.dedup_by_key(|(ends, _)| *ends);
    edges.into_iter().map(|(_, k)| k).collect()
}

/// Pieces of the picture that have area in space.
fn shells(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> usize {
    let shells = Shells::linked(mesh.faces().len(), topology, |k| {
        meets(mesh, set, topology, k)
    });
    let mut has_area = alloc::vec![false; shells.count];
    for (face, shell) in shells.of_face.iter().enumerate() {
        let known = &mut has_area[*shell as usize];
        *known = *known || length(mesh.face_normal(face)) > 0.0;
    }
    has_area.iter().filter(|has| **has).count()
}
