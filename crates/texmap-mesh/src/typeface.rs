//! The built-in typeface: outlines of characters, and the share of each pixel that they cover.

use ttf_parser::{Face, OutlineBuilder};

/// A subset of JetBrains Mono Regular: ASCII, Latin-1, Greek and a few signs. Its licence is `typeface/OFL.txt`.
static BUILT_IN: &[u8] = include_bytes!("../typeface/JetBrainsMono-subset.ttf");

/// A typeface whose characters are all equally wide. Coverage is plain arithmetic: the same bits on every machine.
#[derive(Clone, Debug)]
pub struct Typeface {
    face: Face<'static>,
}

/// Most pixels of a grid: half a gigabyte of sums.
const MOST_PIXELS: u64 = 1 << 26;

/// A grid of pixels and where a character stands in it. Of the built-in typeface, a character is one step wide; capitals rise 1.217
/// steps above the base line, accents at most 1.66, and descenders fall 0.34 below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlyphGrid {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Left end of the character's base line, in pixels right of and below the grid's upper left corner.
    pub origin: [f32; 2],
    /// Pixels from a character to the next.
    pub step: f32,
}

impl Default for Typeface {
    fn default() -> Self {
        Self::built_in()
    }
}

impl Typeface {
    /// The one that texmap brings: a subset of JetBrains Mono Regular.
    #[must_use]
    pub fn built_in() -> Self {
        let face = Face::parse(BUILT_IN, 0).expect("the committed file is a typeface");
        Self { face }
    }

    /// True if it has the character.
    #[must_use]
    pub fn has(&self, character: char) -> bool {
        self.face.glyph_index(character).is_some()
    }

    /// The share of each pixel of a grid that a character covers, 0 to 1 in steps of 1/4096, row by row from the top: the area inside of
    /// the outline, its curves as chords. A missing character is drawn as `?`; what lies outside of the grid is cut. All pixels are 0 if
    /// a number of the grid is not finite, and there are none in a grid of more than 2^26.
    #[must_use]
    pub fn coverage(&self, character: char, grid: &GlyphGrid) -> Vec<f32> {
        if u64::from(grid.width) * u64::from(grid.height) > MOST_PIXELS {
            return Vec::new();
        }
        let mut area = Area::new(grid.width as usize, grid.height as usize);
        let glyph = self
            .face
            .glyph_index(character)
            .or_else(|| self.face.glyph_index('?'));
        let finite = grid.origin.iter().all(|v| v.is_finite()) && grid.step.is_finite();
        if let Some(glyph) = glyph.filter(|_| finite) {
            let advance = self.face.glyph_hor_advance(glyph).unwrap_or(1);
            let mut pen = Pen {
                area: &mut area,
                scale: f64::from(grid.step) / f64::from(advance.max(1)),
                origin: grid.origin.map(f64::from),
                first: [0.0; 2],
                last: [0.0; 2],
            };
            self.face.outline_glyph(glyph, &mut pen);
        }
        area.shares()
    }
}

/// Sums of signed areas: each edge adds to the pixels that it crosses the area right of it, and to all pixels further right its rise
/// (Levien, "Inside the fastest font renderer in the world", 2016).
struct Area {
    width: usize,
    height: usize,
    /// Differences along each row; two more columns take what lies at the right border.
    sums: Vec<f64>,
}

