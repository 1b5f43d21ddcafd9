//! Lines of shape: displaced, bent and turned meshes.

use texmap_math::glam::DVec3;
use texmap_render::{RenderSettings, render};
use texmap_scene::{EdgeBudget, Mesh, Scene};

use crate::support::Files;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const FACE: &str = "tf 0 0 1 1 1 1 2 1 0 3 0 0\n";
const REST: &str = "tf 4 0 1 5 1 1 6 1 0 7 0 0\n";

/// A grey map: everything rises by half the height.
fn files() -> Files {
    let files = Files::new();
    let texels = [128, 128, 128, 255].repeat(64);
    texmap_io::image_io::write_png(&files.path("h.png"), 8, 8, &texels).expect("a picture");
    files
}

fn shaped(scene: &Scene) -> Scene {
    texmap_mesh::tessellate(scene, 64)
        .expect("a good scene")
        .into_owned()
}

fn top(mesh: &Mesh) -> f32 {
    mesh.positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max)
}

#[test]
fn displaced_faces_and_models_move_by_the_map() {
    let scene = files().scene(&format!(
        "texture h.png\nshade modulate\n{SQUARE}displace h.png 0.5 middle 0.25 texels 2 triangles 900\n{FACE}\
         translate 0 5 0\n{SQUARE}f 4 5 6\ndisplace none\n{REST}"
    ));
    let displaced: Vec<_> = scene
        .meshes
        .iter()
        .map(|m| m.displacement.clone())
        .collect();
    let line = displaced[0].as_ref().expect("displaced");
    assert_eq!(
        (line.height, line.middle, line.max_triangles),
        (0.5, 0.25, 900)
    );
    assert_eq!(line.budget, EdgeBudget::Texels(2.0));
    assert!(
        displaced[1..].iter().all(Option::is_none),
        "faces of `f` have no coordinates"
    );
    let scene = shaped(&scene);
    assert!(
        scene.meshes[0].triangles.len() >= 32,
        "{}",
        scene.meshes[0].triangles.len()
    );
    assert!(scene.meshes[0].faces.iter().all(|f| *f == 0));
    let expected = 0.5 * (128.0 / 255.0 - 0.25);
    assert!(
        (top(&scene.meshes[0]) - expected).abs() < 1e-3,
        "{}",
        top(&scene.meshes[0])
    );
    render(
        &scene,
        &RenderSettings::new(16, 16),
        &texmap_render::no_progress,
    )
    .expect("a frame");
}

#[test]
fn disp_of_a_material_displaces_in_units_of_the_model() {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n";
    let files = files()
        .with("m.mtl", "newmtl a\ndisp -bm 0.4 -s 2 2 h.png\n")
        .with("m.obj", obj);
    let scene = files.scene("scale 10\nobj m.obj\n");
    let displacement = scene.meshes[0].displacement.as_ref().expect("displaced");
    assert_eq!(
        (displacement.height, displacement.slot.transform.scale),
        (0.4, [2.0, 2.0])
    );
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let moved = shaped(&scene);
    assert!((top(&moved.meshes[0]) - 0.4 * 128.0 / 255.0).abs() < 1e-3);
    assert!(
        moved.meshes[0]
            .normals
            .iter()
            .all(|n| (n[2] - 1.0).abs() < 1e-6)
    );
}

#[test]
fn terrain_is_a_grid_over_its_map() {
    let scene =
        files().scene("texture h.png\ntranslate 1 0 0\nterrain h.png 0 2 0 14 4 7 step 3\n");
    let mesh = &scene.meshes[0];
    // Texels 0, 3, 6 and 7.
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (16, 18));
    let world = |i: usize| {
        let p = DVec3::from(mesh.positions[i].map(f64::from));
        mesh.world_from_object.transform_point3(p)
    };
    let height = 2.0 + 4.0 * 128.0 / 255.0;
    assert!((world(0) - DVec3::new(-6.0, height, -3.5)).length() < 1e-3);
    assert!((world(15) - DVec3::new(8.0, height, 3.5)).length() < 1e-3);
    assert_eq!(
        scene.materials[mesh.material].texture_role,
        texmap_scene::TextureRole::Modulate
    );
}

