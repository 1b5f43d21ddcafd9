//! Vertices and polygons of a PLY file.

use texmap_math::parallel;

use super::records::{Field, Records};
use crate::obj::{Corner, Face, NONE, Obj, are_finite};

/// A fault of a record.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) record: usize,
    pub(super) problem: String,
}

/// The vertices of a file.
#[derive(Debug, Default)]
pub(super) struct Points {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty, or one per position, like the others.
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    /// 0 to 1.
    pub(super) colors: Vec<[f32; 3]>,
    /// Some positions or coordinates are not finite.
    pub(super) partial: bool,
    /// Normals that are not finite, which became zero.
    pub(super) broken_normals: usize,
}

impl Points {
    pub(super) fn of(vertices: &Records<'_>) -> Result<Self, Fault> {
        let count = vertices.element.count;
        let fields = |names: [&[&str]; 3]| {
            Some([
                vertices.field(names[0])?,
                vertices.field(names[1])?,
                vertices.field(names[2])?,
            ])
        };
        let fault = |record: usize, problem: &str| Fault {
            record,
            problem: problem.into(),
        };
        let Some(xyz) = fields([&["x"], &["y"], &["z"]]) else {
            return Err(fault(0, "has no properties x, y and z"));
        };
        let three = |[a, b, c]: [Field<'_>; 3]| {
            let [a, b, c] = [scalar(a)?, scalar(b)?, scalar(c)?];
            let read = |i: usize| [a.value(i) as f32, b.value(i) as f32, c.value(i) as f32];
            Ok(parallel::list(count, [0.0; 3], read))
        };
        let mut points = Self {
            positions: three(xyz)?,
            ..Self::default()
        };
        points.partial = first_broken(&points.positions).is_some();
        if let Some(normal) = fields([&["nx"], &["ny"], &["nz"]]) {
            points.normals = three(normal)?;
            if first_broken(&points.normals).is_some() {
                for normal in points.normals.iter_mut().filter(|n| is_broken(n)) {
                    *normal = [0.0; 3];
                    points.broken_normals += 1;
                }
            }
        }
        let color = [
            &["red", "r", "diffuse_red"][..],
            &["green", "g", "diffuse_green"],
            &["blue", "b", "diffuse_blue"],
        ];
        if let Some(color) = fields(color) {
            points.colors = three(color)?;
            let most = color.map(|field| match field.property.kind.size() {
                1 => 255.0,
                2 => 65535.0,
                _ => 1.0,
            });
            let pieces = points.colors.chunks_mut(parallel::PIECE);
            parallel::for_each(pieces, |piece| {
                for (c, most) in piece.iter_mut().flat_map(|rgb| rgb.iter_mut().zip(most)) {
                    *c /= most;
                }
            });
            let colors = &points.colors;
            let outside = |i: usize| !colors[i].iter().all(|c| (0.0..=1.0).contains(c));
            if let Some(i) = parallel::first(count, outside) {
                return Err(fault(i, "has a colour outside of 0 to 1 (255 for uchar)"));
            }
        }
        let pair = [
            ("s", "t"),
            ("u", "v"),
            ("texture_u", "texture_v"),
            ("texture_s", "texture_t"),
        ];
        let pair = pair
            .into_iter()
            .find_map(|(u, v)| Some((vertices.field(&[u])?, vertices.field(&[v])?)));
        if let Some((u, v)) = pair {
            let (u, v) = (scalar(u)?, scalar(v)?);
            let read = |i: usize| [u.value(i) as f32, v.value(i) as f32];
            points.uvs = parallel::list(count, [0.0; 2], read);
            points.partial |= first_broken(&points.uvs).is_some();
        }
        Ok(points)
    }

    /// The fault of the first vertex that is not finite and that a face uses. (Scans have others: a vertex for each pixel of a depth
    /// image.)
    pub(super) fn check(&self, polygons: &Polygons) -> Result<(), Fault> {
        if !self.partial {
            return Ok(());
        }
        let corners = polygons.corners.iter().map(|vertex| *vertex as usize);
        match corners.filter(|i| is_broken(&self.positions[*i])).min() {
            None => Ok(()),
            Some(record) => Err(Fault {
                record,
                problem: "has a position that is not finite in 32 bits, and a face uses it".into(),
            }),
        }
    }
}

