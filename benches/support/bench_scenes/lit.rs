//! The benchmark scenes under lighting effects.

use texmap_light::{
    Environment, EnvironmentLayout, EnvironmentLight, Light, NormalMapGreen, PhongMaterial,
    ProjectorBorder, ShadowBias, SpecularModel,
};
use texmap_math::Projector;
use texmap_math::color::srgb8_to_linear;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::Cull;
use texmap_sample::{ColorSpace, Filter, Origin, Precision, SampleError, Sampler, Texture2d};
use texmap_scene::{
    ColorMode, Material, Mesh, MetallicRoughness, NormalDetail, ProjectorLight, ProjectorMode,
    Reflection, Scene, Shadow, TextureSlot,
};

use super::scene::model;
use super::{
    BASE_SIZE, BenchMesh, BenchScene, CLEAR, Content, DEPTH_SIZE, FACE_SIZE, GlMatrix, HEIGHT,
    LIGHT, LIT_EYE, PROJECTOR, WIDTH, base, cube_face, floor, normal, slide, sphere,
};

/// The point that light and projector look at.
pub const MIDDLE: [f64; 3] = [0.0, 0.5, 0.0];
/// Half a side of the area that the shadow map shows around this point: 15 degrees to each side.
pub const LIGHT_AREA: f64 = 1.861_234_573_9;
/// Depth of 0 to 1 that the peers subtract before they compare.
pub const SHADOW_BIAS: f32 = 0.002;

/// Roughness of `pbr`: its lobes read three levels.
pub const ROUGHNESS: f32 = 0.4;
/// Metalness of `pbr`.
pub const METALLIC: f32 = 0.5;
/// Position of the point light of `pbr`.
pub const METALLIC_LIGHT: [f64; 3] = [3.0, 2.0, 3.0];
/// Direction to the directional light of `pbr`, of unit length.
pub const METALLIC_SUN: [f64; 3] = [-0.48, 0.6, 0.64];
/// Color of each light of `pbr`.
pub const METALLIC_LIGHTS: [f32; 3] = [0.5; 3];

/// The turn of the spheres.
#[must_use]
pub fn turn() -> GlMatrix {
    GlMatrix::rotate_x(30.0).then_after(&GlMatrix::rotate_y(40.0))
}

/// World to GL clip space of `lit` and `projective`.
#[must_use]
pub fn lit_matrix() -> GlMatrix {
    GlMatrix::perspective(60.0, f64::from(WIDTH) / f64::from(HEIGHT), 0.1, 100.0)
        .then_after(&GlMatrix::look_at(LIT_EYE, [0.0, 0.8, 0.0]))
}

/// World to GL clip space of the shadow map.
#[must_use]
pub fn light_matrix() -> GlMatrix {
    GlMatrix::perspective(30.0, 1.0, 2.0, 14.0).then_after(&GlMatrix::look_at(LIGHT, MIDDLE))
}

/// World to the homogeneous coordinates of the projected picture.
#[must_use]
pub fn slide_matrix() -> GlMatrix {
    GlMatrix::bias()
        .then_after(&GlMatrix::perspective(40.0, 1.0, 0.5, 50.0))
        .then_after(&GlMatrix::look_at(PROJECTOR, MIDDLE))
}

/// Sphere and floor, each with its object to world matrix, in the order in which they are drawn.
#[must_use]
pub fn lit_meshes() -> [(BenchMesh, GlMatrix); 2] {
    let mut up = GlMatrix::IDENTITY;
    up.0[13] = 1.0;
    [
        (sphere(448, 224), up.then_after(&turn())),
        (floor(20.0, 0.25), GlMatrix::IDENTITY),
    ]
}

