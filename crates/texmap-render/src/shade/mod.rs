//! Shading in stages over a batch of fragments of one surface. Each stage is a file with a kernel of its own (one function for each SIMD
//! level); a stage that the surface lacks is not run. Stages know neither the scene, nor the draw list, nor each other: `plan/shader.rs`
//! gives them their inputs and their order.
//!
//! To add a stage: a file with a struct of its numbers and slots, [`stage::Kernel`] for it, and a line in `plan/shader.rs` that pushes
//! it where the material has it. `read` reads its texture into `texels`; `lanes` is the kernel, a loop over [`batch::parts`]. Another
//! model of light replaces [`lighting::PhongLights`]; the visibility of a light is [`lighting::LitBy::received`].
//!
//! A stage reads [`stage::Inputs`]: vectors, coordinates, sides, texels of projectors and of the pair. These columns of
//! [`stage::ShadeColumns`] go from stage to stage: `toward_eye` and `normal` (from [`vectors`], then the normal detail); `diffuse` and
//! `highlight` (from the lights, then light map, material maps, reflections, ramp, emission); `color` (base color and alpha, then
//! paint; the final color after [`compose`]). `texels`, `uv`, `base` and `slopes` are for the stage that runs.

pub(crate) mod base_color;
pub(crate) mod batch;
pub(crate) mod compose;
pub(crate) mod coordinates;
pub(crate) mod environment;
pub(crate) mod facing;
pub(crate) mod fetch;
pub(crate) mod light_maps;
pub(crate) mod lighting;
pub(crate) mod metallic;
pub(crate) mod normal;
pub(crate) mod paint;
pub(crate) mod procedural;
pub(crate) mod projector;
pub(crate) mod sky;
pub(crate) mod slopes;
pub(crate) mod solid;
pub(crate) mod stage;
pub(crate) mod surface;
pub(crate) mod texels;
pub(crate) mod unlit;
pub(crate) mod vectors;
pub(crate) mod volume;
