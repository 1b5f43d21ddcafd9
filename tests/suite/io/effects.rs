//! Lines of light: the lights, projectors and maps that they give.

use texmap_light::{Light, NormalMapGreen, ShadowBias};
use texmap_math::glam::DVec3;
use texmap_render::{Aov, RenderSettings, render};
use texmap_scene::{NormalDetail, ProceduralHeight, ProjectorMode};

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
        (shadows[0].light, shadows[0].size, shadows[0].pcf_size),
        (1, Some(512), 5)
    );
    assert_eq!(shadows[0].bias, Some(ShadowBias::Constant(0.25)));
    assert_eq!(
        (shadows[1].light, shadows[1].size, shadows[1].bias),
        (2, None, None)
    );
    let projectors = &scene.effects.projectors;
    assert_eq!(projectors[0].mode, ProjectorMode::Light([0.5; 3]));
    assert_eq!(
        (projectors[1].mode, projectors[1].shadow),
        (ProjectorMode::Decal, Some(64))
    );
    // The picture's own aspect: twice as wide as high.
    let [q, s, _] = projectors[0].projector.rows();
    assert!((s.y.abs() / q.x.abs() - 2.0).abs() < 1e-9);
    render(
        &scene,
        &RenderSettings::new(16, 16),
        &texmap_render::no_progress,
    )
    .unwrap();
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
fn casters_of_shadows_and_their_parts_in_a_map() {
    let floor = "v -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\n";
    let lid = "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    let pixel = |words: &str, setting: &str| {
        let scene = files().scene(&format!(
            "background 1 1 1\neye 0 -9 9\nfov 60\nld 1 1 1 0 0 -1\nshadow 64 taps 1 {words}\n{floor}{lid}f 0 1 2 3\n{setting}f 4 5 6 7\n"
        ));
        let frame = render(
            &scene,
            &RenderSettings::new(64, 64),
            &texmap_render::no_progress,
        )
        .unwrap();
        // The ground under the lid, seen below its edge.
        let at = (0..64).map(|y| frame.rgba[(y * 64 + 32) * 4]);
        (scene, at.filter(|c| *c < 60).count())
    };
    let (scene, dark) = pixel("", "");
    assert!(dark > 0 && scene.meshes.len() == 1 && !scene.meshes[0].casts_no_shadow);
    let (scene, none) = pixel("", "shadowless yes\n");
    assert_eq!((none, scene.meshes.len()), (0, 2));
    assert!(!scene.meshes[0].casts_no_shadow && scene.meshes[1].casts_no_shadow);
    let (_, back) = pixel("", "shadowless yes\nshadowless no\n");
    assert_eq!(back, dark);
    // A map of the lid alone shows its shadow; one of another area does not, and points outside of the map are lit.
    let (scene, there) = pixel("area 0 0 0 1.5", "");
    let area = scene.effects.shadows[0].area.unwrap();
    assert_eq!((area.0.to_array(), area.1), ([0.0; 3], 1.5));
    assert!(there > 0);
    assert_eq!(pixel("area 3 3 0 0.5", "").1, 0);
}

