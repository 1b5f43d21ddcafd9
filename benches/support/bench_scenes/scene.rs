//! The benchmark scenes as scenes of texmap.

use texmap_light::PhongMaterial;
use texmap_math::camera::Camera;
use texmap_math::deterministic_f64::{atan, tan};
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{Cull, DepthTest};
use texmap_sample::{ColorSpace, Filter, Origin, Precision, SampleError, Sampler, Texture2d};
use texmap_scene::{
    AlphaMode, ColorMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot,
};

use super::{
    BASE_SIZE, BenchScene, CLEAR, Content, FLAT, HEIGHT, LIT_EYE, Lookup, WIDTH, base, turn,
};

/// Treatment of the opaque layers of `fill`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hidden {
    /// Every layer is shaded: the work that the peers do.
    Shaded,
    /// Visibility first: what cannot be seen is not shaded.
    Skipped,
}

impl BenchScene {
    /// The scene in texmap's terms; `None` for the depth scenes, which have no colour.
    ///
    /// The layers stand before a perspective camera, each at its own distance and scaled to fill the view, since
    /// 1 / w is constant on each the picture is that of clip space.
    ///
    /// # Errors
    /// None in practice: the texture is well formed.
    pub fn scene(
        &self,
        precision: Precision,
        hidden: Hidden,
    ) -> Result<Option<Scene>, SampleError> {
        match self.content {
            Content::Depth { .. } => return Ok(None),
            Content::Lit { .. } | Content::Mirror | Content::Projective | Content::Metallic => {
                return super::lit::scene(self, precision).map(Some);
            }
            _ => {}
        }
        let texture = Texture2d::from_rgba8(
            BASE_SIZE,
            BASE_SIZE,
            base(),
            self.color_space(),
            Origin::TopLeft,
        )?;
        let mesh = self.mesh();
        let mut positions = mesh.positions;
        let half = [half_width(), half_height()];
        if matches!(self.content, Content::Layers { .. }) {
            for (i, p) in positions.iter_mut().enumerate() {
                let distance = 8.0 - (i / 4) as f64 * 0.5;
                *p = [
                    (f64::from(p[0]) * half[0] * distance) as f32,
                    (f64::from(p[1]) * half[1] * distance) as f32,
                    -distance as f32,
                ];
            }
        }
        let sphere = matches!(self.content, Content::Sphere { .. });
        let world_from_object = if sphere { model() } else { DMat4::IDENTITY };
        let mesh = Mesh {
            name: self.name.to_owned(),
            positions,
            uvs: mesh.uvs,
            triangles: mesh.triangles,
            world_from_object,
            ..Mesh::default()
        };
        Ok(Some(Scene {
            background: CLEAR,
            color: self.color,
            depth_test: match self.content {
                Content::Layers { depth: false, .. } => DepthTest::Always,
                _ => DepthTest::Less,
            },
            textures: vec![texture],
            materials: vec![self.material(precision, hidden)],
            meshes: if self.content == Content::Clear {
                Vec::new()
            } else {
                vec![mesh]
            },
            ..Scene::new(self.camera())
        }))
    }

    /// Of the pictures, not of normal maps.
    pub(super) fn color_space(&self) -> ColorSpace {
        match self.color {
            ColorMode::Raw => ColorSpace::Linear,
            ColorMode::Srgb => ColorSpace::Srgb,
        }
    }

    pub(super) fn camera(&self) -> Camera {
        let (eye, look, near, far) = match self.content {
            Content::Lit { .. } | Content::Projective => (LIT_EYE, [0.0, 0.8, 0.0], 0.1, 100.0),
            Content::Floor => ([0.0, 2.0, 8.0], [0.0, 0.0, 2.0], 0.1, 300.0),
            Content::Sphere { .. } | Content::Mirror | Content::Metallic => {
                ([0.0, 0.0, 1.7344], [0.0; 3], 0.1, 100.0)
            }
            _ => ([0.0; 3], [0.0, 0.0, -1.0], 0.1, 100.0),
        };
        Camera {
            eye: DVec3::from(eye),
            look: DVec3::from(look),
            up: DVec3::Y,
            fov_x: 2.0 * atan(half_width()),
            near,
            far,
            lens: Default::default(),
        }
    }

    fn material(&self, precision: Precision, hidden: Hidden) -> Material {
        let filter = match self.lookup {
            Lookup::None | Lookup::Flat => None,
            Lookup::Nearest => Some(Filter::Nearest),
            Lookup::Bilinear => Some(Filter::Bilinear),
            Lookup::Trilinear => Some(Filter::Trilinear),
            Lookup::Aniso16 => Some(Filter::Anisotropic(16)),
        };
        let slot = filter.map(|filter| TextureSlot {
            sampler: Sampler {
                filter,
                precision,
                ..Sampler::default()
            },
            ..TextureSlot::new(0)
        });
        let blend = matches!(self.content, Content::Layers { blend: true, .. });
        let forward =
            blend || (hidden == Hidden::Shaded && matches!(self.content, Content::Layers { .. }));
        Material {
            name: self.filter.to_owned(),
            phong: PhongMaterial {
                color: [FLAT[0], FLAT[1], FLAT[2]],
                ..PhongMaterial::default()
            },
            opacity: if blend { 0.5 } else { 1.0 },
            base_color: slot,
            texture_role: TextureRole::Decal,
            shading: Shading::Unlit,
            alpha: if forward {
                AlphaMode::Blend
            } else {
                AlphaMode::Opaque
            },
            cull: if self.culls_back_faces() {
                Cull::Back
            } else {
                Cull::None
            },
            ..Material::default()
        }
    }
}

/// The turn of the spheres, as every renderer of the race multiplies by it.
pub(super) fn model() -> DMat4 {
    DMat4::from_cols_array(&turn().0.map(f64::from))
}

/// Of the picture at distance 1, vertical field of view 60 degrees.
fn half_height() -> f64 {
    tan(core::f64::consts::FRAC_PI_6)
}

fn half_width() -> f64 {
    half_height() * f64::from(WIDTH) / f64::from(HEIGHT)
}
