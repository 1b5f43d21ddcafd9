//! Grazing facets of depth maps that serve as shadow maps.

mod facet;

use alloc::vec;
use alloc::vec::Vec;

use texmap_math::glam::{DMat3, DMat4, DVec3, DVec4, Vec3Swizzles};
use texmap_math::{parallel, wide};

use crate::{Cull, DepthStrip, DrawCall, Pass, TILE};
use facet::{Facet, any};

/// Tangent of the angle between a facet's normal and the light from which on the facet is a grazing one, texels of depth per texel.
const GRAZING: f64 = 4.0;

/// Part of the square around a texel in which facets that turn their inner side to the light are followed. They lie under what casts the
/// shadow, and from one to the next they would lead through a solid body.
const UNDER: f64 = 0.5;

/// Grazing facets: triangles that the light of a shadow map meets almost on edge. In the map they are narrow strips with few texels of
/// their own, so that a filter compares with the depths on both sides of a strip and with none between: a point behind the strip would be in
/// the shadow of the surface before it. [`lower`](Self::lower) moves the depths of such texels to the far end of the strip.
///
/// ```
/// use texmap_math::glam::DMat4;
/// use texmap_raster::{BinnedDraws, DrawCall, GrazingFacets, TargetSize};
///
/// // Seen from above: a floor, a wall that is a hundredth of a texel wide, and a lower floor.
/// let rows = [(-1.0, 0.8), (0.0, 0.8), (0.002, 0.2), (1.0, 0.2)];
/// let positions: Vec<[f32; 3]> = rows.iter().flat_map(|&(x, z)| [[x, -1.0, z], [x, 1.0, z]]).collect();
/// let indices: Vec<[u32; 3]> = [0, 2, 4].iter().flat_map(|k| [[*k, k + 2, k + 1], [k + 1, k + 2, k + 3]]).collect();
/// let draws = [DrawCall { positions: &positions, indices: &indices, ..DrawCall::default() }];
///
/// let binned = BinnedDraws::new(TargetSize::new(8, 8)?, &draws)?;
/// let facets = GrazingFacets::new(&draws, &[DMat4::IDENTITY], DMat4::IDENTITY, (8, 3), 1);
/// let mut map = Vec::new();
/// binned.depth_strips(1, None, 0.0, &mut map, &|mut strip| facets.lower(&mut strip));
/// // Texels of which a look-up of 3 x 3 comparisons beside the wall reads are those of the lower floor.
/// assert_eq!(map[..8], [0.8, 0.8, 0.8, 0.2, 0.2, 0.2, 0.2, 0.2]);
/// # Ok::<(), texmap_raster::RasterError>(())
/// ```
#[derive(Debug)]
pub struct GrazingFacets<'d> {
    draws: &'d [DrawCall<'d>],
    /// For each draw, true if it mirrors its object.
    mirrored: Vec<bool>,
    /// Texels a side of the map.
    size: u32,
    /// Half a side of the square around a texel's centre whose points read the texel, in texels.
    half: f64,
    /// Draw and triangle of the facets that reach each strip of rows.
    strips: Vec<Vec<[u32; 2]>>,
}

