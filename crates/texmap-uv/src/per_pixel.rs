//! A round mapping evaluated at pixels: exact where vertices cannot be, such as on a face that is large against the
//! shape, crosses its seam or encloses its axis.

mod kernel;

use texmap_math::glam::{DMat4, DVec3};
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Footprint, Level, dispatch_simd};

use crate::mapping::FACTORS;
use crate::spherical::MAX_LANES;
use crate::{Origin, Placement, UvError};

/// The shapes with a seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CurvedShape {
    /// Longitude and height; the side of a cylinder or cone.
    Cylinder,
    /// Longitude and latitude.
    Sphere,
}

/// A round shape around an object, ready to be evaluated per pixel: uv as [`crate::Mapping`] by position gives it, and
/// its derivatives by the chain rule.
///
/// u lies in [0, repeat] and jumps by `repeat[0]` at the seam, which a repeating sampler does not see for whole
/// numbers; the derivatives never jump. A pixel at a pole, whose longitude turns by more than half a turn, has
/// |du| = repeat / 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerPixelProjection {
    shape: CurvedShape,
    /// Takes a point to the unit solid.
    unit_from_point: DMat4,
    /// First three rows of this matrix.
    rows: [[f32; 4]; 3],
    repeat: [f32; 2],
    origin: Origin,
}

impl PerPixelProjection {
    /// `shape` in `frame`, which is in the space of the points; `repeat` pictures around and up.
    ///
    /// # Errors
    /// A frame without size, a repeat that is not finite or zero.
    pub fn new(
        shape: CurvedShape,
        frame: &Placement,
        repeat: [f64; 2],
        origin: Origin,
    ) -> Result<Self, UvError> {
        if let Some(&value) = repeat.iter().find(|v| !FACTORS.contains(&v.abs())) {
            return Err(UvError::BadParameter {
                what: "repeat",
                value,
            });
        }
        let placed = frame.placed()?;
        let turned = DMat4::from_mat3(placed.rotation.transpose());
        let scaled = DMat4::from_scale(DVec3::ONE / placed.size);
        let unit_from_point = scaled * turned * DMat4::from_translation(-placed.origin);
        if !rows(&unit_from_point)
            .as_flattened()
            .iter()
            .all(|v| v.is_finite())
        {
            // So small that f32 cannot hold its inverse.
            let value = frame.scale.min_element();
            return Err(UvError::BadFrame { value });
        }
        Ok(Self {
            shape,
            unit_from_point,
            rows: rows(&unit_from_point),
            repeat: repeat.map(|r| r as f32),
            origin,
        })
    }

    /// The shape moved along with the points: a point that `by` has moved gets the uv that it had. `by` must be
    /// affine and have an inverse, else the results are NaN.
    #[must_use]
    pub fn moved(&self, by: &DMat4) -> Self {
        let unit_from_point = self.unit_from_point * by.inverse();
        Self {
            unit_from_point,
            rows: rows(&unit_from_point),
            ..*self
        }
    }

    /// [`PerPixelProjection::uv_at`] for many pixels, the same bits on every level.
    ///
    /// # Errors
    /// Lists of different lengths.
    pub fn uv_batch(
        &self,
        level: Level,
        points: &[[f32; 3]],
        dx: &[[f32; 3]],
        dy: &[[f32; 3]],
        uvs: &mut [[f32; 2]],
        footprints: &mut [Footprint],
    ) -> Result<(), UvError> {
        let expected = points.len();
        for (what, found) in [
            ("the list of changes to the right", dx.len()),
            ("the list of changes down", dy.len()),
            ("the list of coordinates", uvs.len()),
            ("the list of footprints", footprints.len()),
        ] {
            if found != expected {
                return Err(UvError::WrongLength {
                    what,
                    found,
                    expected,
                });
            }
        }
        dispatch_simd!(level, wide i => self.run(i, [points, dx, dy], uvs, footprints));
        Ok(())
    }

