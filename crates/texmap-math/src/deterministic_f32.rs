//! Deterministic elementary functions in f32, for one value and for lanes of [`Isa`](crate::simd::Isa): the same bits on every machine and level.
//!
//! Each is computed in f64 by one formula, written once for scalars and lanes, and rounded to f32 at the end. The error is below
//! [`MAX_ULPS`] units in the last place, subnormal results included: all but correctly rounded. `sin` and `cos` are so for every finite number.
//! Special values follow IEEE 754-2019, section 9.2; every NaN result is the constant `f32::NAN`.

mod arc;
mod exp_log;
mod trig;
mod wide;

pub use arc::{acos, asin, asin_lanes, atan, atan2, atan2_lanes};
pub use exp_log::{exp, exp2, exp2_lanes, ln, log2, log2_lanes, pow, pow_lanes};
pub use trig::{cos, cos_lanes, sin, sin_cos, sin_lanes, tan};

/// The largest error of any function here, in units in the last place of the exact result.
pub const MAX_ULPS: f64 = 0.51;
