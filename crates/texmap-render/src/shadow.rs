//! Shadow maps: the scene's depth as a light sees it, by the rasterizer's depth pass.

mod faces;
mod watertight;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use texmap_scene::SceneError;

use texmap_light::{FiniteColumns, ShadowBias, ShadowBounds, ShadowKind, ShadowMap, StripBounds};
use texmap_math::{Level, MemoryBudget};
use texmap_raster::{
    AlphaTest, BinnedDraws, DepthTest, DrawCall, GrazingFacets, Pass, TILE, TargetSize,
};

use crate::RenderError;
use crate::frame_resources::reserve_map;
use crate::shadow_alpha_test::AlphaTests;
use faces::views;
use texmap_scene::{AlphaMode, Scene};
use watertight::hidden_sides;

/// Draws a shadow map of `size` x `size` texels a face: depths of the first surfaces along light rays. Opaque and cut-out meshes
/// cast shadows, but for the holes of cut-outs; blended ones do not. The same bits for any number of `threads`.
///
/// # Errors
/// [`RenderError::Raster`] for sizes above 16384 and meshes that the rasterizer refuses.
pub fn shadow_map(
    scene: &Scene,
    kind: &ShadowKind,
    size: u32,
    threads: usize,
) -> Result<ShadowMap, RenderError> {
    shadow_map_for(scene, kind, size, ShadowBias::Constant(0.0), 1, threads)
}

/// [`shadow_map`] for look-ups with a bias and `taps` x `taps` comparisons: under [`ShadowBias::Planes`] every depth is moved away from
/// the light by [`caster_reach`](ShadowBias::caster_reach) texels of its triangle's slope, and in the strips that the light sees of
/// triangles almost on edge to their far ends. Under any other bias it is that of [`shadow_map`].
///
/// # Errors
/// Those of [`shadow_map`].
pub fn shadow_map_for(
    scene: &Scene,
    kind: &ShadowKind,
    size: u32,
    bias: ShadowBias,
    taps: u32,
    threads: usize,
) -> Result<ShadowMap, RenderError> {
    let mut buffer = Vec::new();
    reserve_map(MemoryBudget::of_process(), kind, size, &mut buffer)?;
    shadow_map_in(scene, kind, size, (bias, taps), threads, buffer).map(|(map, _)| map)
}

