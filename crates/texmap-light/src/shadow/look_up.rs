//! Look-ups in a shadow map by percentage-closer filtering: the mean of comparisons around a point's texel, each with a bias.

use texmap_math::float::floor;
use texmap_math::glam::{DVec2, DVec3};

use super::{ShadowKind, ShadowMap};
use crate::error::{LightError, same_length};

/// Steepest change of a receiver's depth that [`ShadowBias::Planes`] follows, texels of depth per texel: light at two degrees. A
/// steeper receiver's plane, followed over some texels, would pass before what casts a shadow on it.
pub(crate) const STEEPEST: f32 = 32.0;

/// Change of a receiver's depth above which the majority of the comparisons under [`ShadowBias::Planes`] decides, as a part of [`STEEPEST`]:
/// light below 3.6 degrees. Over the filter the plane of such a receiver passes before part of what casts a shadow on it.
pub(crate) const STEEP: f32 = 0.5;

/// Addition to the stored depth before the comparison, against a surface that shadows itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowBias {
    /// The planes of both surfaces, with this constant (1e-4 of the scene's size is enough). Each comparison takes the receiver's depth
    /// on its own plane there, where that is nearer to the light (receiver-plane bias), and the map holds every caster's depth as
    /// far as its plane reaches over the filter ([`caster_reach`](Self::caster_reach): slope-scaled bias at drawing). Of the
    /// comparisons, fewer than a row that contradict all others are ignored ([`outliers`](Self::outliers)). Where the light meets the
    /// receiver at less than 3.6 degrees, the majority of the comparisons decides.
    Planes(f64),
    /// A constant, world units. It leaves acne on slopes or detaches shadows: for comparison.
    Constant(f64),
    /// The most that the receiver's plane changes over the filter's half width, plus this constant (1e-4 of the scene's
    /// size is enough): exact for a plane, `(r + 1/2) t (|dz/dx| + |dz/dy|)` with texel size t and filter radius r.
    Slope(f64),
    /// The point is moved along its normal by this many texels first, and compared with a constant of 1e-4 texels.
    NormalOffset(f64),
}

impl ShadowBias {
    /// Offset of each caster's stored depth away from the light, in texels of slope `|dz/dx| + |dz/dy|`. Look-ups of `taps` x
    /// `taps` comparisons need one and a half times the filter's reach and the caster's own texel under [`Planes`](Self::Planes),
    /// else 0.
    #[must_use]
    pub fn caster_reach(self, taps: u32) -> f64 {
        match self {
            Self::Planes(_) => 1.5 * (f64::from(taps.min(15) / 2) + 1.0),
            _ => 0.0,
        }
    }

    /// Number of outliers, comparisons of `taps` x `taps` that contradict all others and are ignored. The edge of a shadow crosses a
    /// filter in a row at least; fewer are a crease or a bump within the filter. 2 r under [`Planes`](Self::Planes) with filter
    /// radius r, else 0; the visibility is the lit comparisons less the outliers, over all less twice the outliers.
    #[must_use]
    pub fn outliers(self, taps: u32) -> u32 {
        match self {
            Self::Planes(_) => taps.min(15) / 2 * 2,
            _ => 0,
        }
    }
}

