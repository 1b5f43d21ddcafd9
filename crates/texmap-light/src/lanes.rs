//! Effects for sixteen points at once, for stages that are generic over the SIMD level; outside semantic versioning.
//!
//! Each function gives, lane by lane, the bits of its scalar twin, which stands beside it.

use texmap_math::fearless_simd::f32x16;

pub use crate::bump::bump_on_lanes;
pub use crate::mirror::EnvironmentView;
pub use crate::normal_map::clamp_to_horizon_lanes;
pub use crate::reflect::{RayLanes, reflect_across_lanes, reflect_lanes};
pub use crate::share::{PowerLanes, ShareLanes, share_lanes};
pub use crate::slide::SlidePlaces;
pub use crate::vector::{affine_lanes, cross_lanes, dot_lanes, spread, unit_lanes};

/// A vector in each lane.
pub type V3<S> = [f32x16<S>; 3];
