//! Bad inputs: each gives one line that names the position of the fault and one that says what to try, exit
//! code 4, and leaves the existing picture as it was.

use crate::program::{Desk, MODEL, ROOM};

/// `room.scene` with one line replaced or appended.
struct Case {
    name: &'static str,
    /// Arguments after `render`; `-o out.png` is added.
    input: &'static str,
    /// Text that the first line must hold.
    place: &'static str,
    code: &'static str,
    prepare: fn(&Desk),
}

fn case(
    name: &'static str,
    input: &'static str,
    place: &'static str,
    code: &'static str,
    prepare: fn(&Desk),
) -> Case {
    Case {
        name,
        input,
        place,
        code,
        prepare,
    }
}

/// Lines of [`ROOM`], so that an appended line is the next one.
const NEXT: usize = 18;

fn append(desk: &Desk, line: &str) {
    assert_eq!(ROOM.lines().count() + 1, NEXT);
    desk.put("room.scene", format!("{ROOM}{line}\n"));
}

fn replace(desk: &Desk, from: &str, to: &str) {
    assert!(ROOM.contains(from));
    desk.put("room.scene", ROOM.replace(from, to));
}

fn model(desk: &Desk, from: &str, to: &str) {
    assert!(MODEL.contains(from));
    desk.put("m.obj", MODEL.replace(from, to));
}

