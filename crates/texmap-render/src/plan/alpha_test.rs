//! Alpha tests of cut-out pixels.

use texmap_math::{Footprint, Level};
use texmap_raster::UvBlock;
use texmap_sample::{Filter, Places, sample_soa};

use texmap_scene::{AlphaMode, Material};
use texmap_shade::Slot;
use texmap_shade::batch::LANES;

/// Alpha of which a cut-out pixel is kept.
#[derive(Clone, Copy)]
pub(crate) enum AlphaTestStage {
    Above(f32),
    AtLeast(f32),
}

impl AlphaTestStage {
    /// The alpha test of a pixel at `place`, uv and footprint. Samplers and level of detail are those of shading.
    pub(crate) fn keeps(
        self,
        place: Option<([f32; 2], Footprint)>,
        [base_color, opacity_map]: [Option<&Slot<'_>>; 2],
        opacity: f32,
    ) -> bool {
        let (uv, d) = place.unwrap_or_default();
        let texel = base_color.map_or(1.0, |s| s.texel(uv, d)[3]);
        let mask = opacity_map.map_or(1.0, |s| s.opacity(s.texel(uv, d)));
        self.passes(texel * mask * opacity)
    }

    /// [`keeps`](Self::keeps) for sixteen pixels, a bit each.
    pub(crate) fn keeps_block(
        self,
        level: Level,
        at: &UvBlock,
        [base_color, opacity_map]: [Option<&Slot<'_>>; 2],
        opacity: f32,
    ) -> u16 {
        let texel = base_color.map_or([1.0; LANES], |slot| texels(level, slot, at)[3]);
        let mask = opacity_map.map_or([1.0; LANES], |slot| {
            texels(level, slot, at)[slot.opacity_channel()]
        });
        (0..LANES).fold(0, |bits, i| {
            bits | u16::from(self.passes(texel[i] * mask[i] * opacity)) << i
        })
    }

    fn passes(self, alpha: f32) -> bool {
        match self {
            Self::Above(t) => alpha > t,
            Self::AtLeast(t) => alpha >= t,
        }
    }
}

/// Sixteen texels, channel by channel.
fn texels(level: Level, slot: &Slot<'_>, at: &UvBlock) -> [[f32; LANES]; 4] {
    let placed = slot.is_transformed().then(|| placed(slot, at));
    let UvBlock { value, ddx, ddy } = placed.as_ref().unwrap_or(at);
    let at = Places {
        u: &value[0],
        v: &value[1],
        gradients: slot
            .reads_derivatives()
            .then(|| [&ddx[0][..], &ddx[1], &ddy[0], &ddy[1]]),
    };
    let mut out = [[0.0; LANES]; 4];
    let columns = out.each_mut().map(|c| &mut c[..]);
    sample_soa(level, &slot.sampler, &slot.texture, &at, columns)
        .expect("the columns have one length");
    out
}

/// A block at the coordinates of the slot.
fn placed(slot: &Slot<'_>, at: &UvBlock) -> UvBlock {
    let mut out = at.clone();
    slot.place_all(
        slices(&mut out.value),
        slices(&mut out.ddx),
        slices(&mut out.ddy),
    );
    out
}

fn slices(pair: &mut [[f32; LANES]; 2]) -> [&mut [f32]; 2] {
    pair.each_mut().map(|c| &mut c[..])
}

/// The alpha test of a material; `None` if there is none, or nothing that it could cut out.
pub(crate) fn alpha_test(
    material: &Material,
    base_color: Option<&Slot<'_>>,
    opacity_map: Option<&Slot<'_>>,
) -> Option<AlphaTestStage> {
    let clear_texels = base_color.is_some_and(Slot::can_be_transparent);
    let has_alpha = material.opacity < 1.0 || opacity_map.is_some() || clear_texels;
    match material.alpha {
        AlphaMode::Test(t) if has_alpha && t > 0.0 => Some(AlphaTestStage::AtLeast(t)),
        AlphaMode::Test(_) if has_alpha => {
            let alpha_source = opacity_map.or(base_color);
            let nearest = alpha_source.is_none_or(|s| picks_texels(s.sampler.filter));
            Some(if nearest {
                AlphaTestStage::Above(0.0)
            } else {
                AlphaTestStage::AtLeast(0.5)
            })
        }
        _ => None,
    }
}

fn picks_texels(filter: Filter) -> bool {
    matches!(filter, Filter::Nearest | Filter::MipNearest)
}
