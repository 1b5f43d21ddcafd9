//! The fill rule: a mesh that tiles a rectangle covers each pixel centre in it exactly once (property 28).

use proptest::prelude::*;
use texmap_math::edge::{Edge, TriangleEdges};
use texmap_math::fixed::{FixedPoint, LIMIT, SUBPIXEL_ONE, snap, snap_point};
use texmap_math::glam::DVec2;

use crate::strategies::config;

const CELLS: i32 = 5;
/// Pixels of a cell.
const CELL: i32 = 6;
const SIDE: i32 = CELLS * CELL;

/// A mesh of jittered cells, in 24.8; its border is a straight rectangle at an offset of its own.
#[derive(Clone, Debug)]
struct Mesh {
    points: Vec<FixedPoint>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// `grid` is the coarsest step of the jitter: 128 puts many vertices and edges exactly on pixel centres.
    fn new(
        offset: (i32, i32),
        jitter: &[(i32, i32)],
        diagonals: &[bool],
        turns: &[bool],
        grid: i32,
    ) -> Self {
        let index = |i: i32, j: i32| (j * (CELLS + 1) + i) as usize;
        let mut points = Vec::new();
        for j in 0..=CELLS {
            for i in 0..=CELLS {
                let (dx, dy) = jitter[index(i, j)];
                let round = |d: i32| d / grid * grid;
                // Less than a quarter cell, so that no cell folds; only along the border at the border.
                let dx = if i == 0 || i == CELLS { 0 } else { round(dx) };
                let dy = if j == 0 || j == CELLS { 0 } else { round(dy) };
                points.push(FixedPoint {
                    x: i * CELL * SUBPIXEL_ONE + dx + offset.0,
                    y: j * CELL * SUBPIXEL_ONE + dy + offset.1,
                });
            }
        }
        let mut triangles = Vec::new();
        for j in 0..CELLS {
            for i in 0..CELLS {
                let (a, b, c, d) = (
                    index(i, j),
                    index(i + 1, j),
                    index(i + 1, j + 1),
                    index(i, j + 1),
                );
                let cell = (j * CELLS + i) as usize;
                let halves = if diagonals[cell] {
                    [[a, b, c], [c, d, a]]
                } else {
                    [[b, c, d], [d, a, b]]
                };
                for mut half in halves {
                    if turns[cell] {
                        half.swap(0, 1);
                    }
                    triangles.push(half);
                }
            }
        }
        Self { points, triangles }
    }

    fn moved(&self, pixels: (i32, i32)) -> Self {
        let mut mesh = self.clone();
        for p in &mut mesh.points {
            p.x += pixels.0 * SUBPIXEL_ONE;
            p.y += pixels.1 * SUBPIXEL_ONE;
        }
        mesh
    }

    /// Number of triangles that cover each pixel of a window around the rectangle, by a rule.
    fn counts(
        &self,
        at: (i32, i32),
        rule: impl Fn(&TriangleEdges, FixedPoint) -> bool,
    ) -> Vec<u32> {
        let edges: Vec<_> = self
            .triangles
            .iter()
            .filter_map(|t| TriangleEdges::new(t.map(|i| self.points[i])))
            .collect();
        let window = -2..SIDE + 3;
        let mut counts = Vec::new();
        for y in window.clone() {
            for x in window.clone() {
                let p = FixedPoint::pixel_centre(at.0 + x, at.1 + y);
                counts.push(edges.iter().filter(|e| rule(e, p)).count() as u32);
            }
        }
        counts
    }

    /// 1 inside the rectangle, its left and top border included, 0 outside.
    fn want(&self, at: (i32, i32)) -> Vec<u32> {
        let (low, high) = (self.points[0], self.points[self.points.len() - 1]);
        let window = -2..SIDE + 3;
        let mut want = Vec::new();
        for y in window.clone() {
            for x in window.clone() {
                let p = FixedPoint::pixel_centre(at.0 + x, at.1 + y);
                want.push(u32::from(
                    p.x >= low.x && p.x < high.x && p.y >= low.y && p.y < high.y,
                ));
            }
        }
        want
    }
}

