//! The renderer against the f64 frame of rays, on every scene of `assets/`.
use std::path::{Path, PathBuf};

use texmap_io::LoadOptions;
use texmap_lab::truth::{Truth, frame};
use texmap_raster::Interp;
use texmap_render::{Frame, Scene, Settings, render};

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.retain(|file| file.extension().is_some_and(|e| e == "scene"));
    files.sort();
    assert!(files.len() >= 5, "{files:?}");
    files
}

/// Values away from edges, and how many of them differ from the truth by more than a code value.
struct Compared {
    inside: usize,
    over: usize,
    worst: f64,
}

/// A pixel lies inside when its neighbours see the same triangle, so that snapped vertices change nothing.
fn compare(truth: &Truth, frame: &Frame) -> Compared {
    let (w, h) = (WIDTH as usize, HEIGHT as usize);
    let codes = truth.codes();
    let mut out = Compared {
        inside: 0,
        over: 0,
        worst: 0.0,
    };
    for y in 1..h - 1 {
        for x in 1..w - 1 {
            let seen = truth.seen[y * w + x];
            let same =
                (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| truth.seen[y * w + x] == seen));
            if !same {
                continue;
            }
            for c in 0..4 {
                let i = (y * w + x) * 4 + c;
                let off = (f64::from(frame.rgba[i]) - codes[i]).abs();
                out.inside += 1;
                out.over += usize::from(off > 1.01);
                out.worst = out.worst.max(off);
            }
        }
    }
    out
}

/// The middle of an odd number of samples is the centre; an even number has none there.
#[test]
fn what_is_seen_does_not_depend_on_the_number_of_samples() {
    let scene = texmap_io::load_scene(&scenes()[0], &LoadOptions::default()).unwrap();
    let seen = |samples| frame(&scene, 40, 30, samples).unwrap().seen;
    let one = seen(1);
    assert!(one.iter().any(|s| *s != one[0]));
    for samples in [2, 3, 6] {
        assert_eq!(seen(samples), one, "{samples}");
    }
    // Negative twin: the first of 3 x 3 samples is another place.
    let fine = frame(&scene, 120, 90, 1).unwrap().seen;
    let first = |i: usize| fine[(i / 40 * 3) * 120 + i % 40 * 3];
    assert!((0..one.len()).any(|i| one[i] != first(i)));
}

fn drawn(scene: &Scene, interp: Option<Interp>) -> Frame {
    render(
        scene,
        &Settings {
            interp,
            ..Settings::new(WIDTH, HEIGHT)
        },
        &|_, _| {},
    )
    .unwrap()
}

#[test]
fn every_scene_is_drawn_as_rays_say() {
    for file in scenes() {
        let mut scene = texmap_io::load_scene(&file, &LoadOptions::default()).unwrap();
        // The truth knows no shadow maps, and takes meshes as they are.
        scene.effects = Default::default();
        let scene = scene.shaped(WIDTH).unwrap();
        let truth = frame(&scene, WIDTH, HEIGHT, 1).unwrap();
        let found = compare(&truth, &drawn(&scene, None));
        let name = file.file_name().unwrap().display().to_string();
        assert!(
            found.inside > 5_000,
            "{name}: {} values inside",
            found.inside
        );
        assert!(
            found.over == 0,
            "{name}: {} of {} values differ, worst {}",
            found.over,
            found.inside,
            found.worst
        );
    }
}

/// The negative twin: the floor drawn affine is far from what rays see.
#[test]
fn affine_frames_differ() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    let scene = texmap_io::load_scene(&folder.join("checker_floor.scene"), &LoadOptions::default())
        .unwrap();
    let truth = frame(&scene, WIDTH, HEIGHT, 1).unwrap();
    let found = compare(&truth, &drawn(&scene, Some(Interp::Affine)));
    assert!(
        found.over * 20 > found.inside,
        "{} of {}",
        found.over,
        found.inside
    );
}
