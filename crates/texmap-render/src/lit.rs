//! Effects at work: what they add to a surface, and the light of one sample under them.

use texmap_light::{
    Light, NormalMap, Power, Ray, Surface as Numbers, Terms, bump_on, clamp_unit_to_horizon,
    decode_offsets, reflect_across, share, unit,
};
use texmap_math::Footprint;
use texmap_math::glam::{DMat3, DVec3};
use texmap_raster::Fragment;
use texmap_sample::Origin;

use crate::canvas::straight;
use crate::carved::Carved;
use crate::effects::{LightMapSlot, Reflection, Relief};
use crate::ready::Ready;
use crate::shade::three;
use crate::textures::{Chains, Slot};
use crate::vertices::{Values, Vertices, flat_normals, linear, narrow, wide};
use crate::{Material, Mesh, Scene, Settings};

/// What one surface adds: its maps, and the attributes that they read.
pub(crate) struct SurfaceEffects<'s> {
    material: &'s Material,
    ambient: Option<Slot<'s>>,
    specular: Option<Slot<'s>>,
    exponent: Option<Slot<'s>>,
    reflectivity: Option<Slot<'s>>,
    relief: Option<(&'s Relief, Slot<'s>)>,
    carved: Option<Carved>,
    /// World units of one unit of the object.
    unit: f32,
    light_map: Option<(&'s LightMapSlot, Slot<'s>)>,
    tangent: Option<usize>,
    lightmap_uv: Option<usize>,
    /// Unit normals of the triangles' planes, world space.
    planes: Vec<DVec3>,
    normal_to_world: DMat3,
    /// What is left to compute: without the lights that are baked.
    lights: Vec<(usize, Light)>,
}

