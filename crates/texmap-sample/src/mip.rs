//! Mip chains.

use crate::encoded::Encoded;
use crate::texel_data::{Chain, Format, Level, Words};
use alloc::{sync::Arc, vec::Vec};
use texmap_math::float::sqrt_f32;

/// Property of the base that a level keeps besides the area-weighted mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reduce {
    Mean,
    /// Unit vectors stored as (n + 1) / 2.
    Normals,
    /// The share of texels whose alpha passes this threshold.
    Coverage(f32),
    /// The mean over three axes: the slices of a volume halve too.
    Volume,
}

/// The chain of the base level down to one texel. Sides halve rounding down; a side of odd length n
/// becomes m = (n - 1) / 2 texels that each cover n / m texels, so that three texels with weights
/// (m - i, m, i + 1) / n make one and the mean of every level is the mean of the base (the
/// polyphase box of Guthe and Heckbert, "Non-power-of-two mipmapping", 2005).
pub(crate) fn build(base: Chain<'_>, reduce: Reduce) -> Chain<'static> {
    if matches!(reduce, Reduce::Mean | Reduce::Normals) {
        return stream(base, reduce);
    }
    let first = Level {
        offset: 0,
        ..base.levels[0]
    };
    let format = base.format;
    let Chain {
        flip, mut opaque, ..
    } = base;
    let sums = base.sums.clone();
    let mut words = decoded(base);
    let share = match reduce {
        Reduce::Coverage(threshold) => {
            coverage(&base_alpha(&words, format), threshold * format.units())
        }
        _ => 0.0,
    };
    let mut levels = Vec::from([first]);
    // The working copy stays in floats, so that rounding does not add up along the chain.
    let mut current: Vec<[f32; 4]> = Vec::new();
    let mut size = first;
    let volume = reduce == Reduce::Volume;
    while size.width > 1 || size.height > 1 || (volume && size.depth > 1) {
        let next = Level {
            offset: words.len(),
            width: (size.width / 2).max(1),
            height: (size.height / 2).max(1),
            depth: if volume {
                (size.depth / 2).max(1)
            } else {
                size.depth
            },
        };
        let reduced = {
            let above = |at: usize| {
                if current.is_empty() {
                    format.fetch(&words, at * format.words())
                } else {
                    current[at]
                }
            };
            halve(&size, &next, volume, above)
        };
        match reduce {
            Reduce::Coverage(threshold) => {
                let scale =
                    coverage_scale(&reduced, share, threshold * format.units(), format.units());
                let most = format.units();
                for &c in &reduced {
                    // Premultiplied: colour follows alpha, and alpha ends at one.
                    let k = if c[3] * scale > most {
                        most / c[3]
                    } else {
                        scale
                    };
                    let c = c.map(|x| x * k);
                    opaque &= c[3] >= most;
                    format.push(&mut words, c);
                }
            }
            _ => {
                reduced.iter().for_each(|&c| format.push(&mut words, c));
            }
        }
        current = reduced;
        levels.push(next);
        size = next;
    }
    Chain {
        words: Words::Owned(Arc::new(words)),
        encoded: None,
        format,
        levels,
        flip,
        opaque,
        sums,
    }
}

/// The words of level 0.
fn decoded(base: Chain<'_>) -> Vec<u32> {
    let (count, format) = (texels(&base.levels[0]), base.format);
    let mut words = owned(base.words);
    if base.encoded.is_some() {
        words.clear();
    }
    match base.encoded {
        Some(encoded) => {
            let Level { width, height, .. } = base.levels[0];
            for y in 0..height {
                (0..width).for_each(|x| format.push(&mut words, encoded.base_texel(width, x, y)));
            }
        }
        None => words.truncate(count * format.words()),
    }
    words
}

/// The words themselves if nobody else holds them, else a copy.
fn owned(words: Words<'_>) -> Vec<u32> {
    match words {
        Words::Owned(w) => Arc::try_unwrap(w).unwrap_or_else(|w| w.to_vec()),
        Words::Borrowed(w) => w.to_vec(),
    }
}

/// [`build`] where each texel of a level depends on few above it. All levels grow together, row by row,
/// so that beside the chain itself no more than three rows a level are held.
fn stream(base: Chain<'_>, reduce: Reduce) -> Chain<'static> {
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
    let mut packed = Vec::with_capacity(first.width as usize * format.words());
    for z in 0..first.depth {
        let mut pending: Vec<Pending> = levels
            .windows(2)
            .map(|pair| Pending::new(pair[0], pair[1]))
            .collect();
        for y in 0..first.height {
            let start = (z * first.height + y) as usize * first.width as usize;
            let end = start + first.width as usize;
            let mut row: Vec<[f32; 4]> = match &encoded {
                Some(encoded) => (0..first.width)
                    .map(|x| encoded.base_texel(first.width, x, y))
                    .collect(),
                None => format.fetch_row(&source[start * format.words()..end * format.words()]),
            };
            let mut at = y;
            for level in &mut pending {
                let Some((done, reduced)) = level.feed(at, row) else {
                    break;
                };
                packed.clear();
                match reduce {
                    Reduce::Normals => {
                        let units = format.units();
                        let unit = reduced.iter().map(|c| normalized(*c, units));
                        format.push_row(&mut packed, &unit.collect::<Vec<_>>());
                    }
                    _ => format.push_row(&mut packed, &reduced),
                }
                let next = &level.next;
                let rows = (z * next.height + done) as usize * next.width as usize;
                let start = next.offset - base_words + rows * format.words();
                rest[start..start + packed.len()].copy_from_slice(&packed);
                (at, row) = (done, reduced);
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
    rows: [Vec<[f32; 4]>; 3],
}

impl Pending {
    fn new(above: Level, next: Level) -> Self {
        Self {
            above,
            next,
            row: 0,
            rows: [const { Vec::new() }; 3],
        }
    }

    /// Takes row `y` of the level above; gives a row of this level when its last source has come.
    fn feed(&mut self, y: i32, row: Vec<[f32; 4]>) -> Option<(i32, Vec<[f32; 4]>)> {
        self.rows[(y % 3) as usize] = row;
        let (y0, wy) = taps(self.row, self.above.height);
        let count = wy.iter().filter(|w| **w > 0.0).count() as i32;
        if self.row >= self.next.height || y + 1 < y0 + count {
            return None;
        }
        let reduced = match (self.above.width % 2, self.above.height % 2) {
            (0, 0) => {
                let [upper, lower] =
                    [y0, y0 + 1].map(|j| self.rows[(j % 3) as usize].as_chunks().0);
                let blocks = upper.iter().zip(lower);
                blocks.map(|([a, b], [c, d])| mean(a, b, c, d)).collect()
            }
            _ => self.weighted(y0, wy),
        };
        self.row += 1;
        Some((self.row - 1, reduced))
    }

    /// A row of sides of any length.
    fn weighted(&self, y0: i32, wy: [f64; 3]) -> Vec<[f32; 4]> {
        (0..self.next.width)
            .map(|x| {
                let (x0, wx) = taps(x, self.above.width);
                let mut sum = [0.0_f64; 4];
                for (j, wy) in (y0..).zip(wy).filter(|(_, w)| *w > 0.0) {
                    let row = &self.rows[(j % 3) as usize];
                    for (i, wx) in (x0..).zip(wx).filter(|(_, w)| *w > 0.0) {
                        for (s, c) in sum.iter_mut().zip(row[i as usize]) {
                            *s += wx * wy * f64::from(c);
                        }
                    }
                }
                sum.map(|s| s as f32)
            })
            .collect()
    }
}

/// The mean of four texels: the weighted sum with weights of a quarter, which are exact and may come last.
#[inline(always)]
fn mean(a: &[f32; 4], b: &[f32; 4], c: &[f32; 4], d: &[f32; 4]) -> [f32; 4] {
    let mut mean = [0.0; 4];
    for k in 0..4 {
        let [a, b, c, d] = [a[k], b[k], c[k], d[k]].map(f64::from);
        mean[k] = ((0.0 + a + b + c + d) * 0.25) as f32;
    }
    mean
}

fn halve(
    size: &Level,
    next: &Level,
    volume: bool,
    above: impl Fn(usize) -> [f32; 4],
) -> Vec<[f32; 4]> {
    let mut reduced = Vec::with_capacity(texels(next));
    for z in 0..next.depth {
        let (z0, wz) = if volume {
            taps(z, size.depth)
        } else {
            (z, [1.0, 0.0, 0.0])
        };
        for y in 0..next.height {
            let (y0, wy) = taps(y, size.height);
            for x in 0..next.width {
                let (x0, wx) = taps(x, size.width);
                let mut sum = [0.0_f64; 4];
                for (k, wz) in (z0..).zip(wz).filter(|(_, w)| *w > 0.0) {
                    for (j, wy) in (y0..).zip(wy).filter(|(_, w)| *w > 0.0) {
                        let row =
                            (k as usize * size.height as usize + j as usize) * size.width as usize;
                        for (i, wx) in (x0..).zip(wx).filter(|(_, w)| *w > 0.0) {
                            let c = above(row + i as usize);
                            for (s, c) in sum.iter_mut().zip(c) {
                                *s += wx * wy * wz * f64::from(c);
                            }
                        }
                    }
                }
                reduced.push(sum.map(|s| s as f32));
            }
        }
    }
    reduced
}

/// First source texel and the three weights of target texel `i` on an axis of `n` texels.
fn taps(i: i32, n: i32) -> (i32, [f64; 3]) {
    if n == 1 {
        (0, [1.0, 0.0, 0.0])
    } else if n % 2 == 0 {
        (2 * i, [0.5, 0.5, 0.0])
    } else {
        let (m, n) = (f64::from(n / 2), f64::from(n));
        let k = f64::from(i);
        (2 * i, [(m - k) / n, m / n, (k + 1.0) / n])
    }
}

/// The unit vector along a mean of unit vectors; +z where they cancel.
fn normalized(c: [f32; 4], units: f32) -> [f32; 4] {
    let n = [0, 1, 2].map(|k| 2.0 * c[k] / units - 1.0);
    let mut n = n;
    let mut length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if !length2.is_finite() {
        // Floats whose squares are too large.
        n = n.map(|x| x * 1e-36);
        length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    }
    let [x, y, z] = if length2 > 1e-12 {
        let length = sqrt_f32(length2);
        n.map(|x| x / length)
    } else {
        [0.0, 0.0, 1.0]
    };
    let back = |x: f32| (x + 1.0) * 0.5 * units;
    [back(x), back(y), back(z), c[3]]
}

fn base_alpha(words: &[u32], format: Format) -> Vec<[f32; 4]> {
    (0..words.len() / format.words())
        .map(|i| format.fetch(words, i * format.words()))
        .collect()
}

/// Share of texels whose alpha reaches the threshold.
fn coverage(texels: &[[f32; 4]], threshold: f32) -> f64 {
    let passing = texels.iter().filter(|c| c[3] >= threshold).count();
    passing as f64 / texels.len() as f64
}

/// The scale nearest to one at which at least as much passes as in the base, and as little more as there can be. Source: Castano,
/// "Computing Alpha Mipmaps", 2010. `threshold` and the alphas are in unscaled values, of which `units` are one.
///
/// The same texels pass at every scale of an interval, so that opaque texels stay opaque wherever one is in it.
fn coverage_scale(texels: &[[f32; 4]], share: f64, threshold: f32, units: f32) -> f32 {
    const MOST: f64 = 16.0;
    // Nothing reaches a threshold that is no number, and everything one that is not above zero, whatever the scale.
    if !(threshold > 0.0 && threshold.is_finite()) {
        return 1.0;
    }
    let mut alphas: Vec<f32> = texels.iter().map(|c| c[3]).collect();
    alphas.sort_unstable_by(|a, b| b.total_cmp(a));
    // A share is a quotient: its product may lie a rounding above a whole number.
    let wanted = (share * alphas.len() as f64 - 1e-6).max(0.0) as usize;
    let last = alphas.get(wanted).filter(|_| share > 0.0);
    let first_out = match last {
        Some(last) => alphas[wanted..].iter().find(|a| *a < last),
        None => alphas.first(),
    };
    let threshold = f64::from(threshold);
    let ends = |margin: f64| {
        let scale = |alpha: &f32, threshold: f64| threshold / f64::from(*alpha).max(1e-30);
        let low = last.map_or(0.0, |a| scale(a, threshold + margin));
        let high = first_out.map_or(f64::INFINITY, |a| scale(a, threshold - margin));
        (low.min(MOST), high)
    };
    // Half a step of 8 bits on either side, so that rounding moves no texel over the threshold.
    let (low, high) = ends(f64::from(units) * 0.5 / 255.0);
    let nearest = if low <= high {
        1.0_f64.clamp(low, high)
    } else {
        let (low, high) = ends(0.0);
        0.5 * (low + high.min(MOST))
    };
    nearest.min(MOST) as f32
}

fn texels(level: &Level) -> usize {
    level.width as usize * level.height as usize * level.depth as usize
}
