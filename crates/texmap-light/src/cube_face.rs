//! Faces of a cube in f32: which one a direction meets, and its coordinates there, in the order and orientation of
//! [`Chart::Cube`](crate::Chart::Cube).

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*};

use crate::lanes::V3;

/// Sides of a cube's face along its coordinates and its axis, by face: the component that each is, and its sign.
const SIDES: [[(usize, f32); 3]; 6] = [
    [(2, -1.0), (1, -1.0), (0, 1.0)],
    [(2, 1.0), (1, -1.0), (0, -1.0)],
    [(0, 1.0), (2, 1.0), (1, 1.0)],
    [(0, 1.0), (2, -1.0), (1, -1.0)],
    [(0, 1.0), (1, -1.0), (2, 1.0)],
    [(0, -1.0), (1, -1.0), (2, -1.0)],
];

/// Components of a vector to the right of a face, down, and along its axis.
pub(crate) fn along(face: usize, d: [f32; 3]) -> [f32; 3] {
    SIDES[face].map(|(component, sign)| d[component] * sign)
}

/// The vector of such components: the inverse of [`along`].
pub(crate) fn direction_of(face: usize, components: [f32; 3]) -> [f32; 3] {
    let mut d = [0.0; 3];
    for ((component, sign), c) in SIDES[face].into_iter().zip(components) {
        d[component] = c * sign;
    }
    d
}

/// Face of a finite direction that is not zero: z before y before x where components tie.
pub(crate) fn face_of([x, y, z]: [f32; 3]) -> usize {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if az >= ax && az >= ay {
        if z > 0.0 { 4 } else { 5 }
    } else if ay >= ax {
        if y > 0.0 { 2 } else { 3 }
    } else if x > 0.0 {
        0
    } else {
        1
    }
}

/// The face of each lane.
#[derive(Clone, Copy)]
pub(crate) struct Side<S: Simd> {
    by_z: mask32x16<S>,
    by_y: mask32x16<S>,
    /// The positive one of two.
    up: mask32x16<S>,
}

impl<S: Simd> Side<S> {
    /// [`face_of`] for sixteen.
    #[inline(always)]
    pub(crate) fn of(s: S, [x, y, z]: V3<S>) -> Self {
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let by_z = az.simd_ge(ax) & az.simd_ge(ay);
        let by_y = ay.simd_ge(ax) & !by_z;
        let major = by_z.select(z, by_y.select(y, x));
        let up = major.simd_gt(f32x16::splat(s, 0.0));
        Self { by_z, by_y, up }
    }

    /// [`along`] for sixteen.
    #[inline(always)]
    pub(crate) fn along(&self, [x, y, z]: V3<S>) -> V3<S> {
        let up = self.up;
        // z: (x, -y, z) and (-x, -y, -z); y: (x, z, y) and (x, -z, -y); x: (-z, -y, x) and (z, -y, -x).
        let sx = self.by_y.select(x, up.select(x, -x));
        let sc = (self.by_z | self.by_y).select(sx, up.select(-z, z));
        let tc = self.by_y.select(up.select(z, -z), -y);
        let major = self.by_z.select(z, self.by_y.select(y, x));
        [sc, tc, up.select(major, -major)]
    }

    /// [`direction_of`] for sixteen.
    #[inline(always)]
    pub(crate) fn direction(&self, [right, down, axis]: V3<S>) -> V3<S> {
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
    pub(crate) fn face(&self, s: S) -> i32x16<S> {
        let (four, two, zero) = (
            i32x16::splat(s, 4),
            i32x16::splat(s, 2),
            i32x16::splat(s, 0),
        );
        let first = self.by_z.select(four, self.by_y.select(two, zero));
        self.up.select(first, first + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Chart;
    use texmap_math::glam::DVec3;
    use texmap_math::lanes::LANES;

    /// Directions within faces, on edges and at corners.
    fn directions() -> impl Iterator<Item = [f32; 3]> {
        let values = [-1.0, -0.75, -0.0, 0.5, 1.0];
        let grid = (0..125).map(move |i| [values[i % 5], values[i / 5 % 5], values[i / 25]]);
        grid.filter(|d| d.iter().any(|c| *c != 0.0))
    }

    #[test]
    fn faces_are_those_of_the_chart() {
        for d in directions() {
            let (face, uv) = Chart::Cube.locate(DVec3::from(d.map(f64::from)));
            let [right, down, axis] = along(face_of(d), d);
            assert_eq!(face_of(d), face, "{d:?}");
            let place = [right, down].map(|c| f64::from(0.5 * c / axis + 0.5));
            assert!((place[0] - uv.x).abs() < 1e-6 && (place[1] - uv.y).abs() < 1e-6);
            assert_eq!(direction_of(face, along(face, d)), d);
        }
    }

    #[test]
    fn lanes_give_the_bits_of_one() {
        let all: Vec<_> = directions().collect();
        for block in all.chunks_exact(LANES) {
            let column = |k: usize| -> [f32; LANES] { core::array::from_fn(|i| block[i][k]) };
            let d = [0, 1, 2].map(column);
            for level in [texmap_math::Level::new(), texmap_math::Level::baseline()] {
                let (mut faces, mut got) = ([0; LANES], [[[0.0f32; LANES]; 3]; 2]);
                texmap_math::on_level!(level, s => {
                    let d = d.map(|column| f32x16::from_slice(s, &column));
                    let side = Side::of(s, d);
                    side.face(s).store_slice(&mut faces);
                    let there = side.along(d);
                    for (out, v) in got.iter_mut().zip([there, side.direction(there)]) {
                        for (out, c) in out.iter_mut().zip(v) {
                            c.store_slice(out);
                        }
                    }
                }, else continue);
                for (i, d) in block.iter().enumerate() {
                    let face = face_of(*d);
                    assert_eq!(faces[i], face as i32, "{d:?}");
                    assert_eq!(got[0].map(|c| c[i]), along(face, *d), "{d:?}");
                    assert_eq!(got[1].map(|c| c[i]), *d, "{d:?}");
                }
            }
        }
    }
}
