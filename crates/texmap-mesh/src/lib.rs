//! Mesh to mesh: displacement, tessellation, skins, vertex functions, billboards, terrain and text.
//!
//! - [`tessellate`]: displacement maps and billboards of a scene become triangles, for one camera and picture size.
//! - [`Skin`], [`Skeleton`]: linear blend skinning; [`map_vertices`]: any function of a vertex.
//! - [`height_field`]: terrain over a picture of heights; [`billboards`]: cards that face the camera; [`Font`]: words as quads;
//!   [`Typeface`]: the built-in letters as coverage of pixels.
//! - [`wireframe()`]: the edges of the faces over a finished picture.
//!
//! ```
//! use texmap_mesh::map_vertices;
//! use texmap_scene::Mesh;
//!
//! let raised = map_vertices(&Mesh::cube(), |_, mut vertex| {
//!     vertex.position[1] += 1.0;
//!     vertex
//! })?;
//! assert!(raised.positions.iter().all(|p| p[1] >= 0.0));
//! # Ok::<(), texmap_mesh::MeshError>(())
//! ```
//!
//! # Limits
//! Triangles alone; displaced meshes are cut to at most 4 million triangles unless a mesh says otherwise. The same bits for any number of
//! threads.
#![forbid(unsafe_code)]

mod billboard;
mod displace;
mod error;
mod height_field;
mod refine;
mod skin;
mod tessellate;
mod text;
mod typeface;
mod vertex_stage;
mod wireframe;

pub use billboard::billboards;
pub use error::MeshError;
pub use height_field::height_field;
pub use skin::{Bone, Skeleton, Skin, SkinBlend, rotation, rotation_about};
pub use tessellate::tessellate;
pub use text::Font;
pub use typeface::{GlyphGrid, Typeface};
pub use vertex_stage::{MeshVertex, map_vertices};
pub use wireframe::wireframe;
