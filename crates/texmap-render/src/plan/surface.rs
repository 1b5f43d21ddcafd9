//! One mesh of a plan: its draw, the stages of its pixels, and the values per vertex that these read.

use texmap_math::glam::DMat4;
use texmap_raster::{Cull, DepthTest, Fragment, Interp, Pass};

use super::effects::SurfaceEffects;
use super::light_stage::{light_stage, lights_depend_on_place};
use super::{AlphaTestStage, View, alpha_test};
use crate::frame_resources::FrameResources;
use crate::textures::Chains;
use crate::vertices::{Values, VertexData, Vertices};
use crate::{Aov, RenderSettings};
use texmap_math::CameraFrame;
use texmap_scene::{
    AlphaMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot, UvSet, VertexColorInterp,
};
use texmap_shade::Slot;
use texmap_shade::coordinates::{Coordinates, uv_of_attributes};
use texmap_shade::lighting::LightStage;
use texmap_shade::sky::SkyStage;
use texmap_shade::solid::SolidStage;
use texmap_shade::unlit::UnlitColor;
use texmap_shade::volume::VolumeStage;

/// One mesh, ready for the rasterizer and the stages.
pub(crate) struct Surface<'s> {
    pub(crate) mesh: &'s Mesh,
    /// Index of the mesh in the scene; `u32::MAX` for a background or volume.
    pub(crate) number: u32,
    pub(crate) material: &'s Material,
    pub(crate) base_color: Option<Slot<'s>>,
    pub(crate) opacity_map: Option<Slot<'s>>,
    pub(crate) color_ramp: Option<Slot<'s>>,
    pub(crate) light_ramp: Option<Slot<'s>>,
    pub(crate) decal: Option<Slot<'s>>,
    pub(crate) carved: Option<SolidStage<'s>>,
    /// Emitted light (raw values in raw mode) and the map that multiplies it, where the surface shows.
    pub(crate) emission: Option<([f32; 3], Option<Slot<'s>>)>,
    /// The only stage of a background or volume, which is no surface.
    pub(crate) space: Option<Space<'s>>,
    pub(crate) uv: Coordinates,
    /// First attribute of the second set of coordinates.
    pub(crate) second_uv: Option<usize>,
    pub(crate) light: LightStage,
    /// Effects of a surface lit per pixel beside plain lights.
    pub(crate) effects: Option<Box<SurfaceEffects<'s>>>,
    /// Vertex colours, where light at the vertices has not taken them in.
    pub(crate) color: Option<usize>,
    pub(crate) normal: Option<usize>,
    pub(crate) position: Option<usize>,
    /// Attributes that shading reads: 0 up to this.
    pub(crate) shaded: usize,
    /// Every look-up of the base colour is opaque.
    pub(crate) solid: bool,
    /// The one stage of a surface that needs no other.
    pub(crate) unlit: Option<UnlitColor>,
    /// `None` if nothing is cut out.
    pub(super) cut: Option<AlphaTestStage>,
    pub(crate) pass: Pass,
    /// Sides that are not drawn.
    pub(super) cull: Cull,
    /// Depth test that replaces that of the scene.
    pub(super) depth_test: Option<DepthTest>,
    pub(crate) vertices: VertexData<'s>,
    pub(super) interp: Interp,
    pub(super) interp_scale: f32,
    pub(super) clip_from_object: DMat4,
}