impl Area {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            sums: vec![0.0; (width + 2) * height],
        }
    }

    fn edge(&mut self, from: [f64; 2], to: [f64; 2]) {
        let (sign, top, bottom) = match from[1] < to[1] {
            true => (1.0, from, to),
            false => (-1.0, to, from),
        };
        let slope = (bottom[0] - top[0]) / (bottom[1] - top[1]);
        let last = bottom[1].min(self.height as f64);
        let mut y = top[1].max(0.0);
        while y < last {
            let row = y as usize;
            let next = (row as f64 + 1.0).min(last);
            let at = |y: f64| top[0] + (y - top[1]) * slope;
            self.span(row, [at(y), at(next)], sign * (next - y));
            y = next;
        }
    }

    /// An edge within a row that rises by `rise` (a share of the row, signed) while x goes from one value to the other.
    fn span(&mut self, row: usize, x: [f64; 2], rise: f64) {
        let (low, high) = (x[0].min(x[1]), x[0].max(x[1]));
        let right = self.width as f64;
        let sums = &mut self.sums[row * (self.width + 2)..][..self.width + 2];
        // Left of the grid an edge counts for whole rows, right of it for nothing.
        let per_pixel = rise / (high - low).max(f64::MIN_POSITIVE);
        let (start, end) = (low.clamp(0.0, right), high.clamp(0.0, right));
        if high <= 0.0 {
            sums[0] += rise;
            return;
        }
        if low < 0.0 {
            sums[0] += per_pixel * -low;
        }
        let (first, last) = (start as usize, end as usize);
        if first == last {
            let inside = if low < 0.0 || high > right {
                per_pixel * (end - start)
            } else {
                rise
            };
            add(sums, first, inside, 0.5 * (start + end));
            return;
        }
        for column in first..=last {
            let (a, b) = (start.max(column as f64), end.min(column as f64 + 1.0));
            add(sums, column, per_pixel * (b - a), 0.5 * (a + b));
        }
    }

    fn shares(self) -> Vec<f32> {
        let mut out = Vec::with_capacity(self.width * self.height);
        for row in self.sums.chunks(self.width + 2) {
            let mut sum = 0.0;
            for value in &row[..self.width] {
                sum += value;
                // Steps swallow what rounding leaves of edges that cancel.
                out.push(((sum.abs().min(1.0) * 4096.0 + 0.5) as u32) as f32 / 4096.0);
            }
        }
        out
    }
}

/// A rise within one column, at `x` in the mean: the part right of it is covered, all columns further right whole.
fn add(sums: &mut [f64], column: usize, rise: f64, x: f64) {
    let inside = rise * (column as f64 + 1.0 - x);
    sums[column] += inside;
    sums[column + 1] += rise - inside;
}

/// Walks along an outline.
struct Pen<'a> {
    area: &'a mut Area,
    /// Pixels a unit.
    scale: f64,
    /// Left end of the base line.
    origin: [f64; 2],
    first: [f64; 2],
    last: [f64; 2],
}

/// Chords of a curve: at 64 pixels a step they are less than a hundredth of a pixel off.
const CHORDS: u32 = 8;

