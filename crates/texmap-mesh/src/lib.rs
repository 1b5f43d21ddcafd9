//! Mesh to mesh: displacement, tessellation, skins, vertex functions, billboards, terrain and text.
#![forbid(unsafe_code)]

mod billboard;
mod displace;
mod error;
mod height_field;
mod refine;
mod skin;
mod tessellate;
mod text;
mod vertex_stage;

pub use billboard::billboards;
pub use error::MeshError;
pub use height_field::height_field;
pub use skin::{Bone, Skeleton, Skin, SkinBlend, turn, turn_by};
pub use tessellate::tessellate;
pub use text::Font;
pub use vertex_stage::{MeshVertex, map_vertices};
