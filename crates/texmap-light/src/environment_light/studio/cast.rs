//! The room of the studio by ray casting and a blur, and its light: makes the files that the library holds.
//!
//! Positions and strengths are those of the environment "neutral" of model-viewer (`EnvironmentScene.js`, Apache-2.0).

use texmap_math::deterministic_f64;
use texmap_math::float::sqrt;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::progress::no_progress;

use super::{GATHERED, ROOM, SIZE};
use crate::environment::Environment;
use crate::environment_light::gather::{Kernel, Texels};
use crate::environment_light::{EnvironmentLight, Prefilter, Roughnesses};
use crate::{EnvironmentLayout, shared_exponent};

/// Rays a texel and side.
const RAYS: u32 = 2;
/// Standard deviation of the blur, radians.
const BLUR: f32 = 0.04;
/// Position of the eye, 3.5 below the origin of the room.
const EYE: DVec3 = DVec3::new(0.0, 3.5, 0.0);
/// Middle and half the sides of the room.
const WALLS: (DVec3, DVec3) = (DVec3::new(0.0, 13.2, 0.0), DVec3::new(15.75, 14.25, 15.75));
/// The point light of the room and of the white boxes: position, intensity in candela and range.
const POINT_LIGHT: (DVec3, f64, f64) = (DVec3::new(0.5, 14.0, 0.5), 400.0, 28.0);

/// Middle, turn about +Y and sides of a white box.
const BOXES: [([f64; 3], f64, [f64; 3]); 6] = [
    ([-10.906, -1.0, 1.846], -0.195, [2.328, 7.905, 4.651]),
    ([-5.607, -0.754, -0.758], 0.994, [1.970, 1.534, 3.955]),
    ([6.167, -0.16, 7.803], 0.561, [3.927, 6.285, 3.687]),
    ([-2.017, 0.018, 6.124], 0.333, [2.002, 4.566, 2.064]),
    ([2.291, -0.756, -2.621], -0.286, [1.546, 1.552, 1.496]),
    ([-2.193, -0.369, -5.547], 0.516, [3.875, 3.487, 2.986]),
];

/// Radiance, middle and sides of a bright slab.
const SLABS: [(f64, [f64; 3], [f64; 3]); 7] = [
    (80.0, [-14.0, 10.0, 8.0], [0.1, 2.5, 2.5]),
    (80.0, [-14.0, 14.0, -4.0], [0.1, 2.5, 2.5]),
    (23.0, [14.0, 12.0, 0.0], [0.1, 5.0, 5.0]),
    (16.0, [0.0, 9.0, 14.0], [5.0, 5.0, 0.1]),
    (80.0, [7.0, 8.0, -14.0], [2.5, 2.5, 0.1]),
    (80.0, [-7.0, 16.0, -14.0], [2.5, 2.5, 0.1]),
    (1.0, [0.0, 20.0, 0.0], [0.1, 0.1, 0.1]),
];

/// A box about +Y.
struct Solid {
    middle: DVec3,
    half: DVec3,
    cos: f64,
    sin: f64,
    /// Radiance of a slab; `None` for boxes, which are lit.
    radiance: Option<f64>,
    /// The cone about its bounding sphere, seen from [`EYE`]: unit axis and cosine of the half angle.
    cone: (DVec3, f64),
}

impl Solid {
    fn all() -> [Self; 13] {
        core::array::from_fn(|k| {
            let (middle, turn, sides, radiance) = match BOXES.get(k) {
                Some((middle, turn, sides)) => (middle, *turn, sides, None),
                None => {
                    let (radiance, middle, sides) = &SLABS[k - BOXES.len()];
                    (middle, 0.0, sides, Some(*radiance))
                }
            };
            let (sin, cos) = deterministic_f64::sin_cos(turn);
            let (middle, half) = (DVec3::from(*middle), DVec3::from(*sides) * 0.5);
            let way = middle - EYE;
            let missed = 1.0 - half.length_squared() / way.length_squared();
            // A little wider than it is. All of the sky where the eye is in the sphere.
            let limit = if missed > 0.0 {
                sqrt(missed) - 1e-6
            } else {
                -2.0
            };
            Self {
                middle,
                half,
                cos,
                sin,
                radiance,
                cone: (way / way.length(), limit),
            }
        })
    }

