//! The renderer against the f64 frame of rays, on every scene of `assets/`.
use std::path::{Path, PathBuf};
use texmap_mesh::tessellate;

use texmap_io::LoadOptions;
use texmap_math::glam::DVec3;
use texmap_raster::Interp;
use texmap_render::{Frame, RenderSettings, render};
use texmap_scene::{Material, Mesh, Scene};
use texmap_truth::verify::verify;
use texmap_truth::{Truth, frame};

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
    squares: f64,
}

impl Compared {
    /// Root mean of the squares, in code values.
    fn rmse(&self) -> f64 {
        (self.squares / self.inside.max(1) as f64).sqrt()
    }
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
        squares: 0.0,
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
                out.squares += off * off;
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
    // Negative twin: the first of 3 x 3 samples is another point.
    let fine = frame(&scene, 120, 90, 1).unwrap().seen;
    let first = |i: usize| fine[(i / 40 * 3) * 120 + i % 40 * 3];
    assert!((0..one.len()).any(|i| one[i] != first(i)));
}

fn drawn(scene: &Scene, interp: Option<Interp>) -> Frame {
    render(
        &tessellate(scene, WIDTH).unwrap(),
        &RenderSettings {
            interp,
            ..RenderSettings::new(WIDTH, HEIGHT)
        },
        &texmap_render::no_progress,
    )
    .unwrap()
}

/// Sample by sample, with the filters of the scene: shadows, bumps, mirrors, projectors, solids, volumes, text and skies included.
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

/// Models of glTF under the studio and their own lights: every lobe, both sets of coordinates, tangents, occlusion, tone mapping.
#[test]
fn metallic_roughness_is_drawn_as_its_reference_says() {
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 6] = [
        ("materials.glb", |s| {
            model(s, |m| m.roughness = 0.5 + 0.5 * m.roughness);
        }),
        ("two_uv.glb", |s| model(s, |m| m.occlusion = None)),
        ("tangents.glb", |s| {
            s.meshes[1].tangents = vec![[1.0, 0.0, 0.0, -1.0]; 4];
        }),
        ("mirrored.glb", |s| {
            s.materials.iter_mut().for_each(|m| m.normal_detail = None);
        }),
        ("instances.glb", |s| {
            s.lights.truncate(1);
            s.effects.light_names.truncate(1);
        }),
        ("plates.gltf", |s| s.effects.tone_mapping.exposure = 1.2),
    ];
    for (name, change) in changes {
        let mut scene = lit_model(name);
        let picture = drawn(&scene, None);
        let found = compare(&frame(&scene, WIDTH, HEIGHT, 1).unwrap(), &picture);
        let rmse = found.rmse();
        assert!(found.inside > 5_000, "{name}: {} values", found.inside);
        // Rounding to bytes leaves 0.29 where colours vary.
        assert!(
            rmse < 0.35 && found.worst < 1.1,
            "{name}: {rmse}, worst {}",
            found.worst
        );
        change(&mut scene);
        texmap_io::framing::renew_studio(&mut scene, texmap_light::Roughnesses::NONE);
        let other = compare(&frame(&scene, WIDTH, HEIGHT, 1).unwrap(), &picture);
        assert!(other.rmse() > 2.0 * rmse, "{name}: {} {rmse}", other.rmse());
    }
}

fn lit_model(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/gltf");
    let mut scene = texmap_io::load(&folder.join(name), &LoadOptions::default()).unwrap();
    texmap_io::framing::light_model(&mut scene, texmap_io::framing::Up::Y, false);
    scene
}

