//! Lights of a model in lux and candela, as programs write them that think in watts.

use core::f64::consts::PI;

use texmap_light::{Light, PhongMaterial, SpecularExponent, SpecularModel, evaluate_light};
use texmap_math::parallel;
use texmap_math::wide;
use texmap_scene::{Mesh, Scene, Shading};

/// Lumens that a watt has (of green light, 555 nm). Blender multiplies watts by it where it writes glTF, and divides where it reads.
///
/// Source: Khronos glTF-Blender-IO, `PBR_WATTS_TO_LUMENS`.
const LUMENS_PER_WATT: f64 = 683.0;
/// Brightness, in that of a white surface of display light 1, from which on lights are in lumens. Lights that are made for a picture
/// without exposure stay far below, and those of Blender above.
const BRIGHT: f64 = 50.0;
/// Brightness that is left at most.
const MOST: f64 = 4.0;
/// Triangles at which brightness is measured, at most.
const SAMPLES: usize = 4096;

/// Dims the lights of a model that are so bright that nearly all would be white. They are taken as watts, by 683 lumens each, and darker
/// where that leaves more than four times white; a warning tells so. Other lights stay as they are, as do emission and light from all
/// around.
pub fn dim_bright_lights(scene: &mut Scene) {
    let brightness = brightness(scene);
    if brightness <= BRIGHT || !brightness.is_finite() {
        return;
    }
    let factor = (1.0 / LUMENS_PER_WATT).min(MOST / brightness);
    for light in &mut scene.lights {
        match light {
            Light::Directional { color, .. }
            | Light::Point { color, .. }
            | Light::Spot { color, .. }
            | Light::Punctual {
                intensity: color, ..
            } => *color = color.map(|c| (f64::from(c) * factor) as f32),
            _ => {}
        }
    }
    scene.warnings.push(format!(
        "the lights of the file give {:.0} lux: drawn {:.0} times darker (683 is a watt); --exposure 1 draws them as they stand",
        brightness * PI,
        1.0 / factor
    ));
}

/// The brightness that one of ten triangles exceeds, if they were white and nothing had a shadow. It counts surfaces that lights shine on.
fn brightness(scene: &Scene) -> f64 {
    if scene.lights.is_empty() {
        return 0.0;
    }
    let lit = |mesh: &&Mesh| {
        let material = scene.materials.get(mesh.material);
        material.is_some_and(|m| m.shading != Shading::Unlit)
    };
    let meshes: Vec<&Mesh> = scene.meshes.iter().filter(lit).collect();
    let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let step = triangles.div_ceil(SAMPLES).max(1);
    let mut found = Vec::new();
    let mut above = 0;
    for mesh in meshes {
        // Every `step`th triangle of all meshes.
        let first = (step - above % step) % step;
        above += mesh.triangles.len();
        if first < mesh.triangles.len() {
            let of_mesh = mesh.triangles[first..].iter().step_by(step).collect();
            found.extend(brightness_of(scene, mesh, of_mesh));
        }
    }
    found.sort_by(f64::total_cmp);
    found.get(found.len() * 9 / 10).copied().unwrap_or(0.0)
}

/// The brightness at the first vertex of each triangle.
fn brightness_of(scene: &Scene, mesh: &Mesh, triangles: Vec<&[u32; 3]>) -> Vec<f64> {
    let white = PhongMaterial {
        ks: 0.0,
        kd: 1.0,
        ..PhongMaterial::default()
    };
    let (power, model) = (SpecularExponent::new(1.0), SpecularModel::Phong);
    let normal = mesh.world_normal();
    parallel::map(triangles.iter(), |triangle| {
        let vertex = triangle[0] as usize;
        let Some(position) = mesh.positions.get(vertex) else {
            return 0.0;
        };
        let point = mesh.world_from_object.transform_point3(wide(*position));
        let point = point.as_vec3().to_array();
        let normal = normal(vertex).as_vec3().to_array();
        let lights = scene.lights.iter().filter_map(|light| {
            if matches!(light, Light::Ambient { .. }) {
                return None;
            }
            let given = evaluate_light(&white, power, model, light, point, normal, normal)?;
            let brightest = given.color.into_iter().fold(0.0, f32::max);
            Some(f64::from(brightest * given.diffuse))
        });
        lights.sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_scene::Material;

    fn cube(light: Light) -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        scene.materials = vec![Material::default()];
        scene.meshes = vec![Mesh::cube()];
        scene.lights = vec![light];
        scene
    }

    fn sun(lux: f64) -> Light {
        Light::Directional {
            color: [(lux / PI) as f32; 3],
            direction: [0.0, 0.0, -1.0],
        }
    }

    fn color(scene: &Scene) -> f64 {
        match scene.lights[0] {
            Light::Directional { color, .. } => color[0].into(),
            Light::Punctual { intensity, .. } => intensity[0].into(),
            _ => f64::NAN,
        }
    }

    #[test]
    fn watts_come_back_and_other_lights_stay() {
        let mut blender = cube(sun(3.0 * LUMENS_PER_WATT));
        dim_bright_lights(&mut blender);
        assert!((color(&blender) - 3.0 / PI).abs() < 1e-6);
        assert!(
            blender.warnings[0].contains("2049 lux: drawn 683 times darker"),
            "{:?}",
            blender.warnings
        );
        // A point light of 1000 W, four metres above the cube.
        let candela = 1000.0 * LUMENS_PER_WATT / (4.0 * PI);
        let mut point = cube(Light::Punctual {
            intensity: [candela as f32; 3],
            position: [0.0, 4.0, 0.0],
            range: f32::INFINITY,
            cone: None,
        });
        dim_bright_lights(&mut point);
        assert!((color(&point) - 1000.0 / (4.0 * PI)).abs() < 1e-3);
        for lux in [0.0, 10.0, 100.0] {
            let mut scene = cube(sun(lux));
            dim_bright_lights(&mut scene);
            assert_eq!(scene.lights, [sun(lux)]);
            assert!(scene.warnings.is_empty());
        }
        // Daylight: still white, and no more than four times.
        let mut day = cube(sun(1e5));
        dim_bright_lights(&mut day);
        assert!((color(&day) - MOST).abs() < 1e-5);
    }

    #[test]
    fn surfaces_in_no_light_do_not_count() {
        // The range of the light ends before the cube, and unlit surfaces show no light.
        let mut unlit = cube(sun(1e4));
        unlit.materials[0].shading = Shading::Unlit;
        let mut away = cube(Light::Punctual {
            intensity: [1e6; 3],
            position: [0.0, 4.0, 0.0],
            range: 1.0,
            cone: None,
        });
        for scene in [&mut unlit, &mut away] {
            let before = color(scene);
            dim_bright_lights(scene);
            assert_eq!(color(scene), before);
            assert!(scene.warnings.is_empty());
        }
    }
}
