//! Grazing facets: triangles that the light meets almost on edge. In a shadow map they are narrow strips with few texels of their
//! own, so that a filter compares with the depths on both sides of a strip and with none between. The point behind the strip would be
//! in the shadow of the surface before it. Here such a texel's depth is moved to the far end of the strip.

mod facet;

use texmap_math::glam::{DMat3, DMat4, DVec3, DVec4, Vec3Swizzles};
use texmap_math::{parallel, wide};
use texmap_raster::{Cull, DepthStrip, DrawCall, Pass, TILE};
use texmap_scene::Mesh;

use facet::{Facet, any};

/// Tangent of the angle between a facet's normal and the light from which on the facet is a grazing one, texels of depth per texel.
const GRAZING: f64 = 4.0;

/// Part of the square around a texel in which facets that turn their inner side to the light are followed. They lie under what casts the
/// shadow, and from one to the next they would lead through a solid body.
const UNDER: f64 = 0.5;

/// The grazing facets of one face of a shadow map.
pub(super) struct GrazingFacets<'d> {
    draws: &'d [DrawCall<'d>],
    /// For each draw, true if it mirrors its mesh.
    mirrored: Vec<bool>,
    /// Texels a side of the map.
    size: u32,
    /// Half a side of the square around a texel's centre whose points read the texel, in texels.
    half: f64,
    /// Draw and triangle of the facets that reach each strip of rows.
    strips: Vec<Vec<[u32; 2]>>,
}

impl<'d> GrazingFacets<'d> {
    /// The facets of `draws`, one for each of the `meshes`, that may hide what lies behind them in a map of `size` x `size` texels
    /// from look-ups of `taps` x `taps` comparisons. Vertices that are not finite or behind the light's plane make no facet.
    pub(super) fn new(
        meshes: &[Mesh],
        draws: &'d [DrawCall<'d>],
        clip_from_world: DMat4,
        (size, taps): (u32, u32),
        threads: usize,
    ) -> Self {
        let mut facets = Self {
            draws,
            mirrored: meshes
                .iter()
                .map(|mesh| mesh.world_from_object.determinant() < 0.0)
                .collect(),
            size,
            half: 0.5 + f64::from(taps.min(15) / 2),
            strips: vec![Vec::new(); size.div_ceil(TILE) as usize],
        };
        // A point that all rays of light pass through, or the direction towards the light with a last coordinate of 0.
        let light = clip_from_world.inverse() * DVec4::Z;
        let pieces: Vec<_> = (0..draws.len())
            .filter(|draw| draws[*draw].pass == Pass::Opaque)
            .flat_map(|draw| {
                let starts = (0..draws[draw].indices.len()).step_by(parallel::PIECE);
                starts.map(move |start| (draw, start))
            })
            .collect();
        let find = |(draw, start)| facets.of_piece(&meshes[draw], light, [draw, start]);
        let found: Vec<Vec<_>> = match threads > 1 {
            true => parallel::map(pieces.into_iter(), find),
            false => pieces.into_iter().map(find).collect(),
        };
        for (place, [first, last]) in found.into_iter().flatten() {
            for strip in &mut facets.strips[first as usize..=last as usize] {
                strip.push(place);
            }
        }
        facets
    }

    /// The grazing facets of a piece of a draw's triangles, each with the first and the last strip that it reaches.
    fn of_piece(
        &self,
        mesh: &Mesh,
        light: DVec4,
        [draw, start]: [usize; 2],
    ) -> Vec<([u32; 2], [u32; 2])> {
        let angles = Angles::new(&mesh.world_from_object, light);
        let triangles = &self.draws[draw].indices[start..];
        let piece = triangles.iter().take(parallel::PIECE).zip(start..);
        let grazing = piece.filter(|(triangle, _)| {
            angles.grazing(triangle.map(|vertex| wide(mesh.positions[vertex as usize])))
        });
        let reaching = grazing.filter_map(|(_, triangle)| {
            let place = [draw as u32, triangle as u32];
            Some((place, self.reached(&self.facet(place)?)?))
        });
        reaching.collect()
    }

    /// The first and the last strip of rows in which a facet may change a texel; `None` outside of the map.
    fn reached(&self, facet: &Facet) -> Option<[u32; 2]> {
        let size = f64::from(self.size);
        let [low, high] = facet.bounds();
        let meets = low.max_element() <= size && high.min_element() >= 0.0;
        let strip = |y: f64| (y.clamp(0.0, size - 1.0) / f64::from(TILE)) as u32;
        meets.then(|| [strip(low.y), strip(high.y)])
    }

    /// A triangle as the map sees it; `None` if it is not finite, reaches behind the light's plane, or shows a side that is not drawn.
    fn facet(&self, [draw, triangle]: [u32; 2]) -> Option<Facet> {
        let mirrored = self.mirrored[draw as usize];
        let draw = &self.draws[draw as usize];
        let size = f64::from(self.size);
        let corners = draw.indices[triangle as usize].map(|vertex| {
            let clip = draw.clip_from_object * wide(draw.positions[vertex as usize]).extend(1.0);
            let p = clip.truncate() / clip.w;
            let on_map = DVec3::new((0.5 + 0.5 * p.x) * size, (0.5 - 0.5 * p.y) * size, p.z);
            if clip.w > 0.0 { on_map } else { DVec3::NAN }
        });
        let [a, b, c] = corners;
        // Rows go down: a front is clockwise here.
        let front = (b - a).xy().perp_dot((c - a).xy()) < 0.0;
        let drawn = match draw.cull {
            Cull::None => true,
            Cull::Back => front,
            Cull::Front => !front,
        };
        let half = if front != mirrored {
            self.half
        } else {
            UNDER * self.half
        };
        let finite = corners.iter().all(|corner| corner.is_finite());
        (drawn && finite).then_some(Facet { corners, half })
    }

    /// Moves the depths of a strip, as the depth buffer holds them, to the far ends of the facets that start at them.
    pub(super) fn lower(&self, strip: &mut DepthStrip<'_>) {
        let places = &self.strips[strip.first_row / TILE as usize];
        let mut facets = Vec::new();
        for facet in places.iter().filter_map(|place| self.facet(*place)) {
            let texels = facet.texels(strip, self.size);
            // Depths only move away from the light.
            let far = facet.ends()[1] as f32;
            if any(strip, self.size, &texels, |stored| far < stored) {
                facets.push((facet, texels));
            }
        }
        // From the light on, since a facet may start where another ends.
        let nearest = facets.iter().map(|(facet, _)| facet.ends()[0]);
        let mut order: Vec<_> = nearest.zip(0..facets.len()).collect();
        order.sort_unstable_by(|(a, i), (b, j)| b.total_cmp(a).then(i.cmp(j)));
        for (_, i) in order {
            let (facet, texels) = &facets[i];
            facet.lower(strip, self.size, texels);
        }
    }
}

