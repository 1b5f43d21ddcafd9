//! The least and the largest depth around each patch of a shadow map: most look-ups are decided by those two, without the comparisons.

use alloc::vec::Vec;
use core::ops::Range;

use texmap_math::dispatch_simd;
use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::level;

/// log2 of a patch's side in texels.
const SHIFT: u32 = 3;
const SIDE: usize = 1 << SHIFT;
/// Columns that are taken at a time.
const PART: usize = 32;

/// Bounds of the faces of a map: of each patch and `radius` texels beyond it; texels beyond a face count as infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowBounds {
    /// Least and largest depth of each patch, face by face, row by row.
    pairs: Vec<[f32; 2]>,
    /// Patches a row, and rows a face.
    across: i32,
    radius: usize,
}

/// Bounds of some rows of a map, a multiple of eight but for its last rows.
#[derive(Clone, Debug)]
pub struct StripBounds {
    first_row: usize,
    /// Least and largest depth of each patch, as far as the strip reaches.
    pairs: Vec<[f32; 2]>,
    /// Bounds of its first and last rows, for the patches above and below.
    ends: [Vec<[f32; 2]>; 2],
    radius: usize,
    across: usize,
}

/// Columns of depths that a strip knows to be infinite, or not.
#[derive(Clone, Copy, Debug)]
pub struct FiniteColumns<'a> {
    /// True for the parts of a row in which some depth may be finite.
    pub parts: &'a [bool],
    /// Columns a part, a multiple of 32.
    pub side: usize,
}

impl FiniteColumns<'_> {
    fn any(&self, columns: Range<usize>) -> bool {
        let parts = columns.start / self.side..columns.end.div_ceil(self.side);
        self.parts[parts].contains(&true)
    }
}

/// Texels that a filter of `taps` x `taps` reads beyond its middle.
pub(crate) fn radius(taps: u32) -> usize {
    taps.min(15) as usize / 2
}

impl StripBounds {
    /// Bounds of the rows from `first_row` on of a map of `size` columns. Look-ups take `taps` x `taps` comparisons.
    #[must_use]
    pub fn new(
        rows: &[f32],
        size: usize,
        taps: u32,
        first_row: usize,
        reached: FiniteColumns<'_>,
    ) -> Self {
        dispatch_simd!(level(), i => Self::of_rows(i, rows, size, taps, first_row, reached))
    }

    #[inline(always)]
    fn of_rows<I: Isa>(
        i: I,
        rows: &[f32],
        size: usize,
        taps: u32,
        first_row: usize,
        reached: FiniteColumns<'_>,
    ) -> Self {
        let radius = radius(taps);
        let (across, height) = (size.div_ceil(SIDE), rows.len() / size);
        let mut strip = Self {
            first_row,
            pairs: Vec::with_capacity(across * height.div_ceil(SIDE)),
            ends: [Vec::with_capacity(across), Vec::with_capacity(across)],
            radius,
            across,
        };
        let mut scan = Scan::new(size, radius, reached);
        for row in (0..height).step_by(SIDE) {
            let part = row.saturating_sub(radius)..(row + SIDE + radius).min(height);
            scan.patches(i, rows, part, &mut strip.pairs);
            let whole = first_row + row;
            if whole < radius || whole + SIDE + radius > size {
                let last = strip.pairs.len() - across;
                strip.pairs[last..]
                    .iter_mut()
                    .for_each(|pair| pair[1] = f32::INFINITY);
            }
        }
        if radius > 0 {
            let [above, below] = &mut strip.ends;
            scan.patches(i, rows, 0..radius.min(height), above);
            scan.patches(i, rows, height.saturating_sub(radius)..height, below);
        }
        strip
    }
}

/// Rows on their way to bounds.
struct Scan<'a> {
    size: usize,
    radius: usize,
    reached: FiniteColumns<'a>,
    /// Least and largest depth of each column.
    low: Vec<f32>,
    high: Vec<f32>,
}

impl<'a> Scan<'a> {
    fn new(size: usize, radius: usize, reached: FiniteColumns<'a>) -> Self {
        Self {
            size,
            radius,
            reached,
            low: alloc::vec![f32::INFINITY; size],
            high: alloc::vec![f32::INFINITY; size],
        }
    }

