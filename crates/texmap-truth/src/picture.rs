//! An RGBA8 picture with a bitmap font, from which strips, heat pictures and demos are assembled.
//!
//! Everything drawn is integer work, so a picture has the same bytes on every machine.

use font8x8::UnicodeFonts;
use texmap_render::Frame;

/// A colour as red, green, blue and alpha bytes.
pub type Rgba = [u8; 4];

/// Width of a glyph at scale 1, in pixels.
pub const GLYPH: u32 = 8;

/// An image of straight-alpha RGBA8 pixels, rows top to bottom.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

impl std::fmt::Debug for Picture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Picture({} x {})", self.width, self.height)
    }
}

impl From<Frame> for Picture {
    /// The colours of a frame.
    fn from(frame: Frame) -> Self {
        Self {
            width: frame.width,
            height: frame.height,
            rgba: frame.rgba,
        }
    }
}

impl Picture {
    /// A picture of one colour.
    pub fn new(width: u32, height: u32, color: Rgba) -> Self {
        Self {
            width,
            height,
            rgba: color.repeat(width as usize * height as usize),
        }
    }

    /// A picture of given pixels; `None` when `rgba` does not hold `width * height * 4` bytes.
    pub fn from_rgba(width: u32, height: u32, rgba: Vec<u8>) -> Option<Self> {
        (rgba.len() == width as usize * height as usize * 4).then_some(Self {
            width,
            height,
            rgba,
        })
    }

