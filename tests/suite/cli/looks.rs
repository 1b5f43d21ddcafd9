//! `texmap render`: looks in place of the input's own, stand-ins, and formats of files.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use texmap_sample::ColorSpace;

use crate::program::Desk;
use texmap_tests::exr_files;

#[test]
fn a_texture_of_ones_own_covers_what_has_none() {
    let desk = Desk::new();
    desk.put("bare.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    let halves = image::RgbaImage::from_fn(8, 8, |x, y| {
        image::Rgba(match (x < 4, y < 4) {
            (true, true) => [255, 0, 0, 255],
            (false, true) => [0, 255, 0, 255],
            (true, false) => [0, 0, 255, 255],
            (false, false) => [255, 255, 255, 255],
        })
    });
    halves.save(desk.path("halves.png")).unwrap();
    desk.texmap("render bare.obj --texture halves.png --view front --resolution 64x64 -o t.png")
        .ok();
    let picture = desk.picture("t.png");
    // v = 0 is the lower edge of an OBJ's picture.
    let strongest = |x, y| {
        let [r, g, b, _] = picture.get_pixel(x, y).0;
        [r, g, b].map(|c| c > 60)
    };
    assert_eq!(strongest(16, 16), [true, false, false]);
    assert_eq!(strongest(48, 16), [false, true, false]);
    assert_eq!(strongest(16, 48), [false, false, true]);
    // A warning tells that every surface has a picture.
    desk.put(
        "one.obj",
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl paper\nf 1/1 2/1 3/1\n",
    );
    let run = desk
        .texmap("render one.obj --texture halves.png --resolution 16x16 -o t.png")
        .ok();
    assert!(
        run.stderr.contains("a picture of its own"),
        "{}",
        run.stderr
    );
    desk.refused("render bare.obj --texture gone.png -o x.png", 4, "gone.png");
}

#[test]
fn every_look_is_another_picture() {
    let desk = Desk::new();
    let mut hashes = Vec::new();
    for look in [
        "",
        "--material unlit",
        "--material clay",
        "--material checker",
        "--material normals",
        "--material uv",
        "--wireframe",
    ] {
        let run = desk
            .texmap(&format!(
                "render m.obj --resolution 80x60 -o m.png --json {look}"
            ))
            .ok();
        hashes.push(
            run.json()["items"][0]["pixel_hash"]
                .as_str()
                .unwrap()
                .to_owned(),
        );
    }
    let count = hashes.len();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), count);
    // A face that looks at the front has the normal (0, 0, 1).
    desk.put(
        "flat.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
    );
    desk.texmap("render flat.obj --material normals --view front --resolution 60x60 -o n.png")
        .ok();
    assert_eq!(
        desk.picture("n.png").get_pixel(30, 12).0,
        [128, 128, 255, 255]
    );
    desk.refused("render m.obj --material gold -o x.png", 2, "clay");
}

#[test]
fn lost_maps_and_libraries_have_stand_ins() {
    let desk = Desk::new();
    desk.put("lost.obj", "mtllib lost.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n");
    let run = desk
        .texmap("render lost.obj --resolution 32x24 -o a.png")
        .ok();
    assert!(run.stderr.contains("lost.mtl"), "{}", run.stderr);
    desk.put("lost.mtl", "newmtl a\nmap_Kd lost.png\n");
    let draw = |flags: &str| {
        desk.texmap(&format!(
            "render lost.obj --view front --resolution 32x24 -o a.png {flags}"
        ))
    };
    let run = draw("").ok();
    assert!(
        run.stderr.contains("a magenta and black checker stands in"),
        "{}",
        run.stderr
    );
    let magenta = |p: &image::Rgba<u8>| p[0] > 100 && p[1] < 20 && p[2] > 100;
    assert!(desk.picture("a.png").pixels().any(magenta));
    let run = draw("--missing grey").ok();
    assert!(run.stderr.contains("grey stands in"), "{}", run.stderr);
    assert!(!desk.picture("a.png").pixels().any(magenta));
    assert_eq!(draw("--missing error").code, 4);
    assert_eq!(draw("--strict").code, 4);
    // Warnings that begin with the model name it once.
    desk.put("line.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n");
    let line = "line.obj: a line or point is not drawn";
    let run = desk
        .texmap("render line.obj --resolution 32x24 -o b.png")
        .ok();
    assert!(
        run.stderr.starts_with(&format!("warning: {line}")),
        "{}",
        run.stderr
    );
    // A scene's own word counts unless the command line has one.
    desk.put("soft.scene", "missing checker\nobj lost.obj\neye 0 0 5\n");
    desk.put("hard.scene", "obj lost.obj\neye 0 0 5\n");
    for (arguments, code) in [
        ("soft.scene", 0),
        ("hard.scene", 4),
        ("hard.scene --missing grey", 0),
        ("soft.scene --missing error", 4),
    ] {
        let run = desk.texmap(&format!("render {arguments} --resolution 16x12 -o s.png"));
        assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
    }
}