    /// Bounds of the patches across the map over some rows.
    #[inline(always)]
    fn patches<I: Isa>(&mut self, i: I, rows: &[f32], part: Range<usize>, out: &mut Vec<[f32; 2]>) {
        let size = self.size;
        let rows = &rows[part.start * size..part.end * size];
        for x in (0..size).step_by(PART) {
            let columns = x..size.min(x + PART);
            // The other columns stay infinite.
            if self.reached.any(columns.clone()) {
                if size < I::LANES {
                    self.columns(Scalar, rows, columns);
                } else {
                    self.columns(i, rows, columns);
                }
            }
        }
        for x in (0..size).step_by(SIDE) {
            let columns = x.saturating_sub(self.radius)..(x + SIDE + self.radius).min(size);
            let mut pair = [f32::INFINITY; 2];
            if self.reached.any(columns.clone()) {
                let (low, high) = (&self.low[columns.clone()], &self.high[columns]);
                let least = low.iter().fold(f32::INFINITY, |a, b| lesser(a, *b));
                let most = high.iter().fold(f32::NEG_INFINITY, |a, b| larger(a, *b));
                let open = x < self.radius || x + SIDE + self.radius > size;
                pair = [least, if open { f32::INFINITY } else { most }];
            }
            out.push(pair);
        }
    }

    /// Bounds of each of some columns over rows, of which there are as many as there are lanes at least.
    #[inline(always)]
    fn columns<I: Isa>(&mut self, i: I, rows: &[f32], columns: Range<usize>) {
        for x in columns.step_by(I::LANES) {
            // The last vector may overlap the one before.
            let lanes = x.min(self.size - I::LANES);
            let lanes = lanes..lanes + I::LANES;
            let (mut least, mut most) = (i.f32(f32::INFINITY), i.f32(f32::NEG_INFINITY));
            for row in rows.chunks_exact(self.size) {
                let depth = i.load_f32(&row[lanes.clone()]);
                least = depth.below(least);
                most = depth.above(most);
            }
            least.store(&mut self.low[lanes.clone()]);
            most.store(&mut self.high[lanes]);
        }
    }
}

impl ShadowBounds {
    /// Bounds of the faces of a map.
    pub(crate) fn new(depths: &[f32], size: usize, taps: u32) -> Self {
        if size == 0 {
            return Self::join([]);
        }
        let reached = FiniteColumns {
            parts: &[true],
            side: size.next_multiple_of(PART),
        };
        let faces = depths.chunks_exact(size * size);
        let face = |rows| Self::join([StripBounds::new(rows, size, taps, 0, reached)]);
        Self::of_faces(faces.map(face))
    }

    /// `found`, if they fit such a map, else those of its depths.
    pub(crate) fn fitting(found: Option<Self>, depths: &[f32], size: usize, taps: u32) -> Self {
        let faces = depths.len() / (size * size).max(1);
        let found = found.filter(|bounds| bounds.fits(faces, size, taps));
        found.unwrap_or_else(|| Self::new(depths, size, taps))
    }

    /// Bounds of a map from those of its faces, in order.
    #[must_use]
    pub fn of_faces(faces: impl IntoIterator<Item = Self>) -> Self {
        let mut faces = faces.into_iter();
        let Some(mut all) = faces.next() else {
            return Self::join([]);
        };
        faces.for_each(|face| all.pairs.extend(face.pairs));
        all
    }

    /// Bounds of a face from those of its strips, in any order.
    #[must_use]
    pub fn join(strips: impl Into<Vec<StripBounds>>) -> Self {
        let mut strips: Vec<StripBounds> = strips.into();
        strips.sort_by_key(|strip| strip.first_row);
        for i in 1..strips.len() {
            let (upper, lower) = strips.split_at_mut(i);
            if let (Some(upper), Some(lower)) = (upper.last_mut(), lower.first_mut()) {
                let last = upper.pairs.len() - upper.across;
                widen(&mut upper.pairs[last..], &lower.ends[0]);
                widen(&mut lower.pairs[..upper.across], &upper.ends[1]);
            }
        }
        let (across, radius) = strips.first().map_or((0, 0), |s| (s.across, s.radius));
        let mut pairs = Vec::with_capacity(across * across);
        strips
            .iter()
            .for_each(|strip| pairs.extend_from_slice(&strip.pairs));
        Self {
            pairs,
            across: across as i32,
            radius,
        }
    }

    /// True if these are bounds for `faces` of `size` and filters of `taps` x `taps`.
    fn fits(&self, faces: usize, size: usize, taps: u32) -> bool {
        let across = size.div_ceil(SIDE);
        self.pairs.len() == faces * across * across && self.radius == radius(taps)
    }

