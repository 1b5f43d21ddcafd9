//! What stands behind everything: a picture stretched over the frame, or an environment seen from inside.

use std::sync::LazyLock;

use texmap_light::Environment;
use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_raster::DepthTest;

use crate::canvas::Colors;
use crate::coordinates::Rays;
use crate::plan::Surface;
use crate::shade::Run;
use crate::vertices::VertexData;
use crate::{AlphaMode, Material, Mesh, Shading, TextureRole, TextureSlot};

/// A sky. It is drawn over the background colour and under everything else, and leaves no trace in output arrays.
#[derive(Clone, Debug, PartialEq)]
pub enum Backdrop {
    /// The picture is stretched over the whole frame, whatever its shape and wherever the camera looks: an opaque texel
    /// hides the background colour.
    Picture(TextureSlot),
    /// The light of [`Effects::environments`](crate::Effects) in the direction of each pixel.
    Environment(usize),
}

/// The frame in clip space, at no depth.
static FRAME: LazyLock<Mesh> = LazyLock::new(|| Mesh {
    name: "backdrop".into(),
    positions: vec![
        [-1.0, 1.0, 0.0],
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
    ],
    uvs: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
    triangles: vec![[0, 1, 2], [0, 2, 3]],
    ..Mesh::default()
});

static MATERIAL: LazyLock<Material> = LazyLock::new(|| Material {
    name: "backdrop".into(),
    shading: Shading::Unlit,
    texture_role: TextureRole::Decal,
    // Blended surfaces are drawn where nothing nearer is, and leave the arrays alone.
    alpha: AlphaMode::Blend,
    ..Material::default()
});

/// A surface over the whole frame, behind all others. It still lacks its colour.
pub(crate) fn behind<'s>() -> Surface<'s> {
    let mesh = &*FRAME;
    let vertices = VertexData::of(mesh, mesh.uvs.as_flattened().to_vec(), 2);
    Surface::bare(
        mesh,
        &MATERIAL,
        vertices,
        DMat4::IDENTITY,
        DepthTest::LessOrEqual,
    )
}

/// An environment as the stages read it.
pub(crate) struct SkyStage<'s> {
    environment: &'s Environment,
    rays: Rays,
    world_from_view: DMat3,
    /// Look-ups a side of a pixel: one or more for each texel that it sees.
    side: u32,
}

impl<'s> SkyStage<'s> {
    pub(crate) fn new(environment: &'s Environment, rays: Rays, view_from_world: DMat4) -> Self {
        let (width, height) = environment.size();
        let texels = f64::from(width) * f64::from(height) * environment.chart().faces() as f64;
        let texel = (4.0 * std::f64::consts::PI / texels).sqrt();
        let side = (rays.step() / texel).ceil().clamp(1.0, 8.0) as u32;
        Self {
            environment,
            rays,
            world_from_view: DMat3::from_mat4(view_from_world).transpose(),
            side,
        }
    }

    pub(crate) fn shade(&self, run: &Run<'_>, out: &mut Colors) {
        for (place, at, bit) in run.places() {
            let pixel = run.pixel(at, bit);
            let mut sum = DVec3::ZERO;
            for (i, j) in (0..self.side).flat_map(|j| (0..self.side).map(move |i| (i, j))) {
                let inside = |k: u32| (f64::from(k) + 0.5) / f64::from(self.side) - 0.5;
                let ray = self.rays.through(pixel, [inside(i), inside(j)]);
                let toward = (self.world_from_view * ray).as_vec3().to_array();
                sum += DVec3::from(self.environment.light(toward).map(f64::from));
            }
            let light = (sum / f64::from(self.side * self.side)).to_array();
            for (column, value) in out.0.iter_mut().zip(light) {
                column[place] = crate::texel::clip(value as f32);
            }
            out.0[3][place] = 1.0;
        }
    }
}
