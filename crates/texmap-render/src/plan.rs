//! From a checked scene to draws: which values each mesh carries per vertex, and which stages run on its pixels.

mod cut;

use std::sync::Arc;

use texmap_light::Light;
use texmap_math::glam::DMat4;
use texmap_raster::{AlphaTest, DepthTest, Draw, Fragment, Interp, Pass, UvBlock};
use texmap_sample::Origin;

use crate::backdrop::{SkyStage, behind};
use crate::coordinates::{CameraFrame, Coordinates, EyeRays, Rays};
use crate::lit::{SurfaceEffects, reads_uv};
use crate::ready::Ready;
use crate::solid::SolidStage;
use crate::texel::TexelStage;
use crate::textures::{Chains, Slot};
use crate::vertices::{Values, VertexData, Vertices};
use crate::volume::{VolumeStage, far_sides};
use crate::{
    AlphaMode, Aov, Backdrop, Gouraud, Material, Mesh, RenderError, Scene, Settings, Shading,
    TextureRole, TextureSlot,
};

pub(crate) use cut::{Cut, cut};

/// All draws of one pass over a grid of samples.
pub(crate) struct Plan<'s> {
    pub(crate) surfaces: Vec<Surface<'s>>,
    pub(crate) lights: &'s [Light],
    pub(crate) ready: Arc<Ready<'s>>,
    pub(crate) eye: [f32; 3],
    pub(crate) rays: EyeRays,
    pub(crate) level: texmap_math::Level,
}

/// One mesh, ready for the rasterizer and the stages.
pub(crate) struct Surface<'s> {
    pub(crate) mesh: &'s Mesh,
    pub(crate) material: &'s Material,
    pub(crate) base_color: Option<Slot<'s>>,
    pub(crate) opacity_map: Option<Slot<'s>>,
    pub(crate) color_ramp: Option<Slot<'s>>,
    pub(crate) light_ramp: Option<Slot<'s>>,
    pub(crate) decal: Option<Slot<'s>>,
    pub(crate) carved: Option<SolidStage<'s>>,
    /// The only stage of what is no surface.
    pub(crate) space: Option<Box<Space<'s>>>,
    pub(crate) uv: Coordinates,
    pub(crate) light: LightStage,
    /// What a surface lit per pixel is under beside plain lights.
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
    pub(crate) texel: Option<TexelStage>,
    /// `None` if nothing is cut out.
    cut: Option<Cut>,
    pub(crate) pass: Pass,
    /// Instead of the scene's.
    depth_test: Option<DepthTest>,
    vertices: VertexData<'s>,
    interp: Interp,
    interp_scale: f32,
    clip_from_object: DMat4,
}

/// What is seen along a ray rather than on a surface.
pub(crate) enum Space<'s> {
    Sky(SkyStage<'s>),
    Volume(VolumeStage<'s>),
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
            material,
            base_color: None,
            opacity_map: None,
            color_ramp: None,
            light_ramp: None,
            decal: None,
            carved: None,
            space: None,
            uv: Coordinates::None,
            light: LightStage::None,
            effects: None,
            color: None,
            normal: None,
            position: None,
            shaded: vertices.attribute_count,
            solid: false,
            texel: None,
            cut: None,
            pass: Pass::Blended,
            depth_test: Some(depth_test),
            vertices,
            interp: Interp::Perspective,
            interp_scale: 1.0,
            clip_from_object,
        }
    }
}

impl Surface<'_> {
    fn kept(&self, fragment: &Fragment) -> bool {
        let Some(cut) = self.cut else { return true };
        let maps = [&self.base_color, &self.opacity_map].map(Option::as_ref);
        cut.keeps(self.uv.at(fragment), maps, self.material.opacity)
    }
}

impl AlphaTest for Plan<'_> {
    fn keep(&self, draw: u32, _triangle: u32, fragment: &Fragment) -> bool {
        self.surfaces[draw as usize].kept(fragment)
    }

    fn keep_by_uv(&self, draw: u32, at: &UvBlock, asked: u16) -> Option<u16> {
        let surface = &self.surfaces[draw as usize];
        if !matches!(surface.uv, Coordinates::Vertices) {
            return None;
        }
        let Some(cut) = surface.cut else {
            return Some(asked);
        };
        let maps = [&surface.base_color, &surface.opacity_map].map(Option::as_ref);
        Some(cut.keeps_block(self.level, at, maps, surface.material.opacity))
    }
}

