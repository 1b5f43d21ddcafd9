//! PLY models: what their elements mean, in every encoding, and the places of faults.

use std::fmt::Write as _;

use texmap_scene::Scene;

use crate::support::Files;

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

const ENCODINGS: [Encoding; 3] = [Encoding::Ascii, Encoding::Little, Encoding::Big];

/// A value and the type that it is written as.
#[derive(Clone, Copy)]
enum V {
    U8(u8),
    I16(i16),
    I32(i32),
    F32(f32),
    F64(f64),
}

impl V {
    fn bytes(self) -> Vec<u8> {
        match self {
            Self::U8(v) => v.to_be_bytes().to_vec(),
            Self::I16(v) => v.to_be_bytes().to_vec(),
            Self::I32(v) => v.to_be_bytes().to_vec(),
            Self::F32(v) => v.to_be_bytes().to_vec(),
            Self::F64(v) => v.to_be_bytes().to_vec(),
        }
    }

    fn word(self) -> String {
        match self {
            Self::U8(v) => v.to_string(),
            Self::I16(v) => v.to_string(),
            Self::I32(v) => v.to_string(),
            Self::F32(v) => v.to_string(),
            Self::F64(v) => v.to_string(),
        }
    }
}

/// A file: head without its first two lines and its last one, and records.
fn ply(encoding: Encoding, head: &str, records: &[Vec<V>]) -> Vec<u8> {
    let format = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let mut out = format!("ply\nformat {format} 1.0\n{head}end_header\n").into_bytes();
    for record in records {
        if encoding == Encoding::Ascii {
            let words: Vec<String> = record.iter().map(|v| v.word()).collect();
            out.extend((words.join(" ") + "\n").bytes());
            continue;
        }
        for value in record {
            let mut bytes = value.bytes();
            if encoding == Encoding::Little {
                bytes.reverse();
            }
            out.extend(bytes);
        }
    }
    out
}

fn load(files: Files) -> Scene {
    files
        .load("a.ply")
        .unwrap_or_else(|e| panic!("{e}; {}", e.help()))
}

#[test]
fn colours_have_several_names() {
    let text = String::from_utf8(square(Encoding::Ascii)).expect("text");
    let colors = |names: [&str; 3]| {
        let mut text = text.clone();
        for (from, to) in ["red", "green", "blue"].into_iter().zip(names) {
            text = text.replace(&format!("uchar {from}\n"), &format!("uchar {to}\n"));
        }
        load(Files::new().with("a.ply", text)).meshes[0]
            .colors
            .clone()
    };
    let right = colors(["red", "green", "blue"]);
    assert_eq!(right.len(), 4);
    assert_eq!(colors(["r", "g", "b"]), right);
    assert_eq!(
        colors(["diffuse_red", "diffuse_green", "diffuse_blue"]),
        right
    );
    assert!(colors(["cyan", "green", "blue"]).is_empty());
}

/// Four vertices with all that a vertex may have, in an order and in types that few programs write, and two faces.
fn square(encoding: Encoding) -> Vec<u8> {
    let head = "comment by hand\nelement vertex 4\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty double z\n\
        property short quality\nproperty float y\nproperty float x\nproperty float nz\nproperty float ny\nproperty float nx\nproperty float t\n\
        property double s\nelement face 2\nproperty int flags\nproperty list short int vertex_index\n";
    let mut records: Vec<Vec<V>> = [(0.0, 0.0), (1.5, 0.0), (1.5, 2.0), (0.0, 2.0)]
        .map(|(x, y)| {
            let color = [V::U8(255), V::U8(0), V::U8(51)];
            let rest = [
                V::F64(0.25),
                V::I16(-7),
                V::F32(y),
                V::F32(x),
                V::F32(1.0),
                V::F32(0.0),
                V::F32(0.0),
                V::F32(y / 2.0),
                V::F64(f64::from(x)),
            ];
            color.into_iter().chain(rest).collect()
        })
        .to_vec();
    let face = |corners: &[i32]| {
        let start = [V::I32(5), V::I16(corners.len() as i16)];
        start
            .into_iter()
            .chain(corners.iter().map(|i| V::I32(*i)))
            .collect()
    };
    records.push(face(&[0, 1, 2]));
    records.push(face(&[0, 2, 3, 1]));
    ply(encoding, head, &records)
}

