//! The direction along which a plane sees a surface best.

use texmap_math::float;
use texmap_math::glam::{DMat3, DVec3};

use crate::mesh::{Mesh, length, unit_or_zero};

/// A surface is flat when the mean square of the cosine between its normals and their main direction is no less.
const FLAT: f64 = 0.9999;

/// The turn of a plane that is fitted to a surface. Its columns are the directions to the right, up, and toward the eye.
///
/// A flat surface is seen along its own normal if `tilted` allows it, any other along z, or along y or x where that sees it
/// more than twice as squarely (by the root mean square of the cosine, weighted by area). A surface that faces away is seen
/// from behind; one that is closed, or faces both ways, from the positive side. Up is +Y, or for a view along y away from the
/// viewer, as on a map. Without area: along z.
pub(crate) fn view(mesh: &Mesh<'_>, tilted: bool) -> DMat3 {
    let (mut squares, mut sum, mut total) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for (_, corners) in mesh.faces().triangles() {
        let [a, b, c] = corners.map(|k| mesh.point(k));
        let normal = (b - a).cross(c - a);
        let area = length(normal);
        if area > 0.0 {
            let weighted = normal / area;
            squares += DMat3::from_cols(
                normal * weighted.x,
                normal * weighted.y,
                normal * weighted.z,
            );
            sum += normal;
            total += area;
        }
    }
    if !(total > 0.0 && total.is_finite()) {
        return DMat3::IDENTITY;
    }
    let along = |d: DVec3| d.dot(squares * d) / total;
    let axes = [DVec3::Z, DVec3::Y, DVec3::X];
    let main = axes
        .into_iter()
        .reduce(|best, d| if along(d) > along(best) { d } else { best })
        .unwrap_or(DVec3::Z);
    // Of a flat surface every column is a multiple of its normal; the largest has the most digits.
    let own = unit_or_zero(squares * main);
    let towards = if tilted && along(own) >= FLAT {
        own
    } else if along(DVec3::Z) * 4.0 >= along(main) {
        DVec3::Z
    } else {
        main
    };
    let away = sum.dot(towards) < -0.5 * along(towards) * total;
    looking(if away { -towards } else { towards })
}

/// Right, up and back for an eye that looks against `back`.
fn looking(back: DVec3) -> DMat3 {
    let level = float::sqrt(back.x * back.x + back.z * back.z);
    // Within a sixteenth of a degree of the vertical, to the right is +X.
    if level < 1e-3 {
        let back = DVec3::new(0.0, if back.y < 0.0 { -1.0 } else { 1.0 }, 0.0);
        return DMat3::from_cols(DVec3::X, back.cross(DVec3::X), back);
    }
    let right = DVec3::new(back.z, 0.0, -back.x) / level;
    DMat3::from_cols(right, back.cross(right), back)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;

    fn of(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> DMat3 {
        view(
            &Mesh::new(positions, &Faces::from_triangles(faces)).unwrap(),
            true,
        )
    }

    #[test]
    fn floors_walls_and_slopes_are_seen_along_their_normals() {
        let quad = [[0, 1, 2], [0, 2, 3]];
        let turned = [[0, 2, 1], [0, 3, 2]];
        let floor = [[0.0; 3], [0.0, 0.0, 2.0], [3.0, 0.0, 2.0], [3.0, 0.0, 0.0]];
        let view = of(&floor, &quad);
        assert_eq!(view, DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y));
        let view = of(&floor, &turned);
        assert_eq!(view, DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        let wall = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(of(&wall, &quad), DMat3::IDENTITY);
        let behind = of(&wall, &turned);
        assert_eq!(
            behind,
            DMat3::from_cols(DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z)
        );
        let slope = [[0.0; 3], [0.0, 0.0, 4.0], [3.0, 3.0, 4.0], [3.0, 3.0, 0.0]];
        let back = of(&slope, &quad).z_axis;
        assert!((back - DVec3::new(-1.0, 1.0, 0.0).normalize()).length() < 1e-12);
    }

    #[test]
    fn what_is_not_flat_is_seen_along_an_axis() {
        // A roof over the ground, folded along z: y faces it most.
        let roof = [
            [-2.0, 0.0, 0.0],
            [-2.0, 0.0, 5.0],
            [0.0, 1.0, 5.0],
            [0.0, 1.0, 0.0],
            [2.0, 0.0, 5.0],
            [2.0, 0.0, 0.0],
        ];
        let faces = [[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]];
        assert_eq!(of(&roof, &faces).z_axis, DVec3::Y);
        // Standing steeper it faces x most and z not at all.
        let steep = roof.map(|[x, y, z]| [x, y * 9.0, z]);
        assert_eq!(of(&steep, &faces).z_axis, DVec3::X);
        assert_eq!(of(&roof, &[[0, 0, 1]]), DMat3::IDENTITY);
    }
}
