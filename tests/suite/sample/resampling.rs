//! Images as functions: resampling through affine maps and homographies; mip options.

use crate::support::{Random, float_texture, random_bytes, random_floats};
use texmap_math::glam::{DMat3, DVec2, DVec3};
use texmap_math::{Homography, Level};
use texmap_sample::{
    Alpha, ColorSpace, EdgeMode, Filter, Image, Origin, Resample, TexelData, Texture2d,
};

fn affine(a: [f64; 6]) -> Homography {
    let [a, b, c, d, e, f] = a;
    Homography::from_matrix(DMat3::from_cols(
        DVec3::new(a, d, 0.0),
        DVec3::new(b, e, 0.0),
        DVec3::new(c, f, 1.0),
    ))
    .unwrap()
}

fn draw(
    t: &Texture2d<'_>,
    filter: Filter,
    outside: EdgeMode,
    map: &Homography,
    w: u32,
    h: u32,
) -> Vec<[f32; 4]> {
    let mut out = vec![[0.0; 4]; (w * h) as usize];
    Resample::new(t, filter, outside, map)
        .rows(Level::new(), w, 0, &mut out)
        .unwrap();
    out
}

#[test]
fn the_identity_and_quarter_turns_are_exact() {
    let t = random_floats(9, 6, 4);
    // The first row is the upper one, whatever the texture counts from.
    let flipped = t.clone().with_origin(Origin::BottomLeft);
    for (filter, read) in [
        (Filter::Nearest, &t),
        (Filter::Bilinear, &t),
        (Filter::Anisotropic(16), &t),
        (Filter::Bilinear, &flipped),
    ] {
        let same = draw(
            read,
            filter,
            EdgeMode::Transparent,
            &Homography::IDENTITY,
            9,
            6,
        );
        // A quarter turn counter-clockwise: (x, y) goes to (y, 9 - x).
        let turned = draw(
            &t,
            filter,
            EdgeMode::Transparent,
            &affine([0.0, 1.0, 0.0, -1.0, 0.0, 9.0]),
            6,
            9,
        );
        for y in 0..6 {
            for x in 0..9 {
                let want = t.texel(0, x, y).unwrap();
                let (a, b) = (
                    same[(y * 9 + x) as usize],
                    turned[((8 - x) * 6 + y) as usize],
                );
                for k in 0..4 {
                    assert!((a[k] - want[k]).abs() < 1e-5 && (b[k] - want[k]).abs() < 1e-5);
                }
            }
        }
    }
}

/// Half a pixel: every value is the mean of two texels, and the border pixel is half covered.
#[test]
fn half_a_pixel_blends_and_covers_by_half() {
    let t = float_texture(4, 1, 4, &[1.0; 16]);
    let out = draw(
        &t,
        Filter::Bilinear,
        EdgeMode::Transparent,
        &affine([1.0, 0.0, 0.5, 0.0, 1.0, 0.0]),
        5,
        1,
    );
    let alpha: Vec<f32> = out.iter().map(|c| c[3]).collect();
    assert_eq!(alpha, [0.5, 1.0, 1.0, 1.0, 0.5]);
    let edge = draw(
        &t,
        Filter::Bilinear,
        EdgeMode::Edge,
        &affine([1.0, 0.0, 0.5, 0.0, 1.0, 0.0]),
        5,
        1,
    );
    assert!(edge.iter().all(|c| c[3] == 1.0));
    let border = EdgeMode::Border([0.0, 0.0, 0.0, 1.0]);
    let out = draw(
        &t,
        Filter::Bilinear,
        border,
        &affine([1.0, 0.0, 0.5, 0.0, 1.0, 0.0]),
        5,
        1,
    );
    assert_eq!((out[0][0], out[0][3]), (0.5, 1.0));
}

/// The covered area of a turned image is its own area: edges are antialiased, not dropped.
#[test]
fn turned_edges_keep_the_area() {
    let t = float_texture(40, 30, 4, &[1.0; 4800]);
    for degrees in [10.0_f64, 33.0, 45.0, 71.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let map = affine([
            c,
            s,
            40.0 - 20.0 * c - 15.0 * s,
            -s,
            c,
            40.0 + 20.0 * s - 15.0 * c,
        ]);
        let out = draw(&t, Filter::Bilinear, EdgeMode::Transparent, &map, 80, 80);
        let area: f64 = out.iter().map(|c| f64::from(c[3])).sum();
        assert!((area - 1200.0).abs() < 3.0, "{degrees}: {area}");
        assert!(out.iter().filter(|c| c[3] > 0.02 && c[3] < 0.98).count() > 60);
    }
}

