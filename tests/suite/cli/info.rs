//! `texmap info`: meshes, maps, uv ranges and what is missing.

use crate::program::{Desk, ROOM};

#[test]
fn a_model_is_described_in_words_and_as_json() {
    let desk = Desk::new();
    let run = desk.texmap("info m.obj").ok();
    let text = String::from_utf8(run.stdout).unwrap();
    for word in [
        "panel",
        "spike",
        "check.png",
        "8 x 8",
        "paper",
        "0..2",
        "0..1",
    ] {
        assert!(text.contains(word), "{word} is not in\n{text}");
    }
    assert!(run.stderr.is_empty());
    let info = desk.texmap("info m.obj --json").ok().json();
    assert_eq!(info["meshes"].as_array().unwrap().len(), 2);
    assert_eq!(
        info["meshes"][0]["uv"],
        serde_json::json!([[0.0, 0.0], [2.0, 1.0]])
    );
    assert_eq!(info["meshes"][0]["triangles"], 2);
    assert_eq!(info["files"][0]["size"], serde_json::json!([8, 8]));
}

/// Two squares beside one of twice their height: the vertex between them lies inside the long edge.
#[test]
fn t_joints_are_counted_over_all_meshes() {
    let desk = Desk::new();
    let corners = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 2 2 0\n";
    let with = |faces: &str| format!("{corners}o wall\nf {faces}\no rest\nf 2 5 6 7\nf 7 6 8 3\n");
    desk.put("t.obj", with("1 2 3 4"));
    desk.put("cured.obj", with("1 2 7 3 4"));
    assert_eq!(desk.texmap("info t.obj --json").ok().json()["t_joints"], 1);
    assert_eq!(
        desk.texmap("info cured.obj --json").ok().json()["t_joints"],
        0
    );
    let words = String::from_utf8(desk.texmap("info t.obj").ok().stdout).unwrap();
    assert!(words.contains("1 T-junctions"), "{words}");
}

#[test]
fn missing_and_broken_files_are_listed_with_exit_code_three() {
    let desk = Desk::new();
    desk.put("broken.png", "no picture");
    desk.put(
        "room.scene",
        format!("{ROOM}texture gone.png\ntexture broken.png\nobj gone.obj\n"),
    );
    let run = desk.texmap("info room.scene --json");
    assert_eq!(run.code, 3, "{}", run.stderr);
    let files = run.json()["files"].as_array().unwrap().clone();
    let missed: Vec<&str> = files
        .iter()
        .filter(|f| !f["problem"].is_null())
        .map(|f| f["path"].as_str().unwrap())
        .collect();
    assert_eq!(missed, ["gone.png", "broken.png", "gone.obj"]);
    assert!(
        files.iter().any(|f| f["named_by"] == "room.scene:18:1"),
        "{files:?}"
    );
    assert_eq!(run.stderr.lines().count(), 3, "{}", run.stderr);
    let words = desk.texmap("info room.scene");
    assert_eq!(words.code, 3);
    assert!(
        String::from_utf8(words.stdout)
            .unwrap()
            .contains("unusable")
    );
}

#[test]
fn a_broken_file_itself_is_an_error() {
    let desk = Desk::new();
    assert_eq!(desk.texmap("info no.scene").code, 4);
    desk.put("bad.scene", "colour red\n");
    let run = desk.texmap("info bad.scene --json");
    assert_eq!(
        (run.code, run.json()["error"]["code"].as_str()),
        (4, Some("unknown-command"))
    );
}

/// A glTF says what `render` can choose from.
#[test]
fn cameras_animations_and_extensions_are_listed() {
    let desk = Desk::new();
    for (name, words) in [
        (
            "box.glb",
            &[
                "(gltf)",
                "camera 0 'front': perspective",
                "letters",
                "64 x 64",
                "/images/0",
            ][..],
        ),
        (
            "bent.glb",
            &[
                "animation 0 'bend': 2 s, 2 channels",
                "animation 1 'jump': 2 s, 1 channels",
            ],
        ),
        (
            "quantized.glb",
            &[
                "extension KHR_mesh_quantization (required): read",
                "extension KHR_texture_transform: read",
            ],
        ),
    ] {
        desk.put("model.glb", asset(name));
        let text = String::from_utf8(desk.texmap("info model.glb").ok().stdout).unwrap();
        for word in words {
            assert!(text.contains(word), "{word} is not in\n{text}");
        }
    }
    desk.put("model.glb", asset("bent.glb"));
    let info = desk.texmap("info model.glb --json").ok().json();
    assert_eq!(
        (&info["kind"], &info["animations"][0]["seconds"]),
        (&"gltf".into(), &2.0.into())
    );
    assert_eq!(
        (&info["meshes"][0]["triangles"], &info["materials"][0]),
        (&8.into(), &"strip".into())
    );
    assert_eq!(info["lights"], 0);
}

fn asset(name: &str) -> Vec<u8> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/gltf");
    std::fs::read(folder.join(name)).unwrap()
}
