//! Triangles in clip space to barycentrics, depth and triangle of each pixel, bottom row first.

use std::sync::atomic::{AtomicBool, Ordering};

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use texmap_raster::TargetSize;

use crate::peel::Layer;
use crate::rast::{Picture, Range};
use crate::support::{Threads, expect_length, interruptible, level, unlocked, value};

/// Draws the pictures of a batch into `rast` and, where asked, `rast_db`. `layer` holds depths and triangles of the layer before
/// and takes those of this one.
#[pyfunction]
#[pyo3(signature = (pos, tri, ranges, size, rast, rast_db, layer, first_layer, threads, simd))]
pub(crate) fn rasterize(
    py: Python<'_>,
    pos: PyReadonlyArray1<'_, f32>,
    tri: PyReadonlyArray1<'_, u32>,
    ranges: Vec<Range>,
    size: (u32, u32),
    mut rast: PyReadwriteArray1<'_, f32>,
    mut rast_db: Option<PyReadwriteArray1<'_, f32>>,
    layer: Option<(PyReadwriteArray1<'_, f32>, PyReadwriteArray1<'_, u32>)>,
    first_layer: bool,
    threads: Option<Threads>,
    simd: Option<&str>,
) -> PyResult<()> {
    let (pos, tri) = (
        pos.as_slice()?.as_chunks::<4>().0,
        tri.as_slice()?.as_chunks::<3>().0,
    );
    let rast = rast.as_slice_mut()?;
    let rast_db = match &mut rast_db {
        Some(array) => array.as_slice_mut()?,
        None => &mut [],
    };
    let target = TargetSize::new(size.0, size.1).map_err(value)?;
    let picture = size.0 as usize * size.1 as usize;
    expect_length("rast", rast.len(), 4 * picture * ranges.len())?;
    if !rast_db.is_empty() {
        expect_length("rast_db", rast_db.len(), rast.len())?;
    }
    let level = level(simd)?;
    let mut layer = layer;
    let (depths, ids) = match &mut layer {
        Some((depths, ids)) => (depths.as_slice_mut()?, ids.as_slice_mut()?),
        None => (&mut [][..], &mut [][..]),
    };
    if !depths.is_empty() {
        expect_length("layer", depths.len(), picture * ranges.len())?;
        expect_length("layer", ids.len(), depths.len())?;
    }
    let pictures = ranges.len();
    let mut work = |stop: Option<&AtomicBool>| {
        let mut db = rast_db.chunks_mut(4 * picture);
        let mut depths = depths.chunks_mut(picture);
        let mut ids = ids.chunks_mut(picture);
        for (range, rast) in ranges.iter().zip(rast.chunks_mut(4 * picture)) {
            if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                break;
            }
            let layer = depths.next().zip(ids.next()).map(|(depths, ids)| Layer {
                depths,
                ids,
                first: first_layer,
            });
            let out = Picture {
                size: target,
                rast,
                db: db.next().unwrap_or_default(),
            };
            out.draw(pos, tri, *range, layer, level).map_err(value)?;
        }
        Ok(())
    };
    // A look for signals costs the start of a thread: only batches take one, which can be left between two pictures.
    match pictures {
        0 | 1 => unlocked(py, threads, || work(None))?,
        _ => interruptible(py, threads, |stop| work(Some(stop)))?,
    }
}
