//! Pictures of every kind that is read, and the decoding of many at once.

use std::io::Cursor;

use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use texmap_io::{FileSource, LoadOptions, image_io, load};
use texmap_math::MemoryBudget;

use crate::support::Files;

/// 3 x 2 texels, all different.
fn picture() -> RgbImage {
    RgbImage::from_fn(3, 2, |x, y| Rgb([100 * x as u8, 200 * y as u8, 30]))
}

fn encoded(format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let image = DynamicImage::from(picture());
    image.write_to(&mut file, format).expect("a picture");
    file.into_inner()
}

const LOSSLESS: [(&str, ImageFormat); 6] = [
    ("a.png", ImageFormat::Png),
    ("a.webp", ImageFormat::WebP),
    ("a.bmp", ImageFormat::Bmp),
    ("a.tga", ImageFormat::Tga),
    ("a.tiff", ImageFormat::Tiff),
    ("a.qoi", ImageFormat::Qoi),
];

#[test]
fn every_format_gives_the_same_texels() {
    let expected = DynamicImage::from(picture()).into_rgba8().into_raw();
    for (name, format) in LOSSLESS {
        let files = Files::new().with(name, encoded(format));
        let image = image_io::read_image(&files.path(name)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((image.width, image.height), (3, 2), "{name}");
        assert_eq!(
            image.texels,
            image_io::Depth::U8(expected.clone()),
            "{name}"
        );
        let info = texmap_io::info(&files.path(name)).unwrap();
        assert_eq!(
            (info.kind, info.files[0].size),
            ("image", Some([3, 2])),
            "{name}"
        );
        let ending = name.rsplit('.').next().unwrap();
        assert!(image_io::ENDINGS.contains(&ending), "{name}");
        // Cut off, it is an error.
        let whole = encoded(format);
        for cut in [0, 1, 10, whole.len() / 2] {
            let files = Files::new().with(name, &whole[..cut]);
            let error = image_io::read_image(&files.path(name)).expect_err(name);
            assert!(
                matches!(error.code(), "broken-image" | "image-size"),
                "{name} {cut}: {error}"
            );
        }
    }
}

/// A JPEG whose Exif orientation is this.
fn turned(orientation: u8) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let image = RgbImage::from_fn(16, 8, |x, _| {
        if x < 8 {
            Rgb([255, 0, 0])
        } else {
            Rgb([0, 0, 255])
        }
    });
    DynamicImage::from(image)
        .write_to(&mut file, ImageFormat::Jpeg)
        .unwrap();
    let jpeg = file.into_inner();
    let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    let mut out = jpeg[..2].to_vec();
    out.extend([0xff, 0xe1]);
    out.extend((exif.len() as u16 + 2).to_be_bytes());
    out.extend(exif);
    out.extend(&jpeg[2..]);
    out
}

#[test]
fn jpegs_are_turned_as_their_exif_says() {
    for (orientation, size, first_red) in [
        (1, (16, 8), true),
        (2, (16, 8), false),
        (3, (16, 8), false),
        (6, (8, 16), true),
        (8, (8, 16), false),
    ] {
        let files = Files::new().with("a.jpg", turned(orientation));
        let image = image_io::read_image(&files.path("a.jpg")).unwrap();
        assert_eq!((image.width, image.height), size, "{orientation}");
        let image_io::Depth::U8(texels) = image.texels else {
            panic!("8 bits")
        };
        assert_eq!(
            texels[0] > 200,
            first_red,
            "{orientation}: {:?}",
            &texels[..4]
        );
    }
}

/// Sides that no texture may have are refused by what the head says.
#[test]
fn stated_sizes_are_held_against_the_limits() {
    let mut qoi = encoded(ImageFormat::Qoi);
    qoi[4..8].copy_from_slice(&100_000_u32.to_be_bytes());
    let mut bmp = encoded(ImageFormat::Bmp);
    bmp[18..22].copy_from_slice(&60_000_i32.to_le_bytes());
    let mut tga = encoded(ImageFormat::Tga);
    tga[12..14].copy_from_slice(&60_000_u16.to_le_bytes());
    for (name, bytes) in [("a.qoi", qoi), ("a.bmp", bmp), ("a.tga", tga)] {
        let files = Files::new().with(name, bytes);
        let error = image_io::read_image(&files.path(name)).expect_err(name);
        assert_eq!(error.code(), "image-size", "{error}");
    }
}

/// Maps that are decoded at once come in the order of their lines, and so does the first fault, whatever the memory allows.
#[test]
fn many_maps_are_what_they_are_alone() {
    let mtl: String = (0..6)
        .map(|i| {
            format!(
                "newmtl m{i}\nmap_Kd {i}.png\nmap_Bump {}.png\n",
                (i + 1) % 6
            )
        })
        .collect();
    let obj: String = (0..6).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let obj = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{obj}");
    let files = (0..6).fold(
        Files::new().with("a.mtl", mtl).with("a.obj", obj),
        |files, i| files.with_png(&format!("{i}.png"), i + 1, 2, [50; 4]),
    );
    let options = |memory| LoadOptions {
        files: FileSource::anywhere().with_memory(memory),
        ..LoadOptions::default()
    };
    let widths = |memory| {
        let scene = load(&files.path("a.obj"), &options(memory)).unwrap();
        let widths: Vec<u32> = scene.textures.iter().map(|t| t.width()).collect();
        widths
    };
    let expected = [1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 1];
    assert_eq!(widths(MemoryBudget::UNLIMITED), expected);
    assert_eq!(widths(MemoryBudget::new(20 << 20)), expected);
    std::fs::write(files.path("4.png"), "no picture").unwrap();
    std::fs::remove_file(files.path("2.png")).unwrap();
    let error = files.load("a.obj").unwrap_err();
    assert_eq!(error.code(), "file-missing", "{error}");
    assert_eq!(error.location().map(|p| p.line), Some(6));
}
