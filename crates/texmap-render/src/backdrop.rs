//! What stands behind everything: a picture stretched over the frame, or an environment seen from inside.

use std::sync::LazyLock;

use texmap_light::lanes::RayLanes;
use texmap_light::{Environment, Ray};
use texmap_math::fearless_simd::{f32x16, prelude::*};
use texmap_math::glam::DMat4;
use texmap_math::lanes::below;
use texmap_math::simd::X16;
use texmap_math::{Level, ViewRays, on_wide_level};
use texmap_raster::DepthTest;

use crate::canvas::{Colors, LANES};
use crate::coordinates::EyeRays;
use crate::plan::Surface;
use crate::shade::Run;
use crate::texel::clip;
use crate::vertices::VertexData;
use texmap_scene::{AlphaMode, Material, Mesh, Shading, TextureRole};

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
    /// Through the places of a pixel that are looked up: one or more for each texel that it sees.
    rays: Vec<EyeRays>,
}

impl<'s> SkyStage<'s> {
    pub(crate) fn new(
        environment: &'s Environment,
        rays: &ViewRays,
        view_from_world: DMat4,
    ) -> Self {
        let (width, height) = environment.size();
        let texels = f64::from(width) * f64::from(height) * environment.chart().faces() as f64;
        let texel = (4.0 * std::f64::consts::PI / texels).sqrt();
        let side = (rays.step() / texel).ceil().clamp(1.0, 8.0) as u32;
        let middle = EyeRays::new(rays, view_from_world);
        let inside = |k: u32| (f64::from(k) + 0.5) / f64::from(side) - 0.5;
        let places = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
        Self {
            environment,
            rays: places
                .map(|(i, j)| middle.beside([inside(i), inside(j)]))
                .collect(),
        }
    }

    pub(crate) fn shade(&self, level: Level, run: &Run<'_>, out: &mut Colors) {
        let count = self.rays.len() as f32;
        on_wide_level!(
            level,
            s => {
                let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
                for (i, at) in run.run.iter().enumerate() {
                    let pixel = run.pixel(*at, 0);
                    let mut sum = [zero; 3];
                    for rays in &self.rays {
                        let [x, y, z] = rays.block(s, pixel);
                        let ray = RayLanes { direction: [-x, -y, -z], dx: [zero; 3], dy: [zero; 3] };
                        let light = self.environment.radiance(X16(s), &ray);
                        for k in 0..3 {
                            sum[k] += light[k];
                        }
                    }
                    let lanes = i * LANES..(i + 1) * LANES;
                    for (column, c) in out.0.iter_mut().zip(sum) {
                        let mean = below(c / f32x16::splat(s, count), one);
                        mean.store_slice(&mut column[lanes.clone()]);
                    }
                    out.0[3][lanes].fill(1.0);
                }
            },
            else for (place, at, bit) in run.places() {
                let pixel = run.pixel(at, bit);
                let mut sum = [0.0; 3];
                for rays in &self.rays {
                    let direction = rays.at(pixel).map(|c| -c);
                    let light = self.environment.light_across(&Ray { direction, ..Ray::default() });
                    sum = [0, 1, 2].map(|k| sum[k] + light[k]);
                }
                for (column, sum) in out.0.iter_mut().zip(sum) {
                    column[place] = clip(sum / count);
                }
                out.0[3][place] = 1.0;
            }
        );
    }
}
