//! The least and the largest depth around each patch of a shadow map: most look-ups are decided by those two, without the comparisons.

use alloc::vec::Vec;

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*, u32x16};
use texmap_math::lanes::{Words, gather};

/// log2 of a patch's side in texels.
const SHIFT: u32 = 3;
const SIDE: usize = 1 << SHIFT;
/// Columns that are taken at a time.
const PART: usize = 32;

/// Bounds of a map of one face.
#[derive(Clone, Debug)]
pub(crate) struct Bounds {
    /// Least and largest depth of each patch, row by row.
    pairs: Vec<[f32; 2]>,
    /// Patches a row.
    across: i32,
}

impl Bounds {
    /// Of `size` x `size` depths, over the patches and `radius` texels beyond them; texels beyond the map count as infinite.
    pub(crate) fn new(depths: &[f32], size: usize, radius: usize) -> Self {
        let across = size.div_ceil(SIDE);
        let mut pairs = Vec::with_capacity(across * across);
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for row in 0..across {
            let first = (row * SIDE).saturating_sub(radius);
            let end = ((row + 1) * SIDE + radius).min(size);
            low.clear();
            high.clear();
            for x in (0..size).step_by(PART) {
                let part = PART.min(size - x);
                let (mut least, mut most) = ([f32::INFINITY; PART], [f32::NEG_INFINITY; PART]);
                for y in first..end {
                    let row = &depths[y * size + x..][..part];
                    for ((least, most), depth) in least.iter_mut().zip(&mut most).zip(row) {
                        *least = lesser(*least, *depth);
                        *most = larger(*most, *depth);
                    }
                }
                low.extend_from_slice(&least[..part]);
                high.extend_from_slice(&most[..part]);
            }
            let beyond = |row: usize| row * SIDE < radius || (row + 1) * SIDE + radius > size;
            for column in 0..across {
                let first = (column * SIDE).saturating_sub(radius);
                let end = ((column + 1) * SIDE + radius).min(size);
                let least = low[first..end]
                    .iter()
                    .fold(f32::INFINITY, |a, b| lesser(a, *b));
                let most = high[first..end]
                    .iter()
                    .fold(f32::NEG_INFINITY, |a, b| larger(a, *b));
                let open = beyond(row) || beyond(column);
                pairs.push([least, if open { f32::INFINITY } else { most }]);
            }
        }
        Self {
            pairs,
            across: across as i32,
        }
    }

    /// The least and the largest depth around sixteen texels of the map.
    #[inline(always)]
    pub(crate) fn around<S: Simd>(&self, s: S, x: i32x16<S>, y: i32x16<S>) -> [f32x16<S>; 2] {
        let Some(words) = Words::new(bytemuck::cast_slice(self.pairs.as_flattened())) else {
            return [
                f32x16::splat(s, f32::NEG_INFINITY),
                f32x16::splat(s, f32::INFINITY),
            ];
        };
        let patch = (y >> SHIFT) * self.across + (x >> SHIFT);
        let at: u32x16<S> = (patch << 1).bitcast();
        [
            gather(s, words, at).bitcast(),
            gather(s, words, at + 1).bitcast(),
        ]
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
            let bounds = Bounds::new(&all.collect::<Vec<_>>(), size, radius);
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
}
