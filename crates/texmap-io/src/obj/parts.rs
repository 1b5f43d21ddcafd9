//! The reader's meshes to parts with one index per vertex, with the normals and coordinates that the file lacks.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use texmap_math::glam::DVec3;
use texmap_uv::{Origin, Projection, project};

use super::Part;
use super::check::{Checked, Face};
use super::mtl::Description;
use super::normals::{Smooth, area_normal, unit};
use crate::IoError;

pub(super) fn parts(
    path: &Path,
    checked: &Checked,
    descriptions: &[Description],
    textured: bool,
) -> Result<Vec<Part>, IoError> {
    let models = meshes(path, checked, descriptions)?;
    let mut polygons: Vec<Vec<Polygon<'_>>> = Vec::new();
    let (mut faces, mut vertices) = (checked.faces.iter().zip(0..), &checked.corners[..]);
    for model in &models {
        let mesh = &model.mesh;
        let mut start = 0;
        let mut list = Vec::new();
        while start < mesh.indices.len() {
            let Some((face, number)) = faces.next() else {
                break;
            };
            let range = start..start + face.corners as usize;
            start = range.end;
            let (own, rest) = vertices.split_at(range.len());
            vertices = rest;
            let points: Vec<DVec3> = mesh.indices[range.clone()]
                .iter()
                .map(|&i| DVec3::from(position(&mesh.positions, i).map(f64::from)))
                .collect();
            list.push(Polygon {
                number,
                face,
                range,
                vertices: own,
                area: area_normal(&points),
                mesh,
            });
        }
        polygons.push(list);
    }
    let mut smooth = Smooth::default();
    for p in polygons.iter().flatten() {
        smooth.add(p.face, p.vertices, p.area);
    }
    let (low, high) = bounds(&models);
    let build = |(model, polygons): (&tobj::Model, &Vec<Polygon<'_>>)| {
        let has_map = |i: usize| descriptions.get(i).is_some_and(Description::has_map);
        let needs_uv = model.mesh.material_id.map_or(textured, has_map);
        let uv = needs_uv || polygons.iter().any(|p| p.face.has_uv);
        let mut part = part(polygons, &smooth, uv, [low, high]);
        part.name.clone_from(&model.name);
        part.material = model.mesh.material_id;
        part
    };
    Ok(models.iter().zip(&polygons).map(build).collect())
}

/// The reader's meshes, cut where object, group or material change.
fn meshes(
    path: &Path,
    checked: &Checked,
    descriptions: &[Description],
) -> Result<Vec<tobj::Model>, IoError> {
    let materials = || {
        let materials = descriptions.iter().map(|d| tobj::Material {
            name: d.name.clone(),
            ..Default::default()
        });
        let indices = descriptions
            .iter()
            .enumerate()
            .map(|(i, d)| (d.name.clone(), i));
        Ok((materials.collect(), indices.collect()))
    };
    // The libraries were read before, so the name is never looked at.
    let mut text = b"mtllib read-before\n"
        .as_slice()
        .chain(checked.text.as_bytes());
    let (mut models, _) =
        tobj::load_obj_buf(&mut text, &tobj::LoadOptions::default(), |_| materials()).map_err(
            |e| IoError::BrokenModel {
                path: path.to_path_buf(),
                problem: e.to_string(),
            },
        )?;
    models.retain(|m| !m.mesh.indices.is_empty());
    let corners: usize = models.iter().map(|m| m.mesh.indices.len()).sum();
    if corners != checked.corners.len() {
        let problem = format!(
            "{} corners in the file, {corners} read",
            checked.corners.len()
        );
        return Err(IoError::BrokenModel {
            path: path.to_path_buf(),
            problem,
        });
    }
    Ok(models)
}

/// One face with everything that its file says about it.
struct Polygon<'a> {
    number: u32,
    face: &'a Face,
    /// Corners in `mesh`.
    range: std::ops::Range<usize>,
    /// Vertices of the file.
    vertices: &'a [u32],
    area: DVec3,
    mesh: &'a tobj::Mesh,
}

impl Polygon<'_> {
    fn uv(&self, corner: usize) -> [f32; 2] {
        let i = 2 * self.mesh.texcoord_indices[corner] as usize;
        [self.mesh.texcoords[i], self.mesh.texcoords[i + 1]]
    }

    /// The file's normal, unless it has none or it has no direction.
    fn normal(&self, corner: usize) -> Option<[f32; 3]> {
        if !self.face.has_normal {
            return None;
        }
        let normal = position(&self.mesh.normals, self.mesh.normal_indices[corner]);
        unit(DVec3::from(normal.map(f64::from))).map(|_| normal)
    }
}

fn position(values: &[f32], index: u32) -> [f32; 3] {
    let i = 3 * index as usize;
    [values[i], values[i + 1], values[i + 2]]
}

