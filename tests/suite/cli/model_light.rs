//! Models under light from all around: their default, the environment behind them, their shadow on the ground, and `texmap env --prefilter`.

use image::{Rgb, Rgb32FImage, RgbaImage};

use crate::program::Desk;
use texmap_tests::exr_files;

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 5 6 7 8\nf 2 1 4 3\nf 6 2 3 7\nf 1 5 8 4\nf 8 7 3 4\nf 1 2 6 5\n";

fn desk() -> Desk {
    let desk = Desk::new();
    desk.put("cube.obj", format!("mtllib cube.mtl\nusemtl m\n{CUBE}"));
    desk.put(
        "cube.mtl",
        "newmtl m\nKd 0.7 0.7 0.7\nKs 0.5 0.5 0.5\nNs 60\n",
    );
    // Red at +X, dark elsewhere, and a little bright above.
    Rgb32FImage::from_fn(64, 32, |x, y| match (x, y) {
        (40..56, 8..24) => Rgb([4.0, 0.2, 0.2]),
        (_, 0..8) => Rgb([0.5, 0.5, 0.6]),
        _ => Rgb([0.05, 0.05, 0.05]),
    })
    .save(desk.path("sky.hdr"))
    .unwrap();
    desk
}

fn drawn(desk: &Desk, flags: &str) -> (RgbaImage, serde_json::Value) {
    let command = format!("render cube.obj --resolution 96x72 -o c.png --json {flags}");
    let run = desk.texmap(&command).ok();
    (desk.picture("c.png"), run.json()["items"][0].clone())
}

#[test]
fn models_are_metallic_roughness_and_scenes_are_not() {
    let desk = desk();
    let hash = |flags: &str| drawn(&desk, flags).1["pixel_hash"].clone();
    let default = hash("");
    assert_eq!(default, hash("--shading metallic-roughness --env neutral"));
    assert_eq!(default, hash("--tone-map pbr-neutral --exposure 1"));
    let classic = hash("--shading classic");
    assert_ne!(default, classic);
    assert_ne!(default, hash("--env sky.hdr"));
    // Raw colours are no light: they keep the classic model.
    assert_ne!(
        hash("--color raw"),
        hash("--color raw --shading metallic-roughness")
    );
    // The reference is of the same light as the picture: within the budget of `--quality good`.
    let judged = |flags: &str| {
        let words = "--resolution 32x24 -o v.png --verify --json";
        let run = desk
            .texmap(&format!("render cube.obj {words} {flags}"))
            .ok();
        let item = run.json()["items"][0].clone();
        item["truth"]["rmse"].as_f64().expect("a figure")
    };
    let own = judged("");
    assert!(own < 0.02, "{own}");
    let other = judged("--shading classic");
    assert!(other < 0.02, "{other}");
    desk.put(
        "cube.scene",
        "eye 0 0 6\nlook 0 0 0\nfov 40\nla 0.3 0.3 0.3\nld 0.6 0.6 0.6 0.2 -0.5 -1\nobj cube.obj\n",
    );
    let scene = |flags: &str| {
        let command = format!("render cube.scene --resolution 48x36 -o s.png --json {flags}");
        desk.texmap(&command).ok().json()["items"][0]["pixel_hash"].clone()
    };
    assert_eq!(scene(""), scene("--shading classic"));
    assert_ne!(scene(""), scene("--shading metallic-roughness"));
}

/// Up is up: the top of a cube that stands on its Z axis is lit as that of one that stands on Y.
#[test]
fn the_light_stands_on_the_axis_that_points_up() {
    let desk = desk();
    let (y, _) = drawn(&desk, "--view front");
    // Turned by hand: (x, y, z) to (x, -z, y).
    let turned: String = CUBE
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(numbers) => {
                let p: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
                format!("v {} {} {}\n", p[0], -p[2], p[1])
            }
            None => format!("{line}\n"),
        })
        .collect();
    desk.put("cube.obj", format!("mtllib cube.mtl\nusemtl m\n{turned}"));
    let (z, _) = drawn(&desk, "--view front --up z");
    let most = |a: &RgbaImage, b: &RgbaImage| {
        let each = a.as_raw().iter().zip(b.as_raw());
        each.map(|(a, b)| a.abs_diff(*b)).max()
    };
    assert!(most(&y, &z) <= Some(1), "{:?}", most(&y, &z));
    let (wrong, _) = drawn(&desk, "--view bottom");
    assert!(most(&y, &wrong) > Some(8));
}

#[test]
fn words_of_metallic_roughness_are_drawn_and_told_where_they_are_not() {
    let desk = desk();
    let hash = |flags: &str| drawn(&desk, flags).1["pixel_hash"].clone();
    let plain = hash("");
    let classic = hash("--shading classic");
    desk.put(
        "cube.mtl",
        "newmtl m\nKd 0.7 0.7 0.7\nKs 0.5 0.5 0.5\nNs 60\nPr 0.2\nPm 1\n",
    );
    let (_, metal) = drawn(&desk, "");
    assert!(metal["pixel_hash"] != plain && metal["warnings"].as_array().unwrap().is_empty());
    let (_, told) = drawn(&desk, "--shading classic");
    assert_eq!(told["pixel_hash"], classic);
    let warnings = told["warnings"].as_array().unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0]
            .as_str()
            .unwrap()
            .contains("1 material has metalness")
    );
}

