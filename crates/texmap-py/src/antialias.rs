//! Analytic antialiasing of silhouettes (Laine and others 2020, "Modular Primitives for High-Performance Differentiable
//! Rendering", section 3.5): pixels on both sides of a silhouette edge are blended by the place where it crosses the line between
//! their centres.

use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;

use crate::planes::decode;
use crate::rast::Range;
use crate::support::{expect_length, value};

/// Beyond an edge of one triangle.
const NOTHING: u32 = u32::MAX;

/// Beyond an edge of more than two triangles: a silhouette from every side.
const MANY: u32 = u32::MAX - 1;

/// For each corner of each triangle the vertex beyond the opposite edge, [`NOTHING`] or [`MANY`]. Three values a triangle.
#[pyfunction]
pub(crate) fn topology<'py>(
    py: Python<'py>,
    tri: PyReadonlyArray1<'py, u32>,
) -> PyResult<Bound<'py, PyArray1<u32>>> {
    let tri = tri.as_slice()?.as_chunks::<3>().0;
    let found = py.detach(|| {
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * tri.len());
        for (k, corners) in tri.iter().enumerate() {
            for c in 0..3 {
                let (p, q) = (corners[(c + 1) % 3], corners[(c + 2) % 3]);
                edges.push(([p.min(q), p.max(q)], (3 * k + c) as u32));
            }
        }
        edges.sort_unstable();
        let mut beyond = vec![NOTHING; edges.len()];
        let third = |corner: u32| tri[corner as usize / 3][corner as usize % 3];
        for equal in edges.chunk_by(|a, b| a.0 == b.0) {
            match equal {
                [_] => {}
                &[(_, a), (_, b)] => {
                    beyond[a as usize] = third(b);
                    beyond[b as usize] = third(a);
                }
                more => more.iter().for_each(|(_, a)| beyond[*a as usize] = MANY),
            }
        }
        beyond
    });
    Ok(PyArray1::from_vec(py, found))
}

/// Blends `color` of a batch into `out`; `beyond` comes from [`topology`].
#[pyfunction]
pub(crate) fn antialias(
    py: Python<'_>,
    color: PyReadonlyArray1<'_, f32>,
    rast: PyReadonlyArray1<'_, f32>,
    pos: PyReadonlyArray1<'_, f32>,
    tri: PyReadonlyArray1<'_, u32>,
    beyond: PyReadonlyArray1<'_, u32>,
    ranges: Vec<Range>,
    size: (usize, usize),
    channels: usize,
    mut out: PyReadwriteArray1<'_, f32>,
) -> PyResult<()> {
    let (color, rast) = (color.as_slice()?, rast.as_slice()?.as_chunks::<4>().0);
    let (pos, tri) = (
        pos.as_slice()?.as_chunks::<4>().0,
        tri.as_slice()?.as_chunks::<3>().0,
    );
    let beyond = beyond.as_slice()?.as_chunks::<3>().0;
    let out = out.as_slice_mut()?;
    let picture = size.0 * size.1;
    expect_length("rast", rast.len(), picture * ranges.len())?;
    expect_length("color", color.len(), rast.len() * channels)?;
    expect_length("out", out.len(), color.len())?;
    expect_length("topology_hash", beyond.len(), tri.len())?;
    py.detach(|| {
        out.copy_from_slice(color);
        for (k, range) in ranges.iter().enumerate() {
            let of = |values: usize| k * picture * values..(k + 1) * picture * values;
            let screen = on_screen(&pos[range.0..range.0 + range.1], size);
            let scene = Pictured {
                rast: &rast[of(1)],
                color: &color[of(channels)],
                edges: silhouettes(tri, beyond, &screen)?,
                size,
                channels,
            };
            scene.blend(&mut out[of(channels)])?;
        }
        Ok(())
    })
}

/// A vertex in pixels from the lower left corner; `None` behind the eye.
type Screen = Option<[f64; 2]>;

fn on_screen(pos: &[[f32; 4]], (width, height): (usize, usize)) -> Vec<Screen> {
    let place = |p: &[f32; 4]| {
        let [x, y, _, w] = p.map(f64::from);
        let (width, height) = (width as f64, height as f64);
        (w > 0.0).then(|| [(x / w + 1.0) * 0.5 * width, (y / w + 1.0) * 0.5 * height])
    };
    pos.iter().map(place).collect()
}