#[test]
fn environments_with_levels_and_an_open_horizon() {
    let scene = files().scene(&format!(
        "{FACE}env square.png octahedron 0.5\nf 0 1 2\nenv square.png octahedron 0.5 mips\nhorizon open\nf 0 1 2\n\
         env square.png octahedron 0.25\nhorizon clamp\nf 0 1 2\n"
    ));
    let levels: Vec<usize> = scene
        .effects
        .environments
        .iter()
        .map(|e| e.levels())
        .collect();
    assert_eq!(
        levels,
        [1, 4],
        "8, 4, 2 and 1 texels; each file is read once for each use"
    );
    let of = |k: usize| {
        let material = &scene.materials[scene.meshes[k].material];
        (
            material.reflection.map(|r| r.environment),
            material.horizon_clamp,
        )
    };
    assert_eq!(of(0), (None, true));
    let rest: Vec<_> = (1..scene.meshes.len()).map(of).collect();
    assert_eq!(rest, [(Some(0), true), (Some(1), false), (Some(0), true)]);
    render(
        &scene,
        &RenderSettings::new(16, 16),
        &texmap_render::no_progress,
    )
    .unwrap();
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
    assert!(
        matches!(material(0).normal_detail, Some(NormalDetail::Bump { height, .. }) if height == 0.1)
    );
    assert_eq!(material(0).light_map.as_ref().unwrap().scale, 2.0);
    assert!(matches!(
        material(1).normal_detail,
        Some(NormalDetail::NormalMap {
            green: NormalMapGreen::Down,
            rebuild_z: true,
            ..
        })
    ));
    assert!(matches!(
        material(2).normal_detail,
        Some(NormalDetail::NormalMap { .. })
    ));
    assert!(
        matches!(material(3).normal_detail, Some(NormalDetail::Bump { height, .. }) if height == 0.3)
    );
    render(
        &scene,
        &RenderSettings::new(16, 16),
        &texmap_render::no_progress,
    )
    .unwrap();
}

/// A second set from a model of other faces, or without coordinates, is refused by name. Without one a light map is left out, with a warning.
#[test]
fn second_coordinates_must_fit() {
    let faces = |corners: &str| {
        format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n{corners}\n")
    };
    let files = || {
        files()
            .with("m.obj", faces("f 1/1 2/2 3/3 4/4"))
            .with("half.obj", faces("f 1/1 2/2 3/3"))
            .with("bare.obj", faces("f 1 2 3 4"))
    };
    for (second, words) in [("half.obj", "same faces"), ("bare.obj", "no `vt`")] {
        let scene = format!("lightmap square.png\nlightmapuv {second}\nobj m.obj\n");
        let error = files().with("a.scene", scene).load("a.scene").unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }
    let scene = files().scene("lightmap square.png\nobj m.obj\n");
    assert!(
        scene.materials[scene.meshes[0].material]
            .light_map
            .is_none()
    );
    let told = |w: &String| w.contains("`lightmap` is not drawn here");
    assert!(scene.warnings.iter().any(told), "{:?}", scene.warnings);
    scene.check().expect("a scene");
}

#[test]
fn lights_are_named_below_their_lines() {
    let scene = files().scene(&format!(
        "la 1 1 1\nlp 1 1 1 0 3 3\nname lamp\nshadow 64\nld 1 1 1 0 -1 0\nls 1 1 1 0 2 3 0 -1 -1 10 30\nname spot_2\n{FACE}"
    ));
    assert_eq!(scene.effects.light_names, ["", "lamp", "", "spot_2"]);
    assert_eq!(Aov::shadow_of(&scene, "lamp"), Ok(Aov::Shadow(1)));
}

#[test]
fn bumps_of_offsets_formulas_and_words() {
    let scene = files().scene(
        "texture a.png\nshade modulate\nv 0 0 0\nv 1 0 0\nv 0 1 0\n\
         offsetmap square.png 0.5 down\ntf 0 0 0 1 1 0 2 0 1\nscale 2\ncarve waves 0.1 1 2 3 1 0.5 1 around 7 fold 0.25\n\
         tf 0 0 0 1 1 0 2 0 1\nemboss \"CS 184\" -0.02\ntf 0 0 0 1 1 0 2 0 1\ncarve none\ntf 0 0 0 1 1 0 2 0 1\n",
    );
    let detail = |i: usize| &scene.materials[scene.meshes[i].material].normal_detail;
    assert!(matches!(
        detail(0),
        Some(NormalDetail::Offsets {
            slope: 0.5,
            green: NormalMapGreen::Down,
            ..
        })
    ));
    let Some(NormalDetail::Procedural {
        heights,
        world_from_solid,
        height,
    }) = detail(1)
    else {
        panic!("{:?}", detail(1))
    };
    assert_eq!(
        (*height, *heights),
        (
            0.1,
            ProceduralHeight::Waves {
                around: 7,
                fold: 0.25
            }
        )
    );
    let place = |p: DVec3| world_from_solid.transform_point3(p);
    assert_eq!(place(DVec3::ZERO), DVec3::new(2.0, 4.0, 6.0));
    assert_eq!(place(DVec3::Y), DVec3::new(2.0, 5.0, 6.0));
    let Some(NormalDetail::Bump {
        slot,
        height: -0.02,
    }) = detail(2)
    else {
        panic!("{:?}", detail(2))
    };
    // Six characters and a margin of half of one, 24 x 40 texels each.
    let words = &scene.textures[slot.texture];
    assert_eq!((words.width(), words.height()), (168, 80));
    let ink = (0..168 * 80).filter(|i| words.texel(0, i % 168, i / 168).unwrap()[0] > 0.5);
    assert!((400..2000).contains(&ink.count()));
    assert!(detail(3).is_none());
    render(
        &scene,
        &RenderSettings::new(16, 16),
        &texmap_render::no_progress,
    )
    .unwrap();
}

