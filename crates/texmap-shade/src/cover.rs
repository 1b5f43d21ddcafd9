//! Texels that cover their surface, and the projectors on them.

use texmap_math::simd::{Isa, prelude::*};
use texmap_scene::AlphaMode;

use crate::base_color::BaseColor;
use crate::batch::{Part, parts, straight};
use crate::compose::Display;
use crate::paint::Paint;
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// A texture that covers its surface, which shows where an opaque one is transparent. Its texels are display light; no light of the
/// scene changes them.
pub struct Cover<'a> {
    /// The texels.
    pub base: BaseColor<'a>,
    /// Projectors on the texels.
    pub projected: Option<Projection<'a>>,
    /// The upper end of colors: 1, or the [limit](texmap_light::ToneMap::limit) of light that is not clipped.
    pub limit: f32,
}

/// Projectors on texels that are display light: paint covers them, then light is added, `texel + display(texel * diffuse + highlight)`.
pub struct Projection<'a> {
    /// Projectors that paint.
    pub paint: Paint<'a>,
    /// Tone mapping of the light of projectors, which the columns hold; `None` without any.
    pub light: Option<Display>,
}

impl Projection<'_> {
    /// The premultiplied texels of a part under the projectors.
    #[inline(always)]
    fn onto<I: Isa>(
        &self,
        i: I,
        inputs: &Inputs<'_>,
        columns: &ShadeColumns,
        part: &Part,
        texel: [I::F32; 4],
        limit: I::F32,
    ) -> [I::F32; 4] {
        let at = part.at;
        let mut color = self.paint.over(i, inputs, part, straight(i, texel));
        if let Some(display) = self.light {
            let (diffuse, highlight) = (columns.diffuse.load(i, at), columns.highlight.load(i, at));
            let mut light = color;
            for k in 0..3 {
                light[k] = light[k] * diffuse[k] + highlight[k];
            }
            let light = display.of(i, light);
            for k in 0..3 {
                color[k] = color[k] + light[k];
            }
        }
        let alpha = texel[3];
        let [r, g, b] = color;
        let (r, g, b) = (r.below(limit), g.below(limit), b.below(limit));
        [r * alpha, g * alpha, b * alpha, alpha]
    }
}

impl Kernel for Cover<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        self.base.fetch(inputs, &mut columns.base);
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        let (base, one, limit) = (&self.base, i.f32(1.0), i.f32(self.limit));
        for part in parts(i, inputs.batch.list) {
            let at = part.at;
            let texel = base.texel(i, &columns.base, at);
            let mut texel = base.under_decal(i, &columns.base, at, texel);
            if let Some(projected) = &self.projected {
                texel = projected.onto(i, inputs, columns, &part, texel, limit);
            }
            let [r, g, b, alpha] = texel;
            if base.alpha == AlphaMode::Opaque {
                let clear = alpha.simd_lt(1.0);
                let under = columns.color.load(i, at);
                let keep = one - alpha;
                let mut color = [r, g, b, one];
                for k in 0..3 {
                    let mixed = clear.select(color[k] + keep * under[k], color[k]);
                    color[k] = mixed.below(limit);
                }
                columns.color.store(i, at, color);
                continue;
            }
            let alpha = match base.alpha {
                AlphaMode::Blend => alpha * base.opacity(i, &columns.base, at),
                _ => one,
            };
            let [r, g, b] = straight(i, texel);
            let (r, g, b) = (r.below(limit), g.below(limit), b.below(limit));
            let color = [r * alpha, g * alpha, b * alpha, alpha];
            columns.color.store(i, at, color);
        }
    }
}
