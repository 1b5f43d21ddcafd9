//! Texture coordinates for meshes: projections, seams, unwrapping, packing, tangents and a distortion report.
//!
//! Conventions: right-handed, +Y up. A unit solid fills [-0.5, 0.5] on every axis, the squares of its sides have v = 0 at
//! the top (or at the bottom, see [`Origin`]), and u rises to the right of a viewer who stands outside.
//! Everything is computed with texmap's own `atan2`; the bytes are the same on every machine, SIMD level and thread
//! count.
//!
//! ```
//! use texmap_math::Level;
//! use texmap_uv::{Faces, Mapping, Mesh, Shape};
//!
//! // A quad that straddles the seam of a cylinder (+X), one unit high.
//! let positions = [[1.0, -0.5, 0.1], [1.0, -0.5, -0.1], [1.0, 0.5, -0.1], [1.0, 0.5, 0.1]];
//! let mut faces = Faces::new();
//! faces.push(&[0, 1, 2, 3]);
//! let mesh = Mesh::new(&positions, &faces)?;
//! let frame = texmap_uv::Placement::upright(Default::default(), texmap_math::glam::DVec3::new(2.0, 1.0, 2.0));
//! let mapping = Mapping { frame: Some(frame), ..Mapping::new(Shape::Cylinder) };
//! let mapped = mapping.map(Level::new(), &mesh, &[])?;
//! // u runs on past 1 instead of jumping back to 0.
//! let u: Vec<f32> = mapped.set.per_corner().iter().map(|uv| uv[0]).collect();
//! assert!(u[0] < 1.0 && u[1] > 1.0 && u[1] - u[0] < 0.05);
//! # Ok::<(), texmap_uv::UvError>(())
//! ```
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
extern crate alloc;

mod auto;
mod error;
mod fallback;
mod islands;
mod layout;
mod mapping;
mod mesh;
mod overlap;
mod pack;
mod parallel;
mod per_pixel;
mod placement;
mod plane;
mod report;
mod seam_edges;
mod seam_unwrap;
mod solid;
mod spherical;
mod t_junction;
mod tangent;
mod topology;
mod tree;
#[cfg(feature = "unwrap")]
mod unwrap;
mod uv_set;
mod views;

pub use auto::auto_planes;
pub use error::UvError;
pub use fallback::{Projection, project};
pub use layout::layout_svg;
pub use mapping::{MappedMesh, Mapping, ProjectionSource, tile};
pub use mesh::{Faces, Mesh};
pub use overlap::{Overlaps, overlaps};
pub use pack::{AtlasSize, pack};
pub use per_pixel::{CurvedShape, PerPixelProjection};
pub use placement::Placement;
pub use report::{Report, ReportOptions, TriangleReport, Unmapped, report, unmapped};
pub use seam_edges::{SeamEdges, cut_seams, sew_seams};
pub use solid::{Origin, Shape, ShapeFace};
pub use spherical::{cylinder_uv_at, cylinder_uv_batch, sphere_uv_at, sphere_uv_batch};
pub use t_junction::{TJunction, TJunctions, t_junctions};
pub use tangent::tangents;
#[cfg(feature = "unwrap")]
pub use unwrap::unwrap;
pub use uv_set::{UvSet, VertexBuffer};
