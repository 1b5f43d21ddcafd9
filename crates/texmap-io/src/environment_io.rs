//! Environments in and out: PNG and JPEG (sRGB), Radiance HDR and OpenEXR (linear light). Layouts of several faces stand below each
//! other: +X -X +Y -Y +Z -Z of a cube, +Z -Z of the paraboloids.

use std::io;
use std::path::Path;

use image::{DynamicImage, Rgb};
use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::color;
use texmap_sample::ColorSpace;

use crate::files::FileSource;
use crate::picture_format::{Lost, PictureFormat, PixelCode, write_pixels};
use crate::{IoError, SourceLocation, image_io};

/// Reads an image as an environment. Whole numbers (PNG, JPEG and the like) are sRGB, floats (HDR, EXR) linear light, also below 0;
/// alpha is not read.
///
/// # Errors
/// File errors; [`IoError::BrokenImage`], also for a NaN or infinity; [`IoError::EnvironmentSize`] for an image whose sides the
/// layout cannot have (a lat-long map that is not 2:1).
pub fn read_environment(path: &Path, chart: EnvironmentLayout) -> Result<Environment, IoError> {
    read_named(&FileSource::anywhere(), path, chart, None)
}

pub(crate) fn read_named(
    files: &FileSource,
    path: &Path,
    chart: EnvironmentLayout,
    named_by: Option<&SourceLocation>,
) -> Result<Environment, IoError> {
    let fits = |(width, height): (u32, u32)| match face_height(chart, width, height) {
        Some(_) => Ok(()),
        None => Err(IoError::EnvironmentSize {
            path: path.to_path_buf(),
            named_by: named_by.cloned(),
            chart: chart.name(),
            width,
            height,
            expected: expected(chart),
        }),
    };
    let image = image_io::decode(files, path, named_by, &fits)?;
    let (width, height) = (image.width(), image.height());
    // Three floats, and the copies with borders and mips that an environment keeps.
    image_io::ask_for_texels(files, path, named_by, (width, height), 12 + 22)?;
    let texels: Vec<[f32; 3]> = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let image = image.into_rgb32f();
            image.pixels().map(|&Rgb(c)| c).collect()
        }
        _ if image.color().bytes_per_pixel() == image.color().channel_count() => {
            let image = image.into_rgb8();
            let texels = image.pixels();
            texels
                .map(|&Rgb(c)| c.map(color::srgb8_to_linear))
                .collect()
        }
        _ => {
            let curve: Vec<f32> = (0..=u16::MAX).map(color::srgb16_to_linear).collect();
            let image = image.into_rgb16();
            let light = |c: u16| curve[usize::from(c)];
            image.pixels().map(|&Rgb(c)| c.map(light)).collect()
        }
    };
    let face = height / chart.faces() as u32;
    Environment::from_texels(chart, (width, face), &texels).map_err(|e| IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        problem: e.to_string(),
    })
}

/// Rows of one face of an image of this size, if the layout can have it.
fn face_height(chart: EnvironmentLayout, width: u32, height: u32) -> Option<u32> {
    let faces = chart.faces() as u32;
    let face = height / faces;
    let fits =
        face > 0 && height.is_multiple_of(faces) && face.checked_mul(chart.aspect()) == Some(width);
    (fits && width <= Environment::MAX_SIDE).then_some(face)
}

fn expected(chart: EnvironmentLayout) -> String {
    let sides = match (chart.faces(), chart.aspect()) {
        (1, 1) => "as wide as high".to_owned(),
        (1, aspect) => format!("{aspect} times as wide as high"),
        (faces, _) => {
            format!("{faces} square faces below each other, so {faces} times as high as wide")
        }
    };
    format!("{sides}, at most {} texels wide", Environment::MAX_SIDE)
}

/// Writes an environment as PNG (sRGB of 8 bits, clipped to 0 to 1), HDR or EXR (linear light), as the name's ending says, whole or not
/// at all. Returns how many texels the format could not hold.
///
/// # Errors
/// [`IoError::UnknownFormat`] for other endings, [`IoError::Write`].
pub fn write_environment(path: &Path, environment: &Environment) -> Result<Lost, IoError> {
    let (width, face) = environment.size();
    let faces = environment.layout().faces();
    let height = face * faces as u32;
    let texels: Vec<[f32; 3]> = (0..faces)
        .flat_map(|f| (0..face).flat_map(move |y| (0..width).map(move |x| (f, x, y))))
        .filter_map(|(f, x, y)| environment.texel(f, x, y))
        .collect();
    write_light(path, width, height, &texels)
}

