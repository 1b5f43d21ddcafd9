//! Property 32: print(parse(x)) is a fixed point; comments, blanks and spacing are no part of a scene.

use std::path::Path;

use proptest::prelude::*;
use texmap_io::scene_file::{
    Alpha, Bias, BoneLine, COMMANDS, Command, DisplaceLine, Effect, EnvironmentLine, Missing, Rate,
    Role, RoundShape, SceneFile, Shade, Shape, Surf, TerrainLine, TexturedCorner, parse, print,
};
use texmap_light::Chart;
use texmap_mesh::SkinBlend;
use texmap_raster::{Cull, Interp};
use texmap_sample::{Cubic, Filter, Wrap};
use texmap_scene::{ColorMode, EdgeBudget, Gouraud};
use texmap_uv::Round;

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

fn float() -> impl Strategy<Value = f32> {
    number().prop_map(|x| x as f32)
}

fn unit() -> impl Strategy<Value = f32> {
    0.0..=1.0_f32
}

fn direction() -> impl Strategy<Value = [f64; 3]> {
    (number(), number(), 0.5..9.0_f64).prop_map(|(x, y, z)| [x, y, z])
}

fn name() -> impl Strategy<Value = String> {
    "[a-zA-Z0-9_./ #é-]{0,12}[a-z]".prop_map(|s| s.trim_start().to_owned())
}

fn camera_and_lights() -> impl Strategy<Value = Command> {
    let positive = || prop::array::uniform3(0.0..4.0_f32);
    let point = || prop::array::uniform3(number());
    prop_oneof![
        point().prop_map(Command::Eye),
        point().prop_map(Command::Look),
        direction().prop_map(Command::Up),
        (0.001..179.9_f64).prop_map(Command::Fov),
        (1e-9..1e9_f64).prop_map(Command::Near),
        prop_oneof![Just(f64::INFINITY), 1.0..1e9_f64].prop_map(Command::Far),
        prop::array::uniform4(unit()).prop_map(Command::Background),
        prop::sample::select(vec![ColorMode::Srgb, ColorMode::Raw]).prop_map(Command::Color),
        positive().prop_map(Command::AmbientLight),
        (positive(), float(), float(), 1.0..2.0_f32).prop_map(|(color, x, y, z)| {
            Command::DirectionalLight {
                color,
                direction: [x, y, z],
            }
        }),
        (positive(), prop::array::uniform3(float()))
            .prop_map(|(color, position)| Command::PointLight { color, position }),
    ]
}

fn settings() -> impl Strategy<Value = Command> {
    let filters = vec![
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Bicubic(Cubic::Mitchell),
        Filter::MipNearest,
        Filter::BilinearMipNearest,
        Filter::Trilinear,
        Filter::Anisotropic(16),
        Filter::ewa(8),
    ];
    let wraps = vec![
        Wrap::Repeat,
        Wrap::MirroredRepeat,
        Wrap::ClampToEdge,
        Wrap::ClampToBorder,
        Wrap::MirrorClampToEdge,
    ];
    let interps = vec![
        Interp::Perspective,
        Interp::Affine,
        Interp::Subdivided(4),
        Interp::Span(16),
        Interp::WithinError(0.5),
        Interp::WithinError(1e-7),
    ];
    let alphas = vec![
        Alpha::Auto,
        Alpha::Opaque,
        Alpha::Test(None),
        Alpha::Test(Some(0.25)),
        Alpha::Blend,
    ];
    let shades = vec![
        Shade {
            role: Some(Role::Decal),
            rate: None,
        },
        Shade {
            role: None,
            rate: Some(Rate::Vertex),
        },
        Shade {
            role: Some(Role::Modulate),
            rate: Some(Rate::Pixel),
        },
    ];
    let wrap = prop::sample::select(wraps);
    prop_oneof![
        prop::sample::select(filters).prop_map(Command::Filter),
        (wrap.clone(), wrap).prop_map(|(u, v)| Command::Wrap(u, v)),
        prop::array::uniform4(unit()).prop_map(Command::Border),
        prop::sample::select(interps).prop_map(Command::Interp),
        prop::sample::select(vec![Cull::None, Cull::Back, Cull::Front]).prop_map(Command::Cull),
        prop::sample::select(alphas).prop_map(Command::Alpha),
        prop::sample::select(shades).prop_map(Command::Shade),
        prop::sample::select(vec![Gouraud::ScreenLinear, Gouraud::Perspective])
            .prop_map(Command::Gouraud),
        prop::sample::select(vec![Missing::Error, Missing::Warn]).prop_map(Command::Missing),
        (
            prop::array::uniform3(unit()),
            prop::array::uniform4(0.0..50.0_f32)
        )
            .prop_map(|(color, [ka, kd, ks, ns])| Command::Surf(Surf {
                color,
                ka,
                kd,
                ks,
                ns
            })),
        prop::array::uniform3(number()).prop_map(Command::Translate),
        (number(), direction()).prop_map(|(angle, axis)| Command::Rotate { angle, axis }),
        prop::array::uniform3(0.1..9.0_f64).prop_map(Command::Scale),
        [0.1..9.0_f64, 0.0..1.0, 0.0..1.0].prop_map(|[x, o, e]| Command::Frame {
            o: [o, e, x],
            u: [x, 0.0, e],
            v: [0.0, x, o],
        }),
        Just(Command::Round(None)),
        (
            prop::bool::ANY,
            prop::array::uniform3(number()),
            prop::array::uniform3(0.1..9.0_f64),
            prop::array::uniform2(1.0..9.0_f64)
        )
            .prop_map(|(sphere, position, size, repeat)| Command::Round(Some(
                RoundShape {
                    shape: if sphere {
                        Round::Sphere
                    } else {
                        Round::Cylinder
                    },
                    position,
                    angles: position,
                    size,
                    repeat,
                }
            ))),
        Just(Command::Push),
        prop::option::of(name()).prop_map(Command::Texture),
        Just(Command::Texture(Some("none".into()))),
        name().prop_map(Command::Obj),
        name().prop_map(Command::Include),
    ]
}

