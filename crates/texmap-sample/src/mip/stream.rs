//! Mip chains row by row, where each texel of a level depends on few above it.

use super::{Reduce, owned, row::Row, tap_count, taps, texels};
use crate::encoded::Encoded;
use crate::texel_data::{Chain, Level, Words};
use alloc::{sync::Arc, vec::Vec};
use texmap_math::{Level as SimdLevel, dispatch_simd, simd::Isa};

/// The chain by means or by unit vectors. All levels grow together, so that beside the chain itself no more than three rows a level
/// are held.
pub(super) fn stream(level: SimdLevel, base: Chain<'_>, reduce: Reduce) -> Chain<'static> {
    let first = base.levels[0];
    let Chain {
        words,
        encoded,
        format,
        flip,
        opaque,
        sums,
        ..
    } = base;
    let mut words = owned(words);
    let base_words = match &encoded {
        Some(_) => 0,
        None => texels(&first) * format.words(),
    };
    words.truncate(base_words);
    let mut levels = Vec::from([first]);
    let mut total = base_words;
    let mut size = first;
    while size.width > 1 || size.height > 1 {
        size = Level {
            offset: total,
            width: (size.width / 2).max(1),
            height: (size.height / 2).max(1),
            depth: size.depth,
        };
        total += texels(&size) * format.words();
        levels.push(size);
    }
    words.reserve_exact(total - base_words);
    words.resize(total, 0);
    let (source, rest) = words.split_at_mut(base_words);
    let pairs = levels.windows(2);
    let mut pending: Vec<Pending> = pairs.map(|pair| Pending::new(pair[0], pair[1])).collect();
    let mut last = Row::new(1);
    let normals = reduce == Reduce::Normals;
    for z in 0..first.depth {
        pending.iter_mut().for_each(|level| level.row = 0);
        for y in 0..first.height {
            let Some(top) = pending.first_mut() else {
                break;
            };
            let row = top.source(y);
            match &encoded {
                Some(encoded) => (0..first.width)
                    .for_each(|x| row.set(x as usize, encoded.base_texel(first.width, x, y))),
                None => {
                    let start = (z * first.height + y) as usize * first.width as usize;
                    let end = start + first.width as usize;
                    let words = &source[start * format.words()..end * format.words()];
                    dispatch_simd!(level, i => row.load(i, format, words));
                }
            }
            let mut at = y;
            let mut waiting = &mut pending[..];
            while let Some((above, below)) = waiting.split_first_mut() {
                let Some(done) = above.completed_by(at) else {
                    break;
                };
                let row = match below.first_mut() {
                    Some(next) => next.source(done),
                    None => &mut last,
                };
                let next = &above.next;
                let rows = (z * next.height + done) as usize * next.width as usize;
                let start = next.offset - base_words + rows * format.words();
                let words = &mut rest[start..start + next.width as usize * format.words()];
                dispatch_simd!(level, i => {
                    above.reduce(i, row);
                    row.store(i, format, normals, words);
                });
                above.row += 1;
                (at, waiting) = (done, below);
            }
        }
    }
    let encoded = match encoded {
        Some(Encoded::Blocks(blocks)) => {
            let blocks = blocks.base(&first);
            words = blocks.append(&mut levels, &words);
            Some(Encoded::Blocks(blocks))
        }
        encoded => encoded,
    };
    Chain {
        words: Words::Owned(Arc::new(words)),
        encoded,
        format,
        levels,
        flip,
        opaque,
        sums,
    }
}

/// A level that waits for rows of the level above.
struct Pending {
    above: Level,
    next: Level,
    /// The row to come.
    row: i32,
    /// Row y of the level above stands at index y modulo 3. Floats, so that rounding does not add up
    /// along the chain.
    rows: [Row; 3],
    /// The weights of each row's texels: one, two or three for a texel of the next.
    weights: Vec<Vec<f64>>,
}

impl Pending {
    fn new(above: Level, next: Level) -> Self {
        let row = Row::new(above.width);
        // As long as whole vectors of lanes want it.
        let texels = 0..(next.width as usize).next_multiple_of(16) as i32;
        let weight = |k: usize| texels.clone().map(|x| taps(x, above.width).1[k]).collect();
        Self {
            above,
            next,
            row: 0,
            rows: [row.clone(), row.clone(), row],
            weights: (0..tap_count(above.width)).map(weight).collect(),
        }
    }

    /// The place of row `y` of the level above.
    fn source(&mut self, y: i32) -> &mut Row {
        &mut self.rows[(y % 3) as usize]
    }

    /// The row of this level whose last source is row `y` of the level above.
    fn completed_by(&self, y: i32) -> Option<i32> {
        let (y0, _) = taps(self.row, self.above.height);
        let count = tap_count(self.above.height) as i32;
        (self.row < self.next.height && y + 1 >= y0 + count).then_some(self.row)
    }

    /// The row to come, whose sources are there.
    #[inline(always)]
    fn reduce<I: Isa>(&self, i: I, reduced: &mut Row) {
        let (y0, wy) = taps(self.row, self.above.height);
        let count = tap_count(self.above.height);
        let [a, b, c] = [y0, y0 + 1, y0 + 2].map(|y| &self.rows[(y % 3) as usize]);
        reduced.reduce(i, &[a, b, c], &wy[..count], &self.weights);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mip::halve;
    use crate::texel_data::Format;
    use alloc::vec;

    const FORMATS: [Format; 4] = [Format::Rgba8, Format::Rgba16, Format::Rgba32, Format::R32];

    fn base(format: Format, width: i32, height: i32) -> Chain<'static> {
        let count = (width * height) as usize * format.words();
        let words = (0..count as u32).map(|i| {
            let h = i.wrapping_mul(0x9e37_79b1) ^ (i >> 3);
            match format {
                Format::Rgba8 | Format::Rgba16 => h ^ h >> 13,
                _ => ((h % 2003) as f32 * 0.37 - 300.0).to_bits(),
            }
        });
        Chain {
            words: Words::Owned(Arc::new(words.collect())),
            encoded: None,
            format,
            levels: vec![Level {
                offset: 0,
                width,
                height,
                depth: 1,
            }],
            flip: false,
            opaque: false,
            sums: None,
        }
    }

    /// The levels by their definition, each as a whole.
    fn by_definition(base: &Chain<'_>) -> Vec<u32> {
        let (format, mut size) = (base.format, base.levels[0]);
        let mut words = base.words().to_vec();
        let mut current: Vec<[f32; 4]> = (0..words.len() / format.words())
            .map(|i| format.fetch(&words, i * format.words()))
            .collect();
        while size.width > 1 || size.height > 1 {
            let next = Level {
                width: (size.width / 2).max(1),
                height: (size.height / 2).max(1),
                ..size
            };
            current = halve(&size, &next, false, |at| current[at]);
            current.iter().for_each(|&c| format.push(&mut words, c));
            size = next;
        }
        words
    }

    #[test]
    fn rows_have_the_bits_of_whole_levels() {
        for format in FORMATS {
            for (width, height) in [
                (1, 1),
                (64, 64),
                (66, 35),
                (33, 17),
                (5, 3),
                (1, 37),
                (100, 1),
                (2, 130),
            ] {
                let expected = by_definition(&base(format, width, height));
                for level in [SimdLevel::new(), SimdLevel::baseline()] {
                    let chain = stream(level, base(format, width, height), Reduce::Mean);
                    assert!(
                        *chain.words() == expected,
                        "{format:?} {width} x {height} on {level:?}"
                    );
                }
            }
        }
    }

    #[inline(always)]
    fn one_row<I: Isa>(i: I, format: Format, words: &[u32], width: i32) -> Vec<u32> {
        let size = |width| Level {
            offset: 0,
            width,
            height: 2,
            depth: 1,
        };
        let next = size((width / 2).max(1));
        let mut pending = Pending::new(size(width), next);
        for y in 0..2 {
            pending.source(y).load(i, format, words);
        }
        let mut reduced = Row::new(next.width);
        pending.reduce(i, &mut reduced);
        let mut stored = vec![0; 2 * next.width as usize * format.words()];
        let (means, normals) = stored.split_at_mut(next.width as usize * format.words());
        reduced.store(i, format, false, means);
        reduced.store(i, format, true, normals);
        stored
    }

    #[test]
    fn widths_agree() {
        for format in FORMATS {
            for width in [1, 2, 31, 32, 70, 129] {
                let base = base(format, width, 1);
                let words = base.words();
                let expected = one_row(texmap_math::simd::Scalar, format, words, width);
                for level in [SimdLevel::new(), SimdLevel::baseline()] {
                    let found = dispatch_simd!(level, i => one_row(i, format, words, width));
                    assert_eq!(found, expected, "{format:?} {width} on {level:?}");
                }
            }
        }
    }

    /// Unit vectors of a level are of length one to half a step of their format; opposite ones and ones too long to be squared have a direction.
    #[test]
    fn normals_are_unit_vectors() {
        let length = |words: &[u32], format: Format| {
            let [x, y, z, _] = format.fetch(words, 0);
            let [x, y, z] = [x, y, z].map(|c| 2.0 * f64::from(c / format.units()) - 1.0);
            (x * x + y * y + z * z).sqrt()
        };
        let normals = |texels: [[f32; 4]; 2], format: Format| {
            let mut chain = base(format, 2, 1);
            let mut words = Vec::new();
            texels.iter().for_each(|&c| format.push(&mut words, c));
            chain.words = Words::Owned(Arc::new(words));
            let chain = stream(SimdLevel::new(), chain, Reduce::Normals);
            chain.words()[2 * format.words()..].to_vec()
        };
        let tilted = normals(
            [[65535.0, 40000.0, 50000.0, 9.0], [30000.0; 4]],
            Format::Rgba16,
        );
        assert!((length(&tilted, Format::Rgba16) - 1.0).abs() < 3e-5);
        let opposite = normals([[1.0, 0.5, 0.5, 1.0], [0.0, 0.5, 0.5, 1.0]], Format::Rgba32);
        assert_eq!(Format::Rgba32.fetch(&opposite, 0), [0.5, 0.5, 1.0, 1.0]);
        let long = normals([[1e30, 1e30, 0.5, 1.0]; 2], Format::Rgba32);
        assert!((length(&long, Format::Rgba32) - 1.0).abs() < 1e-6);
    }
}