/// One sample of a surface.
pub(crate) struct Sample<'a> {
    pub(crate) fragment: &'a Fragment,
    /// World space, and its change for one pixel to the right and one down.
    pub(crate) position: [f32; 3],
    pub(crate) position_dx: [f32; 3],
    pub(crate) position_dy: [f32; 3],
    /// Change of the interpolated normal, on the side that is seen.
    pub(crate) normal_dx: [f32; 3],
    pub(crate) normal_dy: [f32; 3],
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
            position: of(&fragment.values, position),
            position_dx: of(&fragment.ddx, position),
            position_dy: of(&fragment.ddy, position),
            normal_dx: seen(of(&fragment.ddx, normal)),
            normal_dy: seen(of(&fragment.ddy, normal)),
            plane: effects.plane(triangle, fragment.front),
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
        let relief = material
            .relief
            .as_ref()
            .and_then(|relief| Some((relief, slot(relief.slot()?))));
        let unit = unit_of(mesh);
        let tangents = matches!(
            material.relief,
            Some(Relief::NormalMap {
                object_space: false,
                ..
            })
        );
        let light_map = material.light_map.as_ref();
        let tangent = tangents.then(|| vertices.push(Values::Tangent, false));
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
            carved: material.relief.as_ref().and_then(|r| Carved::new(r, unit)),
            unit: unit as f32,
            light_map: light_map.map(|map| (map, slot(&map.slot))),
            tangent,
            lightmap_uv,
            planes: flat_normals(mesh),
            normal_to_world: linear(mesh.world_from_object).inverse().transpose(),
            lights: ready
                .lights
                .iter()
                .copied()
                .enumerate()
                .filter(|(i, _)| !baked(*i))
                .collect(),
        }))
    }

    /// Whether textures stand for numbers of the surface, or baked light for lights.
    pub(crate) fn has_maps(&self) -> bool {
        let slots = [
            &self.ambient,
            &self.specular,
            &self.exponent,
            &self.reflectivity,
        ];
        slots.into_iter().any(Option::is_some)
            || self.light_map.is_some()
            || self.material.specular_map.is_some()
    }

    /// The normal map, its texture, and the first attribute of its tangents; `None` for another relief, which has no lanes.
    pub(crate) fn relief_lanes(&self) -> Option<Option<(NormalMap, &Slot<'s>, usize)>> {
        match (&self.carved, &self.relief) {
            (None, None) => Some(None),
            (
                None,
                Some((
                    Relief::NormalMap {
                        green,
                        rebuild_z,
                        object_space: false,
                        strength,
                        ..
                    },
                    slot,
                )),
            ) => {
                let map = NormalMap {
                    green: *green,
                    rebuild_z: *rebuild_z,
                    strength: *strength,
                };
                Some(Some((map, slot, self.tangent?)))
            }
            _ => None,
        }
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

    /// Normal of a triangle's plane on the side that is seen.
    pub(crate) fn plane(&self, triangle: u32, front: bool) -> DVec3 {
        let plane = self.planes[triangle as usize];
        if front { plane } else { -plane }
    }

    /// The light of a sample and the paint on it (premultiplied). `normal` is the interpolated one on the side that is seen, `uv`
    /// what the mesh's first coordinates are there.
    pub(crate) fn shade(
        &self,
        ready: &Ready<'_>,
        eye: [f32; 3],
        at: &Sample<'_>,
        normal: [f32; 3],
        uv: ([f32; 2], Footprint),
    ) -> (Terms, [f32; 4]) {
        let view = [0, 1, 2].map(|i| eye[i] - at.position[i]);
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
        let mut terms = self.direct(ready, &numbers, ambient, at, normal, unit(view));
        if let (Some((map, slot)), Some(first)) = (&self.light_map, self.lightmap_uv) {
            let (uv, d) = coordinates(at.fragment, first);
            for (sum, c) in terms.diffuse.iter_mut().zip(straight(slot.texel(uv, d))) {
                *sum += numbers.kd * map.scale * c;
            }
        }
        if let Some(slot) = &self.specular {
            let tint = straight(slot.texel(uv.0, uv.1));
            terms.highlight = [0, 1, 2].map(|i| terms.highlight[i] * tint[i]);
        }
        self.mirror(ready, at, smooth, normal, view, uv, numbers.ks, &mut terms);
        (terms, ready.paint(at))
    }

    fn direct(
        &self,
        ready: &Ready<'_>,
        numbers: &Numbers,
        ambient: Option<[f32; 3]>,
        at: &Sample<'_>,
        normal: [f32; 3],
        view: [f32; 3],
    ) -> Terms {
        let power = Power::new(numbers.ns);
        let mut sum = Terms::default();
        for (index, light) in &self.lights {
            let model = self.material.highlight;
            let Some(given) = share(numbers, power, model, light, at.position, normal, view) else {
                continue;
            };
            match (light, ambient) {
                (Light::Ambient { color }, Some(texel)) => {
                    // A colour of its own, which does not multiply the base colour.
                    for i in 0..3 {
                        sum.highlight[i] += color[i] * given.diffuse * texel[i];
                    }
                }
                (Light::Ambient { .. }, None) => sum.add(&given, [1.0; 3]),
                _ => sum.add(&given, ready.received(*index, at)),
            }
        }
        sum
    }

    fn mirror(
        &self,
        ready: &Ready<'_>,
        at: &Sample<'_>,
        smooth: [f32; 3],
        normal: [f32; 3],
        view: [f32; 3],
        uv: ([f32; 2], Footprint),
        ks: f32,
        terms: &mut Terms,
    ) {
        if self.material.reflection.is_none() && self.material.specular_map.is_none() {
            return;
        }
        // The eye rests: the view changes against the position. A relief turns the normal, but its bends are left to its own texels.
        let back = |v: [f32; 3]| v.map(|c| -c);
        let view = Ray {
            direction: view,
            dx: back(at.position_dx),
            dy: back(at.position_dy),
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
            let light = ready.environments[environment].light_across(&mirrored);
            for (sum, c) in terms.highlight.iter_mut().zip(light) {
                *sum += share * c;
            }
        }
        if let Some(map) = self.material.specular_map {
            let light = ready.environments[map].light_across(&mirrored);
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
        (uv, d): ([f32; 2], Footprint),
    ) -> [f32; 3] {
        let turned = match (&self.carved, &self.relief) {
            (Some(carved), _) => carved.normal(at, unit(normal)),
            (None, Some((relief, slot))) => self.turned(at, normal, relief, slot, (uv, d)),
            (None, None) => return unit(normal),
        };
        if self.material.horizon_clamp {
            clamp_unit_to_horizon(turned, unit(view))
        } else {
            turned
        }
    }

    fn turned(
        &self,
        at: &Sample<'_>,
        normal: [f32; 3],
        relief: &Relief,
        slot: &Slot<'s>,
        (uv, d): ([f32; 2], Footprint),
    ) -> [f32; 3] {
        match *relief {
            Relief::Carved { .. } => unit(normal),
            Relief::Bump { .. } | Relief::Offsets { .. } => {
                self.bumped(at, normal, slot, relief, uv, d)
            }
            Relief::NormalMap {
                green,
                rebuild_z,
                object_space,
                strength,
                ..
            } => {
                let map = NormalMap {
                    green,
                    rebuild_z,
                    strength,
                };
                let texel = straight(slot.texel(uv, d));
                if object_space {
                    let world = self.normal_to_world * wide(map.decode(texel));
                    let world = if at.fragment.front { world } else { -world };
                    unit(narrow(world))
                } else {
                    let first = self.tangent.unwrap_or(0);
                    let [tx, ty, tz] = three(at.fragment, first);
                    let sign = at.fragment.values[first + 3];
                    // The frame belongs to the front; on the back N and so B are turned round with it.
                    let sign = if at.fragment.front { sign } else { -sign };
                    let sign = if sign < 0.0 { -1.0 } else { 1.0 };
                    map.turn(unit(normal), [tx, ty, tz, sign], texel)
                }
            }
        }
    }

    /// Blinn's normal, with O_u and O_v from the analytic change of position and coordinates from pixel to pixel.
    fn bumped(
        &self,
        at: &Sample<'_>,
        normal: [f32; 3],
        slot: &Slot<'s>,
        relief: &Relief,
        uv: [f32; 2],
        d: Footprint,
    ) -> [f32; 3] {
        let n = unit(normal);
        let ([u, v], placed) = slot.place(uv, d);
        let det = placed.du_dx * placed.dv_dy - placed.dv_dx * placed.du_dy;
        if det == 0.0 || !det.is_finite() {
            return n;
        }
        let (px, py) = (at.position_dx, at.position_dy);
        let o_u = [0, 1, 2].map(|i| (px[i] * placed.dv_dy - py[i] * placed.dv_dx) / det);
        let o_v = [0, 1, 2].map(|i| (py[i] * placed.du_dx - px[i] * placed.du_dy) / det);
        let [b_u, b_v] = match *relief {
            Relief::Offsets { slope, green, .. } => {
                let texel = slot.sampler.sample_grad(&slot.texture, [u, v], placed);
                let [r, g, _] = straight(texel);
                let [along_u, along_v] = decode_offsets([r, g], green);
                // The slot counts v down the picture, or up it from a bottom-left origin.
                let down = match slot.texture.origin() {
                    Origin::TopLeft => along_v,
                    Origin::BottomLeft => -along_v,
                };
                [along_u, down].map(|c| c * slope * self.unit)
            }
            Relief::Bump { height, .. } => {
                heights(slot, [u, v], placed).map(|c| c * height * self.unit)
            }
            Relief::NormalMap { .. } | Relief::Carved { .. } => [0.0; 2],
        };
        bump_on(n, o_u, o_v, b_u, b_v)
    }
}

/// Slopes of a height map over u and v: central differences over a texel to each side, or over the pixel where that is wider.
fn heights(slot: &Slot<'_>, [u, v]: [f32; 2], placed: Footprint) -> [f32; 2] {
    let wider = |texel: f32, a: f32, b: f32| {
        let pixel = if a.abs() > b.abs() { a.abs() } else { b.abs() };
        if pixel > texel { pixel } else { texel }
    };
    let (w, h) = (slot.texture.width() as f32, slot.texture.height() as f32);
    let (du, dv) = (
        wider(1.0 / w, placed.du_dx, placed.du_dy),
        wider(1.0 / h, placed.dv_dx, placed.dv_dy),
    );
    let sample =
        |u: f32, v: f32| straight(slot.sampler.sample_grad(&slot.texture, [u, v], placed))[0];
    [
        (sample(u + du, v) - sample(u - du, v)) / (2.0 * du),
        (sample(u, v + dv) - sample(u, v - dv)) / (2.0 * dv),
    ]
}

/// World units of one unit of a mesh's own space, the mean of its three axes by volume.
fn unit_of(mesh: &Mesh) -> f64 {
    let volume = linear(mesh.world_from_object).determinant().abs();
    texmap_math::det::pow(volume, 1.0 / 3.0)
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

/// Whether effects read the first coordinates of a mesh.
pub(crate) fn reads_uv(material: &Material) -> bool {
    let maps = &material.maps;
    material.relief.as_ref().is_some_and(|r| r.slot().is_some())
        || [
            &maps.ambient,
            &maps.specular,
            &maps.exponent,
            &maps.reflectivity,
        ]
        .into_iter()
        .any(Option::is_some)
}

/// Coordinates among the attributes of a fragment, and their footprint.
fn coordinates(fragment: &Fragment, first: usize) -> ([f32; 2], Footprint) {
    let Fragment {
        values, ddx, ddy, ..
    } = fragment;
    let d = Footprint {
        du_dx: ddx[first],
        dv_dx: ddx[first + 1],
        du_dy: ddy[first],
        dv_dy: ddy[first + 1],
    };
    ([values[first], values[first + 1]], d)
}

fn length(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// Tangents of a mesh's corners for normal maps whose y points up the picture: world-space vectors and the sign of the bitangent.
pub(crate) fn corner_tangents(mesh: &Mesh, normals: &[DVec3]) -> Vec<[f32; 4]> {
    let faces = texmap_uv::Faces::from_triangles(&mesh.triangles);
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let set = texmap_uv::UvSet {
        uvs: mesh.uvs.clone(),
        corners: corners.clone(),
    };
    let normal = |v: &u32| normals[*v as usize].normalize_or_zero().to_array();
    let at_corners: Vec<[f32; 3]> = corners
        .iter()
        .map(|v| normal(v).map(|c| c as f32))
        .collect();
    let fallback = || vec![[0.0; 4]; corners.len()];
    let Ok(shape) = texmap_uv::Mesh::new(&mesh.positions, &faces) else {
        return fallback();
    };
    let Ok(tangents) = texmap_uv::tangents(&shape, &set, &at_corners) else {
        return fallback();
    };
    let world = linear(mesh.world_from_object);
    let mirror = if world.determinant() < 0.0 { -1.0 } else { 1.0 };
    // The bitangent follows growing v, which runs down the picture from a top-left origin.
    let down = if mesh.uv_origin == Origin::TopLeft {
        -1.0
    } else {
        1.0
    };
    tangents
        .into_iter()
        .map(|[x, y, z, sign]| {
            let t = (world * DVec3::new(x.into(), y.into(), z.into())).normalize_or_zero();
            let [x, y, z] = t.to_array().map(|c| c as f32);
            [x, y, z, sign * mirror * down]
        })
        .collect()
}
