//! Materials, textures, samplers, lights and cameras.

use texmap_io::LoadOptions;
use texmap_light::Light;
use texmap_raster::Cull;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{AlphaMode, Material, NormalDetail, Scene, Shading, TextureSlot, UvSet};

use super::{TRIANGLE, asset, read, read_with, small, triangle_bytes};

fn material<'s>(scene: &'s Scene, name: &str) -> &'s Material {
    scene
        .materials
        .iter()
        .find(|m| m.name == name)
        .unwrap_or_else(|| panic!("no {name}"))
}

fn base(material: &Material) -> &TextureSlot {
    material.base_color.as_ref().expect("a texture")
}

#[test]
fn each_texture_reads_its_coordinates_by_its_sampler() {
    let scene = read("two_uv.glb");
    let lamps = material(&scene, "lamps");
    let slot = base(lamps);
    assert_eq!(slot.uv_set, UvSet::First);
    assert_eq!(
        (
            slot.sampler.filter,
            slot.sampler.wrap_u,
            slot.sampler.wrap_v
        ),
        (Filter::MipNearest, Wrap::ClampToEdge, Wrap::MirroredRepeat)
    );
    let emission = lamps.emission.as_ref().expect("light of its own");
    assert_eq!(emission.color, [1.0; 3], "half, twice as strong");
    let slot = emission.map.as_ref().expect("a map");
    assert_eq!(slot.uv_set, UvSet::Second);
    assert_eq!(
        (
            slot.sampler.filter,
            slot.sampler.wrap_u,
            slot.sampler.wrap_v
        ),
        (Filter::Bilinear, Wrap::Repeat, Wrap::ClampToEdge)
    );
    let model = lamps.metallic_roughness.as_ref().expect("a model of light");
    let slot = model.map.as_ref().expect("a map");
    assert_eq!(
        (slot.uv_set, slot.sampler.filter, slot.sampler.wrap_u),
        (UvSet::Second, Filter::Trilinear, Wrap::Repeat)
    );
    let (occlusion, strength) = model.occlusion.as_ref().expect("occlusion");
    assert_eq!(
        (*strength, occlusion.texture),
        (0.5, slot.texture),
        "one picture of numbers is one texture"
    );
    let mesh = &scene.meshes[0];
    let twice: Vec<[f32; 2]> = mesh.uvs.iter().map(|uv| uv.map(|x| 2.0 * x)).collect();
    assert_eq!(mesh.lightmap_uvs, twice);
    // 120 of 255 as a number, 220 of 255 as an sRGB colour.
    let number = scene.textures[slot.texture]
        .texel(0, 0, 0)
        .expect("a texel");
    assert!((number[0] - 120.0 / 255.0).abs() < 1e-4, "{number:?}");
    let color = scene.textures[base(lamps).texture]
        .texel(0, 0, 0)
        .expect("a texel");
    assert!((color[0] - 0.7157).abs() < 1e-3, "{color:?}");
    // The numbers of Phong's model follow the mean of the map: half a metal, whose map has no blue.
    assert_eq!(lamps.phong.kd, 1.0);
    assert!(scene.check().is_ok());
}

#[test]
fn alpha_modes_and_the_order_of_drawing() {
    let scene = read("plates.gltf");
    let names = |scene: &Scene| -> Vec<String> {
        let draws = scene.drawing_order().into_iter();
        draws
            .map(|draw| {
                let mesh = &scene.meshes[draw.mesh];
                scene.materials[mesh.material].name.clone()
            })
            .collect()
    };
    // Seen from the right, the farther of the two is on the left; of two sides the back comes first.
    assert_eq!(names(&scene), ["opaque", "mask", "blend", "blend", "unlit"]);
    let mut behind = scene.clone();
    behind.camera.eye = behind.camera.look * 2.0 - behind.camera.eye;
    assert_eq!(
        names(&behind),
        ["opaque", "mask", "unlit", "blend", "blend"]
    );
    let of = |name: &str| {
        let m = material(&scene, name);
        (
            m.alpha,
            m.cull,
            m.shading,
            scene.textures[base(m).texture].has_alpha(),
        )
    };
    assert_eq!(
        of("opaque"),
        (AlphaMode::Opaque, Cull::Back, Shading::PerPixel, false)
    );
    assert_eq!(
        of("mask"),
        (AlphaMode::Test(0.75), Cull::None, Shading::PerPixel, true)
    );
    assert_eq!(
        of("blend"),
        (AlphaMode::Blend, Cull::None, Shading::PerPixel, true)
    );
    assert_eq!(
        of("unlit"),
        (AlphaMode::Blend, Cull::Back, Shading::Unlit, true)
    );
    assert!(material(&scene, "unlit").metallic_roughness.is_none());
    assert_eq!(scene.textures.len(), 2, "one picture in two uses");
    // The opaque texture has its colour also where alpha is 0.
    let corner = |name: &str| {
        scene.textures[base(material(&scene, name)).texture]
            .texel(0, 0, 0)
            .expect("a texel")
    };
    assert!(corner("opaque")[1] > 0.3);
    assert_eq!(corner("blend"), [0.0; 4]);
}

