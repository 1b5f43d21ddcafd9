//! Metallic-roughness surfaces in f64: their numbers by maps, and the light that they return.
//!
//! Lights go by the BRDF of [`texmap_light::reference::metallic_roughness`]. The environment light is taken as its levels are: light that
//! is even within each lobe: two look-ups for the base (all light, and that at grazing incidence), up to four for its lobe (`ReflectionLobes`) and one for the clear layer (Karis 2013).

use std::sync::OnceLock;

use texmap_light::lanes::{ClearcoatLanes, SheenLanes};
use texmap_light::reference::metallic_roughness::{Gathered, GgxAlbedo, Reflectance, SheenAlbedo};
use texmap_light::{
    EnvironmentLight, EnvironmentSample, LEAST_SAMPLE_COSINE, Light, MIN_ROUGHNESS,
    MetallicRoughnessSurface, ReflectionLobes,
};
use texmap_math::glam::DVec3;
use texmap_scene::{AlphaMode, Mesh, MetallicRoughness, ProjectorMode, TextureSlot};

use super::color::wide;
use super::lighting::{Point, arriving};
use super::slot::{Slot, Textures};
use super::surface::Surface;
use super::world::World;

/// Least cosine between normal and eye; normals that look away count as seen at that.
const GRAZING: f64 = 1e-4;
/// Steps of roughness between which albedos are interpolated.
const STEPS: usize = 64;

/// The albedos of lobes, each computed when a surface first has its roughness.
pub(super) struct Albedos {
    ggx: [OnceLock<GgxAlbedo>; STEPS + 1],
    sheen: [OnceLock<SheenAlbedo>; STEPS + 1],
}

impl Default for Albedos {
    fn default() -> Self {
        Self {
            ggx: [const { OnceLock::new() }; STEPS + 1],
            sheen: [const { OnceLock::new() }; STEPS + 1],
        }
    }
}

impl Albedos {
    fn ggx(&self, roughness: f32) -> GgxAlbedo {
        let ([low, high], part) = around(&self.ggx, roughness, GgxAlbedo::new);
        low.mix(high, part)
    }

    fn sheen(&self, roughness: f32) -> SheenAlbedo {
        let ([low, high], part) = around(&self.sheen, roughness, SheenAlbedo::new);
        low.mix(high, part)
    }
}

/// The albedos at the steps below and above a roughness, and the part of the way from one to the other.
fn around<T>(
    made: &[OnceLock<T>; STEPS + 1],
    roughness: f32,
    new: impl Fn(f32) -> T,
) -> ([&T; 2], f64) {
    let at = f64::from(roughness.clamp(0.0, 1.0)) * STEPS as f64;
    let low = (at as usize).min(STEPS - 1);
    let step = |k: usize| made[k].get_or_init(|| new(k as f32 / STEPS as f32));
    ([step(low), step(low + 1)], at - low as f64)
}

