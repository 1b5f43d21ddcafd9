//! Groups of faces to meshes with one index per vertex, with the normals and coordinates that the file lacks.

use std::collections::HashMap;
use std::ops::Range;

use texmap_math::parallel;
use texmap_uv::{Origin, Projection, project};

use super::mtl::Description;
use super::normals::Normals;
use super::polygon::Polygons;
use super::read::{Corner, Face, NONE, Obj};
use super::vertices::{Vertex, Vertices};
use super::{Part, UNNAMED};

pub(crate) fn parts(obj: &Obj, descriptions: &[Description], textured: bool) -> Vec<Part> {
    let mut builder = Builder {
        obj,
        normals: Normals::of(obj),
        vertices: Vertices::new(obj.positions.len()),
        corners: &obj.corners,
        polygons: Polygons::default(),
        bounds: None,
    };
    let sections = sections(obj, descriptions).into_iter();
    let build = |section: Section<'_>| {
        let has_map = |i: usize| descriptions.get(i).is_some_and(Description::has_map);
        let needs_uv = section.material.map_or(textured, has_map);
        let faces = &obj.faces[section.faces.clone()];
        let uv = needs_uv || faces.iter().any(|face| face.has_uv);
        Part {
            name: section.name.to_owned(),
            material: section.material,
            ..builder.part(faces, section.faces.start as u32, uv)
        }
    };
    sections.map(build).collect()
}

/// Faces of one object or group with one material.
#[derive(Clone)]
struct Section<'a> {
    name: &'a str,
    material: Option<usize>,
    faces: Range<usize>,
}

/// The faces, cut where object, group or material change.
fn sections<'a>(obj: &'a Obj, descriptions: &[Description]) -> Vec<Section<'a>> {
    // Of two materials of one name the later one holds.
    let known = descriptions.iter().map(|d| d.name.as_str()).zip(0..);
    let known: HashMap<&str, usize> = known.collect();
    let mut materials = obj.materials.iter();
    let mut now = Section {
        name: UNNAMED,
        material: None,
        faces: 0..0,
    };
    let mut sections = Vec::new();
    let mut end_at = |now: &mut Section<'a>, face: usize| {
        now.faces.end = face;
        if !now.faces.is_empty() {
            sections.push(now.clone());
        }
        now.faces.start = face;
    };
    for group in &obj.groups {
        match group.name.as_deref() {
            Some(name) => {
                end_at(&mut now, group.first_face);
                now.name = if name.is_empty() { UNNAMED } else { name };
            }
            None => {
                let name = materials.next().map_or("", |(_, name)| name);
                let material = known.get(name).copied();
                if material != now.material {
                    end_at(&mut now, group.first_face);
                    now.material = material;
                }
            }
        }
    }
    end_at(&mut now, obj.faces.len());
    sections
}

struct Builder<'a> {
    obj: &'a Obj,
    normals: Normals<'a>,
    vertices: Vertices,
    /// Of the faces that no part has yet.
    corners: &'a [Corner],
    polygons: Polygons,
    /// Of the whole file, once a part has asked for them.
    bounds: Option<[[f32; 3]; 2]>,
}

impl Builder<'_> {
    /// The next faces, counted through the file from `first`. `uv`: every vertex gets coordinates, projected ones where the file has
    /// none.
    fn part(&mut self, faces: &[Face], first: u32, uv: bool) -> Part {
        let obj = self.obj;
        let mut part = Part::default();
        let corners: usize = faces.iter().map(|face| face.corners as usize).sum();
        part.triangles.reserve_exact(corners - 2 * faces.len());
        part.faces.reserve_exact(corners - 2 * faces.len());
        self.vertices.next_part();
        // Vertices whose coordinates are projected, and the normals of their faces.
        let (mut bare, mut towards) = (Vec::new(), Vec::new());
        let (mut indices, mut points): (Vec<u32>, _) = (Vec::new(), Vec::new());
        for (face, number) in faces.iter().zip(first..) {
            let (own, rest) = self.corners.split_at(face.corners as usize);
            self.corners = rest;
            // Projection looks at the face, so its corners are not shared.
            let alone = uv && !face.has_uv;
            let area = (alone || face.smoothing == 0).then(|| obj.area_normal(own, &mut points));
            indices.clear();
            for &corner in own {
                let normal = self.normals.at(face, corner, || {
                    area.unwrap_or_else(|| obj.area_normal(own, &mut Vec::new()))
                });
                let vertex = Vertex {
                    of: corner.vertex,
                    uv: if face.has_uv { corner.uv } else { NONE },
                    normal,
                    face: if alone { number } else { NONE },
                };
                let (index, new) = self.vertices.find(vertex, obj, &self.normals);
                if let Some(area) = area.filter(|_| new && alone) {
                    bare.push(index);
                    towards.push(area.as_vec3().to_array());
                }
                indices.push(index);
            }
            let points = own.iter().map(|c| obj.positions[c.vertex as usize]);
            let within = self.polygons.cut(points, |triangle| {
                part.triangles.push(triangle.map(|k| indices[k]));
                part.faces.push(number);
            });
            if !within {
                part.uncut.get_or_insert((face.corners, face.line));
            }
            if alone {
                let (count, _) = part.projected.get_or_insert((0, face.line));
                *count += 1;
            }
        }
        let (vertices, normals) = (self.vertices.of_part(), &self.normals);
        let three = |of: &(dyn Fn(&Vertex) -> [f32; 3] + Sync)| {
            parallel::list(vertices.len(), [0.0; 3], |i| of(&vertices[i]))
        };
        part.positions = three(&|v| obj.positions[v.of as usize]);
        part.normals = three(&|v| normals.get(v.normal));
        if uv {
            part.uvs = parallel::list(vertices.len(), [0.0; 2], |i| obj.uv(vertices[i].uv));
        }
        if !obj.colors.is_empty() {
            part.colors = three(&|v| obj.colors[v.of as usize]);
        }
        if bare.is_empty() {
            return part;
        }
        // The corners of the whole model's box keep parts in one scale.
        let mut points: Vec<_> = bare.iter().map(|&i| part.positions[i as usize]).collect();
        points.extend(*self.bounds.get_or_insert_with(|| bounds(obj)));
        towards.extend([[0.0; 3]; 2]);
        let projected = project(&points, &towards, Projection::Box, Origin::BottomLeft);
        for (&i, uv) in bare.iter().zip(projected) {
            part.uvs[i as usize] = uv;
        }
        part
    }
}

/// The least and largest coordinates of vertices that faces use.
fn bounds(obj: &Obj) -> [[f32; 3]; 2] {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for corner in &obj.corners {
        let point = obj.positions[corner.vertex as usize];
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::super::model::{SQUARE, read_text};

    #[test]
    fn a_concave_face_is_cut_within_its_outline() {
        // The fan of the first corner would cover the notch at (1, 1).
        let model =
            read_text("v 1 0 0\nv 1 2 0\nv 0 1 0\nv -1 2 0\nv -1 0 0\nv 0 3 0\nf 2 3 4 5 1\n");
        let part = &model.parts[0];
        assert_eq!(part.faces, [0, 0, 0]);
        let corner = |k: u32| part.positions[k as usize];
        for triangle in &part.triangles {
            let [x, y] =
                [0, 1].map(|axis| triangle.iter().map(|k| corner(*k)[axis]).sum::<f32>() / 3.0);
            assert!(y < 1.0 + x.abs(), "{triangle:?}");
        }
        assert_eq!(part.uncut, None);
    }

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
