//! Meshes as PLY and STL.

use texmap_math::glam::DVec3;

use crate::mesh::{Corner, Mesh};

impl Mesh {
    /// A binary PLY whose faces bring the coordinates of their corners in one texture.
    pub(crate) fn ply(&self, heading: &str, texture: &str) -> Vec<u8> {
        let faces = self.faces();
        let mut out = format!(
            "ply\nformat binary_little_endian 1.0\ncomment {heading}\ncomment TextureFile {texture}\n\
             element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {}\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n",
            self.positions.len(),
            faces.len(),
        )
        .into_bytes();
        for position in &self.positions {
            out.extend(bytes(*position));
        }
        for face in faces {
            out.push(face.len() as u8);
            out.extend(face.iter().flat_map(|c| (c.position as i32).to_le_bytes()));
            out.push(2 * face.len() as u8);
            let uvs = face.iter().flat_map(|c| self.uvs[c.uv]);
            out.extend(uvs.flat_map(|c| (c as f32).to_le_bytes()));
        }
        out
    }

    /// A binary STL of the fans of all faces.
    pub(crate) fn stl(&self, heading: &str) -> Vec<u8> {
        let faces = self.faces();
        let corner = |c: &Corner| self.positions[c.position];
        let fans = faces.iter().flat_map(|face| {
            let rest = face[1..].windows(2);
            rest.map(move |pair| [corner(&face[0]), corner(&pair[0]), corner(&pair[1])])
        });
        let triangles: Vec<[DVec3; 3]> = fans.collect();
        let mut out = heading.as_bytes().to_vec();
        out.resize(80, b' ');
        out.extend((triangles.len() as u32).to_le_bytes());
        for [a, b, c] in triangles {
            let normal = (b - a).cross(c - a);
            let length = normal.length_squared().sqrt();
            let unit = if length > 0.0 {
                normal / length
            } else {
                DVec3::ZERO
            };
            for v in [unit, a, b, c] {
                out.extend(bytes(v));
            }
            out.extend([0, 0]);
        }
        out
    }

    fn faces(&self) -> Vec<&[Corner]> {
        let groups = self.groups.iter();
        groups
            .flat_map(|(_, faces)| faces.iter().map(Vec::as_slice))
            .collect()
    }
}

fn bytes(v: DVec3) -> impl Iterator<Item = u8> {
    v.as_vec3()
        .to_array()
        .into_iter()
        .flat_map(f32::to_le_bytes)
}
