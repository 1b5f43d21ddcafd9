//! Scenes to frames: the thin renderer that joins texmap's crates.
//!
//! A [`Scene`](scene::Scene) is data: camera, lights, textures, materials, meshes. [`render`] checks all of it, plans which values each
//! mesh needs per vertex and which stages run on its pixels, and draws tiles of 64 x 64 pixels: visibility of opaque and
//! cut-out surfaces first, each visible pixel shaded once, blended surfaces over them in submission order. A stage that a
//! material lacks is not run.
//!
//! Meshes are drawn as triangles. If a scene has displacement maps or billboards, `texmap_mesh::tessellate` comes first; a scene that
//! still holds them is refused.
//!
//! # Conventions
//! Right-handed space, +Y up; the camera looks along -Z of its own space; fronts are counter-clockwise. Rows run from top
//! to bottom. Angles are radians. Colours are linear light, or raw values under [`ColorMode::Raw`](scene::ColorMode::Raw); the background alone is
//! sRGB. Depth is reversed: 1 at the near plane, 0 at infinity. The same input gives the same bytes on every machine, for
//! any number of threads.
//!
//! # Debug builds
//! Without optimisation (opt-level 0, plain `cargo run`) lanes are left out and the scalar code draws the same bytes: no function needs
//! more than 128 KiB of stack, a whole frame less than 1 MiB, but pixels take tens of times as long. These lines in the `Cargo.toml` of a
//! program optimise what it depends on and leave the program itself to the debugger:
//! ```toml
//! [profile.dev.package."*"]
//! opt-level = 3
//! ```
//!
//! ```
//! use texmap_light::PhongMaterial;
//! use texmap_math::{Camera, glam::DVec3};
//! use texmap_render::{RenderSettings, no_progress, render};
//! use texmap_scene::{Material, Mesh, Scene, Shading};
//!
//! let camera = Camera {
//!     eye: DVec3::new(0.0, 0.0, 2.0), look: DVec3::ZERO, up: DVec3::Y,
//!     fov_x: 1.0, near: 1e-4, far: f64::INFINITY,
//!     lens: Default::default(),
//! };
//! let red = PhongMaterial { color: [1.0, 0.0, 0.0], ..PhongMaterial::default() };
//! let triangle = Mesh {
//!     positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! };
//! let scene = Scene {
//!     background: [0.0, 0.0, 1.0, 1.0],
//!     materials: vec![Material { phong: red, shading: Shading::Unlit, ..Material::default() }],
//!     meshes: vec![triangle],
//!     ..Scene::new(camera)
//! };
//! let frame = render(&scene, &RenderSettings::new(64, 64), &no_progress)?;
//! let middle = (32 * 64 + 32) * 4;
//! assert_eq!(frame.rgba[middle..middle + 4], [255, 0, 0, 255]);
//! assert_eq!(frame.rgba[..4], [0, 0, 255, 255]);
//! # Ok::<(), texmap_render::RenderError>(())
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(
    not(any(
        target_arch = "x86",
        target_arch = "x86_64",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )),
    allow(
        dead_code,
        unused_imports,
        unused_mut,
        unused_variables,
        reason = "without a vector unit the scalar versions of the kernels do all of the work"
    )
)]

mod error;
mod frame;
mod frame_resources;
mod plan;
mod render;
mod resolve;
mod settings;
mod shadow;
mod shadow_alpha_test;
mod stopwatch;
mod textures;
mod tile;
mod vertices;

pub use error::RenderError;
pub use frame::{AovData, Frame, HOLE_BITS, PixelHash, Stats, Times, hash_pixels, pixel_hash};
pub use frame_resources::EnvironmentShadows;
pub use render::{Renderer, render, render_ordered};
pub use settings::{Aov, RenderSettings, UnknownAov};
pub use shadow::{shadow_map, shadow_map_for};
pub use texmap_math::progress::no_progress;
/// The crate of scenes.
pub use texmap_scene as scene;
