//! A texture sampler for the CPU: right to the texel centre, linear light, the same bits on every machine.
//!
//! # Conventions
//! - Texel `i` of `n` has its centre at `(i + 0.5) / n`; a coordinate picks a texel by floor.
//! - `v = 0` is the first row of a [`Origin::TopLeft`] texture and the last row of a
//!   [`Origin::BottomLeft`] one. The flip happens at fetch, on integer rows, never as `1 - v`.
//! - Results are linear light with premultiplied alpha. sRGB texels are decoded before they are filtered.
//! - A NaN or infinite coordinate reads as 0 (infinities clamp to the edge where the wrap clamps);
//!   a NaN derivative reads as 0. Nothing here panics on data.
//!
//! # Example
//! One look-up, one with a footprint, and a batch:
//! ```
//! use texmap_math::{Footprint, Level};
//! use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, Wrap, sample_slice};
//!
//! let texels = vec![0, 0, 0, 255, 255, 255, 255, 255];
//! let t = Texture2d::from_rgba8(2, 1, texels, ColorSpace::Srgb, Origin::TopLeft)?.with_mips();
//! let s = Sampler { filter: Filter::Trilinear, wrap_u: Wrap::ClampToEdge, ..Sampler::default() };
//!
//! // Halfway between black and white is half the light, not half the byte.
//! assert!((s.sample(&t, [0.5, 0.5])[0] - 0.5).abs() < 1e-4);
//! // A pixel as large as the image sees its mean, wherever it looks.
//! let whole = Footprint::new(1.0, 0.0, 0.0, 1.0);
//! assert!((s.sample_grad(&t, [0.1, 0.5], whole)[0] - 0.5).abs() < 1e-4);
//!
//! let mut out = [[0.0; 4]; 3];
//! sample_slice(Level::new(), &s, &t, &[0.25, 0.5, 0.75], &[0.5; 3], None, &mut out)?;
//! assert_eq!((out[0][0], out[2][0]), (0.0, 1.0));
//! # Ok::<(), texmap_sample::SampleError>(())
//! ```
//!
//! # How it is built
//! Each filter has an f64 definition in [`mod@reference`] and one kernel in f32, written over the number of lanes: one for a single
//! look-up, four or sixteen for batches, with the same bits on SSE2, AVX2, AVX-512 and NEON and for texels of any kind, size and wrap
//! (integers that repeat over powers of two are the fast case; floats and bytes that stay encoded are fetched one by one). The tests
//! state the bound between the two.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;

mod address;
mod antialias;
mod atlas;
mod batch;
mod blocks;
mod bound_texture;
mod compare;
mod cube;
mod dependent;
mod encoded;
mod error;
mod fetch;
mod filter;
#[doc(hidden)]
pub mod lanes;
mod mip;
mod pattern;
pub mod reference;
mod resample;
mod rgba8;
mod sampler;
mod srgb_codes;
mod texel_data;
mod texture;
mod transform;
mod upload;
mod vectors;
mod volume;
mod volume_integrator;

pub use address::wrap::Wrap;
pub use atlas::AtlasRect;
pub use batch::{
    Places, is_exact_in_rgba8, sample_rgba8_slice, sample_rgba8_soa, sample_slice, sample_soa,
};
pub use blocks::{BlockFormat, BlockImage};
pub use compare::Compare;
pub use cube::{DirectionBatch, TextureCube, cube_direction, cube_face, sample_cube_soa};
pub use dependent::sample_dependent_soa;
pub use error::SampleError;
pub use pattern::{Pattern, gradient_noise};
pub use resample::{EdgeMode, Resample};
pub use sampler::{Cubic, Filter, Lod, Mip, Precision, Sampler, TexelFilter};
pub use texel_data::TexelData;
pub use texture::{Alpha, ColorSpace, Image, Origin, TEXEL_LIMIT, Texture2d};
pub use transform::UvTransform;
pub use volume::{Texture1d, Texture3d, UvwBatch, sample_3d_soa};
pub use volume_integrator::{MAX_STEPS, OPAQUE, RayRadiance, VolumeIntegrator};
