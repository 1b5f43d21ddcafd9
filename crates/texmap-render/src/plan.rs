//! From a checked scene to draws: which values each mesh carries per vertex, and which stages run on its pixels.

use std::borrow::Cow;

use texmap_light::Light;
use texmap_math::Footprint;
use texmap_math::glam::DMat4;
use texmap_raster::Fragment;
use texmap_raster::{AlphaTest, Draw, Interp, Pass};
use texmap_sample::{Filter, Mip, Origin, Sampler, Texture2d, UvTransform, Wrap};

use crate::coordinates::CameraFrame;
use crate::vertices::{Values, VertexData, Vertices};
use crate::{
    AlphaMode, Aov, Gouraud, Material, Mesh, RenderError, Scene, Settings, Shading, TextureRole,
    TextureSlot,
};

/// All draws of one pass over a grid of samples.
pub(crate) struct Plan<'s> {
    pub(crate) surfaces: Vec<Surface<'s>>,
    pub(crate) lights: &'s [Light],
    pub(crate) eye: [f32; 3],
    pub(crate) level: texmap_math::Level,
}

/// One mesh, ready for the rasterizer and the stages.
pub(crate) struct Surface<'s> {
    pub(crate) mesh: &'s Mesh,
    pub(crate) material: &'s Material,
    pub(crate) base_color: Option<Slot<'s>>,
    pub(crate) opacity_map: Option<Slot<'s>>,
    pub(crate) uv: Coordinates,
    pub(crate) light: LightStage,
    /// Vertex colours, where light at the vertices has not taken them in.
    pub(crate) color: Option<usize>,
    pub(crate) normal: Option<usize>,
    pub(crate) position: Option<usize>,
    /// `None` if nothing is cut out.
    cut: Option<Cut>,
    pass: Pass,
    vertices: VertexData<'s>,
    interp: Interp,
    interp_scale: f32,
    clip_from_object: DMat4,
}

/// A texture as one mesh reads it.
pub(crate) struct Slot<'s> {
    pub(crate) texture: Texture2d<'static>,
    pub(crate) sampler: Cow<'s, Sampler>,
    /// Rows of the transform, if there is one.
    transform: Option<[[f32; 3]; 2]>,
}

impl Slot<'_> {
    /// Where the slot is read for coordinates of the mesh.
    pub(crate) fn place(&self, uv: [f32; 2], d: Footprint) -> ([f32; 2], Footprint) {
        let Some([[a, b, c], [e, f, g]]) = self.transform else {
            return (uv, d);
        };
        let uv = [a * uv[0] + b * uv[1] + c, e * uv[0] + f * uv[1] + g];
        let d = Footprint {
            du_dx: a * d.du_dx + b * d.dv_dx,
            dv_dx: e * d.du_dx + f * d.dv_dx,
            du_dy: a * d.du_dy + b * d.dv_dy,
            dv_dy: e * d.du_dy + f * d.dv_dy,
        };
        (uv, d)
    }

    /// The texel at coordinates of the mesh: linear, premultiplied.
    pub(crate) fn texel(&self, uv: [f32; 2], d: Footprint) -> [f32; 4] {
        let (uv, d) = self.place(uv, d);
        self.sampler.sample_grad(&self.texture, uv, d)
    }

    /// What an opacity map says by this texel.
    pub(crate) fn opacity(&self, texel: [f32; 4]) -> f32 {
        if self.texture.has_alpha() {
            texel[3]
        } else {
            texel[0]
        }
    }
}

/// Where texture coordinates come from.
pub(crate) enum Coordinates {
    None,
    /// Attributes 0 and 1.
    Vertices,
    Frame(CameraFrame),
}

impl Coordinates {
    /// Coordinates of a fragment; `None` if the mesh has none there.
    pub(crate) fn at(&self, fragment: &Fragment) -> Option<([f32; 2], Footprint)> {
        match self {
            Self::None => None,
            Self::Vertices => {
                let Fragment {
                    values, ddx, ddy, ..
                } = fragment;
                let d = Footprint {
                    du_dx: ddx[0],
                    dv_dx: ddx[1],
                    du_dy: ddy[0],
                    dv_dy: ddy[1],
                };
                Some(([values[0], values[1]], d))
            }
            Self::Frame(frame) => frame.uv(fragment.pixel[0], fragment.pixel[1]),
        }
    }
}

/// The lighting stage of a surface; numbers are attribute indices.
pub(crate) enum LightStage {
    /// The base colour is the colour.
    None,
    /// Finished colours at the vertices: the base colour is in them.
    Colors(usize),
    /// Terms at the vertices (vertex colours in the diffuse one), a texel between them.
    Terms {
        diffuse: usize,
        highlight: Option<usize>,
    },
    /// Computed per pixel.
    PerPixel,
}

/// Alpha of which a cut-out pixel is kept.
#[derive(Clone, Copy)]
enum Cut {
    Above(f32),
    AtLeast(f32),
}

