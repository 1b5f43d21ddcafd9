//! Shadow maps: the scene's depth as a light sees it, by the rasterizer's depth pass.

mod faces;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use texmap_light::{Light, Reached, ShadowBias, ShadowBounds, ShadowKind, ShadowMap, StripBounds};
use texmap_math::Level;
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{AlphaTest, Cull, DepthTest, Draw, Pass, Prepared, TILE, TargetSize};

use crate::shadow_cut::Cuts;
use crate::vertices::wide;
use crate::{AlphaMode, Mesh, RenderError, Scene};
use faces::views;

/// Cosine and tangent of 85 degrees, half the widest pyramid.
const LEAST_COS: f64 = 0.087;
const MOST_TAN: f64 = 11.43;

/// The part of a scene that a shadow map of a light shows.
///
/// A directional light gets the square around everything that casts a shadow, or around `area` (a centre and half a side), a
/// spot light the pyramid around its outer cone, a point light all directions, or the pyramid that shows `area`.
///
/// # Errors
/// [`RenderError::Index`] for a light that does not exist, [`RenderError::Value`] for one that has no shadow map (ambient light, a
/// spot light of 85 degrees and more from its axis) or an area that is not finite and positive.
pub fn shadow_kind(
    scene: &Scene,
    light: usize,
    area: Option<(DVec3, f64)>,
) -> Result<ShadowKind, RenderError> {
    let place = || format!("shadow of light {light}");
    let value = |what: &str, value: String, expected| RenderError::Value {
        place: place(),
        what: what.to_owned(),
        value,
        expected,
    };
    let good = |centre: DVec3, half: f64| centre.is_finite() && half.is_finite() && half > 0.0;
    let bad_area = |centre: DVec3, half: f64| {
        value(
            "area",
            format!("{centre}, half a side {half}"),
            "it must be finite and of some size, and seen from a point light within 85 degrees of its centre",
        )
    };
    let source = scene.lights.get(light).ok_or(RenderError::Index {
        place: place(),
        what: "light",
        index: light as u64,
        count: scene.lights.len(),
    })?;
    match *source {
        Light::Directional { direction, .. } => {
            let (centre, half) = area.unwrap_or_else(|| around(scene));
            if !good(centre, half) {
                return Err(bad_area(centre, half));
            }
            Ok(ShadowKind::Directional {
                light_from_world: toward(centre, wide(direction)),
                half,
            })
        }
        Light::Point { position, .. } => {
            let position = wide(position);
            let Some((centre, half)) = area else {
                return Ok(ShadowKind::Point { position });
            };
            let way = centre - position;
            if !(good(centre, half) && half < MOST_TAN * way.length()) {
                return Err(bad_area(centre, half));
            }
            Ok(ShadowKind::Spot {
                light_from_world: toward(position, way),
                tan_half: half / way.length(),
            })
        }
        Light::Spot {
            position,
            direction,
            cos_outer,
            ..
        } => {
            let cos = f64::from(cos_outer);
            if cos < LEAST_COS {
                return Err(value(
                    "cosine of its outer cone",
                    cos.to_string(),
                    "a spot light with a shadow must stay within 85 degrees of its axis: make it a point light",
                ));
            }
            Ok(ShadowKind::Spot {
                light_from_world: toward(wide(position), wide(direction)),
                tan_half: (1.0 - cos * cos).sqrt() / cos,
            })
        }
        _ => Err(value(
            "kind",
            "ambient".to_owned(),
            "only directional, point and spot lights have shadows",
        )),
    }
}

/// Draws a shadow map of `size` x `size` texels (a face): what each light ray meets first, of all opaque and cut-out meshes
/// without the holes of these; blended ones cast nothing. The same bits for any number of `threads`.
///
/// # Errors
/// [`RenderError::Raster`] for sizes above 16384 and meshes that the rasterizer refuses.
pub fn shadow_map(
    scene: &Scene,
    kind: &ShadowKind,
    size: u32,
    threads: usize,
) -> Result<ShadowMap, RenderError> {
    shadow_map_in(scene, kind, size, 1, threads, Vec::new()).map(|(map, _)| map)
}

