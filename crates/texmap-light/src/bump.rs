use alloc::vec::Vec;

use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::error::{LightError, same_length};
use crate::lanes::Vector;
use crate::normal_map::NormalMap;
use crate::unit;
use crate::vector::{self, cross, dot, is_zero, select};

/// Measure of the slope of a height field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slope {
    /// `(f(x + 1) - f(x - 1)) / 2`. On a sine of n samples a period it falls short by `1 - sin(2 pi / n) / (2 pi / n)`.
    #[default]
    Central,
    /// The same, averaged over three rows with weights 1 2 1: less noise, the same shortfall along a row.
    Sobel,
}

/// A grid of heights that repeats in both directions.
#[derive(Clone, Copy, Debug)]
pub struct Heights<'a> {
    /// Columns, at least 1.
    pub width: u32,
    /// `width * rows` heights, rows top to bottom.
    pub values: &'a [f32],
}

impl Heights<'_> {
    /// Change of height per texel to the right and down at texel (x, y). Indices wrap.
    ///
    /// # Errors
    /// [`LightError::Length`] unless the values fill rows of `width`.
    pub fn slope(&self, x: i64, y: i64, slope: Slope) -> Result<[f32; 2], LightError> {
        self.check()?;
        Ok(self.slope_unchecked(x, y, slope))
    }

    /// Tangent-space normals of all texels, unit length, x to the right, y up or down the picture by `green`, z out of the
    /// surface: `unit(-strength dh/dx, -strength dh/dy, 1)`. `strength` is the height of 1 in texels.
    ///
    /// # Errors
    /// As [`Heights::slope`].
    pub fn normals(
        &self,
        slope: Slope,
        strength: f32,
        green: NormalMapGreen,
    ) -> Result<Vec<[f32; 3]>, LightError> {
        self.check()?;
        let columns = i64::from(self.width);
        let texels = (0..self.values.len() as i64).map(|i| (i % columns, i / columns));
        let normal = |(x, y)| {
            let [right, down] = self.slope_unchecked(x, y, slope).map(|d| d * strength);
            unit([
                -right,
                if green == NormalMapGreen::Up {
                    down
                } else {
                    -down
                },
                1.0,
            ])
        };
        Ok(texels.map(normal).collect())
    }

    /// The slopes themselves, for an offset map: the change of height over the whole picture, to the right and up or down it by
    /// `green`, as a fraction of the largest change, which is the second result. [`encode_offsets`] makes texels of them. `height` is that
    /// of 1.
    ///
    /// # Errors
    /// As [`Heights::slope`].
    pub fn offsets(
        &self,
        slope: Slope,
        height: f32,
        green: NormalMapGreen,
    ) -> Result<(Vec<[f32; 2]>, f32), LightError> {
        self.check()?;
        let columns = i64::from(self.width);
        let rows = self.values.len() as f32 / columns as f32;
        let over_all = |i: i64| {
            let [right, down] = self.slope_unchecked(i % columns, i / columns, slope);
            let down = down * rows * height;
            [
                right * columns as f32 * height,
                if green == NormalMapGreen::Up {
                    -down
                } else {
                    down
                },
            ]
        };
        let mut offsets: Vec<[f32; 2]> = (0..self.values.len() as i64).map(over_all).collect();
        let mut most = 0.0;
        for c in offsets.as_flattened() {
            most = if c.abs() > most { c.abs() } else { most };
        }
        if most > 0.0 {
            for c in offsets.as_flattened_mut() {
                *c /= most;
            }
        }
        Ok((offsets, most))
    }

    fn check(&self) -> Result<(), LightError> {
        if self.width == 0 {
            return same_length("columns", 0, 1);
        }
        let width = self.width as usize;
        let rows = self.values.len() / width;
        same_length("heights", self.values.len(), rows.max(1) * width)
    }

    fn slope_unchecked(&self, x: i64, y: i64, slope: Slope) -> [f32; 2] {
        let columns = i64::from(self.width);
        let rows = self.values.len() as i64 / columns;
        let (x, y) = (x.rem_euclid(columns), y.rem_euclid(rows));
        let at = |i: i64, j: i64| {
            self.values[((y + j).rem_euclid(rows) * columns + (x + i).rem_euclid(columns)) as usize]
        };
        match slope {
            Slope::Central => [(at(1, 0) - at(-1, 0)) * 0.5, (at(0, 1) - at(0, -1)) * 0.5],
            Slope::Sobel => {
                let across = |j| at(1, j) - at(-1, j);
                let along = |i| at(i, 1) - at(i, -1);
                let mean = |a: f32, b: f32, c: f32| (a + 2.0 * b + c) * 0.125;
                [
                    mean(across(-1), across(0), across(1)),
                    mean(along(-1), along(0), along(1)),
                ]
            }
        }
    }
}

