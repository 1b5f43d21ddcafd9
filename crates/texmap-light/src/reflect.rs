//! The mirrored view, and how fast it turns from pixel to pixel.

use texmap_math::fearless_simd::{Simd, f32x16};

use crate::lanes::V3;
use crate::vector::{dot, dot_lanes};

/// A direction and its change for one pixel to the right and one down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ray {
    /// Of any length.
    pub direction: [f32; 3],
    /// To the right.
    pub dx: [f32; 3],
    /// Down.
    pub dy: [f32; 3],
}

/// The mirrored view: `R = 2(N.V)N - V` for the direction V to the eye and a unit normal N. R has the length of V.
#[must_use]
pub fn reflect(view: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    let k = 2.0 * dot(normal, view);
    [0, 1, 2].map(|i| k * normal[i] - view[i])
}

/// [`reflect`] with the change of its result: `dR = 2 ((dN.V + N.dV) N + (N.V) dN) - dV`. `normal` holds a unit normal and the
/// change of the vector that it is the direction of, of length `length`: what turns a normal is the part of that across it. (Igehy
/// 1999, Tracing Ray Differentials.)
#[must_use]
pub fn reflect_across(view: &Ray, normal: &Ray, length: f32) -> Ray {
    let (n, v) = (normal.direction, view.direction);
    let (facing, per_length) = (dot(n, v), 1.0 / length);
    let change = |dv: [f32; 3], d: [f32; 3]| {
        let along = dot(n, d);
        let dn = [0, 1, 2].map(|i| (d[i] - along * n[i]) * per_length);
        let k = dot(dn, v) + dot(n, dv);
        [0, 1, 2].map(|i| 2.0 * (k * n[i] + facing * dn[i]) - dv[i])
    };
    Ray {
        direction: reflect(v, n),
        dx: change(view.dx, normal.dx),
        dy: change(view.dy, normal.dy),
    }
}

/// A [`Ray`] in each lane.
#[derive(Clone, Copy)]
pub struct RayLanes<S: Simd> {
    /// Of any length.
    pub direction: V3<S>,
    /// To the right.
    pub dx: V3<S>,
    /// Down.
    pub dy: V3<S>,
}

impl<S: Simd> core::fmt::Debug for RayLanes<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("RayLanes")
    }
}

/// [`reflect`] for sixteen.
#[inline(always)]
pub fn reflect_lanes<S: Simd>(view: V3<S>, normal: V3<S>) -> V3<S> {
    let k = dot_lanes(normal, view) * 2.0;
    let mut out = view;
    for i in 0..3 {
        out[i] = k * normal[i] - view[i];
    }
    out
}

/// [`reflect_across`] for sixteen.
#[inline(always)]
pub fn reflect_across_lanes<S: Simd>(
    view: &RayLanes<S>,
    normal: &RayLanes<S>,
    length: f32x16<S>,
) -> RayLanes<S> {
    let (n, v) = (normal.direction, view.direction);
    let facing = dot_lanes(n, v);
    let per_length = 1.0 / length;
    RayLanes {
        direction: reflect_lanes(v, n),
        dx: change_lanes(n, v, facing, view.dx, normal.dx, per_length),
        dy: change_lanes(n, v, facing, view.dy, normal.dy, per_length),
    }
}

#[inline(always)]
fn change_lanes<S: Simd>(
    n: V3<S>,
    v: V3<S>,
    facing: f32x16<S>,
    dv: V3<S>,
    d: V3<S>,
    per_length: f32x16<S>,
) -> V3<S> {
    let along = dot_lanes(n, d);
    let mut dn = d;
    for i in 0..3 {
        dn[i] = (d[i] - along * n[i]) * per_length;
    }
    let k = dot_lanes(dn, v) + dot_lanes(n, dv);
    let mut out = d;
    for i in 0..3 {
        out[i] = (k * n[i] + facing * dn[i]) * 2.0 - dv[i];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::glam::DVec3;

    fn wide(v: [f32; 3]) -> DVec3 {
        DVec3::from(v.map(f64::from))
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
