//! S1 to S5 and S10: wrap, large and senseless coordinates, odd mip chains, sRGB, constants.

use texmap_math::{Footprint, Level};
use texmap_sample::{ColorSpace, Cubic, Filter, Origin, Sampler, Texture2d, Wrap, sample_slice};

use super::Measurement;
use super::probe::{Random, SENSELESS};
use crate::LabError;
use crate::plane::floats;

const WRAPS: [Wrap; 4] = [
    Wrap::Repeat,
    Wrap::MirroredRepeat,
    Wrap::ClampToEdge,
    Wrap::MirrorClampToEdge,
];

/// A one-row float texture that holds its column's number.
fn ruler(width: u32) -> Result<Texture2d<'static>, LabError> {
    let texels: Vec<f32> = (0..width).map(|x| x as f32).collect();
    Ok(floats(width, 1, &texels)?)
}

fn sampler(filter: Filter, wrap: Wrap) -> Sampler {
    Sampler {
        filter,
        wrap_u: wrap,
        wrap_v: wrap,
        ..Sampler::default()
    }
}

/// The column that an exact calculation gives, with u an f32 value. Products of f32 and small integers are
/// exact in f64.
fn column(u: f32, width: u32, wrap: Wrap) -> i64 {
    let n = i64::from(width);
    let i = (f64::from(u) * f64::from(width)).floor() as i64;
    let mirror = |m: i64| if m >= 0 { m } else { -1 - m };
    match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::MirroredRepeat => n - 1 - mirror(i.rem_euclid(2 * n) - n),
        Wrap::MirrorClampToEdge => mirror(i).min(n - 1),
        _ => i.clamp(0, n - 1),
    }
}

/// S1: coordinates at, just beside and far from whole numbers, in every wrap mode.
pub(super) fn s1() -> Result<Vec<Measurement>, LabError> {
    let mut random = Random(1);
    let mut coordinates = vec![
        -0.001f32,
        -1e-30,
        -1.0,
        1.0,
        0.0,
        -0.0,
        1.0f32.next_down(),
        (-1.0f32).next_up(),
        -2.5,
        3.75,
    ];
    coordinates.extend((0..20_000).map(|_| random.range(-3.0, 4.0) as f32));
    let (mut wrong, mut truncated) = (0u32, 0u32);
    for width in [63, 64, 7, 1] {
        let texture = ruler(width)?;
        for wrap in WRAPS {
            for &u in &coordinates {
                let truth = column(u, width, wrap);
                let found = sampler(Filter::Nearest, wrap).sample(&texture, [u, 0.5])[0];
                wrong += u32::from(f64::from(found) != truth as f64);
                if wrap == Wrap::Repeat {
                    let n = i64::from(width);
                    truncated += u32::from(((u * width as f32) as i64 % n + n) % n != truth);
                }
            }
        }
    }
    Ok(measured![
        "floor", "wrong texels" => wrong.into();
        "truncation", "wrong texels" => truncated.into();
    ])
}

/// S2: thousands of repeats: the sampler adds no error to what f32 holds.
pub(super) fn s2() -> Result<Vec<Measurement>, LabError> {
    const WIDTH: u32 = 1000;
    // A triangle wave, so that bilinear results are continuous across the seam.
    let texels: Vec<f32> = (0..WIDTH).map(|x| x.min(WIDTH - 1 - x) as f32).collect();
    let texture = floats(WIDTH, 1, &texels)?;
    let mut random = Random(2);
    let mut out = Vec::new();
    for base in [4096.0, 65_536.0, 1e6] {
        let (mut most, mut naive) = (0.0f64, 0.0f64);
        for _ in 0..5_000 {
            let u = (base + random.range(0.0, 64.0)) as f32;
            let wave = |position: f64| {
                let at = |i: f64| f64::from(texels[i.rem_euclid(f64::from(WIDTH)) as usize]);
                let below = position.floor();
                at(below) * (below + 1.0 - position) + at(below + 1.0) * (position - below)
            };
            let truth = wave(f64::from(u) * f64::from(WIDTH) - 0.5);
            let found = sampler(Filter::Bilinear, Wrap::Repeat).sample(&texture, [u, 0.5])[0];
            most = most.max((f64::from(found) - truth).abs());
            naive = naive.max((wave(f64::from(u * WIDTH as f32 - 0.5)) - truth).abs());
        }
        out.extend(measured![
            "reduce, then scale", format!("u = {base}: added error in texels") => most;
            "scale in f32, then reduce", format!("u = {base}: added error in texels") => naive;
        ]);
    }
    Ok(out)
}

