//! Environments in and out: PNG and JPEG (sRGB), Radiance HDR and OpenEXR (linear light). Charts of several faces stand below each
//! other: +X -X +Y -Y +Z -Z of a cube, +Z -Z of the paraboloids.

use std::io::{self, Cursor};
use std::path::Path;

use image::codecs::hdr::HdrEncoder;
use image::codecs::openexr::OpenExrEncoder;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageReader, Limits, Rgb};
use texmap_light::{Chart, Environment};
use texmap_math::{MemoryBudget, color};

use crate::{IoError, Place, atomic, files, image_io};

/// Reads an image as an environment in a chart. Whole numbers (PNG, JPEG, GIF) are sRGB, floats (HDR, EXR) linear light; alpha is not
/// read, negative floats are 0.
///
/// # Errors
/// File errors; [`IoError::BrokenImage`], also for a NaN or infinity; [`IoError::EnvironmentSize`] for an image whose sides the
/// chart cannot have (a lat-long map that is not 2:1).
pub fn read_environment(path: &Path, chart: Chart) -> Result<Environment, IoError> {
    read_named(path, chart, None, MemoryBudget::of_process())
}

pub(crate) fn read_named(
    path: &Path,
    chart: Chart,
    named_by: Option<&Place>,
    memory: MemoryBudget,
) -> Result<Environment, IoError> {
    let bytes = files::read(path, named_by)?;
    let broken = |problem: String| IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        problem: problem.trim_end().replace('\n', " "),
    };
    let reader = || {
        let mut reader = ImageReader::new(Cursor::new(&bytes))
            .with_guessed_format()
            .map_err(|e| broken(e.to_string()))?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(16 * image_io::MAX_TEXELS);
        reader.limits(limits);
        Ok(reader)
    };
    let (width, height) = reader()?
        .into_dimensions()
        .map_err(|e| broken(e.to_string()))?;
    let face = face_height(chart, width, height).ok_or_else(|| IoError::EnvironmentSize {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        chart: chart.name(),
        width,
        height,
        expected: expected(chart),
    })?;
    // As it is decoded, as three floats, and the copies with borders and mips that an environment keeps.
    image_io::ask_for_texels(memory, path, named_by, (width, height), 16 + 12 + 22)?;
    let image = reader()?.decode().map_err(|e| broken(e.to_string()))?;
    let texels: Vec<[f32; 3]> = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            // NaN stays, to be refused below.
            let bright = |c: f32| if c < 0.0 { 0.0 } else { c };
            let image = image.into_rgb32f();
            image.pixels().map(|&Rgb(c)| c.map(bright)).collect()
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
    Environment::from_texels(chart, (width, face), &texels).map_err(|e| broken(e.to_string()))
}

/// Rows of one face of an image of this size, if the chart can have it.
fn face_height(chart: Chart, width: u32, height: u32) -> Option<u32> {
    let face = height / chart.faces() as u32;
    let fits = face > 0 && face * chart.faces() as u32 == height && width == face * chart.aspect();
    (fits && width <= Environment::MAX_SIDE).then_some(face)
}

fn expected(chart: Chart) -> String {
    let sides = match (chart.faces(), chart.aspect()) {
        (1, 1) => "as wide as high".to_owned(),
        (1, aspect) => format!("{aspect} times as wide as high"),
        (faces, _) => {
            format!("{faces} square faces below each other, so {faces} times as high as wide")
        }
    };
    format!("{sides}, at most {} texels wide", Environment::MAX_SIDE)
}

