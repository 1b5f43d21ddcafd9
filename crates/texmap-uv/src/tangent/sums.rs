//! The tangent of each corner: the sum over its group, weighted by angles (Mikkelsen 2008, section 3.3).

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::deterministic_f64;
use texmap_math::glam::{Vec2, Vec3};

use super::groups::{Group, NONE, groups, neighbours, weld};
use super::triangles::{Input, Space, Triangle, triangles, unit};

/// Around a vertex of more triangles than this, tangents that are exactly opposite are not kept apart.
const APART: usize = 64;

/// The tangent of each corner and the bitangent's sign; `None` where no triangle says anything. O(n log n).
pub(super) fn corner_tangents(input: &Input<'_>) -> Vec<Option<[f32; 4]>> {
    let (mut triangles, slots) = triangles(input);
    // Triangles with area first, each kind in its order.
    triangles.sort_by_key(|t| t.degenerate);
    let solid = triangles.partition_point(|t| !t.degenerate);
    let vertices = weld(input, &triangles);
    let (good, degenerate) = triangles.split_at_mut(solid);
    let across = neighbours(&vertices[..solid]);
    let groups = groups(good, &vertices[..solid], &across);
    let mut spaces: Vec<Option<(Space, bool)>> = vec![None; slots.len()];
    for mut group in groups {
        let each = sums(input, good, &vertices, &mut group);
        for (&f, space) in group.faces.iter().zip(each) {
            let Some(k) = vertices[f as usize].iter().position(|v| *v == group.vertex) else {
                continue;
            };
            let slot = &mut spaces[good[f as usize].slots[k] as usize];
            // Both halves of a quad.
            let space = slot.map_or(space, |(first, _)| mean(first, space));
            *slot = Some((space, group.upright));
        }
    }
    inherit(good, degenerate, &vertices, &mut spaces);
    for t in good.iter().filter(|t| t.half_degenerate) {
        let Some([slot, corner]) = t.missing else {
            continue;
        };
        let twin = (0..3).find(|&k| input.position(t.corners[k]) == input.position(corner));
        if let Some(k) = twin {
            spaces[slot as usize] = spaces[t.slots[k] as usize];
        }
    }
    let mut out = vec![None; input.mesh.faces().corners().len()];
    for (&corner, space) in slots.iter().zip(spaces) {
        // A corner of several triangles of a fan keeps the first.
        let place = &mut out[corner as usize];
        *place = place.or(space.map(|(space, upright)| {
            let [x, y, z] = space.s.to_array();
            [x, y, z, if upright { 1.0 } else { -1.0 }]
        }));
    }
    out
}

/// Triangles without area take what the first triangle with area has at the same vertex.
fn inherit(
    good: &[Triangle],
    degenerate: &[Triangle],
    vertices: &[[u32; 3]],
    spaces: &mut [Option<(Space, bool)>],
) {
    let Some(count) = vertices.iter().flatten().max().map(|v| *v as usize + 1) else {
        return;
    };
    let mut first = vec![NONE; count];
    for (t, v) in good.iter().zip(vertices) {
        for k in 0..3 {
            let slot = &mut first[v[k] as usize];
            *slot = if *slot == NONE { t.slots[k] } else { *slot };
        }
    }
    let of_degenerate = vertices[good.len()..].iter();
    for (t, v) in degenerate.iter().zip(of_degenerate) {
        for k in (0..3).filter(|_| !t.half_degenerate) {
            let from = first[v[k] as usize];
            if from != NONE {
                spaces[t.slots[k] as usize] = spaces[from as usize];
            }
        }
    }
}

fn mean(a: Space, b: Space) -> Space {
    if a == b {
        return a;
    }
    Space {
        s: unit(a.s + b.s),
        t: unit(a.t + b.t),
        lengths: (a.lengths + b.lengths) * 0.5,
    }
}

/// The sum for each triangle of a group: of all of them, but for those whose tangent or bitangent is exactly opposite to its
/// own.
fn sums(
    input: &Input<'_>,
    triangles: &[Triangle],
    vertices: &[[u32; 3]],
    group: &mut Group,
) -> Vec<Space> {
    let n = input.normal(group.vertex);
    let mut sorted = group.faces.clone();
    sorted.sort_unstable();
    let sum = |faces: &[u32]| sum(input, triangles, vertices, group.vertex, faces);
    let whole = sum(&sorted);
    let mut out = vec![whole; group.faces.len()];
    if sorted.len() > APART {
        return out;
    }
    let flat = |f: u32| {
        let space = triangles[f as usize].space;
        [flattened(space.s, n), flattened(space.t, n)]
    };
    let all: Vec<[Vec3; 2]> = sorted.iter().map(|&f| flat(f)).collect();
    let mut known: Vec<(Vec<u32>, Space)> = Vec::new();
    for (&f, out) in group.faces.iter().zip(&mut out) {
        let (a, [s, t]) = (&triangles[f as usize], flat(f));
        let joins = |g: u32, other: &[Vec3; 2]| {
            let b = &triangles[g as usize];
            a.vague
                || b.vague
                || a.piece == b.piece
                || (s.dot(other[0]) > -1.0 && t.dot(other[1]) > -1.0)
        };
        if sorted.iter().zip(&all).all(|(&g, other)| joins(g, other)) {
            continue;
        }
        let joined = sorted
            .iter()
            .zip(&all)
            .filter(|(g, other)| joins(**g, other));
        let joined: Vec<u32> = joined.map(|(&g, _)| g).collect();
        *out = match known.iter().find(|(faces, _)| *faces == joined) {
            Some((_, space)) => *space,
            None => {
                let space = sum(&joined);
                known.push((joined, space));
                space
            }
        };
    }
    out
}

fn flattened(v: Vec3, n: Vec3) -> Vec3 {
    unit(v - n * n.dot(v))
}

fn sum(
    input: &Input<'_>,
    triangles: &[Triangle],
    vertices: &[[u32; 3]],
    vertex: u32,
    faces: &[u32],
) -> Space {
    let n = input.normal(vertex);
    let (mut total, mut angles) = (Space::ZERO, 0.0);
    for &f in faces {
        let t = &triangles[f as usize];
        let at = vertices[f as usize].iter().position(|v| *v == vertex);
        let Some(i) = at.filter(|_| !t.vague) else {
            continue;
        };
        let [here, next, last] =
            [0, 1, 2].map(|k| input.position(vertices[f as usize][(i + k) % 3]));
        let (a, b) = (flattened(next - here, n), flattened(last - here, n));
        let angle = deterministic_f64::acos(f64::from(a.dot(b).clamp(-1.0, 1.0))) as f32;
        total.s += flattened(t.space.s, n) * angle;
        total.t += flattened(t.space.t, n) * angle;
        total.lengths += t.space.lengths * angle;
        angles += angle;
    }
    Space {
        s: unit(total.s),
        t: unit(total.t),
        lengths: if angles > 0.0 {
            Vec2::new(total.lengths.x / angles, total.lengths.y / angles)
        } else {
            total.lengths
        },
    }
}
