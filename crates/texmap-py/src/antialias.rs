//! Analytic antialiasing of silhouettes (Laine and others 2020, "Modular Primitives for High-Performance Differentiable
//! Rendering", section 3.5): pixels on both sides of a silhouette edge are blended by the place where it crosses the line between
//! their centres.

use std::collections::HashMap;

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;

use crate::rasterize::{Range, decode};
use crate::support::{expect_length, value};

/// Blends `color` of a batch into `out`.
#[pyfunction]
pub(crate) fn antialias(
    py: Python<'_>,
    color: PyReadonlyArray1<'_, f32>,
    rast: PyReadonlyArray1<'_, f32>,
    pos: PyReadonlyArray1<'_, f32>,
    tri: PyReadonlyArray1<'_, u32>,
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
    let out = out.as_slice_mut()?;
    let picture = size.0 * size.1;
    expect_length("rast", rast.len(), picture * ranges.len())?;
    expect_length("color", color.len(), rast.len() * channels)?;
    expect_length("out", out.len(), color.len())?;
    py.detach(|| {
        out.copy_from_slice(color);
        let edges = opposite_vertices(tri);
        for (k, range) in ranges.iter().enumerate() {
            let of = |values: usize| k * picture * values..(k + 1) * picture * values;
            let scene = Pictured {
                rast: &rast[of(1)],
                color: &color[of(channels)],
                pos: &pos[range.0..range.0 + range.1],
                tri,
                edges: &edges,
                size,
                channels,
            };
            scene.blend(&mut out[of(channels)])?;
        }
        Ok(())
    })
}

/// For each edge (its vertices in ascending order) the third vertices of its first two triangles; more are no manifold and count as
/// a silhouette.
type Edges = HashMap<(u32, u32), (u32, Option<u32>, bool)>;

fn opposite_vertices(tri: &[[u32; 3]]) -> Edges {
    let mut edges = Edges::with_capacity(tri.len() * 2);
    for &[a, b, c] in tri {
        for (p, q, third) in [(a, b, c), (b, c, a), (c, a, b)] {
            edges
                .entry((p.min(q), p.max(q)))
                .and_modify(|(_, second, more)| match second {
                    None => *second = Some(third),
                    Some(_) => *more = true,
                })
                .or_insert((third, None, false));
        }
    }
    edges
}

struct Pictured<'a> {
    rast: &'a [[f32; 4]],
    color: &'a [f32],
    pos: &'a [[f32; 4]],
    tri: &'a [[u32; 3]],
    edges: &'a Edges,
    size: (usize, usize),
    channels: usize,
}

impl Pictured<'_> {
    fn blend(&self, out: &mut [f32]) -> PyResult<()> {
        let (width, height) = self.size;
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                if x + 1 < width {
                    self.pair(at, at + 1, [x, y], false, out)?;
                }
                if y + 1 < height {
                    self.pair(at, at + width, [x, y], true, out)?;
                }
            }
        }
        Ok(())
    }

    /// Two neighbours, the second to the right of the first or above it.
    fn pair(
        &self,
        a: usize,
        b: usize,
        at: [usize; 2],
        above: bool,
        out: &mut [f32],
    ) -> PyResult<()> {
        let (first, second) = (self.rast[a], self.rast[b]);
        let ids = (decode(first[3]), decode(second[3]));
        if ids.0 == ids.1 {
            return Ok(());
        }
        // The nearer of the two owns the edge.
        let nearer_is_first = match ids {
            (Some(_), Some(_)) => first[2] < second[2],
            (first, _) => first.is_some(),
        };
        let triangle = if nearer_is_first { ids.0 } else { ids.1 };
        let Some(triangle) = triangle else {
            return Ok(());
        };
        let (near, far) = if nearer_is_first { (a, b) } else { (b, a) };
        let mut center = at.map(|c| c as f64 + 0.5);
        let axis = usize::from(above);
        let step = if nearer_is_first { 1.0 } else { -1.0 };
        if !nearer_is_first {
            center[axis] += 1.0;
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
        let tri = self.tri.get(triangle);
        let &[a, b, c] = tri.ok_or_else(|| {
            value(format!(
                "rast names triangle {triangle}, tri holds {}",
                self.tri.len()
            ))
        })?;
        let mut nearest = None;
        for (p, q, third) in [(a, b, c), (b, c, a), (c, a, b)] {
            let (Some(p2), Some(q2), Some(third)) =
                (self.screen(p)?, self.screen(q)?, self.screen(third)?)
            else {
                continue;
            };
            if !self.is_silhouette((p, q), p2, q2, third)? {
                continue;
            }
            let cross = 1 - axis;
            let (from, to) = (p2[cross] - center[cross], q2[cross] - center[cross]);
            // Half open, so that one of two edges at a vertex counts.
            if (from > 0.0) == (to > 0.0) {
                continue;
            }
            let along = p2[axis] + (q2[axis] - p2[axis]) * (from / (from - to));
            let place = (along - center[axis]) * step;
            if (0.0..=1.0).contains(&place) && nearest.is_none_or(|found| place < found) {
                nearest = Some(place);
            }
        }
        Ok(nearest)
    }

    /// True unless the triangles of an edge lie on both sides of it.
    fn is_silhouette(
        &self,
        (p, q): (u32, u32),
        p2: [f64; 2],
        q2: [f64; 2],
        own: [f64; 2],
    ) -> PyResult<bool> {
        let Some(&(first, second, more)) = self.edges.get(&(p.min(q), p.max(q))) else {
            return Ok(true);
        };
        let (Some(second), false) = (second, more) else {
            return Ok(true);
        };
        let side =
            |r: [f64; 2]| (q2[0] - p2[0]) * (r[1] - p2[1]) - (q2[1] - p2[1]) * (r[0] - p2[0]);
        let (Some(first), Some(second)) = (self.screen(first)?, self.screen(second)?) else {
            return Ok(false);
        };
        let other = if first == own { second } else { first };
        Ok((side(own) > 0.0) == (side(other) > 0.0))
    }

    /// A vertex in pixels from the lower left corner; `None` behind the eye.
    fn screen(&self, vertex: u32) -> PyResult<Option<[f64; 2]>> {
        let p = self.pos.get(vertex as usize);
        let p = p.ok_or_else(|| {
            value(format!(
                "tri names vertex {vertex}, there are {}",
                self.pos.len()
            ))
        })?;
        let [x, y, _, w] = p.map(f64::from);
        let (width, height) = (self.size.0 as f64, self.size.1 as f64);
        Ok((w > 0.0).then(|| [(x / w + 1.0) * 0.5 * width, (y / w + 1.0) * 0.5 * height]))
    }
}