fn mesh() -> impl Strategy<Value = Mesh> {
    let points = ((CELLS + 1) * (CELLS + 1)) as usize;
    let cells = (CELLS * CELLS) as usize;
    let quarter = CELL * SUBPIXEL_ONE / 4 - 1;
    (
        (0..SUBPIXEL_ONE, 0..SUBPIXEL_ONE),
        prop::collection::vec((-quarter..=quarter, -quarter..=quarter), points),
        prop::collection::vec(any::<bool>(), cells),
        prop::collection::vec(any::<bool>(), cells),
        prop::sample::select(vec![1, 32, 128]),
    )
        .prop_map(|(offset, jitter, diagonals, turns, grid)| {
            let offset = (offset.0 / grid * grid, offset.1 / grid * grid);
            Mesh::new(offset, &jitter, &diagonals, &turns, grid)
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..config() })]

    #[test]
    fn shared_edges_cover_once(mesh in mesh(), by in (-3000..3000i32, -3000..3000i32)) {
        let counts = mesh.counts((0, 0), TriangleEdges::covers);
        prop_assert_eq!(&counts, &mesh.want((0, 0)));
        // Whole pixels further on: the same picture.
        prop_assert_eq!(&mesh.moved(by).counts(by, TriangleEdges::covers), &counts);
    }

    /// Edges are exact and antisymmetric: the shared edge of two triangles is one number with two signs.
    #[test]
    fn edges_are_antisymmetric(p in [(-1.0..1.0f64, -1.0..1.0f64), (-1.0..1.0, -1.0..1.0), (-1.0..1.0, -1.0..1.0)]) {
        let [a, b, q] = p.map(|p| snap_point(DVec2::from(p) * LIMIT).expect("in range"));
        let (there, back) = (Edge::new(a, b), Edge::new(b, a));
        prop_assert_eq!(there.at(q), -back.at(q));
        prop_assert_eq!(there.at(a), 0);
        prop_assert_eq!(there.at(b), 0);
        prop_assert_eq!(there.top_left, !back.top_left);
        let exact = i128::from(b.x - a.x) * i128::from(q.y - a.y) - i128::from(b.y - a.y) * i128::from(q.x - a.x);
        prop_assert_eq!(i128::from(there.at(q)), exact);
        let (dx, dy) = there.pixel_steps();
        let step = FixedPoint { x: q.x / 2 + SUBPIXEL_ONE, y: q.y / 2 };
        let from = FixedPoint { x: q.x / 2, y: q.y / 2 };
        prop_assert_eq!(there.at(step) - there.at(from), dx);
        prop_assert_eq!(there.at(FixedPoint { x: from.x, y: from.y + SUBPIXEL_ONE }) - there.at(from), dy);
    }
}

/// Without the rule the same meshes show double hits (edges inclusive) or cracks (exclusive).
#[test]
fn without_the_top_left_rule_shared_edges_show() {
    let cells = (CELLS * CELLS) as usize;
    let jitter = vec![(0, 0); ((CELLS + 1) * (CELLS + 1)) as usize];
    // Everything on pixel centres.
    let mesh = Mesh::new(
        (128, 128),
        &jitter,
        &vec![true; cells],
        &vec![false; cells],
        128,
    );
    let every = |limit: i64| {
        move |e: &TriangleEdges, p: FixedPoint| e.edges.iter().all(|e| e.at(p) >= limit)
    };
    let want = mesh.want((0, 0));
    assert_eq!(mesh.counts((0, 0), TriangleEdges::covers), want);
    let inclusive = mesh.counts((0, 0), every(0));
    assert!(inclusive.iter().filter(|c| **c > 1).count() > 100);
    let exclusive = mesh.counts((0, 0), every(1));
    assert!(exclusive.iter().zip(&want).filter(|(c, w)| c < w).count() > 100);
}

/// MIT 6.837, lecture 18: a quad of 56 x 56 pixels drawn with inclusive edges hits its diagonal twice, 57 pixels of it.
#[test]
fn the_lectures_quad_draws_its_diagonal_twice() {
    let corner = |x: i32, y: i32| FixedPoint::pixel_centre(4 + 56 * x, 4 + 56 * y);
    let halves = [
        [corner(0, 0), corner(1, 0), corner(1, 1)],
        [corner(1, 1), corner(0, 1), corner(0, 0)],
    ];
    let halves = halves.map(|h| TriangleEdges::new(h).expect("area"));
    let double = |rule: &dyn Fn(&TriangleEdges, FixedPoint) -> bool| {
        (0..64)
            .flat_map(|y| (0..64).map(move |x| FixedPoint::pixel_centre(x, y)))
            .filter(|p| halves.iter().all(|h| rule(h, *p)))
            .count()
    };
    assert_eq!(double(&|e, p| e.edges.iter().all(|e| e.at(p) >= 0)), 57);
    assert_eq!(double(&TriangleEdges::covers), 0);
}

#[test]
fn snapping_refuses_what_it_cannot_hold() {
    assert_eq!(snap(0.5), Some(128));
    assert_eq!(snap(-0.5 / 256.0), Some(0), "halves go up");
    assert_eq!(snap(0.5 / 256.0), Some(1));
    assert_eq!(snap(LIMIT), Some(LIMIT as i32 * SUBPIXEL_ONE));
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, LIMIT * 1.001, 1e30] {
        assert_eq!(snap(bad), None);
    }
    let p = FixedPoint { x: 7, y: 9 };
    assert_eq!(
        TriangleEdges::new([p, p, FixedPoint { x: 100, y: 3 }]),
        None,
        "no area"
    );
}