fn shapes() -> impl Strategy<Value = Shape> {
    let point = || prop::array::uniform3(number());
    let budget = prop_oneof![
        (0.01..99.0_f32).prop_map(EdgeBudget::Texels),
        (0.01..99.0_f32).prop_map(EdgeBudget::Pixels),
    ];
    prop_oneof![
        (name(), float(), float(), budget, 1..u32::MAX).prop_map(
            |(file, height, middle, budget, triangles)| Shape::Displace(Some(DisplaceLine {
                file,
                height,
                middle,
                budget,
                triangles,
            }))
        ),
        Just(Shape::Displace(None)),
        (
            name(),
            point(),
            prop::array::uniform3(0.1..9.0_f32),
            1..99_u32
        )
            .prop_map(|(file, position, size, step)| Shape::Terrain(TerrainLine {
                file,
                position,
                size,
                step,
            })),
        (
            point(),
            prop::array::uniform2(0.1..9.0_f64),
            prop::option::of(direction())
        )
            .prop_map(|(position, size, axis)| Shape::Billboard {
                position,
                size,
                axis
            }),
        (
            point(),
            point(),
            prop::option::of(0..9_u32),
            prop::option::of((number(), direction()))
        )
            .prop_map(|(head, tail, parent, turn)| Shape::Bone(BoneLine {
                head,
                tail,
                parent,
                turn
            })),
        Just(Shape::Skin(None)),
        Just(Shape::Skin(Some(SkinBlend::Rigid))),
        (0.1..9.0_f64).prop_map(|width| Shape::Skin(Some(SkinBlend::Smooth(width)))),
    ]
}

const VERTICES: u32 = 9;

fn faces() -> impl Strategy<Value = Command> {
    let corners = || prop::collection::vec(0..VERTICES, 3..8);
    let textured = (0..VERTICES, float(), float())
        .prop_map(|(vertex, u, v)| TexturedCorner { vertex, uv: [u, v] });
    prop_oneof![
        corners().prop_map(Command::Face),
        corners().prop_map(Command::FramedFace),
        prop::collection::vec(textured, 3..8).prop_map(Command::TexturedFace),
    ]
}

fn effects() -> impl Strategy<Value = Effect> {
    let area = (prop::array::uniform3(number()), 1e-9..1e9_f64);
    let bias = prop_oneof![
        (0.0..9.0_f64).prop_map(Bias::Slope),
        (0.0..9.0_f64).prop_map(Bias::Constant),
        (0.0..9.0_f64).prop_map(Bias::NormalOffset),
    ];
    let shadow = (
        prop::option::of(1..16_384_u32),
        prop::sample::select(vec![1, 3, 5, 15_u32]),
        prop::option::of(bias),
        prop::option::of(area),
    );
    let chart = prop::sample::select(vec![Chart::Cube, Chart::LatLong, Chart::Octahedron]);
    let line = (name(), chart, unit(), any::<bool>());
    prop_oneof![
        shadow.prop_map(|(size, taps, bias, area)| Effect::Shadow {
            size,
            taps,
            bias,
            area,
        }),
        any::<bool>().prop_map(Effect::Shadowless),
        any::<bool>().prop_map(|clamp| Effect::Horizon { clamp }),
        prop::option::of(line).prop_map(|line| {
            Effect::Environment(line.map(|(file, chart, share, mips)| EnvironmentLine {
                file,
                chart,
                share,
                mips,
            }))
        }),
    ]
}

/// A file that parses: vertices first, and a `pop` for each `push`.
fn scene() -> impl Strategy<Value = SceneFile> {
    let vertices = prop::collection::vec(
        prop::array::uniform3(number()).prop_map(Command::Vertex),
        VERTICES as usize,
    );
    let rest = prop::collection::vec(
        prop_oneof![
            camera_and_lights(),
            settings(),
            faces(),
            shapes().prop_map(Command::Shape),
            effects().prop_map(Command::Effect)
        ],
        0..30,
    );
    (vertices, rest).prop_map(|(vertices, rest)| {
        let open = rest.iter().filter(|c| **c == Command::Push).count();
        vertices
            .into_iter()
            .chain(rest)
            .chain(std::iter::repeat_n(Command::Pop, open))
            .collect()
    })
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
            let list = !["texture", "obj", "include"]
                .iter()
                .any(|w| line.starts_with(w));
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
    fn printing_and_parsing_lose_nothing(scene in scene()) {
        let text = print(&scene);
        let again = read(&text);
        prop_assert_eq!(commands(&again), commands(&scene));
        prop_assert_eq!(print(&again), text);
    }

    #[test]
    fn comments_blanks_and_broken_lines_do_not_alter_the_scene(scene in scene(), seed in any::<u64>()) {
        let text = print(&scene);
        let scribbled = scribble(&text, seed);
        prop_assert_eq!(commands(&read(&scribbled)), commands(&scene), "{}", scribbled);
    }

    /// The twin: what is not a comment or a blank does alter it.
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
    let mut known = COMMANDS.to_vec();
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
                let place = error.place().expect("a place");
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
