//! Base color and opacity: texture, color ramp, antialiased alpha, solid texture, decal, vertex colors, opacity map.

use texmap_light::lanes::{Vector, splat};
use texmap_math::simd::{Isa, Scalar};
use texmap_raster::Varyings;

use crate::Slot;
use crate::batch::{Colors, LANES, columns, load_vector, parts, straight};
use crate::fetch::{Texels, footprint_at};
use crate::solid::SolidStage;
use crate::stage::{Inputs, Kernel, ShadeColumns};
use crate::texture_set::BASE_COLOR;
use texmap_scene::AlphaMode;

/// The base color of a surface.
#[derive(Clone, Copy)]
pub struct BaseColor<'a> {
    /// Factors of the straight texel.
    pub color: [f32; 3],
    /// The base color map.
    pub texture: Option<&'a Slot<'a>>,
    /// The base color is one color, or an opaque texture that is read at the coordinates of the vertices: see
    /// [`TextureSet`](crate::texture_set::TextureSet).
    pub paired: bool,
    /// Every texel is opaque.
    pub opaque_texels: bool,
    /// The first channel of the texture, or of the solid texture, is looked up along this.
    pub ramp: Option<&'a Slot<'a>>,
    /// Alpha becomes the coverage of the outline where it is a half.
    pub antialiased: bool,
    /// A solid texture in place of a map.
    pub solid: Option<&'a SolidStage<'a>>,
    /// A texture over the base color, by its own alpha.
    pub decal: Option<&'a Slot<'a>>,
    /// Opacities that replace the alpha of the base color map.
    pub opacity_map: Option<&'a Slot<'a>>,
    /// First attribute of the vertex colors.
    pub vertex_color: Option<usize>,
    /// Treatment of alpha.
    pub alpha: AlphaMode,
    /// A factor of alpha, 0 to 1.
    pub opacity: f32,
}

/// Texels that base colors are computed from.
#[derive(Default)]
pub(crate) struct BaseTexels {
    texture: Texels,
    solid: Colors,
    decal: Texels,
    opacity: Texels,
}

