//! Volumes in a scene: a box of matter that shines and absorbs, between the eye and what is solid.

use std::sync::LazyLock;

use texmap_math::Level;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{Cull, DepthTest};
use texmap_sample::{Sampler, Texture2d};

use crate::canvas::Colors;
use crate::check::index;
use crate::coordinates::Rays;
use crate::plan::Surface;
use crate::shade::Run;
use crate::solid::has_volume;
use crate::texel::clip;
use crate::vertices::VertexData;
use crate::{AlphaMode, Effects, Material, Mesh, RenderError, Scene, Shading, TextureSlot};

/// A box of matter, marched through at every pixel up to the solid surface there; blended over everything else, several in
/// the order of their list. It throws and takes no shadows, and leaves no trace in output arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Index into [`Effects::grids`].
    pub grid: usize,
    /// How the grid is read; its wrap modes are not.
    pub sampler: Sampler,
    /// The transfer function: a row of texels along which the grid's first channel is looked up. Its colour shines, its alpha
    /// is the density. Without one, see [`texmap_sample::Volume`].
    pub transfer: Option<TextureSlot>,
    /// Extinction of density 1 per world unit: through a length L of it shows `exp(-density L)` of what is behind.
    pub density: f32,
    /// World units between look-ups.
    pub step: f32,
    /// Where the grid's unit cube stands: column 0 of the grid at x = 0, row 0 at y = 0, slice 0 at z = 0. Not flat.
    pub world_from_volume: DMat4,
}

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

impl Volume {
    /// What a check of the scene finds wrong with it.
    pub(crate) fn check(&self, number: usize, effects: &Effects) -> Result<(), RenderError> {
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

fn fault(number: usize, what: &str, value: String) -> RenderError {
    RenderError::Value {
        place: format!("volume {number}"),
        what: what.to_owned(),
        value,
        expected: "the density must be finite and not negative, the step finite and above 0, no side of the box 0",
    }
}

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
    rays: Rays,
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
        rays: Rays,
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
        .map_err(|error| fault(volume.grid, "numbers", error.to_string()))?
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