/// Direction of the green channel of a normal map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalMapGreen {
    /// +Y, up the picture (OpenGL, glTF).
    #[default]
    Up,
    /// -Y, down the picture (Direct3D).
    Down,
}

/// A tangent-space normal from a texel of 0..=1 per channel: `2c - 1`, y up, unit length. With `rebuild_z` only red and green
/// are read and `z = sqrt(1 - x^2 - y^2)`, 0 where that has no root. A texel without direction gives +Z.
///
/// 8 bits: off by at most 0.38 degrees with three channels, 5.8 degrees at grazing angles with a rebuilt z.
#[must_use]
pub fn decode_normal(texel: [f32; 3], green: NormalMapGreen, rebuild_z: bool) -> [f32; 3] {
    let map = NormalMap {
        green,
        rebuild_z,
        strength: 1.0,
    };
    let n = unit(map.decode(Scalar, texel));
    if n == [0.0; 3] { [0.0, 0.0, 1.0] } else { n }
}

/// A texel of 0..=1 per channel from a tangent-space normal; the inverse of [`decode_normal`].
#[must_use]
pub fn encode_normal(normal: [f32; 3], green: NormalMapGreen) -> [f32; 3] {
    let [x, y, z] = unit(normal);
    [x, if green == NormalMapGreen::Up { y } else { -y }, z].map(|c| 0.5 * c + 0.5)
}

/// The slopes of a height field from the red and green of an offset map, 0..=1 each. They are `2c - 1`, as a fraction of the map's largest
/// slope; the second along growing v, down the picture. Blinn's other way to store a bump map (Blinn 1978): nothing is differenced at
/// the look-up, so nothing is lost by it.
///
/// 8 bits: off by at most 1/255 of the largest slope.
#[must_use]
pub fn decode_offsets(texel: [f32; 2], green: NormalMapGreen) -> [f32; 2] {
    let [x, y] = texel.map(|c| 2.0 * c - 1.0);
    [x, if green == NormalMapGreen::Up { -y } else { y }]
}

/// Red and green of 0..=1 from slopes of -1..=1 as [`Heights::offsets`] gives them.
#[must_use]
pub fn encode_offsets(offsets: [f32; 2]) -> [f32; 2] {
    offsets.map(|c| 0.5 * c + 0.5)
}

/// The normal of a surface O(u, v) displaced by a small height B(u, v) along its unit normal n (Blinn 1978):
/// `N' = N + B_u (n x O_v) - B_v (n x O_u)` with `N = O_u x O_v` NOT normalised; unit length. With a unit N in the first term
/// the result depends on the parametrisation, off by 8 degrees where this form is off by 0.5. The error of this form falls with
/// the square of the height. Parallel O_u and O_v give zero.
#[must_use]
pub fn bump(o_u: [f32; 3], o_v: [f32; 3], b_u: f32, b_v: f32) -> [f32; 3] {
    let raw = cross(o_u, o_v);
    let n = unit(raw);
    let (along_v, along_u) = (cross(n, o_v), cross(n, o_u));
    unit([0, 1, 2].map(|i| raw[i] + b_u * along_v[i] - b_v * along_u[i]))
}