/// Every map of a library and the colours of vertices reach the picture: without its line it is another one.
#[test]
fn every_map_of_a_library_is_drawn() {
    const MAPS: [&str; 8] = [
        "map_Ka ka.png",
        "map_Kd kd.png",
        "map_Ks ks.png",
        "map_Ns ns.png",
        "map_d d.png",
        "map_Bump -bm 0.4 b.png",
        "disp -bm 0.2 b.png",
        "norm n.png",
    ];
    const COLORS: [&str; 4] = [" 1 0.2 0.2", " 0.2 1 0.2", " 0.2 0.2 1", " 1 1 0.2"];
    let picture = |maps: &[&str], colors: bool| {
        let color = |i: usize| if colors { COLORS[i] } else { "" };
        let obj = format!(
            "mtllib m.mtl\nv -1 -1 0{}\nv 1 -1 0{}\nv 1 1 0{}\nv -1 1 0{}\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
             usemtl m\nf 1/1 2/2 3/3 4/4\n",
            color(0),
            color(1),
            color(2),
            color(3)
        );
        let scene = Files::new()
            .with_png("ka.png", 6, 6, [0, 250, 60, 255])
            .with_png("kd.png", 5, 5, [250, 200, 180, 255])
            .with_png("ks.png", 4, 4, [40, 60, 250, 255])
            .with_png("ns.png", 4, 4, [90, 90, 90, 255])
            .with_png("d.png", 8, 8, [255, 255, 255, 255])
            .with_png("b.png", 8, 8, [200, 200, 200, 255])
            .with_png("n.png", 8, 8, [190, 100, 220, 255])
            .with("m.mtl", format!("newmtl m\nKd 0.8 0.8 0.8\nKs 0.9 0.9 0.9\nNs 30\nillum 2\n{}\n", maps.join("\n")))
            .with("m.obj", obj)
            .scene("eye 0 0 4\nlook 0 0 0\nfov 40\nbackground 0 0 0.4\nla 0.3 0.3 0.3\nlp 0.6 0.6 0.6 0.5 0.6 1.5\ndisplace none\nobj m.obj\n");
        let shaped = texmap_mesh::tessellate(&scene, 64).unwrap();
        render(
            &shaped,
            &RenderSettings::new(64, 64),
            &texmap_render::no_progress,
        )
        .unwrap()
        .rgba
    };
    // `norm` wins over `map_Bump`: each has its own picture of all the others.
    for other in ["norm", "map_Bump"] {
        let maps: Vec<_> = MAPS.into_iter().filter(|m| !m.starts_with(other)).collect();
        let all = picture(&maps, true);
        for left_out in 0..maps.len() {
            let mut fewer = maps.clone();
            fewer.remove(left_out);
            assert!(
                picture(&fewer, true) != all,
                "{} is not seen",
                maps[left_out]
            );
        }
        assert!(picture(&maps, false) != all, "vertex colours are not seen");
    }
}

