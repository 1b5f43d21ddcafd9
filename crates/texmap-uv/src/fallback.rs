//! Coordinates for a mesh that came without any: one per vertex, fitted to its bounding box.

use alloc::vec::Vec;
use texmap_math::glam::DVec3;

use crate::solid::{self, Origin, ShapeFace};

/// The named fallbacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Projection {
    /// Along -Z on the bounding box's x and y.
    Plane,
    /// Each vertex on the face of the bounding box that its normal points at. Without normals, that its
    /// direction from the middle points at.
    #[default]
    Box,
    /// Longitude and latitude around the middle of the bounding box.
    Sphere,
}

/// Texture coordinates of every vertex, in [0, 1].
///
/// `normals` is empty or has one entry per vertex and serves [`Projection::Box`] alone. The bounding box is that
/// of the finite vertices; a vertex with a NaN or an infinity maps to the middle of the image, and so does an
/// axis along which the mesh has no extent. One coordinate per vertex cannot repair the seam of a sphere.
pub fn project(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    projection: Projection,
    origin: Origin,
) -> Vec<[f32; 2]> {
    let (low, high) = bounds(positions);
    let centre = (low + high) * 0.5;
    let extent = high - low;
    let reciprocal = |e: f64| if e > 0.0 { 1.0 / e } else { 0.0 };
    let scale = DVec3::new(
        reciprocal(extent.x),
        reciprocal(extent.y),
        reciprocal(extent.z),
    );
    positions
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let from_centre = DVec3::from(p.map(f64::from)) - centre;
            if !from_centre.is_finite() {
                return [0.5, 0.5];
            }
            let unit = from_centre * scale;
            let place = match projection {
                Projection::Plane => ShapeFace::Whole.flat(unit),
                Projection::Sphere => solid::sphere(from_centre),
                Projection::Box => {
                    let normal = normals.get(i).map(|n| DVec3::from(n.map(f64::from)));
                    let outward = normal
                        .filter(|n| n.is_finite() && *n != DVec3::ZERO)
                        .unwrap_or(unit);
                    ShapeFace::facing(outward).flat(unit)
                }
            };
            // Rounding of coordinates far from 0 may leave the box.
            place.uv(origin).map(|c| c.clamp(0.0, 1.0) as f32)
        })
        .collect()
}

fn bounds(positions: &[[f32; 3]]) -> (DVec3, DVec3) {
    let mut finite = positions
        .iter()
        .map(|p| DVec3::from(p.map(f64::from)))
        .filter(|p| p.is_finite());
    let Some(first) = finite.next() else {
        return (DVec3::ZERO, DVec3::ZERO);
    };
    finite.fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    const BOX: [[f32; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 4.0, 0.0],
        [0.0, 4.0, 0.0],
        [0.0, 0.0, 8.0],
        [2.0, 0.0, 8.0],
        [2.0, 4.0, 8.0],
        [0.0, 4.0, 8.0],
    ];

    #[test]
    fn plane_fits_the_bounding_box_with_either_origin() {
        let top = project(&BOX, &[], Projection::Plane, Origin::TopLeft);
        let bottom = project(&BOX, &[], Projection::Plane, Origin::BottomLeft);
        assert_eq!(top[0], [0.0, 1.0]);
        assert_eq!(bottom[0], [0.0, 0.0]);
        assert_eq!(top[6], [1.0, 0.0]);
        assert_eq!(bottom[6], [1.0, 1.0]);
    }

    #[test]
    fn coordinates_stay_within_the_image_at_large_extents() {
        let far = 2.0f32.powi(31);
        for low in [1.0, 3.0, 7.0] {
            for x in [-far, -far + 256.0, far - 128.0, far] {
                let positions = [
                    [x, low, -far],
                    [low, far, x],
                    [-far, -far, far],
                    [far, x, low],
                ];
                for projection in [Projection::Plane, Projection::Box, Projection::Sphere] {
                    let uvs = project(&positions, &[], projection, Origin::TopLeft);
                    let uvs = uvs.as_flattened();
                    assert!(uvs.iter().all(|c| (0.0..=1.0).contains(c)), "{uvs:?}");
                }
            }
        }
    }

    #[test]
    fn box_follows_the_normal() {
        let towards = |n: [f32; 3]| project(&BOX, &[n; 8], Projection::Box, Origin::TopLeft)[5];
        assert_eq!(towards([0.0, 0.0, 1.0]), [1.0, 1.0]);
        assert_eq!(towards([1.0, 0.0, 0.0]), [0.0, 1.0]);
        assert_eq!(towards([0.0, -1.0, 0.0]), [1.0, 0.0]);
    }

    #[test]
    fn bad_vertices_map_to_the_middle_and_disturb_nobody() {
        let mut mesh = BOX.to_vec();
        mesh.push([f32::NAN, 0.0, 0.0]);
        mesh.push([f32::INFINITY, 0.0, 0.0]);
        for projection in [Projection::Plane, Projection::Box, Projection::Sphere] {
            let uvs = project(&mesh, &[], projection, Origin::TopLeft);
            assert_eq!(uvs[8..], vec![[0.5, 0.5]; 2]);
            assert_eq!(uvs[..8], project(&BOX, &[], projection, Origin::TopLeft));
            assert!(uvs.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
        }
        assert!(project(&[], &[], Projection::Sphere, Origin::TopLeft).is_empty());
        assert_eq!(
            project(&[[1.0; 3]], &[], Projection::Sphere, Origin::TopLeft),
            [[0.5, 0.5]]
        );
    }
}
