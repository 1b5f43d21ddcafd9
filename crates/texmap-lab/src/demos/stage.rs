//! The props of the demos: quads and cubes, their materials, and pictures taken of them.

use texmap_light::{Light, PhongMaterial};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec2, DVec3, DVec4};
use texmap_raster::Interp;
use texmap_render::{Aov, AovData, Frame, RenderSettings};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, Wrap};
use texmap_scene::{
    AlphaMode, Material, Mesh, Scene, Shading, Shadow, TextureRole, TextureSlot, VertexColorInterp,
};

use crate::LabError;
use texmap_truth::picture::Picture;

/// Sky behind everything, as sRGB values.
const BACKGROUND: [f32; 4] = [0.80, 0.85, 0.90, 1.0];

/// An empty scene seen from `eye`; `fov` is horizontal, in degrees.
pub(super) fn scene(eye: DVec3, look: DVec3, fov: f64) -> Scene {
    let fov_x = fov.to_radians();
    Scene {
        background: BACKGROUND,
        depth_test: texmap_raster::DepthTest::Less,
        ..Scene::new(Camera {
            eye,
            look,
            up: DVec3::Y,
            fov_x,
            near: 1e-3,
            far: f64::INFINITY,
        })
    }
}

/// Adds a texture with its mip chain.
pub(super) fn texture(scene: &mut Scene, picture: &Picture) -> Result<usize, LabError> {
    let rgba = picture.rgba().to_vec();
    let texture = Texture2d::from_rgba8(
        picture.width(),
        picture.height(),
        rgba,
        ColorSpace::Srgb,
        Origin::TopLeft,
    )?
    .with_mips();
    scene.textures.push(texture);
    Ok(scene.textures.len() - 1)
}

/// Grey ambient light and light from one direction.
pub(super) fn daylight(ambient: f32, color: [f32; 3], direction: [f32; 3]) -> Vec<Light> {
    let ambient = Light::Ambient {
        color: [ambient; 3],
    };
    vec![ambient, Light::Directional { color, direction }]
}

/// The default shadow of a light: a map of `size` texels a side, 3 x 3 comparisons.
pub(super) fn shadow(light: usize, size: u32) -> Shadow {
    Shadow {
        light,
        size: Some(size),
        bias: None,
        pcf_size: 3,
        area: None,
    }
}

/// A slot with one filter, and one wrap mode in both directions.
pub(super) fn slot(texture: usize, filter: Filter, wrap: Wrap) -> TextureSlot {
    let sampler = sampler(filter, wrap);
    TextureSlot {
        sampler,
        ..TextureSlot::new(texture)
    }
}

/// A sampler with one filter, and one wrap mode in both directions.
pub(super) fn sampler(filter: Filter, wrap: Wrap) -> Sampler {
    Sampler {
        filter,
        wrap_u: wrap,
        wrap_v: wrap,
        ..Sampler::default()
    }
}

/// Adds a row of sRGB colours and alphas as a texture, and gives the slot of a ramp.
pub(super) fn ramp(
    scene: &mut Scene,
    stops: &[[u8; 4]],
    filter: Filter,
) -> Result<TextureSlot, LabError> {
    let (width, texels) = (stops.len() as u32, stops.concat());
    let texture = Texture2d::from_rgba8(width, 1, texels, ColorSpace::Srgb, Origin::TopLeft)?;
    scene.textures.push(texture);
    Ok(slot(scene.textures.len() - 1, filter, Wrap::ClampToEdge))
}

/// Adds an unlit material that copies the texels of a texture.
pub(super) fn decal(scene: &mut Scene, texture: usize, filter: Filter, interp: Interp) -> usize {
    add(
        scene,
        Material {
            base_color: Some(slot(texture, filter, Wrap::Repeat)),
            texture_role: TextureRole::Decal,
            shading: Shading::Unlit,
            interp,
            ..Material::default()
        },
    )
}

/// Adds an unlit material that shows the colours of the vertices.
pub(super) fn vertex_colors(scene: &mut Scene, gouraud: VertexColorInterp) -> usize {
    let surface = PhongMaterial {
        color: [1.0; 3],
        ..PhongMaterial::default()
    };
    add(
        scene,
        Material {
            phong: surface,
            shading: Shading::Unlit,
            vertex_color_interp: gouraud,
            ..Material::default()
        },
    )
}

/// Adds a material and gives its index.
pub(super) fn add(scene: &mut Scene, material: Material) -> usize {
    scene.materials.push(material);
    scene.materials.len() - 1
}

/// Sets what alpha does and how the texture of a material is wrapped.
pub(super) fn set_alpha(scene: &mut Scene, material: usize, alpha: AlphaMode) {
    scene.materials[material].alpha = alpha;
}

/// Sets both wrap modes of the base colour of a material.
pub(super) fn set_wrap(scene: &mut Scene, material: usize, wrap: Wrap) {
    if let Some(slot) = &mut scene.materials[material].base_color {
        (slot.sampler.wrap_u, slot.sampler.wrap_v) = (wrap, wrap);
    }
}

