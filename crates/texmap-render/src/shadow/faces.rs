//! The faces of a shadow map: their views, and the conversion of their depths.

use texmap_light::{EnvironmentLayout, ShadowKind};
use texmap_math::glam::{DMat4, DVec2, DVec3, DVec4};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{DepthStrip, TILE};

use texmap_scene::Scene;
use texmap_scene::shadow_fit::world_positions;

/// One face of a map: a view, and the way from its depth buffer to the metric of the map.
pub(super) struct FaceView {
    pub(super) clip_from_world: DMat4,
    metric: Metric,
}

enum Metric {
    /// Depth 1 is at the first distance, 0 at the second.
    Linear(f64, f64),
    /// `near / distance along the axis`.
    Reciprocal(f64),
    /// `near / distance along the axis`, where the metric is the distance from the light.
    Distance(f64),
}

impl FaceView {
    /// Converts depths of a face's buffer to those of its map, each moved by `reach` texels of slope. True if all are numbers, and none
    /// is below 0 but under parallel light.
    pub(super) fn measure(
        &self,
        level: Level,
        strip: &mut DepthStrip<'_>,
        size: u32,
        reach: f64,
    ) -> bool {
        // The same operations at every level: only the compiler's vectors differ.
        dispatch_simd!(level, _i => self.measure_strip(strip, size, reach))
    }

    #[inline(always)]
    fn measure_strip(&self, strip: &mut DepthStrip<'_>, size: u32, reach: f64) -> bool {
        match self.metric {
            Metric::Linear(near, far) => {
                each_reached(strip, size, f32::NEG_INFINITY, |_, depth| {
                    near + (1.0 - depth) * (far - near)
                })
            }
            Metric::Reciprocal(near) => each_reached(strip, size, 0.0, |_, depth| near / depth),
            Metric::Distance(near) => {
                // A plane square to the axis becomes farther away from the middle of the face.
                let step = 2.0 / f64::from(size);
                let centre = |i: usize| ((i as f64 + 0.5) * step - 1.0).abs() + reach * step;
                each_reached(strip, size, 0.0, |[x, y], depth| {
                    let p = DVec2::new(centre(x), centre(y));
                    near / depth * (1.0 + p.length_squared()).sqrt()
                })
            }
        }
    }
}

/// Replaces depths above 0 by distances, and 0 by infinity, in the tiles of a strip that are reached. The arguments of `distance`
/// are column and row, and the depth. True if all are numbers from `least` on.
#[inline(always)]
fn each_reached(
    strip: &mut DepthStrip<'_>,
    size: u32,
    least: f32,
    distance: impl Fn([usize; 2], f64) -> f64,
) -> bool {
    const SIDE: usize = TILE as usize;
    let mut good = true;
    for (y, row) in strip.rows.chunks_mut(size as usize).enumerate() {
        let y = strip.first_row + y;
        let parts = row.chunks_mut(SIDE).enumerate().zip(strip.reached);
        for ((column, part), _) in parts.filter(|(_, reached)| **reached) {
            for (x, depth) in part.iter_mut().enumerate() {
                let way = distance([column * SIDE + x, y], f64::from(*depth)) as f32;
                let way = if *depth > 0.0 { way } else { f32::INFINITY };
                good &= way >= least;
                *depth = way;
            }
        }
    }
    good
}

/// The faces of a map.
pub(super) fn views(scene: &Scene, kind: &ShadowKind) -> Vec<FaceView> {
    match *kind {
        ShadowKind::Directional {
            light_from_world,
            half,
        } => {
            // From the first to the last vertex along the light, with a little air.
            let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in world_positions(scene) {
                let z = -light_from_world.transform_point3(p).z;
                (near, far) = (near.min(z), far.max(z));
            }
            if near > far {
                (near, far) = (0.0, 1.0);
            }
            let air = 1e-3 * (far - near) + 1e-6;
            let (near, far) = (near - air, far + air);
            let depth = 1.0 / (far - near);
            let clip = DMat4::from_cols(
                DVec4::X / half,
                DVec4::Y / half,
                DVec4::Z * depth,
                DVec4::new(0.0, 0.0, far * depth, 1.0),
            );
            vec![FaceView {
                clip_from_world: clip * light_from_world,
                metric: Metric::Linear(near, far),
            }]
        }
        ShadowKind::Spot {
            light_from_world,
            tan_half,
        } => {
            let near = nearness(
                scene,
                light_from_world.inverse().transform_point3(DVec3::ZERO),
            );
            let (x, y) = (DVec4::X / tan_half, DVec4::Y / tan_half);
            vec![FaceView {
                clip_from_world: DMat4::from_cols(x, y, DVec4::NEG_W, DVec4::Z * near)
                    * light_from_world,
                metric: Metric::Reciprocal(near),
            }]
        }
        ShadowKind::Point { position } => {
            let near = nearness(scene, position);
            let face = |face: usize| {
                let at = |u: f64, v: f64| {
                    let d = EnvironmentLayout::Cube.direction(face, DVec2::new(u, v));
                    d / d.abs().max_element()
                };
                let forward = at(0.5, 0.5);
                let (right, up) = (at(1.0, 0.5) - forward, at(0.5, 0.0) - forward);
                let row = |axis: DVec3| axis.extend(-axis.dot(position));
                // Rows x, y, z, w of the clip matrix.
                DMat4::from_cols(row(right), row(up), DVec4::W * near, row(forward)).transpose()
            };
            (0..6)
                .map(|i| FaceView {
                    clip_from_world: face(i),
                    metric: Metric::Distance(near),
                })
                .collect()
        }
    }
}

/// A near plane so close that only surfaces almost at the light are cut off. Reversed float depth loses no precision by it.
fn nearness(scene: &Scene, light: DVec3) -> f64 {
    let farthest = world_positions(scene)
        .map(|p| (p - light).length_squared())
        .fold(0.0, f64::max)
        .sqrt();
    (1e-5 * farthest).max(1e-12)
}
