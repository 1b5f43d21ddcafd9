//! The contribution of one light to a point, before shadows.

use texmap_math::deterministic_f32;
use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;
use crate::punctual::falloff;
use crate::vector::{add, dot, is_zero, scale, splat, sub, unit};
use crate::{Light, PhongMaterial, SpecularModel};

/// An exponent: whole ones up to 256 by squaring, off by at most as many units in the last place (and by 2e-19), others by
/// [`deterministic_f32::pow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpecularExponent {
    /// Computed by squaring and multiplication.
    Whole(u32),
    /// Computed by logarithm.
    Real(f32),
}

impl SpecularExponent {
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

    /// The powers of positive numbers.
    #[inline(always)]
    pub fn of<I: Isa>(self, i: I, x: I::F32) -> I::F32 {
        match self {
            Self::Real(ns) => deterministic_f32::pow_lanes(i, x, i.f32(ns)),
            Self::Whole(mut left) => {
                // Clamped numbers have powers below the least one, and no subnormal number on the way: one comparison at the end is enough.
                let scale = left.next_power_of_two().ilog2().min(8);
                let (mut power, mut square) = (i.f32(1.0), x.above(i.f32(LOWEST[scale as usize])));
                loop {
                    if left & 1 == 1 {
                        power = power * square;
                    }
                    left >>= 1;
                    if left == 0 {
                        return flushed(i, power);
                    }
                    square = square * square;
                }
            }
        }
    }
}

/// The largest exponent that is squared and multiplied.
const MOST: u32 = 256;

/// Exponents of the points of a block.
#[derive(Clone, Copy, Debug)]
pub enum SpecularExponentLanes<I: Isa> {
    /// One for all.
    Same(SpecularExponent),
    /// Each has its own.
    Each(I::F32),
}

impl<I: Isa> SpecularExponentLanes<I> {
    /// The powers of positive numbers.
    #[inline(always)]
    pub fn of(self, i: I, x: I::F32) -> I::F32 {
        match self {
            Self::Same(power) => power.of(i, x),
            Self::Each(ns) => of_each(i, x, ns),
        }
    }
}

/// Out of line: exponents from textures are few.
#[inline(never)]
fn of_each<I: Isa>(i: I, x: I::F32, ns: I::F32) -> I::F32 {
    i.vectorize(
        #[inline(always)]
        || {
            let (zero, one) = (i.f32(0.0), i.f32(1.0));
            let fits = ns.simd_ge(0.0) & ns.simd_le(MOST as f32);
            let mut left = fits.select(ns, zero).floor_to_i32();
            let whole = fits & left.to_f32().simd_eq(ns);
            let real = if whole.all_true() {
                zero
            } else {
                deterministic_f32::pow_lanes(i, x, ns)
            };
            let (mut power, mut square) = (one, x);
            while left.simd_gt(0).any_true() {
                let odd = (left & 1).simd_eq(1);
                power = odd.select(flushed(i, power * square), power);
                left = left >> 1;
                square = flushed(i, square * square);
            }
            whole.select(power, real)
        },
    )
}

/// Least power. Lower ones are 0, as their products would be subnormal numbers, which take a hundred times as long.
const LEAST: f32 = 2e-19;

/// `2^(-124 / 2^k)`: its powers of exponents above `2^(k - 1)` and up to `2^k` lie between `2^-124` and [`LEAST`].
const LOWEST: [f32; 9] = [
    4.701_977_4e-38,
    2.168_404_3e-19,
    4.656_613e-10,
    2.157_918_6e-5,
    0.004_645_34,
    0.068_156_734,
    0.261_068_43,
    0.510_948_6,
    0.714_806_7,
];

#[inline(always)]
fn flushed<I: Isa>(i: I, power: I::F32) -> I::F32 {
    power.simd_gt(LEAST).select(power, i.f32(0.0))
}

/// The contribution of one light: `color * diffuse` to the diffuse term, `color * highlight` to the highlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightContributionLanes<I: Isa> {
    /// Lanes that the light reaches: it is not behind them, and they lie in its cone. The values of the others have no meaning.
    pub lit: I::Mask,
    /// The light's colour after falloff by distance and angle.
    pub color: [I::F32; 3],
    /// `kd N.L`, or `ka` of ambient light.
    pub diffuse: I::F32,
    /// `ks (V.R)^ns` or `ks (N.H)^ns`.
    pub specular: I::F32,
}

