//! The light on surfaces, and its way to display light.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use texmap_bake::GroundShadow;
use texmap_io::framing::{
    Up, auto_lights, dim_bright_lights, light_dark_surfaces, light_model, metallic_surfaces,
    renew_studio, studio,
};
use texmap_light::{EnvironmentLayout, EnvironmentLight, Prefilter, Roughnesses, ToneMap};
use texmap_math::camera::Camera;
use texmap_scene::{Background, ColorMode, Material, Mesh, Scene};

use crate::failure::{Failure, Refusal};

/// Light from all around, the model of surfaces, exposure and tone mapping.
#[derive(Args, Debug)]
#[command(next_help_heading = "Light")]
pub(crate) struct LightArgs {
    /// The model of surfaces: metallic-roughness (the exponent of an MTL becomes a roughness) or classic, the model of Phong
    /// [default: metallic-roughness for models, classic for scenes and under --max-error and --quality]
    #[arg(long, value_name = "MODEL")]
    shading: Option<Model>,
    /// Light from all around on metallic-roughness surfaces: a lat-long picture (.hdr, .exr, ...; its top is +Y, its middle -Z and
    /// what is right of that +X), the neutral studio, or none [default: neutral for models]
    #[arg(long, value_name = "FILE|neutral|none")]
    env: Option<Env>,
    /// Turn that light about the axis that points up, counter-clockwise from above
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = degrees)]
    env_rotate: Option<f64>,
    /// Shadows and dark corners under that light, from as many of its directions: 64 are smooth, 256 the most
    #[arg(long, value_name = "DIRECTIONS", default_value_t = 0, hide_default_value = true, value_parser = clap::value_parser!(u32).range(0..=256))]
    env_shadows: u32,
    /// Draw the shadow of a model on the ground under its lowest point: what it hides of the light from all around and of directional
    /// lights. Also on --background transparent
    #[arg(long)]
    pub(crate) ground_shadow: bool,
    /// Factor of light before tone mapping [default: 1, with lights of models dimmed that are in lumens]
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    exposure: Option<f32>,
    /// The way of bright light to display light: pbr-neutral, aces, agx, none (clipped at 1), unclipped [default: pbr-neutral under
    /// light from all around and for pictures of 8 or 16 bits, none otherwise; none clips nothing of HDR and EXR pictures]
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

/// Properties of an input and its pictures that decide its light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lit {
    /// It is a scene file, which has the light that it says.
    pub(crate) scene_file: bool,
    /// It is written as light without an upper end, which no curve bends unless one is asked for.
    pub(crate) floats: bool,
    /// The environment is shown behind it.
    pub(crate) behind: bool,
    /// The axis that points up.
    pub(crate) up: Up,
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

    /// Gives surfaces their model, which is metallic-roughness unless one is asked for. Raw colours are no light and stay as they are,
    /// and `kept` keeps what the files say: of a scene file, and where a plan is asked, which knows the classic model.
    pub(crate) fn shade(&self, scene: &mut Scene, kept: bool) {
        let metallic = match self.shading {
            Some(model) => model == Model::MetallicRoughness,
            None if kept => return,
            None => scene.color == ColorMode::Srgb,
        };
        if metallic {
            metallic_surfaces(scene);
        } else if self.shading.is_some() {
            scene.warnings.extend(not_classic(&scene.materials));
            for material in &mut scene.materials {
                material.metallic_roughness = None;
            }
            scene.effects.environment_light = None;
            scene.effects.tone_mapping.map = ToneMap::None;
        }
    }

    /// The roughnesses that are read beside those of surfaces.
    fn further(&self) -> Roughnesses {
        match self.ground_shadow {
            true => GroundShadow::roughnesses(),
            false => Roughnesses::NONE,
        }
    }

    /// Lights a scene, after it was dressed.
    pub(crate) fn light(&self, scene: &mut Scene, lit: &Lit) -> Result<(), Failure> {
        let Lit {
            scene_file,
            floats,
            behind,
            up,
        } = *lit;
        match &self.env {
            None => {
                if !scene_file {
                    light_model(scene, up, behind);
                }
            }
            Some(Env::None) => {
                scene.effects.environment_light = None;
                scene.effects.tone_mapping.map = ToneMap::None;
            }
            Some(env) => {
                let wanted = scene.roughnesses() | self.further();
                scene.effects.environment_light = Some(environment(env, up, wanted)?);
                scene.effects.tone_mapping.map = ToneMap::PbrNeutral;
                if !scene.reads_environment() && !behind {
                    let warning = "--env: no surface is metallic-roughness, so that nothing shows its light; --shading metallic-roughness makes all of them so";
                    scene.warnings.push(warning.to_owned());
                } else if !scene_file
                    && scene.reads_environment()
                    && scene.lights == auto_lights(up)
                {
                    scene.lights.clear();
                }
            }
        }
        scene.effects.environment_shadows = self.env_shadows;
        let some = scene.effects.environment_light.is_some() && scene.reads_environment();
        if self.env_shadows > 0 && !some {
            let warning = "--env-shadows: light from all around reaches no surface, so that none is kept away";
            scene.warnings.push(warning.to_owned());
        }
        // Surfaces that were changed since the model was read, and the ground.
        renew_studio(scene, self.further());
        match (self.env_rotate, &scene.effects.environment_light) {
            (Some(angle), Some(light)) => {
                let turned = light.clone().turned(angle.to_radians());
                scene.effects.environment_light = Some(turned);
            }
            (Some(_), None) => {
                let warning = "--env-rotate: there is no light from all around to turn; give it with --env FILE, or --env neutral";
                scene.warnings.push(warning.to_owned());
            }
            (None, _) => {}
        }
        match self.exposure {
            Some(exposure) => scene.effects.tone_mapping.exposure = exposure,
            None if !scene_file => dim_bright_lights(scene),
            None => {}
        }
        match self.tone_map {
            // Floats hold all light.
            None | Some(ToneMap::None) if floats => {
                scene.effects.tone_mapping.map = ToneMap::Unclipped;
            }
            Some(map) => scene.effects.tone_mapping.map = map,
            None => {}
        }
        if behind {
            if scene.effects.environment_light.is_none() {
                return Err(Failure::usage(
                    "--background env: there is no light from all around to show",
                    "give it with --env FILE, or --env neutral",
                ));
            }
            scene.effects.background = Some(Background::EnvironmentLight);
        }
        if !scene_file {
            light_dark_surfaces(scene, up);
        }
        Ok(())
    }
}

