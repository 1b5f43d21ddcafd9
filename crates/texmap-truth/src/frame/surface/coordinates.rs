//! Texture coordinates where a ray meets a mesh: by a texture frame, a shape around the mesh, or its vertices.

use texmap_math::glam::{DVec2, DVec3};
use texmap_math::texture_frame::{PlanarTexgen, TextureFrame};

use super::{Place, Surface};
use crate::caster::{Hit, Pinhole};

impl Surface<'_> {
    /// O, U, V about another point than the eye.
    fn frame_about(&self, point: DVec3) -> Option<PlanarTexgen> {
        let world = self
            .mesh
            .texture_frame?
            .transform(self.mesh.world_from_object);
        let frame = TextureFrame::new(world.o - point, world.u, world.v);
        frame.ok().map(|frame| frame.texgen())
    }

    pub(super) fn place(
        &self,
        triangle: u32,
        hit: &Hit,
        pinhole: &Pinhole,
        x: f64,
        y: f64,
    ) -> Place {
        let from_eye = match pinhole.eye == self.scene.camera.eye {
            true => self.frame,
            false => self.frame.and_then(|_| self.frame_about(pinhole.eye)),
        };
        let Some(PlanarTexgen { a, b, c }) = from_eye.filter(|_| self.mesh.uv_projection.is_none())
        else {
            return self.vertex_place(triangle, hit);
        };
        let ray = pinhole.direction(x, y);
        let uv = DVec2::new(a.dot(ray), b.dot(ray)) / c.dot(ray);
        let change =
            |step: DVec3| (DVec2::new(a.dot(step), b.dot(step)) - uv * c.dot(step)) / c.dot(ray);
        Place {
            uv,
            dx: change(pinhole.right),
            dy: change(pinhole.down),
        }
    }

    /// Coordinates by a shape around the mesh, or those of its vertices.
    pub(super) fn vertex_place(&self, triangle: u32, hit: &Hit) -> Place {
        if let Some(map) = &self.mesh.uv_projection {
            let corners = self.corners(triangle);
            let [right, down] = hit.vector_changes(corners);
            let (uv, [ux, vx, uy, vy]) = map.reference(hit.vector(corners), right, down);
            return Place {
                uv: DVec2::from_array(uv),
                dx: DVec2::new(ux, vx),
                dy: DVec2::new(uy, vy),
            };
        }
        self.place_among(&self.mesh.uvs, triangle, hit)
    }

    /// Coordinates of the second set.
    pub(super) fn second_place(&self, triangle: u32, hit: &Hit) -> Place {
        self.place_among(&self.mesh.lightmap_uvs, triangle, hit)
    }

    /// Coordinates by those of the vertices; 0 without.
    fn place_among(&self, uvs: &[[f32; 2]], triangle: u32, hit: &Hit) -> Place {
        let vertices = self.mesh.triangles[triangle as usize];
        let at = |axis: usize| {
            vertices.map(|v| {
                let uv = uvs.get(v as usize);
                uv.map_or(0.0, |uv| f64::from(uv[axis]))
            })
        };
        place_of(hit, at(0), at(1))
    }
}

/// Coordinates at a hit from those of the corners.
fn place_of(hit: &Hit, u: [f64; 3], v: [f64; 3]) -> Place {
    let (du, dv) = (hit.derivative(u), hit.derivative(v));
    Place {
        uv: DVec2::new(hit.attribute(u), hit.attribute(v)),
        dx: DVec2::new(du.x, dv.x),
        dy: DVec2::new(du.y, dv.y),
    }
}