/// S3: NaN, infinities and 1e30 give a colour and leave the neighbours alone.
pub(super) fn s3() -> Result<Vec<Measurement>, LabError> {
    let texture = ruler(64)?.with_mips();
    let (mut not_finite, mut touched, mut beyond) = (0u32, 0u32, 0u32);
    for filter in [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Bicubic(Cubic::Mitchell),
        Filter::Trilinear,
    ] {
        for wrap in WRAPS {
            let sampler = sampler(filter, wrap);
            for u in SENSELESS {
                let footprint = Footprint {
                    du_dx: u,
                    ..Footprint::default()
                };
                for color in [
                    sampler.sample(&texture, [u, 0.5]),
                    sampler.sample(&texture, [0.5, u]),
                    sampler.sample_grad(&texture, [0.3, 0.5], footprint),
                ] {
                    not_finite += u32::from(!color.iter().all(|c| c.is_finite()));
                }
                let good: Vec<f32> = (0..16).map(|i| i as f32 * 0.061).collect();
                let v = [0.5; 16];
                let mut poisoned = good.clone();
                poisoned[5] = u;
                let (mut clean, mut dirty) = ([[0.0f32; 4]; 16], [[0.0f32; 4]; 16]);
                sample_slice(
                    Level::new(),
                    &sampler,
                    &texture,
                    &good,
                    &v,
                    None,
                    &mut clean,
                )?;
                sample_slice(
                    Level::new(),
                    &sampler,
                    &texture,
                    &poisoned,
                    &v,
                    None,
                    &mut dirty,
                )?;
                let unlike = (0..16).filter(|&i| {
                    i != 5 && clean[i].map(f32::to_bits) != dirty[i].map(f32::to_bits)
                });
                touched += unlike.count() as u32;
                // `as i32` saturates; the second texel of a bilinear look-up is then out of range.
                beyond += u32::from(((u * 64.0 - 0.5) as i32).checked_add(1).is_none());
            }
        }
    }
    Ok(measured![
        "reduced coordinates", "colours that are not finite" => not_finite.into();
        "reduced coordinates", "neighbours in a slice that change" => touched.into();
        "saturating cast, then + 1", "overflows" => beyond.into();
    ])
}

/// S4: every level of an odd-sized float texture keeps the mean of the base.
pub(super) fn s4() -> Result<Vec<Measurement>, LabError> {
    let mut random = Random(4);
    let (mut most, mut dropped) = (0.0f64, 0.0f64);
    for (width, height) in [(3, 7), (31, 55), (127, 99), (1, 33), (57, 1), (1, 1)] {
        let texels: Vec<f32> = (0..width * height)
            .map(|_| random.range(0.0, 1.0) as f32)
            .collect();
        let texture = floats(width, 1, &texels)?.with_mips();
        let mean = texels.iter().map(|&t| f64::from(t)).sum::<f64>() / texels.len() as f64;
        for level in 0..texture.levels() {
            let (w, h) = texture.level_size(level).unwrap_or((0, 0));
            let all = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
            let values: Vec<f64> = all
                .filter_map(|(x, y)| texture.texel(level, x, y))
                .map(|t| f64::from(t[0]))
                .collect();
            most = most.max((values.iter().sum::<f64>() / values.len() as f64 - mean).abs());
        }
        let top = drop_halving(
            width as usize,
            height as usize,
            texels.iter().map(|&t| f64::from(t)).collect(),
        );
        dropped = dropped.max((top - mean).abs());
    }
    Ok(measured![
        "weights by area", "mean of a level less that of the base" => most;
        "2 x 2 means, odd rows dropped", "mean of a level less that of the base" => dropped;
    ])
}

