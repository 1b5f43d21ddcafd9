//! The state of a batch on the disk: a marker for each complete unit, and the reports of shards.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use crate::cmd::batch::files::{FileMark, Marks, hash_of_parts};
use crate::cmd::batch::record::{Header, Record, SCHEMA, Status, VERSION};
use crate::failure::{Exit, Failure};
use crate::output::Folder;

/// Proof that a unit is complete.
#[derive(Debug, Serialize, Deserialize)]
struct Marker {
    schema: u32,
    /// The output that was asked for.
    output: String,
    record: Record,
    inputs: Vec<FileMark>,
}

/// The folder of the state. Files in it are written elsewhere first and appear whole.
#[derive(Debug)]
pub(crate) struct State {
    path: PathBuf,
    base: PathBuf,
    fresh: Folder,
    count: AtomicU64,
}

impl State {
    /// Makes the folder.
    pub(crate) fn new(path: &Path, base: &Path) -> Result<Self, Failure> {
        let refused = |e: io::Error| unwritable(path, &e);
        fs::create_dir_all(path.join("done")).map_err(refused)?;
        Ok(Self {
            path: path.to_owned(),
            base: base.to_owned(),
            fresh: Folder::new(path).map_err(refused)?,
            count: AtomicU64::new(0),
        })
    }

    /// The record of a unit, if it is complete: this version drew it with these settings, its inputs have the same bytes, and its outputs
    /// are there with their sizes.
    pub(crate) fn complete(
        &self,
        id: &str,
        output: &str,
        settings_hash: &str,
        marks: &Marks,
    ) -> Option<Record> {
        let text = fs::read_to_string(self.marker(id)).ok()?;
        let marker: Marker = serde_json::from_str(&text).ok()?;
        let record = &marker.record;
        let same = marker.schema == SCHEMA
            && marker.output == output
            && record.id == id
            && record.texmap == VERSION
            && record.settings_hash == settings_hash
            && record.status == Status::Ok;
        // A file that was missing may be there now.
        let missed = record.warnings.iter().any(|w| w.contains("no such file"));
        let written = record.outputs.iter().all(|output| {
            let there = fs::metadata(self.base.join(&output.path));
            there.is_ok_and(|there| there.is_file() && there.len() == output.bytes)
        });
        let complete = same && !missed && written && !record.outputs.is_empty();
        (complete && marker.inputs.iter().all(|input| marks.hold(input))).then_some(marker.record)
    }

    /// Marks a unit as complete.
    pub(crate) fn mark(
        &self,
        record: &Record,
        output: &str,
        inputs: Vec<FileMark>,
    ) -> Result<(), Failure> {
        let marker = Marker {
            schema: SCHEMA,
            output: output.to_owned(),
            record: record.clone(),
            inputs,
        };
        let path = self.marker(&record.id);
        let text = serde_json::to_string(&marker)
            .map_err(|e| Failure::internal(format!("a marker could not be written: {e}")))?;
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|e| unwritable(&path, &e))?;
        }
        self.put(&path, |out| writeln!(out, "{text}"))
    }

    /// Takes the marker of a unit away, before it is run again.
    pub(crate) fn unmark(&self, id: &str) {
        let _ = fs::remove_file(self.marker(id));
    }

    /// Writes a report.
    pub(crate) fn report<'r>(
        &self,
        name: &str,
        header: &Header,
        records: impl IntoIterator<Item = &'r Record>,
    ) -> Result<PathBuf, Failure> {
        let path = self.path.join(format!("{name}.jsonl"));
        self.put(&path, |out| {
            serde_json::to_writer(&mut *out, header)?;
            writeln!(out)?;
            records.into_iter().try_for_each(|record| {
                serde_json::to_writer(&mut *out, record)?;
                writeln!(out)
            })
        })?;
        Ok(path)
    }

    /// The name of a file from the folder of the outputs, if it lies in it.
    pub(crate) fn relative(&self, path: &Path) -> String {
        let inside = || {
            let base = fs::canonicalize(&self.base).ok()?;
            let path = fs::canonicalize(path).ok()?;
            Some(path.strip_prefix(base).ok()?.to_owned())
        };
        let path = inside().unwrap_or_else(|| path.to_owned());
        path.to_string_lossy().into_owned()
    }

    fn marker(&self, id: &str) -> PathBuf {
        let hash = hash_of_parts([id]);
        let digits = hash.rsplit(':').next().unwrap_or_default();
        let folder = self.path.join("done").join(&digits[..2]);
        folder.join(format!("{digits}.json"))
    }

    fn put(
        &self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let number = self.count.fetch_add(1, Ordering::Relaxed);
        let fresh = self.fresh.path().join(number.to_string());
        let written = || {
            let mut out = io::BufWriter::new(fs::File::create(&fresh)?);
            write(&mut out)?;
            out.flush()?;
            drop(out);
            fs::rename(&fresh, path)
        };
        written().map_err(|e| unwritable(path, &e))
    }
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::new(
        Exit::Input,
        "write-failed",
        format!("{}: cannot be written: {error}", path.display()),
        "check the permissions and the free space, or name another folder by --state",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_complete_while_inputs_settings_and_outputs_stay() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("in"), "input").unwrap();
        fs::write(at("out.png"), "picture").unwrap();
        let state = State::new(&at(".texmap"), dir.path()).unwrap();
        let mut output = FileMark::of(&at("out.png")).unwrap();
        output.path = state.relative(&at("out.png"));
        assert_eq!(output.path, "out.png");
        let mut record = Record {
            id: "in".into(),
            index: 3,
            status: Status::Ok,
            code: 0,
            input: "in".into(),
            outputs: vec![output],
            pixel_hash: None,
            band: None,
            warnings: Vec::new(),
            error: None,
            ms: 1.0,
            peak_bytes: None,
            settings_hash: "s".into(),
            texmap: VERSION.into(),
        };
        let inputs = || vec![FileMark::of(&at("in")).unwrap()];
        let complete = |output: &str, settings: &str| {
            state
                .complete("in", output, settings, &Marks::default())
                .is_some()
        };
        assert!(!complete("out.png", "s"));
        state.mark(&record, "out.png", inputs()).unwrap();
        assert!(complete("out.png", "s"));
        assert!(!complete("out.png", "t") && !complete("other.png", "s"));
        fs::write(at("in"), "Input").unwrap();
        assert!(!complete("out.png", "s"));
        state.mark(&record, "out.png", inputs()).unwrap();
        assert!(complete("out.png", "s"));
        fs::write(at("out.png"), "half").unwrap();
        assert!(!complete("out.png", "s"));
        fs::write(at("out.png"), "picture").unwrap();
        record.warnings.push("a.png: no such file".into());
        state.mark(&record, "out.png", inputs()).unwrap();
        assert!(!complete("out.png", "s"));
        record.warnings.clear();
        record.status = Status::Failed;
        state.mark(&record, "out.png", inputs()).unwrap();
        assert!(!complete("out.png", "s"));
    }
}
