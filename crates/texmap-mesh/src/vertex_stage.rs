//! The vertex stage: a function of the user's over all vertices of a mesh.

use texmap_math::parallel;

use crate::MeshError;
use texmap_scene::Mesh;
use texmap_scene::SceneError;

/// A vertex as a vertex function reads and returns it, in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshVertex {
    /// Position.
    pub position: [f32; 3],
    /// Normal, any length; zero if the mesh has none.
    pub normal: [f32; 3],
    /// Tangent and the sign of the bitangent; zero if the mesh has none.
    pub tangent: [f32; 4],
    /// Texture coordinates; zero if the mesh has none.
    pub uv: [f32; 2],
    /// The second set of coordinates; zero if the mesh has none.
    pub lightmap_uv: [f32; 2],
    /// Linear light; white if the mesh has none.
    pub color: [f32; 3],
}

impl Default for MeshVertex {
    /// The values of a vertex without any attribute.
    fn default() -> Self {
        Self {
            position: [0.0; 3],
            normal: [0.0; 3],
            tangent: [0.0; 4],
            uv: [0.0; 2],
            lightmap_uv: [0.0; 2],
            color: [1.0; 3],
        }
    }
}

/// The mesh with `stage(index, vertex)` instead of every vertex.
///
/// Attributes that the mesh lacks stay away unless the function returns something else than their default for some vertex.
/// A function that moves positions should turn normals too, or return zero for all: then the renderer takes the mean of the
/// triangles. The function runs on all threads of rayon's pool, once for each vertex; the result does not depend on their number.
///
/// # Errors
/// [`SceneError::Value`] names the first vertex for which a number is not finite.
pub fn map_vertices(
    mesh: &Mesh,
    stage: impl Fn(u32, MeshVertex) -> MeshVertex + Sync,
) -> Result<Mesh, MeshError> {
    let run = |v: usize| stage(v as u32, vertex(mesh, v as u32));
    let staged = parallel::list(mesh.positions.len(), MeshVertex::default(), run);
    if let Some(v) = staged.iter().position(|v| !v.is_finite()) {
        return Err(SceneError::Value {
            place: format!("mesh '{}' vertex {v}", mesh.name),
            what: "result of the vertex stage".to_owned(),
            value: format!("{:?}", staged[v]),
            expected: "it must be finite: look for divisions by zero in the vertex function",
        }
        .into());
    }
    let default = MeshVertex::default();
    Ok(Mesh {
        positions: staged.iter().map(|v| v.position).collect(),
        normals: column(&staged, |v| v.normal, default.normal, false),
        tangents: column(&staged, |v| v.tangent, default.tangent, false),
        uvs: column(&staged, |v| v.uv, default.uv, !mesh.uvs.is_empty()),
        lightmap_uvs: column(
            &staged,
            |v| v.lightmap_uv,
            default.lightmap_uv,
            !mesh.lightmap_uvs.is_empty(),
        ),
        colors: column(&staged, |v| v.color, default.color, false),
        triangles: mesh.triangles.clone(),
        faces: mesh.faces.clone(),
        name: mesh.name.clone(),
        displacement: mesh.displacement.clone(),
        billboards: Vec::new(),
        ..*mesh
    })
}

fn vertex(mesh: &Mesh, index: u32) -> MeshVertex {
    let v = index as usize;
    let default = MeshVertex::default();
    MeshVertex {
        position: mesh.positions[v],
        normal: mesh.normals.get(v).copied().unwrap_or(default.normal),
        tangent: mesh.tangents.get(v).copied().unwrap_or(default.tangent),
        uv: mesh.uvs.get(v).copied().unwrap_or(default.uv),
        lightmap_uv: mesh
            .lightmap_uvs
            .get(v)
            .copied()
            .unwrap_or(default.lightmap_uv),
        color: mesh.colors.get(v).copied().unwrap_or(default.color),
    }
}

impl MeshVertex {
    fn is_finite(&self) -> bool {
        [self.position, self.normal, self.color]
            .as_flattened()
            .iter()
            .chain([self.uv, self.lightmap_uv].as_flattened())
            .chain(&self.tangent)
            .all(|x| x.is_finite())
    }
}

/// One attribute of all vertices; nothing if it is everywhere the default and need not be kept.
fn column<T: PartialEq + Copy>(
    vertices: &[MeshVertex],
    of: impl Fn(&MeshVertex) -> T,
    default: T,
    keep: bool,
) -> Vec<T> {
    match keep || vertices.iter().any(|v| of(v) != default) {
        true => vertices.iter().map(of).collect(),
        false => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip() -> Mesh {
        Mesh {
            name: "strip".into(),
            positions: (0..5_000)
                .map(|i| [i as f32, (i % 2) as f32, 0.0])
                .collect(),
            uvs: vec![[0.0; 2]; 5_000],
            ..Mesh::default()
        }
    }

    #[test]
    fn every_vertex_is_staged_once_for_any_number_of_threads() {
        let wave = |v: u32, mut vertex: MeshVertex| {
            vertex.position[2] = 0.1 * vertex.position[0] * vertex.position[1];
            vertex.color = [v as f32, 0.0, 0.0];
            vertex
        };
        let expected = map_vertices(&strip(), wave).unwrap();
        assert_eq!(expected.positions[4_999], [4999.0, 1.0, 0.1 * 4999.0]);
        assert_eq!(expected.colors[4_999][0], 4999.0);
        assert_eq!((expected.uvs.len(), expected.normals.len()), (5_000, 0));
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let mesh = pool.install(|| map_vertices(&strip(), wave)).unwrap();
            assert_eq!(mesh.positions, expected.positions, "{threads}");
            assert_eq!(mesh.colors, expected.colors, "{threads}");
        }
    }

    #[test]
    fn the_first_bad_vertex_is_named() {
        let bad = |v: u32, mut vertex: MeshVertex| {
            vertex.uv[0] = 1.0 / (v as f32 - 3_000.0);
            vertex.normal = [if v > 4_000 { f32::NAN } else { 1.0 }; 3];
            vertex
        };
        let error = map_vertices(&strip(), bad).unwrap_err().to_string();
        assert!(error.contains("'strip' vertex 3000"), "{error}");
        assert!(
            map_vertices(&Mesh::default(), bad)
                .unwrap()
                .positions
                .is_empty()
        );
    }
}