#[test]
fn faults_name_their_line() {
    for (text, code, line) in [
        ("la 1 1 1\nshadow\n", "needs-line-above", 2),
        ("name sun\n", "needs-line-above", 1),
        ("la 1 1 1\nname a\nlp 1 1 1 0 0 9\nname a\n", "bad-shape", 4),
        ("offsetmap gone.png 1\n", "file-missing", 1),
        ("lightmap gone.png\n", "file-missing", 1),
        (
            "projector square.png light 0 0 5 0 0 0 0 1 0 0\n",
            "out-of-range",
            1,
        ),
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
            (error.code(), error.location().unwrap().line),
            (code, line),
            "{error}"
        );
        assert!(!error.help().is_empty());
    }
}

/// The sentences that a scene is loaded with.
fn warnings(text: &str) -> Vec<String> {
    files().scene(text).warnings
}

#[test]
fn bumps_that_are_still_set_do_not_reach_faces_without_coordinates() {
    let textured = "texture square.png\nshade modulate\n";
    let tf = "tf 0 0 0 1 1 0 2 1 1\n";
    for (line, words) in [
        ("bump square.png 0.1", "`bump`"),
        ("normalmap square.png", "`normalmap`"),
        ("offsetmap square.png 0.1", "`offsetmap`"),
        ("emboss ab 0.1", "`emboss`"),
        ("emission 1 1 1 square.png", "`emission`"),
        ("lightmap square.png", "`lightmap`"),
    ] {
        let scene = files().scene(&format!("{line}\n{FACE}f 0 2 1\n{textured}{tf}"));
        let face = &scene.materials[scene.meshes[0].material];
        assert!(
            face.normal_detail.is_none() && face.light_map.is_none() && face.emission.is_none()
        );
        // Once for all faces, with the first of them.
        let told = |warning: &&String| warning.contains(words);
        let told: Vec<_> = scene.warnings.iter().filter(told).collect();
        assert_eq!(told.len(), 1, "{line}: {:?}", scene.warnings);
        assert!(told[0].contains("a.scene:5:1"), "{}", told[0]);
        let last = &scene.materials[scene.meshes.last().unwrap().material];
        let reaches = last.normal_detail.is_some() || last.emission.is_some();
        assert_eq!(reaches, line != "lightmap square.png", "{line}");
        render(
            &scene,
            &RenderSettings::new(16, 16),
            &texmap_render::no_progress,
        )
        .expect("a picture");
    }
    // Procedural heights need no coordinates and reach all faces.
    let carved = files().scene(&format!("carve noise 0.1 0 0 0 1 1 1\n{FACE}"));
    assert!(carved.materials[0].normal_detail.is_some() && carved.warnings.is_empty());
}

#[test]
fn effects_on_faces_that_copy_their_texel_are_told_once_a_kind() {
    let set = "ld 1 1 1 0 0 -1\nbump square.png 0.1\nenv square.png octahedron 0.5\nhighlight blinn\ncel square.png\n\
               emission 0.1 0.1 0.1\ntexture square.png\n";
    let faces = "tf 0 0 0 1 1 0 2 1 1\ntf 0 0 0 2 1 0 1 1 1\n";
    let vertices = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\n";
    let told = warnings(&format!("{set}{vertices}{faces}"));
    for kind in ["`bump`", "`env`", "`highlight`", "`cel`", "`emission`"] {
        let of_kind = told.iter().filter(|w| w.contains(kind)).count();
        assert_eq!(of_kind, 1, "{kind}: {told:?}");
    }
    assert!(told.iter().all(|w| w.contains("a.scene:11:1")), "{told:?}");
    // Lit faces show them.
    let lit = warnings(&format!("{set}shade modulate\n{vertices}{faces}"));
    assert!(lit.is_empty(), "{lit:?}");
}

