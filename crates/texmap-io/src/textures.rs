//! The textures of a scene, each file decoded once.

mod packed;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use texmap_math::parallel;
use texmap_sample::{Alpha, ColorSpace, Image, Origin, TexelData, Texture2d, Texture3d};

use crate::files::{Lost, MAX_TEXT, missing};
use crate::obj::Model;
use crate::scene_file::Missing;
use crate::{FileSource, IoError, SourceLocation, shown};
use crate::{grids, image_io};

/// Bytes of models and libraries that a scene may have read a second time.
const MAX_REPEATED: usize = 1 << 27;

/// Content of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Content {
    /// Colours: sRGB, or linear light where they are floats.
    Color,
    /// Light that was baked: sRGB in raw mode too, as environments are, or linear light where it is floats.
    Light,
    /// Numbers, taken as they are.
    Data,
}

/// A map that a file names.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapFile {
    pub(crate) path: PathBuf,
    pub(crate) location: SourceLocation,
    /// Width, height, bits a channel; or the fault.
    pub(crate) found: Result<(u32, u32, u32), String>,
}

/// A texture, and the width, height and bits of its file.
type Decoded = (Texture2d<'static>, (u32, u32, u32));

/// A map and the line that names it.
#[derive(Debug, Clone)]
pub(crate) struct MapSource {
    pub(crate) path: PathBuf,
    pub(crate) location: SourceLocation,
}

#[derive(Debug, Default)]
pub(crate) struct Textures {
    pub(crate) textures: Vec<Texture2d<'static>>,
    pub(crate) grids: Vec<Texture3d<'static>>,
    pub(crate) warnings: Vec<String>,
    /// In the order of their first mention.
    pub(crate) files: Vec<MapFile>,
    /// Colours are taken as they are, too.
    raw: bool,
    /// Source of the files of maps.
    pub(crate) source: FileSource,
    /// Treatment of a missing map, whatever a scene says.
    pub(crate) missing: Option<Missing>,
    /// Every fault is only noted in `files` (for reports on files).
    pub(crate) tolerant: bool,
    /// Names of `files`.
    noted: HashSet<PathBuf>,
    loaded: HashMap<(PathBuf, Content), usize>,
    loaded_grids: HashMap<PathBuf, usize>,
    /// Files that were decoded before they are loaded.
    ahead: HashMap<(PathBuf, Content), Result<Decoded, IoError>>,
    /// Models and libraries that were read.
    texts: HashSet<PathBuf>,
    /// Models that were read twice, and the bytes of their texts: scenes that name one a hundred times need not parse it as often.
    pub(crate) models: HashMap<(PathBuf, Missing, bool), (Model, usize)>,
    /// Bytes of those that were read before.
    repeated: usize,
    /// Textures of two files: of roughness and of metalness.
    packed: Vec<([Option<PathBuf>; 2], usize)>,
    /// Materials are those of the classic model: what only others show is named and not read.
    pub(crate) classic: bool,
    /// Files that models name by other names than they have here.
    lost: Lost,
    /// Textures that no file holds.
    made: Vec<(&'static str, usize)>,
}

impl Textures {
    pub(crate) fn new(source: FileSource, raw: bool, tolerant: bool) -> Self {
        Self {
            source,
            raw,
            tolerant,
            ..Self::default()
        }
    }

    /// The text of a model or library. A scene may name one again and again, so texts that are read twice are limited in all.
    pub(crate) fn text(
        &mut self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        command: &'static str,
    ) -> Result<String, IoError> {
        let text = self.source.text_named(path, named_by, MAX_TEXT)?;
        if self.texts.insert(path.to_path_buf()) {
            return Ok(text);
        }
        self.read_again(path, named_by, command, text.len())
            .map(|()| text)
    }

    /// The bytes of a model that is no text, counted like texts.
    pub(crate) fn bytes(
        &mut self,
        path: &Path,
        named_by: Option<&SourceLocation>,
    ) -> Result<Vec<u8>, IoError> {
        let bytes = self.source.read_named(path, named_by, MAX_TEXT)?;
        if !self.texts.insert(path.to_path_buf()) {
            self.read_again(path, named_by, "obj", bytes.len())?;
        }
        Ok(bytes)
    }

    /// Textures for a model of which only the coordinates are used. Its maps are loaded apart; models read twice are counted here.
    pub(crate) fn for_coordinates(&mut self) -> Self {
        Self {
            texts: std::mem::take(&mut self.texts),
            repeated: self.repeated,
            ..Self::new(self.source.clone(), true, true)
        }
    }

    /// After [`Textures::for_coordinates`].
    pub(crate) fn take_counts(&mut self, other: Self) {
        (self.texts, self.repeated) = (other.texts, other.repeated);
    }

    /// True if this model or library was read before.
    pub(crate) fn was_read(&self, path: &Path) -> bool {
        self.texts.contains(path)
    }

    /// The name, from the folder of a model or library, of a file that it names as another machine has it; a warning says so.
    pub(crate) fn found(
        &mut self,
        location: &SourceLocation,
        name: &str,
        warnings: &mut Vec<String>,
    ) -> Option<String> {
        let (found, first) = self.lost.find(&self.source, &location.file, name)?;
        if first {
            let path = self.source.beside(&location.file, name);
            let error = missing(&path, Some(location));
            warnings.push(format!("{error}: {} is read", shown(Path::new(&found))));
        }
        Some(found)
    }

    /// Counts the text of a model or library that was read before.
    pub(crate) fn read_again(
        &mut self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        command: &'static str,
        bytes: usize,
    ) -> Result<(), IoError> {
        self.repeated += bytes;
        match named_by {
            Some(location) if self.repeated > MAX_REPEATED => Err(IoError::OutOfRange {
                location: location.clone(),
                command,
                text: path.display().to_string(),
                allowed: "models and libraries that were read before: 128 MiB in all",
            }),
            _ => Ok(()),
        }
    }

    /// Decodes files that will be loaded, all at once. Their faults come up when they are loaded; nothing is decoded ahead where the
    /// memory budget does not hold all of them.
    pub(crate) fn decode_ahead(&mut self, mut new: Vec<(PathBuf, SourceLocation, Content)>) {
        let mut seen = HashSet::new();
        new.retain(|(path, _, content)| {
            let key = (path.clone(), *content);
            !self.loaded.contains_key(&key) && seen.insert(key)
        });
        if new.len() < 2 {
            return;
        }
        let sizes = parallel::map(new.iter(), |(path, ..)| {
            let size = image_io::stated_size(&self.source, path);
            size.map_or(0, |(width, height)| u64::from(width) * u64::from(height))
        });
        // Decoded, and with a mip chain.
        let bytes = sizes.into_iter().sum::<u64>().saturating_mul(4 + 11);
        let what = format_args!("{} images at once", new.len());
        if self.source.ask(bytes, what, "", None).is_err() {
            return;
        }
        let read = |(path, location, content): (PathBuf, SourceLocation, Content)| {
            let read = self.read(&path, &location, content);
            (
                (path, content),
                read.map(|(texture, size)| (with_levels(texture), size)),
            )
        };
        let read = parallel::map(new.into_iter(), read);
        self.ahead.extend(read);
    }

    /// Index of the texture of a file.
    pub(crate) fn load(
        &mut self,
        path: &Path,
        location: &SourceLocation,
        content: Content,
        missing: Missing,
    ) -> Result<usize, IoError> {
        let key = (path.to_path_buf(), content);
        if let Some(index) = self.loaded.get(&key) {
            return Ok(*index);
        }
        let ahead = self.ahead.remove(&key);
        let read = ahead.unwrap_or_else(|| {
            let (texture, size) = self.read(path, location, content)?;
            Ok((with_levels(texture), size))
        });
        let texture = match read {
            Ok((texture, size)) => {
                self.note(path, location, Ok(size));
                texture
            }
            Err(error) => {
                self.forgive(path, location, error, missing)?;
                stand_in(missing, content).with_mips()
            }
        };
        self.textures.push(texture);
        let index = self.textures.len() - 1;
        self.loaded.insert(key, index);
        Ok(index)
    }

    /// Index of a texture that no file holds, made once.
    pub(crate) fn made(
        &mut self,
        name: &'static str,
        make: impl FnOnce() -> Texture2d<'static>,
    ) -> usize {
        if let Some((_, index)) = self.made.iter().find(|(known, _)| *known == name) {
            return *index;
        }
        self.textures.push(make());
        let index = self.textures.len() - 1;
        self.made.push((name, index));
        index
    }

    /// Index of the grid of a file.
    pub(crate) fn grid(
        &mut self,
        path: &Path,
        location: &SourceLocation,
        missing: Missing,
    ) -> Result<usize, IoError> {
        if let Some(index) = self.loaded_grids.get(path) {
            return Ok(*index);
        }
        let grid = match grids::read_named(&self.source, path, Some(location)) {
            Ok(grid) => {
                let [width, height, _] = grid.level_size(0).unwrap_or_default();
                self.note(path, location, Ok((width, height, 0)));
                grid
            }
            Err(error) => {
                self.forgive(path, location, error, missing)?;
                stand_in_grid()
            }
        };
        self.grids.push(grid);
        let index = self.grids.len() - 1;
        self.loaded_grids.insert(path.to_path_buf(), index);
        Ok(index)
    }

    /// A warning that a checker replaces a map, or the error if no checker may.
    fn forgive(
        &mut self,
        path: &Path,
        location: &SourceLocation,
        error: IoError,
        missing: Missing,
    ) -> Result<(), IoError> {
        let absent = matches!(error, IoError::FileMissing { .. });
        let over = matches!(error, IoError::Memory { .. });
        if over || !(self.tolerant || absent && missing.is_lenient()) {
            return Err(error);
        }
        self.note(path, location, Err(error.to_string()));
        self.warnings
            .push(format!("{error}: {} stands in", named(missing)));
        Ok(())
    }

    fn read(
        &self,
        path: &Path,
        location: &SourceLocation,
        content: Content,
    ) -> Result<Decoded, IoError> {
        let linear = match content {
            Content::Color => self.raw,
            Content::Light => false,
            Content::Data => true,
        };
        let color = if linear {
            ColorSpace::Linear
        } else {
            ColorSpace::Srgb
        };
        #[cfg(feature = "gpu-images")]
        if let Some(texture) = image_io::block_texture(&self.source, path, Some(location), color)? {
            let size = (texture.width(), texture.height(), 8);
            return Ok((texture, size));
        }
        let image = image_io::read_named(&self.source, path, Some(location))?;
        let (size, bits) = (image.size, image.texels.bits());
        // Eight bytes a texel, sixteen of floats, and a third more for the mip chain.
        let kept = if bits == 32 { 22 } else { 11 };
        image_io::ask_for_texels(&self.source, path, Some(location), size, kept)?;
        let texture = image.texture(path, Some(location), color, false)?;
        Ok((texture, (size.0, size.1, bits)))
    }

    pub(crate) fn note(
        &mut self,
        path: &Path,
        location: &SourceLocation,
        found: Result<(u32, u32, u32), String>,
    ) {
        if self.noted.insert(path.to_path_buf()) {
            self.files.push(MapFile {
                path: path.to_path_buf(),
                location: location.clone(),
                found,
            });
        }
    }
}

/// With a mip chain: that of its file, if it has one.
fn with_levels(texture: Texture2d<'static>) -> Texture2d<'static> {
    match texture.levels() {
        1 => texture.with_mips(),
        _ => texture,
    }
}

pub(crate) fn named(missing: Missing) -> &'static str {
    match missing {
        Missing::Grey => "grey",
        Missing::Error | Missing::Checker => "a magenta and black checker",
    }
}

/// Substitute of a missing map. It is a checker that no material looks like, or grey, which as heights or normals is flat.
pub(crate) fn stand_in(missing: Missing, content: Content) -> Texture2d<'static> {
    const SIDE: u32 = 8;
    if missing == Missing::Grey {
        let (texel, space) = match content {
            Content::Data => ([128, 128, 255, 255], ColorSpace::Linear),
            Content::Color | Content::Light => ([188, 188, 188, 255], ColorSpace::Srgb),
        };
        return Texture2d::from_rgba8(1, 1, texel.to_vec(), space, Origin::TopLeft)
            .expect("4 bytes make one texel");
    }
    let texel = |i: u32| {
        if (i % SIDE + i / SIDE).is_multiple_of(2) {
            [255, 0, 255, 255]
        } else {
            [0, 0, 0, 255]
        }
    };
    let texels = (0..SIDE * SIDE).flat_map(texel).collect();
    Texture2d::from_rgba8(SIDE, SIDE, texels, ColorSpace::Srgb, Origin::TopLeft)
        .expect("64 texels of 4 bytes make an 8 x 8 texture")
}

fn stand_in_grid() -> Texture3d<'static> {
    let voxel = |i: u32| match (i % 2 + i / 2 % 2 + i / 4) % 2 {
        0 => [255, 0, 255],
        _ => [0; 3],
    };
    let texels: Vec<u8> = (0..8).flat_map(voxel).collect();
    let slices = Image {
        width: 2,
        height: 2,
        channels: 3,
        texels: TexelData::U8(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    Texture3d::new(2, &slices).expect("8 voxels of 3 bytes make a 2 x 2 x 2 grid")
}
