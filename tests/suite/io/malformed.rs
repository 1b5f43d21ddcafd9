//! Broken files: each is refused with a code and the position of the fault, before anything is drawn.

use std::fs;

use texmap_io::{CameraPath, IoError, npy};

use crate::support::Files;

const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// The error of loading `name` must have this code, and this file, line and column, or name this file.
#[track_caller]
fn refused(files: &Files, name: &str, code: &str, place: (&str, u32, u32)) {
    let error = files.load(name).expect_err("a broken file must be refused");
    assert_code(&error, code);
    let expected = format!("{}:{}:{}", files.path(place.0).display(), place.1, place.2);
    assert_eq!(
        error.location().map(ToString::to_string),
        Some(expected.clone()),
        "{error}"
    );
    assert!(error.to_string().starts_with(&expected), "{error}");
}

/// As `refused`, where the fault is the whole file.
#[track_caller]
fn refused_whole(files: &Files, name: &str, code: &str) {
    let error = files.load(name).expect_err("a broken file must be refused");
    assert_code(&error, code);
    assert!(
        error
            .to_string()
            .starts_with(&files.path(name).display().to_string()),
        "{error}"
    );
}

#[track_caller]
fn assert_code(error: &IoError, code: &str) {
    assert_eq!(error.code(), code, "{error}");
    for line in [error.to_string(), error.help()] {
        assert!(
            !line.is_empty() && !line.contains('\n'),
            "one line each: {line:?}"
        );
    }
}

fn scene(text: &str) -> Files {
    Files::new().with("a.scene", text)
}

fn obj(text: &str) -> Files {
    Files::new().with("a.obj", text)
}

#[test]
fn scenes() {
    for (text, code, line, column) in [
        ("eye 0 0 6\nlok 0 1 6\n", "unknown-command", 2, 1),
        ("1 2 3\n", "stray-number", 1, 1),
        ("eye 0 0\n", "argument-count", 1, 1),
        ("eye 0 0 6\n 7\n", "argument-count", 2, 2),
        ("eye 0 o 6\n", "not-a-number", 1, 7),
        ("v 0 NaN 0\n", "not-finite", 1, 5),
        ("v 0 0 -inf\n", "not-finite", 1, 7),
        ("v 1e39 0 0\n", "not-finite", 1, 3),
        ("scale 1e30\nv 1e30 0 0\n", "not-finite", 2, 1),
        ("fov 0\n", "out-of-range", 1, 5),
        ("texture \"a.png\n", "stray-quote", 1, 9),
        ("f 0 1 2\n", "bad-index", 1, 3),
        ("frame 0 0 0 1 1 0 2 2 0\n", "degenerate-frame", 1, 1),
        ("pop\n", "needs-line-above", 1, 1),
        ("push\npush\npop\n", "open-push", 1, 1),
        ("eye 1 2 3\nlook 1 2 3\nv 0 0 0\n", "bad-camera", 2, 1),
        ("look 0 0 5\nup 0 0 1\n", "bad-camera", 2, 1),
        ("near 10\nfar 5\n", "bad-camera", 2, 1),
        ("texture no.png\n", "file-missing", 1, 1),
        ("obj no.obj\n", "file-missing", 1, 1),
        ("include no.scene\n", "file-missing", 1, 1),
        ("include a.scene\n", "include-cycle", 1, 1),
        ("\n  texture .\n", "not-a-file", 2, 3),
        ("include .\n", "not-a-file", 1, 1),
    ] {
        refused(&scene(text), "a.scene", code, ("a.scene", line, column));
    }
    for (face, code, line, column) in [
        ("f 0 1\n", "too-few-corners", 4, 1),
        ("f 0 1 3\n", "bad-index", 4, 7),
        ("f 0 1 1000000000\n", "bad-index", 4, 7),
        ("tf 0 0 0 1 1 0 2 0\n", "argument-count", 4, 1),
        ("tf 0 0 0 1 1 0 2 0 1\n", "needs-line-above", 4, 1),
        ("ff 0 1 2\n", "needs-line-above", 4, 1),
    ] {
        refused(
            &scene(&format!("{THREE}{face}")),
            "a.scene",
            code,
            ("a.scene", line, column),
        );
    }
}

#[test]
fn whole_files() {
    refused_whole(&scene(""), "a.scene", "empty-scene");
    refused_whole(&scene("# nothing\nla 1 1 1\n"), "a.scene", "empty-scene");
    refused_whole(&obj(""), "a.obj", "empty-mesh");
    refused_whole(&obj(THREE), "a.obj", "empty-mesh");
    refused_whole(
        &obj(&format!("{THREE}l 1 2 3\np 1\n")),
        "a.obj",
        "empty-mesh",
    );
    refused_whole(&scene(""), "no.scene", "file-missing");
    refused_whole(&scene(""), "no.obj", "file-missing");
    refused_whole(&scene("").with("a.fbx", "{}"), "a.fbx", "unknown-format");
    refused_whole(&scene("").with("a.gltf", "{}"), "a.gltf", "broken-gltf");
    refused_whole(&scene("").with("a.glb", "glTF"), "a.glb", "broken-gltf");
    let files = Files::new().with("room.scene/x", "").with("cow.obj/x", "");
    refused_whole(&files, "room.scene", "not-a-file");
    refused_whole(&files, "cow.obj", "not-a-file");
}

