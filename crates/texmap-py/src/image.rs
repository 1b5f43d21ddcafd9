//! Images: read, warped, compared, hashed.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use texmap_io::PixelCode;
use texmap_io::image_io::{self, Depth};
use texmap_io::npy::{Array, Data};
use texmap_math::Homography;
use texmap_math::glam::{DMat3, DVec2};
use texmap_sample::{ColorSpace, EdgeMode, Filter, Resample};
use texmap_truth::buffer::Buffer;
use texmap_truth::metrics::{self, Metrics, MetricsError, Shape};
use texmap_truth::ssim::ssim;

use crate::support::{Threads, expect_length, interruptible, io, level, unlocked, value, word};
use crate::texture::{Texels, Texture};

fn matrix(rows: [f64; 9]) -> DMat3 {
    DMat3::from_cols_array(&rows).transpose()
}

/// The map from four corners to four others, as nine numbers in rows.
#[pyfunction]
pub(crate) fn homography(source: [[f64; 2]; 4], target: [[f64; 2]; 4]) -> PyResult<[f64; 9]> {
    let quads = [source, target].map(|quad| quad.map(DVec2::from));
    let map = Homography::from_quads(quads[0], quads[1]).map_err(refused)?;
    Ok(map.matrix().transpose().to_cols_array())
}

fn refused(error: texmap_math::HomographyError) -> PyErr {
    value(format!(
        "the four points or the matrix give no map: {error}\nname the corners in order around a convex quad, no three on a line"
    ))
}

/// Draws a texture through a homography (pixels of the source to pixels of the output, rows) into `linear` (4 floats a pixel,
/// premultiplied) or `codes` (4 bytes a pixel, straight; sRGB unless `raw`).
#[pyfunction]
#[pyo3(signature = (texture, rows, width, filter, outside, border, linear, codes, raw, threads, simd))]
pub(crate) fn warp(
    py: Python<'_>,
    texture: &Texture,
    rows: [f64; 9],
    width: u32,
    filter: &str,
    outside: &str,
    border: [f32; 4],
    mut linear: Option<PyReadwriteArray1<'_, f32>>,
    mut codes: Option<PyReadwriteArray1<'_, u8>>,
    raw: bool,
    threads: Option<Threads>,
    simd: Option<&str>,
) -> PyResult<()> {
    let map = Homography::from_matrix(matrix(rows)).map_err(refused)?;
    let filter: Filter = word("filter", filter)?;
    let edge = match outside {
        "transparent" => EdgeMode::Transparent,
        "border" => EdgeMode::Border(border),
        "edge" => EdgeMode::Edge,
        "repeat" => EdgeMode::Repeat,
        other => {
            return Err(value(format!(
                "outside={other:?}: know transparent, border, edge, repeat"
            )));
        }
    };
    let [group] = &texture.groups[..] else {
        return Err(value(format!(
            "the image has {} channels, expected 1 to 4",
            texture.channels
        )));
    };
    let level = level(simd)?;
    let resample = Resample::new(group, filter, edge, &map);
    let space = if raw {
        ColorSpace::Linear
    } else {
        ColorSpace::Srgb
    };
    let code = PixelCode::Png8(space);
    let linear = linear.as_mut().map(|a| a.as_slice_mut()).transpose()?;
    let codes = codes.as_mut().map(|a| a.as_slice_mut()).transpose()?;
    let row = width as usize * 4;
    interruptible(py, threads, |stop| {
        let stopped = || stop.load(Ordering::Relaxed);
        if let Some(out) = linear {
            out.par_chunks_mut(row.max(1))
                .enumerate()
                .try_for_each(|(y, out)| {
                    let colors = out.as_chunks_mut::<4>().0;
                    match stopped() {
                        true => Ok(()),
                        false => resample.rows(level, width, y as u32, colors),
                    }
                })?;
        }
        if let Some(out) = codes {
            out.par_chunks_mut(row.max(1))
                .enumerate()
                .try_for_each_init(
                    || vec![[0.0; 4]; width as usize],
                    |colors, (y, out)| {
                        if !stopped() {
                            resample.rows(level, width, y as u32, colors)?;
                            code.encode(colors, out);
                        }
                        Ok(())
                    },
                )?;
        }
        Ok(())
    })?
    .map_err(|e: texmap_sample::SampleError| value(e))
}

/// An image file: width, height, channels of the file, and flat RGBA texels in the depth of the file.
#[pyfunction]
pub(crate) fn read_image(
    py: Python<'_>,
    path: PathBuf,
) -> PyResult<(u32, u32, u32, Bound<'_, PyAny>)> {
    // Blocks of OpenEXR are decompressed on all threads of the pool.
    let image = unlocked(py, None, || image_io::read_image(&path))?.map_err(io)?;
    let texels = match image.texels {
        Depth::U8(t) => PyArray1::from_vec(py, t).into_any(),
        Depth::U16(t) => PyArray1::from_vec(py, t).into_any(),
        Depth::F32(t) => PyArray1::from_vec(py, t).into_any(),
    };
    Ok((image.width, image.height, image.channels, texels))
}

