//! A glTF file with its bytes: the document, its buffers and the files beside it.

use std::collections::{HashMap, HashSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};

use super::json::Document;
use super::{container, uri};
use crate::error::shortened;
use crate::files::{Lost, MAX_TEXT, missing};
use crate::info::NamedFile;
use crate::{FileSource, IoError, shown};

/// A document with the bytes of its buffers.
#[derive(Debug)]
pub(super) struct Model<'a> {
    pub(super) path: &'a Path,
    pub(super) document: Document,
    /// Source of files, confined to the folder of the model.
    pub(super) files: FileSource,
    /// The whole file.
    bytes: Vec<u8>,
    buffers: Vec<Buffer>,
    /// The bytes of views that are compressed, by the number of the view.
    decoded: Vec<Option<Vec<u8>>>,
    /// Each once, in the order of their causes.
    pub(super) warnings: Vec<String>,
    warned: HashSet<String>,
    lost: Lost,
    /// Files beside it, in the order of their mention.
    pub(super) named: Vec<NamedFile>,
    /// Their numbers.
    named_at: HashMap<PathBuf, usize>,
    /// Faults of files beside it are noted in `named` and do not stop.
    pub(super) tolerant: bool,
}

#[derive(Debug)]
enum Buffer {
    /// In the file itself.
    Binary(std::ops::Range<usize>),
    Own(Vec<u8>),
    /// Its file could not be read, and this only had to be noted.
    Lost,
}

impl<'a> Model<'a> {
    /// Reads a file and the buffers that it names.
    pub(super) fn read(path: &'a Path, files: FileSource, tolerant: bool) -> Result<Self, IoError> {
        let bytes = files.read(path, MAX_TEXT)?;
        let parts = container::split(path, &bytes)?;
        let document = container::parse(path, &bytes[parts.json], &files)?;
        let mut model = Self {
            path,
            document,
            files: files.confined(path)?,
            bytes,
            buffers: Vec::new(),
            decoded: Vec::new(),
            warnings: Vec::new(),
            warned: HashSet::new(),
            lost: Lost::default(),
            named: Vec::new(),
            named_at: HashMap::new(),
            tolerant,
        };
        super::extensions::check(&mut model)?;
        let mut binary = parts.binary;
        for i in 0..model.document.buffers.len() {
            let buffer = model.buffer(i, binary.take().filter(|_| i == 0))?;
            model.buffers.push(buffer);
        }
        model.decoded = super::meshopt::decoded(&model)?;
        Ok(model)
    }

    fn buffer(
        &mut self,
        i: usize,
        binary: Option<std::ops::Range<usize>>,
    ) -> Result<Buffer, IoError> {
        let stated = self.document.buffers[i].byte_length;
        let pointer = format!("/buffers/{i}");
        let own = &self.document.buffers[i];
        // Views of a fallback are decoded instead.
        let is_fallback = own.extensions.stated().any(|(_, it)| it.fallback);
        let uri = own.uri.clone().filter(|_| !is_fallback);
        let buffer = match (&uri, binary) {
            (Some(uri), _) => match self.named_bytes(&format!("{pointer}/uri"), uri)? {
                Some(bytes) => Buffer::Own(bytes),
                None => Buffer::Lost,
            },
            (None, Some(range)) => Buffer::Binary(range),
            // The place of data that is compressed elsewhere.
            (None, None) => Buffer::Own(Vec::new()),
        };
        let found = match &buffer {
            Buffer::Binary(range) => range.len() as u64,
            Buffer::Own(bytes) => bytes.len() as u64,
            Buffer::Lost => return Ok(buffer),
        };
        if found < stated && uri.is_some() {
            return Err(self.broken(&pointer, format!("should have {stated} bytes, has {found}")));
        }
        Ok(buffer)
    }

    /// The bytes of a data URI or of a file beside the model; `None` where a fault is only to be noted.
    pub(super) fn named_bytes(
        &mut self,
        pointer: &str,
        uri: &str,
    ) -> Result<Option<Vec<u8>>, IoError> {
        let target = uri::target(uri).map_err(|problem| self.broken(pointer, problem))?;
        let name = match target {
            uri::Target::Data(bytes) => return Ok(Some(bytes)),
            uri::Target::File(name) => name,
        };
        if let Some((found, true)) = self.lost.find(&self.files, self.path, &name) {
            let path = self.files.beside(self.path, &name);
            let error = missing(&path, None);
            let found = shown(Path::new(&found));
            self.warn(format!("{pointer}: {error}: {found} is read"));
        }
        let path = self.beside(&name);
        match self.files.read(&path, MAX_TEXT) {
            Ok(bytes) => {
                self.note(&path, pointer, None);
                Ok(Some(bytes))
            }
            Err(error) if self.tolerant && !matches!(error, IoError::Memory { .. }) => {
                self.note(&path, pointer, Some(error.to_string()));
                Ok(None)
            }
            Err(error) => Err(self.within(pointer, error)),
        }
    }

    /// A file that the model names, where it was found.
    pub(super) fn beside(&self, name: &str) -> PathBuf {
        let found = self.lost.found(self.path, name);
        self.files.beside(self.path, found.unwrap_or(name))
    }

