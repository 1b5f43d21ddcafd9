//! Property 32: print(parse(x)) is a fixed point; comments, blanks and spacing are no part of a scene.

use std::path::Path;

use proptest::prelude::*;
use proptest::strategy::Union;
use texmap_io::scene_file::{Command, SceneFile, Value, commands as table, parse, print};

use crate::support::Files;

fn read(text: &str) -> SceneFile {
    parse(Path::new("a.scene"), text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Numbers of every size, and those that print in an odd way.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -100.0..100.0_f64,
        (-30.0..30.0_f64).prop_map(|e| 10_f64.powf(e)),
        prop::sample::select(vec![
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.1,
            1e-30,
            3.4e38,
            5e-324,
            1e16,
            1e15,
            123456789.25
        ]),
    ]
}

fn name() -> impl Strategy<Value = String> {
    "[a-zA-Z0-9_./ #é-]{0,12}[a-z]".prop_map(|s| s.trim_start().to_owned())
}

const VERTICES: u32 = 9;

type Line = (&'static str, Vec<Value>);

/// Lines of every command but `v`, as their values.
fn lines() -> Vec<(&'static str, Vec<BoxedStrategy<Value>>)> {
    let any = || number().prop_map(Value::Number).boxed();
    let within = |low: f64, high: f64| (low..high).prop_map(Value::Number).boxed();
    let whole = |low: u32, high: u32| {
        let numbers = low..high;
        numbers.prop_map(|x| Value::Number(f64::from(x))).boxed()
    };
    let float = || number().prop_map(|x| Value::Float(x as f32)).boxed();
    let floats = |low: f32, high: f32| (low..high).prop_map(Value::Float).boxed();
    let unit = || (0.0..=1.0_f32).prop_map(Value::Float).boxed();
    let word = |words: &[&'static str]| {
        let words = prop::sample::select(words.to_vec());
        words.prop_map(Value::Word).boxed()
    };
    let method = |names: &[&'static str]| {
        let names = prop::sample::select(names.to_vec());
        names.prop_map(|name| Value::Name(name.into())).boxed()
    };
    let file = || {
        let names = prop_oneof![name(), Just("none".to_owned()), Just("wood".to_owned())];
        names.prop_map(|name| Value::File(name.into())).boxed()
    };
    let text = || name().prop_map(|text| Value::Text(text.into())).boxed();
    let index = || (0..VERTICES).prop_map(Value::Index).boxed();
    let charts = ["cube", "tan-cube", "lat-long", "octahedron", "sphere-map"];
    let chart = || method(&charts);
    let wraps = [
        "repeat",
        "mirrored-repeat",
        "clamp-to-edge",
        "clamp-to-border",
    ];
    let wrap = || method(&wraps);
    let none = || vec![word(&["none"])];
    let point = || vec![any(), any(), any()];
    let direction = || vec![any(), any(), within(0.5, 9.0)];
    let size = || vec![within(0.1, 9.0), within(-9.0, -0.1), within(0.1, 9.0)];
    let color = || vec![floats(0.0, 4.0), floats(0.0, 4.0), floats(0.0, 4.0)];
    let after = |first: Vec<BoxedStrategy<Value>>, rest: Vec<Vec<BoxedStrategy<Value>>>| {
        first
            .into_iter()
            .chain(rest.into_iter().flatten())
            .collect()
    };
    vec![
        ("eye", point()),
        ("look", point()),
        ("up", direction()),
        ("fov", vec![within(0.001, 179.9)]),
        ("near", vec![within(1e-9, 1e9)]),
        ("far", vec![within(1.0, 1e9)]),
        ("far", vec![word(&["infinite"])]),
        ("background", vec![unit(), unit(), unit()]),
        ("background", vec![unit(), unit(), unit(), unit()]),
        ("color", vec![word(&["srgb", "raw"])]),
        ("la", color()),
        (
            "ld",
            after(color(), vec![vec![float(), float(), floats(1.0, 2.0)]]),
        ),
        ("lp", after(color(), vec![vec![float(), float(), float()]])),
        (
            "surf",
            after(vec![unit(), unit(), unit(), unit()], vec![color()]),
        ),
        ("f", vec![index(), index(), index(), index()]),
        ("ff", vec![index(), index(), index()]),
        ("texture", vec![file()]),
        ("texture", none()),
        (
            "tf",
            after(
                Vec::new(),
                (0..4).map(|_| vec![index(), float(), float()]).collect(),
            ),
        ),
        (
            "frame",
            vec![any(), any(), any()]
                .into_iter()
                .chain([within(1.0, 9.0), within(0.0, 1e-3), within(0.0, 1e-3)])
                .chain([within(0.0, 1e-3), within(1.0, 9.0), within(0.0, 1e-3)])
                .collect(),
        ),
        (
            "uv-projection",
            after(
                vec![word(&["sphere", "cylinder"])],
                vec![point(), point(), size()],
            ),
        ),
        (
            "uv-projection",
            after(
                vec![word(&["sphere", "cylinder"])],
                vec![
                    point(),
                    point(),
                    size(),
                    vec![within(1.0, 9.0), within(1.0, 9.0)],
                ],
            ),
        ),
        ("uv-projection", none()),
        (
            "filter",
            vec![method(&[
                "nearest",
                "bilinear",
                "bicubic:mitchell",
                "mip-nearest",
                "bilinear-mip-nearest",
                "trilinear",
                "anisotropic:16",
                "ewa:8",
                "ewa:16:0.75",
            ])],
        ),
        ("wrap", vec![wrap()]),
        ("wrap", vec![wrap(), wrap()]),
        ("border", vec![unit(), unit(), unit(), unit()]),
        (
            "interp",
            vec![method(&[
                "perspective",
                "affine",
                "subdivided:4",
                "span:16",
                "within:0.5",
                "within:1e-7",
            ])],
        ),
        ("cull", vec![word(&["none", "back", "front"])]),
        ("alpha", vec![word(&["auto", "opaque", "test", "blend"])]),
        ("alpha", vec![word(&["test"]), floats(0.01, 1.0)]),
        (
            "shade",
            vec![word(&["decal", "modulate", "vertex", "pixel"])],
        ),
        (
            "shade",
            vec![word(&["decal", "modulate"]), word(&["vertex", "pixel"])],
        ),
        (
            "shade",
            vec![word(&["vertex", "pixel"]), word(&["decal", "modulate"])],
        ),
        ("gouraud", vec![word(&["screen", "perspective"])]),
        ("missing", vec![word(&["error", "warn"])]),
        ("translate", point()),
        ("rotate", after(vec![any()], vec![direction()])),
        ("scale", size()),
        ("scale", vec![within(0.1, 9.0)]),
        ("push", Vec::new()),
        ("pop", Vec::new()),
        ("obj", vec![file()]),
        ("include", vec![file()]),
        (
            "ls",
            after(
                color(),
                vec![
                    vec![
                        float(),
                        float(),
                        float(),
                        float(),
                        float(),
                        floats(1.0, 2.0),
                    ],
                    vec![floats(0.0, 20.0), floats(20.0, 180.0)],
                ],
            ),
        ),
        ("name", vec![method(&["sun-2", "lamp_1"])]),
        ("shadow", Vec::new()),
        (
            "shadow",
            vec![
                word(&["auto"]),
                word(&["slope", "constant"]),
                within(0.0, 9.0),
            ],
        ),
        (
            "shadow",
            after(
                vec![
                    whole(1, 16_384),
                    word(&["taps"]),
                    method_number(&[1, 3, 5, 15]),
                ],
                vec![
                    vec![word(&["normal-offset"]), within(0.0, 9.0), word(&["area"])],
                    vec![any(), any(), any(), within(1e-9, 1e9)],
                ],
            ),
        ),
        ("shadowless", vec![word(&["yes", "no"])]),
        (
            "projector",
            after(
                vec![file(), word(&["light", "paint"])],
                vec![
                    point(),
                    point(),
                    point(),
                    vec![within(1.0, 179.0), word(&["black", "clamp", "repeat"])],
                    vec![word(&["soft"]), floats(0.0, 0.5), word(&["color"])],
                    color(),
                    vec![word(&["shadow"]), whole(1, 16_384)],
                ],
            ),
        ),
        ("highlight", vec![word(&["phong", "blinn"])]),
        ("env", vec![file(), chart(), unit()]),
        ("env", vec![file(), chart(), unit(), word(&["mips"])]),
        ("env", none()),
        ("specmap", vec![file(), chart(), floats(0.0, 99.0)]),
        ("specmap", none()),
        ("lightmap", vec![file()]),
        ("lightmap", vec![file(), floats(0.0, 99.0)]),
        ("lightmap", none()),
        ("lightmapuv", vec![file()]),
        ("lightmapuv", none()),
        ("emission", color()),
        ("emission", after(color(), vec![vec![file()]])),
        ("emission", none()),
        ("bump", vec![file(), float()]),
        ("bump", none()),
        ("offsetmap", vec![file(), float()]),
        ("offsetmap", vec![file(), float(), word(&["up", "down"])]),
        ("offsetmap", none()),
        (
            "procedural-bump",
            after(
                vec![word(&["waves", "noise", "marble", "wood"]), float()],
                vec![
                    point(),
                    size(),
                    vec![
                        word(&["around"]),
                        whole(1, 65_535),
                        word(&["octaves"]),
                        whole(1, 16),
                    ],
                    vec![word(&["fold"]), float()],
                ],
            ),
        ),
        ("procedural-bump", none()),
        ("emboss", vec![text(), float()]),
        ("emboss", none()),
        (
            "normalmap",
            vec![
                file(),
                word(&["up", "down"]),
                word(&["xyz", "xy"]),
                word(&["tangent", "object"]),
            ],
        ),
        ("normalmap", none()),
        ("horizon", vec![word(&["clamp", "open"])]),
        (
            "displace",
            vec![
                file(),
                float(),
                word(&["middle"]),
                float(),
                word(&["texels", "pixels"]),
                floats(0.01, 99.0),
                word(&["triangles"]),
                whole(1, u32::MAX),
            ],
        ),
        ("displace", none()),
        (
            "terrain",
            after(
                vec![file()],
                vec![
                    point(),
                    vec![floats(0.1, 9.0), float(), floats(0.1, 9.0)],
                    vec![word(&["step"]), whole(1, 99)],
                ],
            ),
        ),
        (
            "billboard",
            after(point(), vec![vec![within(0.1, 9.0), within(0.1, 9.0)]]),
        ),
        (
            "billboard",
            after(
                point(),
                vec![
                    vec![within(0.1, 9.0), within(0.1, 9.0), word(&["axis"])],
                    direction(),
                ],
            ),
        ),
        ("bone", after(point(), vec![point()])),
        (
            "bone",
            after(
                point(),
                vec![
                    point(),
                    vec![word(&["parent"]), whole(0, 9), word(&["turn"]), any()],
                    direction(),
                ],
            ),
        ),
        ("skin", vec![word(&["rigid", "none"])]),
        ("skin", vec![word(&["smooth"]), within(0.1, 9.0)]),
        (
            "solid",
            after(
                vec![word(&["marble", "wood", "noise"])],
                vec![point(), size()],
            ),
        ),
        (
            "solid",
            after(
                vec![file()],
                vec![
                    point(),
                    size(),
                    vec![word(&["octaves"]), whole(1, 16), word(&["fold"]), float()],
                ],
            ),
        ),
        ("solid", none()),
        ("ramp", vec![file()]),
        ("ramp", none()),
        ("cel", vec![file()]),
        ("cel", none()),
        ("decal", vec![file()]),
        (
            "decal",
            vec![file(), float(), float(), floats(0.1, 9.0), floats(0.1, 9.0)],
        ),
        ("decal", none()),
        (
            "font",
            vec![file(), whole(1, 99), whole(1, 99), whole(0, 999)],
        ),
        ("font", none()),
        (
            "text",
            after(vec![text()], vec![point(), direction(), direction()]),
        ),
        ("sky", vec![file()]),
        ("sky", vec![file(), chart()]),
        ("sky", none()),
        (
            "volume",
            after(vec![file()], vec![point(), size(), vec![floats(0.0, 9.0)]]),
        ),
        (
            "volume",
            after(
                vec![file()],
                vec![
                    point(),
                    size(),
                    vec![floats(0.0, 9.0), word(&["step"]), floats(0.01, 9.0)],
                ],
            ),
        ),
    ]
}

fn method_number(numbers: &[u32]) -> BoxedStrategy<Value> {
    let numbers = prop::sample::select(numbers.to_vec());
    numbers.prop_map(|x| Value::Number(f64::from(x))).boxed()
}

/// A file that parses: vertices first, and a `pop` for each `push`.
fn scene() -> impl Strategy<Value = Vec<Line>> {
    let vertex = prop::array::uniform3(number());
    let vertex = vertex.prop_map(|p| ("v", p.map(Value::Number).to_vec()));
    let vertices = prop::collection::vec(vertex, VERTICES as usize);
    let rest = lines()
        .into_iter()
        .filter(|(word, _)| *word != "pop")
        .map(|(word, values)| values.prop_map(move |values| (word, values)).boxed());
    let rest = prop::collection::vec(Union::new(rest), 0..30);
    (vertices, rest).prop_map(|(vertices, rest)| {
        let open = rest.iter().filter(|(word, _)| *word == "push").count();
        let pops = std::iter::repeat_n(("pop", Vec::new()), open);
        vertices.into_iter().chain(rest).chain(pops).collect()
    })
}

/// The lines as somebody may write them: names in quotes, numbers as Rust shows them.
fn written(lines: &[Line]) -> String {
    let mut text = String::new();
    for (word, values) in lines {
        text += word;
        for value in values {
            text += &match value {
                Value::Number(x) => format!(" {x:?}"),
                Value::Float(x) => format!(" {x:?}"),
                Value::Index(i) => format!(" {i}"),
                Value::Word(word) => format!(" {word}"),
                Value::Name(name) => format!(" {name}"),
                Value::File(name) | Value::Text(name) => format!(" \"{name}\""),
            };
        }
        text.push('\n');
    }
    text
}

/// The same scene in another hand: other blanks, comments, and lines broken before numbers.
fn scribble(text: &str, mut seed: u64) -> String {
    let mut next = move |n: u64| {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 33) % n
    };
    let mut out = String::from("\u{feff}# a scene\n")
        .trim_start_matches('\u{feff}')
        .to_owned();
    for line in text.lines() {
        if next(3) == 0 {
            out.push_str(["\n", "  \t\n", "# v 1 2 3\n", "   # \"not a quote\n"][next(4) as usize]);
        }
        out.push_str(["", " ", "\t\t", "      "][next(4) as usize]);
        let mut quoted = false;
        let mut chars = line.chars().peekable();
        while let Some(c) = chars.next() {
            quoted ^= c == '"';
            if c != ' ' || quoted {
                out.push(c);
                continue;
            }
            let number = chars
                .peek()
                .is_some_and(|c| c.is_ascii_digit() || *c == '-');
            // A path may begin with a digit or a dash, so only lists of numbers are broken.
            let list = line.split(' ').all(|word| {
                !word.starts_with(|c: char| c.is_ascii_digit() || c == '-')
                    || word.parse::<f64>().is_ok()
            });
            match next(6) {
                0 if number && list => out.push_str("\n  "),
                1 if number && list => out.push_str(" # to be continued\n\n\t"),
                2 => out.push_str("   "),
                3 => out.push('\t'),
                _ => out.push(' '),
            }
        }
        out.push_str(["\n", "  \n", " # end\n", "\r\n"][next(4) as usize]);
    }
    out
}

