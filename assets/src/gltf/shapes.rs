//! Models that are no plates: a strip that bends, strips and fans, balls.

use serde_json::{Value, json};
use texmap_math::deterministic_f64::{cos, sin};

use super::file::Buffer;

/// A strip of four squares on two joints, which also swells: the upper joint turns by a quarter (linear), a node jumps (step), and the
/// weight of the swelling follows a spline.
pub(super) fn bent() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let rows = 0..=4_u16;
    let y = |row: u16| 0.5 * f32::from(row);
    let positions: Vec<[f32; 3]> = rows
        .clone()
        .flat_map(|r| [[-0.25, y(r), 0.0], [0.25, y(r), 0.0]])
        .collect();
    let swollen: Vec<[f32; 3]> = rows
        .clone()
        .flat_map(|_| [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
        .collect();
    // The lower half hangs on the first joint, the upper on the second, the middle on both.
    let share = |row: u16| (0.5 * f32::from(row) - 0.5).clamp(0.0, 1.0);
    let weights: Vec<[f32; 4]> = rows
        .clone()
        .flat_map(|r| [[1.0 - share(r), share(r), 0.0, 0.0]; 2])
        .collect();
    let joints = buffer.view(&[0, 1, 0, 0].repeat(10));
    let joints = buffer.accessor(
        json!({"bufferView": joints, "componentType": 5121, "count": 10, "type": "VEC4"}),
    );
    let indices: Vec<u16> = (0..4)
        .flat_map(|r| [0, 1, 3, 0, 3, 2].map(|i| 2 * r + i))
        .collect();
    let at_rest = |y: f32| {
        let mut matrix = [0.0; 16];
        (matrix[0], matrix[5], matrix[10], matrix[15]) = (1.0, 1.0, 1.0, 1.0);
        matrix[13] = -y;
        matrix
    };
    let attributes = json!({
        "POSITION": buffer.floats(&positions),
        "NORMAL": buffer.floats(&[[0.0, 0.0, 1.0]; 10]),
        "JOINTS_0": joints,
        "WEIGHTS_0": buffer.floats(&weights),
    });
    let target = buffer.floats(&swollen);
    let indices = buffer.indices(&indices);
    let matrices = buffer.floats(&[at_rest(0.0), at_rest(1.0)]);
    let half = std::f64::consts::FRAC_PI_4;
    let turned = [0.0, 0.0, -sin(half) as f32, cos(half) as f32];
    let times = buffer.floats(&[[0.0], [2.0]]);
    let turns = buffer.floats(&[[0.0, 0.0, 0.0, 1.0], turned]);
    let jumps = buffer.floats(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    // Tangent before, value, tangent after.
    let swells = buffer.floats(&[[0.0], [0.0], [1.0], [0.0], [1.0], [0.0]]);
    buffer.glb(json!({
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "strip", "mesh": 0, "skin": 0},
            {"name": "root", "children": [2]},
            {"name": "upper", "translation": [0.0, 1.0, 0.0]},
        ],
        "skins": [{"inverseBindMatrices": matrices, "joints": [1, 2]}],
        "meshes": [{"name": "strip", "weights": [0.0], "primitives": [
            {"attributes": attributes, "indices": indices, "material": 0, "targets": [{"POSITION": target}]},
        ]}],
        "materials": [{"name": "strip", "doubleSided": true, "pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.3, 0.1, 1.0], "metallicFactor": 0.0,
        }}],
        "animations": [
            {"name": "bend", "channels": [
                {"sampler": 0, "target": {"node": 2, "path": "rotation"}},
                {"sampler": 1, "target": {"node": 0, "path": "weights"}},
            ], "samplers": [
                {"input": times, "output": turns},
                {"input": times, "output": swells, "interpolation": "CUBICSPLINE"},
            ]},
            {"name": "jump", "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
             "samplers": [{"input": times, "output": jumps, "interpolation": "STEP"}]},
        ],
    }))
}

