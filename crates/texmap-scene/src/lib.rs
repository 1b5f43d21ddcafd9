//! Scenes as data: camera, lights, textures, materials, meshes and effects, with the checks that come before a picture.
//!
//! A [`Scene`] draws nothing. `texmap_render::render` makes it a frame, `texmap_mesh` changes its meshes, `texmap_io` reads it from files;
//! [`Scene::check`] finds every number and index that none of them can use. [`shadow_fit`] says what a shadow map of a light must show.
//!
//! # Conventions
//! Those of `texmap_math`: right-handed, +Y up, fronts counter-clockwise, angles in radians. Colours are linear light (raw values under
//! [`ColorMode::Raw`]); the background alone is sRGB. Indices name textures, materials, lights and environments by position.
//!
//! ```
//! use texmap_math::{Camera, glam::DVec3};
//! use texmap_scene::{Material, Mesh, Scene, SceneError};
//!
//! let camera = Camera {
//!     eye: DVec3::new(0.0, 1.0, 5.0), look: DVec3::ZERO, up: DVec3::Y,
//!     fov_x: 1.0, near: 1e-4, far: f64::INFINITY,
//!     lens: Default::default(),
//! };
//! let mut scene = Scene {
//!     materials: vec![Material::default()],
//!     meshes: vec![Mesh::cube()],
//!     ..Scene::new(camera)
//! };
//! assert_eq!(scene.check(), Ok(vec![]));
//! scene.meshes[0].material = 3;
//! assert!(matches!(scene.check(), Err(SceneError::Index { index: 3, .. })));
//! ```
//!
//! # Limits
//! Everything is owned and public; nothing is shared between scenes. A mesh has one material and at most two sets of coordinates.
#![forbid(unsafe_code)]

mod check;
mod drawing_order;
mod effects;
mod error;
mod light_names;
mod material;
mod mesh;
mod metallic_roughness;
mod primitives;
mod scene;
pub mod shadow_fit;
mod shapes;
mod solid_field;

pub use drawing_order::{BlendOrder, MeshDraw};
pub use effects::{
    Background, Effects, Emission, LightMapSlot, NormalDetail, ProceduralHeight, ProjectorLight,
    ProjectorMode, Reflection, Shadow, SolidTexture, SolidTextureSource, SurfaceMaps, ToneMapping,
    Volume,
};
pub use error::SceneError;
pub use light_names::is_light_name;
pub use material::{
    AlphaMode, Material, Shading, TextureRole, TextureSlot, UvSet, VertexColorInterp,
};
pub use mesh::Mesh;
pub use metallic_roughness::{Clearcoat, MetallicRoughness, Sheen, Transmission};
pub use scene::{ColorMode, Scene};
pub use shadow_fit::{shadow_bias, shadow_kind};
pub use shapes::{Billboard, Displacement, EdgeBudget, Facing};
pub use solid_field::SolidField;
