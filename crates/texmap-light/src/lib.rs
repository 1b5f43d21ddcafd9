//! Shading and lighting effects as pure functions over points and normals: no scene, no renderer, no
//! texture reads of their own unless an effect is one.
//!
//! # Conventions
//! Right-handed space, any unit. Colours are linear light, `[r, g, b]`, 1 is white; results are clipped
//! at 1 where that is said. Directions need not be of unit length. Points, normals and the eye share one
//! space (the renderer uses world space).
//!
//! Every function has a scalar form, a form over slices with the same bits, and an f64 reference in
//! [`mod@reference`] that is written for reading. Only IEEE `+ - * / sqrt`, comparisons and
//! `texmap_math::det32` are used, so that the bits are equal on every machine.
//!
//! ```
//! use texmap_light::{Light, Surface, illuminate};
//! let lights = [
//!     Light::Ambient { color: [0.1; 3] },
//!     Light::Directional { color: [1.0; 3], direction: [0.0, -1.0, 0.0] }, // shines down
//! ];
//! let matte = Surface { color: [0.5, 0.25, 1.0], ka: 1.0, kd: 0.8, ks: 0.0, ns: 1.0 };
//! let lit = illuminate(&matte, &lights, [0.0; 3], [0.0, 1.0, 0.0], [0.0, 3.0, 4.0]);
//! for (value, expected) in lit.into_iter().zip([0.45, 0.225, 0.9]) {
//!     assert!((value - expected).abs() < 1e-6);
//! }
//! ```
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(any(
        target_arch = "x86",
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )),
    allow(
        dead_code,
        unused_assignments,
        unused_imports,
        unused_variables,
        reason = "without a vector unit the scalar twins of the kernels do all of the work"
    )
)]
extern crate alloc;

mod bump;
mod chart;
mod cube_face;
mod environment;
mod error;
pub mod lanes;
mod mirror;
mod normal_map;
mod packed;
pub mod reference;
mod reflect;
mod shade;
mod shadow;
mod shadow_bounds;
mod shadow_reader;
mod share;
mod slide;
mod surface;
mod vector;

pub use bump::{
    Green, Heights, Slope, bump, bump_on, decode_normal, decode_offsets, encode_normal,
    encode_offsets,
};
pub use chart::{Chart, UnknownChart};
pub use environment::Environment;
pub use error::LightError;
pub use normal_map::{NormalMap, clamp_to_horizon, clamp_unit_to_horizon, perturb, perturb_slice};
pub use reflect::{Ray, reflect, reflect_across};
pub use shade::{
    Terms, illuminate, illuminate_slice, illuminate_two_sided, terms, terms_received, terms_slice,
};
pub use shadow::{ShadowBias, ShadowKind, ShadowMap};
#[doc(hidden)]
pub use shadow_bounds::{Reached, ShadowBounds, StripBounds};
pub use shadow_reader::ShadowReader;
pub use share::{Power, Share, share};
pub use slide::{Slide, SlideBorder, SlideView, slide_texel};
pub use surface::{Highlight, Light, Surface};
pub use vector::unit;