#[test]
fn the_environment_is_seen_behind_a_model() {
    let desk = desk();
    let corner = |flags: &str| {
        let look = "--camera-eye -6,0,0 --camera-look 0,0,0 --fov 60";
        let (picture, _) = drawn(&desk, &format!("{look} {flags}"));
        picture.get_pixel(10, 36).0
    };
    let plain = corner("--env sky.hdr");
    let [r, g, b, a] = corner("--env sky.hdr --background env");
    assert_ne!(plain, [r, g, b, a]);
    // Toward +X it is red, and stays so where it is turned by a whole turn, and is not by half of one.
    assert!(a == 255 && r > 200 && r > g + 60 && g == b, "{r} {g} {b}");
    assert_eq!(
        corner("--env sky.hdr --background env --env-rotate 360"),
        [r, g, b, a]
    );
    let [back, ..] = corner("--env sky.hdr --background env --env-rotate 180");
    assert!(back < 90, "{back}");
    // The exposure and the curve of the model are those of what is behind it.
    let [dim, ..] = corner("--env sky.hdr --background env --exposure 0.05");
    assert!(dim < r - 40, "{dim}");
    assert_ne!(corner("--background env"), corner(""));
    desk.refused(
        "render cube.obj --env none --background env -o x.png",
        2,
        "--env neutral",
    );
    desk.refused(
        "render cube.obj --orthographic --background env -o x.png",
        4,
        "environment behind",
    );
}

#[test]
fn a_shadow_lies_on_the_ground_under_a_model() {
    let desk = desk();
    let (none, _) = drawn(&desk, "--background transparent");
    let (shadow, report) = drawn(&desk, "--background transparent --ground-shadow");
    // The model itself is as it was; around its foot something dark and half clear is there.
    let mut soft = 0;
    for (a, b) in none.pixels().zip(shadow.pixels()) {
        match (a.0[3], b.0[3]) {
            (255, _) => assert_eq!(a, b),
            (0, 1..=254) => {
                assert_eq!(b.0[..3], [0; 3]);
                soft += 1;
            }
            _ => {}
        }
    }
    assert!(soft > 300, "{soft}");
    assert_eq!(report["pictures"][0]["meshes"].as_array().unwrap().len(), 1);
    // From below there is no ground, and the camera does not move for it.
    let below = "--view bottom --background transparent";
    assert_eq!(
        drawn(&desk, below).0,
        drawn(&desk, &format!("{below} --ground-shadow")).0
    );
    // Arrays do not know it.
    drawn(&desk, "--aov depth");
    let depth = desk.read("c.depth.npy");
    drawn(&desk, "--aov depth --ground-shadow");
    assert_eq!(desk.read("c.depth.npy"), depth);
}

/// A parallel camera cuts nothing of the ground: beside the model its shadow begins faintly.
#[test]
fn the_ground_is_whole_under_parallel_rays() {
    let desk = desk();
    for view in ["", "--view iso"] {
        let flags = format!("--orthographic {view} --background transparent");
        let (model, _) = drawn(&desk, &flags);
        let (picture, _) = drawn(&desk, &format!("{flags} --ground-shadow"));
        let alpha = |picture: &RgbaImage, x, y| picture.get_pixel(x, y).0[3];
        let beside = (0..96).filter(|x| (0..72).all(|y| alpha(&model, *x, y) == 0));
        let mut soft = 0;
        for x in beside {
            let mut rows = (0..72).map(|y| alpha(&picture, x, y));
            if let Some(first) = rows.find(|alpha| *alpha > 0) {
                soft += 1;
                assert!(first < 30, "{view}: {first} in column {x}");
            }
        }
        assert!(soft > 12, "{view}: {soft}");
    }
}

/// Under its own shadows a model is darker in its corners and nowhere brighter; a lone convex body stays as it is.
#[test]
fn the_light_from_all_around_casts_shadows() {
    let desk = desk();
    let (open, _) = drawn(&desk, "");
    let (shadowed, _) = drawn(&desk, "--env-shadows 64");
    let off = |a: &RgbaImage, b: &RgbaImage| {
        let each = a.pixels().zip(b.pixels());
        each.map(|(a, b)| i32::from(a.0[1]) - i32::from(b.0[1]))
            .fold((0, 0), |(less, more), d| (less.max(-d), more.max(d)))
    };
    let (darker, brighter) = off(&open, &shadowed);
    assert!(darker <= 3 && brighter <= 3, "{darker} {brighter}");
    // A roof over the cube.
    let roof = format!("{CUBE}v -3 1.5 -3\nv 3 1.5 -3\nv 3 1.5 3\nv -3 1.5 3\nf 12 11 10 9\n");
    desk.put("cube.obj", format!("mtllib cube.mtl\nusemtl m\n{roof}"));
    let (open, _) = drawn(&desk, "");
    let (shadowed, _) = drawn(&desk, "--env-shadows 64");
    let (brighter, darker) = off(&open, &shadowed);
    assert!(darker > 40 && brighter <= 3, "{darker} {brighter}");
    assert_ne!(shadowed, drawn(&desk, "--env-shadows 16").0);
    assert_eq!(open, drawn(&desk, "--env-shadows 0").0);
    desk.refused("render cube.obj --env-shadows 257 -o x.png", 2, "256");
    for flags in ["--env-shadows 64", "--env-rotate 90"] {
        let (_, report) = drawn(&desk, &format!("--env none {flags}"));
        let flag = flags.split(' ').next().unwrap();
        assert!(report["warnings"].to_string().contains(flag), "{report}");
    }
    let (_, report) = drawn(&desk, "--env-rotate 90");
    assert!(
        !report["warnings"].to_string().contains("--env-rotate"),
        "{report}"
    );
}

