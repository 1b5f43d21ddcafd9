//! Groups of faces to meshes with one index per vertex, with the normals and coordinates that the file lacks.

use std::collections::HashMap;
use std::ops::Range;

use texmap_math::glam::DVec3;
use texmap_uv::{Origin, Projection, project};

use super::Part;
use super::mtl::Description;
use super::normals::{Smooth, area_normal, unit};
use super::read::{Corner, Face, NONE, Obj};

pub(super) fn parts(obj: &Obj, descriptions: &[Description], textured: bool) -> Vec<Part> {
    let mut corners = &obj.corners[..];
    let polygons: Vec<Polygon<'_>> = (obj.faces.iter().zip(0..))
        .map(|(face, number)| {
            let (own, rest) = corners.split_at(face.corners as usize);
            corners = rest;
            let points: Vec<DVec3> = own.iter().map(|c| obj.point(c.vertex)).collect();
            Polygon {
                number,
                face,
                corners: own,
                area: area_normal(&points),
            }
        })
        .collect();
    let mut smooth = Smooth::new(obj.positions.len());
    for p in &polygons {
        smooth.add(p.face, p.corners, p.area);
    }
    let mut builder = Builder {
        obj,
        smooth,
        bounds: bounds(obj),
        newest: vec![(NONE, NONE); obj.positions.len()],
        known: HashMap::new(),
    };
    let sections = sections(obj, descriptions);
    let build = |(section, number): (Section<'_>, u32)| {
        let polygons = &polygons[section.faces];
        let has_map = |i: usize| descriptions.get(i).is_some_and(Description::has_map);
        let needs_uv = section.material.map_or(textured, has_map);
        let uv = needs_uv || polygons.iter().any(|p| p.face.has_uv);
        Part {
            name: section.name.to_owned(),
            material: section.material,
            ..builder.part(polygons, number, uv)
        }
    };
    sections.into_iter().zip(0..).map(build).collect()
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
        name: "unnamed_object",
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
                now.name = if name.is_empty() {
                    "unnamed_object"
                } else {
                    name
                };
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

/// One face with everything that its file says about it.
struct Polygon<'a> {
    number: u32,
    face: &'a Face,
    corners: &'a [Corner],
    area: DVec3,
}

impl Obj {
    fn point(&self, vertex: u32) -> DVec3 {
        DVec3::from(self.positions[vertex as usize].map(f64::from))
    }

    /// The file's normal, unless it has none or it has no direction.
    fn normal(&self, corner: Corner) -> Option<[f32; 3]> {
        let normal = *self.normals.get(corner.normal as usize)?;
        unit(DVec3::from(normal.map(f64::from))).map(|_| normal)
    }
}

struct Builder<'a> {
    obj: &'a Obj,
    smooth: Smooth,
    bounds: [[f32; 3]; 2],
    /// Of each vertex of the file: the part and the vertex in it that was made last.
    newest: Vec<(u32, u32)>,
    /// Vertices of the part by vertex of the file, bits of coordinates and normal, and projected face.
    known: HashMap<[u32; 7], u32>,
}

impl Builder<'_> {
    /// `uv`: every vertex gets coordinates, projected ones where the file has none.
    fn part(&mut self, polygons: &[Polygon<'_>], number: u32, uv: bool) -> Part {
        let obj = self.obj;
        let mut part = Part::default();
        self.known.clear();
        // Keys of the part's vertices.
        let mut keys: Vec<[u32; 7]> = Vec::new();
        // Vertices whose coordinates are projected, and the normals of their faces.
        let (mut bare, mut towards) = (Vec::new(), Vec::new());
        let mut corners: Vec<u32> = Vec::new();
        for p in polygons {
            let project = uv && !p.face.has_uv;
            corners.clear();
            for &corner in p.corners {
                let vertex = corner.vertex as usize;
                let uv = match p.face.has_uv {
                    true => obj.uvs[corner.uv as usize],
                    false => [0.0; 2],
                };
                let normal = obj.normal(corner);
                let normal =
                    normal.unwrap_or_else(|| self.smooth.at(p.face, corner.vertex, p.area));
                let [u, v] = uv.map(f32::to_bits);
                let [x, y, z] = normal.map(f32::to_bits);
                // Projection looks at the face, so its corners are not shared.
                let alone = if project { p.number } else { NONE };
                let key = [corner.vertex, u, v, x, y, z, alone];
                let (of, newest) = self.newest[vertex];
                if of == number && keys[newest as usize] == key {
                    corners.push(newest);
                    continue;
                }
                let index = *self.known.entry(key).or_insert_with(|| {
                    part.positions.push(obj.positions[vertex]);
                    part.normals.push(normal);
                    part.uvs.push(uv);
                    part.colors.extend(obj.colors.get(vertex));
                    keys.push(key);
                    let new = keys.len() as u32 - 1;
                    if project {
                        bare.push(new);
                        towards.push(p.area.as_vec3().to_array());
                    }
                    new
                });
                self.newest[vertex] = (number, index);
                corners.push(index);
            }
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
        points.extend(self.bounds);
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
