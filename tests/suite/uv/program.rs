//! `texmap uv` from outside.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn texmap(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
        .arg("uv")
        .args(args)
        .output()
        .expect("the program starts")
}

fn asset(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../assets/models")
        .join(name)
        .display()
        .to_string()
}

fn json(args: &[&str]) -> serde_json::Value {
    let output = texmap(args);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("a JSON document")
}

fn temp() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let path = dir.path().join("out.obj");
    (dir, path)
}

/// The lines that are no `vt`, with the texture index of each corner cut out.
fn without_uv(text: &str) -> Vec<String> {
    let strip = |line: &str| -> String {
        if !line.starts_with("f ") {
            return line.to_owned();
        }
        let corners = line.split(' ').map(|c| {
            let parts: Vec<&str> = c.split('/').collect();
            format!("{}//{}", parts[0], parts.get(2).unwrap_or(&""))
        });
        corners.collect::<Vec<_>>().join(" ")
    };
    text.lines()
        .filter(|l| !l.starts_with("vt "))
        .map(strip)
        .collect()
}

#[test]
fn every_mapping_writes_an_obj_that_differs_in_vt_and_f_alone() {
    let source = std::fs::read_to_string(asset("house.obj")).unwrap();
    for map in [
        "plane", "cylinder", "cone", "sphere", "box", "auto", "unwrap",
    ] {
        let (_dir, path) = temp();
        let out = path.display().to_string();
        let output = texmap(&[&asset("house.obj"), "-o", &out, "--map", map]);
        assert!(
            output.status.success(),
            "{map}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        let written = std::fs::read_to_string(&path).unwrap();
        // Another folder: the library is named from there.
        let library = written.lines().find_map(|l| l.strip_prefix("mtllib "));
        let library = path.parent().unwrap().join(library.expect("a library"));
        let of_source = std::fs::canonicalize(asset("house.mtl")).unwrap();
        assert_eq!(std::fs::canonicalize(library).unwrap(), of_source);
        let rest = |text: &str| -> Vec<String> {
            let lines = without_uv(text).into_iter();
            lines.filter(|l| !l.starts_with("mtllib ")).collect()
        };
        assert_eq!(rest(&written), rest(&source), "{map}");
        assert_ne!(written, source, "{map}");
        // The written mesh is read again with the same figures.
        let again = json(&[&out, "--json"]);
        assert_eq!(again["triangles"], 940, "{map}");
    }
}

#[test]
fn the_reports_of_the_lecture_objects() {
    let (_dir, path) = temp();
    let out = path.display().to_string();
    let mapped =
        |args: &[&str]| json(&[&[&asset("twisted_box.obj"), "-o", &out, "--json"], args].concat());
    let plane = mapped(&["--map", "plane"]);
    assert!(
        plane["overlap"]["triangles"].as_u64() > Some(500),
        "{plane}"
    );
    let sphere = mapped(&["--map", "sphere", "--fix-seams"]);
    assert_eq!(
        sphere["torn"].as_u64().unwrap(),
        sphere["faces_around_axis"].as_array().unwrap().len() as u64 * 2
    );
    let unwrapped = mapped(&["--map", "unwrap", "--pack", "512", "--gutter", "2"]);
    assert_eq!(unwrapped["overlap"]["triangles"], 0);
    assert!(unwrapped["stretch"]["l2"].as_f64().unwrap() < 1.02);
    // Triangle by triangle on request: the sums are theirs.
    assert!(plane["per_triangle"].is_null());
    let each = mapped(&["--map", "plane", "--per-triangle"])["per_triangle"].take();
    let each = each.as_array().unwrap();
    let count = |key: &str| each.iter().filter(|t| t[key] == true).count() as u64;
    assert_eq!(each.len() as u64, plane["triangles"].as_u64().unwrap());
    assert_eq!(
        Some(count("overlapping")),
        plane["overlap"]["triangles"].as_u64()
    );
    for key in ["flipped", "collapsed", "outside"] {
        assert_eq!(Some(count(key)), plane[key].as_u64(), "{key}");
    }
    let densities = each.iter().filter_map(|t| t["texels_per_unit"].as_f64());
    let highest = densities.fold(0.0, f64::max);
    let stated = plane["texels_per_unit"]["max"].as_f64().unwrap();
    assert!((highest / stated - 1.0).abs() < 1e-6, "{highest} {stated}");
}

#[test]
fn pictures_tangents_cuts_and_seams() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str| dir.path().join(name).display().to_string();
    std::fs::write(dir.path().join("cut.txt"), "# an edge\n1 2\n").unwrap();
    let output = texmap(&[
        &asset("cube.obj"),
        "--map",
        "box",
        "--cut",
        &file("cut.txt"),
        "--sew",
        &file("cut.txt"),
        "--pack",
        "128",
        "--gutter",
        "3",
        "-o",
        &file("out.obj"),
        "--tangents",
        &file("t.npy"),
        "--pictures",
        &file("pictures"),
        "--report",
    ]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(
        table.contains("islands               5\n"),
        "one sewn edge joins two of six sides:\n{table}"
    );
    for name in [
        "out.obj",
        "t.npy",
        "pictures/checker.png",
        "pictures/heat.png",
        "pictures/layout.png",
        "pictures/layout.svg",
    ] {
        assert!(
            dir.path()
                .join(name)
                .metadata()
                .is_ok_and(|m| m.len() > 100),
            "{name}"
        );
    }
}

#[test]
fn bad_input_ends_with_four_and_names_its_place() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let out = file("out.obj", "untouched");
    let cases = [
        (file("empty.obj", ""), "empty.obj: the mesh has no face"),
        (
            file(
                "nan.obj",
                &quad
                    .replace("1 1 0", "nan 1 0")
                    .replace("\nv 0 1 0\n", "\nv 0 1 0\nf 1 2 3 4\n"),
            ),
            "nan.obj:3:3: `v`: `nan` is not a finite",
        ),
        (
            file("index.obj", &format!("{quad}f 1 2 9\n")),
            "index.obj:5:7: vertex index 9 does not exist",
        ),
        (
            file("short.obj", &format!("{quad}\nf 1 2\n")),
            "short.obj:6:1: `f`",
        ),
        (
            file("word.obj", "v 0 zero 0\n"),
            "word.obj:1:5: `v`: `zero` is not a number",
        ),
        (
            dir.path().join("none.obj").display().to_string(),
            "none.obj: no such file",
        ),
        (dir.path().display().to_string(), "not a regular file"),
    ];
    for (path, expected) in cases {
        let output = texmap(&[&path, "--map", "sphere", "-o", &out]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(4), "{path}: {text}");
        assert!(text.contains(expected), "{path}: {text}");
        assert!(text.lines().count() == 2, "{text}");
    }
    let good = file("good.obj", &format!("{quad}f 1 2 3 4\n"));
    let fails = [
        (
            vec!["--report"],
            4,
            "not every corner has a texture coordinate",
        ),
        (
            vec!["--map", "plane", "--frame", "0,0,0,0,0,0,1,0,1", "--report"],
            4,
            "a frame needs finite values",
        ),
        (vec!["--map", "plane"], 2, "nothing to do"),
        (
            vec!["--map", "auto", "--by", "normal", "--report"],
            2,
            "--by has no effect",
        ),
        (
            vec!["--map", "sphere", "--by", "reflection", "--report"],
            2,
            "needs an eye",
        ),
        (
            vec!["--map", "box", "--pack", "8", "--gutter", "5", "--report"],
            4,
            "do not fit an atlas of 8 x 8",
        ),
        (
            vec!["--map", "unwrap", "--pack", "40000", "--report"],
            4,
            "give --pack 32768 or less",
        ),
        (
            vec![
                "--map", "unwrap", "--pack", "8", "--gutter", "4096", "--report",
            ],
            4,
            "give a larger --pack or a smaller --gutter",
        ),
        (
            vec!["--map", "box", "--fix-seams", "--report"],
            2,
            "--fix-seams has no effect",
        ),
    ];
    for (flags, code, expected) in fails {
        let output = texmap(&[&[good.as_str()], &flags[..]].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{flags:?}: {text}");
        assert!(text.contains(expected), "{flags:?}: {text}");
    }
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "untouched");
}

