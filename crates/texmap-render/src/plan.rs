//! Draws of a checked scene: values per vertex of each mesh, and the stages that run on its pixels.

mod alpha_test;
pub(crate) mod effects;
mod light_stage;
mod maps;
mod shader;
mod space;
mod surface;

use std::sync::Arc;
use texmap_scene::SceneError;

use texmap_light::{EnvironmentLight, Light};
use texmap_math::glam::DMat4;
use texmap_raster::DrawCall;
use texmap_sample::Origin;

use crate::frame_resources::FrameResources;
use crate::textures::Chains;
use crate::{Aov, RenderError, RenderSettings};
use texmap_math::ViewRays;
use texmap_scene::{Background, Scene, ToneMapping};
use texmap_shade::compose::Display;
use texmap_shade::coordinates::{Coordinates, EyeRays};
use texmap_shade::sky::{Sky, SkyStage};
use texmap_shade::unlit::UnlitColor;
use texmap_shade::volume::VolumeStage;

pub(crate) use alpha_test::{AlphaTestStage, BoundAlphaTests, alpha_test, bound};
pub(crate) use shader::Shader;
use space::{behind, far_sides};
use surface::surface;
pub(crate) use surface::{Space, Surface};

/// All draws of one pass over a grid of samples.
pub(crate) struct Plan<'s> {
    pub(crate) surfaces: Vec<Surface<'s>>,
    pub(crate) lights: &'s [Light],
    pub(crate) ready: Arc<FrameResources<'s>>,
    pub(crate) environment_light: Option<&'s EnvironmentLight>,
    pub(crate) tone_mapping: ToneMapping,
    pub(crate) eye: [f32; 3],
    pub(crate) rays: EyeRays,
    pub(crate) level: texmap_math::Level,
}

impl<'s> Plan<'s> {
    /// A plan for `width` x `height` samples with the attributes that the shading needs and those of `aovs`.
    pub(crate) fn new(
        scene: &'s Scene,
        settings: &RenderSettings,
        chains: &Chains,
        ready: &Arc<FrameResources<'s>>,
        (width, height): (u32, u32),
        aovs: &[Aov],
    ) -> Result<Self, RenderError> {
        let aspect = f64::from(width) / f64::from(height);
        let view = scene.camera.view().map_err(SceneError::Camera)?;
        let projection = scene.camera.projection(aspect);
        let view = View {
            view_from_world: view,
            clip_from_world: projection * view,
            half: [1.0 / projection.x_axis.x, 1.0 / projection.y_axis.y],
            size: [f64::from(width), f64::from(height)],
            center: scene.camera.lens.center,
            parallel: scene.camera.lens.parallel_width.is_some(),
        };
        let mut surfaces = Vec::with_capacity(scene.meshes.len());
        surfaces.extend(sky(scene, settings, chains, &view));
        for draw in scene.drawing_order() {
            let mesh = &scene.meshes[draw.mesh];
            let surface = surface(scene, settings, chains, ready, &view, mesh, aovs);
            surfaces.push(Surface {
                number: draw.mesh as u32,
                cull: draw.cull,
                ..surface
            });
        }
        for volume in &scene.effects.volumes {
            let transfer = volume
                .transfer
                .as_ref()
                .map(|slot| (&scene.textures[slot.texture], &slot.sampler));
            let rays = view.rays();
            let to_view = view.view_from_world;
            let level = settings.level;
            let stage =
                VolumeStage::new(volume, scene, transfer, rays, level, to_view, projection)?;
            surfaces.push(Surface {
                space: Some(Space::Volume(Box::new(stage))),
                ..far_sides(volume, view.clip_from_world)
            });
        }
        let eye = scene.camera.viewpoint().to_array().map(|x| x as f32);
        Ok(Self {
            surfaces,
            lights: &scene.lights,
            environment_light: scene.effects.environment_light.as_ref(),
            tone_mapping: scene.effects.tone_mapping,
            ready: Arc::clone(ready),
            eye,
            rays: match view.parallel {
                true => EyeRays::parallel(view.view_from_world),
                false => EyeRays::new(&view.rays(), view.view_from_world),
            },
            level: settings.level,
        })
    }

    pub(crate) fn draws(&self, scene: &Scene) -> Vec<DrawCall<'_>> {
        self.surfaces
            .iter()
            .map(|s| DrawCall {
                positions: &s.vertices.positions,
                clip_z: &[],
                indices: &s.vertices.triangles,
                clip_from_object: s.clip_from_object,
                attributes: &s.vertices.attributes,
                attribute_count: s.vertices.attribute_count,
                screen_linear: s.vertices.screen_linear,
                interp: s.interp,
                interp_scale: s.interp_scale,
                cull: s.cull,
                depth_test: s.depth_test.unwrap_or(scene.depth_test),
                depth_write: true,
                pass: s.pass,
                depth_slope: 0.0,
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
    /// The principal point, as in a lens.
    center: [f64; 2],
    /// A parallel projection.
    parallel: bool,
}

impl View {
    /// The rays of a central projection.
    fn rays(&self) -> ViewRays {
        ViewRays::new(self.half, self.size).around(self.center)
    }
}

/// The surface of the sky, which lies behind all others; `None` without a sky.
fn sky<'s>(
    scene: &'s Scene,
    settings: &RenderSettings,
    chains: &Chains,
    view: &View,
) -> Option<Surface<'s>> {
    let mut surface = behind();
    match scene.effects.background.as_ref()? {
        Background::Picture(slot) => {
            let slot = chains.slot(slot, scene, settings, Origin::TopLeft);
            surface.solid = !slot.can_be_transparent();
            let limit = scene.effects.tone_mapping.map.limit();
            let unlit = UnlitColor::new(surface.material, Some(&slot), scene.color);
            surface.unlit = unlit.map(|color| color.with_limit(limit));
            surface.uv = Coordinates::Vertices;
            surface.base_color = Some(slot);
        }
        Background::Environment(index) => {
            let environment = &scene.effects.environments[*index];
            show(&mut surface, Sky::Chart(environment), scene, view);
        }
        Background::EnvironmentLight => {
            let light = scene.effects.environment_light.as_ref()?;
            show(&mut surface, Sky::Light(light), scene, view);
        }
    }
    Some(surface)
}

