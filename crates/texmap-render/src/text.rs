//! Words as textured quads from an atlas of characters.

use texmap_math::glam::DVec3;
use texmap_sample::Origin;

use crate::Mesh;

/// An atlas of equal cells, one character each, in the order of their code points, row by row from the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Font {
    /// Cells across.
    pub columns: u32,
    /// Cells down.
    pub rows: u32,
    /// Code point of the first cell.
    pub first: u32,
    /// The part of a cell that one step of the text is wide and high: left, top, right, bottom, 0 to 1. The whole cell, if
    /// its characters fill it.
    pub body: [f32; 4],
    /// The part of a cell that is drawn, which may reach beyond the body into a clear gutter.
    pub shown: [f32; 4],
}

impl Font {
    /// Cells that are drawn whole.
    #[must_use]
    pub fn whole(columns: u32, rows: u32, first: u32) -> Self {
        Self {
            columns,
            rows,
            first,
            body: [0.0, 0.0, 1.0, 1.0],
            shown: [0.0, 0.0, 1.0, 1.0],
        }
    }

    /// Whether the numbers make sense: at least one cell, parts inside of the cell and not empty.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let part = |[left, top, right, bottom]: [f32; 4]| {
            0.0 <= left
                && left < right
                && right <= 1.0
                && 0.0 <= top
                && top < bottom
                && bottom <= 1.0
        };
        let cells = self.columns.checked_mul(self.rows);
        cells.is_some_and(|n| (1..=1 << 20).contains(&n)) && part(self.body) && part(self.shown)
    }

    /// Words as a mesh of one quad a character, without one for blanks: `origin` is the lower left corner of the first
    /// character, `right` its step to the next and `up` its height; lines stand below each other. A character that the atlas
    /// lacks is drawn as `?`, or left out where that is missing, too. Fronts face `right x up`; v = 0 is the top of the atlas.
    #[must_use]
    pub fn mesh(
        &self,
        words: &str,
        origin: DVec3,
        right: DVec3,
        up: DVec3,
        material: usize,
    ) -> Mesh {
        let mut mesh = Mesh {
            name: format!("text `{}`", words.chars().take(40).collect::<String>()),
            material,
            uv_origin: Origin::TopLeft,
            ..Mesh::default()
        };
        if !self.is_valid() {
            return mesh;
        }
        let [left, top, wide, high] = {
            let [a, b, c, d] = self.body.map(f64::from);
            [a, b, c - a, d - b]
        };
        let [u0, v0, u1, v1] = self.shown;
        for (row, line) in words.lines().enumerate() {
            for (column, cell) in line.chars().map(|c| self.cell(c)).enumerate() {
                let Some(cell) = cell else { continue };
                let at = origin + right * column as f64 - up * row as f64;
                let (x, y) = (cell % self.columns, cell / self.columns);
                let first = mesh.positions.len() as u32;
                for (u, v) in [(u0, v1), (u1, v1), (u1, v0), (u0, v0)] {
                    let across = (f64::from(u) - left) / wide;
                    let rise = 1.0 - (f64::from(v) - top) / high;
                    mesh.positions
                        .push((at + right * across + up * rise).as_vec3().to_array());
                    mesh.uvs.push([
                        (x as f32 + u) / self.columns as f32,
                        (y as f32 + v) / self.rows as f32,
                    ]);
                }
                mesh.triangles
                    .extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| first + i)));
                mesh.faces.extend([column as u32; 2]);
            }
        }
        mesh
    }

    /// `None` for blanks.
    fn cell(&self, c: char) -> Option<u32> {
        let cells = self.columns * self.rows;
        let of = |c: char| (c as u32).checked_sub(self.first).filter(|i| *i < cells);
        (!c.is_whitespace()).then(|| of(c).or(of('?'))).flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quads_in_their_places() {
        let font = Font::whole(16, 6, 32);
        let mesh = font.mesh("A \u{e9}\nB", DVec3::ZERO, DVec3::X, DVec3::Y * 2.0, 3);
        assert_eq!((mesh.triangles.len(), mesh.material), (6, 3));
        // `A` is cell 33: column 1, row 2; lower left first.
        assert_eq!(mesh.positions[0], [0.0; 3]);
        assert_eq!(mesh.uvs[0], [1.0 / 16.0, 3.0 / 6.0]);
        assert_eq!(mesh.uvs[2], [2.0 / 16.0, 2.0 / 6.0]);
        // The unknown letter is `?` in the third place; `B` stands a line below.
        assert_eq!(mesh.positions[4], [2.0, 0.0, 0.0]);
        assert_eq!(mesh.uvs[4][0], 15.0 / 16.0);
        assert_eq!(mesh.positions[8], [0.0, -2.0, 0.0]);
    }

    #[test]
    fn what_is_shown_may_reach_beyond_the_body() {
        let font = Font {
            body: [0.25, 0.25, 0.75, 0.75],
            shown: [0.125, 0.25, 0.875, 0.75],
            ..Font::whole(1, 1, 65)
        };
        let mesh = font.mesh("A", DVec3::ZERO, DVec3::X, DVec3::Y, 0);
        assert_eq!(mesh.positions[0], [-0.25, 0.0, 0.0]);
        assert_eq!(mesh.positions[2], [1.25, 1.0, 0.0]);
        for bad in [
            Font::whole(0, 1, 65),
            Font::whole(u32::MAX, 2, 65),
            Font {
                body: [0.5, 0.0, 0.5, 1.0],
                ..font
            },
            Font {
                shown: [0.0, f32::NAN, 1.0, 1.0],
                ..font
            },
        ] {
            assert!(!bad.is_valid());
            assert!(
                bad.mesh("A", DVec3::ZERO, DVec3::X, DVec3::Y, 0)
                    .triangles
                    .is_empty()
            );
        }
    }
}
