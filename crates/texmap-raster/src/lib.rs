//! Triangles to pixels: clipping, exact coverage, depth, visibility and perspective-correct interpolation, on the CPU.
//!
//! The crate knows nothing of textures: attributes are plain `f32` values, and what to do with a fragment is the caller's.
//! The same input gives the same bits everywhere: coverage is integer arithmetic, values use only `+ - * /` and comparisons.
//!
//! # Conventions
//! - Pixel (x, y): y counts from the top row. Its centre is at +0.5.
//! - Clip space: z in 0..w reversed (z = w at the near plane, 0 at the far plane), y up. Front faces are counter-clockwise.
//! - Vertices are snapped to 1/256 pixel for coverage, and a centre on an edge belongs to the triangle to its right or, for
//!   horizontal edges, below it (the top-left rule): triangles that share an edge leave no gap and hit no pixel twice.
//! - Attributes, 1/w and depth come from the unsnapped f64 positions, as planes about the centre of a fixed 64x64 tile, one
//!   divide a pixel, and are clamped to the hull of the triangle's vertex values (Vulkan 1.4 asks for a convex combination).
//! - A triangle with a NaN or infinite position or attribute is dropped and counted.
//!
//! ```
//! use texmap_raster::{DrawCall, Fragment, NoAlphaTest, BinnedDraws, TargetSize, VisibilityBuffer, NO_PRIMITIVE};
//!
//! // A triangle over the left half of an 8x8 target, at depth 0.5, with one attribute.
//! let draw = DrawCall {
//!     positions: &[[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [-1.0, 1.0, 0.5]],
//!     indices: &[[0, 1, 2]],
//!     attributes: &[0.0, 8.0, 0.0],
//!     attribute_count: 1,
//!     ..DrawCall::default()
//! };
//! let prepared = BinnedDraws::new(TargetSize::new(8, 8)?, &[draw])?;
//! let mut buffers = VisibilityBuffer::new();
//! prepared.visible(0, &NoAlphaTest, &mut buffers);
//! assert_eq!(buffers.id.iter().filter(|&&id| id != NO_PRIMITIVE).count(), 28);
//!
//! let mut fragment = Fragment::default();
//! prepared.evaluate(buffers.id[7 * 64 + 2], 2, 7, &mut fragment);
//! assert_eq!((fragment.values[0], fragment.ddx[0], fragment.depth), (2.5, 1.0, 0.5));
//! # Ok::<(), texmap_raster::RasterError>(())
//! ```
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;

mod atlas;
mod coverage;
mod draw;
mod error;
mod front_end;
mod interpolate;
pub mod reference;
mod setup;
mod visibility;

pub use atlas::{Atlas, AtlasMesh, AtlasOptions, Coverage};
pub use coverage::edge::SUBPIXEL_BITS;
pub use coverage::stamp::block_index;
pub use draw::{
    Cull, DepthTest, DrawCall, Interp, MAX_ATTRIBUTES, MAX_SUBDIVISIONS, Pass, Stats, TargetSize,
};
pub use error::RasterError;
pub use front_end::prepared::{BinnedDraws, Tile};
pub use interpolate::{
    BATCH_PIXELS, BATCH_STRIDE, BlockSink, BlockValues, FragmentBlock, Varying, Varyings,
};
pub use setup::plane_table::AttributePlanes;
pub use setup::{Fragment, TILE, TriangleSetup};
pub use visibility::blocks::{SAMPLES_4, SampleSetup, TileVisibility};
pub use visibility::depth_only::DepthStrip;
pub use visibility::fragments::{VisibleFragment, triangles};
pub use visibility::grazing_facets::GrazingFacets;
pub use visibility::visible::{AlphaTest, NO_PRIMITIVE, NoAlphaTest, UvBlock, VisibilityBuffer};