impl Surface<'_> {
    /// The alpha test, with the sampler and the level of detail of shading.
    fn kept(&self, fragment: &Fragment) -> bool {
        let Some(cut) = self.cut else { return true };
        let (uv, d) = self.uv.at(fragment).unwrap_or_default();
        let texel = self.base_color.as_ref().map_or(1.0, |s| s.texel(uv, d)[3]);
        let mask = self
            .opacity_map
            .as_ref()
            .map_or(1.0, |s| s.opacity(s.texel(uv, d)));
        cut.keeps(texel * mask * self.material.opacity)
    }
}

impl AlphaTest for Plan<'_> {
    fn keep(&self, draw: u32, _triangle: u32, fragment: &Fragment) -> bool {
        self.surfaces[draw as usize].kept(fragment)
    }
}

impl Cut {
    fn keeps(self, alpha: f32) -> bool {
        match self {
            Self::Above(t) => alpha > t,
            Self::AtLeast(t) => alpha >= t,
        }
    }
}

/// Mip chains by texture, built once for both passes and only where a sampler reads them.
pub(crate) struct Chains(Vec<Option<Texture2d<'static>>>);

impl Chains {
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let mut chains = vec![None; scene.textures.len()];
        for mesh in &scene.meshes {
            let material = &scene.materials[mesh.material];
            for slot in material.base_color.iter().chain(&material.opacity_map) {
                let texture = &scene.textures[slot.texture];
                let filter = settings.filter.unwrap_or(slot.sampler.filter);
                let chain = &mut chains[slot.texture];
                if reads_mips(filter) && texture.levels() == 1 && chain.is_none() {
                    *chain = Some(texture.clone().with_mips());
                }
            }
        }
        Self(chains)
    }
}

fn reads_mips(filter: Filter) -> bool {
    !matches!(
        filter,
        Filter::Nearest | Filter::Bilinear | Filter::Bicubic(_) | Filter::Gl { mip: Mip::None, .. }
    )
}

impl<'s> Plan<'s> {
    /// A plan for `width` x `height` samples with the attributes that the shading needs and those of `aovs`.
    pub(crate) fn new(
        scene: &'s Scene,
        settings: &Settings,
        chains: &Chains,
        (width, height): (u32, u32),
        aovs: &[Aov],
    ) -> Result<Self, RenderError> {
        let aspect = f64::from(width) / f64::from(height);
        let view = scene.camera.view().map_err(RenderError::Camera)?;
        let projection = scene.camera.projection(aspect);
        let view = View {
            view_from_world: view,
            clip_from_world: projection * view,
            half: [1.0 / projection.x_axis.x, 1.0 / projection.y_axis.y],
            size: [f64::from(width), f64::from(height)],
        };
        let surfaces = scene
            .meshes
            .iter()
            .map(|mesh| surface(scene, settings, chains, &view, mesh, aovs))
            .collect();
        let eye = scene.camera.eye.to_array().map(|x| x as f32);
        Ok(Self {
            surfaces,
            lights: &scene.lights,
            eye,
            level: settings.level,
        })
    }

    pub(crate) fn draws(&self, scene: &Scene) -> Vec<Draw<'_>> {
        self.surfaces
            .iter()
            .map(|s| Draw {
                positions: &s.vertices.positions,
                indices: &s.vertices.triangles,
                clip_from_object: s.clip_from_object,
                attributes: &s.vertices.attributes,
                attribute_count: s.vertices.attribute_count,
                screen_linear: s.vertices.screen_linear,
                interp: s.interp,
                interp_scale: s.interp_scale,
                cull: s.material.cull,
                depth_test: scene.depth_test,
                depth_write: true,
                pass: s.pass,
            })
            .collect()
    }
}

struct View {
    view_from_world: DMat4,
    clip_from_world: DMat4,
    /// Half the picture's width and height at distance 1.
    half: [f64; 2],
    /// Samples.
    size: [f64; 2],
}