/// [`shadow_map`] in the room of an earlier one, with the bounds that look-ups of `taps` x `taps` comparisons ask for.
pub(crate) fn shadow_map_in(
    scene: &Scene,
    kind: &ShadowKind,
    size: u32,
    taps: u32,
    threads: usize,
    mut room: Vec<f32>,
) -> Result<(ShadowMap, ShadowBounds), RenderError> {
    let target =
        TargetSize::new(size, size).map_err(|error| RenderError::of_raster(scene, error))?;
    let cuts = Cuts::new(scene);
    let mut depths = Vec::new();
    let flat = !matches!(kind, ShadowKind::Point { .. });
    let (strips, good) = (Mutex::new(Vec::new()), AtomicBool::new(true));
    for view in views(scene, kind) {
        let draws: Vec<Draw<'_>> = scene
            .meshes
            .iter()
            .enumerate()
            .map(|(i, mesh)| {
                let holes = cuts.as_ref().and_then(|cuts| cuts.attributes(i));
                let (attributes, attribute_count) = holes.unwrap_or_default();
                Draw {
                    positions: &mesh.positions,
                    indices: &mesh.triangles,
                    clip_from_object: view.clip_from_world * mesh.world_from_object,
                    attributes,
                    attribute_count,
                    cull: hidden_sides(mesh, kind),
                    depth_test: DepthTest::Less,
                    pass: match scene.materials[mesh.material].alpha {
                        _ if mesh.shadowless => Pass::Blended,
                        AlphaMode::Blend => Pass::Blended,
                        _ if holes.is_some() => Pass::CutOut,
                        _ => Pass::Opaque,
                    },
                    ..Draw::default()
                }
            })
            .collect();
        let prepared = Prepared::with_level(target, &draws, Level::new(), threads)
            .map_err(|error| RenderError::of_raster(scene, error))?;
        let mut map = std::mem::take(&mut room);
        let alpha = cuts.as_ref().map(|cuts| cuts as &(dyn AlphaTest + Sync));
        prepared.depth_strips(threads, alpha, f32::INFINITY, &mut map, &|mut strip| {
            let fine = view.measure(&mut strip, size);
            if !fine {
                good.store(false, Ordering::Relaxed);
            }
            if flat {
                let reached = Reached {
                    parts: strip.reached,
                    side: TILE as usize,
                };
                let (rows, first) = (&*strip.rows, strip.first_row);
                let found = StripBounds::new(rows, size as usize, taps, first, reached);
                if let Ok(mut strips) = strips.lock() {
                    strips.push(found);
                }
            }
        });
        if depths.is_empty() {
            depths = map;
        } else {
            depths.extend(map);
        }
    }
    let bounds = ShadowBounds::join(strips.into_inner().unwrap_or_default());
    let map = if good.into_inner() {
        ShadowMap::of_good(*kind, size, depths)
    } else {
        ShadowMap::new(*kind, size, depths)
    };
    let map = map.map_err(|error| RenderError::Value {
        place: "shadow map".to_owned(),
        what: "depths".to_owned(),
        value: error.to_string(),
        expected: "all depths must be finite",
    })?;
    Ok((map, bounds))
}

/// Sides of a mesh's faces that a shadow map leaves out: the fronts of a closed mesh hide its backs.
fn hidden_sides(mesh: &Mesh, kind: &ShadowKind) -> Cull {
    let (ShadowKind::Directional {
        light_from_world, ..
    }
    | ShadowKind::Spot {
        light_from_world, ..
    }) = kind
    else {
        return Cull::None;
    };
    let turns = light_from_world.determinant() * mesh.world_from_object.determinant();
    if mesh.closed && turns > 0.0 {
        Cull::Back
    } else if mesh.closed && turns < 0.0 {
        Cull::Front
    } else {
        Cull::None
    }
}

/// The bias that leaves neither acne nor detached shadows on planes: the slope form with a constant of 1e-4 of the scene's size.
#[must_use]
pub fn shadow_bias(scene: &Scene) -> ShadowBias {
    let (_, half) = around(scene);
    ShadowBias::Slope(2e-4 * half)
}

/// Centre and half a side of a square that holds everything from any direction: of the ball around the box.
pub(crate) fn around(scene: &Scene) -> (DVec3, f64) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in points(scene) {
        (low, high) = (low.min(p), high.max(p));
    }
    if low.x > high.x {
        return (DVec3::ZERO, 1.0);
    }
    let half = 0.5 * (high - low).length();
    (
        0.5 * (low + high),
        if half > 0.0 { half * 1.001 } else { 1.0 },
    )
}

/// All vertices, world space.
fn points(scene: &Scene) -> impl Iterator<Item = DVec3> + '_ {
    scene.meshes.iter().flat_map(|mesh| {
        mesh.positions
            .iter()
            .map(|p| mesh.world_from_object.transform_point3(wide(*p)))
    })
}

/// World to the space of a light at `position` that looks along `direction` (not zero).
fn toward(position: DVec3, direction: DVec3) -> DMat4 {
    let direction = direction / direction.abs().max_element();
    // The axis that is least along the direction cannot be parallel to it.
    let a = direction.abs();
    let up = if a.y <= a.x && a.y <= a.z {
        DVec3::Y
    } else if a.z <= a.x {
        DVec3::Z
    } else {
        DVec3::X
    };
    let camera = Camera {
        eye: DVec3::ZERO,
        look: direction,
        up,
        fov_x: 1.0,
        near: 1.0,
        far: 2.0,
    };
    // Neither zero nor parallel, so there is a view.
    let view = camera.view().unwrap_or(DMat4::IDENTITY);
    view * DMat4::from_translation(-position)
}

