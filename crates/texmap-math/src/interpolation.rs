//! Interpolation along a span that is seen in perspective (MIT 6.837, lecture 18, slides 8 to 11).
//!
//! `t` runs evenly over the screen, `s` evenly over the edge in space, both from 0 to 1. Distances `z` (or clip w) must have one
//! sign over the span: clip before dividing. `inv_w` is 1/z.

use core::ops::{Add, Div, Mul, Sub};

/// f32 or f64.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// 1.
    const ONE: Self;
}

impl Real for f32 {
    const ONE: Self = 1.0;
}

impl Real for f64 {
    const ONE: Self = 1.0;
}

/// `a (1 - t) + b t`: exact at both ends. The form `a + t (b - a)` is neither exact at 1 nor accurate where the ends differ much in
/// size: after the perspective division it loses about 0.5 w2/w1 units of rounding, this one about 2, whatever the ratio.
#[inline(always)]
#[must_use]
pub fn lerp_two_product<T: Real>(a: T, b: T, t: T) -> T {
    a * (T::ONE - t) + b * t
}

/// s(t) from distances: `t z1 / (z2 + t (z1 - z2))`, in two-product form.
#[inline]
#[must_use]
pub fn world_from_screen_z<T: Real>(t: T, z1: T, z2: T) -> T {
    t * z1 / lerp_two_product(z2, z1, t)
}

/// s(t) from inverse distances: `t w2 / (w1 + t (w2 - w1))`, in two-product form.
#[inline]
#[must_use]
pub fn world_from_screen_inv_w<T: Real>(t: T, inv_w1: T, inv_w2: T) -> T {
    t * inv_w2 / lerp_two_product(inv_w1, inv_w2, t)
}

/// t(s), the inverse of [`world_from_screen_z`]: `s z2 / (z1 + s (z2 - z1))`.
#[inline]
#[must_use]
pub fn screen_from_world_z<T: Real>(s: T, z1: T, z2: T) -> T {
    s * z2 / lerp_two_product(z1, z2, s)
}

/// t(s), the inverse of [`world_from_screen_inv_w`]: `s w1 / (w2 + s (w1 - w2))`.
#[inline]
#[must_use]
pub fn screen_from_world_inv_w<T: Real>(s: T, inv_w1: T, inv_w2: T) -> T {
    s * inv_w1 / lerp_two_product(inv_w2, inv_w1, s)
}

/// An end of a span: attributes multiplied by 1/w, and 1/w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Premultiplied<T, const N: usize> {
    /// Each attribute times `inv_w`.
    pub attributes: [T; N],
    /// 1/w.
    pub inv_w: T,
}

impl<T: Real, const N: usize> Premultiplied<T, N> {
    /// Attributes at an end of distance 1/`inv_w`.
    #[inline]
    #[must_use]
    pub fn new(attributes: [T; N], inv_w: T) -> Self {
        Self {
            attributes: attributes.map(|a| a * inv_w),
            inv_w,
        }
    }

    /// The point at screen fraction `t` towards `other`, still multiplied. Everything is linear on the screen.
    #[inline]
    #[must_use]
    pub fn lerp(&self, other: &Self, t: T) -> Self {
        let mut attributes = self.attributes;
        for (a, b) in attributes.iter_mut().zip(other.attributes) {
            *a = lerp_two_product(*a, b, t);
        }
        Self {
            attributes,
            inv_w: lerp_two_product(self.inv_w, other.inv_w, t),
        }
    }

    /// The attributes themselves: one division for all of them.
    #[inline]
    #[must_use]
    pub fn divide(&self) -> [T; N] {
        let w = T::ONE / self.inv_w;
        self.attributes.map(|a| a * w)
    }
}

/// Perspective-correct attributes at screen fraction `t` of the span from `a` (1/w = `inv_w_a`) to `b`.
#[inline]
#[must_use]
pub fn perspective<T: Real, const N: usize>(
    a: [T; N],
    inv_w_a: T,
    b: [T; N],
    inv_w_b: T,
    t: T,
) -> [T; N] {
    Premultiplied::new(a, inv_w_a)
        .lerp(&Premultiplied::new(b, inv_w_b), t)
        .divide()
}
