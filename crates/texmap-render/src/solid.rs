//! Solid textures: colour as a function of the place in space, carved by the surface (Perlin 1985; Peachey 1985).

use texmap_light::lanes::{V3, dot};
use texmap_math::fearless_simd::{Simd, prelude::*};
use texmap_math::lanes::above;
use texmap_math::{Level, on_wide_level};
use texmap_raster::{Column, RUN_ROOM};

use crate::canvas::{LANES, vector};
use texmap_scene::{Effects, Solid, SolidField};

/// A solid texture as the stages read it.
pub(crate) struct SolidStage<'s> {
    field: SolidField<'s>,
    /// First of the attributes that hold the world position.
    pub(crate) position: usize,
}

impl<'s> SolidStage<'s> {
    pub(crate) fn new(solid: &'s Solid, effects: &'s Effects, position: usize) -> Self {
        Self {
            field: SolidField::new(solid, effects),
            position,
        }
    }

    /// The colour at a world position that moves by `dx` and `dy` from pixel to pixel: linear, premultiplied.
    pub(crate) fn color(&self, p: [f32; 3], dx: [f32; 3], dy: [f32; 3]) -> [f32; 4] {
        self.field.color(p, dx, dy)
    }

    /// The values of a pattern at the world positions of a run, where it has lanes: each stands for all three channels.
    pub(crate) fn values(
        &self,
        level: Level,
        [x, y, z]: [&Column; 3],
        blocks: usize,
        out: &mut [f32; RUN_ROOM],
    ) -> bool {
        let Some(pattern) = self.field.pattern() else {
            return false;
        };
        on_wide_level!(
            level,
            s => {
                for i in 0..blocks {
                    let at = i * LANES..(i + 1) * LANES;
                    let value = [&x.value, &y.value, &z.value];
                    let mut place = self.along_lanes(s, value, i);
                    for (c, row) in place.iter_mut().zip(self.field.rows()) {
                        *c += row[3];
                    }
                    let [dx, dy] = [
                        self.along_lanes(s, [&x.ddx, &y.ddx, &z.ddx], i),
                        self.along_lanes(s, [&x.ddy, &y.ddy, &z.ddy], i),
                    ];
                    let width = above(dot(dx, dx), dot(dy, dy)).sqrt();
                    pattern.value_lanes(s, place, width).store_slice(&mut out[at]);
                }
                true
            },
            else false
        )
    }

    /// A vector of a block in solid space.
    #[inline(always)]
    fn along_lanes<S: Simd>(&self, s: S, columns: [&[f32; RUN_ROOM]; 3], i: usize) -> V3<S> {
        let v = vector(s, columns, i);
        let mut out = v;
        for (out, r) in out.iter_mut().zip(self.field.rows()) {
            *out = v[0] * r[0] + v[1] * r[1] + v[2] * r[2];
        }
        out
    }
}
