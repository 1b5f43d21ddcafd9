//! Kernels for stages of one's own; outside semantic versioning.
//!
//! Every function gives, lane by lane, the bits of a single look-up for each number of lanes, on every SIMD level. All that can
//! change a bit (level, probes, wrap) is decided per lane; tests on whole vectors only choose between paths that give the same bits.
//!
//! A stage over lanes, with the dispatch around it:
//! ```
//! use texmap_math::simd::{ByteIsa, Isa, prelude::*};
//! use texmap_math::{Level, dispatch_simd};
//! use texmap_sample::lanes::{BoundTexture, packed};
//! use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d};
//!
//! #[inline(always)]
//! fn stage<I: ByteIsa>(i: I, view: &BoundTexture<'_>, u: &[f32], out: &mut [u32]) {
//!     for (u, out) in u.chunks_exact(I::LANES).zip(out.chunks_exact_mut(I::LANES)) {
//!         packed::bilinear_lanes(i, view, i.load_f32(u), i.f32(0.5)).store(out);
//!     }
//! }
//!
//! let texels = vec![0, 0, 0, 255, 200, 100, 50, 255];
//! let t = Texture2d::from_rgba8(2, 1, texels, ColorSpace::Linear, Origin::TopLeft)?;
//! let s = Sampler { filter: Filter::Bilinear, precision: Precision::Fast, ..Sampler::default() };
//! let view = BoundTexture::new(&s, &t).expect("a texture has texels");
//! let u: [f32; 16] = core::array::from_fn(|i| i as f32 / 16.0);
//! let mut out = [0; 16];
//! dispatch_simd!(Level::new(), i => stage(i, &view, &u, &mut out));
//! // u = 1/4 and 3/4 are the centres, 1/2 lies halfway.
//! assert_eq!(out[4].to_le_bytes(), [0, 0, 0, 255]);
//! assert_eq!(out[8].to_le_bytes(), [100, 50, 25, 255]);
//! assert_eq!(out[12].to_le_bytes(), [200, 100, 50, 255]);
//! # Ok::<(), texmap_sample::SampleError>(())
//! ```

pub use crate::batch::{JointTextures, sample_bound_soa};
pub use crate::bound_texture::{
    ANY, BLOCKS, BoundTexture, RGBA8, RGBA8_EXACT, RGBA16, SCALAR_FETCH,
};
pub use crate::filter::Kernel;
pub use crate::pattern::gradient_noise_lanes;

/// Filters with 8-bit weights on views whose format is [`RGBA8`].
pub mod packed {
    pub use crate::address::lod::TexelFootprint as FootprintLanes;
    pub use crate::rgba8::{
        anisotropic::anisotropic as anisotropic_lanes, bilinear::bilinear as bilinear_lanes,
        lod as lod_lanes, nearest::PowerOfTwoTexture, nearest::nearest as nearest_lanes,
        trilinear::trilinear as trilinear_lanes, unpack as unpack_lanes,
    };
}

/// Filters with f32 weights on views of the other formats; `FORMAT` is the view's or [`ANY`].
pub mod float {
    pub use crate::address::lod::lod as lod_lanes;
    pub use crate::fetch::Color;
    pub use crate::filter::{
        anisotropic::anisotropic as anisotropic_lanes, bilinear::level_0 as bilinear_lanes,
        trilinear::trilinear as trilinear_lanes,
    };
}
