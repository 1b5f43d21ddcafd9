//! Six views from an object: what it would mirror.

use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::MemoryBudget;
use texmap_math::camera::Camera;
use texmap_math::color::srgb_to_linear;
use texmap_math::glam::{DVec2, DVec3};
use texmap_scene::SceneError;

use texmap_render::{RenderError, RenderSettings, render};
use texmap_scene::{ColorMode, Scene};

/// The environment of a mesh as a cube of `size` x `size` texels a face: the scene without the mesh, seen from the middle of its box
/// (SUSTech CS lecture 08). Its light has the 8 bits of frames, 1 at most. A mirror that uses it is right for small objects and far
/// surroundings: at a tenth of the way to the wall directions err by 5.7 degrees.
///
/// # Errors
/// [`SceneError::Index`] for a mesh that does not exist, [`SceneError::Value`] for a mesh without vertices or an environment of no
/// size, and those of [`render`].
pub fn capture_environment(
    scene: &Scene,
    mesh: usize,
    size: u32,
) -> Result<Environment, RenderError> {
    let count = scene.meshes.len();
    let own = scene.meshes.get(mesh).ok_or(SceneError::Index {
        place: "environment".to_owned(),
        what: "mesh",
        index: mesh as u64,
        count,
    })?;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in &own.positions {
        let p = own
            .world_from_object
            .transform_point3(DVec3::from(p.map(f64::from)));
        (low, high) = (low.min(p), high.max(p));
    }
    let eye = 0.5 * (low + high);
    let refused = |what: &str, value: String| -> RenderError {
        SceneError::Value {
            place: format!("environment of mesh '{}'", own.name),
            what: what.to_owned(),
            value,
            expected: "a mesh with vertices and 1 to 8192 texels a side",
        }
        .into()
    };
    if !eye.is_finite() {
        return Err(refused("centre", eye.to_string()));
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
    let mut around = scene.clone();
    around.meshes.remove(mesh);
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
            near: scene.camera.near,
            far: scene.camera.far,
        };
        let frame = render(
            &around,
            &RenderSettings::new(size, size),
            &texmap_render::no_progress,
        )?;
        for (y, row) in out.chunks_exact_mut(size as usize).enumerate() {
            for (x, texel) in row.iter_mut().enumerate() {
                // Faces of a cube map are seen from outside: left and right are exchanged.
                let pixel = 4 * (y * size as usize + size as usize - 1 - x);
                let code = |k: usize| f32::from(frame.rgba[pixel + k]) / 255.0;
                *texel = [0, 1, 2].map(|k| match scene.color {
                    ColorMode::Srgb => srgb_to_linear(code(k)),
                    ColorMode::Raw => code(k),
                });
            }
        }
    }
    Environment::from_texels(EnvironmentLayout::Cube, (size, size), &texels)
        .map_err(|error| refused("size", error.to_string()))
}
