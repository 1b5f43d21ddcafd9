//! Skins, morph targets and animations.

use texmap_io::LoadOptions;
use texmap_scene::Scene;

use super::{TRIANGLE, asset, near, read_with, small, triangle_bytes, world};

fn at(animation: Option<&str>, time: Option<f64>) -> Scene {
    let options = LoadOptions {
        animation: animation.map(Into::into),
        time,
        ..LoadOptions::default()
    };
    read_with("bent.glb", options).unwrap_or_else(|e| panic!("{e}"))
}

/// Corners of the strip by the angle of its upper half and its additional width at each side.
fn strip(degrees: f64, swollen: f64) -> Vec<[f64; 3]> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let corner = |row: i32, side: f64| {
        let (x, y) = (side * (0.25 + swollen * 0.5), 0.5 * f64::from(row));
        let upper = [x * cos + (y - 1.0) * sin, 1.0 + (y - 1.0) * cos - x * sin];
        let share = (0.5 * f64::from(row) - 0.5).clamp(0.0, 1.0);
        [x + (upper[0] - x) * share, y + (upper[1] - y) * share, 0.0]
    };
    (0..=4)
        .flat_map(|row| [corner(row, -1.0), corner(row, 1.0)])
        .collect()
}

#[test]
fn joints_and_weights_follow_their_curves() {
    let rest = world(&at(None, None).meshes[0]);
    assert!(near(&rest, &strip(0.0, 0.0), 1e-6), "{rest:?}");
    for (time, degrees, swollen) in [
        (0.0, 0.0, 0.0),
        (-1.0, 0.0, 0.0),
        // A quarter of the way: the turn is even, the spline begins with a slope of 1 and ends level, 2s - s^2.
        (0.5, 22.5, 0.4375),
        (1.0, 45.0, 0.75),
        (2.0, 90.0, 1.0),
        (7.0, 90.0, 1.0),
    ] {
        let found = world(&at(None, Some(time)).meshes[0]);
        assert!(
            near(&found, &strip(degrees, swollen), 1e-5),
            "{time}: {found:?}"
        );
        if time == 0.5 {
            for other in [0.25, 0.15625] {
                let (line, level) = (
                    strip(degrees, other),
                    "neither a line nor a spline with level ends",
                );
                assert!(!near(&found, &line, 1e-3), "{level}");
            }
        }
    }
}

/// Two quaternions of the upper joint at a quarter of the way would, on a straight line, be late.
#[test]
fn a_turn_has_even_speed() {
    let quarter = world(&at(None, Some(0.5)).meshes[0]);
    let [left, right] = [quarter[8], quarter[9]];
    let degrees = (left[1] - right[1]).atan2(right[0] - left[0]).to_degrees();
    assert!((degrees - 22.5).abs() < 1e-3, "{degrees}");
}

#[test]
fn an_animation_is_chosen_by_name_or_number() {
    let moved = |name: &str, time: f64| world(&at(Some(name), Some(time)).meshes[0])[0][0];
    for name in ["jump", "1"] {
        assert!(
            (moved(name, 1.999) + 0.25).abs() < 1e-6,
            "a step holds until its next key"
        );
        assert!((moved(name, 2.0) - 2.75).abs() < 1e-6);
    }
    let options = LoadOptions {
        animation: Some("walk".into()),
        ..LoadOptions::default()
    };
    let error = read_with("bent.glb", options).unwrap_err();
    assert_eq!(
        error.help(),
        "there are: 0 'bend', 1 'jump' (`texmap info` lists them)"
    );
    let options = LoadOptions {
        time: Some(1.0),
        ..LoadOptions::default()
    };
    let scene = read_with("box.glb", options).expect("a box");
    assert!(
        scene.warnings[0].contains("has no animation"),
        "{:?}",
        scene.warnings
    );
}

/// Normals turn with the skin: at the top they would stay if only positions were moved.
#[test]
fn normals_turn_with_joints() {
    let scene = at(None, Some(0.5));
    let mesh = &scene.meshes[0];
    assert!(
        mesh.normals.iter().all(|n| (n[2] - 1.0).abs() < 1e-6),
        "a turn about z leaves z"
    );
    assert!(
        mesh.triangles.iter().all(|t| mesh.cross(*t).z > 0.0),
        "fronts stay fronts"
    );
}

