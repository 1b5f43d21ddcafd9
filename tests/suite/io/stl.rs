//! STL models, text and binary.

use crate::support::Files;

const TEXT: &str = "solid two facets\n  facet normal 0 0 0\n    outer loop\n      vertex 0 0 0\n      vertex 2 0 0\n      vertex 0 1 0\n    endloop\n  \
    endfacet\nFACET NORMAL 9 9 9\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 0 1e0 0\r\nVERTEX 0 0 -3\nENDLOOP\nENDFACET\nendsolid two facets\n";

const CORNERS: [[f32; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, -3.0],
];

/// The same as bytes, its head beginning with these.
fn bytes(head: &[u8]) -> Vec<u8> {
    let mut out = head.to_vec();
    out.resize(80, b' ');
    out.extend(2_u32.to_le_bytes());
    for triangle in CORNERS.chunks(3) {
        out.extend([0; 12]);
        out.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        out.extend([1, 2]);
    }
    out
}

#[test]
fn text_and_bytes_are_one_model_of_flat_triangles() {
    let trailing = [&bytes(b"made by hand\0")[..], b"more"].concat();
    let rest = ": 4 bytes after the 2 triangles that it states are not read";
    for (file, warning) in [
        (TEXT.into(), None),
        (bytes(b"binary"), None),
        (bytes(b"solid x facet"), None),
        (trailing, Some(rest)),
    ] {
        let scene = Files::new().with("a.STL", file).load("a.STL").unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions, CORNERS);
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
        // Whatever the file says: the normals are those of the corners' order.
        assert_eq!(mesh.normals[..3], [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(mesh.normals[3..], [[-1.0, 0.0, 0.0]; 3]);
        assert!(mesh.uvs.is_empty());
        let warned = scene
            .warnings
            .iter()
            .map(|w| w.split_once(".STL").unwrap().1);
        assert!(warned.eq(warning), "{:?}", scene.warnings);
    }
}

#[test]
fn a_texture_is_projected_onto_it() {
    let files = Files::new()
        .with_png("a.png", 2, 2, [255; 4])
        .with("a.stl", TEXT);
    let scene = files.scene("la 1 1 1\ntexture a.png\nobj a.stl\n");
    assert_eq!(scene.meshes[0].uvs.len(), 6);
}

#[track_caller]
fn refused(file: impl AsRef<[u8]>, code: &str, words: &str) {
    let error = Files::new()
        .with("a.stl", file)
        .load("a.stl")
        .expect_err(words);
    assert_eq!(error.code(), code, "{error}");
    assert!(error.to_string().contains(words), "{error}");
}

#[test]
fn faults_have_their_places() {
    let changed = |from: &str, to: &str| {
        assert!(TEXT.contains(from));
        TEXT.replacen(from, to, 1)
    };
    for (from, to, words) in [
        (
            "vertex 2 0 0",
            "vertex 2 0",
            "a.stl:5:7: `vertex` takes three finite numbers",
        ),
        ("vertex 2 0 0", "vertex 2 nan 0", "a.stl:5:7"),
        ("vertex 2 0 0", "vertex 2 0 0 0", "a.stl:5:7"),
        ("vertex 2 0 0", "", "a.stl:8:3: a facet of 2 corners"),
        (
            "vertex 2 0 0",
            "vertices",
            "a.stl:5:7: `vertices` has no place here",
        ),
        ("  endfacet\n", "", "a.stl:8:1: `facet` has no place here"),
    ] {
        refused(changed(from, to), "broken-model-line", words);
    }
    refused(
        changed("ENDFACET\nendsolid two facets\n", ""),
        "broken-model",
        "ends within a facet",
    );
    refused("solid\nendsolid\n", "empty-mesh", "no faces");
    refused("", "broken-model", "84 bytes");
    let whole = bytes(b"");
    refused(
        &whole[..183],
        "broken-model",
        "the file ends within triangle 1 of 2 (byte 134)",
    );
    let mut bad = whole.clone();
    bad[84 + 50 + 12 + 3] = 0xff;
    bad[84 + 50 + 12 + 2] = 0xff;
    refused(
        bad,
        "broken-model",
        "triangle 1 (byte 134) has a corner that is not finite",
    );
}
