//! Patterns that fill space: noise, marble and wood as functions of a point (Perlin 1985, "An Image Synthesizer").

mod noise;

use texmap_math::deterministic_f32;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use noise::in_reach;
pub(crate) use noise::{edge, hash};
pub use noise::{gradient_noise, gradient_noise_lanes};

/// A pattern in space. Values are 0 to 1, for a ramp of colours to be looked up with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Sums of noise, each octave twice as fine and half as strong: clouds. 0.5 in the mean.
    Noise {
        /// 1 to 16.
        octaves: u8,
    },
    /// Sheets across x, one a unit, folded by the sum of |noise| (Perlin 1985).
    Marble {
        /// 1 to 16.
        octaves: u8,
        /// Distance by which the sheets are folded, in units; 0 leaves them flat.
        turbulence: f32,
    },
    /// Rings about the z axis, one a unit, each from 0 to 1 and back at once, as a year's growth is.
    Wood {
        /// Distance by which the rings leave the circle, in units.
        grain: f32,
    },
}

impl Pattern {
    /// Most octaves.
    pub const MAX_OCTAVES: u8 = 16;

    /// The value at a point, as a pixel `width` units wide sees it. Octaves too fine for it fade out, sheets and rings
    /// go to their mean, so that nothing flickers from afar. A width of 0 (or NaN) gives the pattern itself. A point
    /// beyond 2^23, where floats have no fraction, or not finite, reads as the origin.
    pub fn value(&self, p: [f32; 3], width: f32) -> f32 {
        self.value_lanes(Scalar, p, width)
    }

    /// [`value`](Self::value) for each lane.
    #[inline(always)]
    pub fn value_lanes<I: Isa>(&self, i: I, p: [I::F32; 3], width: I::F32) -> I::F32 {
        let (zero, one) = (i.f32(0.0), i.f32(1.0));
        let reach = in_reach::<I>(p);
        let p = [
            reach.select(p[0], zero),
            reach.select(p[1], zero),
            reach.select(p[2], zero),
        ];
        let width = width.simd_gt(0.0).select(width, zero);
        match *self {
            Self::Noise { octaves } => {
                let sum = octave_sum(i, p, width, octaves, false);
                clamp(i, sum * 0.5 + 0.5, 0.0, 1.0)
            }
            Self::Marble {
                octaves,
                turbulence,
            } => {
                let turns = p[0] + octave_sum(i, p, width, octaves, true) * turbulence;
                let turns = turns - turns.floor();
                // The mean of a sine over a width: its value times sinc.
                let half = width * core::f32::consts::PI;
                let sinc = deterministic_f32::sin_lanes(i, half) / half;
                let seen = width.simd_lt(1.0).select(sinc, zero);
                let seen = half.simd_lt(1e-3).select(one, seen);
                let wave = deterministic_f32::sin_lanes(i, turns * core::f32::consts::TAU);
                clamp(i, seen * 0.5 * wave + 0.5, 0.0, 1.0)
            }
            Self::Wood { grain } => {
                // Fibres run along z: noise is drawn out that way.
                let fibre = [p[0], p[1], p[2] * 0.125];
                let r = (p[0] * p[0] + p[1] * p[1]).sqrt();
                mean_fraction(i, r + gradient_noise_lanes(i, fibre, 0) * grain, width)
            }
        }
    }
}

/// Sum of noise, or of its magnitude, over octaves, each weighed by the pixel's width. An octave counts fully while the pixel is up to
/// half a cell wide, and not at all from a cell on.
#[inline(always)]
fn octave_sum<I: Isa>(i: I, p: [I::F32; 3], width: I::F32, octaves: u8, magnitude: bool) -> I::F32 {
    let (mut sum, mut scale, mut strength) = (i.f32(0.0), 1.0f32, 1.0f32);
    for octave in 0..octaves.clamp(1, Pattern::MAX_OCTAVES) {
        let seen = clamp(i, i.f32(2.0) - width * 2.0 * scale, 0.0, 1.0);
        let some = seen.simd_gt(0.0);
        if !some.any_true() {
            break;
        }
        let at = [p[0] * scale, p[1] * scale, p[2] * scale];
        let n = gradient_noise_lanes(i, at, u32::from(octave));
        let n = if magnitude { n.abs() } else { n };
        sum = some.select(sum + seen * strength * n, sum);
        (scale, strength) = (scale * 2.0, strength * 0.5);
    }
    sum
}

