//! `texmap render`: pictures, arrays, sheets, walks and what the flags change.

use texmap_io::npy::{self, Data};

use crate::program::{Desk, Run, run};

fn pixels(desk: &Desk, name: &str) -> image::RgbaImage {
    image::load_from_memory(&desk.read(name))
        .unwrap()
        .into_rgba8()
}

fn hash(run: Run) -> String {
    run.ok().json()["items"][0]["pixel_hash"]
        .as_str()
        .unwrap()
        .to_owned()
}

#[test]
fn a_scene_and_a_model_become_pictures_and_say_so() {
    let desk = Desk::new();
    for input in ["room.scene", "m.obj"] {
        let run = desk
            .texmap(&format!("render {input} --resolution 64,48 -o out.png"))
            .ok();
        assert!(run.stdout.is_empty(), "standard output is for data");
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        assert!(
            run.stderr.starts_with("out.png: 64 x 48 pixels") && run.stderr.contains(" s\n"),
            "{}",
            run.stderr
        );
        let picture = pixels(&desk, "out.png");
        assert_eq!(picture.dimensions(), (64, 48));
        let first = picture.get_pixel(0, 0);
        assert!(
            picture.pixels().filter(|p| *p != first).count() > 64 * 48 / 10,
            "{input} draws nothing"
        );
    }
}

/// The house with its texture and the cube of the assets, as PLY and STL.
#[test]
fn polygon_and_stereolithography_files_become_pictures() {
    let desk = Desk::new();
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models");
    for name in ["house.ply", "cube.stl"] {
        let input = assets.join(name).display().to_string();
        let run = desk.texmap(&format!(
            "render {input} --resolution 64x48 -o out.png --json"
        ));
        let json = run.ok().json();
        let found = json["items"][0]["scene"]["triangles"].as_u64().unwrap();
        assert!(found > 10, "{name}: {found}");
        let picture = pixels(&desk, "out.png");
        let first = picture.get_pixel(0, 0);
        let drawn = picture.pixels().filter(|p| *p != first).count();
        assert!(drawn > 64 * 48 / 10, "{name} draws nothing");
        let info = desk.texmap(&format!("info {input} --json")).ok().json();
        assert_eq!(info["kind"].as_str(), name.rsplit('.').next());
    }
    desk.put("points.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n");
    let run = desk.texmap("render points.ply -o out.png");
    assert!(
        run.code != 0 && run.stderr.contains("point-cloud"),
        "{}",
        run.stderr
    );
}

/// New coordinates in another folder: the materials beside the old file are still found.
#[test]
fn coordinates_written_elsewhere_keep_their_materials() {
    let desk = Desk::new();
    std::fs::create_dir_all(desk.path("in")).unwrap();
    std::fs::create_dir_all(desk.path("out/deep")).unwrap();
    desk.put("in/a.mtl", "newmtl red\nKd 1 0 0\n");
    desk.put(
        "in/a.obj",
        "# kept\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n",
    );
    desk.texmap("uv in/a.obj --map box -o out/deep/b.obj").ok();
    let text = String::from_utf8(desk.read("out/deep/b.obj")).unwrap();
    assert!(
        text.starts_with("# kept\nmtllib ../../in/a.mtl\nv 0 0 0\n"),
        "{text}"
    );
    let info = desk.texmap("info out/deep/b.obj --json").ok().json();
    assert_eq!(info["meshes"][0]["material"], "red");
    desk.texmap("uv in/a.obj --map box -o in/b.obj").ok();
    assert!(
        String::from_utf8(desk.read("in/b.obj"))
            .unwrap()
            .contains("\nmtllib a.mtl\n")
    );
}

