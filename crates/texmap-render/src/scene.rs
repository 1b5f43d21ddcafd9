use texmap_light::{Highlight, Light, Surface};
use texmap_math::camera::Camera;
use texmap_math::frame::TextureFrame;
use texmap_math::glam::DMat4;
use texmap_raster::{Cull, DepthTest, Interp};
use texmap_sample::{Origin, Sampler, Texture2d, UvTransform};
use texmap_uv::{PixelMapping, Projection};

use crate::Solid;
use crate::billboard::Billboard;
use crate::displace::Displacement;
use crate::effects::{Effects, Emission, LightMapSlot, Reflection, Relief, SurfaceMaps};

/// Everything that is drawn. A scene is data: [`render`](crate::render) reads it and changes nothing.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Colour of pixels that nothing covers: red, green, blue as sRGB values 0..=1 (stored as they are
    /// under [`ColorMode::Raw`]) and alpha, straight. Alpha 0 leaves them transparent.
    pub background: [f32; 4],
    /// Whether colours are converted between sRGB and linear light.
    pub color: ColorMode,
    /// Which of two surfaces at one depth wins: the first drawn (`Less`) or the last (`LessOrEqual`). Without a test (`Always`) the
    /// last drawn wins at any depth.
    pub depth_test: DepthTest,
    /// Light sources, in world space. Read only by materials that are shaded.
    pub lights: Vec<Light>,
    /// Textures that the slots of materials name by index.
    pub textures: Vec<Texture2d<'static>>,
    /// Materials that meshes name by index.
    pub materials: Vec<Material>,
    /// Meshes, in the order in which they are submitted: it settles equal depths and blending.
    pub meshes: Vec<Mesh>,
    /// Shadows, projectors and environments; none by default.
    pub effects: Effects,
    /// What the loader had to decide, one sentence each; carried into [`Frame::warnings`](crate::Frame).
    pub warnings: Vec<String>,
}

/// Whether colours are converted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorMode {
    /// sRGB in files and in the picture, linear light between them.
    #[default]
    Srgb,
    /// Values are stored as computed; every conversion is off. Textures must have been made with
    /// `ColorSpace::Linear`.
    Raw,
}

/// How a surface looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Base colour (linear light; raw under [`ColorMode::Raw`]) and its answer to light.
    pub surface: Surface,
    /// 0 (clear) to 1; multiplies the alpha of the texture. Read by [`AlphaMode::Test`] and
    /// [`AlphaMode::Blend`].
    pub opacity: f32,
    /// Colour, and alpha if the texture has one.
    pub base_color: Option<TextureSlot>,
    /// Opacity from the alpha of a texture, or from its red channel if it has no alpha.
    pub opacity_map: Option<TextureSlot>,
    /// The base colour's alpha is an outline: cut at a half, with one pixel of coverage at its edge, however far it is
    /// magnified (Green 2007, for alpha that falls evenly across the edge). For text and signs.
    pub crisp: bool,
    /// A texture that fills space; multiplies the surface colour.
    pub solid: Option<Solid>,
    /// A row of texels along which the first channel of `solid`, else of `base_color`, is looked up: its colour takes the
    /// place of theirs. A dependent look-up.
    pub color_ramp: Option<TextureSlot>,
    /// A row of texels along which the diffuse light is looked up by its luminance: bands of cel shading. Highlights stay.
    pub light_ramp: Option<TextureSlot>,
    /// A label over the base colour, as its alpha says, under the light. Same coordinates; clamped to a clear border it is
    /// there once.
    pub decal: Option<TextureSlot>,
    /// What the texel does to the surface colour.
    pub texture_role: TextureRole,
    /// Where light is computed.
    pub shading: Shading,
    /// What alpha does.
    pub alpha: AlphaMode,
    /// How texture coordinates run across a triangle.
    pub interp: Interp,
    /// Which side of a triangle is not drawn. Drawn back sides are lit from the side that is seen.
    pub cull: Cull,
    /// How colours of [`Shading::PerVertex`] and vertex colours run across a triangle.
    pub gouraud: Gouraud,
    /// How highlights fall off, per pixel.
    pub highlight: Highlight,
    /// Textures for the numbers of `surface`. Read by [`Shading::PerPixel`].
    pub maps: SurfaceMaps,
    /// Light of its own, under every [`Shading`].
    pub emission: Option<Emission>,
    /// What turns the normal. Read by [`Shading::PerPixel`].
    pub relief: Option<Relief>,
    /// Normals that a relief turns away from the eye are brought back to the horizon: without, such pixels are as dark or bright as
    /// the far side of the relief.
    pub horizon_clamp: bool,
    /// Baked light. Read by [`Shading::PerPixel`].
    pub light_map: Option<LightMapSlot>,
    /// A mirrored environment. Read by [`Shading::PerPixel`].
    pub reflection: Option<Reflection>,
    /// A specular map: index into [`Effects::environments`] of area lights blurred by the highlight's lobe, looked up along the
    /// mirrored view, times `ks`; per pixel or per vertex, as the shading is.
    pub specular_map: Option<usize>,
}