#[test]
fn extensions_of_materials() {
    let scene = read("materials.glb");
    let of = |name: &str| {
        material(&scene, name)
            .metallic_roughness
            .as_ref()
            .expect("a model")
    };
    assert_eq!(
        (
            of("plastic").ior,
            of("plastic").roughness,
            of("gold").metallic
        ),
        (1.8, 0.3, 1.0)
    );
    let coat = of("coated").clearcoat.as_ref().expect("a coat");
    assert_eq!((coat.factor, coat.roughness), (1.0, 0.1));
    let sheen = of("cloth").sheen.as_ref().expect("sheen");
    assert_eq!((sheen.color, sheen.roughness), ([0.9, 0.6, 0.8], 0.4));
    assert_eq!(
        (of("pearl").specular, of("pearl").specular_color),
        (0.8, [1.0, 0.5, 0.7])
    );
    assert_eq!((of("gold").ior, of("gold").specular), (1.5, 1.0));
    let glow = material(&scene, "glow")
        .emission
        .as_ref()
        .expect("light")
        .color;
    assert!(
        glow.iter()
            .zip([0.3, 0.9, 0.6])
            .all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6),
        "{glow:?}"
    );
    // The exponent is that of a lobe as wide: smoother is narrower.
    assert!(material(&scene, "gold").phong.ns > material(&scene, "plastic").phong.ns);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn normal_maps_and_texture_transforms() {
    let scene = read("mirrored.glb");
    let Some(NormalDetail::NormalMap {
        strength,
        green,
        object_space,
        ..
    }) = &material(&scene, "bumps").normal_detail
    else {
        panic!("a normal map")
    };
    assert_eq!(
        (*strength, *green, *object_space),
        (0.8, texmap_light::NormalMapGreen::Up, false)
    );
    // A quarter turn counter-clockwise, as it looks in a picture whose v grows downwards, and one down.
    let scene = read("quantized.glb");
    let transform = base(material(&scene, "turned")).transform;
    for (uv, expected) in [
        ([0.0, 0.0], [0.0, 1.0]),
        ([1.0, 0.0], [0.0, 0.0]),
        ([0.0, 1.0], [1.0, 1.0]),
    ] {
        let got = transform.apply(uv);
        assert!(
            (got[0] - expected[0]).abs() + (got[1] - expected[1]).abs() < 1e-6,
            "{uv:?} {got:?}"
        );
    }
}