impl ShadowMap {
    /// Fraction of the light that reaches a point, 0..=1. It is the mean of `taps` x `taps` comparisons (1 or an odd number up to 15;
    /// even ones are rounded up) around the point's texel. Points outside of the map, behind a spot light, or not finite
    /// are lit. `normal` has unit length.
    #[must_use]
    pub fn visibility(&self, point: DVec3, normal: DVec3, bias: ShadowBias, taps: u32) -> f32 {
        let radius = i64::from(taps.min(15) / 2);
        let Some(mut place) = self.place(point, normal) else {
            return 1.0;
        };
        if let ShadowBias::NormalOffset(texels) = bias {
            match self.place(point + normal * (texels * place.texel_size), normal) {
                Some(moved) => place = moved,
                None => return 1.0,
            }
        }
        let mut slope = DVec2::ZERO;
        let mut outliers = bias.outliers(taps);
        let add = match bias {
            ShadowBias::Constant(constant) => constant,
            ShadowBias::NormalOffset(_) => 1e-4 * place.texel_size,
            ShadowBias::Planes(constant) => {
                let most = DVec2::splat(f64::from(STEEPEST) * place.texel_size);
                if place.slope.abs().max_element() > f64::from(STEEP) * most.x {
                    // All but the median.
                    outliers = 2 * radius as u32 * (radius as u32 + 1);
                }
                slope = place.slope.clamp(-most, most);
                constant
            }
            ShadowBias::Slope(constant) => {
                (radius as f64 + 0.5) * (place.slope.x.abs() + place.slope.y.abs()) + constant
            }
        };
        let (x, y) = (floor(place.texel.x) as i64, floor(place.texel.y) as i64);
        let (mut lit, mut count) = (0u32, 0u32);
        for j in -radius..=radius {
            for i in -radius..=radius {
                count += 1;
                let centre = DVec2::new((x + i) as f64 + 0.5, (y + j) as f64 + 0.5);
                let change = slope.dot(centre - place.texel);
                let nearer = if change < 0.0 { change } else { 0.0 };
                lit += u32::from(
                    self.depth(place.face, x + i, y + j)
                        .is_none_or(|stored| place.depth + nearer <= stored + add),
                );
            }
        }
        let lit = lit.saturating_sub(outliers) as f32 / (count - 2 * outliers) as f32;
        if lit < 1.0 { lit } else { 1.0 }
    }

    /// [`visibility`](Self::visibility) for every point of a slice.
    ///
    /// # Errors
    /// [`LightError::Length`] unless all slices have one length.
    pub fn visibility_slice(
        &self,
        points: &[[f32; 3]],
        normals: &[[f32; 3]],
        bias: ShadowBias,
        taps: u32,
        out: &mut [f32],
    ) -> Result<(), LightError> {
        same_length("points", points.len(), out.len())?;
        same_length("normals", normals.len(), out.len())?;
        for ((out, point), normal) in out.iter_mut().zip(points).zip(normals) {
            *out = self.visibility(
                DVec3::from(point.map(f64::from)),
                DVec3::from(normal.map(f64::from)),
                bias,
                taps,
            );
        }
        Ok(())
    }

