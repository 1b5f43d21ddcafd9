//! The names that most programs use, for `use texmap::prelude::*`.

#[cfg(feature = "io")]
pub use crate::SaveFrame;
#[cfg(all(feature = "image", feature = "render"))]
pub use crate::ToImage;
#[cfg(feature = "light")]
pub use texmap_light::{Light, PhongMaterial};
pub use texmap_math::glam::{DMat4, DVec2, DVec3};
pub use texmap_math::{Camera, Footprint, Homography, Level};
#[cfg(feature = "raster")]
pub use texmap_raster::{BinnedDraws, DrawCall, TargetSize};
#[cfg(feature = "render")]
pub use texmap_render::{Frame, RenderSettings, no_progress, render};
#[cfg(feature = "sample")]
pub use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, Wrap};
#[cfg(feature = "scene")]
pub use texmap_scene::{Material, Mesh, Scene, TextureSlot};
#[cfg(feature = "uv")]
pub use texmap_uv::{Mapping, Shape, UvSet};
