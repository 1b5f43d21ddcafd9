//! Triangles of a picture that lie on one another, by exact clipping.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::float;
use texmap_math::glam::DVec2;

use crate::mesh::{Mesh, UvSet};
use crate::{UvError, parallel};

/// A triangle in the picture, counter-clockwise, with the face it belongs to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flat {
    pub(crate) corners: [DVec2; 3],
    pub(crate) face: u32,
    /// Number of the triangle in [`crate::Faces::triangles`].
    pub(crate) index: u32,
}

impl Flat {
    /// `None` for a triangle without area in the picture.
    pub(crate) fn new(set: &UvSet, face: usize, index: u32, corners: [usize; 3]) -> Option<Self> {
        let [p, q, r] = corners.map(|k| DVec2::from(set.at(k).map(f64::from)));
        let (e, f) = (q - p, r - p);
        let twice = e.perp_dot(f);
        // Rounding of f32 coordinates leaves a sliver where the exact triangle has no area.
        let longest = e.dot(e).max(f.dot(f)).max((f - e).dot(f - e));
        let corners = if twice > 0.0 { [p, q, r] } else { [p, r, q] };
        (twice.abs() > longest * 1e-12).then_some(Self {
            corners,
            face: face as u32,
            index,
        })
    }
}

/// Which triangles overlap another of a different face, and by how much.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlaps {
    /// Pairs that share area.
    pub pairs: u64,
    /// Their common area, summed over the pairs; the whole picture is 1.
    pub area: f64,
    /// The pairs' triangles (of the faces' fans, in order), ascending, each once.
    pub triangles: Vec<u32>,
    /// The pairs' faces, the lower one first, if they were asked for.
    pub(crate) list: Vec<[u32; 2]>,
    /// Too many triangles lie in one place to compare them all: the numbers are lower bounds.
    pub at_least: bool,
}

/// The overlap test of [`crate::report`] alone: exact clipping, linear in the triangles unless very many lie in one
/// place, the same on any number of threads.
///
/// # Errors
/// A set that does not fit the mesh or is not finite.
pub fn overlaps(mesh: &Mesh<'_>, set: &UvSet) -> Result<Overlaps, UvError> {
    set.check(mesh)?;
    let faces = mesh.faces();
    let flats = parallel::collect_chunks(faces.len(), |range| {
        let fans = range.flat_map(|f| faces.fan(f).map(move |(i, corners)| (f, i, corners)));
        fans.filter_map(|(f, i, corners)| Flat::new(set, f, i, corners))
            .collect()
    });
    Ok(find(&flats, None, false))
}

/// Where one cell holds more triangles than this, each is compared with this many others only.
const CROWD: usize = 1024;

/// Finds all overlapping pairs. Two triangles overlap when their common area exceeds a billionth of the smaller
/// one, which neighbours along an edge never do. With `group` only triangles whose faces share a group count.
pub(crate) fn find(triangles: &[Flat], group: Option<&[u32]>, keep_pairs: bool) -> Overlaps {
    let Some(grid) = Grid::new(triangles) else {
        return Overlaps::default();
    };
    let found = parallel::map_chunks(grid.cells(), |range| {
        let mut out = Overlaps::default();
        for cell in range {
            let members = grid.members(cell);
            out.at_least |= members.len() > CROWD;
            for (n, &i) in members.iter().enumerate() {
                for &j in members[n + 1..].iter().take(CROWD) {
                    let (a, b) = (&triangles[i as usize], &triangles[j as usize]);
                    let apart = group.is_some_and(|g| g[a.face as usize] != g[b.face as usize]);
                    if a.face == b.face || apart || grid.owner(a, b) != Some(cell) {
                        continue;
                    }
                    let (area, least) = (
                        common_area(&a.corners, &b.corners),
                        area(&a.corners).min(area(&b.corners)),
                    );
                    if area > least * 1e-9 {
                        out.pairs += 1;
                        out.area += area;
                        out.triangles.extend([a.index, b.index]);
                        if keep_pairs {
                            out.list.push([a.face.min(b.face), a.face.max(b.face)]);
                        }
                    }
                }
            }
        }
        out
    });
    let mut all = Overlaps::default();
    for part in found {
        all.pairs += part.pairs;
        all.area += part.area;
        all.triangles.extend(part.triangles);
        all.list.extend(part.list);
        all.at_least |= part.at_least;
    }
    all.triangles.sort_unstable();
    all.triangles.dedup();
    all.list.sort_unstable();
    all
}

