//! Commands of a scene: the meshes, materials and settings that they give.

use texmap_light::Light;
use texmap_math::glam::DVec3;
use texmap_raster::{Cull, DepthTest};
use texmap_render::{Aov, AovData, RenderSettings, render};
use texmap_sample::{Filter, Wrap};
use texmap_scene::{AlphaMode, ColorMode, Scene, Shading, TextureRole};

use crate::support::Files;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn textured() -> Files {
    Files::new().with_png("a.png", 4, 4, [255, 255, 255, 255])
}

fn close(a: DVec3, b: [f64; 3]) -> bool {
    (a - DVec3::from(b)).length() < 1e-12
}

#[test]
fn defaults_are_the_course_loaders() {
    let scene = Files::new().scene(&format!("{SQUARE}f 0 1 2"));
    assert_eq!(scene.camera.eye.to_array(), [0.0, 0.0, -10.0]);
    assert_eq!(scene.camera.look.to_array(), [0.0; 3]);
    assert_eq!(scene.camera.up.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(scene.camera.fov_x, 30_f64.to_radians());
    assert_eq!((scene.camera.near, scene.camera.far), (1e-4, f64::INFINITY));
    assert_eq!(scene.depth_test, DepthTest::LessOrEqual);
    assert_eq!(
        (scene.color, scene.background),
        (ColorMode::Srgb, [0.0, 0.0, 0.0, 1.0])
    );
    let material = &scene.materials[0];
    assert_eq!(
        (
            material.phong.ka,
            material.phong.kd,
            material.phong.ks,
            material.phong.ns
        ),
        (1.0, 1.0, 1.0, 5.0)
    );
    // 0.5 is an sRGB value.
    assert!((material.phong.color[0] - 0.214_041).abs() < 1e-6);
    assert_eq!(
        (material.shading, material.cull, material.alpha),
        (Shading::PerPixel, Cull::None, AlphaMode::Opaque)
    );
}

#[test]
fn the_lectures_listing_is_read() {
    let listing = "eye 0 0 6\nlook 0 1 6\nup 0 0 1\nfov 60\nla 1 1 1\nld 1 1 1 0.5 0.5 -1\n\
        surf 0.8 0.2 0.9 0.5 0.5 0.0 1.0\ntexture walls.gif\nv -20 20 0\nv 20 20 0\nv 20 20 10\nv -20 20 10\n\
        tf 0 0 0.25 1 1 0.25 2 1 0 3 0 0\n";
    let files = Files::new().with("walls.gif", gif());
    let scene = files.scene(listing);
    assert_eq!(
        scene.lights,
        [
            Light::Ambient { color: [1.0; 3] },
            Light::Directional {
                color: [1.0; 3],
                direction: [0.5, 0.5, -1.0]
            },
        ]
    );
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.uvs, [[0.0, 0.25], [1.0, 0.25], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    let material = &scene.materials[mesh.material];
    assert_eq!(
        (material.texture_role, material.cull),
        (TextureRole::Decal, Cull::None)
    );
    // The transparent index of the picture makes it a cut-out.
    assert_eq!(material.alpha, AlphaMode::Test(0.0));
    assert_eq!(scene.textures[0].texel(0, 0, 0).map(|t| t[3]), Some(1.0));
    assert_eq!(scene.textures[0].texel(0, 1, 0).map(|t| t[3]), Some(0.0));
}

/// Two texels: red, and the transparent index.
fn gif() -> Vec<u8> {
    let mut bytes = b"GIF89a\x02\0\x01\0\x80\0\0\xff\0\0\0\xff\0".to_vec();
    bytes.extend(b"\x21\xf9\x04\x01\0\0\x01\0");
    bytes.extend(b"\x2c\0\0\0\0\x02\0\x01\0\0\x02\x02\x44\x0a\0\x3b");
    bytes
}

#[test]
fn settings_hold_for_later_faces_and_end_with_pop() {
    let scene = textured().scene(&format!(
        "{SQUARE}texture a.png\npush\nfilter nearest\nwrap clamp-to-edge mirrored-repeat\ncull back\nshade modulate vertex\n\
         alpha blend\nsurf 1 0 0 1 1 0 1\ntf 0 0 0 1 1 0 2 1 1\npop\ntf 0 0 0 1 1 0 2 1 1\n"
    ));
    let [inside, outside] = [0, 1].map(|i| &scene.materials[scene.meshes[i].material]);
    let sampler = &inside.base_color.as_ref().unwrap().sampler;
    assert_eq!(
        (sampler.filter, sampler.wrap_u, sampler.wrap_v),
        (Filter::Nearest, Wrap::ClampToEdge, Wrap::MirroredRepeat)
    );
    assert_eq!(
        (inside.cull, inside.shading, inside.alpha),
        (Cull::Back, Shading::PerVertex, AlphaMode::Blend)
    );
    assert_eq!(
        (inside.texture_role, inside.phong.color),
        (TextureRole::Modulate, [1.0, 0.0, 0.0])
    );
    let sampler = &outside.base_color.as_ref().unwrap().sampler;
    assert_eq!(
        (sampler.filter, sampler.wrap_u),
        (Filter::Trilinear, Wrap::Repeat)
    );
    assert_eq!(
        (outside.cull, outside.texture_role, outside.alpha),
        (Cull::None, TextureRole::Decal, AlphaMode::Opaque)
    );
    // One file, one texture; without a surf line the texel is not darkened.
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(outside.phong.color, [1.0; 3]);
}

#[test]
fn transforms_nest_and_the_nearest_acts_first() {
    let scene = Files::new().scene(
        "translate 10 0 0\npush\nrotate 90 0 0 1\nscale 2\nv 1 0 0\nv 0 1 0\npop\nv 1 0 0\nscale -1 1 1\nv 1 2 3\nf 0 1 2 3\n",
    );
    assert_eq!(
        scene.meshes[0].positions,
        [
            [10.0, 2.0, 0.0],
            [8.0, 0.0, 0.0],
            [11.0, 0.0, 0.0],
            [9.0, 2.0, 3.0]
        ]
    );
    let turned = Files::new().scene("rotate 30 0 0 2\nv 2 0 0\nv 0 2 0\nv 0 0 1\nf 0 1 2\n");
    let [x, y, z] = turned.meshes[0].positions[0];
    assert!((x - 3_f32.sqrt()).abs() < 1e-6 && (y - 1.0).abs() < 1e-6 && z == 0.0);
}

#[test]
fn included_files_count_their_own_vertices_and_leak_no_settings() {
    let part =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nsurf 0 1 0 1 1 1 1\ntranslate 5 5 5\nlp 1 1 1 0 0 9\nf 0 1 2\n";
    let scene = Files::new()
        .with("sub/part.scene", part)
        .scene("v 9 9 9\ntranslate 1 0 0\ninclude sub/part.scene\nv 8 8 8\nv 7 7 6\nf 0 1 2\n");
    assert_eq!(scene.meshes[0].positions[0], [1.0, 0.0, 0.0]);
    assert_eq!(
        scene.meshes[1].positions,
        [[9.0, 9.0, 9.0], [9.0, 8.0, 8.0], [8.0, 7.0, 6.0]]
    );
    assert_eq!(
        scene.materials[scene.meshes[0].material].phong.color,
        [0.0, 1.0, 0.0]
    );
    assert!(scene.materials[scene.meshes[1].material].phong.color[0] > 0.2);
    assert_eq!(scene.lights.len(), 1);
    assert_eq!((scene.meshes[0].faces[0], scene.meshes[1].faces[0]), (0, 1));
}

#[test]
fn vertex_normals_follow_the_courses_rule() {
    // A quad of two triangles of unlike size and direction, by the rule: corners 0 and 1 take the first triangle's.
    let scene = Files::new().scene("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 3\nf 0 1 2 3\n");
    let (first, second) = (
        DVec3::new(0.0, 0.0, 1.0),
        DVec3::new(3.0, -3.0, 1.0).normalize(),
    );
    let normals: Vec<DVec3> = scene.meshes[0]
        .normals
        .iter()
        .map(|n| DVec3::from(n.map(f64::from)))
        .collect();
    for (normal, expected) in normals.iter().zip([first, first, first, second]) {
        assert!((*normal - expected).length() < 1e-6, "{normals:?}");
    }
    // Shared by faces: the larger weighs more. Decals have no say.
    let shared = textured().scene(
        "texture a.png\nv 0 0 0\nv 1 0 0\nv 0 3 0\nv 0 0 4\nf 0 1 2\nf 0 3 1\ntf 0 0 0 3 0 0 2 0 0\n",
    );
    let normal = shared.meshes[0].normals[0].map(f64::from);
    assert!(
        close(
            DVec3::from(normal),
            [0.0, f64::from(0.8_f32), f64::from(0.6_f32)]
        ),
        "{normal:?}"
    );
    assert!(shared.meshes[1].normals.is_empty());
    // Back to back they cancel out; the first decides.
    let both = Files::new().scene("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\nf 0 2 1\n");
    assert_eq!(both.meshes[0].normals[0], [0.0, 0.0, 1.0]);
}

#[test]
fn raw_holds_for_the_whole_scene_wherever_it_stands() {
    let scene = textured().scene(&format!("{SQUARE}surf 0.5 0.5 0.5 1 1 1 1\nf 0 1 2\ntexture a.png\ntf 0 0 0 1 1 0 2 1 1\ncolor raw\n"));
    assert_eq!(scene.color, ColorMode::Raw);
    assert_eq!(scene.materials[0].phong.color, [0.5; 3]);
    let grey = Files::new().with_png("a.png", 1, 2, [128, 128, 128, 255]);
    let raw = grey.scene(&format!(
        "color raw\n{SQUARE}texture a.png\ntf 0 0 0 1 1 0 2 1 1\n"
    ));
    let value = raw.textures[0].texel(0, 0, 1).unwrap()[0];
    assert!((value - 128.0 / 255.0).abs() < 1e-6, "{value}");
}

#[test]
fn missing_maps_can_be_drawn_on_purpose() {
    let scene = Files::new().scene(&format!(
        "missing warn\n{SQUARE}texture gone.png\ntf 0 0 0 1 1 0 2 1 1\n"
    ));
    assert_eq!(scene.warnings.len(), 1);
    assert!(
        scene.warnings[0].contains("gone.png") && scene.warnings[0].contains("checker"),
        "{:?}",
        scene.warnings
    );
    assert_eq!(scene.textures[0].texel(0, 0, 0), Some([1.0, 0.0, 1.0, 1.0]));
}

fn uv(scene: &Scene) -> Vec<f32> {
    let settings = RenderSettings {
        aovs: vec![Aov::Uv],
        ..RenderSettings::new(64, 64)
    };
    let frame = render(scene, &settings, &texmap_render::no_progress).expect("a frame");
    match &frame.aovs[0].2 {
        AovData::F32(values) => values.clone(),
        AovData::U32(_) => panic!("uv is f32"),
    }
}

#[test]
fn a_framed_face_is_the_textured_face_within_a_millionth() {
    let camera = "eye 2 -1 4\nlook 0.5 0.5 0\nfov 40\ntexture a.png\n";
    let textured_face = format!("{camera}{SQUARE}tf 0 0 1 1 1 1 2 1 0 3 0 0\n");
    let framed_face = format!("{camera}{SQUARE}frame 0 1 0 1 0 0 0 -1 0\nff 0 1 2 3\n");
    let (a, b) = (
        textured().scene(&textured_face),
        textured().scene(&framed_face),
    );
    assert!(b.warnings.is_empty());
    let (a, b) = (uv(&a), uv(&b));
    let mut covered = 0;
    for (x, y) in a.iter().zip(&b) {
        assert_eq!(x.is_nan(), y.is_nan());
        if !x.is_nan() {
            covered += 1;
            assert!((x - y).abs() <= 1e-6, "{x} {y}");
        }
    }
    assert!(covered > 500, "{covered}");
    // The negative twin: a frame shifted in its plane is another picture.
    let shifted = textured().scene(&framed_face.replace("frame 0 1 0", "frame 0.01 1 0"));
    assert!(
        uv(&shifted)
            .iter()
            .zip(&a)
            .any(|(x, y)| (x - y).abs() > 1e-3)
    );
}

#[test]
fn a_frame_out_of_the_plane_is_drawn_with_a_warning() {
    let with = |frame: &str| {
        textured().scene(&format!(
            "{SQUARE}texture a.png\nframe {frame}\nff 0 1 2 3\n"
        ))
    };
    let tilted = with("0 0 0 1 0 0 0 1 1");
    assert!(
        tilted.warnings[0].contains("45.0000 degrees out of the plane"),
        "{:?}",
        tilted.warnings
    );
    let beside = with("0 0 0.25 1 0 0 0 1 0");
    assert!(
        beside.warnings[0].contains("0.25 units beside the plane"),
        "{:?}",
        beside.warnings
    );
    // Skewed and scaled in the plane is fine, and so is one that moves with the transform.
    assert!(with("0 0 0 3 1 0 0 0.5 0").warnings.is_empty());
    let moved = textured().scene(&format!(
        "translate 1 2 3\nrotate 33 1 2 3\nscale 2 2 2\n{SQUARE}texture a.png\nframe 0 0 0 1 0 0 0 1 0\nff 0 1 2 3\n"
    ));
    assert!(moved.warnings.is_empty(), "{:?}", moved.warnings);
}

#[test]
fn later_faces_win_where_depths_are_equal() {
    let pixel = |order: &str| {
        let scene = Files::new().scene(&format!(
            "color raw\neye 0.5 0.5 3\nlook 0.5 0.5 0\nla 1 1 1\n{SQUARE}{order}"
        ));
        let frame = render(
            &scene,
            &RenderSettings::new(9, 9),
            &texmap_render::no_progress,
        )
        .expect("a frame");
        let at = 4 * (9 * 4 + 4);
        [frame.rgba[at], frame.rgba[at + 1]]
    };
    let (red, green) = (
        "surf 1 0 0 1 0 0 1\nf 0 1 2 3\n",
        "surf 0 1 0 1 0 0 1\nf 0 1 2 3\n",
    );
    assert_eq!(pixel(&format!("{red}{green}")), [0, 255]);
    assert_eq!(pixel(&format!("{green}{red}")), [255, 0]);
}

/// Floats of HDR and EXR are linear light of any size in every map, as colours, as data and in raw mode; so are maps of materials.
#[test]
fn float_maps_are_linear_light() {
    let files = Files::new()
        .with("m.mtl", "newmtl a\nmap_Kd light.exr\nmap_d light.exr\n")
        .with("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n");
    let light = [200.0, -0.5, 0.25, 1.0];
    let picture = image::Rgba32FImage::from_pixel(4, 2, image::Rgba(light));
    texmap_tests::exr_files::write(&files.path("light.exr"), &picture).unwrap();
    image::Rgb32FImage::from_pixel(4, 2, image::Rgb([200.0, 3.0, 0.25]))
        .save(files.path("light.hdr"))
        .unwrap();
    let scene = files.scene(&format!(
        "{SQUARE}texture light.exr\nbump light.exr 1\nlightmap light.hdr\ntf 0 0 0 1 1 0 2 1 1\nobj m.obj\n"
    ));
    let mut found: Vec<[f32; 4]> = (scene.textures.iter())
        .flat_map(|t| [t.texel(0, 0, 0).unwrap(), t.texel(2, 0, 0).unwrap()])
        .collect();
    assert!(found.len() >= 6, "{found:?}");
    found.retain(|c| *c != light);
    // RGBE has steps of one for 200.
    assert_eq!(found, [[200.0, 3.0, 0.0, 1.0]; 2]);
}
