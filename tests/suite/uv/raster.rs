//! `texmap uv-raster` from outside.

use std::path::Path;
use std::process::{Command, Output};

use texmap_io::npy::{self, Data};

fn texmap(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
        .arg("uv-raster")
        .args(args)
        .output()
        .expect("the program starts")
}

/// Two squares, one textured twice (the second face lies on the first), two specks and a face without area.
const MESH: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 4 0 1\nv 4 2 1\n\
vt 0.125 0.125\nvt 0.375 0.125\nvt 0.375 0.375\nvt 0.125 0.375\nvt 0.75 0.75\nvt 0.7501 0.75\nvt 0.75 0.7501\nvt 0.9 0.9\nvt 0.6 0.9\nvt 0.6001 0.9\nvt 0.6 0.9001\n\
vn 0 0 3\nvn 1 0 0\n\
f 1/1/1 2/2/1 3/3/1 4/4/1\nf 2/1/2 5/2/2 6/3/2 3/4/2\nf 1/5/1 2/6/1 3/7/1\nf 1/8/1 2/8/1 3/8/1\nf 1/11/1 2/10/1 3/9/1\n";

fn f32s(path: &Path) -> Vec<f32> {
    match npy::read(path).expect("an array").data {
        Data::F32(v) => v,
        other => panic!("{other:?}"),
    }
}

fn u32s(path: &Path) -> Vec<u32> {
    match npy::read(path).expect("an array").data {
        Data::U32(v) => v,
        other => panic!("{other:?}"),
    }
}

#[test]
fn arrays_say_what_lies_at_each_texel() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    std::fs::write(at("m.obj"), MESH).unwrap();
    let run = |more: &[&str]| {
        let (mesh, out) = (
            at("m.obj").display().to_string(),
            at("a").display().to_string(),
        );
        let output =
            texmap(&[&[mesh.as_str(), "-o", &out, "--size", "32", "--json"], more].concat());
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{words}");
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (json, words)
    };
    let (json, words) = run(&["--gutter", "2"]);
    // The hidden square (2 triangles), the specks and the face without area own nothing.
    assert_eq!(json["lost_triangles"], serde_json::json!([2, 3, 4, 5, 6]));
    assert!(
        words.contains("5 of 7 triangles own no texel (lines 21, 22, 23, 24)"),
        "{words}"
    );
    assert_eq!(json["texels"]["centre"], 64);
    assert_eq!(json["texels"]["gutter"], 12 * 12 - 64);
    let (face, normal, position) = (
        u32s(&at("a.face.npy")),
        f32s(&at("a.normal.npy")),
        f32s(&at("a.position.npy")),
    );
    let coverage = match npy::read(&at("a.coverage.npy")).unwrap() {
        npy::Array {
            shape,
            data: Data::U8(v),
        } => {
            assert_eq!(shape, [32, 32]);
            v
        }
        other => panic!("{other:?}"),
    };
    // v counts from the bottom: the square fills rows 20 to 27 and columns 4 to 11.
    for (y, x) in (0..32usize).flat_map(|y| (0..32usize).map(move |x| (y, x))) {
        let k = y * 32 + x;
        let inside = (20..28).contains(&y) && (4..12).contains(&x);
        let beside = (18..30).contains(&y) && (2..14).contains(&x);
        assert_eq!(face[k], if beside { 0 } else { u32::MAX }, "{x} {y}");
        assert_eq!(
            coverage[k],
            if inside {
                1
            } else if beside {
                3
            } else {
                0
            }
        );
        if inside {
            assert_eq!(normal[3 * k..3 * k + 3], [0.0, 0.0, 1.0]);
            let expected = [(x as f32 + 0.5 - 4.0) / 4.0, (27.5 - y as f32) / 4.0, 0.0];
            let found = &position[3 * k..3 * k + 3];
            assert!(
                found
                    .iter()
                    .zip(expected)
                    .all(|(a, b)| (a - b).abs() < 1e-5),
                "{found:?} {expected:?}"
            );
        }
    }
    let triangles = u32s(&at("a.triangles.npy"));
    assert_eq!(triangles[..8], [0, 0, 1, 2, 0, 0, 2, 3]);
    let picture = texmap_io::image_io::read_image(&at("a.face.png")).unwrap();
    assert_eq!((picture.width, picture.height), (32, 32));

    // Conservative: everything inside the picture owns a texel, whatever its size.
    let (json, words) = run(&["--conservative", "--no-pictures", "--threads", "2"]);
    assert_eq!(json["lost_triangles"], serde_json::json!([]), "{words}");
    let owners = u32s(&at("a.triangle.npy"));
    for triangle in 0..7 {
        assert!(owners.contains(&triangle), "triangle {triangle}");
    }
    assert_eq!(json["files"].as_array().unwrap().len(), 7);
}

#[test]
fn meshes_without_usable_coordinates_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    for (text, code, place) in [
        (
            format!("{quad}f 1 2 3\n"),
            "no-coordinates",
            "not every corner has a texture coordinate",
        ),
        (
            format!("{quad}vt 0 nan\nf 1/1 2/1 3/1\n"),
            "not-finite",
            "m.obj:5: face 1",
        ),
        (String::new(), "empty-mesh", "no face"),
        (format!("{quad}f 1 2 4\n"), "bad-index", "m.obj:4:7"),
    ] {
        let path = dir.path().join("m.obj");
        std::fs::write(&path, text).unwrap();
        let out = dir.path().join("a");
        let output = texmap(&[
            &path.display().to_string(),
            "-o",
            &out.display().to_string(),
        ]);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(4), "{words}");
        assert!(words.contains(code) && words.contains(place), "{words}");
        assert_eq!(
            std::fs::read_dir(dir.path()).unwrap().count(),
            1,
            "nothing is left behind"
        );
    }
    for bad in ["0", "16385", "many"] {
        let output = texmap(&["m.obj", "-o", "a", "--size", bad]);
        assert_eq!(output.status.code(), Some(2), "{bad}");
    }
}
