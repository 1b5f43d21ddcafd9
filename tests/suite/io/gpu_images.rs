//! DDS and KTX2: images for GPUs, against another decoder.

use std::fs;
use std::path::Path;

use dds::header::Header;
use dds::{ColorFormat, Encoder, Format, ImageView, Size};
use texmap_io::image_io::{Depth, read_image, read_texture};
use texmap_io::{Compression, CompressionQuality, LoadOptions, compress, load};
use texmap_sample::{BlockFormat, ColorSpace, Origin, Texture2d};

/// Bytes of no pattern.
fn noise(count: usize, seed: u32) -> Vec<u8> {
    let mut word = seed | 1;
    let next = std::iter::repeat_with(|| {
        word ^= word << 13;
        word ^= word >> 17;
        word ^= word << 5;
        (word >> 11) as u8
    });
    next.take(count).collect()
}

/// A DDS file of random blocks with `levels` levels; every mode of BC7 is there.
fn dds_file(format: Format, held: BlockFormat, size: (u32, u32), levels: u32) -> Vec<u8> {
    let header = Header::new_image(size.0, size.1, format).with_mipmap_count(levels);
    let mut file = Vec::new();
    header.write(&mut file).unwrap();
    let count: usize = (0..levels)
        .map(|k| held.level_bytes((size.0 >> k).max(1), (size.1 >> k).max(1)))
        .sum();
    let mut blocks = noise(count, 77);
    if held == BlockFormat::Bc7 {
        for (k, block) in blocks.chunks_exact_mut(16).enumerate() {
            block[0] = (block[0] | 1) << (k % 8);
        }
    }
    file.extend(blocks);
    file
}

const BLOCKS: [(Format, BlockFormat); 6] = [
    (Format::BC1_UNORM, BlockFormat::Bc1),
    (Format::BC2_UNORM, BlockFormat::Bc2),
    (Format::BC3_UNORM, BlockFormat::Bc3),
    (Format::BC4_UNORM, BlockFormat::Bc4),
    (Format::BC5_UNORM, BlockFormat::Bc5),
    (Format::BC7_UNORM, BlockFormat::Bc7),
];

/// The texels of another decoder: those of BC7 to the bit, of the others within a code, as decoders round differently.
#[test]
fn blocks_have_the_texels_of_another_decoder() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.dds");
    let (width, height) = (61, 34);
    for (format, held) in BLOCKS {
        let file = dds_file(format, held, (width, height), 1);
        fs::write(&path, &file).unwrap();
        let image = read_image(&path).unwrap();
        let got: Vec<f64> = match &image.texels {
            Depth::U8(t) => t.iter().map(|c| f64::from(*c)).collect(),
            Depth::U16(t) => t.iter().map(|c| f64::from(*c) / 257.0).collect(),
            Depth::F32(_) => panic!("{held:?} is not made of floats"),
        };
        let blocks = &file[file.len() - held.level_bytes(width, height)..];
        let allowed = if held == BlockFormat::Bc7 { 0.0 } else { 1.0 };
        for (k, block) in blocks.chunks_exact(held.block_bytes()).enumerate() {
            let (left, top) = (
                4 * (k as u32 % width.div_ceil(4)),
                4 * (k as u32 / width.div_ceil(4)),
            );
            let (texels, channels) = decoded(held, block);
            for (t, texel) in texels.chunks_exact(channels).enumerate() {
                let (x, y) = (left + t as u32 % 4, top + t as u32 / 4);
                if x >= width || y >= height {
                    continue;
                }
                for (c, other) in texel.iter().enumerate() {
                    let here = got[4 * (y * width + x) as usize + c];
                    let apart = (here - f64::from(*other)).abs();
                    assert!(
                        apart <= allowed,
                        "{held:?} ({x}, {y}) {c}: {here} and {other}"
                    );
                }
            }
        }
    }
}

/// The 16 texels of a block by `bcdec`, and their channels.
fn decoded(format: BlockFormat, block: &[u8]) -> (Vec<u8>, usize) {
    let channels = match format {
        BlockFormat::Bc4 => 1,
        BlockFormat::Bc5 => 2,
        _ => 4,
    };
    let mut texels = vec![0; 16 * channels];
    let pitch = 4 * channels;
    match format {
        BlockFormat::Bc1 => bcdec_rs::bc1(block, &mut texels, pitch),
        BlockFormat::Bc2 => bcdec_rs::bc2(block, &mut texels, pitch),
        BlockFormat::Bc3 => bcdec_rs::bc3(block, &mut texels, pitch),
        BlockFormat::Bc4 => bcdec_rs::bc4(block, &mut texels, pitch, false),
        BlockFormat::Bc5 => bcdec_rs::bc5(block, &mut texels, pitch, false),
        _ => bcdec_rs::bc7(block, &mut texels, pitch),
    }
    (texels, channels)
}

