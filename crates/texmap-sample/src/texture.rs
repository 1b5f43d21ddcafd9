use crate::{
    error::SampleError,
    mip,
    sampler::Filter,
    texel_data::{Chain, Format, Level, TexelData, Words, scaled},
    upload::upload,
};
use alloc::{vec, vec::Vec};

/// Encoding of light in colour channels. Alpha is always linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// The sRGB transfer curve of IEC 61966-2-1; decoded before filtering.
    #[default]
    Srgb,
    /// Values proportional to light, or data.
    Linear,
}

/// The row that `v = 0` touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Origin {
    /// The first row in memory (glTF, Direct3D).
    #[default]
    TopLeft,
    /// The last row in memory (OBJ, OpenGL images).
    BottomLeft,
}

/// Meaning of the last of 2 or 4 channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Alpha {
    /// Opacity, not yet multiplied into the colour; done at upload.
    #[default]
    Straight,
    /// Opacity, already multiplied into the (linear) colour.
    Premultiplied,
    /// Just another number: two channels read as (x, y, 0, 1), four stay independent.
    Data,
}

/// A decoded image to make a texture of.
///
/// One channel reads as (x, x, x, 1), two as (x, x, x, alpha), three as (r, g, b, 1).
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 1 to 4.
    pub channels: u32,
    /// `width * height * channels` values, rows top to bottom.
    pub texels: TexelData<'a>,
    /// Encoding of the colour channels.
    pub color: ColorSpace,
    /// Meaning of the last channel.
    pub alpha: Alpha,
    /// The row that `v = 0` touches.
    pub origin: Origin,
}

/// A two-dimensional texture with its mip chain in one allocation.
///
/// Texels are kept premultiplied and linear: linear opaque 8-bit images keep their bytes, other
/// integer images become linear 16-bit, floats stay floats. Cloning shares the texels.
#[derive(Clone, Debug)]
pub struct Texture2d<'a> {
    pub(crate) chain: Chain<'a>,
}

impl Texture2d<'static> {
    /// From straight-alpha RGBA bytes, rows top to bottom.
    ///
    /// # Errors
    /// A side out of range or a slice of the wrong length.
    pub fn from_rgba8(
        width: u32,
        height: u32,
        texels: Vec<u8>,
        color: ColorSpace,
        origin: Origin,
    ) -> Result<Self, SampleError> {
        Self::new(&Image {
            width,
            height,
            channels: 4,
            texels: TexelData::U8(&texels),
            color,
            alpha: Alpha::Straight,
            origin,
        })
    }

    /// From any decoded image.
    ///
    /// # Errors
    /// A side out of range, a slice of the wrong length, more than four channels, a float texel
    /// that is not finite.
    pub fn new(image: &Image<'_>) -> Result<Self, SampleError> {
        Ok(Self {
            chain: upload(image, 1)?,
        })
    }

    /// From 8-bit indices into a palette of straight-alpha RGBA bytes. The palette is applied here,
    /// per texel, so that no filter can ever blend indices.
    ///
    /// # Errors
    /// As [`Texture2d::new`]; an index beyond the palette names its texel.
    pub fn from_palette(
        width: u32,
        height: u32,
        indices: &[u8],
        palette: &[[u8; 4]],
        color: ColorSpace,
        origin: Origin,
    ) -> Result<Self, SampleError> {
        check_size(width, height)?;
        check_length(width as usize * height as usize, indices.len())?;
        let mut texels = Vec::with_capacity(indices.len() * 4);
        for (i, &index) in indices.iter().enumerate() {
            let Some(entry) = palette.get(usize::from(index)) else {
                let (x, y) = (i as u32 % width, i as u32 / width);
                return Err(SampleError::PaletteIndex {
                    x,
                    y,
                    index,
                    entries: palette.len(),
                });
            };
            texels.extend_from_slice(entry);
        }
        Self::from_rgba8(width, height, texels, color, origin)
    }
}

