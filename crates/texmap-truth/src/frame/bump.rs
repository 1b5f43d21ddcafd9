//! Bump: normals that turn without moving the surface, by heights and offsets (Blinn 1978) or normal maps.

use texmap_light::NormalMapGreen;
use texmap_math::glam::{DMat3, DVec3};
use texmap_sample::Origin;
use texmap_scene::{Mesh, NormalDetail};

use super::carving::Formula;
use super::color::straight;
use super::lighting::Point;
use super::slot::{Place, Slot, Textures};
use super::surface::linear;

/// The least cosine between a normal and the direction to the eye, if a bump may not turn it further.
const HORIZON: f64 = 0.01;

/// A bump or normal map on a mesh.
pub(super) enum BumpMap<'s> {
    /// Heights, and the world units of a white texel over a black one.
    Heights(Slot<'s>, f64),
    /// Slopes, and the world units over the whole picture where a channel is 1.
    Offsets(Slot<'s>, f64, NormalMapGreen),
    Formula(Formula),
    /// Normals as colours.
    Normals {
        slot: Slot<'s>,
        green: NormalMapGreen,
        rebuild_z: bool,
        strength: f64,
        /// From the object to the world, unless the normals are those of tangent frames.
        world_from_normal: Option<DMat3>,
    },
}

impl<'s> BumpMap<'s> {
    pub(super) fn new(detail: &'s NormalDetail, mesh: &Mesh, textures: &mut Textures<'s>) -> Self {
        let origin = mesh.uv_origin;
        // World units of one of the object's: the mean of its axes by volume.
        let unit = linear(mesh).determinant().abs().cbrt();
        match detail {
            NormalDetail::Bump { slot, height } => {
                Self::Heights(textures.slot(slot, origin), f64::from(*height) * unit)
            }
            NormalDetail::Offsets { slot, slope, green } => Self::Offsets(
                textures.slot(slot, origin),
                f64::from(*slope) * unit,
                *green,
            ),
            NormalDetail::Procedural {
                heights,
                world_from_solid,
                height,
            } => Self::Formula(Formula::new(
                *heights,
                *world_from_solid,
                f64::from(*height) * unit,
            )),
            NormalDetail::NormalMap {
                slot,
                green,
                rebuild_z,
                object_space,
                strength,
            } => Self::Normals {
                slot: textures.slot(slot, origin),
                green: *green,
                rebuild_z: *rebuild_z,
                strength: f64::from(*strength),
                world_from_normal: object_space.then(|| linear(mesh).inverse().transpose()),
            },
        }
    }

    /// The unit normal that it leaves of a unit normal of the front.
    pub(super) fn normal(&self, at: &Point, n: DVec3) -> DVec3 {
        match self {
            Self::Formula(formula) => formula.normal(at, n),
            Self::Heights(slot, height) => {
                let place = slot.placed(at.read(slot));
                bumped(
                    at,
                    n,
                    place,
                    heights(slot, place).map(|slope| slope * height),
                )
            }
            Self::Offsets(slot, slope, green) => {
                let place = slot.placed(at.read(slot));
                let texel = straight(slot.filtered(place)) * 2.0 - 1.0;
                // Green grows up or down the picture, v down it from a top-left origin, else up it.
                let up =
                    (*green == NormalMapGreen::Up) == (slot.texture.origin() == Origin::TopLeft);
                let along_v = if up { -texel.y } else { texel.y };
                bumped(at, n, place, [texel.x * slope, along_v * slope])
            }
            Self::Normals {
                slot,
                green,
                rebuild_z,
                strength,
                world_from_normal,
            } => {
                let texel = slot.straight(at.read(slot)) * 2.0 - 1.0;
                let y = if *green == NormalMapGreen::Up {
                    texel.y
                } else {
                    -texel.y
                };
                let z = if *rebuild_z {
                    (1.0 - texel.x * texel.x - y * y).max(0.0).sqrt()
                } else {
                    texel.z
                };
                let map = DVec3::new(texel.x * strength, y * strength, z);
                if let Some(matrix) = world_from_normal {
                    return (*matrix * map).normalize_or_zero();
                }
                let (tangent, sign) = at.tangent;
                let turned = tangent * map.x + n.cross(tangent) * (sign * map.y) + n * map.z;
                let frame = tangent != DVec3::ZERO || (map.x == 0.0 && map.y == 0.0);
                if frame && turned.length() > 0.0 {
                    turned.normalize()
                } else {
                    n
                }
            }
        }
    }
}

/// A normal that was turned away from the eye, back at the horizon; `view` leads to the eye.
pub(super) fn clamped(n: DVec3, view: DVec3) -> DVec3 {
    let along = n.dot(view);
    if along >= HORIZON || view == DVec3::ZERO {
        return n;
    }
    let level = (n - view * along).normalize_or_zero();
    level * (1.0 - HORIZON * HORIZON).sqrt() + view * HORIZON
}

/// `N' = N + B_u (n x O_v) - B_v (n x O_u)` with `N = |O_u x O_v| n` (Blinn 1978), for heights that rise along the unit normal n. O_u and
/// O_v follow from the change of position and coordinates from sample to sample.
fn bumped(at: &Point, n: DVec3, place: Place, [b_u, b_v]: [f64; 2]) -> DVec3 {
    let (dx, dy) = (place.dx, place.dy);
    let det = dx.x * dy.y - dx.y * dy.x;
    if det == 0.0 || !det.is_finite() {
        return n;
    }
    let [px, py] = at.moves;
    let (o_u, o_v) = ((px * dy.y - py * dx.y) / det, (py * dx.x - px * dy.x) / det);
    raised(n, o_u, o_v, b_u, b_v)
}

/// The formula itself; coordinates of the other handedness turn the surface, not the bump.
pub(super) fn raised(n: DVec3, o_u: DVec3, o_v: DVec3, b_u: f64, b_v: f64) -> DVec3 {
    let raw = o_u.cross(o_v);
    let side = if raw.dot(n) < 0.0 { -1.0 } else { 1.0 };
    let turned = n * raw.length() + (n.cross(o_v) * b_u - n.cross(o_u) * b_v) * side;
    if raw.length() > 0.0 && turned.length() > 0.0 {
        turned.normalize()
    } else {
        n
    }
}

/// Slopes of a height map along u and v: central differences over a texel to each side, or the sample where that is wider.
fn heights(slot: &Slot<'_>, place: Place) -> [f64; 2] {
    let (w, h) = (slot.texture.width(), slot.texture.height());
    let du = (1.0 / f64::from(w))
        .max(place.dx.x.abs())
        .max(place.dy.x.abs());
    let dv = (1.0 / f64::from(h))
        .max(place.dx.y.abs())
        .max(place.dy.y.abs());
    let height = |u: f64, v: f64| {
        let mut beside = place;
        (beside.uv.x, beside.uv.y) = (place.uv.x + u, place.uv.y + v);
        straight(slot.filtered(beside)).x
    };
    [
        (height(du, 0.0) - height(-du, 0.0)) / (2.0 * du),
        (height(0.0, dv) - height(0.0, -dv)) / (2.0 * dv),
    ]
}
