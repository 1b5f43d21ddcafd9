//! Mip chains.

use crate::texels::{Chain, Format, Level, Words};
use alloc::{sync::Arc, vec::Vec};

/// What a level keeps of the level above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reduce {
    /// The area-weighted mean.
    Mean,
}

/// The chain of the base level down to one texel. Sides halve rounding down; a side of odd length n
/// becomes m = (n - 1) / 2 texels that each cover n / m texels, so that three texels with weights
/// (m - i, m, i + 1) / n make one and the mean of every level is the mean of the base (the
/// polyphase box of Guthe and Heckbert, "Non-power-of-two mipmapping", 2005).
pub(crate) fn build(base: Chain<'_>, _reduce: Reduce) -> Chain<'static> {
    let first = base.levels[0];
    let format = base.format;
    let mut levels = Vec::from([first]);
    let mut words = base.words()[..texels(&first) * format.words()].to_vec();
    // The working copy stays in floats, so that rounding does not add up along the chain.
    let mut current: Vec<[f32; 4]> = Vec::new();
    let mut size = first;
    while size.width > 1 || size.height > 1 {
        let next = Level {
            offset: words.len(),
            width: (size.width / 2).max(1),
            height: (size.height / 2).max(1),
            depth: size.depth,
        };
        let mut reduced = Vec::with_capacity(texels(&next));
        for z in 0..size.depth {
            for y in 0..next.height {
                let (y0, wy) = taps(y, size.height);
                for x in 0..next.width {
                    let (x0, wx) = taps(x, size.width);
                    let mut sum = [0.0_f64; 4];
                    for (j, wy) in wy.into_iter().enumerate().filter(|(_, w)| *w > 0.0) {
                        for (i, wx) in wx.into_iter().enumerate().filter(|(_, w)| *w > 0.0) {
                            let row = z * size.height + y0 + j as i32;
                            let at = row as usize * size.width as usize + x0 as usize + i;
                            let c = if current.is_empty() {
                                format.fetch(base.words(), at * format.words())
                            } else {
                                current[at]
                            };
                            for (s, c) in sum.iter_mut().zip(c) {
                                *s += wx * wy * f64::from(c);
                            }
                        }
                    }
                    reduced.push(sum.map(|s| s as f32));
                }
            }
        }
        for &c in &reduced {
            format.push(&mut words, c);
        }
        current = reduced;
        levels.push(next);
        size = next;
    }
    debug_assert!(format != Format::R32 || words.len() >= texels(&first));
    Chain {
        words: Words::Owned(Arc::new(words)),
        format,
        levels,
        flip: base.flip,
        opaque: base.opaque,
    }
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

fn texels(level: &Level) -> usize {
    level.width as usize * level.height as usize * level.depth as usize
}
