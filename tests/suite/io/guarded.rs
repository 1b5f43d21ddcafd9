//! Reading what strangers wrote: special files, folders that confine, budgets, and messages that keep what is none of a
//! scene's business.

use std::fs;

use texmap_io::{CameraPath, FileSource, IoError, LoadOptions, info_with, load, npy};

use crate::support::Files;

/// Content of a file that a scene must not show.
const SECRET: &str = "root:x:0:0:hunter2\nlook at hunter2\nv hunter2\nf hunter2 2 3\n";

fn within(files: &Files, folder: &str) -> LoadOptions {
    LoadOptions {
        files: FileSource::within(&files.path(folder)).expect("a folder"),
        ..LoadOptions::default()
    }
}

#[track_caller]
fn silent(error: &IoError) {
    for line in [error.to_string(), error.help()] {
        assert!(!line.contains("hunter2"), "{line}");
    }
}

#[test]
fn a_root_holds_for_everything_that_a_scene_or_model_names() {
    let quad = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    let files = Files::new()
        .with("in/m.obj", format!("mtllib m.mtl\n{quad}"))
        .with_png("in/a.png", 4, 2, [9, 9, 9, 255])
        .with_png("out.png", 4, 2, [9, 9, 9, 255])
        .with("out.obj", quad)
        .with("out.mtl", "newmtl a\n")
        .with("out.scene", "v 0 0 0\n")
        .with("out.json", "[]")
        .with("in/m.mtl", "newmtl a\nmap_Kd a.png\n")
        .with("in/lib.obj", format!("mtllib ../out.mtl\n{quad}"))
        .with("in/map.mtl", "newmtl a\nmap_Kd ../out.png\n")
        .with("in/map.obj", format!("mtllib map.mtl\nusemtl a\n{quad}"));
    npy::write(&files.path("out.npy"), &[1, 1, 1], npy::Values::U8(&[9])).expect("an array");
    let absolute = files.path("out.png");
    let absolute = format!("texture \"{}\"", absolute.display());
    for line in [
        "texture ../out.png",
        &absolute,
        "texture ..\\out.png",
        "obj ../out.obj",
        "obj lib.obj",
        "obj map.obj",
        "include ../out.scene",
        "env ../out.png octahedron 1",
        "specmap ../out.png octahedron 1",
        "sky ../out.png",
        "solid ../out.npy 0 0 0 1 1 1",
        "volume ../out.npy 0 0 0 1 1 1 1",
        "bump ../out.png 1",
        "normalmap ../out.png",
        "offsetmap ../out.png 1",
        "displace ../out.png 1",
        "terrain ../out.png 0 0 0 1 1 1",
        "projector ../out.png light 0 3 0 0 0 0 0 0 1 40",
        "lightmap ../out.png",
        "lightmapuv ../out.obj\nobj m.obj",
        "ramp ../out.png",
        "cel ../out.png",
        "decal ../out.png",
        "font ../out.png 1 1 65",
    ] {
        let text = format!("missing warn\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n{line}\n");
        fs::write(files.path("in/a.scene"), text).expect("a scene");
        let scene = files.path("in/a.scene");
        let error = load(&scene, &within(&files, "in")).expect_err(line);
        // Maps that are outside are never stood in for, as missing ones are.
        assert_eq!(error.code(), "outside-root", "{line}: {error}");
        assert!(error.location().is_some(), "{line}");
        // The negative twin: in a wider folder the same name is read, or fails for another reason.
        if let Err(error) = load(&scene, &within(&files, ".")) {
            assert_ne!(error.code(), "outside-root", "{line}: {error}");
        }
    }
    // A file that a flag names is confined too, and the scene itself.
    let error = load(&files.path("out.obj"), &within(&files, "in")).expect_err("outside");
    assert_eq!(error.code(), "outside-root");
    let source = FileSource::within(&files.path("in")).expect("a folder");
    let error = CameraPath::read_from(&files.path("out.json"), &source).expect_err("outside");
    assert_eq!(error.code(), "outside-root");
    let listed = info_with(&files.path("in/m.obj"), &within(&files, "in")).expect("all inside");
    assert_eq!(listed.problems().count(), 0);
    let listed = info_with(&files.path("in/map.obj"), &within(&files, "in")).expect("a report");
    assert_eq!(listed.problems().count(), 1);
    // A report goes on behind what is outside.
    let text = "obj ../out.obj\nobj lib.obj\ntexture ../out.png\n";
    fs::write(files.path("in/a.scene"), text).expect("a scene");
    let listed = info_with(&files.path("in/a.scene"), &within(&files, "in")).expect("a report");
    let problems: Vec<_> = listed.problems().map(|f| f.path.clone()).collect();
    let names = ["in/../out.obj", "in/../out.mtl", "in/../out.png"];
    assert_eq!(problems, names.map(|name| files.path(name)));
}

