//! Materials: base colour, textures, answer to light.

use std::borrow::Cow;

use texmap_light::{PhongMaterial, Roughnesses, SpecularModel};
use texmap_raster::{Cull, Interp};
use texmap_sample::{Sampler, UvTransform};

use crate::{
    Emission, LightMapSlot, Mesh, MetallicRoughness, NormalDetail, Reflection, SolidTexture,
    SurfaceMaps,
};

/// Appearance of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Base colour and its answer to light. Linear light; raw under [`ColorMode::Raw`](crate::ColorMode::Raw).
    pub phong: PhongMaterial,
    /// The metallic-roughness model instead of the numbers of `phong`; the colour of `phong` stays the base colour. Read by
    /// [`Shading::PerPixel`]; `specular_model`, `maps`, `reflection` and `specular_map` are not read then.
    pub metallic_roughness: Option<MetallicRoughness>,
    /// 0 (clear) to 1; multiplies the alpha of the texture. Read by [`AlphaMode::Test`] and
    /// [`AlphaMode::Blend`].
    pub opacity: f32,
    /// Colour, and alpha if the texture has one.
    pub base_color: Option<TextureSlot>,
    /// Opacity from the alpha of a texture, or from its red channel if it has no alpha.
    pub opacity_map: Option<TextureSlot>,
    /// The base colour's alpha is an outline. Cut at a half, with one pixel of coverage at its edge, however far it is
    /// magnified (Green 2007, for alpha that falls evenly across the edge). For text and signs.
    pub antialiased_alpha: bool,
    /// A texture that fills space; multiplies the surface colour.
    pub solid: Option<SolidTexture>,
    /// A row of texels along which the first channel of `solid`, else of `base_color`, is looked up. Its colour replaces theirs.
    /// A dependent look-up. Its alpha, times that of the texture, is read as that of a texture is, but
    /// [`AlphaMode::Test`] cuts by the texture.
    pub color_ramp: Option<TextureSlot>,
    /// A row of texels along which the diffuse light is looked up by its luminance: bands of cel shading. Highlights stay.
    pub light_ramp: Option<TextureSlot>,
    /// A label over the base colour, as its alpha says, under the light. Same coordinates; clamped to a clear border it is
    /// there once.
    pub decal: Option<TextureSlot>,
    /// Effect of the texel on the surface colour.
    pub texture_role: TextureRole,
    /// Frequency of the light's computation: none, per vertex or per pixel.
    pub shading: Shading,
    /// Effect of alpha.
    pub alpha: AlphaMode,
    /// Interpolation of texture coordinates across a triangle.
    pub interp: Interp,
    /// The side of a triangle that is not drawn. Drawn back sides are lit from the side that is seen.
    pub cull: Cull,
    /// Interpolation of colours of [`Shading::PerVertex`] and of vertex colours across a triangle.
    pub vertex_color_interp: VertexColorInterp,
    /// Form of highlights, per pixel.
    pub specular_model: SpecularModel,
    /// Textures for the numbers of `surface`. Read by [`Shading::PerPixel`].
    pub maps: SurfaceMaps,
    /// Light of its own, under every [`Shading`].
    pub emission: Option<Emission>,
    /// Normal map, bump map or procedural heights that turn the normal. Read by [`Shading::PerPixel`].
    pub normal_detail: Option<NormalDetail>,
    /// Normals that a normal or bump map turns away from the eye are brought back to the horizon: without, such pixels are as
    /// dark or bright as the far side of the bump.
    pub horizon_clamp: bool,
    /// Baked light. Read by [`Shading::PerPixel`].
    pub light_map: Option<LightMapSlot>,
    /// A mirrored environment. Read by [`Shading::PerPixel`].
    pub reflection: Option<Reflection>,
    /// A specular map: index into [`Effects::environments`](crate::Effects::environments) of area lights blurred by the highlight's lobe, looked up along the
    /// mirrored view, times `ks`; per pixel or per vertex, as the shading is.
    pub specular_map: Option<usize>,
}

impl Default for Material {
    /// The grey default surface, untextured, opaque, two-sided, lit per pixel.
    fn default() -> Self {
        Self {
            name: String::new(),
            phong: PhongMaterial::default(),
            metallic_roughness: None,
            opacity: 1.0,
            base_color: None,
            opacity_map: None,
            antialiased_alpha: false,
            solid: None,
            color_ramp: None,
            light_ramp: None,
            decal: None,
            texture_role: TextureRole::Modulate,
            shading: Shading::PerPixel,
            alpha: AlphaMode::Opaque,
            interp: Interp::Perspective,
            cull: Cull::None,
            vertex_color_interp: VertexColorInterp::ScreenLinear,
            specular_model: SpecularModel::Phong,
            maps: SurfaceMaps::default(),
            emission: None,
            normal_detail: None,
            horizon_clamp: true,
            light_map: None,
            reflection: None,
            specular_map: None,
        }
    }
}

