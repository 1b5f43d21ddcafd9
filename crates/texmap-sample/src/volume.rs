//! One- and three-dimensional textures.

mod kernel;

pub(crate) use kernel::VolumeView;
pub use kernel::{UvwBatch, sample_3d_soa};

use crate::{
    address::{lod, wrap::Wrap},
    bound_texture::{BoundTexture, exact_format},
    error::SampleError,
    filter::Kernel,
    mip,
    sampler::Sampler,
    texel_data::{Chain, scaled},
    texture::{Alpha, Image, Texture2d},
    upload::upload,
};
use texmap_math::simd::{Isa, Scalar, prelude::*};

/// A texture along a line: a ramp, a table.
#[derive(Clone, Debug)]
pub struct Texture1d<'a> {
    texture: Texture2d<'a>,
}

impl Texture1d<'static> {
    /// From an image of one row.
    ///
    /// # Errors
    /// As [`Texture2d::new`], and for more than one row.
    pub fn new(image: &Image<'_>) -> Result<Self, SampleError> {
        if image.height != 1 {
            return Err(SampleError::Size {
                width: image.width,
                height: image.height,
            });
        }
        Ok(Self {
            texture: Texture2d::new(image)?,
        })
    }

    /// With its mip chain.
    #[must_use]
    pub fn with_mips(self) -> Self {
        Self {
            texture: self.texture.with_mips(),
        }
    }
}

impl Texture1d<'_> {
    /// Texels of level 0.
    pub fn width(&self) -> u32 {
        self.texture.width()
    }
}

/// A uniform grid of texels over the unit cube.
#[derive(Clone, Debug)]
pub struct Texture3d<'a> {
    chain: Chain<'a>,
    alpha_channel: bool,
}

impl Texture3d<'static> {
    /// From `depth` slices of the image's size that stand one after the other in its texels.
    ///
    /// # Errors
    /// As [`Texture2d::new`].
    pub fn new(depth: u32, slices: &Image<'_>) -> Result<Self, SampleError> {
        if !(1..=Texture2d::MAX_SIDE).contains(&depth) {
            return Err(SampleError::Size {
                width: slices.width,
                height: depth,
            });
        }
        Ok(Self {
            chain: upload(slices, depth)?,
            alpha_channel: slices.alpha != Alpha::Data && slices.channels.is_multiple_of(2),
        })
    }

    /// With its mip chain: all three sides halve.
    #[must_use]
    pub fn with_mips(self) -> Self {
        Self {
            chain: mip::build(self.chain, mip::Reduce::Volume),
            ..self
        }
    }
}

impl Texture3d<'_> {
    /// Columns, rows and slices of a level; `None` past the chain.
    pub fn level_size(&self, level: u32) -> Option<[u32; 3]> {
        let l = self.chain.levels.get(level as usize)?;
        Some([l.width as u32, l.height as u32, l.depth as u32])
    }

    /// Levels of the chain.
    pub fn levels(&self) -> u32 {
        self.chain.levels.len() as u32
    }

    /// Slices of level 0.
    fn depth(&self) -> i32 {
        self.chain.levels.first().map_or(1, |level| level.depth)
    }

    /// True if any texel is not fully opaque.
    pub fn has_alpha(&self) -> bool {
        !self.chain.opaque
    }

    /// True if the slices had an alpha channel, whatever it holds: two or four channels that are not [`Alpha::Data`].
    pub fn has_alpha_channel(&self) -> bool {
        self.alpha_channel
    }

    /// One texel, linear and premultiplied. `None` outside.
    pub fn texel(&self, level: u32, [x, y, z]: [u32; 3]) -> Option<[f32; 4]> {
        let l = self.chain.levels.get(level as usize)?;
        let [width, height, depth] = self.level_size(level)?;
        let inside = x < width && y < height && z < depth;
        let scale = self.chain.format.scale();
        inside.then(|| {
            let texel = self.chain.fetch(l, x as i32, y as i32, z as i32);
            scaled(texel, scale)
        })
    }
}

impl Texture3d<'_> {
    /// The level of detail where one pixel to the right moves (u, v, w) by `dx` and one down by `dy`: log2 of the longer in
    /// texels, without the bias and the limits that the look-up adds.
    pub fn lod(&self, dx: [f32; 3], dy: [f32; 3]) -> f32 {
        self.lod_lanes(Scalar, dx, dy)
    }

    /// [`lod`](Self::lod) for each lane.
    #[doc(hidden)]
    #[inline(always)]
    pub fn lod_lanes<I: Isa>(&self, i: I, dx: [I::F32; 3], dy: [I::F32; 3]) -> I::F32 {
        let base = &self.chain.levels[0];
        let size = [base.width as f32, base.height as f32, base.depth as f32];
        // No `map`: its closure is not always inlined.
        let (mut x, mut y) = (i.f32(0.0), i.f32(0.0));
        for k in 0..3 {
            let (along_x, along_y) = (lod::tame(i, dx[k] * size[k]), lod::tame(i, dy[k] * size[k]));
            x = x + along_x * along_x;
            y = y + along_y * along_y;
        }
        lod::log2(i, x.above(y)) * 0.5
    }
}

impl Sampler {
    /// The colour at `u` on a line; `lod` as [`Sampler::sample_lod`].
    pub fn sample_1d(&self, t: &Texture1d<'_>, u: f32, lod: f32) -> [f32; 4] {
        let along = Self {
            wrap_v: Wrap::ClampToEdge,
            ..self.clone()
        };
        along.sample_lod(&t.texture, [u, 0.5], lod)
    }

    /// The colour at (u, v, w) in a volume: nearest, or eight texels a level, with the filter's choice
    /// of levels at `lod`. The third axis wraps as `wrap_w` says; bicubic, anisotropic and EWA filters
    /// have no form in three dimensions and take eight texels.
    pub fn sample_3d(&self, t: &Texture3d<'_>, uvw: [f32; 3], wrap_w: Wrap, lod: f32) -> [f32; 4] {
        let format = exact_format(&t.chain);
        match BoundTexture::single(self, &t.chain, Kernel::Gl, format) {
            Some(view) => VolumeView::of(view, self, wrap_w, t.depth()).look(Scalar, uvw, lod),
            None => [0.0; 4],
        }
    }
}