/// [`bump`] on surfaces with smooth normals: see [`crate::bump_on`].
#[inline(always)]
pub fn bump_on<I: Isa>(
    i: I,
    n: Vector<I>,
    o_u: Vector<I>,
    o_v: Vector<I>,
    b_u: I::F32,
    b_v: I::F32,
) -> Vector<I> {
    let raw = cross(o_u, o_v);
    let area = dot(raw, raw).sqrt();
    let side = dot(raw, n).simd_lt(0.0).select(i.f32(-1.0), i.f32(1.0));
    let (along_v, along_u) = (cross(n, o_v), cross(n, o_u));
    let mut bumped = n;
    for k in 0..3 {
        bumped[k] = area * n[k] + side * (b_u * along_v[k] - b_v * along_u[k]);
    }
    let bumped = vector::unit(i, bumped);
    let useful = area.simd_gt(0.0) & !is_zero(i, bumped);
    select(useful, bumped, n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{bump_on, clamp_to_horizon, perturb};
    use core::f64::consts::TAU;
    use texmap_math::glam::DVec3;

    fn wide(a: [f32; 3]) -> DVec3 {
        DVec3::from(a.map(f64::from))
    }

    fn degrees(a: DVec3, b: DVec3) -> f64 {
        a.cross(b).length().atan2(a.dot(b)).to_degrees()
    }

    /// Case B1: the shortfall of a central difference on a sine, to 1 %.
    #[test]
    fn central_differences_fall_short_by_the_closed_form() {
        for n in [4u32, 8, 16, 32, 64] {
            let w = TAU / f64::from(n);
            let values: Vec<f32> = (0..n * 3)
                .map(|i| (f64::from(i % n) * w).sin() as f32)
                .collect();
            let heights = Heights {
                width: n,
                values: &values,
            };
            for slope in [Slope::Central, Slope::Sobel] {
                let [right, down] = heights.slope(0, 1, slope).unwrap();
                let short = 1.0 - f64::from(right) / w;
                let expected = 1.0 - w.sin() / w;
                assert!(
                    (short / expected - 1.0).abs() < 0.01,
                    "{n}: {short} for {expected}"
                );
                assert_eq!(down, 0.0);
            }
        }
    }

    #[test]
    fn normals_lean_against_the_slope_in_both_greens() {
        // Rises to the right and down.
        let values: Vec<f32> = (0..64).map(|i| (i % 8 + 2 * (i / 8)) as f32).collect();
        let heights = Heights {
            width: 8,
            values: &values,
        };
        let up = heights
            .normals(Slope::Central, 0.5, NormalMapGreen::Up)
            .unwrap()[3 * 8 + 3];
        let down = heights
            .normals(Slope::Central, 0.5, NormalMapGreen::Down)
            .unwrap()[3 * 8 + 3];
        let expected = DVec3::new(-0.5, 1.0, 1.0).normalize();
        assert!((wide(up) - expected).length() < 1e-6, "{up:?}");
        assert_eq!([up[0], -up[1], up[2]], down);
        // A mutant: the wrong green turns the bump inside out.
        assert!(
            degrees(
                wide(decode_normal(
                    encode_normal(up, NormalMapGreen::Up),
                    NormalMapGreen::Down,
                    false
                )),
                wide(up)
            ) > 45.0
        );
    }

    /// An offset map holds the differences of the heights, in both greens and within its 8 bits.
    #[test]
    fn offsets_are_the_slopes_of_the_heights() {
        let height = |x: u32, y: u32| {
            let (a, b) = (f64::from(x) / 16.0 * TAU, f64::from(y) / 8.0 * TAU);
            (0.5 + 0.3 * a.sin() + 0.2 * b.cos()) as f32
        };
        let values: Vec<f32> = (0..128).map(|i| height(i % 16, i / 16)).collect();
        let heights = Heights {
            width: 16,
            values: &values,
        };
        for green in [NormalMapGreen::Up, NormalMapGreen::Down] {
            let (offsets, most) = heights.offsets(Slope::Central, 0.2, green).unwrap();
            for (i, offset) in (0..).zip(&offsets) {
                let [right, down] = heights.slope(i % 16, i / 16, Slope::Central).unwrap();
                let bytes = encode_offsets(*offset).map(|c| (c * 255.0 + 0.5).floor() / 255.0);
                let found = decode_offsets(bytes, green).map(|c| c * most);
                let truth = [right * 0.2 * 16.0, down * 0.2 * 8.0];
                for k in 0..2 {
                    assert!(
                        (found[k] - truth[k]).abs() <= most * (1.0 / 255.0 + 1e-6),
                        "{i} {k}"
                    );
                }
            }
            let sizes = offsets.as_flattened().iter().map(|c| c.abs());
            let largest = sizes.fold(0.0, f32::max);
            assert_eq!(largest, 1.0);
        }
        let flat = Heights {
            width: 2,
            values: &[0.5; 4],
        };
        let (offsets, most) = flat.offsets(Slope::Sobel, 1.0, NormalMapGreen::Up).unwrap();
        assert_eq!((offsets[0].map(f32::abs), most), ([0.0; 2], 0.0));
    }

    /// Case B3: the error of 8 bits, with three channels and with two.
    #[test]
    fn eight_bits_cost_a_known_angle() {
        let (mut full, mut rebuilt) = (0.0f64, 0.0f64);
        for i in 0..40_000u32 {
            let (z, phi) = (f64::from(i) / 40_000.0, f64::from(i) * 2.399_963);
            let r = (1.0 - z * z).sqrt();
            let n = DVec3::new(r * phi.cos(), r * phi.sin(), z);
            let bytes = encode_normal(n.to_array().map(|c| c as f32), NormalMapGreen::Up)
                .map(|c| (c * 255.0 + 0.5).floor() / 255.0);
            full = full.max(degrees(
                wide(decode_normal(bytes, NormalMapGreen::Up, false)),
                n,
            ));
            rebuilt = rebuilt.max(degrees(
                wide(decode_normal(bytes, NormalMapGreen::Up, true)),
                n,
            ));
        }
        assert!(full <= 0.39 && full > 0.3, "{full}");
        assert!(rebuilt <= 5.9 && rebuilt > 3.0, "{rebuilt}");
    }

    /// Property 25 on a stretched cylinder: exact normal of the displaced surface against both readings of the formula.
    fn bump_error(amplitude: f64, unit_first: bool) -> f64 {
        let radius = 2.0;
        let surface = |u: f64, v: f64| {
            let out = DVec3::new(u.cos(), 0.0, u.sin());
            (out * radius + DVec3::Y * (3.0 * v), out)
        };
        let height = |u: f64, v: f64| amplitude * (3.0 * u).sin() * (2.0 * v).cos();
        let displaced = |u: f64, v: f64| {
            let (p, n) = surface(u, v);
            p + n * height(u, v)
        };
        let mut worst = 0.0f64;
        for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
            let (u, v, h) = (f64::from(i) * 0.3, f64::from(j) * 0.15, 1e-5);
            let slope = |f: &dyn Fn(f64, f64) -> DVec3| {
                (
                    (f(u + h, v) - f(u - h, v)) / (2.0 * h),
                    (f(u, v + h) - f(u, v - h)) / (2.0 * h),
                )
            };
            let ((o_u, o_v), (d_u, d_v)) = (slope(&|u, v| surface(u, v).0), slope(&displaced));
            // O_v x O_u points out of this cylinder.
            let truth = d_v.cross(d_u);
            let b_u = 3.0 * amplitude * (3.0 * u).cos() * (2.0 * v).cos();
            let b_v = -2.0 * amplitude * (3.0 * u).sin() * (2.0 * v).sin();
            let narrow = |a: DVec3| a.to_array().map(|c| c as f32);
            let got = if unit_first {
                // The lecture's reading, with N overwritten by its unit vector.
                let n = o_v.cross(o_u).normalize();
                n + n.cross(o_u) * b_v - n.cross(o_v) * b_u
            } else {
                wide(bump(narrow(o_v), narrow(o_u), b_v as f32, b_u as f32))
            };
            worst = worst.max(degrees(got, truth));
        }
        worst
    }

    #[test]
    fn the_bumped_normal_errs_with_the_square_of_the_height() {
        let (large, small) = (bump_error(0.1, false), bump_error(0.01, false));
        assert!(large < 2.0, "{large}");
        let order = (large / small).log10();
        assert!((order - 2.0).abs() < 0.2, "order {order}");
        // The negative twin falls with the height alone.
        let twin = (bump_error(0.1, true) / bump_error(0.01, true)).log10();
        assert!(bump_error(0.1, true) > 5.0 * large && twin < 1.5, "{twin}");
        // A constant height leaves the direction of N.
        let n = bump([1.0, 0.2, 0.0], [0.0, 3.0, 0.5], 0.0, 0.0);
        assert!(degrees(wide(n), wide(cross([1.0, 0.2, 0.0], [0.0, 3.0, 0.5]))) < 1e-4);
    }

    /// Heights rise along the side that is seen, for every orientation of u and v, and a frame without area leaves the normal.
    #[test]
    fn bumps_on_smooth_normals_do_not_ask_which_way_u_and_v_turn() {
        let (o_u, o_v) = ([2.0, 0.0, 0.0], [0.0, 3.0, 0.0]);
        let up = [0.0, 0.0, 1.0];
        let expected = bump(o_u, o_v, 0.4, -0.3);
        assert_eq!(bump_on(up, o_u, o_v, 0.4, -0.3), expected);
        assert_eq!(bump_on(up, o_v, o_u, -0.3, 0.4), expected);
        // A bump is a bump from behind, too: it leans the same way.
        let down = bump_on([0.0, 0.0, -1.0], o_u, o_v, 0.4, -0.3);
        assert!(
            (wide(down) - DVec3::new(-0.196_116, 0.098_058, -0.975_7)).length() < 2e-3,
            "{down:?}"
        );
        assert_eq!(bump_on(up, o_u, o_u, 0.4, 0.3), up);
        assert_eq!(bump_on(up, [0.0; 3], o_v, 0.4, 0.3), up);
    }

    #[test]
    fn frames_place_the_map_and_fail_softly() {
        let (n, t) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(perturb(n, t, [0.0, 0.0, 1.0]), n);
        assert_eq!(perturb(n, t, [0.6, 0.8, 0.0]), [0.6, 0.8, 0.0]);
        assert_eq!(
            perturb(n, [1.0, 0.0, 0.0, -1.0], [0.6, 0.8, 0.0]),
            [0.6, -0.8, 0.0]
        );
        for bad in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0]] {
            assert_eq!(perturb([0.0, 0.0, 2.0], bad, [0.5, 0.5, 0.7]), n, "{bad:?}");
        }
        assert_eq!(bump([1.0, 0.0, 0.0], [2.0, 0.0, 0.0], 0.1, 0.1), [0.0; 3]);
        assert_eq!(decode_normal([0.5; 3], NormalMapGreen::Up, false), n);
    }

    /// Case B6.
    #[test]
    fn the_horizon_is_not_crossed() {
        let v = [0.0, 0.0, 1.0];
        for normal in [[1.0, 0.0, -0.5], [0.3, -0.9, -0.2], [0.0, 1.0, 0.0]] {
            let n = clamp_to_horizon(normal, v);
            assert!((dot(n, v) - 0.01).abs() < 1e-6 && (dot(n, n) - 1.0).abs() < 1e-5);
        }
        assert_eq!(clamp_to_horizon([0.6, 0.0, 0.8], v), [0.6, 0.0, 0.8]);
        let behind = clamp_to_horizon([0.0, 0.0, -1.0], v);
        assert!(behind.iter().all(|c| c.is_finite()) && dot(behind, v) > 0.0);
    }

    #[test]
    fn heights_must_fill_their_rows() {
        let short = Heights {
            width: 4,
            values: &[0.0; 7],
        };
        assert!(matches!(
            short.slope(0, 0, Slope::Central),
            Err(LightError::Length { .. })
        ));
        let none = Heights {
            width: 4,
            values: &[],
        };
        assert!(none.slope(0, 0, Slope::Central).is_err());
        let one = Heights {
            width: 1,
            values: &[3.0],
        };
        assert_eq!(one.slope(-7, 9, Slope::Sobel), Ok([0.0; 2]));
        let no_columns = Heights {
            width: 0,
            values: &[1.0, 2.0],
        };
        let normals = no_columns.normals(Slope::Central, 1.0, NormalMapGreen::Up);
        assert!(matches!(normals, Err(LightError::Length { .. })));
        // Any index wraps.
        let row = Heights {
            width: 4,
            values: &[0.0, 1.0, 3.0, 9.0],
        };
        for (far, near) in [(i64::MAX, 3), (i64::MIN, 0)] {
            let found = row.slope(far, far, Slope::Sobel);
            assert_eq!(found, row.slope(near, 0, Slope::Sobel));
        }
    }
}
