//! Position of an error in a text file.

use std::fmt;
use std::path::{Path, PathBuf};

use super::{IoError, shown};

/// A position in a text file: 1-based line and column (in characters), as editors count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceLocation {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

impl SourceLocation {
    /// The position `line`:`column` of `file`.
    pub fn new(file: &Path, line: u32, column: u32) -> Self {
        Self {
            file: file.to_path_buf(),
            line,
            column,
        }
    }
}

impl fmt::Display for SourceLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", shown(&self.file), self.line, self.column)
    }
}

impl IoError {
    /// The position of the error in a text file, if it has one.
    pub fn location(&self) -> Option<&SourceLocation> {
        match self {
            Self::FileMissing { named_by, .. }
            | Self::NotAFile { named_by, .. }
            | Self::Read { named_by, .. }
            | Self::OutsideRoot { named_by, .. }
            | Self::BrokenImage { named_by, .. }
            | Self::ImageLeftOut { named_by, .. }
            | Self::ImageSize { named_by, .. }
            | Self::EnvironmentSize { named_by, .. }
            | Self::EmptyMesh { named_by, .. }
            | Self::PointCloud { named_by, .. }
            | Self::Memory { named_by, .. } => named_by.as_ref(),
            Self::NotUtf8 { location }
            | Self::UnknownCommand { location, .. }
            | Self::StrayNumber { location, .. }
            | Self::ArgumentCount { location, .. }
            | Self::NotANumber { location, .. }
            | Self::NotFinite { location, .. }
            | Self::OutOfRange { location, .. }
            | Self::UnknownWord { location, .. }
            | Self::StrayQuote { location }
            | Self::BadIndex { location, .. }
            | Self::TooFewCorners { location, .. }
            | Self::MixedCorners { location, .. }
            | Self::NeedsAbove { location, .. }
            | Self::OpenPush { location }
            | Self::IncludeCycle { location, .. }
            | Self::DegenerateFrame { location, .. }
            | Self::BadCamera { location, .. }
            | Self::BadProjector { location, .. }
            | Self::BadShape { location, .. }
            | Self::BrokenModelLine { location, .. }
            | Self::UnknownMaterial { location, .. }
            | Self::BrokenPath { location, .. } => Some(location),
            Self::Write { .. }
            | Self::FileTooLarge { .. }
            | Self::UnknownFormat { .. }
            | Self::EmptyScene { .. }
            | Self::BrokenModel { .. }
            | Self::BrokenGltf { .. }
            | Self::UnsupportedGltf { .. }
            | Self::NamedByGltf { .. }
            | Self::UnknownName { .. }
            | Self::BrokenArray { .. } => None,
        }
    }
}

/// The position as a message begins with it, if there is one.
pub(super) fn line_of(location: &Option<SourceLocation>) -> String {
    location
        .as_ref()
        .map(|p| format!("{p}: "))
        .unwrap_or_default()
}

/// A JSON pointer as a message begins with it, if there is one.
pub(super) fn pointer_of(pointer: &str) -> String {
    match pointer {
        "" => String::new(),
        pointer => format!("{}: ", super::shortened(pointer)),
    }
}
