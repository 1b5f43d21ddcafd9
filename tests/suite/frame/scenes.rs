//! Small scenes and ways to read their frames.

use texmap_light::PhongMaterial;
use texmap_render::{Aov, AovData, Frame, RenderSettings, render};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};
use texmap_scene::{Emission, Material, Mesh, Scene, Shading, TextureSlot};

pub(crate) use texmap_targets::scenes::{empty, quad};

/// A scene of one mesh and its material.
pub(crate) fn of(material: Material, mesh: Mesh) -> Scene {
    Scene {
        materials: vec![material],
        meshes: vec![mesh],
        ..empty()
    }
}

pub(crate) fn unlit(color: [f32; 3]) -> Material {
    Material {
        phong: PhongMaterial {
            color,
            ..PhongMaterial::default()
        },
        shading: Shading::Unlit,
        ..Material::default()
    }
}

/// A surface of this base colour, whole under ambient light, that gives off light of its own.
pub(crate) fn glowing(color: [f32; 3], shading: Shading, emission: Emission) -> Material {
    Material {
        phong: PhongMaterial {
            color,
            ka: 1.0,
            ..PhongMaterial::default()
        },
        shading,
        emission: Some(emission),
        ..Material::default()
    }
}

/// A square of half-side `half` at distance `z` that faces the camera.
pub(crate) fn wall(half: f32, z: f32) -> Mesh {
    quad([
        [-half, -half, -z],
        [half, -half, -z],
        [half, half, -z],
        [-half, half, -z],
    ])
}

pub(crate) fn slot(texture: usize, filter: Filter) -> Option<TextureSlot> {
    Some(TextureSlot {
        sampler: Sampler {
            filter,
            ..Sampler::default()
        },
        ..TextureSlot::new(texture)
    })
}

pub(crate) fn texture(
    width: u32,
    height: u32,
    texel: impl Fn(u32, u32) -> [u8; 4],
) -> Texture2d<'static> {
    let texels = (0..width * height)
        .flat_map(|i| texel(i % width, i / width))
        .collect();
    Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft).unwrap()
}

pub(crate) fn draw(scene: &Scene, width: u32, height: u32) -> Frame {
    render(
        scene,
        &RenderSettings::new(width, height),
        &texmap_render::no_progress,
    )
    .unwrap()
}

pub(crate) fn draw_aovs(scene: &Scene, width: u32, height: u32, aovs: &[Aov]) -> Frame {
    let settings = RenderSettings {
        aovs: aovs.to_vec(),
        ..RenderSettings::new(width, height)
    };
    render(scene, &settings, &texmap_render::no_progress).unwrap()
}

pub(crate) fn pixel(frame: &Frame, x: u32, y: u32) -> [u8; 4] {
    let at = (y * frame.width + x) as usize * 4;
    frame.rgba[at..at + 4].try_into().unwrap()
}

/// Values of an f32 AOV at a pixel.
pub(crate) fn values(frame: &Frame, aov: Aov, x: u32, y: u32) -> Vec<f32> {
    let (_, channels, data) = frame.aovs.iter().find(|(a, ..)| *a == aov).unwrap();
    let AovData::F32(data) = data else {
        panic!("{aov} is not f32")
    };
    let at = (y * frame.width + x) as usize * channels;
    data[at..at + channels].to_vec()
}

pub(crate) fn faces(frame: &Frame) -> &[u32] {
    frame
        .aovs
        .iter()
        .find_map(|(_, _, data)| {
            if let AovData::U32(faces) = data {
                Some(faces.as_slice())
            } else {
                None
            }
        })
        .unwrap()
}

/// AOVs as bits, to be compared.
pub(crate) fn bits(frame: &Frame) -> Vec<Vec<u32>> {
    let of = |data: &AovData| match data {
        AovData::F32(values) => values.iter().map(|v| v.to_bits()).collect(),
        AovData::U32(values) => values.clone(),
    };
    frame.aovs.iter().map(|(_, _, data)| of(data)).collect()
}