/// Light along a ray rather than from a surface.
pub(crate) enum Space<'s> {
    Sky(SkyStage<'s>),
    Volume(Box<VolumeStage<'s>>),
}

impl<'s> Surface<'s> {
    /// Triangles of no colour that blend.
    pub(crate) fn bare(
        mesh: &'s Mesh,
        material: &'s Material,
        vertices: VertexData<'s>,
        clip_from_object: DMat4,
        depth_test: DepthTest,
    ) -> Self {
        Self {
            mesh,
            number: u32::MAX,
            material,
            base_color: None,
            opacity_map: None,
            color_ramp: None,
            light_ramp: None,
            decal: None,
            carved: None,
            emission: None,
            space: None,
            uv: Coordinates::None,
            second_uv: None,
            light: LightStage::None,
            effects: None,
            color: None,
            normal: None,
            position: None,
            shaded: vertices.attribute_count,
            solid: false,
            unlit: None,
            cut: None,
            pass: Pass::Blended,
            cull: material.cull,
            depth_test: Some(depth_test),
            vertices,
            interp: Interp::Perspective,
            interp_scale: 1.0,
            clip_from_object,
        }
    }
}

impl Surface<'_> {
    pub(super) fn kept(&self, fragment: &Fragment) -> bool {
        let Some(cut) = self.cut else { return true };
        let maps = [&self.base_color, &self.opacity_map].map(Option::as_ref);
        let place = match self.second_uv.filter(|_| self.cut_by_second()) {
            Some(first) => Some(uv_of_attributes(fragment, first)),
            None => self.uv.at(fragment),
        };
        cut.keeps(place, maps, self.material.opacity)
    }

    /// True if the maps of the alpha test are read at the second set of coordinates.
    pub(super) fn cut_by_second(&self) -> bool {
        let maps = [&self.base_color, &self.opacity_map];
        let mut maps = maps.into_iter().flatten();
        maps.any(|slot| slot.uv_set == UvSet::Second)
    }
}

