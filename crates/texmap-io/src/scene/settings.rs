//! The current settings of later faces, from lines like `surf`, `filter` or `translate`.

use texmap_light::PhongMaterial;
use texmap_math::color::srgb_to_linear;
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};
use texmap_math::texture_frame::TextureFrame;
use texmap_mesh::SkinBlend;
use texmap_raster::{Cull, Interp};
use texmap_sample::{Filter, Sampler, UvTransform, Wrap};
use texmap_scene::{
    AlphaMode, ColorMode, Displacement, Material, Shading, TextureRole, TextureSlot,
    VertexColorInterp,
};
use texmap_uv::PerPixelProjection;

use super::effects::EffectSettings;
use super::materials::MaterialSettings;
use super::shapes::DisplaceSetting;
use crate::scene_file::Missing;
use crate::{SourceLocation, obj};

/// Everything that `push` keeps and `pop` brings back.
#[derive(Debug, Clone)]
pub(super) struct Settings {
    /// With colours as the file has them.
    pub(super) surf: Option<PhongMaterial>,
    /// The surface without a `surf`, but for vertex colours, which nothing darkens.
    pub(super) matte: Option<PhongMaterial>,
    pub(super) texture: Option<CurrentTexture>,
    pub(super) frame: Option<TextureFrame>,
    /// In world space; wins over `frame`.
    pub(super) round: Option<PerPixelProjection>,
    pub(super) filter: Filter,
    pub(super) wrap: [Wrap; 2],
    /// sRGB, straight alpha.
    pub(super) border: [f32; 4],
    pub(super) interp: Interp,
    pub(super) cull: Cull,
    /// `None`: tested where the texture has alpha.
    pub(super) alpha: Option<AlphaMode>,
    pub(super) role: Option<TextureRole>,
    pub(super) shading: Shading,
    pub(super) gouraud: VertexColorInterp,
    pub(super) missing: Missing,
    pub(super) transform: DMat4,
    pub(super) effects: EffectSettings,
    pub(super) materials: MaterialSettings,
    pub(super) displace: Option<DisplaceSetting>,
    /// With its line.
    pub(super) skin: Option<(SkinBlend, SourceLocation)>,
}

/// The texture of the last `texture` line.
#[derive(Debug, Clone)]
pub(super) struct CurrentTexture {
    pub(super) index: usize,
    pub(super) name: String,
    pub(super) has_alpha: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            surf: None,
            matte: None,
            texture: None,
            frame: None,
            round: None,
            filter: Filter::default(),
            wrap: [Wrap::Repeat; 2],
            border: [0.0; 4],
            interp: Interp::Perspective,
            cull: Cull::None,
            alpha: None,
            role: None,
            shading: Shading::PerPixel,
            gouraud: VertexColorInterp::ScreenLinear,
            missing: Missing::Error,
            transform: DMat4::IDENTITY,
            effects: EffectSettings::default(),
            materials: MaterialSettings::default(),
            displace: None,
            skin: None,
        }
    }
}

/// The course loader's `surf` of faces that no line says it for.
const COURSE: PhongMaterial = PhongMaterial {
    color: [0.5; 3],
    ka: 1.0,
    kd: 1.0,
    ks: 1.0,
    ns: 5.0,
};

/// The surface that texels multiply without a `surf` line: white, without a highlight.
pub(super) const WHITE: PhongMaterial = PhongMaterial {
    color: [1.0; 3],
    ka: 1.0,
    kd: 1.0,
    ks: 0.0,
    ns: 5.0,
};

impl Settings {
    /// An untextured face.
    pub(super) fn plain(&self, color: ColorMode) -> Material {
        let surf = self.surf.or(self.matte).unwrap_or(COURSE);
        Material {
            name: "surf".into(),
            phong: surface(&surf, color),
            shading: self.shading,
            interp: self.interp,
            cull: self.cull,
            vertex_color_interp: self.gouraud,
            ..Material::default()
        }
    }

    /// A face with the current texture; `role` where no `shade` line says otherwise.
    pub(super) fn textured(
        &self,
        texture: &CurrentTexture,
        role: TextureRole,
        color: ColorMode,
    ) -> Material {
        Material {
            name: texture.name.clone(),
            phong: surface(&self.surf.or(self.matte).unwrap_or(WHITE), color),
            base_color: Some(self.slot(texture.index, UvTransform::default(), false, color)),
            texture_role: self.role.unwrap_or(role),
            alpha: self.alpha(texture.has_alpha),
            ..self.plain(color)
        }
    }