fn is_broken<const N: usize>(values: &[f32; N]) -> bool {
    !are_finite(values)
}

fn first_broken<const N: usize>(values: &[[f32; N]]) -> Option<usize> {
    parallel::first(values.len(), |i| is_broken(&values[i]))
}

/// A property that is no list.
fn scalar(field: Field<'_>) -> Result<Field<'_>, Fault> {
    match field.property.list {
        None => Ok(field),
        Some(_) => Err(Fault {
            record: 0,
            problem: format!(
                "has a list `{}`, where a value is needed",
                field.property.name
            ),
        }),
    }
}

/// The polygons of a file.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    /// Vertices of all corners, one polygon after the other.
    pub(super) corners: Vec<u32>,
    /// Corners of each polygon; empty where all are triangles.
    pub(super) sizes: Vec<u32>,
    /// Coordinates of all corners, NaN where a polygon has none; empty if none has any.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Texture of each polygon; empty if none is named.
    pub(super) textures: Vec<u32>,
}

impl Polygons {
    /// Those of `face`; `vertices` is the number of points.
    pub(super) fn of(faces: &Records<'_>, vertices: usize) -> Result<Self, Fault> {
        let count = faces.element.count;
        let fault = |record: usize, problem: String| Fault { record, problem };
        let indices = faces.field(&["vertex_indices", "vertex_index"]);
        let indices = indices.filter(|f| f.property.list.is_some() && f.property.kind.is_whole());
        let Some(indices) = indices else {
            let problem = "has no list `vertex_indices` of whole numbers".to_owned();
            return Err(fault(0, problem));
        };
        let mut polygons = Self::default();
        if parallel::first(count, |i| indices.list(i).len() != 3).is_none() {
            let corners = parallel::list(count, [0; 3], |i| {
                let mut corners = [0; 3];
                for (corner, index) in corners.iter_mut().zip(indices.list(i)) {
                    *corner = whole(index);
                }
                corners
            });
            polygons.corners = corners.into_flattened();
        } else {
            for i in 0..count {
                let list = indices.list(i);
                if list.len() < 3 {
                    let problem = format!("has {} corners; a face needs 3 or more", list.len());
                    return Err(fault(i, problem));
                }
                polygons.sizes.push(list.len() as u32);
                polygons.corners.extend(list.map(whole));
            }
        }
        let beyond = |index: &u32| *index as usize >= vertices;
        let corners = &polygons.corners;
        if parallel::first(corners.len(), |i| beyond(&corners[i])).is_some() {
            let bad = (0..count).find_map(|i| {
                let index = indices.list(i).find(|index| beyond(&whole(*index)))?;
                Some((i, index))
            });
            let (i, index) = bad.unwrap_or_default();
            let problem =
                format!("names vertex {index}, which does not exist; there are {vertices}, from 0");
            return Err(fault(i, problem));
        }
        if let Some(uvs) = faces
            .field(&["texcoord"])
            .filter(|f| f.property.list.is_some())
        {
            polygons.uvs.reserve_exact(polygons.corners.len());
            for i in 0..count {
                let (corners, mut list) = (polygons.size(i), uvs.list(i));
                if list.len() != 0 && list.len() != 2 * corners {
                    let found = list.len();
                    let problem = format!(
                        "has {found} numbers in `texcoord` for {corners} corners; each has two"
                    );
                    return Err(fault(i, problem));
                }
                let first = polygons.uvs.len();
                for _ in 0..corners {
                    let uv = [(); 2].map(|()| list.next().unwrap_or(f64::NAN) as f32);
                    polygons.uvs.push(uv);
                }
                let own = &mut polygons.uvs[first..];
                if own.iter().any(is_broken) {
                    own.fill([f32::NAN; 2]);
                }
            }
        }
        if let Some(number) = faces
            .field(&["texnumber"])
            .filter(|f| f.property.list.is_none())
        {
            polygons.textures = (0..count).map(|i| whole(number.value(i))).collect();
        }
        Ok(polygons)
    }