/// A triangle with a normal map, a tangent along X, a target that adds to it and a joint that turns by a quarter about Z.
fn with_tangents(tangent: [f32; 3], weight: f64, skinned: bool) -> Scene {
    let mut bytes = triangle_bytes();
    let mut views = String::new();
    let mut accessors = String::new();
    let mut add = |data: Vec<u8>, component: u32, kind: &str| {
        views += &format!(
            r#",{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#,
            bytes.len(),
            data.len()
        );
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        if component > 0 {
            accessors += &format!(
                r#",{{"bufferView":{},"componentType":{component},"count":3,"type":"{kind}"}}"#,
                1 + views.matches("byteOffset").count()
            );
        }
    };
    let floats = |values: &[f32]| -> Vec<u8> {
        let thrice = values.repeat(3);
        thrice.iter().flat_map(|x| x.to_le_bytes()).collect()
    };
    let [x, y, z] = tangent;
    add(floats(&[0.0, 0.0, 1.0]), 5126, "VEC3");
    add(floats(&[x, y, z, -1.0]), 5126, "VEC4");
    add(floats(&[-1.0, 2.0, 0.0]), 5126, "VEC3");
    add(vec![0; 12], 5121, "VEC4");
    add(floats(&[1.0, 0.0, 0.0, 0.0]), 5126, "VEC4");
    add(floats(&[0.0, 0.0]), 5126, "VEC2");
    let picture = std::fs::read(asset("leaf card.png")).expect("a picture");
    add(picture, 0, "");
    let skin = if skinned { r#""skin":0,"# } else { "" };
    let json = TRIANGLE
        .replace(
            r#"[{"mesh":0}]"#,
            &format!(
                r#"[{{{skin}"mesh":0,"weights":[{weight}]}},{{"rotation":[0,0,0.7071067811865476,0.7071067811865476]}}],
"skins":[{{"joints":[1]}}],"materials":[{{"normalTexture":{{"index":0}}}}],"textures":[{{"source":0}}],
"images":[{{"bufferView":8,"mimeType":"image/png"}}]"#
            ),
        )
        .replace(
            r#""POSITION":0},"#,
            r#""POSITION":0,"NORMAL":2,"TANGENT":3,"JOINTS_0":5,"WEIGHTS_0":6,"TEXCOORD_0":7},"material":0,"targets":[{"TANGENT":4}],"#,
        )
        .replace(r#""byteLength":44}"#, &format!(r#""byteLength":{}}}"#, bytes.len()))
        .replace(r#""byteLength":6}"#, &format!(r#""byteLength":6}}{views}"#))
        .replace(r#""type":"SCALAR"}"#, &format!(r#""type":"SCALAR"}}{accessors}"#));
    small(&json, &bytes).unwrap_or_else(|e| panic!("{e}\n{json}"))
}

#[test]
fn tangents_follow_targets_and_joints() {
    let along = |scene: &Scene| -> [f32; 4] {
        let [x, y, z, sign] = scene.meshes[0].tangents[0];
        [x, y, z, sign].map(|c| (c * 1e5).round() / 1e5)
    };
    let x = [1.0, 0.0, 0.0];
    assert_eq!(along(&with_tangents(x, 0.0, false)), [1.0, 0.0, 0.0, -1.0]);
    assert_eq!(along(&with_tangents(x, 0.5, false)), [0.5, 1.0, 0.0, -1.0]);
    assert_eq!(along(&with_tangents(x, 0.0, true)), [0.0, 1.0, 0.0, -1.0]);
    // A quarter turn of (0, 2, 0), of unit length.
    assert_eq!(along(&with_tangents(x, 1.0, true)), [-1.0, 0.0, 0.0, -1.0]);
    let none = with_tangents([0.0; 3], 0.0, false);
    assert!(none.meshes[0].tangents.is_empty());
    assert!(
        none.warnings
            .iter()
            .any(|w| w.contains("tangents of no length")),
        "{:?}",
        none.warnings
    );
}
