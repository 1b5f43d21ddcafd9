//! The vertices of a part: corners that agree in position, coordinates and normal are one.

use std::collections::BTreeMap;

use super::normals::Normals;
use super::read::{NONE, Obj};

/// A vertex, by numbers of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Vertex {
    /// The vertex of the file.
    pub(super) of: u32,
    /// The coordinates, or [`NONE`].
    pub(super) uv: u32,
    /// The normal, as [`Normals`] numbers them.
    pub(super) normal: u32,
    /// The face that has it for itself, or [`NONE`].
    pub(super) face: u32,
}

/// The vertices of all parts, in the order in which their faces name them. Those of one vertex of the file and one part form a chain
/// of at most [`LONGEST`]; where there are more, the rest is found in a sorted map.
#[derive(Debug)]
pub(super) struct Vertices {
    all: Vec<Vertex>,
    /// The one before in the chain of each.
    before: Vec<u32>,
    /// The last one in the chain of each vertex of the file.
    last: Vec<u32>,
    /// Start of the part.
    first: usize,
    /// Vertices of the part that are in no chain, by the bits that make them equal.
    rest: BTreeMap<[u32; 7], u32>,
}

/// Longer chains belong to the few vertices with a coordinate for each of very many faces.
const LONGEST: usize = 16;

impl Vertices {
    /// Empty chains for a file of this number of vertices.
    pub(super) fn new(count: usize) -> Self {
        Self {
            all: Vec::with_capacity(count),
            before: Vec::with_capacity(count),
            last: vec![NONE; count],
            first: 0,
            rest: BTreeMap::new(),
        }
    }

    /// Begins a part.
    pub(super) fn next_part(&mut self) {
        self.first = self.all.len();
        self.rest.clear();
    }

    /// The vertices of the part.
    pub(super) fn of_part(&self) -> &[Vertex] {
        &self.all[self.first..]
    }

    /// The index of a vertex in the part, and true if it is new.
    pub(super) fn find(&mut self, vertex: Vertex, obj: &Obj, normals: &Normals<'_>) -> (u32, bool) {
        let end = self.last[vertex.of as usize];
        let (mut at, mut length) = (end, 0);
        // Of an earlier part are the ends of chains, too.
        while at != NONE && at as usize >= self.first {
            let known = self.all[at as usize];
            if known == vertex || same(known, vertex, obj, normals) {
                return (at - self.first as u32, false);
            }
            at = self.before[at as usize];
            length += 1;
        }
        let new = self.all.len() as u32;
        let index = new - self.first as u32;
        if length == LONGEST {
            let known = *self.rest.entry(key(vertex, obj, normals)).or_insert(index);
            if known != index {
                return (known, false);
            }
        }
        self.all.push(vertex);
        self.before.push(end);
        if length < LONGEST {
            self.last[vertex.of as usize] = new;
        }
        (index, true)
    }
}

/// True if two vertices of one vertex of the file have the same values under other numbers.
fn same(a: Vertex, b: Vertex, obj: &Obj, normals: &Normals<'_>) -> bool {
    a.face == b.face && key(a, obj, normals) == key(b, obj, normals)
}

/// Bits of the values in which vertices differ.
fn key(vertex: Vertex, obj: &Obj, normals: &Normals<'_>) -> [u32; 7] {
    let [u, v] = obj.uv(vertex.uv).map(f32::to_bits);
    let [x, y, z] = normals.get(vertex.normal).map(f32::to_bits);
    [vertex.of, u, v, x, y, z, vertex.face]
}

impl Obj {
    /// The coordinates of this number; zero where a corner has none.
    pub(super) fn uv(&self, number: u32) -> [f32; 2] {
        self.uvs.get(number as usize).copied().unwrap_or([0.0; 2])
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::read_text;

    /// Coordinates of equal value are one vertex under any numbers, in a chain and beyond it. Others are different vertices.
    #[test]
    fn vertices_are_told_apart_by_values() {
        let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        let count = 3 * super::LONGEST;
        for i in 0..2 * count {
            text += &format!("vt {} 0.5\n", i % count);
        }
        for round in 0..2 {
            for i in 1..=count {
                let i = i + round * count;
                text += &format!("f 1/{i} 2/1 3/1\n");
            }
        }
        let model = read_text(&text);
        let part = &model.parts[0];
        assert_eq!(part.positions.len(), count + 2);
        let (once, again) = part.triangles.split_at(count);
        assert_eq!(once, again);
        let u: Vec<f32> = once.iter().map(|t| part.uvs[t[0] as usize][0]).collect();
        assert!((0..count).all(|i| u[i] == i as f32), "{u:?}");
    }

    /// Parts share no vertices, and each counts its own from 0.
    #[test]
    fn parts_have_vertices_of_their_own() {
        let faces = "f 1 2 3\nf 1 3 2\n";
        let model = read_text(&format!(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\ns 1\n{faces}g b\n{faces}"
        ));
        for part in &model.parts {
            assert_eq!((part.positions.len(), part.triangles[0]), (6, [0, 1, 2]));
        }
    }
}
