//! The look of surfaces, instead of that of the input.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use texmap_io::image_io;
use texmap_io::scene_file::Missing;
use texmap_light::PhongMaterial;
use texmap_math::color::srgb_to_linear;
use texmap_sample::{ColorSpace, Filter, Origin, Texture2d};
use texmap_scene::{
    AlphaMode, ColorMode, Material, Mesh, MetallicRoughness, Scene, Shading, TextureSlot,
    VertexColorInterp,
};
use texmap_uv::Projection;

use crate::failure::Failure;
use crate::levels::ask_for_levels;

/// Textures and materials of one's own.
#[derive(Args, Debug)]
#[command(next_help_heading = "Look")]
pub(crate) struct LookArgs {
    /// A picture for every surface that has none: an OBJ without an MTL
    #[arg(long, value_name = "FILE", conflicts_with = "material")]
    pub(crate) texture: Option<PathBuf>,
    /// One look for all surfaces: their colours without light, grey clay, a checker of their coordinates, their normals as colours, or
    /// their coordinates as red and green
    #[arg(long, value_name = "LOOK")]
    material: Option<Look>,
    /// Draw the edges of the faces over the picture
    #[arg(long)]
    pub(crate) wireframe: bool,
    /// A map or material library that is not there: error, or a magenta and black checker or grey with a warning, whatever the scene
    /// says [default: the scene's word, error without one; checker for models]
    #[arg(long, value_name = "WHAT")]
    pub(crate) missing: Option<Missing>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Look {
    Unlit,
    Clay,
    Checker,
    Normals,
    Uv,
}

impl LookArgs {
    /// Gives a scene its look, with a warning for options that change nothing.
    pub(crate) fn dress(&self, scene: &mut Scene) -> Result<(), Failure> {
        if let Some(path) = &self.texture {
            let space = match scene.color {
                ColorMode::Srgb => ColorSpace::Srgb,
                ColorMode::Raw => ColorSpace::Linear,
            };
            let (texture, _) = image_io::read_texture(path, space)?;
            ask_for_levels(&texture, path)?;
            cover(scene, texture.with_mips());
        }
        match self.material {
            None => {}
            Some(Look::Unlit) => {
                for material in &mut scene.materials {
                    material.shading = Shading::Unlit;
                }
            }
            Some(Look::Clay) => one_material(scene, clay([0.6; 3])),
            Some(Look::Checker) => {
                let lit = clay([1.0; 3]);
                with_texture(scene, lit, checker(), Filter::Anisotropic(16));
            }
            Some(Look::Normals) => normals(scene),
            Some(Look::Uv) => {
                let unlit = Material {
                    shading: Shading::Unlit,
                    ..clay([1.0; 3])
                };
                with_texture(scene, unlit, gradient(), Filter::Bilinear);
            }
        }
        Ok(())
    }
}

/// A matte surface of one colour.
fn clay(color: [f32; 3]) -> Material {
    Material {
        phong: PhongMaterial {
            color,
            ka: 1.0,
            kd: 1.0,
            ks: 0.0,
            ns: 5.0,
        },
        ..Material::default()
    }
}

/// Gives every mesh one material and no colours of its own.
fn one_material(scene: &mut Scene, mut material: Material) {
    // Of the model of the surfaces that it replaces: light from all around shows on metallic-roughness surfaces alone.
    let of_before = &scene.materials;
    if of_before.iter().any(|m| m.metallic_roughness.is_some()) {
        material.metallic_roughness = Some(MetallicRoughness::default());
    }
    scene.materials = vec![material];
    for mesh in &mut scene.meshes {
        mesh.material = 0;
        mesh.colors.clear();
    }
}

/// Puts a texture on every material without one.
fn cover(scene: &mut Scene, texture: Texture2d<'static>) {
    let alpha = texture.has_alpha();
    scene.textures.push(texture);
    let slot = TextureSlot::new(scene.textures.len() - 1);
    let bare: Vec<bool> = scene
        .materials
        .iter()
        .map(|m| m.base_color.is_none() && m.solid.is_none())
        .collect();
    for (material, _) in scene.materials.iter_mut().zip(&bare).filter(|(_, b)| **b) {
        material.base_color = Some(slot.clone());
        material.phong.color = [1.0; 3];
        if alpha && material.alpha == AlphaMode::Opaque {
            material.alpha = AlphaMode::Test(0.0);
        }
    }
    if !bare.contains(&true) {
        let warning = "--texture: every surface has a picture of its own; it is not drawn";
        scene.warnings.push(warning.to_owned());
    }
    let Scene {
        meshes, warnings, ..
    } = scene;
    for mesh in meshes.iter_mut().filter(|m| bare[m.material]) {
        coordinates(mesh, warnings);
    }
}

/// Gives every mesh one material with this texture.
fn with_texture(
    scene: &mut Scene,
    material: Material,
    texture: Texture2d<'static>,
    filter: Filter,
) {
    scene.textures.push(texture.with_mips());
    let mut slot = TextureSlot::new(scene.textures.len() - 1);
    slot.sampler.filter = filter;
    let material = Material {
        base_color: Some(slot),
        ..material
    };
    one_material(scene, material);
    let Scene {
        meshes, warnings, ..
    } = scene;
    meshes
        .iter_mut()
        .for_each(|mesh| coordinates(mesh, warnings));
}

/// Projects coordinates onto a mesh that has none.
fn coordinates(mesh: &mut Mesh, warnings: &mut Vec<String>) {
    let has = mesh.texture_frame.is_some() || mesh.uv_projection.is_some();
    if mesh.uvs.is_empty() && !has {
        mesh.project_uvs(Projection::Box);
        warnings.push(format!(
            "mesh '{}' has no texture coordinates; box projection stands in",
            mesh.name
        ));
    }
}

/// Unit normals as colours: (n + 1) / 2, as they are stored.
fn normals(scene: &mut Scene) {
    let color = scene.color;
    one_material(
        scene,
        Material {
            shading: Shading::Unlit,
            vertex_color_interp: VertexColorInterp::Perspective,
            ..clay([1.0; 3])
        },
    );
    for mesh in &mut scene.meshes {
        let code = |n: f64| {
            let code = ((n + 1.0) * 0.5) as f32;
            match color {
                ColorMode::Srgb => srgb_to_linear(code),
                ColorMode::Raw => code,
            }
        };
        let normals = mesh.world_normals();
        mesh.colors = normals.iter().map(|n| n.to_array().map(code)).collect();
    }
}

/// Squares of a sixteenth, light and dark, tinted from corner to corner so that turned and mirrored parts are told apart.
fn checker() -> Texture2d<'static> {
    const SIDE: u32 = 512;
    const SQUARE: u32 = SIDE / 16;
    let texel = |i: u32| {
        let (x, y) = (i % SIDE, i / SIDE);
        let light = (x / SQUARE + y / SQUARE).is_multiple_of(2);
        let base = if light { 190 } else { 70 };
        let tint = |at: u32| (at / SQUARE * 60 / 15) as u8;
        [base + tint(x), base + 25, base + tint(SIDE - 1 - y), 255]
    };
    made(SIDE, texel, ColorSpace::Srgb)
}

