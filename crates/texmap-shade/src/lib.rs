//! Shading of surfaces in stages over batches of up to 256 fragments; `texmap-render` runs it on the tiles of a picture. Each stage is a
//! file with a kernel of its own (one function for each SIMD level); a stage that a surface lacks is not run. Stages know neither the
//! draw list nor each other: `plan/shader.rs` of `texmap-render` gives them their inputs and their order. The README has an example.
//!
//! To add a stage: a file with a struct of its numbers and slots, [`stage::Kernel`] for it, and a line in `plan/shader.rs` that pushes
//! it where the material has it. `read` reads its texture into `texels`; `lanes` is the kernel, a loop over [`batch::parts`]. Another
//! model of light replaces [`lighting::PhongLights`]; the visibility of a light is [`lighting::LitBy::received`].
//!
//! A stage reads [`stage::Inputs`]: vectors, coordinates, sides, texels of projectors and of the pair. These columns of
//! [`stage::ShadeColumns`] go from stage to stage: `toward_eye` and `normal` (from [`vectors`], then the normal detail); `diffuse` and
//! `highlight` (from the lights, then light map, material maps, reflections, ramp, emission); `color` (base color and alpha, then
//! paint; the final color after [`compose`]). `texels`, `uv`, `base` and `slopes` are for the stage that runs.

#![forbid(unsafe_code)]
#![allow(
    missing_debug_implementations,
    reason = "stages borrow the scene and columns are scratch memory: nothing of them is worth printing"
)]

pub mod base_color;
pub mod batch;
pub mod compose;
pub mod coordinates;
pub mod environment;
pub mod facing;
pub mod fetch;
pub mod light_maps;
pub mod lighting;
pub mod metallic;
pub mod normal;
pub mod paint;
pub mod procedural;
pub mod projector;
pub mod sky;
pub mod slopes;
mod slot;
pub mod solid;
pub mod stage;
pub mod surface;
pub mod texels;
pub mod unlit;
pub mod vectors;
pub mod volume;

pub use slot::Slot;

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
