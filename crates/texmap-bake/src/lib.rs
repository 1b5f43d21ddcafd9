//! Light baked into textures: light maps of meshes and environments captured from a point of the scene.
#![forbid(unsafe_code)]

mod environment;
mod light_map;

pub use environment::environment_of;
pub use light_map::{BakeOptions, LightMap, bake};
