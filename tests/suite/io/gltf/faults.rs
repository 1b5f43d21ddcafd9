//! Broken documents: each fault is named with its place in the JSON.

use std::path::Path;

use texmap_io::scene_file::Missing;
use texmap_io::{FileSource, IoError, LoadOptions, load, load_bytes};
use texmap_math::MemoryBudget;

use super::{TRIANGLE, asset, small, triangle_bytes};
use crate::support::Files;

fn refused(from: &str, to: &str) -> IoError {
    let json = TRIANGLE.replace(from, to);
    assert_ne!(json, TRIANGLE, "{from} is not there");
    match small(&json, &triangle_bytes()) {
        Ok(_) => panic!("{to} is read"),
        Err(error) => error,
    }
}

#[test]
fn faults_name_their_place() {
    small(TRIANGLE, &triangle_bytes()).expect("the document without a fault");
    for (from, to, message) in [
        (
            r#""POSITION":0"#,
            r#""POSITION":7"#,
            "/meshes/0/primitives/0/attributes/POSITION: accessor 7 does not exist; there are 2",
        ),
        (
            r#""indices":1"#,
            r#""indices":9"#,
            "/meshes/0/primitives/0/indices: accessor 9 does not exist; there are 2",
        ),
        (
            r#""POSITION":0"#,
            r#""NORMAL":0"#,
            "/meshes/0/primitives/0/attributes: has no POSITION",
        ),
        (
            r#""mesh":0"#,
            r#""mesh":1"#,
            "/nodes/0/mesh: mesh 1 does not exist; there is 1",
        ),
        (
            r#""indices":1"#,
            r#""indices":1,"material":0"#,
            "/meshes/0/primitives/0/material: material 0 does not exist; there are 0",
        ),
        (
            r#""indices":1"#,
            r#""indices":1,"mode":7"#,
            "/meshes/0/primitives/0/mode: 7 is none of 0 to 6",
        ),
        (
            r#""count":3,"type":"VEC3""#,
            r#""count":4,"type":"VEC3""#,
            "/accessors/0: 4 elements from byte 0 on need 48 bytes; its view has 36",
        ),
        (
            r#""count":3,"type":"VEC3""#,
            r#""count":0,"type":"VEC3""#,
            "/accessors/0/count: 0 elements; 1 to 4294967295 are allowed",
        ),
        (
            r#""count":3,"type":"VEC3""#,
            r#""count":3,"type":"VEC5""#,
            "/accessors/0/type: `VEC5` is no type that is read here",
        ),
        (
            r#""count":3,"type":"VEC3""#,
            r#""count":3,"type":"VEC2""#,
            "/accessors/0: elements of 2 numbers, where 3 are needed",
        ),
        (
            "5126",
            "5127",
            "/accessors/0/componentType: 5127 is no type of component",
        ),
        (
            "5123",
            "5122",
            "/accessors/1: indices are plain unsigned integers, one an element",
        ),
        (
            r#""byteOffset":36"#,
            r#""byteOffset":41"#,
            "/bufferViews/1: bytes 41 to 47 lie outside of buffer 0, which has 44",
        ),
        (
            r#""byteOffset":36"#,
            r#""byteOffset":18446744073709551615"#,
            "/bufferViews/1: bytes 18446744073709551615 to",
        ),
        (
            r#""byteOffset":36"#,
            r#""byteOffset":30"#,
            "/meshes/0/primitives/0/indices: index 0 names vertex 16256; there are 3",
        ),
        (
            r#""byteLength":36"#,
            r#""byteLength":36,"byteStride":4"#,
            "/accessors/0: elements of 12 bytes do not lie 4 bytes apart",
        ),
        (
            r#""byteLength":44"#,
            r#""byteLength":45"#,
            "/buffers/0: should have 45 bytes, has 44",
        ),
        (
            "a.bin",
            "http://x/a.bin",
            "/buffers/0/uri: `http://x/a.bin` is an address; only files beside the model are read",
        ),
        ("a.bin", "data:,x", "/buffers/0/uri: a data URI must be"),
        (
            r#"{"mesh":0}"#,
            r#"{"mesh":0,"children":[0]}"#,
            "/nodes/0: is an ancestor of itself",
        ),
        (
            r#"{"mesh":0}"#,
            r#"{"children":[2]},{"children":[2]},{"mesh":0}"#,
            "/nodes/1/children/0: node 2 has another parent already",
        ),
        (
            r#"{"mesh":0}"#,
            r#"{"mesh":0,"skin":0}"#,
            "/nodes/0/skin: skin 0 does not exist; there are 0",
        ),
        (
            r#""nodes""#,
            r#""scene":3,"nodes""#,
            "/scene: scene 3 does not exist; there are 0",
        ),
        (
            r#""nodes""#,
            r#""scenes":[{"nodes":[4]}],"nodes""#,
            "/scenes/0/nodes/0: node 4 does not exist; there is 1",
        ),
        (
            r#""mesh":0"#,
            r#""mesh":-1"#,
            "/nodes/0/mesh: invalid value",
        ),
        (r#""mesh":0"#, r#""mesh":{}"#, "/nodes/0/mesh: invalid type"),
    ] {
        let error = refused(from, to);
        assert!(
            error.to_string().starts_with(&format!("a.gltf: {message}")),
            "{to}: {error}"
        );
        assert_eq!(error.code(), "broken-gltf", "{to}");
        assert!(!error.help().is_empty());
    }
    let mut bytes = triangle_bytes();
    bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = small(TRIANGLE, &bytes).unwrap_err();
    assert!(
        error
            .to_string()
            .ends_with("/accessors/0: element 0 is not finite"),
        "{error}"
    );
}

#[test]
fn what_is_not_read_is_refused_by_name_with_what_converts_it() {
    let used = |name: &str| {
        format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"],"nodes""#)
    };
    for (name, command) in [
        ("KHR_draco_mesh_compression", "npx @gltf-transform/cli copy"),
        (
            "KHR_texture_basisu",
            "npx @gltf-transform/cli ktxdecompress",
        ),
        ("ACME_teleport", "npx @gltf-transform/cli"),
    ] {
        let error = refused(r#""nodes""#, &used(name));
        assert_eq!(
            error.to_string(),
            format!("a.gltf: /extensionsRequired/0: {name} is not read")
        );
        assert_eq!(error.code(), "unsupported-gltf");
        assert!(error.help().contains(command), "{}", error.help());
    }
    let first = refused(r#""version":"2.0""#, r#""version":"1.0""#);
    assert_eq!(
        first.to_string(),
        "a.gltf: /asset/version: glTF 1.0 is not read"
    );
    assert!(first.help().contains("npx gltf-pipeline"));
}

#[test]
fn optional_extensions_are_one_warning() {
    let json = TRIANGLE.replace(
        r#""nodes""#,
        r#""extensionsUsed":["A_b","C_d","KHR_materials_unlit","KHR_materials_volume"],"nodes""#,
    );
    let scene = small(&json, &triangle_bytes()).expect("a triangle");
    assert_eq!(scene.warnings, ["2 optional extensions left out: A_b, C_d"]);
    let glass = json
        .replace(r#""indices":1"#, r#""indices":1,"material":0"#)
        .replace(
            r#""nodes""#,
            r#""materials":[{"extensions":{"KHR_materials_volume":{}}}],"nodes""#,
        );
    let scene = small(&glass, &triangle_bytes()).expect("a triangle");
    assert!(
        scene.warnings[0].contains("KHR_materials_volume: light is coloured at the surface"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn nothing_is_read_outside_of_the_folder() {
    let outside = TRIANGLE.replace("a.bin", "../a.bin");
    let files = Files::new()
        .with("models/a.gltf", &outside)
        .with("a.bin", triangle_bytes());
    let error = files.load("models/a.gltf").unwrap_err();
    assert_eq!(error.code(), "outside-root", "{error}");
    assert!(
        error.to_string().contains("/buffers/0/uri: ") && error.help().contains("--root"),
        "{error}"
    );
    for address in ["file:///etc/passwd", "/etc/passwd"] {
        let files = Files::new().with("a.gltf", TRIANGLE.replace("a.bin", address));
        let error = files.load("a.gltf").unwrap_err();
        assert_eq!(error.code(), "outside-root", "{error}");
    }
    let wider = LoadOptions {
        files: FileSource::within(files.root()).expect("a folder"),
        ..LoadOptions::default()
    };
    load(&files.path("models/a.gltf"), &wider).expect("a root that holds both");
    let gone = files.with("models/b.gltf", TRIANGLE);
    let error = gone.load("models/b.gltf").unwrap_err();
    assert_eq!(error.code(), "file-missing");
    assert!(
        error.to_string().contains("b.gltf: /buffers/0/uri: "),
        "{error}"
    );
}

#[test]
fn lost_and_broken_pictures() {
    let textured = TRIANGLE
        .replace(r#""indices":1"#, r#""indices":1,"material":0"#)
        .replace(r#""nodes""#, r#""materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"uri":"a.png"}],"nodes""#);
    let files = Files::new()
        .with("a.gltf", &textured)
        .with("a.bin", triangle_bytes());
    let error = files.load("a.gltf").unwrap_err();
    assert!(
        error.to_string().contains("a.gltf: /images/0/uri: ") && error.code() == "file-missing",
        "{error}"
    );
    let lenient = LoadOptions {
        missing: Some(Missing::Checker),
        ..LoadOptions::default()
    };
    let scene = load(&files.path("a.gltf"), &lenient).expect("a stand-in");
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("checker stands in")),
        "{:?}",
        scene.warnings
    );
    // It has no coordinates either.
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("not the coordinates")),
        "{:?}",
        scene.warnings
    );
    let info = texmap_io::info(&files.path("a.gltf")).expect("a report");
    assert_eq!(info.problems().count(), 1);
    let files = files.with("a.png", "no picture");
    let error = files.load("a.gltf").unwrap_err();
    assert!(
        error.to_string().contains("/images/0: ") && error.code() == "broken-image",
        "{error}"
    );
    let files = files.with("a.png", b"\xabKTX 20\xbb\r\n\x1a\n");
    let error = files.load("a.gltf").unwrap_err();
    assert_eq!(error.code(), "unsupported-gltf");
    assert!(error.help().contains("ktxdecompress"));
    // The picture of a machine that takes both cases for one.
    let files = files
        .with("b.gltf", textured.replace("a.png", "b.png"))
        .with_png("B.PNG", 3, 3, [255; 4]);
    let scene = files.load("b.gltf").expect("a model");
    assert_eq!(scene.textures[0].width(), 3);
    let told = "b.png: no such file: B.PNG is read";
    assert!(
        scene.warnings.iter().any(|w| w.contains(told)),
        "{:?}",
        scene.warnings
    );
    // The path of a drive, and an address of the network.
    let files = files
        .with("c.gltf", textured.replace("a.png", r"C:\\art\\B.PNG"))
        .with("d.gltf", textured.replace("a.png", "https://x/a.png"));
    assert_eq!(files.load("c.gltf").unwrap().textures[0].width(), 3);
    let error = files.load("d.gltf").unwrap_err();
    assert_eq!(error.code(), "broken-gltf");
    let scene = load(&files.path("d.gltf"), &lenient).expect("a stand-in");
    assert_eq!(scene.textures[0].width(), 8);
    let told = "`https://x/a.png` is an address; only files beside the model are read: a magenta";
    let told = scene.warnings.iter().any(|w| w.starts_with(told));
    assert!(told, "{:?}", scene.warnings);
    let info = texmap_io::info(&files.path("d.gltf")).expect("a report");
    assert_eq!(info.problems().count(), 1);
}

#[test]
fn bytes_without_files() {
    let bytes = std::fs::read(asset("box.glb")).expect("an asset");
    let scene =
        load_bytes(Path::new("any.glb"), bytes.clone(), &LoadOptions::default()).expect("a box");
    assert_eq!(scene.meshes[0].triangles.len(), 12);
    // The bytes of a file tell its format.
    load_bytes(
        Path::new("any.gltf"),
        bytes.clone(),
        &LoadOptions::default(),
    )
    .expect("a box");
    let error = load_bytes(
        Path::new("a.gltf"),
        TRIANGLE.into(),
        &LoadOptions::default(),
    )
    .unwrap_err();
    assert_eq!(error.code(), "file-missing");
    let cut = load_bytes(
        Path::new("a.glb"),
        bytes[..200].to_vec(),
        &LoadOptions::default(),
    )
    .unwrap_err();
    assert!(cut.to_string().contains("the file ends after 200"), "{cut}");
}

/// A few bytes that ask for gigabytes.
#[test]
fn the_memory_budget_is_asked() {
    let json = TRIANGLE.replace(r#""bufferView":0,"#, "").replace(
        r#""count":3,"type":"VEC3""#,
        r#""count":400000000,"type":"VEC3""#,
    );
    let files = FileSource::in_memory([
        ("a.gltf".into(), json.into_bytes()),
        ("a.bin".into(), triangle_bytes()),
    ]);
    let files = files.with_memory(MemoryBudget::new(1 << 30));
    let error = load(
        Path::new("a.gltf"),
        &LoadOptions {
            files,
            ..LoadOptions::default()
        },
    )
    .unwrap_err();
    assert_eq!(error.code(), "over-memory-budget", "{error}");
}