    /// A picture whose pixel at column x and row y is `color(x, y)`.
    pub fn from_fn(width: u32, height: u32, mut color: impl FnMut(u32, u32) -> Rgba) -> Self {
        let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            width,
            height,
            rgba: rows.flat_map(|(x, y)| color(x, y)).collect(),
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The bytes, four for each pixel.
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// The pixel at (x, y), or transparent black outside.
    pub fn get(&self, x: i64, y: i64) -> Rgba {
        self.index(x, y).map_or([0; 4], |i| {
            [
                self.rgba[i],
                self.rgba[i + 1],
                self.rgba[i + 2],
                self.rgba[i + 3],
            ]
        })
    }

    /// Writes a pixel; positions outside are ignored.
    pub fn set(&mut self, x: i64, y: i64, color: Rgba) {
        if let Some(i) = self.index(x, y) {
            self.rgba[i..i + 4].copy_from_slice(&color);
        }
    }

    /// Fills a rectangle, cut at the border.
    pub fn fill(&mut self, x: i64, y: i64, width: u32, height: u32, color: Rgba) {
        for row in y..y + i64::from(height) {
            for column in x..x + i64::from(width) {
                self.set(column, row, color);
            }
        }
    }

    /// Copies another picture with its top left corner at (x, y), cut at the border.
    pub fn blit(&mut self, x: i64, y: i64, other: &Self) {
        for row in 0..i64::from(other.height) {
            for column in 0..i64::from(other.width) {
                self.set(x + column, y + row, other.get(column, row));
            }
        }
    }

    /// Copies a region of another picture, each pixel `zoom` by `zoom`.
    pub fn blit_zoomed(&mut self, x: i64, y: i64, other: &Self, region: [i64; 4], zoom: u32) {
        let [left, top, width, height] = region;
        for row in 0..height {
            for column in 0..width {
                let (px, py) = (x + column * i64::from(zoom), y + row * i64::from(zoom));
                self.fill(px, py, zoom, zoom, other.get(left + column, top + row));
            }
        }
    }

    /// A line of single pixels from one position to another, both included (Bresenham 1965).
    pub fn line(&mut self, from: (i64, i64), to: (i64, i64), color: Rgba) {
        let (dx, dy) = ((to.0 - from.0).abs(), -(to.1 - from.1).abs());
        let (step_x, step_y) = ((to.0 - from.0).signum(), (to.1 - from.1).signum());
        let (mut x, mut y, mut error) = (from.0, from.1, dx + dy);
        loop {
            self.set(x, y, color);
            if (x, y) == to {
                return;
            }
            let doubled = 2 * error;
            if doubled >= dy {
                error += dy;
                x += step_x;
            }
            if doubled <= dx {
                error += dx;
                y += step_y;
            }
        }
    }

    /// The outline of a rectangle.
    pub fn frame(&mut self, x: i64, y: i64, width: u32, height: u32, color: Rgba) {
        let (right, bottom) = (x + i64::from(width) - 1, y + i64::from(height) - 1);
        self.line((x, y), (right, y), color);
        self.line((x, bottom), (right, bottom), color);
        self.line((x, y), (x, bottom), color);
        self.line((right, y), (right, bottom), color);
    }

    /// One line of text with its top left corner at (x, y): glyphs `8 * scale` wide and `16 * scale` high
    /// (each row of the 8x8 font twice, which reads better at a small size). A character that the font lacks
    /// is drawn as `?`.
    pub fn text(&mut self, x: i64, y: i64, scale: u32, color: Rgba, text: &str) {
        for (place, character) in text.chars().enumerate() {
            let rows = glyph(character);
            let left = x + place as i64 * i64::from(GLYPH * scale);
            for (row, bits) in rows.into_iter().enumerate() {
                for column in (0..8u32).filter(|column| bits & (1 << column) != 0) {
                    let top = y + row as i64 * i64::from(2 * scale);
                    self.fill(
                        left + i64::from(column * scale),
                        top,
                        scale,
                        2 * scale,
                        color,
                    );
                }
            }
        }
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let inside = x >= 0 && y >= 0 && x < i64::from(self.width) && y < i64::from(self.height);
        inside.then(|| (y as usize * self.width as usize + x as usize) * 4)
    }
}

/// Breaks a text into lines of at most `columns` characters, at spaces where that is possible.
pub fn wrap(text: &str, columns: usize) -> Vec<String> {
    let columns = columns.max(1);
    let mut lines = Vec::new();
    for paragraph in text.split('\n') {
        let mut line = String::new();
        for word in paragraph.split(' ') {
            let mut word: Vec<char> = word.chars().collect();
            let used = line.chars().count();
            if used > 0 && used + 1 + word.len() > columns {
                lines.push(std::mem::take(&mut line));
            } else if used > 0 {
                line.push(' ');
            }
            while word.len() > columns {
                lines.push(word.drain(..columns).collect());
            }
            line.extend(word);
        }
        lines.push(line);
    }
    lines
}

fn glyph(character: char) -> [u8; 8] {
    font8x8::BASIC_FONTS
        .get(character)
        .or_else(|| font8x8::LATIN_FONTS.get(character))
        .or_else(|| font8x8::GREEK_FONTS.get(character))
        .or_else(|| font8x8::BASIC_FONTS.get('?'))
        .unwrap_or([0xff; 8])
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: Rgba = [255, 255, 255, 255];
    const PAPER: Rgba = [0, 0, 0, 255];

    #[test]
    fn what_leaves_the_border_is_cut() {
        let mut picture = Picture::new(4, 4, PAPER);
        picture.fill(-2, -2, 4, 4, INK);
        picture.blit(3, 3, &Picture::new(5, 5, INK));
        picture.line((-3, 3), (0, 3), INK);
        let lit = picture.rgba().chunks(4).filter(|p| p[0] == 255).count();
        assert_eq!(lit, 4 + 1 + 1);
    }

    #[test]
    fn text_has_the_glyphs_pixels_twice_as_high() {
        let mut picture = Picture::new(8, 16, PAPER);
        picture.text(0, 0, 1, INK, "I");
        let rows = glyph('I');
        for y in 0..16 {
            for x in 0..8 {
                let lit = rows[y as usize / 2] & (1 << x) != 0;
                assert_eq!(picture.get(x, y), if lit { INK } else { PAPER });
            }
        }
        assert_eq!(
            glyph('\u{1F600}'),
            glyph('?'),
            "a character that the font lacks"
        );
    }

    #[test]
    fn wrap_keeps_every_word_within_the_columns() {
        assert_eq!(
            wrap("affine bends the lines", 12),
            ["affine bends", "the lines"]
        );
        assert_eq!(wrap("abcdefgh ij", 3), ["abc", "def", "gh", "ij"]);
        assert_eq!(wrap("one\ntwo", 80), ["one", "two"]);
    }
}
