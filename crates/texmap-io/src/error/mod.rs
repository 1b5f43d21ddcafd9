//! Errors of files. One line says what and where, one says why and what to try.

mod code;
mod help;
mod location;
mod shown;

use std::borrow::Cow;
use std::io;
use std::path::PathBuf;

use location::{line_of, pointer_of};
use texmap_math::OverBudget;

pub use location::SourceLocation;
pub use shown::{plain, plain_json, shortened, shown};

use shown::one_message;

/// Reasons for which a file cannot be read or written.
///
/// `Display` is the line *what and where*; [`IoError::help`] is the line *why and what to try*;
/// [`IoError::code`] is a short name that stays the same from version to version.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// No file of this name.
    #[error("{}{}: no such file", line_of(.named_by), shown(.path))]
    FileMissing {
        /// The file that was looked for.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
    },
    /// A directory or a device where a file is needed.
    #[error("{}{}: not a regular file", line_of(.named_by), shown(.path))]
    NotAFile {
        /// The path given.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
    },
    /// The operating system refused to read.
    #[error("{}{}: cannot be read: {source}", line_of(.named_by), shown(.path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The operating system refused to write.
    #[error("{}: cannot be written: {source}", shown(.path))]
    Write {
        /// The file that should have been written.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A file outside of the folder to which reading is confined.
    #[error("{}{}: lies outside of the folder that may be read", line_of(.named_by), shown(.path))]
    OutsideRoot {
        /// The path given.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
    },
    /// More bytes than the stated limit.
    #[error("{}: {bytes} bytes, the limit is {limit}", shown(.path))]
    FileTooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit for files of this kind.
        limit: u64,
    },
    /// A text file that is not UTF-8.
    #[error("{location}: not UTF-8 text")]
    NotUtf8 {
        /// The first byte that is not text.
        location: SourceLocation,
    },
    /// A file name ending that texmap does not read.
    #[error("{}: unknown kind of file", shown(.path))]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A word that is no command.
    #[error("{location}: unknown command `{word}`", word = shortened(.word))]
    UnknownCommand {
        /// Position of the word.
        location: SourceLocation,
        /// The word.
        word: String,
        /// The command that looks most like it.
        nearest: Option<&'static str>,
    },
    /// Numbers before the first command.
    #[error("{location}: number `{text}` with no command above it", text = shortened(.text))]
    StrayNumber {
        /// Position of the number.
        location: SourceLocation,
        /// The number.
        text: String,
    },
    /// Too few or too many values after a command.
    #[error("{location}: `{command}` takes {expected}, found {found}")]
    ArgumentCount {
        /// The first value too many, or the command.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// Values that the command takes, in words.
        expected: Cow<'static, str>,
        /// Number of values found.
        found: usize,
    },
    /// A word where a number is needed.
    #[error("{location}: `{command}`: `{text}` is not a number", text = shortened(.text))]
    NotANumber {
        /// Position of the word.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// The word.
        text: String,
    },
    /// NaN, an infinity, or a number beyond 32-bit floats.
    #[error("{location}: `{command}`: `{text}` is not a finite 32-bit number", text = shortened(.text))]
    NotFinite {
        /// Position of the number.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// The number.
        text: String,
    },
    /// A number outside of the range of its command.
    #[error("{location}: `{command}`: `{text}` is out of range", text = shortened(.text))]
    OutOfRange {
        /// Position of the number.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// The number.
        text: String,
        /// Allowed values, in words.
        allowed: &'static str,
    },
    /// A word that its command does not know.
    #[error("{location}: `{command}` does not know `{word}`", word = shortened(.word))]
    UnknownWord {
        /// Position of the word.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// The word.
        word: String,
        /// Allowed values, in words.
        allowed: Cow<'static, str>,
    },
    /// A quote that does not end, or one inside a word.
    #[error("{location}: stray quote")]
    StrayQuote {
        /// Position of the quote.
        location: SourceLocation,
    },
    /// An index of a vertex, texture coordinate or normal that does not exist.
    #[error("{location}: {of} index {index} does not exist; there are {count} above this line", index = shortened(.index))]
    BadIndex {
        /// Position of the index.
        location: SourceLocation,
        /// `vertex`, `texture coordinate` or `normal`.
        of: &'static str,
        /// The index as written.
        index: String,
        /// Number of elements above the line.
        count: usize,
    },
    /// A face of fewer than three corners.
    #[error("{location}: `{command}` with {found} corners; a face needs 3 or more")]
    TooFewCorners {
        /// Position of the face.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// Number of corners of the face.
        found: usize,
    },
    /// An OBJ face whose corners do not all name the same kinds of data.
    #[error("{location}: corners of one face differ: some name a {of}, some do not")]
    MixedCorners {
        /// Position of the odd corner.
        location: SourceLocation,
        /// `texture coordinate` or `normal`.
        of: &'static str,
    },
    /// A command that needs another one above it.
    #[error("{location}: `{command}` needs {needs} above it")]
    NeedsAbove {
        /// Position of the command.
        location: SourceLocation,
        /// The command.
        command: &'static str,
        /// Missing line or setting, such as "a `texture` line".
        needs: &'static str,
    },
    /// A `push` that no `pop` closes.
    #[error("{location}: `push` without a `pop` in the same file")]
    OpenPush {
        /// Position of the push.
        location: SourceLocation,
    },
    /// A file that includes itself.
    #[error("{location}: `include` of {} goes in a circle", shown(.path))]
    IncludeCycle {
        /// The line that closes the circle.
        location: SourceLocation,
        /// The file that is already open.
        path: PathBuf,
    },
    /// A texture frame whose U and V do not span a plane.
    #[error("{location}: `frame`: {problem}", problem = one_message(.problem))]
    DegenerateFrame {
        /// Position of the frame.
        location: SourceLocation,
        /// Description of the fault.
        problem: String,
    },
    /// A camera that sees nothing.
    #[error("{location}: camera: {problem}", problem = one_message(.problem))]
    BadCamera {
        /// The last line that set the camera.
        location: SourceLocation,
        /// Description of the fault.
        problem: String,
    },
    /// A projector that projects nowhere.
    #[error("{location}: projector: {problem}", problem = one_message(.problem))]
    BadProjector {
        /// Its line.
        location: SourceLocation,
        /// Description of the fault.
        problem: String,
    },
    /// An image that cannot be decoded.
    #[error("{}{}: broken image: {problem}", line_of(.named_by), shown(.path), problem = one_message(.problem))]
    BrokenImage {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
        /// Message of the decoder.
        problem: String,
    },
    /// An image of a format that a feature of this crate reads, in a build without it.
    #[error("{}{}: this build reads no {format} images", line_of(.named_by), shown(.path))]
    ImageLeftOut {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
        /// Name of its format.
        format: &'static str,
        /// The feature, of this crate and of the program.
        feature: &'static str,
    },
    /// An image without texels, or larger than the limit.
    #[error("{}{}: image of {width} x {height} texels", line_of(.named_by), shown(.path))]
    ImageSize {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
    /// An environment whose layout cannot have the image's sides.
    #[error("{}{}: an environment of {width} x {height} texels is no {chart} map", line_of(.named_by), shown(.path))]
    EnvironmentSize {
        /// The image.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
        /// The layout.
        chart: &'static str,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Sides that the layout can have, in words.
        expected: String,
    },
    /// A line whose shape cannot be made.
    #[error("{location}: {problem}", problem = one_message(.problem))]
    BadShape {
        /// The line.
        location: SourceLocation,
        /// Description of the fault.
        problem: String,
    },
    /// A scene that draws nothing.
    #[error("{}: the scene has no faces", shown(.path))]
    EmptyScene {
        /// The scene.
        path: PathBuf,
    },
    /// A model without faces.
    #[error("{}{}: the model has no faces", line_of(.named_by), shown(.path))]
    EmptyMesh {
        /// The model.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
    },
    /// A `usemtl` whose material no library defines.
    #[error("{location}: material `{name}` is not defined", name = shortened(.name))]
    UnknownMaterial {
        /// The `usemtl` line.
        location: SourceLocation,
        /// The name.
        name: String,
    },
    /// A line of a model that its reader refuses.
    #[error("{location}: {problem}", problem = one_message(.problem))]
    BrokenModelLine {
        /// The line.
        location: SourceLocation,
        /// Description of the fault.
        problem: String,
    },
    /// A model of points without faces.
    #[error("{}{}: {points} {kind} without faces", line_of(.named_by), shown(.path))]
    PointCloud {
        /// The model.
        path: PathBuf,
        /// The line that names it, if a file does.
        named_by: Option<SourceLocation>,
        /// Number of points.
        points: usize,
        /// `points` or `Gaussian splats`.
        kind: &'static str,
    },
    /// A model that its reader refuses.
    #[error("{}: {problem}", shown(.path), problem = one_message(.problem))]
    BrokenModel {
        /// The model.
        path: PathBuf,
        /// Message of the reader.
        problem: String,
    },
    /// A glTF file that contradicts itself or the standard.
    #[error("{}: {}{problem}", shown(.path), pointer_of(.pointer), problem = one_message(.problem))]
    BrokenGltf {
        /// The file.
        path: PathBuf,
        /// JSON pointer of the fault; empty where it is not in the JSON.
        pointer: String,
        /// Description of the fault.
        problem: String,
    },
    /// A glTF file of a version, or with an extension, that is not read.
    #[error("{}: {}{feature} is not read", shown(.path), pointer_of(.pointer))]
    UnsupportedGltf {
        /// The file.
        path: PathBuf,
        /// JSON pointer of the part that needs the version or the extension.
        pointer: String,
        /// The version or the extension.
        feature: String,
        /// Remedy, with the command that converts the file if there is one.
        instead: String,
    },
    /// A fault of a file, or of a part, that a glTF file names.
    #[error("{}: {}{error}", shown(.path), pointer_of(.pointer))]
    NamedByGltf {
        /// The glTF file.
        path: PathBuf,
        /// JSON pointer of the part that names the file.
        pointer: String,
        /// The fault.
        error: Box<Self>,
    },
    /// A camera or animation that a model does not have.
    #[error("{}: has no {of} '{}'", shown(.path), shortened(.name))]
    UnknownName {
        /// The model.
        path: PathBuf,
        /// `camera` or `animation`.
        of: &'static str,
        /// The name or number that was asked for.
        name: String,
        /// The numbers and names that there are, in words; empty if there are none.
        known: String,
    },
    /// An array file that cannot be read.
    #[error("{}: {problem}", shown(.path), problem = one_message(.problem))]
    BrokenArray {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        problem: String,
    },
    /// Something that takes more memory than the budget has.
    #[error("{}{refused}", line_of(.named_by))]
    Memory {
        /// The line that asks for it, if a file does.
        named_by: Option<SourceLocation>,
        /// Refusal of the memory budget.
        refused: OverBudget,
    },
    /// A camera path that cannot be read.
    #[error("{location}: camera path: {problem}", problem = one_message(.problem))]
    BrokenPath {
        /// Position of the fault.
        location: SourceLocation,
        /// Description of the fault.
        problem: String,
    },
}

impl IoError {
    /// A refusal of the memory budget for a file or a line of one.
    pub(crate) fn memory(refused: OverBudget, named_by: Option<&SourceLocation>) -> Self {
        Self::Memory {
            named_by: named_by.cloned(),
            refused,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn one_line_each_and_the_place_comes_first() {
        let error = IoError::BadIndex {
            location: SourceLocation::new(Path::new("room.scene"), 3, 7),
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
        assert_eq!(error.location().map(|p| p.line), Some(3));
    }
}
