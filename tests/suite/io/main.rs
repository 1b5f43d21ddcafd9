//! Files in and out: the scene language, models, images, arrays, and every way in which they can be broken.

mod effects;
mod gltf;
mod gpu_images;
mod guarded;
mod language;
mod malformed;
mod manual;
mod memory;
mod models;
mod oracle;
mod pictures;
mod ply;
mod scenes;
mod shapes;
mod stl;
mod support;