impl Material {
    /// True if the light map holds the light of this light, by its number.
    #[must_use]
    pub fn bakes(&self, light: usize) -> bool {
        match self.light_map.as_ref().map(|map| &map.baked) {
            None => false,
            Some(None) => true,
            Some(Some(all)) => all.contains(&light),
        }
    }

    /// The roughnesses at which it reflects an environment that lights it from all around.
    #[must_use]
    pub fn roughnesses(&self) -> Roughnesses {
        match &self.metallic_roughness {
            Some(model) if self.shading == Shading::PerPixel => model.roughnesses(),
            _ => Roughnesses::NONE,
        }
    }

    /// Every texture that the material names.
    pub fn slots(&self) -> impl Iterator<Item = &TextureSlot> {
        let maps = &self.maps;
        let normal_detail = self.normal_detail.as_ref().and_then(NormalDetail::slot);
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
            .chain(normal_detail)
            .chain(self.light_map.as_ref().map(|map| &map.slot))
            .chain(
                self.metallic_roughness
                    .iter()
                    .flat_map(MetallicRoughness::slots),
            )
    }

    /// The textures that are read at coordinates of the mesh as their [`TextureSlot::uv_set`] says: neither ramps nor the light map.
    pub fn uv_slots(&self) -> impl Iterator<Item = &TextureSlot> {
        let (maps, lit) = (&self.maps, self.shading == Shading::PerPixel);
        let relief = self.normal_detail.as_ref().and_then(NormalDetail::slot);
        let model = self.metallic_roughness.iter();
        let numbers = [
            &maps.ambient,
            &maps.specular,
            &maps.exponent,
            &maps.reflectivity,
        ];
        let lit = numbers
            .into_iter()
            .flatten()
            .chain(relief)
            .chain(model.flat_map(MetallicRoughness::slots))
            .filter(move |_| lit);
        let emission = self.emission.as_ref().and_then(|e| e.map.as_ref());
        let color = [&self.base_color, &self.opacity_map, &self.decal];
        color.into_iter().flatten().chain(emission).chain(lit)
    }

    /// True if a texture is read at this set of coordinates.
    #[must_use]
    pub fn reads_uv(&self, set: UvSet) -> bool {
        self.uv_slots().any(|slot| slot.uv_set == set)
    }
}

/// A texture and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSlot {
    /// Index into [`Scene::textures`](crate::Scene::textures).
    pub texture: usize,
    /// Filter, wrap modes, level of detail.
    pub sampler: Sampler,
    /// Applied to the coordinates of the mesh before the look-up.
    pub transform: UvTransform,
    /// The coordinates of the mesh that are read.
    pub uv_set: UvSet,
}

/// One of the two sets of texture coordinates of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UvSet {
    /// [`Mesh::uvs`](crate::Mesh::uvs), or the frame or projection of the mesh instead of them.
    #[default]
    First,
    /// [`Mesh::lightmap_uvs`](crate::Mesh::lightmap_uvs).
    Second,
}

impl TextureSlot {
    /// Coordinates of a mesh along which the texture lies on it: those that tangents follow. They are turned and mirrored as the transform says;
    /// its offset, and scales above 0 alone, leave all directions.
    #[must_use]
    pub fn tangent_uvs<'m>(&self, mesh: &'m Mesh) -> Cow<'m, [[f32; 2]]> {
        let uvs = match self.uv_set {
            UvSet::First => &mesh.uvs,
            UvSet::Second => &mesh.lightmap_uvs,
        };
        let transform = &self.transform;
        if transform.rotation == 0.0 && transform.scale.iter().all(|s| *s > 0.0) {
            return Cow::Borrowed(uvs);
        }
        let [[a, b, _], [c, d, _]] = transform.rows();
        let turned = uvs.iter().map(|[u, v]| [a * u + b * v, c * u + d * v]);
        Cow::Owned(turned.collect())
    }

    /// The texture of this index in [`Scene::textures`](crate::Scene::textures), by the default sampler and without a transform.
    #[must_use]
    pub fn new(texture: usize) -> Self {
        Self {
            texture,
            sampler: Sampler::default(),
            transform: UvTransform::default(),
            uv_set: UvSet::First,
        }
    }
}

/// Effect of a texel on the surface colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureRole {
    /// The texel is copied and ignores the lights but projectors: the MIT `tf` face. If an opaque material's texel is (partly) transparent, the
    /// lit surface shows through, as around a label.
    Decal,
    /// The texel multiplies the surface colour (and the vertex colour), then light is applied. A white
    /// surface makes it a replacement.
    #[default]
    Modulate,
}

/// Frequency of the light's computation.
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

/// Interpolation of colours across a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VertexColorInterp {
    /// Linear on the screen: what the lecture's rasterizer does, with its seams at T-junctions.
    #[default]
    ScreenLinear,
    /// Linear on the surface.
    Perspective,
}

/// Effect of alpha.
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
