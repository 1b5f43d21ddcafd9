//! One mesh of the truth: its geometry and coordinates, its opacity, and its colour where a ray meets it.

mod coordinates;

use texmap_light::SpecularModel;
use texmap_math::glam::{DMat3, DVec3, DVec4};
use texmap_math::texture_frame::{PlanarTexgen, TextureFrame};
use texmap_sample::Filter;
use texmap_scene::{
    AlphaMode, Material, Mesh, Scene, Shading, TextureRole, UvSet, VertexColorInterp,
};

use super::bump::{BumpMap, clamped};
use super::color::{luminance, over, straight, wide};
use super::emission::Emitter;
use super::environment::Ray;
use super::lighting::{Point, Terms, contribution, terms};
use super::metallic::Metal;
use super::projector::{onto, paint};
use super::slot::{Place, Slot, Textures};
use super::space::SampledSolid;
use super::tangents::corner_tangents;
use super::world;
use super::world::World;
use crate::TruthError;
use crate::caster::{Hit, Pinhole};

pub(super) struct Surface<'s> {
    scene: &'s Scene,
    pub(super) mesh: &'s Mesh,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Tangents of the corners, three for each triangle; empty without a normal map.
    tangents: Vec<(DVec3, f64)>,
    base_color: Option<Slot<'s>>,
    opacity_map: Option<Slot<'s>>,
    color_ramp: Option<Slot<'s>>,
    light_ramp: Option<Slot<'s>>,
    decal: Option<Slot<'s>>,
    solid: Option<SampledSolid>,
    bump: Option<BumpMap<'s>>,
    emission: Option<Emitter<'s>>,
    /// The model of light in place of the classic one.
    metal: Option<Metal<'s>>,
    pub(super) ambient: Option<Slot<'s>>,
    pub(super) specular: Option<Slot<'s>>,
    pub(super) exponent: Option<Slot<'s>>,
    pub(super) reflectivity: Option<Slot<'s>>,
    pub(super) light_map: Option<Slot<'s>>,
    /// O, U, V about the eye.
    frame: Option<PlanarTexgen>,
    mirrored: bool,
}

