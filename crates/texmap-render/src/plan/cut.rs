//! Alpha tests: which pixels of a cut-out exist.

use texmap_math::Footprint;
use texmap_sample::Filter;

use crate::textures::Slot;
use crate::{AlphaMode, Material};

/// Alpha of which a cut-out pixel is kept.
#[derive(Clone, Copy)]
pub(crate) enum Cut {
    Above(f32),
    AtLeast(f32),
}

impl Cut {
    /// The alpha test of a pixel at `place`, with the samplers and the level of detail of shading.
    pub(crate) fn keeps(
        self,
        place: Option<([f32; 2], Footprint)>,
        [base_color, opacity_map]: [Option<&Slot<'_>>; 2],
        opacity: f32,
    ) -> bool {
        let (uv, d) = place.unwrap_or_default();
        let texel = base_color.map_or(1.0, |s| s.texel(uv, d)[3]);
        let mask = opacity_map.map_or(1.0, |s| s.opacity(s.texel(uv, d)));
        let alpha = texel * mask * opacity;
        match self {
            Self::Above(t) => alpha > t,
            Self::AtLeast(t) => alpha >= t,
        }
    }
}

/// What an alpha test keeps; `None` if there is none, or nothing that it could cut out.
pub(crate) fn cut(
    material: &Material,
    base_color: Option<&Slot<'_>>,
    opacity_map: Option<&Slot<'_>>,
) -> Option<Cut> {
    let clear_texels = base_color.is_some_and(Slot::can_be_transparent);
    let has_alpha = material.opacity < 1.0 || opacity_map.is_some() || clear_texels;
    match material.alpha {
        AlphaMode::Test(t) if has_alpha && t > 0.0 => Some(Cut::AtLeast(t)),
        AlphaMode::Test(_) if has_alpha => {
            let alpha_source = opacity_map.or(base_color);
            let nearest = alpha_source.is_none_or(|s| picks_texels(s.sampler.filter));
            Some(if nearest {
                Cut::Above(0.0)
            } else {
                Cut::AtLeast(0.5)
            })
        }
        _ => None,
    }
}

fn picks_texels(filter: Filter) -> bool {
    matches!(filter, Filter::Nearest | Filter::MipNearest)
}
