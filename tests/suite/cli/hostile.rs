//! Files and names that were made to harm: none is waited for, none fills the memory, and none writes to the terminal what it likes.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::process::Command;

use crate::program::Desk;

/// Every argument of every verb that takes a file to read, as `X`; the ending that it needs.
const READERS: [(&str, &str); 34] = [
    ("render X -o out.png", "scene"),
    ("render X -o out.png", "obj"),
    ("render room.scene -o w%d.png --frames 2 --path X", "json"),
    ("info X", "scene"),
    ("info X", "obj"),
    ("info X", "png"),
    ("diff X check.png", "png"),
    ("diff check.png X", "npy"),
    ("hash X", "png"),
    ("hash X", "npy"),
    ("hash --check X", "txt"),
    ("uv X --report", "obj"),
    ("uv m.obj -o out.obj --map box --cut X", "txt"),
    ("uv m.obj -o out.obj --map box --sew X", "txt"),
    ("uv-raster X -o out --size 8", "obj"),
    ("warp X -o out.png --rotate 1", "png"),
    ("sample X --uv uv.csv -o out.npy", "png"),
    ("sample check.png --uv X -o out.npy", "csv"),
    ("sample check.png --uv X -o out.npy", "npy"),
    ("sample check.png --uv uv.csv --grad X -o out.npy", "csv"),
    ("mip X -o out%d.png", "png"),
    ("env X -o out.png --to cube", "hdr"),
    ("bake X --object a --light --size 8 -o out.png", "scene"),
    ("slice X -o out.png", "npy"),
    ("slice marble --ramp X -o out.png", "png"),
    ("chart X -o out.html", "scene"),
    ("render @X -o w%d.png", "txt"),
    ("render room.scene -o w%d.png --cameras X", "json"),
    ("render m.obj -o out.png --texture X", "png"),
    ("render m.obj -o out.png --env X", "hdr"),
    ("compress X -o out.dds", "png"),
    ("batch X -o out/", "json"),
    ("batch @X -o out/", "txt"),
    (
        "render room.scene -o w%d.png --frames 2 --light-path X",
        "json",
    ),
];

#[test]
fn pipes_devices_and_folders_are_refused_wherever_a_file_is_read() {
    let desk = Desk::new();
    desk.put("uv.csv", "0.5,0.5\n");
    for (line, ending) in READERS {
        for what in ["pipe", "zero", "folder", "missing"] {
            let name = format!("{what}.{ending}");
            let path = desk.path(&name);
            if !path.is_symlink() && !path.exists() {
                match what {
                    "pipe" => drop(Command::new("mkfifo").arg(&path).status().unwrap()),
                    "zero" => symlink("/dev/zero", &path).unwrap(),
                    "folder" => std::fs::create_dir(&path).unwrap(),
                    _ => {}
                }
            }
            let line = line.replace('X', &name);
            let code = match what {
                "missing" => "error[file-missing]: ",
                _ => "error[not-a-file]: ",
            };
            desk.refused(&line, 4, code);
        }
    }
}

#[test]
fn reports_of_shards_and_what_they_name_are_regular_files_in_their_folder() {
    let desk = Desk::new();
    let report = desk.path("out/.texmap/report.jsonl");
    std::fs::create_dir_all(desk.path("out/.texmap")).unwrap();
    symlink("/dev/zero", &report).unwrap();
    desk.refused("merge out -o all", 4, "error[not-a-file]: ");
    std::fs::remove_file(&report).unwrap();
    let head = "{\"texmap\":\"0\",\"schema\":1,\"verb\":\"render\",\"shard\":\"1/1\",\"folder\":\"..\",\"units\":1,\
                \"units_hash\":\"a\",\"settings_hash\":\"b\"}\n";
    let unit = |more: &str| {
        format!(
            "{head}{{\"id\":\"a\",\"index\":0,\"status\":\"ok\",\"code\":0,\"input\":\"a.obj\",\"warnings\":[],\"ms\":1,\
             \"settings_hash\":\"c\",\"texmap\":\"0\"{more}}}\n"
        )
    };
    let output = |path: &str| {
        let mark = "\"bytes\":0,\"hash\":\"blake3:af1349b9f5f9a1a6a0404dea36dcc949\"";
        unit(&format!(",\"outputs\":[{{\"path\":\"{path}\",{mark}}}]"))
    };
    let pipe = desk.path("out/pipe.png");
    Command::new("mkfifo").arg(&pipe).status().unwrap();
    desk.put("out/empty.png", "");
    desk.put("stray.png", "");
    for (text, code) in [
        (output("pipe.png"), "error[shard-output]: "),
        (output("../stray.png"), "error[shard-output]: "),
        (
            unit(",\"band\":{\"picture\":\"a.png\",\"index\":1,\"count\":1}"),
            "error[shard-report]: ",
        ),
        (
            head.replace(":1,\"units_hash", ":18446744073709551615,\"units_hash"),
            "error[not-complete]: ",
        ),
    ] {
        desk.put("out/.texmap/report.jsonl", &text);
        let exit = if code.contains("complete") { 75 } else { 4 };
        desk.refused("merge out -o all", exit, code);
    }
    desk.put("out/.texmap/report.jsonl", output("empty.png"));
    desk.texmap("merge out -o all").ok();
}

