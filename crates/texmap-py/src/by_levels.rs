//! Look-ups in textures by levels of detail, as `texmap.dr.texture` asks for them.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use texmap_math::{Footprint, deterministic_f32};
use texmap_sample::{Filter, Lod, Sampler, Wrap};

use crate::look_up::{interruptible_look_ups, look_up};
use crate::support::{Threads, expect_length, level, value};
use crate::texture::Texture;

/// Look-ups by levels of detail: `level` holds one footprint length in texels an entry is multiplied with, see `texmap.dr.texture`.
#[pyfunction]
#[pyo3(signature = (texture, uv, uv_da, bias, out, filter, boundary, max_level, threads, simd))]
pub(crate) fn sample_levels(
    py: Python<'_>,
    texture: &Texture,
    uv: PyReadonlyArray1<'_, f32>,
    uv_da: Option<PyReadonlyArray1<'_, f32>>,
    bias: Option<PyReadonlyArray1<'_, f32>>,
    mut out: PyReadwriteArray1<'_, f32>,
    filter: &str,
    boundary: &str,
    max_level: f32,
    threads: Option<Threads>,
    simd: Option<&str>,
) -> PyResult<()> {
    let uv = uv.as_slice()?;
    let count = uv.len() / 2;
    let by_levels = ByLevels::new(filter, boundary, max_level, (&uv_da, 4), &bias, count)?;
    let ByLevels { sampler, da, bias } = by_levels;
    let (width, height, ..) = texture.shape();
    let size = [width as f32, height as f32];
    let has_levels = da.is_some() || bias.is_some();
    let (out, level) = (out.as_slice_mut()?, level(simd)?);
    interruptible_look_ups(py, texture, uv, out, threads, |first, uv, out| {
        look_up(
            &sampler,
            level,
            texture,
            uv,
            out,
            has_levels,
            |range, into| {
                for k in first + range.start..first + range.end {
                    let length = match da {
                        Some(da) => footprint_length(&da[4 * k..4 * k + 4], size),
                        None => 1.0,
                    };
                    let scale = bias.map_or(1.0, |bias| deterministic_f32::exp2(bias[k]));
                    let length = length * scale;
                    let length = if length > LONGEST { LONGEST } else { length };
                    into.push(Footprint::new(length / size[0], 0.0, 0.0, length / size[1]));
                }
            },
        )
    })
}

/// Look-ups by levels of detail: a sampler, and derivatives and biases where there are.
pub(crate) struct ByLevels<'a> {
    pub(crate) sampler: Sampler,
    pub(crate) da: Option<&'a [f32]>,
    pub(crate) bias: Option<&'a [f32]>,
}

impl<'a> ByLevels<'a> {
    /// For `count` look-ups; `da` holds so many derivatives for each, `bias` one. `boundary` is wrap, clamp, zero, or cube for cubes, which
    /// have no edge; `filter` nearest, linear, linear-mipmap-nearest or linear-mipmap-linear.
    pub(crate) fn new(
        filter: &str,
        boundary: &str,
        max_level: f32,
        (da, each): (&'a Option<PyReadonlyArray1<'_, f32>>, usize),
        bias: &'a Option<PyReadonlyArray1<'_, f32>>,
        count: usize,
    ) -> PyResult<Self> {
        let slice = |name, array: &'a Option<PyReadonlyArray1<'_, f32>>, expected| {
            let Some(array) = array else { return Ok(None) };
            let found = array.as_slice()?;
            expect_length(name, found.len(), expected)?;
            PyResult::Ok(Some(found))
        };
        let wrap = dr_boundary(boundary)?;
        Ok(Self {
            sampler: Sampler {
                filter: dr_filter(filter)?,
                wrap_u: wrap,
                wrap_v: wrap,
                lod: Lod {
                    max: max_level,
                    ..Lod::default()
                },
                ..Sampler::default()
            },
            da: slice("uv_da", da, each * count)?,
            bias: slice("mip_level_bias", bias, count)?,
        })
    }
}

fn dr_boundary(name: &str) -> PyResult<Wrap> {
    match name {
        "wrap" | "cube" => Ok(Wrap::Repeat),
        "clamp" => Ok(Wrap::ClampToEdge),
        "zero" => Ok(Wrap::ClampToBorder),
        other => Err(value(format!(
            "boundary_mode={other:?}: know wrap, clamp, zero, cube"
        ))),
    }
}

fn dr_filter(name: &str) -> PyResult<Filter> {
    match name {
        "nearest" => Ok(Filter::Nearest),
        "linear" => Ok(Filter::Bilinear),
        "linear-mipmap-nearest" => Ok(Filter::BilinearMipNearest),
        "linear-mipmap-linear" => Ok(Filter::Trilinear),
        other => Err(value(format!(
            "filter_mode={other:?}: know auto, nearest, linear, linear-mipmap-nearest, linear-mipmap-linear"
        ))),
    }
}

/// Longer half axis of the ellipse of a pixel in texels: the larger singular value of (du/dX, du/dY, dv/dX, dv/dY) in texels.
pub(crate) fn footprint_length(da: &[f32], [width, height]: [f32; 2]) -> f32 {
    let (ux, uy) = (da[0] * width, da[1] * width);
    let (vx, vy) = (da[2] * height, da[3] * height);
    let (a, b, c) = (ux * ux + uy * uy, ux * vx + uy * vy, vx * vx + vy * vy);
    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
    let length = (mean + (half * half + b * b).sqrt()).sqrt();
    match length.is_finite() || da.iter().any(|d| d.is_nan()) {
        true => length,
        // Squares beyond f32, whose differences say nothing: the longest of the four is not far off the length.
        false => {
            let longest = [ux, uy, vx, vy].map(f32::abs).into_iter();
            longest.fold(0.0, f32::max).min(LONGEST)
        }
    }
}

/// Texels of the longest footprint that a sampler takes: its square is finite, and no chain has a level as coarse.
const LONGEST: f32 = 1e18;