impl<'s> Plan<'s> {
    /// A plan for `width` x `height` samples with the attributes that the shading needs and those of `aovs`.
    pub(crate) fn new(
        scene: &'s Scene,
        settings: &Settings,
        chains: &Chains,
        ready: &Arc<Ready<'s>>,
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
        let mut surfaces = Vec::with_capacity(scene.meshes.len());
        surfaces.extend(sky(scene, settings, chains, &view));
        for mesh in &scene.meshes {
            surfaces.push(surface(scene, settings, chains, ready, &view, mesh, aovs));
        }
        for volume in &scene.effects.volumes {
            let transfer = volume
                .transfer
                .as_ref()
                .map(|slot| (&scene.textures[slot.texture], &slot.sampler));
            let rays = Rays::new(view.half, view.size);
            let to_view = view.view_from_world;
            let stage = VolumeStage::new(volume, scene, transfer, rays, to_view, projection)?;
            surfaces.push(Surface {
                space: Some(Box::new(Space::Volume(stage))),
                ..far_sides(volume, view.clip_from_world)
            });
        }
        let eye = scene.camera.eye.to_array().map(|x| x as f32);
        Ok(Self {
            surfaces,
            lights: &scene.lights,
            ready: Arc::clone(ready),
            eye,
            rays: EyeRays::new(&Rays::new(view.half, view.size), view.view_from_world),
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
                depth_test: s.depth_test.unwrap_or(scene.depth_test),
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

/// The backdrop.
fn sky<'s>(
    scene: &'s Scene,
    settings: &Settings,
    chains: &Chains,
    view: &View,
) -> Option<Surface<'s>> {
    let mut surface = behind();
    match scene.effects.backdrop.as_ref()? {
        Backdrop::Picture(slot) => {
            let slot = Slot::new(slot, scene, settings, chains, Origin::TopLeft);
            surface.solid = !slot.can_be_transparent();
            surface.texel = TexelStage::new(surface.material, Some(&slot), scene.color);
            surface.uv = Coordinates::Vertices;
            surface.base_color = Some(slot);
        }
        Backdrop::Environment(index) => {
            let environment = &scene.effects.environments[*index];
            let rays = Rays::new(view.half, view.size);
            let stage = SkyStage::new(environment, rays, view.view_from_world);
            surface.space = Some(Box::new(Space::Sky(stage)));
            surface.shaded = 0;
        }
    }
    Some(surface)
}

fn surface<'s>(
    scene: &'s Scene,
    settings: &Settings,
    chains: &Chains,
    ready: &Ready<'s>,
    view: &View,
    mesh: &'s Mesh,
    aovs: &[Aov],
) -> Surface<'s> {
    let material = &scene.materials[mesh.material];
    let base_color = material
        .base_color
        .as_ref()
        .map(|s| Slot::new(s, scene, settings, chains, mesh.uv_origin));
    let opacity_map = material
        .opacity_map
        .as_ref()
        .filter(|_| material.alpha != AlphaMode::Opaque)
        .map(|s| Slot::new(s, scene, settings, chains, mesh.uv_origin));
    let ramp = |slot: &'s Option<TextureSlot>| {
        let slot = slot.as_ref();
        slot.map(|s| Slot::ramp(s, scene, chains))
    };
    let colored = material.solid.is_some() || base_color.is_some();
    let color_ramp = ramp(&material.color_ramp).filter(|_| colored);
    let decal = material
        .decal
        .as_ref()
        .map(|s| Slot::new(s, scene, settings, chains, mesh.uv_origin));
    let clear_texels = base_color.as_ref().is_some_and(Slot::can_be_transparent);
    // The lit surface is out of sight behind a decal that covers it.
    let shows_surface = base_color.is_none()
        || material.texture_role == TextureRole::Modulate
        || (material.alpha == AlphaMode::Opaque && clear_texels);
    let cut = cut(material, base_color.as_ref(), opacity_map.as_ref());
    let pass = match material.alpha {
        AlphaMode::Blend => Pass::Blended,
        _ if cut.is_some() => Pass::CutOut,
        _ => Pass::Opaque,
    };
    let interp = match settings.interp.unwrap_or(material.interp) {
        // Its tolerance is one of coordinates at the vertices; a round mapping has none.
        Interp::WithinError(_) if mesh.round.is_some() => Interp::Perspective,
        interp => interp,
    };
    let mut vertices = Vertices::default();
    let textured = base_color.is_some()
        || opacity_map.is_some()
        || decal.is_some()
        || material.shading == Shading::PerPixel && reads_uv(material);

    let mut position = None;
    let uv = match mesh.frame {
        _ if mesh.round.is_some() && (textured || aovs.contains(&Aov::Uv)) => {
            let first = vertices.push(Values::Position, false);
            position = Some(first);
            mesh.round
                .map_or(Coordinates::None, |map| Coordinates::Round(map, first))
        }
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
    let covered = base_color.is_some() && material.texture_role == TextureRole::Decal;
    let varies = base_color.is_some() || material.solid.is_some() || decal.is_some();
    let light = light_stage(material, shows_surface, varies && !covered, &mut vertices);
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
    let at_a_vertex = matches!(uv, Coordinates::Vertices) || base_color.is_none();
    let unlit = matches!(light, LightStage::None) && color.is_none() && opacity_map.is_none();
    let plain = !material.crisp && color_ramp.is_none() && decal.is_none() && carved.is_none();
    let texel = (at_a_vertex && unlit && plain)
        .then(|| TexelStage::new(material, base_color.as_ref(), scene.color))
        .flatten();

    let vertices = vertices.finish(scene, mesh);
    let (width, height) = base_color
        .as_ref()
        .map_or((1, 1), |s| (s.texture.width(), s.texture.height()));
    Surface {
        mesh,
        material,
        color_ramp,
        light_ramp,
        decal,
        carved,
        space: None,
        uv,
        light,
        effects,
        color,
        normal,
        position,
        shaded,
        solid: !clear_texels,
        texel,
        cut,
        pass,
        depth_test: None,
        interp,
        interp_scale: width.max(height) as f32,
        clip_from_object: view.clip_from_world * mesh.world_from_object,
        vertices,
        base_color,
        opacity_map,
    }
}

