//! Random scenes: every path through the tile gives the same bytes, on every level, any number of threads and in any order.

use texmap_render::{Aov, Frame, RenderSettings, Renderer, pixel_hash, render, render_ordered};
use texmap_scene::{ColorMode, Scene};
use texmap_targets::random::{scene, settings};
use texmap_tests::levels::levels;

use crate::scenes::{bits, empty, quad, unlit, values};

fn assert_same(frame: &Frame, expected: &Frame, what: &str) {
    assert_eq!(pixel_hash(frame), pixel_hash(expected), "{what}");
    assert_eq!(bits(frame), bits(expected), "{what}");
    let covered = [frame, expected].map(|f| f.stats.pixels_covered);
    assert_eq!(covered[0], covered[1], "{what}");
}

#[test]
fn random_scenes_have_one_picture() {
    let mut colours = std::collections::BTreeSet::new();
    for seed in 0..200 {
        let (scene, settings) = (scene(seed), settings(seed));
        let expected =
            render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
        colours.extend(expected.rgba.chunks_exact(4).map(<[u8]>::to_vec));
        let general = Renderer::new(&scene, &settings)
            .expect("a good scene")
            .staged();
        let general = general
            .draw(&texmap_render::no_progress)
            .expect("a good scene");
        assert_same(&general, &expected, &format!("seed {seed}, all stages"));
        for (name, level) in levels() {
            let settings = RenderSettings {
                level,
                ..settings.clone()
            };
            let frame =
                render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
            assert_same(&frame, &expected, &format!("seed {seed}, {name}"));
        }
        for threads in [1, 2, 3, 8] {
            let settings = RenderSettings {
                threads: Some(threads),
                ..settings.clone()
            };
            let backwards = |n: usize| (0..n).rev().collect();
            let frame = render_ordered(&scene, &settings, &texmap_render::no_progress, &backwards);
            let frame = frame.expect("a good scene");
            assert_same(
                &frame,
                &expected,
                &format!("seed {seed}, {threads} threads"),
            );
        }
    }
    // The comparison is not one of empty pictures.
    assert!(colours.len() > 50_000, "{} colours", colours.len());
}

/// Four samples a pixel see a quarter of an edge pixel: the mean of the covered samples, in linear light, and nothing within.
#[test]
fn four_samples_smooth_edges_and_nothing_else() {
    let white = Scene {
        color: ColorMode::Srgb,
        materials: vec![unlit([1.0; 3])],
        meshes: vec![quad([
            [-0.5, -0.6, -1.0],
            [0.5, -0.4, -1.0],
            [0.4, 0.6, -1.0],
            [-0.6, 0.4, -1.0],
        ])],
        ..empty()
    };
    let four = RenderSettings {
        msaa: 4,
        ..RenderSettings::new(64, 64)
    };
    let frame = render(&white, &four, &texmap_render::no_progress).expect("a good scene");
    let mut seen: Vec<_> = frame.rgba.chunks_exact(4).map(|p| p[0]).collect();
    seen.sort_unstable();
    seen.dedup();
    // 0, 1/4, 1/2, 3/4 and 1 of white light as sRGB bytes.
    assert_eq!(seen, [0, 137, 188, 225, 255]);
    let one = render(
        &white,
        &RenderSettings::new(64, 64),
        &texmap_render::no_progress,
    )
    .expect("a good scene");
    let mut edges = 0;
    for (a, b) in frame.rgba.chunks_exact(4).zip(one.rgba.chunks_exact(4)) {
        if a != b {
            assert!(![0, 255].contains(&a[0]), "{a:?} {b:?}");
            edges += 1;
        }
    }
    assert!((60..300).contains(&edges), "{edges}");
}

/// Both sides of an edge that two triangles share: with four samples nothing of the background shows through.
#[test]
fn four_samples_leave_no_seam() {
    let scene = Scene {
        background: [1.0, 0.0, 0.0, 1.0],
        materials: vec![unlit([0.0, 1.0, 0.0])],
        meshes: vec![quad([
            [-3.0, -3.0, -1.0],
            [3.0, -3.1, -1.3],
            [3.0, 3.0, -1.0],
            [-3.2, 3.0, -1.1],
        ])],
        ..empty()
    };
    let four = RenderSettings {
        msaa: 4,
        aovs: vec![Aov::Depth],
        ..RenderSettings::new(70, 66)
    };
    let frame = render(&scene, &four, &texmap_render::no_progress).expect("a good scene");
    assert!(frame.rgba.chunks_exact(4).all(|p| p == [0, 255, 0, 255]));
    assert!(values(&frame, Aov::Depth, 35, 33)[0] > 0.0);
}

#[test]
fn samples_other_than_one_or_four_are_refused() {
    let scene = scene(1);
    for (msaa, supersample) in [(0, 1), (2, 1), (8, 1), (4, 2)] {
        let settings = RenderSettings {
            msaa,
            supersample,
            ..RenderSettings::new(8, 8)
        };
        let error = render(&scene, &settings, &texmap_render::no_progress).expect_err("refused");
        assert!(error.to_string().contains("msaa"), "{error}");
    }
}
