//! Effects at work: what they add to a surface, and the light of one sample under them.

use texmap_light::{
    Light, Power, Ray, Surface as Numbers, Terms, clamp_unit_to_horizon, reflect_across, share,
    unit,
};
use texmap_math::Footprint;
use texmap_math::glam::DVec3;
use texmap_raster::Fragment;

use crate::Settings;
use crate::coordinates::attributes;
use crate::plan::Plan;
use crate::ready::Ready;
use crate::relief::ReliefStage;
use crate::textures::{Chains, Slot};
use crate::vertices::{Values, Vertices};
use texmap_math::color::straight;
use texmap_scene::{LightMapSlot, Material, Mesh, Reflection, Scene};

/// What one surface adds: its maps, and the attributes that they read.
pub(crate) struct SurfaceEffects<'s> {
    material: &'s Material,
    ambient: Option<Slot<'s>>,
    specular: Option<Slot<'s>>,
    exponent: Option<Slot<'s>>,
    reflectivity: Option<Slot<'s>>,
    relief: Option<ReliefStage<'s>>,
    light_map: Option<(&'s LightMapSlot, Slot<'s>)>,
    lightmap_uv: Option<usize>,
    /// Unit normals of the triangles' planes, world space.
    planes: Vec<DVec3>,
    /// What is left to compute: without the lights that are baked.
    lights: Vec<(usize, Light)>,
}

/// One sample of a surface.
pub(crate) struct Sample<'a> {
    pub(crate) fragment: &'a Fragment,
    pub(crate) site: Site,
    /// Change of the interpolated normal, on the side that is seen.
    pub(crate) normal_dx: [f32; 3],
    pub(crate) normal_dy: [f32; 3],
}

/// Where light arrives: what shadows, slides and carvings ask for.
pub(crate) struct Site {
    /// World space, and its change for one pixel to the right and one down.
    pub(crate) position: [f32; 3],
    pub(crate) position_dx: [f32; 3],
    pub(crate) position_dy: [f32; 3],
    /// Normal of the triangle's plane, on the side that is seen.
    pub(crate) plane: DVec3,
}

impl<'a> Sample<'a> {
    /// A fragment of a triangle, its world position and normal from these attributes on.
    pub(crate) fn new(
        fragment: &'a Fragment,
        position: Option<usize>,
        normal: Option<usize>,
        effects: &SurfaceEffects<'_>,
        triangle: u32,
    ) -> Self {
        let of = |values: &[f32], first: Option<usize>| {
            let first = first.unwrap_or(0);
            [values[first], values[first + 1], values[first + 2]]
        };
        let seen = |v: [f32; 3]| if fragment.front { v } else { v.map(|c| -c) };
        Self {
            site: Site {
                position: of(&fragment.values, position),
                position_dx: of(&fragment.ddx, position),
                position_dy: of(&fragment.ddy, position),
                plane: effects.plane(triangle, fragment.front),
            },
            normal_dx: seen(of(&fragment.ddx, normal)),
            normal_dy: seen(of(&fragment.ddy, normal)),
            fragment,
        }
    }
}

impl<'s> SurfaceEffects<'s> {
    /// The effects that a surface lit per pixel is under; `None` if there are none. Asks for the attributes that they read; the
    /// caller sees to uv, normals and positions.
    pub(crate) fn new(
        scene: &'s Scene,
        settings: &Settings,
        chains: &Chains,
        ready: &Ready<'s>,
        mesh: &'s Mesh,
        vertices: &mut Vertices,
    ) -> Option<Box<Self>> {
        let material = &scene.materials[mesh.material];
        if ready.is_plain() && !has_effects(material) {
            return None;
        }
        let slot = |slot| Slot::new(slot, scene, settings, chains, mesh.uv_origin);
        let maps = &material.maps;
        let relief = material.relief.as_ref();
        let relief = relief.map(|r| ReliefStage::new(r, mesh, vertices, slot));
        let light_map = material.light_map.as_ref();
        let lightmap_uv = light_map.map(|_| vertices.push(Values::LightMapUv, false));
        let baked = |index: usize| match light_map.map(|map| &map.baked) {
            None => false,
            Some(None) => index < scene.lights.len(),
            Some(Some(all)) => all.contains(&index),
        };
        Some(Box::new(Self {
            material,
            ambient: maps.ambient.as_ref().map(slot),
            specular: maps.specular.as_ref().map(slot),
            exponent: maps.exponent.as_ref().map(slot),
            reflectivity: maps.reflectivity.as_ref().map(slot),
            relief,
            light_map: light_map.map(|map| (map, slot(&map.slot))),
            lightmap_uv,
            planes: mesh.triangle_normals(),
            lights: ready
                .lights
                .iter()
                .copied()
                .enumerate()
                .filter(|(i, _)| !baked(*i))
                .collect(),
        }))
    }

