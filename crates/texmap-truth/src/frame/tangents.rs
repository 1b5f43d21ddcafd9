//! Tangent frames for normal maps: MikkTSpace's, as the bakers of such maps use them.

use texmap_math::glam::DVec3;
use texmap_sample::Origin;
use texmap_scene::Mesh;

use super::color::wide;
use super::surface::{linear, object_normals};

/// World-space tangents of a mesh's corners, and the sign that makes `sign (N x T)` point up the picture: those of the mesh, or else
/// of these coordinates. Zero if there are none.
pub(super) fn corner_tangents(mesh: &Mesh, uvs: &[[f32; 2]]) -> Vec<(DVec3, f64)> {
    let world = linear(mesh);
    let mirror = if world.determinant() < 0.0 { -1.0 } else { 1.0 };
    let in_world = |[x, y, z, sign]: [f32; 4], up: f64| {
        let tangent = (world * wide([x, y, z])).normalize_or_zero();
        (tangent, f64::from(sign) * mirror * up)
    };
    if !mesh.tangents.is_empty() {
        let corners = mesh.triangles.as_flattened().iter();
        return corners
            .map(|v| in_world(mesh.tangents[*v as usize], 1.0))
            .collect();
    }
    let faces = texmap_uv::Faces::from_triangles(&mesh.triangles);
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let normals = object_normals(mesh);
    let normal = |v: &u32| {
        normals[*v as usize]
            .normalize_or_zero()
            .as_vec3()
            .to_array()
    };
    let at_corners: Vec<[f32; 3]> = corners.iter().map(normal).collect();
    let set = texmap_uv::UvSet {
        uvs: uvs.to_vec(),
        corners,
    };
    let found = texmap_uv::Mesh::new(&mesh.positions, &faces)
        .and_then(|shape| texmap_uv::tangents(&shape, &set, &at_corners));
    let Ok(found) = found else {
        return Vec::new();
    };
    // The bitangent follows growing v, which runs down the picture from a top-left origin.
    let up = if mesh.uv_origin == Origin::TopLeft {
        -1.0
    } else {
        1.0
    };
    found.into_iter().map(|t| in_world(t, up)).collect()
}
