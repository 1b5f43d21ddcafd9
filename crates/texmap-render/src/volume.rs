//! Volumes in a scene: a box of matter that shines and absorbs, between the eye and what is solid.

use std::sync::LazyLock;
use texmap_scene::SceneError;

use texmap_math::glam::{DMat4, DVec3};
use texmap_math::{Level, ViewRays};
use texmap_raster::{Cull, DepthTest};
use texmap_sample::{Sampler, Texture2d};

use crate::canvas::Colors;

use crate::RenderError;
use crate::plan::Surface;
use crate::shade::Run;
use crate::texel::clip;
use crate::vertices::VertexData;
use texmap_scene::{AlphaMode, Material, Mesh, Scene, Shading, Volume};

/// The unit cube, fronts outwards.
static CUBE: LazyLock<Mesh> = LazyLock::new(|| Mesh {
    name: "volume".into(),
    positions: (0..8u8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from))
        .collect(),
    triangles: [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ]
    .into_iter()
    .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
    .collect(),
    ..Mesh::default()
});

static MATERIAL: LazyLock<Material> = LazyLock::new(|| Material {
    name: "volume".into(),
    shading: Shading::Unlit,
    alpha: AlphaMode::Blend,
    // The far sides cover what the box covers, also for an eye inside of it.
    cull: Cull::Front,
    ..Material::default()
});

/// The far sides of a volume's box, whatever stands before them. They still lack their stage.
pub(crate) fn far_sides<'s>(volume: &Volume, clip_from_world: DMat4) -> Surface<'s> {
    let mesh = &*CUBE;
    let mut vertices = VertexData::of(mesh, Vec::new(), 0);
    if volume.world_from_volume.determinant() < 0.0 {
        vertices
            .triangles
            .to_mut()
            .iter_mut()
            .for_each(|t| t.swap(1, 2));
    }
    Surface::bare(
        mesh,
        &MATERIAL,
        vertices,
        clip_from_world * volume.world_from_volume,
        DepthTest::Always,
    )
}

/// A volume as the stages read it.
pub(crate) struct VolumeStage<'s> {
    matter: texmap_sample::Volume<'s>,
    rays: ViewRays,
    /// The eye, and the matrix of directions, in the space of the grid.
    eye: DVec3,
    volume_from_view: DMat4,
    /// `depth = offset + scale / distance` along the view.
    depth: (f64, f64),
}

impl<'s> VolumeStage<'s> {
    pub(crate) fn new(
        volume: &'s Volume,
        scene: &'s Scene,
        transfer: Option<(&'s Texture2d<'static>, &'s Sampler)>,
        rays: ViewRays,
        level: Level,
        view_from_world: DMat4,
        projection: DMat4,
    ) -> Result<Self, RenderError> {
        let grid = &scene.effects.grids[volume.grid];
        let matter = texmap_sample::Volume::new(
            grid,
            &volume.sampler,
            transfer,
            volume.density,
            volume.step,
        )
        .map_err(|error| SceneError::Value {
            place: format!("volume of grid {}", volume.grid),
            what: "its numbers".to_owned(),
            value: error.to_string(),
            expected: "see Scene::check",
        })?
        .on_level(level);
        let volume_from_world = volume.world_from_volume.inverse();
        Ok(Self {
            matter,
            rays,
            eye: volume_from_world.transform_point3(scene.camera.eye),
            volume_from_view: volume_from_world * view_from_world.inverse(),
            depth: (-projection.z_axis.z, projection.w_axis.z),
        })
    }

    pub(crate) fn shade(&self, run: &Run<'_>, out: &mut Colors) {
        for (place, at, bit) in run.places() {
            let ray = self.rays.through(run.pixel(at, bit));
            let length = ray.length();
            let along = self.volume_from_view.transform_vector3(ray / length);
            let (offset, scale) = self.depth;
            let near = f64::from(run.depth(at, bit)) - offset;
            let solid = if near > 0.0 {
                scale / near * length
            } else {
                f64::INFINITY
            };
            let seen = self
                .matter
                .march(self.eye.to_array(), along.to_array(), (0.0, solid));
            let [r, g, b, a] = seen.color;
            for (column, value) in out.0.iter_mut().zip([clip(r), clip(g), clip(b), a]) {
                column[place] = value;
            }
        }
    }
}
