//! The font that texmap brings: the characters of the code page of the first PCs, 8 x 8 dots each.

use font8x8::UnicodeFonts;
use texmap_mesh::Font;
use texmap_sample::{ColorSpace, Origin, SampleError, Texture2d};

/// Dots a side of a character, and texels a side of its cell: the gutter keeps neighbours apart on mip levels.
const DOTS: u32 = 8;
const CELL: u32 = 16;
const COLUMNS: u32 = 16;
const ROWS: u32 = 6;
const FIRST: u32 = 0x20;

/// White characters on a transparent atlas, from the blank to the tilde, and their layout.
///
/// # Errors
/// Never in practice: the atlas has a size that textures may have.
pub fn built_in_font() -> Result<(Texture2d<'static>, Font), SampleError> {
    let (width, height) = (COLUMNS * CELL, ROWS * CELL);
    let mut texels = vec![0; (width * height * 4) as usize];
    for cell in 0..COLUMNS * ROWS {
        let glyph = char::from_u32(FIRST + cell)
            .and_then(|c| font8x8::BASIC_FONTS.get(c))
            .unwrap_or_default();
        let gutter = (CELL - DOTS) / 2;
        let (left, top) = (
            cell % COLUMNS * CELL + gutter,
            cell / COLUMNS * CELL + gutter,
        );
        for (y, row) in glyph.into_iter().enumerate() {
            for x in (0..DOTS).filter(|x| row >> x & 1 == 1) {
                let at = ((top + y as u32) * width + left + x) as usize * 4;
                texels[at..at + 4].fill(255);
            }
        }
    }
    let texture =
        Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft)?;
    let part = |gutter: u32| {
        let (low, high) = (
            gutter as f32 / CELL as f32,
            (CELL - gutter) as f32 / CELL as f32,
        );
        [low, low, high, high]
    };
    let font = Font {
        body: part((CELL - DOTS) / 2),
        // One texel around, over which the outline falls.
        shown: part((CELL - DOTS) / 2 - 1),
        ..Font::whole(COLUMNS, ROWS, FIRST)
    };
    Ok((texture.with_mips(), font))
}
