//! Texture fetches of a batch. RGBA8 texels stay packed until a block needs them; uv and mips are computed once for the textures that
//! share coordinates.

use texmap_math::simd::Isa;
use texmap_math::{Footprint, Level};
use texmap_raster::{AttributePlanes, BATCH_STRIDE, FragmentBlock, TileVisibility, Varyings};
use texmap_sample::lanes::packed::unpack_lanes;
use texmap_sample::lanes::{BoundTexture, sample_bound_soa};
use texmap_sample::{Places, sample_soa};

use crate::Slot;
use crate::batch::{Colors, LANES, straight};
use crate::texels::{Pixels, TexelAddresses, packed_view, read_pair};

/// Columns 0 and 1 as coordinates to sample at, with the derivatives that the filter reads.
pub(crate) fn pixel_samples<'a>(slot: &Slot<'_>, values: &'a Varyings, count: usize) -> Places<'a> {
    let [u, v] = [&values.varyings[0], &values.varyings[1]];
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

    /// The straight colors from pixel `at` on: black where alpha is 0.
    #[inline(always)]
    pub(crate) fn straight<I: Isa>(&self, i: I, at: usize) -> [I::F32; 3] {
        straight(i, self.colors.load(i, at))
    }
}

/// Texels of a batch: packed bytes, or channel by channel.
pub(crate) struct PackedTexels {
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
    /// The premultiplied colors from pixel `at` on.
    #[inline(always)]
    pub(crate) fn load<I: Isa>(&self, i: I, at: usize) -> [I::F32; 4] {
        if self.packed {
            unpack_lanes(i, i.load_u32(&self.words[at..at + I::LANES]))
        } else {
            self.colors.load(i, at)
        }
    }
}