#[test]
fn no_verb_quotes_a_file_that_it_was_not_made_for() {
    let desk = Desk::new();
    let secret = "v hunter2 hunter2 hunter2\nf hunter2/1 hunter2 hunter2\n1 hunter2\n";
    desk.put("uv.csv", "0.5,0.5\n");
    for (line, ending) in READERS {
        // A name that says what is in it is quoted, so that its author can mend it.
        if matches!(ending, "scene" | "obj") && !line.starts_with("uv") {
            continue;
        }
        // So are the names of a list.
        if line.contains('@') {
            continue;
        }
        let ending = if ending == "obj" { "cfg" } else { ending };
        let name = format!("secret.{ending}");
        desk.put(&name, secret);
        let run = desk.texmap(&line.replace('X', &name));
        assert_eq!(run.code, 4, "{line}: {}", run.stderr);
        assert!(!run.stderr.contains("hunter2"), "{line}: {}", run.stderr);
    }
    desk.put("room.scene", "include secret.cfg\nobj secret.cfg\n");
    for line in ["render room.scene -o out.png", "info room.scene --json"] {
        let run = desk.texmap(line);
        assert_eq!(run.code, 4, "{line}: {}", run.stderr);
        let said = run.stderr + &String::from_utf8_lossy(&run.stdout);
        assert!(!said.contains("hunter2"), "{line}: {said}");
    }
}

#[test]
fn a_root_is_a_flag_of_every_verb_that_loads_scenes() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("in")).unwrap();
    desk.put(
        "in/a.scene",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\ninclude ../room.scene\n",
    );
    desk.put("walk.json", "[]");
    for line in [
        "render in/a.scene -o out.png",
        "bake in/a.scene --object a --light --size 8 -o out.png",
        "chart in/a.scene -o out.html",
        "info in/a.scene",
        "info check.png",
        "render room.scene -o out.png",
        "render in/a.scene -o w%d.png --frames 2 --path walk.json",
    ] {
        desk.refused(&format!("{line} --root in"), 4, "error[outside-root]: ");
    }
    desk.refused(
        "info room.scene --root none",
        4,
        "error[file-missing]: none",
    );
    desk.refused(
        "info room.scene --root check.png",
        4,
        "error[read-failed]: check.png",
    );
    desk.texmap("render in/a.scene -o out.png --resolution 16x12 --root .")
        .ok();
}

