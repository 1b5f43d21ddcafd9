//! What one light gives a point before anything stands in its way, for one point and for sixteen.

use texmap_math::det32;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*};
use texmap_math::lanes::floor_to_i32;

use crate::lanes::V3;
use crate::vector::{dot, dot_lanes, scale, spread, sub, sub_lanes, unit, unit_lanes};
use crate::{Highlight, Light, Surface};

/// What one light gives: `color * diffuse` to the diffuse term, `color * highlight` to the highlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The light's colour, in a spot light's cone.
    pub color: [f32; 3],
    /// `kd N.L`, or `ka` of ambient light.
    pub diffuse: f32,
    /// `ks (V.R)^ns` or `ks (N.H)^ns`.
    pub highlight: f32,
}

/// An exponent: whole ones up to 256 by squaring, off by at most as many units in the last place (and by 2e-19), others by
/// [`det32::pow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Power {
    /// Squared and multiplied.
    Whole(u32),
    /// By logarithm.
    Real(f32),
}

impl Power {
    /// `x^ns`.
    #[must_use]
    pub fn new(ns: f32) -> Self {
        let whole = ns as u32;
        if whole as f32 == ns && whole <= MOST {
            Self::Whole(whole)
        } else {
            Self::Real(ns)
        }
    }

    /// The power of a positive number.
    #[must_use]
    pub fn of(self, x: f32) -> f32 {
        match self {
            Self::Real(ns) => det32::pow(x, ns),
            Self::Whole(mut left) => {
                let (mut power, mut square) = (1.0, x);
                loop {
                    if left & 1 == 1 {
                        power = some(power * square);
                    }
                    left >>= 1;
                    if left == 0 {
                        return power;
                    }
                    square = some(square * square);
                }
            }
        }
    }

    /// [`of`](Self::of) for sixteen.
    #[inline(always)]
    pub fn of_lanes<S: Simd>(self, s: S, x: f32x16<S>) -> f32x16<S> {
        match self {
            Self::Real(ns) => det32::pow_lanes(texmap_math::simd::X16(s), x, f32x16::splat(s, ns)),
            Self::Whole(mut left) => {
                let (mut power, mut square) = (f32x16::splat(s, 1.0), x);
                loop {
                    if left & 1 == 1 {
                        power = some_lanes(s, power * square);
                    }
                    left >>= 1;
                    if left == 0 {
                        return power;
                    }
                    square = some_lanes(s, square * square);
                }
            }
        }
    }
}

/// The largest exponent that is squared and multiplied.
const MOST: u32 = 256;

/// Exponents of sixteen points.
#[derive(Clone, Copy)]
pub enum PowerLanes<S: Simd> {
    /// One for all.
    Same(Power),
    /// Each has its own.
    Each(f32x16<S>),
}

impl<S: Simd> core::fmt::Debug for PowerLanes<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("PowerLanes")
    }
}

impl<S: Simd> PowerLanes<S> {
    /// [`Power::of`] for sixteen.
    #[inline(always)]
    pub fn of(self, s: S, x: f32x16<S>) -> f32x16<S> {
        match self {
            Self::Same(power) => power.of_lanes(s, x),
            Self::Each(ns) => of_each(s, x, ns),
        }
    }
}

/// Out of line: exponents from textures are few.
#[inline(never)]
fn of_each<S: Simd>(s: S, x: f32x16<S>, ns: f32x16<S>) -> f32x16<S> {
    s.vectorize(
        #[inline(always)]
        || {
            let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
            let fits = ns.simd_ge(zero) & ns.simd_le(MOST as f32);
            let mut left = floor_to_i32(s, fits.select(ns, zero));
            let whole = fits & left.to_float::<f32x16<S>>().simd_eq(ns);
            let real = if whole.all_true() {
                zero
            } else {
                det32::pow_lanes(texmap_math::simd::X16(s), x, ns)
            };
            let (mut power, mut square) = (one, x);
            let some = i32x16::splat(s, 1);
            while left.simd_gt(0).any_true() {
                let odd = (left & some).simd_eq(some);
                power = odd.select(some_lanes(s, power * square), power);
                left >>= 1;
                square = some_lanes(s, square * square);
            }
            whole.select(power, real)
        },
    )
}

