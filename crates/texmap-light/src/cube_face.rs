//! Faces of a cube in f32. Faces of directions and coordinates on the faces have the order and orientation of
//! [`EnvironmentLayout::Cube`](crate::EnvironmentLayout::Cube).

use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;

/// Sides of a cube's face along its coordinates and its axis, by face: the component that each is, and its sign.
const SIDES: [[(usize, f32); 3]; 6] = [
    [(2, -1.0), (1, -1.0), (0, 1.0)],
    [(2, 1.0), (1, -1.0), (0, -1.0)],
    [(0, 1.0), (2, 1.0), (1, 1.0)],
    [(0, 1.0), (2, -1.0), (1, -1.0)],
    [(0, 1.0), (1, -1.0), (2, 1.0)],
    [(0, -1.0), (1, -1.0), (2, -1.0)],
];

/// The vector of components to the right of a face, down, and along its axis: the reference of [`Side::direction`].
pub(crate) fn direction_of(face: usize, components: [f32; 3]) -> [f32; 3] {
    let mut d = [0.0; 3];
    for ((component, sign), c) in SIDES[face].into_iter().zip(components) {
        d[component] = c * sign;
    }
    d
}

/// The face of each lane.
#[derive(Clone, Copy)]
pub(crate) struct Side<I: Isa> {
    by_z: I::Mask,
    by_y: I::Mask,
    /// The positive one of two.
    up: I::Mask,
}

impl<I: Isa> Side<I> {
    /// Faces of finite directions that are not zero: z before y before x where components tie.
    #[inline(always)]
    pub(crate) fn of([x, y, z]: Vector<I>) -> Self {
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let by_z = az.simd_ge(ax) & az.simd_ge(ay);
        let by_y = ay.simd_ge(ax) & !by_z;
        let major = by_z.select(z, by_y.select(y, x));
        let up = major.simd_gt(0.0);
        Self { by_z, by_y, up }
    }

    /// Components of a vector to the right of a face, down, and along its axis.
    #[inline(always)]
    pub(crate) fn along(&self, [x, y, z]: Vector<I>) -> Vector<I> {
        let up = self.up;
        // z: (x, -y, z) and (-x, -y, -z); y: (x, z, y) and (x, -z, -y); x: (-z, -y, x) and (z, -y, -x).
        let sx = self.by_y.select(x, up.select(x, -x));
        let sc = (self.by_z | self.by_y).select(sx, up.select(-z, z));
        let tc = self.by_y.select(up.select(z, -z), -y);
        let major = self.by_z.select(z, self.by_y.select(y, x));
        [sc, tc, up.select(major, -major)]
    }

    /// The vector of such components: the inverse of [`along`](Self::along).
    #[inline(always)]
    pub(crate) fn direction(&self, [right, down, axis]: Vector<I>) -> Vector<I> {
        let up = self.up;
        let major = up.select(axis, -axis);
        let across = self.by_y.select(right, up.select(right, -right));
        let x = (self.by_z | self.by_y).select(across, major);
        let y = self.by_y.select(major, -down);
        let of_y = up.select(down, -down);
        let of_x = up.select(-right, right);
        let z = self.by_z.select(major, self.by_y.select(of_y, of_x));
        [x, y, z]
    }

    /// The numbers of the faces.
    #[inline(always)]
    pub(crate) fn face(&self, i: I) -> I::I32 {
        let first = self
            .by_z
            .select(i.i32(4), self.by_y.select(i.i32(2), i.i32(0)));
        self.up.select(first, first + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EnvironmentLayout;
    use crate::vector::{columns, load};
    use alloc::vec::Vec;
    use texmap_math::glam::DVec3;

    /// Directions within faces, on edges and at corners.
    fn directions() -> impl Iterator<Item = [f32; 3]> {
        let values = [-1.0, -0.75, -0.0, 0.5, 1.0];
        let grid = (0..125).map(move |i| [values[i % 5], values[i / 5 % 5], values[i / 25]]);
        grid.filter(|d| d.iter().any(|c| *c != 0.0))
    }

    /// Faces and coordinates are those of the cube layout, at every width.
    #[test]
    fn faces_are_those_of_the_chart() {
        let all: Vec<_> = directions().collect();
        check(texmap_math::simd::Scalar, &all);
        every_width!(i => check(i, &all));
        fn check<I: Isa>(i: I, all: &[[f32; 3]]) {
            for first in (0..all.len()).step_by(I::LANES) {
                let d = load(i, all, first);
                let side = Side::<I>::of(d);
                let mut faces = [0; 16];
                side.face(i).store(&mut faces);
                let there = side.along(d);
                let back = columns(i, side.direction(there));
                let there = columns(i, there);
                for (lane, d) in all[first..].iter().take(I::LANES).enumerate() {
                    let (face, uv) = EnvironmentLayout::Cube.locate(DVec3::from(d.map(f64::from)));
                    assert_eq!(faces[lane], face as i32, "{d:?}");
                    let [right, down, axis] = there.map(|c| c[lane]);
                    let place = [right, down].map(|c| f64::from(0.5 * c / axis + 0.5));
                    assert!((place[0] - uv.x).abs() < 1e-6 && (place[1] - uv.y).abs() < 1e-6);
                    assert_eq!(back.map(|c| c[lane]), *d, "{d:?}");
                    assert_eq!(direction_of(face, [right, down, axis]), *d, "{d:?}");
                }
            }
        }
    }
}