/// Light passes sheets of glass, less of it where they mirror, and what they mirror does not fade with it.
#[test]
fn glass_is_drawn_as_its_reference_says() {
    let mut scene = lit_model("materials.glb");
    for material in &mut scene.materials {
        material.alpha = texmap_scene::AlphaMode::Blend;
    }
    model(&mut scene, |m| {
        m.roughness *= 0.5;
        m.metallic *= 0.5;
        m.transmission = Some(texmap_scene::Transmission {
            factor: 0.9,
            map: m.map.clone(),
        });
    });
    texmap_io::framing::renew_studio(&mut scene, texmap_light::Roughnesses::NONE);
    let picture = drawn(&scene, None);
    let compared = |scene: &Scene| compare(&frame(scene, WIDTH, HEIGHT, 1).unwrap(), &picture);
    let found = compared(&scene);
    let rmse = found.rmse();
    assert!(found.inside > 5_000, "{} values", found.inside);
    assert!(rmse < 0.35 && found.worst < 1.1, "{rmse}, {}", found.worst);
    // Opaque surfaces, or reflections that fade, are another picture.
    let mut opaque = scene.clone();
    model(&mut opaque, |m| m.transmission = None);
    let mut faded = opaque.clone();
    faded.materials.iter_mut().for_each(|m| m.opacity = 0.5);
    for other in [opaque, faded] {
        let other = compared(&other).rmse();
        assert!(other > 10.0 * rmse, "{other} {rmse}");
    }
}

/// The light of an environment that shadows keep away is that of the reference, which has no lanes and no f32.
#[test]
fn environment_shadows_are_those_of_the_reference() {
    let mut scene = lit_model("materials.glb");
    // A wall over the model keeps the light from above.
    let (center, half) = texmap_scene::shadow_fit::bounding_square(&scene);
    let side = 2.0 * half;
    let corners = [[-side, -side], [side, -side], [side, side], [-side, side]];
    let wall = corners.map(|[x, z]| {
        let corner = center + DVec3::new(x, half, z);
        corner.to_array().map(|c| c as f32)
    });
    scene.meshes.push(Mesh::quad(wall));
    let open = drawn(&scene, None);
    scene.effects.environment_shadows = 24;
    let picture = drawn(&scene, None);
    let found = compare(&frame(&scene, WIDTH, HEIGHT, 1).unwrap(), &picture);
    let rmse = found.rmse();
    assert!(found.inside > 5_000, "{} values", found.inside);
    assert!(rmse < 0.35 && found.worst < 6.0, "{rmse}, {}", found.worst);
    let without = compare(&frame(&scene, WIDTH, HEIGHT, 1).unwrap(), &open).rmse();
    assert!(without > 5.0 * rmse, "{without} {rmse}");
}

fn model(scene: &mut Scene, change: fn(&mut texmap_scene::MetallicRoughness)) {
    let models = scene.materials.iter_mut();
    models
        .filter_map(|material| material.metallic_roughness.as_mut())
        .for_each(change);
}

/// The reference picture of `--verify` is the limit of the renderer with many samples.
#[test]
fn the_reference_is_where_supersampling_leads() {
    let (mut off, size) = (Vec::new(), (120, 90));
    for file in scenes() {
        let scene = texmap_io::load_scene(&file, &LoadOptions::default()).unwrap();
        let settings = RenderSettings {
            supersample: 8,
            ..RenderSettings::new(size.0, size.1)
        };
        let scene = tessellate(scene, size.0).unwrap();
        let frame = render(&scene, &settings, &texmap_render::no_progress).unwrap();
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
            s.effects.background = None;
        }),
        ("stretched skies", "signs", |s| s.effects.background = None),
        ("mirrors", "mirrors", |s| all(s, |m| m.reflection = None)),
        ("specular maps", "mirrors", |s| {
            all(s, |m| m.specular_map = None);
        }),
        ("reliefs", "reliefs", |s| all(s, |m| m.normal_detail = None)),
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