/// Cells about as large as the triangles, each with the triangles whose bounding boxes touch it.
struct Grid {
    low: DVec2,
    per_unit: DVec2,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Grid {
    fn new(triangles: &[Flat]) -> Option<Self> {
        let first = triangles.first()?.corners[0];
        let (mut low, mut high, mut sides) = (first, first, DVec2::ZERO);
        for t in triangles {
            let (l, h) = bounds(t);
            (low, high) = (low.min(l), high.max(h));
            sides += h - l;
        }
        let (extent, mean) = (high - low, sides / triangles.len() as f64);
        // No more cells than triangles on the whole, whatever the extents are.
        let most = float::ceil(float::sqrt(triangles.len() as f64));
        let count = |extent: f64, side: f64| {
            let cells = if side > 0.0 { extent / side } else { most };
            if cells < 1.0 {
                1.0
            } else if cells < most {
                float::floor(cells)
            } else {
                most
            }
        };
        let cells = DVec2::new(count(extent.x, mean.x), count(extent.y, mean.y));
        let rate = |cells: f64, extent: f64| if extent > 0.0 { cells / extent } else { 0.0 };
        let mut grid = Self {
            low,
            per_unit: DVec2::new(rate(cells.x, extent.x), rate(cells.y, extent.y)),
            columns: cells.x as usize,
            rows: cells.y as usize,
            starts: vec![0; cells.x as usize * cells.y as usize + 1],
            members: Vec::new(),
        };
        let each = |triangle: &Flat, act: &mut dyn FnMut(usize)| {
            let (l, h) = bounds(triangle);
            let ((x0, y0), (x1, y1)) = (grid.cell(l), grid.cell(h));
            for y in y0..=y1 {
                for x in x0..=x1 {
                    act(y * grid.columns + x);
                }
            }
        };
        let mut counts = vec![0u32; grid.columns * grid.rows + 1];
        for t in triangles {
            each(t, &mut |cell| counts[cell + 1] += 1);
        }
        for cell in 1..counts.len() {
            counts[cell] += counts[cell - 1];
        }
        let mut fill = counts.clone();
        let mut members = vec![0; counts[counts.len() - 1] as usize];
        for (i, t) in triangles.iter().enumerate() {
            each(t, &mut |cell| {
                members[fill[cell] as usize] = i as u32;
                fill[cell] += 1;
            });
        }
        (grid.starts, grid.members) = (counts, members);
        Some(grid)
    }

    fn cells(&self) -> usize {
        self.columns * self.rows
    }

    fn members(&self, cell: usize) -> &[u32] {
        &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    fn cell(&self, p: DVec2) -> (usize, usize) {
        let at = (p - self.low) * self.per_unit;
        (
            (at.x as usize).min(self.columns - 1),
            (at.y as usize).min(self.rows - 1),
        )
    }

    /// The one cell that counts a pair: that of the lower left corner of the boxes' intersection.
    fn owner(&self, a: &Flat, b: &Flat) -> Option<usize> {
        let ((al, ah), (bl, bh)) = (bounds(a), bounds(b));
        let (low, high) = (al.max(bl), ah.min(bh));
        (low.x < high.x && low.y < high.y).then(|| {
            let (x, y) = self.cell(low);
            y * self.columns + x
        })
    }
}

fn bounds(t: &Flat) -> (DVec2, DVec2) {
    let [a, b, c] = t.corners;
    (a.min(b).min(c), a.max(b).max(c))
}

fn area(t: &[DVec2; 3]) -> f64 {
    (t[1] - t[0]).perp_dot(t[2] - t[0]).abs() * 0.5
}

/// Area of the intersection of two counter-clockwise triangles (Sutherland and Hodgman 1974).
fn common_area(a: &[DVec2; 3], b: &[DVec2; 3]) -> f64 {
    // Relative to a corner, so that small triangles far out lose nothing.
    let mut polygon = [DVec2::ZERO; 9];
    let mut count = 3;
    for k in 0..3 {
        polygon[k] = b[k] - a[0];
    }
    for k in 0..3 {
        let (from, to) = (a[k] - a[0], a[(k + 1) % 3] - a[0]);
        let side = |p: DVec2| (to - from).perp_dot(p - from);
        let (mut out, mut kept) = ([DVec2::ZERO; 9], 0);
        for i in 0..count {
            let (p, q) = (polygon[i], polygon[(i + 1) % count]);
            let (sp, sq) = (side(p), side(q));
            if sp >= 0.0 {
                out[kept] = p;
                kept += 1;
            }
            if (sp > 0.0 && sq < 0.0) || (sp < 0.0 && sq > 0.0) {
                out[kept] = p + (q - p) * (sp / (sp - sq));
                kept += 1;
            }
        }
        (polygon, count) = (out, kept);
        if count < 3 {
            return 0.0;
        }
    }
    let twice: f64 = (1..count - 1)
        .map(|k| (polygon[k] - polygon[0]).perp_dot(polygon[k + 1] - polygon[0]))
        .sum();
    twice.abs() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(face: u32, c: [[f64; 2]; 3]) -> Flat {
        Flat {
            corners: c.map(DVec2::from),
            face,
            index: face,
        }
    }

    #[test]
    fn common_areas_are_exact() {
        let a = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(DVec2::from);
        assert_eq!(common_area(&a, &a), 0.5);
        let moved = a.map(|p| p + DVec2::new(0.5, 0.0));
        assert_eq!(common_area(&a, &moved), 0.125);
        let beside = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from);
        assert_eq!(common_area(&a, &beside), 0.0);
        let star = [[0.0, 0.25], [1.0, 0.25], [0.5, -0.75]].map(DVec2::from);
        let turned = [star[2], star[1], star[0]];
        assert!(common_area(&a, &turned) > 0.15);
    }

    /// A strip of squares is free of overlaps; folded back onto itself every triangle meets others.
    #[test]
    fn neighbours_do_not_overlap_and_folds_do() {
        let strip = |fold: bool| -> Vec<Flat> {
            (0..40u32)
                .flat_map(|i| {
                    let x = 0.037 * f64::from(if fold { i % 20 } else { i });
                    let (l, r) = (x, x + 0.037);
                    [
                        flat(2 * i, [[l, 0.1], [r, 0.1], [r, 0.2]]),
                        flat(2 * i + 1, [[l, 0.1], [r, 0.2], [l, 0.2]]),
                    ]
                })
                .collect()
        };
        let free = find(&strip(false), None, true);
        assert_eq!((free.pairs, free.area, free.triangles.len()), (0, 0.0, 0));
        let folded = find(&strip(true), None, true);
        assert_eq!((folded.pairs, folded.triangles.len()), (40, 80));
        assert!((folded.area - 20.0 * 0.037 * 0.1).abs() < 1e-12);
        let groups: Vec<u32> = (0..80).map(|f| f / 40).collect();
        assert_eq!(find(&strip(true), Some(&groups), false).pairs, 0);
    }

    #[test]
    fn a_crowd_is_a_lower_bound_and_nothing_is_nothing() {
        let crowd: Vec<Flat> = (0..3000)
            .map(|f| flat(f, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
            .collect();
        let found = find(&crowd, None, false);
        assert!(found.at_least && found.triangles.len() == 3000);
        assert_eq!(find(&[], None, true), Overlaps::default());
        let points: Vec<Flat> = (0..5).map(|f| flat(f, [[0.5, 0.5]; 3])).collect();
        assert_eq!(find(&points, None, true).pairs, 0);
    }
}
