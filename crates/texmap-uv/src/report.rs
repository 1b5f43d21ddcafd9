//! How good a mapping is, in figures.
//!
//! Stretch after Sander, Snyder, Gortler and Hoppe (2001): the singular values of the map from the picture to space.

use alloc::vec::Vec;
use texmap_math::float;
use texmap_math::glam::DVec2;

use crate::mesh::{Mesh, UvSet, length};
use crate::overlap::{self, Flat};
use crate::shells::{MANY, RIM, Shells, Topology, edge_length};
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
    /// Length in space of the edges where the picture is interrupted.
    pub seam_length: f64,
    /// Mean share of that length which is seen, over 14 views from the axes and corners of a cube; NaN without
    /// views, 0 without seams.
    pub seam_seen: f64,
    /// Length in space of the mesh's own rim.
    pub rim_length: f64,
    /// Edges of more than two faces; they count as seams.
    pub non_manifold_edges: usize,
    /// Connected pieces of the picture.
    pub shells: usize,
    /// Vertices inside an edge of a face that does not have them, with the face.
    pub t_joints: Vec<TJoint>,
}

/// Sums over a chunk of triangles.
#[derive(Clone, Copy, Default)]
struct Sums {
    space: f64,
    picture: f64,
    l2: f64,
    angle: f64,
    area: f64,
    mapped: f64,
    density: f64,
}

/// Stretch of one triangle before it is normalised.
#[derive(Clone, Copy)]
struct Raw {
    corners: [usize; 3],
    face: u32,
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
    let list: Vec<(usize, [usize; 3])> = mesh.faces().triangles().collect();
    let raw = parallel::collect_chunks(list.len(), |range| {
        list[range]
            .iter()
            .map(|(f, c)| raw(mesh, set, *f, *c, options))
            .collect()
    });
    let (space, picture) = (total(&raw, |r| r.space), total(&raw, |r| r.picture.abs()));
    // The mean scale of the map: what stretch 1 means.
    let scale = if space > 0.0 {
        float::sqrt(picture / space)
    } else {
        0.0
    };
    let uv = |r: &Raw| r.corners.map(|k| set.at(k));
    let mut triangles: Vec<TriangleReport> = raw
        .iter()
        .map(|r| TriangleReport {
            density: (float::sqrt(r.picture.abs() / r.space) * f64::from(options.texture_size))
                as f32,
            outside: uv(r)
                .as_flattened()
                .iter()
                .any(|c| !(0.0..=1.0).contains(c)),
            ..normalised(r, scale)
        })
        .collect();

    let (flats, flat_of) = flats(set, &raw);
    let overlaps = overlap::find(&flats, None, false);
    for &i in &overlaps.triangles {
        triangles[flat_of[i as usize] as usize].overlapping = true;
    }
    let sums = parallel::map_chunks(raw.len(), |range| {
        range.fold(Sums::default(), |s, i| add(s, &raw[i], &triangles[i]))
    });
    let sums = sums.into_iter().fold(Sums::default(), |a, b| Sums {
        space: a.space + b.space,
        picture: a.picture + b.picture,
        l2: a.l2 + b.l2,
        angle: a.angle + b.angle,
        area: a.area + b.area,
        mapped: a.mapped + b.mapped,
        density: a.density + b.density,
    });
    let count =
        |test: &dyn Fn(&TriangleReport) -> bool| triangles.iter().filter(|t| test(t)).count();
    let largest = |value: &dyn Fn(&TriangleReport) -> f32| {
        triangles
            .iter()
            .map(|t| f64::from(value(t)))
            .filter(|v| v.is_finite())
            .fold(0.0, |a: f64, b| if b > a { b } else { a })
    };
    let topology = Topology::new(mesh);
    let seams = seams(mesh, set, &topology);
    let densities = densities(&raw, options.texture_size);
    let mean = |sum: f64, of: f64| if of > 0.0 { sum / of } else { f64::NAN };
    let collapsed = count(&|t| t.collapsed);
    Ok(Report {
        faces: mesh.faces().len(),
        degenerate: raw.iter().filter(|r| r.space == 0.0).count(),
        stretch_l2: if collapsed > 0 {
            f64::INFINITY
        } else {
            float::sqrt(mean(sums.l2, sums.space))
        },
        stretch_linf: if collapsed > 0 {
            f64::INFINITY
        } else {
            largest(&|t| t.linf)
        },
        angle_mean: mean(sums.angle, sums.mapped),
        angle_max: largest(&|t| t.angle),
        area_mean: mean(sums.area, sums.mapped),
        area_max: largest(&|t| t.area),
        density: [
            densities[0],
            mean(sums.density, sums.space) * f64::from(options.texture_size),
            densities[1],
        ],
        flipped: count(&|t| t.flipped),
        collapsed,
        overlapping: count(&|t| t.overlapping),
        overlap_pairs: overlaps.pairs,
        overlap_area: overlaps.area,
        overlap_at_least: overlaps.at_least,
        outside: count(&|t| t.outside),
        wide: raw.iter().filter(|r| wide(uv(r))).count(),
        picture_area: picture,
        surface_area: space,
        seam_length: lengths(mesh, &topology, seams.iter().copied()),
        seam_seen: if options.views {
            views::seen(mesh, &topology, &seams)
        } else {
            f64::NAN
        },
        rim_length: lengths(
            mesh,
            &topology,
            (0..topology.twin.len()).filter(|&k| topology.twin[k] == RIM),
        ),
        non_manifold_edges: non_manifold(mesh, &topology),
        shells: Shells::linked(mesh.faces().len(), &topology, |k| {
            meets(mesh, set, &topology, k)
        })
        .count,
        t_joints: t_joint::find(mesh, &topology),
        triangles,
    })
}

