//! What can be wrong with a file: one line says what and where, one says why and what to try.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

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
        write!(f, "{}:{}:{}", self.file.display(), self.line, self.column)
    }
}

/// Why a file cannot be read or written.
///
/// `Display` is the line *what and where*; [`IoError::help`] is the line *why and what to try*;
/// [`IoError::code`] is a short name that stays the same from version to version.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// No file of this name.
    #[error("{}{}: no such file", line_of(.named_by), .path.display())]
    FileMissing {
        /// The file that was looked for.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
    },
    /// A directory or a device where a file is needed.
    #[error("{}{}: not a regular file", line_of(.named_by), .path.display())]
    NotAFile {
        /// The path given.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
    },
    /// The operating system refused to read.
    #[error("{}{}: cannot be read: {source}", line_of(.named_by), .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
        /// What the operating system said.
        source: io::Error,
    },
    /// The operating system refused to write.
    #[error("{}: cannot be written: {source}", .path.display())]
    Write {
        /// The file that should have been written.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// More bytes than the stated limit.
    #[error("{}: {bytes} bytes, the limit is {limit}", .path.display())]
    FileTooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit for files of this kind.
        limit: u64,
    },
    /// A text file that is not UTF-8.
    #[error("{place}: not UTF-8 text")]
    NotUtf8 {
        /// The first byte that is not text.
        place: Place,
    },
    /// A file name ending that texmap does not read.
    #[error("{}: unknown kind of file", .path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A word that is no command.
    #[error("{place}: unknown command `{word}`")]
    UnknownCommand {
        /// Where the word stands.
        place: Place,
        /// The word.
        word: String,
        /// The command that looks most like it.
        nearest: Option<&'static str>,
    },
    /// Numbers before the first command.
    #[error("{place}: number `{text}` with no command above it")]
    StrayNumber {
        /// Where the number stands.
        place: Place,
        /// The number.
        text: String,
    },
    /// Too few or too many values after a command.
    #[error("{place}: `{command}` takes {expected}, found {found}")]
    ArgumentCount {
        /// The first value too many, or the command.
        place: Place,
        /// The command.
        command: &'static str,
        /// What it takes.
        expected: &'static str,
        /// How many values were found.
        found: usize,
    },
    /// A word where a number is needed.
    #[error("{place}: `{command}`: `{text}` is not a number")]
    NotANumber {
        /// Where the word stands.
        place: Place,
        /// The command.
        command: &'static str,
        /// The word.
        text: String,
    },
    /// NaN, an infinity, or a number beyond 32-bit floats.
    #[error("{place}: `{command}`: `{text}` is not a finite 32-bit number")]
    NotFinite {
        /// Where the number stands.
        place: Place,
        /// The command.
        command: &'static str,
        /// The number.
        text: String,
    },
    /// A number outside of what its command allows.
    #[error("{place}: `{command}`: `{text}` is out of range")]
    OutOfRange {
        /// Where the number stands.
        place: Place,
        /// The command.
        command: &'static str,
        /// The number.
        text: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A word that its command does not know.
    #[error("{place}: `{command}` does not know `{word}`")]
    UnknownWord {
        /// Where the word stands.
        place: Place,
        /// The command.
        command: &'static str,
        /// The word.
        word: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A quote that does not end, or one inside a word.
    #[error("{place}: stray quote")]
    StrayQuote {
        /// Where the quote stands.
        place: Place,
    },
    /// An index of a vertex, texture coordinate or normal that does not exist.
    #[error("{place}: {of} index {index} does not exist; there are {count} above this line")]
    BadIndex {
        /// Where the index stands.
        place: Place,
        /// `vertex`, `texture coordinate` or `normal`.
        of: &'static str,
        /// The index as written.
        index: String,
        /// How many there are.
        count: usize,
    },
    /// A face of fewer than three corners.
    #[error("{place}: `{command}` with {found} corners; a face needs 3 or more")]
    TooFewCorners {
        /// Where the face stands.
        place: Place,
        /// The command.
        command: &'static str,
        /// How many corners it has.
        found: usize,
    },
    /// An OBJ face whose corners do not all name the same kinds of data.
    #[error("{place}: corners of one face differ: some name a {of}, some do not")]
    MixedCorners {
        /// Where the odd corner stands.
        place: Place,
        /// `texture coordinate` or `normal`.
        of: &'static str,
    },
    /// A command that needs another one above it.
    #[error("{place}: `{command}` without a `{needs}` line above it")]
    NeedsAbove {
        /// Where the command stands.
        place: Place,
        /// The command.
        command: &'static str,
        /// The command that it needs.
        needs: &'static str,
    },
    /// A `push` that no `pop` closes.
    #[error("{place}: `push` without a `pop` in the same file")]
    OpenPush {
        /// Where the push stands.
        place: Place,
    },
    /// A file that includes itself.
    #[error("{place}: `include` of {} goes in a circle", .path.display())]
    IncludeCycle {
        /// The line that closes the circle.
        place: Place,
        /// The file that is already open.
        path: PathBuf,
    },
    /// A texture frame whose U and V do not span a plane.
    #[error("{place}: `frame`: {problem}")]
    DegenerateFrame {
        /// Where the frame stands.
        place: Place,
        /// What is wrong with it.
        problem: String,
    },
    /// A camera that sees nothing.
    #[error("{place}: camera: {problem}")]
    BadCamera {
        /// The last line that set the camera.
        place: Place,
        /// What is wrong with it.
        problem: String,
    },
    /// A projector that throws its slide nowhere.
    #[error("{place}: projector: {problem}")]
    BadProjector {
        /// Its line.
        place: Place,
        /// What is wrong with it.
        problem: String,
    },
    /// An image that cannot be decoded.
    #[error("{}{}: broken image: {problem}", line_of(.named_by), .path.display())]
    BrokenImage {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
        /// What the decoder said.
        problem: String,
    },
    /// An image without texels, or larger than the limit.
    #[error("{}{}: image of {width} x {height} texels", line_of(.named_by), .path.display())]
    ImageSize {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
    /// An environment whose chart cannot have the image's sides.
    #[error("{}{}: an environment of {width} x {height} texels is no {chart} map", line_of(.named_by), .path.display())]
    EnvironmentSize {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
        /// The chart.
        chart: &'static str,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Sides that the chart can have, in words.
        expected: String,
    },
    /// A line whose shape cannot be made.
    #[error("{place}: {problem}")]
    BadShape {
        /// The line.
        place: Place,
        /// What is wrong with it.
        problem: String,
    },
    /// A scene that draws nothing.
    #[error("{}: the scene has no faces", .path.display())]
    EmptyScene {
        /// The scene.
        path: PathBuf,
    },
    /// A model without faces.
    #[error("{}{}: the model has no faces", line_of(.named_by), .path.display())]
    EmptyMesh {
        /// The model.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<Place>,
    },
    /// A `usemtl` whose material no library defines.
    #[error("{place}: material `{name}` is not defined")]
    UnknownMaterial {
        /// The `usemtl` line.
        place: Place,
        /// The name.
        name: String,
    },
    /// A model that the OBJ reader refuses.
    #[error("{}: {problem}", .path.display())]
    BrokenModel {
        /// The model.
        path: PathBuf,
        /// What the reader said.
        problem: String,
    },
    /// An array file that cannot be read.
    #[error("{}: {problem}", .path.display())]
    BrokenArray {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A camera path that cannot be read.
    #[error("{place}: camera path: {problem}")]
    BrokenPath {
        /// Where it is wrong.
        place: Place,
        /// What is wrong with it.
        problem: String,
    },
}

impl IoError {
    /// A short name of the error that stays the same from version to version.
    pub fn code(&self) -> &'static str {
        match self {
            Self::FileMissing { .. } => "file-missing",
            Self::NotAFile { .. } => "not-a-file",
            Self::Read { .. } => "read-failed",
            Self::Write { .. } => "write-failed",
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
            Self::ImageSize { .. } => "image-size",
            Self::EnvironmentSize { .. } => "environment-size",
            Self::BadShape { .. } => "bad-shape",
            Self::EmptyScene { .. } => "empty-scene",
            Self::EmptyMesh { .. } => "empty-mesh",
            Self::UnknownMaterial { .. } => "unknown-material",
            Self::BrokenModel { .. } => "broken-model",
            Self::BrokenArray { .. } => "broken-array",
            Self::BrokenPath { .. } => "broken-camera-path",
        }
    }

    /// The place in a text file that the error speaks of, if there is one.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::FileMissing { named_by, .. }
            | Self::NotAFile { named_by, .. }
            | Self::Read { named_by, .. }
            | Self::BrokenImage { named_by, .. }
            | Self::ImageSize { named_by, .. }
            | Self::EnvironmentSize { named_by, .. }
            | Self::EmptyMesh { named_by, .. } => named_by.as_ref(),
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

    /// One line: why this is refused, and what to try.
    pub fn help(&self) -> String {
        match self {
            Self::FileMissing { named_by: Some(_), .. } => "names are relative to the file that holds the line; put the file there or mend the line (for maps and material libraries, `missing warn` draws without them)".into(),
            Self::FileMissing { .. } => "check the spelling and the working directory".into(),
            Self::NotAFile { .. } => "name a file, not a directory".into(),
            Self::Read { .. } => "check the permissions of the file".into(),
            Self::Write { .. } => "check that the directory exists and may be written; an older file of this name was left as it was".into(),
            Self::FileTooLarge { .. } => "split the file, or store the model in parts".into(),
            Self::NotUtf8 { .. } => "scene, OBJ and MTL files are UTF-8 text; convert the file (for example with iconv)".into(),
            Self::UnknownFormat { .. } => "texmap reads .scene and .obj models and .png, .jpg and .gif images".into(),
            Self::UnknownCommand { nearest: Some(nearest), .. } => format!("did you mean `{nearest}`? docs/SCENE_FORMAT.md lists the commands"),
            Self::UnknownCommand { .. } => "docs/SCENE_FORMAT.md lists the commands; `#` begins a comment".into(),
            Self::StrayNumber { .. } => "a line that begins with a number continues the command above it; begin with a command".into(),
            Self::ArgumentCount { .. } => "give as many values as the command takes; every command begins its own line".into(),
            Self::NotANumber { .. } => "write a decimal number such as 12, -0.5 or 1e-3".into(),
            Self::NotFinite { .. } => "NaN, infinities and magnitudes above 3.4e38 cannot be drawn; mend the program that wrote the file".into(),
            Self::OutOfRange { allowed, .. } | Self::UnknownWord { allowed, .. } => format!("allowed: {allowed}"),
            Self::StrayQuote { .. } => "quotes stand around a whole path: \"my file.png\"".into(),
            Self::BadIndex { place, count, .. } => index_help(place, *count),
            Self::TooFewCorners { .. } => "remove the face or give it its missing corners".into(),
            Self::MixedCorners { .. } => "write every corner of a face in the same form: v, v/vt, v//vn or v/vt/vn".into(),
            Self::NeedsAbove { command: "pop", .. } => "each `pop` closes a `push` of the same file; remove one or add the other".into(),
            Self::NeedsAbove { needs, .. } => format!("add a `{needs}` line before the first face that uses it"),
            Self::OpenPush { .. } => "close it with `pop`".into(),
            Self::IncludeCycle { .. } => "a file cannot contain itself; remove one of the `include` lines".into(),
            Self::DegenerateFrame { .. } => "give U and V two directions of the texture's plane, neither zero nor parallel".into(),
            Self::BadCamera { .. } => "eye and look must differ, up must not point along the line of sight, and 0 < near < far".into(),
            Self::BadProjector { .. } => "its position and look must differ, and up must not be zero or point along the line of projection".into(),
            Self::BrokenImage { .. } => "the file is damaged or of another kind than PNG, JPEG or GIF; write it again".into(),
            Self::ImageSize { .. } => format!("textures have 1 to {} texels a side and {} in all", crate::image_io::MAX_SIDE, crate::image_io::MAX_TEXELS),
            Self::EnvironmentSize { chart, expected, .. } => format!("a {chart} map is {expected}; name the chart that the image is in, or convert it with `texmap env`"),
            Self::BadShape { .. } => "docs/SCENE_FORMAT.md says what the line takes, and from which sizes on it is refused".into(),
            Self::EmptyScene { .. } => "nothing would be drawn; add `f`, `tf`, `ff` or `obj` lines".into(),
            Self::EmptyMesh { .. } => "nothing would be drawn; the OBJ needs `f` lines (points and lines are not drawn)".into(),
            Self::UnknownMaterial { .. } => "define it in the MTL library, mend the name, or draw without it (`missing warn`)".into(),
            Self::BrokenModel { .. } => "export the model again as plain OBJ polygons".into(),
            Self::BrokenArray { .. } => "texmap reads .npy arrays of format 1 to 3, C order, little-endian f4, f8, u1 or u2".into(),
            Self::BrokenPath { .. } => "a camera path is a JSON list of {\"eye\":[x,y,z],\"look\":[x,y,z]} with optional \"up\" and \"fov\" (degrees)".into(),
        }
    }
}

fn line_of(place: &Option<Place>) -> String {
    place.as_ref().map(|p| format!("{p}: ")).unwrap_or_default()
}

fn index_help(place: &Place, count: usize) -> String {
    let one_based = place
        .file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    match (one_based, count) {
        (_, 0) => "none is defined above this line; list them before the faces".into(),
        (true, n) => format!("indices count from 1 to {n}, or from -1 back to -{n}"),
        (false, n) => format!("indices count from 0 to {}", n - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_each_and_the_place_comes_first() {
        let error = IoError::BadIndex {
            place: Place::new(Path::new("room.scene"), 3, 7),
            of: "vertex",
            index: "9".into(),
            count: 4,
        };
        assert_eq!(
            error.to_string(),
            "room.scene:3:7: vertex index 9 does not exist; there are 4 above this line"
        );
        assert_eq!(error.help(), "indices count from 0 to 3");
        assert_eq!(error.code(), "bad-index");
        assert_eq!(error.place().map(|p| p.line), Some(3));
    }
}