    /// Distance along a ray from [`EYE`] and the normal of the face that it enters.
    fn meets(&self, d: DVec3) -> Option<(f64, DVec3)> {
        let (c, s) = (self.cos, self.sin);
        let turned = |v: DVec3| DVec3::new(c * v.x - s * v.z, v.y, s * v.x + c * v.z);
        let (from, d) = (turned(EYE - self.middle), turned(d));
        let (mut enters, mut leaves, mut axis) = (f64::NEG_INFINITY, f64::INFINITY, 0);
        for k in 0..3 {
            // Parallel rays divide by zero and compare as they should; none starts on a face's plane.
            let (a, b) = (
                (-self.half[k] - from[k]) / d[k],
                (self.half[k] - from[k]) / d[k],
            );
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            if a > enters {
                (enters, axis) = (a, k);
            }
            leaves = if b < leaves { b } else { leaves };
        }
        if !(enters > 0.0 && enters < leaves) {
            return None;
        }
        let mut n = DVec3::ZERO;
        n[axis] = if d[axis] > 0.0 { -1.0 } else { 1.0 };
        Some((
            enters,
            DVec3::new(c * n.x + s * n.z, n.y, c * n.z - s * n.x),
        ))
    }
}

/// Radiance of a white surface under the point light.
fn lit(point: DVec3, normal: DVec3) -> f64 {
    let (position, intensity, range) = POINT_LIGHT;
    let way = position - point;
    let square = way.length_squared();
    let ratio = square / (range * range);
    let window = 1.0 - ratio * ratio;
    let window = if window > 0.0 { window } else { 0.0 };
    let facing = normal.dot(way) / sqrt(square);
    let facing = if facing > 0.0 { facing } else { 0.0 };
    intensity * window * window * facing / (square * core::f64::consts::PI)
}

/// Radiance from a direction.
fn radiance(solids: &[Solid], d: DVec3) -> f64 {
    // The eye is in the room, so that a ray meets a wall.
    let (middle, half) = WALLS;
    let (mut nearest, mut normal) = (f64::INFINITY, DVec3::ZERO);
    for k in 0..3 {
        let wall = if d[k] > 0.0 { half[k] } else { -half[k] };
        let way = (middle[k] + wall - EYE[k]) / d[k];
        if way < nearest {
            nearest = way;
            normal = DVec3::ZERO;
            normal[k] = if d[k] > 0.0 { -1.0 } else { 1.0 };
        }
    }
    let mut own = None;
    for solid in solids {
        let (axis, limit) = solid.cone;
        if d.dot(axis) < limit {
            continue;
        }
        if let Some((way, towards)) = solid.meets(d)
            && way < nearest
        {
            (nearest, normal, own) = (way, towards, solid.radiance);
        }
    }
    own.unwrap_or_else(|| lit(EYE + d * nearest, normal))
}

/// The light of the room as its eye sees it.
fn cast() -> Environment {
    let solids = Solid::all();
    let room = Environment::from_directions(
        EnvironmentLayout::Cube,
        SIZE,
        &no_progress,
        |face, centre, sides| {
            let mut sum = 0.0;
            for ray in 0..RAYS * RAYS {
                let inside = |k: u32| (f64::from(k) + 0.5) / f64::from(RAYS) - 0.5;
                let offset = DVec2::new(inside(ray % RAYS), inside(ray / RAYS));
                let uv = (centre + offset) / sides;
                sum += radiance(&solids, EnvironmentLayout::Cube.direction(face, uv));
            }
            [(sum / f64::from(RAYS * RAYS)) as f32; 3]
        },
    );
    Texels::new(&room.unwrap(), 0)
        .lobe(Kernel::gaussian(BLUR))
        .environment(EnvironmentLayout::Cube, SIZE)
        .unwrap()
}

/// The words of grey light without two of their channels.
fn codes(cube: &Environment) -> impl Iterator<Item = u8> {
    cube.first_level().iter().flat_map(|texel| {
        let word = shared_exponent::pack(texel);
        let code = word & 511 | (word >> 27) << 9;
        (code as u16).to_le_bytes()
    })
}

/// The files hold what is cast and gathered, to the bit. `TEXMAP_BLESS=1` writes them after a change of the room.
#[test]
fn the_files_hold_the_room_and_its_light() {
    let cast = cast();
    let mut made = Prefilter::of_cube(cast.clone());
    let light = made.light(Roughnesses::ALL).unwrap();
    let texels = cast.texels.iter();
    let room: Vec<u8> = texels.flat_map(|[light, ..]| light.to_le_bytes()).collect();
    let gathered: Vec<u8> = made
        .diffuse
        .iter()
        .flatten()
        .chain(made.rough.iter().flatten())
        .flat_map(codes)
        .collect();
    if std::env::var_os("TEXMAP_BLESS").is_some() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/environment_light/studio/");
        std::fs::write(folder.to_owned() + "room.f32", &room).unwrap();
        std::fs::write(folder.to_owned() + "gathered.u14", &gathered).unwrap();
        return;
    }
    assert!(room == ROOM[..] && gathered == GATHERED[..]);
    assert_eq!(light, EnvironmentLight::studio());
}
