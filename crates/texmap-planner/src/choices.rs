//! Error budgets, and the choices that keep them.

use texmap_raster::Interp;
use texmap_sample::{Filter, Precision};
use texmap_scene::{Scene, Shading, TextureRole};

use crate::textures::Textures;
use crate::{EnvironmentChoice, IdleLight, ShadowChoice, lights, maps};

/// The largest errors that a picture may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Texels, for interpolation.
    pub texels: f64,
    /// Root mean square error of the colour as it is stored (0 to 1), for filters.
    pub rmse: f64,
}

impl Default for Budget {
    /// Half a texel and 0.02.
    fn default() -> Self {
        Self {
            texels: 0.5,
            rmse: 0.02,
        }
    }
}

/// The choice for a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Interpolation of coordinates across its triangles.
    pub interp: Interp,
    /// Predicted largest error of `interp` in texels.
    pub predicted_texels: f64,
    /// Filter of its texture, and of a label over it; none if it has no texture.
    pub filter: Option<(Filter, Precision)>,
    /// The colour that stands for a texture of one colour: no look-up at all. Premultiplied, linear.
    pub constant: Option<[f32; 4]>,
    /// Predicted root mean square error of the look-ups, with its margin.
    pub predicted_rmse: f64,
    /// Nanoseconds a pixel by the table, interpolation and filter of all its samples.
    pub price: f64,
    /// Pixels that the pilot tried.
    pub tried: usize,
    /// Reason for the choice, in words.
    pub why: String,
    /// Features that the mesh does not need.
    pub left_out: Vec<&'static str>,
}

/// A plan: a choice for each mesh that has triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// The budget.
    pub budget: Budget,
    /// Samples a side of a pixel: `Settings::supersample` of texmap-render.
    pub supersample: u32,
    /// One for each mesh with triangles.
    pub meshes: Vec<Choice>,
    /// Lights that reach nothing.
    pub idle_lights: Vec<IdleLight>,
    /// The shadow maps of the other lights.
    pub shadows: Vec<ShadowChoice>,
    /// The environments and specular maps that the picture reads.
    pub environments: Vec<EnvironmentChoice>,
}

impl Choices {
    /// True if every prediction fits the budget.
    pub fn met(&self) -> bool {
        self.meshes.iter().all(|c| {
            c.predicted_texels <= self.budget.texels && c.predicted_rmse <= self.budget.rmse
        })
    }

    /// The largest predicted error of a colour.
    pub(crate) fn worst(&self) -> f64 {
        let all = self.meshes.iter().map(|c| c.predicted_rmse);
        all.fold(0.0, f64::max)
    }

    /// Changes the scene to what was chosen: each mesh gets a material of its own.
    pub fn apply(&self, scene: &mut Scene) {
        let textures = scene.textures.clone();
        let textures = Textures::new(&textures);
        for choice in &self.meshes {
            let Some(mesh) = scene.meshes.get_mut(choice.mesh) else {
                continue;
            };
            let Some(mut material) = scene.materials.get(mesh.material).cloned() else {
                continue;
            };
            material.interp = choice.interp;
            maps::drop_constant(&textures, &mut material);
            if let Some([r, g, b, _]) = choice.constant {
                material.base_color = None;
                if material.texture_role == TextureRole::Decal {
                    material.phong.color = [r, g, b];
                    material.shading = Shading::Unlit;
                } else {
                    let [x, y, z] = material.phong.color;
                    material.phong.color = [x * r, y * g, z * b];
                }
            }
            if let (Some(slot), Some((filter, precision))) =
                (&mut material.base_color, choice.filter)
            {
                for slot in std::iter::once(slot).chain(&mut material.decal) {
                    slot.sampler.filter = filter;
                    slot.sampler.precision = precision;
                }
            }
            mesh.material = scene.materials.len();
            scene.materials.push(material);
        }
        lights::apply(&self.idle_lights, &self.shadows, scene);
    }
}