/// Whether a point lies inside of a closed mesh: a ray in an odd direction leaves through an odd number of triangles.
pub(crate) fn encloses(mesh: &Mesh, point: DVec3) -> bool {
    let d = DVec3::new(0.612, 0.354, 0.709);
    let crossed = mesh.triangles.iter().filter(|t| {
        let [a, b, c] = t.map(|v| {
            mesh.world_from_object
                .transform_point3(wide(mesh.positions[v as usize]))
        });
        let (u, v) = (b - a, c - a);
        let p = d.cross(v);
        let (det, s) = (u.dot(p), point - a);
        let q = s.cross(u);
        let (x, y, t) = (s.dot(p) / det, d.dot(q) / det, v.dot(q) / det);
        x >= 0.0 && y >= 0.0 && x + y < 1.0 && t > 0.0
    });
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;

    /// A tetrahedron over a large floor.
    fn scene(light: Light) -> Scene {
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
            camera: Camera {
                eye: DVec3::new(0.0, 2.0, 5.0),
                look: DVec3::ZERO,
                up: DVec3::Y,
                fov_x: 1.0,
                near: 1e-4,
                far: f64::INFINITY,
            },
            background: [0.0; 4],
            color: crate::ColorMode::Srgb,
            depth_test: DepthTest::Less,
            lights: vec![light],
            textures: Vec::new(),
            materials: vec![Material::default()],
            meshes: vec![floor, top],
            warnings: Vec::new(),
            effects: Default::default(),
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
                    let stored = f64::from(map.stored(face, i % size, i / size).unwrap());
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
                map.lit(DVec3::new(x, 0.0, z), DVec3::Y, ShadowBias::Slope(1e-4), 1)
            };
            assert_eq!(
                (lit(0.0, 0.0), lit(1.5, 0.0), lit(0.0, -1.6)),
                (0.0, 1.0, 1.0),
                "{light:?}"
            );
        }
    }

    /// A closed mesh throws the shadow of an open one, mirrored too: texels at its outline may lie deeper, no other. The negative twin has
    /// its fronts inwards.
    #[test]
    fn fronts_of_closed_meshes_throw_the_whole_shadow() {
        let spot = Light::spot([1.0; 3], [0.3, 4.0, 0.5], [0.0, -1.0, -0.1], 0.5, 0.7);
        let down = [0.1, -1.0, 0.2];
        let sun = Light::Directional {
            color: [1.0; 3],
            direction: down,
        };
        for (light, mirrored) in [(spot, 1.0), (spot, -1.0), (sun, 1.0), (sun, -1.0)] {
            let mut scene = scene(light);
            scene.meshes.remove(0);
            scene.meshes[0].world_from_object = DMat4::from_scale(DVec3::new(mirrored, 1.0, 1.0));
            let kind = shadow_kind(&scene, 0, Some((DVec3::Y, 1.0))).unwrap();
            let size = 200;
            let map = |scene: &Scene| shadow_map(scene, &kind, size, 1).unwrap();
            let open = map(&scene);
            scene.meshes[0].closed = true;
            let closed = map(&scene);
            scene.meshes[0]
                .triangles
                .iter_mut()
                .for_each(|t| t.reverse());
            let inside_out = map(&scene);
            let (mut met, mut deeper, mut backs) = (0, 0, 0);
            for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
                let at = |map: &ShadowMap| map.stored(0, x, y).unwrap();
                let (a, b) = (at(&open), at(&closed));
                assert!(b >= a && b.is_finite() == a.is_finite(), "{x} {y}: {a} {b}");
                met += u32::from(a.is_finite());
                deeper += u32::from(b > a);
                backs += u32::from(at(&inside_out) > a);
            }
            assert!(
                met > 500 && deeper * 100 < met,
                "{mirrored}: {met} {deeper}"
            );
            assert!(backs * 2 > met, "{mirrored}: {met} {backs}");
        }
    }

    /// What the depth pass finds on its way is what a scan of its map finds, for any number of threads.
    #[test]
    fn bounds_from_the_depth_pass_are_those_of_the_map() {
        let light = Light::spot([1.0; 3], [0.0, 4.0, 0.0], [0.0, -1.0, 0.0], 0.5, 0.7);
        let mut scene = scene(light);
        scene.meshes.remove(0);
        let kind = shadow_kind(&scene, 0, None).unwrap();
        for (size, taps, threads) in [(64, 1, 1), (300, 3, 2), (520, 15, 2)] {
            let (map, bounds) =
                shadow_map_in(&scene, &kind, size, taps, threads, vec![7.0; 9]).unwrap();
            let depths = (0..size * size).map(|i| map.stored(0, i % size, i / size).unwrap());
            let depths: Vec<f32> = depths.collect();
            assert!(depths.contains(&f32::INFINITY) && depths.iter().any(|d| d.is_finite()));
            let whole = Reached {
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
            Err(RenderError::Index { .. })
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
