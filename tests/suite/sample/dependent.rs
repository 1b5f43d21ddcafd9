//! Dependent look-ups over columns have the bits of single ones, and take the bias of a level once.

use crate::support::{Random, WRAPS, float_texture, random_bytes, random_floats};
use texmap_math::Footprint;
use texmap_sample::{Filter, Lod, Places, Sampler, sample_dependent_soa};
use texmap_tests::levels::levels;

fn columns(count: usize) -> [Vec<f32>; 6] {
    let mut random = Random::new(5);
    let mut all = core::array::from_fn(|k| {
        let reach = if k < 2 { 3.0 } else { 0.2 };
        (0..count).map(|_| random.range(-reach, reach)).collect()
    });
    let odd = [f32::NAN, f32::INFINITY, 1e30, -0.0, -1e-30, 65536.25];
    for (k, column) in all.iter_mut().enumerate() {
        let column: &mut Vec<f32> = column;
        for (at, value) in odd.into_iter().enumerate() {
            column[(7 * at + 3 * k) % count] = value;
        }
    }
    all
}

#[test]
fn columns_equal_single_dependent_look_ups_on_every_level() {
    // More than one part, and no whole number of vectors.
    let at = columns(300);
    let firsts = [
        random_bytes(64, 32, 3).with_mips(),
        random_bytes(13, 7, 4),
        random_floats(16, 16, 5).with_mips(),
    ];
    let second = random_bytes(64, 2, 6).with_mips();
    let along = Sampler::default();
    for first in &firsts {
        for (wrap_u, filter) in WRAPS
            .into_iter()
            .zip([Filter::Nearest, Filter::Trilinear].into_iter().cycle())
        {
            let s = Sampler {
                filter,
                wrap_u,
                border: [0.2, 0.7, 0.1, 1.0],
                ..Sampler::default()
            };
            let want: Vec<[f32; 4]> = (0..at[0].len())
                .map(|k| {
                    let [u, v, ux, vx, uy, vy] = at.each_ref().map(|column| column[k]);
                    s.sample_through_ramp(
                        first,
                        [u, v],
                        Footprint::new(ux, vx, uy, vy),
                        &along,
                        &second,
                    )
                })
                .collect();
            let [u, v, gradients @ ..] = at.each_ref().map(|column| &column[..]);
            let places = Places {
                u,
                v,
                gradients: Some(gradients),
            };
            for (name, level) in levels() {
                let mut out = [(); 4].map(|()| vec![0.0; u.len()]);
                let slices = out.each_mut().map(|column| &mut column[..]);
                sample_dependent_soa(level, (&s, first), (&along, &second), &places, slices)
                    .unwrap();
                for (k, want) in want.iter().enumerate() {
                    let found = out.each_ref().map(|column| column[k].to_bits());
                    assert_eq!(found, want.map(f32::to_bits), "{wrap_u:?} {name} {k}");
                }
            }
        }
    }
    let short = Places {
        u: &[0.5; 2],
        v: &[0.5; 3],
        gradients: None,
    };
    let mut out = [[0.0; 2]; 4];
    let slices = out.each_mut().map(|column| &mut column[..]);
    let level = texmap_math::Level::new();
    let e = sample_dependent_soa(level, (&along, &second), (&along, &second), &short, slices);
    assert!(e.unwrap_err().to_string().contains('v'));
}

/// A bias of one level moves the surface by one level, not by two.
#[test]
fn the_bias_of_a_level_counts_once() {
    let first = random_floats(16, 16, 8).with_mips();
    let values: Vec<f32> = (0..512).map(|i| (i as f32 + 0.5) / 512.0).collect();
    let ramp = float_texture(512, 1, 1, &values);
    let plain = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    let biased = Sampler {
        lod: Lod {
            bias: 1.0,
            ..Lod::default()
        },
        ..plain
    };
    let (uv, d) = (
        [0.31, 0.64],
        Footprint::new(1.0 / 16.0, 0.0, 0.0, 1.0 / 16.0),
    );
    let found = biased.sample_through_ramp(&first, uv, d, &plain, &ramp)[0];
    let on = |level| plain.sample_with_gradient(&first, uv, level)[0][0];
    assert!((found - on(1.0)).abs() < 2e-3, "{found} {}", on(1.0));
    assert!((on(2.0) - on(1.0)).abs() > 2e-2, "levels differ");
}
