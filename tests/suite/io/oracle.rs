//! Models against `tobj`: names, materials, faces and the values of their corners are the same.

use std::fs;
use std::io::BufReader;
use std::path::Path;

use proptest::prelude::*;
use texmap_io::{LoadOptions, load};
use texmap_math::glam::DVec3;
use texmap_scene::{Mesh, Scene};

use crate::support::Files;

/// Position, coordinates and normal.
type Corner = ([f32; 3], Option<[f32; 2]>, Option<[f32; 3]>);

/// The corner values of all faces: position, and coordinates and normal if all faces of the file have some.
#[derive(Debug)]
struct Part {
    name: String,
    material: Option<String>,
    /// The polygons of the reference, the triangles of each polygon of the scene.
    faces: Vec<Vec<Corner>>,
}

fn reference(path: &Path, [has_uv, has_normal]: [bool; 2]) -> Vec<Part> {
    let options = tobj::LoadOptions {
        single_index: false,
        ignore_lines: true,
        ignore_points: true,
        ..tobj::LoadOptions::default()
    };
    let folder = path.parent().expect("a folder");
    let mut file = BufReader::new(fs::File::open(path).expect("a model"));
    let (models, materials) = tobj::load_obj_buf(&mut file, &options, |name| {
        let library = fs::File::open(folder.join(name));
        tobj::load_mtl_buf(&mut BufReader::new(library.expect("a library")))
    })
    .expect("a model");
    let materials = materials.expect("materials");
    let read = |tobj::Model { mesh, name }: tobj::Model| {
        let three = |values: &[f32], i: u32| values.as_chunks::<3>().0[i as usize];
        let corner = |(k, &i): (usize, &u32)| {
            let uv = mesh.texcoord_indices.get(k).filter(|_| has_uv);
            let normal = mesh.normal_indices.get(k).filter(|_| has_normal);
            (
                three(&mesh.positions, i),
                uv.map(|t| mesh.texcoords.as_chunks::<2>().0[*t as usize]),
                normal.map(|n| three(&mesh.normals, *n)),
            )
        };
        let mut corners = mesh.indices.iter().enumerate().map(corner);
        let arities = match mesh.face_arities.is_empty() {
            true => vec![3; mesh.indices.len() / 3],
            false => mesh.face_arities.clone(),
        };
        let face = |arity: &u32| corners.by_ref().take(*arity as usize).collect();
        Part {
            name,
            material: mesh.material_id.map(|m| materials[m].name.clone()),
            faces: arities.iter().map(face).collect(),
        }
    };
    let parts = models.into_iter().map(read);
    parts.filter(|part| !part.faces.is_empty()).collect()
}

/// The scene's part, without what the reference does not have.
fn part(mesh: &Mesh, scene: &Scene, like: &Part) -> Part {
    let corner = |&v: &u32| {
        let like = like.faces[0][0];
        let v = v as usize;
        (
            mesh.positions[v],
            like.1.map(|_| mesh.uvs[v]),
            like.2.map(|_| mesh.normals[v]),
        )
    };
    Part {
        name: mesh.name.clone(),
        material: (like.material.is_some()).then(|| scene.materials[mesh.material].name.clone()),
        faces: mesh
            .faces
            .iter()
            .zip(&mesh.triangles)
            .collect::<Vec<_>>()
            .chunk_by(|a, b| a.0 == b.0)
            .map(|face| {
                face.iter()
                    .flat_map(|(_, t)| t.iter().map(corner))
                    .collect()
            })
            .collect(),
    }
}

/// True if the triangles are the fan of the polygon, or three corners of it each where the fan turns one around.
fn cut(polygon: &[Corner], triangles: &[Corner]) -> bool {
    let fan = |k: usize| [polygon[0], polygon[k - 1], polygon[k]];
    let fans: Vec<[Corner; 3]> = (2..polygon.len()).map(fan).collect();
    let at = |corner: Corner| DVec3::from(corner.0.map(f64::from));
    let area = |[a, b, c]: &[Corner; 3]| (at(*b) - at(*a)).cross(at(*c) - at(*a));
    let normal: DVec3 = fans.iter().map(area).sum();
    let turned = fans.iter().any(|t| area(t).dot(normal) < 0.0);
    triangles == fans.as_flattened()
        || turned
            && triangles.len() <= 3 * fans.len()
            && triangles.iter().all(|corner| polygon.contains(corner))
}

