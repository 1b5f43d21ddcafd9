//! The renderer against the f64 frame of rays, on every scene of `assets/`.
use std::path::{Path, PathBuf};

use texmap_io::LoadOptions;
use texmap_lab::truth::{Truth, frame};
use texmap_lab::verify::verify;
use texmap_raster::Interp;
use texmap_render::{Frame, Material, Scene, Settings, render};

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
    assert!(files.len() >= 17, "{files:?}");
    files
}

/// Values away from edges, and how many of them differ from the truth by more than a code value.
struct Compared {
    inside: usize,
    over: usize,
    worst: f64,
}

/// A pixel lies inside when its neighbours see the same triangle under the same meshes, so that snapped vertices change nothing, and no
/// shadow ends beside it.
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
            let sees = |i: usize| (truth.seen[i], truth.layers[i]);
            let seen = sees(y * w + x);
            let same = (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| sees(y * w + x) == seen));
            if !same || truth.shadow_edges[y * w + x] {
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

/// Sample by sample, with the filters of the scene: shadows, reliefs, mirrors, projectors, solids, volumes, text and skies included.
#[test]
fn every_scene_is_drawn_as_rays_say() {
    let mut off = Vec::new();
    for file in scenes() {
        let scene = texmap_io::load_scene(&file, &LoadOptions::default()).unwrap();
        let truth = frame(&scene, WIDTH, HEIGHT, 1).unwrap();
        let found = compare(&truth, &drawn(&scene, None));
        let name = file.file_name().unwrap().display().to_string();
        assert!(
            found.inside > 5_000,
            "{name}: {} values inside",
            found.inside
        );
        if found.over > 0 {
            off.push(format!(
                "{name}: {} of {} values differ, worst {}",
                found.over, found.inside, found.worst
            ));
        }
    }
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// What `--verify` calls the true picture is what the renderer comes to with many samples.
#[test]
fn the_reference_is_where_supersampling_leads() {
    let (mut off, size) = (Vec::new(), (120, 90));
    for file in scenes() {
        let scene = texmap_io::load_scene(&file, &LoadOptions::default()).unwrap();
        let settings = Settings {
            supersample: 8,
            ..Settings::new(size.0, size.1)
        };
        let frame = render(&scene, &settings, &|_, _| {}).unwrap();
        let found = verify(&scene, &frame, 6).unwrap();
        if !(found.rmse <= 0.01 && found.judged > 1_000) {
            let name = file.file_name().unwrap().display().to_string();
            let (rmse, max, at) = (found.rmse, found.max, found.max_at);
            off.push(format!(
                "{name}: RMSE {rmse}, {max} at {at:?}, {} judged",
                found.judged
            ));
        }
    }
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// Each effect is in the truth: without it the truth is another picture.
#[test]
fn no_effect_is_left_out_of_the_truth() {
    type Change = fn(&mut Scene);
    fn all(scene: &mut Scene, change: fn(&mut Material)) {
        scene.materials.iter_mut().for_each(change);
    }
    let effects: [(&str, &str, Change); 20] = [
        ("shadows of lights", "shadows", |s| {
            s.effects.shadows.clear();
        }),
        ("shadows of projectors", "teapot_slides", |s| {
            s.effects
                .projectors
                .iter_mut()
                .for_each(|p| p.shadow = None);
        }),
        ("light of projectors", "teapot_slides", |s| {
            s.effects.projectors.clear();
        }),
        ("paint of projectors", "painted_cow", |s| {
            s.effects.projectors.clear();
        }),
        ("skies by direction", "mirrors", |s| {
            s.effects.backdrop = None;
        }),
        ("stretched skies", "signs", |s| s.effects.backdrop = None),
        ("mirrors", "mirrors", |s| all(s, |m| m.reflection = None)),
        ("specular maps", "mirrors", |s| {
            all(s, |m| m.specular_map = None);
        }),
        ("reliefs", "reliefs", |s| all(s, |m| m.relief = None)),
        ("maps of ambient light", "reliefs", |s| {
            all(s, |m| m.maps.ambient = None);
        }),
        ("maps of highlights", "reliefs", |s| {
            all(s, |m| m.maps.specular = None);
        }),
        ("maps of exponents", "reliefs", |s| {
            all(s, |m| m.maps.exponent = None);
        }),
        ("light maps", "baked_light", |s| {
            all(s, |m| m.light_map = None);
        }),
        ("solids", "solids", |s| all(s, |m| m.solid = None)),
        ("ramps", "solids", |s| all(s, |m| m.color_ramp = None)),
        ("volumes", "cloud", |s| s.effects.volumes.clear()),
        ("text", "signs", |s| {
            s.meshes.retain(|m| !m.name.starts_with("text"));
        }),
        ("labels", "signs", |s| all(s, |m| m.decal = None)),
        ("emission", "signs", |s| all(s, |m| m.emission = None)),
        ("cel shading", "signs", |s| all(s, |m| m.light_ramp = None)),
    ];
    for (effect, name, change) in effects {
        let file = scenes()
            .into_iter()
            .find(|f| f.file_stem().is_some_and(|n| n == name));
        let scene = texmap_io::load_scene(&file.unwrap(), &LoadOptions::default()).unwrap();
        let mut without = scene.clone();
        change(&mut without);
        let colors = |scene: &Scene| frame(scene, 64, 48, 1).unwrap().codes();
        let (with, without) = (colors(&scene), colors(&without));
        let differ = with
            .iter()
            .zip(&without)
            .filter(|(a, b)| (*a - *b).abs() > 2.0);
        assert!(differ.count() > 12, "{effect} do not show in {name}");
    }
}

/// The truth does not depend on threads.
#[test]
fn any_number_of_threads_computes_the_same_truth() {
    let file = scenes().into_iter().find(|f| f.ends_with("shadows.scene"));
    let scene = texmap_io::load_scene(&file.unwrap(), &LoadOptions::default()).unwrap();
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let many = rayon::ThreadPoolBuilder::new()
        .num_threads(5)
        .build()
        .unwrap();
    let colors =
        |pool: &rayon::ThreadPool| pool.install(|| frame(&scene, 40, 30, 2).unwrap().color);
    assert_eq!(colors(&alone), colors(&many));
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