/// A metallic-roughness model on a mesh, with its maps.
pub(super) struct Metal<'s> {
    model: &'s MetallicRoughness,
    map: Option<Slot<'s>>,
    occlusion: Option<(Slot<'s>, f64)>,
    specular: Option<Slot<'s>>,
    specular_color: Option<Slot<'s>>,
    coat: [Option<Slot<'s>>; 2],
    sheen: [Option<Slot<'s>>; 2],
    transmission: Option<Slot<'s>>,
}

impl<'s> Metal<'s> {
    pub(super) fn new(
        model: &'s MetallicRoughness,
        mesh: &Mesh,
        textures: &mut Textures<'s>,
    ) -> Self {
        let mut slot = |slot: &'s TextureSlot| textures.slot(slot, mesh.uv_origin);
        let coat = model.clearcoat.as_ref();
        let sheen = model.sheen.as_ref();
        let sheet = model.transmission.as_ref();
        Self {
            model,
            map: model.map.as_ref().map(&mut slot),
            occlusion: model
                .occlusion
                .as_ref()
                .map(|(map, strength)| (slot(map), f64::from(*strength))),
            specular: model.specular_map.as_ref().map(&mut slot),
            specular_color: model.specular_color_map.as_ref().map(&mut slot),
            coat: [
                coat.and_then(|coat| coat.map.as_ref()).map(&mut slot),
                coat.and_then(|coat| coat.roughness_map.as_ref())
                    .map(&mut slot),
            ],
            sheen: [
                sheen
                    .and_then(|sheen| sheen.color_map.as_ref())
                    .map(&mut slot),
                sheen
                    .and_then(|sheen| sheen.roughness_map.as_ref())
                    .map(&mut slot),
            ],
            transmission: sheet.and_then(|sheet| sheet.map.as_ref()).map(&mut slot),
        }
    }

    /// The surface at a point, and the fraction of indirect light that reaches it. Light passes it where it is `blended`.
    fn surface(
        &self,
        at: &Point,
        base_color: DVec3,
        blended: bool,
    ) -> (MetallicRoughnessSurface, f64) {
        let model = self.model;
        let color = |slot: &Option<Slot<'_>>| {
            slot.as_ref()
                .map_or(DVec3::ONE, |slot| slot.straight(at.read(slot)))
        };
        let alpha = |slot: &Option<Slot<'_>>| {
            slot.as_ref()
                .map_or(1.0, |slot| slot.texel(at.read(slot)).w)
        };
        let both = color(&self.map);
        let specular = f64::from(model.specular) * alpha(&self.specular);
        let root = f64::from((model.ior - 1.0) / (model.ior + 1.0));
        let f0 = wide(model.specular_color) * root * root * color(&self.specular_color);
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let surface = MetallicRoughnessSurface {
            base_color: narrow(base_color),
            metallic: (f64::from(model.metallic) * both.z) as f32,
            roughness: (f64::from(model.roughness) * both.y) as f32,
            f0: narrow(f0.min(DVec3::ONE) * specular),
            f90: specular as f32,
            transmission: model
                .transmission
                .as_ref()
                .filter(|_| blended)
                .map(|sheet| (f64::from(sheet.factor) * color(&self.transmission).x) as f32),
            clearcoat: model.clearcoat.as_ref().map(|coat| ClearcoatLanes {
                factor: (f64::from(coat.factor) * color(&self.coat[0]).x) as f32,
                roughness: (f64::from(coat.roughness) * color(&self.coat[1]).y) as f32,
            }),
            sheen: model.sheen.as_ref().map(|sheen| SheenLanes {
                color: narrow(wide(sheen.color) * color(&self.sheen[0])),
                roughness: (f64::from(sheen.roughness) * alpha(&self.sheen[1])) as f32,
            }),
        };
        let share = self.occlusion.as_ref().map_or(1.0, |(slot, strength)| {
            1.0 + (slot.straight(at.read(slot)).x - 1.0) * strength
        });
        (surface, share)
    }

    /// The light that a point returns, not clipped, and the fraction of the light from behind that passes it.
    pub(super) fn light(
        &self,
        world: &World<'_>,
        surface: &Surface<'_>,
        at: &Point,
        base_color: DVec3,
    ) -> (DVec3, f64) {
        let material = surface.material();
        let blended = material.alpha == AlphaMode::Blend;
        let (numbers, share) = self.surface(at, base_color, blended);
        let albedos = &world.albedos;
        let reflectance = Reflectance::of_albedos(
            &numbers,
            albedos.ggx(numbers.roughness),
            numbers.clearcoat.map(|coat| albedos.ggx(coat.roughness)),
            numbers.sheen.map(|sheen| albedos.sheen(sheen.roughness)),
        );
        let (normal, smooth) = (surface.turned_normal(at), at.normal.normalize_or_zero());
        let eye = at.view.direction.normalize_or_zero();
        let lift = (GRAZING - normal.dot(eye)).max(0.0);
        let view = (eye + normal * lift).normalize_or_zero();
        let cosines = (normal.dot(view), smooth.dot(view).max(GRAZING));
        let mut sum = DVec3::ZERO;
        if let Some(light) = &world.scene.effects.environment_light {
            let mut visible = [share; 3];
            if !world.environment_shadows.0.is_empty() {
                let seen = environment_visible(world, at, |sample| {
                    reflectance.sample_weights((normal, smooth, view), cosines, sample)
                });
                visible = seen.map(|seen| seen.min(share));
            }
            sum += under_environment(
                &reflectance,
                &numbers,
                light,
                (normal, smooth, eye),
                cosines,
                visible,
            );
        }
        if let (Some(map), Some(slot)) = (&material.light_map, &surface.light_map) {
            let light = slot.straight(at.baked_place) * f64::from(map.scale);
            sum += reflectance.under_irradiance(cosines, light);
        }
        // `pi f (N.L)`: a light of 1 leaves a white diffuse surface as 1.
        let returned = |toward: DVec3| {
            let facing = normal.dot(toward);
            let brdf = reflectance.brdf(normal, smooth, view, toward);
            brdf * (std::f64::consts::PI * facing.max(0.0))
        };
        for (index, light) in world.scene.lights.iter().enumerate() {
            if material.bakes(index) {
                continue;
            }
            if let Light::Ambient { color } = *light {
                let color = wide(color);
                sum += reflectance.under_gathered(cosines, &Gathered::even(color)) * share;
                continue;
            }
            let (color, toward) = arriving(light, at.position);
            let part = returned(toward) * color;
            if part != DVec3::ZERO && world.light_reaches(index, at) {
                sum += part;
            }
        }
        for (index, cast) in world.projectors.iter().enumerate() {
            let ProjectorMode::Light(color) = cast.projector.mode else {
                continue;
            };
            let toward = (cast.projector.position - at.position).normalize_or_zero();
            let part = returned(toward) * wide(color);
            let picture = cast.texel(at.position, at.moves).truncate();
            if part * picture != DVec3::ZERO && world.projector_reaches(index, at) {
                sum += part * picture;
            }
        }
        (sum, reflectance.transmitted(cosines))
    }
}

