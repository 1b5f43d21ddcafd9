//! The current settings: what lines like `surf`, `filter` or `translate` say about the faces after them.

use texmap_light::Surface;
use texmap_math::color::srgb_to_linear;
use texmap_math::det;
use texmap_math::frame::TextureFrame;
use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::SkinBlend;
use texmap_raster::{Cull, Interp};
use texmap_sample::{Filter, Sampler, UvTransform, Wrap};
use texmap_scene::{
    AlphaMode, ColorMode, Displacement, Gouraud, Material, Shading, TextureRole, TextureSlot,
};
use texmap_uv::PixelMapping;

use super::classics::ClassicSettings;
use super::effects::EffectSettings;
use super::shapes::DisplaceSetting;
use crate::scene_file::{Alpha, Command, Missing, Rate, Role, Surf};
use crate::{Place, obj};

/// Everything that `push` keeps and `pop` brings back.
#[derive(Debug, Clone)]
pub(super) struct Settings {
    pub(super) surf: Option<Surf>,
    pub(super) texture: Option<CurrentTexture>,
    pub(super) frame: Option<TextureFrame>,
    /// In world space; wins over `frame`.
    pub(super) round: Option<PixelMapping>,
    pub(super) filter: Filter,
    pub(super) wrap: [Wrap; 2],
    /// sRGB, straight alpha.
    pub(super) border: [f32; 4],
    pub(super) interp: Interp,
    pub(super) cull: Cull,
    pub(super) alpha: Alpha,
    pub(super) role: Option<Role>,
    pub(super) rate: Rate,
    pub(super) gouraud: Gouraud,
    pub(super) missing: Missing,
    pub(super) transform: DMat4,
    pub(super) effects: EffectSettings,
    pub(super) classics: ClassicSettings,
    pub(super) displace: Option<DisplaceSetting>,
    /// With its line.
    pub(super) skin: Option<(SkinBlend, Place)>,
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
            texture: None,
            frame: None,
            round: None,
            filter: Filter::default(),
            wrap: [Wrap::Repeat; 2],
            border: [0.0; 4],
            interp: Interp::Perspective,
            cull: Cull::None,
            alpha: Alpha::Auto,
            role: None,
            rate: Rate::Pixel,
            gouraud: Gouraud::ScreenLinear,
            missing: Missing::Error,
            transform: DMat4::IDENTITY,
            effects: EffectSettings::default(),
            classics: ClassicSettings::default(),
            displace: None,
            skin: None,
        }
    }
}

/// What a texel multiplies where no `surf` line says otherwise: white, without a highlight.
pub(super) const WHITE: Surf = Surf {
    color: [1.0; 3],
    ka: 1.0,
    kd: 1.0,
    ks: 0.0,
    ns: 5.0,
};

impl Settings {
    /// What the line of a setting says.
    pub(super) fn set(&mut self, command: &Command) {
        match command {
            Command::Surf(surf) => self.surf = Some(*surf),
            Command::Filter(filter) => self.filter = *filter,
            Command::Wrap(u, v) => self.wrap = [*u, *v],
            Command::Border(color) => self.border = *color,
            Command::Interp(interp) => self.interp = *interp,
            Command::Cull(cull) => self.cull = *cull,
            Command::Alpha(alpha) => self.alpha = *alpha,
            Command::Shade(shade) => {
                self.role = shade.role.or(self.role);
                self.rate = shade.rate.unwrap_or(self.rate);
            }
            Command::Gouraud(gouraud) => self.gouraud = *gouraud,
            Command::Missing(missing) => self.missing = *missing,
            Command::Frame { o, u, v } => {
                let [o, u, v] = [o, u, v].map(|p| DVec3::from(*p));
                self.frame = Some(TextureFrame { o, u, v }.transform(self.transform));
                self.round = None;
            }
            Command::Translate(p) => self.transform *= DMat4::from_translation(DVec3::from(*p)),
            Command::Scale(f) => self.transform *= DMat4::from_scale(DVec3::from(*f)),
            Command::Rotate { angle, axis } => {
                self.transform *= rotation(*angle, DVec3::from(*axis));
            }
            // `color` was read before; everything else is handled by the builder.
            _ => {}
        }
    }

    /// An untextured face.
    pub(super) fn plain(&self, color: ColorMode) -> Material {
        let surf = self.surf.unwrap_or_default();
        Material {
            name: "surf".into(),
            surface: surface(&surf, color),
            shading: self.shading(),
            interp: self.interp,
            cull: self.cull,
            gouraud: self.gouraud,
            ..Material::default()
        }
    }

    /// A face with the current texture; `role` where no `shade` line says otherwise.
    pub(super) fn textured(
        &self,
        texture: &CurrentTexture,
        role: Role,
        color: ColorMode,
    ) -> Material {
        Material {
            name: texture.name.clone(),
            surface: surface(&self.surf.unwrap_or(WHITE), color),
            base_color: Some(self.slot(texture.index, UvTransform::default(), false, color)),
            texture_role: self.role(role),
            alpha: self.alpha(texture.has_alpha),
            ..self.plain(color)
        }
    }

    /// Faces whose vertices bring colours.
    pub(super) fn colored(&self, color: ColorMode) -> Material {
        let surface = surface(&self.surf.unwrap_or(WHITE), color);
        Material {
            name: "vertex colours".into(),
            surface,
            ..self.plain(color)
        }
    }

    pub(super) fn role(&self, default: Role) -> TextureRole {
        match self.role.unwrap_or(default) {
            Role::Decal => TextureRole::Decal,
            Role::Modulate => TextureRole::Modulate,
        }
    }

    pub(super) fn alpha(&self, has_alpha: bool) -> AlphaMode {
        match self.alpha {
            Alpha::Auto if !has_alpha => AlphaMode::Opaque,
            // A threshold of 0 stands for the rule of the filter.
            Alpha::Auto | Alpha::Test(None) => AlphaMode::Test(0.0),
            Alpha::Opaque => AlphaMode::Opaque,
            Alpha::Test(Some(threshold)) => AlphaMode::Test(threshold),
            Alpha::Blend => AlphaMode::Blend,
        }
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
            texture,
            sampler,
            transform,
        }
    }

    /// What the `displace` line does to what has coordinates.
    pub(super) fn displacement(&self, color: ColorMode) -> Option<Displacement> {
        let setting = self.displace.as_ref()?;
        let slot = self.slot(setting.texture, UvTransform::default(), false, color);
        Some(setting.displacement(slot))
    }

    fn shading(&self) -> Shading {
        match self.rate {
            Rate::Vertex => Shading::PerVertex,
            Rate::Pixel => Shading::PerPixel,
        }
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

pub(super) fn surface(surf: &Surf, color: ColorMode) -> Surface {
    Surface {
        color: light(surf.color, color),
        ka: surf.ka,
        kd: surf.kd,
        ks: surf.ks,
        ns: surf.ns,
    }
}

/// A turn about `axis`, exact for quarter turns.
pub(super) fn rotation(degrees: f64, axis: DVec3) -> DMat4 {
    let axis = obj::unit(axis).unwrap_or(DVec3::Z);
    let angle = quarter_turns(degrees).unwrap_or_else(|| det::sin_cos(degrees.to_radians()));
    texmap_mesh::turn_by(axis, angle)
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
