//! Panel 6: memory against error.

use texmap_light::EnvironmentLayout;
use texmap_math::{Footprint, Level};
#[cfg(feature = "gpu-images")]
use texmap_sample::BlockFormat;
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Sampler, TexelData, Texture2d, sample_slice,
};

use super::environment::{Waves, direction};
use super::shadow::{Method, Stage, Sun};
use super::time::Effort;
use super::{Across, Error, Panel, Point, SceneChart, Source};
use crate::LabError;
use crate::cases::Random;
use crate::plane::{TEXELS, TiltedPlane, Truth, sines};

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    Ok(Panel {
        id: "memory",
        title: "Memory against error",
        about: "The same picture from fewer or coarser texels. Nothing is timed here: what the bytes cost shows in the \
                other panels once they leave the cache.",
        charts: vec![textures(effort)?, environments()?, shadows(effort)?],
    })
}

fn point(method: String, bytes: u64, error: Error) -> Point {
    Point {
        method,
        source: Source::Texmap,
        time: None,
        error,
        bytes: Some(bytes),
        failures: Vec::new(),
        picture: None,
    }
}

/// The continuous waves of the tilted plane from textures of several sizes and depths.
fn textures(effort: Effort) -> Result<SceneChart, LabError> {
    let plane = TiltedPlane::default();
    let truth = plane.truth_by(Truth::Box, effort.grid.min(24), |[x, y]| {
        [sines([x - 0.5, y - 0.5])]
    });
    let u: Vec<f32> = plane.places().map(|p| p.2[0] as f32).collect();
    let v: Vec<f32> = plane.places().map(|p| p.2[1] as f32).collect();
    let footprints: Vec<_> = plane.footprints().collect();
    let mut points = Vec::new();
    for side in [128u32, 256, 512, 1024] {
        let scale = TEXELS as f64 / f64::from(side);
        let values: Vec<f64> = (0..side * side)
            .map(|i| {
                let at = |c: u32| (f64::from(c) + 0.5) * scale - 0.5;
                sines([at(i % side), at(i / side)])
            })
            .collect();
        for format in Format::ALL {
            let texture = format.texture(side, &values)?;
            for mips in [true, false] {
                let texture = if mips {
                    texture.clone().with_mips()
                } else {
                    texture.clone()
                };
                let sampler = Sampler {
                    filter: if mips {
                        Filter::Anisotropic(16)
                    } else {
                        Filter::Bilinear
                    },
                    ..Sampler::default()
                };
                let errors = errors_of(&sampler, &texture, [&u, &v], &footprints, &truth)?;
                let texels: u64 = (0..texture.levels())
                    .filter_map(|level| texture.level_size(level))
                    .map(|(w, h)| u64::from(w) * u64::from(h))
                    .sum();
                let how = if mips { "mips" } else { "one level" };
                points.push(point(
                    format!("{side}, {}, {how}", format.name()),
                    texels * format.bytes(),
                    errors,
                ));
            }
        }
        #[cfg(feature = "gpu-images")]
        for (name, format) in BLOCKS {
            let whole = Format::Byte.texture(side, &values)?.with_mips();
            let compression = texmap_io::Compression {
                format,
                quality: texmap_io::CompressionQuality::Normal,
                color: ColorSpace::Linear,
            };
            let texture = texmap_io::compress_texture(&whole, &compression)
                .map_err(|e| LabError::Chart(e.to_string()))?;
            let sampler = Sampler {
                filter: Filter::Anisotropic(16),
                ..Sampler::default()
            };
            let bytes = (0..texture.levels())
                .filter_map(|level| texture.level_size(level))
                .map(|(w, h)| format.level_bytes(w, h) as u64);
            points.push(point(
                format!("{side}, {name}, mips"),
                bytes.sum(),
                errors_of(&sampler, &texture, [&u, &v], &footprints, &truth)?,
            ));
        }
    }
    Ok(SceneChart {
        id: "memory-textures".to_owned(),
        title: "Two plane waves on the tilted plane, anisotropic:16 (bilinear without mips)"
            .to_owned(),
        truth: "mean of the continuous waves over the pixel's square".to_owned(),
        item: "pixel",
        unit: "of 1",
        across: Across::Bytes,
        points,
    })
}

/// Block-compressed storage. The waves are grey: one channel is enough.
#[cfg(feature = "gpu-images")]
const BLOCKS: [(&str, BlockFormat); 3] = [
    ("BC1", BlockFormat::Bc1),
    ("BC4", BlockFormat::Bc4),
    ("BC7", BlockFormat::Bc7),
];