/// Fractions of the light of an environment that reach a point, by the weights of samples in the lobes of its surface.
fn environment_visible(
    world: &World<'_>,
    at: &Point,
    weights: impl Fn(&EnvironmentSample) -> [f64; 3],
) -> [f64; 3] {
    let (maps, bias) = &world.environment_shadows;
    let (mut reached, mut all) = ([0.0; 3], [0.0; 3]);
    for (sample, map) in maps {
        if at.plane.dot(wide(sample.direction)) <= LEAST_SAMPLE_COSINE.into() {
            continue;
        }
        let visibility = f64::from(map.visibility(at.position, at.plane, *bias, 1));
        for (k, weight) in weights(sample).into_iter().enumerate() {
            reached[k] += weight * visibility;
            all[k] += weight;
        }
    }
    [0, 1, 2].map(|k| match all[k] > 0.0 {
        true => reached[k] / all[k],
        false => 1.0,
    })
}

/// The light of an environment: level by level as it was gathered.
fn under_environment(
    reflectance: &Reflectance,
    numbers: &MetallicRoughnessSurface,
    light: &EnvironmentLight,
    (normal, smooth, view): (DVec3, DVec3, DVec3),
    cosines: (f64, f64),
    [of_base, of_lobe, of_coat]: [f64; 3],
) -> DVec3 {
    let narrow = |v: DVec3| v.as_vec3().to_array();
    let mirrored = |n: DVec3| 2.0 * n.dot(view) * n - view;
    let roughness = numbers.roughness.max(MIN_ROUGHNESS);
    let irradiance = wide(light.irradiance(narrow(normal)));
    let grazing = wide(light.grazing(narrow(normal)));
    let seen = ReflectionLobes::new(roughness, normal.dot(view) as f32);
    let mut glossy = irradiance * f64::from(seen.diffuse);
    for lobe in seen.lobes {
        let axis = mirrored(normal).lerp(normal, lobe.lean.into());
        glossy += wide(light.radiance(lobe.roughness, narrow(axis))) * f64::from(lobe.weight);
    }
    let coating = numbers.clearcoat.map_or(glossy, |coat| {
        let roughness = coat.roughness.max(MIN_ROUGHNESS);
        wide(light.radiance(roughness, narrow(mirrored(smooth))))
    });
    let light = Gathered {
        irradiance: irradiance * of_base,
        grazing: grazing * of_base,
        glossy: glossy * of_lobe,
        coating: coating * of_coat,
    };
    reflectance.under_gathered(cosines, &light)
}
