//! A million look-ups by the slice function of `texmap-sample`: the measure of `crates/texmap-py/bench.py overhead`.

#![allow(clippy::print_stdout, reason = "the times are the output")]

use std::error::Error;
use std::time::Instant;

use texmap_math::{Footprint, Level};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Sampler, TexelData, Texture2d, sample_slice,
};

fn main() -> Result<(), Box<dyn Error>> {
    const COUNT: usize = 1_000_000;
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
        let mut best = f64::INFINITY;
        for _ in 0..9 {
            let begin = Instant::now();
            sample_slice(Level::new(), &sampler, &texture, &u, &v, grads, &mut out)?;
            best = best.min(begin.elapsed().as_secs_f64());
        }
        println!(
            "sample_slice, 1 M look-ups, 4 channels, {filter:?}: {:.2} ms",
            best * 1e3
        );
    }
    Ok(())
}