#[test]
fn billboards_turn_to_the_camera_of_each_picture() {
    let mut scene = files()
        .scene("texture h.png\nscale 2\nbillboard 1 0 0 1 3\nbillboard 0 1 0 1 1 axis 0 1 0\n");
    for eye in [DVec3::new(0.0, 3.0, 9.0), DVec3::new(9.0, 2.0, 0.0)] {
        (scene.camera.eye, scene.camera.look) = (eye, DVec3::ZERO);
        let turned = shaped(&scene);
        let edge = |mesh: usize, a: usize, b: usize| {
            let at = |i: usize| DVec3::from(turned.meshes[mesh].positions[i].map(f64::from));
            at(b) - at(a)
        };
        assert!(edge(0, 0, 1).dot(eye).abs() < 1e-5 && edge(0, 0, 3).dot(eye).abs() < 1e-5);
        assert!((edge(0, 0, 3).length() - 6.0).abs() < 1e-5 && edge(0, 0, 3).y > 0.0);
        assert!(edge(1, 0, 1).dot(DVec3::new(eye.x, 0.0, eye.z)).abs() < 1e-5);
        assert!((edge(1, 0, 3) - DVec3::Y * 2.0).length() < 1e-5);
    }
}

#[test]
fn skins_follow_the_bones_wherever_these_stand() {
    let arm = "v 0 0 0\nv 4 0 0\nv 4 1 0\nv 0 1 0\nskin smooth 1\nf 0 1 2 3\nskin none\nf 0 1 2 3\n\
               bone 0 0 0 2 0 0\nbone 2 0 0 4 0 0 parent 0 turn 90 0 0 1\n";
    let scene = files().scene(arm);
    let [bent, resting] = &scene.meshes[..] else {
        panic!("{} meshes", scene.meshes.len())
    };
    assert_eq!(resting.positions[1], [4.0, 0.0, 0.0]);
    let close = |a: [f32; 3], b: [f32; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-6);
    assert!(close(bent.positions[0], [0.0; 3]));
    assert!(
        close(bent.positions[1], [2.0, 2.0, 0.0]),
        "{:?}",
        bent.positions[1]
    );
    assert!(
        close(bent.positions[2], [1.0, 2.0, 0.0]),
        "{:?}",
        bent.positions[2]
    );
}

/// A mirror image has the fronts and the poses of what it mirrors.
#[test]
fn mirrors_keep_fronts_and_turn_the_sense_of_turns() {
    let both = |words: &str| {
        let of = |scale: &str| shaped(&files().scene(&format!("{scale}{words}")));
        [of(""), of("scale -1 1 1\n")]
    };
    let [plain, mirrored] = both("texture h.png\nterrain h.png 0 2 0 14 4 7 step 3\n");
    for scene in [plain, mirrored] {
        let mesh = &scene.meshes[0];
        let corner = |i: u32| {
            let p = DVec3::from(mesh.positions[i as usize].map(f64::from));
            mesh.world_from_object.transform_point3(p)
        };
        let sense = mesh.world_from_object.determinant().signum();
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(corner)) {
            // Renderers take the other side of a mirrored mesh for its front.
            assert!(sense * (b - a).cross(c - a).y > 0.0);
        }
    }
    let arm = "bone 0 0 0 2 0 0\nbone 2 0 0 4 0 0 parent 0 turn 90 0 0 1\nskin rigid\nv 0 0 0\nv 3 0 0\nv 3 0 1\nf 0 1 2\n";
    let [plain, mirrored] = both(arm);
    for (a, b) in plain.meshes[0]
        .positions
        .iter()
        .zip(&mirrored.meshes[0].positions)
    {
        assert!(
            (a[0] + b[0]).abs() < 1e-6 && a[1..] == b[1..],
            "{a:?} {b:?}"
        );
    }
    assert!(
        plain.meshes[0].positions.iter().any(|p| p[1] > 0.5),
        "it bends"
    );
}

#[test]
fn faults_name_their_line() {
    for (text, code, line) in [
        ("displace gone.png 1\n", "file-missing", 1),
        ("\nterrain one.png 0 0 0 1 1 1\n", "bad-shape", 2),
        ("billboard 0 0 0 1 1\n", "needs-line-above", 1),
        (
            "bone 0 0 0 1 0 0\nbone 0 0 0 1 0 0 parent 1\n",
            "out-of-range",
            2,
        ),
        ("v 0 0 0\nskin rigid\nf 0 0 0\n", "needs-line-above", 2),
        ("ls 1 1 1 0 0 3 0 0 -1 20 175\n\nshadow\n", "bad-shape", 3),
    ] {
        let files = files()
            .with_png("one.png", 1, 1, [0, 0, 0, 255])
            .with("a.scene", format!("{text}{SQUARE}f 0 1 2\n"));
        let error = files.load("a.scene").unwrap_err();
        assert_eq!(
            (error.code(), error.location().unwrap().line),
            (code, line),
            "{text}: {error}"
        );
        assert!(!error.help().is_empty());
    }
}