/// u as red and v as green, as they are stored.
fn gradient() -> Texture2d<'static> {
    made(
        256,
        |i| [(i % 256) as u8, (i / 256) as u8, 0, 255],
        ColorSpace::Srgb,
    )
}

fn made(side: u32, texel: impl Fn(u32) -> [u8; 4], space: ColorSpace) -> Texture2d<'static> {
    let texels = (0..side * side).flat_map(texel).collect();
    Texture2d::from_rgba8(side, side, texels, space, Origin::TopLeft)
        .expect("a square of whole texels is a texture")
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;

    fn scene() -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        scene.materials = vec![Material::default()];
        scene.meshes = vec![Mesh {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }];
        scene
    }

    fn args(material: Option<Look>) -> LookArgs {
        LookArgs {
            texture: None,
            material,
            wireframe: false,
            missing: None,
        }
    }

    #[test]
    fn every_look_passes_the_check_and_coordinates_are_made_where_they_are_read() {
        for (look, made) in [
            (None, false),
            (Some(Look::Unlit), false),
            (Some(Look::Clay), false),
            (Some(Look::Checker), true),
            (Some(Look::Normals), false),
            (Some(Look::Uv), true),
        ] {
            let mut scene = scene();
            args(look).dress(&mut scene).unwrap();
            scene.check().unwrap();
            assert_eq!(!scene.meshes[0].uvs.is_empty(), made, "{look:?}");
            assert_eq!(scene.warnings.len(), usize::from(made), "{look:?}");
        }
    }

    #[test]
    fn a_normal_toward_the_front_is_the_usual_light_blue() {
        let mut scene = scene();
        args(Some(Look::Normals)).dress(&mut scene).unwrap();
        let stored = scene.meshes[0].colors[0].map(texmap_math::color::linear_to_srgb8);
        assert_eq!(stored, [128, 128, 255]);
    }
}