fn cases() -> Vec<Case> {
    vec![
        case(
            "no such scene",
            "no.scene",
            "no.scene",
            "file-missing",
            |_| {},
        ),
        case(
            "a folder as scene",
            "d.scene",
            "d.scene",
            "not-a-file",
            |d| {
                std::fs::create_dir(d.path("d.scene")).unwrap();
            },
        ),
        case("a folder as model", "d.obj", "d.obj", "not-a-file", |d| {
            std::fs::create_dir(d.path("d.obj")).unwrap();
        }),
        case(
            "an unknown kind of file",
            "m.fbx",
            "m.fbx",
            "unknown-format",
            |d| d.put("m.fbx", "x"),
        ),
        case(
            "binary as scene",
            "room.scene",
            "room.scene:2:1",
            "not-utf8",
            |d| {
                d.put("room.scene", b"eye 0 0 6\n\xff\xfe\x00");
            },
        ),
        case(
            "an empty scene",
            "room.scene",
            "room.scene",
            "empty-scene",
            |d| d.put("room.scene", "# nothing\n"),
        ),
        case(
            "an unknown command",
            "room.scene",
            "room.scene:18:1",
            "unknown-command",
            |d| append(d, "colour red"),
        ),
        case(
            "a number without a command",
            "room.scene",
            "room.scene:1:1",
            "stray-number",
            |d| {
                d.put("room.scene", "0 1 2\n");
            },
        ),
        case(
            "too few values",
            "room.scene",
            "room.scene:1:",
            "argument-count",
            |d| replace(d, "eye 0 1 6", "eye 0 1"),
        ),
        case(
            "a word for a number",
            "room.scene",
            "room.scene:4:5",
            "not-a-number",
            |d| {
                replace(d, "fov 60", "fov wide");
            },
        ),
        case(
            "NaN as a vertex",
            "room.scene",
            "room.scene:18:5",
            "not-finite",
            |d| append(d, "v 0 nan 0"),
        ),
        case(
            "an infinite number",
            "room.scene",
            "room.scene:18:3",
            "not-finite",
            |d| append(d, "v 1e999 0 0"),
        ),
        case(
            "a field of view of 180",
            "room.scene",
            "room.scene:4:5",
            "out-of-range",
            |d| {
                replace(d, "fov 60", "fov 180");
            },
        ),
        case(
            "eye on look",
            "room.scene",
            "room.scene",
            "bad-camera",
            |d| replace(d, "look 0 1 0", "look 0 1 6"),
        ),
        case(
            "up along the line of sight",
            "room.scene",
            "room.scene",
            "bad-camera",
            |d| {
                replace(d, "up 0.2 1 0", "up 0 0 1");
            },
        ),
        case(
            "a face of two corners",
            "room.scene",
            "room.scene:18:",
            "too-few-corners",
            |d| append(d, "f 0 1"),
        ),
        case(
            "a vertex that does not exist",
            "room.scene",
            "room.scene:18:7",
            "bad-index",
            |d| append(d, "f 0 1 999"),
        ),
        case(
            "a texture that does not exist",
            "room.scene",
            "no.png",
            "file-missing",
            |d| {
                replace(d, "texture check.png", "texture no.png");
            },
        ),
        case(
            "a truncated texture",
            "room.scene",
            "cut.png",
            "broken-image",
            |d| {
                d.put("cut.png", &d.read("check.png")[..60]);
                replace(d, "texture check.png", "texture cut.png");
            },
        ),
        case(
            "a texture of size zero",
            "room.scene",
            "zero.png",
            "image-size",
            |d| {
                let mut bytes = d.read("check.png");
                bytes[16..20].fill(0);
                d.put("zero.png", bytes);
                replace(d, "texture check.png", "texture zero.png");
            },
        ),
        case(
            "text as texture",
            "room.scene",
            "t.png",
            "broken-image",
            |d| {
                d.put("t.png", "not a picture");
                replace(d, "texture check.png", "texture t.png");
            },
        ),
        case(
            "a folder as texture",
            "room.scene",
            "t.png",
            "not-a-file",
            |d| {
                std::fs::create_dir(d.path("t.png")).unwrap();
                replace(d, "texture check.png", "texture t.png");
            },
        ),
        case(
            "a textured face without a texture",
            "room.scene",
            "room.scene",
            "needs-line-above",
            |d| {
                replace(d, "texture check.png\n", "");
            },
        ),
        case(
            "a frame of parallel directions",
            "room.scene",
            "room.scene:18:1",
            "degenerate-frame",
            |d| {
                append(d, "frame 0 0 0 1 0 0 2 0 0\nff 0 1 2");
            },
        ),
        case(
            "a framed face without a frame",
            "room.scene",
            "room.scene:18:1",
            "needs-line-above",
            |d| {
                append(d, "ff 0 1 2");
            },
        ),
        case(
            "a scene that includes itself",
            "room.scene",
            "room.scene:18:",
            "include-cycle",
            |d| {
                append(d, "include room.scene");
            },
        ),
        case(
            "a model that does not exist",
            "room.scene",
            "no.obj",
            "file-missing",
            |d| append(d, "obj no.obj"),
        ),
        case(
            "an OBJ index of 10^9",
            "m.obj",
            "m.obj:13:",
            "bad-index",
            |d| {
                model(d, "f 1/1 2/2 3/3 4/4", "f 1/1 2/2 1000000000/3");
            },
        ),
        case(
            "an OBJ index of 0",
            "m.obj",
            "m.obj:16:",
            "bad-index",
            |d| model(d, "f 1 2 5", "f 0 2 5"),
        ),
        case(
            "an OBJ vertex that is NaN",
            "m.obj",
            "m.obj:6:",
            "not-finite",
            |d| model(d, "v 0 0 1", "v 0 nan 1"),
        ),
        case(
            "an OBJ vertex that is a word",
            "m.obj",
            "m.obj:6:",
            "not-a-number",
            |d| model(d, "v 0 0 1", "v 0 x 1"),
        ),
        case(
            "an OBJ face of two corners",
            "m.obj",
            "m.obj:16:",
            "too-few-corners",
            |d| model(d, "f 1 2 5", "f 1 2"),
        ),
        case(
            "an OBJ without faces",
            "m.obj",
            "m.obj",
            "empty-mesh",
            |d| d.put("m.obj", "v 0 0 0\nv 1 0 0\n"),
        ),
        case(
            "an OBJ with an undefined material",
            "m.obj",
            "m.obj:15:",
            "unknown-material",
            |d| {
                model(d, "usemtl plain", "usemtl gold");
            },
        ),
        case(
            "an OBJ whose library is missing",
            "m.obj",
            "no.mtl",
            "file-missing",
            |d| {
                model(d, "mtllib m.mtl", "mtllib no.mtl");
            },
        ),
        case(
            "an OBJ whose map is missing",
            "m.obj",
            "no.png",
            "file-missing",
            |d| {
                d.put("m.mtl", "newmtl paper\nmap_Kd no.png\nnewmtl plain\n");
            },
        ),
        case(
            "a walk that is no list",
            "room.scene --frames 2 --path w.json",
            "w.json:1:",
            "broken-camera-path",
            |d| {
                d.put("w.json", "{}");
            },
        ),
        case(
            "an empty walk",
            "room.scene --frames 2 --path w.json",
            "w.json",
            "broken-camera-path",
            |d| {
                d.put("w.json", "[]");
            },
        ),
        case(
            "a walk through eye = look",
            "room.scene --frames 3 --path w.json",
            "room.scene",
            "render-camera",
            |d| {
                d.put(
                    "w.json",
                    r#"[{"eye":[0,0,2],"look":[0,0,0]},{"eye":[0,0,-2],"look":[0,0,0]}]"#,
                );
            },
        ),
    ]
}

