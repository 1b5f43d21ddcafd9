//! Textures of any number of channels.

use std::sync::OnceLock;

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use texmap_math::MemoryBudget;
use texmap_sample::{Alpha, ColorSpace, Filter, Image, Origin, TexelData, Texture2d};

use crate::support::{expect_length, value};

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
pub(crate) enum Group {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl Group {
    pub(crate) fn of(texels: TexelData<'_>, channels: usize, first: usize, count: usize) -> Self {
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

    pub(crate) fn data(&self) -> TexelData<'_> {
        match self {
            Self::U8(t) => TexelData::U8(t),
            Self::U16(t) => TexelData::U16(t),
            Self::F32(t) => TexelData::F32(t),
        }
    }
}

const SMALLER: &str = "give a smaller image, or one at a time";

/// The textures of an image: one of up to four channels, or one for each four channels of data.
fn groups(
    texels: TexelData<'_>,
    (width, height): (u32, u32),
    channels: usize,
    (color, alpha, origin): (ColorSpace, Alpha, Origin),
    mips: bool,
) -> PyResult<Vec<Texture2d<'static>>> {
    let budget = MemoryBudget::of_process();
    let what = format_args!("a texture of {width} x {height} texels");
    let texture = |texels: &TexelData<'_>, channels: usize, alpha: Alpha| {
        // Bytes of a texel as it is kept: whole numbers have 8 or 16 bits for each of four channels.
        let each = match (texels, channels) {
            (TexelData::U8(_), _) | (TexelData::F32(_), 1) => 4,
            (TexelData::F32(_), _) => 16,
            _ => 8,
        };
        let bytes = each * u64::from(width) * u64::from(height);
        budget.ask(bytes, what, SMALLER).map_err(value)?;
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
        if !mips {
            return Ok(texture);
        }
        let more = texture.bytes_to_prepare(Filter::Trilinear);
        budget.ask(more, what, SMALLER).map_err(value)?;
        Ok(texture.with_mips())
    };
    if channels <= 4 {
        return Ok(vec![texture(&texels, channels, alpha)?]);
    }
    (0..channels)
        .step_by(4)
        .map(|first| {
            let count = (channels - first).min(4);
            let bytes = len(&texels) as u64 / channels as u64 * count as u64 * 4;
            budget.ask(bytes, what, SMALLER).map_err(value)?;
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
    pub(crate) fn prepared_for(&self, filter: Filter) -> &Self {
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
    pub(crate) fn shown(&self, color: [f32; 4]) -> [f32; 4] {
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
    pub(crate) fn shape(&self) -> (u32, u32, usize, u32) {
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
