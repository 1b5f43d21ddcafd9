//! One mesh of the truth: its coordinates, its opacity and its colour where a ray meets it.

use texmap_light::reference::terms;
use texmap_math::frame::{MagicVectors, TextureFrame};
use texmap_math::glam::{DMat3, DVec2, DVec3, DVec4};
use texmap_render::{AlphaMode, Gouraud, Material, Mesh, Scene, Shading, TextureRole, TextureSlot};
use texmap_sample::{Filter, Texture2d, reference as sampling};

use super::{wide, world};
use crate::LabError;
use crate::reference::{Hit, Pinhole};

/// Light that a vertex or a point returns: what the base colour multiplies, and the highlight.
type Terms = (DVec3, DVec3);

pub(super) struct Surface<'s> {
    scene: &'s Scene,
    mesh: &'s Mesh,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    base_color: Option<Slot<'s>>,
    opacity_map: Option<Slot<'s>>,
    /// O, U, V about the eye.
    frame: Option<MagicVectors>,
    mirrored: bool,
}

struct Slot<'s> {
    slot: &'s TextureSlot,
    texture: Texture2d<'static>,
}

/// Coordinates and their change for one pixel to the right and one down.
#[derive(Clone, Copy)]
struct Place {
    uv: DVec2,
    dx: DVec2,
    dy: DVec2,
}

impl<'s> Surface<'s> {
    pub(super) fn new(scene: &'s Scene, mesh: &'s Mesh) -> Result<Self, LabError> {
        let material = &scene.materials[mesh.material];
        let slot = |slot: &'s TextureSlot| {
            let texture = scene.textures[slot.texture].clone();
            let texture = if texture.levels() == 1 {
                texture.with_mips()
            } else {
                texture
            };
            Slot {
                slot,
                texture: texture.with_origin(mesh.uv_origin),
            }
        };
        let frame = |frame: TextureFrame| -> Result<MagicVectors, LabError> {
            let world = frame.transform(mesh.world_from_object);
            Ok(TextureFrame::new(world.o - scene.camera.eye, world.u, world.v)?.magic())
        };
        Ok(Self {
            scene,
            mesh,
            points: world(mesh),
            normals: normals(mesh),
            base_color: material.base_color.as_ref().map(slot),
            opacity_map: material.opacity_map.as_ref().map(slot),
            frame: mesh.frame.map(frame).transpose()?,
            mirrored: mesh.world_from_object.determinant() < 0.0,
        })
    }

    pub(super) fn material(&self) -> &'s Material {
        &self.scene.materials[self.mesh.material]
    }

    pub(super) fn triangles(&self) -> u32 {
        self.mesh.triangles.len() as u32
    }

    pub(super) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh.triangles[triangle as usize].map(|vertex| self.points[vertex as usize])
    }

    /// Whether the counter-clockwise side is seen; a mirror does not turn a surface inside out.
    pub(super) fn front(&self, hit: &Hit) -> bool {
        hit.front != self.mirrored
    }

    /// The alpha test of a cut-out material; others keep everything.
    pub(super) fn kept(&self, triangle: u32, hit: &Hit, pinhole: &Pinhole, x: f64, y: f64) -> bool {
        let AlphaMode::Test(threshold) = self.material().alpha else {
            return true;
        };
        let place = self.place(triangle, hit, pinhole, x, y);
        let texel = self
            .base_color
            .as_ref()
            .map_or(1.0, |slot| slot.texel(place).w);
        let alpha = texel * self.veil(place);
        let source = self.opacity_map.as_ref().or(self.base_color.as_ref());
        let nearest = source
            .is_none_or(|s| matches!(s.slot.sampler.filter, Filter::Nearest | Filter::MipNearest));
        match (threshold > 0.0, nearest) {
            (true, _) => alpha >= f64::from(threshold),
            (false, true) => alpha > 0.0,
            (false, false) => alpha >= 0.5,
        }
    }

    /// The colour where a ray meets a triangle: linear light, premultiplied.
    pub(super) fn shade(
        &self,
        triangle: u32,
        hit: &Hit,
        pinhole: &Pinhole,
        x: f64,
        y: f64,
    ) -> DVec4 {
        let material = self.material();
        let place = self.place(triangle, hit, pinhole, x, y);
        let texel = self.base_color.as_ref().map(|slot| slot.texel(place));
        let straight = |t: DVec4| {
            if t.w > 0.0 {
                t.truncate() / t.w
            } else {
                DVec3::ZERO
            }
        };
        let base = wide(material.surface.color);
        let opaque = |color: DVec3| color.min(DVec3::ONE).extend(1.0);
        let (color, alpha) = match (texel, material.texture_role) {
            (Some(texel), TextureRole::Decal) => {
                if material.alpha == AlphaMode::Opaque {
                    let under = if texel.w < 1.0 {
                        self.lit(triangle, hit, base, false)
                    } else {
                        DVec3::ZERO
                    };
                    return opaque(texel.truncate() + under * (1.0 - texel.w));
                }
                (straight(texel).min(DVec3::ONE), texel.w)
            }
            (Some(texel), TextureRole::Modulate) => (
                self.lit(triangle, hit, base * straight(texel), true),
                texel.w,
            ),
            (None, _) => (self.lit(triangle, hit, base, false), 1.0),
        };
        match material.alpha {
            AlphaMode::Blend => {
                let alpha = alpha * self.veil(place);
                (color * alpha).extend(alpha)
            }
            _ => opaque(color),
        }
    }

    /// Opacity of the material and its map.
    fn veil(&self, place: Place) -> f64 {
        let material = self.material();
        let map = |slot: &Slot<'_>| {
            let texel = slot.texel(place);
            if slot.texture.has_alpha() {
                texel.w
            } else {
                texel.x
            }
        };
        f64::from(material.opacity) * self.opacity_map.as_ref().map_or(1.0, map)
    }

    /// A base colour under the scene's light, clipped at 1. `textured` tells that it holds a texel, which
    /// varies between the vertices.
    fn lit(&self, triangle: u32, hit: &Hit, base: DVec3, textured: bool) -> DVec3 {
        let material = self.material();
        let vertices = self.mesh.triangles[triangle as usize];
        let tint = |vertex: u32| {
            self.mesh
                .colors
                .get(vertex as usize)
                .map_or(DVec3::ONE, |c| wide(*c))
        };
        let mix = |at: [DVec3; 3]| {
            let b = match material.gouraud {
                Gouraud::Perspective => hit.weights,
                Gouraud::ScreenLinear => self.screen_weights(triangle, hit),
            };
            at[0] * b.x + at[1] * b.y + at[2] * b.z
        };
        let color = match material.shading {
            Shading::Unlit => base * mix(vertices.map(tint)),
            Shading::PerPixel => {
                let at = |values: &[DVec3]| {
                    (0..3)
                        .map(|i| values[vertices[i] as usize] * hit.weights[i])
                        .sum()
                };
                let (diffuse, highlight) =
                    self.terms(at(&self.points), at(&self.normals), self.front(hit));
                base * mix(vertices.map(tint)) * diffuse + highlight
            }
            Shading::PerVertex => {
                let light = vertices.map(|vertex| {
                    let (point, normal) =
                        (self.points[vertex as usize], self.normals[vertex as usize]);
                    let (diffuse, highlight) = self.terms(point, normal, self.front(hit));
                    (diffuse * tint(vertex), highlight)
                });
                if textured {
                    base * mix(light.map(|l| l.0)) + mix(light.map(|l| l.1))
                } else {
                    // Without a texel the colour is finished, and clipped, at the vertices.
                    mix(light.map(|l| (base * l.0 + l.1).min(DVec3::ONE)))
                }
            }
        };
        color.min(DVec3::ONE)
    }

    fn terms(&self, point: DVec3, normal: DVec3, front: bool) -> Terms {
        let normal = if front { normal } else { -normal };
        terms(
            &self.material().surface,
            &self.scene.lights,
            point,
            normal,
            self.scene.camera.eye,
        )
    }

    /// Barycentrics on the screen: those in space times the vertices' distances along the line of sight.
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

    fn place(&self, triangle: u32, hit: &Hit, pinhole: &Pinhole, x: f64, y: f64) -> Place {
        if let Some(MagicVectors { a, b, c }) = self.frame {
            let ray = pinhole.direction(x, y);
            let uv = DVec2::new(a.dot(ray), b.dot(ray)) / c.dot(ray);
            let change = |step: DVec3| {
                (DVec2::new(a.dot(step), b.dot(step)) - uv * c.dot(step)) / c.dot(ray)
            };
            return Place {
                uv,
                dx: change(pinhole.right),
                dy: change(pinhole.down),
            };
        }
        if let Some(map) = &self.mesh.round {
            let corners = self.corners(triangle);
            let axes = [0, 1, 2].map(|k| corners.map(|p| p[k]));
            let point = DVec3::from_array(axes.map(|values| hit.attribute(values)));
            let change = axes.map(|values| hit.derivative(values));
            let (uv, [ux, vx, uy, vy]) = map.reference(
                point,
                DVec3::from_array(change.map(|d| d.x)),
                DVec3::from_array(change.map(|d| d.y)),
            );
            return Place {
                uv: DVec2::from_array(uv),
                dx: DVec2::new(ux, vx),
                dy: DVec2::new(uy, vy),
            };
        }
        let vertices = self.mesh.triangles[triangle as usize];
        let at = |axis: usize| {
            vertices.map(|v| {
                self.mesh
                    .uvs
                    .get(v as usize)
                    .map_or(0.0, |uv| f64::from(uv[axis]))
            })
        };
        let (du, dv) = (hit.derivative(at(0)), hit.derivative(at(1)));
        Place {
            uv: DVec2::new(hit.attribute(at(0)), hit.attribute(at(1))),
            dx: DVec2::new(du.x, dv.x),
            dy: DVec2::new(du.y, dv.y),
        }
    }
}

