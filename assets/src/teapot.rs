//! The Utah teapot (Newell 1975), tessellated from its Bezier control points.
//!
//! Rim, body, lid and bottom are bodies of revolution whose rings are four cubic arcs, so a control point is
//! a radius and a height; handle and spout are two mirrored halves of one tube each, whose rings are given by
//! their inner and outer corner and a half-width.

use texmap_math::glam::DVec3;

use crate::mesh::{Corner, Mesh, length, unit};

/// Radius, height and the arc's handle length as a share of the radius.
type Ring = [f64; 3];
const LID: [[Ring; 4]; 2] = [
    [
        [0.0, 3.15, 0.56],
        [0.8, 3.15, 0.5625],
        [0.0, 2.85, 0.56],
        [0.2, 2.7, 0.56],
    ],
    [
        [0.2, 2.7, 0.56],
        [0.4, 2.55, 0.56],
        [1.3, 2.55, 0.56],
        [1.3, 2.4, 0.56],
    ],
];
const BODY: [[Ring; 4]; 3] = [
    [
        [1.4, 2.4, 0.56],
        [1.3375, 2.53125, 0.56],
        [1.4375, 2.53125, 0.56],
        [1.5, 2.4, 0.56],
    ],
    [
        [1.5, 2.4, 0.56],
        [1.75, 1.875, 0.56],
        [2.0, 1.35, 0.56],
        [2.0, 0.9, 0.56],
    ],
    [
        [2.0, 0.9, 0.56],
        [2.0, 0.45, 0.56],
        [1.5, 0.225, 0.56],
        [1.5, 0.15, 0.56],
    ],
];
const BOTTOM: [[Ring; 4]; 1] = [[
    [1.5, 0.15, 0.56],
    [1.5, 0.075, 0.56],
    [1.425, 0.0, 0.56],
    [0.0, 0.0, 0.56],
]];

/// x and height of the inner corner, x and height of the outer corner, half-width.
type Loop = [f64; 5];
const HANDLE: [[Loop; 4]; 2] = [
    [
        [-1.6, 2.025, -1.5, 2.25, 0.3],
        [-2.3, 2.025, -2.5, 2.25, 0.3],
        [-2.7, 2.025, -3.0, 2.25, 0.3],
        [-2.7, 1.8, -3.0, 1.8, 0.3],
    ],
    [
        [-2.7, 1.8, -3.0, 1.8, 0.3],
        [-2.7, 1.575, -3.0, 1.35, 0.3],
        [-2.5, 1.125, -2.65, 0.9375, 0.3],
        [-2.0, 0.9, -1.9, 0.6, 0.3],
    ],
];
const SPOUT: [[Loop; 4]; 2] = [
    [
        [1.7, 1.425, 1.7, 0.6, 0.66],
        [2.6, 1.425, 3.1, 0.825, 0.66],
        [2.3, 2.1, 2.4, 2.025, 0.25],
        [2.7, 2.4, 3.3, 2.4, 0.25],
    ],
    [
        [2.7, 2.4, 3.3, 2.4, 0.25],
        [2.8, 2.475, 3.525, 2.49375, 0.25],
        [2.9, 2.475, 3.45, 2.5125, 0.15],
        [2.8, 2.4, 3.2, 2.4, 0.15],
    ],
];

/// A rectangle of the texture: left, bottom, right, top.
type Rect = [f64; 4];

/// With `steps` squares along each side of a patch.
pub(crate) fn teapot(steps: usize) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.append(turned("body", &BODY, [0.0, 0.34, 1.0, 0.80], steps));
    mesh.append(turned("bottom", &BOTTOM, [0.0, 0.24, 1.0, 0.33], steps));
    mesh.append(turned("lid", &LID, [0.0, 0.81, 1.0, 1.0], steps));
    mesh.append(tube("handle", &HANDLE, [0.0, 0.0, 0.49, 0.23], steps));
    mesh.append(tube("spout", &SPOUT, [0.51, 0.0, 1.0, 0.23], steps));
    mesh.welded()
}

/// A body of revolution from its profile, a ring of four patches after the other.
fn turned<const N: usize>(name: &str, profile: &[[Ring; 4]; N], rect: Rect, steps: usize) -> Mesh {
    let quarter = |[r, h, k]: Ring| {
        [
            DVec3::new(r, h, 0.0),
            DVec3::new(r, h, -k * r),
            DVec3::new(k * r, h, -r),
            DVec3::new(0.0, h, -r),
        ]
    };
    let patches = profile.iter().map(|rings| {
        let first = rings.map(quarter);
        core::array::from_fn::<_, 4, _>(|turn| first.map(|row| row.map(|p| quarter_turns(p, turn))))
    });
    surface(name, &patches.collect::<Vec<_>>(), rect, steps)
}

