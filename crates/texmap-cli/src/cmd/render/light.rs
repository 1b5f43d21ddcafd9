//! The light on surfaces, and its way to display light.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use texmap_io::framing::{Up, auto_lights};
use texmap_light::{EnvironmentLayout, EnvironmentLight, ToneMap};
use texmap_scene::{MetallicRoughness, Scene, Shading};

use crate::failure::Failure;

/// Light from all around, the model of surfaces, exposure and tone mapping.
#[derive(Args, Debug)]
#[command(next_help_heading = "Light")]
pub(crate) struct LightArgs {
    /// The model of surfaces: metallic-roughness (also of an OBJ, whose exponent becomes a roughness) or classic, the model of
    /// Phong [default: that of the file: metallic-roughness for glTF, classic for others]
    #[arg(long, value_name = "MODEL")]
    shading: Option<Model>,
    /// Light from all around on metallic-roughness surfaces: a lat-long picture (.hdr, .exr, ...), the neutral studio, or none
    /// [default: neutral for models]
    #[arg(long, value_name = "FILE|neutral|none")]
    env: Option<Env>,
    /// Turn that light about the vertical axis, counter-clockwise from above
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = degrees)]
    env_rotate: Option<f64>,
    /// Factor of light before tone mapping [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    exposure: Option<f32>,
    /// The way of bright light to display light: pbr-neutral, aces, agx, none [default: pbr-neutral under light from all around and
    /// for pictures of 8 or 16 bits, none otherwise]
    #[arg(long, value_name = "CURVE", value_parser = tone_map)]
    tone_map: Option<ToneMap>,
}

/// `--shading`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Model {
    Classic,
    MetallicRoughness,
}

/// `--env`.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Env {
    None,
    Neutral,
    Picture(PathBuf),
}

impl FromStr for Env {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "none" => Self::None,
            "neutral" => Self::Neutral,
            path => Self::Picture(path.into()),
        })
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| n.is_finite());
    number.ok_or_else(|| "expected an angle in degrees".to_owned())
}

fn factor(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    number
        .filter(|n| n.is_finite() && *n >= 0.0)
        .ok_or_else(|| "expected a factor of at least 0".to_owned())
}

fn tone_map(text: &str) -> Result<ToneMap, String> {
    let names = ToneMap::ALL.map(ToneMap::name).join(", ");
    text.parse().map_err(|_| format!("choose from {names}"))
}

impl LightArgs {
    /// The picture of light from all around.
    pub(crate) fn picture(&self) -> Option<&Path> {
        match &self.env {
            Some(Env::Picture(path)) => Some(path),
            _ => None,
        }
    }

    /// Lights a scene that has its look. `scene_file`: the scene keeps its own light. `floats`: the picture is written as light without an
    /// upper end, which no tone mapping changes unless one is asked for.
    pub(crate) fn light(
        &self,
        scene: &mut Scene,
        scene_file: bool,
        floats: bool,
        up: Up,
    ) -> Result<(), Failure> {
        match self.shading {
            Some(Model::Classic) => {
                for material in &mut scene.materials {
                    material.metallic_roughness = None;
                }
                scene.effects.environment_light = None;
                scene.effects.tone_mapping.map = ToneMap::None;
            }
            Some(Model::MetallicRoughness) => {
                for material in &mut scene.materials {
                    let of_phong = || MetallicRoughness::of_phong(&material.phong);
                    material.metallic_roughness.get_or_insert_with(of_phong);
                }
                if !scene_file && scene.effects.environment_light.is_none() {
                    scene.effects.environment_light = Some(EnvironmentLight::studio());
                    scene.effects.tone_mapping.map = ToneMap::PbrNeutral;
                    // The lights of the loader, which replace light from all around.
                    if scene.lights == auto_lights(up) {
                        scene.lights.clear();
                    }
                }
            }
            None => {}
        }
        match &self.env {
            None => {}
            Some(Env::None) => {
                scene.effects.environment_light = None;
                scene.effects.tone_mapping.map = ToneMap::None;
            }
            Some(env) => {
                scene.effects.environment_light = Some(environment(env)?);
                scene.effects.tone_mapping.map = ToneMap::PbrNeutral;
                if !reads_environment(scene) {
                    let warning = "--env: no surface is metallic-roughness, so that nothing shows its light; --shading metallic-roughness makes all of them so";
                    scene.warnings.push(warning.to_owned());
                }
            }
        }
        if let (Some(angle), Some(light)) = (self.env_rotate, &scene.effects.environment_light) {
            let turned = light.clone().turned(angle.to_radians());
            scene.effects.environment_light = Some(turned);
        }
        if let Some(exposure) = self.exposure {
            scene.effects.tone_mapping.exposure = exposure;
        }
        match self.tone_map {
            Some(map) => scene.effects.tone_mapping.map = map,
            None if floats => scene.effects.tone_mapping.map = ToneMap::None,
            None => {}
        }
        // A model without lights is not dark.
        if !scene_file && scene.lights.is_empty() && needs_lights(scene) {
            scene.lights = auto_lights(up);
        }
        Ok(())
    }
}

