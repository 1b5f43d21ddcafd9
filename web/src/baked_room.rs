//! A room of the user under light maps: the lights of its file are baked, and a spot light goes round in it.

use std::f64::consts::TAU;

use texmap_bake::{BakeOptions, Baker, MovingLight};
use texmap_light::{Light, PhongMaterial, ShadowBias, ShadowMap};
use texmap_math::deterministic_f64::sin_cos;
use texmap_math::glam::DVec3;
use texmap_render::{RenderError, RenderSettings, shadow_map_for};
use texmap_sample::{Alpha, ColorSpace, Image, Origin, Sampler, TexelData, Texture2d, Wrap};
use texmap_scene::{
    LightMapSlot, Mesh, Scene, SceneError, Shading, TextureRole, TextureSlot, shadow_bias,
    shadow_kind,
};
use texmap_uv::{AtlasSize, Faces, auto_planes};

use crate::answer::Answer;
use crate::draw;

/// Most meshes and triangles: more would take minutes here.
const MESHES: usize = 64;
const TRIANGLES: usize = 20_000;
/// Texels a side of a shadow map, comparisons a side of its filter, texels of dilation: those of `texmap bake`.
const SHADOW_SIZE: u32 = 1024;
const PCF_SIZE: u32 = 3;
const GUTTER: u32 = 2;

/// The room under maps of its resting lights plus that of the spot at a part of its round, and the largest difference to a fresh bake of
/// all lights unless it shall be `quick`. Meshes get coordinates for their maps from six planes, and decals become modulated surfaces, as light must show on them.
pub(crate) fn answer(scene: &Scene, size: u32, part: f64, quick: bool) -> Result<Answer, String> {
    let told = |e: RenderError| e.to_string();
    let shaped = texmap_mesh::tessellate(scene, size).map_err(|e| e.to_string())?;
    let mut scene = shaped.into_owned();
    let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    if scene.meshes.len() > MESHES || triangles > TRIANGLES || triangles == 0 {
        return Err(format!(
            "the room has {} meshes and {triangles} triangles\ndrop one of 1 to {TRIANGLES} triangles in at most {MESHES} meshes",
            scene.meshes.len()
        ));
    }
    if scene.lights.is_empty() {
        scene.lights.push(Light::Ambient { color: [0.25; 3] });
    }
    let texels = match scene.meshes.len() {
        0..=4 => 256,
        5..=16 => 128,
        _ => 64,
    };
    charts(&mut scene, texels)?;
    let spot = scene.lights.len();
    scene.lights.push(spot_light(&scene, part));
    let resting: Vec<usize> = (0..spot).collect();
    let mut moved = with_maps(&scene, texels, &resting).map_err(told)?;
    let moving = MovingLight::new(&moved, spot, SHADOW_SIZE, PCF_SIZE, GUTTER).map_err(told)?;
    moving.place(&mut moved, scene.lights[spot]).map_err(told)?;
    let settings = RenderSettings::new(size, size);
    let shown = draw::frame(&moved, &settings)?;
    let worst = if quick {
        None
    } else {
        let all: Vec<usize> = (0..=spot).collect();
        let fresh = with_maps(&scene, texels, &all).map_err(told)?;
        let fresh = draw::frame(&fresh, &settings)?;
        let differences = shown.rgba.iter().zip(&fresh.rgba);
        differences.map(|(a, b)| a.abs_diff(*b)).max()
    };
    let mut answer = Answer::default();
    answer.frame("resting maps plus the maps of the spot", shown);
    if let Some(worst) = worst {
        answer.expected(
            "largest difference to a fresh bake of all lights",
            f64::from(worst),
            0.0,
            "of 255",
        );
    }
    answer.figure("triangles", triangles as f64, "");
    Ok(answer)
}

/// A spot under the ceiling that shines at a point on a circle around the middle of the floor.
fn spot_light(scene: &Scene, part: f64) -> Light {
    let points = scene.meshes.iter().flat_map(|mesh| {
        let at = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let world = move |p| mesh.world_from_object.transform_point3(at(p));
        mesh.positions.iter().map(world)
    });
    let bounds = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), bounds);
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let up = scene.camera.up.normalize_or(DVec3::Y);
    let ahead = scene.camera.look - scene.camera.eye;
    let right = ahead.cross(up).normalize_or(up.any_orthonormal_vector());
    let away = up.cross(right);
    let reach = |way: DVec3| half.dot(way.abs());
    let (sin, cos) = sin_cos(part * TAU);
    let from = middle + up * (0.85 * reach(up));
    // Not at a grazing angle, however wide the room is.
    let around = |way: DVec3| way * (0.6 * reach(way)).min(1.5 * reach(up));
    let aim = middle - up * reach(up) + around(right) * cos + around(away) * sin;
    let narrow = |v: DVec3| v.as_vec3().to_array();
    Light::spot(
        [0.8, 0.75, 0.6],
        narrow(from),
        narrow(aim - from),
        0.3,
        0.45,
    )
}

/// Gives every mesh a material of its own and coordinates without overlaps; those of the file stay.
fn charts(scene: &mut Scene, texels: u32) -> Result<(), String> {
    let mut materials = Vec::new();
    for mesh in &mut scene.meshes {
        if mesh.lightmap_uvs.is_empty() {
            *mesh = charted(mesh, texels)?;
        }
        let mut material = scene
            .materials
            .get(mesh.material)
            .cloned()
            .unwrap_or_default();
        let decal = material.texture_role == TextureRole::Decal && material.base_color.is_some();
        if decal || material.shading == Shading::Unlit {
            // The texel, or the colour, is the surface as before.
            material.phong = PhongMaterial {
                color: if decal {
                    [1.0; 3]
                } else {
                    material.phong.color
                },
                ka: 1.0,
                kd: 1.0,
                ks: 0.0,
                ..material.phong
            };
        }
        material.texture_role = TextureRole::Modulate;
        material.shading = Shading::PerPixel;
        mesh.material = materials.len();
        materials.push(material);
    }
    scene.materials = materials;
    Ok(())
}