    /// Stored depth; `None` outside of the map, which is lit. A comparison over the edge of a cube's face reads the neighbour: all
    /// faces store distances, so that their depths compare.
    fn depth(&self, face: usize, x: i64, y: i64) -> Option<f64> {
        let size = i64::from(self.size);
        if (0..size).contains(&x) && (0..size).contains(&y) {
            let index = (face as i64 * size + y) * size + x;
            return self.depths.get(index as usize).map(|d| f64::from(*d));
        }
        if !matches!(self.kind, ShadowKind::Point { .. }) {
            return None;
        }
        let n = f64::from(self.size);
        let beyond = DVec2::new((x as f64 + 0.5) / n, (y as f64 + 0.5) / n);
        let direction = crate::EnvironmentLayout::Cube.direction(face, beyond);
        let (face, uv) = crate::EnvironmentLayout::Cube.locate(direction);
        let texel = |c: f64| {
            let i = floor(c * n) as i64;
            if i < size { i } else { size - 1 }
        };
        let index = (face as i64 * size + texel(uv.y)) * size + texel(uv.x);
        self.depths.get(index as usize).map(|d| f64::from(*d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use alloc::vec::Vec;

    use texmap_math::float::sqrt;
    use texmap_math::glam::DMat4;

    /// Ball of radius 0.5 around (0, 0, 0.5) on the plane z = 0: distance along a ray, its normal there.
    fn trace(origin: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let plane = (d.z < 0.0).then(|| -origin.z / d.z).filter(|t| *t > 1e-9);
        let ball = {
            let o = origin - DVec3::new(0.0, 0.0, 0.5);
            let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 0.25);
            let root = b * b - a * c;
            (root > 0.0)
                .then(|| (-b - root.sqrt()) / a)
                .filter(|t| *t > 1e-9)
        };
        match (plane, ball) {
            (Some(p), Some(b)) if p < b => Some((p, DVec3::Z)),
            (_, Some(b)) => Some((b, (origin + d * b - DVec3::new(0.0, 0.0, 0.5)) * 2.0)),
            (Some(p), None) => Some((p, DVec3::Z)),
            (None, None) => None,
        }
    }

    fn map(kind: ShadowKind, size: u32) -> ShadowMap {
        let faces = if matches!(kind, ShadowKind::Point { .. }) {
            6
        } else {
            1
        };
        let mut depths = Vec::new();
        for face in 0..faces {
            for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
                let (origin, d) = ShadowMap::ray(&kind, size, face, x, y);
                // Parallel light starts far behind its plane.
                let back = if matches!(kind, ShadowKind::Directional { .. }) {
                    10.0
                } else {
                    0.0
                };
                let hit = trace(origin - d * back, d).map_or(f64::INFINITY, |(t, _)| t - back);
                depths.push(hit as f32);
            }
        }
        ShadowMap::new(kind, size, depths).unwrap()
    }

    fn look_at(eye: DVec3, toward: DVec3) -> DMat4 {
        texmap_math::Camera {
            eye,
            look: eye + toward,
            up: DVec3::Z,
            fov_x: 1.0,
            near: 0.1,
            far: 10.0,
            lens: Default::default(),
        }
        .view()
        .unwrap()
    }

    fn sun(elevation: f64) -> (DVec3, ShadowKind) {
        let (s, c) = elevation.to_radians().sin_cos();
        let toward = DVec3::new(0.8 * c, -0.6 * c, s);
        (
            toward,
            ShadowKind::Directional {
                light_from_world: look_at(DVec3::ZERO, -toward),
                half: 2.6,
            },
        )
    }

    /// Fractions of false shadow and false light over points of plane and ball seen from above. A band of 1.5 texels around the true
    /// shadow's edge is left out; the light must face the surface.
    fn wrong(
        map: &ShadowMap,
        to_light: &dyn Fn(DVec3) -> DVec3,
        texel: f64,
        bias: ShadowBias,
        taps: u32,
    ) -> (f64, f64) {
        let (mut count, mut shadow, mut light) = (0u32, 0u32, 0u32);
        let n = 160;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let at = |k: i32| (f64::from(k) + 0.37) / f64::from(n) * 3.0 - 1.5;
            let Some((t, normal)) = trace(DVec3::new(at(i), at(j), 5.0), DVec3::NEG_Z) else {
                continue;
            };
            let point = DVec3::new(at(i), at(j), 5.0 - t);
            let l = to_light(point);
            if normal.dot(l.normalize()) <= 0.02 {
                continue;
            }
            let blocked = |p: DVec3| {
                trace(p + normal * 1e-4, to_light(p))
                    .is_some_and(|(t, _)| t < 1.0 - 1e-6 || l.length() > 99.0)
            };
            let truth = blocked(point);
            let side = normal.any_orthonormal_vector();
            let ring = (0..8).map(|k| {
                let (s, c) = (f64::from(k) * 0.785).sin_cos();
                point
                    + (side * c + normal.cross(side) * s)
                        * (1.5 * texel / normal.dot(l.normalize()))
            });
            if ring.into_iter().any(|p| blocked(p) != truth) {
                continue;
            }
            count += 1;
            let lit = map.visibility(point, normal, bias, taps);
            shadow += u32::from(!truth && lit < 1.0);
            light += u32::from(truth && lit > 0.0);
        }
        assert!(count > 10_000, "{count}");
        (
            f64::from(shadow) / f64::from(count),
            f64::from(light) / f64::from(count),
        )
    }

    /// Cases H1 to H3 on a ball over a plane: no bias is acne, a constant leaves some at low light, the slope form none.
    #[test]
    fn the_slope_bias_cures_acne_without_detaching_shadows() {
        for elevation in [60.0, 25.0, 10.0] {
            let (toward, kind) = sun(elevation);
            let map = map(kind, 512);
            let texel = 5.2 / 512.0;
            let far = |_| toward * 100.0;
            let none = wrong(&map, &far, texel, ShadowBias::Constant(0.0), 1);
            assert!(none.0 > 0.3, "H1, {elevation}: {none:?}");
            let constant = wrong(&map, &far, texel, ShadowBias::Constant(texel), 1);
            let slope = wrong(&map, &far, texel, ShadowBias::Slope(1e-4), 1);
            assert!(
                elevation > 30.0 || constant.0 > 0.02,
                "H2, {elevation}: {constant:?}"
            );
            assert!(
                slope.0 <= 1e-3 && slope.1 <= 1e-3,
                "H3, {elevation}: {slope:?}"
            );
            let pcf = wrong(&map, &far, texel, ShadowBias::Slope(1e-4), 3);
            assert!(pcf.0 <= 0.03, "PCF, {elevation}: {pcf:?}");
        }
    }