#[test]
fn the_ending_decides_and_a_wrong_one_is_refused() {
    let desk = Desk::new();
    let draw = |name: &str, flags: &str| {
        desk.texmap(&format!(
            "render room.scene --resolution 60x40 -o {name} {flags}"
        ))
        .ok()
    };
    draw("a.png", "");
    let plain = desk.picture("a.png");
    draw("a.webp", "");
    assert_eq!(desk.picture("a.webp"), plain, "lossless");
    draw("a.jpeg", "");
    let near = |a: &image::RgbaImage, b: &image::RgbaImage| {
        let sum: u64 = a
            .as_raw()
            .iter()
            .zip(b.as_raw())
            .map(|(a, b)| u64::from(a.abs_diff(*b)))
            .sum();
        sum as f64 / a.as_raw().len() as f64
    };
    assert!(near(&desk.picture("a.jpeg"), &plain) < 6.0);
    // Sixteen bits and floats hold more than eight and round to them.
    draw("b.png", "--bits 16");
    let deep = image::open(desk.path("b.png")).unwrap();
    assert_eq!(deep.color(), image::ColorType::Rgba16);
    let values: std::collections::BTreeSet<u16> =
        deep.to_rgba16().as_raw().iter().copied().collect();
    assert!(values.len() > 300, "{}", values.len());
    for (deep, byte) in deep.to_rgba16().as_raw().iter().zip(plain.as_raw()) {
        assert!((f64::from(*deep) / 257.0 - f64::from(*byte)).abs() < 0.51);
    }
    draw("a.exr", "--aov depth,face");
    assert!(!desk.path("a.depth.npy").exists(), "arrays lie in the file");
    let (texture, bits) =
        texmap_io::image_io::read_texture(&desk.path("a.exr"), ColorSpace::Srgb).unwrap();
    assert_eq!(bits, 32);
    let [light, ..] = texture.texel(0, 30, 30).unwrap();
    assert_eq!(
        texmap_math::color::linear_to_srgb8(light),
        plain.get_pixel(30, 30)[0]
    );
    for verb in [
        "render room.scene",
        "warp check.png",
        "env check.png --to cube",
        "slice marble",
        "bake room.scene --light --object all --size 8",
    ] {
        desk.refused(
            &format!("{verb} -o x.bmp"),
            2,
            "end the name with .png, .jpg, .webp, .hdr or .exr",
        );
    }
}

#[test]
fn inputs_come_from_lists_and_from_standard_input_and_names_have_folders() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("sub")).unwrap();
    desk.put("sub/k.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    desk.put("all.txt", "# two\nm.obj\nsub/k.obj\n");
    desk.texmap("render @all.txt --resolution 16x12 -o {dir}/{model}-small.png")
        .ok();
    assert!(desk.path("m-small.png").is_file() && desk.path("sub/k-small.png").is_file());
    desk.texmap("render @all.txt --resolution 16x12 -o new/deep/")
        .ok();
    assert!(desk.path("new/deep/k.png").is_file());
    desk.refused("render @gone.txt -o x/", 4, "gone.txt");
    let output = piped(
        &desk,
        "render - --resolution 16x12 -o -",
        &desk.read("sub/k.obj"),
    );
    assert!(output.status.success());
    assert_eq!(output.stdout, desk.read("new/deep/k.png"));
}

