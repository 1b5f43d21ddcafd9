//! The colour of the cow at a point in space.

use texmap_math::glam::DVec3;

use super::shape::{self, EYE, EYE_RADIUS, MUZZLE, NECK};
use super::{BELL, EARS, EYES, HORNS, TAIL};
use crate::mesh::{length, unit};
use crate::picture::{chance, mix, smooth_step};

pub(crate) const PURPLE: u32 = 0xB04BDC;
const CREAM: u32 = 0xFFF3FA;
const PINK: u32 = 0xFFA6C8;
const DEEP: u32 = 0x5B2A86;
const HOOF: u32 = 0x4A3550;
const DARK: u32 = 0x2A1430;
const RED: u32 = 0xD8323C;
const GOLD: u32 = 0xF2B632;

type Color = [f64; 3];

pub(crate) fn color(part: usize, p: DVec3, n: DVec3) -> Color {
    match part {
        EYES => eye(p),
        EARS => ear(p, n),
        HORNS => over(
            hex(0xF4E6C8),
            hex(0x7A5C48),
            smooth_step(1.74, 1.90, p.y + 0.01 * wobble(p * 6.0)),
        ),
        TAIL => over(
            hex(PURPLE),
            hex(DEEP),
            smooth_step(0.63, 0.60, p.y + 0.03 * wobble(p * 9.0)),
        ),
        BELL => over(hex(GOLD), hex(DARK), smooth_step(0.816, 0.812, p.y)),
        _ => body(p, n),
    }
}

fn body(p: DVec3, n: DVec3) -> Color {
    let mut c = hex(PURPLE);
    c = over(c, hex(CREAM), patches(p));
    // Belly and blaze between the eyes.
    c = over(
        c,
        hex(CREAM),
        smooth_step(0.55, 0.62, -n.y + 0.15 * wobble(p * 5.0))
            * smooth_step(0.78, 0.70, p.y)
            * smooth_step(0.36, 0.44, p.y),
    );
    let blaze = p.z.abs() - 0.035 - 0.05 * smooth_step(1.62, 1.32, p.y);
    c = over(
        c,
        hex(CREAM),
        inside(blaze, 0.008)
            * smooth_step(0.98, 1.02, p.x)
            * smooth_step(1.22, 1.26, p.y)
            * smooth_step(1.64, 1.60, p.y),
    );
    c = over(
        c,
        hex(DEEP),
        inside(
            shape::ellipsoid(
                p,
                DVec3::new(1.02, 1.66, 0.0),
                DVec3::new(0.105, 0.075, 0.10),
            ) + 0.012 * wobble(p * 14.0),
            0.008,
        ),
    );
    c = over(
        c,
        hex(PINK),
        inside(
            shape::ellipsoid(
                p,
                shape::UDDER - DVec3::Y * 0.05,
                DVec3::new(0.21, 0.16, 0.19),
            ),
            0.01,
        ),
    );
    let hoof = over(
        hex(HOOF),
        hex(DARK),
        smooth_step(0.012, 0.004, (p.z.abs() - 0.245).abs()) * smooth_step(0.5, 0.7, n.x),
    );
    c = over(c, hoof, smooth_step(0.155, 0.147, p.y));
    c = muzzle(c, p, n);
    collar(c, p)
}

/// Cream patches: balls whose rims are roughened.
fn patches(p: DVec3) -> f64 {
    const SPOTS: [([f64; 3], f64); 12] = [
        ([-0.45, 1.18, 0.40], 0.26),
        ([0.12, 0.86, 0.46], 0.21),
        ([0.42, 1.22, 0.32], 0.15),
        ([-0.86, 0.86, 0.32], 0.17),
        ([-0.05, 1.32, -0.18], 0.24),
        ([-0.62, 0.92, -0.44], 0.25),
        ([0.30, 0.82, -0.46], 0.22),
        ([-0.95, 1.12, -0.12], 0.15),
        ([0.48, 0.42, 0.33], 0.10),
        ([-0.70, 0.46, -0.37], 0.11),
        ([0.88, 1.40, 0.27], 0.12),
        ([0.70, 1.32, -0.24], 0.13),
    ];
    let rough = 0.045 * wobble(p * 5.0) + 0.02 * wobble(p * 11.0);
    let nearest = SPOTS
        .iter()
        .map(|(s, r)| length(p - DVec3::from(*s)) - r)
        .fold(f64::INFINITY, |a, b| if b < a { b } else { a });
    inside(nearest + rough, 0.006)
}

