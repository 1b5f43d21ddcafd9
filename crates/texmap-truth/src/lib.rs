//! The f64 reference of texmap: a whole frame by ray casting, a ray tracer, image metrics, and the verification of
//! a rendered picture against the reference.
//!
//! - [`frame()`] computes a picture of a scene in f64, each effect from its definition;
//! - [`rays`] finds the surfaces that a ray meets: meshes and the unit solids;
//! - [`caster`] intersects one ray per pixel with triangles, as an exact homography;
//! - [`metrics`] and [`ssim`](mod@ssim) measure the difference of two images, [`buffer`] reads them from files;
//! - [`strip`](mod@strip) and [`picture`] show a difference;
//! - [`verify`](mod@verify) judges a rendered frame against the reference.
//!
//! The reference shares no code path with the renderer that it judges: it casts rays in f64 where the renderer clips,
//! snaps and interpolates planes in f32. It is slow by design.
//!
//! Conventions: rows run top to bottom, a pixel centre lies at `(x + 0.5, y + 0.5)`, channel values are interleaved,
//! a hole in a float image is NaN.
//!
//! ```
//! use texmap_truth::metrics::{Shape, compare};
//!
//! let shape = Shape { width: 2, height: 1, channels: 1 };
//! let figures = compare(shape, &[0.0, 1.0], &[0.0, 0.5], 0.1)?;
//! assert_eq!(figures.max, 0.5);
//! assert_eq!(figures.max_at.unwrap().x, 1);
//! assert_eq!(figures.over_limit, 1);
//! # Ok::<(), texmap_truth::metrics::MetricsError>(())
//! ```
#![forbid(unsafe_code)]

pub mod buffer;
pub mod caster;
mod error;
mod frame;
pub mod metrics;
pub mod picture;
pub mod rays;
pub mod ssim;
pub mod strip;
pub mod verify;

pub use error::TruthError;
pub use frame::{ASSUMPTIONS, Truth, frame, frame_by_rays};
