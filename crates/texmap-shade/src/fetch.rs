//! Texture fetches of a batch. RGBA8 texels stay packed until a block needs them; uv and mips are computed once for the textures that
//! share coordinates.

use texmap_math::simd::Isa;
use texmap_math::{Footprint, Level};
use texmap_raster::{BATCH_STRIDE, Varyings};
use texmap_sample::lanes::packed::unpack_lanes;
use texmap_sample::{Places, sample_dependent_soa, sample_soa};

use crate::Slot;
use crate::batch::{Colors, LANES, straight};

/// Columns 0 and 1 as coordinates to sample at, with the derivatives that the filter reads.
pub(crate) fn pixel_samples<'a>(slot: &Slot<'_>, values: &'a Varyings, count: usize) -> Places<'a> {
    let [u, v] = [&values.varyings[0], &values.varyings[1]];
    Places {
        u: &u.value[..count],
        v: &v.value[..count],
        gradients: slot.reads_derivatives().then(|| gradients(values, count)),
    }
}

/// The derivatives of columns 0 and 1.
fn gradients(values: &Varyings, count: usize) -> [&[f32]; 4] {
    let [u, v] = [&values.varyings[0], &values.varyings[1]];
    [&u.ddx, &v.ddx, &u.ddy, &v.ddy].map(|column| &column[..count])
}

/// The coordinates of a pixel, and their footprint.
pub(crate) fn footprint_at(uv: &Varyings, at: usize) -> ([f32; 2], Footprint) {
    let [u, v] = [&uv.varyings[0], &uv.varyings[1]];
    let d = Footprint::new(u.ddx[at], v.ddx[at], u.ddy[at], v.ddy[at]);
    ([u.value[at], v.value[at]], d)
}

/// The texels of one texture over a batch, premultiplied.
#[derive(Default)]
pub(crate) struct Texels {
    /// Coordinates of the slot, where it has some of its own.
    placed: Varyings,
    pub(crate) colors: Colors,
    /// Texels of a ramp.
    along: Colors,
}

impl Texels {
    /// Reads a texture at the coordinates of `blocks` blocks, columns 0 and 1 of `uv`.
    pub(crate) fn fetch(&mut self, level: Level, slot: &Slot<'_>, uv: &Varyings, blocks: usize) {
        let count = blocks * LANES;
        let uv = slot.placed(uv, count, &mut self.placed);
        let (at, columns) = (
            pixel_samples(slot, uv, count),
            self.colors.columns_mut(count),
        );
        sample_soa(level, &slot.sampler, &slot.texture, &at, columns)
            .expect("the columns have one length");
    }

    /// Looks the first channel of a texture up along a ramp, by the change of both; the alpha of the texture, which
    /// [`fetch`](Self::fetch) has read, stays a factor.
    pub(crate) fn fetch_along(
        &mut self,
        level: Level,
        [slot, ramp]: [&Slot<'_>; 2],
        uv: &Varyings,
        blocks: usize,
    ) {
        let count = blocks * LANES;
        let uv = slot.placed(uv, count, &mut self.placed);
        let at = Places {
            gradients: Some(gradients(uv, count)),
            ..pixel_samples(slot, uv, count)
        };
        let [first, second] = [slot, ramp].map(|s| (&*s.sampler, &s.texture));
        let along = self.along.columns_mut(count);
        sample_dependent_soa(level, first, second, &at, along)
            .expect("the columns have one length");
        let [.., alpha] = self.colors.0;
        for (color, along) in self.colors.0.iter_mut().zip(&self.along.0) {
            for ((color, along), keep) in color.iter_mut().zip(along).zip(&alpha).take(count) {
                *color = along * keep;
            }
        }
    }

    /// The straight colors from pixel `at` on: black where alpha is 0.
    #[inline(always)]
    pub(crate) fn straight<I: Isa>(&self, i: I, at: usize) -> [I::F32; 3] {
        straight(i, self.colors.load(i, at))
    }
}

/// Texels of a batch: packed bytes, or channel by channel.
pub struct PackedTexels {
    pub(crate) words: [u32; BATCH_STRIDE],
    pub(crate) colors: Colors,
    pub(crate) packed: bool,
}

impl Default for PackedTexels {
    fn default() -> Self {
        Self {
            words: [0; BATCH_STRIDE],
            colors: Colors::default(),
            packed: false,
        }
    }
}

impl PackedTexels {
    /// True if they are bytes: four of a pixel in one word.
    pub fn is_packed(&self) -> bool {
        self.packed
    }

    /// The premultiplied colors from pixel `at` on.
    #[inline(always)]
    pub fn load<I: Isa>(&self, i: I, at: usize) -> [I::F32; 4] {
        if self.packed {
            unpack_lanes(i, i.load_u32(&self.words[at..at + I::LANES]))
        } else {
            self.colors.load(i, at)
        }
    }

    /// The colors of opaque texels from pixel `at` on.
    #[inline(always)]
    pub(crate) fn opaque<I: Isa>(&self, i: I, at: usize) -> [I::F32; 3] {
        let [r, g, b, _] = self.load(i, at);
        [r, g, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_raster::BATCH_PIXELS;

    /// Unpacked bytes are whole numbers over 255 at every width.
    #[test]
    fn unpacked_bytes_are_those_of_every_width() {
        use texmap_math::dispatch_simd;
        let mut texels = PackedTexels {
            packed: true,
            ..PackedTexels::default()
        };
        for (k, word) in texels.words.iter_mut().enumerate() {
            *word = (k as u32).wrapping_mul(0x9e37_79b9);
        }
        let mut out = Colors::default();
        for level in [Level::new(), Level::baseline()] {
            dispatch_simd!(level, i => load_all(i, &texels, &mut out));
            for at in 0..BATCH_PIXELS {
                let bytes = texels.words[at].to_le_bytes();
                assert_eq!(out.get(at), bytes.map(|b| f32::from(b) * (1.0 / 255.0)));
            }
        }

        #[inline(always)]
        fn load_all<I: Isa>(i: I, texels: &PackedTexels, out: &mut Colors) {
            for at in (0..BATCH_PIXELS).step_by(I::LANES) {
                out.store(i, at, texels.load(i, at));
            }
        }
    }
}