    /// The textures that stand for numbers of the surface: ambient colour, specular colour, exponent, reflectivity.
    pub(crate) fn maps(&self) -> [Option<&Slot<'s>>; 4] {
        [
            self.ambient.as_ref(),
            self.specular.as_ref(),
            self.exponent.as_ref(),
            self.reflectivity.as_ref(),
        ]
    }

    /// The environment that gives highlights.
    pub(crate) fn specular_map(&self) -> Option<usize> {
        self.material.specular_map
    }

    /// Baked light: its texels' share of the diffuse light, where they are read, and the first attribute of the coordinates.
    pub(crate) fn baked(&self) -> Option<(f32, &Slot<'s>, usize)> {
        let (map, slot) = self.light_map.as_ref()?;
        Some((
            self.material.surface.kd * map.scale,
            slot,
            self.lightmap_uv?,
        ))
    }

    /// What turns its normals.
    pub(crate) fn relief_stage(&self) -> Option<&ReliefStage<'s>> {
        self.relief.as_ref()
    }

    /// The mirrored environment, and the share of its light.
    pub(crate) fn reflection(&self) -> Option<(usize, f32)> {
        let reflection = self.material.reflection?;
        Some((reflection.environment, reflection.reflectivity))
    }

    /// The lights that are not baked, by their number.
    pub(crate) fn lights(&self) -> &[(usize, Light)] {
        &self.lights
    }

    /// Whether anything asks where a sample lies. (A mirror asks for the direction to the eye alone.)
    pub(crate) fn reads_positions(&self, ready: &Ready<'_>) -> bool {
        let mut lights = self.lights.iter();
        self.relief.is_some()
            || !ready.paints.is_empty()
            || lights.any(|(_, light)| !matches!(light, Light::Ambient { .. }))
    }

    /// Normal of a triangle's plane on the side that is seen.
    pub(crate) fn plane(&self, triangle: u32, front: bool) -> DVec3 {
        let plane = self.planes[triangle as usize];
        if front { plane } else { -plane }
    }

    /// The light of a sample and the paint on it (premultiplied). `normal` is the interpolated one on the side that is seen, `uv`
    /// what the mesh's first coordinates are there.
    pub(crate) fn shade(
        &self,
        plan: &Plan<'_>,
        at: &Sample<'_>,
        normal: [f32; 3],
        uv: ([f32; 2], Footprint),
    ) -> (Terms, [f32; 4]) {
        let ready = &plan.ready;
        let view = [0, 1, 2].map(|i| plan.eye[i] - at.site.position[i]);
        let smooth = normal;
        let normal = self.relief(at, normal, view, uv);
        let mut numbers = self.material.surface;
        if let Some(slot) = &self.exponent {
            numbers.ns *= straight(slot.texel(uv.0, uv.1))[0];
        }
        let ambient = self
            .ambient
            .as_ref()
            .map(|slot| straight(slot.texel(uv.0, uv.1)));
        let (mut terms, own) = self.direct(ready, &numbers, ambient, at, normal, unit(view));
        if let (Some((map, slot)), Some(first)) = (&self.light_map, self.lightmap_uv) {
            let (uv, d) = attributes(at.fragment, first);
            for (sum, c) in terms.diffuse.iter_mut().zip(straight(slot.texel(uv, d))) {
                *sum += numbers.kd * map.scale * c;
            }
        }
        if let Some(slot) = &self.specular {
            let tint = straight(slot.texel(uv.0, uv.1));
            terms.highlight = [0, 1, 2].map(|i| terms.highlight[i] * tint[i]);
        }
        terms.highlight = [0, 1, 2].map(|i| terms.highlight[i] + own[i]);
        self.mirror(plan, at, smooth, normal, uv, numbers.ks, &mut terms);
        (terms, ready.paint(&at.site))
    }

    /// The light of all lights, and the ambient light of an ambient map: a colour of its own, which multiplies neither the base colour nor
    /// that of the highlight.
    fn direct(
        &self,
        ready: &Ready<'_>,
        numbers: &Numbers,
        ambient: Option<[f32; 3]>,
        at: &Sample<'_>,
        normal: [f32; 3],
        view: [f32; 3],
    ) -> (Terms, [f32; 3]) {
        let power = Power::new(numbers.ns);
        let (mut sum, mut own) = (Terms::default(), [0.0; 3]);
        for (index, light) in &self.lights {
            let model = self.material.highlight;
            let Some(given) = share(numbers, power, model, light, at.site.position, normal, view)
            else {
                continue;
            };
            match (light, ambient) {
                (Light::Ambient { color }, Some(texel)) => {
                    for i in 0..3 {
                        own[i] += color[i] * given.diffuse * texel[i];
                    }
                }
                (Light::Ambient { .. }, None) => sum.add(&given, [1.0; 3]),
                _ => sum.add(&given, ready.received(*index, &at.site)),
            }
        }
        (sum, own)
    }

    fn mirror(
        &self,
        plan: &Plan<'_>,
        at: &Sample<'_>,
        smooth: [f32; 3],
        normal: [f32; 3],
        uv: ([f32; 2], Footprint),
        ks: f32,
        terms: &mut Terms,
    ) {
        if self.material.reflection.is_none() && self.material.specular_map.is_none() {
            return;
        }
        // A relief turns the normal, but its bends are left to its own texels.
        let view = Ray {
            direction: plan.rays.at(at.fragment.pixel),
            dx: plan.rays.dx,
            dy: plan.rays.dy,
        };
        let normal = Ray {
            direction: normal,
            dx: at.normal_dx,
            dy: at.normal_dy,
        };
        let mirrored = reflect_across(&view, &normal, length(smooth));
        if let Some(Reflection {
            environment,
            reflectivity,
        }) = self.material.reflection
        {
            let share = reflectivity
                * self
                    .reflectivity
                    .as_ref()
                    .map_or(1.0, |slot| straight(slot.texel(uv.0, uv.1))[0]);
            let light = plan.ready.environments[environment].light_across(&mirrored);
            for (sum, c) in terms.highlight.iter_mut().zip(light) {
                *sum += share * c;
            }
        }
        if let Some(map) = self.material.specular_map {
            let light = plan.ready.environments[map].light_across(&mirrored);
            for (sum, c) in terms.highlight.iter_mut().zip(light) {
                *sum += ks * c;
            }
        }
    }

    /// The unit normal that the relief leaves, never turned away from the eye unless the material asks for that.
    fn relief(
        &self,
        at: &Sample<'_>,
        normal: [f32; 3],
        view: [f32; 3],
        uv: ([f32; 2], Footprint),
    ) -> [f32; 3] {
        let Some(relief) = &self.relief else {
            return unit(normal);
        };
        let turned = relief.normal(at, normal, uv);
        if self.material.horizon_clamp {
            clamp_unit_to_horizon(turned, unit(view))
        } else {
            turned
        }
    }
}

/// Whether a material lit per pixel needs more than plain lights.
fn has_effects(material: &Material) -> bool {
    let maps = &material.maps;
    material.relief.is_some()
        || material.light_map.is_some()
        || material.reflection.is_some()
        || material.specular_map.is_some()
        || material.highlight != texmap_light::Highlight::Phong
        || [&maps.ambient, &maps.specular, &maps.exponent]
            .into_iter()
            .any(Option::is_some)
}

fn length(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}
