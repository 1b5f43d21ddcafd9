//! Outputs: never an input, never two in one file, with their old mode; and standard output that takes nothing.

use crate::program::{Desk, ROOM};

#[test]
fn no_output_is_an_input_or_another_output() {
    let desk = Desk::new();
    for name in ["uv.txt", "grid.npy", "out.depth.npy"] {
        desk.put(name, "0.5 0.5\n");
    }
    std::fs::copy(desk.path("check.png"), desk.path("b.png")).unwrap();
    std::fs::copy(desk.path("check.png"), desk.path("l0.png")).unwrap();
    std::fs::copy(desk.path("m.obj"), desk.path("q.face.npy")).unwrap();
    for (arguments, input) in [
        ("diff check.png b.png --heat b.png", "b.png"),
        ("diff check.png b.png --heat ./check.png", "check.png"),
        ("warp check.png -o check.png", "check.png"),
        ("mip l0.png -o l%d.png", "l0.png"),
        ("sample check.png --uv uv.txt -o uv.txt", "uv.txt"),
        ("slice grid.npy -o grid.npy", "grid.npy"),
        ("slice noise --ramp check.png -o check.png", "check.png"),
        ("env check.png --to cube -o check.png", "check.png"),
        (
            "bake room.scene --object a --light --size 8 -o room.scene",
            "room.scene",
        ),
        ("uv m.obj --map sphere -o m.obj", "m.obj"),
        ("uv-raster q.face.npy -o q", "q.face.npy"),
        (
            "render out.depth.npy -o out.png --aov depth",
            "out.depth.npy",
        ),
    ] {
        let before = desk.read(input);
        desk.refused(arguments, 2, "the output is the input");
        assert_eq!(desk.read(input), before, "{arguments}");
    }
    for arguments in [
        "uv m.obj --map sphere --tangents ./m.obj",
        "uv m.obj --map sphere -o x.npy --tangents x.npy",
        "uv m.obj --map sphere -o x.npy --tangents ./x.npy",
    ] {
        desk.refused(arguments, 2, "");
    }
    desk.refused(
        "chart --quick -o c.csv -o ./c.csv",
        2,
        "two outputs are one file",
    );
}

/// Files that scenes and models name are read later than the command line, and are inputs too.
#[test]
fn no_output_is_what_a_scene_or_model_names() {
    let desk = Desk::new();
    let more = "include part.scene\nsolid out.depth.npy 0 0 0 4 4 4\nobj m.obj\n";
    desk.put("all.scene", format!("{ROOM}{more}"));
    desk.put(
        "part.scene",
        "texture m.png\nv 0 2 0\nv 1 2 0\nv 0 3 0\ntf 0 0 0 1 1 0 2 0 1\n",
    );
    desk.put("other.scene", "eye 0 0 5\ninclude part.scene\n");
    let check = desk.picture("check.png");
    for name in ["m.png", "view1.png"] {
        check.save(desk.path(name)).unwrap();
    }
    image::imageops::resize(&check, 8, 4, image::imageops::Nearest)
        .save(desk.path("sky.png"))
        .unwrap();
    let turned = ROOM.replace("check.png", "view1.png");
    desk.put("turned.scene", turned);
    let values = texmap_io::npy::Values::F32(&[0.5; 8]);
    texmap_io::npy::write(&desk.path("out.depth.npy"), &[2, 2, 2], values).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(desk.path("check.png"), desk.path("soft.png")).unwrap();
    let mut cases = vec![
        ("render room.scene -o check.png", "check.png"),
        ("render room.scene -o check.png --dry-run", "check.png"),
        ("render room.scene -o .//check.png", "check.png"),
        ("render all.scene -o m.png", "m.png"),
        ("render m.obj -o check.png", "check.png"),
        ("render m.obj -o check.png --views front,top", "check.png"),
        ("render all.scene -o out.png --aov depth", "out.depth.npy"),
        (
            "render turned.scene -o view%d.png --turntable 3",
            "view1.png",
        ),
        ("render m.obj -o sky.png --env sky.png", "sky.png"),
        // The model's picture would be written before the scene is read that names it.
        ("render m.obj other.scene -o {model}.png", "m.png"),
        (
            "bake all.scene --object panel --light --size 8 -o check.png",
            "check.png",
        ),
    ];
    if cfg!(unix) {
        cases.push(("render room.scene -o soft.png", "check.png"));
    }
    for (arguments, input) in cases {
        let before = desk.read(input);
        let size = match arguments.starts_with("render") {
            true => " --resolution 16x12",
            false => "",
        };
        desk.refused(&format!("{arguments}{size}"), 2, "the output is the input");
        assert!(desk.read(input) == before, "{arguments}");
    }
    // Negative twin: pictures of an earlier run are written again.
    for _ in 0..2 {
        let run = desk.texmap("render room.scene m.obj -o new/{model}.png --resolution 16x12");
        run.ok();
        desk.texmap("render m.obj -o soft2.png --resolution 16x12")
            .ok();
    }
}

#[cfg(unix)]
#[test]
fn links_hide_no_input() {
    let desk = Desk::new();
    std::os::unix::fs::symlink(desk.path("check.png"), desk.path("soft.png")).unwrap();
    std::fs::hard_link(desk.path("check.png"), desk.path("hard.png")).unwrap();
    for name in ["soft.png", "hard.png"] {
        desk.refused(
            &format!("warp check.png -o {name}"),
            2,
            "the output is the input check.png",
        );
    }
    // A link to another file is an output like any other.
    std::fs::write(desk.path("old.png"), "old").unwrap();
    std::os::unix::fs::symlink(desk.path("old.png"), desk.path("new.png")).unwrap();
    desk.texmap("warp check.png -o new.png").ok();
    assert!(desk.path("new.png").is_symlink() && desk.read("old.png") != b"old");
}

