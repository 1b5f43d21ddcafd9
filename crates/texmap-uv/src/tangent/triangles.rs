//! The triangles of a mesh with the first-order tangents of Mikkelsen (2008, section 3.1): derivatives of the position along
//! u and v.

use alloc::vec::Vec;
use texmap_math::float;
use texmap_math::glam::{Vec2, Vec3};

use crate::mesh::Mesh;
use crate::parallel::collect_chunks;
use crate::uv_set::UvSet;

/// Mesh, texture coordinates and normals that the rule reads; normals are of unit length.
pub(super) struct Input<'a> {
    pub(super) mesh: &'a Mesh<'a>,
    pub(super) set: &'a UvSet,
    pub(super) normals: &'a [[f32; 3]],
}

impl Input<'_> {
    pub(super) fn position(&self, corner: u32) -> Vec3 {
        self.mesh.positions()[self.mesh.faces().corners()[corner as usize] as usize].into()
    }

    pub(super) fn normal(&self, corner: u32) -> Vec3 {
        self.normals[corner as usize].into()
    }

    pub(super) fn uv(&self, corner: u32) -> Vec2 {
        self.set.at(corner as usize).into()
    }
}

/// Unit vectors along growing u and v, and their lengths before.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Space {
    pub(super) s: Vec3,
    pub(super) t: Vec3,
    pub(super) lengths: Vec2,
}

impl Space {
    pub(super) const ZERO: Self = Self {
        s: Vec3::ZERO,
        t: Vec3::ZERO,
        lengths: Vec2::ZERO,
    };
}

/// A triangle, or half of a quad.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    /// Corners of the triangle, as indices into the list of corners.
    pub(super) corners: [u32; 3],
    /// Indices of their tangents in the list of slots.
    pub(super) slots: [u32; 3],
    /// Number of the triangle or quad that it belongs to.
    pub(super) piece: u32,
    /// Of a quad's half: the slot and the corner that it lacks.
    pub(super) missing: Option<[u32; 2]>,
    pub(super) space: Space,
    /// The picture is not mirrored.
    pub(super) upright: bool,
    /// The picture says nothing here: any neighbour's group will do.
    pub(super) vague: bool,
    /// Two corners have one position.
    pub(super) degenerate: bool,
    /// Of a quad of which one half is degenerate and the other is not.
    pub(super) half_degenerate: bool,
}

/// All triangles, and the corner of each slot: quads are divided along the diagonal that is shorter in the picture (in space if
/// they are equal), larger faces are fans.
pub(super) fn triangles(input: &Input<'_>) -> (Vec<Triangle>, Vec<u32>) {
    let faces = input.mesh.faces();
    let (mut slots, mut pieces) = (Vec::with_capacity(faces.corners().len()), 0);
    // The first slot and the first piece of each face.
    let mut starts = Vec::with_capacity(faces.len());
    for face in 0..faces.len() {
        let (first, last) = (faces.range(face).start as u32, faces.range(face).end as u32);
        starts.push([slots.len() as u32, pieces]);
        if last - first == 4 {
            slots.extend(first..last);
            pieces += 1;
        } else {
            let fan = first + 1..last - 1;
            pieces += fan.len() as u32;
            slots.extend(fan.flat_map(|k| [first, k, k + 1]));
        }
    }
    let triangles = collect_chunks(faces.len(), |chunk| {
        let mut triangles = Vec::with_capacity(2 * chunk.len());
        for face in chunk {
            let (corners, [mut base, mut piece]) = (faces.range(face), starts[face]);
            let first = corners.start as u32;
            if corners.len() == 4 {
                triangles.extend(quad(input, first, base, piece));
                continue;
            }
            for k in first + 1..corners.end as u32 - 1 {
                let places = [base, base + 1, base + 2];
                triangles.push(triangle(input, [first, k, k + 1], places, piece));
                (base, piece) = (base + 3, piece + 1);
            }
        }
        triangles
    });
    (triangles, slots)
}

fn quad(input: &Input<'_>, first: u32, base: u32, piece: u32) -> [Triangle; 2] {
    let diagonal = |a: u32, b: u32| {
        let d = input.uv(first + a) - input.uv(first + b);
        d.x * d.x + d.y * d.y
    };
    let (one, other) = (diagonal(2, 0), diagonal(3, 1));
    let along_02 = if one < other {
        true
    } else if one > other {
        false
    } else {
        let squared = |a: u32, b: u32| {
            let d = input.position(first + a) - input.position(first + b);
            d.dot(d)
        };
        squared(3, 1) >= squared(2, 0)
    };
    let halves = if along_02 {
        [([0, 1, 2], 3), ([0, 2, 3], 1)]
    } else {
        [([0, 1, 3], 2), ([1, 2, 3], 0)]
    };
    let [mut a, mut b] = halves.map(|(corners, missing)| Triangle {
        missing: Some([base + missing, first + missing]),
        ..triangle(
            input,
            corners.map(|k: u32| first + k),
            corners.map(|k| base + k),
            piece,
        )
    });
    a.half_degenerate = a.degenerate != b.degenerate;
    b.half_degenerate = a.half_degenerate;
    if !a.degenerate && !b.degenerate && a.upright != b.upright {
        // The larger half in the picture decides for both.
        if b.vague || twice_area(input, a.corners).abs() >= twice_area(input, b.corners).abs() {
            b.upright = a.upright;
        } else {
            a.upright = b.upright;
        }
    }
    [a, b]
}

fn twice_area(input: &Input<'_>, corners: [u32; 3]) -> f32 {
    let [a, b, c] = corners.map(|k| input.uv(k));
    let (e, f) = (b - a, c - a);
    e.x * f.y - e.y * f.x
}

fn triangle(input: &Input<'_>, corners: [u32; 3], slots: [u32; 3], piece: u32) -> Triangle {
    let [a, b, c] = corners.map(|k| input.position(k));
    let mut out = Triangle {
        corners,
        slots,
        piece,
        missing: None,
        space: Space::ZERO,
        upright: false,
        vague: true,
        degenerate: a == b || b == c || c == a,
        half_degenerate: false,
    };
    if out.degenerate {
        out.vague = false;
        return out;
    }
    let twice = twice_area(input, corners);
    out.upright = twice > 0.0;
    if !counts(twice.abs()) {
        return out;
    }
    let [p, q, r] = corners.map(|k| input.uv(k));
    let (e1, e2, f1, f2) = (b - a, c - a, q - p, r - p);
    let (s, t) = (f2.y * e1 - f1.y * e2, -f2.x * e1 + f1.x * e2);
    let sign = if out.upright { 1.0 } else { -1.0 };
    out.space = Space {
        s: unit(s) * sign,
        t: unit(t) * sign,
        lengths: Vec2::new(length(s), length(t)) / twice.abs(),
    };
    out.vague = !(counts(out.space.lengths.x) && counts(out.space.lengths.y));
    out
}

/// True if a number that is not negative is more than the smallest normal one.
pub(super) fn counts(x: f32) -> bool {
    x > f32::MIN_POSITIVE
}

fn length(v: Vec3) -> f32 {
    float::sqrt_f32(v.dot(v))
}

/// The vector with length 1; as it is if nothing of it counts.
pub(super) fn unit(v: Vec3) -> Vec3 {
    if counts(v.x.abs()) || counts(v.y.abs()) || counts(v.z.abs()) {
        v * (1.0 / length(v))
    } else {
        v
    }
}