/// The less usual words of the scene language, a few at a time, around a few things of every kind.
const RARE: [(&str, &str); 16] = [
    ("blinn", "highlight blinn\nsurf .6 .5 .4 1 1 .6 40\n"),
    (
        "lit at vertices",
        "shade vertex\nsurf .6 .5 .4 1 1 .6 12\ngouraud perspective\nspecmap TEX/lamps.png lat-long 20\n",
    ),
    (
        "lit at vertices, on the screen",
        "shade modulate vertex\ncel TEX/tones.png\n",
    ),
    (
        "objects' normals",
        "normalmap TEX/normals.png object down xy\n",
    ),
    (
        "tangents' normals, downwards",
        "normalmap TEX/normals.png tangent down xy\nhorizon open\n",
    ),
    ("mirrored", "scale -1 1 1\nnormalmap TEX/normals.png\n"),
    (
        "mirrored heights from behind",
        "scale 1 1 -1\nbump TEX/brick_heights.png -0.05\ncull back\n",
    ),
    (
        "uneven",
        "scale 1 .6 1.3\noffsetmap TEX/offsets.png 2 down\n",
    ),
    (
        "carved noise, folded waves",
        "carve waves .06 0 0 0 1 .3 1 around 7 fold .5\n",
    ),
    (
        "an octahedron of light",
        "env TEX/label.png octahedron .6 mips\nspecmap TEX/checker.png equal-area-octahedron 6\nsurf .3 .3 .3 1 1 .5 10\n",
    ),
    (
        "a mirror ball and paraboloids",
        "env TEX/face.png sphere-map .5\n",
    ),
    (
        "raw",
        "color raw\nbump TEX/brick_heights.png 0.05\nsurf .6 .5 .4 .7 .7 .6 12\n",
    ),
    (
        "a ramp with alpha",
        "ramp clear.png\nshade modulate pixel\n",
    ),
    ("a copied ramp with alpha", "ramp clear.png\n"),
    (
        "a blended ramp with alpha",
        "ramp clear.png\nalpha blend\nshade modulate pixel\n",
    ),
    (
        "voxels, nearest",
        "filter nearest\nwrap mirrored-repeat\nsolid TEX/cloud.npy 0 0 0 .7 .8 .9\n",
    ),
];

const THINGS: &str = "la .2 .2 .25\nld .5 .5 .4 -.5 -1 -.6\nls .6 .5 .5 1.5 2.5 2 -1.5 -2.5 -2 30 60\n\
    obj MODELS/ball_plain.obj\ntranslate 1.3 .1 -.4\nrotate 30 .2 1 0\ntexture TEX/uv_grid.png\nobj MODELS/cube_plain.obj\n\
    shade modulate pixel\nv -2.2 -.6 -1\nv -.7 -.6 -1.4\nv -.7 .9 -1.4\nv -2.2 .9 -1\ntf 0 0 1 1 1 1 2 1 0 3 0 0\n";

