//! A sheet of equal captioned panels with the claims below: the layout that every demo shares.

use super::{Claim, DemoPicture, Panel};
use texmap_truth::picture::{GLYPH, Picture, Rgba, wrap};

const PAPER: Rgba = [247, 245, 240, 255];
const INK: Rgba = [30, 32, 40, 255];
const SOFT: Rgba = [92, 96, 108, 255];
const RULE: Rgba = [200, 196, 188, 255];
const GOOD: Rgba = [20, 110, 60, 255];
const BAD: Rgba = [180, 30, 30, 255];

/// Pixels around and between panels.
const GAP: u32 = 16;
/// Height of a text line at scale 1: 16 for the glyph and 4 for air.
const LINE: u32 = 20;

/// Sets a title, the panels in one row (or two rows beyond four panels) and the claims on a sheet of paper.
pub(super) fn sheet(title: &str, panels: Vec<Panel>, claims: Vec<Claim>) -> DemoPicture {
    let size = panels
        .iter()
        .map(|p| p.picture.width().max(p.picture.height()))
        .max()
        .unwrap_or(1);
    let scale = if size >= 560 { 2 } else { 1 };
    let line = LINE * scale;
    let columns = if panels.len() > 4 {
        panels.len().div_ceil(2)
    } else {
        panels.len()
    } as u32;
    let rows = (panels.len() as u32).div_ceil(columns.max(1));
    let width = columns * (size + GAP) + GAP;
    let fit = |pixels: u32| (pixels / (GLYPH * scale)) as usize;
    let words = |panel: &Panel| {
        let title = wrap(&panel.title, fit(size))
            .into_iter()
            .map(|line| (INK, line));
        title
            .chain(
                wrap(&panel.caption, fit(size))
                    .into_iter()
                    .map(|line| (SOFT, line)),
            )
            .collect::<Vec<_>>()
    };
    let texts: Vec<_> = panels.iter().map(words).collect();
    let caption_lines = texts.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let title_scale = if fit(width - 2 * GAP) >= 2 * title.chars().count() {
        2 * scale
    } else {
        scale
    };
    let title_lines = wrap(
        title,
        (width as usize - 2 * GAP as usize) / (GLYPH * title_scale) as usize,
    );
    let title_height = GAP + LINE * title_scale * title_lines.len() as u32 + GAP / 2;
    let caption_height = line * caption_lines + GAP / 2;
    let row_height = size + GAP / 2 + caption_height;
    let footer: Vec<(Rgba, String)> = claims
        .iter()
        .flat_map(|claim| {
            let color = if claim.holds() { GOOD } else { BAD };
            wrap(&claim.to_string(), fit(width - 2 * GAP))
                .into_iter()
                .map(move |text| (color, text))
        })
        .collect();
    let footer_height = GAP + line * footer.len() as u32 + GAP / 2;
    let height = title_height + rows * row_height + footer_height;

    let mut image = Picture::new(width, height, PAPER);
    for (index, text) in title_lines.iter().enumerate() {
        let y = GAP + index as u32 * LINE * title_scale;
        image.text(i64::from(GAP), i64::from(y), title_scale, INK, text);
    }
    for (index, panel) in panels.iter().enumerate() {
        let (column, row) = (index as u32 % columns, index as u32 / columns);
        let x = i64::from(GAP + column * (size + GAP));
        let y = i64::from(title_height + row * row_height);
        image.blit(x, y, &panel.picture);
        image.frame(x - 1, y - 1, size + 2, size + 2, RULE);
        let top = y + i64::from(size + GAP / 2);
        for (below, (color, text)) in texts[index].iter().enumerate() {
            image.text(x, top + i64::from(line) * below as i64, scale, *color, text);
        }
    }
    let top = i64::from(height - footer_height);
    image.fill(i64::from(GAP), top, width - 2 * GAP, 1, RULE);
    for (index, (color, text)) in footer.iter().enumerate() {
        let y = top + i64::from(GAP) + i64::from(line) * index as i64;
        image.text(i64::from(GAP), y, scale, *color, text);
    }
    let captions = panels
        .into_iter()
        .map(|p| format!("{}: {}", p.title, p.caption))
        .collect();
    DemoPicture {
        image,
        captions,
        claims,
    }
}
