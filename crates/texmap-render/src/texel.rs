//! The fast stage: surfaces whose colour is a texel or one colour, unlit and tinted by one factor. Their runs stay in columns
//! from the look-up to the canvas.

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::lanes::below;
use texmap_raster::{RUN_ROOM, RunValues};
use texmap_sample::{Places, gives_bytes, sample_columns, sample_rgba8_columns};

use crate::canvas::{Colors, LANES, finish, straight_lanes};
use crate::textures::Slot;
use texmap_math::color::straight;
use texmap_math::on_wide_level;
use texmap_scene::{AlphaMode, ColorMode, Material, TextureRole};

/// What stands between a texel and its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TexelStage {
    /// Factors of the straight texel.
    tint: [f32; 3],
    /// Factor of its alpha where the surface blends.
    veil: f32,
    blends: bool,
    /// Every look-up is opaque.
    solid: bool,
    /// Look-ups are bytes.
    bytes: bool,
    /// Those bytes are the finished pixels where nothing blends.
    plain: bool,
    /// The finished pixel of an opaque surface without a texture.
    word: u32,
}

impl TexelStage {
    /// For a surface that is unlit, without vertex colours and without an opacity map.
    pub(crate) fn new(
        material: &Material,
        base_color: Option<&Slot<'_>>,
        mode: ColorMode,
    ) -> Option<Self> {
        let decal = base_color.is_some() && material.texture_role == TextureRole::Decal;
        let solid = !base_color.is_some_and(Slot::can_be_transparent);
        // Where a clear decal lies on an opaque surface, that shows.
        if decal && !solid && material.alpha == AlphaMode::Opaque {
            return None;
        }
        let tint = if decal {
            [1.0; 3]
        } else {
            material.surface.color
        };
        let bytes = base_color.is_some_and(|slot| gives_bytes(&slot.sampler, &slot.texture));
        let mut stage = Self {
            tint,
            veil: material.opacity,
            blends: material.alpha == AlphaMode::Blend,
            solid,
            bytes,
            plain: bytes && mode == ColorMode::Raw && solid && tint == [1.0; 3],
            word: 0,
        };
        stage.word = finish(mode, stage.tinted([1.0; 4]));
        Some(stage)
    }

    /// Whether all colours are opaque.
    pub(crate) fn is_opaque(&self) -> bool {
        !self.blends || (self.solid && self.veil >= 1.0)
    }

    /// Whether [`words`](Self::words) may stand for [`colors`](Self::colors).
    pub(crate) fn gives_words(&self) -> bool {
        self.plain && self.is_opaque()
    }

    pub(crate) fn looks_up_bytes(&self) -> bool {
        self.bytes
    }

    /// The finished pixel of an opaque surface without a texture.
    pub(crate) fn word(&self) -> u32 {
        self.word
    }

    /// Finished pixels of a run of `count` places.
    pub(crate) fn words(
        level: Level,
        slot: &Slot<'_>,
        values: &mut RunValues,
        count: usize,
        out: &mut [u32],
    ) {
        slot.place_columns(values, count);
        sample_rgba8_columns(
            level,
            &slot.sampler,
            &slot.texture,
            &places(slot, values, count),
            &mut out[..count],
        )
        .expect("the columns have one length");
    }

    /// Colours of a run of `count` places.
    pub(crate) fn colors(
        &self,
        level: Level,
        slot: Option<&Slot<'_>>,
        values: &mut RunValues,
        count: usize,
        out: &mut Colors,
    ) {
        match slot {
            Some(slot) => {
                slot.place_columns(values, count);
                let columns = out.0.each_mut().map(|c| &mut c[..count]);
                sample_columns(
                    level,
                    &slot.sampler,
                    &slot.texture,
                    &places(slot, values, count),
                    columns,
                )
                .expect("the columns have one length");
            }
            None => out.0.iter_mut().for_each(|c| c[..count].fill(1.0)),
        }
        on_wide_level!(
            level,
            s => self.tint_lanes(s, count, out),
            else for place in 0..count {
                let color = self.tinted(out.0.each_ref().map(|c| c[place]));
                for (column, value) in out.0.iter_mut().zip(color) {
                    column[place] = value;
                }
            }
        );
    }