#[test]
fn messages_keep_the_words_of_files_that_are_no_scenes() {
    let files = Files::new()
        .with("secret.txt", SECRET)
        .with("secret.scene", SECRET)
        .with("v.txt", "v hunter2\n")
        .with(
            "f.txt",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl hunter2\nhunter2\nf 1 2 3\n",
        )
        .with("number.txt", "12hunter2\n")
        .with("list.json", "[\"hunter2\"]")
        .with("key.json", "[{\"hunter2\": 1}]")
        .with("text.json", "{\"eye\": \"hunter2\"}")
        .with("three.scene", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n");
    for line in [
        "include secret.txt",
        "include secret.scene",
        "include v.txt",
        "include number.txt",
        "obj secret.txt",
        "obj v.txt",
        "texture secret.txt",
        "env secret.txt lat-long 1",
        "solid secret.txt 0 0 0 1 1 1",
        "font secret.txt 1 1 65",
        "lightmapuv secret.txt\nobj f.txt",
    ] {
        fs::write(files.path("a.scene"), format!("{line}\n")).expect("a scene");
        silent(&files.load("a.scene").expect_err(line));
    }
    for name in ["list.json", "key.json", "text.json", "secret.txt"] {
        silent(&CameraPath::read(&files.path(name)).expect_err(name));
    }
    silent(&npy::read(&files.path("secret.txt")).expect_err("no array"));
    let scene = files
        .with("a.scene", "obj f.txt\n")
        .load("a.scene")
        .expect("three corners of a text");
    assert!(scene.warnings.len() >= 2, "{:?}", scene.warnings);
    assert!(!scene.warnings.concat().contains("hunter2` is not known"));
    // The negative twin: a scene that begins like one is quoted, and so is a model by its name.
    let error = Files::new()
        .with("a.scene", "eye 0 0 6\nlok 0 0 0\n")
        .load("a.scene")
        .expect_err("lok");
    assert!(error.to_string().contains("`lok`") && error.help().contains("`look`"));
    // The first word of a scene is not quoted, and still there is help.
    let error = Files::new()
        .with("a.scene", "eyee 0 0 6\n")
        .load("a.scene")
        .expect_err("eyee");
    assert!(!error.to_string().contains("eyee") && error.help().contains("`eye`"));
}

#[test]
fn long_words_are_cut_and_terminals_are_not_commanded() {
    let word = "Q".repeat(100_000);
    for line in [
        format!("v 0 0 {word}"),
        format!("v 0 0 9{}", "9".repeat(100_000)),
        format!("f 0 0 {word}"),
        format!("filter {word}"),
        format!("{word} 1 2"),
        format!("texture {word}"),
    ] {
        let files = Files::new().with("a.scene", format!("eye 0 0 6\n{line}\n"));
        let text = files.load("a.scene").expect_err("nonsense").to_string();
        assert!(text.len() < 1000, "{} bytes", text.len());
        let longest = text
            .split(['`', ' '])
            .filter(|w| w.starts_with(['Q', '9']))
            .map(|w| w.chars().count())
            .max();
        assert!(longest.is_none_or(|n| n <= 201), "{longest:?} characters");
    }
    let files = Files::new().with("a.scene", "eye 0 0 6\nfilter \u{1b}]0;x\u{7}\n");
    let text = files.load("a.scene").expect_err("no filter").to_string();
    assert!(
        text.contains("\\u{1b}]0;x\\u{7}") && !text.contains('\u{1b}'),
        "{text}"
    );
    // Names of meshes and materials reach warnings, errors of the renderer, and tables.
    let model = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\no {word}\u{1b}\nf 1 2 3\n");
    let scene = Files::new()
        .with("a.obj", model)
        .load("a.obj")
        .expect("a triangle");
    assert_eq!(scene.meshes[0].name.chars().count(), 201);
}

#[test]
fn what_a_scene_has_read_again_and_again_is_limited() {
    // 400 includes of 12,500 lines are five million; one is nothing.
    let files = Files::new()
        .with("part.scene", "v 0 0 0\n".repeat(12_500))
        .with("a.scene", "include part.scene\n".repeat(400))
        .with(
            "b.scene",
            "include part.scene\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
        );
    let error = files.load("a.scene").expect_err("five million lines");
    assert_eq!(
        (error.code(), error.location().map(|p| p.line)),
        ("out-of-range", Some(336))
    );
    assert!(error.help().contains("million lines"), "{}", error.help());
    files.load("b.scene").expect("12,500 lines");
    // By bytes: comments of a megabyte.
    let files = Files::new()
        .with("part.scene", format!("# {}\n", "x".repeat(1 << 20)))
        .with("a.scene", "include part.scene\n".repeat(300));
    let error = files.load("a.scene").expect_err("300 MiB");
    assert_eq!(
        (error.code(), error.location().map(|p| p.line)),
        ("out-of-range", Some(256))
    );
    // Models: the first reading is free.
    let comment = format!("# {}\n", "x".repeat(1 << 22));
    let files = Files::new()
        .with(
            "m.obj",
            format!("{comment}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        )
        .with("a.scene", "obj m.obj\n".repeat(60))
        .with("b.scene", "obj m.obj\n".repeat(20));
    let error = files.load("a.scene").expect_err("240 MiB");
    assert_eq!(
        (error.code(), error.location().map(|p| p.line)),
        ("out-of-range", Some(33))
    );
    files.load("b.scene").expect("80 MiB");
}

#[cfg(unix)]
#[test]
fn arrays_that_are_too_large_are_refused_before_they_are_read() {
    use std::os::unix::fs::FileExt;
    let files = Files::new();
    let path = files.path("a.npy");
    let header = |shape: &str| {
        let dict = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        let dict = format!("{dict:<117}\n");
        [b"\x93NUMPY\x01\0\x76\0", dict.as_bytes()].concat()
    };
    // A hole of 5 GiB takes no space on the disk.
    let file = fs::File::create(&path).expect("a file");
    file.write_all_at(&header("(1342177280,)"), 0)
        .expect("a header");
    file.set_len(128 + (5 << 30)).expect("a hole");
    assert_eq!(
        npy::read(&path).expect_err("5 GiB").code(),
        "file-too-large"
    );
    // A grid is held against its own limit: a voxel takes more memory than an element.
    file.write_all_at(&header("(1024,1024,512)"), 0)
        .expect("a header");
    let error = texmap_io::read_grid(&path).expect_err("2^29 voxels");
    assert!(
        error.to_string().contains("at most 268435456 voxels"),
        "{error}"
    );
}
