//! The checks of the fuzz targets; also replayed on stable by the suite `fuzz`.

mod choices;
mod draw;
mod files;
mod light;
mod sample;
mod uv;

pub use draw::draw;
pub use files::{
    cameras, gltf, gpu_image, image, light_path, manifest, mtl, npy, obj, path, planner, ply,
    report, scene, stl,
};
pub use light::light;
pub use sample::sample;
pub use uv::uv;
