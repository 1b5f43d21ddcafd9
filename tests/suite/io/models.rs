//! OBJ models, their materials and maps, alone and in scenes.

use texmap_io::scene_file::Missing;
use texmap_io::{LoadOptions, load};
use texmap_render::{Frame, RenderSettings, render};
use texmap_sample::{Origin, Wrap};
use texmap_scene::{AlphaMode, MetallicRoughness, Scene, TextureRole};

use crate::support::Files;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
const FACE: &str = "f 1/1 2/2 3/3 4/4\n";

fn files(mtl: &str) -> Files {
    Files::new()
        .with_png("map.png", 4, 4, [255, 255, 255, 255])
        .with("a.mtl", mtl)
        .with("a.obj", format!("mtllib a.mtl\n{SQUARE}usemtl m\n{FACE}"))
}

fn frame(scene: &Scene) -> Frame {
    render(
        scene,
        &RenderSettings::new(33, 33),
        &texmap_render::no_progress,
    )
    .expect("a frame")
}

fn pixel(frame: &Frame, x: usize, y: usize) -> [u8; 3] {
    let at = 4 * (33 * y + x);
    [frame.rgba[at], frame.rgba[at + 1], frame.rgba[at + 2]]
}

/// Folders that tell letters of both cases apart, and models from machines that do not, with the paths of these.
#[test]
fn files_of_another_machine_are_found_with_a_warning() {
    let files = Files::new()
        .with_png("Map.PNG", 4, 4, [255, 255, 255, 255])
        .with(
            "A.mtl",
            "newmtl m\nmap_Kd C:\\art\\map.png\nmap_Ke C:\\art\\map.png\n",
        )
        .with("a.obj", format!("mtllib a.MTL\n{SQUARE}usemtl m\n{FACE}"));
    let scene = files.load("a.obj").expect("a model");
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(scene.textures[0].width(), 4);
    let told = |part: &str| scene.warnings.iter().filter(|w| w.contains(part)).count();
    assert_eq!(told("a.obj:1:1: "), 1, "{:?}", scene.warnings);
    assert_eq!(told("a.MTL: no such file: A.mtl is read"), 1);
    assert_eq!(told("A.mtl:2:1: "), 1);
    assert_eq!(told("C:/art/map.png: no such file: Map.PNG is read"), 1);
    // Two files that differ in case alone: neither is meant.
    let files = files.with_png("mAP.png", 2, 2, [255, 255, 255, 255]);
    let error = files.load("a.obj").expect_err("a lost map").to_string();
    assert!(error.contains("C:/art/map.png: no such file"), "{error}");
}

#[test]
fn v_grows_upwards_in_an_obj_and_downwards_in_a_scene() {
    // The picture's top row is black, the rest white.
    let camera = "color raw\neye 0.5 0.5 1\nlook 0.5 0.5 0\nfov 50\nfilter nearest\nshade decal\n";
    let obj = files("newmtl m\nmap_Kd map.png\n").scene(&format!("{camera}obj a.obj\n"));
    assert_eq!(obj.meshes[0].uv_origin, Origin::BottomLeft);
    let picture = frame(&obj);
    assert_eq!(
        (pixel(&picture, 16, 3), pixel(&picture, 16, 30)),
        ([0; 3], [255; 3])
    );
    let scene = files("").scene(&format!(
        "{camera}texture map.png\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ntf 0 0 0 1 1 0 2 1 1 3 0 1\n"
    ));
    let picture = frame(&scene);
    assert_eq!(
        (pixel(&picture, 16, 3), pixel(&picture, 16, 30)),
        ([255; 3], [0; 3])
    );
}

#[test]
fn materials_of_a_library() {
    let scene = files(
        "newmtl other\nKd 1 0 0\nnewmtl m\nKd 0.5 0.5 0.5\nKs 0.2 0.4 0.1\nNs 12\nmap_Kd -s 2 3 -o 0.25 0.5 -clamp on map.png\n",
    )
    .load("a.obj")
    .expect("a model");
    let material = &scene.materials[scene.meshes[0].material];
    assert_eq!(
        (material.name.as_str(), material.texture_role),
        ("m", TextureRole::Modulate)
    );
    assert_eq!(
        (material.phong.ks, material.phong.ns, material.phong.kd),
        (0.4, 12.0, 1.0)
    );
    assert!((material.phong.color[0] - 0.214_041).abs() < 1e-6);
    let slot = material.base_color.as_ref().expect("a map");
    assert_eq!(
        (slot.transform.scale, slot.transform.offset),
        ([2.0, 3.0], [0.25, 0.5])
    );
    assert_eq!(
        (slot.sampler.wrap_u, slot.sampler.wrap_v),
        (Wrap::ClampToEdge, Wrap::ClampToEdge)
    );
    assert_eq!(material.alpha, AlphaMode::Opaque);
}

