//! `texmap merge`: the shards of a batch, checked and joined.

mod bands;
mod shards;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Component, Path, PathBuf};

use clap::Args;
use serde::Serialize;
use texmap_io::PictureFormat;
use texmap_math::parallel;

use crate::cmd::batch::files::FileMark;
use crate::cmd::batch::plan::STATE;
use crate::cmd::batch::record::{Header, Record, Status};
use crate::cmd::batch::state::State;
use crate::failure::{self, Exit, Failure, say};
use crate::output::{Destination, Stage};
use shards::{Report, read, unite};

/// Join the shards of a batch: check that they are complete and fit together, join bands to pictures, and write one report.
///
/// Refuses shards of different versions, settings or items, and units that two shards have, by name. Nothing is written then.
#[derive(Args, Debug)]
#[command(
    after_help = "One folder for all machines:    texmap merge out -o out\n\
                  A folder from each machine:     texmap merge part-1 part-2 part-3 -o out\n\
                  Exit code 75 while shards are missing, 3 when units have failed: the others are joined."
)]
pub(crate) struct MergeArgs {
    /// Folders of outputs, each with the reports of its shards, or reports (.texmap/report-I-of-N.jsonl)
    #[arg(required = true, value_name = "SHARDS")]
    shards: Vec<PathBuf>,
    /// The folder of all outputs; a batch of one picture in bands: the picture (.png)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Serialize)]
struct Merged {
    texmap: &'static str,
    verb: &'static str,
    exit: u8,
    units: u64,
    failed: Vec<String>,
    report: String,
    /// Pictures that were joined from bands.
    pictures: Vec<FileMark>,
}

/// Number of the units of the batch whose reports these are, all of them once.
pub(crate) fn units(shards: &[PathBuf]) -> Result<u64, Failure> {
    Ok(unite(&read(shards)?)?.units)
}

pub(crate) fn run(args: &MergeArgs) -> Result<Exit, Failure> {
    let reports = read(&args.shards)?;
    let header = unite(&reports)?;
    let all: Vec<(&Report, &Record)> = reports
        .iter()
        .flat_map(|report| report.records.iter().map(move |record| (report, record)))
        .collect();
    // Everything is read before anything is written.
    parallel::try_for_each(all.iter(), |(report, record)| verify(report, record))?;
    let (bands, plain): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, r)| r.band.is_some());
    let mut pictures: BTreeMap<&str, Vec<(&Report, &Record)>> = BTreeMap::new();
    for (report, record) in bands {
        if let Some(band) = &record.band {
            pictures
                .entry(&band.picture)
                .or_default()
                .push((report, record));
        }
    }
    let single = is_picture(&args.output);
    if single && (pictures.len() != 1 || !plain.is_empty()) {
        return Err(Failure::usage(
            format!(
                "-o {}: this batch is not one picture in bands",
                args.output.display()
            ),
            "name a folder",
        ));
    }
    if let Some(format) = PictureFormat::of(&args.output)
        && !single
        && !args.output.is_dir()
    {
        return Err(Failure::usage(
            format!(
                "-o {}: bands are joined to .png, and the name ends with .{}",
                args.output.display(),
                format.ending()
            ),
            "end the name with .png, or name a folder",
        ));
    }
    let base = match single {
        true => args
            .output
            .parent()
            .filter(|p| !p.as_os_str().is_empty())
            .unwrap_or(Path::new(".")),
        false => &args.output,
    };
    parallel::try_for_each(plain.iter(), |(report, record)| copy(report, record, base))?;
    let mut records: Vec<Record> = plain.iter().map(|(_, record)| (*record).clone()).collect();
    let mut joined = Vec::new();
    for (name, mut parts) in pictures {
        parts.sort_by_key(|(_, record)| record.band.as_ref().map(|band| band.index));
        let output = match (single, parts.first()) {
            (true, _) => args.output.clone(),
            (false, Some((report, record))) if leads_out(name) => {
                return Err(lost(report, record, Path::new(name), OUTSIDE));
            }
            (false, _) => base.join(name),
        };
        let Some(mut record) = bands::record(&parts) else {
            continue;
        };
        if record.status == Status::Ok {
            let mut mark = bands::join(&parts, &output)?;
            say(&format!(
                "{}: {} bands joined\n",
                output.display(),
                parts.len()
            ));
            record.pixel_hash.clone_from(&mark.pixel_hash);
            joined.push(mark.clone());
            mark.path = match single {
                true => output
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned(),
                false => name.to_owned(),
            };
            record.outputs = vec![mark];
        }
        records.push(record);
    }
    records.sort_by_key(|record| record.index);
    let failed = records.iter().filter(|record| record.status != Status::Ok);
    let failed: Vec<String> = failed.map(|record| record.id.clone()).collect();
    for id in &failed {
        say(&format!("{id}: failed, and is not joined\n"));
    }
    let exit = match failed.is_empty() {
        true => Exit::Done,
        false => Exit::Partial,
    };
    let header = Header {
        shard: "merged".to_owned(),
        folder: "..".to_owned(),
        ..header
    };
    let state = State::new(&base.join(STATE), base)?;
    let report = state.report("merged", &header, &records)?;
    say(&format!(
        "{}: {} units, {} failed\n",
        report.display(),
        records.len(),
        failed.len()
    ));
    if args.json {
        failure::print_json(&Merged {
            texmap: env!("CARGO_PKG_VERSION"),
            verb: "merge",
            exit: exit as u8,
            units: records.len() as u64,
            failed,
            report: report.display().to_string(),
            pictures: joined,
        })?;
    }
    Ok(exit)
}