fn light_stage(
    material: &Material,
    shows_surface: bool,
    has_texel: bool,
    vertices: &mut Vertices,
) -> LightStage {
    let screen = material.gouraud == Gouraud::ScreenLinear;
    match material.shading {
        Shading::PerPixel if shows_surface => LightStage::PerPixel,
        // A texel multiplies the diffuse term only; without one, colours are finished at the vertices.
        Shading::PerVertex if has_texel => {
            let diffuse = vertices.push(Values::Diffuse, screen);
            let shiny = material.surface.ks > 0.0;
            let highlight = shiny.then(|| vertices.push(Values::Highlight, screen));
            LightStage::Terms { diffuse, highlight }
        }
        Shading::PerVertex if shows_surface => {
            LightStage::Colors(vertices.push(Values::Lit, screen))
        }
        _ => LightStage::None,
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

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_math::glam::DVec3;
    use texmap_raster::DepthTest;
    use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, UvTransform, Wrap};

    use crate::TextureSlot;

    fn scene(material: Material) -> Scene {
        let texture =
            Texture2d::from_rgba8(4, 4, vec![255; 64], ColorSpace::Srgb, Origin::TopLeft).unwrap();
        let mesh = Mesh {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            uvs: vec![[0.0; 2]; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        Scene {
            camera: Camera {
                eye: DVec3::new(0.0, 0.0, 5.0),
                look: DVec3::ZERO,
                up: DVec3::Y,
                fov_x: 1.0,
                near: 1e-4,
                far: f64::INFINITY,
            },
            background: [0.0; 4],
            color: crate::ColorMode::Srgb,
            depth_test: DepthTest::Less,
            lights: vec![Light::Ambient { color: [1.0; 3] }],
            textures: vec![texture],
            materials: vec![material],
            meshes: vec![mesh],
            warnings: Vec::new(),
            effects: Default::default(),
        }
    }

    fn slot(filter: Filter) -> Option<TextureSlot> {
        let sampler = Sampler {
            filter,
            ..Sampler::default()
        };
        Some(TextureSlot {
            texture: 0,
            sampler,
            transform: UvTransform::default(),
        })
    }

    /// Which surfaces are shaded sixteen samples at a time, where the level has lanes.
    #[test]
    fn surfaces_lit_per_pixel_have_lanes() {
        let has_lanes = |material: Material| {
            let mut scene = scene(material);
            scene.meshes[0].lightmap_uvs = vec![[0.0; 2]; 3];
            let settings = Settings::new(8, 8);
            let chains = Chains::new(&scene, &settings);
            let ready = Arc::new(Ready::new(&scene, &settings).unwrap());
            let plan = Plan::new(&scene, &settings, &chains, &ready, (8, 8), &[]).unwrap();
            crate::lit_lanes::LitLanes::new(&plan, &plan.surfaces[0]).is_some()
        };
        let normals = |object_space| crate::Relief::NormalMap {
            slot: slot(Filter::Trilinear).unwrap(),
            green: texmap_light::Green::Up,
            rebuild_z: false,
            object_space,
            strength: 1.0,
        };
        let with = |relief| Material {
            relief: Some(relief),
            ..Material::default()
        };
        let baked = Material {
            light_map: Some(crate::LightMapSlot {
                slot: slot(Filter::Bilinear).unwrap(),
                scale: 1.0,
                baked: None,
            }),
            ..Material::default()
        };
        let some = has_lanes(Material::default());
        let bump = crate::Relief::Bump {
            slot: slot(Filter::Bilinear).unwrap(),
            height: 0.1,
        };
        for material in [with(normals(false)), with(normals(true)), with(bump), baked] {
            assert_eq!(has_lanes(material), some);
        }
        // A texel that covers the light.
        let decal = Material {
            base_color: slot(Filter::Bilinear),
            texture_role: TextureRole::Decal,
            ..Material::default()
        };
        assert!(!has_lanes(decal));
    }

    /// Attributes per vertex, pass, and whether a mip chain was built.
    fn needs(material: Material, aovs: &[Aov]) -> (usize, Pass, bool) {
        let scene = scene(material);
        let settings = Settings::new(8, 8);
        let chains = Chains::new(&scene, &settings);
        let ready = Arc::new(Ready::new(&scene, &settings).unwrap());
        let plan = Plan::new(&scene, &settings, &chains, &ready, (8, 8), aovs).unwrap();
        let surface = &plan.surfaces[0];
        (
            surface.vertices.attribute_count,
            surface.pass,
            chains.0[0].is_some(),
        )
    }

    #[test]
    fn a_scene_carries_what_it_needs_and_no_more() {
        let unlit = Material {
            shading: Shading::Unlit,
            ..Material::default()
        };
        assert_eq!(needs(unlit.clone(), &[]), (0, Pass::Opaque, false));
        assert_eq!(
            needs(unlit.clone(), &[Aov::Depth, Aov::InvW, Aov::Face]).0,
            0
        );
        assert_eq!(needs(unlit.clone(), &[Aov::Normal, Aov::Uv]).0, 5);
        let nearest = Material {
            base_color: slot(Filter::Nearest),
            ..unlit.clone()
        };
        assert_eq!(needs(nearest, &[]), (2, Pass::Opaque, false));
        let trilinear = Material {
            base_color: slot(Filter::Trilinear),
            ..unlit
        };
        assert_eq!(needs(trilinear, &[]), (2, Pass::Opaque, true));
        // Only an ambient light: no position. A decal that covers its surface: no light at all.
        assert_eq!(needs(Material::default(), &[]).0, 3);
        let decal = Material {
            base_color: slot(Filter::Nearest),
            texture_role: TextureRole::Decal,
            ..Material::default()
        };
        assert_eq!(needs(decal, &[]).0, 2);
    }

    #[test]
    fn an_alpha_test_of_opaque_texels_is_no_test() {
        let opaque = Material {
            base_color: slot(Filter::Nearest),
            alpha: AlphaMode::Test(0.5),
            ..Material::default()
        };
        assert_eq!(needs(opaque.clone(), &[]).1, Pass::Opaque);
        let mut bordered = opaque;
        bordered.base_color.as_mut().unwrap().sampler.wrap_u = Wrap::ClampToBorder;
        assert_eq!(needs(bordered.clone(), &[]).1, Pass::CutOut);
        assert_eq!(
            needs(
                Material {
                    alpha: AlphaMode::Opaque,
                    ..bordered
                },
                &[]
            )
            .1,
            Pass::Opaque
        );
    }
}