/// The share of a pixel's square that lies in the image, by 128 x 128 points.
fn counted(map: &Homography, size: [f64; 2], x: usize, y: usize) -> f64 {
    const SIDE: usize = 128;
    let back = map.inverse();
    let front = back
        .apply_homogeneous(map.apply(DVec2::from_array(size) * 0.5).unwrap())
        .z;
    let mut inside = 0;
    for j in 0..SIDE {
        for i in 0..SIDE {
            let step = |k: usize| (k as f64 + 0.5) / SIDE as f64;
            let p = back.apply_homogeneous(DVec2::new(x as f64 + step(i), y as f64 + step(j)));
            let source = p.truncate() / p.z;
            inside += usize::from(
                p.z * front > 0.0
                    && source.min_element() >= 0.0
                    && source.x <= size[0]
                    && source.y <= size[1],
            );
        }
    }
    inside as f64 / (SIDE * SIDE) as f64
}

/// Slanted edges, corners, slivers, images within a pixel and images that end at their horizon. A white image's alpha is the share of the
/// pixel's square that it covers.
#[test]
fn edges_cover_the_area_of_the_pixel() {
    let t = float_texture(30, 20, 1, &[1.0; 600]).with_mips();
    let size = [30.0, 20.0];
    let corners = [[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]].map(DVec2::from_array);
    let mut random = Random::new(7);
    let mut maps = Vec::new();
    while maps.len() < 60 {
        // From a third of a pixel to the whole picture.
        let reach = 40.0 * f64::from(random.unit()).powi(3) + 0.3;
        let mut c = || f64::from(random.range(-0.5, 0.5)) * reach;
        let turn = [[-0.6, -0.5], [0.5, -0.6], [0.6, 0.5], [-0.5, 0.6]];
        let quad = turn.map(|[x, y]| DVec2::new(20.3 + x * reach + c(), 19.8 + y * reach + c()));
        maps.extend(Homography::from_quads(corners, quad));
    }
    // Steep planes whose horizon crosses the picture, and the source too.
    for tilt in [0.04, 0.11, -0.07] {
        let plane = DMat3::from_cols(
            DVec3::new(0.9, 0.2, tilt * 0.3),
            DVec3::new(-0.3, 1.1, tilt),
            DVec3::new(2.0, 3.0, 1.0),
        );
        maps.push(Homography::from_matrix(plane).unwrap());
        maps.push(Homography::from_matrix(plane * -2.0).unwrap());
    }
    maps.push(affine([0.9, 0.4, 3.0, -0.4, 0.9, 14.0]));
    let (mut partial, mut within) = (0, 0);
    for map in &maps {
        let counts: Vec<f64> = (0..1600)
            .map(|i| counted(map, size, i % 40, i / 40))
            .collect();
        for outside in [EdgeMode::Transparent, EdgeMode::Border([0.0; 4])] {
            let out = draw(&t, Filter::Anisotropic(16), outside, map, 40, 40);
            for (i, (c, &want)) in out.iter().zip(&counts).enumerate() {
                assert!(
                    (f64::from(c[3]) - want).abs() < 0.005 && (c[0] - c[3]).abs() < 1e-5,
                    "{map:?} ({}, {}): {} {want}",
                    i % 40,
                    i / 40,
                    c[3]
                );
                partial += usize::from(want > 0.0 && want < 1.0);
            }
            let covered = out.iter().filter(|c| c[3] > 0.0).count();
            within += usize::from(covered == 1);
        }
    }
    assert!(partial > 5000 && within > 3, "{partial} {within}");
}

/// A pixel at the edge shows what of the image is in it, not what would lie beyond.
#[test]
fn a_cut_pixel_takes_its_colour_inside() {
    let ramp: Vec<f32> = (0..8).flat_map(|i| [i as f32, 0.0, 0.0, 1.0]).collect();
    let t = float_texture(8, 1, 4, &ramp);
    // Pixel 0 holds half of texel 0, pixel 8 half of texel 7: their middles are a quarter of a texel from the edges.
    let shifted = affine([1.0, 0.0, 0.5, 0.0, 1.0, 0.0]);
    let out = draw(&t, Filter::Bilinear, EdgeMode::Transparent, &shifted, 9, 1);
    let colors: Vec<f32> = out.iter().map(|c| c[0] / c[3]).collect();
    assert_eq!(colors[..2], [0.0, 0.5]);
    assert_eq!((colors[8], out[8][3]), (7.0, 0.5));
    let slow = affine([4.0, 0.0, 2.0, 0.0, 1.0, 0.0]);
    let out = draw(&t, Filter::Bilinear, EdgeMode::Transparent, &slow, 36, 1);
    assert!(out.iter().all(|c| c[3] == 1.0 || c[3] == 0.0));
}

