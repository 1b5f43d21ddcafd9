//! Where in a text file an error is.

use std::fmt;
use std::path::{Path, PathBuf};

use super::{IoError, shown};

/// A position in a text file: 1-based line and column (in characters), as editors count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

impl Place {
    /// The place `line`:`column` of `file`.
    pub fn new(file: &Path, line: u32, column: u32) -> Self {
        Self {
            file: file.to_path_buf(),
            line,
            column,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", shown(&self.file), self.line, self.column)
    }
}

impl IoError {
    /// The place in a text file that the error speaks of, if there is one.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::FileMissing { named_by, .. }
            | Self::NotAFile { named_by, .. }
            | Self::Read { named_by, .. }
            | Self::OutsideRoot { named_by, .. }
            | Self::BrokenImage { named_by, .. }
            | Self::ImageSize { named_by, .. }
            | Self::EnvironmentSize { named_by, .. }
            | Self::EmptyMesh { named_by, .. }
            | Self::Memory { named_by, .. } => named_by.as_ref(),
            Self::NotUtf8 { place }
            | Self::UnknownCommand { place, .. }
            | Self::StrayNumber { place, .. }
            | Self::ArgumentCount { place, .. }
            | Self::NotANumber { place, .. }
            | Self::NotFinite { place, .. }
            | Self::OutOfRange { place, .. }
            | Self::UnknownWord { place, .. }
            | Self::StrayQuote { place }
            | Self::BadIndex { place, .. }
            | Self::TooFewCorners { place, .. }
            | Self::MixedCorners { place, .. }
            | Self::NeedsAbove { place, .. }
            | Self::OpenPush { place }
            | Self::IncludeCycle { place, .. }
            | Self::DegenerateFrame { place, .. }
            | Self::BadCamera { place, .. }
            | Self::BadProjector { place, .. }
            | Self::BadShape { place, .. }
            | Self::UnknownMaterial { place, .. }
            | Self::BrokenPath { place, .. } => Some(place),
            Self::Write { .. }
            | Self::FileTooLarge { .. }
            | Self::UnknownFormat { .. }
            | Self::EmptyScene { .. }
            | Self::BrokenModel { .. }
            | Self::BrokenArray { .. } => None,
        }
    }
}

/// The place as a message begins with it, if there is one.
pub(super) fn line_of(place: &Option<Place>) -> String {
    place.as_ref().map(|p| format!("{p}: ")).unwrap_or_default()
}