impl<'d> GrazingFacets<'d> {
    /// The facets of `draws`, each with the transform of its object, that may hide what lies behind them in a map of `size` x `size` texels
    /// from look-ups of `taps` x `taps` comparisons. `clip_from_world` is the light's view. Draws without a transform, vertices that are not
    /// finite, that there are not or that lie behind the light's plane make no facet.
    #[must_use]
    pub fn new(
        draws: &'d [DrawCall<'d>],
        world_from_object: &[DMat4],
        clip_from_world: DMat4,
        (size, taps): (u32, u32),
        threads: usize,
    ) -> Self {
        let mut facets = Self {
            draws,
            mirrored: world_from_object
                .iter()
                .map(|transform| transform.determinant() < 0.0)
                .collect(),
            size,
            half: 0.5 + f64::from(taps.min(15) / 2),
            strips: vec![Vec::new(); size.div_ceil(TILE) as usize],
        };
        if size == 0 {
            return facets;
        }
        // A point that all rays of light pass through, or the direction towards the light with a last coordinate of 0.
        let light = clip_from_world.inverse() * DVec4::Z;
        let pieces: Vec<_> = draws
            .iter()
            .zip(world_from_object)
            .enumerate()
            .filter(|(_, (draw, _))| draw.pass == Pass::Opaque)
            .flat_map(|(draw, (call, transform))| {
                let angles = Angles::new(transform, light);
                let starts = (0..call.indices.len()).step_by(parallel::PIECE);
                starts.map(move |start| (angles, [draw, start]))
            })
            .collect();
        let find = |(angles, piece)| facets.of_piece(&angles, piece);
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
    fn of_piece(&self, angles: &Angles, [draw, start]: [usize; 2]) -> Vec<([u32; 2], [u32; 2])> {
        let call = &self.draws[draw];
        let triangles = call.indices[start..].iter().take(parallel::PIECE);
        let grazing = triangles
            .zip(start..)
            .filter(|(triangle, _)| angles.grazing(triangle.map(|vertex| position(call, vertex))));
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
            let clip = draw.clip_from_object * position(draw, vertex).extend(1.0);
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

    /// Moves the depths of a strip, as [`depth_strips`](crate::BinnedDraws::depth_strips) lends it, to the far ends of the facets that start
    /// at them.
    pub fn lower(&self, strip: &mut DepthStrip<'_>) {
        let Some(places) = self.strips.get(strip.first_row / TILE as usize) else {
            return;
        };
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

/// A vertex of a draw; NaN if there is none of this number.
fn position(draw: &DrawCall<'_>, vertex: u32) -> DVec3 {
    let position = draw.positions.get(vertex as usize);
    position.map_or(DVec3::NAN, |position| wide(*position))
}

/// The angles at which the light meets the triangles of an object.
#[derive(Clone, Copy)]
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
    use super::*;

    /// Two floors, the second `drop` lower, joined by a wall of two halves that is `width` wide as a light from above sees it.
    fn step(width: f32, drop: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let rows = [
            (-1.0, 0.0),
            (0.0, 0.0),
            (0.5 * width, -0.5 * drop),
            (width, -drop),
            (1.0, -drop),
        ];
        let positions = rows.map(|(x, y)| [[x, y, -1.0], [x, y, 1.0]]).concat();
        let triangles = [0, 2, 4, 6u32].map(|k| [[k, k + 1, k + 2], [k + 1, k + 3, k + 2]]);
        (positions, triangles.concat())
    }

    fn rows(rows: [[f64; 4]; 4]) -> DMat4 {
        DMat4::from_cols_array_2d(&rows).transpose()
    }

    /// Views from above: of parallel light, and from a point with the tangent of half its angle.
    fn from_above() -> [DMat4; 3] {
        let parallel = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, -1.0, 0.0],
            [0.0, 0.25, 0.0, 0.5],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let from_point = |tan_half: f64| {
            rows([
                [1.0 / tan_half, 0.0, 0.0, 0.0],
                [0.0, 0.0, -1.0 / tan_half, 0.0],
                [0.0, 0.0, 0.0, 1e-3],
                [0.0, -1.0, 0.0, 1e3],
            ])
        };
        [rows(parallel), from_point(2e-3), from_point(1.0)]
    }

    fn draw<'s>(
        (positions, indices): &'s (Vec<[f32; 3]>, Vec<[u32; 3]>),
        clip_from_object: DMat4,
    ) -> DrawCall<'s> {
        DrawCall {
            positions,
            indices,
            clip_from_object,
            ..DrawCall::default()
        }
    }

    /// Facets are found by the angle of the light, near or far: those that it meets at a tangent of 4 or more from the normal.
    #[test]
    fn facets_are_grazing_by_angle() {
        for clip_from_world in from_above() {
            for (drop, grazing) in [(0.39, false), (0.41, true)] {
                let mut mesh = step(0.1, drop);
                for (mirrored, side) in [(1.0, 1.0), (-1.0, 1.0), (1.0, UNDER), (-1.0, UNDER)] {
                    let transform = DMat4::from_scale(DVec3::new(mirrored, 1.0, 1.0));
                    let draws = [draw(&mesh, clip_from_world * transform)];
                    let facets =
                        GrazingFacets::new(&draws, &[transform], clip_from_world, (32, 3), 1);
                    let found: Vec<_> = facets.strips.iter().flatten().collect();
                    assert_eq!(!found.is_empty(), grazing, "{clip_from_world} {drop}");
                    for place in found {
                        assert_eq!(facets.facet(*place).unwrap().half, 1.5 * side);
                    }
                    if mirrored < 0.0 {
                        mesh.1.iter_mut().for_each(|triangle| triangle.reverse());
                    }
                }
            }
        }
    }

    /// Facets that are not finite, have no area or lie behind the light are none; nor are those of vertices, transforms and texels that
    /// there are not. None ends the work.
    #[test]
    fn facets_of_any_numbers_are_none() {
        let clip_from_world = from_above()[1];
        let transforms = [DMat4::IDENTITY];
        for worst in [f32::NAN, f32::INFINITY, 1e30, -1e30, 2e3] {
            for k in 0..10 {
                let mut mesh = step(1e-3, 0.02);
                mesh.0[k][1] = worst;
                mesh.0[(k + 3) % 10] = mesh.0[k];
                let draws = [draw(&mesh, clip_from_world)];
                let facets = GrazingFacets::new(&draws, &transforms, clip_from_world, (64, 5), 1);
                for [_, triangle] in facets.strips.iter().flatten() {
                    let corners = mesh.1[*triangle as usize].map(|v| mesh.0[v as usize]);
                    assert!(corners.iter().all(|at| at[1] <= 1e3), "{worst} {k}");
                }
            }
        }
        let mut mesh = step(1e-3, 0.02);
        let found = |mesh: &_, transforms: &[DMat4], size| {
            let draws = [draw(mesh, clip_from_world)];
            let facets = GrazingFacets::new(&draws, transforms, clip_from_world, (size, 5), 1);
            facets.strips.iter().flatten().count()
        };
        assert!(found(&mesh, &transforms, 64) > 0);
        assert_eq!(found(&mesh, &transforms, 0) + found(&mesh, &[], 64), 0);
        mesh.1.iter_mut().for_each(|triangle| triangle[1] = 99);
        assert_eq!(found(&mesh, &transforms, 64), 0);
    }
}