/// A scene keeps blocks, with the levels of the file; a file of one level gets a chain of its own.
#[test]
fn scenes_sample_blocks_with_the_levels_of_their_file() {
    let dir = tempfile::tempdir().unwrap();
    let scene = dir.path().join("a.scene");
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ntexture a.dds\ntf 0 0 0 1 1 0 2 1 1 3 0 1\n";
    fs::write(&scene, text).unwrap();
    for (levels, ascending) in [(6, false), (1, true)] {
        let (format, held) = BLOCKS[5];
        fs::write(
            dir.path().join("a.dds"),
            dds_file(format, held, (32, 20), levels),
        )
        .unwrap();
        let scene = load(&scene, &LoadOptions::default()).unwrap();
        let texture = &scene.textures[0];
        assert_eq!(texture.block_format(), Some(held));
        assert_eq!(texture.levels(), 6);
        let made = read_texture(&dir.path().join("a.dds"), ColorSpace::Srgb)
            .unwrap()
            .0
            .with_mips();
        assert_eq!(texture.texel(3, 1, 1) == made.texel(3, 1, 1), ascending);
    }
}

/// The parts of a KTX2 file of one surface, largest level first.
fn ktx2_file(format: u32, size: (u32, u32), scheme: u32, levels: &[(Vec<u8>, u64)]) -> Vec<u8> {
    let mut file = vec![
        0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, 13, 10, 26, 10,
    ];
    let index = 80 + 24 * levels.len() as u32;
    let head = [
        format,
        1,
        size.0,
        size.1,
        0,
        0,
        1,
        levels.len() as u32,
        scheme,
    ];
    let sections = [index, 44, 0, 0, 0, 0, 0, 0];
    file.extend(head.iter().chain(&sections).flat_map(|w| w.to_le_bytes()));
    let mut at = u64::from(index) + 44;
    for (bytes, whole) in levels {
        file.extend(
            [at, bytes.len() as u64, *whole]
                .iter()
                .flat_map(|w| w.to_le_bytes()),
        );
        at += bytes.len() as u64;
    }
    // A basic descriptor of one sample; nothing in it matters here.
    let mut descriptor = [
        44_u32,
        0,
        2 | 40 << 16,
        134 | 1 << 8 | 2 << 16,
        0x0303,
        16,
        0,
        127 << 16,
        0,
        0,
        u32::MAX,
    ];
    descriptor[4] = 3 | 3 << 8;
    file.extend(descriptor.iter().flat_map(|w| w.to_le_bytes()));
    levels.iter().for_each(|(bytes, _)| file.extend(bytes));
    file.push(0);
    file
}

/// A Zstandard frame of one block that is not compressed.
fn zstd_frame(bytes: &[u8]) -> Vec<u8> {
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0xA0];
    frame.extend((bytes.len() as u32).to_le_bytes());
    frame.extend(&((bytes.len() as u32) << 3 | 1).to_le_bytes()[..3]);
    frame.extend(bytes);
    frame
}

const VK_R8G8B8A8_SRGB: u32 = 43;
const VK_BC7_SRGB: u32 = 146;
const VK_ASTC_4X4: u32 = 157;

#[test]
fn ktx2_has_the_texels_of_dds_with_and_without_zstandard() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let size = (20, 12);
    let whole = dds_file(Format::BC7_UNORM, BlockFormat::Bc7, size, 3);
    fs::write(at("a.dds"), &whole).unwrap();
    let mut data = &whole[whole.len() - (15 + 6 + 2) * 16..];
    let mut levels = Vec::new();
    for blocks in [15, 6, 2] {
        let (level, rest) = data.split_at(16 * blocks);
        levels.push((level.to_vec(), level.len() as u64));
        data = rest;
    }
    fs::write(at("plain.ktx2"), ktx2_file(VK_BC7_SRGB, size, 0, &levels)).unwrap();
    let framed: Vec<_> = levels.iter().map(|(l, n)| (zstd_frame(l), *n)).collect();
    fs::write(at("zstd.ktx2"), ktx2_file(VK_BC7_SRGB, size, 2, &framed)).unwrap();
    let dds = read_texture(&at("a.dds"), ColorSpace::Srgb).unwrap().0;
    for name in ["plain.ktx2", "zstd.ktx2"] {
        let ktx2 = read_texture(&at(name), ColorSpace::Srgb).unwrap().0;
        assert_eq!(
            (ktx2.levels(), ktx2.block_format()),
            (3, dds.block_format())
        );
        for (level, x, y) in [(0, 19, 11), (0, 7, 3), (1, 9, 5), (2, 4, 2)] {
            assert_eq!(ktx2.texel(level, x, y), dds.texel(level, x, y), "{name}");
        }
        assert_eq!(
            read_image(&at(name)).unwrap(),
            read_image(&at("a.dds")).unwrap()
        );
    }
    let refused = |bytes: &[u8]| {
        fs::write(at("b.ktx2"), bytes).unwrap();
        let error = read_image(&at("b.ktx2")).unwrap_err();
        assert_eq!(error.code(), "broken-image");
        error.to_string()
    };
    let basis = ktx2_file(0, size, 0, &levels);
    assert!(refused(&basis).contains("Basis Universal"));
    let astc = ktx2_file(VK_ASTC_4X4, size, 0, &levels);
    assert!(refused(&astc).contains("ASTC"), "{}", refused(&astc));
    let mut cube = ktx2_file(VK_BC7_SRGB, size, 0, &levels);
    cube[36] = 6;
    assert!(refused(&cube).contains("six faces of a cube"));
    let short = [(vec![0; 64], 64)];
    assert!(refused(&ktx2_file(VK_BC7_SRGB, size, 0, &short)).contains("64 bytes, 240 are needed"));
}

