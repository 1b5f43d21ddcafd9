//! The textures of a scene, each file decoded once.

use std::path::{Path, PathBuf};

use texmap_math::MemoryBudget;
use texmap_sample::{Alpha, ColorSpace, Image, Origin, Texels, Texture2d, Texture3d};

use crate::scene_file::Missing;
use crate::{IoError, Place};
use crate::{grids, image_io};

/// What a map holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// Colours, sRGB.
    Color,
    /// Numbers, taken as they are.
    Data,
}

/// A map that a file names.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapFile {
    pub(crate) path: PathBuf,
    pub(crate) place: Place,
    /// Width, height, bits a channel; or what is wrong.
    pub(crate) found: Result<(u32, u32, u32), String>,
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
    /// Every fault is only noted in `files` (for reports on files).
    pub(crate) tolerant: bool,
    /// Asked for every map.
    pub(crate) memory: MemoryBudget,
    loaded: Vec<(PathBuf, Content, usize)>,
    loaded_grids: Vec<(PathBuf, usize)>,
    /// Textures that no file holds.
    made: Vec<(&'static str, usize)>,
}

impl Textures {
    pub(crate) fn new(raw: bool, tolerant: bool, memory: MemoryBudget) -> Self {
        Self {
            raw,
            tolerant,
            memory,
            ..Self::default()
        }
    }

    /// Index of the texture of a file.
    pub(crate) fn load(
        &mut self,
        path: &Path,
        place: &Place,
        content: Content,
        missing: Missing,
    ) -> Result<usize, IoError> {
        let known = self
            .loaded
            .iter()
            .find(|(p, c, _)| p == path && *c == content);
        if let Some((_, _, index)) = known {
            return Ok(*index);
        }
        let texture = match self.read(path, place, content) {
            Ok((texture, size)) => {
                self.note(path, place, Ok(size));
                texture
            }
            Err(error) => {
                self.forgive(path, place, error, missing)?;
                stand_in()
            }
        };
        self.textures.push(texture.with_mips());
        let index = self.textures.len() - 1;
        self.loaded.push((path.to_path_buf(), content, index));
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
        place: &Place,
        missing: Missing,
    ) -> Result<usize, IoError> {
        if let Some((_, index)) = self.loaded_grids.iter().find(|(p, _)| p == path) {
            return Ok(*index);
        }
        let grid = match grids::read_named(path, Some(place), self.memory) {
            Ok(grid) => {
                let [width, height, _] = grid.level_size(0).unwrap_or_default();
                self.note(path, place, Ok((width, height, 0)));
                grid
            }
            Err(error) => {
                self.forgive(path, place, error, missing)?;
                stand_in_grid()
            }
        };
        self.grids.push(grid);
        let index = self.grids.len() - 1;
        self.loaded_grids.push((path.to_path_buf(), index));
        Ok(index)
    }

    /// A warning that a checker stands in for a map, or the error where none may.
    fn forgive(
        &mut self,
        path: &Path,
        place: &Place,
        error: IoError,
        missing: Missing,
    ) -> Result<(), IoError> {
        let absent = matches!(error, IoError::FileMissing { .. });
        let over = matches!(error, IoError::Memory { .. });
        if over || !(self.tolerant || absent && missing == Missing::Warn) {
            return Err(error);
        }
        self.note(path, place, Err(error.to_string()));
        self.warnings
            .push(format!("{error}: a magenta and black checker stands in"));
        Ok(())
    }

    fn read(
        &self,
        path: &Path,
        place: &Place,
        content: Content,
    ) -> Result<(Texture2d<'static>, (u32, u32, u32)), IoError> {
        let image = image_io::read_named(path, Some(place), self.memory)?;
        let bits = image.texels.bits();
        let linear = self.raw || content == Content::Data;
        let color = if linear {
            ColorSpace::Linear
        } else {
            ColorSpace::Srgb
        };
        // At most eight bytes a texel, and a third more for the mip chain.
        let size = (image.width, image.height);
        image_io::ask_for_texels(self.memory, path, Some(place), size, 11)?;
        let texture = image_io::texture(path, Some(place), &image, color)?;
        Ok((texture, (image.width, image.height, bits)))
    }

    pub(crate) fn note(
        &mut self,
        path: &Path,
        place: &Place,
        found: Result<(u32, u32, u32), String>,
    ) {
        if !self.files.iter().any(|f| f.path == path) {
            self.files.push(MapFile {
                path: path.to_path_buf(),
                place: place.clone(),
                found,
            });
        }
    }
}

/// What is drawn where a map is missing: loud, and never mistaken for a material.
fn stand_in() -> Texture2d<'static> {
    const SIDE: u32 = 8;
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
        texels: Texels::U8(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    Texture3d::new(2, &slices).expect("8 voxels of 3 bytes make a 2 x 2 x 2 grid")
}