/// The values of one side as images or arrays that `texmap diff` reads.
fn buffer(values: &Texels<'_>, shape: &[usize], image: bool) -> PyResult<Buffer> {
    if let (true, &[height, width, 4]) = (image, shape) {
        let texels = match values {
            Texels::U8(t) => Depth::U8(t.as_slice()?.to_vec()),
            Texels::U16(t) => Depth::U16(t.as_slice()?.to_vec()),
            Texels::F32(t) => Depth::F32(t.as_slice()?.to_vec()),
        };
        let made = Buffer::of_image(width, height, texels);
        return made.ok_or_else(|| value("an image has four channels here"));
    }
    let data = match values {
        Texels::U8(t) => Data::U8(t.as_slice()?.to_vec()),
        Texels::U16(t) => Data::U16(t.as_slice()?.to_vec()),
        Texels::F32(t) => Data::F32(t.as_slice()?.to_vec()),
    };
    Ok(Buffer::of_array(Array {
        shape: shape.to_vec(),
        data,
    }))
}

/// Figures of two arrays of f64, which no file of the program has: of all values, and SSIM.
#[pyfunction]
pub(crate) fn diff_f64<'py>(
    py: Python<'py>,
    expected: PyReadonlyArray1<'py, f64>,
    actual: PyReadonlyArray1<'py, f64>,
    size: (usize, usize, usize),
    limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let (width, height, channels) = size;
    let (expected, actual) = (expected.as_slice()?, actual.as_slice()?);
    let shape = Shape {
        width,
        height,
        channels,
    };
    let largest = |values: &[f64]| {
        let finite = values.iter().map(|v| v.abs()).filter(|v| v.is_finite());
        finite.fold(0.0, f64::max)
    };
    let found = unlocked(py, None, || {
        let values = metrics::compare(shape, expected, actual, limit)?;
        let peak = largest(expected).max(largest(actual));
        let pair = |index: usize| (expected[index], actual[index]);
        Ok((values, ssim(shape, channels, peak, pair), peak))
    })?;
    let (values, ssim, peak) = found.map_err(|e: MetricsError| value(e))?;
    let out = figures(py, &values)?;
    out.set_item("psnr", values.psnr(peak))?;
    out.set_item("ssim", ssim)?;
    out.set_item("passes", values.passes())?;
    out.set_item("alpha", None::<f64>)?;
    Ok(out)
}

/// The figures of `texmap diff` of two arrays of one shape; those of four channels may be compared as images.
#[pyfunction]
pub(crate) fn diff<'py>(
    py: Python<'py>,
    expected: Texels<'py>,
    actual: Texels<'py>,
    shape: Vec<usize>,
    image: bool,
    limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let (expected, actual) = (
        buffer(&expected, &shape, image)?,
        buffer(&actual, &shape, image)?,
    );
    let found = unlocked(py, None, || actual.compare(&expected, limit))?.map_err(value)?;
    let out = figures(py, &found.values)?;
    let psnr = found.values.psnr(expected.peak.max(actual.peak));
    out.set_item("psnr", psnr)?;
    out.set_item("ssim", found.ssim)?;
    out.set_item("passes", found.passes())?;
    let alpha = found.alpha.map(|alpha| figures(py, &alpha)).transpose()?;
    out.set_item("alpha", alpha)?;
    Ok(out)
}

fn figures<'py>(py: Python<'py>, m: &Metrics) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("mean", m.mean)?;
    out.set_item("rms", m.rmse)?;
    out.set_item("p999", m.p999)?;
    out.set_item("max", m.max)?;
    out.set_item("max_at", m.max_at.map(|p| (p.x, p.y, p.channel)))?;
    out.set_item("over_limit", m.over_limit)?;
    out.set_item("non_finite", m.non_finite)?;
    out.set_item("holes", m.holes)?;
    Ok(out)
}

/// The hash of `texmap render --json` of flat bytes.
#[pyfunction]
pub(crate) fn pixel_hash(
    py: Python<'_>,
    width: u32,
    height: u32,
    bytes: PyReadonlyArray1<'_, u8>,
) -> PyResult<String> {
    let bytes = bytes.as_slice()?;
    expect_length(
        "the image",
        bytes.len() % (width as usize * height as usize).max(1),
        0,
    )?;
    Ok(py.detach(|| texmap_render::hash_pixels(width, height, bytes)))
}