/// The one texel at the top of a chain of 2 x 2 means that leaves out the last odd row and column.
fn drop_halving(mut width: usize, mut height: usize, mut texels: Vec<f64>) -> f64 {
    while width * height > 1 {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let at = |x: usize, y: usize| texels[y.min(height - 1) * width + x.min(width - 1)];
        let mean = |x: usize, y: usize| {
            (at(2 * x, 2 * y)
                + at(2 * x + 1, 2 * y)
                + at(2 * x, 2 * y + 1)
                + at(2 * x + 1, 2 * y + 1))
                / 4.0
        };
        texels = (0..w * h).map(|i| mean(i % w, i / w)).collect();
        (width, height) = (w, h);
    }
    texels[0]
}

/// S5: halfway between black and green in sRGB is half the light.
pub(super) fn s5() -> Result<Vec<Measurement>, LabError> {
    let bytes = vec![0, 0, 0, 255, 0, 255, 0, 255];
    let texture = Texture2d::from_rgba8(2, 1, bytes, ColorSpace::Srgb, Origin::TopLeft)?;
    let found = sampler(Filter::Bilinear, Wrap::ClampToEdge).sample(&texture, [0.5, 0.5])[1];
    // The wrong way: filter the code values, then decode.
    let wrong = texmap_math::color::srgb_to_linear(0.5);
    Ok(measured![
        "decode, then filter", "distance from 0.5 in linear light" => (f64::from(found) - 0.5).abs();
        "filter, then decode", "distance from 0.5 in linear light" => (f64::from(wrong) - 0.5).abs();
        "filter, then decode", "value in linear light" => wrong.into();
    ])
}

/// S10: a constant texture gives its constant, whatever the filter and the footprint.
pub(super) fn s10() -> Result<Vec<Measurement>, LabError> {
    let mut random = Random(10);
    let value = 0.3f32;
    let float = floats(37, 1, &[value; 37 * 19])?
        .with_mips()
        .with_summed_area();
    let bytes = Texture2d::from_rgba8(
        37,
        19,
        [77, 77, 77, 255].repeat(37 * 19),
        ColorSpace::Linear,
        Origin::TopLeft,
    )?;
    let bytes = bytes.with_mips().with_summed_area();
    let filters = [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Bicubic(Cubic::CatmullRom),
        Filter::Bicubic(Cubic::BSpline),
        Filter::MipNearest,
        Filter::BilinearMipNearest,
        Filter::Trilinear,
        Filter::Anisotropic(16),
        Filter::ewa(8),
        Filter::SummedArea,
    ];
    let (mut ulps, mut codes, mut truncated) = (0.0f64, 0u32, 0u32);
    for filter in filters {
        let sampler = sampler(filter, Wrap::Repeat);
        for _ in 0..2_000 {
            let uv = [
                random.range(-3.0, 3.0) as f32,
                random.range(-3.0, 3.0) as f32,
            ];
            let mut step = || (random.range(-1.0, 1.0) * random.range(0.0, 0.5)) as f32;
            let footprint = Footprint {
                du_dx: step(),
                dv_dx: step(),
                du_dy: step(),
                dv_dy: step(),
            };
            let found = sampler.sample_grad(&float, uv, footprint)[0];
            ulps = ulps.max(f64::from((found - value).abs()) / f64::from(value.next_up() - value));
            let code = sampler.sample_grad(&bytes, uv, footprint)[0];
            codes += u32::from(texmap_math::color::unit_to_u8(code) != 77);
            // 8-bit weights, every product shifted down on its own.
            let (a, b) = (
                (uv[0].abs().fract() * 256.0) as u32,
                (uv[1].abs().fract() * 256.0) as u32,
            );
            let weights = [(256 - a) * (256 - b), a * (256 - b), (256 - a) * b, a * b];
            truncated += u32::from(weights.map(|w| (w * 77) >> 16).iter().sum::<u32>() != 77);
        }
    }
    Ok(measured![
        "weights that sum to 1", "f32: units of the last place" => ulps;
        "weights that sum to 1", "u8: look-ups that differ" => codes.into();
        "truncated products", "u8: look-ups that differ" => truncated.into();
    ])
}