/// A strip, a fan, lines and points; one corner of the strip is moved by a sparse accessor, and the fan has colours.
pub(super) fn sparse() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let ladder: Vec<[f32; 3]> = (0..6_u16)
        .map(|i| [0.5 * f32::from(i / 2), 1.0 - f32::from(i % 2), 0.0])
        .collect();
    let moved = buffer.view(&5_u16.to_le_bytes());
    let place: Vec<u8> = [1.5_f32, -0.5, 0.25]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    let place = buffer.view(&place);
    let plain = buffer.floats(&ladder);
    let bent = buffer.accessor(json!({
        "bufferView": 2, "componentType": 5126, "count": 6, "type": "VEC3", "min": [0.0, -0.5, 0.0], "max": [1.5, 1.0, 0.25],
        "sparse": {"count": 1, "indices": {"bufferView": moved, "componentType": 5123}, "values": {"bufferView": place}},
    }));
    let fan = buffer.floats(&[
        [2.0, 0.0, 0.0],
        [3.0, 0.0, 0.0],
        [3.2, 0.8, 0.0],
        [2.5, 1.3, 0.0],
        [1.8, 0.8, 0.0],
    ]);
    let colors = [
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [255, 255, 0],
        [0, 255, 255],
    ];
    let colors: Vec<u8> = colors
        .into_iter()
        .flat_map(|[r, g, b]: [u8; 3]| [r, g, b, 255])
        .collect();
    let colors = buffer.view(&colors);
    let colors = buffer.accessor(json!({
        "bufferView": colors, "componentType": 5121, "normalized": true, "count": 5, "type": "VEC4",
    }));
    buffer.embedded(json!({
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"name": "modes", "primitives": [
            {"attributes": {"POSITION": bent}, "mode": 5},
            {"attributes": {"POSITION": fan, "COLOR_0": colors}, "mode": 6},
            {"attributes": {"POSITION": plain}, "mode": 1},
            {"attributes": {"POSITION": plain}, "mode": 0},
        ]}],
    }))
}

/// A row of balls: dielectric, metal, coated, cloth, coloured highlight, glowing.
pub(super) fn materials() -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (columns, rows) = (24_u16, 12_u16);
    let mut points = Vec::new();
    for (r, c) in (0..=rows).flat_map(|r| (0..=columns).map(move |c| (r, c))) {
        let down = std::f64::consts::PI * f64::from(r) / f64::from(rows);
        let around = std::f64::consts::TAU * f64::from(c) / f64::from(columns);
        let point = [sin(down) * sin(around), cos(down), sin(down) * cos(around)];
        points.push(point.map(|x| x as f32));
    }
    let at = |r: u16, c: u16| r * (columns + 1) + c;
    let quads = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c)));
    let indices: Vec<u16> = quads
        .flat_map(|(r, c)| {
            [
                at(r, c),
                at(r + 1, c),
                at(r + 1, c + 1),
                at(r, c),
                at(r + 1, c + 1),
                at(r, c + 1),
            ]
        })
        .collect();
    let points = buffer.floats(&points);
    let attributes = json!({"POSITION": points, "NORMAL": points});
    let indices = buffer.indices(&indices);
    let material = |name: &str,
                    color: [f64; 3],
                    metallic: f64,
                    roughness: f64,
                    extensions: Value| {
        let [r, g, b] = color;
        json!({"name": name, "extensions": extensions, "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness,
        }})
    };
    let mut all = vec![
        material(
            "plastic",
            [0.7, 0.1, 0.1],
            0.0,
            0.3,
            json!({"KHR_materials_ior": {"ior": 1.8}}),
        ),
        material("gold", [1.0, 0.77, 0.34], 1.0, 0.25, json!({})),
        material(
            "coated",
            [0.1, 0.2, 0.6],
            0.0,
            0.8,
            json!({"KHR_materials_clearcoat": {
                "clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.1,
            }}),
        ),
        material(
            "cloth",
            [0.3, 0.05, 0.2],
            0.0,
            0.9,
            json!({"KHR_materials_sheen": {
                "sheenColorFactor": [0.9, 0.6, 0.8], "sheenRoughnessFactor": 0.4,
            }}),
        ),
        material(
            "pearl",
            [0.8, 0.8, 0.8],
            0.0,
            0.3,
            json!({"KHR_materials_specular": {
                "specularFactor": 0.8, "specularColorFactor": [1.0, 0.5, 0.7],
            }}),
        ),
        material(
            "glow",
            [0.0, 0.0, 0.0],
            0.0,
            1.0,
            json!({"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}}),
        ),
    ];
    all[5]["emissiveFactor"] = json!([0.1, 0.3, 0.2]);
    let meshes = (0..all.len()).map(
        |m| json!({"primitives": [{"attributes": attributes, "indices": indices, "material": m}]}),
    );
    let meshes: Vec<Value> = meshes.collect();
    let nodes = (0..6).map(|n| json!({"mesh": n, "translation": [2.3 * f64::from(n % 3), -2.3 * f64::from(n / 3), 0.0]}));
    let nodes: Vec<Value> = nodes.collect();
    buffer.glb(json!({
        "extensionsUsed": [
            "KHR_materials_clearcoat", "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_sheen",
            "KHR_materials_specular",
        ],
        "scenes": [{"nodes": [0, 1, 2, 3, 4, 5]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": all,
    }))
}
