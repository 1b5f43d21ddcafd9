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
        assert_eq!(without_uv(&written), without_uv(&source), "{map}");
        assert_ne!(written, source, "{map}");
        // What was written is read again with the same figures.
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
        table.contains("shells                5\n"),
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
            "nan.obj:5: face 1 uses vertex 3",
        ),
        (
            file("index.obj", &format!("{quad}f 1 2 9\n")),
            "index.obj:5: vertex 9 is not there",
        ),
        (
            file("short.obj", &format!("{quad}\nf 1 2\n")),
            "short.obj:6: a face of 2 corners",
        ),
        (
            file("word.obj", "v 0 zero 0\n"),
            "word.obj:1: `zero` is no number",
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
            "do not fit a page of 8 x 8",
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
