//! The light around a model that is drawn as metallic-roughness.

use std::sync::OnceLock;

use texmap_light::{EnvironmentLight, ToneMap};
use texmap_scene::Scene;

use super::Up;

/// The neutral studio, upright along an axis.
#[must_use]
pub fn studio(up: Up) -> EnvironmentLight {
    // Made once: it takes longer than many a model.
    static STUDIO: OnceLock<EnvironmentLight> = OnceLock::new();
    let studio = STUDIO.get_or_init(EnvironmentLight::studio).clone();
    match up {
        Up::Y => studio,
        Up::Z => studio.upright_on_z(),
    }
}

/// Lights a scene by the neutral studio alone, under PBR Neutral.
pub fn light_by_studio(scene: &mut Scene, up: Up) {
    scene.effects.environment_light = Some(studio(up));
    scene.effects.tone_mapping.map = ToneMap::PbrNeutral;
    scene.lights.clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_studio_stands_on_the_axis_that_points_up() {
        let (y, z) = (studio(Up::Y), studio(Up::Z));
        for d in [[0.3, 0.9, -0.2], [-0.7, 0.1, 0.6], [0.0, -1.0, 0.1]] {
            let [a, b, c] = d;
            assert_eq!(y.irradiance(d), z.irradiance([a, -c, b]));
            assert_eq!(y.radiance(0.3, d), z.radiance(0.3, [a, -c, b]));
            assert_ne!(y.irradiance(d), z.irradiance(d));
        }
    }
}
