//! Six views from a point: what a mirror there would show.

use texmap_light::{Environment, EnvironmentLayout, ToneMap};
use texmap_math::MemoryBudget;
use texmap_math::camera::Camera;
use texmap_math::color::srgb_to_linear;
use texmap_math::glam::{DVec2, DVec3};
use texmap_scene::SceneError;

use texmap_render::{Aov, AovData, RenderError, RenderSettings, render};
use texmap_scene::{ColorMode, Mesh, Scene, ToneMapping};

/// The environment of a mesh as a cube of `size` x `size` texels a face: the scene without the mesh, seen from the middle of its box
/// (SUSTech CS lecture 08). Its light has the 8 bits of frames, 1 at most. A mirror that uses it is right for small objects and far
/// surroundings: at a tenth of the way to the wall directions err by 5.7 degrees. [`Reflection::within`](texmap_scene::Reflection) cures
/// that in rooms that are boxes.
///
/// # Errors
/// [`SceneError::Index`] for a mesh that does not exist, [`SceneError::Value`] for a mesh without vertices or an environment of no
/// size, and those of [`render`].
pub fn capture_environment(
    scene: &Scene,
    mesh: usize,
    size: u32,
) -> Result<Environment, RenderError> {
    let center = center_of(scene, &[mesh])?;
    let mut around = scene.clone();
    around.meshes.remove(mesh);
    capture(around, center, size, Captured::Display)
}

/// The environment of a point, as [`capture_environment`] makes that of a mesh, but in linear light that is neither rounded nor
/// clipped, without tone mapping: colours that are lit at vertices and volumes alone end at 1. `hidden` meshes are left out, by index.
///
/// # Errors
/// [`SceneError::Index`] for a mesh that does not exist, [`SceneError::Value`] for a point that is not finite or an environment of no
/// size, and those of [`render`].
pub fn capture_environment_at(
    scene: &Scene,
    point: DVec3,
    hidden: &[usize],
    size: u32,
) -> Result<Environment, RenderError> {
    for mesh in hidden {
        mesh_at(scene, *mesh)?;
    }
    let mut around = scene.clone();
    let mut index = 0..;
    around
        .meshes
        .retain(|_| !index.next().is_some_and(|i| hidden.contains(&i)));
    capture(around, point, size, Captured::Light)
}

/// The middle of the box around the vertices of meshes, in the world.
///
/// # Errors
/// [`SceneError::Index`] for a mesh that does not exist, [`SceneError::Value`] where there is no vertex.
pub fn center_of(scene: &Scene, meshes: &[usize]) -> Result<DVec3, RenderError> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut name = "";
    for mesh in meshes {
        let own = mesh_at(scene, *mesh)?;
        name = &own.name;
        for p in &own.positions {
            let p = own
                .world_from_object
                .transform_point3(DVec3::from(p.map(f64::from)));
            (low, high) = (low.min(p), high.max(p));
        }
    }
    let center = 0.5 * (low + high);
    match center.is_finite() {
        true => Ok(center),
        false => Err(SceneError::Value {
            place: format!("environment of mesh '{name}'"),
            what: "centre".to_owned(),
            value: center.to_string(),
            expected: "a mesh with vertices",
        }
        .into()),
    }
}

fn mesh_at(scene: &Scene, mesh: usize) -> Result<&Mesh, RenderError> {
    let found = scene.meshes.get(mesh).ok_or(SceneError::Index {
        place: "environment".to_owned(),
        what: "mesh",
        index: mesh as u64,
        count: scene.meshes.len(),
    })?;
    Ok(found)
}

/// The light that is kept.
#[derive(Clone, Copy, PartialEq)]
enum Captured {
    /// Codes of frames.
    Display,
    /// Linear light.
    Light,
}

/// A scene seen from a point.
fn capture(
    mut around: Scene,
    eye: DVec3,
    size: u32,
    kept: Captured,
) -> Result<Environment, RenderError> {
    let refused = |what: &str, value: String| -> RenderError {
        SceneError::Value {
            place: "environment".to_owned(),
            what: what.to_owned(),
            value,
            expected: "a finite point and 1 to 8192 texels a side",
        }
        .into()
    };
    if !eye.is_finite() {
        return Err(refused("point", eye.to_string()));
    }
    if !(1..=Environment::MAX_SIDE).contains(&size) {
        return Err(refused("size", size.to_string()));
    }
    // The environment's texels, and the copies with borders and mips that it keeps.
    MemoryBudget::of_process().ask(
        6 * u64::from(size) * u64::from(size) * (12 + 16 + 6),
        format_args!("an environment of 6 x {size} x {size} texels"),
        "take fewer texels a side",
    )?;
    let (color, near, far) = (around.color, around.camera.near, around.camera.far);
    if kept == Captured::Light {
        around.effects.tone_mapping = ToneMapping {
            exposure: 1.0,
            map: ToneMap::Unclipped,
        };
    }
    let mut settings = RenderSettings::new(size, size);
    if kept == Captured::Light {
        settings.aovs.push(Aov::Color);
    }
    let mut texels = vec![[0.0; 3]; 6 * size as usize * size as usize];
    for (face, out) in texels
        .chunks_exact_mut((size * size).max(1) as usize)
        .enumerate()
    {
        let at = |u: f64, v: f64| EnvironmentLayout::Cube.direction(face, DVec2::new(u, v));
        let forward = at(0.5, 0.5);
        let up = at(0.5, 0.0) - forward * at(0.5, 0.0).dot(forward);
        around.camera = Camera {
            eye,
            look: eye + forward,
            up,
            fov_x: std::f64::consts::FRAC_PI_2,
            near,
            far,
            lens: Default::default(),
        };
        let frame = render(&around, &settings, &texmap_render::no_progress)?;
        let light = frame.aovs.iter().find_map(|(aov, _, values)| match values {
            AovData::F32(values) if *aov == Aov::Color => Some(values),
            _ => None,
        });
        for (y, row) in out.chunks_exact_mut(size as usize).enumerate() {
            for (x, texel) in row.iter_mut().enumerate() {
                // Faces of a cube map are seen from outside: left and right are exchanged.
                let pixel = 4 * (y * size as usize + size as usize - 1 - x);
                if let Some(light) = &light {
                    *texel = [0, 1, 2].map(|k| light[pixel + k]);
                    continue;
                }
                let code = |k: usize| f32::from(frame.rgba[pixel + k]) / 255.0;
                *texel = [0, 1, 2].map(|k| match color {
                    ColorMode::Srgb => srgb_to_linear(code(k)),
                    ColorMode::Raw => code(k),
                });
            }
        }
    }
    Environment::from_texels(EnvironmentLayout::Cube, (size, size), &texels)
        .map_err(|error| refused("size", error.to_string()))
}
