//! The reports of shards, read and held against each other.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::cmd::batch::plan::STATE;
use crate::cmd::batch::record::{Header, Record, SCHEMA, Status};
use crate::failure::{Exit, Failure};
use crate::values::{Part, Ranges};

/// The report of a shard.
#[derive(Debug)]
pub(super) struct Report {
    pub(super) path: PathBuf,
    /// The folder of its outputs.
    pub(super) folder: PathBuf,
    pub(super) header: Header,
    pub(super) records: Vec<Record>,
}

/// Reads the reports that are named, and all of the folders that are named.
pub(super) fn read(shards: &[PathBuf]) -> Result<Vec<Report>, Failure> {
    let mut reports = Vec::new();
    for shard in shards {
        if !shard.is_dir() {
            reports.push(report(shard)?);
            continue;
        }
        let state = shard.join(STATE);
        let state = if state.is_dir() { state } else { shard.clone() };
        let entries = fs::read_dir(&state).map_err(|e| bad(&state, &e.to_string()))?;
        let is_report = |name: &str| name.starts_with("report") && name.ends_with(".jsonl");
        let mut names: Vec<PathBuf> = entries
            .flatten()
            .filter(|entry| is_report(&entry.file_name().to_string_lossy()))
            .map(|entry| entry.path())
            .collect();
        names.sort();
        if names.is_empty() {
            return Err(Failure::new(
                Exit::Again,
                "not-complete",
                format!("{}: no shard has ended yet", shard.display()),
                "a shard writes .texmap/report-I-of-N.jsonl at its end",
            ));
        }
        for name in &names {
            reports.push(report(name)?);
        }
    }
    Ok(reports)
}

fn report(path: &Path) -> Result<Report, Failure> {
    let file = File::open(path).map_err(|e| bad(path, &e.to_string()))?;
    let mut header: Option<Header> = None;
    let mut records = Vec::new();
    for (line, number) in BufReader::new(file).lines().zip(1..) {
        let fault = |e: String| bad(path, &format!("line {number}: {e}"));
        let line = line.map_err(|e| fault(e.to_string()))?;
        match header {
            None => header = Some(serde_json::from_str(&line).map_err(|e| fault(e.to_string()))?),
            Some(_) => records.push(serde_json::from_str(&line).map_err(|e| fault(e.to_string()))?),
        }
    }
    let header = header.ok_or_else(|| bad(path, "it is empty"))?;
    if header.schema != SCHEMA {
        let what = format!(
            "a report of schema {}; this program reads {SCHEMA}",
            header.schema
        );
        return Err(bad(path, &what));
    }
    let state = path.parent().unwrap_or(Path::new(""));
    let folder = match header.folder == ".." {
        // Short names: `out/x.png` and not `out/.texmap/../x.png`.
        true => match state.parent() {
            Some(parent) if parent.as_os_str().is_empty() => PathBuf::from("."),
            Some(parent) => parent.to_owned(),
            None => PathBuf::from(".."),
        },
        false => state.join(&header.folder),
    };
    Ok(Report {
        path: path.to_owned(),
        folder,
        header,
        records,
    })
}

fn bad(path: &Path, why: &str) -> Failure {
    Failure::new(
        Exit::Input,
        "shard-report",
        format!("{}: {why}", path.display()),
        "name the folders of the outputs of `texmap batch --shard`, or the reports in their .texmap",
    )
}

/// Holds the reports against each other: one batch, every unit once. Returns the header that they share.
pub(super) fn unite(reports: &[Report]) -> Result<Header, Failure> {
    let Some(first) = reports.first() else {
        return Err(Failure::internal("no reports to merge"));
    };
    for other in reports {
        let (a, b) = (&first.header, &other.header);
        let differs = [
            ("texmap", &a.texmap, &b.texmap),
            ("verb", &a.verb, &b.verb),
            ("items", &a.units_hash, &b.units_hash),
            ("settings", &a.settings_hash, &b.settings_hash),
        ];
        if let Some((what, one, another)) = differs.into_iter().find(|(_, a, b)| a != b) {
            return Err(Failure::new(
                Exit::Input,
                "mixed-shards",
                format!(
                    "{} and {} are not of one batch: their {what} differ ({one}, {another})",
                    first.path.display(),
                    other.path.display()
                ),
                "run the odd one out again with the command and the program of the others, or take its report away",
            ));
        }
    }
    let mut owners: BTreeMap<u64, (&Report, &Record)> = BTreeMap::new();
    for report in reports {
        for record in &report.records {
            if let Some((other, _)) = owners.insert(record.index, (report, record)) {
                return Err(Failure::new(
                    Exit::Input,
                    "double-shards",
                    format!(
                        "{} (shard {}) and {} (shard {}) both have the unit {}",
                        other.path.display(),
                        other.header.shard,
                        report.path.display(),
                        report.header.shard,
                        record.id
                    ),
                    "name each shard once; reports of an earlier cut into shards are to be taken away",
                ));
            }
        }
    }
    let done = |index: &u64| {
        owners
            .get(index)
            .is_some_and(|(_, r)| r.status != Status::Killed)
    };
    let missing: Vec<u64> = (0..first.header.units)
        .filter(|index| !done(index))
        .collect();
    match missing.is_empty() {
        true => Ok(first.header.clone()),
        false => Err(incomplete(reports, missing)),
    }
}

fn incomplete(reports: &[Report], missing: Vec<u64>) -> Failure {
    let units = reports.first().map_or(0, |report| report.header.units);
    let parts: Option<Vec<Part>> = reports
        .iter()
        .map(|r| r.header.shard.parse().ok())
        .collect();
    let count = parts.and_then(|parts| {
        let count = parts.first()?.count;
        parts
            .iter()
            .all(|part| part.count == count)
            .then_some(count)
    });
    let number = missing.len();
    let names = match count {
        Some(count) => {
            let part = |index| Part { index, count };
            let late = (1..=count).map(part).filter(|part| {
                let units = part.of(units);
                let after = missing.partition_point(|unit| *unit < units.start);
                missing.get(after).is_some_and(|unit| *unit < units.end)
            });
            let late: Vec<String> = late.map(|part| part.to_string()).collect();
            format!("shard {}", some(&late))
        }
        None => {
            let ranges = Ranges::of(missing);
            let words: Vec<String> = ranges.to_string().split(',').map(str::to_owned).collect();
            format!("units {}", some(&words))
        }
    };
    Failure::new(
        Exit::Again,
        "not-complete",
        format!("{number} of {units} units are missing: {names}"),
        "wait for these shards, or run them again with --resume; nothing was written",
    )
}

/// The first of many names.
fn some(names: &[String]) -> String {
    let first: Vec<&str> = names.iter().take(20).map(String::as_str).collect();
    let rest = names.len() - first.len();
    match rest {
        0 => first.join(", "),
        rest => format!("{} and {rest} more", first.join(", ")),
    }
}
