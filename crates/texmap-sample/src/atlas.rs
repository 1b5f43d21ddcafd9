use crate::{
    Filter,
    address::wrap::{Axis, Wrap},
    error::SampleError,
    filter::gl_of,
    sampler::{Sampler, TexelFilter},
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

    /// Atlas coordinates of a coordinate of the rectangle, which wraps or clamps within it. On its far border begins the texel outside, which
    /// a nearest look-up there takes; [`sample_grad`](Self::sample_grad) does not.
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

    /// [`uv`](Self::uv) for a sampler: at the centre of the texel that a nearest filter takes, and without a gutter no nearer than half a texel
    /// to the border.
    fn guarded_uv(&self, s: &Sampler, [u, v]: [f32; 2]) -> [f32; 2] {
        let (mag, min, _) = gl_of(s.filter);
        let nearest = mag == TexelFilter::Nearest && min == mag;
        let uv = self.uv([u, v], s.wrap_u, s.wrap_v);
        let one = |u: f32, wrap: Wrap, uv: f32, (at, n, side): (u32, u32, u32)| {
            let (first, side) = (at as f32, side as f32);
            if nearest {
                // Beyond a clamped rectangle its border continues, as it does in a gutter.
                let wrap = match wrap {
                    Wrap::ClampToBorder => Wrap::ClampToEdge,
                    wrap => wrap,
                };
                let texel = Axis::new(wrap, n as i32).nearest(u, n as i32);
                (first + texel as f32 + 0.5) / side
            } else if self.gutter == 0 {
                uv.clamp((first + 0.5) / side, (first + n as f32 - 0.5) / side)
            } else {
                uv
            }
        };
        let across = (self.x, self.width, self.atlas.0);
        let down = (self.y, self.height, self.atlas.1);
        [
            one(u, s.wrap_u, uv[0], across),
            one(v, s.wrap_v, uv[1], down),
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
    /// as their footprint is long, are trilinear here. Linear filters blend across a border, as repeating textures ask, with a gutter alone;
    /// cubic ones need one of two texels. There is no border colour: `ClampToBorder` is `ClampToEdge`.
    pub fn sample_grad(
        &self,
        s: &Sampler,
        atlas: &Texture2d<'_>,
        uv: [f32; 2],
        d: Footprint,
    ) -> [f32; 4] {
        let uv = self.guarded_uv(s, uv);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texel_data::TexelData;
    use crate::texture::{Alpha, ColorSpace, Image, Origin};
    use alloc::vec::Vec;

    /// On and beside its borders a rectangle without a gutter has the texels of a texture of its own, whichever side is a power of two.
    #[test]
    fn borders_take_no_texel_of_a_neighbour() {
        let image = |width, height, texels: &[f32]| {
            Texture2d::new(&Image {
                width,
                height,
                channels: 1,
                texels: TexelData::F32(texels),
                color: ColorSpace::Linear,
                alpha: Alpha::Data,
                origin: Origin::TopLeft,
            })
            .unwrap()
        };
        let texels: Vec<f32> = (0..32 * 16).map(|i| i as f32).collect();
        let atlas = image(32, 16, &texels);
        let rect = AtlasRect::new(&atlas, 4, 3, 8, 6, 0).unwrap();
        let own: Vec<f32> = (0..48)
            .map(|i| texels[(3 + i / 8) * 32 + 4 + i % 8])
            .collect();
        let own = image(8, 6, &own);
        let coordinates = [
            -3.0,
            -1.0,
            -1e-9,
            0.0,
            0.3,
            1.0 - f32::EPSILON,
            1.0,
            1.2,
            3.0,
        ];
        let modes = [
            Wrap::Repeat,
            Wrap::MirroredRepeat,
            Wrap::ClampToEdge,
            Wrap::MirrorClampToEdge,
        ];
        for filter in [Filter::Nearest, Filter::MipNearest, Filter::Bilinear] {
            for wrap in modes {
                // Repeating textures blend across their borders, which takes a gutter.
                if filter == Filter::Bilinear && wrap == Wrap::Repeat {
                    continue;
                }
                let s = Sampler {
                    filter,
                    wrap_u: wrap,
                    wrap_v: wrap,
                    ..Sampler::default()
                };
                for u in coordinates {
                    for v in coordinates {
                        let got = rect.sample_grad(&s, &atlas, [u, v], Footprint::default())[0];
                        let want = s.sample_grad(&own, [u, v], Footprint::default())[0];
                        let near = (got - want).abs() < 0.01;
                        assert!(near, "{filter:?} {wrap:?} {u} {v}: {got} {want}");
                    }
                }
            }
        }
    }
}
