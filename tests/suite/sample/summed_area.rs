//! The filter by summed-area tables against what it states: means of rectangles, whose sums lose nothing.

use crate::support::{Random, WRAPS, largest_difference, random_bytes, random_floats};
use texmap_math::Footprint;
use texmap_sample::{Filter, Lod, Origin, Sampler, Wrap, reference};

fn summed() -> Sampler {
    Sampler {
        filter: Filter::SummedArea,
        border: [0.1, 0.9, 0.4, 0.7],
        ..Sampler::default()
    }
}

/// Rectangles from less than a texel to several images, about places up to three images outside, for every pair of wraps.
#[test]
fn means_are_those_of_the_definition_across_every_wrap() {
    let mut random = Random::new(41);
    for origin in [Origin::TopLeft, Origin::BottomLeft] {
        // A table counts rows as memory does, whichever end v = 0 has afterwards.
        let t = random_floats(7, 5, 2)
            .with_summed_area()
            .with_origin(origin);
        for wrap_u in WRAPS {
            for wrap_v in WRAPS {
                let s = Sampler {
                    wrap_u,
                    wrap_v,
                    ..summed()
                };
                for _ in 0..40 {
                    let uv = [random.range(-3.0, 4.0), random.range(-3.0, 4.0)];
                    let [a, b, c, d] = [(); 4].map(|()| random.range(-1.5, 1.5));
                    let got = s.sample_grad(&t, uv, Footprint::new(a, b, c, d));
                    let exact = [a, b, c, d].map(f64::from);
                    let truth = reference::sample_grad(&s, &t, uv.map(f64::from), exact);
                    let off = largest_difference(got, truth);
                    assert!(
                        off < 1e-6,
                        "{wrap_u:?} {wrap_v:?} {uv:?} {exact:?}: {off:e}"
                    );
                }
            }
        }
    }
}

/// Magnified textures are bilinear, whatever the footprint; without a table the filter is trilinear.
#[test]
fn a_texel_of_side_is_bilinear_and_no_table_trilinear() {
    let plain = random_floats(9, 6, 3).with_mips();
    let t = plain.clone().with_summed_area();
    let with = |filter| Sampler { filter, ..summed() };
    let mut random = Random::new(5);
    let mut apart = 0;
    for _ in 0..200 {
        let uv = [random.range(-1.0, 2.0), random.range(-1.0, 2.0)];
        let bilinear = with(Filter::Bilinear).sample(&t, uv).map(f64::from);
        let magnified = Footprint::new(0.04, 0.0, 0.02, 0.1);
        assert!(largest_difference(summed().sample(&t, uv), bilinear) < 3e-6);
        assert!(largest_difference(summed().sample_grad(&t, uv, magnified), bilinear) < 3e-6);
        let d = Footprint::new(0.4, 0.0, 0.0, 0.4);
        let trilinear = with(Filter::Trilinear).sample_grad(&plain, uv, d);
        assert_eq!(summed().sample_grad(&plain, uv, d), trilinear);
        let mean = summed().sample_grad(&t, uv, d);
        apart += u32::from(largest_difference(mean, trilinear.map(f64::from)) > 1e-3);
    }
    assert!(apart > 150, "a table that is not read: {apart}");
}

/// Sums of a large picture lose nothing: one black texel in a white one of 4 million is seen as in a small picture. Sums in f32 would
/// be off by whole texels here.
#[test]
fn sums_of_large_pictures_are_exact() {
    let side = 2048_u32;
    let mut texels = vec![255_u8; (side * side * 4) as usize];
    let last = texels.len() - 4;
    texels[last..last + 3].fill(0);
    let t = texmap_sample::Texture2d::from_rgba8(
        side,
        side,
        texels,
        texmap_sample::ColorSpace::Linear,
        Origin::TopLeft,
    )
    .unwrap()
    .with_summed_area();
    let centre = (side as f32 - 0.5) / side as f32;
    let s = Sampler {
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..summed()
    };
    assert_eq!(s.sample(&t, [centre; 2]), [0.0, 0.0, 0.0, 1.0]);
    let beside = centre - 2.0 / side as f32;
    assert_eq!(s.sample(&t, [beside; 2]), [1.0; 4]);
    // The mean of four texels about the corner of the black one.
    let d = Footprint::new(2.0 / side as f32, 0.0, 0.0, 2.0 / side as f32);
    let corner = (side - 1) as f32 / side as f32;
    let mean = s.sample_grad(&t, [corner; 2], d);
    assert!(largest_difference(mean, [0.75, 0.75, 0.75, 1.0]) < 1e-6);
}

/// Bias and limits are those of the logarithm of a side.
#[test]
fn limits_of_levels_limit_the_sides() {
    let t = random_bytes(32, 32, 4).with_summed_area();
    let limited = |bias, min, max| Sampler {
        lod: Lod { bias, min, max },
        ..summed()
    };
    let [one, four] = [1.0 / 32.0, 4.0 / 32.0].map(|d| Footprint::new(d, 0.0, 0.0, d));
    let uv = [0.37, 0.71];
    let of = |s: Sampler, d| s.sample_grad(&t, uv, d);
    assert_eq!(of(limited(2.0, 0.0, 1000.0), one), of(summed(), four));
    assert_eq!(of(limited(0.0, 2.0, 1000.0), one), of(summed(), four));
    assert_eq!(of(limited(0.0, 0.0, 0.0), four), of(summed(), one));
    assert_eq!(summed().sample_lod(&t, uv, 2.0), of(summed(), four));
    assert_ne!(of(summed(), one), of(summed(), four));
}
