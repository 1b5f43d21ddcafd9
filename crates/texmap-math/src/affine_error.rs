//! Error of affine (screen-linear) interpolation, in closed form.
//!
//! Over a span whose ends have 1/w in the ratio `r = inv_w2 / inv_w1`, affine interpolation puts the parameter at t where it should be at
//! s(t); the error is `e(t) = s(t) - t = k t (1 - t) / (1 + k t)` with `k = r - 1` (Heckbert and Moreton, "Interpolation for Polygon
//! Texture Mapping and Shading", 1991). Setting its derivative to zero gives the rest. Each function is a fraction of the
//! attribute's change over the span; multiply by |u2 - u1|. All take `r > 0`, above 1 where the far end comes first; NaN gives NaN.

use crate::float::{ceil, sqrt};

/// e(t) = s(t) - t.
#[must_use]
pub fn error_at(t: f64, ratio: f64) -> f64 {
    let k = ratio - 1.0;
    k * t * (1.0 - t) / (1.0 + k * t)
}

/// The largest |e|: `|sqrt r - 1| / (sqrt r + 1)`. It also bounds a whole triangle, with r over its three vertices and the range of
/// the attribute, and the shift on the screen as a fraction of the span.
#[must_use]
pub fn max_error(ratio: f64) -> f64 {
    let root = sqrt(ratio);
    // (r - 1)/(sqrt r + 1)^2 keeps its digits for r near 1.
    (ratio - 1.0).abs() / ((root + 1.0) * (root + 1.0))
}

/// Position of the largest error on the screen: `t = 1 / (1 + sqrt r)`; in space at `s = 1 - t`.
#[must_use]
pub fn max_error_at(ratio: f64) -> f64 {
    1.0 / (1.0 + sqrt(ratio))
}

/// The largest |e| after cutting the span into `n` equal parts of the screen with exact ends. The worst part is the far one.
#[must_use]
pub fn screen_subdivision_error(ratio: f64, n: u32) -> f64 {
    let r = if ratio < 1.0 { 1.0 / ratio } else { ratio };
    let n = f64::from(n);
    let d = (r - 1.0) / n;
    let root = 1.0 + sqrt(1.0 + d);
    r * (r - 1.0) / (n * n) / ((1.0 + d) * root * root)
}

/// A bound of [`screen_subdivision_error`] and the limit of n^2 times it: `r (r - 1) / (4 n^2)`.
#[must_use]
pub fn screen_subdivision_bound(ratio: f64, n: u32) -> f64 {
    let r = if ratio < 1.0 { 1.0 / ratio } else { ratio };
    let n = f64::from(n);
    r * (r - 1.0) / (4.0 * n * n)
}

/// The largest |e| after cutting the span into `n` parts that are equal in space, as a subdivided mesh is. The worst part is the near one.
#[must_use]
pub fn world_subdivision_error(ratio: f64, n: u32) -> f64 {
    let r = if ratio < 1.0 { 1.0 / ratio } else { ratio };
    let n = f64::from(n);
    // Distances run evenly from 1 to r; the near part ends at 1 + (r - 1)/n.
    max_error(1.0 + (r - 1.0) / n) / n
}

/// A bound of [`world_subdivision_error`]: `(r - 1) / (4 n^2)`.
#[must_use]
pub fn world_subdivision_bound(ratio: f64, n: u32) -> f64 {
    let r = if ratio < 1.0 { 1.0 / ratio } else { ratio };
    let n = f64::from(n);
    (r - 1.0) / (4.0 * n * n)
}

/// The fewest equal screen parts whose error times `change` = |u2 - u1| is within `budget`. None where no u32 is enough, the budget is
/// not above 0 or a number is NaN.
#[must_use]
pub fn screen_subdivisions_for(ratio: f64, change: f64, budget: f64) -> Option<u32> {
    fewest(
        ratio,
        change,
        budget,
        screen_subdivision_error,
        screen_subdivision_bound,
    )
}

/// The same for equal parts in space.
#[must_use]
pub fn world_subdivisions_for(ratio: f64, change: f64, budget: f64) -> Option<u32> {
    fewest(
        ratio,
        change,
        budget,
        world_subdivision_error,
        world_subdivision_bound,
    )
}

/// The bound falls as 1/n^2, so its root is enough; the exact form falls too, so bisect below that.
fn fewest(
    ratio: f64,
    change: f64,
    budget: f64,
    exact: fn(f64, u32) -> f64,
    bound: fn(f64, u32) -> f64,
) -> Option<u32> {
    let change = change.abs();
    if !(budget > 0.0 && ratio > 0.0 && ratio.is_finite() && change.is_finite()) {
        return None;
    }
    let fits = |n: u32| exact(ratio, n) * change <= budget;
    if fits(1) {
        return Some(1);
    }
    let enough = ceil(sqrt(bound(ratio, 1) * change / budget)) + 1.0;
    let (mut low, mut high) = (
        1,
        if enough < f64::from(u32::MAX) {
            enough as u32
        } else {
            u32::MAX
        },
    );
    if !fits(high) {
        return None;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if fits(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}