/// A floor in x and z has no extent along z: the plane turns to it, and a plane that does not is told.
#[test]
fn a_plane_is_fitted_and_what_it_loses_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let floor = file(
        "floor.obj",
        "v 0 0 0\nv 0 0 2\nv 3 0 2\nv 3 0 0\nf 1 2 3 4\n",
    );
    let (_dir, out) = temp();
    let out = out.display().to_string();
    let run = |mesh: &str, flags: &[&str]| {
        let output = texmap(&[&[mesh, "--map", "plane", "--report", "-o", &out], flags].concat());
        assert!(output.status.success());
        let [told, table] =
            [&output.stderr, &output.stdout].map(|text| String::from_utf8_lossy(text).into_owned());
        (told, table, std::fs::read_to_string(&out).unwrap())
    };
    let (told, table, text) = run(&floor, &[]);
    assert!(!told.contains("warning"), "{told}");
    assert!(
        table.contains("without area          0 triangles"),
        "{table}"
    );
    // As on a map: u to +X, v up to -Z.
    assert!(text.contains("vt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n"), "{text}");
    // Tiles of half a unit, counted from the origin.
    let (told, _, text) = run(&floor, &["--tile", "0.5,0.5"]);
    assert!(
        !told.contains("warning") && text.contains("vt 0 -4\n"),
        "{told}{text}"
    );
    let (told, table, _) = run(&floor, &["--frame", "0,0,0,0,0,0,4,4,4"]);
    assert!(told.contains("warning: 100 % of the surface has no area in the picture (2 triangles, the first in line 5)"), "{told}");
    assert!(table.contains("without area          2 triangles"));
    // Four of six sides of a cube; of a slope nothing.
    let (told, ..) = run(&asset("cube.obj"), &[]);
    assert!(told.contains("warning: 66.6667 % of the surface"), "{told}");
    let slope = file(
        "slope.obj",
        "v 0 0 0\nv 0 0 2\nv 3 4 2\nv 3 4 0\nf 1 2 3 4\n",
    );
    let (told, table, _) = run(&slope, &["--texture-size", "100"]);
    assert!(!told.contains("warning"), "{told}");
    assert!(table.contains("angle distortion      mean 2.5,"), "{table}");
}