/// Errors of the red channel of look-ups.
fn errors_of(
    sampler: &Sampler,
    texture: &Texture2d<'_>,
    [u, v]: [&[f32]; 2],
    footprints: &[Footprint],
    truth: &[[f64; 1]],
) -> Result<Error, LabError> {
    let mut out = vec![[0.0f32; 4]; u.len()];
    sample_slice(
        Level::new(),
        sampler,
        texture,
        u,
        v,
        Some(footprints),
        &mut out,
    )?;
    let errors = out.iter().zip(truth).map(|(o, t)| f64::from(o[0]) - t[0]);
    Ok(Error::of(errors))
}

/// Storage of a texel.
#[derive(Clone, Copy, Debug)]
enum Format {
    Byte,
    Short,
    Float,
}

impl Format {
    const ALL: [Self; 3] = [Self::Byte, Self::Short, Self::Float];

    fn name(self) -> &'static str {
        match self {
            Self::Byte => "8-bit",
            Self::Short => "16-bit",
            Self::Float => "float",
        }
    }

    /// Bytes of a texel in memory: texmap keeps integer images in four channels.
    fn bytes(self) -> u64 {
        match self {
            Self::Byte | Self::Float => 4,
            Self::Short => 8,
        }
    }

    fn texture(self, side: u32, values: &[f64]) -> Result<Texture2d<'static>, LabError> {
        let code = |most: f64| move |v: &f64| (v * most + 0.5).floor();
        let bytes: Vec<u8> = values.iter().map(code(255.0)).map(|c| c as u8).collect();
        let shorts: Vec<u16> = values
            .iter()
            .map(code(65_535.0))
            .map(|c| c as u16)
            .collect();
        let floats: Vec<f32> = values.iter().map(|&v| v as f32).collect();
        Ok(Texture2d::new(&Image {
            width: side,
            height: side,
            channels: 1,
            texels: match self {
                Self::Byte => TexelData::U8(&bytes),
                Self::Short => TexelData::U16(&shorts),
                Self::Float => TexelData::F32(&floats),
            },
            color: ColorSpace::Linear,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        })?)
    }
}

fn environments() -> Result<SceneChart, LabError> {
    const COUNT: usize = 20_000;
    let waves = Waves::new(20.0);
    let mut random = Random(99);
    let directions: Vec<_> = (0..COUNT).map(|_| direction(&mut random)).collect();
    let truth: Vec<f64> = directions.iter().map(|&d| waves.light(d)).collect();
    let mut points = Vec::new();
    for chart in EnvironmentLayout::ALL {
        for part in [0.5, 1.0, 2.0] {
            let size = (f64::from(super::environment::size(chart)) * part).round() as u32;
            let environment = waves.environment(chart, size)?;
            let errors = directions
                .iter()
                .zip(&truth)
                .map(|(d, t)| f64::from(environment.radiance(d.as_vec3().to_array())[0]) - t);
            let (width, height) = environment.size();
            let texels = chart.faces() as u64 * u64::from(width + 2) * u64::from(height + 2);
            points.push(point(
                format!("{} {size}", chart.name()),
                texels * 12,
                Error::of(errors),
            ));
        }
    }
    Ok(SceneChart {
        id: "memory-environment".to_owned(),
        title: "64 plane waves of frequency 20 in charts of three sizes".to_owned(),
        truth: format!("the waves themselves in {COUNT} uniform directions"),
        item: "look-up",
        unit: "of the light's RMS",
        across: Across::Bytes,
        points,
    })
}

fn shadows(effort: Effort) -> Result<SceneChart, LabError> {
    let stage = Stage::new(128)?;
    let sun = Sun::new(&stage, 25.0);
    let sizes: &[u32] = if effort == Effort::FULL {
        &[128, 256, 512, 1024, 2048]
    } else {
        &[128, 256, 512]
    };
    let mut points = Vec::new();
    for &size in sizes {
        let map = sun.map(size)?;
        for (method, name) in [(Method::Slope(1), "one tap"), (Method::Slope(3), "3 x 3")] {
            let mut out = vec![0.0; sun.len()];
            sun.run(method, &map, 0.0, &mut out);
            let errors = sun.judge(&out, &vec![true; sun.len()]).errors;
            points.push(point(
                format!("{size}, {name}"),
                4 * u64::from(size) * u64::from(size),
                Error::of(errors),
            ));
        }
    }
    Ok(SceneChart {
        id: "memory-shadows".to_owned(),
        title: "Shadow maps at an elevation of 25 degrees, slope bias, the edges judged too"
            .to_owned(),
        truth: format!("a shadow ray from each of {} points", sun.len()),
        item: "look-up",
        unit: "of full light",
        across: Across::Bytes,
        points,
    })
}