/// Plates of the same bumps under other coordinates, far away so that the eye sees all at one angle.
#[test]
fn tangents_of_the_file_turn_the_normals() {
    let scene = read("tangents.glb");
    let tangents: Vec<_> = scene.meshes.iter().map(|m| m.tangents.clone()).collect();
    assert!(tangents[0].is_empty());
    assert_eq!(tangents[2], vec![[-1.0, 0.0, 0.0, -1.0]; 4]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let plates = |scene: &Scene| -> Vec<Vec<u8>> {
        (0..4)
            .map(|k| {
                let mut one = scene.clone();
                one.meshes = vec![scene.meshes[k].clone()];
                one.meshes[0].world_from_object = texmap_math::glam::DMat4::IDENTITY;
                one.camera.eye = [0.3, 0.5, 2.0].into();
                one.camera.look = [0.0, 0.0, 0.0].into();
                one.lights = vec![Light::Directional {
                    color: [2.0; 3],
                    direction: [0.5, -0.7, -0.6],
                }];
                let settings = texmap_render::RenderSettings::new(48, 48);
                let frame = texmap_render::render(&one, &settings, &texmap_render::no_progress);
                frame.expect("a frame").rgba
            })
            .collect()
    };
    let off = |a: &[u8], b: &[u8]| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
    };
    let alike = plates(&scene);
    for (k, plate) in alike.iter().enumerate() {
        assert!(off(plate, &alike[0]) <= 3, "{k}: {}", off(plate, &alike[0]));
    }
    // Each sign and direction counts.
    let mut wrong = scene.clone();
    wrong.meshes[1].tangents = vec![[1.0, 0.0, 0.0, -1.0]; 4];
    wrong.meshes[2].tangents = vec![[1.0, 0.0, 0.0, -1.0]; 4];
    wrong.meshes[3].tangents = vec![[1.0, 0.0, 0.0, 1.0]; 4];
    for (k, plate) in plates(&wrong).iter().enumerate().skip(1) {
        assert!(off(plate, &alike[0]) > 40, "{k}");
    }
    // Without them they are computed from the coordinates, which is the same here.
    scene_without_tangents(&mut wrong);
    for (k, plate) in plates(&wrong).iter().enumerate() {
        assert!(off(plate, &alike[0]) <= 3, "{k}");
    }
}

fn scene_without_tangents(scene: &mut Scene) {
    scene
        .meshes
        .iter_mut()
        .for_each(|mesh| mesh.tangents.clear());
}

#[test]
fn lights_in_physical_units() {
    let scene = read("instances.glb");
    let [
        Light::Directional { color, direction },
        Light::Punctual {
            intensity,
            position,
            range,
            cone: None,
        },
        Light::Punctual {
            cone: Some(cone),
            range: endless,
            ..
        },
    ] = &scene.lights[..]
    else {
        panic!("{:?}", scene.lights)
    };
    assert!((color[0] - 0.5 / std::f32::consts::PI).abs() < 1e-6);
    assert_eq!(*direction, [0.0, 0.0, -1.0]);
    assert_eq!(
        (*intensity, *position, *range),
        ([1.5, 0.9, 0.3], [-1.0, 1.0, 1.0], 4.0)
    );
    for (cos, angle) in [(cone.cos_inner, 0.2_f64), (cone.cos_outer, 0.4)] {
        assert!((f64::from(cos) - angle.cos()).abs() < 1e-6);
    }
    assert!(endless.is_infinite());
    assert_eq!(scene.light_named("bulb"), Ok(1));
    // The studio lights all models, beside the lights of their own; raw colours are not light.
    assert!(scene.effects.environment_light.is_some());
    let dark = read("box.glb");
    assert!(dark.lights.is_empty() && dark.effects.environment_light.is_some());
    let options = LoadOptions {
        color: Some(texmap_scene::ColorMode::Raw),
        ..LoadOptions::default()
    };
    let raw = texmap_io::load(&asset("box.glb"), &options).expect("a box");
    assert_eq!(
        raw.lights,
        texmap_io::framing::auto_lights(texmap_io::framing::Up::Y)
    );
    assert!(raw.effects.environment_light.is_none());
}

#[test]
fn cameras_by_name_and_number() {
    let with = |camera: &str, aspect: f64| {
        let options = LoadOptions {
            camera: Some(camera.into()),
            aspect,
            ..LoadOptions::default()
        };
        read_with("box.glb", options)
    };
    let whole = 2.0 * 0.4_f64.tan().atan();
    for (name, aspect, fov) in [
        ("front", 1.0, whole),
        ("0", 1.0, whole),
        // A wider picture shows more at its sides, a narrower one more above and below.
        ("front", 2.0, 2.0 * (2.0 * 0.4_f64.tan()).atan()),
        ("front", 0.5, whole),
    ] {
        let camera = with(name, aspect).expect("a camera").camera;
        assert!((camera.fov_x - fov).abs() < 1e-12, "{name} {aspect}");
        assert_eq!(
            (camera.eye.to_array(), camera.look.to_array(), camera.near),
            ([0.0, 0.0, 3.0], [0.0, 0.0, 2.0], 0.1)
        );
    }
    let error = with("back", 1.0).unwrap_err();
    assert_eq!(
        (error.code(), error.help().as_str()),
        (
            "unknown-name",
            "there are: 0 'front' (`texmap info` lists them)"
        )
    );
    assert_eq!(with("1", 1.0).unwrap_err().code(), "unknown-name");
}