#[test]
fn several_inputs_fill_a_folder_and_one_bad_one_stops_no_other() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("out")).unwrap();
    let run = desk.texmap("render room.scene no.scene m.obj --resolution 32x24 -o out --json");
    assert_eq!(run.code, 3, "{}", run.stderr);
    let items = run.json()["items"].as_array().unwrap().clone();
    let statuses: Vec<&str> = items
        .iter()
        .map(|i| i["status"].as_str().unwrap())
        .collect();
    assert_eq!(statuses, ["ok", "failed", "ok"]);
    assert_eq!(items[1]["error"]["code"], "file-missing");
    assert!(desk.path("out/room.png").is_file() && desk.path("out/m.png").is_file());
    let run = desk
        .texmap("render room.scene m.obj --resolution 32x24 -o p-{model}.png")
        .ok();
    assert_eq!(run.stderr.lines().count(), 2);
    assert!(desk.path("p-room.png").is_file() && desk.path("p-m.png").is_file());
    assert_eq!(
        desk.texmap("render no.scene gone.obj --resolution 32x24 -o out")
            .code,
        4
    );
}

#[test]
fn a_dash_is_standard_output() {
    let desk = Desk::new();
    let run = desk
        .texmap("render room.scene --resolution 32x24 -o -")
        .ok();
    desk.texmap("render room.scene --resolution 32x24 -o out.png")
        .ok();
    assert_eq!(run.stdout, desk.read("out.png"));
}

#[test]
fn arrays_stand_beside_the_picture() {
    let desk = Desk::new();
    desk.texmap("render room.scene --resolution 48x32 -o room.png --aov depth,inv_w,uv,lod,face,normal,position").ok();
    for (name, channels) in [
        ("depth", 1),
        ("inv_w", 1),
        ("uv", 2),
        ("lod", 1),
        ("face", 1),
        ("normal", 3),
        ("position", 3),
    ] {
        let array = npy::read(&desk.path(&format!("room.{name}.npy"))).unwrap();
        assert_eq!(array.shape, [32, 48, channels], "{name}");
        let holes = match &array.data {
            Data::F32(values) if name != "face" => values.iter().filter(|v| v.is_nan()).count(),
            Data::U32(values) if name == "face" => {
                values.iter().filter(|v| **v == u32::MAX).count()
            }
            other => panic!("{name}: {other:?}"),
        };
        // The upper corners are empty, the floor covers the lower half.
        let pixels = 48 * 32 * channels;
        assert!(
            holes > pixels / 10 && holes < pixels / 2 + pixels / 4,
            "{name}: {holes} holes of {pixels}"
        );
    }
    // Rows run from top to bottom and columns from left to right: position y grows upwards, x to the right.
    let array = npy::read(&desk.path("room.position.npy")).unwrap();
    let Data::F32(position) = array.data else {
        panic!("f32")
    };
    let at = |x: usize, y: usize| &position[(y * 48 + x) * 3..][..3];
    assert!(at(10, 31)[0] < 0.0 && at(40, 31)[0] > 0.0);
    assert!(
        at(24, 31)[2] > at(24, 28)[2],
        "nearer floor is lower in the picture"
    );
    // uv is as interpolated, not wrapped: it reaches 4.
    let Data::F32(uv) = npy::read(&desk.path("room.uv.npy")).unwrap().data else {
        panic!("f32")
    };
    assert!(uv.iter().any(|v| *v > 2.0));
}

#[test]
fn a_sheet_shows_every_view_once() {
    let desk = Desk::new();
    let run = desk
        .texmap("render m.obj --views front,right,top,iso --resolution 80x60 -o sheet.png --json")
        .ok();
    let item = &run.json()["items"][0];
    let views: Vec<&str> = item["cameras"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["view"].as_str().unwrap())
        .collect();
    assert_eq!(views, ["front", "right", "top", "iso"]);
    let picture = pixels(&desk, "sheet.png");
    assert_eq!(
        (u64::from(picture.width()), u64::from(picture.height())),
        (
            item["width"].as_u64().unwrap(),
            item["height"].as_u64().unwrap()
        )
    );
    assert!(picture.width() > 160 && picture.height() > 120);
}