/// Writes linear light, rows top to bottom, as [`write_environment`] does: a light map, for one.
///
/// # Errors
/// As [`write_environment`]; [`IoError::Write`] also when `texels` does not hold `width * height` of them.
pub fn write_light(
    path: &Path,
    width: u32,
    height: u32,
    texels: &[[f32; 3]],
) -> Result<Lost, IoError> {
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        let problem = format!("{} texels for {width} x {height}", texels.len());
        return Err(IoError::Write {
            path: path.to_path_buf(),
            source: io::Error::new(io::ErrorKind::InvalidInput, problem),
        });
    }
    let code = match PictureFormat::of(path) {
        Some(PictureFormat::Png) => PixelCode::Png8(ColorSpace::Srgb),
        Some(PictureFormat::Jpeg) => PixelCode::Jpeg(ColorSpace::Srgb),
        Some(PictureFormat::WebP) => PixelCode::WebP(ColorSpace::Srgb),
        Some(PictureFormat::Hdr) => PixelCode::Hdr,
        Some(PictureFormat::Exr) => PixelCode::Exr,
        None => {
            return Err(IoError::UnknownFormat {
                path: path.to_path_buf(),
            });
        }
    };
    let mut lost = Lost::default();
    write_pixels(path, code, (width, height), |out| {
        let mut row = vec![0; code.bytes() * width as usize];
        texels.chunks(width.max(1) as usize).try_for_each(|texels| {
            let colors: Vec<[f32; 4]> = texels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
            lost += code.encode(&colors, &mut row);
            out.write_all(&row)
        })
    })?;
    Ok(lost)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(chart: EnvironmentLayout, size: u32) -> Environment {
        Environment::from_fn(chart, size, |d| {
            [0.5 + 0.5 * d.x, 0.5 + 0.4 * d.y, 3.0 + d.z].map(|c| c as f32)
        })
        .unwrap()
    }

    fn worst(a: &Environment, b: &Environment, scale: impl Fn(f32) -> f32) -> f32 {
        let (w, h) = a.size();
        let mut worst = 0.0f32;
        for face in 0..a.layout().faces() {
            for i in 0..w * h {
                let texel = |e: &Environment| e.texel(face, i % w, i / w).unwrap();
                for (a, b) in texel(a).into_iter().zip(texel(b)) {
                    worst = worst.max((a - b).abs() / scale(a));
                }
            }
        }
        worst
    }

    #[test]
    fn files_come_back_as_exactly_as_they_can() {
        let dir = tempfile::tempdir().unwrap();
        for (chart, size) in [
            (EnvironmentLayout::LatLong, 8),
            (EnvironmentLayout::Cube, 9),
            (EnvironmentLayout::DualParaboloid, 8),
        ] {
            let sky = sky(chart, size);
            let file = |ending: &str| dir.path().join(format!("a.{ending}"));
            assert!(write_environment(&file("exr"), &sky).unwrap().nothing());
            let back = read_environment(&file("exr"), chart).unwrap();
            assert_eq!(worst(&sky, &back, |_| 1.0), 0.0, "{chart:?}");
            write_environment(&file("hdr"), &sky).unwrap();
            let back = read_environment(&file("hdr"), chart).unwrap();
            // 8 bits of mantissa, of the largest channel: half a step of 4 / 256.
            assert!(worst(&sky, &back, |_| 4.0) <= 0.5 / 256.0);
            // Blue is above 1 everywhere and is clipped.
            let lost = write_environment(&file("png"), &sky).unwrap();
            assert!(lost.above >= u64::from(size * size) && lost.below == 0);
            let back = read_environment(&file("png"), chart).unwrap();
            let red = worst(&sky, &back, |c| if c > 1.0 { f32::INFINITY } else { 1.0 });
            assert!(red < 0.005, "{red}");
        }
    }

    #[test]
    fn light_below_zero_is_kept_or_counted() {
        let dir = tempfile::tempdir().unwrap();
        let dark = Environment::from_fn(EnvironmentLayout::LatLong, 4, |d| [d.x as f32, 0.5, 0.0])
            .unwrap();
        let file = |ending: &str| dir.path().join(format!("a.{ending}"));
        assert!(write_environment(&file("exr"), &dark).unwrap().nothing());
        let back = read_environment(&file("exr"), EnvironmentLayout::LatLong).unwrap();
        assert_eq!(worst(&dark, &back, |_| 1.0), 0.0);
        let below = (0..32)
            .filter(|i| back.texel(0, i % 8, i / 8).unwrap()[0] < 0.0)
            .count();
        assert_eq!(below, 16);
        for ending in ["hdr", "png"] {
            let lost = write_environment(&file(ending), &dark).unwrap();
            assert_eq!((lost.above, lost.below), (0, 16), "{ending}");
        }
    }

    /// Values of 16 bits are those of 8 bits times 257.
    #[test]
    fn wide_pixels_are_the_light_of_narrow_ones() {
        let dir = tempfile::tempdir().unwrap();
        let code = |x: u32, y: u32| [(x * 16 + y) as u8, (y * 13) as u8, 255 - x as u8];
        let narrow = image::RgbImage::from_fn(16, 8, |x, y| Rgb(code(x, y)));
        let wide = |c: u8| u16::from(c) * 257;
        let wide = image::ImageBuffer::from_fn(16, 8, |x, y| Rgb(code(x, y).map(wide)));
        let files = ["narrow.png", "wide.png"].map(|name| dir.path().join(name));
        narrow.save(&files[0]).unwrap();
        wide.save(&files[1]).unwrap();
        let [narrow, wide] =
            files.map(|file| read_environment(&file, EnvironmentLayout::LatLong).unwrap());
        assert!(worst(&narrow, &wide, |_| 1.0) < 1e-7);
        let [red, ..] = narrow.texel(0, 8, 0).unwrap();
        assert!((red - 0.215_861).abs() < 1e-6, "byte 128 is {red}");
    }

    #[test]
    fn sizes_are_those_of_the_chart() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("square.png");
        image_io::write_png(&path, 8, 8, &[128; 256]).unwrap();
        let error = read_environment(&path, EnvironmentLayout::LatLong).unwrap_err();
        assert_eq!(error.code(), "environment-size");
        assert!(
            error.to_string().contains("8 x 8") && error.help().contains("2 times"),
            "{error}"
        );
        assert!(read_environment(&path, EnvironmentLayout::Octahedron).is_ok());
        assert_eq!(
            read_environment(&path, EnvironmentLayout::Cube)
                .unwrap_err()
                .code(),
            "environment-size"
        );
        let odd = dir.path().join("a.tif");
        assert_eq!(
            write_environment(&odd, &sky(EnvironmentLayout::Cube, 2))
                .unwrap_err()
                .code(),
            "unknown-format"
        );
    }
}