fn muzzle(under: Color, p: DVec3, n: DVec3) -> Color {
    let rim = shape::ellipsoid(
        p,
        MUZZLE + DVec3::new(0.03, -0.01, 0.0),
        DVec3::new(0.16, 0.165, 0.225),
    ) + 0.006 * wobble(p * 9.0);
    let mut c = over(under, hex(PINK), inside(rim, 0.008));
    let side = DVec3::new(p.x, p.y, p.z.abs());
    let nostril = shape::ellipsoid(side, shape::nostril_at(), DVec3::new(0.06, 0.034, 0.030));
    c = over(c, hex(0x8E2F5E), inside(nostril, 0.006));
    // A smile: a curve that rises to both sides of the muzzle, and a dimple at its ends.
    let from = p - MUZZLE;
    let curve = -0.070 + 1.9 * from.z * from.z;
    let line = (from.y - curve).abs() - 0.0085;
    let front = smooth_step(-0.2, 0.0, n.x) * smooth_step(0.172, 0.166, from.z.abs());
    c = over(
        c,
        hex(0x8E2F5E),
        inside(line, 0.004) * front * smooth_step(0.02, 0.04, from.x),
    );
    let dimple = length(side - (MUZZLE + DVec3::new(0.075, -0.012, 0.175))) - 0.022;
    over(c, hex(0xF0709F), inside(dimple, 0.012) * 0.8)
}

fn collar(under: Color, p: DVec3) -> Color {
    let axis = unit(NECK.1 - NECK.0 + DVec3::new(0.0, 0.1, 0.0));
    let middle = NECK.0 + (NECK.1 - NECK.0) * 0.56;
    let along = (p - middle).dot(axis).abs();
    let near = smooth_step(0.5, 0.45, length(p - middle));
    let band = over(hex(RED), hex(0x9C1C2C), smooth_step(0.026, 0.030, along));
    over(under, band, smooth_step(0.042, 0.038, along) * near)
}

fn eye(p: DVec3) -> Color {
    let side = DVec3::new(p.x, p.y, p.z.abs());
    let from = (side - EYE) / EYE_RADIUS;
    let gaze = unit(DVec3::new(0.90, 0.02, 0.44));
    let away = length(unit(from) - gaze);
    let mut c = hex(0xFFFFFF);
    c = over(c, hex(0x5A3A1E), smooth_step(0.66, 0.60, away));
    c = over(c, hex(0x120810), smooth_step(0.46, 0.40, away));
    // The glint sits on the same side of both eyes, toward one light.
    let glint = unit(DVec3::new(0.86, 0.28, if p.z < 0.0 { 0.26 } else { 0.60 }));
    c = over(
        c,
        hex(0xFFFFFF),
        smooth_step(0.17, 0.12, length(unit(from) - glint)),
    );
    let lid = from.y - 0.68 - 0.04 * from.z;
    c = over(c, hex(DEEP), smooth_step(-0.05, -0.01, lid));
    over(c, hex(PURPLE), smooth_step(0.05, 0.09, lid))
}

fn ear(p: DVec3, n: DVec3) -> Color {
    let z = p.z.abs();
    let middle = length(DVec3::new(
        (p.y - 1.53 + (z - 0.36).max(0.0) * 0.45) / 0.065,
        0.0,
        (z - 0.37) / 0.125,
    )) - 1.0;
    over(
        hex(PURPLE),
        hex(PINK),
        inside(middle, 0.08) * smooth_step(0.1, 0.3, n.x),
    )
}

/// 1 inside (negative distance), 0 outside, with a rim of half-width `soft`.
fn inside(distance: f64, soft: f64) -> f64 {
    smooth_step(soft, -soft, distance)
}

fn over(under: Color, top: Color, coverage: f64) -> Color {
    core::array::from_fn(|i| mix(under[i], top[i], coverage))
}

fn hex(rgb: u32) -> Color {
    [rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255].map(|c| f64::from(c) / 255.0)
}

/// Value noise in space, in [-1, 1].
fn wobble(p: DVec3) -> f64 {
    let f = p.floor();
    let t = p - f;
    let t = t * t * (DVec3::splat(3.0) - t * 2.0);
    let (x, y, z) = (f.x as i32, f.y as i32, f.z as i32);
    let at =
        |dx: i32, dy: i32, dz: i32| chance(x + dx, y + dy, 77u32.wrapping_add((z + dz) as u32));
    let plane = |dz: i32| {
        mix(
            mix(at(0, 0, dz), at(1, 0, dz), t.x),
            mix(at(0, 1, dz), at(1, 1, dz), t.x),
            t.y,
        )
    };
    mix(plane(0), plane(1), t.z) * 2.0 - 1.0
}