fn raw(
    mesh: &Mesh<'_>,
    set: &UvSet,
    face: usize,
    corners: [usize; 3],
    options: &ReportOptions,
) -> Raw {
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
            corners,
            face: face as u32,
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
        corners,
        face: face as u32,
        space,
        picture: sign * twice * 0.5,
        high,
        low,
    }
}

fn normalised(r: &Raw, scale: f64) -> TriangleReport {
    let (high, low) = (r.high * scale, r.low * scale);
    let area = high * low;
    let finite = r.high.is_finite();
    TriangleReport {
        face: r.face,
        corners: r.corners.map(|k| k as u32),
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

fn add(s: Sums, r: &Raw, t: &TriangleReport) -> Sums {
    if r.space == 0.0 || t.collapsed {
        return Sums {
            space: s.space + r.space,
            ..s
        };
    }
    let w = r.space;
    Sums {
        space: s.space + w,
        picture: s.picture + r.picture.abs(),
        l2: s.l2 + w * f64::from(t.l2) * f64::from(t.l2),
        angle: s.angle + w * f64::from(t.angle),
        area: s.area + w * f64::from(t.area),
        mapped: s.mapped + w,
        density: s.density + w * float::sqrt(r.picture.abs() / w),
    }
}

/// Sum in chunk order.
fn total(raw: &[Raw], value: impl Fn(&Raw) -> f64 + Sync + Send) -> f64 {
    parallel::map_chunks(raw.len(), |range| {
        raw[range].iter().map(&value).sum::<f64>()
    })
    .into_iter()
    .sum()
}

/// The triangles that have area in the picture, counter-clockwise, and which triangle each of them is.
fn flats(set: &UvSet, raw: &[Raw]) -> (Vec<Flat>, Vec<u32>) {
    let (mut flats, mut which) = (Vec::new(), Vec::new());
    for (i, r) in raw.iter().enumerate().filter(|(_, r)| r.picture != 0.0) {
        if let Some(flat) = Flat::new(set, r.face, r.corners) {
            flats.push(flat);
            which.push(i as u32);
        }
    }
    (flats, which)
}

fn wide(uv: [[f32; 2]; 3]) -> bool {
    (0..3).any(|k| (uv[k][0] - uv[(k + 1) % 3][0]).abs() > 0.5)
}

/// Lowest and highest texel density of triangles with area in space.
fn densities(raw: &[Raw], size: u32) -> [f64; 2] {
    let all = raw
        .iter()
        .filter(|r| r.space > 0.0)
        .map(|r| float::sqrt(r.picture.abs() / r.space) * f64::from(size));
    let range = all.fold([f64::INFINITY, 0.0], |[low, high], d| {
        [
            if d < low { d } else { low },
            if d > high { d } else { high },
        ]
    });
    if range[0].is_finite() {
        range
    } else {
        [f64::NAN; 2]
    }
}

/// Sum of the lengths of edges; a plain sum of none would be -0.
fn lengths(mesh: &Mesh<'_>, topology: &Topology, edges: impl Iterator<Item = usize>) -> f64 {
    edges.fold(0.0, |sum, k| sum + edge_length(mesh, topology, k))
}

/// The edges, each named by one corner, where two faces meet in space but not in the picture.
fn seams(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> Vec<usize> {
    parallel::collect_chunks(topology.twin.len(), |range| {
        let is_seam = |k: &usize| match topology.twin[*k] {
            RIM => false,
            MANY => true,
            twin => (*k as u32) < twin && !meets(mesh, set, topology, *k),
        };
        range.filter(is_seam).collect()
    })
}

/// As [`Topology::joined`], but equal coordinates count as one whatever their index: the picture goes on there.
fn meets(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology, k: usize) -> bool {
    let here = [k, topology.next[k] as usize].map(|c| set.at(c));
    topology
        .across(mesh, k)
        .is_some_and(|there| there.map(|c| set.at(c)) == here)
}

fn non_manifold(mesh: &Mesh<'_>, topology: &Topology) -> usize {
    let mut edges: Vec<[u32; 2]> = (0..topology.twin.len())
        .filter(|&k| topology.twin[k] == MANY)
        .map(|k| {
            let [a, b] = [k, topology.next[k] as usize]
                .map(|k| topology.welded[mesh.faces().corners()[k] as usize]);
            [a.min(b), a.max(b)]
        })
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges.len()
}
