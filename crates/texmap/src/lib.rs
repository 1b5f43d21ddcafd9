#![doc = include_str!("../README.md")]
#![cfg_attr(not(feature = "std"), no_std)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

#[cfg(feature = "bake")]
pub use texmap_bake as bake;
#[cfg(feature = "io")]
pub use texmap_io as io;
#[cfg(feature = "light")]
pub use texmap_light as light;
pub use texmap_math as math;
#[cfg(feature = "mesh")]
pub use texmap_mesh as mesh;
#[cfg(feature = "planner")]
pub use texmap_planner as planner;
#[cfg(feature = "raster")]
pub use texmap_raster as raster;
#[cfg(feature = "render")]
pub use texmap_render as render;
#[cfg(feature = "sample")]
pub use texmap_sample as sample;
#[cfg(feature = "scene")]
pub use texmap_scene as scene;
#[cfg(feature = "shade")]
pub use texmap_shade as shade;
#[cfg(feature = "uv")]
pub use texmap_uv as uv;

#[cfg(feature = "image")]
mod image_buffers;
pub mod prelude;
#[cfg(feature = "io")]
mod save;

#[cfg(all(feature = "image", feature = "render"))]
pub use image_buffers::ToImage;
#[cfg(feature = "image")]
pub use image_buffers::{texture_from_f32, texture_from_rgba8};
#[cfg(feature = "io")]
pub use save::SaveFrame;
