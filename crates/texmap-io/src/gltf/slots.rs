//! References to textures: their pictures, coordinates and samplers.

use texmap_sample::{Filter, Mip, Sampler, TexelFilter, UvTransform, Wrap};
use texmap_scene::{TextureSlot, UvSet};

use super::images::{Use, Uses};
use super::json::{self, TextureInfo};
use super::model::Model;
use crate::IoError;

/// The numbers of the sets of coordinates (`TEXCOORD_n`) that a material reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sets {
    pub(super) first: u32,
    pub(super) second: Option<u32>,
    /// Another one, which is not read.
    pub(super) third: Option<u32>,
}

impl Sets {
    /// The sets of some references in rising order.
    pub(super) fn of(infos: &[&TextureInfo]) -> Self {
        let mut numbers: Vec<u32> = infos.iter().map(|info| set(info)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut numbers = numbers.into_iter();
        Self {
            first: numbers.next().unwrap_or(0),
            second: numbers.next(),
            third: numbers.next(),
        }
    }
}

/// The number of the set that a reference reads.
fn set(info: &TextureInfo) -> u32 {
    let moved = info.extensions.transform.as_ref().and_then(|t| t.tex_coord);
    moved.unwrap_or(info.tex_coord)
}

/// The slot of a reference; `None`, with a warning, for a texture without a picture.
pub(super) fn slot(
    model: &mut Model<'_>,
    uses: &mut Uses,
    info: &TextureInfo,
    sets: Sets,
    used: Use,
    pointer: &str,
) -> Result<Option<TextureSlot>, IoError> {
    let textures = &model.document.textures;
    let texture = model.item(textures, info.index, &format!("{pointer}/index"), "texture")?;
    let at = format!("/textures/{}", info.index);
    let sampler = match texture.sampler {
        Some(sampler) => {
            let stated = model.item(
                &model.document.samplers,
                sampler,
                &format!("{at}/sampler"),
                "sampler",
            )?;
            self::sampler(model, stated, &format!("/samplers/{sampler}"))?
        }
        None => Sampler::default(),
    };
    let extensions = &texture.extensions;
    let encoded = [
        ("KHR_texture_basisu", extensions.basisu.is_some()),
        ("EXT_texture_avif", extensions.avif.is_some()),
    ];
    let webp = extensions.webp.as_ref().and_then(|webp| webp.source);
    let image = match webp.or(texture.source) {
        Some(image) => image,
        None => match encoded.into_iter().find(|(_, present)| *present) {
            Some((name, _)) => {
                let help = super::extensions::instead(name);
                return Err(model.unsupported(&format!("{at}/extensions/{name}"), name, help));
            }
            None => {
                model.warn(format!("{at} has no picture: it is left out"));
                return Ok(None);
            }
        },
    };
    model.item(
        &model.document.images,
        image,
        &format!("{at}/source"),
        "image",
    )?;
    let transform = match &info.extensions.transform {
        None => UvTransform::default(),
        Some(t) => UvTransform {
            offset: t.offset.map(|x| x as f32),
            scale: t.scale.map(|x| x as f32),
            rotation: t.rotation as f32,
        },
    };
    Ok(Some(TextureSlot {
        texture: uses.index(image, used),
        sampler,
        transform,
        uv_set: match sets.second == Some(set(info)) {
            true => UvSet::Second,
            false => UvSet::First,
        },
    }))
}

/// The sampler of a document; repeating and trilinear by default.
fn sampler(model: &Model<'_>, stated: &json::Sampler, at: &str) -> Result<Sampler, IoError> {
    let wrap = |code: Option<u32>, key: &str| match code {
        None | Some(10497) => Ok(Wrap::Repeat),
        Some(33071) => Ok(Wrap::ClampToEdge),
        Some(33648) => Ok(Wrap::MirroredRepeat),
        Some(other) => {
            let problem = format!("{other} is none of 10497, 33071, 33648");
            Err(model.broken(&format!("{at}/{key}"), problem))
        }
    };
    let mag = match stated.mag_filter {
        None | Some(9729) => TexelFilter::Linear,
        Some(9728) => TexelFilter::Nearest,
        Some(other) => {
            let problem = format!("{other} is none of 9728, 9729");
            return Err(model.broken(&format!("{at}/magFilter"), problem));
        }
    };
    let (min, mip) = match stated.min_filter {
        None | Some(9987) => (TexelFilter::Linear, Mip::Linear),
        Some(9728) => (TexelFilter::Nearest, Mip::None),
        Some(9729) => (TexelFilter::Linear, Mip::None),
        Some(9984) => (TexelFilter::Nearest, Mip::Nearest),
        Some(9985) => (TexelFilter::Linear, Mip::Nearest),
        Some(9986) => (TexelFilter::Nearest, Mip::Linear),
        Some(other) => {
            let problem = format!("{other} is none of 9728, 9729, 9984 to 9987");
            return Err(model.broken(&format!("{at}/minFilter"), problem));
        }
    };
    Ok(Sampler {
        filter: filter(mag, min, mip),
        wrap_u: wrap(stated.wrap_s, "wrapS")?,
        wrap_v: wrap(stated.wrap_t, "wrapT")?,
        ..Sampler::default()
    })
}

/// The filter by its own name where it has one.
fn filter(mag: TexelFilter, min: TexelFilter, mip: Mip) -> Filter {
    use TexelFilter::{Linear, Nearest};
    match (mag, min, mip) {
        (Nearest, Nearest, Mip::None) => Filter::Nearest,
        (Linear, Linear, Mip::None) => Filter::Bilinear,
        (Nearest, Nearest, Mip::Nearest) => Filter::MipNearest,
        (Linear, Linear, Mip::Nearest) => Filter::BilinearMipNearest,
        (Linear, Linear, Mip::Linear) => Filter::Trilinear,
        _ => Filter::Gl { mag, min, mip },
    }
}
