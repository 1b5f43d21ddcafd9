//! An RGBA8 picture with the built-in typeface, from which strips, heat pictures and demos are assembled.
//!
//! Shapes are integer work and letters plain arithmetic, so a picture has the same bytes on every machine.

use texmap_math::color::{linear_to_srgb8, srgb8_to_linear, unit_to_u8};
use texmap_mesh::{GlyphGrid, Typeface};
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

    /// One line of text with its top left corner at (x, y): the built-in typeface, characters `8 * scale` wide and `16 * scale` high, mixed
    /// in linear light by the share of each pixel that they cover. A character that it lacks is drawn as `?`.
    pub fn text(&mut self, x: i64, y: i64, scale: u32, color: Rgba, text: &str) {
        let typeface = Typeface::built_in();
        let step = GLYPH * scale.max(1);
        // An accent above a capital reaches a quarter of a row beyond the top.
        let over = scale.max(1);
        let grid = GlyphGrid {
            width: step,
            height: 2 * step + over,
            origin: [0.0, (over + 13 * scale.max(1)) as f32],
            step: step as f32,
        };
        for (character, left) in text.chars().zip((x..).step_by(step as usize)) {
            let cover = typeface.coverage(character, &grid);
            for (row, y) in cover.chunks(step as usize).zip(y - i64::from(over)..) {
                for (cover, x) in row.iter().zip(left..) {
                    self.mix(x, y, color, *cover);
                }
            }
        }
    }

    /// Lays a colour over the share `cover` of a pixel.
    fn mix(&mut self, x: i64, y: i64, color: Rgba, cover: f32) {
        let Some(at) = self.index(x, y).filter(|_| cover > 0.0) else {
            return;
        };
        let pixel = &mut self.rgba[at..at + 4];
        let front = cover * f32::from(color[3]) / 255.0;
        let back = f32::from(pixel[3]) / 255.0 * (1.0 - front);
        let alpha = front + back;
        if alpha > 0.0 {
            for (to, from) in pixel.iter_mut().zip(color).take(3) {
                let [below, above] = [*to, from].map(srgb8_to_linear);
                *to = linear_to_srgb8((above * front + below * back) / alpha);
            }
        }
        pixel[3] = unit_to_u8(alpha);
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
    fn text_is_as_bright_as_it_covers_and_stays_in_its_cells() {
        let mut picture = Picture::new(30, 20, PAPER);
        picture.text(2, 2, 1, INK, "I.");
        let grid = GlyphGrid {
            width: 8,
            height: 16,
            origin: [0.0, 13.0],
            step: 8.0,
        };
        let cover = Typeface::built_in().coverage('I', &grid);
        for (i, cover) in cover.iter().enumerate() {
            let (x, y) = (i as i64 % 8, i as i64 / 8);
            let shade = linear_to_srgb8(*cover);
            assert_eq!(picture.get(2 + x, 2 + y), [shade, shade, shade, 255]);
        }
        let ink = |columns: std::ops::Range<i64>| {
            columns
                .flat_map(|x| (0..20).map(move |y| (x, y)))
                .filter(|&(x, y)| picture.get(x, y) != PAPER)
                .count()
        };
        assert!(ink(2..10) > 10 && ink(10..18) > 1);
        assert_eq!(ink(0..2) + ink(18..30), 0);
        // A character that the typeface lacks.
        let drawn = |text: &str| {
            let mut picture = Picture::new(8, 16, PAPER);
            picture.text(0, 0, 1, INK, text);
            picture
        };
        assert_eq!(drawn("\u{1F600}"), drawn("?"));
        assert_ne!(drawn("\u{1F600}"), drawn("!"));
        // Beyond the border nothing is written.
        Picture::new(3, 3, PAPER).text(-4, -9, 2, INK, "W");
    }

    /// On a clear ground letters have their own colour, and their coverage is the alpha.
    #[test]
    fn text_on_a_clear_ground_keeps_its_colour() {
        let mut picture = Picture::new(8, 16, [0; 4]);
        picture.text(0, 0, 1, [200, 40, 10, 255], "A");
        let inked: Vec<&[u8]> = picture.rgba().chunks(4).filter(|p| p[3] > 0).collect();
        assert!(inked.iter().all(|p| p[..3] == [200, 40, 10]));
        assert!(inked.iter().any(|p| p[3] < 255) && inked.len() > 10);
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
