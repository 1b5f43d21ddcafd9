//! The lights of a document (`KHR_lights_punctual`).

use texmap_light::{Light, LightCone};
use texmap_scene::{ColorMode, Scene};

use super::json;
use super::model::Model;
use super::nodes::Tree;
use crate::framing::{Up, light_by_studio};
use crate::{IoError, shortened};

/// Ambient light beside the lights of a file, so that surfaces which they do not reach are not black.
const AMBIENT: f32 = 0.1;

/// The lights of the nodes that are drawn, in their order, with the names of their nodes.
pub(super) fn lights(model: &mut Model<'_>, tree: &Tree) -> Result<Vec<(String, Light)>, IoError> {
    let mut lights = Vec::new();
    for n in &tree.shown {
        let node = &model.document.nodes[*n];
        let Some(named) = &node.extensions.light else {
            continue;
        };
        let pointer = format!("/nodes/{n}/extensions/KHR_lights_punctual/light");
        let all = &model.document.extensions.lights.lights;
        let stated = model.item(all, named.light, &pointer, "light")?;
        let at = format!("/extensions/KHR_lights_punctual/lights/{}", named.light);
        let name = match stated.name.as_str() {
            "" => node.name.clone(),
            name => name.to_owned(),
        };
        lights.push((name, light(model, tree, *n, stated, &at)?));
    }
    Ok(lights)
}

fn light(
    model: &Model<'_>,
    tree: &Tree,
    node: usize,
    stated: &json::Light,
    at: &str,
) -> Result<Light, IoError> {
    let position = tree.world[node].w_axis.truncate().as_vec3().to_array();
    let direction = super::cameras::forward(tree, node).as_vec3().to_array();
    let scaled = |by: f64| stated.color.map(|c| (c * stated.intensity * by) as f32);
    let punctual = |cone| Light::Punctual {
        intensity: scaled(1.0),
        position,
        range: stated.range.map_or(f32::INFINITY, |range| range as f32),
        cone,
    };
    let light = match stated.kind.as_str() {
        // A white surface returns 1 / pi of its illuminance (lux) in every direction.
        "directional" => Light::Directional {
            color: scaled(1.0 / core::f64::consts::PI),
            direction,
        },
        "point" => punctual(None),
        "spot" => {
            let (inner, outer) = (stated.spot.inner_cone_angle, stated.spot.outer_cone_angle);
            if !(inner >= 0.0 && inner < outer && outer <= core::f64::consts::FRAC_PI_2 + 1e-6) {
                let problem = format!(
                    "inner angle {inner} and outer angle {outer}: 0 <= inner < outer <= pi / 2 is needed"
                );
                return Err(model.broken(&format!("{at}/spot"), problem));
            }
            punctual(Some(LightCone::new(direction, inner as f32, outer as f32)))
        }
        other => {
            let problem = format!("`{}` is none of directional, point, spot", shortened(other));
            return Err(model.broken(&format!("{at}/type"), problem));
        }
    };
    match light.is_valid() {
        true => Ok(light),
        false => Err(model.broken(at, format!("cannot be used: {light:?}"))),
    }
}

/// Lights a scene by the lights of the file and the neutral studio, under PBR Neutral. Raw colours are not light: they keep the lights of
/// other models where the file has none.
pub(super) fn illuminate(scene: &mut Scene, lights: Vec<(String, Light)>, up: Up) {
    if scene.color == ColorMode::Srgb {
        light_by_studio(scene, up);
    }
    if lights.is_empty() {
        return;
    }
    let named = lights
        .iter()
        .map(|(name, _)| match texmap_scene::is_light_name(name) {
            true => name.clone(),
            false => String::new(),
        });
    scene.effects.light_names = named.collect();
    scene.lights = lights.into_iter().map(|(_, light)| light).collect();
    if scene.effects.environment_light.is_none() {
        scene.lights.push(Light::Ambient {
            color: [AMBIENT; 3],
        });
    }
}