/// Two textures that are read at the coordinates of the vertices as they are: base color and normal map.
#[derive(Default)]
pub struct TexturePair<'a> {
    slots: [Option<&'a Slot<'a>>; 2],
    /// The textures of the slots.
    bound: [Option<BoundTexture<'a>>; 2],
    /// All of them, if all are packed.
    views: Option<[Option<BoundTexture<'a>>; 2]>,
    /// The mips of both are the same.
    same_mips: bool,
    /// True if some filter reads derivatives.
    derivatives: bool,
}

impl<'a> TexturePair<'a> {
    /// Base color and normal map: packed words if both have a packed form at the same coordinates.
    pub fn new(slots: [Option<&'a Slot<'a>>; 2]) -> Self {
        let views = slots.map(|slot| slot.map(|slot| packed_view(&slot.sampler, &slot.texture)));
        // A slot without a view spoils it.
        let views = match views {
            [Some(None), _] | [_, Some(None)] => None,
            [base, normal] => Some([base.flatten(), normal.flatten()]),
        };
        let same_mips = match (slots, &views) {
            ([Some(base), Some(normal)], Some([Some(a), Some(b)])) => {
                a.kind == b.kind && a.size() == b.size() && base.sampler.lod == normal.sampler.lod
            }
            _ => false,
        };
        let derivatives = slots.into_iter().flatten().any(Slot::reads_derivatives);
        let bound =
            slots.map(|slot| slot.and_then(|slot| BoundTexture::new(&slot.sampler, &slot.texture)));
        Self {
            slots,
            bound,
            views,
            same_mips,
            derivatives,
        }
    }

    /// Reads the texels of a batch.
    pub(crate) fn fetch(
        &self,
        level: Level,
        planes: &AttributePlanes,
        blocks: &TileVisibility,
        batch: &[FragmentBlock],
        scratch: &mut PairScratch,
        out: &mut [PackedTexels; 2],
    ) {
        if self.slots.iter().all(Option::is_none) {
            return;
        }
        let PairScratch { values, addresses } = scratch;
        if let Some(views) = &self.views {
            let pixels = Pixels::Blocks(planes, blocks);
            let words = out.each_mut().map(|out| {
                out.packed = true;
                &mut out.words
            });
            read_pair(
                level,
                views,
                self.same_mips,
                &pixels,
                batch,
                addresses,
                words,
            );
            return;
        }
        planes.values(level, blocks, batch, &[0, 1], self.derivatives, values);
        let count = batch.len() * LANES;
        for ((slot, view), out) in self.slots.iter().zip(&self.bound).zip(out) {
            if let (Some(slot), Some(view)) = (slot, view) {
                out.packed = false;
                let (at, columns) = (
                    pixel_samples(slot, values, count),
                    out.colors.columns_mut(count),
                );
                sample_bound_soa(level, (&slot.sampler, view), &at, columns)
                    .expect("the columns have one length");
            }
        }
    }
}

/// Columns that a [`TexturePair`] reads.
#[derive(Default)]
pub(crate) struct PairScratch {
    values: Varyings,
    addresses: TexelAddresses,
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::borrow::Cow;
    use texmap_math::glam::{DMat4, DVec4};
    use texmap_math::simd::Scalar;
    use texmap_raster::{
        BATCH_PIXELS, BinnedDraws, DrawCall, NO_PRIMITIVE, NoAlphaTest, TargetSize,
    };
    use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d, Wrap};
    use texmap_scene::TextureSlot;

    pub(crate) fn noise(width: u32, height: u32) -> Texture2d<'static> {
        bordered(width, height, 0)
    }

    /// Within a black border.
    pub(crate) fn bordered(width: u32, height: u32, border: u32) -> Texture2d<'static> {
        let mut seed = width * 31 + height;
        let within = |i: u32, n: u32| (border..n - border).contains(&i);
        let texels: Vec<u8> = (0..width * height)
            .flat_map(|i| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let [_, r, g, b] = seed.to_le_bytes();
                match within(i % width, width) && within(i / width, height) {
                    true => [r, g, b, 255],
                    false => [0, 0, 0, 255],
                }
            })
            .collect();
        let texture =
            Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft);
        texture.unwrap().with_mips()
    }

    pub(crate) fn sampler(filter: Filter, wrap: Wrap) -> Sampler {
        Sampler {
            filter,
            wrap_u: wrap,
            precision: Precision::Fast,
            ..Sampler::default()
        }
    }

    /// The bits of the color of a pixel.
    pub(crate) fn bits(texels: &PackedTexels, at: usize) -> [u32; 3] {
        let [r, g, b, _] = texels.load(Scalar, at);
        [r, g, b].map(f32::to_bits)
    }

    /// Packed words are the texels that [`sample_soa`] gives, for each filter, wrap, origin and pair of sizes, with mips that both
    /// textures share and mips of their own, in perspective and over the edge of two triangles.
    #[test]
    fn packed_words_are_the_texels_of_the_general_fetches() {
        let level = Level::new();
        let textures = [noise(64, 64), noise(64, 64), noise(16, 32)];
        let corners = [[-1.3, -1.3], [1.3, -1.3], [1.3, 1.3], [-1.3, 1.3]];
        let draw = DrawCall {
            positions: &corners.map(|[x, y]| [x, y, 0.0]),
            indices: &[[0, 1, 2], [0, 2, 3]],
            // w is 1 + 0.4 y.
            clip_from_object: DMat4::from_cols(
                DVec4::X,
                DVec4::new(0.0, 1.0, 0.0, 0.4),
                DVec4::ZERO,
                DVec4::new(0.0, 0.0, 0.3, 1.0),
            ),
            attributes: &[-0.4, 0.2, 3.3, -0.3, 1.1, 2.7, 0.1, 5.9],
            attribute_count: 2,
            ..DrawCall::default()
        };
        let size = TargetSize::new(64, 64).unwrap();
        let prepared = BinnedDraws::with_level(size, &[draw], level, 1).unwrap();
        let (mut blocks, mut planes) = (TileVisibility::new(), AttributePlanes::new());
        prepared.visible_blocks(0, &NoAlphaTest, &mut blocks);
        prepared.planes(0, &mut planes);
        let all = blocks.masks.iter().enumerate();
        let all = all
            .filter(|(_, mask)| **mask != 0)
            .map(|(k, mask)| FragmentBlock {
                block: k as u16,
                mask: *mask,
                slot: NO_PRIMITIVE,
            });
        let list: Vec<FragmentBlock> = all.collect();
        assert!(list.len() > 150, "{}", list.len());
        let (mut shared, mut compared) = (0, 0);
        for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
            for wrap in [Wrap::Repeat, Wrap::ClampToEdge, Wrap::MirroredRepeat] {
                for (second, origin) in [
                    (1, Origin::TopLeft),
                    (1, Origin::BottomLeft),
                    (2, Origin::TopLeft),
                ] {
                    let slots = [0, second].map(|texture: usize| {
                        let texture = textures[texture].clone().with_origin(origin);
                        let sampler = Cow::Owned(sampler(filter, wrap));
                        Slot::new(texture, sampler, &TextureSlot::new(0))
                    });
                    let packed = TexturePair::new(slots.each_ref().map(Some));
                    assert!(packed.views.is_some(), "{filter:?} {wrap:?}");
                    let general = TexturePair {
                        views: None,
                        ..TexturePair::new(slots.each_ref().map(Some))
                    };
                    shared += u32::from(packed.same_mips);
                    let mut scratch = PairScratch::default();
                    let mut words: [PackedTexels; 2] = Default::default();
                    let mut floats: [PackedTexels; 2] = Default::default();
                    for batch in list.chunks(BATCH_PIXELS / LANES) {
                        packed.fetch(level, &planes, &blocks, batch, &mut scratch, &mut words);
                        general.fetch(level, &planes, &blocks, batch, &mut scratch, &mut floats);
                        for (words, floats) in words.iter().zip(&floats) {
                            assert!(words.packed && !floats.packed);
                            for (k, at) in batch.iter().enumerate() {
                                for bit in crate::batch::set_bits(at.mask) {
                                    let at = k * LANES + bit;
                                    let (a, b) = (bits(words, at), bits(floats, at));
                                    assert_eq!(a, b, "{filter:?} {wrap:?} {at}");
                                    compared += 1;
                                }
                            }
                        }
                    }
                }
            }
        }
        assert!(shared > 5 && compared > 100_000, "{shared} {compared}");
    }

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
