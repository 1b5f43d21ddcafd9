//! What the lines of light become.

use texmap_light::{Green, Light, ShadowBias};
use texmap_render::{Relief, Settings, SlideRole, render};

use crate::support::Files;

const FACE: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 0 1 2\n";

fn files() -> Files {
    Files::new()
        .with_png("a.png", 8, 4, [200, 100, 50, 255])
        .with_png("square.png", 8, 8, [200, 100, 50, 255])
}

#[test]
fn lights_shadows_and_projectors_are_added() {
    let scene = files().scene(&format!(
        "la 1 1 1\nls 1 1 1 0 2 3 0 -1 -1 10 30\nshadow 512 taps 5 constant 0.25\nlp 1 1 1 0 3 3\nshadow\n\
         projector a.png light 0 0 5 0 0 0 0 1 0 40 color 0.5 0.5 0.5\nprojector a.png paint 0 0 5 0 0 0 0 1 0 40 shadow 64\n{FACE}"
    ));
    assert!(
        matches!(scene.lights[1], Light::Spot { cos_inner, .. } if (cos_inner - 10f32.to_radians().cos()).abs() < 1e-6)
    );
    let shadows = &scene.effects.shadows;
    assert_eq!(
        (shadows[0].light, shadows[0].size, shadows[0].taps),
        (1, Some(512), 5)
    );
    assert_eq!(shadows[0].bias, Some(ShadowBias::Constant(0.25)));
    assert_eq!(
        (shadows[1].light, shadows[1].size, shadows[1].bias),
        (2, None, None)
    );
    let slides = &scene.effects.projectors;
    assert_eq!(slides[0].role, SlideRole::Light([0.5; 3]));
    assert_eq!(
        (slides[1].role, slides[1].shadow),
        (SlideRole::Paint, Some(64))
    );
    // The slide's own aspect: twice as wide as high.
    let [q, s, _] = slides[0].projector.rows();
    assert!((s.y.abs() / q.x.abs() - 2.0).abs() < 1e-9);
    render(&scene, &Settings::new(16, 16), &|_, _| ()).unwrap();
}

#[test]
fn settings_hold_for_later_faces_and_end_with_none() {
    let scene = files().scene(&format!(
        "{FACE}env square.png octahedron 0.5\nspecmap square.png octahedron 10\nhighlight blinn\nf 0 1 2\n\
         env none\nspecmap none\nhighlight phong\nf 0 1 2\n"
    ));
    let [plain, shiny] = &scene.materials[..] else {
        panic!("{} materials", scene.materials.len())
    };
    assert!(plain.reflection.is_none() && plain.specular_map.is_none());
    assert_eq!(shiny.reflection.unwrap().environment, 0);
    assert_eq!(
        (shiny.specular_map, scene.effects.environments.len()),
        (Some(1), 2)
    );
}

#[test]
fn relief_and_light_maps_reach_models() {
    let obj =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let second = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.1 0.1\nvt 0.4 0.1\nvt 0.4 0.4\nvt 0.1 0.4\nf 1/1 2/2 3/3 4/4\n";
    let scene = files()
        .with("m.obj", obj)
        .with("l.obj", second)
        .with("n.mtl", "newmtl n\nnorm a.png\nnewmtl b\nbump -bm 0.3 a.png\n")
        .with("n.obj", format!("mtllib n.mtl\n{}usemtl n\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n", &obj[..obj.find('f').unwrap()]))
        .scene("lightmap a.png 2\nlightmapuv l.obj\nbump a.png 0.1\nobj m.obj\nlightmap none\nlightmapuv none\nnormalmap a.png down xy\nobj m.obj\nnormalmap none\nobj n.obj\n");
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.lightmap_uvs.len(), mesh.positions.len());
    for (uv, second) in mesh.uvs.iter().zip(&mesh.lightmap_uvs) {
        assert!(
            (second[0] - (0.1 + 0.3 * uv[0])).abs() < 1e-6
                && (second[1] - (0.1 + 0.3 * uv[1])).abs() < 1e-6
        );
    }
    let material = |i: usize| &scene.materials[scene.meshes[i].material];
    assert!(matches!(material(0).relief, Some(Relief::Bump { height, .. }) if height == 0.1));
    assert_eq!(material(0).light_map.as_ref().unwrap().scale, 2.0);
    assert!(matches!(
        material(1).relief,
        Some(Relief::NormalMap {
            green: Green::Down,
            rebuild_z: true,
            ..
        })
    ));
    assert!(matches!(material(2).relief, Some(Relief::NormalMap { .. })));
    assert!(matches!(material(3).relief, Some(Relief::Bump { height, .. }) if height == 0.3));
    render(&scene, &Settings::new(16, 16), &|_, _| ()).unwrap();
}

#[test]
fn faults_name_their_line() {
    for (text, code, line) in [
        ("la 1 1 1\nshadow\n", "needs-line-above", 2),
        (
            "projector a.png light 0 0 5 0 0 0 0 0 1 40\n",
            "bad-projector",
            1,
        ),
        (
            "projector a.png light 0 0 5 0 0 5 0 1 0 40\n",
            "bad-projector",
            1,
        ),
        (
            "projector gone.png light 0 0 5 0 0 0 0 1 0 40\n",
            "file-missing",
            1,
        ),
        ("env square.png lat-long 1\n", "environment-size", 1),
        ("\nbump gone.png 1\n", "file-missing", 2),
    ] {
        let files = files().with("a.scene", format!("{text}{FACE}"));
        let error = files.load("a.scene").unwrap_err();
        assert_eq!(
            (error.code(), error.place().unwrap().line),
            (code, line),
            "{error}"
        );
        assert!(!error.help().is_empty());
    }
}
