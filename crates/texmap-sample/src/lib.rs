//! A texture sampler for the CPU: right to the texel centre, linear light, the same bits on every machine.
//!
//! # Conventions
//! - Texel `i` of `n` has its centre at `(i + 0.5) / n`; a coordinate picks a texel by floor.
//! - `v = 0` is the first row of a [`Origin::TopLeft`] texture and the last row of a
//!   [`Origin::BottomLeft`] one. The flip happens at fetch, on integer rows, never as `1 - v`.
//! - Results are linear light with premultiplied alpha. sRGB texels are decoded before they are filtered.
//! - A NaN or infinite coordinate reads as 0 (infinities clamp to the edge where the wrap clamps);
//!   a non-finite derivative reads as 0. Nothing here panics on data.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;

mod atlas;
mod compare;
mod cube;
mod dependent;
mod error;
mod filter;
#[doc(hidden)]
pub mod lanes;
mod lod;
mod mip;
pub mod reference;
mod resample;
mod sampler;
mod slice;
mod summed_area;
mod texels;
mod texture;
mod transform;
mod volume;
mod wrap;

pub use atlas::AtlasRect;
pub use compare::Compare;
pub use cube::{TextureCube, cube_direction, cube_face};
pub use error::SampleError;
pub use resample::{Outside, Resample};
pub use sampler::{Cubic, Filter, Lod, Mip, Precision, Sampler, Texel};
pub use slice::{sample_rgba8_slice, sample_slice};
pub use summed_area::SummedArea;
pub use texels::Texels;
pub use texture::{Alpha, ColorSpace, Image, Origin, Texture2d};
pub use transform::UvTransform;
pub use volume::{Texture1d, Texture3d};
pub use wrap::Wrap;
