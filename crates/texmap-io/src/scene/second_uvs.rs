//! The second coordinates of models, for light maps.

use std::collections::HashMap;
use std::path::Path;

use texmap_scene::Mesh;

use crate::models::{self, Request};
use crate::scene_file::Missing;
use crate::textures::Textures;
use crate::{IoError, SourceLocation, shortened};

/// Gives the meshes of a model the coordinates of another model of the same faces as their second set. Vertices whose corners
/// differ there are split.
pub(super) fn second_uvs(
    meshes: &mut [Mesh],
    textures: &mut Textures,
    path: &Path,
    location: &SourceLocation,
) -> Result<(), IoError> {
    let mut unused = textures.for_coordinates();
    let request = Request {
        path,
        named_by: Some(location),
        missing: Missing::Checker,
        textured: false,
    };
    let other = models::read(&request, &mut unused);
    textures.take_counts(unused);
    let other = other?;
    let broken = |problem: String| IoError::BrokenModel {
        path: path.to_path_buf(),
        problem,
    };
    // The triangles of each face of the file, in their order.
    let mut faces: HashMap<u32, Vec<[[f32; 2]; 3]>> = HashMap::new();
    for part in &other.parts {
        if part.uvs.is_empty() {
            return Err(broken(format!(
                "`lightmapuv`: the part `{}` has no `vt`",
                shortened(&part.name)
            )));
        }
        for (triangle, face) in part.triangles.iter().zip(&part.faces) {
            faces
                .entry(*face)
                .or_default()
                .push(triangle.map(|v| part.uvs[v as usize]));
        }
    }
    let mut next: HashMap<u32, usize> = HashMap::new();
    for mesh in meshes {
        let mut split: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let mut out = Mesh {
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            lightmap_uvs: Vec::new(),
            ..mesh.clone()
        };
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let face = mesh.face(t as u32);
            let at = next.entry(face).or_default();
            let uvs = faces.get(&face).and_then(|all| all.get(*at)).ok_or_else(|| {
                broken(format!(
                    "`lightmapuv`: face {} of the model has no like in it; both files must have the same faces in the same order",
                    face + 1
                ))
            })?;
            *at += 1;
            let mirrored = mesh.world_from_object.determinant() < 0.0;
            let corner = |k: usize| {
                // A mirrored model has its second and third corners swapped.
                let uv = uvs[if mirrored && k > 0 { 3 - k } else { k }];
                (triangle[k], uv)
            };
            let mut corners = [0; 3];
            for (k, location) in corners.iter_mut().enumerate() {
                let (vertex, uv) = corner(k);
                *location = *split
                    .entry((vertex, uv.map(f32::to_bits)))
                    .or_insert_with(|| {
                        let v = vertex as usize;
                        out.positions.push(mesh.positions[v]);
                        out.normals.extend(mesh.normals.get(v));
                        out.tangents.extend(mesh.tangents.get(v));
                        out.uvs.extend(mesh.uvs.get(v));
                        out.colors.extend(mesh.colors.get(v));
                        out.lightmap_uvs.push(uv);
                        out.positions.len() as u32 - 1
                    });
            }
            out.triangles.push(corners);
        }
        *mesh = out;
    }
    Ok(())
}
