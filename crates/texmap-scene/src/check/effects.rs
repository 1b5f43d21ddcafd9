//! Checks of effects, before the first pixel.

use texmap_light::{Light, ReflectionBox, ShadowBias};
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::Pattern;

use crate::check::{finite, index, unit_range};
use crate::shadow_fit::{encloses, shadow_kind};
use crate::{
    Background, Effects, Material, NormalDetail, ProceduralHeight, ProjectorLight, ProjectorMode,
    Scene, SceneError, Shading, Shadow, SolidTextureSource, Volume,
};

/// Parts of a material that only surfaces lit per pixel read.
fn read_per_pixel(material: &Material) -> Vec<&'static str> {
    let maps = &material.maps;
    let has = [
        (material.normal_detail.is_some(), "bump or normal map"),
        (material.light_map.is_some(), "light map"),
        (material.reflection.is_some(), "mirrored environment"),
        (maps.ambient.is_some(), "ambient map"),
        (maps.specular.is_some(), "specular colour map"),
        (maps.exponent.is_some(), "exponent map"),
    ];
    has.into_iter()
        .filter_map(|(has, name)| has.then_some(name))
        .collect()
}

/// Most texels a side of a shadow map.
const MOST: u32 = 16_384;

impl Scene {
    pub(crate) fn check_material_effects(&self, material: &Material) -> Result<(), SceneError> {
        let place = || format!("material '{}'", material.name);
        let environments = self.effects.environments.len();
        if let Some(solid) = &material.solid {
            if let SolidTextureSource::Grid { grid, .. } = solid.source {
                index(place, "grid", grid as u64, self.effects.grids.len())?;
            }
            if !has_volume(&solid.world_from_solid) {
                return Err(SceneError::Value {
                    place: place(),
                    what: "placement of the solid texture".to_owned(),
                    value: solid.world_from_solid.to_string(),
                    expected: "it must be finite, and no side 0",
                });
            }
            if let SolidTextureSource::Pattern(
                Pattern::Marble { turbulence: x, .. } | Pattern::Wood { grain: x },
            ) = solid.source
            {
                finite(place, || "fold of the solid texture".to_owned(), &[x])?;
            }
        }
        if let Some(map) = material.specular_map {
            index(place, "specular map", map as u64, environments)?;
        }
        if let Some(reflection) = &material.reflection {
            index(
                place,
                "environment",
                reflection.environment as u64,
                environments,
            )?;
            unit_range(place, "reflectivity", &[reflection.reflectivity])?;
            if let Some(walls) = &reflection.within {
                check_box(place, walls)?;
            }
        }
        match &material.normal_detail {
            Some(NormalDetail::Bump { height, .. }) => {
                finite(place, || "bump height".to_owned(), &[*height])?;
            }
            Some(NormalDetail::Offsets { slope, .. }) => {
                finite(place, || "slope of the offset map".to_owned(), &[*slope])?;
            }
            Some(NormalDetail::Procedural {
                heights,
                world_from_solid,
                height,
            }) => {
                finite(place, || "carved height".to_owned(), &[*height])?;
                let fold = match heights {
                    ProceduralHeight::Pattern(
                        Pattern::Marble { turbulence: x, .. } | Pattern::Wood { grain: x },
                    )
                    | ProceduralHeight::Waves { fold: x, .. } => *x,
                    ProceduralHeight::Pattern(Pattern::Noise { .. }) => 0.0,
                };
                finite(place, || "fold of the carved height".to_owned(), &[fold])?;
                if !has_volume(world_from_solid) {
                    return Err(SceneError::Value {
                        place: place(),
                        what: "placement of the carved height".to_owned(),
                        value: world_from_solid.to_string(),
                        expected: "it must be finite, and no side 0",
                    });
                }
                if matches!(heights, ProceduralHeight::Waves { around: 0, .. }) {
                    return Err(SceneError::Value {
                        place: place(),
                        what: "waves around".to_owned(),
                        value: "0".to_owned(),
                        expected: "it must be 1 or more",
                    });
                }
            }
            Some(NormalDetail::NormalMap { strength, .. }) => {
                finite(
                    place,
                    || "strength of the normal map".to_owned(),
                    &[*strength],
                )?;
            }
            None => {}
        }
        if let Some(emission) = &material.emission
            && !emission.color.iter().all(|c| c.is_finite() && *c >= 0.0)
        {
            return Err(SceneError::Value {
                place: place(),
                what: "emission".to_owned(),
                value: format!("{:?}", emission.color),
                expected: "it must be finite and not negative",
            });
        }
        if let Some(map) = &material.light_map {
            if !(map.scale >= 0.0 && map.scale.is_finite()) {
                return Err(SceneError::Value {
                    place: place(),
                    what: "scale of the light map".to_owned(),
                    value: map.scale.to_string(),
                    expected: "it must be finite and not negative",
                });
            }
            for light in map.baked.iter().flatten() {
                index(place, "baked light", *light as u64, self.lights.len())?;
            }
        }
        Ok(())
    }

