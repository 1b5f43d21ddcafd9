//! Accessors, primitives, nodes.

use texmap_raster::Cull;
use texmap_render::{RenderSettings, render};
use texmap_sample::Origin;
use texmap_scene::Scene;

use super::{TRIANGLE, near, read, small, triangle_bytes, world};

#[test]
fn sides_without_normals_are_flat_and_face_outwards() {
    let scene = read("box.glb");
    let mesh = &scene.meshes[0];
    assert_eq!(
        (mesh.triangles.len(), mesh.positions.len(), mesh.uv_origin),
        (12, 36, Origin::TopLeft)
    );
    for triangle in &mesh.triangles {
        let normal = mesh.normals[triangle[0] as usize];
        let outward = mesh.cross(*triangle);
        for (n, c) in normal.iter().zip(outward.to_array()) {
            assert!((f64::from(*n) - c).abs() < 1e-6, "{normal:?} {outward}");
        }
        let middle: f32 = triangle
            .iter()
            .map(|i| mesh.positions[*i as usize])
            .map(|p| (0..3).map(|k| p[k] * normal[k]).sum::<f32>())
            .sum();
        assert!(
            (middle - 1.5).abs() < 1e-6,
            "the plane of a side is half a unit away"
        );
    }
}

#[test]
fn strips_fans_and_sparse_accessors() {
    let scene = read("sparse.gltf");
    assert_eq!(scene.meshes.len(), 2);
    let strip = &scene.meshes[0];
    // Flat, so each of four triangles has its corners; only the last one has the corner that was moved.
    assert_eq!(strip.triangles.len(), 4);
    let moved = strip
        .positions
        .iter()
        .filter(|p| **p == [1.0, -0.5, 0.25])
        .count();
    let others = strip
        .positions
        .iter()
        .filter(|p| p[1] < 0.0 || p[2] != 0.0)
        .count();
    let at = strip
        .positions
        .iter()
        .position(|p| p[2] != 0.0)
        .map(|i| strip.positions[i]);
    assert_eq!((moved, others, at), (0, 1, Some([1.5, -0.5, 0.25])));
    assert!(
        strip.triangles.iter().all(|t| strip.cross(*t).z > 0.0),
        "every second triangle is turned"
    );
    let fan = &scene.meshes[1];
    assert_eq!(fan.triangles.len(), 3);
    assert!(fan.triangles.iter().all(|t| fan.cross(*t).z > 0.0));
    // The last triangle: corners 3, 4 and 0.
    assert_eq!(
        fan.colors[6..],
        [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 0.0]]
    );
    let told: Vec<_> = scene
        .warnings
        .iter()
        .filter(|w| w.contains("points and lines"))
        .collect();
    assert_eq!(told.len(), 1);
    assert!(
        told[0].contains("/meshes/0/primitives/2, and 1 more"),
        "{told:?}"
    );
}