    /// Faces whose vertices bring colours.
    pub(super) fn colored(&self, color: ColorMode) -> Material {
        let surface = surface(&self.surf.unwrap_or(WHITE), color);
        Material {
            name: "vertex colours".into(),
            phong: surface,
            ..self.plain(color)
        }
    }

    pub(super) fn alpha(&self, has_alpha: bool) -> AlphaMode {
        self.alpha.unwrap_or(match has_alpha {
            false => AlphaMode::Opaque,
            // A threshold of 0 stands for the rule of the filter.
            true => AlphaMode::Test(0.0),
        })
    }

    pub(super) fn slot(
        &self,
        texture: usize,
        transform: UvTransform,
        clamp: bool,
        color: ColorMode,
    ) -> TextureSlot {
        let [wrap_u, wrap_v] = if clamp {
            [Wrap::ClampToEdge; 2]
        } else {
            self.wrap
        };
        let [r, g, b, alpha] = self.border;
        let [r, g, b] = light([r, g, b], color).map(|c| c * alpha);
        let sampler = Sampler {
            filter: self.filter,
            wrap_u,
            wrap_v,
            border: [r, g, b, alpha],
            ..Sampler::default()
        };
        TextureSlot {
            sampler,
            transform,
            ..TextureSlot::new(texture)
        }
    }

    /// The displacement of the `displace` line, for meshes with coordinates.
    pub(super) fn displacement(&self, color: ColorMode) -> Option<Displacement> {
        let setting = self.displace.as_ref()?;
        let slot = self.slot(setting.texture, UvTransform::default(), false, color);
        Some(setting.displacement(slot))
    }
}

/// Colours of a file as the renderer takes them.
pub(super) fn light(srgb: [f32; 3], color: ColorMode) -> [f32; 3] {
    match color {
        ColorMode::Srgb => srgb.map(srgb_to_linear),
        ColorMode::Raw => srgb,
    }
}

/// Emitted light of a file as the renderer takes it: a colour up to 1, a linear factor above.
pub(super) fn emitted(srgb: [f32; 3], color: ColorMode) -> [f32; 3] {
    srgb.map(|c| if c > 1.0 { c } else { light([c; 3], color)[0] })
}

/// A surface whose colour is that of a file.
pub(super) fn surface(surf: &PhongMaterial, color: ColorMode) -> PhongMaterial {
    PhongMaterial {
        color: light(surf.color, color),
        ..*surf
    }
}

/// A turn about `axis`, exact for quarter turns.
pub(super) fn rotation(degrees: f64, axis: DVec3) -> DMat4 {
    let axis = obj::unit(axis).unwrap_or(DVec3::Z);
    let angle =
        quarter_turns(degrees).unwrap_or_else(|| deterministic_f64::sin_cos(degrees.to_radians()));
    texmap_mesh::rotation_about(axis, angle)
}

/// Sine and cosine of whole quarter turns, exactly.
fn quarter_turns(degrees: f64) -> Option<(f64, f64)> {
    let turns = degrees / 90.0;
    (turns == turns.trunc()).then(|| match turns.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    })
}

#[cfg(test)]
mod tests {
    use crate::scene_file::assert_faults;

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("surf 2 0 0 1 1 1 5", "out-of-range", 6),
            ("surf 1 0 0 1 1 1 -5", "out-of-range", 18),
            ("scale 1 0 1", "out-of-range", 9),
            ("rotate 30 0 0 0", "out-of-range", 11),
            ("frame 0 0 0 1 0 0 2 0 0", "degenerate-frame", 1),
            ("uv-projection torus 0 0 0 0 0 0 1 1 1", "unknown-word", 15),
            ("uv-projection sphere 0 0 0 0 0 0 1 1", "argument-count", 1),
            (
                "uv-projection cylinder 0 0 0 0 0 0 1 0 1",
                "out-of-range",
                38,
            ),
            (
                "uv-projection sphere 0 0 0 0 0 0 1 1 1 2 0",
                "out-of-range",
                42,
            ),
            ("filter blurry", "unknown-word", 8),
            ("filter anisotropic:99", "unknown-word", 8),
            ("wrap repeat sideways", "unknown-word", 13),
            ("interp span:0", "unknown-word", 8),
            ("cull left", "unknown-word", 6),
            ("alpha test 2", "out-of-range", 12),
            ("alpha test 0", "out-of-range", 12),
            ("shade decal modulate", "unknown-word", 13),
            ("texture my wall.png", "argument-count", 12),
            ("texture", "argument-count", 1),
        ]);
    }
}