fn same(path: &Path) {
    let scene = load(path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let text = fs::read_to_string(path).expect("a model");
    let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
    let corners: Vec<&str> = faces.flat_map(str::split_whitespace).collect();
    let has = |part: usize| {
        let part = |corner: &str| corner.split('/').nth(part).is_some_and(|i| !i.is_empty());
        corners.iter().all(|corner| part(corner))
    };
    let expected = reference(path, [has(1), has(2)]);
    let stem = path.file_stem().and_then(|s| s.to_str());
    assert_eq!(scene.meshes.len(), expected.len(), "{path:?}");
    for (mesh, expected) in scene.meshes.iter().zip(expected) {
        let mut found = part(mesh, &scene, &expected);
        // The scene calls a part without a name after its file.
        if expected.name == "unnamed_object" && Some(found.name.as_str()) == stem {
            found.name.clone_from(&expected.name);
        }
        assert_eq!(found.name, expected.name, "{path:?}");
        assert_eq!(found.material, expected.material, "{path:?}");
        assert_eq!(found.faces.len(), expected.faces.len(), "{path:?}");
        for (polygon, triangles) in expected.faces.iter().zip(&found.faces) {
            assert!(
                cut(polygon, triangles),
                "{path:?}: {polygon:?} {triangles:?}"
            );
        }
    }
}

#[test]
fn the_models_of_the_examples_are_read_as_tobj_reads_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models");
    let mut read = 0;
    for entry in fs::read_dir(folder).expect("models") {
        let path = entry.expect("a model").path();
        if path.extension().is_some_and(|e| e == "obj") {
            same(&path);
            read += 1;
        }
    }
    assert!(read > 4, "{read} models");
}

/// A model of so many vertices: faces of one form in each group, with positive and negative indices.
fn model() -> impl Strategy<Value = String> {
    let number = (-1000_i32..1000, 0..4_u32).prop_map(|(x, e)| format!("{x}e-{e}"));
    let vertex = prop::collection::vec(number, 3).prop_map(|v| v.join(" "));
    let vertices = prop::collection::vec(vertex, 12);
    let corners = prop::collection::vec((1..=12_i32, any::<bool>()), 3..7);
    let faces = prop::collection::vec(corners, 1..5);
    let head = prop::sample::select(vec!["", "o left\n", "g right side\n", "g\n", "s off\n"]);
    let material = prop::sample::select(vec!["", "usemtl red\n", "usemtl two words\n"]);
    let group = (head, material, faces);
    let groups = prop::collection::vec(group, 1..6);
    (vertices, groups, 0..4_usize).prop_map(|(vertices, groups, form)| {
        let mut text = String::from("mtllib a.mtl\n");
        for (i, vertex) in vertices.iter().enumerate() {
            text += &format!("v {vertex}\nvt 0.{i} 1.5e-{i} 0\nvn 1 {i} -0.5\n");
        }
        for (head, material, faces) in groups {
            text += head;
            text += material;
            for corners in faces {
                text.push('f');
                for (index, negative) in corners {
                    let i = if negative { index - 13 } else { index };
                    text += &match form {
                        0 => format!(" {i}"),
                        1 => format!(" {i}/{i}"),
                        2 => format!(" {i}//{i}"),
                        _ => format!(" {i}/{index}/{i}"),
                    };
                }
                text.push('\n');
            }
        }
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn models_are_read_as_tobj_reads_them(text in model()) {
        let library = "newmtl red\nKd 1 0 0\nnewmtl two words\nKd 0 1 0\n";
        let files = Files::new().with("a.mtl", library).with("a.obj", &text);
        same(&files.path("a.obj"));
    }
}