#[test]
fn a_walk_gives_numbered_frames_and_its_ends_stand_on_the_stops() {
    let desk = Desk::new();
    desk.put(
        "w.json",
        r#"[{"eye":[0,1,6],"look":[0,1,0]},{"eye":[1,1,5],"look":[0,1,0],"fov":50}]"#,
    );
    let run = desk.texmap("render room.scene --path w.json --frames 3 --resolution 32x24 --aov face -o w%04d.png --json").ok();
    let items = run.json()["items"].as_array().unwrap().clone();
    assert_eq!(items.len(), 3);
    for (number, item) in items.iter().enumerate() {
        assert_eq!(item["frame"], number);
        assert_eq!(item["output"], format!("w{number:04}.png"));
        assert!(desk.path(&format!("w{number:04}.face.npy")).is_file());
    }
    assert_ne!(desk.read("w0000.png"), desk.read("w0001.png"));
    // Frame 0 is the scene's own camera, the last one the second stop given by flags.
    desk.texmap("render room.scene --resolution 32x24 -o first.png")
        .ok();
    desk.texmap("render room.scene --resolution 32x24 --camera-eye 1,1,5 --fov 50 -o last.png")
        .ok();
    assert_eq!(desk.read("w0000.png"), desk.read("first.png"));
    assert_eq!(desk.read("w0002.png"), desk.read("last.png"));
}

#[test]
fn no_pixel_depends_on_threads_or_level() {
    let desk = Desk::new();
    let draw = |flags: &str| {
        desk.texmap(&format!(
            "render room.scene --resolution 200x150 -o out.png --json {flags}"
        ))
    };
    let expected = hash(draw(""));
    for threads in [1, 2, 3, 7] {
        assert_eq!(
            hash(draw(&format!("--threads {threads}"))),
            expected,
            "{threads} threads"
        );
    }
    let mut levels = 0;
    for level in ["avx512", "avx2", "sse4.2", "sse2", "fallback"] {
        let run = draw(&format!("--level {level}"));
        // A level that this processor lacks is refused by name, never replaced.
        if run.code == 2 {
            assert!(run.stderr.contains(level), "{}", run.stderr);
            continue;
        }
        assert_eq!(run.json()["settings"]["level"], level);
        assert_eq!(hash(run), expected, "{level}");
        levels += 1;
    }
    assert!(levels >= 1, "no level could be named");
    assert!(draw("--level fallback").code == 0);
    assert_ne!(
        hash(draw("--interp affine")),
        expected,
        "the hash sees a change"
    );
}

#[test]
fn every_flag_changes_the_picture_it_names() {
    let desk = Desk::new();
    let draw = |flags: &str| {
        hash(desk.texmap(&format!(
            "render room.scene --resolution 160x120 -o out.png --json {flags}"
        )))
    };
    let plain = draw("");
    for flags in [
        "--interp affine",
        "--interp span:16",
        "--interp subdivided:2",
        "--filter nearest",
        "--filter bilinear",
        "--filter bicubic:mitchell",
        "--filter anisotropic:16",
        "--wrap clamp-to-edge",
        "--wrap mirrored-repeat",
        "--supersample 2",
        "--background #204060",
        "--background transparent",
        "--color raw",
        "--camera-eye -1,1,6",
        "--camera-look 0,1.5,0",
        "--camera-up 1,1,0",
        "--fov 50",
    ] {
        assert_ne!(draw(flags), plain, "{flags}");
    }
    assert_eq!(draw("--interp perspective"), plain);
    assert_eq!(draw("--color srgb"), plain);
    assert_eq!(draw("--camera-eye 0,1,6 --fov 60"), plain);
}

#[test]
fn backgrounds_are_srgb_values_and_transparency_is_kept() {
    let desk = Desk::new();
    for (flag, expected) in [
        ("#204060", [0x20, 0x40, 0x60, 255]),
        ("0,0.5,1", [0, 128, 255, 255]),
        ("transparent", [0; 4]),
    ] {
        desk.texmap(&format!(
            "render room.scene --resolution 32x24 --background {flag} -o out.png"
        ))
        .ok();
        assert_eq!(
            pixels(&desk, "out.png").get_pixel(0, 0).0,
            expected,
            "{flag}"
        );
    }
}