/// Powers below this are 0: their products would be subnormal numbers, which take a hundred times as long.
const LEAST: f32 = 2e-19;

fn some(power: f32) -> f32 {
    if power > LEAST { power } else { 0.0 }
}

#[inline(always)]
fn some_lanes<S: Simd>(s: S, power: f32x16<S>) -> f32x16<S> {
    power.simd_gt(LEAST).select(power, f32x16::splat(s, 0.0))
}

/// What a light gives a point; `None` for a light behind the surface. `normal` and `view`, the direction to the eye, have unit length
/// or are zero.
#[must_use]
pub fn share(
    surface: &Surface,
    power: Power,
    model: Highlight,
    light: &Light,
    point: [f32; 3],
    normal: [f32; 3],
    view: [f32; 3],
) -> Option<Share> {
    let (color, toward) = match *light {
        Light::Ambient { color } => {
            return Some(Share {
                color,
                diffuse: surface.ka,
                highlight: 0.0,
            });
        }
        Light::Directional { color, direction } => (color, unit(scale(direction, -1.0))),
        Light::Point { color, position } => (color, unit(sub(position, point))),
        Light::Spot {
            color, position, ..
        } => {
            let toward = unit(sub(position, point));
            (scale(color, cone(light, toward)), toward)
        }
    };
    let facing = dot(normal, toward);
    if facing.is_nan() || facing <= 0.0 || color == [0.0; 3] {
        return None;
    }
    let mut highlight = 0.0;
    if surface.ks > 0.0 {
        let along = match model {
            Highlight::Phong => {
                let k = 2.0 * facing;
                dot(view, sub(scale(normal, k), toward))
            }
            Highlight::Blinn => {
                let halfway = [0, 1, 2].map(|i| view[i] + toward[i]);
                dot(normal, unit(halfway))
            }
        };
        if along > 0.0 {
            highlight = surface.ks * power.of(along);
        }
    }
    Some(Share {
        color,
        diffuse: surface.kd * facing,
        highlight,
    })
}

/// Share of a spot light's strength for a point from which the light lies in the unit direction `toward`, 0..=1; 1 for other lights.
/// A point in the light gets nothing.
fn cone(light: &Light, toward: [f32; 3]) -> f32 {
    let Light::Spot {
        direction,
        cos_inner,
        cos_outer,
        ..
    } = *light
    else {
        return 1.0;
    };
    let along = -dot(unit(direction), toward);
    if toward == [0.0; 3] || along < cos_outer {
        0.0
    } else if along >= cos_inner {
        1.0
    } else {
        let x = (along - cos_outer) / (cos_inner - cos_outer);
        x * x * (3.0 - 2.0 * x)
    }
}

/// [`Share`] of sixteen points.
#[derive(Clone, Copy)]
pub struct ShareLanes<S: Simd> {
    /// Lanes that the light is not behind of; what the others hold has no meaning.
    pub lit: mask32x16<S>,
    /// See [`Share`].
    pub color: V3<S>,
    /// See [`Share`].
    pub diffuse: f32x16<S>,
    /// See [`Share`].
    pub highlight: f32x16<S>,
}

impl<S: Simd> core::fmt::Debug for ShareLanes<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("ShareLanes")
    }
}

