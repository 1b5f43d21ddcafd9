//! The contact sheet of `--views`.

use texmap_truth::picture::{GLYPH, Picture};

/// Between the cells, and around a caption.
const GAP: u32 = 8;
const TEXT_HEIGHT: u32 = 16;

/// Lays captioned pictures of one size out, row by row, in a grid as square as their number allows.
pub(crate) fn sheet(cells: &[(String, Picture)]) -> Picture {
    let (width, height) = cells
        .first()
        .map_or((1, 1), |(_, p)| (p.width(), p.height()));
    let columns = (1..).find(|c| c * c >= cells.len() as u32).unwrap_or(1);
    let rows = (cells.len() as u32).div_ceil(columns);
    let (step_x, step_y) = (width + GAP, TEXT_HEIGHT + height + 2 * GAP);
    let mut sheet = Picture::new(
        GAP + columns * step_x,
        GAP + rows * step_y,
        [32, 34, 38, 255],
    );
    for (index, (caption, picture)) in (0..).zip(cells) {
        let x = i64::from(GAP + index % columns * step_x);
        let y = i64::from(GAP + index / columns * step_y);
        let caption: String = caption.chars().take((width / GLYPH) as usize).collect();
        sheet.text(x, y, 1, [235, 235, 235, 255], &caption);
        sheet.blit(x, y + i64::from(TEXT_HEIGHT + GAP), picture);
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_is_as_square_as_its_cells_allow() {
        let cell = |n: usize| (n.to_string(), Picture::new(20, 10, [n as u8, 0, 0, 255]));
        let of = |n: usize| sheet(&(0..n).map(cell).collect::<Vec<_>>());
        assert_eq!((of(1).width(), of(1).height()), (36, 50));
        let four = of(4);
        assert_eq!((four.width(), four.height()), (64, 92));
        // Right column, second row: below the first row, its own caption and the gap.
        assert_eq!(four.get(36, 8 + 42 + 24), [3, 0, 0, 255]);
        assert_eq!(four.get(36, 8 + 42 + 23), [32, 34, 38, 255]);
    }
}