/// Nobody can make files in /proc: neither the mesh nor the pictures appear without the other.
#[cfg(target_os = "linux")]
#[test]
fn pictures_and_mesh_appear_together() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).display().to_string();
    for (mesh, pictures) in [
        ("/proc/x.obj".to_owned(), at("pictures")),
        (at("x.obj"), "/proc/pictures".to_owned()),
    ] {
        let model = asset("cube.obj");
        let flags = ["--map", "auto", "-o", &mesh, "--pictures", &pictures];
        let output = texmap(&[&[model.as_str()], &flags[..]].concat());
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{told}");
        let left: Vec<_> = std::fs::read_dir(dir.path()).unwrap().collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

/// A comb of more corners than are cut.
#[test]
fn a_concave_face_that_is_drawn_as_a_fan_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("comb.obj").display().to_string();
    let end = 16_384;
    let mut text = String::new();
    for k in 0..end {
        text += &format!("v {k} {} 0\n", if k % 2 == 0 { 1.0 } else { 0.1 });
    }
    text += &format!("v {end} 0 0\nv -1 0 0\n");
    let corners: Vec<String> = (1..=end + 2).map(|i| i.to_string()).collect();
    text += &format!("f {}\n", corners.join(" "));
    std::fs::write(&path, text).unwrap();
    let output = texmap(&[&path, "--map", "plane", "-o", &path.replace("comb", "out")]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    let warning = "comb.obj:16387: a concave face of 16386 corners is drawn as a fan";
    assert!(told.contains(warning), "{told}");
}

#[test]
fn polygons_too_large_for_the_unwrapper_are_refused_by_line() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("disc.obj");
    let count = 10_000;
    let mut text = String::new();
    for i in 0..count {
        let (s, c) = (f64::from(i) / f64::from(count) * std::f64::consts::TAU).sin_cos();
        text += &format!("v {c} 0 {s}\n");
    }
    let corners: Vec<String> = (1..=count).rev().map(|i| i.to_string()).collect();
    text += &format!("f {}\n", corners.join(" "));
    std::fs::write(&path, text).unwrap();
    let path = path.display().to_string();
    let output = texmap(&[&path, "--map", "unwrap", "--report"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(
        told.contains("disc.obj:10001: a face of 10000 corners"),
        "{told}"
    );
    assert!(told.contains("--map auto"), "{told}");
    assert!(
        texmap(&[&path, "--map", "plane", "--report"])
            .status
            .success()
    );
}

/// Other formats become an OBJ: a cube of four-cornered faces as PLY, its triangles as STL, where no corner is shared.
#[test]
fn a_ply_and_an_stl_become_an_obj() {
    let (dir, out) = temp();
    let at = |name: &str| dir.path().join(name).display().to_string();
    let corner = |k: usize| [k & 1, (k >> 1) & 1, k >> 2];
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let mut ply = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n".to_owned();
    for [x, y, z] in (0..8).map(corner) {
        ply += &format!("{x} {y} {z}\n");
    }
    let mut stl = "solid cube\n".to_owned();
    for [a, b, c, d] in faces {
        ply += &format!("4 {a} {b} {c} {d}\n");
        for triangle in [[a, b, c], [a, c, d]] {
            stl += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                stl += &format!("vertex {x} {y} {z}\n");
            }
            stl += "endloop\nendfacet\n";
        }
    }
    std::fs::write(at("a.ply"), ply).unwrap();
    std::fs::write(at("a.stl"), stl + "endsolid cube\n").unwrap();
    for (name, corners, count) in [("a.ply", 4, 6), ("a.stl", 3, 12)] {
        let output = texmap(&[&at(name), "--map", "unwrap", "-o", &at("out.obj")]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {told}");
        let text = std::fs::read_to_string(&out).unwrap();
        let of = |word: &str| text.lines().filter(|l| l.starts_with(word)).count();
        assert_eq!((of("v "), of("f ")), (8, count), "{name}");
        let face = text.lines().find(|l| l.starts_with("f ")).unwrap();
        assert_eq!(face.split(' ').count(), corners + 1, "{face}");
        let found = json(&[&at("out.obj"), "--report", "--json"]);
        assert_eq!(found["triangles"], 12, "{found}");
        // A flat mapping loses the sides; their faces have numbers, not lines.
        let output = texmap(&[&at(name), "--map", "plane", "-o", &at("flat.obj")]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(told.contains("the first in face "), "{told}");
    }
    let glb = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/gltf/box.glb");
    let output = texmap(&[&glb.display().to_string(), "-o", &at("b.obj")]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(
        told.contains("error[unknown-format]") && told.contains(".obj, .ply and .stl"),
        "{told}"
    );
}