#[test]
fn a_prefiltered_environment_is_files_of_powers_of_two() {
    let desk = desk();
    let run = desk
        .texmap("env sky.hdr --prefilter ggx --size 16 -o out/sky.exr --json")
        .ok();
    let files = run.json()["files"].clone();
    let name = |i: usize| files[i]["path"].as_str().unwrap().to_owned();
    let shape = |i: usize| files[i]["shape"].clone();
    let names: Vec<String> = (0..5).map(name).collect();
    let expected = ["level0", "level1", "level2", "irradiance", "brdf"];
    assert_eq!(
        names,
        expected.map(|middle| format!("out/sky.{middle}.exr"))
    );
    assert_eq!(shape(1), serde_json::json!([48, 8]));
    assert_eq!(shape(4), serde_json::json!([128, 128]));
    // Level 0 is the environment, the last its roughest mean: red toward +X in both, less so in the latter.
    let red = |name: &str| {
        let picture = exr_files::read(&desk.path(name));
        let side = picture.width();
        picture.get_pixel(side / 2, side / 2).0[0]
    };
    let (sharp, rough) = (red("out/sky.level0.exr"), red("out/sky.level2.exr"));
    assert!(
        (sharp - 4.0).abs() < 0.1 && rough < 3.0 && rough > 0.5,
        "{sharp} {rough}"
    );
    desk.texmap("env sky.hdr --prefilter ggx --size 16 --levels 2 --faces files -o f.hdr")
        .ok();
    for name in [
        "f.level0.px.hdr",
        "f.level1.nz.hdr",
        "f.irradiance.py.hdr",
        "f.brdf.hdr",
    ] {
        assert!(desk.path(name).is_file(), "{name}");
    }
    desk.texmap("env sky.hdr --to cube --size 8 --faces cross -o cross.png")
        .ok();
    assert_eq!(desk.picture("cross.png").dimensions(), (32, 24));
    desk.refused(
        "env sky.hdr --prefilter ggx --size 24 -o x.exr",
        2,
        "power of two",
    );
    desk.refused(
        "env sky.hdr --prefilter ggx --size 16 --levels 9 -o x.exr",
        2,
        "5 are the most",
    );
    desk.refused("env sky.hdr --prefilter ggx -o x.png", 2, ".exr or .hdr");
    desk.refused("env sky.hdr --prefilter ggx -o -", 2, "several files");
    desk.refused(
        "env sky.hdr --to lat-long --faces cross -o x.exr",
        2,
        "six faces",
    );
    desk.refused("env sky.hdr -o x.exr", 2, "--to");
}

/// Lights as Blender writes them, 683 lumens for each watt: the picture is that of watts, and tells so. An exposure of one's own
/// draws the file as it stands.
#[test]
fn lights_in_lumens_do_not_make_all_white() {
    let desk = Desk::new();
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/gltf");
    for name in ["plates.bin", "leaf card.png"] {
        desk.put(name, std::fs::read(assets.join(name)).unwrap());
    }
    let text = std::fs::read_to_string(assets.join("plates.gltf")).unwrap();
    let lit_by = |lux: f64| {
        let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
        let sun = serde_json::json!({ "type": "directional", "intensity": lux });
        file["extensions"] = serde_json::json!({ "KHR_lights_punctual": { "lights": [sun] } });
        file["extensionsUsed"] = serde_json::json!(["KHR_lights_punctual"]);
        let nodes = file["nodes"].as_array_mut().unwrap();
        nodes.push(serde_json::json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        let node = nodes.len() - 1;
        file["scenes"][0]["nodes"]
            .as_array_mut()
            .unwrap()
            .push(node.into());
        desk.put("sun.gltf", file.to_string());
    };
    let drawn = |flags: &str| {
        let command = format!("render sun.gltf --resolution 64x48 -o s.png --json {flags}");
        let run = desk.texmap(&command).ok();
        let item = run.json()["items"][0].clone();
        let told = item["warnings"].to_string().contains("683 times darker");
        (item["pixel_hash"].clone(), told)
    };
    lit_by(2.0);
    let (watts, told) = drawn("");
    assert!(!told);
    lit_by(2.0 * 683.0);
    assert_eq!(drawn(""), (watts.clone(), true));
    let (white, told) = drawn("--exposure 1");
    assert!(white != watts && !told);
}