/// Makes a surface show a sky.
fn show<'s>(surface: &mut Surface<'s>, sky: Sky<'s>, scene: &Scene, view: &View) {
    let display = Display::new(scene.effects.tone_mapping);
    let stage = SkyStage::new(sky, &view.rays(), view.view_from_world, display);
    surface.space = Some(Space::Sky(stage));
    surface.shaded = 0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_math::glam::DVec3;
    use texmap_raster::Pass;
    use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, Wrap};

    use texmap_scene::{AlphaMode, Material, Mesh, Shading, TextureRole, TextureSlot};

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
            background: [0.0; 4],
            lights: vec![Light::Ambient { color: [1.0; 3] }],
            textures: vec![texture],
            materials: vec![material],
            meshes: vec![mesh],
            ..Scene::new(Camera {
                eye: DVec3::new(0.0, 0.0, 5.0),
                look: DVec3::ZERO,
                up: DVec3::Y,
                fov_x: 1.0,
                near: 1e-4,
                far: f64::INFINITY,
                lens: Default::default(),
            })
        }
    }

    fn slot(filter: Filter) -> Option<TextureSlot> {
        let sampler = Sampler {
            filter,
            ..Sampler::default()
        };
        Some(TextureSlot {
            sampler,
            ..TextureSlot::new(0)
        })
    }

    /// Surfaces that read a few columns of vectors and the texels of a set, and those that read all of their attributes.
    #[test]
    fn plain_lit_surfaces_read_few_columns() {
        let is_short = |material: Material| {
            let mut scene = scene(material);
            scene.meshes[0].lightmap_uvs = vec![[0.0; 2]; 3];
            let settings = RenderSettings::new(8, 8);
            let chains = Chains::new(&scene, &settings).unwrap();
            let ready = Arc::new(FrameResources::new(&scene, &settings).unwrap());
            let plan = Plan::new(&scene, &settings, &chains, &ready, (8, 8), &[]).unwrap();
            match Shader::new(&plan, &plan.surfaces[0]) {
                Shader::Surface(shader) => shader.attributes.is_none(),
                _ => false,
            }
        };
        let normals = |object_space| texmap_scene::NormalDetail::NormalMap {
            slot: slot(Filter::Trilinear).unwrap(),
            green: texmap_light::NormalMapGreen::Up,
            rebuild_z: false,
            object_space,
            strength: 1.0,
        };
        let with = |detail| Material {
            normal_detail: Some(detail),
            ..Material::default()
        };
        let baked = Material {
            light_map: Some(texmap_scene::LightMapSlot {
                slot: slot(Filter::Bilinear).unwrap(),
                scale: 1.0,
                baked: None,
            }),
            ..Material::default()
        };
        let metallic = |map: Option<TextureSlot>| Material {
            metallic_roughness: Some(texmap_scene::MetallicRoughness {
                map: map.clone(),
                ..Default::default()
            }),
            emission: Some(texmap_scene::Emission {
                color: [1.0; 3],
                map,
            }),
            ..Material::default()
        };
        for material in [
            Material::default(),
            with(normals(false)),
            with(normals(true)),
            baked,
            metallic(slot(Filter::Trilinear)),
        ] {
            assert!(is_short(material));
        }
        // Maps that a stage reads itself: under a transform here.
        let turned = slot(Filter::Trilinear).map(|slot| TextureSlot {
            transform: texmap_sample::UvTransform {
                scale: [2.0, 1.0],
                ..Default::default()
            },
            ..slot
        });
        let bump = texmap_scene::NormalDetail::Bump {
            slot: slot(Filter::Bilinear).unwrap(),
            height: 0.1,
        };
        let blended = Material {
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        let decal = Material {
            base_color: slot(Filter::Bilinear),
            texture_role: TextureRole::Decal,
            ..Material::default()
        };
        for material in [with(bump), blended, decal, metallic(turned)] {
            assert!(!is_short(material));
        }
    }

    /// Attributes per vertex, pass, and true if a mip chain was built.
    fn needs(material: Material, aovs: &[Aov]) -> (usize, Pass, bool) {
        let scene = scene(material);
        let settings = RenderSettings::new(8, 8);
        let chains = Chains::new(&scene, &settings).unwrap();
        let ready = Arc::new(FrameResources::new(&scene, &settings).unwrap());
        let plan = Plan::new(&scene, &settings, &chains, &ready, (8, 8), aovs).unwrap();
        let surface = &plan.surfaces[0];
        (
            surface.vertices.attribute_count,
            surface.pass,
            chains.made[0].is_some(),
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