/// Adds the shadow on the ground. The cameras are set: they frame the model alone.
pub(crate) fn add_ground(scene: &mut Scene, up: Up) -> Result<(), Refusal> {
    let shaped = texmap_mesh::tessellate(&*scene, 256)?;
    let shadow = GroundShadow::new(&shaped, up.direction())?;
    drop(shaped);
    if let Some(shadow) = shadow {
        shadow.add_to(scene);
    }
    Ok(())
}

/// Moves the planes of a parallel camera, and its eye back along its rays, so that they do not cut what casts no shadow: the ground.
/// Perspective cameras have no far plane.
pub(crate) fn hold_ground(scene: &Scene, camera: &mut Camera) {
    if camera.lens.parallel_width.is_none() {
        return;
    }
    let along = (camera.look - camera.eye).normalize_or_zero();
    let ground = scene.meshes.iter().filter(|mesh| mesh.casts_no_shadow);
    let depths = ground
        .flat_map(Mesh::world_positions)
        .map(|p| (p - camera.eye).dot(along));
    let (near, far) = depths.fold((camera.near, camera.far), |(near, far), depth| {
        (near.min(depth), far.max(depth))
    });
    let air = 1e-3 * (far - near);
    let back = match near < camera.near {
        true => camera.near - near + air,
        false => 0.0,
    };
    camera.eye -= along * back;
    camera.far = back + if far > camera.far { far + air } else { far };
}

/// The warning on properties of metallic-roughness surfaces that Phong's model does not draw.
fn not_classic(materials: &[Material]) -> Option<String> {
    let models = materials
        .iter()
        .filter_map(|m| m.metallic_roughness.as_ref());
    let count = models
        .filter(|m| {
            m.metallic > 0.0 || m.map.is_some() || m.clearcoat.is_some() || m.sheen.is_some()
        })
        .count();
    (count > 0).then(|| {
        let materials = match count {
            1 => "1 material has",
            _ => &format!("{count} materials have"),
        };
        format!(
            "--shading classic: {materials} metalness, maps of it, a clear coat or sheen, which the model of Phong does not draw"
        )
    })
}

