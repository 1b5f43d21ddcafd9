//! Words as textured quads from an atlas of characters.

use texmap_math::glam::DVec3;
use texmap_sample::{Alpha, ColorSpace, Image, Origin, SampleError, TexelData, Texture2d};

use texmap_scene::Mesh;

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

    /// True if the numbers make sense: at least one cell, parts inside of the cell and not empty.
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

    /// Words as a mesh of one quad a character, without one for blanks. `origin` is the lower left corner of the first
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

    /// Texels across and down of [`heights`](Self::heights).
    #[must_use]
    pub fn heights_size(&self, words: &str, atlas: &Texture2d<'_>) -> [u32; 2] {
        let [_, body] = self.texels_of(self.body, atlas);
        let lines = words.lines();
        let longest = lines.clone().map(|line| line.chars().count()).max();
        // A character more than is written makes the margin.
        let side = |count: usize, body: u32| {
            u32::try_from((count as u64 + 1).saturating_mul(u64::from(body))).unwrap_or(u32::MAX)
        };
        [
            side(longest.unwrap_or(0), body[0]),
            side(lines.count(), body[1]),
        ]
    }

    /// First texel of a part of the cell (left, top, right, bottom), and its texels across and down.
    fn texels_of(&self, part: [f32; 4], atlas: &Texture2d<'_>) -> [[u32; 2]; 2] {
        let cell = self.cell_texels(atlas);
        let texel = |k: usize, part: f32| (part * cell[k] as f32 + 0.5) as u32;
        let [left, top, right, bottom] = part;
        let first = [texel(0, left), texel(1, top)];
        let size = [
            texel(0, right).saturating_sub(first[0]),
            texel(1, bottom).saturating_sub(first[1]),
        ];
        [first, size]
    }

    /// Texels of a cell, across and down.
    fn cell_texels(&self, atlas: &Texture2d<'_>) -> [u32; 2] {
        let (columns, rows) = if self.is_valid() {
            (self.columns, self.rows)
        } else {
            (1, 1)
        };
        [atlas.width() / columns, atlas.height() / rows]
    }

    /// Words as heights for a bump map: the alpha of the atlas (its red, if it has no alpha), 0 elsewhere, half a character of margin
    /// around. The atlas's own texels, so that each keeps its coordinates; where characters reach into their neighbours, the higher counts.
    ///
    /// # Errors
    /// [`SampleError`] if the words need more texels than a texture has, or the cells none.
    pub fn heights(
        &self,
        words: &str,
        atlas: &Texture2d<'_>,
    ) -> Result<Texture2d<'static>, SampleError> {
        // Cells count from the top, whatever the texture counts from.
        let atlas = &atlas.clone().with_origin(Origin::TopLeft);
        let columns = self.columns.max(1);
        let cell = self.cell_texels(atlas);
        let [body_first, body] = self.texels_of(self.body, atlas);
        let [first, shown] = self.texels_of(self.shown, atlas);
        let lines: Vec<&str> = words.lines().collect();
        let [width, height] = self.heights_size(words, atlas);
        let fits = self.is_valid() && u64::from(width) * u64::from(height) <= 1 << 28;
        let mut texels = vec![0u8; if fits { (width * height) as usize } else { 0 }];
        for (row, line) in lines.iter().enumerate().filter(|_| fits) {
            for (column, glyph) in line.chars().map(|c| self.cell(c)).enumerate() {
                let Some(glyph) = glyph else { continue };
                let from = [
                    glyph % columns * cell[0] + first[0],
                    glyph / columns * cell[1] + first[1],
                ];
                // Of the first texel that is shown; it may lie before the picture.
                let to = [column, row].map(|place| place as i64);
                let to = [0, 1].map(|k| {
                    let body_at = to[k] * i64::from(body[k]) + i64::from(body[k] / 2);
                    body_at + i64::from(first[k]) - i64::from(body_first[k])
                });
                for (x, y) in (0..shown[1]).flat_map(|y| (0..shown[0]).map(move |x| (x, y))) {
                    let (left, top) = (to[0] + i64::from(x), to[1] + i64::from(y));
                    let inside = (0..i64::from(width)).contains(&left)
                        && (0..i64::from(height)).contains(&top);
                    let texel = atlas.texel(0, from[0] + x, from[1] + y);
                    let Some(texel) = texel.filter(|_| inside) else {
                        continue;
                    };
                    let rise = texel[if atlas.has_alpha() { 3 } else { 0 }];
                    let to = &mut texels[top as usize * width as usize + left as usize];
                    *to = texmap_math::color::unit_to_u8(rise).max(*to);
                }
            }
        }
        let image = Image {
            width,
            height,
            channels: 1,
            texels: TexelData::U8(&texels),
            color: ColorSpace::Linear,
            alpha: Alpha::Straight,
            origin: Origin::TopLeft,
        };
        Ok(Texture2d::new(&image)?.with_mips())
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
        // The unknown letter is `?`, the third character; `B` stands a line below.
        assert_eq!(mesh.positions[4], [2.0, 0.0, 0.0]);
        assert_eq!(mesh.uvs[4][0], 15.0 / 16.0);
        assert_eq!(mesh.positions[8], [0.0, -2.0, 0.0]);
    }

    #[test]
    fn words_are_heights_in_the_atlas_own_texels() {
        // Cells of 4 x 4 texels with a gutter of 1: `A` is one dot, `B` a column.
        let dots = [(1, 1), (6, 1), (6, 2)];
        let texels = (0..32u32)
            .flat_map(|i| {
                [if dots.contains(&(i % 8, i / 8)) {
                    255
                } else {
                    0
                }; 4]
            })
            .collect();
        let atlas =
            Texture2d::from_rgba8(8, 4, texels, ColorSpace::Linear, Origin::TopLeft).unwrap();
        let font = Font {
            body: [0.25, 0.25, 0.75, 0.75],
            ..Font::whole(2, 1, 65)
        };
        let raised = |font: &Font, words: &str, side: u32| -> Vec<(u32, u32)> {
            let heights = font.heights(words, &atlas).unwrap();
            assert_eq!((heights.width(), heights.height()), (side, side));
            (0..side * side)
                .map(|i| (i % side, i / side))
                .filter(|&(x, y)| heights.texel(0, x, y).unwrap()[0] > 0.5)
                .collect()
        };
        assert_eq!(
            raised(&font, "AB\n B", 6),
            [(1, 1), (4, 1), (4, 2), (4, 3), (4, 4)]
        );
        let flipped = atlas.clone().with_origin(Origin::BottomLeft);
        let texels = |atlas| {
            let heights = font.heights("AB", atlas).unwrap();
            let size = [heights.width(), heights.height()];
            let all = (0..size[0] * size[1]).map(|i| heights.texel(0, i % size[0], i / size[0]));
            all.collect::<Vec<_>>()
        };
        assert_eq!(texels(&flipped), texels(&atlas));
        // The part of `B` above its body reaches into the margin.
        let tall = Font {
            body: [0.25, 0.5, 0.75, 1.0],
            shown: [0.25, 0.25, 0.75, 1.0],
            ..font
        };
        assert_eq!(raised(&tall, "B", 4), [(2, 0), (2, 1)]);
        let cut = Font {
            shown: tall.body,
            ..tall
        };
        assert_eq!(raised(&cut, "B", 4), [(2, 1)]);
        let wide = "A".repeat(1 << 29);
        assert!(font.heights(&wide, &atlas).is_err());
        assert!(Font::whole(0, 1, 65).heights("A", &atlas).is_err());
        assert!(Font::whole(64, 64, 65).heights("A", &atlas).is_err());
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