#[test]
fn names_and_words_of_files_cannot_command_a_terminal() {
    let desk = Desk::new();
    desk.put("a.scene", "eye 0 0 6\nfilter \u{1b}[31m\u{9b}2J\n");
    desk.put(
        "b.obj",
        "o \u{1b}[31mred\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    );
    let odd = "\u{1b}[31m\u{9b}\u{202e}.obj";
    std::fs::copy(desk.path("b.obj"), desk.path(odd)).unwrap();
    for words in [
        &["render", "a.scene", "-o", "out.png"][..],
        &["info", "b.obj"],
        &["info", odd],
        &["info", odd, "--json"],
        &["uv", odd, "--report"],
        &["render", odd, "-o", "out.png", "--resolution", "16x12"],
        &["render", "\u{1b}[31m.scene", "-o", "out.png"],
        &[
            "render",
            "b.obj",
            "-o",
            "\u{1b}[31m.png",
            "--resolution",
            "16x12",
        ],
        &["render", "b.obj", "--\u{1b}[31m"],
    ] {
        let run = crate::program::run(desk.path("").as_path(), words);
        let said = run.stderr + &String::from_utf8_lossy(&run.stdout);
        let raw = said
            .chars()
            .find(|c| (c.is_control() && *c != '\n') || *c == '\u{202e}');
        assert_eq!(raw, None, "{words:?}: {said:?}");
    }
    // Values of JSON are the names themselves, however they are written.
    let run = crate::program::run(desk.path("").as_path(), &["info", odd, "--json"]).ok();
    assert_eq!(run.json()["file"], odd);
}

#[test]
fn words_as_long_as_a_file_are_cut() {
    let desk = Desk::new();
    let word = "Q".repeat(1 << 20);
    desk.put("a.scene", format!("eye 0 0 6\n{word} 1\n"));
    desk.put("b.scene", format!("eye 0 0 6\nfilter {word}\n"));
    desk.put(
        "c.obj",
        format!("o {word}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n{word}\n"),
    );
    desk.put("d.obj", format!("v 0 0 {word}\n"));
    for line in [
        "info a.scene",
        "info b.scene",
        "info c.obj",
        "info d.obj",
        "uv d.obj --report",
        "bake c.obj --object none --light --size 8 -o out.png",
        "render c.obj -o out.png --resolution 16x12",
    ] {
        let run = desk.texmap(line);
        let said = run.stderr + &String::from_utf8_lossy(&run.stdout);
        assert_ne!(run.code, 6, "{line}: {said}");
        assert!(
            !said.contains(&"Q".repeat(201)) && said.len() < 4000,
            "{line}: {} bytes",
            said.len()
        );
    }
    // The table holds names beyond 65,535 characters, which a format width does not.
    desk.texmap("info c.obj").ok();
}

#[test]
fn names_that_are_no_unicode_are_kept() {
    let desk = Desk::new();
    let name = |bytes: &[u8]| OsStr::from_bytes(bytes).to_owned();
    std::fs::rename(desk.path("m.obj"), desk.path("").join(name(b"m\xff.obj"))).unwrap();
    desk.put(
        "walk.json",
        r#"[{"eye":[0,0,9],"look":[0,0,0]},{"eye":[1,0,9],"look":[0,0,0]}]"#,
    );
    let run = |words: &[OsString]| {
        let output = Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
            .args(words)
            .current_dir(desk.path(""))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {said}");
        output.stdout
    };
    let words = |line: &str, odd: &[&[u8]]| -> Vec<OsString> {
        let mut odd = odd.iter();
        let word = |w: &str| {
            if w == "X" {
                name(odd.next().unwrap())
            } else {
                w.into()
            }
        };
        line.split(' ').map(word).collect()
    };
    let listed = run(&words("info X --json", &[b"m\xff.obj"]));
    let listed: serde_json::Value = serde_json::from_slice(&listed).unwrap();
    assert_eq!(listed["file"], "m\u{fffd}.obj");
    run(&words(
        "render X -o X --resolution 16x12 --frames 2 --path walk.json",
        &[b"m\xff.obj", b"\xfe%d.png"],
    ));
    run(&words(
        "render X -o X --resolution 16x12",
        &[b"m\xff.obj", b"out-{model}\xfe.png"],
    ));
    run(&words("render X -o . --resolution 16x12", &[b"m\xff.obj"]));
    run(&words("mip check.png -o X", &[b"l\xff%d.png"]));
    for made in [
        &b"\xfe0.png"[..],
        b"\xfe1.png",
        b"out-m\xff\xfe.png",
        b"m\xff.png",
        b"l\xff0.png",
    ] {
        assert!(
            desk.path("").join(name(made)).is_file(),
            "{}",
            made.escape_ascii()
        );
    }
}

#[test]
fn coordinates_beyond_floats_are_not_written() {
    let desk = Desk::new();
    desk.put("far.obj", "v 0 0 0\nv 3e38 0 0\nv 0 3e38 0\nf 1 2 3\n");
    desk.put(
        "inf.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt inf 0\nvt 0 0\nf 1/2 2/2 3/2\n",
    );
    desk.refused(
        "uv far.obj -o out.obj --map plane --tile 1e-30,1",
        4,
        "error[not-finite]: far.obj:4",
    );
    desk.refused(
        "uv far.obj -o out.obj --map plane --frame 0,0,0,0,0,0,1e-9,1,1",
        4,
        "error[not-finite]: far.obj:4",
    );
    desk.refused("uv inf.obj -o out.obj", 4, "error[not-finite]: inf.obj");
    desk.texmap("uv far.obj -o out.obj --map plane").ok();
}