/// The contribution of a light to the points of a block: see [`crate::evaluate_light`].
#[inline(always)]
pub fn evaluate_light<I: Isa>(
    i: I,
    surface: &PhongMaterial,
    power: SpecularExponentLanes<I>,
    model: SpecularModel,
    light: &Light,
    point: Vector<I>,
    normal: Vector<I>,
    view: Vector<I>,
) -> LightContributionLanes<I> {
    if let Light::Ambient { color } = *light {
        return LightContributionLanes {
            lit: i.mask(true),
            color: splat(i, color),
            diffuse: i.f32(surface.ka),
            specular: i.f32(0.0),
        };
    }
    let (color, toward, mut lit) = arriving(i, light, point);
    let facing = dot(normal, toward);
    lit = lit & facing.simd_gt(0.0);
    let mut highlight = i.f32(0.0);
    if surface.ks > 0.0 && lit.any_true() {
        let along = match model {
            SpecularModel::Phong => dot(view, sub(scale(normal, facing * 2.0), toward)),
            SpecularModel::Blinn => dot(normal, unit(i, add(view, toward))),
        };
        let bright = along.simd_gt(0.0);
        if bright.any_true() {
            highlight = bright.select(power.of(i, along) * surface.ks, highlight);
        }
    }
    LightContributionLanes {
        lit,
        color,
        diffuse: facing * surface.kd,
        specular: highlight,
    }
}

/// Colour of a light at the points of a block, the unit vectors to it, and the lanes that it reaches. The lanes do not depend on
/// normals. Ambient light has no direction.
#[inline(always)]
pub(crate) fn arriving<I: Isa>(
    i: I,
    light: &Light,
    point: Vector<I>,
) -> (Vector<I>, Vector<I>, I::Mask) {
    match *light {
        Light::Ambient { color } => (splat(i, color), splat(i, [0.0; 3]), i.mask(false)),
        Light::Directional { color, direction } => {
            let toward = crate::unit(scale(direction, -1.0));
            (splat(i, color), splat(i, toward), i.mask(color != [0.0; 3]))
        }
        Light::Point { color, position } => {
            let toward = unit(i, sub(splat(i, position), point));
            (splat(i, color), toward, i.mask(color != [0.0; 3]))
        }
        Light::Spot {
            color,
            position,
            direction,
            cos_inner,
            cos_outer,
        } => {
            let toward = unit(i, sub(splat(i, position), point));
            let part = cone(i, direction, cos_inner, cos_outer, toward);
            let lit = part.simd_gt(0.0) & i.mask(color != [0.0; 3]);
            (scale(splat(i, color), part), toward, lit)
        }
        Light::Punctual {
            intensity,
            position,
            range,
            ref cone,
        } => {
            let way = sub(splat(i, position), point);
            let toward = unit(i, way);
            let part = falloff(i, range, cone.as_ref(), way, toward);
            let lit = part.simd_gt(0.0) & i.mask(intensity != [0.0; 3]);
            (scale(splat(i, intensity), part), toward, lit)
        }
    }
}

/// Fraction of a spot light's strength at points, 0..=1. `toward` are the unit directions from the points to the light; a point in
/// the light receives none.
#[inline(always)]
fn cone<I: Isa>(
    i: I,
    direction: [f32; 3],
    cos_inner: f32,
    cos_outer: f32,
    toward: Vector<I>,
) -> I::F32 {
    let along = -dot(splat(i, crate::unit(direction)), toward);
    let x = (along - cos_outer) / (cos_inner - cos_outer);
    let between = x * x * (i.f32(3.0) - x * 2.0);
    let inner = along.simd_ge(cos_inner).select(i.f32(1.0), between);
    let out = is_zero(i, toward) | along.simd_lt(cos_outer);
    out.select(i.f32(0.0), inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::Scalar;

    /// Also where whole exponents and others stand side by side.
    #[test]
    fn exponents_of_their_own_give_the_bits_of_one_for_all() {
        let ns = [
            0.0, 1.0, 5.0, 20.5, 255.0, 256.0, 257.0, 0.25, 3.0, 100.0, 31.0, 1e4, 64.0, 17.0,
            -1.0, -0.0,
        ];
        let x: [f32; 16] = core::array::from_fn(|i| 1e-3 + i as f32 / 14.9);
        let whole = ns.map(|n: f32| n.abs().floor().min(256.0));
        for ns in [ns, whole] {
            check(Scalar, &ns, &x);
            every_width!(i => check(i, &ns, &x));
        }
        fn check<I: Isa>(i: I, ns: &[f32; 16], x: &[f32; 16]) {
            for at in (0..16).step_by(I::LANES) {
                let mut out = [0.0; 16];
                let each = SpecularExponentLanes::Each(i.load_f32(&ns[at..]));
                each.of(i, i.load_f32(&x[at..])).store(&mut out);
                for lane in 0..I::LANES {
                    let (ns, x) = (ns[at + lane], x[at + lane]);
                    let one = SpecularExponent::new(ns).of(Scalar, x);
                    assert_eq!(out[lane].to_bits(), one.to_bits(), "{x}^{ns}");
                    let mut same = [0.0; 16];
                    SpecularExponent::new(ns).of(i, i.f32(x)).store(&mut same);
                    assert_eq!(same[0].to_bits(), one.to_bits(), "{x}^{ns}");
                }
            }
        }
    }
}
