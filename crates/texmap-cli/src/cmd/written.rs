//! The report of verbs that write files and print nothing else: as JSON on request.

use std::path::Path;

use serde::Serialize;

use crate::failure::{self, Exit, Failure, say};
use crate::observe;

/// Files that a verb wrote.
#[derive(Debug, Serialize)]
pub(crate) struct Written {
    texmap: &'static str,
    verb: &'static str,
    exit: u8,
    files: Vec<WrittenFile>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct WrittenFile {
    path: String,
    /// Height, width and channels of a picture, or the shape of an array; absent for text.
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<Vec<usize>>,
}

impl Written {
    pub(crate) fn new(verb: &'static str) -> Self {
        Self {
            texmap: env!("CARGO_PKG_VERSION"),
            verb,
            exit: Exit::Done as u8,
            files: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// A picture of `width` x `height` pixels.
    pub(crate) fn picture(&mut self, path: &Path, (width, height): (u32, u32)) {
        self.array(path, &[height as usize, width as usize]);
    }

    pub(crate) fn array(&mut self, path: &Path, shape: &[usize]) {
        self.files.push(WrittenFile {
            path: path.display().to_string(),
            shape: Some(shape.to_vec()),
        });
    }

    pub(crate) fn text(&mut self, path: &Path) {
        self.files.push(WrittenFile {
            path: path.display().to_string(),
            shape: None,
        });
    }

    pub(crate) fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        self.warnings.extend(warnings);
    }

    /// Warns on standard error, too.
    pub(crate) fn say_warning(&mut self, warning: String) {
        say(&format!("warning: {warning}\n"));
        self.warn([warning]);
    }

    /// Prints the report if `json` asks for it.
    pub(crate) fn tell(&self, json: bool) -> Result<Exit, Failure> {
        if json || observe::is_on() {
            failure::print_json(self)?;
        }
        Ok(Exit::Done)
    }
}

/// Standard output is the file or the report.
pub(crate) fn one_stdout(json: bool, output: &Path) -> Result<(), Failure> {
    match json && output == Path::new("-") {
        true => Err(Failure::usage(
            "-o - and --json do not go together",
            "name a file",
        )),
        false => Ok(()),
    }
}