fn commands(file: &SceneFile) -> Vec<Command> {
    file.commands().cloned().collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn printing_and_parsing_lose_nothing(lines in scene()) {
        let scene = read(&written(&lines));
        let values: Vec<Line> =
            scene.commands().map(|c| (c.word(), c.values().to_vec())).collect();
        prop_assert_eq!(&values, &lines);
        let text = print(&scene);
        let again = read(&text);
        prop_assert_eq!(commands(&again), commands(&scene));
        prop_assert_eq!(print(&again), text);
    }

    #[test]
    fn comments_blanks_and_broken_lines_do_not_alter_the_scene(lines in scene(), seed in any::<u64>()) {
        let scene = read(&written(&lines));
        let scribbled = scribble(&print(&scene), seed);
        prop_assert_eq!(commands(&read(&scribbled)), commands(&scene), "{}", scribbled);
    }

    /// The negative twin: a change that is neither a comment nor a blank does alter it.
    #[test]
    fn a_changed_number_alters_the_scene(x in 0_u32..1000, y in 0_u32..1000) {
        let text = |n: u32| format!("v 1 {n}.5 2 # {x}");
        prop_assert_eq!(x == y, commands(&read(&text(x))) == commands(&read(&text(y))));
    }

    #[test]
    fn a_polygon_of_n_corners_is_a_fan_of_n_less_two(n in 3_u32..40) {
        let mut text = String::new();
        for i in 0..n {
            let angle = f64::from(i) / f64::from(n) * 6.0;
            text += &format!("v {} {} 0\n", angle.cos(), angle.sin());
        }
        let list: Vec<_> = (0..n).map(|i| i.to_string()).collect();
        text += &format!("f {}\n", list.join(" "));
        let scene = Files::new().scene(&text);
        let triangles = &scene.meshes[0].triangles;
        prop_assert_eq!(triangles.len() as u32, n - 2);
        for (k, t) in (1..).zip(triangles) {
            prop_assert_eq!(*t, [0, k, k + 1]);
        }
        prop_assert!(scene.meshes[0].faces.iter().all(|f| *f == 0));
    }
}

