//! Vertex attributes at rasterized pixels, and the gradient with respect to them.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::planes::decode;
use crate::support::{Threads, expect_length, unlocked, value};

/// Pixels that one task does.
const TASK: usize = 1 << 13;

/// A triangle's vertices, checked against the arrays.
fn corners(tri: &[[u32; 3]], triangle: usize, vertices: usize) -> PyResult<[usize; 3]> {
    let found = tri.get(triangle).copied();
    let found = found.ok_or_else(|| {
        value(format!(
            "rast names triangle {triangle}, tri holds {}: pass the tri that was rasterized",
            tri.len()
        ))
    })?;
    match found.iter().find(|i| **i as usize >= vertices) {
        None => Ok(found.map(|i| i as usize)),
        Some(index) => Err(value(format!(
            "tri[{triangle}] names vertex {index}, there are {vertices}"
        ))),
    }
}

/// Attributes of `batch` pictures into `out`, and the derivatives of the channels in `diff` into `out_da`. `attr` holds one set of
/// `vertices` x `channels` values for all pictures, or one for each.
#[pyfunction]
#[pyo3(signature = (attr, shape, rast, tri, rast_db, diff, out, out_da, batch, threads))]
pub(crate) fn interpolate(
    py: Python<'_>,
    attr: PyReadonlyArray1<'_, f32>,
    shape: (usize, usize),
    rast: PyReadonlyArray1<'_, f32>,
    tri: PyReadonlyArray1<'_, u32>,
    rast_db: Option<PyReadonlyArray1<'_, f32>>,
    diff: Vec<usize>,
    mut out: PyReadwriteArray1<'_, f32>,
    mut out_da: PyReadwriteArray1<'_, f32>,
    batch: usize,
    threads: Option<Threads>,
) -> PyResult<()> {
    let (vertices, channels) = shape;
    let (attr, rast) = (attr.as_slice()?, rast.as_slice()?.as_chunks::<4>().0);
    let tri = tri.as_slice()?.as_chunks::<3>().0;
    let db = match &rast_db {
        Some(array) => array.as_slice()?.as_chunks::<4>().0,
        None => &[],
    };
    let (out, out_da) = (out.as_slice_mut()?, out_da.as_slice_mut()?);
    expect_length("out", out.len(), rast.len() * channels)?;
    let pairs = 2 * diff.len();
    expect_length("out_da", out_da.len(), rast.len() * pairs)?;
    if pairs > 0 {
        expect_length("rast_db", db.len(), rast.len())?;
    }
    let picture = rast.len() / batch.max(1);
    let shared = attr.len() == vertices * channels;
    if channels == 0 || rast.is_empty() {
        return Ok(());
    }
    let task = |(k, (pixels, out)): (usize, (&[[f32; 4]], &mut [f32])), da: &mut [f32]| {
        for (n, (pixel, out)) in pixels
            .iter()
            .zip(out.chunks_exact_mut(channels))
            .enumerate()
        {
            let at = k * TASK + n;
            let da = &mut da[n * pairs..(n + 1) * pairs];
            let Some(triangle) = decode(pixel[3]) else {
                out.fill(0.0);
                da.fill(0.0);
                continue;
            };
            let set = if shared { 0 } else { at / picture * vertices };
            let rows = corners(tri, triangle, vertices)?.map(|i| {
                let first = (set + i) * channels;
                &attr[first..first + channels]
            });
            let [u, v] = [pixel[0], pixel[1]];
            let w = 1.0 - u - v;
            for (c, out) in out.iter_mut().enumerate() {
                *out = u * rows[0][c] + v * rows[1][c] + w * rows[2][c];
            }
            if let Some(&[ux, uy, vx, vy]) = db.get(at) {
                for (c, da) in diff.iter().zip(da.chunks_exact_mut(2)) {
                    let (du, dv) = (rows[0][*c] - rows[2][*c], rows[1][*c] - rows[2][*c]);
                    da[0] = ux * du + vx * dv;
                    da[1] = uy * du + vy * dv;
                }
            }
        }
        Ok(())
    };
    unlocked(py, threads, || {
        let chunks = rast
            .par_chunks(TASK)
            .zip(out.par_chunks_mut(TASK * channels));
        if pairs == 0 {
            chunks.enumerate().try_for_each(|part| task(part, &mut []))
        } else {
            chunks
                .zip(out_da.par_chunks_mut(TASK * pairs))
                .enumerate()
                .try_for_each(|(k, (part, da))| task((k, part), da))
        }
    })?
}

/// Gradient with respect to `attr` from that with respect to the interpolated values: summed in f64 in the order of the pixels, on
/// one thread.
#[pyfunction]
pub(crate) fn interpolate_gradient(
    py: Python<'_>,
    shape: (usize, usize),
    rast: PyReadonlyArray1<'_, f32>,
    tri: PyReadonlyArray1<'_, u32>,
    grad: PyReadonlyArray1<'_, f32>,
    mut out: PyReadwriteArray1<'_, f32>,
    batch: usize,
) -> PyResult<()> {
    let (vertices, channels) = shape;
    let rast = rast.as_slice()?.as_chunks::<4>().0;
    let tri = tri.as_slice()?.as_chunks::<3>().0;
    let (grad, out) = (grad.as_slice()?, out.as_slice_mut()?);
    expect_length("grad", grad.len(), rast.len() * channels)?;
    let picture = (rast.len() / batch.max(1)).max(1);
    let shared = out.len() == vertices * channels;
    py.detach(|| {
        let mut sums = vec![0.0_f64; out.len()];
        for (at, pixel) in rast.iter().enumerate() {
            let Some(triangle) = decode(pixel[3]) else {
                continue;
            };
            let set = if shared { 0 } else { at / picture * vertices };
            let [u, v] = [pixel[0], pixel[1]];
            let weights = [u, v, 1.0 - u - v].map(f64::from);
            let grad = &grad[at * channels..(at + 1) * channels];
            for (corner, weight) in corners(tri, triangle, vertices)?.iter().zip(weights) {
                let first = (set + corner) * channels;
                for (sum, grad) in sums[first..first + channels].iter_mut().zip(grad) {
                    *sum += weight * f64::from(*grad);
                }
            }
        }
        for (out, sum) in out.iter_mut().zip(&sums) {
            *out = *sum as f32;
        }
        Ok(())
    })
}
