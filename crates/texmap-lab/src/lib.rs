//! The truth that texmap is held against: metrics of two images, an f64 reference of a whole frame, the
//! accuracy scenes, the failure cases and the demos of the lectures.
//!
//! Nothing here is fast and nothing here shares a code path with what it judges: the reference casts one ray
//! through each pixel centre in f64, where the renderer clips, snaps and evaluates planes.
//!
//! Conventions: rows run top to bottom, a pixel centre lies at `(x + 0.5, y + 0.5)`, channel values are
//! interleaved, a hole in a float image is NaN.
//!
//! ```
//! use texmap_lab::metrics::{Shape, compare};
//!
//! let shape = Shape { width: 2, height: 1, channels: 1 };
//! let figures = compare(shape, &[0.0, 1.0], &[0.0, 0.5], 0.1)?;
//! assert_eq!(figures.max, 0.5);
//! assert_eq!(figures.max_at.unwrap().x, 1);
//! assert_eq!(figures.over_limit, 1);
//! # Ok::<(), texmap_lab::metrics::MetricsError>(())
//! ```
#![forbid(unsafe_code)]

pub mod buffer;
pub mod cases;
pub mod chart;
pub mod demos;
mod error;
pub mod metrics;
pub mod picture;
pub mod plane;
pub mod reference;
pub mod scenes;
pub mod shading;
pub mod shadow_scene;
mod shadow_shapes;
pub mod shadow_truth;
pub mod ssim;
pub mod strip;
pub mod topology;
pub mod truth;
pub mod uv_pictures;
pub mod verify;

pub use error::LabError;