    /// Fewer comparisons than a row that contradict all others are ignored under the default bias. An edge keeps its position.
    #[test]
    fn stray_comparisons_say_nothing() {
        let kind = ShadowKind::Directional {
            light_from_world: DMat4::IDENTITY,
            half: 8.0,
        };
        let bias = ShadowBias::Planes(1e-4);
        let lit = |near: &dyn Fn(usize, usize) -> bool| {
            let depth = |i: usize| if near(i % 16, i / 16) { 1.0 } else { 9.0 };
            let map = ShadowMap::new(kind, 16, (0..256).map(depth).collect()).unwrap();
            // The middle of texel (8, 7).
            map.visibility(DVec3::new(0.5, 0.5, -5.0), DVec3::Z, bias, 5)
        };
        assert_eq!((bias.outliers(5), bias.outliers(1)), (4, 0));
        assert_eq!(ShadowBias::Slope(1e-4).outliers(5), 0);
        assert_eq!(lit(&|_, _| false), 1.0);
        assert_eq!(lit(&|x, y| x == 6 && y < 9), 1.0, "four of a row");
        assert_eq!(lit(&|x, y| x != 6 || y > 8), 0.0);
        let rows = [7, 8, 9, 10, 11].map(|edge| lit(&|x, _| x < edge));
        assert!(rows.windows(2).all(|w| w[0] > w[1]), "{rows:?}");
        assert!((rows[0] + rows[3] - 1.0).abs() < 1e-6, "{rows:?}");
    }

    /// The majority of the comparisons decides for a receiver that the light meets below 3.6 degrees. A less steep one has soft edges.
    #[test]
    fn steep_receivers_are_lit_or_dark() {
        let kind = ShadowKind::Directional {
            light_from_world: DMat4::IDENTITY,
            half: 8.0,
        };
        let bias = ShadowBias::Planes(1e-4);
        let lit = |tangent: f64, edge: usize| {
            let depth = |i: usize| if i % 16 < edge { 1.0 } else { 900.0 };
            let map = ShadowMap::new(kind, 16, (0..256).map(depth).collect()).unwrap();
            let normal = DVec3::new(0.0, tangent, 1.0).normalize();
            map.visibility(DVec3::new(0.5, 0.5, -500.0), normal, bias, 5)
        };
        let edges = [7, 8, 9, 10];
        assert_eq!(edges.map(|edge| lit(16.1, edge)), [1.0, 1.0, 0.0, 0.0]);
        assert!(edges.iter().all(|edge| {
            let lit = lit(15.9, *edge);
            0.0 < lit && lit < 1.0
        }));
    }

    #[test]
    fn spot_and_point_lights_compare_in_their_own_metric() {
        let position = DVec3::new(1.0, -1.2, 2.0);
        let aim = look_at(position, DVec3::new(-1.0, 1.2, -1.8));
        let to_light = |p: DVec3| position - p;
        for (kind, texel) in [
            (
                ShadowKind::Spot {
                    light_from_world: aim,
                    tan_half: 1.2,
                },
                3.0 * 2.4 / 512.0,
            ),
            (ShadowKind::Point { position }, 3.0 * 2.0 / 512.0),
        ] {
            let map = map(kind, 512);
            let slope = wrong(&map, &to_light, texel, ShadowBias::Slope(1e-4), 1);
            assert!(slope.0 <= 2e-3 && slope.1 <= 2e-3, "{slope:?}");
            let none = wrong(&map, &to_light, texel, ShadowBias::Constant(0.0), 1);
            assert!(none.0 > 0.3, "{none:?}");
            let offset = wrong(&map, &to_light, texel, ShadowBias::NormalOffset(2.0), 1);
            assert!(offset.0 < 0.02, "{offset:?}");
        }
    }

