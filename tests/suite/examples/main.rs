//! The six tasks of a library's user: each example runs, does its work, and is short.
#![allow(
    unreachable_pub,
    reason = "the examples are programs; their main functions are public for this suite alone"
)]

use std::fs;
use std::path::Path;

#[path = "../../../examples/rectify.rs"]
mod rectify;
#[path = "../../../examples/sample_image.rs"]
mod sample_image;
#[path = "../../../examples/shade_fragments.rs"]
mod shade_fragments;
#[path = "../../../examples/shadow_map.rs"]
mod shadow_map;
#[path = "../../../examples/textured_cube.rs"]
mod textured_cube;
#[path = "../../../examples/unwrap_mesh.rs"]
mod unwrap_mesh;

/// One test for all: they read and write files below the current folder, which a process has one of.
#[test]
fn each_example_does_its_work() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::tempdir().expect("a folder for pictures");
    let textures = folder.path().join("assets/textures");
    fs::create_dir_all(&textures).expect("a folder for textures");
    fs::copy(
        root.join("assets/textures/brick.png"),
        textures.join("brick.png"),
    )
    .expect("a texture");
    std::env::set_current_dir(folder.path()).expect("the folder exists");

    sample_image::main().expect("an image is sampled");
    rectify::main().expect("a photo is rectified");
    shade_fragments::main().expect("fragments are shaded");
    unwrap_mesh::main().expect("a mesh is unwrapped");
    shadow_map::main().expect("a shadow is looked up");
    textured_cube::main().expect("a cube is drawn");

    let size = |name| image::image_dimensions(folder.path().join(name)).expect("a picture");
    assert_eq!(
        (size("rectified.png"), size("cube.png")),
        ((320, 200), (640, 480))
    );
}

#[test]
fn each_example_is_short() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    for entry in fs::read_dir(folder).expect("the folder of examples") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("an example");
        let code = text.lines().filter(|line| {
            let line = line.trim();
            !line.is_empty() && !line.starts_with("//")
        });
        let lines = code.count();
        assert!(lines <= 25, "{} has {lines} lines", path.display());
    }
}
