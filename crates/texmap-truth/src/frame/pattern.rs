//! Patterns that fill space, in f64: noise, marble, wood (Perlin 1985), as a sample of some width sees them.

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_sample::{Pattern, reference::gradient_noise};

use std::f64::consts::{PI, TAU};

/// The value of a pattern, 0 to 1, at a point as a sample `width` units wide sees it.
pub(super) fn value(pattern: Pattern, p: DVec3, width: f64) -> f64 {
    let value = match pattern {
        Pattern::Noise { octaves } => 0.5 + 0.5 * octave_sum(p, width, octaves, |n| n),
        Pattern::Marble {
            octaves,
            turbulence,
        } => {
            let fold = f64::from(turbulence) * octave_sum(p, width, octaves, f64::abs);
            // The mean of a sine over a width is its value times sinc.
            let half = PI * width;
            let seen = if half < 1e-6 {
                1.0
            } else if width < 1.0 {
                deterministic_f64::sin(half) / half
            } else {
                0.0
            };
            0.5 + 0.5 * seen * deterministic_f64::sin(TAU * fraction(p.x + fold))
        }
        Pattern::Wood { grain } => {
            let fibre = DVec3::new(p.x, p.y, p.z * 0.125);
            let ring = p.truncate().length() + f64::from(grain) * noise(fibre, 0);
            mean_fraction(ring, width)
        }
    };
    value.clamp(0.0, 1.0)
}

/// Gradient noise, -1 to 1.
pub(super) fn noise(p: DVec3, seed: u32) -> f64 {
    gradient_noise(p.to_array(), seed)
}

/// Octaves of noise, each twice as fine and half as strong, as far as the width resolves them: all up to half a cell, none from a cell on.
fn octave_sum(p: DVec3, width: f64, octaves: u8, shape: impl Fn(f64) -> f64) -> f64 {
    let octave = |i: u8| {
        let scale = f64::from(1u32 << i);
        let seen = (2.0 - 2.0 * width * scale).clamp(0.0, 1.0);
        if seen > 0.0 {
            seen / scale * shape(noise(p * scale, u32::from(i)))
        } else {
            0.0
        }
    };
    (0..octaves.clamp(1, Pattern::MAX_OCTAVES))
        .map(octave)
        .sum()
}

fn fraction(x: f64) -> f64 {
    x - x.floor()
}

/// The mean of the fraction over `width` around x, by its integral `floor(x) / 2 + fraction(x)^2 / 2`.
fn mean_fraction(x: f64, width: f64) -> f64 {
    if width < 1e-9 {
        return fraction(x);
    }
    if width > 1024.0 {
        return 0.5;
    }
    let base = (x - 0.5 * width).floor();
    let integral = |x: f64| 0.5 * x.floor() + 0.5 * fraction(x) * fraction(x);
    (integral(x + 0.5 * width - base) - integral(x - 0.5 * width - base)) / width
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The library's f32 patterns are these.
    #[test]
    fn patterns_are_those_of_the_library() {
        let patterns = [
            Pattern::Noise { octaves: 4 },
            Pattern::Marble {
                octaves: 5,
                turbulence: 1.3,
            },
            Pattern::Wood { grain: 0.3 },
        ];
        for pattern in patterns {
            for i in 0..2_000u32 {
                let c = |k: f32| (i as f32 * k).sin() * 7.0;
                let p = [c(0.37), c(0.71), c(1.13)];
                let width = (i % 40) as f32 * 0.03;
                let wanted = f64::from(pattern.value(p, width));
                let found = value(pattern, super::super::wide(p), f64::from(width));
                // At a ring's end a sixteenth of an ulp turns 1 to 0.
                let off = (wanted - found).abs();
                assert!(
                    !(2e-4..=0.999).contains(&off),
                    "{pattern:?} {p:?} {width}: {off}"
                );
            }
        }
    }
}
