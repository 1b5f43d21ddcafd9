//! Light that a surface gives off itself, added after the light that it receives.

use texmap_sample::Origin;

use crate::Settings;
use crate::textures::{Chains, Slot};
use texmap_math::color::straight;
use texmap_scene::{Emission, Scene};

/// The emission of one surface.
pub(crate) struct EmissionStage<'s> {
    /// Linear light (raw values in raw mode).
    pub(crate) color: [f32; 3],
    /// Multiplies the colour.
    pub(crate) map: Option<Slot<'s>>,
}

impl<'s> EmissionStage<'s> {
    pub(crate) fn new(
        emission: &'s Emission,
        scene: &'s Scene,
        settings: &Settings,
        chains: &Chains,
        origin: Origin,
    ) -> Self {
        let slot = |slot| Slot::new(slot, scene, settings, chains, origin);
        Self {
            color: emission.color,
            map: emission.map.as_ref().map(slot),
        }
    }

    /// The emitted light where the map has this texel (premultiplied).
    pub(crate) fn of(&self, texel: Option<[f32; 4]>) -> [f32; 3] {
        match texel {
            Some(texel) => {
                let texel = straight(texel);
                [0, 1, 2].map(|k| texel[k] * self.color[k])
            }
            None => self.color,
        }
    }
}