    pub(crate) fn check_effects(&self, warnings: &mut Vec<String>) -> Result<(), SceneError> {
        self.check_light_names()?;
        let exposure = self.effects.tone_mapping.exposure;
        if !(exposure.is_finite() && exposure >= 0.0) {
            return Err(SceneError::Value {
                place: "tone mapping".to_owned(),
                what: "exposure".to_owned(),
                value: exposure.to_string(),
                expected: "it must be finite and not negative",
            });
        }
        self.check_roughnesses()?;
        for shadow in &self.effects.shadows {
            self.check_shadow(shadow, warnings)?;
        }
        for (number, volume) in self.effects.volumes.iter().enumerate() {
            volume.check(number, &self.effects)?;
            if let Some(slot) = &volume.transfer {
                self.check_slot(slot, || format!("volume {number}"))?;
            }
        }
        if self.effects.environment_shadows > 256 {
            return Err(SceneError::Value {
                place: "environment light".to_owned(),
                what: "number of samples that cast shadows".to_owned(),
                value: self.effects.environment_shadows.to_string(),
                expected: "it must be 0 to 256",
            });
        }
        match &self.effects.background {
            Some(Background::Picture(slot)) => self.check_slot(slot, || "backdrop".to_owned())?,
            Some(Background::Environment(environment)) => index(
                || "backdrop".to_owned(),
                "environment",
                *environment as u64,
                self.effects.environments.len(),
            )?,
            Some(Background::EnvironmentLight) if self.effects.environment_light.is_none() => {
                return Err(SceneError::Value {
                    place: "backdrop".to_owned(),
                    what: "environment light".to_owned(),
                    value: "none".to_owned(),
                    expected: "the scene must have one to show it",
                });
            }
            Some(Background::EnvironmentLight) | None => {}
        }
        for (number, projector) in self.effects.projectors.iter().enumerate() {
            self.check_projector(number, projector)?;
        }
        for material in &self.materials {
            let unread = read_per_pixel(material);
            if !unread.is_empty() && material.shading != Shading::PerPixel {
                warnings.push(format!(
                    "material '{}' is not lit per pixel: its {} is not drawn",
                    material.name,
                    unread.join(", ")
                ));
            }
        }
        Ok(())
    }

    /// Error if a surface reflects levels of the environment light that were not made.
    fn check_roughnesses(&self) -> Result<(), SceneError> {
        let Some(light) = &self.effects.environment_light else {
            return Ok(());
        };
        let made = light.roughnesses();
        let mut materials = self.materials.iter();
        match materials.find(|material| !made.contains(material.roughnesses())) {
            None => Ok(()),
            Some(material) => Err(SceneError::Value {
                place: format!("material '{}'", material.name),
                what: "roughness".to_owned(),
                value: "not among those that the environment light was made for".to_owned(),
                expected: "make the light for `Scene::roughnesses`, or for all",
            }),
        }
    }

