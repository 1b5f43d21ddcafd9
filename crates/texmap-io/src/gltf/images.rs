//! Pictures of a document to textures: each decoded once, all at the same time.

use std::collections::BTreeMap;
use std::path::PathBuf;

use texmap_math::parallel;
use texmap_sample::{ColorSpace, Texture2d};

use super::model::Model;
use super::uri;
use crate::image_io::{self, Decoded};
use crate::scene_file::Missing;
use crate::textures::{Content, named, stand_in};
use crate::{IoError, info::NamedFile};

/// The use of the texels of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Use {
    /// sRGB colours with alpha.
    Color,
    /// sRGB colours; alpha hides nothing.
    OpaqueColor,
    /// Numbers with alpha.
    Data,
    /// Numbers; alpha is none of them.
    OpaqueData,
}

impl Use {
    fn content(self) -> Content {
        match self {
            Self::Color | Self::OpaqueColor => Content::Color,
            Self::Data | Self::OpaqueData => Content::Data,
        }
    }
}

/// The textures that materials ask for: pictures and their uses.
#[derive(Debug, Default)]
pub(super) struct Uses {
    list: Vec<(usize, Use)>,
    known: BTreeMap<(usize, Use), usize>,
}

impl Uses {
    /// Index of the texture of a picture in this use.
    pub(super) fn index(&mut self, image: usize, used: Use) -> usize {
        let wanted = (image, used);
        let list = &mut self.list;
        *self.known.entry(wanted).or_insert_with(|| {
            list.push(wanted);
            list.len() - 1
        })
    }
}

/// Source of the bytes of a picture.
enum Bytes {
    View(usize),
    Own(Vec<u8>),
    Lost(String),
}

/// Width and height of a picture, and its bits a channel.
#[derive(Clone, Copy)]
struct Found((u32, u32), u32);

/// Decodes the pictures that are used and makes the textures, in the order of `uses`. `raw`: colours are taken as they are.
pub(super) fn textures(
    model: &mut Model<'_>,
    uses: &Uses,
    missing: Missing,
    raw: bool,
) -> Result<Vec<Texture2d<'static>>, IoError> {
    let mut wanted: Vec<usize> = uses.known.keys().map(|(image, _)| *image).collect();
    wanted.dedup();
    let mut sources = Vec::new();
    for image in &wanted {
        sources.push((*image, source(model, *image, missing)?));
    }
    let shared = &*model;
    // The texels of a picture are gone as soon as its textures are made.
    let read = parallel::map(sources.iter(), |(image, bytes)| {
        let decoded = decode(shared, *image, bytes);
        let here = (*image, Use::Color)..=(*image, Use::OpaqueData);
        let made = uses.known.range(here).map(|((_, used), at)| {
            let made = match &decoded {
                Ok(Some(picture)) => texture(shared, *image, picture, *used, raw),
                _ => Ok(stand_in(missing, used.content()).with_mips()),
            };
            (*at, made)
        });
        let made: Vec<_> = made.collect();
        let found = decoded.map(|picture| picture.map(|p| Found(p.size, p.texels.bits())));
        (found, made)
    });
    let mut all = Vec::new();
    for ((image, bytes), (found, made)) in sources.iter().zip(read) {
        note(model, *image, bytes, missing, found)?;
        all.extend(made);
    }
    all.sort_by_key(|(at, _)| *at);
    all.into_iter().map(|(_, made)| made).collect()
}

/// The name of a picture in messages.
fn called(model: &Model<'_>, image: usize) -> PathBuf {
    let stated = &model.document.images[image];
    let file = stated.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    match file.map(|uri| uri::target(uri)) {
        Some(Ok(uri::Target::File(name))) => model.beside(&name),
        _ if stated.name.is_empty() => format!("image {image}").into(),
        _ => format!("image {image} '{}'", crate::shortened(&stated.name)).into(),
    }
}