/// Writes an environment as PNG (sRGB of 8 bits, clipped at 1), HDR or EXR (linear light), as the name's ending says, whole or not at
/// all. Returns how many texels were brighter than PNG can hold (0 for the others).
///
/// # Errors
/// [`IoError::UnknownFormat`] for other endings, [`IoError::Write`].
pub fn write_environment(path: &Path, environment: &Environment) -> Result<u64, IoError> {
    let (width, face) = environment.size();
    let faces = environment.chart().faces();
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
) -> Result<u64, IoError> {
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        let problem = format!("{} texels for {width} x {height}", texels.len());
        return Err(IoError::Write {
            path: path.to_path_buf(),
            source: io::Error::new(io::ErrorKind::InvalidInput, problem),
        });
    }
    let ending = path
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase);
    match ending.as_deref() {
        Some("png") => {
            let rgba: Vec<u8> = texels
                .iter()
                .flat_map(|c| {
                    let [r, g, b] = c.map(color::linear_to_srgb8);
                    [r, g, b, 255]
                })
                .collect();
            image_io::write_png(path, width, height, &rgba)?;
            let bright = texels.iter().filter(|c| c.iter().any(|c| *c > 1.0)).count();
            Ok(bright as u64)
        }
        Some("hdr") => {
            let pixels: Vec<Rgb<f32>> = texels.iter().map(|c| Rgb(*c)).collect();
            atomic::write(path, |out| {
                HdrEncoder::new(out)
                    .encode(&pixels, width as usize, height as usize)
                    .map_err(io::Error::other)
            })?;
            Ok(0)
        }
        Some("exr") => {
            // The encoder seeks.
            let mut bytes = Cursor::new(Vec::new());
            let data: Vec<u8> = texels
                .iter()
                .flatten()
                .flat_map(|c| c.to_ne_bytes())
                .collect();
            OpenExrEncoder::new(&mut bytes)
                .write_image(&data, width, height, ExtendedColorType::Rgb32F)
                .map_err(|e| IoError::Write {
                    path: path.to_path_buf(),
                    source: io::Error::other(e),
                })?;
            atomic::write(path, |out| out.write_all(bytes.get_ref()))?;
            Ok(0)
        }
        _ => Err(IoError::UnknownFormat {
            path: path.to_path_buf(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(chart: Chart, size: u32) -> Environment {
        Environment::from_fn(chart, size, |d| {
            [0.5 + 0.5 * d.x, 0.5 + 0.4 * d.y, 3.0 + d.z].map(|c| c as f32)
        })
        .unwrap()
    }

    fn worst(a: &Environment, b: &Environment, scale: impl Fn(f32) -> f32) -> f32 {
        let (w, h) = a.size();
        let mut worst = 0.0f32;
        for face in 0..a.chart().faces() {
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
            (Chart::LatLong, 8),
            (Chart::Cube, 9),
            (Chart::DualParaboloid, 8),
        ] {
            let sky = sky(chart, size);
            let file = |ending: &str| dir.path().join(format!("a.{ending}"));
            assert_eq!(write_environment(&file("exr"), &sky).unwrap(), 0);
            let back = read_environment(&file("exr"), chart).unwrap();
            assert_eq!(worst(&sky, &back, |_| 1.0), 0.0, "{chart:?}");
            write_environment(&file("hdr"), &sky).unwrap();
            let back = read_environment(&file("hdr"), chart).unwrap();
            // 8 bits of mantissa, of the largest channel.
            assert!(worst(&sky, &back, |_| 4.0) <= 1.0 / 256.0);
            // Blue is above 1 everywhere and is clipped.
            assert!(write_environment(&file("png"), &sky).unwrap() >= u64::from(size * size));
            let back = read_environment(&file("png"), chart).unwrap();
            let red = worst(&sky, &back, |c| if c > 1.0 { f32::INFINITY } else { 1.0 });
            assert!(red < 0.005, "{red}");
        }
    }

    /// 16 bits hold what 8 bits hold, 257 times as much.
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
        let [narrow, wide] = files.map(|file| read_environment(&file, Chart::LatLong).unwrap());
        assert!(worst(&narrow, &wide, |_| 1.0) < 1e-7);
        let [red, ..] = narrow.texel(0, 8, 0).unwrap();
        assert!((red - 0.215_861).abs() < 1e-6, "byte 128 is {red}");
    }

    #[test]
    fn sizes_are_those_of_the_chart() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("square.png");
        image_io::write_png(&path, 8, 8, &[128; 256]).unwrap();
        let error = read_environment(&path, Chart::LatLong).unwrap_err();
        assert_eq!(error.code(), "environment-size");
        assert!(
            error.to_string().contains("8 x 8") && error.help().contains("2 times"),
            "{error}"
        );
        assert!(read_environment(&path, Chart::Octahedron).is_ok());
        assert_eq!(
            read_environment(&path, Chart::Cube).unwrap_err().code(),
            "environment-size"
        );
        let odd = dir.path().join("a.tif");
        assert_eq!(
            write_environment(&odd, &sky(Chart::Cube, 2))
                .unwrap_err()
                .code(),
            "unknown-format"
        );
    }
}
