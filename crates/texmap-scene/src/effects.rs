//! Lighting effects as data: what a scene says about shadows, projectors and environments, and materials about maps.

use texmap_light::{
    Environment, EnvironmentLight, NormalMapGreen, ProjectorBorder, ReflectionBox, ShadowBias,
    ToneMap,
};
use texmap_math::Projector;
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::{Pattern, Sampler, Texture3d, Wrap};

use crate::TextureSlot;

/// Effects of a whole scene. None costs anything where it is not named.
#[derive(Clone, Debug, Default)]
pub struct Effects {
    /// Names of lights in their order, for [`Scene::light_named`](crate::Scene::light_named). An empty name, or a list that ends
    /// early, is no name.
    pub light_names: Vec<String>,
    /// Lights that cast shadows.
    pub shadows: Vec<Shadow>,
    /// Projectors: lights and decals whose colour is a picture.
    pub projectors: Vec<ProjectorLight>,
    /// Environments and specular maps that materials name by index.
    pub environments: Vec<Environment>,
    /// Grids that solid textures and volumes name by index.
    pub grids: Vec<Texture3d<'static>>,
    /// Matter between the eye and the surfaces.
    pub volumes: Vec<Volume>,
    /// A sky.
    pub background: Option<Background>,
    /// Light from every direction on metallic-roughness surfaces. It shows nowhere but on them; a
    /// [`background`](Self::background) shows it.
    pub environment_light: Option<EnvironmentLight>,
    /// [Samples](EnvironmentLight::samples) of the environment light that cast shadows, each by a shadow map, up to 256. 0: its light reaches
    /// all metallic-roughness surfaces. 64 darken corners and draw soft shadows of what is bright; where a material has an occlusion map, the
    /// lesser of both fractions is left.
    pub environment_shadows: u32,
    /// The way from light to display light.
    pub tone_mapping: ToneMapping,
}

/// Exposure and tone mapping. They act on the light of lit surfaces (per pixel and per vertex) and of environments in the
/// background, before samples are averaged and surfaces blended: edges between bright and dark stay smooth. Background colours and
/// pictures, volumes and surfaces of [`Shading::Unlit`](crate::Shading::Unlit) are display light already and stay as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToneMapping {
    /// Factor of light, finite and not negative.
    pub exposure: f32,
    /// The curve.
    pub map: ToneMap,
}

impl ToneMapping {
    /// True if light stays as it is, but for a clip at 1.
    #[must_use]
    pub fn is_identity(self) -> bool {
        self.exposure == 1.0 && matches!(self.map, ToneMap::None | ToneMap::Unclipped)
    }
}

impl Default for ToneMapping {
    /// Light as it is, clipped at 1.
    fn default() -> Self {
        Self {
            exposure: 1.0,
            map: ToneMap::None,
        }
    }
}

/// A shadow map for a light. Read by surfaces that are lit per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Shadow {
    /// Index into [`Scene::lights`](crate::Scene::lights).
    pub light: usize,
    /// Texels a side (of each face, for a point light). `None`: about one texel for each pixel at the middle of the scene, 256 to 4096.
    pub size: Option<u32>,
    /// Depth bias that keeps a surface from shadowing itself; `None`: [`shadow_bias`](crate::shadow_bias).
    pub bias: Option<ShadowBias>,
    /// Comparisons a side of the filter, 1 or an odd number up to 15.
    pub pcf_size: u32,
    /// For a directional light the square that its map shows, by centre and half a side. `None`: all of the scene. For a point light
    /// one map instead of six, which looks at the centre and shows half a side there: what lies beyond it is lit.
    pub area: Option<(DVec3, f64)>,
}

/// A projector: a light whose colour is a picture, or paint projected onto surfaces. Read by surfaces that are lit per pixel, those
/// whose texel covers them ([`TextureRole::Decal`](crate::TextureRole)) included: on these paint covers the texel, and the light, through
/// exposure and tone mapping, is added to it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectorLight {
    /// Map from world points to picture coordinates; made with the aspect of the picture.
    pub projector: Projector,
    /// Position of the projector: light comes from here.
    pub position: DVec3,
    /// Index into [`Scene::textures`](crate::Scene::textures), v = 0 at the top.
    pub texture: usize,
    /// Filter of the picture; the sampler's wrap modes are not read.
    pub sampler: Sampler,
    /// Colour beyond the picture.
    pub border: ProjectorBorder,
    /// Part of the picture's width and height over which its edge fades, 0..=0.5.
    pub softness: f32,
    /// Light or paint.
    pub mode: ProjectorMode,
    /// Texels a side of the depth map that keeps it from shining through things; `None`: it shines through.
    pub shadow: Option<u32>,
}

/// Effect of the projected picture on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProjectorMode {
    /// Light of this linear colour times the picture, from the projector's position: diffuse, with highlights.
    Light([f32; 3]),
    /// Paint over the base colour of surfaces that face the projector, as alpha says.
    Decal,
}

/// Textures for the numbers of a surface; each multiplies what the surface says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMaps {
    /// Colour of the ambient term.
    pub ambient: Option<TextureSlot>,
    /// Colour of the highlight.
    pub specular: Option<TextureSlot>,
    /// The exponent of the highlight (red channel).
    pub exponent: Option<TextureSlot>,
    /// Fraction of the environment's light that is mirrored (red channel).
    pub reflectivity: Option<TextureSlot>,
}

/// Light that a surface gives off itself. It is added after the light that the surface receives, clipped at white with it ([unless no light is](ToneMap::Unclipped)), and is
/// not lit, shadowed or tinted by vertex colours. It lights nothing else. A decal texel that covers the surface covers it too.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Linear light, finite and not negative (raw values under [`ColorMode::Raw`](crate::ColorMode)).
    pub color: [f32; 3],
    /// A texture that multiplies the colour, at the coordinates of the mesh: straight colours, black where alpha is 0.
    pub map: Option<TextureSlot>,
}