impl BaseColor<'_> {
    /// True if some texture is read by columns of coordinates.
    pub fn reads_uv(&self) -> bool {
        !self.paired
            && (self.texture.is_some() || self.decal.is_some() || self.opacity_map.is_some())
    }

    /// Reads the textures of the base colors of a batch, but for the texels of the set.
    pub(crate) fn fetch(&self, inputs: &Inputs<'_>, out: &mut BaseTexels) {
        let (level, batch) = (inputs.level, inputs.batch);
        let blocks = batch.list.len();
        if let Some(slot) = self.texture {
            let uv = inputs.uv_of(slot);
            out.texture.fetch(level, slot, uv, blocks);
            if let (Some(ramp), None) = (self.ramp, self.solid) {
                out.texture.fetch_along(level, [slot, ramp], uv, blocks);
            }
            if self.antialiased {
                let colors = &mut out.texture.colors;
                for (at, ..) in batch.fragments() {
                    let (place, d) = footprint_at(uv, at);
                    let texel = colors.get(at);
                    let alpha = slot.outline(place, d, texel[3]);
                    let [r, g, b] = straight(Scalar, texel);
                    colors.set(at, [r * alpha, g * alpha, b * alpha, alpha]);
                }
            }
        }
        if let Some(slot) = self.decal {
            out.decal.fetch(level, slot, inputs.uv_of(slot), blocks);
        }
        if let Some(slot) = self.opacity_map {
            out.opacity.fetch(level, slot, inputs.uv_of(slot), blocks);
        }
        if let Some(solid) = self.solid {
            solid.fetch(level, batch, &mut out.solid);
            if let Some(ramp) = self.ramp {
                let [values, ..] = out.solid.0;
                let count = blocks * LANES;
                ramp.along(level, &values[..count], out.solid.columns_mut(count));
            }
        }
    }

    /// The texels of the set, times the color.
    #[inline(always)]
    pub(crate) fn of_set<I: Isa>(&self, i: I, inputs: &Inputs<'_>, at: usize) -> Vector<I> {
        let [r, g, b] = match self.texture {
            Some(_) => inputs.textures[BASE_COLOR].opaque(i, at),
            None => [i.f32(1.0); 3],
        };
        [r * self.color[0], g * self.color[1], b * self.color[2]]
    }

    /// The premultiplied texels of the texture.
    #[inline(always)]
    pub(crate) fn texel<I: Isa>(&self, i: I, read: &BaseTexels, at: usize) -> [I::F32; 4] {
        let mut texel = match self.texture {
            Some(_) => read.texture.colors.load(i, at),
            None => [i.f32(1.0); 4],
        };
        if self.opaque_texels {
            texel[3] = i.f32(1.0);
        }
        texel
    }

    /// The decal over premultiplied colors, or colors without alpha.
    #[inline(always)]
    pub(crate) fn under_decal<I: Isa, const N: usize>(
        &self,
        i: I,
        read: &BaseTexels,
        at: usize,
        mut colors: [I::F32; N],
    ) -> [I::F32; N] {
        if self.decal.is_some() {
            let label = read.decal.colors.load(i, at);
            let keep = i.f32(1.0) - label[3];
            for (color, label) in colors.iter_mut().zip(label) {
                *color = label + keep * *color;
            }
        }
        colors
    }

    /// Colors times the vertex colors.
    #[inline(always)]
    fn tinted<I: Isa>(&self, i: I, values: &Varyings, at: usize, base: Vector<I>) -> Vector<I> {
        match self.vertex_color {
            Some(first) => {
                let tint = load_vector(i, columns(values, first), at);
                [base[0] * tint[0], base[1] * tint[1], base[2] * tint[2]]
            }
            None => base,
        }
    }

    /// Opacity of the material and its opacity map.
    #[inline(always)]
    pub(crate) fn opacity<I: Isa>(&self, i: I, read: &BaseTexels, at: usize) -> I::F32 {
        match self.opacity_map {
            Some(slot) => read.opacity.colors.load(i, at)[slot.opacity_channel()] * self.opacity,
            None => i.f32(self.opacity),
        }
    }

    /// Straight base colors and their alpha.
    #[inline(always)]
    fn load<I: Isa>(
        &self,
        i: I,
        read: &BaseTexels,
        values: &Varyings,
        at: usize,
    ) -> (Vector<I>, I::F32) {
        let texel = self.texel(i, read, at);
        let [r, g, b] = straight(i, texel);
        let mut base = [r * self.color[0], g * self.color[1], b * self.color[2]];
        if self.solid.is_some() {
            let [r, g, b] = straight(i, read.solid.load(i, at));
            base = [base[0] * r, base[1] * g, base[2] * b];
        }
        let base = self.under_decal(i, read, at, base);
        let alpha = match self.alpha {
            AlphaMode::Blend => texel[3] * self.opacity(i, read, at),
            _ => i.f32(1.0),
        };
        (self.tinted(i, values, at, base), alpha)
    }
}

/// Base colors as columns.
pub struct BaseStage<'a> {
    /// The base color.
    pub base: BaseColor<'a>,
    /// The form of the colors that the next stage reads.
    pub colors: BaseColors,
}

/// The colors that a [`BaseStage`] stores.
#[derive(Clone, Copy, PartialEq)]
pub enum BaseColors {
    /// The colors of the textures.
    Own,
    /// The color of the material alone, times the vertex colors; opaque.
    Material,
    /// Finished colors of the vertices, from this attribute on; the base color gives their alpha.
    Finished(usize),
}

impl Kernel for BaseStage<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        if !self.base.paired && self.colors != BaseColors::Material {
            self.base.fetch(inputs, &mut columns.base);
        }
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, out: &mut ShadeColumns) {
        let (base, values) = (&self.base, inputs.batch.values);
        for part in parts(i, inputs.batch.list) {
            let at = part.at;
            let (color, alpha) = if self.colors == BaseColors::Material {
                let color = base.tinted(i, values, at, splat(i, base.color));
                (color, i.f32(1.0))
            } else if base.paired {
                (base.of_set(i, inputs, at), i.f32(1.0))
            } else {
                base.load(i, &out.base, values, at)
            };
            let [r, g, b] = match self.colors {
                BaseColors::Finished(first) => load_vector(i, columns(values, first), at),
                _ => color,
            };
            out.color.store(i, at, [r, g, b, alpha]);
        }
    }
}
