//! Textures that are sampled from compressed blocks.

use crate::support::{Random, SIZES, filters};
use texmap_math::{Footprint, Level};
use texmap_sample::{
    Alpha, BlockFormat, BlockImage, ColorSpace, Filter, Image, Origin, SampleError, Sampler,
    TexelData, Texture2d, Wrap, reference, sample_slice,
};
use texmap_tests::levels::levels;

/// Random blocks. The first bits of every eighth block of BC7 ask for another mode, and ends of BC1 and BC4 are often equal.
fn blocks(format: BlockFormat, count: usize, seed: u64) -> Vec<u8> {
    let mut random = Random::new(seed);
    let n = format.block_bytes();
    let mut bytes: Vec<u8> = (0..count * n).map(|_| random.word() as u8).collect();
    for (k, block) in bytes.chunks_exact_mut(n).enumerate() {
        match format {
            BlockFormat::Bc7 if k % 9 < 8 => {
                block[0] = (block[0] | 1) << (k % 9);
            }
            BlockFormat::Bc7 => block[0] = 0,
            BlockFormat::Bc3 | BlockFormat::Bc4 | BlockFormat::Bc5 if k % 5 == 0 => {
                block[1] = block[0];
            }
            BlockFormat::Bc1 | BlockFormat::Bc1Opaque if k % 5 == 0 => {
                (block[2], block[3]) = (block[0], block[1]);
            }
            _ => {}
        }
    }
    bytes
}

fn texture(
    format: BlockFormat,
    (width, height): (u32, u32),
    blocks: &[u8],
    (color, alpha): (ColorSpace, Alpha),
) -> Texture2d<'static> {
    Texture2d::from_blocks(&BlockImage {
        width,
        height,
        format,
        levels: &[blocks],
        color,
        alpha,
        origin: Origin::TopLeft,
    })
    .expect("good blocks")
}

/// The texel of a picture of blocks by the f64 decoder.
fn truth(format: BlockFormat, width: u32, blocks: &[u8], x: u32, y: u32) -> [f64; 4] {
    let n = format.block_bytes();
    let k = (y / 4 * width.div_ceil(4) + x / 4) as usize;
    reference::block_texel(
        format,
        &blocks[k * n..(k + 1) * n],
        x as usize % 4,
        y as usize % 4,
    )
    .expect("a texel of a block")
}

/// Values of texels are those of the formats' definitions: BC7 to the bit, BC1 to BC3 within half a code, BC4 and BC5, of which 16 bits are kept,
/// within half of 1/257 of one.
#[test]
fn texels_are_those_of_the_definition() {
    const SIDE: u32 = 180;
    for format in BlockFormat::ALL {
        let blocks = blocks(format, 45 * 45, 7);
        let data = (ColorSpace::Linear, Alpha::Data);
        let t = texture(format, (SIDE, SIDE), &blocks, data);
        let allowed = match format {
            BlockFormat::Bc7 => 0.0,
            BlockFormat::Bc4 | BlockFormat::Bc5 => 0.5 / 257.0,
            _ => 0.5,
        };
        let mut largest = 0.0_f64;
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let got = t.texel(0, x, y).unwrap();
            let want = truth(format, SIDE, &blocks, x, y);
            for (k, (got, want)) in got.iter().zip(want).enumerate() {
                if format == BlockFormat::Bc5 && k == 2 {
                    continue;
                }
                // Unscaled channels are whole: the scale is taken back exactly.
                let code = (f64::from(*got) * 65535.0).round() / 257.0;
                largest = largest.max((code - want).abs());
            }
        }
        assert!(
            largest <= allowed + 1e-9,
            "{format:?}: {largest} of a code, {allowed} are allowed"
        );
    }
}

/// The mutant that expands 5 bits by repeating them and cuts off thirds is farther away than half a code.
#[test]
fn integer_thirds_are_farther_away() {
    let block = [0xe8, 0xa9, 0x41, 0x10, 0xaa, 0xaa, 0xaa, 0xaa];
    let want = reference::block_texel(BlockFormat::Bc1, &block, 0, 0).unwrap()[2];
    let repeat = |c: u32| c << 3 | c >> 2;
    let cut = f64::from((2 * repeat(8) + repeat(1)) / 3);
    assert!((cut - want).abs() > 0.5, "{cut} {want}");
    let t = texture(
        BlockFormat::Bc1,
        (4, 4),
        &block,
        (ColorSpace::Linear, Alpha::Data),
    );
    let code = f64::from(t.texel(0, 0, 0).unwrap()[2]) * 255.0;
    assert!((code - want).abs() <= 0.5, "{code} {want}");
}