/// [`shadow_map_for`] in the buffer of an earlier map, with its bounds. Look-ups take `taps` x `taps` comparisons.
pub(crate) fn shadow_map_in(
    scene: &Scene,
    kind: &ShadowKind,
    size: u32,
    (bias, taps): (ShadowBias, u32),
    threads: usize,
    mut buffer: Vec<f32>,
) -> Result<(ShadowMap, ShadowBounds), RenderError> {
    let target =
        TargetSize::new(size, size).map_err(|error| RenderError::of_raster(scene, error))?;
    let cuts = AlphaTests::new(scene)?;
    let (level, reach) = (Level::new(), bias.caster_reach(taps));
    let mut depths = Vec::new();
    let mut bounds = Vec::new();
    let (strips, good) = (Mutex::new(Vec::new()), AtomicBool::new(true));
    let transforms: Vec<_> = scene
        .meshes
        .iter()
        .map(|mesh| mesh.world_from_object)
        .collect();
    for view in views(scene, kind) {
        let draws: Vec<DrawCall<'_>> = scene
            .meshes
            .iter()
            .enumerate()
            .map(|(i, mesh)| {
                let holes = cuts.as_ref().and_then(|cuts| cuts.attributes(i));
                let (attributes, attribute_count) = holes.unwrap_or_default();
                DrawCall {
                    positions: &mesh.positions,
                    indices: &mesh.triangles,
                    clip_from_object: view.clip_from_world * mesh.world_from_object,
                    attributes,
                    attribute_count,
                    cull: hidden_sides(mesh, kind),
                    depth_test: DepthTest::Less,
                    depth_slope: reach as f32,
                    pass: match scene.materials[mesh.material].alpha {
                        _ if mesh.casts_no_shadow => Pass::Blended,
                        AlphaMode::Blend => Pass::Blended,
                        _ if holes.is_some() => Pass::CutOut,
                        _ => Pass::Opaque,
                    },
                    ..DrawCall::default()
                }
            })
            .collect();
        let prepared = BinnedDraws::with_level(target, &draws, level, threads)
            .map_err(|error| RenderError::of_raster(scene, error))?;
        let grazing = (reach > 0.0).then(|| {
            let clip_from_world = view.clip_from_world;
            GrazingFacets::new(&draws, &transforms, clip_from_world, (size, taps), threads)
        });
        let mut map = std::mem::take(&mut buffer);
        let alpha = cuts.as_ref().map(|cuts| cuts as &(dyn AlphaTest + Sync));
        prepared.depth_strips(threads, alpha, f32::INFINITY, &mut map, &|mut strip| {
            if let Some(grazing) = &grazing {
                grazing.lower(&mut strip);
            }
            let fine = view.measure(level, &mut strip, size, reach);
            if !fine {
                good.store(false, Ordering::Relaxed);
            }
            let reached = FiniteColumns {
                parts: strip.reached,
                side: TILE as usize,
            };
            let (rows, first) = (&*strip.rows, strip.first_row);
            let found = StripBounds::new(rows, size as usize, taps, first, reached);
            if let Ok(mut strips) = strips.lock() {
                strips.push(found);
            }
        });
        let strips = strips.lock().map(|mut strips| std::mem::take(&mut *strips));
        bounds.push(ShadowBounds::join(strips.unwrap_or_default()));
        if depths.is_empty() {
            depths = map;
        } else {
            depths.extend_from_slice(&map);
            buffer = map;
        }
    }
    let map = if good.into_inner() {
        ShadowMap::from_valid(*kind, size, depths)
    } else {
        ShadowMap::new(*kind, size, depths)
    };
    let map = map.map_err(|error| SceneError::Value {
        place: "shadow map".to_owned(),
        what: "depths".to_owned(),
        value: error.to_string(),
        expected: "all depths must be finite",
    })?;
    Ok((map, ShadowBounds::of_faces(bounds)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_light::Light;
    use texmap_math::camera::Camera;
    use texmap_math::glam::DVec3;
    use texmap_math::wide;
    use texmap_scene::shadow_fit::shadow_kind;
    use texmap_scene::{Material, Mesh};

    /// A tetrahedron over a large floor.
    pub(super) fn scene(light: Light) -> Scene {
        let floor = Mesh {
            positions: vec![
                [-4.0, 0.0, -4.0],
                [4.0, 0.0, -4.0],
                [4.0, 0.0, 4.0],
                [-4.0, 0.0, 4.0],
            ],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
            ..Mesh::default()
        };
        let top = Mesh {
            positions: vec![
                [0.0, 1.5, 0.0],
                [0.6, 0.7, 0.5],
                [-0.6, 0.7, 0.5],
                [0.0, 0.7, -0.7],
            ],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Mesh::default()
        };
        Scene {
            background: [0.0; 4],
            lights: vec![light],
            materials: vec![Material::default()],
            meshes: vec![floor, top],
            ..Scene::new(Camera {
                eye: DVec3::new(0.0, 2.0, 5.0),
                look: DVec3::ZERO,
                up: DVec3::Y,
                fov_x: 1.0,
                near: 1e-4,
                far: f64::INFINITY,
                lens: Default::default(),
            })
        }
    }

    /// Distance along a ray to the nearest triangle, by brute force.
    fn trace(scene: &Scene, o: DVec3, d: DVec3) -> f64 {
        let mut nearest = f64::INFINITY;
        for mesh in &scene.meshes {
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|v| wide(mesh.positions[v as usize]));
                let (u, v) = (b - a, c - a);
                let p = d.cross(v);
                let (det, s) = (u.dot(p), o - a);
                let q = s.cross(u);
                let (x, y, t) = (s.dot(p) / det, d.dot(q) / det, v.dot(q) / det);
                if x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 0.0 && t < nearest {
                    nearest = t;
                }
            }
        }
        nearest
    }

    /// Every stored depth is the way along the light ray of its texel, in the map's own metric.
    #[test]
    fn depths_are_distances_along_the_rays_of_the_light() {
        let position = [1.0, 3.0, 1.5];
        let down = [-0.4, -1.0, -0.3];
        let lights = [
            Light::Directional {
                color: [1.0; 3],
                direction: down,
            },
            Light::spot([1.0; 3], position, down, 0.5, 0.8),
            Light::Point {
                color: [1.0; 3],
                position,
            },
        ];
        for light in lights {
            let scene = scene(light);
            let kind = shadow_kind(&scene, 0, None).unwrap();
            let size = 96;
            let map = shadow_map(&scene, &kind, size, 1).unwrap();
            assert_eq!(map, shadow_map(&scene, &kind, size, 2).unwrap(), "threads");
            let faces = if matches!(kind, ShadowKind::Point { .. }) {
                6
            } else {
                1
            };
            let (mut same, mut far, mut met) = (0u32, 0u32, 0u32);
            for face in 0..faces {
                for i in 0..size * size {
                    let (o, d) = ShadowMap::ray(&kind, size, face, i % size, i / size);
                    // Parallel rays start behind the plane of the light's origin.
                    let back = if matches!(kind, ShadowKind::Directional { .. }) {
                        20.0
                    } else {
                        0.0
                    };
                    let unit = if faces == 6 { d.normalize() } else { d };
                    let t = trace(&scene, o - unit * back, unit) - back;
                    let stored = f64::from(map.depth_at(face, i % size, i / size).unwrap());
                    if t.is_finite() || stored.is_finite() {
                        met += 1;
                        // Texels at edges may fall either way: positions are snapped to 1/256.
                        if (t - stored).abs() < 2e-5 * (1.0 + t.abs()) {
                            same += 1;
                        } else {
                            far += 1;
                        }
                    }
                }
            }
            assert!(met > 1_000 && far * 100 < same, "{kind:?}: {same} {far}");
        }
    }

    /// The floor under the tetrahedron is dark and the rest is lit, for each kind of light.
    #[test]
    fn maps_from_the_depth_pass_cast_shadows() {
        let lights = [
            Light::Directional {
                color: [1.0; 3],
                direction: [0.0, -1.0, 0.0],
            },
            Light::spot([1.0; 3], [0.0, 4.0, 0.0], [0.0, -1.0, 0.0], 0.5, 0.7),
            Light::Point {
                color: [1.0; 3],
                position: [0.0, 4.0, 0.0],
            },
        ];
        for light in lights {
            let scene = scene(light);
            let kind = shadow_kind(&scene, 0, None).unwrap();
            let map = shadow_map(&scene, &kind, 256, 1).unwrap();
            let lit = |x: f64, z: f64| {
                map.visibility(DVec3::new(x, 0.0, z), DVec3::Y, ShadowBias::Slope(1e-4), 1)
            };
            assert_eq!(
                (lit(0.0, 0.0), lit(1.5, 0.0), lit(0.0, -1.6)),
                (0.0, 1.0, 1.0),
                "{light:?}"
            );
        }
    }

    /// The bounds found by the depth pass are those of a scan of the map, for any number of threads.
    #[test]
    fn bounds_from_the_depth_pass_are_those_of_the_map() {
        let light = Light::spot([1.0; 3], [0.0, 4.0, 0.0], [0.0, -1.0, 0.0], 0.5, 0.7);
        let mut scene = scene(light);
        scene.meshes.remove(0);
        let kind = shadow_kind(&scene, 0, None).unwrap();
        let bias = ShadowBias::Planes(1e-4);
        for (size, taps, threads) in [(64, 1, 1), (300, 3, 2), (520, 15, 2)] {
            let (map, bounds) =
                shadow_map_in(&scene, &kind, size, (bias, taps), threads, vec![7.0; 9]).unwrap();
            let depths = (0..size * size).map(|i| map.depth_at(0, i % size, i / size).unwrap());
            let depths: Vec<f32> = depths.collect();
            assert!(depths.contains(&f32::INFINITY) && depths.iter().any(|d| d.is_finite()));
            let whole = FiniteColumns {
                parts: &[true],
                side: size.next_multiple_of(32) as usize,
            };
            let whole =
                ShadowBounds::join([StripBounds::new(&depths, size as usize, taps, 0, whole)]);
            assert_eq!(bounds, whole, "{size} {taps}");
        }
    }

    #[test]
    fn lights_without_a_map_are_named() {
        let spot = Light::spot([1.0; 3], [0.0; 3], [0.0, -1.0, 0.0], 1.0, 1.5);
        let ambient = Light::Ambient { color: [1.0; 3] };
        for light in [spot, ambient] {
            let error = shadow_kind(&scene(light), 0, None).unwrap_err();
            assert!(error.to_string().contains("light 0"), "{error}");
        }
        assert!(matches!(
            shadow_kind(&scene(ambient), 3, None),
            Err(SceneError::Index { .. })
        ));
        let sun = Light::Directional {
            color: [1.0; 3],
            direction: [0.0, -1.0, 0.0],
        };
        assert!(shadow_kind(&scene(sun), 0, Some((DVec3::ZERO, 0.0))).is_err());
        let kind = shadow_kind(&scene(sun), 0, None).unwrap();
        assert!(matches!(
            shadow_map(&scene(sun), &kind, 0, 1),
            Err(RenderError::Raster { .. })
        ));
    }
}