pub(super) fn surface<'s>(
    scene: &'s Scene,
    settings: &RenderSettings,
    chains: &Chains,
    ready: &FrameResources<'s>,
    view: &View,
    mesh: &'s Mesh,
    aovs: &[Aov],
) -> Surface<'s> {
    let material = &scene.materials[mesh.material];
    let base_color = material
        .base_color
        .as_ref()
        .map(|s| chains.slot(s, scene, settings, mesh.uv_origin));
    let opacity_map = material
        .opacity_map
        .as_ref()
        .filter(|_| material.alpha != AlphaMode::Opaque)
        .map(|s| chains.slot(s, scene, settings, mesh.uv_origin));
    let ramp = |slot: &'s Option<TextureSlot>| {
        let slot = slot.as_ref();
        slot.map(|s| chains.ramp(s, scene))
    };
    let colored = material.solid.is_some() || base_color.is_some();
    let color_ramp = ramp(&material.color_ramp).filter(|_| colored);
    let decal = material
        .decal
        .as_ref()
        .map(|s| chains.slot(s, scene, settings, mesh.uv_origin));
    // The texels of a ramp stand in for those of the texture.
    let ramped = material.solid.is_none().then_some(color_ramp.as_ref());
    let mut read = base_color.iter().chain(ramped.flatten());
    let clear_texels = base_color.is_some() && read.any(Slot::can_be_transparent);
    // The lit surface is out of sight behind a decal that covers it.
    let shows_surface = base_color.is_none()
        || material.texture_role == TextureRole::Modulate
        || (material.alpha == AlphaMode::Opaque && clear_texels);
    let emission = material.emission.as_ref().filter(|_| shows_surface);
    let emission = emission.map(|e| {
        let slot = |s| chains.slot(s, scene, settings, mesh.uv_origin);
        (e.color, e.map.as_ref().map(slot))
    });
    let cut = alpha_test(material, base_color.as_ref(), opacity_map.as_ref());
    let pass = match material.alpha {
        AlphaMode::Blend => Pass::Blended,
        _ if cut.is_some() => Pass::CutOut,
        _ => Pass::Opaque,
    };
    let interp = match settings.interp.unwrap_or(material.interp) {
        // Its tolerance is one of coordinates at the vertices; a round mapping has none.
        Interp::WithinError(_) if mesh.uv_projection.is_some() => Interp::Perspective,
        interp => interp,
    };
    let mut vertices = Vertices::default();
    let textured = base_color.is_some()
        || opacity_map.is_some()
        || decal.is_some()
        || emission.as_ref().is_some_and(|e| e.1.is_some())
        || material.reads_uv(UvSet::First);
    let second = material.reads_uv(UvSet::Second);

    let mut position = None;
    let uv = match mesh.texture_frame {
        _ if mesh.uv_projection.is_some() && (textured || aovs.contains(&Aov::Uv)) => {
            let first = vertices.push(Values::Position, false);
            position = Some(first);
            mesh.uv_projection
                .map_or(Coordinates::None, |map| Coordinates::Round(map, first))
        }
        Some(frame) if textured || aovs.contains(&Aov::Uv) => {
            let camera_from_object = view.view_from_world * mesh.world_from_object;
            Coordinates::Frame(CameraFrame::new(
                frame.transform(camera_from_object),
                view.rays(),
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
    let second_uv = second.then(|| vertices.push(Values::LightMapUv, false));
    let screen = material.vertex_color_interp == VertexColorInterp::ScreenLinear;
    let covered = base_color.is_some() && material.texture_role == TextureRole::Decal;
    let varies = base_color.is_some() || material.solid.is_some() || decal.is_some();
    // Projectors reach the texels of decals, too.
    let shows_light =
        shows_surface || (material.shading == Shading::PerPixel && ready.has_projectors());
    let light = light_stage(material, shows_light, varies && !covered, &mut vertices);
    let light_ramp = ramp(&material.light_ramp);
    let at_vertices = matches!(light, LightStage::Colors(_) | LightStage::Terms { .. });
    let tinted = shows_surface && !mesh.colors.is_empty() && !at_vertices;
    let color = tinted.then(|| vertices.push(Values::Color, screen));
    let per_pixel = matches!(light, LightStage::PerPixel);
    let effects = per_pixel
        .then(|| SurfaceEffects::new(scene, settings, chains, ready, mesh, &mut vertices))
        .flatten();
    let by_place = match &effects {
        Some(effects) => effects.reads_positions(ready),
        None => per_pixel && lights_depend_on_place(&scene.lights, material),
    };
    let mut normal = per_pixel.then(|| vertices.push(Values::Normal, false));
    let carved = material.solid.as_ref().filter(|_| shows_surface);
    if position.is_none() && (by_place || carved.is_some()) {
        position = Some(vertices.push(Values::Position, false));
    }
    let carved = carved
        .zip(position)
        .map(|(solid, first)| SolidStage::new(solid, &scene.effects, first));
    let shaded = vertices.attribute_count();
    if normal.is_none() && aovs.contains(&Aov::Normal) {
        normal = Some(vertices.push(Values::Normal, false));
    }
    if position.is_none() && aovs.contains(&Aov::Position) {
        position = Some(vertices.push(Values::Position, false));
    }
    let second_base = base_color
        .as_ref()
        .is_some_and(|slot| slot.uv_set == UvSet::Second);
    let at_a_vertex = matches!(uv, Coordinates::Vertices) && !second_base || base_color.is_none();
    let is_unlit = matches!(light, LightStage::None) && color.is_none() && opacity_map.is_none();
    let plain = !material.antialiased_alpha
        && color_ramp.is_none()
        && decal.is_none()
        && carved.is_none()
        && emission.is_none();
    let unlit = (at_a_vertex && is_unlit && plain)
        .then(|| UnlitColor::new(material, base_color.as_ref(), scene.color))
        .flatten()
        .map(|color| color.with_limit(scene.effects.tone_mapping.map.limit()));

    let vertices = vertices.finish(scene, mesh);
    let (width, height) = base_color
        .as_ref()
        .map_or((1, 1), |s| (s.texture.width(), s.texture.height()));
    Surface {
        mesh,
        number: u32::MAX,
        material,
        color_ramp,
        light_ramp,
        decal,
        carved,
        emission,
        space: None,
        uv,
        second_uv,
        light,
        effects,
        color,
        normal,
        position,
        shaded,
        solid: !clear_texels,
        unlit,
        cut,
        pass,
        cull: material.cull,
        depth_test: None,
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