/// The third channel of BC5 makes a unit vector, or 0 where x and y are too long for one.
#[test]
fn normals_of_two_channels_have_length_one() {
    let blocks = blocks(BlockFormat::Bc5, 16 * 16, 3);
    let data = (ColorSpace::Linear, Alpha::Data);
    let t = texture(BlockFormat::Bc5, (64, 64), &blocks, data);
    let mut inside = 0;
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let [x, y, z, a] = t.texel(0, x, y).unwrap().map(f64::from);
        let [x, y, z] = [x, y, z].map(|c| 2.0 * c - 1.0);
        let z2 = 1.0 - x * x - y * y;
        let want = z2.max(0.0).sqrt();
        // Half a step of 16 bits over (z + 1) / 2.
        assert!((z - want).abs() < 1.01 / 65535.0 + 1e-6, "{z} {want}");
        assert_eq!(a, 1.0);
        inside += u32::from(z2 > 0.0);
    }
    assert!(inside > 1000, "{inside}");
}

/// The same texels uncompressed, at 16 bits.
fn unpacked(
    format: BlockFormat,
    (width, height): (u32, u32),
    blocks: &[u8],
    color: ColorSpace,
) -> Texture2d<'static> {
    let data = texture(
        format,
        (width, height),
        blocks,
        (ColorSpace::Linear, Alpha::Data),
    );
    let codes: Vec<u16> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .flat_map(|(x, y)| data.texel(0, x, y).unwrap())
        .map(|c| (c * 65535.0).round() as u16)
        .collect();
    let bytes: Vec<u8> = codes.iter().map(|c| (c / 257) as u8).collect();
    Texture2d::new(&Image {
        width,
        height,
        channels: 4,
        texels: match color {
            ColorSpace::Srgb => TexelData::U8(&bytes),
            ColorSpace::Linear => TexelData::U16(&codes),
        },
        color,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
    .expect("a good image")
}

/// Look-ups in blocks have the bits of look-ups in their texels: every filter, wrap and size, with and without mips, on every SIMD level.
#[test]
fn every_look_up_has_the_bits_of_the_unpacked_picture() {
    let all = SIZES
        .iter()
        .cycle()
        .zip(filters())
        .zip(BlockFormat::ALL.iter().cycle());
    let wraps = [
        Wrap::Repeat,
        Wrap::MirroredRepeat,
        Wrap::ClampToEdge,
        Wrap::ClampToBorder,
    ];
    for (k, ((size, filter), format)) in all.enumerate().flat_map(|(k, c)| [(k, c), (k + 1, c)]) {
        let color = match format {
            // No sRGB, or codes of 16 bits.
            BlockFormat::Bc4 | BlockFormat::Bc5 => ColorSpace::Linear,
            _ if k % 3 == 0 => ColorSpace::Linear,
            _ => ColorSpace::Srgb,
        };
        let count = (size.0.div_ceil(4) * size.1.div_ceil(4)) as usize;
        let blocks = blocks(*format, count, k as u64);
        let origin = if k % 2 == 0 {
            Origin::TopLeft
        } else {
            Origin::BottomLeft
        };
        let both = [
            texture(*format, *size, &blocks, (color, Alpha::Straight)),
            unpacked(*format, *size, &blocks, color),
        ];
        let both = both.map(|t| t.with_origin(origin));
        let both = if k % 4 == 0 {
            both
        } else {
            both.map(Texture2d::with_mips)
        };
        assert_eq!(
            both[0].has_alpha(),
            both[1].has_alpha(),
            "{format:?} {size:?}"
        );
        let sampler = Sampler {
            filter,
            wrap_u: wraps[k % 4],
            wrap_v: wraps[(k + 1) % 4],
            ..Sampler::default()
        };
        let mut random = Random::new(k as u64);
        let u: Vec<f32> = (0..75).map(|_| random.range(-1.5, 2.5)).collect();
        let v: Vec<f32> = (0..75).map(|_| random.range(-1.5, 2.5)).collect();
        let grads: Vec<Footprint> = (0..75)
            .map(|_| {
                let mut d = || random.range(-1.0, 1.0) * random.unit() * random.unit();
                Footprint::new(d(), d(), d(), d())
            })
            .collect();
        let look = |level: Level, t: &Texture2d<'_>| {
            let mut out = vec![[0.0; 4]; u.len()];
            sample_slice(level, &sampler, t, &u, &v, Some(&grads), &mut out).unwrap();
            out.into_iter()
                .map(|c| c.map(f32::to_bits))
                .collect::<Vec<_>>()
        };
        let want = look(Level::fallback(), &both[1]);
        for (name, level) in levels() {
            let got = look(level, &both[0]);
            assert_eq!(got, want, "{format:?} {size:?} {filter:?} {color:?} {name}");
        }
        let one = sampler.sample_grad(&both[0], [u[3], v[3]], grads[3]);
        assert_eq!(one.map(f32::to_bits), want[3]);
    }
}

