//! The conformance table of the sampler, from the f64 definitions:
//! `cargo run --release -p texmap-tests --example sample_conformance > tests/data/sampler.toml`
//!
//! Any sampler can be run against it: textures are float RGBA, linear, rows top to bottom.
#![allow(clippy::print_stdout, reason = "a table is what it makes")]

use texmap_sample::{Alpha, ColorSpace, Image, Origin, Sampler, TexelData, Texture2d, reference};

const WRAPS: [&str; 5] = [
    "repeat",
    "mirrored-repeat",
    "clamp-to-edge",
    "clamp-to-border",
    "mirror-clamp-to-edge",
];
const FILTERS: [&str; 9] = [
    "nearest",
    "bilinear",
    "bicubic:catmull-rom",
    "bicubic:mitchell",
    "bicubic:b-spline",
    "mip-nearest",
    "bilinear-mip-nearest",
    "trilinear",
    "anisotropic:16",
];
const SIZES: [(u32, u32); 5] = [(4, 8), (3, 7), (5, 1), (1, 1), (9, 6)];

/// A full-period generator modulo 2^32 (Knuth), its top bits as sixteenths: short numbers in the file.
fn sixteenths(state: &mut u32, steps: u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 20) as f32 % steps as f32 / 16.0
}

fn main() {
    println!("# Made by `cargo run --release -p texmap-tests --example sample_conformance`.");
    println!(
        "# uv and grad = [du/dx, dv/dx, du/dy, dv/dy] per pixel; v = 0 is the first row; border is (0.5, 0.25, 0, 1)."
    );
    println!(
        "# Mip levels: area-weighted means, sides halve rounding down. Level of detail: Vulkan's formula.\n"
    );
    let mut state = 1;
    let border = [0.5, 0.25, 0.0, 1.0];
    for (width, height) in SIZES {
        let texels: Vec<f32> = (0..width * height * 4)
            .map(|_| sixteenths(&mut state, 17))
            .collect();
        println!("[[texture]]\nwidth = {width}\nheight = {height}\ntexels = {texels:?}\n");
        let t = Texture2d::new(&Image {
            width,
            height,
            channels: 4,
            texels: TexelData::F32(&texels),
            color: ColorSpace::Linear,
            alpha: Alpha::Premultiplied,
            origin: Origin::TopLeft,
        })
        .expect("the sizes are in range")
        .with_mips();
        for filter in FILTERS {
            for (i, wrap) in WRAPS.into_iter().enumerate() {
                let wrap_v = WRAPS[(i + 1) % 5];
                let s = Sampler {
                    filter: filter.parse().expect("a known filter"),
                    wrap_u: wrap.parse().expect("a known wrap"),
                    wrap_v: wrap_v.parse().expect("a known wrap"),
                    border,
                    ..Sampler::default()
                };
                for _ in 0..4 {
                    // Odd 1/64ths stay off texel edges and ties of these sizes.
                    let uv = [0; 2].map(|_| sixteenths(&mut state, 64) - 1.5 + 1.0 / 61.0);
                    let d = [0; 4].map(|_| (sixteenths(&mut state, 32) - 1.0) / 4.0 + 1.0 / 67.0);
                    let expect =
                        reference::sample_grad(&s, &t, uv.map(f64::from), d.map(f64::from));
                    println!(
                        "[[texture.case]]\nfilter = {filter:?}\nwrap = [{wrap:?}, {wrap_v:?}]\nuv = {uv:?}\ngrad = {d:?}\nexpect = {expect:?}\n"
                    );
                }
            }
        }
    }
}
