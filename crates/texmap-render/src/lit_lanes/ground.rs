//! What lies under the light: base colour and opacity.

use texmap_light::lanes::{V3, splat};
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::simd::X16;

use super::columns::Columns;
use super::fits;
use super::vectors::three;
use crate::canvas::{Colors, straight_lanes};
use crate::plan::Surface;
use crate::textures::Slot;
use texmap_scene::AlphaMode;

/// How base colours are found.
pub(super) enum Ground<'a> {
    /// One colour, or an opaque texture by packed look-ups.
    Texels,
    /// By maps of any kind, and vertex colours from this attribute on.
    Maps {
        base: Option<&'a Slot<'a>>,
        opacity: Option<&'a Slot<'a>>,
        tint: Option<usize>,
    },
    /// Decals, outlines, ramps and solids: pixel by pixel.
    Stages,
}

impl<'a> Ground<'a> {
    pub(super) fn new(surface: &'a Surface<'a>) -> Self {
        let (base, opacity) = (surface.base_color.as_ref(), surface.opacity_map.as_ref());
        let material = surface.material;
        if surface.color_ramp.is_some()
            || surface.decal.is_some()
            || surface.carved.is_some()
            || material.crisp
        {
            return Self::Stages;
        }
        let whole = material.alpha == AlphaMode::Opaque && opacity.is_none();
        if whole && surface.color.is_none() && base.is_none_or(|slot| fits(surface, slot)) {
            return Self::Texels;
        }
        Self::Maps {
            base,
            opacity,
            tint: surface.color,
        }
    }

    /// Whether it reads coordinates as columns.
    pub(super) fn reads_uv(&self) -> bool {
        match self {
            Self::Maps { base, opacity, .. } => base.is_some() || opacity.is_some(),
            _ => false,
        }
    }
}

impl Columns<'_> {
    /// The base colours of a block by packed look-ups.
    #[inline(always)]
    pub(super) fn texels<S: Simd>(&self, s: S, i: usize) -> V3<S> {
        let [r, g, b] = match self.stage.surface.base_color {
            Some(_) => self.read.texels[0].lanes(s, i),
            None => [f32x16::splat(s, 1.0); 3],
        };
        let color = self.stage.numbers.color;
        [r * color[0], g * color[1], b * color[2]]
    }

    /// The base colours of a block, straight, and its opacities; `found` holds those that the stages have found.
    #[inline(always)]
    pub(super) fn ground<S: Simd>(&self, s: S, i: usize, found: &Colors) -> (V3<S>, f32x16<S>) {
        let (surface, one) = (self.stage.surface, f32x16::splat(s, 1.0));
        let material = surface.material;
        let color = splat(X16(s), self.stage.numbers.color);
        match &self.stage.ground {
            Ground::Texels => (self.texels(s, i), one),
            Ground::Maps {
                base,
                opacity,
                tint,
            } => {
                let mut texel = match base {
                    Some(_) => self.read.base.lanes(s, i),
                    None => [one; 4],
                };
                if surface.solid {
                    texel[3] = one;
                }
                let [r, g, b] = straight_lanes(s, texel);
                let mut base = [r * color[0], g * color[1], b * color[2]];
                if let Some(first) = tint {
                    let tint = three(s, self.run.values, *first, i);
                    base = [base[0] * tint[0], base[1] * tint[1], base[2] * tint[2]];
                }
                if material.alpha != AlphaMode::Blend {
                    return (base, one);
                }
                let mask = match opacity {
                    Some(slot) => self.read.opacity.lanes(s, i)[slot.opacity_channel()],
                    None => one,
                };
                (base, texel[3] * (mask * material.opacity))
            }
            Ground::Stages => {
                let [r, g, b, alpha] = found.lanes(s, i);
                ([r, g, b], alpha)
            }
        }
    }
}
