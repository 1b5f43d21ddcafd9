//! V1 to V6: volumes, solid textures, letters and ramps.

use texmap_math::deterministic_f64;
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Pattern, Sampler, TexelData, Texture2d, Texture3d,
    VolumeIntegrator, Wrap, gradient_noise, reference,
};

use super::Measurement;
use super::environment::Noise;
use crate::LabError;

fn grid([width, height, depth]: [u32; 3], voxels: &[f32]) -> Result<Texture3d<'static>, LabError> {
    let slices = Image {
        width,
        height,
        channels: 1,
        texels: TexelData::F32(voxels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    };
    Ok(Texture3d::new(depth, &slices)?)
}

fn sampler(filter: Filter) -> Sampler {
    Sampler {
        filter,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..Sampler::default()
    }
}

/// A volume of size 1, and steps up to far beyond it.
pub(super) fn v1() -> Result<Vec<Measurement>, LabError> {
    let (one, s) = (grid([1; 3], &[1.0])?, sampler(Filter::Trilinear));
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    let mut noise = Noise::new(71);
    for step in [1e-3f32, 0.03, 0.4, 1.0, 1e6] {
        for density in [0.2f32, 1.0, 6.0] {
            let volume = VolumeIntegrator::new(&one, &s, None, density, step)?;
            for _ in 0..50 {
                let mut next = || noise.unit();
                let (y, z) = (next(), next());
                let length = next();
                let seen =
                    volume.integrate([1.0 - length, y, z], [1.0, 0.0, 0.0], (0.0, f64::INFINITY));
                let exact = 1.0 - deterministic_f64::exp(-f64::from(density) * length);
                worst = worst.max((f64::from(seen.color[3]) - exact).abs());
                // Opacity of a step of 0.1, whatever the step is.
                let fixed = 1.0 - deterministic_f64::exp(-0.1 * f64::from(density));
                let steps = (length / f64::from(step)).ceil().max(1.0);
                naive = naive.max((1.0 - deterministic_f64::pow(1.0 - fixed, steps) - exact).abs());
            }
        }
    }
    let measure = "largest error of the opacity against 1 - exp(-density length)";
    Ok(measured![
        "steps of their own length", measure => worst;
        "one opacity for every step", measure => naive;
    ])
}

