//! The line of a unit in reports: JSON, one line each.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::cmd::batch::files::FileMark;

/// Version of the shape of reports and markers; grows when a field changes its meaning or goes.
pub(crate) const SCHEMA: u32 = 1;

/// Version of the program, which reports and markers carry.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Outcome of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    /// Its outputs are written.
    Ok,
    /// It fails again if it is run again.
    Failed,
    /// Its process was ended from outside: it may succeed later.
    Killed,
    /// A dry run.
    Planned,
}

/// A band's place in its picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct BandMark {
    /// The picture that the bands are joined to, named from the folder of the outputs.
    pub(crate) picture: String,
    pub(crate) index: u32,
    pub(crate) count: u32,
}

/// A unit that was run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    pub(crate) id: String,
    /// Position among all units of the batch, from 0.
    pub(crate) index: u64,
    pub(crate) status: Status,
    /// The exit code that the verb alone would end with.
    pub(crate) code: u8,
    pub(crate) input: String,
    /// Named from the folder of the outputs if they lie in it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) outputs: Vec<FileMark>,
    /// Of the picture, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) pixel_hash: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) band: Option<BandMark>,
    pub(crate) warnings: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<Value>,
    pub(crate) ms: f64,
    /// The largest memory of the process meanwhile, where the system tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) peak_bytes: Option<u64>,
    pub(crate) settings_hash: String,
    pub(crate) texmap: String,
}

/// The first line of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    pub(crate) texmap: String,
    pub(crate) schema: u32,
    pub(crate) verb: String,
    /// `I/N`, or the numbers of `--range`.
    pub(crate) shard: String,
    /// The folder of the outputs, named from that of the report unless it is a whole path.
    pub(crate) folder: String,
    /// Units of the whole batch.
    pub(crate) units: u64,
    /// Hash of the ids of all of them.
    pub(crate) units_hash: String,
    /// Hash of the settings of all items.
    pub(crate) settings_hash: String,
}

/// The last line of a run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) texmap: &'static str,
    pub(crate) shard: String,
    pub(crate) units: u64,
    pub(crate) done: u64,
    /// Complete before, with `--resume`.
    pub(crate) skipped: u64,
    pub(crate) failed: u64,
    pub(crate) killed: u64,
    /// Not started after `--fail-fast`.
    pub(crate) waiting: u64,
    pub(crate) ms: f64,
    pub(crate) jobs: usize,
    pub(crate) threads: u16,
    pub(crate) exit: u8,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) report: Option<String>,
}