impl Default for Material {
    /// The grey default surface, untextured, opaque, two-sided, lit per pixel.
    fn default() -> Self {
        Self {
            name: String::new(),
            surface: Surface::default(),
            opacity: 1.0,
            base_color: None,
            opacity_map: None,
            crisp: false,
            solid: None,
            color_ramp: None,
            light_ramp: None,
            decal: None,
            texture_role: TextureRole::Modulate,
            shading: Shading::PerPixel,
            alpha: AlphaMode::Opaque,
            interp: Interp::Perspective,
            cull: Cull::None,
            gouraud: Gouraud::ScreenLinear,
            highlight: Highlight::Phong,
            maps: SurfaceMaps::default(),
            emission: None,
            relief: None,
            horizon_clamp: true,
            light_map: None,
            reflection: None,
            specular_map: None,
        }
    }
}

impl Material {
    /// Every texture that the material names.
    pub fn slots(&self) -> impl Iterator<Item = &TextureSlot> {
        let maps = &self.maps;
        let relief = self.relief.as_ref().and_then(Relief::slot);
        self.base_color
            .iter()
            .chain(&self.opacity_map)
            .chain(&self.color_ramp)
            .chain(&self.light_ramp)
            .chain(&self.decal)
            .chain(
                [
                    &maps.ambient,
                    &maps.specular,
                    &maps.exponent,
                    &maps.reflectivity,
                ]
                .into_iter()
                .flatten(),
            )
            .chain(self.emission.as_ref().and_then(|e| e.map.as_ref()))
            .chain(relief)
            .chain(self.light_map.as_ref().map(|map| &map.slot))
    }
}

/// A texture and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSlot {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Filter, wrap modes, level of detail.
    pub sampler: Sampler,
    /// Applied to the coordinates of the mesh before the look-up.
    pub transform: UvTransform,
}

/// What a texel does to the surface colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureRole {
    /// The texel is copied and ignores the lights: the MIT `tf` face. Where an opaque material's texel is
    /// (partly) transparent, the lit surface shows through, as around a label.
    Decal,
    /// The texel multiplies the surface colour (and the vertex colour), then light is applied. A white
    /// surface makes it a replacement.
    #[default]
    Modulate,
}

/// Where light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shading {
    /// No light: the base colour is the colour.
    Unlit,
    /// At the vertices, interpolated across the triangle (Gouraud).
    PerVertex,
    /// At every pixel, from the interpolated position and normal.
    #[default]
    PerPixel,
}

/// How colours run across a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gouraud {
    /// Linear on the screen: what the lecture's rasterizer does, with its seams at T-joints.
    #[default]
    ScreenLinear,
    /// Linear on the surface.
    Perspective,
}