#[test]
fn opacity_and_cut_outs() {
    let alpha = |mtl: &str| {
        let scene = files(mtl).load("a.obj").expect("a model");
        let material = &scene.materials[scene.meshes[0].material];
        (
            material.alpha,
            material.opacity,
            material.opacity_map.is_some(),
        )
    };
    assert_eq!(alpha("newmtl m\nd 0.5\n"), (AlphaMode::Blend, 0.5, false));
    assert_eq!(
        alpha("newmtl m\nTr 0.25\n"),
        (AlphaMode::Blend, 0.75, false)
    );
    assert_eq!(
        alpha("newmtl m\nmap_d map.png\n"),
        (AlphaMode::Test(0.0), 1.0, true)
    );
    assert_eq!(
        alpha("newmtl m\nKd 1 1 1\n"),
        (AlphaMode::Opaque, 1.0, false)
    );
}

#[test]
fn a_model_alone_is_framed_and_lit() {
    let scene = files("newmtl m\nmap_Kd map.png\n")
        .load("a.obj")
        .expect("a model");
    assert!(!scene.lights.is_empty());
    let picture = frame(&scene);
    let background = pixel(&picture, 0, 0);
    let seen = (0..33 * 33)
        .filter(|i| pixel(&picture, i % 33, i / 33) != background)
        .count();
    assert!((60..33 * 33 - 60).contains(&seen), "{seen} pixels");
    assert_ne!(pixel(&picture, 16, 16), background);
}

#[test]
fn faces_without_a_material_take_the_scenes_texture_and_surface() {
    let bare = || {
        Files::new()
            .with_png("map.png", 4, 4, [9, 9, 9, 255])
            .with("b.obj", format!("{SQUARE}{FACE}"))
    };
    let scene =
        bare().scene("texture map.png\nobj b.obj\ntexture none\nsurf 0 0 1 1 1 0 1\nobj b.obj\n");
    let [textured, plain] = [0, 1].map(|i| &scene.materials[scene.meshes[i].material]);
    assert!(textured.base_color.is_some() && textured.texture_role == TextureRole::Modulate);
    assert_eq!((textured.phong.color, textured.phong.ks), ([1.0; 3], 0.0));
    assert!(plain.base_color.is_none());
    assert_eq!(plain.phong.color, [0.0, 0.0, 1.0]);
    assert_eq!(scene.meshes[0].name, "b");
}