impl<'a> Texture2d<'a> {
    /// Longest side of any texture.
    pub const MAX_SIDE: u32 = 32768;

    /// Linear premultiplied RGBA8 texels used in place (r in the low byte).
    ///
    /// # Errors
    /// A side out of range or a slice of the wrong length.
    pub fn borrow_rgba8(
        width: u32,
        height: u32,
        texels: &'a [u32],
        origin: Origin,
    ) -> Result<Self, SampleError> {
        Self::borrow_words(width, height, texels, Format::Rgba8, origin)
    }

    /// One float a texel used in place, read as (x, x, x, 1): heights, depths.
    ///
    /// # Errors
    /// A side out of range, a slice of the wrong length, a value that is not finite.
    pub fn borrow_r32(
        width: u32,
        height: u32,
        texels: &'a [f32],
        origin: Origin,
    ) -> Result<Self, SampleError> {
        check_finite(&TexelData::F32(texels), width, 1)?;
        Self::borrow_words(
            width,
            height,
            bytemuck::cast_slice(texels),
            Format::R32,
            origin,
        )
    }

    fn borrow_words(
        width: u32,
        height: u32,
        words: &'a [u32],
        format: Format,
        origin: Origin,
    ) -> Result<Self, SampleError> {
        check_size(width, height)?;
        check_length(
            width as usize * height as usize * format.words(),
            words.len(),
        )?;
        let level = Level {
            offset: 0,
            width: width as i32,
            height: height as i32,
            depth: 1,
        };
        let chain = Chain {
            words: Words::Borrowed(words),
            encoded: None,
            format,
            levels: vec![level],
            flip: origin == Origin::BottomLeft,
            opaque: format != Format::Rgba8 || words.iter().all(|w| w >> 24 == 255),
            sums: None,
        };
        Ok(Self { chain })
    }

    /// The same image with its whole mip chain. Every level is the area-weighted mean of the base,
    /// in linear light and premultiplied, for odd sizes too. A borrowed texture is copied.
    #[must_use]
    pub fn with_mips(self) -> Texture2d<'static> {
        Texture2d {
            chain: mip::build(self.chain, mip::Reduce::Mean),
        }
    }

    /// A mip chain for unit vectors stored as (n + 1) / 2 (x, y, z in the first three channels).
    /// Each level's means are made unit vectors again.
    #[must_use]
    pub fn with_normal_mips(self) -> Texture2d<'static> {
        Texture2d {
            chain: mip::build(self.chain, mip::Reduce::Normals),
        }
    }

    /// A mip chain for cut-outs. Alpha (and the premultiplied colour with it) of each level is scaled
    /// so that the share of texels at or above `threshold` stays that of the base; by the factor nearest to one that does it, so that an
    /// opaque image stays opaque.
    #[must_use]
    pub fn with_coverage_mips(self, threshold: f32) -> Texture2d<'static> {
        Texture2d {
            chain: mip::build(self.chain, mip::Reduce::Coverage(threshold)),
        }
    }

    /// The same texture with all that look-ups by a filter read: its mip chain, its summed-area table, or nothing more.
    #[must_use]
    pub fn prepared_for(self, filter: Filter) -> Texture2d<'static>
    where
        'a: 'static,
    {
        let made = match filter.reads_mips() && self.levels() == 1 {
            true => self.with_mips(),
            false => self,
        };
        match filter.reads_summed_area() {
            true => made.with_summed_area(),
            false => made,
        }
    }

    /// Bytes that [`prepared_for`](Self::prepared_for) adds at most.
    #[must_use]
    pub fn bytes_to_prepare(&self, filter: Filter) -> u64 {
        let (width, height) = (u64::from(self.width()), u64::from(self.height()));
        let mut texels = 0;
        let mut level = [width, height];
        while level != [1, 1] {
            level = level.map(|side| (side / 2).max(1));
            texels += level[0] * level[1];
        }
        // Words may grow into new memory; encoded texels stay where they are.
        if self.chain.encoded.is_none() {
            texels += width * height;
        }
        let mips = texels * self.chain.format.words() as u64 * 4;
        // Four f64.
        let sums = (width + 1) * (height + 1) * 32;
        u64::from(filter.reads_mips() && self.levels() == 1) * mips
            + u64::from(filter.reads_summed_area() && !self.has_summed_area()) * sums
    }

    /// The same texels with `v = 0` on the other row. Costs nothing.
    #[must_use]
    pub fn with_origin(mut self, origin: Origin) -> Self {
        self.chain.flip = origin == Origin::BottomLeft;
        self
    }

    /// Columns of level 0.
    pub fn width(&self) -> u32 {
        self.chain.levels[0].width as u32
    }

    /// Rows of level 0.
    pub fn height(&self) -> u32 {
        self.chain.levels[0].height as u32
    }

    /// Levels of the chain, 1 without mips.
    pub fn levels(&self) -> u32 {
        self.chain.levels.len() as u32
    }

    /// Columns and rows of a level; `None` past the chain.
    pub fn level_size(&self, level: u32) -> Option<(u32, u32)> {
        self.chain
            .levels
            .get(level as usize)
            .map(|l| (l.width as u32, l.height as u32))
    }

    /// True if any texel of any level is not fully opaque (float alphas above one are).
    pub fn has_alpha(&self) -> bool {
        !self.chain.opaque
    }

    /// The row that `v = 0` touches.
    pub fn origin(&self) -> Origin {
        if self.chain.flip {
            Origin::BottomLeft
        } else {
            Origin::TopLeft
        }
    }

    /// One texel, linear and premultiplied; rows count from the origin. `None` outside.
    pub fn texel(&self, level: u32, x: u32, y: u32) -> Option<[f32; 4]> {
        let l = self.chain.levels.get(level as usize)?;
        if x >= l.width as u32 || y >= l.height as u32 {
            return None;
        }
        let scale = self.chain.format.scale();
        let texel = self.chain.fetch(l, x as i32, y as i32, 0);
        Some(scaled(texel, scale))
    }
}