/// Rays along and beside slabs, from inside, and without direction.
pub(super) fn v2() -> Result<Vec<Measurement>, LabError> {
    let (one, s) = (grid([1; 3], &[1.0])?, sampler(Filter::Bilinear));
    let volume = VolumeIntegrator::new(&one, &s, None, 1.0, 0.25)?;
    let rays: [([f64; 3], [f64; 3], f64); 9] = [
        ([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], 1.0),
        ([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0),
        ([-1.0, 1.0, 0.5], [1.0, 0.0, 0.0], 1.0),
        ([-1.0, 1.0 + 1e-9, 0.5], [1.0, 0.0, 0.0], 0.0),
        ([-1.0, -1e-300, 0.5], [1.0, 0.0, 0.0], 0.0),
        ([0.25, 0.5, 0.5], [1.0, 0.0, 0.0], 0.75),
        ([0.0, 0.5, 0.5], [0.0, 0.0, 1.0], 0.5),
        ([2.0, 0.5, 0.5], [1.0, 0.0, 0.0], 0.0),
        ([0.5, 0.5, 0.5], [0.0, 0.0, -1.0], 0.5),
    ];
    let (mut wrong, mut divided) = (0.0, 0.0);
    for (o, d, length) in rays {
        let exact = 1.0 - deterministic_f64::exp(-length);
        let seen = f64::from(volume.integrate(o, d, (0.0, f64::INFINITY)).color[3]);
        wrong += f64::from(u8::from((seen - exact).abs() > 1e-6));
        // Slabs by division alone: 0 / 0 on a face is NaN, and every comparison with it fails.
        let (mut near, mut far) = (0.0, f64::INFINITY);
        for k in 0..3 {
            let (a, b) = (-o[k] / d[k], (1.0 - o[k]) / d[k]);
            let (first, last) = if a < b { (a, b) } else { (b, a) };
            near = if near > first { near } else { first };
            far = if far < last { far } else { last };
        }
        let found: f64 = if near < far { far - near } else { 0.0 };
        divided += f64::from(u8::from(!((found - length).abs() <= 1e-6)));
    }
    let measure = "rays whose part inside is wrong, of 9";
    Ok(measured![
        "slabs, rays along them apart", measure => wrong;
        "slabs by division", measure => divided;
    ])
}

/// Grids without voxels or with ones that are no numbers.
pub(super) fn v3() -> Result<Vec<Measurement>, LabError> {
    let faulty: [([u32; 3], &[f32]); 5] = [
        ([0, 1, 1], &[]),
        ([1, 1, 0], &[]),
        ([2, 1, 1], &[0.0]),
        ([2, 1, 1], &[0.0, f32::NAN]),
        ([1, 1, 2], &[f32::INFINITY, 0.0]),
    ];
    let taken = faulty
        .iter()
        .filter(|(size, voxels)| grid(*size, voxels).is_ok())
        .count();
    // Effect of a NaN on a ray that takes it.
    let mut left = 1.0f32;
    for dense in [0.5f32, f32::NAN, 0.5] {
        left *= 1.0 - 0.1 * dense;
    }
    let measure = "faulty grids taken, of 5, or rays that end in NaN";
    Ok(measured![
        "checked where they enter", measure => taken as f64;
        "marched as they are", measure => f64::from(u8::from(left.is_nan()));
    ])
}

/// Rings far finer than pixels.
pub(super) fn v4() -> Result<Vec<Measurement>, LabError> {
    let wood = Pattern::Wood { grain: 0.0 };
    let (mut filtered, mut centre) = (0.0f64, 0.0f64);
    let mut noise = Noise::new(72);
    for _ in 0..300 {
        let (x, width) = (5.0 + 45.0 * noise.unit(), 0.2 + 4.0 * noise.unit());
        let at = |x: f64, width: f64| f64::from(wood.value([x as f32, 0.0, 0.0], width as f32));
        let fine = |i: u32| at(x + width * ((f64::from(i) + 0.5) / 512.0 - 0.5), 0.0);
        let truth = (0..512).map(fine).sum::<f64>() / 512.0;
        filtered = filtered.max((at(x, width) - truth).abs());
        centre = centre.max((at(x, 0.0) - truth).abs());
    }
    let measure = "largest error of what a pixel sees, pixels of 0.2 to 4.2 rings";
    Ok(measured![
        "mean over the pixel's width", measure => filtered;
        "the pixel's centre", measure => centre;
    ])
}

/// Noise where coordinates are negative, huge or no numbers.
pub(super) fn v5() -> Result<Vec<Measurement>, LabError> {
    let (mut worst, mut truncated, mut outside) = (0.0f64, 0.0f64, 0.0);
    let mut noise = Noise::new(73);
    for _ in 0..4000 {
        let p = [0, 1, 2]
            .map(|_| 16.0 * noise.unit() - 8.0)
            .map(|x| x as f32);
        let exact = reference::gradient_noise(p.map(f64::from), 0);
        worst = worst.max((f64::from(gradient_noise(p, 0)) - exact).abs());
        // Truncation takes the cell on the other side of 0: the fraction comes from the wrong end.
        let turned = p.map(|x| {
            if x < 0.0 {
                x.trunc() - (x - x.trunc())
            } else {
                x
            }
        });
        truncated = truncated.max((f64::from(gradient_noise(turned, 0)) - exact).abs());
    }
    let all = [
        Pattern::Noise { octaves: 16 },
        Pattern::Marble {
            octaves: 16,
            turbulence: 1e30,
        },
        Pattern::Wood { grain: 1e30 },
    ];
    for x in [
        0.0,
        -0.0,
        1e30,
        -1e38,
        8_388_608.5,
        f32::NAN,
        f32::INFINITY,
        f32::MIN_POSITIVE,
    ] {
        for (pattern, width) in all
            .iter()
            .flat_map(|p| [0.0, 1e-30, 1e30, f32::NAN].map(|w| (p, w)))
        {
            outside += f64::from(u8::from(
                !(0.0..=1.0).contains(&pattern.value([x, 1.0 - x, 0.3], width)),
            ));
        }
    }
    let measure = "largest error of the noise, coordinates -8 to 8";
    Ok(measured![
        "cells by floor", measure => worst;
        "cells by truncation", measure => truncated;
        "cells by floor", "values of patterns outside of 0 to 1, of 96" => outside;
    ])
}

/// A ramp with a sharp step behind a picture of two numbers.
pub(super) fn v6() -> Result<Vec<Measurement>, LabError> {
    let value = |v: &[u8]| {
        Texture2d::from_rgba8(
            2,
            1,
            v.iter().flat_map(|c| [*c, *c, *c, 255]).collect(),
            ColorSpace::Linear,
            Origin::TopLeft,
        )
    };
    let (field, ramp) = (value(&[0, 255])?, {
        // Black, then white in the middle quarter, then black again.
        let texels: Vec<u8> = (0..64)
            .flat_map(|i| {
                if (24..40).contains(&i) {
                    [255; 4]
                } else {
                    [0, 0, 0, 255]
                }
            })
            .collect();
        Texture2d::from_rgba8(64, 1, texels, ColorSpace::Linear, Origin::TopLeft)?
    });
    let (first, second) = (sampler(Filter::Bilinear), sampler(Filter::Nearest));
    let still = texmap_math::Footprint::default();
    let (mut after, mut before) = (0.0f64, 0.0f64);
    for i in 0..200 {
        let u = 0.25 + 0.5 * (f64::from(i) + 0.5) / 200.0;
        let number = (u - 0.25) / 0.5;
        let exact = f64::from(u8::from((0.375..0.625).contains(&number)));
        let uv = [u as f32, 0.5];
        let looked = first.sample_through_ramp(&field, uv, still, &second, &ramp)[0];
        after = after.max((f64::from(looked) - exact).abs());
        // Colours of both texels, then mixed: the band between them never appears.
        let ends = [0.0f32, 1.0].map(|x| f64::from(second.sample_lod(&ramp, [x, 0.5], 0.0)[0]));
        before = before.max((ends[0] + (ends[1] - ends[0]) * number - exact).abs());
    }
    let measure = "largest error of the colour between two numbers";
    Ok(measured![
        "filtered, then looked up", measure => after;
        "looked up, then filtered", measure => before;
    ])
}
