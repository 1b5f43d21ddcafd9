//! Textures of any number of channels, and look-ups in them.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use texmap_math::{Footprint, Level, deterministic_f32};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Lod, Origin, Sampler, TexelData, Texture2d, TextureCube,
    Wrap, sample_slice,
};

use crate::support::{expect_length, interruptible, level, unlocked, value, word};

/// Look-ups that one task does.
const TASK: usize = 1 << 13;

/// Texels of a call, as they come from an array.
#[derive(FromPyObject)]
pub(crate) enum Texels<'py> {
    U8(PyReadonlyArray1<'py, u8>),
    U16(PyReadonlyArray1<'py, u16>),
    F32(PyReadonlyArray1<'py, f32>),
}

impl Texels<'_> {
    pub(crate) fn data(&self) -> PyResult<TexelData<'_>> {
        Ok(match self {
            Self::U8(t) => TexelData::U8(t.as_slice()?),
            Self::U16(t) => TexelData::U16(t.as_slice()?),
            Self::F32(t) => TexelData::F32(t.as_slice()?),
        })
    }
}

pub(crate) fn len(texels: &TexelData<'_>) -> usize {
    match texels {
        TexelData::U8(t) => t.len(),
        TexelData::U16(t) => t.len(),
        TexelData::F32(t) => t.len(),
        _ => 0,
    }
}

/// Channels `first..first + count` of interleaved texels, as their own image's texels.
enum Group {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl Group {
    fn of(texels: TexelData<'_>, channels: usize, first: usize, count: usize) -> Self {
        fn part<T: Copy>(all: &[T], channels: usize, first: usize, count: usize) -> Vec<T> {
            let texels = all.chunks_exact(channels);
            texels
                .flat_map(|t| t[first..first + count].iter().copied())
                .collect()
        }
        match texels {
            TexelData::U8(t) => Self::U8(part(t, channels, first, count)),
            TexelData::U16(t) => Self::U16(part(t, channels, first, count)),
            TexelData::F32(t) => Self::F32(part(t, channels, first, count)),
            _ => Self::F32(Vec::new()),
        }
    }

    fn data(&self) -> TexelData<'_> {
        match self {
            Self::U8(t) => TexelData::U8(t),
            Self::U16(t) => TexelData::U16(t),
            Self::F32(t) => TexelData::F32(t),
        }
    }
}

/// The textures of an image: one of up to four channels, or one for each four channels of data.
fn groups(
    texels: TexelData<'_>,
    (width, height): (u32, u32),
    channels: usize,
    (color, alpha, origin): (ColorSpace, Alpha, Origin),
    mips: bool,
) -> PyResult<Vec<Texture2d<'static>>> {
    let texture = |texels: &TexelData<'_>, channels: usize, alpha: Alpha| {
        let image = Image {
            width,
            height,
            channels: channels as u32,
            texels: *texels,
            color,
            alpha,
            origin,
        };
        let texture = Texture2d::new(&image).map_err(value)?;
        Ok(if mips { texture.with_mips() } else { texture })
    };
    if channels <= 4 {
        return Ok(vec![texture(&texels, channels, alpha)?]);
    }
    (0..channels)
        .step_by(4)
        .map(|first| {
            let count = (channels - first).min(4);
            let group = Group::of(texels, channels, first, count);
            texture(&group.data(), count, Alpha::Data)
        })
        .collect()
}

/// An image with its mip chain.
#[pyclass(frozen, module = "texmap._texmap")]
pub(crate) struct Texture {
    pub(crate) groups: Vec<Texture2d<'static>>,
    pub(crate) channels: usize,
    /// Two channels, the second of which is opacity.
    grey_alpha: bool,
    /// The same with summed-area tables, once a filter reads them.
    with_sums: OnceLock<Box<Self>>,
}

impl Texture {
    /// The image with all that a filter reads.
    fn prepared_for(&self, filter: Filter) -> &Self {
        if !filter.reads_summed_area() {
            return self;
        }
        let prepared = |group: &Texture2d<'static>| group.clone().prepared_for(filter);
        self.with_sums.get_or_init(|| {
            Box::new(Self {
                groups: self.groups.iter().map(prepared).collect(),
                channels: self.channels,
                grey_alpha: self.grey_alpha,
                with_sums: OnceLock::new(),
            })
        })
    }

    /// The channels of a look-up in the order of the image.
    #[inline(always)]
    fn shown(&self, color: [f32; 4]) -> [f32; 4] {
        match self.grey_alpha {
            true => [color[0], color[3], 0.0, 1.0],
            false => color,
        }
    }
}