/// Shrinking to a sixteenth gives the means, not every sixteenth texel.
#[test]
fn shrinking_is_filtered() {
    let checker: Vec<f32> = (0..64 * 64)
        .map(|i| ((i % 64 + i / 64) & 1) as f32)
        .collect();
    let t = float_texture(64, 64, 1, &checker).with_mips();
    let map = affine([1.0 / 16.0, 0.0, 0.0, 0.0, 1.0 / 16.0, 0.0]);
    let out = draw(&t, Filter::Anisotropic(16), EdgeMode::Edge, &map, 4, 4);
    assert!(out.iter().all(|c| (c[0] - 0.5).abs() < 0.02), "{out:?}");
    let bare = draw(&t, Filter::Nearest, EdgeMode::Edge, &map, 4, 4);
    assert!(bare.iter().any(|c| (c[0] - 0.5).abs() > 0.4));
}

/// A quad rectified and put back returns the picture; behind the horizon there is nothing.
#[test]
fn homographies_take_corners_to_corners() {
    let ramp: Vec<f32> = (0..64 * 64)
        .flat_map(|i| [(i % 64) as f32, (i / 64) as f32, 0.0, 1.0])
        .collect();
    let t = float_texture(64, 64, 4, &ramp);
    let corners =
        [[0.0, 0.0], [64.0, 0.0], [64.0, 64.0], [0.0, 64.0]].map(|[x, y]| DVec2::new(x, y));
    let quad =
        [[20.0, 10.0], [90.0, 25.0], [80.0, 85.0], [15.0, 60.0]].map(|[x, y]| DVec2::new(x, y));
    let map = Homography::from_quads(corners, quad).unwrap();
    let out = draw(&t, Filter::Bilinear, EdgeMode::Transparent, &map, 100, 100);
    let back = map.inverse();
    let mut inside = 0;
    for y in 0..100 {
        for x in 0..100 {
            let c = out[y * 100 + x];
            let p = back
                .apply(DVec2::new(x as f64 + 0.5, y as f64 + 0.5))
                .unwrap();
            if p.min_element() > 2.0 && p.max_element() < 62.0 {
                inside += 1;
                assert!(
                    (f64::from(c[0]) - (p.x - 0.5)).abs() < 1e-3
                        && (f64::from(c[1]) - (p.y - 0.5)).abs() < 1e-3
                );
            } else if p.min_element() < -2.0 || p.max_element() > 66.0 {
                assert_eq!(c[3], 0.0);
            }
        }
    }
    assert!(inside > 2500);
    // A plane that runs to its horizon inside the picture: above it, transparent.
    let steep = Homography::from_matrix(DMat3::from_cols(
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(0.0, 1.0, 0.05),
        DVec3::new(0.0, 0.0, 1.0),
    ))
    .unwrap();
    let out = draw(&t, Filter::Bilinear, EdgeMode::Edge, &steep, 32, 64);
    assert!(out.iter().all(|c| c.iter().all(|c| c.is_finite())));
}

#[test]
fn rows_may_be_drawn_apart() {
    let t = random_floats(20, 20, 3).with_mips();
    let map = affine([0.7, 0.2, 3.0, -0.3, 0.9, 5.0]);
    let whole = draw(&t, Filter::Trilinear, EdgeMode::Repeat, &map, 300, 8);
    let r = Resample::new(&t, Filter::Trilinear, EdgeMode::Repeat, &map);
    let mut row = vec![[0.0; 4]; 300];
    for y in 0..8 {
        r.rows(Level::new(), 300, y, &mut row).unwrap();
        assert_eq!(row, whole[300 * y as usize..300 * (y as usize + 1)]);
    }
    assert!(r.rows(Level::new(), 300, 0, &mut row[..299]).is_err());
}

/// Cut-outs: the plain mean loses coverage with every level, the scaled one keeps it.
#[test]
fn coverage_survives_the_chain() {
    let mut random = Random::new(12);
    let texels: Vec<f32> = (0..64 * 64)
        .flat_map(|_| {
            let a = random.unit() * random.unit().max(random.unit());
            [0.2 * a, 0.8 * a, 0.1 * a, a]
        })
        .collect();
    let make = || float_texture(64, 64, 4, &texels);
    let share = |t: &Texture2d<'_>, level: u32| {
        let (w, h) = t.level_size(level).unwrap();
        let passing = (0..w * h)
            .filter(|i| t.texel(level, i % w, i / w).unwrap()[3] >= 0.5)
            .count();
        passing as f64 / f64::from(w * h)
    };
    let (plain, kept) = (make().with_mips(), make().with_coverage_mips(0.5));
    for level in 1..=3 {
        assert!(
            (share(&kept, level) - share(&kept, 0)).abs() < 0.03,
            "{level} {}",
            share(&kept, level)
        );
        let c = kept.texel(level, 1, 1).unwrap();
        assert!(c[3] <= 1.0 && (c[1] - 0.8 * c[3]).abs() < 1e-5);
    }
    assert!(share(&plain, 3) < 0.1);
}