fn quarter_turns(p: DVec3, turns: usize) -> DVec3 {
    (0..turns).fold(p, |p, _| DVec3::new(p.z, p.y, -p.x))
}

/// A tube from its loops: the near half and the mirrored far half.
fn tube<const N: usize>(name: &str, loops: &[[Loop; 4]; N], rect: Rect, steps: usize) -> Mesh {
    let half = |[xi, hi, xo, ho, w]: Loop| {
        [
            DVec3::new(xi, hi, 0.0),
            DVec3::new(xi, hi, w),
            DVec3::new(xo, ho, w),
            DVec3::new(xo, ho, 0.0),
        ]
    };
    let patches = loops.iter().map(|rows| {
        let near = rows.map(half);
        let far = near.map(|[a, b, c, d]| [d, c, b, a].map(|p| DVec3::new(p.x, p.y, -p.z)));
        [near, far]
    });
    surface(name, &patches.collect::<Vec<_>>(), rect, steps)
}

/// Tessellates rows of patches that close on themselves sideways; v follows the length of the first column,
/// so that the texture is not squeezed where a profile bends.
fn surface<const AROUND: usize>(
    name: &str,
    rows: &[[[[DVec3; 4]; 4]; AROUND]],
    rect: Rect,
    steps: usize,
) -> Mesh {
    let (across, down) = (AROUND * steps, rows.len() * steps);
    let at = |i: usize, j: usize| {
        // The last line of one row of patches is the first of the next.
        let (row, t) = if j == down {
            (rows.len() - 1, 1.0)
        } else {
            (j / steps, (j % steps) as f64 / steps as f64)
        };
        let (patch, s) = (i / steps % AROUND, (i % steps) as f64 / steps as f64);
        evaluate(&rows[row][patch], s, t)
    };
    let mut lengths = vec![0.0];
    for j in 1..=down {
        lengths.push(lengths[j - 1] + length(at(0, j).0 - at(0, j - 1).0));
    }
    let mut mesh = Mesh::default();
    for j in 0..=down {
        for i in 0..=across {
            let share = lengths[j] / lengths[down];
            let u = rect[0] + (rect[2] - rect[0]) * i as f64 / across as f64;
            mesh.uvs.push([u, rect[3] - (rect[3] - rect[1]) * share]);
            if i < across {
                let (position, normal) = at(i, j);
                mesh.positions.push(position);
                mesh.normals.push(normal);
            }
        }
    }
    let mut faces = Vec::new();
    for (j, i) in (0..down * across).map(|k| (k / across, k % across)) {
        let corner = |di: usize, dj: usize| {
            let vertex = (j + dj) * across + (i + di) % across;
            Corner {
                position: vertex,
                uv: (j + dj) * (across + 1) + i + di,
                normal: vertex,
            }
        };
        let mut face = vec![corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
        // A pole's square has no width at one end: a triangle remains.
        face.dedup_by_key(|c| mesh.positions[c.position]);
        if mesh.positions[face[0].position] == mesh.positions[face[face.len() - 1].position] {
            face.pop();
        }
        faces.push(face);
    }
    mesh.groups.push((name.into(), faces));
    mesh
}

/// Point and outward unit normal of a bicubic patch at (s across, t down).
fn evaluate(patch: &[[DVec3; 4]; 4], s: f64, t: f64) -> (DVec3, DVec3) {
    let rows = patch.map(|row| bezier(&row, s));
    let (point, down) = (bezier(&rows, t), slope(&rows, t));
    let across = bezier(&patch.map(|row| slope(&row, s)), t);
    let normal = down.cross(across);
    if length(normal) > 1e-9 {
        return (point, unit(normal));
    }
    // At a pole every column meets: the normal is the axis, up on top and down below.
    (point, if t < 0.5 { DVec3::Y } else { DVec3::NEG_Y })
}

fn bezier(p: &[DVec3; 4], t: f64) -> DVec3 {
    let r = 1.0 - t;
    p[0] * (r * r * r) + p[1] * (3.0 * r * r * t) + p[2] * (3.0 * r * t * t) + p[3] * (t * t * t)
}

fn slope(p: &[DVec3; 4], t: f64) -> DVec3 {
    let r = 1.0 - t;
    (p[1] - p[0]) * (3.0 * r * r) + (p[2] - p[1]) * (6.0 * r * t) + (p[3] - p[2]) * (3.0 * t * t)
}