#[pymethods]
impl Texture {
    /// From flat texels, rows top to bottom; `kind` is (color space, alpha, v = 0 at the bottom row).
    #[new]
    fn new(
        py: Python<'_>,
        texels: Texels<'_>,
        size: (u32, u32),
        channels: usize,
        kind: (&str, &str, bool),
        mips: bool,
    ) -> PyResult<Self> {
        let color = match kind.0 {
            "srgb" => ColorSpace::Srgb,
            "linear" => ColorSpace::Linear,
            other => return Err(value(format!("color={other:?}: know srgb, linear"))),
        };
        let alpha = match kind.1 {
            "straight" => Alpha::Straight,
            "premultiplied" => Alpha::Premultiplied,
            "data" => Alpha::Data,
            other => {
                return Err(value(format!(
                    "alpha={other:?}: know straight, premultiplied, data"
                )));
            }
        };
        let origin = if kind.2 {
            Origin::BottomLeft
        } else {
            Origin::TopLeft
        };
        let data = texels.data()?;
        expect_length(
            "the image",
            len(&data),
            size.0 as usize * size.1 as usize * channels,
        )?;
        let groups = py.detach(|| groups(data, size, channels, (color, alpha, origin), mips))?;
        Ok(Self {
            groups,
            channels,
            grey_alpha: channels == 2 && alpha != Alpha::Data,
            with_sums: OnceLock::new(),
        })
    }

    /// Width, height, channels and levels.
    fn shape(&self) -> (u32, u32, usize, u32) {
        let first = &self.groups[0];
        (first.width(), first.height(), self.channels, first.levels())
    }

    /// Sizes of the levels: (width, height).
    fn level_sizes(&self) -> Vec<(u32, u32)> {
        let first = &self.groups[0];
        (0..first.levels())
            .filter_map(|l| first.level_size(l))
            .collect()
    }

    /// The texels of a level, linear and premultiplied, rows counted from the origin.
    fn level(
        &self,
        py: Python<'_>,
        index: u32,
        mut out: PyReadwriteArray1<'_, f32>,
    ) -> PyResult<()> {
        let size = self.groups[0].level_size(index);
        let (width, height) = size.ok_or_else(|| {
            value(format!(
                "level {index}: there are {}",
                self.groups[0].levels()
            ))
        })?;
        let out = out.as_slice_mut()?;
        let channels = self.channels;
        expect_length(
            "out",
            out.len(),
            width as usize * height as usize * channels,
        )?;
        py.detach(|| {
            for (k, texel) in out.chunks_exact_mut(channels).enumerate() {
                let (x, y) = (k as u32 % width, k as u32 / width);
                for (group, texel) in self.groups.iter().zip(texel.chunks_mut(4)) {
                    let color = group.texel(index, x, y).unwrap_or_default();
                    texel.copy_from_slice(&self.shown(color)[..texel.len()]);
                }
            }
        });
        Ok(())
    }
}

/// Look-ups at flat coordinates (two each) with flat derivatives (du/dx, du/dy, dv/dx, dv/dy each) into `out`.
#[pyfunction]
#[pyo3(signature = (texture, uv, duv, out, filter, wrap, border, lod, threads, simd))]
pub(crate) fn sample(
    py: Python<'_>,
    texture: &Texture,
    uv: PyReadonlyArray1<'_, f32>,
    duv: Option<PyReadonlyArray1<'_, f32>>,
    mut out: PyReadwriteArray1<'_, f32>,
    filter: &str,
    wrap: (&str, &str),
    border: [f32; 4],
    lod: [f32; 3],
    threads: Option<usize>,
    simd: Option<&str>,
) -> PyResult<()> {
    let sampler = Sampler {
        filter: word::<Filter>("filter", filter)?,
        wrap_u: word::<Wrap>("wrap", wrap.0)?,
        wrap_v: word::<Wrap>("wrap", wrap.1)?,
        border,
        lod: Lod {
            bias: lod[0],
            min: lod[1],
            max: lod[2],
        },
        ..Sampler::default()
    };
    let uv = uv.as_slice()?;
    let duv = duv.as_ref().map(|d| d.as_slice()).transpose()?;
    let footprints = move |range: std::ops::Range<usize>, into: &mut Vec<Footprint>| {
        if let Some(duv) = duv {
            let given = duv.as_chunks::<4>().0[range].iter();
            into.extend(given.map(|&[ux, uy, vx, vy]| Footprint::new(ux, vx, uy, vy)));
        }
    };
    if let Some(duv) = duv {
        expect_length("duv", duv.len(), uv.len() * 2)?;
    }
    let (out, level) = (out.as_slice_mut()?, level(simd)?);
    let has_footprints = duv.is_some();
    let texture = py.detach(|| texture.prepared_for(sampler.filter));
    interruptible_look_ups(py, texture, uv, out, threads, |first, uv, out| {
        look_up(
            &sampler,
            level,
            texture,
            uv,
            out,
            has_footprints,
            |range, into| {
                footprints(first + range.start..first + range.end, into);
            },
        )
    })
}

