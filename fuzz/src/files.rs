//! Files of every kind that texmap reads.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::Path;
use texmap_mesh::tessellate;

use texmap_io::{
    CameraList, CameraPath, FileSource, IoError, LightPath, LoadOptions, image_io, load_bytes,
    npy as array, read_environment, read_grid, scene_file,
};
use texmap_light::{EnvironmentLayout, Light};
use texmap_math::glam::DVec3;
use texmap_planner::{Budget, choose};
use texmap_render::{RenderSettings, render};
use texmap_sample::ColorSpace;
use texmap_scene::Scene;

/// A scene file: refused by name with its line, or printed, read again as the same, and drawn.
pub fn scene(bytes: &[u8]) {
    let name = Path::new("fuzz.scene");
    if let Ok(text) = std::str::from_utf8(bytes) {
        match scene_file::parse(name, text) {
            Ok(file) => {
                let printed = scene_file::print(&file);
                let again = scene_file::parse(name, &printed)
                    .unwrap_or_else(|e| panic!("{printed:?} is not read again: {e}"));
                assert!(file.commands().eq(again.commands()), "{text:?} {printed:?}");
            }
            Err(error) => named(&error, text),
        }
    }
    file(bytes, "fuzz.scene");
}

/// A model: refused by name, or drawn.
pub fn obj(bytes: &[u8]) {
    file(bytes, "fuzz.obj");
}

/// A glTF model, as JSON or GLB: refused by name, or drawn at rest and in motion.
pub fn gltf(bytes: &[u8]) {
    file(bytes, "fuzz.glb");
    let options = LoadOptions {
        time: Some(0.7),
        camera: Some("0".into()),
        ..LoadOptions::default()
    };
    if let Err(error) = load_bytes(Path::new("fuzz.gltf"), bytes.to_vec(), &options) {
        named(&error, "");
    }
}

/// A polygon file: refused by name, or drawn.
pub fn ply(bytes: &[u8]) {
    binary(bytes, "fuzz.ply");
}

/// A stereolithography file: refused by name, or drawn.
pub fn stl(bytes: &[u8]) {
    binary(bytes, "fuzz.stl");
}

/// A library of materials beside a model that uses it.
pub fn mtl(bytes: &[u8]) {
    let model = "mtllib fuzz.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n\
                 usemtl a\nf 1/1/1 2/2/1 3/3/1\nusemtl b\nf 1/1 2/2 3/3\n";
    in_folder(
        &[("fuzz.obj", model.as_bytes()), ("fuzz.mtl", bytes)],
        |folder| {
            image_io::write_png(
                &folder.join("a.png"),
                2,
                1,
                &[90, 200, 30, 255, 0, 0, 255, 40],
            )
            .expect("a picture");
            loaded(&folder.join("fuzz.obj"));
        },
    );
}

/// A picture: refused, or decoded to what its header says, as a texture and as an environment in any chart.
pub fn image(bytes: &[u8]) {
    in_folder(&[("fuzz.png", bytes)], |folder| {
        let path = folder.join("fuzz.png");
        match image_io::read_image(&path) {
            Ok(image) => {
                assert!(image.width > 0 && image.height > 0 && (1..=4).contains(&image.channels));
            }
            Err(error) => named(&error, ""),
        }
        for space in [ColorSpace::Srgb, ColorSpace::Linear] {
            match image_io::read_texture(&path, space) {
                Ok((texture, _)) => assert!(texture.width() > 0 && texture.height() > 0),
                Err(error) => named(&error, ""),
            }
        }
        for chart in EnvironmentLayout::ALL {
            match read_environment(&path, chart) {
                Ok(sky) => assert!(sky.radiance([0.3, 0.5, -0.2]).iter().all(|c| c.is_finite())),
                Err(error) => named(&error, ""),
            }
        }
    });
}

/// An array: refused, or as many values as its shape holds; a grid where it can be one.
pub fn npy(bytes: &[u8]) {
    in_folder(&[("fuzz.npy", bytes)], |folder| {
        let path = folder.join("fuzz.npy");
        match array::read(&path) {
            Ok(array) => {
                let values = match &array.data {
                    array::Data::F32(v) => v.len(),
                    array::Data::U8(v) => v.len(),
                    array::Data::U16(v) => v.len(),
                    array::Data::U32(v) => v.len(),
                };
                assert_eq!(array.shape.iter().product::<usize>(), values);
            }
            Err(error) => named(&error, ""),
        }
        if let Err(error) = read_grid(&path) {
            named(&error, "");
        }
    });
}

