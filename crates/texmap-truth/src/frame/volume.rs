//! Volumes: matter that shines and absorbs, integrated along a ray (Max 1995, emission and absorption).

use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3, DVec4};
use texmap_sample::Wrap;
use texmap_scene::{Scene, Volume};

use super::color::straight;
use super::grid::Grid;
use super::slot::{Slot, Textures};

/// Look-ups for the length of a voxel, unless the scene's own steps are shorter.
const PER_VOXEL: f64 = 2.0;
/// The most look-ups of a ray.
const MOST: f64 = 4096.0;

/// A box of matter.
pub(super) struct Medium<'s> {
    volume: &'s Volume,
    grid: Grid,
    transfer: Option<Slot<'s>>,
    volume_from_world: DMat4,
}

impl<'s> Medium<'s> {
    pub(super) fn new(scene: &'s Scene, volume: &'s Volume, textures: &mut Textures<'s>) -> Self {
        let transfer = volume.transfer.as_ref();
        Self {
            volume,
            grid: Grid::new(
                &scene.effects.grids[volume.grid],
                &volume.sampler,
                [Wrap::ClampToEdge; 3],
            ),
            transfer: transfer.map(|slot| textures.slot(slot, texmap_sample::Origin::TopLeft)),
            volume_from_world: volume.world_from_volume.inverse(),
        }
    }

    /// Light of the volume along a ray of unit direction up to a distance: premultiplied, alpha is its opacity. The matter is taken as even
    /// over each of the short steps, the light that comes through them as `exp(-density length)`.
    pub(super) fn seen(&self, origin: DVec3, direction: DVec3, end: f64) -> DVec4 {
        let o = self.volume_from_world.transform_point3(origin);
        let d = self.volume_from_world.transform_vector3(direction);
        let Some((near, far)) = within(o, d, end) else {
            return DVec4::ZERO;
        };
        let voxel = 1.0 / (d * self.grid.size()).length();
        let step = (voxel / PER_VOXEL).min(f64::from(self.volume.step));
        let count = ((far - near) / step).ceil().clamp(1.0, MOST);
        let step = (far - near) / count;
        let (mut color, mut left) = (DVec3::ZERO, 1.0);
        for i in 0..count as u32 {
            let t = near + (f64::from(i) + 0.5) * step;
            let (shine, dense) = self.matter(o + d * t);
            if dense <= 0.0 {
                continue;
            }
            let clear = deterministic_f64::exp(-f64::from(self.volume.density) * dense * step);
            color += shine * (left * (1.0 - clear));
            left *= clear;
            if left < 1e-7 {
                break;
            }
        }
        color.min(DVec3::ONE).extend(1.0 - left)
    }

    /// Colour and density at a point of the box.
    fn matter(&self, at: DVec3) -> (DVec3, f64) {
        let voxel = self.grid.voxel(at, [DVec3::ZERO; 2]);
        let matter = match &self.transfer {
            Some(ramp) => ramp.along(voxel.x),
            None if self.grid.has_alpha_channel => voxel,
            None => voxel.truncate().extend(voxel.truncate().max_element()),
        };
        (straight(matter), matter.w)
    }
}

/// The part of a ray in the unit cube, from 0 to `end` at most.
fn within(origin: DVec3, direction: DVec3, end: f64) -> Option<(f64, f64)> {
    let (mut near, mut far) = (0.0f64, end);
    for k in 0..3 {
        if direction[k] == 0.0 {
            if !(0.0..=1.0).contains(&origin[k]) {
                return None;
            }
            continue;
        }
        let (a, b) = (-origin[k] / direction[k], (1.0 - origin[k]) / direction[k]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    (near < far && far.is_finite()).then_some((near, far))
}
