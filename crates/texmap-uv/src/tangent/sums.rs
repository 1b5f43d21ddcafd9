//! The tangent of each corner: the sum over its group, weighted by angles (Mikkelsen 2008, section 3.3).

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::deterministic_f64;
use texmap_math::glam::{Vec2, Vec3};

use super::groups::{NONE, groups, neighbours, weld};
use super::triangles::{Input, Space, Triangle, triangles, unit};
use crate::parallel::map_chunks;

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
    // The sums are apart from each other; the triangles take them in the order of the groups.
    let reader = GroupReader {
        input,
        triangles: good,
        vertices: &vertices,
    };
    let found = map_chunks(groups.all.len(), |chunk| {
        let (mut terms, mut out) = (Vec::new(), Vec::new());
        for group in chunk {
            let vertex = groups.all[group].vertex;
            reader.sums(vertex, groups.faces(group), &mut terms, &mut out);
        }
        out
    });
    let mut found = found.into_iter().flatten();
    for (k, group) in groups.all.iter().enumerate() {
        for (&f, space) in groups.faces(k).iter().zip(&mut found) {
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

/// Triangles with area and the welded vertices of their corners.
struct GroupReader<'a> {
    input: &'a Input<'a>,
    triangles: &'a [Triangle],
    vertices: &'a [[u32; 3]],
}

/// The part of a triangle in the sum around one of its corners.
struct Term {
    face: u32,
    /// Tangent and bitangent in the plane of the vertex, of unit length.
    s: Vec3,
    t: Vec3,
    /// Angle at the corner; `None` for triangles that say nothing.
    angle: Option<f32>,
}

impl GroupReader<'_> {
    /// The sum for each triangle of a group, appended to `out`: of all of them, but for those whose tangent or bitangent is exactly
    /// opposite to its own.
    fn sums(&self, vertex: u32, faces: &[u32], terms: &mut Vec<Term>, out: &mut Vec<Space>) {
        terms.clear();
        terms.extend(faces.iter().map(|&face| self.term(vertex, face)));
        terms.sort_unstable_by_key(|term| term.face);
        let whole = self.sum(terms.iter());
        let at = out.len();
        out.resize(at + faces.len(), whole);
        if faces.len() > APART || self.within_a_third(terms) {
            return;
        }
        let mut known: Vec<(Vec<u32>, Space)> = Vec::new();
        for (&face, out) in faces.iter().zip(&mut out[at..]) {
            let own = terms.binary_search_by_key(&face, |term| term.face);
            let Some(own) = own.ok().map(|own| &terms[own]) else {
                continue;
            };
            let joins = |other: &&Term| self.joins(own, other);
            if terms.iter().all(|other| joins(&other)) {
                continue;
            }
            let joined = || terms.iter().filter(joins);
            let list: Vec<u32> = joined().map(|term| term.face).collect();
            *out = match known.iter().find(|(faces, _)| *faces == list) {
                Some((_, space)) => *space,
                None => {
                    let space = self.sum(joined());
                    known.push((list, space));
                    space
                }
            };
        }
    }

    /// True if tangents and bitangents lie within 60 degrees of those of one triangle: then none is opposite to another.
    fn within_a_third(&self, terms: &[Term]) -> bool {
        let mut tell = terms.iter().filter(|term| term.angle.is_some());
        let Some(one) = tell.next() else { return false };
        tell.all(|term| one.s.dot(term.s) > 0.5 && one.t.dot(term.t) > 0.5)
    }

    /// True if the sum for one triangle holds the other.
    fn joins(&self, one: &Term, other: &Term) -> bool {
        let [a, b] = [one, other].map(|term| &self.triangles[term.face as usize]);
        a.vague
            || b.vague
            || a.piece == b.piece
            || (one.s.dot(other.s) > -1.0 && one.t.dot(other.t) > -1.0)
    }

    fn term(&self, vertex: u32, face: u32) -> Term {
        let n = self.input.normal(vertex);
        let (t, corners) = (
            &self.triangles[face as usize],
            &self.vertices[face as usize],
        );
        let at = corners.iter().position(|v| *v == vertex);
        let angle = at.filter(|_| !t.vague).map(|i| {
            let [here, next, last] = [0, 1, 2].map(|k| self.input.position(corners[(i + k) % 3]));
            let (a, b) = (flattened(next - here, n), flattened(last - here, n));
            deterministic_f64::acos(f64::from(a.dot(b).clamp(-1.0, 1.0))) as f32
        });
        Term {
            face,
            s: flattened(t.space.s, n),
            t: flattened(t.space.t, n),
            angle,
        }
    }

    /// The sum of terms in the order of their triangles, weighted by angles.
    fn sum<'t>(&self, terms: impl Iterator<Item = &'t Term>) -> Space {
        let (mut total, mut angles) = (Space::ZERO, 0.0);
        for term in terms {
            let Some(angle) = term.angle else { continue };
            total.s += term.s * angle;
            total.t += term.t * angle;
            total.lengths += self.triangles[term.face as usize].space.lengths * angle;
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
}

fn flattened(v: Vec3, n: Vec3) -> Vec3 {
    unit(v - n * n.dot(v))
}
