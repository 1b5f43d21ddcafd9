//! The look-ups of `bench.py` through the slice function of `texmap-sample`: what a call from Python is measured against.
use std::error::Error;
use std::fs;
use std::time::Instant;

use texmap_math::{Footprint, Level};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Sampler, TexelData, Texture2d, sample_slice,
};

/// Nanoseconds that this process ran on a processor, where Linux tells; else of the clock.
fn now(begin: Instant) -> u64 {
    let told = fs::read_to_string("/proc/self/schedstat").ok();
    let told = told.and_then(|text| text.split(' ').next()?.parse().ok());
    told.unwrap_or(begin.elapsed().as_nanos() as u64)
}

fn main() -> Result<(), Box<dyn Error>> {
    const COUNT: usize = 1_000_000;
    let begin = Instant::now();
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let texels: Vec<f32> = (0..1024 * 1024 * 4).map(|_| next()).collect();
    let texture = Texture2d::new(&Image {
        width: 1024,
        height: 1024,
        channels: 4,
        texels: TexelData::F32(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::BottomLeft,
    })?
    .with_mips();
    let u: Vec<f32> = (0..COUNT).map(|_| next()).collect();
    let v: Vec<f32> = (0..COUNT).map(|_| next()).collect();
    let grads = vec![Footprint::new(1e-3, 1e-3, 1e-3, 1e-3); COUNT];
    let mut out = vec![[0.0; 4]; COUNT];
    for (filter, grads) in [
        (Filter::Bilinear, None),
        (Filter::Trilinear, Some(&grads[..])),
    ] {
        let sampler = Sampler {
            filter,
            ..Sampler::default()
        };
        let mut best = u64::MAX;
        for _ in 0..9 {
            let from = now(begin);
            sample_slice(Level::new(), &sampler, &texture, &u, &v, grads, &mut out)?;
            best = best.min(now(begin) - from);
        }
        println!(
            "sample_slice, 1 M look-ups, 4 channels, {filter:?}: {:.2} ms",
            best as f64 * 1e-6
        );
    }
    Ok(())
}