    /// Notes a file beside the model.
    fn note(&mut self, path: &Path, pointer: &str, problem: Option<String>) {
        if !self.named_at.contains_key(path) {
            self.note_file(NamedFile {
                path: path.to_path_buf(),
                named_by: self.place(pointer),
                size: None,
                bits: None,
                problem,
            });
        }
    }

    /// Notes a file beside the model in place of an earlier note on it.
    pub(super) fn note_file(&mut self, file: NamedFile) {
        match self.named_at.get(&file.path) {
            Some(at) => self.named[*at] = file,
            None => {
                self.named_at.insert(file.path.clone(), self.named.len());
                self.named.push(file);
            }
        }
    }

    /// Bytes `offset..offset + length` of a view; `None` where its buffer was lost.
    pub(super) fn view(&self, index: usize, pointer: &str) -> Result<Option<&[u8]>, IoError> {
        let views = &self.document.buffer_views;
        let view = self.item(views, index, pointer, "bufferView")?;
        if view.extensions.stated().next().is_some() {
            return Ok(self.decoded.get(index).and_then(Option::as_deref));
        }
        let at = format!("/bufferViews/{index}");
        self.slice(view.buffer, view.byte_offset, view.byte_length, &at)
    }

    /// Bytes `start..start + length` of a buffer, which the part at `pointer` names; `None` where it was lost.
    pub(super) fn slice(
        &self,
        buffer: usize,
        start: u64,
        length: u64,
        pointer: &str,
    ) -> Result<Option<&[u8]>, IoError> {
        let named_at = format!("{pointer}/buffer");
        let bytes = match self.item(&self.buffers, buffer, &named_at, "buffer")? {
            Buffer::Binary(range) => &self.bytes[range.clone()],
            Buffer::Own(bytes) => bytes,
            Buffer::Lost => return Ok(None),
        };
        let end = start.checked_add(length);
        let slice =
            end.and_then(|end| bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        slice.map(Some).ok_or_else(|| {
            let problem = format!(
                "bytes {start} to {} lie outside of buffer {buffer}, which has {}",
                start.saturating_add(length),
                bytes.len()
            );
            self.broken(pointer, problem)
        })
    }

    /// The item of a list that `pointer` names by its index.
    pub(super) fn item<'l, T>(
        &self,
        list: &'l [T],
        index: usize,
        pointer: &str,
        what: &str,
    ) -> Result<&'l T, IoError> {
        list.get(index).ok_or_else(|| {
            let are = if list.len() == 1 { "is" } else { "are" };
            self.broken(
                pointer,
                format!("{what} {index} does not exist; there {are} {}", list.len()),
            )
        })
    }

    /// The index that a name or number means; names come first.
    pub(super) fn chosen(
        &self,
        of: &'static str,
        wanted: &str,
        names: &[&str],
    ) -> Result<usize, IoError> {
        let named = names.iter().position(|name| *name == wanted);
        let numbered = || wanted.parse().ok().filter(|n| *n < names.len());
        named.or_else(numbered).ok_or_else(|| {
            let list = names
                .iter()
                .take(20)
                .enumerate()
                .map(|(i, name)| match *name {
                    "" => i.to_string(),
                    name => format!("{i} '{}'", shortened(name)),
                });
            IoError::UnknownName {
                path: self.path.to_path_buf(),
                of,
                name: wanted.to_owned(),
                known: list.collect::<Vec<_>>().join(", "),
            }
        })
    }

    /// Asks the memory budget.
    pub(super) fn ask(&self, bytes: u64, pointer: &str) -> Result<(), IoError> {
        let what = format_args!("what {pointer} of {} names", self.path.display());
        self.files.ask(bytes, what, "split the model", None)
    }

    pub(super) fn broken(&self, pointer: &str, problem: impl Into<String>) -> IoError {
        container::broken(self.path, pointer, problem.into())
    }

    pub(super) fn unsupported(&self, pointer: &str, feature: &str, instead: String) -> IoError {
        IoError::UnsupportedGltf {
            path: self.path.to_path_buf(),
            pointer: pointer.to_owned(),
            feature: shortened(feature).to_string(),
            instead,
        }
    }

    /// An error of a file that the document names. A refusal of the memory budget is passed on.
    pub(super) fn within(&self, pointer: &str, error: IoError) -> IoError {
        match error {
            error @ IoError::Memory { .. } => error,
            error => IoError::NamedByGltf {
                path: self.path.to_path_buf(),
                pointer: pointer.to_owned(),
                error: Box::new(error),
            },
        }
    }

    /// The path of the file and a JSON pointer, as messages begin with them.
    pub(super) fn place(&self, pointer: &str) -> String {
        format!("{}: {}", shown(self.path), shortened(pointer))
    }

    /// Adds a warning that was not given yet.
    pub(super) fn warn(&mut self, warning: impl Display) {
        let warning = warning.to_string();
        if self.warned.insert(warning.clone()) {
            self.warnings.push(warning);
        }
    }
}
