//! Where directions fall in a chart, in f32: for one and for sixteen. [`Chart::locate`] is the reference in f64; coordinates are off by
//! less than 4e-7.

use core::f32::consts::{FRAC_1_PI, FRAC_2_PI};

use texmap_math::det32;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*};
use texmap_math::float::sqrt_f32;

use super::Chart;
use crate::cube_face::{Side, along, face_of};
use crate::lanes::V3;
use crate::vector::{dot, dot_lanes};

const FRAC_1_TAU: f32 = 0.5 * FRAC_1_PI;
const FRAC_4_PI: f32 = 4.0 * FRAC_1_PI;

/// Coordinates in a face.
type Uv<S> = [f32x16<S>; 2];

impl Chart {
    /// Face and coordinates of a finite direction that is not zero.
    pub(crate) fn place(self, d: [f32; 3]) -> (usize, [f32; 2]) {
        let [ax, ay, az] = d.map(f32::abs);
        let most = if ax > ay { ax } else { ay };
        let most = if most > az { most } else { az };
        let [x, y, z] = d.map(|c| c / most);
        let square = dot([x, y, z], [x, y, z]);
        match self {
            Self::Cube | Self::TanCube => {
                let face = face_of(d);
                let [right, down, axis] = along(face, d);
                let p = [right, down].map(|c| {
                    if self == Self::Cube {
                        c / axis
                    } else {
                        det32::atan2(c, axis) * FRAC_4_PI
                    }
                });
                (face, p.map(|c| 0.5 * c + 0.5))
            }
            Self::LatLong => {
                let longitude = det32::atan2(x, -z);
                let from_top = det32::atan2(sqrt_f32(x * x + z * z), y);
                (0, [longitude * FRAC_1_TAU + 0.5, from_top * FRAC_1_PI])
            }
            Self::Octahedron => {
                let sum = x.abs() + y.abs() + z.abs();
                let p = [x / sum, y / sum];
                (0, unit(if z < 0.0 { fold(p) } else { p }))
            }
            Self::EqualAreaOctahedron => {
                let [x, y, z] = [x, y, z].map(|c| c / sqrt_f32(square));
                let r = sqrt_f32((x * x + y * y) / (1.0 + z.abs()));
                let along = r * det32::atan2(y.abs(), x.abs()) * FRAC_2_PI;
                let p = [sign(x) * (r - along), sign(y) * along];
                (0, unit(if z < 0.0 { fold(p) } else { p }))
            }
            Self::DualParaboloid => {
                let below = sqrt_f32(square) + z.abs();
                (usize::from(z < 0.0), unit([x / below, y / below]))
            }
            Self::SphereMap => {
                let length = sqrt_f32(square);
                // 1 + z without cancellation.
                let rise = if z < 0.0 {
                    (x * x + y * y) / (length - z)
                } else {
                    length + z
                };
                let m = sqrt_f32(2.0 * length * rise);
                // Exactly -Z is any point of the rim.
                let p = if m > 0.0 { [x / m, y / m] } else { [1.0, 0.0] };
                (0, unit(p))
            }
        }
    }

    /// [`place`](Self::place) for sixteen.
    #[inline(always)]
    pub(crate) fn place_lanes<S: Simd>(self, s: S, d: V3<S>) -> (i32x16<S>, Uv<S>) {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let (ax, ay, az) = (d[0].abs(), d[1].abs(), d[2].abs());
        let most = ax.simd_gt(ay).select(ax, ay);
        let most = most.simd_gt(az).select(most, az);
        let [x, y, z] = [d[0] / most, d[1] / most, d[2] / most];
        let length = dot_lanes([x, y, z], [x, y, z]).sqrt();
        let (back, first) = (z.simd_lt(zero), i32x16::splat(s, 0));
        match self {
            Self::Cube | Self::TanCube => {
                let side = Side::of(s, d);
                let [right, down, axis] = side.along(d);
                let (p, q) = if self == Self::Cube {
                    (right / axis, down / axis)
                } else {
                    (
                        det32::atan2_lanes(texmap_math::simd::X16(s), right, axis) * FRAC_4_PI,
                        det32::atan2_lanes(texmap_math::simd::X16(s), down, axis) * FRAC_4_PI,
                    )
                };
                (side.face(s), [p * 0.5 + 0.5, q * 0.5 + 0.5])
            }
            Self::LatLong => {
                let longitude = det32::atan2_lanes(texmap_math::simd::X16(s), x, -z);
                let from_top =
                    det32::atan2_lanes(texmap_math::simd::X16(s), (x * x + z * z).sqrt(), y);
                let uv = [longitude * FRAC_1_TAU + 0.5, from_top * FRAC_1_PI];
                (first, uv)
            }
            Self::Octahedron => {
                let sum = x.abs() + y.abs() + z.abs();
                let p = [x / sum, y / sum];
                (first, unit_lanes(fold_lanes(s, back, p)))
            }
            Self::EqualAreaOctahedron => {
                let [x, y, z] = [x / length, y / length, z / length];
                let r = ((x * x + y * y) / (z.abs() + 1.0)).sqrt();
                let along =
                    r * det32::atan2_lanes(texmap_math::simd::X16(s), y.abs(), x.abs()) * FRAC_2_PI;
                let p = [sign_lanes(s, x) * (r - along), sign_lanes(s, y) * along];
                (first, unit_lanes(fold_lanes(s, back, p)))
            }
            Self::DualParaboloid => {
                let below = length + z.abs();
                let face = back.select(first + 1, first);
                (face, unit_lanes([x / below, y / below]))
            }
            Self::SphereMap => {
                let rise = back.select((x * x + y * y) / (length - z), length + z);
                let m = (length * 2.0 * rise).sqrt();
                let some = m.simd_gt(zero);
                let p = [some.select(x / m, one), some.select(y / m, zero)];
                (first, unit_lanes(p))
            }
        }
    }
}

