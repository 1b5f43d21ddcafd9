use crate::{
    Filter,
    address::wrap::{Axis, Wrap},
    error::SampleError,
    sampler::Sampler,
    texture::Texture2d,
};
use texmap_math::footprint::Footprint;

/// A rectangle of an atlas that acts as a texture of its own.
///
/// Around it lie `gutter` texels that repeat its border (clamping rectangles) or its other side
/// (repeating ones), so that filters may reach across.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasRect {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    gutter: u32,
    atlas: (u32, u32),
}

impl AtlasRect {
    /// Texels `x..x + width`, `y..y + height` of an atlas, without the gutter.
    ///
    /// # Errors
    /// The rectangle with its gutter is empty or leaves the atlas.
    pub fn new(
        atlas: &Texture2d<'_>,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
        gutter: u32,
    ) -> Result<Self, SampleError> {
        let fits = |at: u32, n: u32, side: u32| {
            n > 0
                && at >= gutter
                && u64::from(at) + u64::from(n) + u64::from(gutter) <= u64::from(side)
        };
        if !fits(x, width, atlas.width()) || !fits(y, height, atlas.height()) {
            return Err(SampleError::Size { width, height });
        }
        Ok(Self {
            x,
            y,
            width,
            height,
            gutter,
            atlas: (atlas.width(), atlas.height()),
        })
    }

    /// Atlas coordinates of a coordinate of the rectangle, which wraps or clamps within it.
    pub fn uv(&self, [u, v]: [f32; 2], wrap_u: Wrap, wrap_v: Wrap) -> [f32; 2] {
        let one = |u: f32, wrap: Wrap, at: u32, n: u32, side: u32| {
            let size = n as i32;
            let place = Axis::new(wrap, size).texels(u, size);
            let n = n as f32;
            let place = match wrap {
                Wrap::Repeat => place - n * texmap_math::float::floor_f32(place / n),
                Wrap::MirroredRepeat | Wrap::MirrorClampToEdge => place.abs(),
                Wrap::ClampToEdge | Wrap::ClampToBorder => place,
            };
            let place = if place > 0.0 {
                if place < n { place } else { n }
            } else {
                0.0
            };
            (at as f32 + place) / side as f32
        };
        [
            one(u, wrap_u, self.x, self.width, self.atlas.0),
            one(v, wrap_v, self.y, self.height, self.atlas.1),
        ]
    }

    /// The footprint in atlas coordinates.
    pub fn footprint(&self, d: Footprint) -> Footprint {
        let (x, y) = (
            self.width as f32 / self.atlas.0 as f32,
            self.height as f32 / self.atlas.1 as f32,
        );
        Footprint::new(d.du_dx * x, d.dv_dx * y, d.du_dy * x, d.dv_dy * y)
    }

    /// The level up to which a bilinear look-up stays within the gutter. A look-up reaches one texel of its level where rectangle and
    /// gutter are whole numbers of such texels, else one and a half: log2 of the gutter, or of two thirds of it; 0 for gutters of one
    /// texel or none.
    pub fn max_lod(&self) -> f32 {
        let log2 = |texels: u32| (u32::BITS - 1).saturating_sub(texels.max(1).leading_zeros());
        let level = log2(self.gutter);
        let sides = [self.x, self.y, self.width, self.height, self.gutter];
        if sides.iter().all(|side| side.trailing_zeros() >= level) {
            level as f32
        } else {
            log2((u64::from(self.gutter) * 2 / 3) as u32) as f32
        }
    }

    /// Samples the rectangle as a texture of its own, on no level that its gutter cannot guard. Anisotropic filters, which reach as far
    /// as their footprint is long, are trilinear here.
    pub fn sample_grad(
        &self,
        s: &Sampler,
        atlas: &Texture2d<'_>,
        uv: [f32; 2],
        d: Footprint,
    ) -> [f32; 4] {
        let uv = self.uv(uv, s.wrap_u, s.wrap_v);
        let mut s = s.clone();
        s.wrap_u = Wrap::ClampToEdge;
        s.wrap_v = Wrap::ClampToEdge;
        if matches!(s.filter, Filter::Anisotropic(_) | Filter::Ewa { .. }) {
            s.filter = Filter::Trilinear;
        }
        let most = self.max_lod();
        s.lod.max = if s.lod.max < most { s.lod.max } else { most };
        s.sample_grad(atlas, uv, self.footprint(d))
    }
}
