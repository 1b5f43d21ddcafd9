//! Views compressed by meshoptimizer.
//!
//! The files of `tests/data` are those of `assets/gltf` as gltfpack 1.3 writes them: `gltfpack -i NAME.glb -o NAME.meshopt.glb -cc -mi`
//! (`materials` with `-cz`, whose streams are those of the newer version).

use std::path::{Path, PathBuf};

use texmap_io::{FileSource, IoError, LoadOptions, load};
use texmap_math::MemoryBudget;
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

use super::{asset, small, world};

pub(super) fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name)
}

fn at(path: &Path, time: Option<f64>) -> Scene {
    let options = LoadOptions {
        time,
        ..LoadOptions::default()
    };
    load(path, &options).unwrap_or_else(|e| panic!("{e}; {}", e.help()))
}

/// Positions and normals in space.
fn points(scene: &Scene) -> Vec<(DVec3, DVec3)> {
    let of = |mesh| world(mesh).into_iter().map(DVec3::from);
    let meshes = scene.meshes.iter();
    meshes
        .flat_map(|mesh| of(mesh).zip(mesh.world_normals()))
        .collect()
}

/// True if each point of one lies on a point of the other with the same normal, or nearly.
fn covers(a: &[(DVec3, DVec3)], b: &[(DVec3, DVec3)], tolerance: f64) -> bool {
    b.iter().all(|(p, n)| {
        a.iter()
            .any(|(q, m)| p.distance(*q) <= tolerance && n.dot(*m) > 0.99)
    })
}

#[test]
fn compressed_models_are_those_that_they_were_made_of() {
    for (name, time) in [
        ("bent", None),
        ("bent", Some(0.5)),
        ("bent", Some(1.3)),
        ("instances", None),
        ("materials", None),
    ] {
        let plain = at(&asset(&format!("{name}.glb")), time);
        let packed = at(&data(&format!("{name}.meshopt.glb")), time);
        let triangles = |scene: &Scene| -> usize {
            let of = |mesh: &texmap_scene::Mesh| mesh.triangles.len();
            scene.meshes.iter().map(of).sum()
        };
        // The poles of spheres lose the triangles without area.
        let (all, left) = (triangles(&plain), triangles(&packed));
        assert!(
            left <= all && left > all * 9 / 10,
            "{name}: {left} of {all}"
        );
        let (plain, packed) = (points(&plain), points(&packed));
        let off = 2e-3;
        assert!(
            covers(&plain, &packed, off) && covers(&packed, &plain, off),
            "{name} {time:?}"
        );
        // The time matters to the one that moves.
        if time == Some(1.3) {
            let rest = points(&at(&asset("bent.glb"), None));
            assert!(!covers(&rest, &packed, off));
        }
    }
}

/// A triangle whose indices, 0, 1 and 2, are a compressed sequence behind its positions.
fn document(stream: &[u8], extension: &str) -> (String, Vec<u8>) {
    let document = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["KHR_meshopt_compression"],"extensionsUsed":["KHR_meshopt_compression"],
"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{"uri":"a.bin","byteLength":{}}},{{"uri":"nowhere.bin","byteLength":6,"extensions":{{"KHR_meshopt_compression":{{"fallback":true}}}}}}],
"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":1,"byteLength":6,"extensions":{{"KHR_meshopt_compression":{{"buffer":0,"byteOffset":36,{extension}}}}}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}]}}"#,
        36 + stream.len()
    );
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend_from_slice(stream);
    (document, bytes)
}

fn sequence(stream: &[u8], extension: &str) -> Result<Scene, IoError> {
    let (document, bytes) = document(stream, extension);
    small(&document, &bytes)
}

/// Header, differences 0, 1 and 1 from the first earlier index, four bytes of padding.
const SEQUENCE: [u8; 8] = [0xd1, 0, 4, 4, 0, 0, 0, 0];

#[test]
fn faults_of_a_stream_are_named_with_their_view() {
    let good = r#""byteLength":8,"byteStride":2,"count":3,"mode":"INDICES""#;
    let scene = sequence(&SEQUENCE, good).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    let changed = |at: usize, byte: u8| {
        let mut stream = SEQUENCE;
        stream[at] = byte;
        stream
    };
    let filtered = good.to_owned() + r#","filter":"OCTAHEDRAL""#;
    let cases: [(&[u8], String, &str); 9] = [
        (
            &changed(0, 0xd7),
            good.into(),
            "begins with 0xd7, of no known version",
        ),
        (&changed(3, 0x80), good.into(), "the stream ends early"),
        (
            &SEQUENCE,
            good.replace("\"count\":3", "\"count\":2"),
            "2 elements of 2 bytes are not the 6 bytes of the view",
        ),
        (
            &SEQUENCE,
            good.replace("INDICES", "TRIANGLES"),
            "begins with 0xd1, of no known version",
        ),
        (
            &SEQUENCE,
            good.replace("INDICES", "POINTS"),
            "there is no mode 'POINTS'",
        ),
        (
            &SEQUENCE,
            good.replace("INDICES", "ATTRIBUTES"),
            "elements of 2 bytes do not go with its mode and filter",
        ),
        (&SEQUENCE, filtered, "indices have no filter"),
        (
            &SEQUENCE,
            good.replace("\"byteLength\":8", "\"byteLength\":9"),
            "bytes 36 to 45 lie outside of buffer 0, which has 44",
        ),
        (
            &[0xd1, 0, 4, 4, 0, 0, 0, 0, 0],
            good.replace("\"byteLength\":8", "\"byteLength\":9"),
            "1 bytes of the stream are left over",
        ),
    ];
    for (stream, extension, problem) in cases {
        let message = sequence(stream, &extension).expect_err(problem).to_string();
        let at = "a.gltf: /bufferViews/1/extensions/KHR_meshopt_compression: ";
        assert!(
            message.starts_with(at) && message.ends_with(problem),
            "{message}"
        );
    }
}

/// A few bytes can say that they hold gigabytes: those are asked of the memory budget.
#[test]
fn large_counts_are_asked_of_the_memory() {
    let extension = r#""byteLength":8,"byteStride":2,"count":3000000000,"mode":"INDICES""#;
    let (document, bytes) = document(&SEQUENCE, extension);
    let large = document.replace(
        r#""buffer":1,"byteLength":6"#,
        r#""buffer":1,"byteLength":6000000000"#,
    );
    let files = FileSource::in_memory([
        ("a.gltf".into(), large.into_bytes()),
        ("a.bin".into(), bytes),
    ]);
    let options = LoadOptions {
        files: files.with_memory(MemoryBudget::new(1 << 20)),
        ..LoadOptions::default()
    };
    let error = load(Path::new("a.gltf"), &options).expect_err("a budget of less");
    assert_eq!(error.code(), "over-memory-budget", "{error}");
}