/// The ends of the edges of each triangle that are silhouettes: those of one triangle, of many, or of two on the same side.
type Silhouettes = Vec<[Option<[[f64; 2]; 2]>; 3]>;

fn silhouettes(tri: &[[u32; 3]], beyond: &[[u32; 3]], screen: &[Screen]) -> PyResult<Silhouettes> {
    let at = |vertex: u32| {
        let found = screen.get(vertex as usize).copied();
        found.ok_or_else(|| {
            value(format!(
                "tri names vertex {vertex}, there are {}",
                screen.len()
            ))
        })
    };
    let mut all = vec![[None; 3]; tri.len()];
    for ((corners, beyond), out) in tri.iter().zip(beyond).zip(&mut all) {
        let places = [at(corners[0])?, at(corners[1])?, at(corners[2])?];
        let [Some(a), Some(b), Some(c)] = places else {
            continue;
        };
        for (k, (own, p, q)) in [(a, b, c), (b, c, a), (c, a, b)].into_iter().enumerate() {
            let side = |r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            let is_one = match beyond[k] {
                NOTHING | MANY => true,
                other => at(other)?.is_some_and(|other| (side(own) > 0.0) == (side(other) > 0.0)),
            };
            out[k] = is_one.then_some([p, q]);
        }
    }
    Ok(all)
}

struct Pictured<'a> {
    rast: &'a [[f32; 4]],
    color: &'a [f32],
    edges: Silhouettes,
    size: (usize, usize),
    channels: usize,
}

impl Pictured<'_> {
    fn blend(&self, out: &mut [f32]) -> PyResult<()> {
        let (width, height) = self.size;
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                if x + 1 < width && self.rast[at][3] != self.rast[at + 1][3] {
                    self.pair(at, at + 1, [x, y], 0, out)?;
                }
                if y + 1 < height && self.rast[at][3] != self.rast[at + width][3] {
                    self.pair(at, at + width, [x, y], 1, out)?;
                }
            }
        }
        Ok(())
    }

    /// Two neighbours of different triangles, the second to the right of the first (`axis` 0) or above it (1).
    fn pair(
        &self,
        a: usize,
        b: usize,
        at: [usize; 2],
        axis: usize,
        out: &mut [f32],
    ) -> PyResult<()> {
        let (first, second) = (self.rast[a], self.rast[b]);
        // The nearer of the two owns the edge.
        let (near, far, triangle) = match (decode(first[3]), decode(second[3])) {
            (Some(_), Some(two)) if first[2] >= second[2] => (b, a, two),
            (Some(one), _) => (a, b, one),
            (None, Some(two)) => (b, a, two),
            (None, None) => return Ok(()),
        };
        let mut center = at.map(|c| c as f64 + 0.5);
        let mut step = 1.0;
        if near == b {
            center[axis] += 1.0;
            step = -1.0;
        }
        let Some(crossing) = self.crossing(triangle, center, axis, step)? else {
            return Ok(());
        };
        // At the middle nothing changes; beyond it the nearer surface covers a part of the other pixel.
        let (to, from, weight) = match crossing > 0.5 {
            true => (far, near, crossing - 0.5),
            false => (near, far, 0.5 - crossing),
        };
        for c in 0..self.channels {
            let [to, from] = [to, from].map(|k| k * self.channels + c);
            out[to] += weight as f32 * (self.color[from] - self.color[to]);
        }
        Ok(())
    }

    /// The place, 0 to 1 from a centre to its neighbour, at which a silhouette edge of a triangle crosses.
    fn crossing(
        &self,
        triangle: usize,
        center: [f64; 2],
        axis: usize,
        step: f64,
    ) -> PyResult<Option<f64>> {
        let edges = self.edges.get(triangle);
        let edges = edges.ok_or_else(|| {
            value(format!(
                "rast names triangle {triangle}, tri holds {}",
                self.edges.len()
            ))
        })?;
        let cross = 1 - axis;
        let mut nearest = None;
        for [p, q] in edges.iter().flatten() {
            let (from, to) = (p[cross] - center[cross], q[cross] - center[cross]);
            // Half open, so that one of two edges at a vertex counts.
            if (from > 0.0) == (to > 0.0) {
                continue;
            }
            let along = p[axis] + (q[axis] - p[axis]) * (from / (from - to));
            let place = (along - center[axis]) * step;
            if (0.0..=1.0).contains(&place) && nearest.is_none_or(|found| place < found) {
                nearest = Some(place);
            }
        }
        Ok(nearest)
    }
}
