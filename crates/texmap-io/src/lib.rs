//! Files in and out of texmap: the scene language, models (OBJ with MTL, glTF, PLY, STL), images, `.npy` arrays. The only crate that sees
//! files.
//!
//! - [`load`] reads a scene or model with everything that it names into a [`texmap_scene::Scene`]; [`info`] lists
//!   the contents of a file and the files that it names in vain.
//! - [`scene_file`] is the language alone: text to statements and back.
//! - [`image_io`], [`write_pixels`], [`npy`], [`CameraPath`]: pictures, arrays, walks. [`framing`]: cameras that show a whole model.
//! - [`atomic`]: files that are written whole or not at all; every writer here uses it.
//!
//! Everything is checked while it is read: an [`IoError`] names file, line and column, gives the reason and a remedy, and
//! has a stable code. Colours of files are sRGB (HDR and EXR: linear light), `v` of a scene grows downwards and `v` of an OBJ upwards; the values
//! are kept as they are and the mesh says where its origin is.
//!
//! ```
//! use std::path::Path;
//! use texmap_io::scene_file::{Value, parse, print};
//!
//! let text = "v 0 0 0   # three corners\nv 1 0 0\nv 0 1e0 0\nf 0 1\n  2\n";
//! let file = parse(Path::new("triangle.scene"), text)?;
//! assert_eq!(file.statements[3].command.values(), [0, 1, 2].map(Value::Index));
//! assert_eq!(print(&file), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n");
//!
//! let error = parse(Path::new("triangle.scene"), "v 0 0 0\nf 0 0 3\n").unwrap_err();
//! assert_eq!(error.to_string(), "triangle.scene:2:7: vertex index 3 does not exist; there are 1 above this line");
//! assert_eq!((error.code(), error.help().as_str()), ("bad-index", "indices count from 0 to 0"));
//! # Ok::<(), texmap_io::IoError>(())
//! ```
#![forbid(unsafe_code)]

mod animation;
pub mod atomic;
mod camera_list;
mod camera_path;
mod camera_pose;
mod environment_io;
mod error;
mod files;
mod font;
pub mod framing;
mod gltf;
#[cfg(feature = "gpu-images")]
mod gpu_image;
mod grids;
mod held;
pub mod image_io;
mod info;
mod keyframes;
mod light_path;
mod models;
pub mod npy;
mod obj;
mod open_exr;
mod picture_format;
mod ply;
mod scene;
pub mod scene_file;
mod stl;
mod textures;

pub use animation::{Animation, AnimationFormat, write_animation};
pub use camera_list::{CameraList, NamedCamera};
pub use camera_path::{CameraPath, Keyframe};
pub use camera_pose::{CameraAxes, CameraPose, Intrinsics};
pub use environment_io::{read_environment, write_environment, write_light};
pub use error::{IoError, SourceLocation, plain, plain_json, shortened, shown};
pub use files::FileSource;
pub use font::built_in_font;
#[cfg(feature = "gpu-images")]
pub use gpu_image::{Compression, CompressionQuality, compress, compress_texture};
pub use grids::read_grid;
pub use info::{
    AnimationInfo, CameraInfo, ExtensionInfo, FileInfo, MeshInfo, NamedFile, info, info_with,
};
pub use light_path::{LightKeyframe, LightPath};
pub use models::obj_text;
pub use obj::ObjText;
pub use open_exr::{ExrLayer, write_exr};
pub use picture_format::{Lost, PictureFormat, PixelCode, write_pixels};
pub use scene::{LoadOptions, load, load_bytes, load_model, load_scene};