#[test]
fn a_dry_run_checks_everything_and_writes_nothing() {
    let desk = Desk::new();
    let before = desk.names();
    let run = desk
        .texmap("render room.scene m.obj --resolution 64x48 --aov uv --dry-run -o {model}.png")
        .ok();
    let text = String::from_utf8(run.stdout).unwrap();
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(
        text.contains("room.scene -> room.png: 64 x 48 pixels") && text.contains("MB"),
        "{text}"
    );
    assert_eq!(desk.names(), before);
    // Without a name too, and it finds what a run would find.
    desk.texmap("render room.scene --dry-run").ok();
    assert_eq!(desk.texmap("render no.scene --dry-run").code, 4);
    assert_eq!(
        desk.texmap("render room.scene --dry-run -o m.obj/out.png")
            .code,
        4
    );
    let plan = desk
        .texmap("render room.scene --dry-run --json")
        .ok()
        .json();
    assert_eq!(plan["items"][0]["status"], "planned");
    assert!(plan["items"][0]["memory_bytes"].as_u64().unwrap() > 1024 * 768 * 4);
}

#[cfg(unix)]
#[test]
fn a_device_is_written_through_and_a_link_stays_a_link() {
    let desk = Desk::new();
    desk.texmap("render room.scene --resolution 32x24 -o /dev/null")
        .ok();
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    std::os::unix::fs::symlink(desk.path("real.png"), desk.path("link.png")).unwrap();
    desk.put("real.png", "old");
    desk.texmap("render room.scene --resolution 32x24 -o link.png")
        .ok();
    assert!(desk.path("link.png").is_symlink());
    assert!(desk.read("real.png").starts_with(b"\x89PNG"));
}

#[test]
fn help_and_version_are_answers() {
    let desk = Desk::new();
    for arguments in [
        ["--help"].as_slice(),
        &["render", "--help"],
        &["--version"],
        &["help", "render"],
    ] {
        let run = run(&desk.path("."), arguments).ok();
        assert!(!run.stdout.is_empty() && run.stderr.is_empty());
    }
}

/// A GLB by its own camera and at times of its animation; what it does not have is named.
#[test]
fn a_gltf_model_is_drawn_by_its_camera_and_at_a_time() {
    let desk = Desk::new();
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/gltf");
    for name in ["box.glb", "bent.glb"] {
        desk.put(name, std::fs::read(folder.join(name)).unwrap());
    }
    let at = |more: &str| {
        hash(desk.texmap(&format!(
            "render {more} --resolution 64x48 -o out.png --json"
        )))
    };
    let hashes = [
        at("box.glb"),
        at("box.glb --camera front"),
        at("bent.glb"),
        at("bent.glb --time 1"),
        at("bent.glb --time 1 --animation jump"),
    ];
    assert_eq!(hashes[1], at("box.glb --camera 0"));
    assert_eq!(
        hashes[2],
        at("bent.glb --time 0"),
        "the first key is the pose at rest"
    );
    assert_eq!(hashes[2], hashes[4], "a step waits");
    let different: std::collections::BTreeSet<_> = hashes.iter().collect();
    assert_eq!(different.len(), 4);
    let run = desk.texmap("render box.glb --camera back -o out.png");
    assert!(
        run.code != 0
            && run.stderr.contains("has no camera 'back'")
            && run.stderr.contains("0 'front'"),
        "{}",
        run.stderr
    );
    desk.put(
        "cut.glb",
        &std::fs::read(folder.join("box.glb")).unwrap()[..100],
    );
    let run = desk.texmap("render cut.glb -o out.png");
    assert!(
        run.code != 0 && run.stderr.contains("broken-gltf"),
        "{}",
        run.stderr
    );
    let run = desk.texmap("render box.glb --time soon -o out.png");
    assert_eq!(run.code, 2, "{}", run.stderr);
}
