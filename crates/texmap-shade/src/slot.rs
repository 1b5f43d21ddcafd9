//! Textures as meshes read them.

use std::borrow::Cow;

use texmap_math::{Footprint, Level};
use texmap_raster::{BATCH_STRIDE, Varyings};
use texmap_sample::{Places, Sampler, Texture2d, UvTransform, Wrap, sample_soa};
use texmap_scene::{TextureSlot, UvSet};

/// A texture as one mesh reads it.
pub struct Slot<'s> {
    /// The texture, with the levels that its filter reads.
    pub texture: Texture2d<'static>,
    /// Its texels as encoded pixels: see [`Texture2d::srgb8_codes`].
    pub(crate) codes: Option<Texture2d<'static>>,
    /// Filter and wraps.
    pub sampler: Cow<'s, Sampler>,
    /// Rows of the transform, if there is one.
    transform: Option<[[f32; 3]; 2]>,
    /// The coordinates that it is read at.
    pub uv_set: UvSet,
}

impl<'s> Slot<'s> {
    /// The texture, with the levels that its filter reads, and its sampler; transform and set of coordinates are those of `slot`.
    pub fn new(texture: Texture2d<'static>, sampler: Cow<'s, Sampler>, slot: &TextureSlot) -> Self {
        let transform = (slot.transform != UvTransform::default()).then(|| slot.transform.rows());
        Self {
            texture,
            codes: None,
            sampler,
            transform,
            uv_set: slot.uv_set,
        }
    }

    /// With its texels as encoded pixels, of the same size and origin: see [`Texture2d::srgb8_codes`].
    pub fn with_codes(self, codes: Option<Texture2d<'static>>) -> Self {
        Self { codes, ..self }
    }
}

impl Slot<'_> {
    /// Coordinates of the slot, and their footprint, from those of the mesh.
    pub fn place(&self, uv: [f32; 2], d: Footprint) -> ([f32; 2], Footprint) {
        let Some([[a, b, c], [e, f, g]]) = self.transform else {
            return (uv, d);
        };
        let uv = [a * uv[0] + b * uv[1] + c, e * uv[0] + f * uv[1] + g];
        let d = Footprint {
            du_dx: a * d.du_dx + b * d.dv_dx,
            dv_dx: e * d.du_dx + f * d.dv_dx,
            du_dy: a * d.du_dy + b * d.dv_dy,
            dv_dy: e * d.du_dy + f * d.dv_dy,
        };
        (uv, d)
    }

    /// Coordinates of the slot for the first `count` pixels of columns 0 and 1 of `uv`. They are `uv`, or `scratch` under a transform.
    pub fn placed<'a>(
        &self,
        uv: &'a Varyings,
        count: usize,
        scratch: &'a mut Varyings,
    ) -> &'a Varyings {
        if self.transform.is_none() {
            return uv;
        }
        scratch.varyings.clear();
        scratch.varyings.extend(uv.varyings.iter().take(2).cloned());
        self.place_columns(scratch, count);
        scratch
    }

    /// [`place`](Self::place) over the first `count` pixels of columns 0 and 1.
    pub fn place_columns(&self, values: &mut Varyings, count: usize) {
        if self.transform.is_none() {
            return;
        }
        let [u, v, ..] = &mut values.varyings[..] else {
            return;
        };
        self.place_all(
            [&mut u.value[..count], &mut v.value[..count]],
            [&mut u.ddx[..count], &mut v.ddx[..count]],
            [&mut u.ddy[..count], &mut v.ddy[..count]],
        );
    }

    /// [`place`](Self::place) over slices of one length, of coordinates and their changes to the right and down.
    pub fn place_all(
        &self,
        [u, v]: [&mut [f32]; 2],
        [ux, vx]: [&mut [f32]; 2],
        [uy, vy]: [&mut [f32]; 2],
    ) {
        for i in 0..u.len() {
            let d = Footprint::new(ux[i], vx[i], uy[i], vy[i]);
            let (uv, d) = self.place([u[i], v[i]], d);
            [u[i], v[i]] = uv;
            [ux[i], vx[i]] = [d.du_dx, d.dv_dx];
            [uy[i], vy[i]] = [d.du_dy, d.dv_dy];
        }
    }

    /// True if coordinates of the mesh are not those of the texture.
    pub fn is_transformed(&self) -> bool {
        self.transform.is_some()
    }

    /// True if the filter reads derivatives.
    pub fn reads_derivatives(&self) -> bool {
        self.sampler.filter.reads_derivatives()
    }

    /// The texel at coordinates of the mesh: linear, premultiplied.
    pub fn texel(&self, uv: [f32; 2], d: Footprint) -> [f32; 4] {
        let (uv, d) = self.place(uv, d);
        self.sampler.sample_grad(&self.texture, uv, d)
    }

    /// The texels of a ramp at numbers from 0 to 1 along it: linear, premultiplied.
    pub(crate) fn along(&self, level: Level, at: &[f32], out: [&mut [f32]; 4]) {
        let v = &[0.5; BATCH_STRIDE][..at.len()];
        let places = Places {
            u: at,
            v,
            gradients: None,
        };
        sample_soa(level, &self.sampler, &self.texture, &places, out)
            .expect("the columns have one length");
    }

    /// Fraction of a pixel inside of the outline where alpha is a half; `alpha` is that of the filter.
    pub fn outline(&self, uv: [f32; 2], d: Footprint, alpha: f32) -> f32 {
        let (uv, d) = self.place(uv, d);
        self.sampler.antialiased_alpha(&self.texture, uv, d, alpha)
    }

    /// Opacity of a texel of an opacity map.
    pub fn opacity(&self, texel: [f32; 4]) -> f32 {
        texel[self.opacity_channel()]
    }

    /// The channel that holds an opacity map's opacities.
    pub fn opacity_channel(&self) -> usize {
        if self.texture.has_alpha() { 3 } else { 0 }
    }

    /// True if some look-up may give less than full alpha.
    pub fn can_be_transparent(&self) -> bool {
        let s = &self.sampler;
        let border = s.wrap_u == Wrap::ClampToBorder || s.wrap_v == Wrap::ClampToBorder;
        self.texture.has_alpha() || (border && !(s.border[3] >= 1.0))
    }
}
