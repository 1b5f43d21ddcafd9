//! The maps of a surface, each read once for all stages where it can be, else by its stage.

use super::Surface;
use super::effects::SurfaceEffects;
use texmap_scene::UvSet;
use texmap_shade::Slot;
use texmap_shade::coordinates::Coordinates;
use texmap_shade::metallic::METALLIC_MAPS;
use texmap_shade::texture_set::{BASE_COLOR, EMISSION, METALLIC, MapSource, NORMAL, TEXTURES};

/// The textures of a surface that are read before its stages, and the sources of its maps.
#[derive(Clone, Copy)]
pub(super) struct SurfaceMaps<'a> {
    /// By their numbers in the set.
    pub(super) set: [Option<&'a Slot<'a>>; TEXTURES],
    pub(super) metallic: [MapSource<'a>; METALLIC_MAPS],
    pub(super) emission: MapSource<'a>,
}

impl<'a> SurfaceMaps<'a> {
    /// Base color and normal map, where they are read before the stages.
    pub(super) fn new([base, normal]: [Option<&'a Slot<'a>>; 2]) -> Self {
        let mut set = [None; TEXTURES];
        (set[BASE_COLOR], set[NORMAL]) = (base, normal);
        Self {
            set,
            metallic: [MapSource::None; METALLIC_MAPS],
            emission: MapSource::None,
        }
    }

    /// With the other maps of a surface.
    pub(super) fn with_others(
        mut self,
        surface: &'a Surface<'a>,
        effects: Option<&'a SurfaceEffects<'a>>,
    ) -> Self {
        let metallic = effects.map_or([None; METALLIC_MAPS], |effects| {
            effects.metallic.each_ref().map(Option::as_ref)
        });
        for (k, slot) in metallic.into_iter().enumerate() {
            self.metallic[k] = self.source(surface, METALLIC + k, slot);
        }
        let emission = surface.emission.as_ref().and_then(|(_, map)| map.as_ref());
        self.emission = self.source(surface, EMISSION, emission);
        self
    }

    fn source(
        &mut self,
        surface: &Surface<'_>,
        number: usize,
        slot: Option<&'a Slot<'a>>,
    ) -> MapSource<'a> {
        match slot {
            None => MapSource::None,
            Some(slot) if fits(surface, slot) => {
                self.set[number] = Some(slot);
                MapSource::Set(number)
            }
            Some(slot) => MapSource::Own(slot),
        }
    }

    /// True if some stage reads its map itself.
    pub(super) fn some_own(&self) -> bool {
        let mut sources = self.metallic.iter().chain([&self.emission]);
        sources.any(|map| matches!(map, MapSource::Own(_)))
    }
}

/// True if a texture is opaque and read at the coordinates of the vertices as they are.
pub(super) fn fits(surface: &Surface<'_>, slot: &Slot<'_>) -> bool {
    let uv = matches!(surface.uv, Coordinates::Vertices);
    let first = slot.uv_set == UvSet::First;
    uv && first && !slot.is_transformed() && !slot.can_be_transparent()
}