    /// The triangles of `tristrips`: -1 ends a strip, and every other triangle of one is turned over.
    pub(super) fn of_strips(strips: &Records<'_>, vertices: usize) -> Result<Self, Fault> {
        let fault = |record: usize, problem: String| Fault { record, problem };
        let indices = strips.field(&["vertex_indices", "vertex_index"]);
        let Some(indices) = indices.filter(|f| f.property.list.is_some()) else {
            return Err(fault(0, "has no list `vertex_indices`".into()));
        };
        let mut polygons = Self::default();
        for i in 0..strips.element.count {
            let (mut last, mut length) = ([0; 2], 0_usize);
            for index in indices.list(i) {
                if index == -1.0 {
                    length = 0;
                    continue;
                }
                let corner = whole(index);
                if corner as usize >= vertices {
                    let problem = format!(
                        "names vertex {index}, which does not exist; there are {vertices}, from 0"
                    );
                    return Err(fault(i, problem));
                }
                let [a, b] = last;
                // Strips repeat vertices to turn; those triangles are lines.
                if length >= 2 && a != b && b != corner && corner != a {
                    polygons.corners.extend(match length % 2 {
                        0 => [a, b, corner],
                        _ => [b, a, corner],
                    });
                }
                (last, length) = ([b, corner], length + 1);
            }
        }
        Ok(polygons)
    }

    pub(super) fn len(&self) -> usize {
        match self.sizes.is_empty() {
            true => self.corners.len() / 3,
            false => self.sizes.len(),
        }
    }

    fn size(&self, polygon: usize) -> usize {
        self.sizes.get(polygon).map_or(3, |size| *size as usize)
    }

    /// An OBJ that says the same with its faces sorted by texture, and the polygon that each of them is.
    pub(super) fn into_obj(self, points: Points) -> (Obj, Vec<u32>) {
        let mut order: Vec<(u32, usize, usize)> = Vec::with_capacity(self.len());
        let mut first = 0;
        for i in 0..self.len() {
            let texture = self.textures.get(i).copied().unwrap_or(0);
            order.push((texture, i, first));
            first += self.size(i);
        }
        order.sort_by_key(|(texture, ..)| *texture);
        let per_vertex = !points.uvs.is_empty();
        let per_corner = !self.uvs.is_empty();
        let has_normals = !points.normals.is_empty();
        let numbers = order.iter().map(|(_, i, _)| *i as u32).collect();
        let mut obj = Obj {
            positions: points.positions,
            normals: points.normals,
            colors: points.colors,
            uvs: if per_corner { Vec::new() } else { points.uvs },
            ..Obj::default()
        };
        for (_, i, first) in order {
            let size = self.size(i);
            let mut corners = self.corners[first..first + size].iter();
            let has_uv = match per_corner {
                true => !self.uvs[first][0].is_nan(),
                false => per_vertex && !corners.any(|i| is_broken(&obj.uvs[*i as usize])),
            };
            obj.faces.push(Face {
                line: 0,
                corners: size as u32,
                has_uv,
                smoothing: u32::MAX,
            });
            let corners = self.corners[first..first + size].iter().zip(first..);
            obj.corners.extend(corners.map(|(&vertex, corner)| Corner {
                vertex,
                uv: match (has_uv, per_corner) {
                    (false, _) => NONE,
                    (true, false) => vertex,
                    (true, true) => corner as u32,
                },
                normal: if has_normals { vertex } else { NONE },
            }));
        }
        if per_corner {
            obj.uvs = self.uvs;
        }
        (obj, numbers)
    }
}

/// An index; values that are none become one larger than any.
fn whole(value: f64) -> u32 {
    match value >= 0.0 {
        true => value as u32,
        false => u32::MAX,
    }
}