#[test]
fn text_that_is_none() {
    let latin1 = Files::new().with("a.scene", b"eye 0 0 6\n# caf\xe9\n");
    refused(&latin1, "a.scene", "not-utf8", ("a.scene", 2, 6));
    let binary = Files::new().with("a.obj", b"v 0 0 0\n\xff\xfe\0\0");
    refused(&binary, "a.obj", "not-utf8", ("a.obj", 2, 1));
}

#[test]
fn include_cycles_of_any_length() {
    let files = scene("include sub/b.scene\n")
        .with("sub/b.scene", "\ninclude ../c.scene\n")
        .with("c.scene", "v 0 0 0\n include a.scene\n");
    refused(&files, "a.scene", "include-cycle", ("sub/../c.scene", 2, 2));
    // Twice is no circle.
    let twice =
        scene("include b.scene\ninclude b.scene\n").with("b.scene", format!("{THREE}f 0 1 2\n"));
    assert_eq!(twice.load("a.scene").expect("two copies").meshes.len(), 2);
}

#[test]
fn includes_that_multiply_are_stopped() {
    let mut files = Files::new()
        .with("a.scene", "include 0.scene\n")
        .with("20.scene", "v 0 0 0\n");
    for i in 0..20 {
        files = files.with(
            &format!("{i}.scene"),
            format!("include {0}.scene\ninclude {0}.scene\n", i + 1),
        );
    }
    let error = files.load("a.scene").expect_err("a million files");
    assert_code(&error, "out-of-range");
    let mut chain = Files::new().with("40.scene", "v 0 0 0\n");
    for i in 0..40 {
        chain = chain.with(&format!("{i}.scene"), format!("include {}.scene\n", i + 1));
    }
    refused(&chain, "0.scene", "out-of-range", ("32.scene", 1, 1));
}

#[test]
fn models() {
    for (line, code, column) in [
        ("f 1 2 1000000000", "bad-index", 7),
        ("f 1 2 -4", "bad-index", 7),
        ("f 0 1 2", "bad-index", 3),
        ("f 1/1 2/1 3/1", "bad-index", 3),
        ("f 1//1 2//1 3//1", "bad-index", 3),
        ("f 1 2", "too-few-corners", 1),
        ("f 1 2 x", "not-a-number", 7),
        ("f 1 2 3/", "bad-index", 0),
        ("v 0 nan 0\nf 1 2 4", "not-finite", 5),
        ("v 0 1e99 0\nf 1 2 4", "not-finite", 5),
        ("v 0 0", "argument-count", 1),
        ("vt", "argument-count", 1),
        ("mtllib no.mtl", "file-missing", 1),
        ("usemtl", "argument-count", 1),
    ] {
        if column == 0 {
            // An empty part names nothing: it is allowed.
            let good = obj(&format!("{THREE}{line}\n"));
            assert!(good.load("a.obj").is_ok(), "{line}");
            continue;
        }
        refused(
            &obj(&format!("{THREE}{line}\nf 1 2 3\n")),
            "a.obj",
            code,
            ("a.obj", 4, column),
        );
    }
    let mixed = obj(&format!("{THREE}vt 0 0\nf 1/1 2 3/1\n"));
    refused(&mixed, "a.obj", "mixed-corners", ("a.obj", 5, 7));
    let unknown = obj(&format!("mtllib a.mtl\n{THREE}usemtl gold\nf 1 2 3\n"))
        .with("a.mtl", "newmtl silver\n");
    refused(&unknown, "a.obj", "unknown-material", ("a.obj", 5, 1));
}

#[test]
fn libraries() {
    for (text, code, line) in [
        ("Kd 1 1 1\n", "needs-line-above", 1),
        ("newmtl a\nKd 1 1\n", "argument-count", 2),
        ("newmtl a\nKd nan 0 0\n", "not-finite", 2),
        ("newmtl a\nd 7\n", "out-of-range", 2),
        ("newmtl a\nmap_Kd no.png\n", "file-missing", 2),
        ("newmtl a\nmap_d\n", "argument-count", 2),
        ("newmtl a\nmap_Kd -s x 1 a.png\n", "not-a-number", 2),
    ] {
        let files = obj(&format!("mtllib a.mtl\n{THREE}usemtl a\nf 1 2 3\n")).with("a.mtl", text);
        refused(&files, "a.obj", code, ("a.mtl", line, 1));
    }
    let directory = obj(&format!("mtllib sub\n{THREE}f 1 2 3\n")).with("sub/x", "");
    refused(&directory, "a.obj", "not-a-file", ("a.obj", 1, 1));
}