/// What alpha does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Nothing: every covered pixel is opaque. The colour that a texture hides under alpha 0 is lost
    /// (texels are premultiplied) and drawn black.
    #[default]
    Opaque,
    /// A pixel is drawn, and its depth written, only where alpha reaches the threshold (`alpha >= t`).
    /// `Test(0.0)` is the rule of the filter: `alpha > 0` for nearest (the lecture's test), `alpha >= 0.5`
    /// for filtered alpha.
    Test(f32),
    /// Composed over what stands behind, in submission order; writes no depth.
    Blend,
}

/// Triangles of one material.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// For messages.
    pub name: String,
    /// Vertices, object space.
    pub positions: Vec<[f32; 3]>,
    /// Empty, or one per vertex: object space, any length, out of the counter-clockwise side. If empty and
    /// needed, the area-weighted mean of the triangles at each vertex is used.
    pub normals: Vec<[f32; 3]>,
    /// Empty, or one per vertex: the file's own values.
    pub uvs: Vec<[f32; 2]>,
    /// Empty, or one per vertex: the second set, in which no two triangles overlap, for light maps.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Empty, or one per vertex: linear light, multiplies the surface colour.
    pub colors: Vec<[f32; 3]>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Empty, or the source face of each triangle (for the `face` AOV and for errors). Empty: the
    /// triangle's own index.
    pub faces: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Object to world space; may scale unevenly and mirror.
    pub world_from_object: DMat4,
    /// Where v = 0 lies in the pictures that this mesh's uv speak of: overrides the origin of the texture.
    pub uv_origin: Origin,
    /// Object-space O, U, V. If given, uv is computed at every pixel as A.W/C.W, B.W/C.W (Brackeen 2003,
    /// chapter 8) and `uvs` is not read.
    pub frame: Option<TextureFrame>,
    /// A sphere or cylinder in world space. If given, uv is computed at every pixel from its position, exact also
    /// across the seam and around the axis, and neither `frame` nor `uvs` is read.
    pub round: Option<PixelMapping>,
    /// Throws no shadow: shadow maps and the depth maps of projectors do not show it.
    pub shadowless: bool,
    /// Bounds a solid, its fronts outwards and no hole in it: maps of parallel and spot lights show its fronts alone, which is half of the
    /// work and the same shadow. Lights that stand inside of it shine through.
    pub closed: bool,
    /// A height map that moves the surface, by [`Scene::shaped`].
    pub displacement: Option<Displacement>,
    /// If not empty, the mesh is these rectangles, four vertices each: see [`Mesh::of_billboards`].
    pub billboards: Vec<Billboard>,
}

impl Default for Mesh {
    /// No triangles, first material, identity transform, top-left uv.
    fn default() -> Self {
        Self {
            name: String::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            lightmap_uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            faces: Vec::new(),
            material: 0,
            world_from_object: DMat4::IDENTITY,
            uv_origin: Origin::TopLeft,
            frame: None,
            round: None,
            shadowless: false,
            closed: false,
            displacement: None,
            billboards: Vec::new(),
        }
    }
}

impl Mesh {
    /// Source face of a triangle, see [`faces`](Self::faces).
    #[must_use]
    pub fn face(&self, triangle: u32) -> u32 {
        self.faces
            .get(triangle as usize)
            .copied()
            .unwrap_or(triangle)
    }

    /// Replaces `uvs` by a projection of the positions onto a plane, box or sphere around them: the named
    /// fallback for a mesh that came without coordinates. Follows `uv_origin`.
    pub fn project_uvs(&mut self, projection: Projection) {
        let origin = match self.uv_origin {
            Origin::TopLeft => texmap_uv::Origin::TopLeft,
            Origin::BottomLeft => texmap_uv::Origin::BottomLeft,
        };
        self.uvs = texmap_uv::project(&self.positions, &self.normals, projection, origin);
    }
}