fn environment(env: &Env) -> Result<EnvironmentLight, Failure> {
    let Env::Picture(path) = env else {
        return Ok(EnvironmentLight::studio());
    };
    let picture = texmap_io::read_environment(path, EnvironmentLayout::LatLong)?;
    // As many texels around as the picture has.
    let size = (picture.size().0 / 4).clamp(16, 1024);
    EnvironmentLight::new(&picture, size).map_err(|e| {
        Failure::usage(
            format!("--env {}: {e}", path.display()),
            "give a picture of all directions, twice as wide as high",
        )
    })
}

/// True if some surface shows the light of an environment.
fn reads_environment(scene: &Scene) -> bool {
    let mut materials = scene.materials.iter();
    materials.any(|m| m.metallic_roughness.is_some() && m.shading == Shading::PerPixel)
}

/// True if some surface is dark without lights.
fn needs_lights(scene: &Scene) -> bool {
    let around = scene.effects.environment_light.is_some();
    let mut drawn = scene
        .meshes
        .iter()
        .map(|mesh| &scene.materials[mesh.material]);
    drawn.any(|m| match m.shading {
        Shading::Unlit => false,
        Shading::PerVertex => true,
        Shading::PerPixel => m.metallic_roughness.is_none() || !around,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_scene::{Material, Mesh};

    fn args() -> LightArgs {
        LightArgs {
            shading: None,
            env: None,
            env_rotate: None,
            exposure: None,
            tone_map: None,
        }
    }

    fn model() -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        scene.materials = vec![Material::default()];
        scene.meshes = vec![Mesh::cube()];
        scene.lights = auto_lights(Up::Y);
        scene
    }

    #[test]
    fn models_change_to_metallic_roughness_and_back() {
        let mut scene = model();
        let shading = Some(Model::MetallicRoughness);
        let modern = LightArgs { shading, ..args() };
        modern.light(&mut scene, false, false, Up::Y).unwrap();
        assert!(scene.materials[0].metallic_roughness.is_some() && scene.lights.is_empty());
        assert!(scene.effects.environment_light.is_some());
        assert_eq!(scene.effects.tone_mapping.map, ToneMap::PbrNeutral);
        modern.light(&mut scene, false, true, Up::Y).unwrap();
        assert_eq!(scene.effects.tone_mapping.map, ToneMap::None);
        let shading = Some(Model::Classic);
        let classic = LightArgs { shading, ..args() };
        classic.light(&mut scene, false, false, Up::Y).unwrap();
        assert_eq!(scene.lights, auto_lights(Up::Y));
        assert!(scene.effects.environment_light.is_none());
        // A dark scene stays dark.
        let mut dark = model();
        dark.lights.clear();
        args().light(&mut dark, true, false, Up::Y).unwrap();
        assert!(dark.lights.is_empty());
    }

    #[test]
    fn an_environment_that_nothing_shows_is_told() {
        let mut scene = model();
        let env = Some(Env::Neutral);
        let lit = LightArgs { env, ..args() };
        lit.light(&mut scene, false, false, Up::Y).unwrap();
        assert_eq!(scene.warnings.len(), 1);
        let shading = Some(Model::MetallicRoughness);
        let mut scene = model();
        LightArgs { shading, ..lit }
            .light(&mut scene, false, false, Up::Y)
            .unwrap();
        assert!(scene.warnings.is_empty());
    }

    #[test]
    fn values_are_checked() {
        assert!(factor("-1").is_err() && factor("nan").is_err() && factor("1.3") == Ok(1.3));
        assert!(tone_map("filmic").unwrap_err().contains("aces"));
        assert_eq!("x.hdr".parse(), Ok(Env::Picture("x.hdr".into())));
    }
}