/// Levels of a file are those that are sampled, not means of level 0.
#[test]
fn levels_of_a_file_are_kept() {
    let format = BlockFormat::Bc7;
    let sizes = [(20_u32, 9_u32), (10, 4), (5, 2), (2, 1), (1, 1)];
    let levels: Vec<Vec<u8>> = (0..)
        .zip(sizes)
        .map(|(k, (w, h))| blocks(format, (w.div_ceil(4) * h.div_ceil(4)) as usize, k))
        .collect();
    let slices: Vec<&[u8]> = levels.iter().map(Vec::as_slice).collect();
    let t = Texture2d::from_blocks(&BlockImage {
        width: 20,
        height: 9,
        format,
        levels: &slices,
        color: ColorSpace::Srgb,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
    .unwrap();
    assert_eq!((t.levels(), t.block_format()), (5, Some(format)));
    let trilinear = Sampler {
        filter: Filter::Trilinear,
        wrap_u: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    for ((k, size), bytes) in (0..).zip(sizes).zip(&levels) {
        let alone = texture(format, size, bytes, (ColorSpace::Srgb, Alpha::Straight));
        let bilinear = Sampler {
            filter: Filter::Bilinear,
            ..trilinear
        };
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            assert_eq!(t.texel(k, x, y), alone.texel(0, x, y), "{k} {x} {y}");
        }
        let uv = [0.37, 0.61];
        assert_eq!(
            trilinear.sample_lod(&t, uv, k as f32),
            bilinear.sample(&alone, uv)
        );
    }
    // A new chain replaces the levels of the file.
    let remade = t.clone().with_mips();
    let alone = texture(
        format,
        sizes[0],
        &levels[0],
        (ColorSpace::Srgb, Alpha::Straight),
    )
    .with_mips();
    assert_eq!(remade.texel(2, 1, 1), alone.texel(2, 1, 1));
    assert_ne!(remade.texel(2, 1, 1), t.texel(2, 1, 1));
    let cut_out = t.with_coverage_mips(0.5);
    assert_eq!((cut_out.levels(), cut_out.block_format()), (5, None));
    assert_eq!(cut_out.texel(0, 19, 8), alone.texel(0, 19, 8));
}

#[test]
fn wrong_lengths_and_levels_are_errors() {
    let image = |size: (u32, u32), levels: &[&[u8]]| {
        Texture2d::from_blocks(&BlockImage {
            width: size.0,
            height: size.1,
            format: BlockFormat::Bc1,
            levels,
            color: ColorSpace::Srgb,
            alpha: Alpha::Straight,
            origin: Origin::TopLeft,
        })
        .map(|t| t.levels())
    };
    let block: &[u8] = &[0; 8];
    assert_eq!(image((3, 4), &[block]), Ok(1));
    assert_eq!(
        image((5, 4), &[block]),
        Err(SampleError::Length {
            expected: 16,
            got: 8
        })
    );
    assert_eq!(
        image((4, 4), &[block, &block[..7]]),
        Err(SampleError::Length {
            expected: 8,
            got: 7
        })
    );
    assert_eq!(
        image((4, 4), &[]),
        Err(SampleError::Levels { levels: 0, most: 3 })
    );
    let five = image((4, 4), &[block; 4]).unwrap_err();
    assert_eq!(
        five.to_string(),
        "4 mip levels: an image of this size has 1 to 3"
    );
    assert_eq!(
        image((0, 4), &[block]),
        Err(SampleError::Size {
            width: 0,
            height: 4
        })
    );
}
