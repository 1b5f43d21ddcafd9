//! Light baked into textures: light maps of meshes, environments captured from a point of the scene and the shadow on the ground.
//!
//! Meshes are read as triangles: `texmap_mesh::tessellate` comes first where there are displacement maps or billboards.
//!
//! ```
//! use texmap_bake::{BakeOptions, bake};
//! use texmap_light::Light;
//! use texmap_math::{Camera, glam::DVec3};
//! use texmap_scene::{Material, Mesh, Scene};
//!
//! let camera = Camera {
//!     eye: DVec3::new(0.0, 2.0, 2.0), look: DVec3::ZERO, up: DVec3::Y,
//!     fov_x: 1.0, near: 1e-4, far: f64::INFINITY,
//!     lens: Default::default(),
//! };
//! let floor = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
//! let scene = Scene {
//!     lights: vec![Light::Directional { color: [0.5; 3], direction: [0.0, -1.0, 0.0] }],
//!     materials: vec![Material::default()],
//!     meshes: vec![Mesh::quad(floor)],
//!     ..Scene::new(camera)
//! };
//! let map = bake(&scene, 0, &BakeOptions { size: 8, gutter: 1, shadows: &[], lights: None })?;
//! assert_eq!(map.texels[27], [0.5; 3]);
//! # Ok::<(), texmap_render::RenderError>(())
//! ```
//!
//! # Limits
//! Direct light alone. Environments of meshes hold the 8 bits of frames, those of points linear light as floats, which does not end at 1.
#![forbid(unsafe_code)]

mod environment;
mod ground_shadow;
mod light_map;
mod moving_light;
mod planar_mirror;

pub use environment::{capture_environment, capture_environment_at, center_of};
pub use ground_shadow::GroundShadow;
pub use light_map::{BakeOptions, Baker, LightMap, bake};
pub use moving_light::MovingLight;
pub use planar_mirror::{PlanarMirror, with_planar_mirrors};