#[test]
fn pictures() {
    let whole = {
        let files = Files::new().with_png("a.png", 8, 8, [200, 100, 50, 255]);
        fs::read(files.path("a.png")).expect("a picture")
    };
    let broken: [(&str, Vec<u8>, &str); 9] = [
        (
            "truncated.png",
            whole[..whole.len() / 2].to_vec(),
            "broken-image",
        ),
        ("header.png", whole[..20].to_vec(), "broken-image"),
        ("empty.png", Vec::new(), "broken-image"),
        ("text.png", b"this is no picture".to_vec(), "broken-image"),
        ("flipped.png", flipped(&whole), "broken-image"),
        ("zero.png", with_width(&whole, 0), "image-size"),
        ("huge.png", with_width(&whole, 1 << 30), "image-size"),
        ("zero.gif", b"GIF89a\0\0\0\0\0\0\0;".to_vec(), "image-size"),
        (
            "cut.jpg",
            b"\xff\xd8\xff\xe0\0\x10JFIF\0".to_vec(),
            "broken-image",
        ),
    ];
    for (name, bytes, code) in broken {
        let files =
            scene(&format!("{THREE}texture {name}\ntf 0 0 0 1 1 0 2 0 1\n")).with(name, bytes);
        refused(&files, "a.scene", code, ("a.scene", 4, 1));
        assert!(
            files
                .load("a.scene")
                .expect_err("broken")
                .to_string()
                .contains(name)
        );
    }
}

/// A bit of the compressed data is wrong.
fn flipped(png: &[u8]) -> Vec<u8> {
    let mut bytes = png.to_vec();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    bytes
}

/// The header says another width.
fn with_width(png: &[u8], width: u32) -> Vec<u8> {
    let mut bytes = png.to_vec();
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes
}

#[test]
fn faults_deep_below_an_include_are_placed_there() {
    let files = scene("include parts/wall.scene\n")
        .with("parts/wall.scene", format!("{THREE}texture brick.png\n"))
        .with("brick.png", "here is the wrong folder");
    refused(
        &files,
        "a.scene",
        "file-missing",
        ("parts/wall.scene", 4, 1),
    );
    let model = scene("obj m.obj\n").with("m.obj", format!("{THREE}f 1 2 9\n"));
    refused(&model, "a.scene", "bad-index", ("m.obj", 4, 7));
}

#[test]
fn camera_paths_and_arrays() {
    let files = Files::new()
        .with("walk.json", "[{\"eye\": [0, 0, 0],\n  \"look\": [1, 0]}]")
        .with("a.npy", b"\x93NUMPY\x01\0\xff\xff");
    let error = CameraPath::read(&files.path("walk.json")).expect_err("two numbers");
    assert_code(&error, "broken-camera-path");
    assert_eq!(error.location().map(|p| p.line), Some(2));
    assert_code(
        &npy::read(&files.path("a.npy")).expect_err("no header"),
        "broken-array",
    );
    assert_code(
        &npy::read(files.root()).expect_err("a directory"),
        "not-a-file",
    );
}

/// Objects whose coordinates are projected share the box of their file, which is not sought again for each.
#[test]
fn very_many_objects_without_coordinates_are_no_fault() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 4 0 0\nusemtl textured\n");
    for i in 0..40_000 {
        text += &format!("o n{i}\nf 1 2 3\n");
    }
    text += "o last\nf 1 4 3\n";
    let scene = obj(&format!("mtllib a.mtl\n{text}"))
        .with("a.mtl", "newmtl textured\nmap_Kd a.png\n")
        .with_png("a.png", 8, 8, [200, 100, 50, 255])
        .load("a.obj")
        .expect("40,001 objects");
    assert_eq!(scene.meshes.len(), 40_001);
    let right = |mesh: usize| scene.meshes[mesh].uvs[1][0];
    assert_eq!([right(0), right(39_999), right(40_000)], [0.25, 0.25, 1.0]);
}

#[test]
fn a_huge_face_is_no_fault() {
    let mut text = String::new();
    for i in 0..20_000 {
        let a = f64::from(i) * 3e-4;
        text += &format!("v {} {} 0\n", a.cos(), a.sin());
    }
    let corners: Vec<_> = (1..=20_000).map(|i| i.to_string()).collect();
    text += &format!("f {}\n", corners.join(" "));
    let scene = obj(&text)
        .load("a.obj")
        .expect("a polygon of 20,000 corners");
    assert_eq!(scene.meshes[0].triangles.len(), 19_998);
}