fn source(model: &mut Model<'_>, image: usize, missing: Missing) -> Result<Bytes, IoError> {
    let stated = &model.document.images[image];
    let pointer = format!("/images/{image}");
    match (stated.uri.clone(), stated.buffer_view) {
        (Some(uri), _) => {
            let lenient = model.tolerant || missing != Missing::Error;
            if let Some(problem) = uri::address(&uri).filter(|_| lenient) {
                return Ok(Bytes::Lost(problem));
            }
            match model.named_bytes(&format!("{pointer}/uri"), &uri) {
                Ok(Some(bytes)) => Ok(Bytes::Own(bytes)),
                Ok(None) => Ok(Bytes::Lost(format!(
                    "{}: cannot be read",
                    called(model, image).display()
                ))),
                Err(IoError::NamedByGltf { error, .. })
                    if lenient && matches!(*error, IoError::FileMissing { .. }) =>
                {
                    Ok(Bytes::Lost(error.to_string()))
                }
                Err(error) => Err(error),
            }
        }
        (None, Some(view)) => Ok(Bytes::View(view)),
        (None, None) => Err(model.broken(&pointer, "has neither a `uri` nor a `bufferView`")),
    }
}

fn decode(model: &Model<'_>, image: usize, bytes: &Bytes) -> Result<Option<Decoded>, IoError> {
    let pointer = format!("/images/{image}");
    let bytes = match bytes {
        Bytes::Own(bytes) => bytes.as_slice(),
        Bytes::View(view) => match model.view(*view, &format!("{pointer}/bufferView"))? {
            Some(bytes) => bytes,
            None => return Ok(None),
        },
        Bytes::Lost(_) => return Ok(None),
    };
    if bytes.starts_with(b"\xabKTX 20\xbb") {
        return Err(model.unsupported(&pointer, "KTX2", super::extensions::PICTURES.to_owned()));
    }
    let path = called(model, image);
    image_io::read_bytes(&model.files, &path, bytes)
        .map(Some)
        .map_err(|error| model.within(&pointer, error))
}

/// Notes the result of reading a picture: its size and bits, or `None` where a stand-in replaces it.
fn note(
    model: &mut Model<'_>,
    image: usize,
    bytes: &Bytes,
    missing: Missing,
    found: Result<Option<Found>, IoError>,
) -> Result<(), IoError> {
    let path = called(model, image);
    let (found, problem) = match found {
        Ok(Some(found)) => (Some(found), None),
        Ok(None) => match bytes {
            Bytes::Lost(problem) => (None, Some(problem.clone())),
            _ => (None, Some("its buffer cannot be read".to_owned())),
        },
        Err(error @ IoError::NamedByGltf { .. }) if model.tolerant => {
            (None, Some(error.to_string()))
        }
        Err(error) => return Err(error),
    };
    if let Some(problem) = &problem {
        model.warn(format!("{problem}: {} stands in", named(missing)));
    }
    let file = NamedFile {
        path,
        named_by: model.place(&format!("/images/{image}")),
        size: found.map(|Found(size, _)| size.into()),
        bits: found.map(|Found(_, bits)| bits),
        problem,
    };
    model.note_file(file);
    Ok(())
}

fn texture(
    model: &Model<'_>,
    image: usize,
    picture: &Decoded,
    used: Use,
    raw: bool,
) -> Result<Texture2d<'static>, IoError> {
    let path = called(model, image);
    let color = match used {
        Use::Color | Use::OpaqueColor if !raw => ColorSpace::Srgb,
        _ => ColorSpace::Linear,
    };
    // As for the maps of other models: texels and a third more for the levels.
    let kept = if picture.texels.bits() == 32 { 22 } else { 11 };
    let size = picture.size;
    let within = |error| model.within(&format!("/images/{image}"), error);
    image_io::ask_for_texels(&model.files, &path, None, size, kept).map_err(within)?;
    let opaque = matches!(used, Use::OpaqueColor | Use::OpaqueData);
    let made = picture.texture(&path, None, color, opaque);
    made.map(Texture2d::with_mips).map_err(within)
}
