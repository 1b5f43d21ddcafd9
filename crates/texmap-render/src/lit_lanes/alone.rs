//! Stages without lanes, pixel by pixel between those that have some.

use texmap_light::{Environment, Ray};
use texmap_raster::RunBlock;

use super::Lamp;
use super::columns::{Columns, Side};
use crate::canvas::{LANES, bits, luminance, straight};
use crate::lit::Site;
use crate::textures::Slot;

/// A vector of each pixel of a block.
pub(super) type Three = [[f32; LANES]; 3];

fn of(three: &Three, bit: usize) -> [f32; 3] {
    three.each_ref().map(|c| c[bit])
}

fn put<const N: usize>(out: &mut [[f32; LANES]; N], bit: usize, value: [f32; N]) {
    for (column, c) in out.iter_mut().zip(value) {
        column[bit] = c;
    }
}

impl Columns<'_> {
    /// What reaches some pixels of a block of a light.
    #[inline(never)]
    pub(super) fn received_alone(
        &self,
        lamp: &Lamp<'_>,
        pixels: u16,
        i: usize,
        at: RunBlock,
        side: &Side,
    ) -> Three {
        let mut out = [[0.0; LANES]; 3];
        for bit in bits(pixels) {
            let site = self.site(i, at, bit, side);
            put(&mut out, bit, self.stage.ready.received(lamp.index, &site));
        }
        out
    }

    /// The paint on a block, premultiplied.
    #[inline(never)]
    pub(super) fn painted(&self, i: usize, at: RunBlock, side: &Side) -> [[f32; LANES]; 4] {
        let mut out = [[0.0; LANES]; 4];
        for bit in bits(at.mask) {
            let site = self.site(i, at, bit, side);
            put(&mut out, bit, self.stage.ready.paint(&site));
        }
        out
    }

    /// Where a pixel lies.
    fn site(&self, i: usize, at: RunBlock, bit: usize, side: &Side) -> Site {
        let place = i * LANES + bit;
        let first = self.stage.position.unwrap_or(0);
        let columns = &self.values.columns[first..first + 3];
        let effects = self.stage.surface.effects.as_ref();
        let plane = effects.map_or_else(Default::default, |effects| {
            let slot = self.run.slot(at, bit) as usize;
            let (_, triangle) = self.run.prepared.source(self.run.blocks.ids[slot]);
            effects.plane(triangle, side.back >> bit & 1 == 0)
        });
        Site {
            position: [0, 1, 2].map(|k| columns[k].value[place]),
            position_dx: [0, 1, 2].map(|k| columns[k].ddx[place]),
            position_dy: [0, 1, 2].map(|k| columns[k].ddy[place]),
            plane,
        }
    }
}

/// The light of an environment over mirrored rays: directions, and their changes to the right and down.
#[inline(never)]
pub(super) fn mirrored(environment: &Environment, pixels: u16, rays: &[Three; 3]) -> Three {
    let mut out = [[0.0; LANES]; 3];
    for bit in bits(pixels) {
        let ray = Ray {
            direction: of(&rays[0], bit),
            dx: of(&rays[1], bit),
            dy: of(&rays[2], bit),
        };
        put(&mut out, bit, environment.light_across(&ray));
    }
    out
}

/// Light along a ramp, by its luminance.
#[inline(never)]
pub(super) fn banded(ramp: &Slot<'_>, pixels: u16, light: &Three) -> Three {
    let mut out = [[0.0; LANES]; 3];
    for bit in bits(pixels) {
        let band = ramp.along(luminance(of(light, bit)));
        put(&mut out, bit, straight(band));
    }
    out
}