impl<'s> Surface<'s> {
    pub(super) fn new(
        scene: &'s Scene,
        mesh: &'s Mesh,
        textures: &mut Textures<'s>,
    ) -> Result<Self, TruthError> {
        let material = &scene.materials[mesh.material];
        let frame = |frame: TextureFrame| -> Result<PlanarTexgen, TruthError> {
            let world = frame.transform(mesh.world_from_object);
            Ok(TextureFrame::new(world.o - scene.camera.eye, world.u, world.v)?.texgen())
        };
        let bump = material.normal_detail.as_ref();
        let bump = bump.map(|bump| BumpMap::new(bump, mesh, textures));
        let emission = material.emission.as_ref();
        let emission = emission.map(|emission| Emitter::new(emission, mesh, textures));
        let tangents = match &bump {
            Some(BumpMap::Normals {
                world_from_normal: None,
                ..
            }) => {
                let slot = material
                    .normal_detail
                    .as_ref()
                    .and_then(texmap_scene::NormalDetail::slot);
                slot.map_or_else(Vec::new, |slot| {
                    corner_tangents(mesh, &slot.tangent_uvs(mesh))
                })
            }
            _ => Vec::new(),
        };
        let metal = material.metallic_roughness.as_ref();
        let metal = metal.map(|model| Metal::new(model, mesh, textures));
        let mut ramp = |slot: &'s Option<texmap_scene::TextureSlot>| {
            let slot = slot.as_ref();
            slot.map(|slot| textures.slot(slot, texmap_sample::Origin::TopLeft))
        };
        let (color_ramp, light_ramp) = (ramp(&material.color_ramp), ramp(&material.light_ramp));
        let mut slot = |slot: &'s Option<texmap_scene::TextureSlot>| {
            slot.as_ref()
                .map(|slot| textures.slot(slot, mesh.uv_origin))
        };
        let maps = &material.maps;
        Ok(Self {
            scene,
            mesh,
            points: world(mesh),
            normals: normals(mesh),
            tangents,
            base_color: slot(&material.base_color),
            opacity_map: slot(&material.opacity_map),
            color_ramp,
            light_ramp,
            decal: slot(&material.decal),
            ambient: slot(&maps.ambient),
            specular: slot(&maps.specular),
            exponent: slot(&maps.exponent),
            reflectivity: slot(&maps.reflectivity),
            light_map: material
                .light_map
                .as_ref()
                .map(|map| textures.slot(&map.slot, mesh.uv_origin)),
            solid: material
                .solid
                .as_ref()
                .map(|solid| SampledSolid::new(solid, &scene.effects)),
            bump,
            emission,
            metal,
            frame: mesh.texture_frame.map(frame).transpose()?,
            mirrored: mesh.world_from_object.determinant() < 0.0,
        })
    }

    pub(super) fn material(&self) -> &'s Material {
        &self.scene.materials[self.mesh.material]
    }

    pub(super) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh.triangles[triangle as usize].map(|vertex| self.points[vertex as usize])
    }

    /// The normal of a triangle's counter-clockwise side, of any length. A mirror does not turn a surface inside out.
    pub(super) fn flat(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        let normal = (b - a).cross(c - a);
        if self.mirrored { -normal } else { normal }
    }

    /// True if the counter-clockwise side is seen.
    pub(super) fn front(&self, hit: &Hit) -> bool {
        hit.front != self.mirrored
    }

    /// The alpha test of a cut-out material; others keep everything.
    pub(super) fn kept(&self, triangle: u32, hit: &Hit, pinhole: &Pinhole, x: f64, y: f64) -> bool {
        match self.material().alpha {
            AlphaMode::Test(threshold) => {
                let first = self.place(triangle, hit, pinhole, x, y);
                self.passes(threshold, first, self.second_place(triangle, hit))
            }
            _ => true,
        }
    }

    /// True if a cut-out blocks light at these weights of a triangle's corners. The coordinates of a texture frame are bound to the
    /// camera, and what has them is whole to the light.
    pub(super) fn holds_light(&self, triangle: u32, weights: DVec3) -> bool {
        let AlphaMode::Test(threshold) = self.material().alpha else {
            return true;
        };
        if self.frame.is_some() && self.mesh.uv_projection.is_none() {
            return true;
        }
        let hit = Hit {
            triangle,
            weights,
            d_dx: DVec3::ZERO,
            d_dy: DVec3::ZERO,
            t: 1.0,
            front: true,
        };
        let first = self.vertex_place(triangle, &hit);
        self.passes(threshold, first, self.second_place(triangle, &hit))
    }

    /// The alpha test by the first and second coordinates.
    fn passes(&self, threshold: f32, first: Place, second: Place) -> bool {
        let read = |slot: &Slot<'_>| match slot.uv_set {
            UvSet::First => first,
            UvSet::Second => second,
        };
        let texel = self.base_color.as_ref();
        let texel = texel.map_or(1.0, |slot| slot.texel(read(slot)).w);
        let alpha = texel * self.opacity(read);
        let source = self.opacity_map.as_ref().or(self.base_color.as_ref());
        let nearest =
            source.is_none_or(|s| matches!(s.sampler.filter, Filter::Nearest | Filter::MipNearest));
        match (threshold > 0.0, nearest) {
            (true, _) => alpha >= f64::from(threshold),
            (false, true) => alpha > 0.0,
            (false, false) => alpha >= 0.5,
        }
    }

    /// Opacity of the material and its map.
    fn opacity(&self, read: impl Fn(&Slot<'_>) -> Place) -> f64 {
        let map = self.opacity_map.as_ref();
        f64::from(self.material().opacity) * map.map_or(1.0, |slot| slot.opacity(read(slot)))
    }

    /// The colour where a ray meets a triangle: linear light, premultiplied.
    pub(super) fn shade(&self, world: &World<'_>, at: &Point, hit: &Hit) -> DVec4 {
        let material = self.material();
        let texel = self
            .base_color
            .as_ref()
            .map(|slot| self.base_texel(slot, at));
        let label = self.decal.as_ref().map(|slot| slot.texel(at.read(slot)));
        let limit = world.limit();
        let opaque = |color: DVec3| color.min(limit).extend(1.0);
        let surface = wide(material.phong.color);
        let (color, alpha, passing) = match (texel, material.texture_role) {
            (Some(texel), TextureRole::Decal) => {
                let texel = label.map_or(texel, |label| over(label, texel));
                let texel = onto(world, self, at, texel);
                if material.alpha == AlphaMode::Opaque {
                    let under = if texel.w < 1.0 {
                        self.lit(world, at, hit, surface, true).0
                    } else {
                        DVec3::ZERO
                    };
                    return opaque(texel.truncate() + under * (1.0 - texel.w));
                }
                (straight(texel).min(limit), texel.w, 0.0)
            }
            (texel, _) => {
                let mut base = surface * texel.map_or(DVec3::ONE, straight);
                if let Some(solid) = &self.solid {
                    let color = solid.color(at.position, at.moves);
                    let ramp = self.color_ramp.as_ref();
                    base *= straight(ramp.map_or(color, |ramp| ramp.along(color.x)));
                }
                if let Some(label) = label {
                    base = label.truncate() + base * (1.0 - label.w);
                }
                let varies = texel.is_some() || self.solid.is_some() || label.is_some();
                let (color, passing) = self.lit(world, at, hit, base, varies);
                (color, texel.map_or(1.0, |texel| texel.w), passing)
            }
        };
        match material.alpha {
            AlphaMode::Blend => {
                let alpha = alpha * self.opacity(|slot| at.read(slot));
                (color * alpha).extend(alpha * (1.0 - passing))
            }
            _ => opaque(color),
        }
    }

    /// The texel of the base colour: through its ramp, within its outline.
    fn base_texel(&self, slot: &Slot<'_>, at: &Point) -> DVec4 {
        let place = at.read(slot);
        let mut texel = slot.texel(place);
        if let (Some(ramp), None) = (&self.color_ramp, &self.solid) {
            texel = slot.dependent(place, ramp) * texel.w;
        }
        if self.material().antialiased_alpha {
            let alpha = slot.outline(place, texel.w);
            texel = (straight(texel) * alpha).extend(alpha);
        }
        texel
    }

    /// A base colour under the scene's light, as display light, and the fraction of the light from behind that passes. `varies` tells that
    /// the colour is not the same at all vertices.
    fn lit(
        &self,
        world: &World<'_>,
        at: &Point,
        hit: &Hit,
        base: DVec3,
        varies: bool,
    ) -> (DVec3, f64) {
        let material = self.material();
        let vertices = self.mesh.triangles[at.owner.1 as usize];
        let tint = |vertex: u32| {
            self.mesh
                .colors
                .get(vertex as usize)
                .map_or(DVec3::ONE, |c| wide(*c))
        };
        let mix = |values: [DVec3; 3]| {
            let b = match material.vertex_color_interp {
                VertexColorInterp::Perspective => hit.weights,
                VertexColorInterp::ScreenLinear => self.screen_weights(at.owner.1, hit),
            };
            values[0] * b.x + values[1] * b.y + values[2] * b.z
        };
        let emitter = self.emission.as_ref();
        let emitted = emitter.map_or(DVec3::ZERO, |emitter| emitter.light(at));
        let finished = |mut terms: Terms| {
            if let Some(ramp) = &self.light_ramp {
                terms.diffuse = straight(ramp.along(luminance(terms.diffuse)));
            }
            terms.specular += emitted;
            terms
        };
        match material.shading {
            Shading::Unlit => {
                let color = base * mix(vertices.map(tint)) + emitted;
                (color.min(world.limit()), 0.0)
            }
            Shading::PerPixel => {
                let paint = paint(world, at);
                let base = base * mix(vertices.map(tint));
                let base = paint.truncate() + base * (1.0 - paint.w);
                let (light, passing) = match &self.metal {
                    Some(metal) => {
                        let (light, passing) = metal.light(world, self, at, base);
                        (light + emitted, passing)
                    }
                    None => (finished(terms(world, self, at)).color(base), 0.0),
                };
                (world.display(light), passing)
            }
            Shading::PerVertex => {
                let light = vertices.map(|vertex| self.vertex_terms(world, vertex, at.front));
                if varies {
                    let tinted = [0, 1, 2].map(|k| light[k].diffuse * tint(vertices[k]));
                    let terms = Terms {
                        diffuse: mix(tinted),
                        specular: mix(light.map(|terms| terms.specular)),
                    };
                    return (finished(terms).color(base).min(world.limit()), 0.0);
                }
                // A term that does not vary is finished, and clipped, at the vertices.
                let color = |k: usize| light[k].color(base * tint(vertices[k])).min(DVec3::ONE);
                let color = mix([0, 1, 2].map(color));
                ((color + emitted).min(world.limit()), 0.0)
            }
        }
    }

    /// The light at a vertex, without shadows and projectors, on the side that is seen.
    fn vertex_terms(&self, world: &World<'_>, vertex: u32, front: bool) -> Terms {
        let numbers = &self.material().phong;
        let (point, normal) = (self.points[vertex as usize], self.normals[vertex as usize]);
        let normal = if front { normal } else { -normal };
        let view = (self.scene.camera.eye - point).normalize_or_zero();
        let mut sum = Terms::default();
        for light in &self.scene.lights {
            let (color, diffuse, highlight) =
                contribution(numbers, SpecularModel::Phong, light, point, normal, view);
            sum.diffuse += color * diffuse;
            sum.specular += color * highlight;
        }
        let map = self.material().specular_map;
        if let Some(sphere) = map.and_then(|map| world.environments[map].as_ref()) {
            let ray = Ray {
                direction: view,
                changes: [DVec3::ZERO; 2],
            };
            let mirrored = ray.mirrored(normal, 1.0, [DVec3::ZERO; 2]);
            sum.specular += sphere.light(&mirrored) * f64::from(numbers.ks);
        }
        sum
    }

    /// The unit normal after the bump or normal map of the surface.
    pub(super) fn turned_normal(&self, at: &Point) -> DVec3 {
        let n = at.normal.normalize_or_zero();
        let Some(bump) = &self.bump else { return n };
        // Relief belongs to the front: seen from behind, a bump is a dent.
        let side = if at.front { 1.0 } else { -1.0 };
        let turned = side * bump.normal(at, side * n);
        if self.material().horizon_clamp {
            clamped(turned, at.view.direction.normalize_or_zero())
        } else {
            turned
        }
    }

    /// Barycentrics on the screen: those in space times the vertices' distances along the line of visible.
    fn screen_weights(&self, triangle: u32, hit: &Hit) -> DVec3 {
        let camera = &self.scene.camera;
        let forward = (camera.look - camera.eye).normalize();
        let w = DVec3::from_array(
            self.corners(triangle)
                .map(|p| (p - camera.eye).dot(forward)),
        );
        let scaled = hit.weights * w;
        scaled / scaled.element_sum()
    }

    /// Everything that shading asks for at a hit.
    pub(super) fn point(
        &self,
        owner: (usize, u32),
        hit: &Hit,
        pinhole: &Pinhole,
        x: f64,
        y: f64,
    ) -> Point {
        let triangle = owner.1;
        let vertices = self.mesh.triangles[triangle as usize];
        let (corners, front) = (self.corners(triangle), self.front(hit));
        let side = if front { 1.0 } else { -1.0 };
        let normals = vertices.map(|v| self.normals[v as usize] * side);
        let tangent = |k: usize| {
            self.tangents
                .get(3 * triangle as usize + k)
                .copied()
                .unwrap_or_default()
        };
        let tangents = [0, 1, 2].map(tangent);
        Point {
            owner,
            front,
            position: hit.vector(corners),
            moves: hit.vector_changes(corners),
            normal: hit.vector(normals),
            turns: hit.vector_changes(normals),
            plane: self.flat(triangle).normalize_or_zero() * side,
            place: self.place(triangle, hit, pinhole, x, y),
            baked_place: self.second_place(triangle, hit),
            tangent: (
                hit.vector(tangents.map(|t| t.0)),
                hit.attribute(tangents.map(|t| t.1)).signum(),
            ),
            view: Ray {
                direction: -pinhole.direction(x, y),
                changes: [-pinhole.right, -pinhole.down],
            },
            mirrored: false,
        }
    }
}

/// The linear part of a mesh's placement.
pub(super) fn linear(mesh: &Mesh) -> DMat3 {
    DMat3::from_mat4(mesh.world_from_object)
}

/// Normals in object space, of any length: the mesh's own, or the sum of the cross products of the triangles at each vertex.
pub(super) fn object_normals(mesh: &Mesh) -> Vec<DVec3> {
    if !mesh.normals.is_empty() {
        return mesh.normals.iter().map(|n| wide(*n)).collect();
    }
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| wide(mesh.positions[vertex as usize]));
        triangle
            .iter()
            .for_each(|vertex| normals[*vertex as usize] += (b - a).cross(c - a));
    }
    normals
}

/// Unit normals in world space by the inverse transpose.
fn normals(mesh: &Mesh) -> Vec<DVec3> {
    let matrix = linear(mesh).inverse().transpose();
    object_normals(mesh)
        .into_iter()
        .map(|n| (matrix * n.normalize_or_zero()).normalize_or_zero())
        .collect()
}
