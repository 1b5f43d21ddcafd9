//! The mirrored view, and its change from pixel to pixel.

use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;
use crate::vector::dot;

/// A direction and its change for one pixel to the right and one down, in each lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayLanes<I: Isa> {
    /// The direction, of any length.
    pub direction: [I::F32; 3],
    /// Change for one pixel to the right.
    pub dx: [I::F32; 3],
    /// Change for one pixel down.
    pub dy: [I::F32; 3],
}

/// The mirrored view `R = 2(N.V)N - V`: see [`crate::reflect`].
#[inline(always)]
pub fn reflect<T: Number<f32>>(view: [T; 3], normal: [T; 3]) -> [T; 3] {
    let k = dot(normal, view) * 2.0;
    [
        k * normal[0] - view[0],
        k * normal[1] - view[1],
        k * normal[2] - view[2],
    ]
}

/// [`reflect`] with the change of its result: see [`crate::reflect_across`].
#[inline(always)]
pub fn reflect_across<I: Isa>(
    i: I,
    view: &RayLanes<I>,
    normal: &RayLanes<I>,
    length: I::F32,
) -> RayLanes<I> {
    let (n, v) = (normal.direction, view.direction);
    let facing = dot(n, v);
    let per_length = i.f32(1.0) / length;
    RayLanes {
        direction: reflect(v, n),
        dx: change(i, n, v, facing, view.dx, normal.dx, per_length),
        dy: change(i, n, v, facing, view.dy, normal.dy, per_length),
    }
}

/// Change of the mirrored view by those of the view, `dv`, and of the vector that gives the normal, `d`.
#[inline(always)]
fn change<I: Isa>(
    _: I,
    n: Vector<I>,
    v: Vector<I>,
    facing: I::F32,
    dv: Vector<I>,
    d: Vector<I>,
    per_length: I::F32,
) -> Vector<I> {
    let along = dot(n, d);
    let mut dn = d;
    for k in 0..3 {
        dn[k] = (d[k] - along * n[k]) * per_length;
    }
    let k = dot(dn, v) + dot(n, dv);
    let mut out = d;
    for c in 0..3 {
        out[c] = (k * n[c] + facing * dn[c]) * 2.0 - dv[c];
    }
    out
}

/// A box whose walls a mirror shows: an environment holds them as they are seen from the `center` of its capture, and a ray from another
/// point is led to the wall that it meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectionBox {
    /// Least corner of the box, in the world.
    pub low: [f32; 3],
    /// Greatest corner.
    pub high: [f32; 3],
    /// The point from which the environment was captured, within the box.
    pub center: [f32; 3],
}

impl ReflectionBox {
    /// Distance from a wall up to which a position outside still counts as one on it, by the side of the box: floors and walls of a room
    /// that is the box lie on it, up to rounding.
    pub const WALL: f32 = 1.0 / 1024.0;