/// An opaque image has nothing to keep, and an image whose means pass as often as its texels needs no scale.
#[test]
fn coverage_mips_change_no_more_than_they_must() {
    for threshold in [0.1, 0.5, 1.0, 0.0, -1.0, 1.5, f32::NAN] {
        let t = random_bytes(16, 9, 2).with_coverage_mips(threshold);
        assert!(!t.has_alpha(), "{threshold}");
        for level in 0..t.levels() {
            assert_eq!(t.texel(level, 0, 0).unwrap()[3], 1.0, "{threshold} {level}");
        }
    }
    // Half of the texels stand out, in blocks that means keep.
    let texels: Vec<f32> = (0..16 * 16)
        .flat_map(|i| [0.0, 0.0, 0.0, if i % 16 < 8 { 0.9 } else { 0.2 }])
        .collect();
    let t = float_texture(16, 16, 4, &texels).with_coverage_mips(0.5);
    for level in 0..4 {
        assert_eq!(t.texel(level, 0, 0).unwrap()[3], 0.9, "{level}");
    }
}

#[test]
fn normals_stay_unit_vectors_down_the_chain() {
    let mut random = Random::new(2);
    let texels: Vec<f32> = (0..16 * 16)
        .flat_map(|_| {
            let (x, y) = (random.range(-0.7, 0.7), random.range(-0.7, 0.7));
            let z = (1.0 - x * x - y * y).sqrt();
            [x, y, z].map(|c| 0.5 + 0.5 * c)
        })
        .collect();
    let image = Image {
        width: 16,
        height: 16,
        channels: 3,
        texels: TexelData::F32(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    };
    let t = Texture2d::new(&image).unwrap();
    let plain = t.clone().with_mips();
    let t = t.with_normal_mips();
    let length = |t: &Texture2d<'_>, level| {
        let c = t.texel(level, 0, 0).unwrap();
        (0..3)
            .map(|k| (2.0 * c[k] - 1.0).powi(2))
            .sum::<f32>()
            .sqrt()
    };
    for level in 0..t.levels() {
        assert!((length(&t, level) - 1.0).abs() < 1e-5, "{level}");
    }
    assert!(length(&plain, 4) < 0.95);
}

/// Every scale of an interval keeps the coverage. The one nearest to one is taken, so that levels change no more than they must.
#[test]
fn coverage_scales_no_more_than_it_must() {
    let alphas = |texel: fn(u32, u32) -> f32| {
        let texels: Vec<f32> = (0..32 * 32)
            .flat_map(|i| {
                let a = texel(i % 32, i / 32);
                [0.5 * a, 0.25 * a, 0.0, a]
            })
            .collect();
        let t = float_texture(32, 32, 4, &texels).with_coverage_mips(0.5);
        let level = |level: u32| {
            let (w, h) = t.level_size(level).unwrap();
            let all = (0..w * h).map(|i| t.texel(level, i % w, i / w).unwrap()[3]);
            all.collect::<Vec<f32>>()
        };
        [level(1), level(3), level(5)].concat()
    };
    for opaque in [1.0, 0.75] {
        let stays = match opaque {
            1.0 => alphas(|_, _| 1.0),
            _ => alphas(|_, _| 0.75),
        };
        assert!(stays.iter().all(|a| *a == opaque), "{opaque} {stays:?}");
    }
    // Nothing passes in the base: nothing is scaled away.
    assert!(alphas(|_, _| 0.25).iter().all(|a| *a == 0.25));
    // Half of the columns: halves of texels are all that passes or fails.
    let halves = alphas(|x, _| if x < 16 { 1.0 } else { 0.0 });
    assert!(halves[..256].iter().all(|a| *a == 1.0 || *a == 0.0));
    // One hole: its 2 x 2 passes with the mean of its four, and so does the base but for a thousandth.
    let hole = alphas(|x, y| if (x, y) == (5, 7) { 0.0 } else { 1.0 });
    assert_eq!(hole[..256].iter().filter(|a| **a == 1.0).count(), 255);
    assert_eq!(hole[3 * 16 + 2], 0.75);
}
