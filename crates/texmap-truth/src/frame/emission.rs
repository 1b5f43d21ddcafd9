//! Light that a surface gives off itself.

use texmap_math::glam::DVec3;
use texmap_scene::{Emission, Mesh};

use super::color::wide;
use super::lighting::Point;
use super::slot::{Slot, Textures};

/// The emission of a surface.
pub(super) struct Emitter<'s> {
    color: DVec3,
    map: Option<Slot<'s>>,
}

impl<'s> Emitter<'s> {
    pub(super) fn new(emission: &'s Emission, mesh: &Mesh, textures: &mut Textures<'s>) -> Self {
        let map = emission.map.as_ref();
        Self {
            color: wide(emission.color),
            map: map.map(|slot| textures.slot(slot, mesh.uv_origin)),
        }
    }

    /// The emitted light, added to the light that the surface returns.
    pub(super) fn light(&self, at: &Point) -> DVec3 {
        let map = self.map.as_ref();
        self.color * map.map_or(DVec3::ONE, |slot| slot.straight(at.read(slot)))
    }
}
