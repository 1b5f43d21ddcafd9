//! Textures as meshes read them.

use std::borrow::Cow;

use texmap_math::Footprint;
use texmap_raster::RunValues;
use texmap_sample::{Filter, Mip, Origin, Sampler, Texture2d, UvTransform, Wrap};

use crate::{Scene, Settings, TextureSlot};

/// Mip chains by texture, built once for both passes and only where a sampler reads them.
pub(crate) struct Chains(pub(crate) Vec<Option<Texture2d<'static>>>);

impl Chains {
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let mut chains = vec![None; scene.textures.len()];
        for mesh in &scene.meshes {
            let material = &scene.materials[mesh.material];
            for slot in material.slots() {
                let texture = &scene.textures[slot.texture];
                let filter = settings.filter.unwrap_or(slot.sampler.filter);
                let chain = &mut chains[slot.texture];
                if reads_mips(filter) && texture.levels() == 1 && chain.is_none() {
                    *chain = Some(texture.clone().with_mips());
                }
            }
        }
        Self(chains)
    }
}

fn reads_mips(filter: Filter) -> bool {
    !matches!(
        filter,
        Filter::Nearest | Filter::Bilinear | Filter::Bicubic(_) | Filter::Gl { mip: Mip::None, .. }
    )
}

/// A texture as one mesh reads it.
pub(crate) struct Slot<'s> {
    pub(crate) texture: Texture2d<'static>,
    pub(crate) sampler: Cow<'s, Sampler>,
    /// Rows of the transform, if there is one.
    transform: Option<[[f32; 3]; 2]>,
}

impl Slot<'_> {
    /// Where the slot is read for coordinates of the mesh.
    pub(crate) fn place(&self, uv: [f32; 2], d: Footprint) -> ([f32; 2], Footprint) {
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

    /// [`place`](Self::place) over the first `count` places of columns 0 and 1.
    pub(crate) fn place_columns(&self, values: &mut RunValues, count: usize) {
        if self.transform.is_none() {
            return;
        }
        let [u, v, ..] = &mut values.columns[..] else {
            return;
        };
        for i in 0..count {
            let d = Footprint {
                du_dx: u.ddx[i],
                dv_dx: v.ddx[i],
                du_dy: u.ddy[i],
                dv_dy: v.ddy[i],
            };
            let (uv, d) = self.place([u.value[i], v.value[i]], d);
            [u.value[i], v.value[i]] = uv;
            [u.ddx[i], v.ddx[i]] = [d.du_dx, d.dv_dx];
            [u.ddy[i], v.ddy[i]] = [d.du_dy, d.dv_dy];
        }
    }

    /// Whether the filter asks how large a pixel is.
    pub(crate) fn reads_derivatives(&self) -> bool {
        !matches!(
            self.sampler.filter,
            Filter::Nearest | Filter::Bilinear | Filter::Bicubic(_)
        )
    }

    /// The texel at coordinates of the mesh: linear, premultiplied.
    pub(crate) fn texel(&self, uv: [f32; 2], d: Footprint) -> [f32; 4] {
        let (uv, d) = self.place(uv, d);
        self.sampler.sample_grad(&self.texture, uv, d)
    }

    /// What an opacity map says by this texel.
    pub(crate) fn opacity(&self, texel: [f32; 4]) -> f32 {
        if self.texture.has_alpha() {
            texel[3]
        } else {
            texel[0]
        }
    }
}

impl<'s> Slot<'s> {
    pub(crate) fn new(
        slot: &'s TextureSlot,
        scene: &'s Scene,
        settings: &Settings,
        chains: &Chains,
        origin: Origin,
    ) -> Self {
        let texture = chains.0[slot.texture]
            .as_ref()
            .unwrap_or(&scene.textures[slot.texture]);
        let texture = texture.clone().with_origin(origin);
        let mut sampler = Cow::Borrowed(&slot.sampler);
        if let Some(filter) = settings.filter {
            sampler.to_mut().filter = filter;
        }
        if let Some(wrap) = settings.wrap {
            (sampler.to_mut().wrap_u, sampler.to_mut().wrap_v) = (wrap, wrap);
        }
        let transform = (slot.transform != UvTransform::default()).then(|| slot.transform.rows());
        Self {
            texture,
            sampler,
            transform,
        }
    }
}

impl Slot<'_> {
    /// Whether any look-up may give less than full alpha.
    pub(crate) fn can_be_transparent(&self) -> bool {
        let s = &self.sampler;
        let border = s.wrap_u == Wrap::ClampToBorder || s.wrap_v == Wrap::ClampToBorder;
        self.texture.has_alpha() || (border && s.border[3] < 1.0)
    }
}