    /// A look-up to the colour of the surface, premultiplied.
    fn tinted(&self, texel: [f32; 4]) -> [f32; 4] {
        let color = if self.solid {
            [texel[0], texel[1], texel[2]]
        } else {
            straight(texel)
        };
        let alpha = match (self.blends, self.solid) {
            (false, _) => 1.0,
            (true, true) => self.veil,
            (true, false) => texel[3] * self.veil,
        };
        let [r, g, b] = [0, 1, 2].map(|c| clip(self.tint[c] * color[c]) * alpha);
        [r, g, b, alpha]
    }

    #[inline(always)]
    fn tint_lanes<S: Simd>(&self, s: S, count: usize, out: &mut Colors) {
        for i in 0..count.div_ceil(LANES) {
            let color = self.tint_block(s, out.lanes(s, i));
            for (to, color) in out.0.iter_mut().zip(&color) {
                color.store_slice(&mut to[i * LANES..(i + 1) * LANES]);
            }
        }
    }

    /// [`tinted`](Self::tinted) for sixteen.
    #[inline(always)]
    pub(crate) fn tint_block<S: Simd>(&self, s: S, texel: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
        let one = f32x16::splat(s, 1.0);
        let [mut r, mut g, mut b, a] = texel;
        let alpha = match (self.blends, self.solid) {
            (false, _) => one,
            (true, true) => f32x16::splat(s, self.veil),
            (true, false) => a * self.veil,
        };
        if !self.solid {
            [r, g, b] = straight_lanes(s, texel);
        }
        // A factor of one changes nothing, and bytes are not above one.
        if !(self.bytes && self.solid && self.tint == [1.0; 3]) {
            (r, g, b) = (r * self.tint[0], g * self.tint[1], b * self.tint[2]);
            (r, g, b) = (below(r, one), below(g, one), below(b, one));
        }
        [r * alpha, g * alpha, b * alpha, alpha]
    }
}

/// Coordinates of a run's pixels.
pub(crate) struct RunUv {
    pub(crate) u: [f32; RUN_ROOM],
    pub(crate) v: [f32; RUN_ROOM],
}

impl Default for RunUv {
    fn default() -> Self {
        Self {
            u: [0.0; RUN_ROOM],
            v: [0.0; RUN_ROOM],
        }
    }
}

impl RunUv {
    /// Those of a block.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 2] {
        let at = i * LANES..(i + 1) * LANES;
        [
            f32x16::from_slice(s, &self.u[at.clone()]),
            f32x16::from_slice(s, &self.v[at]),
        ]
    }

    #[inline(always)]
    pub(crate) fn put<S: Simd>(&mut self, i: usize, [u, v]: [f32x16<S>; 2]) {
        let at = i * LANES..(i + 1) * LANES;
        u.store_slice(&mut self.u[at.clone()]);
        v.store_slice(&mut self.v[at]);
    }
}

/// Attributes 0 and 1 as places to sample, with the derivatives that the filter reads.
pub(crate) fn places<'a>(slot: &Slot<'_>, values: &'a RunValues, count: usize) -> Places<'a> {
    let [u, v] = [&values.columns[0], &values.columns[1]];
    Places {
        u: &u.value[..count],
        v: &v.value[..count],
        gradients: slot.reads_derivatives().then(|| {
            [
                &u.ddx[..count],
                &v.ddx[..count],
                &u.ddy[..count],
                &v.ddy[..count],
            ]
        }),
    }
}

pub(crate) fn clip(value: f32) -> f32 {
    if value < 1.0 { value } else { 1.0 }
}