#[test]
fn uncompressed_texels_are_those_that_were_written() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let texels = noise(4 * 15, 5);
    let header = Header::new_image(5, 3, Format::B8G8R8A8_UNORM);
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, Format::B8G8R8A8_UNORM, &header).unwrap();
    let view = ImageView::new(&texels, Size::new(5, 3), ColorFormat::RGBA_U8).unwrap();
    encoder.write_surface(view).unwrap();
    encoder.finish().unwrap();
    fs::write(at("a.dds"), &file).unwrap();
    let level = (texels.clone(), 60);
    fs::write(
        at("a.ktx2"),
        ktx2_file(VK_R8G8B8A8_SRGB, (5, 3), 0, &[level]),
    )
    .unwrap();
    for name in ["a.dds", "a.ktx2"] {
        assert_eq!(
            read_image(&at(name)).unwrap().texels,
            Depth::U8(texels.clone()),
            "{name}"
        );
    }
}

/// Cut anywhere, a file is an error that names it, and never a panic.
#[test]
fn every_truncation_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.bin");
    let size = (8, 8);
    let level = (noise(64, 9), 64);
    let dds = dds_file(Format::BC7_UNORM, BlockFormat::Bc7, size, 4);
    for whole in [dds, ktx2_file(VK_BC7_SRGB, size, 0, &[level])] {
        fs::write(&path, &whole).unwrap();
        read_image(&path).unwrap();
        for cut in 0..whole.len() - 1 {
            fs::write(&path, &whole[..cut]).unwrap();
            let error = read_image(&path).unwrap_err();
            assert!(
                ["broken-image", "image-size"].contains(&error.code()),
                "cut at {cut}: {error}"
            );
        }
        // Any byte of the head spoilt: an error or another picture.
        for at in 0..whole.len().min(200) {
            let mut spoilt = whole.clone();
            spoilt[at] ^= 0xff;
            fs::write(&path, &spoilt).unwrap();
            let _ = read_image(&path);
        }
    }
}

fn compressed(texture: &Texture2d<'_>, format: BlockFormat, path: &Path) -> Texture2d<'static> {
    let compression = Compression {
        format,
        quality: CompressionQuality::Fast,
        color: ColorSpace::Linear,
    };
    let mut file = Vec::new();
    compress(texture, &compression, &mut file).unwrap();
    fs::write(path, file).unwrap();
    read_texture(path, ColorSpace::Linear).unwrap().0
}

/// Files of the encoder are read: a ramp comes back within the steps of its format, which are coarser for BC1 than for BC7.
#[test]
fn compressed_ramps_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.dds");
    let texels = (0..64 * 64).flat_map(|i| {
        let (x, y) = (i % 64, i / 64);
        [(x * 4) as u8, (y * 3 + 20) as u8, ((x + y) * 2) as u8, 255]
    });
    let ramp = Texture2d::from_rgba8(
        64,
        64,
        texels.collect(),
        ColorSpace::Linear,
        Origin::TopLeft,
    );
    let ramp = ramp.unwrap().with_mips();
    let mut errors = Vec::new();
    for format in [
        BlockFormat::Bc1,
        BlockFormat::Bc3,
        BlockFormat::Bc4,
        BlockFormat::Bc7,
    ] {
        let back = compressed(&ramp, format, &path);
        assert_eq!((back.levels(), back.block_format()), (7, Some(format)));
        let channels = if format == BlockFormat::Bc4 { 1 } else { 3 };
        let mut sum = 0.0;
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let [a, b] = [&ramp, &back].map(|t| t.texel(0, x, y).unwrap());
            sum += (0..channels)
                .map(|k| f64::from(a[k] - b[k]).powi(2))
                .sum::<f64>();
        }
        errors.push((sum / (64.0 * 64.0 * channels as f64)).sqrt() * 255.0);
    }
    let [bc1, bc3, bc4, bc7] = errors[..] else {
        panic!("four formats")
    };
    // A block spans 12 codes of red, 9 of green and 6 of both in blue: more than two ends of 5 bits hold.
    assert!(bc1 < 6.0 && bc3 < 6.0, "{bc1} {bc3}");
    // Eight values over twelve codes: steps of 12 / 7, a quarter of one in the mean.
    assert!(bc4 < 12.0 / 7.0 / 2.0, "{bc4}");
    assert!(bc7 < 0.7 * bc1, "{bc7} {bc1}");
}
