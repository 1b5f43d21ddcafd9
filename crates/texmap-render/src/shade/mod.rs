//! Shading in stages over a batch of fragments of one surface. Each stage is a file with a kernel of its own (one function for each SIMD
//! level); a stage that the surface lacks is not run. Stages know neither the scene, nor the draw list, nor each other: `plan/shader.rs`
//! gives them their inputs and their order.
//!
//! To add a stage: a file with a struct of its numbers and slots, [`stage::Stage`] for it, and a line in `plan/shader.rs` that pushes
//! it where the material has it. `run` reads its textures into `texels`, then dispatches one kernel over [`batch::each_part`]. A light
//! model takes the place of [`lighting::PhongLights`]; shadows and projected texels are [`lighting::LitBy::received`].
//!
//! It reads [`stage::Inputs`] (vectors, coordinates, sides, texels of projectors and of the pair) and these columns of
//! [`stage::ShadeColumns`], in this order: `toward_eye` and `normal` ([`vectors`], then the normal detail), `diffuse` and `highlight` (the lights, then maps, ramp, reflections and emission), `color` (base color and alpha, then paint; the
//! final color after [`compose`]).

pub(crate) mod base_color;
pub(crate) mod batch;
pub(crate) mod compose;
pub(crate) mod coordinates;
pub(crate) mod environment;
pub(crate) mod facing;
pub(crate) mod fetch;
pub(crate) mod light_maps;
pub(crate) mod lighting;
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