/// docs/SCENE_FORMAT.md has a table row for each command and for nothing else, and its example is right.
#[test]
fn the_manual_lists_every_command() {
    let manual = include_str!("../../../docs/SCENE_FORMAT.md");
    let mut listed: Vec<&str> = manual
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` |"))
        .map(|(word, _)| word)
        .collect();
    let mut known: Vec<_> = table().map(|spec| spec.word).collect();
    listed.sort_unstable();
    known.sort_unstable();
    assert_eq!(listed, known);

    let example = manual.split("```").nth(1).expect("an example");
    let scene = Files::new()
        .with_png("brick.png", 4, 4, [150, 60, 40, 255])
        .scene(example);
    assert_eq!(scene.meshes[0].uvs[0], [0.0, 2.0]);
}

#[test]
fn lines_of_every_command_are_tried() {
    let mut tried: Vec<_> = lines().iter().map(|(word, _)| *word).collect();
    tried.push("v");
    for spec in table() {
        assert!(tried.contains(&spec.word), "{}", spec.word);
    }
}

#[test]
fn garbage_is_refused_and_never_panics() {
    let words = [
        "v", "f", "tf", "ff", "frame", "texture", "1", "-1", "nan", "\"", "#", "\n", "1e999",
        "push", "obj", "é",
    ];
    let mut seed = 1_u64;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..8 {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            text.push_str(words[(seed >> 40) as usize % words.len()]);
            text.push(if seed >> 63 == 0 { ' ' } else { '\n' });
        }
        match parse(Path::new("a.scene"), &text) {
            Ok(file) => assert_eq!(print(&read(&print(&file))), print(&file)),
            Err(error) => {
                let place = error.location().expect("a place");
                let lines = text.lines().count() as u32;
                assert!(
                    (1..=lines).contains(&place.line) && place.column >= 1,
                    "{error}\n{text}"
                );
                assert!(!error.to_string().contains('\n') && !error.help().contains('\n'));
            }
        }
    }
}
