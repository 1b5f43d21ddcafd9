//! Effects for sixteen points at once, for stages that are generic over the SIMD level; outside semantic versioning.
//!
//! Each function gives, lane by lane, the bits of its scalar twin, which stands beside it.

use texmap_math::fearless_simd::{Simd, f32x16};

pub use crate::mirror::{MirrorView, RayLanes, reflect_across_lanes, reflect_lanes};

/// A vector in each lane.
pub type V3<S> = [f32x16<S>; 3];

#[inline(always)]
pub(crate) fn dot3<S: Simd>(a: V3<S>, b: V3<S>) -> f32x16<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
