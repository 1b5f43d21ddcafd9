//! The light around a model that is drawn as metallic-roughness.

use std::sync::{Mutex, PoisonError};

use texmap_light::{EnvironmentLight, Prefilter, Roughnesses, ToneMap};
use texmap_scene::Scene;

use super::Up;

/// The room and its light, made once.
static STUDIO: Mutex<Option<Prefilter>> = Mutex::new(None);

/// The neutral studio for surfaces of some roughnesses, upright along an axis.
#[must_use]
pub fn studio(up: Up, roughnesses: Roughnesses) -> EnvironmentLight {
    // Nothing is gathered under the lock: the studio holds all of its light.
    let mut made = STUDIO.lock().unwrap_or_else(PoisonError::into_inner);
    let light = made
        .get_or_insert_with(Prefilter::studio)
        .light(roughnesses);
    let light = light.unwrap_or_else(|error| unreachable!("sizes are within range: {error}"));
    match up {
        Up::Y => light,
        Up::Z => light.upright_on_z(),
    }
}

/// Lights a scene by the neutral studio alone, under PBR Neutral. The light is that for the surfaces of the scene:
/// [`renew_studio`] follows changes of their roughness.
pub fn light_by_studio(scene: &mut Scene, up: Up) {
    scene.effects.environment_light = Some(studio(up, scene.roughnesses()));
    scene.effects.tone_mapping.map = ToneMap::PbrNeutral;
    scene.lights.clear();
}

/// Completes the neutral studio around a scene for its surfaces, where they have changed, and for `further` roughnesses. It stays
/// turned as it is, and light of another environment stays.
pub fn renew_studio(scene: &mut Scene, further: Roughnesses) {
    let wanted = scene.roughnesses() | further;
    let Some(light) = &mut scene.effects.environment_light else {
        return;
    };
    let made = light.roughnesses();
    if !made.contains(wanted)
        && let Some(whole) = light.with_levels_of(&studio(Up::Y, made | wanted))
    {
        *light = whole;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_light::{Environment, EnvironmentLayout};
    use texmap_math::Camera;
    use texmap_scene::{Material, MetallicRoughness};

    #[test]
    fn the_studio_stands_on_the_axis_that_points_up() {
        let (y, z) = (
            studio(Up::Y, Roughnesses::ALL),
            studio(Up::Z, Roughnesses::ALL),
        );
        for d in [[0.3, 0.9, -0.2], [-0.7, 0.1, 0.6], [0.0, -1.0, 0.1]] {
            let [a, b, c] = d;
            assert_eq!(y.irradiance(d), z.irradiance([a, -c, b]));
            assert_eq!(y.radiance(0.3, d), z.radiance(0.3, [a, -c, b]));
            assert_ne!(y.irradiance(d), z.irradiance(d));
        }
    }

    #[test]
    fn threads_of_the_pool_do_not_wait_for_each_other() {
        let of = |k: i32| Roughnesses::between(0.1 * k as f32, 0.1 * k as f32);
        let all = texmap_math::parallel::map(0..32, |k| studio(Up::Y, of(k % 8)));
        assert!((0..8).all(|k| all[k] == all[k + 24]));
        assert_ne!(all[2], all[5]);
    }

    #[test]
    fn the_studio_follows_the_surfaces_of_its_scene() {
        let metal = |roughness: f32| Material {
            metallic_roughness: Some(MetallicRoughness {
                roughness,
                ..MetallicRoughness::default()
            }),
            ..Material::default()
        };
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        scene.materials = vec![metal(0.85)];
        light_by_studio(&mut scene, Up::Z);
        scene.check().unwrap();
        let light = scene.effects.environment_light.take().unwrap();
        assert_eq!(light.roughnesses(), scene.roughnesses());
        scene.effects.environment_light = Some(light.turned(1.0));
        scene.materials.push(metal(0.2));
        let error = scene.check().unwrap_err().to_string();
        assert!(error.contains("roughness is not among"), "{error}");
        renew_studio(&mut scene, Roughnesses::NONE);
        scene.check().unwrap();
        let whole = studio(Up::Z, Roughnesses::ALL).turned(1.0);
        let light = scene.effects.environment_light.as_ref().unwrap();
        for d in [[0.3, 0.9, -0.2], [-0.7, 0.1, 0.6]] {
            assert_eq!(light.radiance(0.2, d), whole.radiance(0.2, d));
        }
        // Another environment of some levels is not mixed with the studio.
        let sky = Environment::from_fn(EnvironmentLayout::Cube, 64, |_| [0.5; 3]).unwrap();
        let sky = Prefilter::new(&sky, 64).unwrap().light(Roughnesses::NONE);
        let sky = Some(sky.unwrap());
        scene.effects.environment_light = sky.clone();
        renew_studio(&mut scene, Roughnesses::NONE);
        assert_eq!(scene.effects.environment_light, sky);
    }
}
