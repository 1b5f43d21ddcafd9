//! The tangent of each corner: the sum over its group, weighted by angles (Mikkelsen 2008, section 3.3).

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::deterministic_f64;
use texmap_math::glam::{Vec2, Vec3};

use super::groups::{Groups, NONE, groups, neighbours, weld};
use super::triangles::{Input, Space, Triangle, triangles, unit};
use crate::parallel::collect_chunks;

/// Around a vertex of more triangles than this, tangents that are exactly opposite are not kept apart.
const APART: usize = 64;

/// A unit tangent, and true where the picture is not mirrored; `None` where no triangle says anything.
pub(super) type Tangent = Option<(Vec3, bool)>;

/// The tangent of each corner. O(n log n).
pub(super) fn corner_tangents(input: &Input<'_>) -> Vec<Tangent> {
    let (mut triangles, slots) = triangles(input);
    // Triangles with area first, each kind in its order.
    triangles.sort_by_key(|t| t.degenerate);
    let solid = triangles.partition_point(|t| !t.degenerate);
    let vertices = weld(input, &triangles);
    let (good, degenerate) = triangles.split_at_mut(solid);
    let across = neighbours(&vertices[..solid]);
    let groups = groups(good, &vertices[..solid], &across);
    // The sums are apart from each other.
    let reader = GroupReader {
        input,
        triangles: good,
        vertices: &vertices,
    };
    let sums = collect_chunks(groups.all.len(), |chunk| {
        let (mut terms, mut out) = (Vec::new(), Vec::new());
        for group in chunk {
            let vertex = groups.all[group].vertex;
            reader.sums(vertex, groups.faces(group), &mut terms, &mut out);
        }
        out
    });
    let mut tangents = of_slots(slots.len(), good, &groups, &sums);
    inherit(good, degenerate, &vertices, &mut tangents);
    for t in good.iter().filter(|t| t.half_degenerate) {
        let Some([slot, corner]) = t.missing else {
            continue;
        };
        let twin = (0..3).find(|&k| input.position(t.corners[k]) == input.position(corner));
        if let Some(k) = twin {
            tangents[slot as usize] = tangents[t.slots[k] as usize];
        }
    }
    let corners = input.mesh.faces().corners().len();
    if slots.len() == corners {
        return tangents;
    }
    let mut out = vec![None; corners];
    for (&corner, tangent) in slots.iter().zip(tangents) {
        // A corner of several triangles of a fan keeps the first.
        let place = &mut out[corner as usize];
        *place = place.or(tangent);
    }
    out
}

/// The tangent of each slot by the sums of the triangles that have it: one, or both halves of a quad.
fn of_slots(count: usize, triangles: &[Triangle], groups: &Groups, sums: &[Space]) -> Vec<Tangent> {
    let mut owners = vec![[NONE; 2]; count];
    for (f, t) in triangles.iter().enumerate() {
        for (k, slot) in t.slots.into_iter().enumerate() {
            let [first, second] = &mut owners[slot as usize];
            let owner = if *first == NONE { first } else { second };
            *owner = (3 * f + k) as u32;
        }
    }
    let sum = |owner: u32| {
        let (f, k) = (owner as usize / 3, owner as usize % 3);
        let place = *groups.places.get(f)?.get(k)?;
        let sum = sums.get(place as usize)?;
        Some((place, *sum, triangles[f].upright))
    };
    let tangent = |owners: &[u32; 2]| match owners.map(sum) {
        // The later group decides.
        [Some(a), Some(b)] => Some((mean(a.1, b.1), if a.0 > b.0 { a.2 } else { b.2 })),
        [a, b] => a.or(b).map(|(_, sum, upright)| (sum.s, upright)),
    };
    collect_chunks(count, |chunk| owners[chunk].iter().map(tangent).collect())
}

/// Triangles without area take what the first triangle with area has at the same vertex.
fn inherit(
    good: &[Triangle],
    degenerate: &[Triangle],
    vertices: &[[u32; 3]],
    tangents: &mut [Tangent],
) {
    let count = vertices.iter().flatten().max().map(|v| *v as usize + 1);
    let Some(count) = count.filter(|_| !degenerate.is_empty()) else {
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
                tangents[t.slots[k] as usize] = tangents[from as usize];
            }
        }
    }
}

/// The tangent of both halves of a quad.
fn mean(a: Space, b: Space) -> Vec3 {
    if a == b { a.s } else { unit(a.s + b.s) }
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
