//! The plan by budget: for each mesh the cheapest interpolation and filter whose predicted error fits.
//!
//! [`choose`] is a pure function of the scene, the size of the picture and the budget. Prices come from a table that is
//! part of the crate ([`prices`]), never from a clock, so that the same scene gets the same plan on every machine. Errors
//! of interpolation are predicted by the closed form of affine mapping, those of filters by a pilot: each candidate is
//! tried at some of the mesh's own pixels, where all are known at those off its outlines, against the mean over the pixel.
//!
//! ```
//! use texmap_math::{Camera, glam::DVec3};
//! use texmap_planner::{Budget, choose};
//! use texmap_scene::{Material, Mesh, Scene};
//!
//! let camera = Camera {
//!     eye: DVec3::new(0.0, 1.0, 5.0), look: DVec3::ZERO, up: DVec3::Y,
//!     fov_x: 1.0, near: 1e-4, far: f64::INFINITY,
//!     lens: Default::default(),
//! };
//! let mut scene = Scene {
//!     materials: vec![Material::default()],
//!     meshes: vec![Mesh::cube()],
//!     ..Scene::new(camera)
//! };
//! let choices = choose(&scene, 64, 48, Budget::default())?;
//! assert!(choices.met() && choices.meshes.len() == 1);
//! choices.apply(&mut scene);
//! # Ok::<(), texmap_scene::SceneError>(())
//! ```
//!
//! # Limits
//! Meshes are read as triangles: `texmap_mesh::tessellate` comes first. Errors are predictions with a margin, no bounds.
#![forbid(unsafe_code)]

mod choices;
mod environments;
mod gain;
mod lights;
mod look;
mod maps;
mod pilot;
mod prices;
mod textures;
mod view;
mod visible;

use texmap_math::glam::{DVec2, DVec4};
use texmap_raster::TargetSize;
use texmap_scene::SceneError;

pub use choices::{Budget, Choice, Choices};
pub use environments::EnvironmentChoice;
use gain::Lighting;
pub use lights::{IdleLight, ShadowChoice};
use pilot::{PixelSamples, pixel_grid};
pub use prices::{Price, prices};
use texmap_scene::{Mesh, Scene};
use view::View;

/// Chooses for a picture of this size: with one sample a pixel if that can keep the budget, else with 2 x 2 or 4 x 4. If none
/// can, the smallest predicted error.
///
/// # Errors
/// Every fault that [`Scene::check`] finds.
pub fn choose(
    scene: &Scene,
    width: u32,
    height: u32,
    budget: Budget,
) -> Result<Choices, SceneError> {
    choose_sampled(scene, width, height, budget, &[1, 2, 4])
}

