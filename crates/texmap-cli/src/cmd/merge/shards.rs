//! The reports of shards, read and held against each other.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use texmap_io::{FileSource, shortened};

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
    let text = FileSource::anywhere().read_text(path, FileSource::MAX_LIST)?;
    let mut header: Option<Header> = None;
    let mut records = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let fault = |e: serde_json::Error| {
            let what = format!("line {number}: {}", shortened(&e.to_string()));
            bad(path, &what)
        };
        match header {
            None => header = Some(serde_json::from_str(line).map_err(fault)?),
            Some(_) => records.push(serde_json::from_str(line).map_err(fault)?),
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

pub(super) fn bad(path: &Path, why: &str) -> Failure {
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
    let ended = owners
        .iter()
        .filter(|(_, (_, r))| r.status != Status::Killed);
    let missing = gaps(ended.map(|(index, _)| *index), first.header.units);
    match missing.0.is_empty() {
        true => Ok(first.header.clone()),
        false => Err(incomplete(reports, &missing)),
    }
}

/// The numbers below `all` that do not stand among ascending ones. A report may state any number of units.
fn gaps(ascending: impl Iterator<Item = u64>, all: u64) -> Ranges {
    let mut ranges = Vec::new();
    let mut next = 0;
    for index in ascending.take_while(|index| *index < all) {
        if index > next {
            ranges.push(next..=index - 1);
        }
        next = index + 1;
    }
    if next < all {
        ranges.push(next..=all - 1);
    }
    Ranges(ranges)
}

fn incomplete(reports: &[Report], missing: &Ranges) -> Failure {
    /// More shards than that are not named one by one.
    const MOST_SHARDS: u32 = 1 << 20;
    let units = reports.first().map_or(0, |report| report.header.units);
    let parts: Option<Vec<Part>> = reports
        .iter()
        .map(|r| r.header.shard.parse().ok())
        .collect();
    let count = parts.and_then(|parts| {
        let count = parts.first()?.count;
        let same = count <= MOST_SHARDS && parts.iter().all(|part| part.count == count);
        same.then_some(count)
    });
    let number: u64 = missing.0.iter().map(|r| r.end() - r.start() + 1).sum();
    let names = match count {
        Some(count) => {
            let part = |index| Part { index, count };
            let late = (1..=count).map(part).filter(|part| {
                let units = part.of(units);
                let after = missing.0.partition_point(|gap| *gap.end() < units.start);
                missing
                    .0
                    .get(after)
                    .is_some_and(|gap| *gap.start() < units.end)
            });
            let late: Vec<String> = late.map(|part| part.to_string()).collect();
            format!("shard {}", some(&late))
        }
        None => {
            let ranges = missing
                .0
                .iter()
                .map(|gap| Ranges(vec![gap.clone()]).to_string());
            format!("units {}", some(&ranges.collect::<Vec<_>>()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_the_numbers_that_are_not_there() {
        let of = |there: &[u64], all| gaps(there.iter().copied(), all).to_string();
        assert_eq!(of(&[1, 2, 5, 9], 8), "0,3-4,6-7");
        assert_eq!(of(&[0, 1], 2), "");
        assert_eq!(
            of(&[3], u64::MAX),
            "0-2,4-18446744073709551614",
            "as many as a report can state"
        );
    }
}