/// Runs the program with bytes on its standard input.
fn piped(desk: &Desk, arguments: &str, bytes: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
        .args(arguments.split(' '))
        .current_dir(desk.path(""))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(bytes).unwrap();
    child.wait_with_output().unwrap()
}

/// A model on standard input has the materials and maps of `--root`, and without it says where they would be looked for.
#[test]
fn a_piped_model_finds_its_files_under_the_root() {
    let desk = Desk::new();
    std::fs::create_dir_all(desk.path("m/maps")).unwrap();
    desk.put("m/a.obj", "mtllib maps/a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\n");
    desk.put("m/maps/a.mtl", "newmtl a\nmap_Kd a.png\n");
    image::RgbaImage::from_pixel(2, 2, image::Rgba([250, 20, 20, 255]))
        .save(desk.path("m/maps/a.png"))
        .unwrap();
    let drawn = "--resolution 16x12 --view front -o";
    desk.texmap(&format!("render m/a.obj {drawn} a.png")).ok();
    let model = desk.read("m/a.obj");
    let rooted = piped(&desk, &format!("render - --root m {drawn} -"), &model);
    let words = String::from_utf8_lossy(&rooted.stderr).into_owned();
    assert!(!words.contains("warning"), "{words}");
    assert_eq!(rooted.stdout, desk.read("a.png"));
    let bare = piped(&desk, &format!("render - {drawn} -"), &model);
    assert!(bare.status.success());
    let words = String::from_utf8_lossy(&bare.stderr).into_owned();
    assert_eq!(words.matches("--root DIR").count(), 1, "{words}");
    assert_ne!(bare.stdout, rooted.stdout);
    // A root without them is not told of itself, and nothing outside of it is read.
    let other = piped(&desk, &format!("render - --root . {drawn} -"), &model);
    let words = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(
        words.contains("no such file") && !words.contains("--root"),
        "{words}"
    );
    let scene = b"eye 0 0 5\nlook 0 0 0\nobj m/a.obj\n";
    let refused = piped(&desk, &format!("render - {drawn} -"), scene);
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(4));
    assert!(words.contains("m/a.obj: no such file"), "{words}");
    assert!(words.contains("--root DIR"), "{words}");
}

#[test]
fn demos_and_heat_pictures_are_of_any_format() {
    let desk = Desk::new();
    let other = image::RgbaImage::from_pixel(8, 8, image::Rgba([90, 20, 20, 255]));
    other.save(desk.path("a.png")).unwrap();
    let other = image::RgbaImage::from_fn(8, 8, |x, y| image::Rgba([90, (x * y) as u8, 20, 255]));
    other.save(desk.path("b.png")).unwrap();
    for ending in ["png", "jpg", "webp", "hdr", "exr"] {
        let found = desk.texmap(&format!("diff a.png b.png --heat heat.{ending}"));
        assert_eq!(found.code, 1, "{}", found.stderr);
    }
    let heat = desk.picture("heat.png");
    assert_eq!(
        image::open(desk.path("heat.webp")).unwrap().to_rgba8(),
        heat
    );
    let light = exr_files::read(&desk.path("heat.exr"));
    for (light, code) in light.pixels().zip(heat.pixels()) {
        for k in 0..3 {
            let wanted = texmap_math::color::srgb8_to_linear(code[k]);
            assert!((light[k] - wanted).abs() < 1e-6, "{light:?} {code:?}");
        }
    }
    desk.texmap("demo affine-checker -o d.webp").ok();
    desk.texmap("demo affine-checker -o d.png").ok();
    assert_eq!(
        image::open(desk.path("d.webp")).unwrap().to_rgba8(),
        desk.picture("d.png")
    );
}