/// From -1..=1, y up, to 0..=1, v down.
fn unit([x, y]: [f32; 2]) -> [f32; 2] {
    [0.5 * x + 0.5, 0.5 - 0.5 * y]
}

#[inline(always)]
fn unit_lanes<S: Simd>([x, y]: Uv<S>) -> Uv<S> {
    [x * 0.5 + 0.5, 0.5 - y * 0.5]
}

/// 1 for zero too, of either sign: the folds need a side.
fn sign(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[inline(always)]
fn sign_lanes<S: Simd>(s: S, x: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    x.simd_lt(zero).select(-one, one)
}

/// Between the inner and the outer triangles of an unfolded octahedron.
fn fold([x, y]: [f32; 2]) -> [f32; 2] {
    [sign(x) * (1.0 - y.abs()), sign(y) * (1.0 - x.abs())]
}

/// [`fold`] in some lanes.
#[inline(always)]
fn fold_lanes<S: Simd>(s: S, lanes: mask32x16<S>, [x, y]: Uv<S>) -> Uv<S> {
    let folded = [
        sign_lanes(s, x) * (1.0 - y.abs()),
        sign_lanes(s, y) * (1.0 - x.abs()),
    ];
    [lanes.select(folded[0], x), lanes.select(folded[1], y)]
}

#[cfg(test)]
mod tests {
    use super::super::tests::{directions, special};
    use super::*;
    use alloc::vec::Vec;
    use texmap_math::glam::DVec3;
    use texmap_math::lanes::LANES;

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

    /// Each chart's place against the f64 one, by the direction that it stands for: places on an edge may lie on either side.
    #[test]
    fn places_are_those_of_the_reference() {
        for chart in Chart::ALL {
            let mut worst = 0.0f64;
            for d in all() {
                let (face, uv) = chart.place(d);
                assert!(uv.iter().all(|c| (-1e-6..=1.000_001).contains(c)), "{d:?}");
                let d = DVec3::from(d.map(f64::from));
                let (at, there) = chart.locate(d);
                let off = uv
                    .iter()
                    .zip(there.to_array())
                    .map(|(a, b)| (f64::from(*a) - b).abs());
                let off = off.fold(0.0, f64::max);
                if face == at && off < 0.1 {
                    worst = worst.max(off);
                } else {
                    // Another place of the same direction.
                    let uv = texmap_math::glam::DVec2::new(uv[0].into(), uv[1].into());
                    let back = chart.direction(face, uv);
                    assert!((back - d.normalize()).length() < 2e-6, "{chart:?} {d}");
                }
            }
            assert!(worst > 0.0 && worst < 4e-7, "{chart:?}: {worst}");
        }
    }

    #[test]
    fn lanes_give_the_bits_of_one() {
        for chart in Chart::ALL {
            for block in all().chunks_exact(LANES) {
                let d =
                    [0, 1, 2].map(|k| -> [f32; LANES] { core::array::from_fn(|i| block[i][k]) });
                for level in [texmap_math::Level::new(), texmap_math::Level::baseline()] {
                    let (mut faces, mut places) = ([0; LANES], [[0.0; LANES]; 2]);
                    texmap_math::on_level!(level, s => {
                        let (face, uv) = chart.place_lanes(s, d.map(|c| f32x16::from_slice(s, &c)));
                        face.store_slice(&mut faces);
                        for (out, c) in places.iter_mut().zip(uv) {
                            c.store_slice(out);
                        }
                    }, else continue);
                    for (i, d) in block.iter().enumerate() {
                        let (face, uv) = chart.place(*d);
                        assert_eq!(faces[i], face as i32, "{chart:?} {d:?}");
                        let got = places.map(|c| c[i].to_bits());
                        assert_eq!(got, uv.map(f32::to_bits), "{chart:?} {d:?}");
                    }
                }
            }
        }
    }
}