    /// The direction from the centre to the wall that `ray` meets from a position, with its change; `ray` where the position is not in the
    /// box ([`WALL`](Self::WALL) beyond it at most). Neither ray nor result need have length 1. Source: Lagarde and Zanuttini 2012, "Local image-based lighting with
    /// parallax-corrected cubemaps".
    ///
    /// With t the least of `(wall - P) / R` over the axes and H = P + t R: `dt = -(dP + t dR) / R` on the axis of the wall, and the change of
    /// H - C is `dP + t dR + dt R`.
    #[inline(always)]
    pub fn led<I: Isa>(&self, i: I, position: &RayLanes<I>, ray: &RayLanes<I>) -> RayLanes<I> {
        let (p, r) = (position.direction, ray.direction);
        let mut t = i.f32(f32::MAX);
        let mut inside = t.simd_gt(0.0);
        // The axis of the wall: ray, and the changes of position and ray along it.
        let mut along = [i.f32(1.0), t, t, t, t];
        for k in 0..3 {
            let beyond = (self.high[k] - self.low[k]) * Self::WALL;
            inside =
                inside & p[k].simd_ge(self.low[k] - beyond) & p[k].simd_le(self.high[k] + beyond);
            let ahead = r[k].simd_gt(0.0);
            let wall = ahead.select(i.f32(self.high[k]), i.f32(self.low[k]));
            let reach = (wall - p[k]) / r[k];
            // Rays along a wall never meet it, whatever their quotient is.
            let nearer = reach.simd_lt(t) & !r[k].simd_eq(0.0);
            t = nearer.select(reach, t);
            let here = [r[k], position.dx[k], position.dy[k], ray.dx[k], ray.dy[k]];
            for c in 0..5 {
                along[c] = nearer.select(here[c], along[c]);
            }
        }
        let [r_wall, px, py, rx, ry] = along;
        let inside = inside & t.simd_gt(0.0) & t.simd_lt(f32::MAX);
        let tx = -(px + t * rx) / r_wall;
        let ty = -(py + t * ry) / r_wall;
        let mut out = *ray;
        for k in 0..3 {
            let hit = (p[k] - self.center[k]) + t * r[k];
            out.direction[k] = inside.select(hit, r[k]);
            let dx = position.dx[k] + t * ray.dx[k] + tx * r[k];
            let dy = position.dy[k] + t * ray.dy[k] + ty * r[k];
            out.dx[k] = inside.select(dx, ray.dx[k]);
            out.dy[k] = inside.select(dy, ray.dy[k]);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::ReflectionBox;
    use crate::{Ray, reflect_across};
    use texmap_math::glam::DVec3;
    use texmap_math::simd::Scalar;

    fn wide(v: [f32; 3]) -> DVec3 {
        DVec3::from(v.map(f64::from))
    }

    /// Rays are led to the wall that they meet, and change as their neighbours say; from outside of the box they stay as they are.
    #[test]
    fn rays_end_on_the_walls() {
        let walls = ReflectionBox {
            low: [-2.0, -1.0, -3.0],
            high: [2.0, 3.0, 1.0],
            center: [0.0, 1.0, -1.0],
        };
        let (p, dp) = (DVec3::new(0.5, 0.2, -0.3), DVec3::new(0.1, -0.2, 0.05));
        let (r, dr) = (DVec3::new(0.4, 0.9, -0.6), DVec3::new(-0.3, 0.2, 0.5));
        // The wall y = 3 is the nearest along r.
        let led = |t: f64| {
            let (p, r) = (p + dp * t, r + dr * t);
            p + r * ((3.0 - p.y) / r.y) - DVec3::new(0.0, 1.0, -1.0)
        };
        let narrow = |v: DVec3| v.to_array().map(|c| c as f32);
        let ray = |v: DVec3, dv: DVec3| Ray {
            direction: narrow(v),
            dx: narrow(dv),
            dy: [0.0; 3],
        };
        let found = walls.led(Scalar, &ray(p, dp), &ray(r, dr));
        let slope = (led(1e-5) - led(-1e-5)) / 2e-5;
        assert!(
            (wide(found.direction) - led(0.0)).length() < 1e-5,
            "{found:?}"
        );
        assert!(
            (wide(found.dx) - slope).length() < 1e-4,
            "{found:?} {slope}"
        );
        assert_eq!(found.dy, [0.0; 3]);
        // From the centre a ray keeps its direction; from elsewhere it does not.
        let middle = walls.led(Scalar, &ray(wide(walls.center), dp), &ray(r, dr));
        let turn = |a: [f32; 3]| wide(a).normalize().dot(r.normalize());
        assert!(turn(middle.direction) > 1.0 - 1e-6 && turn(found.direction) < 0.995);
        let outside = walls.led(Scalar, &ray(DVec3::new(0.0, 5.0, 0.0), dp), &ray(r, dr));
        assert_eq!(outside, ray(r, dr));
        // From beside the box, towards it and past it.
        for (p, r) in [
            (DVec3::new(3.0, 0.0, 0.0), DVec3::new(1.0, 2.0, 0.5)),
            (DVec3::new(3.0, 0.0, 0.0), DVec3::new(-1.0, 2.0, 0.5)),
            (DVec3::new(0.0, -1.1, 0.0), DVec3::new(0.1, 1.0, 0.0)),
        ] {
            assert_eq!(walls.led(Scalar, &ray(p, dp), &ray(r, dr)), ray(r, dr));
        }
        // A floor that is the wall of the box is in it, also where rounding puts it below.
        for y in [-1.0, -1.0 - 1e-6] {
            let floor = DVec3::new(0.5, y, 0.0);
            let found = walls.led(Scalar, &ray(floor, dp), &ray(DVec3::Y, dr));
            let seen = DVec3::new(0.5, 3.0, 0.0) - wide(walls.center);
            assert!((wide(found.direction) - seen).length() < 1e-5, "{found:?}");
        }
        // A ray along an axis meets the wall of that axis.
        let along = walls.led(Scalar, &ray(p, dp), &ray(DVec3::Z, dr));
        assert_eq!(along.direction[2], 2.0);
    }

    /// The change of a mirrored ray against mirrored neighbours.
    #[test]
    fn mirrored_rays_change_as_their_neighbours_say() {
        let (v, dv) = (DVec3::new(0.4, 0.2, 2.0), DVec3::new(-0.3, 0.1, 0.2));
        let (n, dn) = (DVec3::new(0.1, 0.9, 1.2), DVec3::new(0.5, -0.4, 0.3));
        let mirrored = |t: f64| {
            let (v, n) = (v + dv * t, (n + dn * t).normalize());
            n * (2.0 * n.dot(v)) - v
        };
        let narrow = |v: DVec3| v.to_array().map(|c| c as f32);
        let view = Ray {
            direction: narrow(v),
            dx: narrow(dv),
            dy: [0.0; 3],
        };
        let normal = Ray {
            direction: narrow(n.normalize()),
            dx: narrow(dn),
            dy: [0.0; 3],
        };
        let ray = reflect_across(&view, &normal, n.length() as f32);
        let slope = (mirrored(1e-5) - mirrored(-1e-5)) / 2e-5;
        assert!((wide(ray.direction) - mirrored(0.0)).length() < 1e-5);
        assert!((wide(ray.dx) - slope).length() < 1e-5, "{:?}", ray.dx);
        assert_eq!(ray.dy, [0.0; 3]);
    }
}