/// A quad from its corners (top left, then clockwise as one looks at it) with v growing downward.
pub(super) fn quad(corners: [DVec3; 4], uv: [[f32; 2]; 4], material: usize) -> Mesh {
    Mesh {
        uvs: uv.to_vec(),
        material,
        ..Mesh::quad(corners.map(|p| p.as_vec3().to_array()))
    }
}

/// The square of half side 1 about the origin, seen from +z, with the whole texture.
pub(super) fn square(material: usize) -> Mesh {
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    quad(
        corners.map(|(x, y)| DVec3::new(x, y, 0.0)),
        UNIT_UV,
        material,
    )
}

/// The whole texture once.
pub(super) const UNIT_UV: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A cube of edge 2 about the origin, turned by `yaw` degrees about the vertical and moved to `center`. Each
/// face carries the whole texture; the faces are numbered front, right, back, left, top, bottom.
pub(super) fn cube(center: DVec3, yaw: f64, material: usize) -> Mesh {
    Mesh {
        material,
        world_from_object: DMat4::from_translation(center) * turn(yaw),
        ..Mesh::cube()
    }
}

/// Rotation about the vertical, from the corpus of exact trigonometry of the math crate.
fn turn(yaw: f64) -> DMat4 {
    let (sin, cos) = texmap_math::deterministic_f64::sin_cos(yaw.to_radians());
    DMat4::from_cols(
        DVec3::new(cos, 0.0, -sin).extend(0.0),
        DVec3::Y.extend(0.0),
        DVec3::new(sin, 0.0, cos).extend(0.0),
        DVec4::W,
    )
}

/// A picture of a scene without buffers, smoothed by 3 x 3 samples.
pub(super) fn photograph(scene: &Scene, size: u32) -> Result<Picture, LabError> {
    picture(scene, size, 3)
}

/// A picture of a scene with `supersample` x `supersample` samples a pixel.
pub(super) fn picture(scene: &Scene, size: u32, supersample: u32) -> Result<Picture, LabError> {
    let settings = RenderSettings {
        supersample,
        ..RenderSettings::new(size, size)
    };
    let scene = texmap_mesh::tessellate(scene, size)?;
    Ok(texmap_render::render(&scene, &settings, &texmap_render::no_progress)?.into())
}

/// A frame at one sample a pixel with further buffers.
pub(super) fn with_aovs(scene: &Scene, size: u32, aovs: Vec<Aov>) -> Result<Frame, LabError> {
    let settings = RenderSettings {
        aovs,
        ..RenderSettings::new(size, size)
    };
    let scene = texmap_mesh::tessellate(scene, size)?;
    Ok(texmap_render::render(
        &scene,
        &settings,
        &texmap_render::no_progress,
    )?)
}

/// The floats of a buffer; none if the frame lacks it.
pub(super) fn floats_of(frame: &Frame, wanted: Aov) -> &[f32] {
    match frame.aovs.iter().find(|(aov, ..)| *aov == wanted) {
        Some((_, _, AovData::F32(values))) => values,
        _ => &[],
    }
}

/// A picture at one sample a pixel together with what lies under each pixel.
#[derive(Debug)]
pub(super) struct Shot {
    pub(super) picture: Picture,
    size: u32,
    uv: Vec<f32>,
    face: Vec<u32>,
    depth: Vec<f32>,
}

impl Shot {
    /// Takes the picture.
    pub(super) fn take(scene: &Scene, size: u32) -> Result<Self, LabError> {
        let frame = with_aovs(scene, size, vec![Aov::Uv, Aov::Face, Aov::Depth])?;
        let face = match frame.aovs.iter().find(|(aov, ..)| *aov == Aov::Face) {
            Some((_, _, AovData::U32(values))) => values.clone(),
            _ => Vec::new(),
        };
        Ok(Self {
            size,
            uv: floats_of(&frame, Aov::Uv).to_vec(),
            face,
            depth: floats_of(&frame, Aov::Depth).to_vec(),
            picture: frame.into(),
        })
    }

    /// Pixels a side.
    pub(super) fn size(&self) -> u32 {
        self.size
    }

    /// Every pixel (x, y) of the shot, row by row.
    pub(super) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let size = self.size;
        (0..size).flat_map(move |y| (0..size).map(move |x| (x, y)))
    }

    /// Coordinates under a pixel, as interpolated; `None` where nothing textured is seen.
    pub(super) fn uv(&self, x: u32, y: u32) -> Option<DVec2> {
        let i = self.index(x, y) * 2;
        let at = DVec2::new(f64::from(*self.uv.get(i)?), f64::from(*self.uv.get(i + 1)?));
        at.is_finite().then_some(at)
    }

    /// The face under a pixel.
    pub(super) fn face(&self, x: u32, y: u32) -> Option<u32> {
        self.face
            .get(self.index(x, y))
            .copied()
            .filter(|&face| face != u32::MAX)
    }

    /// The depth buffer at a pixel (1 near, 0 far); `None` where nothing is seen.
    pub(super) fn depth(&self, x: u32, y: u32) -> Option<f32> {
        self.depth
            .get(self.index(x, y))
            .copied()
            .filter(|depth| depth.is_finite())
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.size as usize + x as usize
    }
}