#[test]
fn encodings_and_orders_of_properties_change_nothing() {
    for encoding in ENCODINGS {
        let scene = load(Files::new().with("a.ply", square(encoding)));
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions[2], [1.5, 2.0, 0.25]);
        assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 4]);
        assert_eq!(mesh.uvs, [[0.0, 0.0], [1.5, 0.0], [1.5, 1.0], [0.0, 1.0]]);
        assert_eq!(mesh.colors[0][..2], [1.0, 0.0]);
        assert!(
            (mesh.colors[0][2] - 0.033_105).abs() < 1e-5,
            "sRGB 51 is linear 0.0331"
        );
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 1]]);
        assert_eq!(mesh.faces, [0, 1, 1]);
        assert_eq!(mesh.name, "a");
    }
}

/// A PLY and an OBJ that say the same are the same meshes.
#[test]
fn a_ply_is_the_obj_that_says_the_same() {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.5],
        [0.0, 1.0, 0.0],
        [2.0, 0.5, 0.0],
    ];
    let faces: [&[i32]; 3] = [&[0, 1, 2, 3], &[1, 4, 2], &[0, 3, 2, 4, 1]];
    let head = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 3\nproperty list uchar int vertex_indices\n";
    let mut records: Vec<Vec<V>> = points.iter().map(|p| p.map(V::F32).to_vec()).collect();
    let mut obj = String::new();
    for [x, y, z] in points {
        writeln!(obj, "v {x} {y} {z}").unwrap();
    }
    for face in faces {
        let length = V::U8(face.len() as u8);
        records.push(
            [length]
                .into_iter()
                .chain(face.iter().map(|i| V::I32(*i)))
                .collect(),
        );
        let corners: Vec<String> = face.iter().map(|i| (i + 1).to_string()).collect();
        writeln!(obj, "f {}", corners.join(" ")).unwrap();
    }
    let expected = Files::new().with("a.obj", obj).load("a.obj").unwrap();
    for encoding in ENCODINGS {
        let scene = load(Files::new().with("a.ply", ply(encoding, head, &records)));
        let (a, b) = (&scene.meshes[0], &expected.meshes[0]);
        assert_eq!(
            (&a.positions, &a.normals, &a.uvs),
            (&b.positions, &b.normals, &b.uvs)
        );
        assert_eq!(
            (&a.triangles, &a.faces, &a.name),
            (&b.triangles, &b.faces, &b.name)
        );
    }
}

/// Coordinates of corners split vertices, and `texnumber` picks the texture of a face.
#[test]
fn faces_bring_coordinates_and_textures() {
    let head = "comment TextureFile one.png\ncomment TextureFile two words.png\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 3\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n";
    let point = |x, y| vec![V::F32(x), V::F32(y), V::F32(0.0)];
    let face = |corners: [i32; 3], uv: [f32; 6], texture: i32| {
        let mut record = vec![V::U8(3)];
        record.extend(corners.map(V::I32));
        record.push(V::U8(6));
        record.extend(uv.map(V::F32));
        record.push(V::I32(texture));
        record
    };
    let uv = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
    let records = [
        point(0.0, 0.0),
        point(1.0, 0.0),
        point(1.0, 1.0),
        point(0.0, 1.0),
        face([0, 1, 2], uv, 1),
        face([0, 2, 3], [0.5, 0.5, 1.0, 1.0, 0.0, 1.0], 0),
        face([2, 1, 0], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 1),
    ];
    for encoding in ENCODINGS {
        let files = Files::new()
            .with_png("one.png", 2, 1, [255; 4])
            .with_png("two words.png", 3, 1, [255; 4])
            .with("a.ply", ply(encoding, head, &records));
        let scene = load(files);
        let [first, second] = &scene.meshes[..] else {
            panic!("{} meshes", scene.meshes.len())
        };
        assert_eq!(first.uvs, [[0.5, 0.5], [1.0, 1.0], [0.0, 1.0]]);
        // Normals of both sides cancel out at vertex 1, where each side has its own.
        assert_eq!((second.uvs.len(), second.triangles.len()), (4, 2));
        assert_eq!(
            (&first.faces[..], &second.faces[..]),
            (&[1][..], &[0, 2][..])
        );
        let width = |mesh: &texmap_scene::Mesh| {
            let slot = scene.materials[mesh.material].base_color.as_ref().unwrap();
            scene.textures[slot.texture].width()
        };
        assert_eq!((width(first), width(second)), (2, 3));
    }
}

#[test]
fn strips_become_triangles() {
    let head = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\n";
    let mut records: Vec<Vec<V>> = (0..5)
        .map(|i| [i as f32, (i % 2) as f32, 0.0].map(V::F32).to_vec())
        .collect();
    records.push([8, 0, 1, 2, 3, -1, 2, 3, 4].map(V::I32).to_vec());
    for encoding in ENCODINGS {
        let scene = load(Files::new().with("a.ply", ply(encoding, head, &records)));
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    }
}