fn surface<'s>(
    scene: &'s Scene,
    settings: &Settings,
    chains: &Chains,
    view: &View,
    mesh: &'s Mesh,
    aovs: &[Aov],
) -> Surface<'s> {
    let material = &scene.materials[mesh.material];
    let base_color = material
        .base_color
        .as_ref()
        .map(|s| slot(s, scene, settings, chains, mesh.uv_origin));
    let opacity_map = material
        .opacity_map
        .as_ref()
        .filter(|_| material.alpha != AlphaMode::Opaque)
        .map(|s| slot(s, scene, settings, chains, mesh.uv_origin));
    let clear_texels = base_color.as_ref().is_some_and(Slot::can_be_transparent);
    let has_alpha = material.opacity < 1.0 || opacity_map.is_some() || clear_texels;
    // The lit surface is out of sight behind a decal that covers it.
    let shows_surface = base_color.is_none()
        || material.texture_role == TextureRole::Modulate
        || (material.alpha == AlphaMode::Opaque && clear_texels);
    let (pass, cut) = match material.alpha {
        AlphaMode::Opaque => (Pass::Opaque, None),
        AlphaMode::Blend => (Pass::Blended, None),
        AlphaMode::Test(_) if !has_alpha => (Pass::Opaque, None),
        AlphaMode::Test(t) if t > 0.0 => (Pass::CutOut, Some(Cut::AtLeast(t))),
        AlphaMode::Test(_) => {
            let alpha_source = opacity_map.as_ref().or(base_color.as_ref());
            let nearest = alpha_source.is_none_or(|s| picks_texels(s.sampler.filter));
            (
                Pass::CutOut,
                Some(if nearest {
                    Cut::Above(0.0)
                } else {
                    Cut::AtLeast(0.5)
                }),
            )
        }
    };
    let interp = settings.interp.unwrap_or(material.interp);
    let mut vertices = Vertices::default();
    let textured = base_color.is_some() || opacity_map.is_some();

    let uv = match mesh.frame {
        Some(frame) if textured || aovs.contains(&Aov::Uv) => {
            let camera_from_object = view.view_from_world * mesh.world_from_object;
            Coordinates::Frame(CameraFrame::new(
                frame.transform(camera_from_object),
                view.half,
                view.size,
            ))
        }
        None if !mesh.uvs.is_empty()
            && (textured || aovs.contains(&Aov::Uv) || needs_tolerance(interp)) =>
        {
            vertices.push(Values::Uv, false);
            Coordinates::Vertices
        }
        _ => Coordinates::None,
    };
    let screen = material.gouraud == Gouraud::ScreenLinear;
    let mut color = None;
    let light = if material.lit(shows_surface) {
        match material.shading {
            Shading::Unlit => LightStage::None,
            Shading::PerPixel => LightStage::PerPixel,
            // A texel multiplies the diffuse term only; without one, colours are finished at the vertices.
            Shading::PerVertex
                if base_color.is_some() && material.texture_role == TextureRole::Modulate =>
            {
                let diffuse = vertices.push(Values::Diffuse, screen);
                let highlight =
                    (material.surface.ks > 0.0).then(|| vertices.push(Values::Highlight, screen));
                LightStage::Terms { diffuse, highlight }
            }
            Shading::PerVertex => LightStage::Colors(vertices.push(Values::Lit, screen)),
        }
    } else {
        LightStage::None
    };
    let at_vertices = matches!(light, LightStage::Colors(_) | LightStage::Terms { .. });
    if shows_surface && !mesh.colors.is_empty() && !at_vertices {
        color = Some(vertices.push(Values::Color, screen));
    }
    let per_pixel = matches!(light, LightStage::PerPixel);
    let normal =
        (per_pixel || aovs.contains(&Aov::Normal)).then(|| vertices.push(Values::Normal, false));
    let by_place = per_pixel && lights_depend_on_place(&scene.lights, material);
    let position =
        (by_place || aovs.contains(&Aov::Position)).then(|| vertices.push(Values::Position, false));

    let vertices = vertices.finish(scene, mesh);
    let (width, height) = base_color
        .as_ref()
        .map_or((1, 1), |s| (s.texture.width(), s.texture.height()));
    Surface {
        mesh,
        material,
        uv,
        light,
        color,
        normal,
        position,
        cut,
        pass,
        interp,
        interp_scale: width.max(height) as f32,
        clip_from_object: view.clip_from_world * mesh.world_from_object,
        vertices,
        base_color,
        opacity_map,
    }
}

/// `WithinError` measures its tolerance on attributes 0 and 1, which must then be uv.
fn needs_tolerance(interp: Interp) -> bool {
    matches!(interp, Interp::WithinError(_))
}

/// Whether light differs between points of one normal.
fn lights_depend_on_place(lights: &[Light], material: &Material) -> bool {
    lights.iter().any(|light| match light {
        Light::Ambient { .. } => false,
        Light::Directional { .. } => material.surface.ks > 0.0,
        _ => true,
    })
}

fn picks_texels(filter: Filter) -> bool {
    matches!(filter, Filter::Nearest | Filter::MipNearest)
}

fn slot<'s>(
    slot: &'s TextureSlot,
    scene: &'s Scene,
    settings: &Settings,
    chains: &Chains,
    origin: Origin,
) -> Slot<'s> {
    let texture = chains.0[slot.texture]
        .as_ref()
        .unwrap_or(&scene.textures[slot.texture]);
    let texture = texture.clone().with_origin(origin);
    let mut sampler = Cow::Borrowed(&slot.sampler);
    if let Some(filter) = settings.filter {
        sampler.to_mut().filter = filter;
    }
    if let Some(wrap) = settings.wrap {
        (sampler.to_mut().wrap_u, sampler.to_mut().wrap_v) = (wrap, wrap);
    }
    let transform = (slot.transform != UvTransform::default()).then(|| slot.transform.rows());
    Slot {
        texture,
        sampler,
        transform,
    }
}

impl Slot<'_> {
    fn can_be_transparent(&self) -> bool {
        let s = &self.sampler;
        let border = s.wrap_u == Wrap::ClampToBorder || s.wrap_v == Wrap::ClampToBorder;
        self.texture.has_alpha() || (border && s.border[3] < 1.0)
    }
}
