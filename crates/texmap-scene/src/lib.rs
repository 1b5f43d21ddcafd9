//! Scenes as data: camera, lights, textures, materials, meshes and effects, with the checks that come before a picture.
#![forbid(unsafe_code)]

mod check;
mod effects;
mod error;
mod light_names;
mod material;
mod mesh;
mod scene;
pub mod shadow_fit;
mod shapes;
mod solid_field;

pub use effects::{
    Backdrop, Carving, Effects, Emission, LightMapSlot, Reflection, Relief, Shadow, SlideProjector,
    SlideRole, Solid, SolidSource, SurfaceMaps, Volume,
};
pub use error::SceneError;
pub use light_names::is_light_name;
pub use material::{AlphaMode, Gouraud, Material, Shading, TextureRole, TextureSlot};
pub use mesh::Mesh;
pub use scene::{ColorMode, Scene};
pub use shadow_fit::{shadow_bias, shadow_kind};
pub use shapes::{Billboard, Displacement, EdgeBudget, Facing};
pub use solid_field::SolidField;
