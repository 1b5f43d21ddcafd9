//! Patterns that fill space: noise, marble and wood as functions of a point (Perlin 1985, "An Image Synthesizer").

use texmap_math::{det32, float};

/// Gradient noise at a point: -1 to 1, 0 at whole coordinates, features about one unit wide, twice continuously
/// differentiable (Perlin 2002, "Improving Noise": the twelve edge directions and 6t^5 - 15t^4 + 10t^3).
///
/// The gradients come from an integer hash of the cell and `seed`, so nothing repeats within 2^32 cells. A coordinate
/// that is not finite gives 0, as does one beyond 2^23, where floats have no fraction. Within 2e-6 of
/// [`reference::gradient_noise`](crate::reference::gradient_noise) of the same point.
pub fn gradient_noise(p: [f32; 3], seed: u32) -> f32 {
    if !in_reach(p) {
        return 0.0;
    }
    let cell = p.map(float::floor_f32);
    let at = [p[0] - cell[0], p[1] - cell[1], p[2] - cell[2]];
    let cell = cell.map(|c| c as i32);
    let [wx, wy, wz] = at.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |x: i32, y: i32, z: i32| {
        let from = [at[0] - x as f32, at[1] - y as f32, at[2] - z as f32];
        let [a, b] = edge(hash([cell[0] + x, cell[1] + y, cell[2] + z], seed));
        let along = |(axis, negative): (usize, bool)| {
            if negative { -from[axis] } else { from[axis] }
        };
        along(a) + along(b)
    };
    let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
    let row = |y: i32, z: i32| mix(corner(0, y, z), corner(1, y, z), wx);
    let slice = |z: i32| mix(row(0, z), row(1, z), wy);
    let value = mix(slice(0), slice(1), wz);
    clamp(value, -1.0, 1.0)
}

/// Whether floats have a fraction there.
fn in_reach(p: [f32; 3]) -> bool {
    p.iter().all(|x| x.abs() < 8_388_608.0)
}

/// One of the twelve edge directions of a cube as two axes with their signs; four of them come twice.
pub(crate) fn edge(hash: u32) -> [(usize, bool); 2] {
    let (first, second) = (hash >> 31 != 0, hash >> 30 & 1 != 0);
    match hash >> 28 & 3 {
        0 => [(0, first), (1, second)],
        1 => [(0, first), (2, second)],
        2 => [(1, first), (2, second)],
        // (1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, -1, -1), as in the paper.
        _ if first => [(1, true), (2, second)],
        _ => [(0, second), (1, false)],
    }
}

/// Every bit depends on every coordinate: odd multipliers, then the finisher of MurmurHash3 (Appleby 2011).
pub(crate) fn hash([x, y, z]: [i32; 3], seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77).rotate_left(11)
        ^ (z as u32).wrapping_mul(0xc2b2_ae3d).rotate_left(22)
        ^ seed.wrapping_mul(0x27d4_eb2f);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

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
        /// How far the sheets are folded, in units; 0 leaves them flat.
        turbulence: f32,
    },
    /// Rings about the z axis, one a unit, each from 0 to 1 and back at once, as a year's growth is.
    Wood {
        /// How far the rings leave the circle, in units.
        grain: f32,
    },
}

impl Pattern {
    /// Most octaves.
    pub const MOST_OCTAVES: u8 = 16;

    /// The value at a point, as a pixel `width` units wide sees it: octaves too fine for it fade out, sheets and rings
    /// go to their mean, so that nothing flickers from afar. A width of 0 (or NaN) gives the pattern itself. A point
    /// beyond 2^23, where floats have no fraction, or not finite, reads as the origin.
    pub fn value(&self, p: [f32; 3], width: f32) -> f32 {
        let p = if in_reach(p) { p } else { [0.0; 3] };
        let width = if width > 0.0 { width } else { 0.0 };
        match *self {
            Self::Noise { octaves } => {
                let sum = octave_sum(p, width, octaves, |n| n);
                clamp(0.5 + 0.5 * sum, 0.0, 1.0)
            }
            Self::Marble {
                octaves,
                turbulence,
            } => {
                let fold = turbulence * octave_sum(p, width, octaves, f32::abs);
                let turns = p[0] + fold;
                let turns = turns - float::floor_f32(turns);
                // The mean of a sine over a width: its value times sinc.
                let half = core::f32::consts::PI * width;
                let seen = if half < 1e-3 {
                    1.0
                } else if width < 1.0 {
                    det32::sin(half) / half
                } else {
                    0.0
                };
                let wave = det32::sin(core::f32::consts::TAU * turns);
                clamp(0.5 + 0.5 * seen * wave, 0.0, 1.0)
            }
            Self::Wood { grain } => {
                // Fibres run along z: noise is drawn out that way.
                let fibre = [p[0], p[1], p[2] * 0.125];
                let r = float::sqrt_f32(p[0] * p[0] + p[1] * p[1]);
                mean_fraction(r + grain * gradient_noise(fibre, 0), width)
            }
        }
    }
}

/// Sum of `shape(noise)` over octaves, each weighed by how well a pixel of this width resolves it: all up to half a
/// cell, none from a cell on.
fn octave_sum(p: [f32; 3], width: f32, octaves: u8, shape: impl Fn(f32) -> f32) -> f32 {
    let (mut sum, mut scale, mut strength) = (0.0, 1.0f32, 1.0f32);
    for octave in 0..octaves.clamp(1, Pattern::MOST_OCTAVES) {
        let seen = clamp(2.0 - 2.0 * width * scale, 0.0, 1.0);
        if seen <= 0.0 {
            break;
        }
        let n = gradient_noise(p.map(|x| x * scale), u32::from(octave));
        sum += seen * strength * shape(n);
        (scale, strength) = (scale * 2.0, strength * 0.5);
    }
    sum
}

/// The mean of x - floor(x) over `width` around x, by its integral floor(x) / 2 + (x - floor(x))^2 / 2.
fn mean_fraction(x: f32, width: f32) -> f32 {
    let fraction = |x: f32| x - float::floor_f32(x);
    if width < 1e-3 {
        return fraction(x);
    }
    if width > 1024.0 {
        return 0.5;
    }
    // Both ends are measured from one whole number, so that nothing cancels far out.
    let base = float::floor_f32(x - 0.5 * width);
    let low = x - 0.5 * width - base;
    let high = low + width;
    let whole = float::floor_f32(high);
    let rest = high - whole;
    (0.5 * whole + 0.5 * rest * rest - 0.5 * low * low) / width
}

/// NaN gives `low`.
fn clamp(x: f32, low: f32, high: f32) -> f32 {
    if x >= high {
        high
    } else if x > low {
        x
    } else {
        low
    }
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
}
