//! Meshes as polygons with separate position, texture and normal indices, and their OBJ text.

use std::fmt::Write;

use texmap_math::glam::DVec3;

/// Index of the position, the texture coordinate and the normal of one corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    pub(crate) position: usize,
    pub(crate) uv: usize,
    pub(crate) normal: usize,
}

/// A mesh; v is measured from the bottom row, as OBJ does.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) uvs: Vec<[f64; 2]>,
    pub(crate) normals: Vec<DVec3>,
    /// Named groups of polygons in order.
    pub(crate) groups: Vec<(String, Vec<Vec<Corner>>)>,
}

impl Mesh {
    /// Appends `other` as further groups.
    pub(crate) fn append(&mut self, other: Self) {
        let (p, t, n) = (self.positions.len(), self.uvs.len(), self.normals.len());
        self.positions.extend(other.positions);
        self.uvs.extend(other.uvs);
        self.normals.extend(other.normals);
        self.groups
            .extend(other.groups.into_iter().map(|(name, faces)| {
                let shift = |c: Corner| Corner {
                    position: c.position + p,
                    uv: c.uv + t,
                    normal: c.normal + n,
                };
                (
                    name,
                    faces
                        .into_iter()
                        .map(|f| f.into_iter().map(shift).collect())
                        .collect(),
                )
            }));
    }

    /// A flat polygon with its own corners; the normal follows from the counter-clockwise order.
    pub(crate) fn polygon(&mut self, group: &str, corners: &[(DVec3, [f64; 2])]) {
        let normal =
            (corners[1].0 - corners[0].0).cross(corners[corners.len() - 1].0 - corners[0].0);
        self.normals.push(normal / length(normal));
        let face = corners
            .iter()
            .map(|(position, uv)| {
                self.positions.push(*position);
                self.uvs.push(*uv);
                Corner {
                    position: self.positions.len() - 1,
                    uv: self.uvs.len() - 1,
                    normal: self.normals.len() - 1,
                }
            })
            .collect();
        match self.groups.last_mut() {
            Some((name, faces)) if name == group => faces.push(face),
            _ => self.groups.push((group.into(), vec![face])),
        }
    }

    /// Merges equal positions, uvs and normals (to a millionth), first come first kept.
    pub(crate) fn welded(self) -> Self {
        let (positions, p) = weld(self.positions, |v| v.to_array().map(key));
        let (uvs, t) = weld(self.uvs, |v| [key(v[0]), key(v[1]), 0]);
        let (normals, n) = weld(self.normals, |v| v.to_array().map(key));
        let groups = self
            .groups
            .into_iter()
            .map(|(name, faces)| {
                let renumber = |c: Corner| Corner {
                    position: p[c.position],
                    uv: t[c.uv],
                    normal: n[c.normal],
                };
                (
                    name,
                    faces
                        .into_iter()
                        .map(|f| f.into_iter().map(renumber).collect())
                        .collect(),
                )
            })
            .collect();
        Self {
            positions,
            uvs,
            normals,
            groups,
        }
    }

    /// OBJ text that draws every group with `material` of the library `library`.
    pub(crate) fn obj(&self, heading: &str, library: &str, material: &str) -> String {
        let mut out = format!("# {heading}\nmtllib {library}\n");
        for p in &self.positions {
            let _ = writeln!(
                out,
                "v {} {} {}",
                number(p.x, 4),
                number(p.y, 4),
                number(p.z, 4)
            );
        }
        for t in &self.uvs {
            let _ = writeln!(out, "vt {} {}", number(t[0], 5), number(t[1], 5));
        }
        for n in &self.normals {
            let _ = writeln!(
                out,
                "vn {} {} {}",
                number(n.x, 3),
                number(n.y, 3),
                number(n.z, 3)
            );
        }
        for (name, faces) in &self.groups {
            let _ = writeln!(out, "g {name}\nusemtl {material}");
            for face in faces {
                out.push('f');
                for c in face {
                    let _ = write!(out, " {}/{}/{}", c.position + 1, c.uv + 1, c.normal + 1);
                }
                out.push('\n');
            }
        }
        out
    }
}

/// The number of millionths: what differs by rounding alone is equal.
fn key(x: f64) -> i64 {
    (x * 1e6 + 0.5).floor() as i64
}

fn weld<T: Copy>(items: Vec<T>, key: impl Fn(&T) -> [i64; 3]) -> (Vec<T>, Vec<usize>) {
    let mut known = std::collections::BTreeMap::new();
    let mut kept = Vec::new();
    let renumber = items
        .iter()
        .map(|item| {
            *known.entry(key(item)).or_insert_with(|| {
                kept.push(*item);
                kept.len() - 1
            })
        })
        .collect();
    (kept, renumber)
}

/// A decimal without trailing zeros and without a negative zero.
fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

pub(crate) fn length(v: DVec3) -> f64 {
    (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
}

pub(crate) fn unit(v: DVec3) -> DVec3 {
    let l = length(v);
    if l > 0.0 { v / l } else { DVec3::Y }
}

/// The material library that goes with a mesh: one textured material.
pub(crate) fn mtl(name: &str, texture: &str) -> String {
    format!("newmtl {name}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nNs 10\nmap_Kd ../textures/{texture}\n")
}