#[test]
fn missing_coordinates_are_projected_and_told() {
    let scene = Files::new()
        .with_png("map.png", 4, 4, [9, 9, 9, 255])
        .with("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
        .scene("texture map.png\nobj b.obj\n");
    assert!(
        scene.warnings[0].contains("b.obj:5") && scene.warnings[0].contains("box projection"),
        "{:?}",
        scene.warnings
    );
    assert_eq!(scene.meshes[0].uvs.len(), scene.meshes[0].positions.len());
    assert!(
        render(
            &scene,
            &RenderSettings::new(8, 8),
            &texmap_render::no_progress
        )
        .is_ok()
    );
}

#[test]
fn mirroring_keeps_the_outside_outside() {
    let covered = |scale: &str, cull: &str| {
        let lines = format!("eye 0 0 6\nlook 0 0 0\n{scale}\ncull {cull}\nobj a.obj\n");
        let scene = files("newmtl m\n").scene(&lines);
        frame(&scene).stats.pixels_covered
    };
    for scale in ["scale 1 1 1", "scale -1 1 1", "scale -1 -1 1"] {
        assert!(covered(scale, "back") > 10, "{scale}");
        assert_eq!(covered(scale, "front"), 0, "{scale}");
    }
    // Turned about by half a turn it shows its back.
    assert_eq!(covered("rotate 180 0 1 0", "back"), 0);
}

#[test]
fn missing_libraries_and_maps_may_be_warnings() {
    let lenient = LoadOptions {
        missing: Some(Missing::Checker),
        ..LoadOptions::default()
    };
    let files = Files::new().with(
        "a.obj",
        format!("mtllib gone.mtl\n{SQUARE}usemtl m\n{FACE}"),
    );
    assert_eq!(
        files.load("a.obj").expect_err("strict").code(),
        "file-missing"
    );
    let scene = load(&files.path("a.obj"), &lenient).expect("a model");
    assert!(
        scene.warnings.iter().any(|w| w.contains("gone.mtl")),
        "{:?}",
        scene.warnings
    );
    let files = files.with("gone.mtl", "newmtl m\nmap_Kd gone.png\n");
    let scene = load(&files.path("a.obj"), &lenient).expect("a model");
    assert!(
        scene.warnings.iter().any(|w| w.contains("gone.png")),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn black_diffuse_does_not_hide_a_map() {
    let scene = files("newmtl m\nKd 0 0 0\nmap_Kd map.png\n")
        .load("a.obj")
        .expect("a model");
    assert_eq!(
        scene.materials[scene.meshes[0].material].phong.color,
        [1.0; 3]
    );
    assert!(
        scene.warnings[0].contains("Kd is black"),
        "{:?}",
        scene.warnings
    );
}

/// Nothing darkens the colours of vertices that a model brings without a material.
#[test]
fn vertex_colours_are_drawn_as_they_are() {
    let files = Files::new().with(
        "a.obj",
        "v 0 0 0 .5 .25 .75\nv 1 0 0 .5 .25 .75\nv 0 1 0 .5 .25 .75\nf 1 2 3\n",
    );
    let scene = files.load("a.obj").expect("a model");
    assert_eq!(
        scene.materials[scene.meshes[0].material].phong.color,
        [1.0; 3]
    );
}

#[test]
fn backslashes_separate_folders_too() {
    let scene = files("newmtl m\nmap_Kd maps\\wall.png\n").with("maps/x", "");
    std::fs::copy(scene.path("map.png"), scene.path("maps/wall.png")).expect("a copy");
    assert_eq!(scene.load("a.obj").expect("a model").textures.len(), 1);
}

#[test]
fn surfaces_give_off_the_light_of_their_library() {
    let emission = |mtl: &str| {
        let scene = files(mtl).load("a.obj").expect("a model");
        let emission = scene.materials[0].emission.clone();
        (emission, scene.warnings)
    };
    let (none, _) = emission("newmtl m\nKe 0 0 0\n");
    assert!(none.is_none());
    let (some, _) = emission("newmtl m\nKd 0 0 0\nKe 1 0.5 3\n");
    let some = some.expect("light");
    let half = texmap_math::color::srgb_to_linear(0.5);
    assert_eq!((some.color, some.map), ([1.0, half, 3.0], None));
    // Without a factor the map is the light, as with one that a program wrote black.
    let (mapped, warnings) = emission("newmtl m\nmap_Ke -s 2 2 map.png\n");
    let mapped = mapped.expect("light");
    assert_eq!(mapped.color, [1.0; 3]);
    assert_eq!(mapped.map.expect("a map").transform.scale, [2.0; 2]);
    assert!(warnings.is_empty(), "{warnings:?}");
    let (black, warnings) = emission("newmtl m\nKe 0 0 0\nmap_Ke map.png\n");
    assert_eq!(black.expect("light").color, [1.0; 3]);
    assert!(warnings[0].contains("Ke is black"), "{warnings:?}");
}

#[test]
fn a_missing_map_of_emission_is_no_black_picture() {
    let mtl = "newmtl m\nKd 0 0 0\nKe 1 1 1\nmap_Ke gone.png\n";
    let error = files(mtl).load("a.obj").unwrap_err();
    assert_eq!(error.code(), "file-missing");
    assert_eq!(error.location().map(|p| p.line), Some(4));
    let scene = files(mtl).scene("missing warn\nla 1 1 1\nobj a.obj\n");
    assert!(
        scene.warnings.iter().any(|w| w.contains("gone.png")),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn statements_that_are_not_drawn_are_told_with_their_line() {
    let files = files("newmtl m\nKd 1 1 1\nPr 0.3\nrefl -type sphere map.png\nNi 1.5\n");
    let told = files.load("a.obj").expect("a model").warnings;
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("a.mtl:4:1") && told[0].contains("`refl`"));
    // A scene is classic.
    let scene = files.scene("la 1 1 1\nobj a.obj\n");
    assert!(
        scene
            .materials
            .iter()
            .all(|m| m.metallic_roughness.is_none())
    );
    let told = scene.warnings;
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].contains("a.mtl:3:1") && told[0].contains("`Pr`"));
}

/// The model of the only material of an OBJ with this library, and the warnings.
fn metallic(files: &Files) -> (Scene, MetallicRoughness) {
    let scene = files.load("a.obj").expect("a model");
    let used = &scene.materials[scene.meshes[0].material];
    let model = used.metallic_roughness.clone().expect("metallic-roughness");
    (scene, model)
}

#[test]
fn letters_with_a_p_make_a_material_metallic_roughness() {
    let (scene, model) = metallic(&files(
        "newmtl m\nKd 0.5 0.5 0.5\nNs 6\nPr 0.3\nPm 0.8\nPs 0.4\nPc 0.9\nPcr 0.1\nKe 1 0 0\n",
    ));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(
        (model.roughness, model.metallic, model.specular),
        (0.3, 0.8, 1.0)
    );
    let (coat, sheen) = (model.clearcoat.unwrap(), model.sheen.unwrap());
    assert_eq!(
        (coat.factor, coat.roughness, sheen.color),
        (0.9, 0.1, [0.4; 3])
    );
    assert!(scene.materials[scene.meshes[0].material].emission.is_some());
    // The exponent stands for a roughness that is not given, and layers of no strength are none.
    let (_, model) = metallic(&files("newmtl m\nNs 6\nPm 1\nPs 0\nPc 0\n"));
    assert!((model.roughness - 0.5).abs() < 1e-6 && model.metallic == 1.0);
    assert!(model.clearcoat.is_none() && model.sheen.is_none());
    // Without a word of the extension the reader leaves the classic model.
    let plain = files("newmtl m\nNs 6\nKs 1 1 1\nnorm map.png\nKe 1 1 1\n");
    let plain = plain.load("a.obj").unwrap();
    assert!(
        plain
            .materials
            .iter()
            .all(|m| m.metallic_roughness.is_none())
    );
}

#[test]
fn roughness_and_metalness_are_packed_into_one_texture() {
    let files = |mtl: &str| {
        files(mtl)
            .with_png("rough.png", 4, 4, [102, 102, 102, 255])
            .with_png("metal.png", 2, 2, [51, 51, 51, 255])
            .with_png("orm.png", 2, 2, [255, 204, 153, 255])
    };
    // A map stands in place of its number.
    let mtl = "newmtl m\nPr 0.5\nPm 0\nmap_Pr -s 2 2 rough.png\nmap_Pm -s 2 2 metal.png\n";
    let (scene, model) = metallic(&files(mtl));
    assert_eq!((model.roughness, model.metallic), (1.0, 1.0));
    let slot = model.map.expect("a map");
    assert_eq!(slot.transform.scale, [2.0, 2.0]);
    let texture = &scene.textures[slot.texture];
    assert_eq!((texture.width(), texture.height()), (4, 4));
    // Three quarters of the way from the black row of the smaller picture to the other.
    let [_, green, blue, _] = texture.texel(0, 1, 2).unwrap();
    assert!(
        (green - 0.4).abs() < 0.01 && (blue - 0.15).abs() < 0.01,
        "{green} {blue}"
    );
    let told = &scene.warnings;
    assert!(
        told.len() == 1 && told[0].contains("2 x 2 pixels, map_Pr 4 x 4"),
        "{told:?}"
    );
    // One file for both is packed as glTF packs it; other options are told.
    let (scene, model) = metallic(&files(
        "newmtl m\nmap_Pr orm.png\nmap_Pm -o 0.5 0 orm.png\n",
    ));
    let texture = &scene.textures[model.map.unwrap().texture];
    let [_, green, blue, _] = texture.texel(0, 1, 1).unwrap();
    assert!((green - 0.8).abs() < 0.01 && (blue - 0.6).abs() < 0.01);
    assert!(
        scene.warnings[0].contains("other options"),
        "{:?}",
        scene.warnings
    );
    // Alone, metalness leaves the roughness of the number.
    let (scene, model) = metallic(&files("newmtl m\nPr 0.3\nmap_Pm metal.png\n"));
    assert_eq!((model.roughness, model.metallic), (0.3, 1.0));
    let texture = &scene.textures[model.map.unwrap().texture];
    assert_eq!(texture.texel(0, 1, 1).unwrap()[1], 1.0);
    // A missing map is an error, or a stand-in where that is asked for.
    let lost = files("newmtl m\nmap_Pr gone.png\nmap_Pm metal.png\n");
    assert_eq!(lost.load("a.obj").unwrap_err().code(), "file-missing");
}