#[test]
fn thirty_and_more_bad_inputs_name_their_place_and_leave_the_old_picture() {
    let cases = cases();
    assert!(cases.len() >= 30, "{} cases", cases.len());
    let mut wrong = Vec::new();
    for case in &cases {
        let desk = Desk::new();
        (case.prepare)(&desk);
        let output = if case.input.contains("--frames") {
            "out%d.png"
        } else {
            "out.png"
        };
        desk.put("out.png", "the old picture");
        desk.put("out0.png", "the old picture");
        let before = desk.names();
        let run = desk.texmap(&format!(
            "render {} --missing error --resolution 32x24 -o {output}",
            case.input
        ));
        let lines: Vec<&str> = run.stderr.lines().collect();
        let mut fault = |what: &str| wrong.push(format!("{}: {what}\n{}", case.name, run.stderr));
        if run.code != 4 {
            fault(&format!("exit code {}", run.code));
        }
        if lines.len() != 2 {
            fault("not two lines");
        }
        if !lines.first().is_some_and(|l| {
            l.starts_with(&format!("error[{}]: ", case.code)) && l.contains(case.place)
        }) {
            fault(&format!(
                "the first line is not error[{}] at {}",
                case.code, case.place
            ));
        }
        if desk.read("out.png") != b"the old picture" || desk.read("out0.png") != b"the old picture"
        {
            fault("the old picture is gone");
        }
        if desk.names() != before {
            fault("files were left behind");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The negative twin: the desk these cases start from is good, and does replace the old picture.
#[test]
fn the_unspoilt_inputs_replace_the_old_picture() {
    for input in ["room.scene", "m.obj"] {
        let desk = Desk::new();
        desk.put("out.png", "the old picture");
        desk.texmap(&format!("render {input} --resolution 32x24 -o out.png"))
            .ok();
        assert!(desk.read("out.png").starts_with(b"\x89PNG"));
    }
}

#[test]
fn errors_are_objects_for_programs() {
    let desk = Desk::new();
    append(&desk, "colour red");
    let run = desk.texmap("render room.scene -o out.png --json");
    let error = &run.json()["error"];
    assert_eq!(error["code"], "unknown-command");
    assert_eq!(error["exit"], 4);
    assert!(error["what"].as_str().unwrap().contains("room.scene:18:1"));
    assert!(!error["why"].as_str().unwrap().is_empty());
}

#[test]
fn wrong_command_lines_end_with_two_and_say_what_is_allowed() {
    let desk = Desk::new();
    for (arguments, hint) in [
        ("", "Usage"),
        ("paint", "paint"),
        ("render", "IN"),
        ("render room.scene", "--output"),
        ("render room.scene -o out.png --resolution 0x5", "1920x1080"),
        ("render room.scene -o out.png --filter blurry", "trilinear"),
        ("render room.scene -o out.png --interp span:0", "span:N"),
        (
            "render room.scene -o out.png --wrap torus",
            "mirrored-repeat",
        ),
        ("render room.scene -o out.png --camera-eye 1,2", "x,y,z"),
        (
            "render room.scene -o out.png --fov 180",
            "between 0 and 180",
        ),
        ("render room.scene -o out.png --background red", "#rrggbb"),
        ("render room.scene -o out.png --aov albedo", "inv_w"),
        ("render room.scene -o out.png --views inside", "front"),
        ("render room.scene -o out.png --level mmx", "sse2"),
        ("render room.scene -o out.png --threads 0", "threads"),
        ("render room.scene -o out%04d.png --frames 3", "--path"),
        (
            "bake room.scene --light --object all --size 8 -o o.png --shadow-taps 2",
            "odd",
        ),
        ("uv cube.obj -o - --map box --json", "do not go together"),
        (
            "uv cube.obj -o - --map box --tangents -",
            "do not go together",
        ),
        (
            "render room.scene -o out.png --path w.json --frames 3",
            "%04d",
        ),
        ("render room.scene -o out%04d.png", "--frames"),
        (
            "render room.scene -o out.bmp",
            ".png, .jpg, .webp, .hdr or .exr",
        ),
        ("render room.scene m.obj -o out.png", "{model}"),
        (
            "render room.scene ./room.scene -o {model}.png",
            "both write",
        ),
        ("render room.scene -o - --json", "--json"),
        ("render room.scene -o - --aov uv", "--aov"),
        ("render check.png -o check.png", "the output is the input"),
        ("demo", "--output"),
    ] {
        let before = desk.names();
        let run = desk.texmap(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(hint), "{arguments}: {}", run.stderr);
        assert!(
            run.stderr.lines().count() <= 2,
            "{arguments}: {}",
            run.stderr
        );
        assert_eq!(desk.names(), before, "{arguments}");
    }
}

#[test]
fn unwritable_outputs_are_found_before_anything_is_read() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("taken.png")).unwrap();
    std::fs::create_dir(desk.path("aov.uv.npy")).unwrap();
    for output in [
        "check.png/such/out.png",
        "m.obj/out.png",
        "check.png/out.jpg/x.png",
    ] {
        let run = desk.texmap(&format!("render no.scene -o {output}"));
        assert_eq!(run.code, 4, "{}", run.stderr);
        assert!(
            run.stderr.starts_with("error[write-failed]: ") && run.stderr.contains(output),
            "{}",
            run.stderr
        );
    }
    // An array whose name is taken by a folder is found too, and nothing is drawn or written.
    let run = desk.texmap("render room.scene --aov uv -o aov.png");
    assert_eq!(run.code, 4, "{}", run.stderr);
    assert!(run.stderr.contains("aov.uv.npy") && !desk.path("aov.png").exists());
}
