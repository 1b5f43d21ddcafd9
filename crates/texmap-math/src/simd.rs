//! Kernels over lane widths. One source gives the scalar form ([`Scalar`], one lane), four lanes ([`X4`]) and sixteen ([`X16`]);
//! outside semantic versioning.
//!
//! A kernel takes `i: I` where `I: Isa`, computes on `I::F32`, `I::I32`, `I::U32`, `I::F64` and masks, and is run by
//! [`dispatch_simd!`](crate::dispatch_simd). Every operation is lane-wise and exact to the bit of its scalar form, so that neither
//! width nor level changes a result; the one that may, [`Isa::estimate_mul_add`], is for estimates that are made exact afterwards. A kernel
//! asks for no other fused multiply-add, no approximate reciprocal, and no minimum of floats by another name than [`F32s::above`] and
//! [`F32s::below`].
//!
//! ```
//! use texmap_math::simd::{Isa, Scalar, prelude::*};
//! use texmap_math::{Level, dispatch_simd};
//!
//! /// `a + (b - a) t`, where `t` is above zero.
//! #[inline(always)]
//! fn blend<I: Isa>(i: I, a: I::F32, b: I::F32, t: I::F32) -> I::F32 {
//!     let t = t.simd_gt(0.0).select(t, i.f32(0.0));
//!     a + (b - a) * t
//! }
//!
//! let t: [f32; 16] = core::array::from_fn(|k| k as f32 / 8.0 - 0.5);
//! let mut out = [0.0; 16];
//! dispatch_simd!(Level::new(), i => lanes(i, &t, &mut out));
//! #[inline(always)]
//! fn lanes<I: Isa>(i: I, t: &[f32], out: &mut [f32]) {
//!     for (t, out) in t.chunks_exact(I::LANES).zip(out.chunks_exact_mut(I::LANES)) {
//!         blend(i, i.f32(2.0), i.f32(4.0), i.load_f32(t)).store(out);
//!     }
//! }
//! assert_eq!(out[8], blend(Scalar, 2.0, 4.0, 0.5));
//! ```

mod bytes;
mod dispatch;
mod encode;
mod isa;
mod scalar;
mod shuffle;
mod wide;

pub use crate::lanes::GatherTable;
pub use bytes::{ByteHalves, ByteIsa};
pub use dispatch::KernelLevel;
pub use encode::{encode_srgb8, encode_unorm8};
pub use fearless_simd::Level;
pub use isa::{Compare, F32s, Float, I32s, Int, Isa, Mask, Number, Select, U32s};
pub use scalar::{One, Scalar};
pub use wide::{Pair, X4, X16};

/// The traits whose methods kernels call.
pub mod prelude {
    pub use super::{Compare, F32s, Float, I32s, Int, Isa, Mask, Number, Select, U32s};
}
