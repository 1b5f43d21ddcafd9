//! Billboards: pictures that turn to face the viewer, for what is too fine to be modelled.

use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::Origin;

use texmap_scene::{Billboard, Facing, Mesh};

/// A mesh of billboards, each with the whole picture of the material's texture. The material should cut it out by its
/// alpha.
///
/// The billboards face +Z until [`tessellate`](crate::tessellate) turns them to the camera.
#[must_use]
pub fn billboards(name: &str, billboards: Vec<Billboard>, material: usize) -> Mesh {
    let mut mesh = Mesh {
        name: name.to_owned(),
        material,
        uvs: [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].repeat(billboards.len()),
        uv_origin: Origin::TopLeft,
        triangles: (0..billboards.len() as u32)
            .flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]])
            .collect(),
        faces: (0..billboards.len() as u32).flat_map(|i| [i, i]).collect(),
        billboards,
        ..Mesh::default()
    };
    place(&mut mesh, |_| [DVec3::X, DVec3::Y]);
    mesh
}

/// Turns all billboards of a mesh to a camera that has a view; they are plain triangles from then on.
pub(crate) fn turn_to(mesh: &mut Mesh, camera: &Camera) {
    let forward = (camera.look - camera.eye).normalize_or_zero();
    let right = forward.cross(camera.up).normalize_or_zero();
    place(mesh, |board| match board.facing {
        Facing::Screen => [right, right.cross(forward)],
        Facing::Axis(axis) => {
            let upright = axis.normalize_or_zero();
            let across = upright.cross(camera.viewpoint() - board.position);
            // On the axis there is no such direction; any will do, for nothing is seen.
            let across = if across.length_squared() > 0.0 {
                across
            } else {
                right
            };
            [across.normalize_or_zero(), upright]
        }
    });
    mesh.billboards.clear();
}

/// Positions and normals of all billboards, each with the axes to its right and up.
fn place(mesh: &mut Mesh, axes: impl Fn(&Billboard) -> [DVec3; 2]) {
    mesh.world_from_object = DMat4::IDENTITY;
    mesh.positions.clear();
    mesh.normals.clear();
    mesh.tangents.clear();
    for board in &mesh.billboards {
        let [right, up] = axes(board);
        let (x, y) = (right * (0.5 * board.size[0]), up * (0.5 * board.size[1]));
        let corners = [-x - y, x - y, x + y, y - x];
        mesh.positions
            .extend(corners.map(|c| (board.position + c).as_vec3().to_array()));
        mesh.normals
            .extend([right.cross(up).as_vec3().to_array(); 4]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: DVec3) -> Camera {
        Camera {
            eye,
            look: DVec3::ZERO,
            up: if eye.x == 0.0 && eye.z == 0.0 {
                DVec3::Z
            } else {
                DVec3::Y
            },
            fov_x: 1.0,
            near: 0.1,
            far: f64::INFINITY,
            lens: Default::default(),
        }
    }

    fn faced(facing: Facing, eye: DVec3) -> [DVec3; 3] {
        let position = DVec3::new(0.5, 0.0, 0.25);
        let mut mesh = billboards(
            "tree",
            vec![Billboard {
                position,
                size: [2.0, 3.0],
                facing,
            }],
            0,
        );
        turn_to(&mut mesh, &camera(eye));
        let p: Vec<DVec3> = mesh
            .positions
            .iter()
            .map(|p| DVec3::from(p.map(f64::from)))
            .collect();
        let middle: DVec3 = p.iter().sum::<DVec3>() / 4.0;
        assert!((middle - position).length() < 1e-6);
        assert!(
            ((p[1] - p[0]).length() - 2.0).abs() < 1e-6
                && ((p[3] - p[0]).length() - 3.0).abs() < 1e-6
        );
        let normal = DVec3::from(mesh.normals[0].map(f64::from));
        assert!(
            (p[1] - p[0]).cross(p[2] - p[0]).normalize().dot(normal) > 0.999_999,
            "the front is the seen side"
        );
        [(p[1] - p[0]) / 2.0, (p[3] - p[0]) / 3.0, normal]
    }

    #[test]
    fn they_face_the_picture_or_turn_about_their_axis() {
        let eye = DVec3::new(3.0, 4.0, 5.0);
        let [right, up, normal] = faced(Facing::Screen, eye);
        let forward = -eye.normalize();
        assert!((normal + forward).length() < 1e-6 && right.y.abs() < 1e-6 && up.y > 0.0);
        let [right, up, normal] = faced(Facing::Axis(DVec3::Y * 7.0), eye);
        assert!((up - DVec3::Y).length() < 1e-6 && right.y == 0.0);
        let to_eye = eye - DVec3::new(0.5, 0.0, 0.25);
        let level = DVec3::new(to_eye.x, 0.0, to_eye.z).normalize();
        assert!((normal - level).length() < 1e-6);
        // From above on the axis: edge-on, but of finite size.
        let [_, up, normal] = faced(Facing::Axis(DVec3::Y), DVec3::new(0.5, 9.0, 0.25));
        assert!((up - DVec3::Y).length() < 1e-6 && normal.y.abs() < 1e-6);
    }
}