/// Look-ups by levels of detail: `level` holds one footprint length in texels an entry is multiplied with, see `texmap.dr.texture`.
/// `boundary` is wrap, clamp or zero; `filter` nearest, linear, linear-mipmap-nearest or linear-mipmap-linear.
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
    threads: Option<usize>,
    simd: Option<&str>,
) -> PyResult<()> {
    let wrap = match boundary {
        "wrap" => Wrap::Repeat,
        "clamp" => Wrap::ClampToEdge,
        "zero" => Wrap::ClampToBorder,
        other => {
            return Err(value(format!(
                "boundary_mode={other:?}: know wrap, clamp, zero, cube"
            )));
        }
    };
    let uv = uv.as_slice()?;
    let by_levels = ByLevels::new(filter, wrap, max_level, (&uv_da, 4), &bias, uv.len() / 2)?;
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
                    into.push(Footprint::new(length / size[0], 0.0, 0.0, length / size[1]));
                }
            },
        )
    })
}

/// Look-ups by levels of detail: a sampler, and derivatives and biases where there are.
struct ByLevels<'a> {
    sampler: Sampler,
    da: Option<&'a [f32]>,
    bias: Option<&'a [f32]>,
}

impl<'a> ByLevels<'a> {
    /// For `count` look-ups; `da` holds so many derivatives for each, `bias` one.
    fn new(
        filter: &str,
        wrap: Wrap,
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

pub(crate) fn dr_filter(name: &str) -> PyResult<Filter> {
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
    (mean + (half * half + b * b).sqrt()).sqrt()
}

/// Look-ups of one task; `footprints` appends those of a range of the task.
fn look_up(
    sampler: &Sampler,
    level: Level,
    texture: &Texture,
    uv: &[f32],
    out: &mut [f32],
    has_footprints: bool,
    footprints: impl Fn(std::ops::Range<usize>, &mut Vec<Footprint>),
) -> PyResult<()> {
    const PART: usize = 256;
    let (mut u, mut v) = ([0.0; PART], [0.0; PART]);
    let mut colors = [[0.0; 4]; PART];
    let mut grads = Vec::with_capacity(PART);
    let channels = texture.channels;
    let pairs = uv.as_chunks::<2>().0;
    for (part, (pairs, out)) in pairs
        .chunks(PART)
        .zip(out.chunks_mut(PART * channels))
        .enumerate()
    {
        let count = pairs.len();
        for (k, &[a, b]) in pairs.iter().enumerate() {
            (u[k], v[k]) = (a, b);
        }
        grads.clear();
        footprints(part * PART..part * PART + count, &mut grads);
        let grads = has_footprints.then_some(&grads[..]);
        let (u, v) = (&u[..count], &v[..count]);
        if channels == 4 {
            let (out, _) = out.as_chunks_mut::<4>();
            sample_slice(level, sampler, &texture.groups[0], u, v, grads, out).map_err(value)?;
            continue;
        }
        for (g, group) in texture.groups.iter().enumerate() {
            let colors = &mut colors[..count];
            sample_slice(level, sampler, group, u, v, grads, colors).map_err(value)?;
            let (first, last) = (4 * g, channels.min(4 * g + 4));
            for (texel, color) in out.chunks_exact_mut(channels).zip(colors) {
                texel[first..last].copy_from_slice(&texture.shown(*color)[..last - first]);
            }
        }
    }
    Ok(())
}

/// Runs `work` (first look-up, coordinates, output) over all look-ups, many at a time; long ones can be interrupted.
fn interruptible_look_ups(
    py: Python<'_>,
    texture: &Texture,
    uv: &[f32],
    out: &mut [f32],
    threads: Option<usize>,
    work: impl Fn(usize, &[f32], &mut [f32]) -> PyResult<()> + Sync + Send,
) -> PyResult<()> {
    let channels = texture.channels;
    expect_length("out", out.len(), uv.len() / 2 * channels)?;
    let mut tasks = |stop: Option<&AtomicBool>| {
        if threads == Some(1) || uv.len() <= 2 * TASK {
            for (k, (uv, out)) in uv
                .chunks(2 * TASK)
                .zip(out.chunks_mut(TASK * channels))
                .enumerate()
            {
                if !stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                    work(k * TASK, uv, out)?;
                }
            }
            return Ok(());
        }
        uv.par_chunks(2 * TASK)
            .zip(out.par_chunks_mut(TASK * channels))
            .enumerate()
            .try_for_each(|(k, (uv, out))| match stop {
                Some(stop) if stop.load(Ordering::Relaxed) => Ok(()),
                _ => work(k * TASK, uv, out),
            })
    };
    // A second's work at most goes without a look for signals, which costs the start of a thread.
    if uv.len() > 1 << 24 {
        return interruptible(py, threads, |stop| tasks(Some(stop)))?;
    }
    if threads == Some(1) || uv.len() <= 2 * TASK {
        return py.detach(|| tasks(None));
    }
    unlocked(py, threads, || tasks(None))?
}

/// A cube of six images.
#[pyclass(frozen, module = "texmap._texmap")]
pub(crate) struct Cube {
    groups: Vec<TextureCube<'static>>,
    channels: usize,
}

#[pymethods]
impl Cube {
    /// From flat texels of six faces +X -X +Y -Y +Z -Z, one after the other.
    #[new]
    fn new(
        py: Python<'_>,
        texels: PyReadonlyArray1<'_, f32>,
        side: u32,
        channels: usize,
        mips: bool,
    ) -> PyResult<Self> {
        let texels = texels.as_slice()?;
        let face = side as usize * side as usize * channels;
        expect_length("the cube", texels.len(), 6 * face)?;
        py.detach(|| {
            let made = (0..channels).step_by(4).map(|first| {
                let count = (channels - first).min(4);
                let faces: [Group; 6] = std::array::from_fn(|k| {
                    let face = TexelData::F32(&texels[k * face..(k + 1) * face]);
                    Group::of(face, channels, first, count)
                });
                let images = faces.each_ref().map(|group| Image {
                    width: side,
                    height: side,
                    channels: count as u32,
                    texels: group.data(),
                    color: ColorSpace::Linear,
                    alpha: Alpha::Data,
                    origin: Origin::TopLeft,
                });
                let cube = TextureCube::new(&images).map_err(value)?;
                Ok(if mips { cube.with_mips() } else { cube })
            });
            Ok(Self {
                groups: made.collect::<PyResult<_>>()?,
                channels,
            })
        })
    }
}

/// Look-ups in a cube at flat directions (three each), with flat derivatives (six each: dx/dX, dx/dY, dy/dX, ..) or none. Zero and
/// non-finite directions give 0.
#[pyfunction]
#[pyo3(signature = (cube, directions, da, bias, out, filter, max_level, threads))]
pub(crate) fn sample_cube(
    py: Python<'_>,
    cube: &Cube,
    directions: PyReadonlyArray1<'_, f32>,
    da: Option<PyReadonlyArray1<'_, f32>>,
    bias: Option<PyReadonlyArray1<'_, f32>>,
    mut out: PyReadwriteArray1<'_, f32>,
    filter: &str,
    max_level: f32,
    threads: Option<usize>,
) -> PyResult<()> {
    let directions = directions.as_slice()?;
    let out = out.as_slice_mut()?;
    let channels = cube.channels;
    let count = directions.len() / 3;
    expect_length("out", out.len(), count * channels)?;
    let wrap = Sampler::default().wrap_u;
    let by_levels = ByLevels::new(filter, wrap, max_level, (&da, 6), &bias, count)?;
    let ByLevels { sampler, da, bias } = by_levels;
    unlocked(py, threads, || {
        out.par_chunks_mut(channels)
            .enumerate()
            .for_each(|(k, out)| {
                let d = [
                    directions[3 * k],
                    directions[3 * k + 1],
                    directions[3 * k + 2],
                ];
                if d == [0.0; 3] || !d.iter().all(|c| c.is_finite()) {
                    out.fill(0.0);
                    return;
                }
                let shift = bias.map_or(0.0, |bias| bias[k]);
                let mut own = sampler.clone();
                own.lod.bias = shift;
                for (cube, out) in cube.groups.iter().zip(out.chunks_mut(4)) {
                    let color = match da {
                        Some(da) => {
                            let of = |axis: usize| [0, 2, 4].map(|c| da[6 * k + c + axis]);
                            own.sample_cube_grad(cube, d, of(0), of(1))
                        }
                        None => sampler.sample_cube(cube, d, shift),
                    };
                    out.copy_from_slice(&color[..out.len()]);
                }
            });
    })
}
