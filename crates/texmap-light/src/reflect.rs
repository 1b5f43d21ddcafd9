//! The mirrored view, and its change from pixel to pixel.

use texmap_math::simd::{Isa, Number};

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

#[cfg(test)]
mod tests {
    use crate::{Ray, reflect_across};
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
