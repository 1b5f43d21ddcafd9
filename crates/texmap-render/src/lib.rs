//! Scenes to frames: the thin renderer that joins texmap's crates.
#![forbid(unsafe_code)]

mod check;
mod error;
mod frame;
mod scene;
mod settings;

pub use error::RenderError;
pub use frame::{AovData, Frame, HOLE_BITS, Stats, Times, pixel_hash};
pub use scene::{
    AlphaMode, ColorMode, Gouraud, Material, Mesh, Scene, Shading, TextureRole, TextureSlot,
};
pub use settings::{Aov, Settings, UnknownAov};
