//! The scene: everything that is drawn, as data.

use std::borrow::Cow;

use texmap_light::{Light, Roughnesses};
use texmap_math::camera::Camera;
use texmap_raster::DepthTest;
use texmap_sample::Texture2d;

use crate::{BlendOrder, Effects, Material, Mesh, Shading};

/// Everything that is drawn. A scene is data: `texmap_render::render` reads it and changes nothing.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Camera of the picture.
    pub camera: Camera,
    /// Colour of pixels that nothing covers: red, green, blue as sRGB values 0..=1 (stored as they are
    /// under [`ColorMode::Raw`]) and alpha, straight. Alpha 0 leaves them transparent.
    pub background: [f32; 4],
    /// Conversion of colours between sRGB and linear light.
    pub color: ColorMode,
    /// The surface that wins of two at one depth: the first drawn (`Less`) or the last (`LessOrEqual`). Without a test (`Always`)
    /// the last drawn wins at any depth.
    pub depth_test: DepthTest,
    /// The order in which blended meshes are composed.
    pub blend_order: BlendOrder,
    /// Light sources, in world space. Read only by materials that are shaded.
    pub lights: Vec<Light>,
    /// Textures that the slots of materials name by index.
    pub textures: Vec<Texture2d<'static>>,
    /// Materials that meshes name by index.
    pub materials: Vec<Material>,
    /// Meshes, in the order in which they are submitted: it settles equal depths and, but for [`blend_order`](Self::blend_order), blending.
    pub meshes: Vec<Mesh>,
    /// Shadows, projectors and environments; none by default.
    pub effects: Effects,
    /// Choices that the loader made for the scene, one sentence each; carried into the warnings of a frame.
    pub warnings: Vec<String>,
}

impl Scene {
    /// An empty scene: black opaque background, colours in sRGB, the nearer surface wins, and of two at one depth the first.
    #[must_use]
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            background: [0.0, 0.0, 0.0, 1.0],
            color: ColorMode::Srgb,
            depth_test: DepthTest::Less,
            blend_order: BlendOrder::OfMeshes,
            lights: Vec::new(),
            textures: Vec::new(),
            materials: Vec::new(),
            meshes: Vec::new(),
            effects: Effects::default(),
            warnings: Vec::new(),
        }
    }

    /// True if some surface shows the light of an environment.
    #[must_use]
    pub fn reads_environment(&self) -> bool {
        let mut materials = self.materials.iter();
        materials.any(|m| m.metallic_roughness.is_some() && m.shading == Shading::PerPixel)
    }

    /// The roughnesses at which surfaces reflect the environment light.
    #[must_use]
    pub fn roughnesses(&self) -> Roughnesses {
        let materials = self.materials.iter();
        materials.fold(Roughnesses::NONE, |all, m| all | m.roughnesses())
    }
}

impl From<Scene> for Cow<'_, Scene> {
    fn from(scene: Scene) -> Self {
        Self::Owned(scene)
    }
}

impl<'s> From<&'s Scene> for Cow<'s, Scene> {
    fn from(scene: &'s Scene) -> Self {
        Self::Borrowed(scene)
    }
}

/// Conversion of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorMode {
    /// sRGB in files and in the picture, linear light between them.
    #[default]
    Srgb,
    /// Values are stored as computed; every conversion is off. Textures must have been made with
    /// `ColorSpace::Linear`.
    Raw,
}