impl Slot<'_> {
    fn texel(&self, place: Place) -> DVec4 {
        let [[a, b, c], [d, e, f]] = self.slot.transform.rows().map(|row| row.map(f64::from));
        let turn = |p: DVec2| DVec2::new(a * p.x + b * p.y, d * p.x + e * p.y);
        let uv = turn(place.uv) + DVec2::new(c, f);
        let (dx, dy) = (turn(place.dx), turn(place.dy));
        let texel = sampling::sample_grad(
            &self.slot.sampler,
            &self.texture,
            uv.to_array(),
            [dx.x, dx.y, dy.x, dy.y],
        );
        DVec4::from_array(texel)
    }
}

/// Unit normals in world space by the inverse transpose: the mesh's own, or the sum of the cross products of
/// the triangles at each vertex.
fn normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut normals: Vec<DVec3> = mesh.normals.iter().map(|n| wide(*n)).collect();
    if normals.is_empty() {
        normals = vec![DVec3::ZERO; mesh.positions.len()];
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| wide(mesh.positions[vertex as usize]));
            triangle
                .iter()
                .for_each(|vertex| normals[*vertex as usize] += (b - a).cross(c - a));
        }
    }
    let matrix = DMat3::from_mat4(mesh.world_from_object)
        .inverse()
        .transpose();
    normals
        .into_iter()
        .map(|n| (matrix * n.normalize_or_zero()).normalize_or_zero())
        .collect()
}
