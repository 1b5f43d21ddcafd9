//! Effects for the lanes of an [`Isa`], for stages that are generic over it; outside semantic versioning.
//!
//! One source gives every width: a lane has the bits that [`Scalar`](texmap_math::simd::Scalar) gives its point, on every SIMD level.

use texmap_math::simd::{Isa, X16};

pub use crate::bump::bump_on;
pub use crate::metallic_roughness::{
    ClearcoatLanes, EnvironmentVisibilityLanes, MetallicRoughnessLanes, ReflectanceLanes,
    SheenLanes,
};
pub use crate::normal_map::{clamp_to_horizon, perturb};
pub use crate::projector_texture::ProjectorUvBatch;
pub use crate::reflect::{RayLanes, reflect, reflect_across};
pub use crate::shade::TermsLanes;
pub use crate::share::{LightContributionLanes, SpecularExponentLanes, evaluate_light};
pub use crate::vector::{affine, cross, dot, splat, unit};

/// A vector in each lane.
pub type Vector<I> = [<I as Isa>::F32; 3];

/// A vector in each of sixteen lanes.
pub type V3<S> = Vector<X16<S>>;