fn is_picture(output: &Path) -> bool {
    let ending = output.extension().and_then(|e| e.to_str());
    ending.is_some_and(|e| e.eq_ignore_ascii_case("png")) && !output.is_dir()
}

const OUTSIDE: &str = "it lies outside of the folder of its shard";

/// True for a name that may lead out of the folder that it is joined to: a report may come from another machine.
fn leads_out(name: &str) -> bool {
    let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    !Path::new(name).components().all(plain)
}

/// Reads the outputs of a unit, which must be those that its report tells of.
fn verify(report: &Report, record: &Record) -> Result<(), Failure> {
    for output in &record.outputs {
        let path = report.folder.join(&output.path);
        let now = FileMark::of(&path).map_err(|e| lost(report, record, &path, &e.to_string()))?;
        if (now.bytes, &now.hash) != (output.bytes, &output.hash) {
            return Err(lost(
                report,
                record,
                &path,
                "it has other bytes than the report says",
            ));
        }
    }
    Ok(())
}

fn lost(report: &Report, record: &Record, path: &Path, why: &str) -> Failure {
    Failure::new(
        Exit::Input,
        "shard-output",
        format!(
            "{}: the output of {} by {}: {why}",
            path.display(),
            record.id,
            report.path.display()
        ),
        "run its shard again with --force",
    )
}

/// Copies the outputs of a unit to the folder of all, unless they lie there.
fn copy(report: &Report, record: &Record, base: &Path) -> Result<(), Failure> {
    for output in &record.outputs {
        let (from, to) = (report.folder.join(&output.path), base.join(&output.path));
        if from == to || same_file(&from, &to) {
            continue;
        }
        if leads_out(&output.path) {
            return Err(lost(report, record, &from, OUTSIDE));
        }
        let main = Destination::new(&to)?;
        let mut stage = Stage::new(&main)?;
        let ending = to
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let place = stage.add(main, &ending);
        let copied = || io::copy(&mut File::open(&from)?, &mut File::create(&place)?);
        copied().map_err(|e| {
            let what = format!("{}: cannot be written: {e}", to.display());
            Failure::new(
                Exit::Input,
                "write-failed",
                what,
                "check the permissions and the free space",
            )
        })?;
        stage.commit()?;
    }
    Ok(())
}

fn same_file(a: &Path, b: &Path) -> bool {
    fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_reports_stay_in_their_folder() {
        for name in ["a.png", "b/a.png", "./a.png"] {
            assert!(!leads_out(name), "{name}");
        }
        for name in ["../a.png", "b/../../a.png", "/a.png", ".."] {
            assert!(leads_out(name), "{name}");
        }
    }
}
