//! The short names of errors, and errors without what they quote.

use super::IoError;

impl IoError {
    /// A short name of the error that stays the same from version to version.
    pub fn code(&self) -> &'static str {
        match self {
            Self::FileMissing { .. } => "file-missing",
            Self::NotAFile { .. } => "not-a-file",
            Self::Read { .. } => "read-failed",
            Self::Write { .. } => "write-failed",
            Self::OutsideRoot { .. } => "outside-root",
            Self::FileTooLarge { .. } => "file-too-large",
            Self::NotUtf8 { .. } => "not-utf8",
            Self::UnknownFormat { .. } => "unknown-format",
            Self::UnknownCommand { .. } => "unknown-command",
            Self::StrayNumber { .. } => "stray-number",
            Self::ArgumentCount { .. } => "argument-count",
            Self::NotANumber { .. } => "not-a-number",
            Self::NotFinite { .. } => "not-finite",
            Self::OutOfRange { .. } => "out-of-range",
            Self::UnknownWord { .. } => "unknown-word",
            Self::StrayQuote { .. } => "stray-quote",
            Self::BadIndex { .. } => "bad-index",
            Self::TooFewCorners { .. } => "too-few-corners",
            Self::MixedCorners { .. } => "mixed-corners",
            Self::NeedsAbove { .. } => "needs-line-above",
            Self::OpenPush { .. } => "open-push",
            Self::IncludeCycle { .. } => "include-cycle",
            Self::DegenerateFrame { .. } => "degenerate-frame",
            Self::BadCamera { .. } => "bad-camera",
            Self::BadProjector { .. } => "bad-projector",
            Self::BrokenImage { .. } => "broken-image",
            Self::ImageLeftOut { .. } => "image-left-out",
            Self::ImageSize { .. } => "image-size",
            Self::EnvironmentSize { .. } => "environment-size",
            Self::BadShape { .. } => "bad-shape",
            Self::EmptyScene { .. } => "empty-scene",
            Self::EmptyMesh { .. } => "empty-mesh",
            Self::UnknownMaterial { .. } => "unknown-material",
            Self::BrokenModel { .. } => "broken-model",
            Self::BrokenGltf { .. } => "broken-gltf",
            Self::UnsupportedGltf { .. } => "unsupported-gltf",
            Self::NamedByGltf { error, .. } => error.code(),
            Self::UnknownName { .. } => "unknown-name",
            Self::BrokenModelLine { .. } => "broken-model-line",
            Self::PointCloud { .. } => "point-cloud",
            Self::BrokenArray { .. } => "broken-array",
            Self::BrokenPath { .. } => "broken-camera-path",
            Self::Memory { .. } => "over-memory-budget",
        }
    }
}

impl IoError {
    /// The error without quotations of the file, for files that may not be of their expected kind.
    pub(crate) fn without_words(mut self) -> Self {
        match &mut self {
            Self::UnknownCommand { word: quoted, .. }
            | Self::StrayNumber { text: quoted, .. }
            | Self::NotANumber { text: quoted, .. }
            | Self::NotFinite { text: quoted, .. }
            | Self::OutOfRange { text: quoted, .. }
            | Self::UnknownWord { word: quoted, .. }
            | Self::BadIndex { index: quoted, .. }
            | Self::UnknownMaterial { name: quoted, .. } => "...".clone_into(quoted),
            _ => {}
        }
        self
    }
}
