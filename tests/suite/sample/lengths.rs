//! Batches of every length: none, fewer than a vector has lanes, and lengths that no vector divides.

use crate::support::{Random, filters, random_bytes};
use texmap_math::{Footprint, Level};
use texmap_sample::{
    ColorSpace, DirectionBatch, Places, Precision, Sampler, UvwBatch, Wrap, sample_3d_soa,
    sample_cube_soa, sample_dependent_soa, sample_rgba8_slice, sample_slice, sample_soa,
};
use texmap_tests::levels::levels;

/// Two vectors of sixteen and some.
const MOST: usize = 35;

/// Columns of coordinates and derivatives over several texels and levels.
fn columns() -> [Vec<f32>; 6] {
    let mut random = Random::new(71);
    [2.0, 2.0, 0.1, 0.1, 0.1, 0.1].map(|reach| {
        (0..MOST)
            .map(|_| random.range(-reach, reach))
            .collect::<Vec<f32>>()
    })
}

/// Runs `batch` for every length on every level; each result must be the front of the longest one of one lane.
fn check<T: Copy + Default + PartialEq + std::fmt::Debug>(
    kind: &str,
    batch: impl Fn(Level, usize, &mut [T]),
) {
    let levels = levels();
    let singles: Vec<T> = {
        let (_, narrowest) = levels[levels.len() - 1];
        let mut out = [T::default(); MOST];
        batch(narrowest, MOST, &mut out);
        out.to_vec()
    };
    assert!(singles.iter().any(|x| *x != T::default()), "{kind}");
    for (name, level) in levels {
        for count in 0..=MOST {
            let mut out = [T::default(); MOST];
            batch(level, count, &mut out[..count]);
            assert_eq!(out[..count], singles[..count], "{kind} {name} {count}");
        }
    }
}

/// Columns of four to colours.
fn colors(columns: [[f32; MOST]; 4], out: &mut [[u32; 4]]) {
    for (k, out) in out.iter_mut().enumerate() {
        *out = columns.each_ref().map(|column| column[k].to_bits());
    }
}

#[test]
fn textures_in_batches_of_every_length() {
    let at = columns();
    let opaque = random_bytes(16, 16, 3).with_mips().with_summed_area();
    let soft = random_bytes(13, 7, 4).with_mips().with_summed_area();
    let footprints: Vec<Footprint> = (0..MOST)
        .map(|k| Footprint::new(at[2][k], at[3][k], at[4][k], at[5][k]))
        .collect();
    for (t, filter) in [&opaque, &soft]
        .into_iter()
        .flat_map(|t| filters().into_iter().map(move |filter| (t, filter)))
    {
        for precision in [Precision::Exact, Precision::Fast] {
            let s = Sampler {
                filter,
                precision,
                ..Sampler::default()
            };
            let kind = format!("{filter:?} {precision:?}");
            for with in [true, false] {
                check(&kind, |level, count, out| {
                    let [u, v, gradients @ ..] = at.each_ref().map(|column| &column[..count]);
                    let gradients = with.then_some(gradients);
                    let mut found = [[0.0; MOST]; 4];
                    let slices = found.each_mut().map(|column| &mut column[..count]);
                    sample_soa(level, &s, t, &Places { u, v, gradients }, slices).unwrap();
                    colors(found, out);
                });
                check(&kind, |level, count, out: &mut [[u32; 4]]| {
                    let [u, v] = [&at[0][..count], &at[1][..count]];
                    let footprints = with.then_some(&footprints[..count]);
                    let mut found = [[0.0; 4]; MOST];
                    sample_slice(level, &s, t, u, v, footprints, &mut found[..count]).unwrap();
                    let found = found.map(|c| c.map(f32::to_bits));
                    out.copy_from_slice(&found[..count]);
                });
                check(&kind, |level, count, out: &mut [u32]| {
                    let [u, v] = [&at[0][..count], &at[1][..count]];
                    let footprints = with.then_some(&footprints[..count]);
                    sample_rgba8_slice(level, &s, t, u, v, footprints, out).unwrap();
                });
            }
        }
    }
}

#[test]
fn cubes_volumes_and_ramps_in_batches_of_every_length() {
    let at = columns();
    let cube = crate::cubes::cube(8, ColorSpace::Srgb, |a| a as u8);
    let [_, (_, volume), ..] = crate::volumes::volumes();
    let first = random_bytes(16, 16, 3).with_mips();
    let ramp = random_bytes(32, 2, 6).with_mips();
    let s = Sampler::default();
    for with in [true, false] {
        check("cube", |level, count, out| {
            let [x, y, z, lod] = [0, 1, 2, 3].map(|k| &at[k][..count]);
            let lod = with.then_some(lod);
            let mut found = [[0.0; MOST]; 4];
            let slices = found.each_mut().map(|column| &mut column[..count]);
            sample_cube_soa(level, &s, &cube, &DirectionBatch { x, y, z, lod }, slices).unwrap();
            colors(found, out);
        });
        check("volume", |level, count, out| {
            let [u, v, w, lod] = [0, 1, 2, 3].map(|k| &at[k][..count]);
            let lod = with.then_some(lod);
            let mut found = [[0.0; MOST]; 4];
            let slices = found.each_mut().map(|column| &mut column[..count]);
            let at = UvwBatch { u, v, w, lod };
            sample_3d_soa(level, &s, &volume, Wrap::Repeat, &at, slices).unwrap();
            colors(found, out);
        });
        check("ramp", |level, count, out| {
            let [u, v, gradients @ ..] = at.each_ref().map(|column| &column[..count]);
            let gradients = with.then_some(gradients);
            let mut found = [[0.0; MOST]; 4];
            let slices = found.each_mut().map(|column| &mut column[..count]);
            let at = Places { u, v, gradients };
            sample_dependent_soa(level, (&s, &first), (&s, &ramp), &at, slices).unwrap();
            colors(found, out);
        });
    }
}
