//! Mip chains.

mod row;
mod stream;

use crate::texel_data::{Chain, Format, Level, Words};
use alloc::{sync::Arc, vec::Vec};
use texmap_math::Level as SimdLevel;

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
        let level = SimdLevel::try_detect().unwrap_or(SimdLevel::baseline());
        return stream::stream(level, base, reduce);
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

/// How many texels of an axis of `n` make one of the next level.
fn tap_count(n: i32) -> usize {
    match n {
        1 => 1,
        _ => 2 + (n % 2) as usize,
    }
}

/// First source texel and the three weights of target texel `i` on an axis of `n` texels; those beyond the [count](tap_count) are 0.
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