/// Scans have a vertex that is not finite for each pixel without depth; faces leave them out.
#[test]
fn vertices_that_no_face_uses_may_be_anything() {
    for encoding in ENCODINGS {
        let mut records = vec![[f32::NAN, 0.0, 0.0].map(V::F32).to_vec()];
        records.push([0.0, 0.0, 0.0].map(V::F32).to_vec());
        records.push([1.0, 0.0, 0.0].map(V::F32).to_vec());
        records.push([0.0, f32::INFINITY, 0.0].map(V::F32).to_vec());
        records.push([0.0, 1.0, 0.0].map(V::F32).to_vec());
        records.push(vec![V::U8(3), V::I32(1), V::I32(2), V::I32(4)]);
        let head = HEAD.replace("vertex 3", "vertex 5");
        let bytes = ply(encoding, &head, &records);
        let whole = load(Files::new().with("a.ply", triangle(encoding)));
        let scan = load(Files::new().with("a.ply", bytes));
        let (whole, scan) = (&whole.meshes[0], &scan.meshes[0]);
        assert_eq!(scan.positions, whole.positions);
        assert_eq!(
            (&scan.triangles, &scan.faces),
            (&whole.triangles, &whole.faces)
        );
        *records.last_mut().unwrap() = vec![V::U8(3), V::I32(1), V::I32(2), V::I32(3)];
        refused(
            ply(encoding, &head, &records),
            match encoding {
                Encoding::Ascii => "broken-model-line",
                _ => "broken-model",
            },
            "vertex 3",
        );
    }
}

/// A normal that is not finite is computed, and a face with such coordinates has none.
#[test]
fn normals_and_coordinates_that_are_not_finite() {
    let head = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
        property float nz\nproperty float s\nproperty float t\nelement face 2\nproperty list uchar int vertex_indices\n";
    let point = |x, y, n, s| {
        vec![
            V::F32(x),
            V::F32(y),
            V::F32(0.0),
            V::F32(0.0),
            V::F32(n),
            V::F32(1.0),
            V::F32(s),
            V::F32(y),
        ]
    };
    for encoding in ENCODINGS {
        let face = |i| vec![V::U8(3), V::I32(0), V::I32(i), V::I32(i + 1)];
        let records = [
            point(0.0, 0.0, f32::NAN, 0.0),
            point(1.0, 0.0, 0.0, 1.0),
            point(1.0, 1.0, 0.0, 1.0),
            point(0.0, 1.0, 0.0, f32::NAN),
            face(1),
            face(2),
        ];
        let scene = load(Files::new().with("a.ply", ply(encoding, head, &records)));
        let mesh = &scene.meshes[0];
        assert!(mesh.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
        assert_eq!(mesh.uvs[..3], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        assert!(mesh.uvs.as_flattened().iter().all(|x| x.is_finite()));
        assert_eq!(mesh.positions.len(), 6, "the second face is apart");
        let warned = |words: &str| scene.warnings.iter().any(|w| w.contains(words));
        assert!(warned("a normal that is not finite is computed from faces"));
        assert!(warned("1 faces without texture coordinates"));
    }
}

/// Code, and the place of a text or the words about a byte.
#[track_caller]
fn refused(bytes: impl AsRef<[u8]>, code: &str, words: &str) {
    let error = Files::new()
        .with("a.ply", bytes)
        .load("a.ply")
        .expect_err(words);
    assert_eq!(error.code(), code, "{error}");
    assert!(error.to_string().contains(words), "{error}");
    assert!(!error.help().is_empty());
}

const HEAD: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n";

fn triangle(encoding: Encoding) -> Vec<u8> {
    let mut records = vec![[0.0, 0.0, 0.0].map(V::F32).to_vec()];
    records.push([1.0, 0.0, 0.0].map(V::F32).to_vec());
    records.push([0.0, 1.0, 0.0].map(V::F32).to_vec());
    records.push(vec![V::U8(3), V::I32(0), V::I32(1), V::I32(2)]);
    ply(encoding, HEAD, &records)
}

#[test]
fn faults_of_a_text_have_line_and_column() {
    let text = String::from_utf8(triangle(Encoding::Ascii)).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from));
        text.replacen(from, to, 1)
    };
    refused(
        changed("3 0 1 2", "3 0 1 3"),
        "broken-model-line",
        "a.ply:13:1: face 0 names vertex 3, which does not exist",
    );
    refused(
        changed("3 0 1 2", "2 0 1"),
        "broken-model-line",
        "a.ply:13:1: face 0 has 2 corners",
    );
    refused(
        changed("3 0 1 2", "3 0 1"),
        "broken-model-line",
        "a.ply:13:6: the file ends within record 0",
    );
    refused(
        changed("1 0 0", "1 x 0"),
        "broken-model-line",
        "a.ply:11:3: `x` is no F32",
    );
    refused(
        changed("1 0 0", "1 nan 0"),
        "broken-model-line",
        "a.ply:11:1: vertex 1 has a position that is not finite",
    );
    refused(
        changed("1 0 0", "1 -nan(ind) 0"),
        "broken-model-line",
        "a.ply:11:1: vertex 1 has a position that is not finite",
    );
    refused(
        changed("3 0 1 2", "300 0 1 2"),
        "broken-model-line",
        "a.ply:13:1: `300` is no U8",
    );
    refused(
        changed("float x", "float w"),
        "broken-model-line",
        "a.ply:10:1: vertex 0 has no properties x, y and z",
    );
    refused(
        changed("end_header", "end"),
        "broken-model-line",
        "a.ply:9:1: `end` in the head",
    );
    refused(changed("element face 1\n", ""), "point-cloud", "3 points");
    refused("", "broken-model-line", "a.ply:1:1");
}

