//! Faces and coordinates of directions in a layout, in f32. [`EnvironmentLayout::locate`] is the reference in f64; coordinates are off by
//! less than 4e-7.

use core::f32::consts::{FRAC_1_PI, FRAC_2_PI};

use texmap_math::deterministic_f32::atan2_lanes;
use texmap_math::simd::{Isa, prelude::*};

use super::EnvironmentLayout;
use crate::cube_face::Side;
use crate::lanes::Vector;
use crate::vector::dot;

const FRAC_1_TAU: f32 = 0.5 * FRAC_1_PI;
const FRAC_4_PI: f32 = 4.0 * FRAC_1_PI;

impl EnvironmentLayout {
    /// Faces and coordinates of finite directions that are not zero.
    #[inline(always)]
    pub(crate) fn place<I: Isa>(self, i: I, d: Vector<I>) -> (I::I32, [I::F32; 2]) {
        let most = d[0].abs().above(d[1].abs()).above(d[2].abs());
        let [x, y, z] = [d[0] / most, d[1] / most, d[2] / most];
        let length = dot([x, y, z], [x, y, z]).sqrt();
        let (back, first) = (z.simd_lt(0.0), i.i32(0));
        match self {
            Self::Cube | Self::TanCube => {
                let side = Side::<I>::of(d);
                let [right, down, axis] = side.along(d);
                let (p, q) = if self == Self::Cube {
                    (right / axis, down / axis)
                } else {
                    (
                        atan2_lanes(i, right, axis) * FRAC_4_PI,
                        atan2_lanes(i, down, axis) * FRAC_4_PI,
                    )
                };
                (side.face(i), [p * 0.5 + 0.5, q * 0.5 + 0.5])
            }
            Self::LatLong => {
                let longitude = atan2_lanes(i, x, -z);
                let from_top = atan2_lanes(i, (x * x + z * z).sqrt(), y);
                let uv = [longitude * FRAC_1_TAU + 0.5, from_top * FRAC_1_PI];
                (first, uv)
            }
            Self::Octahedron => {
                let sum = x.abs() + y.abs() + z.abs();
                let p = [x / sum, y / sum];
                (first, unit(i, fold(i, back, p)))
            }
            Self::EqualAreaOctahedron => {
                let [x, y, z] = [x / length, y / length, z / length];
                let r = ((x * x + y * y) / (z.abs() + 1.0)).sqrt();
                let along = r * atan2_lanes(i, y.abs(), x.abs()) * FRAC_2_PI;
                let p = [sign(i, x) * (r - along), sign(i, y) * along];
                (first, unit(i, fold(i, back, p)))
            }
            Self::DualParaboloid => {
                let below = length + z.abs();
                let face = back.select(first + 1, first);
                (face, unit(i, [x / below, y / below]))
            }
            Self::SphereMap => {
                // 1 + z without cancellation.
                let rise = back.select((x * x + y * y) / (length - z), length + z);
                let m = (length * 2.0 * rise).sqrt();
                // Exactly -Z is any point of the rim.
                let some = m.simd_gt(0.0);
                let p = [
                    some.select(x / m, i.f32(1.0)),
                    some.select(y / m, i.f32(0.0)),
                ];
                (first, unit(i, p))
            }
        }
    }
}

/// Face coordinates 0..=1, v down, from -1..=1, y up.
#[inline(always)]
fn unit<I: Isa>(i: I, [x, y]: [I::F32; 2]) -> [I::F32; 2] {
    [x * 0.5 + 0.5, i.f32(0.5) - y * 0.5]
}

/// 1 for zero too, of either sign: the folds need a side.
#[inline(always)]
fn sign<I: Isa>(i: I, x: I::F32) -> I::F32 {
    x.simd_lt(0.0).select(i.f32(-1.0), i.f32(1.0))
}

/// Between the inner and the outer triangles of an unfolded octahedron, in some lanes.
#[inline(always)]
fn fold<I: Isa>(i: I, lanes: I::Mask, [x, y]: [I::F32; 2]) -> [I::F32; 2] {
    let folded = [
        sign(i, x) * (i.f32(1.0) - y.abs()),
        sign(i, y) * (i.f32(1.0) - x.abs()),
    ];
    [lanes.select(folded[0], x), lanes.select(folded[1], y)]
}

#[cfg(test)]
mod tests {
    use super::super::tests::{directions, special};
    use super::*;
    use crate::vector::{columns, load};
    use alloc::vec::Vec;
    use texmap_math::glam::DVec3;
    use texmap_math::simd::Scalar;

    fn all() -> Vec<[f32; 3]> {
        let d = directions(4_000).chain(special());
        let mut all: Vec<_> = d.map(|d| d.to_array().map(|c| c as f32)).collect();
        // Of any length, near the blind spot of the sphere map and near poles.
        let more: Vec<_> = all
            .iter()
            .step_by(7)
            .map(|d| d.map(|c| c * 1e-30))
            .collect();
        let near = (1..12i32).flat_map(|i| {
            let e = 0.1f32.powi(i);
            [[e, 0.0, -1.0], [-e, e, -1.0], [e, 1.0, -e], [e, -1.0, e]]
        });
        all.extend(more.into_iter().chain(near));
        all
    }

    /// The coordinates of each layout against the f64 ones, compared by their directions. A point of an edge may lie on either face.
    #[test]
    fn places_are_those_of_the_reference() {
        for chart in EnvironmentLayout::ALL {
            let mut worst = 0.0f64;
            for d in all() {
                let (face, uv) = chart.place(Scalar, d);
                assert!(uv.iter().all(|c| (-1e-6..=1.000_001).contains(c)), "{d:?}");
                let d = DVec3::from(d.map(f64::from));
                let (at, there) = chart.locate(d);
                let off = uv
                    .iter()
                    .zip(there.to_array())
                    .map(|(a, b)| (f64::from(*a) - b).abs());
                let off = off.fold(0.0, f64::max);
                if face.0 as usize == at && off < 0.1 {
                    worst = worst.max(off);
                } else {
                    // Other coordinates of the same direction.
                    let uv = texmap_math::glam::DVec2::new(uv[0].into(), uv[1].into());
                    let back = chart.direction(face.0 as usize, uv);
                    assert!((back - d.normalize()).length() < 2e-6, "{chart:?} {d}");
                }
            }
            assert!(worst > 0.0 && worst < 4e-7, "{chart:?}: {worst}");
        }
    }

    /// Every width gives the bits of one direction.
    #[test]
    fn widths_agree() {
        let all = all();
        for chart in EnvironmentLayout::ALL {
            every_width!(i => check(i, chart, &all));
        }
        fn check<I: Isa>(i: I, chart: EnvironmentLayout, all: &[[f32; 3]]) {
            for first in (0..all.len()).step_by(I::LANES) {
                let (face, uv) = chart.place(i, load(i, all, first));
                let (mut faces, places) = ([0; 16], columns(i, uv));
                face.store(&mut faces);
                for (lane, d) in all[first..].iter().take(I::LANES).enumerate() {
                    let (face, uv) = chart.place(Scalar, *d);
                    assert_eq!(faces[lane], face.0, "{chart:?} {d:?}");
                    let got = places.map(|c| c[lane].to_bits());
                    assert_eq!(got, uv.map(f32::to_bits), "{chart:?} {d:?}");
                }
            }
        }
    }
}