pub(crate) fn check_size(width: u32, height: u32) -> Result<(), SampleError> {
    let range = 1..=Texture2d::MAX_SIDE;
    if range.contains(&width) && range.contains(&height) {
        Ok(())
    } else {
        Err(SampleError::Size { width, height })
    }
}

pub(crate) fn check_length(expected: usize, got: usize) -> Result<(), SampleError> {
    if expected == got {
        Ok(())
    } else {
        Err(SampleError::Length { expected, got })
    }
}

/// The largest magnitude of a float texel, 2^120: differences and weighted sums of texels stay finite.
pub const TEXEL_LIMIT: f32 = 1.329_228e36;

fn check_finite(texels: &TexelData<'_>, width: u32, channels: u32) -> Result<(), SampleError> {
    let TexelData::F32(values) = texels else {
        return Ok(());
    };
    match values
        .iter()
        .position(|v| v.is_nan() || v.abs() > TEXEL_LIMIT)
    {
        None => Ok(()),
        Some(i) => {
            let texel = i as u32 / channels;
            Err(SampleError::Texel {
                x: texel % width.max(1),
                y: texel / width.max(1),
            })
        }
    }
}

impl Image<'_> {
    /// Checks `depth` images that stand one after the other, and counts their texels.
    pub(crate) fn check(&self, depth: u32) -> Result<usize, SampleError> {
        let Self {
            width,
            height,
            channels,
            texels,
            ..
        } = *self;
        check_size(width, height)?;
        if !(1..=4).contains(&channels) {
            return Err(SampleError::Channels(channels));
        }
        let count = width as usize * height as usize * depth as usize;
        if count > 1 << 29 {
            return Err(SampleError::TooLarge { width, height });
        }
        check_length(count * channels as usize, texels.len())?;
        check_finite(&texels, width, channels)?;
        Ok(count)
    }
}
