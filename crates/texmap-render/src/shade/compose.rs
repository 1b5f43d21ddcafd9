//! The colour of a sample from what the stages have found.

use super::{Stages, with_alpha};
use crate::plan::{LightStage, Surface};
use crate::texel::clip;
use texmap_math::color::straight;
use texmap_scene::{AlphaMode, TextureRole};

impl Stages {
    /// The colour of sample `i`.
    pub(super) fn compose(&self, surface: &Surface<'_>, i: usize) -> [f32; 4] {
        let material = surface.material;
        if surface.base_color.is_some() && material.texture_role == TextureRole::Decal {
            let mut texel = self.texel(surface, i);
            if let Some(label) = self.label(surface, i) {
                texel = [0, 1, 2, 3].map(|k| label[k] + (1.0 - label[3]) * texel[k]);
            }
            let [r, g, b, alpha] = texel;
            return match material.alpha {
                AlphaMode::Opaque if alpha < 1.0 => {
                    let base = self.tinted(surface, i, material.surface.color);
                    let under = self.light(surface, i, base);
                    let over = |texel: f32, under: f32| clip(texel + (1.0 - alpha) * under);
                    [over(r, under[0]), over(g, under[1]), over(b, under[2]), 1.0]
                }
                AlphaMode::Opaque => [clip(r), clip(g), clip(b), 1.0],
                AlphaMode::Test(_) => with_alpha(straight(texel).map(clip), 1.0),
                AlphaMode::Blend => {
                    with_alpha(straight(texel).map(clip), alpha * self.veil(surface, i))
                }
            };
        }
        let (base, alpha) = self.base_color(surface, i);
        with_alpha(self.light(surface, i, base), alpha)
    }

    /// The straight colour of sample `i` under its light, and its opacity.
    pub(super) fn base_color(&self, surface: &Surface<'_>, i: usize) -> ([f32; 3], f32) {
        let material = surface.material;
        let texel = self.texel(surface, i);
        let [r, g, b] = material.surface.color;
        let [tr, tg, tb] = straight(texel);
        let mut base = [r * tr, g * tg, b * tb];
        if surface.carved.is_some() {
            let color = straight(self.carved[i]);
            base = [0, 1, 2].map(|k| base[k] * color[k]);
        }
        if let Some(label) = self.label(surface, i) {
            base = [0, 1, 2].map(|k| label[k] + (1.0 - label[3]) * base[k]);
        }
        let alpha = if material.alpha == AlphaMode::Blend {
            texel[3] * self.veil(surface, i)
        } else {
            1.0
        };
        (self.tinted(surface, i, base), alpha)
    }

    fn texel(&self, surface: &Surface<'_>, i: usize) -> [f32; 4] {
        let mut texel = match surface.base_color {
            Some(_) => self.texel[i],
            None => [1.0; 4],
        };
        if surface.solid {
            texel[3] = 1.0;
        }
        texel
    }

    fn label(&self, surface: &Surface<'_>, i: usize) -> Option<[f32; 4]> {
        surface.decal.as_ref().map(|_| self.decal[i])
    }

    /// What the material and its opacity map leave.
    fn veil(&self, surface: &Surface<'_>, i: usize) -> f32 {
        let mask = surface
            .opacity_map
            .as_ref()
            .map_or(1.0, |slot| slot.opacity(self.mask[i]));
        surface.material.opacity * mask
    }

    fn tinted(&self, surface: &Surface<'_>, i: usize, base: [f32; 3]) -> [f32; 3] {
        match (surface.color, self.color.get(i)) {
            (Some(_), Some(tint)) => [base[0] * tint[0], base[1] * tint[1], base[2] * tint[2]],
            _ => base,
        }
    }

    /// A base colour under the surface's light and its own, clipped at 1.
    fn light(&self, surface: &Surface<'_>, i: usize, base: [f32; 3]) -> [f32; 3] {
        let emitted = surface.emission.as_ref().map(|stage| {
            let texel = stage.map.as_ref().map(|_| self.emitted[i]);
            stage.of(texel)
        });
        let plus = |a: [f32; 3]| match emitted {
            Some(b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
            None => a,
        };
        match surface.light {
            LightStage::None => plus(base).map(clip),
            // Without emission they are clipped at the vertices.
            LightStage::Colors(_) if emitted.is_some() => plus(self.color[i]).map(clip),
            LightStage::Colors(_) => self.color[i],
            LightStage::Terms { .. } | LightStage::PerPixel => {
                let base = match (&surface.effects, self.paint.get(i)) {
                    (Some(_), Some(paint)) => {
                        let keep = 1.0 - paint[3];
                        [0, 1, 2].map(|k| paint[k] + keep * base[k])
                    }
                    _ => base,
                };
                let mut terms = self.terms[i];
                terms.highlight = plus(terms.highlight);
                terms.color(base)
            }
        }
    }
}