#[test]
fn faults_of_bytes_have_their_number() {
    for encoding in [Encoding::Little, Encoding::Big] {
        let bytes = triangle(encoding);
        let head = bytes.len() - 49;
        let at = |byte: usize| format!("(byte {})", head + byte);
        let changed = |byte: usize, value: u8| {
            let mut bytes = bytes.clone();
            bytes[head + byte] = value;
            bytes
        };
        refused(
            changed(36, 2),
            "broken-model",
            &format!("face 0 {} has 2 corners", at(36)),
        );
        refused(
            changed(36, 4),
            "broken-model",
            &format!("face 0 {} is cut off", at(36)),
        );
        refused(
            changed(39, 9),
            "broken-model",
            &format!("face 0 {} names vertex", at(36)),
        );
        refused(
            changed(if encoding == Encoding::Big { 12 } else { 15 }, 0xff),
            "broken-model",
            &format!("vertex 1 {}", at(12)),
        );
        refused(
            &bytes[..head + 20],
            "broken-model",
            &format!("vertex 1 {} is cut off", at(12)),
        );
    }
}

#[test]
fn points_without_faces_are_refused_by_name() {
    let points = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 1 1\n";
    refused(points, "point-cloud", "2 points without faces");
    let splats = points.replace(
        "property float z",
        "property float z\nproperty float f_dc_0",
    );
    refused(splats, "point-cloud", "2 Gaussian splats without faces");
    refused(
        "ply\nformat ascii 1.0\nend_header\n",
        "empty-mesh",
        "no faces",
    );
}

/// Counts that no file of this size can hold are refused at once, whatever they ask for.
#[test]
fn counts_beyond_the_file_cost_nothing() {
    for encoding in ["ascii", "binary_little_endian"] {
        let head = format!("ply\nformat {encoding} 1.0\n");
        let rest = "property float x\nproperty float y\nproperty float z\nelement face 4294967295\nproperty list int int vertex_indices\nend_header\n0 0 0\n";
        let error = Files::new()
            .with("a.ply", format!("{head}element vertex 4294967295\n{rest}"))
            .load("a.ply")
            .unwrap_err();
        assert!(error.code().starts_with("broken-model"), "{error}");
    }
    let empty = "ply\nformat ascii 1.0\nelement vertex 0\nelement nothing 4294967295\nelement face 4294967295\nend_header\n";
    refused(empty, "broken-model-line", "face 0");
}

#[test]
fn a_scene_names_a_ply_like_an_obj() {
    let files = Files::new()
        .with("a.ply", triangle(Encoding::Little))
        .with("b.scene", "la 1 1 1\ntranslate 0 0 3\nobj a.ply\n");
    let scene = files.load("b.scene").unwrap();
    assert_eq!(
        (
            scene.meshes[0].name.as_str(),
            scene.meshes[0].triangles.len()
        ),
        ("a", 1)
    );
    // A texture needs coordinates, which are projected.
    let files = files
        .with_png("a.png", 2, 2, [255; 4])
        .with("c.scene", "la 1 1 1\ntexture a.png\nobj a.ply\n");
    let scene = files.load("c.scene").unwrap();
    assert_eq!(scene.meshes[0].uvs.len(), 3);
    assert!(
        scene.warnings.iter().any(|w| w.contains("box projection")),
        "{:?}",
        scene.warnings
    );
}