    fn check_shadow(&self, shadow: &Shadow, warnings: &mut Vec<String>) -> Result<(), SceneError> {
        shadow_kind(self, shadow.light, shadow.area)?;
        let value = |what: &str, value: u32, expected| SceneError::Value {
            place: format!("shadow of light {}", shadow.light),
            what: what.to_owned(),
            value: value.to_string(),
            expected,
        };
        if let Some(size) = shadow.size.filter(|size| !(1..=MOST).contains(size)) {
            return Err(value("size", size, "it must be 1 to 16384 texels"));
        }
        if shadow.pcf_size.is_multiple_of(2) || shadow.pcf_size > 15 {
            return Err(value("taps", shadow.pcf_size, "an odd number, 1 to 15"));
        }
        if let Some(
            ShadowBias::Planes(x)
            | ShadowBias::Constant(x)
            | ShadowBias::Slope(x)
            | ShadowBias::NormalOffset(x),
        ) = shadow.bias
        {
            let place = || format!("shadow of light {}", shadow.light);
            finite(place, || "bias".to_owned(), &[x])?;
        }
        if let Light::Point { position, .. }
        | Light::Spot { position, .. }
        | Light::Punctual { position, .. } = self.lights[shadow.light]
        {
            let position = DVec3::from(position.map(f64::from));
            if let Some(mesh) = self.meshes.iter().find(|mesh| encloses(mesh, position)) {
                warnings.push(format!(
                    "light {} stands inside of mesh '{}', which keeps its light from everything outside",
                    shadow.light, mesh.name
                ));
            }
        }
        Ok(())
    }

    fn check_projector(&self, number: usize, projector: &ProjectorLight) -> Result<(), SceneError> {
        let place = || format!("projector {number}");
        index(
            place,
            "texture",
            projector.texture as u64,
            self.textures.len(),
        )?;
        finite(
            place,
            || "position".to_owned(),
            &projector.position.to_array(),
        )?;
        for row in projector.projector.rows() {
            finite(place, || "matrix".to_owned(), &row.to_array())?;
        }
        let value = |what: &str, value: String, expected| SceneError::Value {
            place: place(),
            what: what.to_owned(),
            value,
            expected,
        };
        if !(0.0..=0.5).contains(&projector.softness) {
            return Err(value(
                "softness",
                projector.softness.to_string(),
                "it must be 0 to 0.5",
            ));
        }
        if let ProjectorMode::Light(color) = projector.mode
            && !color.iter().all(|c| c.is_finite() && *c >= 0.0)
        {
            return Err(value(
                "colour",
                format!("{color:?}"),
                "finite and not negative",
            ));
        }
        match projector.shadow.filter(|size| !(1..=MOST).contains(size)) {
            Some(size) => Err(value(
                "shadow size",
                size.to_string(),
                "it must be 1 to 16384 texels",
            )),
            None => Ok(()),
        }
    }
}

impl Volume {
    /// Error if a number or an index of the volume is out of its range.
    fn check(&self, number: usize, effects: &Effects) -> Result<(), SceneError> {
        let place = || format!("volume {number}");
        index(place, "grid", self.grid as u64, effects.grids.len())?;
        if !(self.density.is_finite() && self.density >= 0.0) {
            return Err(fault(number, "density", self.density.to_string()));
        }
        if !(self.step.is_finite() && self.step > 0.0) {
            return Err(fault(number, "step", self.step.to_string()));
        }
        if !has_volume(&self.world_from_volume) {
            let matrix = self.world_from_volume.to_string();
            return Err(fault(number, "placement", matrix));
        }
        Ok(())
    }
}

pub(crate) fn fault(number: usize, what: &str, value: String) -> SceneError {
    SceneError::Value {
        place: format!("volume {number}"),
        what: what.to_owned(),
        value,
        expected: "the density must be finite and not negative, the step finite and above 0, no side of the box 0",
    }
}

fn check_box(place: impl Fn() -> String, walls: &ReflectionBox) -> Result<(), SceneError> {
    let inside = (0..3).all(|k| {
        let (low, high) = (walls.low[k], walls.high[k]);
        low.is_finite() && high.is_finite() && low < walls.center[k] && walls.center[k] < high
    });
    match inside {
        true => Ok(()),
        false => Err(SceneError::Value {
            place: place(),
            what: "box of the reflection".to_owned(),
            value: format!("{walls:?}"),
            expected: "finite corners, the least first, with the point of capture between them",
        }),
    }
}

/// True if a matrix has a finite inverse.
fn has_volume(matrix: &DMat4) -> bool {
    let determinant = matrix.determinant();
    let inverse = matrix.inverse();
    determinant != 0.0
        && determinant.is_finite()
        && inverse.is_finite()
        && inverse.transform_vector3(DVec3::ONE).as_vec3().is_finite()
}
