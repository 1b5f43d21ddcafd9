//! Texels that a batch fetches as packed bytes are those of the general look-ups, for base color, normal map and projectors.

use std::borrow::Cow;

use texmap_light::{BoundProjectorTexture, ProjectorBorder, ProjectorTexture};
use texmap_math::glam::{DMat4, DVec3, DVec4};
use texmap_math::simd::Scalar;
use texmap_math::{Level, Projector};
use texmap_raster::{
    AttributePlanes, BATCH_PIXELS, BATCH_STRIDE, BinnedDraws, DrawCall, FragmentBlock,
    NO_PRIMITIVE, NoAlphaTest, TargetSize, TileVisibility, Varying,
};
use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d, Wrap};
use texmap_scene::TextureSlot;
use texmap_shade::Slot;
use texmap_shade::batch::{LANES, set_bits};
use texmap_shade::fetch::PackedTexels;
use texmap_shade::projector::{Projected, ProjectorStage, ProjectorTexels};
use texmap_shade::texture_set::{BASE_COLOR, NORMAL, SetScratch, TEXTURES, TextureSet};

fn noise(width: u32, height: u32) -> Texture2d<'static> {
    bordered(width, height, 0)
}

/// Within a black border.
fn bordered(width: u32, height: u32, border: u32) -> Texture2d<'static> {
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
    let texture = Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft);
    texture.unwrap().with_mips()
}

fn sampler(filter: Filter, wrap: Wrap) -> Sampler {
    Sampler {
        filter,
        wrap_u: wrap,
        precision: Precision::Fast,
        ..Sampler::default()
    }
}

/// The bits of the color of a pixel.
fn bits(texels: &PackedTexels, at: usize) -> [u32; 3] {
    let [r, g, b, _] = texels.load(Scalar, at);
    [r, g, b].map(f32::to_bits)
}

/// Packed words are the texels that `sample_soa` gives, for each filter, wrap, origin and pair of sizes, with mips that both
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
                let mut set = [None; TEXTURES];
                [set[BASE_COLOR], set[NORMAL]] = slots.each_ref().map(Some);
                let (packed, general) = (TextureSet::new(set), TextureSet::unpacked(set));
                shared += u32::from(packed.shares_mips());
                let mut scratch = SetScratch::default();
                let (mut words, mut floats) = (Vec::new(), Vec::new());
                for batch in list.chunks(BATCH_PIXELS / LANES) {
                    packed.fetch(level, &planes, &blocks, batch, &mut scratch, &mut words);
                    general.fetch(level, &planes, &blocks, batch, &mut scratch, &mut floats);
                    for number in [BASE_COLOR, NORMAL] {
                        let (words, floats): (&PackedTexels, &PackedTexels) =
                            (&words[number], &floats[number]);
                        assert!(words.is_packed() && !floats.is_packed());
                        for (k, at) in batch.iter().enumerate() {
                            for bit in set_bits(at.mask) {
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

/// The packed words of a projector are its texels. Blocks that it does not reach have none, and pixels do not depend on each other.
#[test]
fn packed_words_of_projectors_are_their_texels() {
    let level = Level::new();
    let textures = [noise(32, 32), bordered(32, 32, 1)];
    let projector = Projector::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.2, 1.0).unwrap();
    // Steps of a fraction of a texel up to several.
    let step = |k: f32| core::array::from_fn(|i| k * (1 + i % 29) as f32);
    let axis = |value: [f32; BATCH_STRIDE], right: f32, down: f32| Varying {
        value,
        ddx: step(right),
        ddy: step(down),
    };
    let position = [
        axis(
            core::array::from_fn(|i| (i % 37) as f32 * 0.09 - 0.6),
            0.003,
            0.004,
        ),
        axis(
            core::array::from_fn(|i| (i % 23) as f32 * 0.13 - 1.4),
            -0.001,
            0.003,
        ),
        // The first lie behind the projector.
        axis(
            core::array::from_fn(|i| match i {
                0..32 => 2.0,
                _ => -1.0 - (i % 5) as f32 * 0.3,
            }),
            0.004,
            -0.001,
        ),
    ];
    // The last reaches no further than its picture, which is then read as if it were repeated.
    let borders = [
        (0, ProjectorBorder::Black, 0.2),
        (0, ProjectorBorder::Clamp, 0.0),
        (1, ProjectorBorder::Clamp, 0.0),
    ];
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
        for (texture, border, softness) in borders {
            let sampler = sampler(filter, Wrap::Repeat);
            let view = BoundProjectorTexture::new(&ProjectorTexture {
                projector,
                texture: &textures[texture],
                sampler: &sampler,
                border,
                softness,
            });
            let projected = Projected {
                view,
                position: [0.0; 3],
                shadow: None,
            };
            let packed = ProjectorStage::new(&projected);
            let general = ProjectorStage::new(&projected).unpacked();
            let (mut words, mut floats) = <(ProjectorTexels, ProjectorTexels)>::default();
            let count = BATCH_PIXELS / LANES;
            packed.fetch(level, &position, count, &mut words);
            general.fetch(level, &position, count, &mut floats);
            let mut reached = 0;
            for block in 0..count {
                reached += usize::from(words.reaches(block));
                for pixel in 0..LANES {
                    let [a, b] = [&words, &floats].map(|texels| {
                        let color = texels.load(Scalar, block, pixel)?;
                        Some(color.map(f32::to_bits))
                    });
                    assert_eq!(a, b, "{filter:?} {border:?} {block}");
                    let at = block * LANES + pixel;
                    let of = |pick: fn(&Varying) -> &[f32; BATCH_STRIDE]| {
                        position.each_ref().map(|column| pick(column)[at])
                    };
                    let changes = [of(|c| &c.ddx), of(|c| &c.ddy)];
                    let alone = projected.view.light(of(|c| &c.value), changes);
                    let [r, g, b, _] = b.map_or([0.0; 4], |c| c.map(f32::from_bits));
                    assert_eq!([r, g, b], [alone[0], alone[1], alone[2]]);
                }
            }
            assert!(reached > 4 && reached < count, "{reached}");
        }
    }
}
