//! Shading in stages over a batch of fragments of one surface. Each stage is a file; a stage that the surface lacks is not run.
//! Stages know neither the scene nor the draw list: `plan` gives them their inputs.

pub(crate) mod base_color;
pub(crate) mod batch;
mod compose;
pub(crate) mod coordinates;
pub(crate) mod environment;
pub(crate) mod facing;
pub(crate) mod fetch;
pub(crate) mod lighting;
pub(crate) mod normal;
pub(crate) mod procedural;
pub(crate) mod projector;
pub(crate) mod sky;
pub(crate) mod solid;
pub(crate) mod surface;
pub(crate) mod texels;
pub(crate) mod unlit;
pub(crate) mod volume;
