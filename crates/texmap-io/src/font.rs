//! The font that scenes write with where they bring none: the built-in typeface as an atlas.

use texmap_mesh::{Font, GlyphGrid, Typeface};
use texmap_sample::{ColorSpace, Origin, SampleError, Texture2d};

/// Texels of a cell across and down.
const CELL: [u32; 2] = [32, 64];
/// The part of it that is a character's step and line, in texels: left, top, right, bottom. The rest keeps neighbours apart on mip levels.
const BODY: [u32; 4] = [4, 14, 28, 54];
/// The part of it that is drawn: accents and descenders, and two texels over which the outline falls.
const SHOWN: [u32; 4] = [2, 4, 30, 58];
/// Texels from the top of a cell to the base line: a fifth of the line lies below it.
const BASE: u32 = 46;
const COLUMNS: u32 = 16;
const ROWS: u32 = 14;
const FIRST: u32 = 0x20;

/// White characters on a transparent atlas, from the blank to U+00FF, and their layout. Alpha is the covered share of each texel. A code
/// point without a character has a question mark.
///
/// # Errors
/// Never in practice: the atlas has a size that textures may have.
pub fn built_in_font() -> Result<(Texture2d<'static>, Font), SampleError> {
    let typeface = Typeface::built_in();
    let (width, height) = (COLUMNS * CELL[0], ROWS * CELL[1]);
    let grid = GlyphGrid {
        width: CELL[0],
        height: CELL[1],
        origin: [BODY[0] as f32, BASE as f32],
        step: (BODY[2] - BODY[0]) as f32,
    };
    let mut texels = vec![0; (width * height * 4) as usize];
    for cell in 0..COLUMNS * ROWS {
        let (left, top) = (cell % COLUMNS * CELL[0], cell / COLUMNS * CELL[1]);
        let character = char::from_u32(FIRST + cell).unwrap_or('?');
        let cover = typeface.coverage(character, &grid);
        for (row, y) in cover.chunks(CELL[0] as usize).zip(top..) {
            for (cover, x) in row.iter().zip(left..) {
                let alpha = texmap_math::color::unit_to_u8(*cover);
                let at = (y * width + x) as usize * 4;
                texels[at..at + 4].copy_from_slice(&[255, 255, 255, alpha]);
            }
        }
    }
    let texture =
        Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft)?;
    let part = |texels: [u32; 4]| [0, 1, 2, 3].map(|k| texels[k] as f32 / CELL[k % 2] as f32);
    let font = Font {
        body: part(BODY),
        shown: part(SHOWN),
        ..Font::whole(COLUMNS, ROWS, FIRST)
    };
    Ok((texture.with_mips(), font))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything that a character covers is shown, and nothing of its neighbours.
    #[test]
    fn characters_stand_in_the_shown_part_of_their_cells() {
        let (texture, font) = built_in_font().unwrap();
        assert!(font.is_valid());
        let mut inked = 0;
        for (x, y) in (0..texture.height()).flat_map(|y| (0..texture.width()).map(move |x| (x, y)))
        {
            let (left, top) = (x % CELL[0], y % CELL[1]);
            let inside =
                (SHOWN[0]..SHOWN[2]).contains(&left) && (SHOWN[1]..SHOWN[3]).contains(&top);
            let alpha = texture.texel(0, x, y).unwrap()[3];
            assert!(inside || alpha == 0.0, "{x} {y}");
            inked += u32::from(alpha > 0.5);
        }
        assert!(inked > 30_000, "{inked}");
    }
}