/// The mean of x - floor(x) over `width` around x, by its integral floor(x) / 2 + (x - floor(x))^2 / 2.
#[inline(always)]
fn mean_fraction<I: Isa>(i: I, x: I::F32, width: I::F32) -> I::F32 {
    let fraction = x - x.floor();
    // Both ends are measured from one whole number, so that nothing cancels far out.
    let base = (x - width * 0.5).floor();
    let low = x - width * 0.5 - base;
    let high = low + width;
    let whole = high.floor();
    let rest = high - whole;
    let mean = (whole * 0.5 + rest * 0.5 * rest - low * 0.5 * low) / width;
    let mean = width.simd_gt(1024.0).select(i.f32(0.5), mean);
    width.simd_lt(1e-3).select(fraction, mean)
}

/// NaN gives `low`.
#[inline(always)]
fn clamp<I: Isa>(i: I, x: I::F32, low: f32, high: f32) -> I::F32 {
    let above = x.simd_gt(low).select(x, i.f32(low));
    x.simd_ge(high).select(i.f32(high), above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;

    fn points(count: u32, spread: f32) -> impl Iterator<Item = [f32; 3]> {
        (0..count).map(move |i| {
            [0, 1, 2].map(|k| {
                let h = hash([i as i32, k, 7], 3);
                spread * (h as f32 / u32::MAX as f32 - 0.5)
            })
        })
    }

    #[test]
    fn noise_is_its_reference_and_keeps_its_range() {
        let (mut worst, mut low, mut high, mut sum) = (0.0f64, 0.0f32, 0.0f32, 0.0f64);
        for p in points(100_000, 64.0) {
            let n = gradient_noise(p, 5);
            worst =
                worst.max((f64::from(n) - reference::gradient_noise(p.map(f64::from), 5)).abs());
            (low, high) = (low.min(n), high.max(n));
            sum += f64::from(n);
        }
        assert!(worst < 2e-6, "{worst}");
        assert!(
            low < -0.7 && high > 0.7 && low >= -1.0 && high <= 1.0,
            "{low} {high}"
        );
        assert!((sum / 1e5).abs() < 0.01, "{sum}");
    }

    #[test]
    fn noise_is_nought_on_the_lattice_and_smooth_across_it() {
        for p in points(1000, 64.0) {
            assert_eq!(gradient_noise(p.map(f32::floor), 0), 0.0);
            let near = |d: f64| {
                let q = [
                    f64::from(p[0].floor()) + d,
                    f64::from(p[1]),
                    f64::from(p[2]),
                ];
                reference::gradient_noise(q, 0)
            };
            // Value, slope and curvature from both sides of a cell's face.
            let h = 1e-4;
            let left = (near(0.0) - 2.0 * near(-h) + near(-2.0 * h)) / (h * h);
            let right = (near(2.0 * h) - 2.0 * near(h) + near(0.0)) / (h * h);
            assert!((near(h) - near(-h)).abs() < 4.0 * h);
            assert!((left - right).abs() < 0.1, "{left} {right}");
        }
    }

    #[test]
    fn every_pattern_stays_in_range_and_goes_to_its_mean_from_afar() {
        let all = [
            (Pattern::Noise { octaves: 5 }, 0.5),
            (
                Pattern::Marble {
                    octaves: 5,
                    turbulence: 1.5,
                },
                0.5,
            ),
            (Pattern::Wood { grain: 0.2 }, 0.5),
        ];
        for (pattern, mean) in all {
            for p in points(2000, 32.0).chain([
                [1e30; 3],
                [f32::NAN, 0.0, 1.0],
                [f32::INFINITY; 3],
                [-3e8, 0.0, 1e9],
            ]) {
                for width in [0.0, 1e-4, 0.3, 1.0, 7.0, 1e9, f32::NAN, f32::INFINITY] {
                    let v = pattern.value(p, width);
                    assert!((0.0..=1.0).contains(&v), "{pattern:?} {p:?} {width}: {v}");
                }
                let afar = pattern.value(p, 4096.0);
                assert!((afar - mean).abs() < 1e-3, "{pattern:?} {p:?}: {afar}");
            }
        }
    }

    #[test]
    fn a_wide_pixel_sees_the_mean_of_its_narrow_ones() {
        let wood = Pattern::Wood { grain: 0.0 };
        for (x, width) in [(3.3, 0.5), (10.0, 0.8), (7.7, 2.3)] {
            let fine: f32 = (0..4096)
                .map(|i| {
                    wood.value(
                        [x + width * ((i as f32 + 0.5) / 4096.0 - 0.5), 0.0, 0.0],
                        0.0,
                    )
                })
                .sum();
            let wide = wood.value([x, 0.0, 0.0], width);
            assert!(
                (wide - fine / 4096.0).abs() < 1e-3,
                "{wide} {}",
                fine / 4096.0
            );
        }
        let marble = Pattern::Marble {
            octaves: 1,
            turbulence: 0.0,
        };
        let fine: f32 = (0..4096)
            .map(|i| {
                marble.value(
                    [0.3 + 0.6 * ((i as f32 + 0.5) / 4096.0 - 0.5), 0.0, 0.0],
                    0.0,
                )
            })
            .sum();
        assert!((marble.value([0.3, 0.0, 0.0], 0.6) - fine / 4096.0).abs() < 1e-4);
    }

    fn every_lane<I: Isa>(
        i: I,
        columns: &[[f32; 16]; 3],
        width: &[f32; 16],
        patterns: &[Pattern],
        noise: &mut [f32],
        values: &mut [[f32; 16]; 3],
    ) {
        for k in (0..16).step_by(I::LANES) {
            let p = [0, 1, 2].map(|c| i.load_f32(&columns[c][k..]));
            gradient_noise_lanes(i, p, 5).store(&mut noise[k..]);
            for (out, pattern) in values.iter_mut().zip(patterns) {
                let width = i.load_f32(&width[k..]);
                pattern.value_lanes(i, p, width).store(&mut out[k..]);
            }
        }
    }

    /// Also where points lie out of reach, and pixels of all widths stand side by side.
    #[test]
    fn every_level_and_width_has_the_bits_of_single_points() {
        use texmap_math::lanes::LANES;
        let patterns = [
            Pattern::Noise { octaves: 5 },
            Pattern::Marble {
                octaves: 3,
                turbulence: 1.5,
            },
            Pattern::Wood { grain: 0.3 },
        ];
        let odd = [f32::NAN, f32::INFINITY, 1e30, -0.0, 8_388_607.5, -5.0, 0.5];
        let widths = [0.0, 1e-4, 0.02, 0.1, 0.3, 0.6, 1.0, 7.0, 1e9, f32::NAN];
        let mut all: Vec<[f32; 3]> = points(16 * 40, 64.0).collect();
        for (i, p) in all.iter_mut().enumerate().filter(|(i, _)| i % 11 == 0) {
            p[i % 3] = odd[i / 11 % odd.len()];
        }
        for (k, points) in all.chunks_exact(LANES).enumerate() {
            let columns: [[f32; LANES]; 3] =
                [0, 1, 2].map(|c| core::array::from_fn(|i| points[i][c]));
            let width: [f32; LANES] = core::array::from_fn(|i| widths[(k + i * i) % widths.len()]);
            let (new, least) = (texmap_math::Level::new(), texmap_math::Level::baseline());
            for (level, wide) in [(new, false), (least, false), (least, true)] {
                let mut noise = [0.0; LANES];
                let mut values = [[0.0; LANES]; 3];
                let (noise, values) = (&mut noise, &mut values);
                if wide {
                    texmap_math::dispatch_simd!(level, wide i => {
                        every_lane(i, &columns, &width, &patterns, noise, values);
                    });
                } else {
                    texmap_math::dispatch_simd!(level, i => {
                        every_lane(i, &columns, &width, &patterns, noise, values);
                    });
                }
                for (i, p) in points.iter().enumerate() {
                    let one = gradient_noise(*p, 5);
                    assert_eq!(noise[i].to_bits(), one.to_bits(), "{p:?}");
                    for (values, pattern) in values.iter().zip(&patterns) {
                        let one = pattern.value(*p, width[i]);
                        let (a, b) = (values[i], width[i]);
                        assert_eq!(
                            a.to_bits(),
                            one.to_bits(),
                            "{pattern:?} {p:?} {b}: {a} {one}"
                        );
                    }
                }
            }
        }
    }
}