    #[inline(always)]
    fn run<I: Isa>(
        &self,
        i: I,
        columns: [&[[f32; 3]]; 3],
        uvs: &mut [[f32; 2]],
        footprints: &mut [Footprint],
    ) {
        let batches = uvs
            .chunks_mut(I::LANES)
            .zip(footprints.chunks_mut(I::LANES));
        for (k, (uvs, footprints)) in batches.enumerate() {
            let mut input = [[[1.0, 0.0, 0.0]; MAX_LANES]; 3];
            for (to, from) in input.iter_mut().zip(columns) {
                to[..uvs.len()].copy_from_slice(&from[k * I::LANES..][..uvs.len()]);
            }
            let [point, dx, dy] = &input;
            let input = [i.load_xyz(point), i.load_xyz(dx), i.load_xyz(dy)];
            let mut lanes = [[0.0; MAX_LANES]; 6];
            let columns = self.pixels(i, input);
            for k in 0..6 {
                columns[k].store(&mut lanes[k]);
            }
            let [u, v, du_dx, dv_dx, du_dy, dv_dy] = &lanes;
            for (i, (uv, footprint)) in uvs.iter_mut().zip(footprints).enumerate() {
                *uv = [u[i], v[i]];
                *footprint = Footprint::new(du_dx[i], dv_dx[i], du_dy[i], dv_dy[i]);
            }
        }
    }
}

/// The first three rows of an affine matrix.
fn rows(m: &DMat4) -> [[f32; 4]; 3] {
    core::array::from_fn(|k| m.row(k).to_array().map(|c| c as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;
    use alloc::vec::Vec;

    pub(super) fn frame() -> Placement {
        Placement {
            yaw: 0.4,
            pitch: -0.3,
            roll: 0.2,
            ..Placement::upright(DVec3::new(0.1, -0.2, 0.3), DVec3::new(2.0, 1.5, 1.0))
        }
    }

    /// A pixel's point and its changes, on a plane that crosses seam and axis of [`frame`].
    pub(super) fn pixel(i: i32, j: i32) -> [[f32; 3]; 3] {
        let (x, z) = (0.02 * i as f32 + 0.013, 0.02 * j as f32 + 0.007);
        [[x, 0.3 - 0.1 * x, z], [0.02, -0.002, 0.0], [0.0, 0.0, 0.02]]
    }

    #[test]
    fn a_shape_moves_with_its_points() {
        let by = DMat4::from_cols_array(&[
            0.0, 2.0, 0.0, 0.0, -3.0, 0.1, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 5.0, -4.0, 1.0, 1.0,
        ]);
        for shape in [CurvedShape::Cylinder, CurvedShape::Sphere] {
            let map = PerPixelProjection::new(shape, &frame(), [1.0; 2], Origin::TopLeft).unwrap();
            let moved = map.moved(&by);
            for k in -20..20 {
                let [p, dx, dy] = pixel(k, 7).map(|v| DVec3::from(v.map(f64::from)));
                let single = |v: DVec3| v.to_array().map(|c| c as f32);
                let (a, da) = map.uv_at(single(p), single(dx), single(dy));
                let (b, db) = moved.uv_at(
                    single(by.transform_point3(p)),
                    single(by.transform_vector3(dx)),
                    single(by.transform_vector3(dy)),
                );
                assert!(
                    (a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5,
                    "{a:?} {b:?}"
                );
                assert!((da.du_dx - db.du_dx).abs() < 1e-5 && (da.dv_dy - db.dv_dy).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn slices_have_the_bits_of_single_pixels() {
        for (shape, count) in [(CurvedShape::Cylinder, 64), (CurvedShape::Sphere, 83)] {
            let map =
                PerPixelProjection::new(shape, &frame(), [3.0, 1.5], Origin::TopLeft).unwrap();
            let pixels: Vec<[[f32; 3]; 3]> = (0..count).map(|i| pixel(i - 40, 3 - i)).collect();
            let column = |k: usize| -> Vec<[f32; 3]> { pixels.iter().map(|p| p[k]).collect() };
            let n = pixels.len();
            let (mut uvs, mut prints) = (vec![[0.0; 2]; n], vec![Footprint::default(); n]);
            map.uv_batch(
                Level::new(),
                &column(0),
                &column(1),
                &column(2),
                &mut uvs,
                &mut prints,
            )
            .unwrap();
            for (i, [p, dx, dy]) in pixels.iter().enumerate() {
                assert_eq!(
                    map.uv_at(*p, *dx, *dy),
                    (uvs[i], prints[i]),
                    "{shape:?} {i}"
                );
            }
            assert!(matches!(
                map.uv_batch(
                    Level::new(),
                    &column(0),
                    &[],
                    &column(2),
                    &mut uvs,
                    &mut prints
                ),
                Err(UvError::WrongLength { found: 0, .. })
            ));
        }
        let flat = Placement::upright(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0));
        assert!(
            PerPixelProjection::new(CurvedShape::Sphere, &flat, [1.0; 2], Origin::TopLeft).is_err()
        );
        assert!(
            PerPixelProjection::new(CurvedShape::Sphere, &frame(), [0.0, 1.0], Origin::TopLeft)
                .is_err()
        );
    }
}