fn environment(env: &Env, up: Up, wanted: Roughnesses) -> Result<EnvironmentLight, Failure> {
    let Env::Picture(path) = env else {
        return Ok(studio(up, wanted));
    };
    let picture = texmap_io::read_environment(path, EnvironmentLayout::LatLong)?;
    // As many texels around as the picture has.
    let size = (picture.size().0 / 4).clamp(16, 1024);
    let light = Prefilter::new(&picture, size).and_then(|mut made| made.light(wanted));
    let light = light.map_err(|e| {
        Failure::usage(
            format!("--env {}: {e}", path.display()),
            "give a picture of all directions, twice as wide as high",
        )
    })?;
    Ok(match up {
        Up::Y => light,
        Up::Z => light.upright_on_z(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_scene::{Mesh, MetallicRoughness};

    fn args() -> LightArgs {
        LightArgs {
            env_shadows: 0,
            shading: None,
            env: None,
            env_rotate: None,
            ground_shadow: false,
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

    fn drawn(args: &LightArgs, mut scene: Scene, scene_file: bool, floats: bool) -> Scene {
        args.shade(&mut scene, scene_file);
        let lit = Lit {
            scene_file,
            floats,
            behind: false,
            up: Up::Y,
        };
        args.light(&mut scene, &lit).unwrap();
        scene
    }

    #[test]
    fn models_are_metallic_roughness_unless_they_are_raw_or_asked_to_be_classic() {
        let modern = drawn(&args(), model(), false, false);
        assert!(modern.materials[0].metallic_roughness.is_some() && modern.lights.is_empty());
        assert!(modern.effects.environment_light.is_some());
        assert_eq!(modern.effects.tone_mapping.map, ToneMap::PbrNeutral);
        let floats = drawn(&args(), model(), false, true);
        assert_eq!(floats.effects.tone_mapping.map, ToneMap::Unclipped);
        let classic = LightArgs {
            shading: Some(Model::Classic),
            ..args()
        };
        let raw = Scene {
            color: ColorMode::Raw,
            ..model()
        };
        for classic in [
            drawn(&classic, modern, false, false),
            drawn(&classic, model(), false, false),
            drawn(&args(), raw, false, false),
        ] {
            assert_eq!(classic.lights, auto_lights(Up::Y));
            assert!(classic.materials[0].metallic_roughness.is_none());
            assert!(classic.effects.environment_light.is_none());
            assert_eq!(classic.effects.tone_mapping.map, ToneMap::None);
            assert!(classic.warnings.is_empty());
        }
        // A scene keeps its model and its darkness.
        let mut dark = model();
        dark.lights.clear();
        let dark = drawn(&args(), dark, true, false);
        assert!(dark.lights.is_empty() && dark.materials[0].metallic_roughness.is_none());
    }

    #[test]
    fn classic_tells_once_what_it_does_not_draw() {
        let classic = LightArgs {
            shading: Some(Model::Classic),
            ..args()
        };
        let mut scene = model();
        let metal = MetallicRoughness {
            metallic: 1.0,
            ..MetallicRoughness::default()
        };
        scene.materials[0].metallic_roughness = Some(metal);
        scene.materials.push(scene.materials[0].clone());
        let scene = drawn(&classic, scene, false, false);
        assert_eq!(scene.warnings.len(), 1);
        assert!(scene.warnings[0].contains("2 materials"));
    }

    #[test]
    fn an_environment_that_nothing_shows_is_told() {
        let lit = LightArgs {
            env: Some(Env::Neutral),
            ..args()
        };
        assert_eq!(drawn(&lit, model(), true, false).warnings.len(), 1);
        let told = drawn(&lit, model(), false, false);
        assert!(told.warnings.is_empty() && told.lights.is_empty());
        // Without it a model has the lights of the loader.
        let none = LightArgs {
            env: Some(Env::None),
            ..args()
        };
        assert_eq!(
            drawn(&none, model(), false, false).lights,
            auto_lights(Up::Y)
        );
    }

    #[test]
    fn the_environment_behind_is_that_of_the_light() {
        let lit = |scene_file| Lit {
            scene_file,
            floats: false,
            behind: true,
            up: Up::Y,
        };
        let mut scene = model();
        args().light(&mut scene, &lit(false)).unwrap();
        assert_eq!(scene.effects.background, Some(Background::EnvironmentLight));
        scene.check().unwrap();
        // A scene file has none of its own.
        assert!(args().light(&mut model(), &lit(true)).is_err());
        let neutral = LightArgs {
            env: Some(Env::Neutral),
            ..args()
        };
        let mut scene = model();
        neutral.light(&mut scene, &lit(true)).unwrap();
        assert!(scene.warnings.is_empty());
        scene.effects.environment_light = None;
        assert!(scene.check().is_err());
    }

    #[test]
    fn values_are_checked() {
        assert!(factor("-1").is_err() && factor("nan").is_err() && factor("1.3") == Ok(1.3));
        assert!(tone_map("filmic").unwrap_err().contains("aces"));
        assert_eq!("x.hdr".parse(), Ok(Env::Picture("x.hdr".into())));
    }
}