/// A camera path: refused by name, or cameras of finite places.
pub fn path(bytes: &[u8]) {
    in_folder(&[("fuzz.json", bytes)], |folder| {
        match CameraPath::read(&folder.join("fuzz.json")) {
            Ok(path) => {
                assert!(!path.keyframes().is_empty());
                let camera = texmap_math::Camera {
                    eye: DVec3::ZERO,
                    look: DVec3::NEG_Z,
                    up: DVec3::Y,
                    fov_x: 1.0,
                    near: 1e-4,
                    far: f64::INFINITY,
                    lens: Default::default(),
                };
                for (frame, frames) in [(0, 1), (0, 7), (3, 7), (6, 7), (9, 7), (0, 0)] {
                    let at = path.camera(&camera, frame, frames);
                    assert!(at.fov_x > 0.0 && at.fov_x < std::f64::consts::PI, "{at:?}");
                    // The renderer checks the view: eye and point may coincide.
                    let _ = at.view();
                }
            }
            Err(error) => named(&error, &String::from_utf8_lossy(bytes)),
        }
    });
}

/// A list of cameras: refused by name, or cameras with a view, as many as it names, at any shape of picture.
pub fn cameras(bytes: &[u8]) {
    in_folder(&[("fuzz.json", bytes)], |folder| {
        let path = folder.join("fuzz.json");
        let text = String::from_utf8_lossy(bytes);
        let list = match CameraList::read_from(&path, &FileSource::anywhere()) {
            Ok(list) => list,
            Err(error) => return named(&error, &text),
        };
        let count = list.names().len();
        assert!(count > 0);
        let base = texmap_math::Camera::look_at([0.0, 0.0, 5.0], [0.0; 3]);
        for (width, height) in [(640, 480), (1, 1), (16384, 1)] {
            match list.cameras(&base, width, height) {
                Ok(cameras) => {
                    assert_eq!(cameras.len(), count);
                    for place in cameras {
                        let aspect = f64::from(width) / f64::from(height);
                        assert!(place.camera.view().is_ok(), "{place:?}");
                        // A lens may still be refused, but by a name.
                        if let Err(error) = place.camera.clip_from_world(aspect) {
                            assert!(!error.to_string().is_empty());
                        }
                    }
                }
                Err(error) => named(&error, &text),
            }
        }
    });
}

/// An image for GPUs (DDS, KTX2): refused by name, or decoded to what its head says, and sampled from its blocks.
pub fn gpu_image(bytes: &[u8]) {
    // Files are told by their first bytes.
    in_folder(&[("fuzz.dds", bytes)], |folder| {
        let path = folder.join("fuzz.dds");
        let size = match image_io::read_image(&path) {
            Ok(image) => {
                assert!(image.width > 0 && image.height > 0 && (1..=4).contains(&image.channels));
                Some((image.width, image.height))
            }
            Err(error) => {
                named(&error, "");
                None
            }
        };
        for space in [ColorSpace::Srgb, ColorSpace::Linear] {
            let texture = match image_io::read_texture(&path, space) {
                Ok((texture, _)) => texture,
                Err(error) => {
                    named(&error, "");
                    continue;
                }
            };
            let (width, height) = (texture.width(), texture.height());
            assert_eq!(size, Some((width, height)));
            for level in 0..texture.levels() {
                let texel = texture.texel(level, 0, 0).expect("a texel of a level");
                let floats = texture.block_format().is_none();
                let plain = |c: &f32| floats || (-1.0..=1.0).contains(c);
                assert!(texel.iter().all(plain), "level {level}: {texel:?}");
            }
        }
    });
}

/// A path of a light: refused by name, or lights of every kind but the ambient one.
pub fn light_path(bytes: &[u8]) {
    in_folder(&[("fuzz.json", bytes)], |folder| {
        let path = folder.join("fuzz.json");
        let path = match LightPath::read_from(&path, &FileSource::anywhere()) {
            Ok(path) => path,
            Err(error) => return named(&error, &String::from_utf8_lossy(bytes)),
        };
        let (color, position) = ([0.5; 3], [0.0, 2.0, 1.0]);
        let moving = [
            Light::Directional {
                color,
                direction: [0.0, -1.0, 0.0],
            },
            Light::Point { color, position },
            Light::spot(color, position, [0.0, -1.0, 0.0], 30.0, 2.0),
        ];
        for (frame, frames) in [(0, 1), (0, 7), (3, 7), (6, 7), (9, 7), (0, 0)] {
            for light in &moving {
                let moved = path.light(light, frame, frames).expect("a light moves");
                assert_eq!(
                    std::mem::discriminant(&moved),
                    std::mem::discriminant(light)
                );
            }
            let ambient = Light::Ambient { color };
            assert!(path.light(&ambient, frame, frames).is_none());
        }
    });
}