impl Pen<'_> {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        let [left, base] = self.origin;
        [
            left + f64::from(x) * self.scale,
            base - f64::from(y) * self.scale,
        ]
    }

    fn go(&mut self, to: [f64; 2]) {
        self.area.edge(self.last, to);
        self.last = to;
    }

    /// A Bézier curve, by de Casteljau's steps.
    fn curve<const N: usize>(&mut self, points: [[f64; 2]; N]) {
        for i in 1..=CHORDS {
            let t = f64::from(i) / f64::from(CHORDS);
            let mut points = points;
            for left in (1..N).rev() {
                for k in 0..left {
                    points[k] = [0, 1].map(|d| (1.0 - t) * points[k][d] + t * points[k + 1][d]);
                }
            }
            self.go(points[0]);
        }
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.first = self.place(x, y);
        self.last = self.first;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.go(self.place(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.curve([self.last, self.place(x1, y1), self.place(x, y)]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.curve([
            self.last,
            self.place(x1, y1),
            self.place(x2, y2),
            self.place(x, y),
        ]);
    }

    fn close(&mut self) {
        self.go(self.first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws closed outlines.
    fn fill(width: usize, height: usize, outline: &[Vec<[f64; 2]>]) -> Vec<f32> {
        let mut area = Area::new(width, height);
        for contour in outline {
            for (i, from) in contour.iter().enumerate() {
                area.edge(*from, contour[(i + 1) % contour.len()]);
            }
        }
        area.shares()
    }

    #[test]
    fn the_pixels_of_a_polygon_sum_to_its_area() {
        // A triangle, and a square with a hole, at odd places; areas by the shoelace formula.
        for outline in [
            vec![vec![[1.3, 0.4], [8.7, 3.1], [2.2, 9.6]]],
            vec![
                vec![[0.5, 0.5], [0.5, 9.25], [9.75, 9.25], [9.75, 0.5]],
                vec![[3.1, 3.2], [7.3, 3.2], [7.3, 7.9], [3.1, 7.9]],
            ],
        ] {
            let mut expected = 0.0;
            for contour in &outline {
                for (i, from) in contour.iter().enumerate() {
                    let to = contour[(i + 1) % contour.len()];
                    expected += 0.5 * (from[0] * to[1] - to[0] * from[1]);
                }
            }
            let sum: f64 = fill(10, 10, &outline).iter().map(|v| f64::from(*v)).sum();
            assert!((sum - f64::abs(expected)).abs() < 0.01, "{sum} {expected}");
        }
    }

    /// A polygon that leaves a grid covers in it what the same polygon covers there in a larger one.
    #[test]
    fn borders_cut_and_change_nothing_inside() {
        let moved = |by: f64| -> Vec<Vec<[f64; 2]>> {
            let points = [[-3.7, 1.2], [7.9, -2.6], [9.3, 8.8], [2.1, 5.3]];
            vec![points.map(|[x, y]| [x + by, y + by]).to_vec()]
        };
        let (small, large) = (fill(5, 5, &moved(0.0)), fill(20, 20, &moved(6.0)));
        for (i, share) in small.iter().enumerate() {
            assert_eq!(*share, large[(6 + i / 5) * 20 + 6 + i % 5], "pixel {i}");
        }
        assert!(small.iter().any(|v| *v > 0.0 && *v < 1.0));
    }

    #[test]
    fn a_pixel_is_the_mean_of_a_larger_drawing() {
        let face = Typeface::built_in();
        let grid = |k: u32| GlyphGrid {
            width: 8 * k,
            height: 16 * k,
            origin: [0.0, (13 * k) as f32],
            step: (8 * k) as f32,
        };
        for character in ['A', 'g', '8', '@', 'ß'] {
            let small = face.coverage(character, &grid(1));
            let large = face.coverage(character, &grid(16));
            for (i, value) in small.iter().enumerate() {
                let (x, y) = (i % 8 * 16, i / 8 * 16);
                let cells = (0..256).map(|k| large[(y + k / 16) * 128 + x + k % 16]);
                let mean = cells.sum::<f32>() / 256.0;
                assert!(
                    (value - mean).abs() < 0.001,
                    "{character} {i}: {value} {mean}"
                );
            }
        }
    }

    #[test]
    fn characters_stand_where_the_grid_says_and_missing_ones_are_question_marks() {
        let face = Typeface::built_in();
        let grid = GlyphGrid {
            width: 14,
            height: 22,
            origin: [3.0, 16.0],
            step: 8.0,
        };
        for character in (' '..='~').chain('\u{a0}'..='ÿ') {
            assert!(face.has(character), "{character}");
            let cover = face.coverage(character, &grid);
            let inside = |i: usize| (3..11).contains(&(i % 14)) && (2..19).contains(&(i / 14));
            assert!(
                (0..cover.len()).all(|i| inside(i) || cover[i] == 0.0),
                "{character}"
            );
            let ink: f32 = cover.iter().sum();
            assert_eq!(ink > 1.0, !character.is_whitespace(), "{character}: {ink}");
        }
        assert!(!face.has('漢'));
        assert_eq!(face.coverage('漢', &grid), face.coverage('?', &grid));
        let broken = GlyphGrid {
            step: f32::NAN,
            ..grid
        };
        assert!(face.coverage('A', &broken).iter().all(|v| *v == 0.0));
        let large = GlyphGrid {
            width: u32::MAX,
            height: u32::MAX,
            ..grid
        };
        assert_eq!(face.coverage('A', &large), []);
    }
}
