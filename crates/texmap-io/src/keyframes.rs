//! JSON lists of keyframes and cameras: their faults, and the way from keyframe to keyframe.

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::{FileSource, IoError, SourceLocation};

/// Messages on the contents of a list.
pub(crate) struct Fields {
    /// The fields of an entry, for an unknown one.
    pub(crate) known: &'static str,
    /// The message for a file that is no such list.
    pub(crate) list: &'static str,
}

/// Reads a list with at least one entry.
pub(crate) fn read<T: DeserializeOwned>(
    path: &Path,
    files: &FileSource,
    fields: &Fields,
) -> Result<Vec<T>, IoError> {
    let text = files.read_text(path, FileSource::MAX_LIST)?;
    let list: Vec<T> =
        serde_json::from_str(&text).map_err(|e| broken_json(path, &text, &e, fields))?;
    match list.is_empty() {
        true => Err(broken(path, "the list is empty".into())),
        false => Ok(list),
    }
}

/// A fault of a list as a whole, or of an entry that it names.
pub(crate) fn broken(path: &Path, problem: String) -> IoError {
    IoError::BrokenPath {
        location: SourceLocation::new(path, 1, 1),
        problem,
    }
}

/// The two keyframes around a frame, and the way from the first to the second, 0 to 1.
pub(crate) struct Leg {
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) t: f64,
}

impl Leg {
    /// Of frame `frame` of `frames` among `count` keyframes, at least one: equal numbers of frames for each leg, the first frame on the
    /// first keyframe, the last on the last.
    pub(crate) fn of(count: usize, frame: u32, frames: u32) -> Self {
        let last = count - 1;
        let along = if frames > 1 {
            f64::from(frame.min(frames - 1)) * last as f64 / f64::from(frames - 1)
        } else {
            0.0
        };
        let from = (along as usize).min(last.saturating_sub(1));
        Self {
            from,
            to: (from + 1).min(last),
            t: along - from as f64,
        }
    }
}

/// A fault of a JSON list of keyframes or cameras, with its position.
fn broken_json(path: &Path, text: &str, error: &serde_json::Error, fields: &Fields) -> IoError {
    // The end of a text that ends in a line feed is column 0 of a line that it does not have.
    let last = text.lines().count().max(1);
    let (line, column) = match error.line() {
        line if line > last => (last, text.lines().last().map_or(0, str::len) + 1),
        line => (line.max(1), error.column().max(1)),
    };
    IoError::BrokenPath {
        location: SourceLocation::new(path, line as u32, column as u32),
        problem: problem(error, fields),
    }
}

/// The reader's message without quotations. The file may be no list at all, and its contents must not be shown.
fn problem(error: &serde_json::Error, fields: &Fields) -> String {
    let text = error.to_string();
    let text = text.split(" at line ").next().unwrap_or_default();
    if !error.is_data() || text.starts_with("missing field") {
        text.into()
    } else if text.starts_with("unknown field") {
        fields.known.into()
    } else if text.starts_with("duplicate field") {
        "a field stands twice".into()
    } else {
        fields.list.into()
    }
}