    /// The least and the largest depth around texels of faces.
    #[inline(always)]
    pub(crate) fn around<I: Isa>(&self, i: I, face: I::I32, x: I::I32, y: I::I32) -> [I::F32; 2] {
        let Some(words) = GatherTable::new(bytemuck::cast_slice(self.pairs.as_flattened())) else {
            return [i.f32(f32::NEG_INFINITY), i.f32(f32::INFINITY)];
        };
        let row = face * self.across + (y >> SHIFT);
        let patch = row * self.across + (x >> SHIFT);
        let [least, most] = i.gather_pairs(words, (patch << 1).to_u32());
        [least.to_f32_bits(), most.to_f32_bits()]
    }
}

fn widen(pairs: &mut [[f32; 2]], by: &[[f32; 2]]) {
    for (pair, by) in pairs.iter_mut().zip(by) {
        *pair = [lesser(pair[0], by[0]), larger(pair[1], by[1])];
    }
}

/// One instruction each, unlike the functions of f32, which tell NaN apart.
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_every_depth_that_a_look_up_compares() {
        for (size, radius) in [(1, 0), (7, 1), (16, 0), (45, 2), (64, 7)] {
            let depth = |x: usize, y: usize| ((x * 37 + y * 101) % 89) as f32;
            let all = (0..size * size).map(|i| depth(i % size, i / size));
            let bounds = ShadowBounds::new(&all.collect::<Vec<_>>(), size, 2 * radius as u32 + 1);
            let mut tight = 0;
            for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
                let patch = (y / SIDE) * bounds.across as usize + x / SIDE;
                let [low, high] = bounds.pairs[patch];
                tight += u32::from(high < 89.0 && low >= 0.0);
                for (i, j) in (0..=2 * radius).flat_map(|j| (0..=2 * radius).map(move |i| (i, j))) {
                    let inside =
                        |c: usize, k: usize| (c + k).checked_sub(radius).filter(|c| *c < size);
                    match (inside(x, i), inside(y, j)) {
                        (Some(x), Some(y)) => assert!((low..=high).contains(&depth(x, y))),
                        _ => assert_eq!(high, f32::INFINITY, "{size} {radius} {x} {y}"),
                    }
                }
            }
            assert!(tight > 0 || size < 3 * SIDE, "{size} {radius}");
        }
    }

    /// Strips in any number and order give the bounds of a scan of the whole map. They may leave columns out.
    #[test]
    fn strips_join_to_the_bounds_of_the_whole() {
        let mut left_out = 0;
        for (size, taps, high) in [
            (64, 3, 64),
            (129, 15, 64),
            (200, 5, 8),
            (192, 1, 32),
            (70, 15, 64),
        ] {
            // A disc in an empty map.
            let depth = |x: usize, y: usize| {
                let (dx, dy) = (x as f32 - 90.0, y as f32 - 60.0);
                let inside = dx * dx + dy * dy < 1_400.0;
                if inside {
                    ((x * 37 + y * 101) % 89) as f32
                } else {
                    f32::INFINITY
                }
            };
            let all: Vec<f32> = (0..size * size)
                .map(|i| depth(i % size, i / size))
                .collect();
            let whole = ShadowBounds::new(&all, size, taps);
            let mut strips = Vec::new();
            for (i, rows) in all.chunks(high * size).enumerate() {
                let columns = |part: usize| part * 32..size.min(part * 32 + 32);
                let met = |part: usize| {
                    let mut rows = rows.chunks(size);
                    rows.any(|row| row[columns(part)].iter().any(|d| d.is_finite()))
                };
                let parts: Vec<bool> = (0..size.div_ceil(32)).map(met).collect();
                left_out += parts.iter().filter(|met| !**met).count();
                let reached = FiniteColumns {
                    parts: &parts,
                    side: 32,
                };
                strips.push(StripBounds::new(rows, size, taps, i * high, reached));
            }
            strips.reverse();
            let joined = ShadowBounds::join(strips);
            assert_eq!(joined.pairs, whole.pairs, "{size} {taps} {high}");
            assert!(joined.fits(1, size, taps) && !joined.fits(1, size + 8, taps));
            assert!(!joined.fits(1, size, taps + 2) || taps == 15);
        }
        assert!(left_out > 20, "{left_out}");
    }
}
