//! The mathematics of texture mapping: perspective-correct interpolation and its error bounds, texture frames, homographies,
//! cameras, exact coverage, colour transfer, and elementary functions with the same bits on every machine.
//!
//! # Example
//! A floor that runs away from the eye: half-way along its picture is not half-way along the floor.
//! ```
//! use texmap_math::glam::DVec3;
//! use texmap_math::{TextureFrame, affine_error, interpolation};
//!
//! // u from the near edge (distance 1) to the far edge (distance 4), at the middle of the screen span.
//! let u = interpolation::perspective([0.0], 1.0, [1.0], 0.25, 0.5)[0];
//! assert_eq!(u, 0.2);
//! // Affine interpolation would say 0.5. Its largest error has a closed form: (sqrt 4 - 1)/(sqrt 4 + 1).
//! assert!((affine_error::max_error(4.0) - 1.0 / 3.0).abs() < 1e-15);
//! // 256 texels to half a texel: so many equal spans would do.
//! assert_eq!(affine_error::screen_subdivisions_for(4.0, 256.0, 0.5), Some(37));
//!
//! // The same floor as a frame O, U, V in camera space: any view direction gives its uv, without a vertex.
//! let floor = TextureFrame::new(DVec3::new(0.0, -1.0, -1.0), DVec3::X, DVec3::NEG_Z * 3.0)?;
//! let uv = floor.texgen().uv(DVec3::new(0.0, -1.0, -1.6)).expect("below the horizon");
//! assert!((uv.y - 0.2).abs() < 1e-15);
//! # Ok::<(), texmap_math::FrameError>(())
//! ```
//!
//! # What is where
//! - [`interpolation`], [`plane`], [`bary`]: attributes over a span and over a triangle, with derivatives; [`affine_error`]: what the
//!   screen-linear shortcut costs.
//! - [`texture_frame`], [`homography`], [`camera`], [`projector`], [`reflection`]: maps between texture, space and screen, in f64.
//! - [`fixed`], [`edge`]: 24.8 positions, exact edge functions, the top-left rule.
//! - [`deterministic_f64`], [`deterministic_f32`], [`float`], [`color`]: deterministic functions; [`wrap`], [`footprint`]: texel choice.
//! - [`memory`]: the budget that large buffers ask; [`progress`]: callbacks that hear of long work and may end it.
//!
//! # Conventions of the workspace
//! - The centre of texel i of N lies at `(i + 0.5)/N`; the internal texture origin is top-left, a bottom-left texture is flipped at fetch, in
//!   integers, never by `1 - v`.
//! - Right-handed, +Y up; the camera looks along -Z; front faces are counter-clockwise. On the screen x runs right and y down; pixel centres lie at `.5`.
//! - Depth is reversed: 1 at the near plane, 0 at the far plane or infinity.
//! - `w` is clip w, the distance along the line of sight; `inv_w` is 1/w, linear on the screen. Angles are radians.
//! - Filtering and lighting happen in linear light, premultiplied.
//!
//! # The same bits everywhere
//! Only IEEE `+ - * /` and square roots, comparisons, integer operations and conversions of values in range: no fused
//! multiply-add, no approximate reciprocal, no platform libm. The features `std` (default) and `libm` choose where square roots and
//! rounding come from; both round exactly, so the bits agree. Lanes give the bits of the scalar form on every SIMD level.
//!
//! # Limits
//! - Matrices and frames are f64 only. Screen positions that are snapped stay within 2^21 pixels.
//! - Functions on raw numbers pass NaN on; constructors refuse it with an error.
//! - Determinism assumes the default rounding mode, and subnormals neither flushed nor read as zero for values that small.
//!
//! # Sources
//! MIT 6.837 (Fall 2001), lectures 6 and 18; D. Brackeen, "Developing Games in Java" (2003), chapter 8; P. Heckbert, "Fundamentals of
//! Texture Mapping and Image Warping" (1989); J. Blinn, "Hyperbolic Interpolation" (1992); J.-M. Muller, "Elementary Functions" (3rd ed., 2016). Each item names its own.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]
#![cfg_attr(
    not(any(
        target_arch = "x86",
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )),
    allow(
        dead_code,
        unused_imports,
        unused_variables,
        reason = "without a vector unit the scalar versions of the kernels do all of the work"
    )
)]

extern crate alloc;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("texmap-math needs the feature `std` or `libm` (square roots and rounding)");

pub mod affine_error;
pub mod bary;
pub mod camera;
pub mod color;
pub mod deterministic_f32;
pub mod deterministic_f64;
pub mod edge;
pub mod fixed;
pub mod float;
pub mod footprint;
pub mod hilbert;
pub mod homography;
pub mod interpolation;
#[doc(hidden)]
pub mod lanes;
pub mod memory;
mod on_level;
#[doc(hidden)]
pub mod parallel;
pub mod plane;
pub mod progress;
pub mod projector;
pub mod reflection;
#[doc(hidden)]
pub mod simd;
pub mod texture_frame;
pub mod vector;
pub mod view_rays;
pub mod wrap;

pub use camera::{Camera, CameraError};
pub use fearless_simd;
pub use fearless_simd::Level;
pub use footprint::Footprint;
pub use glam;
pub use homography::{Homography, HomographyError};
pub use memory::{MemoryBudget, OverBudget};
#[doc(hidden)]
pub use on_level::LANES;
pub use projector::Projector;
pub use texture_frame::{FrameError, PlanarTexgen, TextureFrame};
pub use vector::{narrow, wide};
pub use view_rays::{CameraFrame, ViewRays};
