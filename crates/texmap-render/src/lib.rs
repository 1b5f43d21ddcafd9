//! Scenes to frames: the thin renderer that joins texmap's crates.
#![forbid(unsafe_code)]

mod block;
mod check;
mod coordinates;
mod error;
mod frame;
mod plan;
mod render;
mod rows;
mod scene;
mod settings;
mod shade;
mod vertices;

pub use error::RenderError;
pub use frame::{AovData, Frame, HOLE_BITS, Stats, Times, pixel_hash};
pub use render::{Renderer, render, render_ordered};
pub use scene::{
    AlphaMode, ColorMode, Gouraud, Material, Mesh, Scene, Shading, TextureRole, TextureSlot,
};
pub use settings::{Aov, Settings, UnknownAov};