/// The mesh with three vertices a triangle and a second set of coordinates.
fn charted(mesh: &Mesh, texels: u32) -> Result<Mesh, String> {
    let faces = Faces::from_triangles(&mesh.triangles);
    let shape = texmap_uv::Mesh::new(&mesh.positions, &faces).map_err(|e| e.to_string())?;
    let atlas = AtlasSize {
        size: texels,
        gutter: 2 * GUTTER,
    };
    let set = auto_planes(&shape, atlas, texmap_uv::Origin::TopLeft).map_err(|e| e.to_string())?;
    let corners = faces.corners();
    fn of<T: Copy>(values: &[T], corners: &[u32]) -> Vec<T> {
        let at = |corner: &u32| values.get(*corner as usize).copied();
        corners.iter().filter_map(at).collect()
    }
    let normals: Vec<[f32; 3]> = mesh
        .object_normals()
        .iter()
        .map(|n| n.as_vec3().to_array())
        .collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    Ok(Mesh {
        positions: of(&mesh.positions, corners),
        normals: of(&normals, corners),
        uvs: of(&mesh.uvs, corners),
        colors: of(&mesh.colors, corners),
        lightmap_uvs: set.per_corner(),
        triangles: triangles.collect(),
        ..mesh.clone()
    })
}

/// The scene with a map of some lights on each of its meshes, in place of all its lights.
fn with_maps(scene: &Scene, texels: u32, lights: &[usize]) -> Result<Scene, RenderError> {
    let mut shadows: Vec<(usize, ShadowMap, ShadowBias, u32)> = Vec::new();
    for light in lights.iter().copied() {
        if !matches!(scene.lights[light], Light::Ambient { .. }) {
            let kind = shadow_kind(scene, light, None)?;
            let bias = shadow_bias(scene);
            let map = shadow_map_for(scene, &kind, SHADOW_SIZE, bias, PCF_SIZE, usize::MAX)?;
            shadows.push((light, map, bias, PCF_SIZE));
        }
    }
    let options = BakeOptions {
        size: texels,
        gutter: GUTTER,
        shadows: &shadows,
        lights: Some(lights),
    };
    let baker = Baker::new(scene)?;
    let mut baked = scene.clone();
    for (index, mesh) in scene.meshes.iter().enumerate() {
        let map = baker.bake(index, &options)?;
        let texture = Texture2d::new(&Image {
            width: texels,
            height: texels,
            channels: 3,
            texels: TexelData::F32(map.texels.as_flattened()),
            color: ColorSpace::Linear,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        });
        let texture = texture.map_err(|error| SceneError::Value {
            place: format!("light map of mesh '{}'", mesh.name),
            what: "texel".to_owned(),
            value: error.to_string(),
            expected: "a light of finite brightness",
        })?;
        let slot = TextureSlot {
            sampler: Sampler {
                wrap_u: Wrap::ClampToEdge,
                wrap_v: Wrap::ClampToEdge,
                ..Sampler::default()
            },
            ..TextureSlot::new(baked.textures.len())
        };
        baked.textures.push(texture.with_mips());
        baked.materials[mesh.material].light_map = Some(LightMapSlot {
            slot,
            scale: 1.0,
            baked: None,
        });
    }
    Ok(baked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Files;

    /// A floor and a wall of one colour under a dim light.
    const ROOM: &str = "eye 0 3 7\nlook 0 1 0\nfov 60\nla 0.2 0.2 0.2\nsurf 0.8 0.8 0.8 1 1 0 1\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nv -4 0 -4\nv -4 4 -4\nv 4 4 -4\nf 0 1 2 3\nf 3 2 5 4\n";

    fn drawn(part: f64) -> Answer {
        let scene = Files::new().scene("room.scene", Some(ROOM), 1.0).unwrap();
        answer(&scene, 64, part, false).unwrap()
    }

    #[test]
    fn the_spot_moves_and_is_its_fresh_bake() {
        let (first, half) = (drawn(0.0), drawn(0.5));
        for answer in [&first, &half] {
            let worst = answer.figures.iter().find(|f| f.unit == "of 255").unwrap();
            assert!(worst.value <= 1.0, "{}", worst.value);
        }
        // Right of the middle at first, left of it half a round later.
        let light = |answer: &Answer, left: bool| -> u32 {
            let rgba = &answer.panels[0].rgba;
            let pixels = rgba.chunks(4).enumerate();
            let side = pixels.filter(|(i, _)| (i % 64 < 32) == left);
            side.map(|(_, p)| u32::from(p[0])).sum()
        };
        assert!(light(&first, false) > light(&first, true) * 11 / 10);
        assert!(light(&half, true) > light(&half, false) * 11 / 10);
    }

    #[test]
    fn a_room_of_too_many_meshes_is_refused() {
        let scene = Files::new().scene("room.scene", Some(ROOM), 1.0);
        let mut scene = scene.unwrap();
        scene.meshes = vec![scene.meshes[0].clone(); MESHES + 1];
        let refused = answer(&scene, 64, 0.0, true).unwrap_err();
        assert!(refused.contains("65 meshes"), "{refused}");
    }
}