/// A manifest of a batch: refused by a message, or units with ids of their own and a command line each.
pub fn manifest(bytes: &[u8]) {
    in_folder(&[("fuzz.json", bytes)], |folder| {
        let manifest = folder.join("fuzz.json");
        for (verb, more) in [
            ("render", &["-o", "out/{id}.png"][..]),
            ("render", &["--unit", "frame"]),
            ("render", &["--bands", "3"]),
            ("bake", &[]),
        ] {
            let mut words: Vec<OsString> = ["texmap", "batch", verb].map(OsString::from).into();
            words.push(manifest.clone().into_os_string());
            words.extend(more.iter().map(OsString::from));
            match texmap_cli::batch_units(&words) {
                Ok(units) => {
                    let ids: BTreeSet<&String> = units.iter().map(|(id, _)| id).collect();
                    assert_eq!(ids.len(), units.len());
                    for (_, words) in &units {
                        assert_eq!(words[..2], ["texmap", verb]);
                    }
                }
                Err(said) => assert!(!said.is_empty()),
            }
        }
    });
}

/// The report of a shard: refused by a message, or a batch of which every unit is there.
pub fn report(bytes: &[u8]) {
    in_folder(
        &[("fuzz.jsonl", bytes)],
        |folder| match texmap_cli::merged_units(&folder.join("fuzz.jsonl")) {
            Ok(units) => assert!(units <= bytes.len() as u64),
            Err(said) => assert!(!said.is_empty()),
        },
    );
}

/// A scene, and a budget of its first bytes: plans have finite prices, keep what they say and draw.
pub fn planner(bytes: &[u8]) {
    let [texels, rmse] = [0, 1].map(|i| f64::from(bytes.get(i).copied().unwrap_or(0)));
    let budget = Budget {
        texels: texels / 64.0,
        rmse: rmse / 1024.0,
    };
    in_folder(&[("fuzz.scene", bytes.get(2..).unwrap_or(&[]))], |folder| {
        let loaded = texmap_io::load(&folder.join("fuzz.scene"), &LoadOptions::default());
        let Some(Ok(scene)) = loaded.ok().map(|scene| tessellate(scene, 24)) else {
            return;
        };
        let mut scene = scene.into_owned();
        match choose(&scene, 24, 18, budget) {
            Ok(choices) => {
                for choice in &choices.meshes {
                    assert!(choice.price >= 0.0, "{choice:?}");
                    assert!(
                        choice.predicted_rmse >= 0.0 && choice.predicted_texels >= 0.0,
                        "{choice:?}"
                    );
                }
                choices.apply(&mut scene);
                picture(&scene);
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    });
}

fn file(bytes: &[u8], name: &str) {
    drawn(bytes, name, &String::from_utf8_lossy(bytes));
}

/// A file that is not made of lines.
fn binary(bytes: &[u8], name: &str) {
    drawn(bytes, name, "");
}

fn drawn(bytes: &[u8], name: &str, text: &str) {
    in_folder(&[(name, bytes)], |folder| {
        let path = folder.join(name);
        match texmap_io::load(&path, &LoadOptions::default()) {
            Ok(scene) => picture(&scene),
            Err(error) => named(&error, text),
        }
        // Reports on files have a result or an error, too.
        if let Err(error) = texmap_io::info(&path) {
            named(&error, text);
        }
    });
}

fn loaded(path: &Path) {
    match texmap_io::load(path, &LoadOptions::default()) {
        Ok(scene) => picture(&scene),
        Err(error) => assert!(!error.to_string().is_empty() && !error.code().is_empty()),
    }
}

fn in_folder(files: &[(&str, &[u8])], run: impl FnOnce(&Path)) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("a file in it");
    }
    run(folder.path());
}

fn picture(scene: &Scene) {
    let settings = RenderSettings {
        threads: Some(1),
        ..RenderSettings::new(24, 18)
    };
    let scene = match tessellate(scene, settings.width) {
        Ok(scene) => scene,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    match render(&scene, &settings, &texmap_render::no_progress) {
        Ok(frame) => assert_eq!(frame.rgba.len(), 24 * 18 * 4),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// An error has one line, a code, and a place within the text.
fn named(error: &IoError, text: &str) {
    assert!(!error.to_string().is_empty() && !error.code().is_empty());
    if let Some(place) = error.location().filter(|_| !text.is_empty()) {
        let lines = text.lines().count() as u32;
        assert!((1..=lines.max(1)).contains(&place.line), "{error}");
    }
}
