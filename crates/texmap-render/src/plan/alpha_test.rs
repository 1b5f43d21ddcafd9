//! Alpha tests of cut-out pixels.

use texmap_math::{Footprint, Level};
use texmap_raster::{AlphaTest, Fragment, UvBlock};
use texmap_sample::lanes::{BoundTexture, sample_bound_soa};
use texmap_sample::{Filter, Places};

use super::Plan;
use texmap_scene::{AlphaMode, Material};
use texmap_shade::Slot;
use texmap_shade::batch::LANES;
use texmap_shade::coordinates::Coordinates;

/// The alpha tests of the surfaces of a plan.
pub(crate) struct BoundAlphaTests<'a> {
    plan: &'a Plan<'a>,
    /// The maps of each surface that is cut out and lies in the first set of coordinates.
    maps: Vec<Option<Box<[Option<BoundMap<'a>>; 2]>>>,
}

/// A map of an alpha test, and its texture.
pub(crate) type BoundMap<'a> = (&'a Slot<'a>, BoundTexture<'a>);

/// A map and its texture as the test of a block reads them.
pub(crate) fn bound<'a>(slot: Option<&'a Slot<'a>>) -> Option<BoundMap<'a>> {
    let slot = slot?;
    Some((slot, BoundTexture::new(&slot.sampler, &slot.texture)?))
}

impl<'a> BoundAlphaTests<'a> {
    pub(crate) fn new(plan: &'a Plan<'a>) -> Self {
        let maps = plan.surfaces.iter().map(|surface| {
            let by_uv = matches!(surface.uv, Coordinates::Vertices) && !surface.cut_by_second();
            (by_uv && surface.cut.is_some()).then(|| {
                let maps = [&surface.base_color, &surface.opacity_map];
                Box::new(maps.map(|map| bound(map.as_ref())))
            })
        });
        Self {
            plan,
            maps: maps.collect(),
        }
    }
}

impl AlphaTest for BoundAlphaTests<'_> {
    fn keep(&self, draw: u32, _triangle: u32, fragment: &Fragment) -> bool {
        self.plan.surfaces[draw as usize].kept(fragment)
    }

    fn keep_by_uv(&self, draw: u32, at: &UvBlock, asked: u16) -> Option<u16> {
        let surface = &self.plan.surfaces[draw as usize];
        let Some(cut) = surface.cut else {
            return Some(asked);
        };
        let maps = self.maps[draw as usize].as_deref()?;
        let maps = maps.each_ref().map(Option::as_ref);
        Some(cut.keeps_block(self.plan.level, at, maps, surface.material.opacity))
    }
}

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
        [base_color, opacity_map]: [Option<&BoundMap<'_>>; 2],
        opacity: f32,
    ) -> u16 {
        let texel = base_color.map_or([1.0; LANES], |map| texels(level, map, at)[3]);
        let mask = opacity_map.map_or([1.0; LANES], |map| {
            texels(level, map, at)[map.0.opacity_channel()]
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
fn texels(level: Level, (slot, view): &BoundMap<'_>, at: &UvBlock) -> [[f32; LANES]; 4] {
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
    sample_bound_soa(level, (&slot.sampler, view), &at, columns)
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
