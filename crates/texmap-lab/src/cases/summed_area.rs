//! S11: sums of a large picture, and footprints that lie across it.

use texmap_math::{Footprint, deterministic_f64};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};

use super::Measurement;
use super::probe::Random;
use crate::LabError;
use crate::plane::floats;

const SIDE: u32 = 1024;

/// S11: means of single texels far from the origin of the sums, and a long footprint turned by 45 degrees.
pub(super) fn s11() -> Result<Vec<Measurement>, LabError> {
    let mut random = Random(11);
    let mut bytes = vec![255u8; (SIDE * SIDE * 4) as usize];
    for texel in bytes.chunks_exact_mut(4) {
        texel[0] = random.range(0.0, 256.0) as u8;
    }
    let narrow = narrow_sums(&bytes);
    let texture = Texture2d::from_rgba8(
        SIDE,
        SIDE,
        bytes.clone(),
        ColorSpace::Linear,
        Origin::TopLeft,
    )?;
    let texture = texture.with_summed_area();
    let by = |filter| Sampler {
        filter,
        ..Sampler::default()
    };
    let summed = by(Filter::SummedArea);
    let (mut wide_off, mut narrow_off) = (0.0f64, 0.0f64);
    for _ in 0..2_000 {
        let [x, y] = [(); 2].map(|()| random.range(0.0, f64::from(SIDE)) as usize);
        let texel = f64::from(bytes[4 * (y * SIDE as usize + x)]);
        let uv = [x, y].map(|c| (c as f32 + 0.5) / SIDE as f32);
        let found = f64::from(summed.sample(&texture, uv)[0]) * 255.0;
        wide_off = wide_off.max((found - texel).abs());
        let at = |x: usize, y: usize| narrow[y * (SIDE as usize + 1) + x];
        let mean = at(x + 1, y + 1) - at(x, y + 1) - at(x + 1, y) + at(x, y);
        narrow_off = narrow_off.max((f64::from(mean) - texel).abs());
    }
    let stripes = stripes()?;
    // Along a crest: one texel wide, 45 long. All that it sees is 1, or nearly.
    let along = 32.0 / SIDE as f32;
    let across = 0.5 / SIDE as f32;
    let turned = Footprint::new(along, along, -across, across);
    let error = |filter| {
        let found = by(filter).sample_grad(&stripes, [0.5, 0.5], turned)[0];
        1.0 - f64::from(found)
    };
    let measure = "error on a footprint turned by 45 degrees, along a crest of 1";
    Ok(measured![
        "sums in f64", "error of a texel of 1024 x 1024, of 255" => wide_off;
        "sums in f32", "error of a texel of 1024 x 1024, of 255" => narrow_off;
        "anisotropic:16", measure => error(Filter::Anisotropic(16));
        "summed-area", measure => error(Filter::SummedArea);
    ])
}

/// The table of the first channel in f32.
fn narrow_sums(bytes: &[u8]) -> Vec<f32> {
    let side = SIDE as usize;
    let mut sums = vec![0.0f32; (side + 1) * (side + 1)];
    for y in 0..side {
        let mut line = 0.0;
        for x in 0..side {
            line += f32::from(bytes[4 * (y * side + x)]);
            sums[(y + 1) * (side + 1) + x + 1] = sums[y * (side + 1) + x + 1] + line;
        }
    }
    sums
}

/// Waves 32 texels long in x and in y, their crests along x = y.
fn stripes() -> Result<Texture2d<'static>, LabError> {
    let texel = |i: u32| {
        let from = f64::from(i % SIDE) - f64::from(i / SIDE);
        deterministic_f64::cos(from / 32.0 * std::f64::consts::TAU) as f32
    };
    let texels: Vec<f32> = (0..SIDE * SIDE).map(texel).collect();
    Ok(floats(SIDE, 1, &texels)?.with_mips().with_summed_area())
}
