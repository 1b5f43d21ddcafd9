//! Files in and out: the scene language, OBJ/MTL, images and `.npy` arrays.
#![forbid(unsafe_code)]

pub mod atomic;
mod camera_path;
mod error;
mod files;
pub mod framing;
pub mod image_io;
mod info;
pub mod npy;
mod obj;
mod scene;
pub mod scene_file;
mod textures;

pub use camera_path::{CameraPath, Stop};
pub use error::{IoError, Place};
pub use info::{FileInfo, MeshInfo, NamedFile, info};
pub use scene::{LoadOptions, load, load_obj, load_scene};
