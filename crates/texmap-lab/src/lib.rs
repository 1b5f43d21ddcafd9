//! Experiments with texmap: failure cases with measured figures, charts of error against time, and demos whose captions
//! state measured claims. All of them are held against the f64 reference of `texmap-truth`.
//!
//! - [`cases`] runs the failure cases of `cases.toml`, each with limits for its measurements;
//! - [`demos`] draws the captioned pictures of `texmap demo`;
//! - [`chart`] draws the panels of `texmap chart`;
//! - [`plane`], [`scenes`], [`shading`], [`shadow_scene`] are the accuracy scenes that they share.
//!
//! Conventions: rows run top to bottom, a pixel centre lies at `(x + 0.5, y + 0.5)`.
//!
//! ```
//! use texmap_lab::cases::{all, judge};
//!
//! let cases = all()?;
//! let case = cases.iter().find(|case| case.id == "R1").expect("in the list");
//! assert!(judge(case)?.iter().all(|verdict| verdict.passes()));
//! # Ok::<(), texmap_lab::LabError>(())
//! ```
#![forbid(unsafe_code)]

pub mod cases;
pub mod chart;
pub mod demos;
mod error;
pub mod plane;
pub mod scenes;
pub mod shading;
pub mod shadow_scene;
mod shadow_shapes;
pub mod shadow_truth;
pub mod topology;
pub mod uv_pictures;

pub use error::LabError;