/// A scene in texmap's terms.
pub(super) fn scene(scene: &BenchScene, precision: Precision) -> Result<Scene, SampleError> {
    let with = |space: ColorSpace| {
        move |side: u32, texels: Vec<u8>| {
            Texture2d::from_rgba8(side, side, texels, space, Origin::TopLeft)
        }
    };
    let (picture, data) = (with(scene.color_space()), with(ColorSpace::Linear));
    let slot = |texture: usize, filter: Filter| TextureSlot {
        sampler: Sampler {
            filter,
            precision,
            ..Sampler::default()
        },
        ..TextureSlot::new(texture)
    };
    let mut out = Scene {
        background: CLEAR,
        color: scene.color,
        ..Scene::new(scene.camera())
    };
    let surface = |ka: f32, kd: f32, ks: f32| PhongMaterial {
        color: [1.0; 3],
        ka,
        kd,
        ks,
        ns: 32.0,
    };
    let textured = Material {
        base_color: Some(slot(0, Filter::Trilinear)),
        cull: Cull::Back,
        ..Material::default()
    };
    let white = [1.0; 3];
    match scene.content {
        Content::Mirror => {
            out.effects.environments = environment(scene.color).into_iter().collect();
            out.materials.push(Material {
                phong: surface(0.0, 0.0, 0.0),
                reflection: Some(Reflection {
                    environment: 0,
                    reflectivity: 1.0,
                    within: None,
                }),
                cull: Cull::Back,
                ..Material::default()
            });
            out.meshes.push(mesh(sphere(448, 224), model()));
            return Ok(out);
        }
        Content::Metallic => {
            out.effects.environment_light = metallic_environment(scene.color);
            out.textures = vec![picture(BASE_SIZE, base())?];
            out.lights = vec![
                Light::Point {
                    color: METALLIC_LIGHTS,
                    position: METALLIC_LIGHT.map(|c| c as f32),
                },
                Light::Directional {
                    color: METALLIC_LIGHTS,
                    direction: METALLIC_SUN.map(|c| -c as f32),
                },
            ];
            out.materials.push(Material {
                phong: surface(0.0, 0.0, 0.0),
                metallic_roughness: Some(MetallicRoughness {
                    metallic: METALLIC,
                    roughness: ROUGHNESS,
                    ..MetallicRoughness::default()
                }),
                ..textured
            });
            out.meshes.push(mesh(sphere(448, 224), model()));
            return Ok(out);
        }
        Content::Projective => {
            out.textures = vec![picture(BASE_SIZE, base())?, picture(FACE_SIZE, slide())?];
            out.lights.push(Light::Ambient { color: [0.3; 3] });
            out.effects.projectors.extend(projector(precision));
            out.materials.push(Material {
                phong: surface(1.0, 1.0, 0.0),
                ..textured
            });
        }
        _ => {
            out.textures = vec![picture(BASE_SIZE, base())?, data(BASE_SIZE, normal())?];
            out.lights = vec![
                Light::Ambient { color: white },
                Light::Point {
                    color: white,
                    position: LIGHT.map(|c| c as f32),
                },
            ];
            // The bias of the peers where the sphere touches the floor: dz = d^2 / (n f / (f - n)) at a distance of 6.
            let bias = f64::from(SHADOW_BIAS) * 36.0 / (2.0 * 14.0 / 12.0);
            out.effects.shadows.push(Shadow {
                light: 1,
                size: Some(DEPTH_SIZE),
                bias: Some(ShadowBias::Constant(bias)),
                pcf_size: 3,
                area: Some((DVec3::from(MIDDLE), LIGHT_AREA)),
            });
            out.materials.push(Material {
                phong: surface(0.15, 0.85, 0.4),
                specular_model: SpecularModel::Blinn,
                horizon_clamp: false,
                normal_detail: Some(NormalDetail::NormalMap {
                    slot: slot(1, Filter::Trilinear),
                    green: NormalMapGreen::Up,
                    rebuild_z: false,
                    object_space: false,
                    strength: 1.0,
                }),
                ..textured
            });
        }
    }
    let [(ball, at), (ground, still)] = lit_meshes();
    let wide = |m: GlMatrix| DMat4::from_cols_array(&m.0.map(f64::from));
    out.meshes = vec![
        // The peers' shadow pass culls back faces too.
        Mesh {
            watertight: true,
            ..mesh(ball, wide(at))
        },
        Mesh {
            casts_no_shadow: true,
            ..mesh(ground, wide(still))
        },
    ];
    Ok(out)
}

fn mesh(mesh: BenchMesh, world_from_object: DMat4) -> Mesh {
    Mesh {
        positions: mesh.positions,
        normals: mesh.normals,
        uvs: mesh.uvs,
        triangles: mesh.triangles,
        world_from_object,
        ..Mesh::default()
    }
}

fn environment(color: ColorMode) -> Option<Environment> {
    let texels: Vec<[f32; 3]> = (0..6)
        .flat_map(cube_face)
        .collect::<Vec<u8>>()
        .chunks_exact(4)
        .map(|t| {
            [t[0], t[1], t[2]].map(|c| match color {
                ColorMode::Raw => f32::from(c) / 255.0,
                ColorMode::Srgb => srgb8_to_linear(c),
            })
        })
        .collect();
    let faces = Environment::from_texels(EnvironmentLayout::Cube, (FACE_SIZE, FACE_SIZE), &texels);
    faces.ok().map(Environment::with_mips)
}

/// The light of the environment of `pbr`: that of `env`, gathered by lobes.
#[must_use]
pub fn metallic_environment(color: ColorMode) -> Option<EnvironmentLight> {
    EnvironmentLight::new(&environment(color)?, FACE_SIZE / 4).ok()
}

fn projector(precision: Precision) -> Option<ProjectorLight> {
    let position = DVec3::from(PROJECTOR);
    let fov = 40f64.to_radians();
    let projector = Projector::new(position, DVec3::from(MIDDLE), DVec3::Y, fov, 1.0).ok()?;
    Some(ProjectorLight {
        projector,
        position,
        texture: 1,
        sampler: Sampler {
            filter: Filter::Bilinear,
            precision,
            ..Sampler::default()
        },
        border: ProjectorBorder::Clamp,
        softness: 0.0,
        mode: ProjectorMode::Light([1.0; 3]),
        shadow: None,
    })
}