#[test]
fn every_verb_reports_as_json_and_is_quiet_on_request() {
    let desk = Desk::new();
    desk.put("uv.txt", "0.5,0.5\n0.1,0.2\n");
    for (arguments, files) in [
        ("warp check.png --rotate 5 -o w.png", 1),
        ("sample check.png --uv uv.txt -o s.npy", 1),
        ("mip check.png -o m%d.png", 4),
        (
            "env check.png --from octahedron --to cube --size 8 -o e.png",
            1,
        ),
        ("slice noise --size 16 -o n.png", 1),
        (
            "bake room.scene --light --object all --size 8 -o b/{object}.png",
            1,
        ),
    ] {
        let run = desk.texmap(&format!("{arguments} --json --quiet")).ok();
        let report = run.json();
        assert_eq!(report["verb"], arguments.split(' ').next().unwrap());
        let written = report["files"].as_array().unwrap();
        assert_eq!(written.len(), files, "{arguments}");
        for file in written {
            assert!(
                desk.path(file["path"].as_str().unwrap()).is_file(),
                "{file}"
            );
        }
        assert!(run.stderr.is_empty(), "{}", run.stderr);
        desk.refused(
            &format!("{} -o - --json", arguments.split(" -o").next().unwrap()),
            2,
            "",
        );
    }
    let run = desk
        .texmap("render m.obj --resolution 16x12 -o q.png --quiet")
        .ok();
    assert!(run.stderr.is_empty(), "{}", run.stderr);
    assert!(
        desk.texmap("render gone.obj -o q.png --quiet")
            .stderr
            .contains("gone.obj"),
        "errors are said"
    );
}

#[test]
fn objects_of_scenes_have_names() {
    let desk = Desk::new();
    desk.put(
        "named.scene",
        "la 1 1 1\nname sky\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 1 0\ntexture check.png\ntf 0 0 0 1 1 0 2 1 1\nname floor\ntf 0 0 0 1 1 0 3 1 1\nname wall\nobj m.obj\nname chair\n",
    );
    let run = desk.texmap("bake named.scene --light --object sofa --size 8 -o x.png");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("floor, wall, chair.panel, chair.spike"),
        "{}",
        run.stderr
    );
    desk.texmap("bake named.scene --light --object floor --size 8 -o floor.png")
        .ok();
    desk.texmap("bake named.scene --light --object all --size 8 -o maps/{object}.png")
        .ok();
    assert!(desk.path("maps/wall.png").is_file() && desk.path("maps/chair.panel.png").is_file());
    let run = desk
        .texmap("bake room.scene --light --object all --size 8 -o only-{object}.png")
        .ok();
    assert!(run.stderr.contains("is left out"), "{}", run.stderr);
    desk.refused(
        "bake named.scene --light --object all --size 8 -o one.png",
        2,
        "{object}",
    );
}

#[test]
fn completions_and_manual_pages_name_every_verb() {
    let desk = Desk::new();
    for shell in ["bash", "zsh", "fish"] {
        let run = desk.texmap(&format!("completions {shell}")).ok();
        let text = String::from_utf8(run.stdout).unwrap();
        assert!(
            text.contains("uv-raster") && text.contains("turntable"),
            "{shell}"
        );
    }
    let run = desk.texmap("man").ok();
    assert!(
        String::from_utf8(run.stdout)
            .unwrap()
            .contains(".TH texmap 1")
    );
    desk.texmap("man -o man/man1").ok();
    let page = String::from_utf8(desk.read("man/man1/texmap-render.1")).unwrap();
    assert!(page.contains("turntable"));
    let page = String::from_utf8(desk.read("man/man1/texmap-batch-bake.1")).unwrap();
    assert!(page.contains("shard") && page.contains("object"));
    // Every page that a page names is there.
    let entries = std::fs::read_dir(desk.path("man/man1")).unwrap();
    let names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let mut named = 0;
    for name in &names {
        let text = String::from_utf8(desk.read(&format!("man/man1/{name}"))).unwrap();
        for line in text.lines().filter(|line| line.ends_with("(1)")) {
            let other = line.replace('\\', "").replace("(1)", ".1");
            assert!(
                names.contains(&other) || other.ends_with("-help.1"),
                "{name} names {other}"
            );
            named += 1;
        }
    }
    assert!(named > 30, "{named}");
    for name in ["texmap.1", "texmap-merge.1", "texmap-shards-render.1"] {
        assert!(names.iter().any(|page| page == name), "{name}");
    }
}
