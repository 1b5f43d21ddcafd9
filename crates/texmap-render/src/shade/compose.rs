//! Final colors: the base color under its light, and decals that cover their surface.

use texmap_math::simd::{Isa, prelude::*};
use texmap_scene::AlphaMode;

use super::base_color::BaseColor;
use super::batch::{parts, straight};
use super::stage::{Inputs, Kernel, ShadeColumns};

/// Premultiplied colors from base colors and their light.
pub(crate) struct Compose<'a> {
    /// The base color, where no stage has stored it: its texels are those of the pair.
    pub(crate) paired: Option<BaseColor<'a>>,
    /// `base * diffuse + highlight`; else the colors have their light already.
    pub(crate) lit: bool,
    /// Colors are clipped at 1.
    pub(crate) clips: bool,
}

impl Kernel for Compose<'_> {
    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let (at, one) = (part.at, i.f32(1.0));
            let [r, g, b, alpha] = match &self.paired {
                Some(base) => {
                    let [r, g, b] = base.of_pair(i, &inputs.pair[0], at);
                    [r, g, b, one]
                }
                None => columns.color.load(i, at),
            };
            let mut color = [r, g, b];
            if self.lit {
                let (diffuse, highlight) =
                    (columns.diffuse.load(i, at), columns.highlight.load(i, at));
                for k in 0..3 {
                    color[k] = color[k] * diffuse[k] + highlight[k];
                }
            }
            if self.clips {
                for c in &mut color {
                    *c = c.below(one);
                }
            }
            let [r, g, b] = color;
            let color = [r * alpha, g * alpha, b * alpha, alpha];
            columns.color.store(i, at, color);
        }
    }
}

/// A decal that covers its surface, which shows where an opaque decal is transparent.
pub(crate) struct Cover<'a>(pub(crate) BaseColor<'a>);

impl Kernel for Cover<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let base = &mut columns.base;
        self.0.fetch(inputs.level, inputs.batch, inputs.uv, base);
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let (base, one) = (&self.0, i.f32(1.0));
        for part in parts(i, inputs.batch.list) {
            let at = part.at;
            let texel = base.texel(i, &columns.base, at);
            let texel = base.under_decal(i, &columns.base, at, texel);
            let [r, g, b, alpha] = texel;
            if base.alpha == AlphaMode::Opaque {
                let clear = alpha.simd_lt(1.0);
                let under = columns.color.load(i, at);
                let keep = one - alpha;
                let mut color = [r, g, b, one];
                for k in 0..3 {
                    let mixed = clear.select(color[k] + keep * under[k], color[k]);
                    color[k] = mixed.below(one);
                }
                columns.color.store(i, at, color);
                continue;
            }
            let alpha = match base.alpha {
                AlphaMode::Blend => alpha * base.opacity(i, &columns.base, at),
                _ => one,
            };
            let [r, g, b] = straight(i, texel);
            let (r, g, b) = (r.below(one), g.below(one), b.below(one));
            let color = [r * alpha, g * alpha, b * alpha, alpha];
            columns.color.store(i, at, color);
        }
    }
}
