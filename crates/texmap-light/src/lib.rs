//! Shading and lighting effects as pure functions over points and normals: no scene, no renderer, no
//! texture reads of their own unless an effect is one.
//!
//! # Conventions
//! Right-handed space, any unit. Colours are linear light, `[r, g, b]`, 1 is white; results are clipped
//! at 1 where that is said. Directions need not be of unit length. Points, normals and the eye share one
//! space (the renderer uses world space).
//!
//! Every formula is written once over lane widths: functions of one point and functions over slices are its widths, with the same
//! bits, and an f64 reference in [`mod@reference`] is written for reading. Only IEEE `+ - * / sqrt`, comparisons and
//! `texmap_math::deterministic_f32` are used, so that the bits are equal on every machine.
//!
//! ```
//! use texmap_light::{Light, PhongMaterial, illuminate};
//! let lights = [
//!     Light::Ambient { color: [0.1; 3] },
//!     Light::Directional { color: [1.0; 3], direction: [0.0, -1.0, 0.0] }, // shines down
//! ];
//! let matte = PhongMaterial { color: [0.5, 0.25, 1.0], ka: 1.0, kd: 0.8, ks: 0.0, ns: 1.0 };
//! let lit = illuminate(&matte, &lights, [0.0; 3], [0.0, 1.0, 0.0], [0.0, 3.0, 4.0]);
//! for (value, expected) in lit.into_iter().zip([0.45, 0.225, 0.9]) {
//!     assert!((value - expected).abs() < 1e-6);
//! }
//! ```
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;

/// Runs a kernel at every width, on the best level and on the least.
#[cfg(test)]
macro_rules! every_width {
    ($i:ident => $kernel:expr) => {
        for level in [texmap_math::Level::new(), texmap_math::Level::baseline()] {
            texmap_math::dispatch_simd!(level, $i => $kernel);
            texmap_math::dispatch_simd!(level, wide $i => $kernel);
        }
    };
}

mod albedo;
mod bump;
mod cube_face;
mod environment;
mod environment_layout;
mod environment_light;
mod environment_lookup;
mod error;
pub mod lanes;
mod metallic_roughness;
mod normal_map;
mod packed;
mod phong;
mod points;
mod projector_texture;
mod punctual;
pub mod reference;
mod reflect;
mod reflection_lobes;
mod roughness_table;
mod shade;
mod shadow;
mod shadow_bounds;
mod shadow_reader;
mod share;
mod shared_exponent;
mod tone_map;
mod vector;

pub use albedo::split_sum;
pub use bump::{
    Heights, NormalMapGreen, Slope, bump, decode_normal, decode_offsets, encode_normal,
    encode_offsets,
};
pub use environment::Environment;
pub use environment_layout::{EnvironmentLayout, UnknownLayout};
pub use environment_light::{
    EnvironmentLight, EnvironmentSample, LEAST_SAMPLE_COSINE, Prefilter, Roughnesses,
};
pub use error::LightError;
pub use metallic_roughness::{
    MIN_ROUGHNESS, MetallicRoughnessSurface, SHEEN_MIN_ROUGHNESS, dielectric_f0,
};
pub use normal_map::NormalMap;
pub use phong::{Light, PhongMaterial, SpecularModel};
pub use points::{
    LightContribution, Lighting, Ray, bump_on, clamp_to_horizon, clamp_unit_to_horizon,
    evaluate_light, perturb, perturb_slice, reflect, reflect_across, unit,
};
pub use projector_texture::{
    BoundProjectorTexture, ProjectorBorder, ProjectorTexture, projector_texel,
};
pub use punctual::LightCone;
pub use reflect::ReflectionBox;
pub use reflection_lobes::{ReflectionLobeLanes, ReflectionLobes, ReflectionLobesLanes};
pub use shade::{
    illuminate, illuminate_slice, illuminate_two_sided, lighting, lighting_slice,
    shade_with_visibility,
};
pub use shadow::{ShadowBias, ShadowKind, ShadowMap};
#[doc(hidden)]
pub use shadow_bounds::{FiniteColumns, ShadowBounds, StripBounds};
pub use shadow_reader::ShadowSampler;
pub use share::SpecularExponent;
pub use tone_map::ToneMap;

/// The level of this CPU; no bit depends on it.
fn level() -> texmap_math::Level {
    texmap_math::Level::try_detect().unwrap_or(texmap_math::Level::baseline())
}
