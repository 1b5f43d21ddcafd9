//! Drawing order: the draws of a scene, in the order in which blended surfaces are composed.

use texmap_math::glam::DVec3;
use texmap_math::wide;
use texmap_raster::Cull;

use crate::{AlphaMode, Mesh, Scene};

/// The order in which blended meshes are composed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BlendOrder {
    /// That of [`Scene::meshes`].
    #[default]
    OfMeshes,
    /// After all others, by the centres of their boxes, the farthest from the camera first, and of two-sided ones the backs before the
    /// fronts. Those that cast no shadow come first: they lie on what others stand on. Triangles of one side of one mesh stay in their order.
    FarthestFirst,
}

/// One draw of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshDraw {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Sides that this draw leaves out.
    pub cull: Cull,
}

impl Scene {
    /// The draws of all meshes in their order, as [`blend_order`](Self::blend_order) says. The scene must be [checked](Self::check).
    #[must_use]
    pub fn drawing_order(&self) -> Vec<MeshDraw> {
        let draw = |mesh: usize| MeshDraw {
            mesh,
            cull: self.materials[self.meshes[mesh].material].cull,
        };
        let all = 0..self.meshes.len();
        if self.blend_order == BlendOrder::OfMeshes {
            return all.map(draw).collect();
        }
        let blends =
            |mesh: &usize| self.materials[self.meshes[*mesh].material].alpha == AlphaMode::Blend;
        let (mut blended, others): (Vec<usize>, Vec<usize>) = all.partition(blends);
        // Stable: equal distances stay in the order of the meshes.
        blended.sort_by_cached_key(|mesh| {
            let mesh = &self.meshes[*mesh];
            // Bits of positive floats rise with them.
            (!mesh.casts_no_shadow, !self.distance(mesh).to_bits())
        });
        let both = blended.into_iter().map(draw).flat_map(|draw| {
            let side = |cull| MeshDraw { cull, ..draw };
            match draw.cull {
                Cull::None => [Some(side(Cull::Front)), Some(side(Cull::Back))],
                _ => [Some(draw), None],
            }
        });
        others.into_iter().map(draw).chain(both.flatten()).collect()
    }

    /// Distance from the camera to the centre of the box of a mesh, at least 0; along the view for parallel rays.
    fn distance(&self, mesh: &Mesh) -> f64 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in &mesh.positions {
            (low, high) = (low.min(wide(*p)), high.max(wide(*p)));
        }
        let center = mesh.world_from_object.transform_point3(0.5 * (low + high));
        let way = center - self.camera.eye;
        let distance = match self.camera.lens.parallel_width {
            // Of the far side of an eye in the middle of a scene, too.
            Some(_) => {
                let along = (self.camera.look - self.camera.eye).normalize_or_zero();
                let depth = way.dot(along);
                if depth < 0.0 {
                    1.0 / (1.0 - depth)
                } else {
                    1.0 + depth
                }
            }
            None => way.length(),
        };
        if distance >= 0.0 { distance } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;
    use texmap_math::camera::{Camera, Lens};
    use texmap_math::glam::DMat4;

    /// Three panes and a solid at z = -1, 1, 0, 2.
    fn panes() -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3]));
        let blend = |cull| Material {
            alpha: AlphaMode::Blend,
            cull,
            ..Material::default()
        };
        scene.materials = vec![blend(Cull::None), blend(Cull::Back), Material::default()];
        let at = [(-1.0, 1), (1.0, 0), (0.0, 1), (2.0, 2)];
        scene.meshes = at
            .map(|(z, material)| Mesh {
                material,
                world_from_object: DMat4::from_translation(DVec3::new(0.0, 0.0, z)),
                ..Mesh::cube()
            })
            .to_vec();
        scene
    }

    fn meshes(scene: &Scene) -> Vec<usize> {
        scene.drawing_order().iter().map(|draw| draw.mesh).collect()
    }

    #[test]
    fn blended_meshes_are_composed_from_the_farthest_on() {
        let mut scene = panes();
        assert_eq!(meshes(&scene), [0, 1, 2, 3]);
        scene.blend_order = BlendOrder::FarthestFirst;
        assert_eq!(meshes(&scene), [3, 0, 2, 1, 1]);
        let sides = |scene: &Scene| scene.drawing_order()[3..].iter().map(|d| d.cull).collect();
        let both: Vec<Cull> = sides(&scene);
        assert_eq!(both, [Cull::Front, Cull::Back]);
        scene.camera.eye.z = -5.0;
        assert_eq!(meshes(&scene), [3, 1, 1, 2, 0]);
        // An eye of parallel rays may stand among them.
        scene.camera.eye.z = -0.5;
        scene.camera.look.z = 9.0;
        scene.camera.lens = Lens {
            parallel_width: Some(4.0),
            ..Lens::default()
        };
        assert_eq!(meshes(&scene), [3, 1, 1, 2, 0]);
        scene.meshes[0].casts_no_shadow = true;
        assert_eq!(meshes(&scene), [3, 0, 1, 1, 2]);
    }
}