#[cfg(unix)]
#[test]
fn overwritten_outputs_keep_their_mode() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::new();
    let mode = |name: &str| {
        std::fs::metadata(desk.path(name))
            .unwrap()
            .permissions()
            .mode()
            & 0o777
    };
    for (name, arguments) in [
        (
            "o.png",
            "render room.scene --resolution 16x16 -o o.png --aov depth",
        ),
        (
            "o.depth.npy",
            "render room.scene --resolution 16x16 -o o.png --aov depth",
        ),
        ("x.obj", "uv m.obj --map sphere -o x.obj"),
        ("w.png", "warp check.png -o w.png"),
    ] {
        desk.put(name, "old");
        std::fs::set_permissions(desk.path(name), std::fs::Permissions::from_mode(0o600)).unwrap();
        desk.texmap(arguments).ok();
        assert_eq!(mode(name), 0o600, "{name}");
    }
    std::fs::remove_file(desk.path("o.png")).unwrap();
    desk.texmap("render room.scene --resolution 16x16 -o o.png")
        .ok();
    assert_ne!(mode("o.png"), 0o600, "a new file has the mode of any other");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error_and_a_closed_one_is_not() {
    use std::fs::OpenOptions;
    use std::io::Read;
    use std::process::{Command, Stdio};

    let desk = Desk::new();
    let program = |arguments: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_texmap-tested"));
        command
            .args(arguments.split(' '))
            .current_dir(desk.path("."));
        command
    };
    for arguments in [
        "info room.scene",
        "info room.scene --json",
        "hash check.png",
        "hash check.png --json",
        "diff check.png check.png",
        "uv m.obj --map sphere --report",
        "demo --list",
        "stability R1",
        "render room.scene --dry-run",
        "render room.scene --resolution 8x8 -o p.png --json",
        "render room.scene --resolution 8x8 -o -",
        "--help",
    ] {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let out = program(arguments).stdout(full).output().unwrap();
        let words = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(4), "{arguments}: {words}");
        assert!(
            words.contains("standard output: cannot be written"),
            "{arguments}: {words}"
        );

        let mut child = program(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut words = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut words)
            .unwrap();
        assert_eq!(
            child.wait().unwrap().code(),
            Some(0),
            "{arguments}: {words}"
        );
        assert!(!words.contains("error"), "{arguments}: {words}");
    }
}

/// A picture that cannot be written leaves the mesh and its tangents as they were.
#[test]
fn coordinates_and_their_pictures_are_written_together() {
    let desk = Desk::new();
    desk.put("x.obj", "old");
    std::fs::create_dir_all(desk.path("pictures/layout.png")).unwrap();
    let run = desk.texmap("uv m.obj --map sphere -o x.obj --tangents x.npy --pictures pictures");
    assert_eq!(run.code, 4, "{}", run.stderr);
    assert_eq!(desk.read("x.obj"), b"old");
    assert!(!desk.path("x.npy").exists());
}

/// Arrays of other shapes differ, whatever their values; a file of a list that is lost fails alone.
#[test]
fn shapes_are_compared_and_lost_files_fail_alone() {
    let desk = Desk::new();
    let values: Vec<f32> = (0..24).map(|i| i as f32).collect();
    for (name, shape) in [
        ("a.npy", &[2, 3, 2, 2][..]),
        ("b.npy", &[6, 2, 2]),
        ("c.npy", &[2, 1, 3, 2, 2]),
    ] {
        let values = texmap_io::npy::Values::F32(&values);
        texmap_io::npy::write(&desk.path(name), shape, values).unwrap();
    }
    let run = desk.texmap("diff a.npy b.npy");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("(2, 3, 2, 2)"), "{}", run.stderr);
    desk.texmap("diff a.npy c.npy").ok();
    let hashes = desk.texmap("hash check.png a.npy").ok().stdout;
    let hashes = String::from_utf8(hashes).unwrap();
    desk.put("list", format!("fnv1a-128:0  gone.png\n{hashes}"));
    let run = desk.texmap("hash --check list");
    assert_eq!(run.code, 1, "{}", run.stderr);
    let text = String::from_utf8(run.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    assert!(lines[0].starts_with("FAIL  gone.png") && lines[0].contains("no such file"));
    assert_eq!(lines[1..], ["PASS  check.png", "PASS  a.npy"]);
}

#[cfg(unix)]
#[test]
fn names_with_line_breaks_are_hashed_on_one_line() {
    let desk = Desk::new();
    for name in ["a\nb\\n.png", "plain\\n.png"] {
        desk.put(name, desk.read("check.png"));
    }
    let names = ["hash", "a\nb\\n.png", "plain\\n.png"];
    let list = crate::program::run(&desk.path(""), &names).ok().stdout;
    assert_eq!(String::from_utf8_lossy(&list).lines().count(), 2);
    desk.put("list", list);
    let checked = desk.texmap("hash --check list").ok();
    let text = String::from_utf8(checked.stdout).unwrap();
    assert_eq!(text, "PASS  a\\nb\\\\n.png\nPASS  plain\\n.png\n");
}