/// `uv`: every vertex gets coordinates, projected ones where the file has none.
fn part(polygons: &[Polygon<'_>], smooth: &Smooth, uv: bool, bounds: [[f32; 3]; 2]) -> Part {
    let mut part = Part::default();
    let mut known: HashMap<[u32; 7], u32> = HashMap::new();
    // Vertices whose coordinates are projected, and the normals of their faces.
    let (mut bare, mut towards) = (Vec::new(), Vec::new());
    for p in polygons {
        let project = uv && !p.face.has_uv;
        let corners: Vec<u32> = p
            .range
            .clone()
            .zip(p.vertices)
            .map(|(corner, &vertex)| {
                let index = p.mesh.indices[corner];
                let uv = if p.face.has_uv {
                    p.uv(corner)
                } else {
                    [0.0; 2]
                };
                let normal = p
                    .normal(corner)
                    .unwrap_or_else(|| smooth.at(p.face, vertex, p.area));
                let [u, v] = uv.map(f32::to_bits);
                let [x, y, z] = normal.map(f32::to_bits);
                // Projection looks at the face, so its corners are not shared.
                let alone = if project { p.number } else { u32::MAX };
                *known
                    .entry([index, u, v, x, y, z, alone])
                    .or_insert_with(|| {
                        let new = part.positions.len() as u32;
                        part.positions.push(position(&p.mesh.positions, index));
                        part.normals.push(normal);
                        part.uvs.push(uv);
                        part.colors.push(position(&p.mesh.vertex_color, index));
                        if project {
                            bare.push(new);
                            towards.push(p.area.as_vec3().to_array());
                        }
                        new
                    })
            })
            .collect();
        for pair in corners[1..].windows(2) {
            part.triangles.push([corners[0], pair[0], pair[1]]);
            part.faces.push(p.number);
        }
        if project {
            let (count, _) = part.projected.get_or_insert((0, p.face.line));
            *count += 1;
        }
    }
    if !uv {
        part.uvs.clear();
    }
    // The corners of the whole model's box keep parts in one scale.
    let mut points: Vec<_> = bare.iter().map(|&i| part.positions[i as usize]).collect();
    points.extend(bounds);
    towards.extend([[0.0; 3]; 2]);
    for (&i, uv) in bare.iter().zip(project(
        &points,
        &towards,
        Projection::Box,
        Origin::BottomLeft,
    )) {
        part.uvs[i as usize] = uv;
    }
    part
}

fn bounds(models: &[tobj::Model]) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in models
        .iter()
        .flat_map(|m| m.mesh.positions.as_chunks::<3>().0)
    {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::super::model::{SQUARE, read_text};

    #[test]
    fn polygons_become_fans_with_the_numbers_of_their_faces() {
        let m = read_text(&format!(
            "{SQUARE}f 1/1 2/2 3/3\nf 1/1 2/2 3/3 4/4\nf -4/-4 -3/-3 -2/-2 -1/-1 1/1\n"
        ));
        let part = &m.parts[0];
        assert_eq!(part.faces, [0, 1, 1, 2, 2, 2]);
        assert_eq!(part.triangles[1], [0, 1, 2]);
        assert_eq!(part.triangles[2], [0, 2, 3]);
        assert_eq!(part.positions.len(), 4);
        assert_eq!(part.uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(part.normals, [[0.0, 0.0, 1.0]; 4]);
    }

    #[test]
    fn one_vertex_with_two_coordinates_is_split() {
        let m = read_text(&format!("{SQUARE}f 1/1 2/2 3/3\nf 1/4 3/3 4/1\n"));
        assert_eq!(m.parts[0].positions.len(), 5);
        assert_eq!(m.parts[0].triangles[1], [3, 2, 4]);
    }

    #[test]
    fn faces_with_and_without_coordinates_do_not_share_them() {
        let m = read_text(&format!("{SQUARE}f 1 2 3\nf 1/4 3/4 4/4\nf 1 3 4\n"));
        let part = &m.parts[0];
        assert_eq!(part.projected, Some((2, 9)));
        let uv = |t: usize, k: usize| part.uvs[part.triangles[t][k] as usize];
        assert_eq!([uv(1, 0), uv(1, 1), uv(1, 2)], [[0.0, 1.0]; 3]);
        // The box's front: u to the right, v up.
        assert_eq!(
            [uv(0, 0), uv(0, 1), uv(0, 2)],
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
        );
        assert!(m.warnings[0].contains("box projection"), "{:?}", m.warnings);
    }

    #[test]
    fn smoothing_groups_and_given_normals() {
        let bent = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\nvn 0 1 0\nvn 0 0 0\n";
        let faces = "f 1 2 3\nf 1 4 2\n";
        let smooth = read_text(&format!("{bent}{faces}"));
        assert_eq!(smooth.parts[0].positions.len(), 4);
        let diagonal = 0.5_f32.sqrt();
        assert_eq!(smooth.parts[0].normals[0], [0.0, diagonal, diagonal]);
        let flat = read_text(&format!("{bent}s off\n{faces}"));
        assert_eq!(flat.parts[0].positions.len(), 6);
        assert_eq!(flat.parts[0].normals[0], [0.0, 0.0, 1.0]);
        let given = read_text(&format!("{bent}f 1//1 2//2 3//1\n"));
        assert_eq!(
            given.parts[0].normals,
            [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
        );
    }

    #[test]
    fn colours_of_vertices_are_kept() {
        let m = read_text("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 0 0.5 1\nf 1 2 3\n");
        assert!(m.colored);
        assert_eq!(
            m.parts[0].colors,
            [[1.0, 0.0, 0.0], [1.0; 3], [0.0, 0.5, 1.0]]
        );
    }
}