/// The angles at which the light meets a mesh's triangles.
struct Angles {
    world_from_object: DMat3,
    /// For normals: the matrix of cofactors.
    normals: DMat3,
    light_in_object: DVec4,
}

impl Angles {
    fn new(world_from_object: &DMat4, light: DVec4) -> Self {
        let linear = DMat3::from_mat4(*world_from_object);
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        Self {
            world_from_object: linear,
            normals: DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)),
            light_in_object: world_from_object.inverse() * light,
        }
    }

    /// True if the light meets a triangle at a tangent of at least [`GRAZING`] from its normal. A triangle without area has no angle.
    fn grazing(&self, [a, b, c]: [DVec3; 3]) -> bool {
        let normal = self.normals * (b - a).cross(c - a);
        let to_light = self.light_in_object.truncate() - a * self.light_in_object.w;
        let to_light = self.world_from_object * to_light;
        let (cosine, square) = (normal.dot(to_light), normal.length_squared());
        square > 0.0
            && cosine * cosine * (1.0 + GRAZING * GRAZING) <= square * to_light.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::super::faces::views;
    use super::super::{shadow_map, shadow_map_for, tests::scene};
    use super::*;
    use texmap_light::{Light, ShadowBias, ShadowKind};
    use texmap_scene::Scene;
    use texmap_scene::shadow_fit::shadow_kind;

    fn sun() -> Light {
        Light::Directional {
            color: [1.0; 3],
            direction: [0.0, -1.0, 0.0],
        }
    }

    /// Two floors, the second `drop` lower, joined by a wall of two halves that is `width` wide as a light from above
    /// sees it.
    fn step(width: f32, drop: f32) -> Scene {
        let mut scene = scene(sun());
        scene.meshes.truncate(1);
        let (top, foot) = (0.013, 0.013 + width);
        let middle = 0.5 * (top + foot);
        let row = |x: f32, y: f32| [[x, y, -1.0], [x, y, 1.0]];
        let rows = [
            row(-1.0, 0.0),
            row(top, 0.0),
            row(middle, -0.5 * drop),
            row(foot, -drop),
            row(1.0, -drop),
        ];
        scene.meshes[0].positions = rows.concat();
        // The lower half of the wall first.
        let quads = [4, 2, 0, 6u32].into_iter();
        scene.meshes[0].triangles = quads
            .flat_map(|k| [[k, k + 1, k + 2], [k + 1, k + 3, k + 2]])
            .collect();
        scene
    }

    fn draws_of<'s>(scene: &'s Scene, clip_from_world: DMat4) -> Vec<DrawCall<'s>> {
        let draw = |mesh: &'s Mesh| DrawCall {
            positions: &mesh.positions,
            indices: &mesh.triangles,
            clip_from_object: clip_from_world * mesh.world_from_object,
            ..DrawCall::default()
        };
        scene.meshes.iter().map(draw).collect()
    }

    fn kind_of(scene: &Scene) -> ShadowKind {
        shadow_kind(scene, 0, Some((DVec3::ZERO, 1.0))).unwrap()
    }

    /// A wall thinner than a texel hides none of the floor behind it, which a light from above reaches. The depths without this pass, that
    /// move each caster by its own slope alone, put it in the shadow of the upper floor.
    #[test]
    fn thin_walls_hide_no_floor() {
        let scene = step(1e-3, 0.02);
        let kind = kind_of(&scene);
        let size = 64;
        let bias = ShadowBias::Planes(1e-4);
        for (taps, by_hand) in [(1, false), (3, false), (5, false), (3, true)] {
            let map = if by_hand {
                shadow_map(&scene, &kind, size, 1).unwrap()
            } else {
                shadow_map_for(&scene, &kind, size, bias, taps, 1).unwrap()
            };
            let dark = (0..500).filter(|i| {
                let x = 0.0141 + f64::from(*i) * 4e-4;
                let at = DVec3::new(x, -0.02, 0.1 + f64::from(i % 7) * 0.01);
                map.visibility(at, DVec3::Y, bias, taps) < 1.0
            });
            let dark = dark.count();
            assert!(
                if by_hand { dark > 20 } else { dark == 0 },
                "{taps}: {dark}"
            );
        }
    }

    /// A wall that hangs above the floor casts no shadow that its few texels would not: its foot is not moved up into a texel of the floor.
    #[test]
    fn thin_walls_in_the_air_darken_no_floor() {
        let mut scene = step(1e-3, 0.2);
        let mesh = &mut scene.meshes[0];
        mesh.triangles.truncate(4);
        for y in mesh.positions.iter_mut().map(|p| &mut p[1]) {
            *y += 0.5;
        }
        let mut floor = step(0.0, 0.0).meshes.remove(0);
        floor.triangles = vec![[0, 1, 8], [1, 9, 8]];
        scene.meshes.push(floor);
        let kind = kind_of(&scene);
        let bias = ShadowBias::Planes(1e-4);
        for taps in [1, 3, 5] {
            let map = shadow_map_for(&scene, &kind, 64, bias, taps, 1).unwrap();
            for x in -200..200 {
                let at = DVec3::new(f64::from(x) * 1e-3, 0.0, 0.1);
                assert_eq!(map.visibility(at, DVec3::Y, bias, taps), 1.0, "{taps} {x}");
            }
        }
    }

    /// A roof over the wall keeps its shadow on the floor at the foot of the wall.
    #[test]
    fn thin_walls_under_a_roof_are_dark() {
        let mut scene = step(1e-3, 0.02);
        let mut roof = step(0.0, 0.0).meshes.remove(0);
        roof.positions.iter_mut().for_each(|p| p[1] = 0.5);
        scene.meshes.push(roof);
        let kind = kind_of(&scene);
        let bias = ShadowBias::Planes(1e-4);
        for taps in [1, 3, 5] {
            let map = shadow_map_for(&scene, &kind, 64, bias, taps, 1).unwrap();
            for x in 0..200 {
                let at = DVec3::new(0.0141 + f64::from(x) * 1e-3, -0.02, 0.1);
                assert_eq!(map.visibility(at, DVec3::Y, bias, taps), 0.0, "{taps} {x}");
            }
        }
    }

    /// What lies deeper than the foot of the wall keeps its shadow: the upper floor hides a floor under it up to its edge.
    #[test]
    fn thin_walls_let_no_light_through() {
        let scene = step(1e-3, 0.02);
        let kind = kind_of(&scene);
        let bias = ShadowBias::Planes(1e-4);
        for taps in [1, 3, 5] {
            let map = shadow_map_for(&scene, &kind, 64, bias, taps, 1).unwrap();
            for x in -20..20 {
                let at = DVec3::new(f64::from(x) * 0.01, -0.2, 0.1);
                assert_eq!(map.visibility(at, DVec3::Y, bias, taps), 0.0, "{taps} {x}");
            }
        }
    }

    /// Facets are found by the angle of the light, whatever its kind: those that it meets at a tangent of 4 or more from the normal.
    #[test]
    fn facets_are_grazing_by_angle() {
        for light in [
            sun(),
            Light::spot([1.0; 3], [0.0, 1e3, 0.0], [0.0, -1.0, 0.0], 0.5, 0.7),
            Light::Point {
                color: [1.0; 3],
                position: [0.0, 1e3, 0.0],
            },
        ] {
            for (drop, grazing) in [(0.39, false), (0.41, true)] {
                let mut scene = step(0.1, drop);
                scene.lights = vec![light];
                for (mirrored, side) in [(1.0, 1.0), (-1.0, 1.0), (1.0, UNDER), (-1.0, UNDER)] {
                    let mesh = &mut scene.meshes[0];
                    mesh.world_from_object = DMat4::from_scale(DVec3::new(mirrored, 1.0, 1.0));
                    let kind = kind_of(&scene);
                    let mut found = 0;
                    for view in views(&scene, &kind) {
                        let draws = draws_of(&scene, view.clip_from_world);
                        let clip = view.clip_from_world;
                        let facets = GrazingFacets::new(&scene.meshes, &draws, clip, (32, 3), 1);
                        for place in facets.strips.iter().flatten() {
                            found += 1;
                            assert_eq!(facets.facet(*place).unwrap().half, 1.5 * side, "{kind:?}");
                        }
                    }
                    assert_eq!(found > 0, grazing, "{kind:?} {drop}");
                    if mirrored < 0.0 {
                        let triangles = &mut scene.meshes[0].triangles;
                        triangles.iter_mut().for_each(|triangle| triangle.reverse());
                    }
                }
            }
        }
    }

    /// Facets that are not finite, have no area or lie behind the light are none, and none ends the work.
    #[test]
    fn facets_of_any_numbers_are_none() {
        let mut scene = step(1e-3, 0.02);
        let spot = Light::spot([1.0; 3], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], 0.5, 0.7);
        scene.lights = vec![spot];
        let kind = kind_of(&scene);
        let view = &views(&scene, &kind)[0];
        for worst in [f32::NAN, f32::INFINITY, 1e30, -1e30, 2.0] {
            for k in 0..scene.meshes[0].positions.len() {
                let mut scene = scene.clone();
                scene.meshes[0].positions[k][1] = worst;
                scene.meshes[0].positions[(k + 3) % 10] = scene.meshes[0].positions[k];
                let draws = draws_of(&scene, view.clip_from_world);
                let clip = view.clip_from_world;
                let facets = GrazingFacets::new(&scene.meshes, &draws, clip, (64, 5), 1);
                for [draw, triangle] in facets.strips.iter().flatten() {
                    let corners = scene.meshes[*draw as usize].triangles[*triangle as usize];
                    let corner = |v: u32| scene.meshes[0].positions[v as usize];
                    assert!(corners.iter().all(|v| corner(*v)[1] <= 1.0), "{worst} {k}");
                }
            }
        }
    }

    #[test]
    fn threads_agree() {
        let scene = step(1e-3, 0.02);
        let kind = kind_of(&scene);
        let bias = ShadowBias::Planes(1e-4);
        let map = |threads| shadow_map_for(&scene, &kind, 300, bias, 5, threads).unwrap();
        assert_eq!(map(1), map(2));
    }
}