/// Variation of the normals of a surface, without moving the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalDetail {
    /// A height field (red channel), Blinn 1978.
    Bump {
        /// The texture.
        slot: TextureSlot,
        /// Height of a white texel over a black one, in units of the object; negative turns it inside out.
        height: f32,
    },
    /// The slopes of a height field as colours, red along u and green along v (Blinn 1978): half is level. The texture stores the
    /// slopes that a bump map measures at every look-up, with no loss at fine detail.
    Offsets {
        /// The texture: data, not sRGB.
        slot: TextureSlot,
        /// Change of the height over the whole picture where a channel is 1, in units of the object. Negative turns it inside out.
        slope: f32,
        /// Direction in which the height rises where green is more than half.
        green: NormalMapGreen,
    },
    /// Heights by a formula of the position in the world.
    Procedural {
        /// The formula.
        heights: ProceduralHeight,
        /// Map from the unit space of the formula to the world; may not be flat.
        world_from_solid: DMat4,
        /// Height of 1 over 0, in units of the object; negative turns it inside out.
        height: f32,
    },
    /// Normals as colours.
    NormalMap {
        /// The texture: data, not sRGB.
        slot: TextureSlot,
        /// Direction of the green channel.
        green: NormalMapGreen,
        /// Only red and green are stored.
        rebuild_z: bool,
        /// The normals are those of the object, not of its tangent frames.
        object_space: bool,
        /// Multiplies x and y before the normal is brought to length 1; 1 is the map as it is.
        strength: f32,
    },
}

impl NormalDetail {
    /// Texture of the normals or heights, if there is one.
    #[must_use]
    pub fn slot(&self) -> Option<&TextureSlot> {
        match self {
            Self::Bump { slot, .. } | Self::Offsets { slot, .. } | Self::NormalMap { slot, .. } => {
                Some(slot)
            }
            Self::Procedural { .. } => None,
        }
    }
}

/// A height of 0 to 1 as a formula of a position, for [`NormalDetail::Procedural`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProceduralHeight {
    /// A pattern in space.
    Pattern(Pattern),
    /// Waves in cylindrical space about the y axis: 1/2 + 1/2 cos(around a) cos(2 pi y), a the angle about the axis. A whole number
    /// around leaves no seam.
    Waves {
        /// Waves around, 1 to 65535; those along the axis are one unit long.
        around: u16,
        /// Distance by which noise folds the waves, as a part of one.
        fold: f32,
    },
}

/// A light map on the second uv set of the meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMapSlot {
    /// The texture: linear light; one channel or three.
    pub slot: TextureSlot,
    /// Multiplies the texel: maps of 8 bits can hold more than 1 that way.
    pub scale: f32,
    /// Lights that are in the map, by index, and are not computed again. `None`: all of the scene (not its projectors).
    pub baked: Option<Vec<usize>>,
}

/// A mirrored environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection {
    /// Index into [`Effects::environments`].
    pub environment: usize,
    /// Share of the mirrored light that is added, 0..=1.
    pub reflectivity: f32,
    /// The walls that the environment shows: rays are led to them, so that a mirror away from the point of capture shows them where they
    /// are. `None`: everything is infinitely far.
    pub within: Option<ReflectionBox>,
}

/// A sky. It is drawn over the background colour and under everything else, and leaves no trace in output arrays.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// The picture is stretched over the whole frame, whatever its shape and wherever the camera looks. An opaque texel
    /// hides the background colour.
    Picture(TextureSlot),
    /// The light of [`Effects::environments`](crate::Effects) in the direction of each pixel.
    Environment(usize),
    /// The scene's [`environment_light`](Effects::environment_light) in the direction of each pixel, with its turn: what a mirror
    /// shows.
    EnvironmentLight,
}

/// A box of matter, marched through at every pixel up to the solid surface there. Blended over everything else, several in
/// the order of their list. It casts and receives no shadows, and leaves no trace in output arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Index into [`Effects::grids`].
    pub grid: usize,
    /// Filter of the grid; the sampler's wrap modes are not read.
    pub sampler: Sampler,
    /// The transfer function: a row of texels along which the grid's first channel is looked up. Its colour shines, its alpha
    /// is the density. Without one, see [`texmap_sample::VolumeIntegrator`].
    pub transfer: Option<TextureSlot>,
    /// Extinction of density 1 per world unit. Through a length L of it shows `exp(-density L)` of what is behind.
    pub density: f32,
    /// World units between look-ups.
    pub step: f32,
    /// Map from the grid's unit cube to the world: column 0 of the grid at x = 0, row 0 at y = 0, slice 0 at z = 0. Not flat.
    pub world_from_volume: DMat4,
}

/// A texture that fills space. Its colour multiplies that of the surface; with a
/// [`color_ramp`](crate::Material::color_ramp) its first channel is looked up along that.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidTexture {
    /// Source of the colour.
    pub source: SolidTextureSource,
    /// Map from the unit cube (of a grid) or the unit space (of a pattern) to the world; may not be flat.
    pub world_from_solid: DMat4,
}

/// Source of a solid texture's colour.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidTextureSource {
    /// A grid over the unit cube.
    Grid {
        /// Index into [`Effects::grids`].
        grid: usize,
        /// Filter and the wrap along x and y.
        sampler: Sampler,
        /// The wrap along z.
        wrap_w: Wrap,
    },
    /// A formula; grey without a ramp.
    Pattern(Pattern),
}