/// [`share`] for sixteen.
#[inline(always)]
pub fn share_lanes<S: Simd>(
    s: S,
    surface: &Surface,
    power: PowerLanes<S>,
    model: Highlight,
    light: &Light,
    point: V3<S>,
    normal: V3<S>,
    view: V3<S>,
) -> ShareLanes<S> {
    let zero = f32x16::splat(s, 0.0);
    let (color, toward) = match *light {
        Light::Ambient { color } => {
            return ShareLanes {
                lit: mask32x16::splat(s, true),
                color: spread(s, color),
                diffuse: f32x16::splat(s, surface.ka),
                highlight: zero,
            };
        }
        Light::Directional { color, direction } => {
            (spread(s, color), spread(s, unit(scale(direction, -1.0))))
        }
        Light::Point { color, position } => (
            spread(s, color),
            unit_lanes(s, sub_lanes(spread(s, position), point)),
        ),
        Light::Spot {
            color, position, ..
        } => {
            let toward = unit_lanes(s, sub_lanes(spread(s, position), point));
            let share = cone_lanes(s, light, toward);
            let color = spread(s, color);
            (
                [color[0] * share, color[1] * share, color[2] * share],
                toward,
            )
        }
    };
    let facing = dot_lanes(normal, toward);
    let lit = facing.simd_gt(zero);
    let mut highlight = zero;
    if surface.ks > 0.0 && lit.any_true() {
        let along = match model {
            Highlight::Phong => {
                let k = facing * 2.0;
                let mirrored = [
                    normal[0] * k - toward[0],
                    normal[1] * k - toward[1],
                    normal[2] * k - toward[2],
                ];
                dot_lanes(view, mirrored)
            }
            Highlight::Blinn => {
                let halfway = [
                    view[0] + toward[0],
                    view[1] + toward[1],
                    view[2] + toward[2],
                ];
                dot_lanes(normal, unit_lanes(s, halfway))
            }
        };
        let bright = power.of(s, along) * surface.ks;
        highlight = along.simd_gt(zero).select(bright, zero);
    }
    ShareLanes {
        lit,
        color,
        diffuse: facing * surface.kd,
        highlight,
    }
}

/// [`cone`] for sixteen.
#[inline(always)]
fn cone_lanes<S: Simd>(s: S, light: &Light, toward: V3<S>) -> f32x16<S> {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    let Light::Spot {
        direction,
        cos_inner,
        cos_outer,
        ..
    } = *light
    else {
        return one;
    };
    let along = -dot_lanes(spread(s, unit(direction)), toward);
    let x = (along - cos_outer) / f32x16::splat(s, cos_inner - cos_outer);
    let between = x * x * (3.0 - x * 2.0);
    let inner = along.simd_ge(cos_inner).select(one, between);
    let nowhere = toward[0].simd_eq(zero) & toward[1].simd_eq(zero) & toward[2].simd_eq(zero);
    let out = nowhere | along.simd_lt(cos_outer);
    out.select(zero, inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::lanes::LANES;
    use texmap_math::{Level, on_wide_level};

    /// Also where whole exponents and others stand side by side.
    #[test]
    fn exponents_of_their_own_give_the_bits_of_one_for_all() {
        let ns = [
            0.0, 1.0, 5.0, 20.5, 255.0, 256.0, 257.0, 0.25, 3.0, 100.0, 31.0, 1e4, 64.0, 17.0,
            -1.0, -0.0,
        ];
        let x: [f32; LANES] = core::array::from_fn(|i| 1e-3 + i as f32 / 14.9);
        let whole = ns.map(|n: f32| n.abs().floor().min(256.0));
        let level = Level::new();
        for ns in [ns, whole] {
            for level in [level, Level::baseline()] {
                let mut out = [0.0; LANES];
                on_wide_level!(
                    level,
                    s => {
                        let each = PowerLanes::Each(f32x16::from_slice(s, &ns));
                        each.of(s, f32x16::from_slice(s, &x)).store_slice(&mut out);
                    },
                    else for (i, out) in out.iter_mut().enumerate() {
                        *out = Power::new(ns[i]).of(x[i]);
                    }
                );
                for (i, out) in out.into_iter().enumerate() {
                    let one = Power::new(ns[i]).of(x[i]);
                    assert_eq!(out.to_bits(), one.to_bits(), "{}^{}", x[i], ns[i]);
                }
            }
        }
    }
}