    /// Filtered shadows of a point light do not depend on its cube. Across an edge of two faces the visibility is that of the same
    /// ball under a cube that is turned so that no edge is near.
    #[test]
    fn filtered_taps_cross_the_faces_of_a_cube() {
        // A wall at x = 2 seen from the origin; a screen at x = 1 shadows all of z < x. Its shadow's edge is the cube's edge +X +Z.
        let depth = |d: DVec3| {
            let (wall, screen) = (2.0 / d.x, 1.0 / d.x);
            if d.x <= 0.0 {
                f64::INFINITY
            } else if d.z < 0.999 * d.x {
                screen * sqrt(d.dot(d))
            } else {
                wall * sqrt(d.dot(d))
            }
        };
        let size = 64;
        let kind = ShadowKind::Point {
            position: DVec3::ZERO,
        };
        let mut depths = Vec::new();
        for face in 0..6 {
            for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
                let (_, d) = ShadowMap::ray(&kind, size, face, x, y);
                let d = d / sqrt(d.dot(d));
                depths.push(depth(d) as f32);
            }
        }
        let map = ShadowMap::new(kind, size, depths).unwrap();
        let lit = |z: f64| {
            map.visibility(
                DVec3::new(2.0, 0.1, z),
                DVec3::NEG_X,
                ShadowBias::Constant(0.1),
                5,
            )
        };
        let texel = 4.0 / 64.0;
        // Half of the comparisons lie over the edge, in the other face.
        assert!(
            (lit(2.0 - 0.5 * texel) - 0.4).abs() < 0.01,
            "{}",
            lit(2.0 - 0.5 * texel)
        );
        assert!(
            (lit(2.0 + 0.5 * texel) - 0.6).abs() < 0.01,
            "{}",
            lit(2.0 + 0.5 * texel)
        );
        assert_eq!((lit(2.0 - 3.5 * texel), lit(2.0 + 3.5 * texel)), (0.0, 1.0));
    }

    /// Cases H4 and H5: beyond the map, behind the light, and at 1e30 everything is lit.
    #[test]
    fn outside_is_lit() {
        let (_, kind) = sun(60.0);
        let parallel = map(kind, 64);
        let aim = look_at(DVec3::new(0.0, 0.0, 3.0), DVec3::new(0.1, 0.0, -1.0));
        let spot = map(
            ShadowKind::Spot {
                light_from_world: aim,
                tan_half: 0.3,
            },
            64,
        );
        let bias = ShadowBias::Slope(1e-4);
        for p in [
            [9.0, 0.0, 0.0],
            [0.0, 0.0, 1e30],
            [1e30, -1e30, 0.0],
            [f64::NAN, 0.0, 0.0],
            [f64::INFINITY, 0.0, 0.0],
        ] {
            assert_eq!(
                parallel.visibility(DVec3::from(p), DVec3::Z, bias, 5),
                1.0,
                "{p:?}"
            );
        }
        assert_eq!(
            spot.visibility(DVec3::new(0.0, 0.0, 4.0), DVec3::Z, bias, 3),
            1.0,
            "behind"
        );
        assert_eq!(
            spot.visibility(DVec3::new(0.0, 0.0, 3.0), DVec3::Z, bias, 3),
            1.0,
            "in the light"
        );
    }

    /// Case H7 and property 24: a mean of comparisons in 0..=1; a blocker only removes light.
    #[test]
    fn filtered_shadows_are_shares_and_blockers_only_darken() {
        let (_, kind) = sun(25.0);
        let with = map(kind, 128);
        let free = ShadowMap::new(kind, 128, alloc::vec![f32::INFINITY; 128 * 128]).unwrap();
        let mut between = 0;
        for i in 0..2_000 {
            let p = DVec3::new(
                f64::from(i % 50) * 0.06 - 1.5,
                f64::from(i / 50) * 0.075 - 1.5,
                0.0,
            );
            let (a, b) = (
                with.visibility(p, DVec3::Z, ShadowBias::Slope(1e-4), 5),
                free.visibility(p, DVec3::Z, ShadowBias::Slope(1e-4), 5),
            );
            assert!((0.0..=1.0).contains(&a) && b == 1.0);
            assert!(((a * 25.0).round() - a * 25.0).abs() < 1e-4);
            between += u32::from(a > 0.0 && a < 1.0);
        }
        assert!(between > 20, "{between}");
    }
}