#[test]
fn integers_are_shares_of_their_largest() {
    let mesh = &read("quantized.glb").meshes[0];
    let square = [
        [-0.5, -0.5, 0.0],
        [0.5, -0.5, 0.0],
        [0.5, 0.5, 0.0],
        [-0.5, 0.5, 0.0],
    ];
    assert!(near(&world(mesh), &square, 1e-7), "{:?}", world(mesh));
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(mesh.uvs, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
}

/// Texture coordinates of every component type, normalized and not, in elements that lie apart.
#[test]
fn component_types() {
    let i16s = |v: [i16; 6]| v.map(i16::to_le_bytes).concat();
    let u16s = |v: [u16; 6]| v.map(u16::to_le_bytes).concat();
    for (code, normalized, pairs, expected) in [
        (
            5120,
            true,
            vec![127, 0, 0x80, 0x81, 64, 1],
            [[1.0, 0.0], [-1.0, -1.0], [64.0 / 127.0, 1.0 / 127.0]],
        ),
        (
            5120,
            false,
            vec![127, 0, 0x80, 0x81, 64, 1],
            [[127.0, 0.0], [-128.0, -127.0], [64.0, 1.0]],
        ),
        (
            5121,
            true,
            vec![255, 0, 51, 1, 64, 1],
            [[1.0, 0.0], [0.2, 1.0 / 255.0], [64.0 / 255.0, 1.0 / 255.0]],
        ),
        (
            5121,
            false,
            vec![255, 0, 51, 1, 64, 1],
            [[255.0, 0.0], [51.0, 1.0], [64.0, 1.0]],
        ),
        (
            5122,
            true,
            i16s([32767, 0, -32768, -32767, 1, 2]),
            [[1.0, 0.0], [-1.0, -1.0], [1.0 / 32767.0, 2.0 / 32767.0]],
        ),
        (
            5123,
            true,
            u16s([65535, 0, 13107, 1, 2, 3]),
            [
                [1.0, 0.0],
                [0.2, 1.0 / 65535.0],
                [2.0 / 65535.0, 3.0 / 65535.0],
            ],
        ),
        (
            5123,
            false,
            u16s([65535, 0, 13107, 1, 2, 3]),
            [[65535.0, 0.0], [13107.0, 1.0], [2.0, 3.0]],
        ),
    ] {
        let size = pairs.len() / 3;
        let mut bytes = triangle_bytes();
        for element in pairs.chunks(size) {
            bytes.extend(element);
            bytes.resize(bytes.len() + 8 - size, 0xaa);
        }
        let json = TRIANGLE
            .replace(r#""POSITION":0"#, r#""POSITION":0,"TEXCOORD_0":2"#)
            .replace(r#""byteLength":44"#, &format!(r#""byteLength":{}"#, bytes.len()))
            .replace(r#""byteLength":6}"#, r#""byteLength":6},{"buffer":0,"byteOffset":44,"byteLength":24,"byteStride":8}"#)
            .replace(r#""type":"SCALAR"}"#, &format!(
                r#""type":"SCALAR"}},{{"bufferView":2,"componentType":{code},"normalized":{normalized},"count":3,"type":"VEC2"}}"#
            ));
        let scene = small(&json, &bytes).unwrap_or_else(|e| panic!("{e}\n{json}"));
        assert_eq!(scene.meshes[0].uvs, expected, "{code} {normalized}");
    }
}

#[test]
fn a_mirrored_node_keeps_its_outside() {
    let scene = read("mirrored.glb");
    let [plain, mirrored] = &scene.meshes[..] else {
        panic!("two meshes")
    };
    assert!(
        plain.world_from_object.determinant() > 0.0
            && mirrored.world_from_object.determinant() < 0.0
    );
    assert_eq!(
        plain.triangles, mirrored.triangles,
        "fronts are those of the object"
    );
    assert!(scene.materials.iter().all(|m| m.cull == Cull::Back));
    // The right half of the picture is the mirrored plate.
    let right = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.camera.eye = [0.0, 0.0, 4.0].into();
        scene.camera.look = [0.0, 0.0, 0.0].into();
        let frame = render(
            &scene,
            &RenderSettings::new(64, 32),
            &texmap_render::no_progress,
        )
        .expect("a frame");
        let corner = frame.rgba[..4].to_vec();
        let texels = frame.rgba.chunks(4).enumerate();
        texels.filter(|(i, p)| i % 64 >= 32 && *p != corner).count()
    };
    let seen = right(&scene);
    assert!(seen > 100, "{seen} pixels");
    let mut turned = scene.clone();
    turned.meshes[1]
        .triangles
        .iter_mut()
        .for_each(|t| t.swap(1, 2));
    assert_eq!(
        right(&turned),
        0,
        "with its corners exchanged it shows its back"
    );
}

#[test]
fn instances_stand_where_their_attributes_say() {
    let scene = read("instances.glb");
    assert_eq!(scene.meshes.len(), 9);
    for (i, mesh) in (0..9_u8).zip(&scene.meshes) {
        let center = mesh.world_from_object.w_axis;
        let (x, y) = (f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0);
        assert!((center.x - x).abs() < 1e-6 && (center.y - y).abs() < 1e-6);
        let size = 0.4 + 0.06 * f64::from(i);
        let right = mesh.world_from_object.x_axis;
        assert!((right.length() - size).abs() < 1e-6);
        let degrees = right.y.atan2(right.x).to_degrees();
        assert!(
            (degrees - 20.0 * f64::from(i)).abs() < 1e-3,
            "{i}: {degrees}"
        );
    }
}

#[test]
fn nodes_scaled_to_nothing_are_left_out_with_a_warning() {
    let two = TRIANGLE.replace(
        r#""nodes":[{"mesh":0}]"#,
        r#""nodes":[{"mesh":0},{"mesh":0,"scale":[1,0,1]}]"#,
    );
    let scene = small(&two, &triangle_bytes()).expect("one mesh");
    assert_eq!(scene.meshes.len(), 1);
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("scaled to nothing")),
        "{:?}",
        scene.warnings
    );
    let none = TRIANGLE.replace(r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[0,0,0]}"#);
    assert_eq!(
        small(&none, &triangle_bytes()).unwrap_err().code(),
        "empty-mesh"
    );
}