/// [`choose`] among these numbers of samples a side of a pixel, in this order.
///
/// # Errors
/// Every fault that [`Scene::check`] finds; [`SceneError::Value`] for a scene with tone mapping, and for a number of samples that is 0
/// or above 1,024.
pub fn choose_sampled(
    scene: &Scene,
    width: u32,
    height: u32,
    budget: Budget,
    samples: &[u32],
) -> Result<Choices, SceneError> {
    scene.check()?;
    scene.check_tessellated()?;
    if !scene.effects.tone_mapping.is_identity() {
        return Err(SceneError::Value {
            place: "plan".to_owned(),
            what: "tone mapping".to_owned(),
            value: format!("{:?}", scene.effects.tone_mapping),
            expected: "plans predict the errors of light that is shown as it is: exposure 1, no curve",
        });
    }
    if let Some(side) = samples.iter().find(|side| !(1..=1024).contains(*side)) {
        return Err(SceneError::Value {
            place: "plan".to_owned(),
            what: "number of samples".to_owned(),
            value: side.to_string(),
            expected: "1 to 1024 a side of a pixel",
        });
    }
    let aspect = f64::from(width) / f64::from(height);
    let view_from_world = scene.camera.view().map_err(SceneError::Camera)?;
    let projection = scene.camera.projection(aspect);
    let clip_from_world = projection * view_from_world;
    let size = DVec2::new(f64::from(width), f64::from(height));
    let place = |mesh: &Mesh| -> Vec<DVec4> {
        let clip = clip_from_world * mesh.world_from_object;
        let pixels = |p: &[f32; 3]| {
            let [x, y, z] = p.map(f64::from);
            let p = clip * DVec4::new(x, y, z, 1.0);
            let (x, y) = ((p.x + p.w) * 0.5, (p.w - p.y) * 0.5);
            DVec4::new(x * size.x, y * size.y, p.z, p.w)
        };
        mesh.positions.iter().map(pixels).collect()
    };
    let positions: Vec<Vec<DVec4>> = scene.meshes.iter().map(place).collect();
    let idle_lights = lights::idle(scene);
    let lighting = Lighting::new(scene, &idle_lights);
    let views: Vec<View<'_>> = scene
        .meshes
        .iter()
        .zip(&positions)
        .map(|(mesh, positions)| View {
            scene,
            mesh,
            lighting: &lighting,
            positions,
            size,
            view_from_world,
            half: [1.0 / projection.x_axis.x, 1.0 / projection.y_axis.y],
        })
        .collect();
    let mut places: Vec<PixelSamples> = {
        let grid = pixel_grid::grid(&views);
        views
            .iter()
            .map(|view| pixel_grid::places(view, grid))
            .collect()
    };
    let before: Vec<usize> = places.iter().map(|p| p.list.len()).collect();
    visible::keep_visible(scene, &positions, size, &mut places);
    places.iter_mut().for_each(|p| p.leave_outlines_out(size));
    let mut best = Choices {
        budget,
        supersample: 1,
        meshes: Vec::new(),
        shadows: lights::shadows(scene, width, &idle_lights)?,
        idle_lights: idle_lights.clone(),
        environments: environments::used(scene),
    };
    for (k, &supersample) in samples.iter().enumerate() {
        let side = u64::from(width.max(height)) * u64::from(supersample);
        if k > 0 && side > u64::from(TargetSize::MAX) {
            break;
        }
        let meshes = (0..views.len())
            .filter(|&i| !views[i].mesh.triangles.is_empty())
            .map(|i| views[i].choose(i, budget, &places[i], before[i], supersample))
            .collect();
        let next = Choices {
            supersample,
            meshes,
            ..best.clone()
        };
        if k == 0 || next.worst() < best.worst() {
            best = next;
        }
        if best.met() {
            break;
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use texmap_light::Light;
    use texmap_math::Camera;
    use texmap_math::glam::DVec3;
    use texmap_raster::{Cull, DepthTest};
    use texmap_sample::{ColorSpace, Origin, Sampler, Texture2d};

    use super::*;
    use texmap_scene::{
        AlphaMode, ColorMode, Effects, Material, Shading, Shadow, TextureRole, TextureSlot,
    };

    /// A square of side 4 across the view at this depth, with a picture that no filter can show at its size.
    fn square(z: f32, material: usize) -> Mesh {
        Mesh {
            positions: [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]
                .map(|[x, y]| [x, y, z])
                .to_vec(),
            uvs: vec![[0.0, 0.0], [3.1, 0.0], [3.1, 3.1], [0.0, 3.1]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material,
            ..Mesh::default()
        }
    }

    /// A noisy square behind a plain one.
    pub(super) fn scene() -> Scene {
        let noise = (0..64 * 64u32)
            .flat_map(|i| {
                let on = i.wrapping_mul(0x9e37_79b9) >> 31;
                [on as u8 * 255, 0, 255 - on as u8 * 255, 255]
            })
            .collect();
        let texture =
            Texture2d::from_rgba8(64, 64, noise, ColorSpace::Srgb, Origin::TopLeft).unwrap();
        let noisy = Material {
            base_color: Some(TextureSlot {
                sampler: Sampler::default(),
                ..TextureSlot::new(0)
            }),
            ..Material::default()
        };
        Scene {
            background: [0.0; 4],
            lights: vec![Light::Ambient { color: [1.0; 3] }],
            textures: vec![texture],
            materials: vec![noisy, Material::default()],
            meshes: vec![square(-1.0, 0), square(0.0, 1)],
            ..Scene::new(Camera {
                eye: DVec3::new(0.0, 0.0, 5.0),
                look: DVec3::ZERO,
                up: DVec3::Y,
                fov_x: 1.0,
                near: 1e-2,
                far: f64::INFINITY,
                lens: Default::default(),
            })
        }
    }

    const TIGHT: Budget = Budget {
        texels: 0.5,
        rmse: 0.01,
    };

    /// With one sample a pixel.
    fn plan(scene: &Scene) -> Choices {
        choose_sampled(scene, 96, 96, TIGHT, &[1]).unwrap()
    }

    /// Predicted error of the most accurate filter, whatever its price.
    fn least_error(scene: &Scene) -> f64 {
        let never = Budget {
            rmse: 1e-9,
            ..TIGHT
        };
        let choices = choose_sampled(scene, 96, 96, never, &[1]).unwrap();
        choices.meshes[0].predicted_rmse
    }

    #[test]
    fn more_samples_are_taken_where_one_cannot_keep_the_budget_and_nowhere_else() {
        let mut seen = scene();
        seen.meshes.truncate(1);
        assert!(!plan(&seen).met());
        let more = choose(&seen, 96, 96, TIGHT).unwrap();
        assert!(more.met() && more.supersample > 1, "{more:?}");
        let loose = Budget { rmse: 0.4, ..TIGHT };
        assert_eq!(choose(&seen, 96, 96, loose).unwrap().supersample, 1);
        // Not beyond what can be drawn.
        let wide = choose(
            &seen,
            16384,
            16,
            Budget {
                rmse: 1e-9,
                ..TIGHT
            },
        )
        .unwrap();
        assert_eq!((wide.met(), wide.supersample), (false, 1));
    }

    #[test]
    fn what_is_hidden_breaks_no_budget() {
        let hidden = scene();
        let choices = plan(&hidden);
        assert!(choices.met(), "{choices:?}");
        assert!(choices.meshes[0].why.contains("hidden"), "{choices:?}");
        assert_eq!(choices.meshes[0].tried, 0);
        // Negative twins: each leaves the noise in sight.
        let seen = |change: &dyn Fn(&mut Scene)| {
            let mut scene = scene();
            change(&mut scene);
            let choices = plan(&scene);
            assert!(
                !choices.met() && choices.meshes[0].tried > 100,
                "{choices:?}"
            );
        };
        seen(&|s| s.meshes.truncate(1));
        seen(&|s| s.meshes[1].positions.iter_mut().for_each(|p| p[2] = -1.5));
        seen(&|s| s.materials[1].alpha = AlphaMode::Blend);
        seen(&|s| s.depth_test = DepthTest::Always);
        seen(&|s| s.materials[1].cull = Cull::Front);
        // Nearer than the near plane it is not drawn.
        seen(&|s| s.meshes[1].positions.iter_mut().for_each(|p| p[2] = 4.995));
        // Half of it is enough to be judged.
        seen(&|s| s.meshes[1].positions.iter_mut().for_each(|p| p[0] += 2.0));
        // Back faces of a one-sided mesh are not drawn, its front is.
        let mut one_sided = scene();
        one_sided.materials[1].cull = Cull::Back;
        assert!(plan(&one_sided).met());
    }

    #[test]
    fn a_dark_surface_shows_little_of_its_picture() {
        let mut scene = scene();
        scene.meshes.truncate(1);
        (scene.color, scene.materials[0].shading) = (ColorMode::Raw, Shading::Unlit);
        scene.materials[0].phong.color = [1.0; 3];
        let bright = least_error(&scene);
        scene.materials[0].phong.color = [0.25; 3];
        let ratio = least_error(&scene) / bright;
        assert!((0.24..0.27).contains(&ratio), "{ratio}");
        // Negative twin: a decal covers the surface.
        scene.materials[0].texture_role = TextureRole::Decal;
        assert_eq!(least_error(&scene), bright);
    }

    #[test]
    fn strong_light_shows_more_of_a_dark_picture() {
        let mut scene = scene();
        scene.meshes.truncate(1);
        scene.color = ColorMode::Raw;
        scene.materials[0].phong.color = [0.25; 3];
        scene.materials[0].phong.ka = 1.0;
        let mut predicted = |strength: f32| {
            scene.lights = vec![Light::Ambient {
                color: [strength; 3],
            }];
            least_error(&scene)
        };
        let (weak, strong) = (predicted(1.0), predicted(4.0));
        assert!((3.5..4.5).contains(&(strong / weak)), "{weak} {strong}");
        // Negative twin: what is white already cannot get lighter.
        assert_eq!(predicted(1e3), predicted(1e4));
    }

    #[test]
    fn lights_that_reach_nothing_are_left_out_with_their_shadows() {
        let spot = |x: f32| Light::spot([1.0; 3], [x, 0.0, 3.0], [0.0, 0.0, -1.0], 0.2, 0.3);
        let mut scene = scene();
        let sun = Light::Directional {
            color: [1.0; 3],
            direction: [0.0, 0.0, -1.0],
        };
        let dark = Light::spot([0.0; 3], [0.0; 3], [0.0, 0.0, -1.0], 0.2, 0.3);
        // The cone of the second spot light is about 1.2 wide where the squares are, and 4 aside.
        scene.lights = vec![dark, spot(0.0), spot(8.0), sun];
        let shadow = |light, size| Shadow {
            light,
            size,
            bias: None,
            pcf_size: 3,
            area: None,
        };
        scene.effects.shadows = vec![shadow(2, None), shadow(3, None), shadow(1, Some(512))];
        let choices = plan(&scene);
        let idle: Vec<usize> = choices.idle_lights.iter().map(|l| l.light).collect();
        assert_eq!(idle, [0, 2], "{:?}", choices.idle_lights);
        assert_eq!(choices.shadows.len(), 2);
        assert!((choices.shadows[0].light, choices.shadows[0].fixed) == (3, false));
        assert!((0.5..=1.0).contains(&choices.shadows[0].pixels) || choices.shadows[0].size == 256);
        assert_eq!(
            (choices.shadows[1].light, choices.shadows[1].size),
            (1, 512)
        );
        let mut planned = scene.clone();
        choices.apply(&mut planned);
        assert_eq!(planned.lights, [scene.lights[1], scene.lights[3]]);
        let left: Vec<(usize, Option<u32>)> = planned
            .effects
            .shadows
            .iter()
            .map(|s| (s.light, s.size))
            .collect();
        assert_eq!(left, [(1, Some(choices.shadows[0].size)), (0, Some(512))]);
        planned.check().unwrap();
        // Two lights three units away from squares that reach 2.83 around their middles: one has the range.
        let light = |range| Light::Punctual {
            intensity: [1.0; 3],
            position: [0.0, 0.0, 3.0],
            range,
            cone: None,
        };
        let lit = Scene {
            lights: vec![light(0.1), light(9.0)],
            effects: Effects::default(),
            ..scene.clone()
        };
        let idle: Vec<usize> = plan(&lit).idle_lights.iter().map(|l| l.light).collect();
        assert_eq!(idle, [0]);
        // Nothing lit: no light at all.
        for material in &mut scene.materials {
            material.shading = Shading::Unlit;
        }
        assert_eq!(plan(&scene).idle_lights.len(), 4);
    }
}
