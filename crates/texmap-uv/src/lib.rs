//! Texture coordinates for meshes.
//!
//! Conventions: right-handed, +Y up. A unit solid fills [-0.5, 0.5] on every axis, its side charts have v = 0 at
//! the top (or at the bottom, see [`Origin`]), and u rises to the right of a viewer who stands outside.
//! Coordinates are computed in f64 with texmap's own `atan2` and rounded once to f32: same bits everywhere.
//!
//! ```
//! use texmap_uv::{Origin, Projection, project};
//! let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
//! let uvs = project(&corners, &[], Projection::Plane, Origin::TopLeft);
//! assert_eq!(uvs, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
//! ```
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;

mod fallback;
mod solid;

pub use fallback::{Projection, project};
pub use solid::Origin;
