//! Triangles of a picture that lie on one another, by exact clipping.

use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use texmap_math::glam::DVec2;

use crate::mesh::Mesh;
use crate::tree::{BoxTree, Meter, search_each, steps_for};
use crate::uv_set::UvSet;
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

/// Triangles that overlap another of a different face, with the area.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlaps {
    /// Pairs that share area.
    pub pairs: u64,
    /// The pairs' common area, summed over the pairs; the whole picture is 1.
    pub area: f64,
    /// The pairs' triangles (of the faces' fans, in order), ascending, each once.
    pub triangles: Vec<u32>,
    /// The later faces of the pairs, ascending, each once.
    pub(crate) later: Vec<u32>,
    /// Faces that were not compared with all others.
    pub(crate) unfinished: Vec<u32>,
    /// Too many triangles lie at one point to compare them all: the numbers are lower bounds.
    pub at_least: bool,
}

/// The overlap test of [`crate::report`] alone: exact clipping, at most n log n steps for n triangles on any input (where
/// very many lie at one point, not every pair is compared), the same on any number of threads.
///
/// # Errors
/// A set that does not fit the mesh or is not finite.
pub fn overlaps(mesh: &Mesh<'_>, set: &UvSet) -> Result<Overlaps, UvError> {
    set.check(mesh)?;
    let faces = mesh.faces();
    let flats = parallel::collect_chunks(faces.len(), |range| {
        let fans = range.flat_map(|f| {
            faces
                .triangles_of(f)
                .map(move |(i, corners)| (f, i, corners))
        });
        fans.filter_map(|(f, i, corners)| Flat::new(set, f, i, corners))
            .collect()
    });
    Ok(find(&flats, None))
}

/// Steps of a search that the comparison of two triangles counts for.
const CLIP: u64 = 16;

/// Finds all overlapping pairs of triangles that are sorted by their faces. Two triangles overlap when their common area
/// exceeds a billionth of the smaller one, which neighbours along an edge never do. With `group` only triangles whose faces
/// share a group count.
pub(crate) fn find(triangles: &[Flat], group: Option<&[u32]>) -> Overlaps {
    let search = Search::new(triangles, group);
    let marks =
        || -> Vec<AtomicBool> { triangles.iter().map(|_| AtomicBool::new(false)).collect() };
    let (meets, is_later) = (marks(), marks());
    let (found, open) = search.each(|i, meter, out| {
        let (mut pairs, mut shared) = (0, 0.0);
        let done = search.from(i, meter, |j, common| {
            pairs += 1;
            shared += common;
            meets[i].store(true, Relaxed);
            meets[j].store(true, Relaxed);
            is_later[j].store(true, Relaxed);
        });
        if pairs > 0 {
            out.push((pairs, shared));
        }
        done
    });
    let mut all = Overlaps {
        at_least: !open.is_empty(),
        unfinished: search.faces(&open),
        ..Overlaps::default()
    };
    for (_, (pairs, area)) in found {
        all.pairs += pairs;
        all.area += area;
    }
    for (k, triangle) in triangles.iter().enumerate() {
        if meets[k].load(Relaxed) {
            all.triangles.push(triangle.index);
        }
        if is_later[k].load(Relaxed) {
            all.later.push(triangle.face);
        }
    }
    all.later.dedup();
    all
}

/// The faces of the pairs that [`find`] finds, the later one first, ascending; and those not compared with all others.
pub(crate) fn pairs(triangles: &[Flat], group: Option<&[u32]>) -> (Vec<[u32; 2]>, Vec<u32>) {
    let search = Search::new(triangles, group);
    let (found, open) = search.each(|i, meter, out| {
        search.from(i, meter, |j, _| {
            out.push([triangles[j].face, triangles[i].face]);
        })
    });
    let mut pairs: Vec<[u32; 2]> = found.into_iter().map(|(_, pair)| pair).collect();
    pairs.sort_unstable();
    pairs.dedup();
    (pairs, search.faces(&open))
}

/// Triangles of the picture in a tree.
struct Search<'a> {
    triangles: &'a [Flat],
    group: Option<&'a [u32]>,
    tree: BoxTree,
}

impl<'a> Search<'a> {
    fn new(triangles: &'a [Flat], group: Option<&'a [u32]>) -> Self {
        let items = (0..triangles.len() as u32).collect();
        let tree = BoxTree::new(items, |i| {
            let (low, high) = bounds(&triangles[i as usize]);
            [low.extend(0.0), high.extend(0.0)]
        });
        Self {
            triangles,
            group,
            tree,
        }
    }

    fn each<T: Send>(
        &self,
        search: impl Fn(usize, &mut Meter, &mut Vec<T>) -> bool + Sync + Send,
    ) -> (Vec<(u32, T)>, Vec<u32>) {
        let count = self.triangles.len();
        search_each(count, steps_for(count), search)
    }

    fn faces(&self, items: &[u32]) -> Vec<u32> {
        let face = |i: &u32| self.triangles[*i as usize].face;
        items.iter().map(face).collect()
    }

    /// The later triangles that overlap the `i`th, with the common areas; false if the meter ran out.
    fn from(&self, i: usize, meter: &mut Meter, mut found: impl FnMut(usize, f64)) -> bool {
        let a = &self.triangles[i];
        let (low, high) = bounds(a);
        let meets = |l: DVec2, h: DVec2| l.x < high.x && low.x < h.x && l.y < high.y && low.y < h.y;
        self.tree.search(
            meter,
            |[l, h]| meets(l.truncate(), h.truncate()),
            |j, meter| {
                let b = &self.triangles[j as usize];
                let mut group = self.group.iter();
                let apart = group.any(|g| g[a.face as usize] != g[b.face as usize]);
                let (l, h) = bounds(b);
                if j as usize <= i || a.face == b.face || apart || !meets(l, h) {
                    return true;
                }
                if !meter.take(CLIP) {
                    return false;
                }
                let common = common_area(&a.corners, &b.corners);
                if common > area(&a.corners).min(area(&b.corners)) * 1e-9 {
                    found(j as usize, common);
                }
                true
            },
        )
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
        let free = find(&strip(false), None);
        assert_eq!((free.pairs, free.area, free.triangles.len()), (0, 0.0, 0));
        let folded = find(&strip(true), None);
        assert_eq!((folded.pairs, folded.triangles.len()), (40, 80));
        assert!((folded.area - 20.0 * 0.037 * 0.1).abs() < 1e-12);
        let groups: Vec<u32> = (0..80).map(|f| f / 40).collect();
        assert_eq!(find(&strip(true), Some(&groups)).pairs, 0);
    }

    #[test]
    fn a_crowd_is_a_lower_bound_and_nothing_is_nothing() {
        let crowd: Vec<Flat> = (0..12_000)
            .map(|f| flat(f, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
            .collect();
        let found = find(&crowd, None);
        assert!(found.at_least && found.triangles.len() == 12_000);
        assert_eq!(find(&[], None), Overlaps::default());
        let points: Vec<Flat> = (0..5).map(|f| flat(f, [[0.5, 0.5]; 3])).collect();
        assert_eq!(find(&points, None).pairs, 0);
    }
}
