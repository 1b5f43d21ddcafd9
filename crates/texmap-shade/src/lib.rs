//! Shading of surfaces in stages over batches of up to 256 fragments; `texmap-render` runs it on the tiles of a picture. Each stage is a
//! file with a kernel of its own (one function for each SIMD level); a stage that a surface lacks is not run. Stages know neither the
//! draw list nor each other: `plan/shader.rs` of `texmap-render` gives them their inputs and their order.
//!
//! To add a stage: a file with a struct of its numbers and slots, `Kernel` of `stage.rs` for it, and a line in `plan/shader.rs` that pushes
//! it where the material has it. `read` reads its texture into `texels`; `lanes` is the kernel, a loop over `parts` of `batch.rs`. Another
//! model of light replaces [`lighting::PhongLights`]; the visibility of a light is `LitBy::received` there.
//!
//! A stage reads [`stage::Inputs`]: vectors, coordinates, sides, texels of projectors and of the texture set. These columns of
//! [`stage::ShadeColumns`] go from stage to stage: `toward_eye` and `normal` (from [`vectors`], then the normal detail); `diffuse` and
//! `highlight` (from the lights, then light map, material maps, reflections, ramp, emission); `color` (base color and alpha, then
//! paint; the final color after [`compose`] and [`cover`]). `texels`, `uv`, `base` and `slopes` are for the stage that runs.
//!
//! ```
//! use std::borrow::Cow;
//! use texmap_math::Level;
//! use texmap_raster::{AttributePlanes, BinnedDraws, DrawCall, FragmentBlock, NO_PRIMITIVE, NoAlphaTest, TargetSize, TileVisibility};
//! use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};
//! use texmap_scene::{ColorMode, Material, Shading, TextureSlot};
//! use texmap_shade::batch::Colors;
//! use texmap_shade::texels::Pixels;
//! use texmap_shade::unlit::{Unlit, UnlitColor, UnlitScratch};
//! use texmap_shade::Slot;
//!
//! // A triangle over the whole target, with uv at its corners.
//! let level = Level::new();
//! let draw = DrawCall {
//!     positions: &[[-1.0, -1.0, 0.5], [3.0, -1.0, 0.5], [-1.0, 3.0, 0.5]],
//!     indices: &[[0, 1, 2]],
//!     attributes: &[0.0, 1.0, 2.0, 1.0, 0.0, -1.0],
//!     attribute_count: 2,
//!     ..DrawCall::default()
//! };
//! let draws = BinnedDraws::with_level(TargetSize::new(64, 64)?, &[draw], level, 1)?;
//! let (mut visible, mut planes) = (TileVisibility::new(), AttributePlanes::new());
//! draws.visible_blocks(0, &NoAlphaTest, &mut visible);
//! draws.planes(0, &mut planes);
//!
//! // Its texture: the left half red, the right half green.
//! let texture = Texture2d::from_rgba8(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 255], ColorSpace::Srgb, Origin::TopLeft)?;
//! let sampler = Sampler { filter: Filter::Nearest, ..Sampler::default() };
//! let slot = Slot::new(texture, Cow::Owned(sampler), &TextureSlot::new(0));
//! let material = Material { shading: Shading::Unlit, ..Material::default() };
//! let color = UnlitColor::new(&material, Some(&slot), ColorMode::Srgb).expect("no decal");
//! let unlit = Unlit::new(color, Some(&slot));
//!
//! // The first and the last block of the first row of 4 x 4 pixels.
//! let batch = [0, 15].map(|block| FragmentBlock { block, mask: visible.masks[usize::from(block)], slot: NO_PRIMITIVE });
//! let (mut scratch, mut colors) = (UnlitScratch::default(), Colors::default());
//! unlit.shade(level, &Pixels::Blocks(&planes, &visible), &batch, &mut scratch, &mut colors);
//! assert_eq!(colors.get(0), [1.0, 0.0, 0.0, 1.0]);
//! assert_eq!(colors.get(16), [0.0, 1.0, 0.0, 1.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]
#![allow(
    missing_debug_implementations,
    reason = "stages borrow the scene and columns are scratch memory: nothing of them is worth printing"
)]

pub mod base_color;
pub mod batch;
pub mod compose;
pub mod coordinates;
pub mod cover;
pub mod environment;
pub mod facing;
pub mod fetch;
pub mod light_maps;
pub mod lighting;
pub mod metallic;
pub mod normal;
pub mod paint;
pub mod procedural;
pub mod projector;
pub mod sky;
pub mod slopes;
mod slot;
pub mod solid;
pub mod stage;
pub mod surface;
pub mod texels;
pub mod texture_set;
pub mod unlit;
pub mod vectors;
pub mod volume;

pub use slot::Slot;