#[test]
fn a_webp_comes_before_the_picture_for_others() {
    let scene = read("webp.glb");
    let texture = &scene.textures[base(material(&scene, "letter")).texture];
    assert_eq!(
        (texture.width(), texture.height()),
        (64, 64),
        "the other one is smaller"
    );
    let red = texture.texel(0, 0, 0).expect("a texel");
    assert!(red[0] > 0.6 && red[1] < 0.1, "{red:?}");
}

/// Glass is blended, whatever its alpha; a metal and a factor of 0 are opaque. The inside colours the light that passes.
#[test]
fn glass_is_a_sheet_that_light_passes() {
    let glass = |(metallic, pbr): (u8, &str), factor: f32, volume: &str, more: &str| {
        let json = TRIANGLE
            .replace(r#""indices":1"#, r#""indices":1,"material":0"#)
            .replace(
                r#""nodes""#,
                &format!(
                    r#""materials":[{{"pbrMetallicRoughness":{{"metallicFactor":{metallic}{pbr}}},"extensions":{{
                    "KHR_materials_transmission":{{"transmissionFactor":{factor}}},"KHR_materials_volume":{{{volume}}}}}{more}}}],"nodes""#
                ),
            );
        let scene = small(&json, &triangle_bytes()).unwrap_or_else(|e| panic!("{e}"));
        scene.materials[0].clone()
    };
    let model = |material: &Material| material.metallic_roughness.clone().expect("a model");
    let clear = glass((0, r#","baseColorFactor":[0.5,1,1,0.25]"#), 0.75, "", "");
    assert_eq!((clear.alpha, clear.opacity), (AlphaMode::Blend, 1.0));
    assert_eq!(clear.phong.color, [0.5, 1.0, 1.0]);
    assert_eq!(model(&clear).transmission.map(|t| t.factor), Some(0.75));
    // Twice the distance after which a quarter of red is left.
    let inside = r#""thicknessFactor":2,"attenuationDistance":1,"attenuationColor":[0.25,1,1]"#;
    let coloured = glass((0, ""), 1.0, inside, "");
    assert!((coloured.phong.color[0] - 0.0625).abs() < 1e-6);
    assert_eq!(coloured.phong.color[1..], [1.0, 1.0]);
    let half = glass((0, ""), 0.5, inside, "");
    assert!((half.phong.color[0] - 0.53125).abs() < 1e-6);
    for (metallic, factor) in [(0, 0.0), (1, 1.0)] {
        let opaque = glass((metallic, ""), factor, inside, "");
        assert_eq!(opaque.alpha, AlphaMode::Opaque, "{metallic} {factor}");
        assert!(model(&opaque).transmission.is_none());
        assert_eq!(opaque.phong.color, [1.0; 3]);
    }
    // Holes stay holes.
    let mask = glass((0, ""), 1.0, "", r#","alphaMode":"MASK""#);
    assert_eq!(mask.alpha, AlphaMode::Test(0.5));
}

/// Hidden nodes, and those below them, are not drawn.
#[test]
fn hidden_nodes_are_not_drawn() {
    let with = |visible: &str| {
        let json = TRIANGLE.replace(
            r#""nodes":[{"mesh":0}]"#,
            &format!(
                r#""extensionsUsed":["KHR_node_visibility"],"scenes":[{{"nodes":[0,1]}}],
                "nodes":[{{"mesh":0}},{{"children":[2],"extensions":{{"KHR_node_visibility":{visible}}}}},{{"mesh":0}}]"#
            ),
        );
        let scene = small(&json, &triangle_bytes()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.warnings, [""; 0]);
        scene.meshes.len()
    };
    assert_eq!(with(r#"{"visible":false}"#), 1);
    assert_eq!(with(r#"{"visible":true}"#), 2);
    assert_eq!(with("{}"), 2);
}
