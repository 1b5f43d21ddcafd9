//! Clipping in homogeneous space changes no value (property 14).

use proptest::prelude::*;
use texmap_math::bary;
use texmap_math::glam::{DVec2, DVec3};

use crate::strategies::{EPS32, area2, at, config, inverse_w, triangle, weights};

/// A vertex before the division: (x, y, z) with the screen at (x/z, y/z), and an attribute.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    position: DVec3,
    u: f64,
}

/// The part of a polygon where `plane . position >= 0`, cut in homogeneous space (Sutherland and Hodgman 1974).
fn clip(polygon: &[Vertex], plane: DVec3) -> Vec<Vertex> {
    let mut out = Vec::new();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (da, db) = (plane.dot(a.position), plane.dot(b.position));
        if da >= 0.0 {
            out.push(*a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            out.push(Vertex {
                position: a.position.lerp(b.position, t),
                u: a.u * (1.0 - t) + b.u * t,
            });
        }
    }
    out
}

fn screen(v: [Vertex; 3]) -> [DVec2; 3] {
    v.map(|v| v.position.truncate() / v.position.z)
}

fn value(v: [Vertex; 3], x: DVec2) -> f64 {
    let l = bary::screen(screen(v), x).expect("area");
    bary::blend(
        bary::perspective(l, v.map(|v| 1.0 / v.position.z)).expect("in front"),
        v.map(|v| v.u),
    )
}

fn value_f32(v: [Vertex; 3], x: DVec2) -> f64 {
    let narrow = |v: DVec2| [v.x as f32, v.y as f32];
    let l = bary::screen_f32(screen(v).map(narrow), narrow(x)).expect("area");
    let b = bary::perspective_f32(l, v.map(|v| 1.0 / v.position.z as f32)).expect("in front");
    f64::from(bary::blend_f32(b, v.map(|v| v.u as f32)))
}

/// Affine interpolation, which clipping does change.
fn affine(v: [Vertex; 3], x: DVec2) -> f64 {
    bary::blend(bary::screen(screen(v), x).expect("area"), v.map(|v| v.u))
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn clipping_changes_no_value(
        p in triangle(3.0, 0.05), inv_w in [inverse_w(3.0), inverse_w(3.0), inverse_w(3.0)], u in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
        near in 0.2..3.0f64, side in -1.5..1.5f64, first in 0..5usize, l in weights(),
    ) {
        let whole: [Vertex; 3] = std::array::from_fn(|i| Vertex { position: p[i].extend(1.0) / inv_w[i], u: u[i] });
        // z >= near needs the constant: cut where z passes it, as a plane through the first vertex's depth would not be.
        let shifted: Vec<Vertex> = whole.to_vec();
        let near_cut = clip_near(&shifted, near);
        // x <= side * z.
        let pieces = clip(&near_cut, DVec3::new(-1.0, 0.0, side));
        prop_assume!(pieces.len() >= 3);
        for k in 1..pieces.len() - 1 {
            let n = pieces.len();
            let piece = [pieces[first % n], pieces[(first + k) % n], pieces[(first + k + 1) % n]];
            let size = area2(screen(piece)) / 2.0;
            if size < 1e-3 {
                continue;
            }
            let x = at(screen(piece), l);
            let want = value(whole, x);
            prop_assert!((value(piece, x) - want).abs() <= 1e-11);
            if size >= 0.02 {
                prop_assert!((value_f32(piece, x) - want).abs() <= 200.0 * EPS32);
            }
        }
    }
}

/// Clips against z >= near, an affine plane in (x, y, z).
fn clip_near(polygon: &[Vertex], near: f64) -> Vec<Vertex> {
    let mut out = Vec::new();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (da, db) = (a.position.z - near, b.position.z - near);
        if da >= 0.0 {
            out.push(*a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            out.push(Vertex {
                position: a.position.lerp(b.position, t),
                u: a.u * (1.0 - t) + b.u * t,
            });
        }
    }
    out
}

/// Negative: affine values move when a triangle is clipped.
#[test]
fn clipping_moves_affine_values() {
    let whole = [
        Vertex {
            position: DVec3::new(-1.0, -1.0, 1.0),
            u: 0.0,
        },
        Vertex {
            position: DVec3::new(8.0, -8.0, 8.0),
            u: 1.0,
        },
        Vertex {
            position: DVec3::new(0.0, 2.0, 2.0),
            u: 0.5,
        },
    ];
    let pieces = clip(&whole, DVec3::new(-1.0, 0.0, 0.5));
    let piece = [pieces[0], pieces[1], pieces[2]];
    let x = at(screen(piece), [0.3, 0.3, 0.4]);
    assert!((value(piece, x) - value(whole, x)).abs() < 1e-12);
    assert!((affine(piece, x) - affine(whole, x)).abs() > 1e-2);
}
