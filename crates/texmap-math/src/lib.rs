//! texmap-math
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("texmap-math needs the feature `std` or `libm` (square roots and rounding)");

pub mod affine_error;
pub mod bary;
pub mod camera;
pub mod color;
pub mod det;
pub mod det32;
pub mod edge;
pub mod fixed;
pub mod float;
pub mod footprint;
pub mod frame;
pub mod homography;
pub mod interp;
#[doc(hidden)]
pub mod lanes;
pub mod plane;
pub mod projector;
pub mod reflection;
pub mod wrap;

pub use camera::{Camera, CameraError};
pub use fearless_simd;
pub use fearless_simd::Level;
pub use footprint::Footprint;
pub use frame::{FrameError, MagicVectors, TextureFrame};
pub use glam;
pub use homography::{Homography, HomographyError};
pub use projector::Projector;