/// Lights and casters: each line is a scene's effects over a floor and a wall.
const CAST: [(&str, &str); 10] = [
    (
        "areas",
        "ld .6 .6 .5 -.5 -1 -.6\nshadow 1024 area 0 0 0 1.2\nlp .4 .4 .5 1 2 1.5\nshadow 512 area 0 -.5 0 1\n",
    ),
    (
        "a bias of its own",
        "ld .6 .6 .5 -.5 -1 -.6\nshadow 1024 slope .002\nls .5 .5 .5 1 2.4 1 -1 -2.4 -1 40 60\nshadow 1024 slope .001\n",
    ),
    (
        "a light all around",
        "lp .8 .8 .7 .2 1.6 .3\nshadow 256 taps 1\n",
    ),
    (
        "light beyond its picture",
        "projector TEX/label.png light 1 2 3 0 0 0 0 1 0 20 clamp\nprojector TEX/checker.png light -2 2 2 0 0 0 0 1 0 16 repeat color .4 .5 .6 shadow 512\n",
    ),
    (
        "soft light and paint",
        "projector TEX/face.png light 0 2 3 0 -.2 0 0 1 0 40 soft .2 shadow 512\nprojector TEX/label.png paint -2 1.5 2 0 0 0 0 1 0 40 shadow 512\n",
    ),
    (
        "shadowless and blended casters",
        "ld .7 .7 .6 -.5 -1 -.6\nshadow 1024\nshadowless yes\nobj MODELS/cube_plain.obj\nshadowless no\nalpha blend\ntranslate 1 .3 .3\nobj MODELS/ball_plain.obj\n",
    ),
    (
        "cut-outs at a threshold",
        "ld .7 .7 .6 -.3 -1 -.9\nshadow 1024 taps 1\ntexture TEX/leaf.png\nalpha test .3\nv -.9 -.5 .9\nv .9 -.5 .9\nv .9 .6 .7\nv -.9 .6 .7\nshade modulate\ntf 8 0 1 9 1 1 10 1 0 11 0 0\n",
    ),
    (
        "projectors on copied texels",
        "projector TEX/face.png light 0 2 3 0 -.2 0 0 1 0 40 soft .2 color .7 .8 .9 shadow 512\nprojector TEX/label.png paint -2 1.5 2 0 0 0 0 1 0 40 shadow 512\n\
         texture TEX/brick.png\nsurf .8 .75 .7 1 .9 .3 12\nbump TEX/brick_heights.png .03\nv -2.5 -.45 2.5\nv 2.5 -.45 2.5\nv 2.5 -.45 -1.5\nv -2.5 -.45 -1.5\n\
         tf 8 0 0 9 2 0 10 2 2 11 0 2\nbump none\nv -.4 -.4 .9\nv .4 -.4 .9\nv .4 .4 .7\nv -.4 .4 .7\ntexture TEX/leaf.png\ntf 12 0 1 13 1 1 14 1 0 15 0 0\n",
    ),
    (
        "projectors on texels over their surface",
        "projector TEX/checker.png light -2 2 2 0 0 0 0 1 0 30 repeat color .4 .5 .6\nprojector TEX/label.png paint 2 1.5 2 0 0 0 0 1 0 40\n\
         alpha opaque\ntexture TEX/label.png\nhighlight blinn\nv -2.5 -.4 -1\nv 2.5 -.4 -1\nv 2.5 1.8 -1\nv -2.5 1.8 -1\ntf 8 0 1 9 1 1 10 1 0 11 0 0\n",
    ),
    (
        "projectors on blended texels, raw",
        "color raw\nprojector TEX/face.png light 0 2 3 0 -.2 0 0 1 0 40 color .5 .5 .5\nprojector TEX/label.png paint -2 1.5 2 0 0 0 0 1 0 40\n\
         alpha blend\ntexture TEX/label.png\nframe -2 0 -.5 3 0 0 0 2 0\nv -2 -.4 -.5\nv 2 -.4 -.5\nv 2 1.4 -.5\nv -2 1.4 -.5\nff 8 9 10 11\n",
    ),
];

const ROOM: &str = "surf .8 .75 .7 1 1 .2 20\nv -3 -.5 3\nv 3 -.5 3\nv 3 -.5 -2\nv -3 -.5 -2\nf 0 1 2 3\n\
    v -3 -.5 -2\nv 3 -.5 -2\nv 3 2 -2\nv -3 2 -2\nf 4 5 6 7\npush\nscale .7\nobj MODELS/ball_plain.obj\npop\n";

#[test]
fn rare_words_are_drawn_as_rays_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    let folder = tempfile::tempdir().unwrap();
    // A row that is half clear at one end.
    image::RgbaImage::from_fn(8, 1, |x, _| {
        image::Rgba([100 + x as u8 * 10, 200, 90, 150 + x as u8 * 14])
    })
    .save(folder.path().join("clear.png"))
    .unwrap();
    let things = RARE.map(|(name, words)| (name, format!("{words}{THINGS}")));
    let rooms = CAST.map(|(name, words)| (name, format!("la .2 .2 .2\n{ROOM}{words}")));
    let mut off = Vec::new();
    for (name, text) in things.into_iter().chain(rooms) {
        let place = |word: &str| root.join(word).display().to_string();
        let text = text
            .replace("TEX", &place("textures"))
            .replace("MODELS", &place("models"));
        let file = folder.path().join("rare.scene");
        std::fs::write(
            &file,
            format!("eye .4 .8 3.4\nfov 50\nbackground .2 .3 .4\n{text}"),
        )
        .unwrap();
        let scene = texmap_io::load_scene(&file, &LoadOptions::default())
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let truth = frame(&scene, WIDTH, HEIGHT, 1).unwrap();
        let found = compare(&truth, &drawn(&scene, None));
        assert!(found.inside > 3_000, "{name}: {} inside", found.inside);
        if found.over > 0 {
            let (over, inside, worst) = (found.over, found.inside, found.worst);
            off.push(format!(
                "{name}: {over} of {inside} values differ, worst {worst}"
            ));
        }
    }
    assert!(off.is_empty(), "{}", off.join("\n"));
}