#[test]
fn shadows_and_projectors_that_nothing_shows_are_told() {
    let lines = "ld 1 1 1 0 0 -1\nshadow 64\nprojector a.png paint 0 0 5 0 0 0 0 1 0 40\ntexture square.png\n\
                 v -1 -1 0\nv 1 -1 0\nv 1 1 0\n";
    let face = "tf 0 0 0 1 1 0 2 1 1\n";
    let told = warnings(&format!("{lines}shade vertex\n{face}"));
    assert!(told.iter().any(|w| w.contains("`shadow`")), "{told:?}");
    assert!(told.iter().any(|w| w.contains("`projector`")), "{told:?}");
    // A texel that covers is under projectors, not under shadows.
    let told = warnings(&format!("{lines}{face}"));
    assert!(told.len() == 1 && told[0].contains("`shadow`"), "{told:?}");
    assert!(warnings(&format!("{lines}shade modulate\n{face}")).is_empty());
}

/// Bumps and highlights show on a texel that a projector lights, wherever its line stands.
#[test]
fn the_light_of_a_projector_shows_bumps_on_faces_that_copy_their_texel() {
    let face = "bump square.png 0.1\nhighlight blinn\ncel square.png\ntexture square.png\n\
                v -1 -1 0\nv 1 -1 0\nv 1 1 0\ntf 0 0 0 1 1 0 2 1 1\n";
    let projector = |mode| format!("projector a.png {mode} 0 0 5 0 0 0 0 1 0 40\n");
    let told = |text: String| {
        let told = warnings(&text);
        ["`bump`", "`highlight`", "`cel`"].map(|word| told.iter().any(|w| w.contains(word)))
    };
    assert_eq!(
        told(format!("{face}{}", projector("light"))),
        [false, false, true]
    );
    assert_eq!(
        told(format!("{}{face}", projector("light"))),
        [false, false, true]
    );
    // Negative twins: paint is not bent, and what is lit at vertices is under no projector.
    assert_eq!(told(format!("{face}{}", projector("paint"))), [true; 3]);
    let vertex = format!("shade decal vertex\n{face}{}", projector("light"));
    assert_eq!(told(vertex), [true; 3]);
}

/// The code of the middle pixel of a textured face in raw colours, `t + t N.L c` under light, the paint under paint.
#[test]
fn projectors_light_and_paint_faces_that_copy_their_texel() {
    let middle = |lines: &str| {
        let files = files().with_png("white.png", 4, 4, [255; 4]).with_png(
            "green.png",
            4,
            4,
            [0, 255, 0, 255],
        );
        let scene = files.scene(&format!(
            "color raw\nfilter nearest\neye 0 0 5\nfov 20\ntexture square.png\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
             {lines}\ntf 0 .5 .75 1 .5 .75 2 .5 .75 3 .5 .75\n"
        ));
        let frame = render(
            &scene,
            &RenderSettings::new(16, 16),
            &texmap_render::no_progress,
        )
        .unwrap();
        let at = 4 * (8 * 16 + 8);
        [frame.rgba[at], frame.rgba[at + 1], frame.rgba[at + 2]]
    };
    // Rays of the projector are along the normal but for 1e-6; red is cut.
    let light = "projector white.png light 0 0 100 0 0 0 0 1 0 4 color .5 .5 .5";
    let paint = "projector green.png paint 0 0 100 0 0 0 0 1 0 4";
    let plain = [200, 100, 50];
    assert_eq!(middle(""), plain);
    assert_eq!(middle(light), [255, 150, 75]);
    assert_eq!(
        middle(&format!("surf 1 0 0 1 .6 0 1\n{light}")),
        [255, 130, 65]
    );
    assert_eq!(middle(paint), [0, 255, 0]);
    // A card between them, which the eye does not see.
    let card = "v -1.5 -1.5 50\nv 1.5 -1.5 50\nv 1.5 1.5 50\nv -1.5 1.5 50\nf 4 5 6 7\n";
    assert_eq!(middle(&format!("{light} shadow 256\n{card}")), plain);
    assert_eq!(middle(&format!("{paint} shadow 256\n{card}")), plain);
    assert_eq!(middle(&format!("{light}\n{card}")), [255, 150, 75]);
    // Negative twins: from behind, and where light stands at vertices alone.
    for line in [light, paint] {
        assert_eq!(middle(&line.replacen("100", "-100", 1)), plain);
        assert_eq!(middle(&format!("shade decal vertex\n{line}")), plain);
    }
}
