//! A batch from its plan to its report.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::IsTerminal;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use texmap_io::IoError;
use texmap_math::MemoryBudget;
use texmap_math::parallel;

use crate::cmd::batch::args::BatchArgs;
use crate::cmd::batch::files::Marks;
use crate::cmd::batch::plan::{Plan, Unit, UnitPart};
use crate::cmd::batch::pool::{self, Ended, Job, Means};
use crate::cmd::batch::record::{BandMark, Header, Record, SCHEMA, Status, Summary, VERSION};
use crate::cmd::batch::shard::Shard;
use crate::cmd::batch::state::State;
use crate::cmd::batch::worker::Outcome;
use crate::failure::{self, Exit, Failure, say};
use crate::memory;
use crate::output::{distinct, sweep};
use crate::progress::Progress;

pub(crate) fn run(args: &BatchArgs) -> Result<Exit, Failure> {
    let began = Instant::now();
    let shard = Shard::of(&args.flags, &|name| std::env::var(name).ok())?;
    let plan = Plan::new(args)?;
    let wanted = shard.units(plan.units.len())?;
    let units: Vec<(usize, &Unit)> = wanted.iter().map(|at| (*at, &plan.units[*at])).collect();
    // Names from the folder of the outputs lead nowhere else.
    let outputs: BTreeSet<String> = units.iter().map(|(_, unit)| plan.output(unit)).collect();
    let inputs: BTreeSet<&String> = units
        .iter()
        .map(|(_, unit)| &plan.item(unit).input)
        .collect();
    distinct(plan.files(&units)?, inputs)?;
    let lines = args.json || !std::io::stdout().is_terminal();
    if args.dry_run {
        return dry_run(&plan, &units);
    }
    let state = State::new(&plan.state, &plan.base)?;
    let marks = Marks::default();
    let resumed = match args.flags.resume && !args.flags.force {
        true => complete(&plan, &units, &state, &marks, &outputs),
        false => BTreeMap::new(),
    };
    let left: Vec<(usize, &Unit)> = units
        .iter()
        .filter(|(at, _)| !resumed.contains_key(at))
        .copied()
        .collect();
    let means = means(args, left.len());
    let mut run = Run {
        plan: &plan,
        state: &state,
        lines,
        progress: Progress::of_items(args.verb.name(), units.len() as u64),
        records: BTreeMap::new(),
        skipped: resumed.len() as u64,
        done: 0,
        failures: Vec::new(),
        codes: BTreeSet::new(),
    };
    for (at, mut record) in resumed {
        record.index = at as u64;
        run.tell(record, true)?;
    }
    let jobs = jobs(&plan, &left, means);
    let fail_fast = args.flags.fail_fast;
    let outcome = pool::run(jobs, means, fail_fast, |unit, ended| run.ended(unit, ended));
    drop(std::mem::replace(&mut run.progress, Progress::hidden()));
    outcome?;
    run.finish(&shard, units.len() as u64, means, began)
}

/// Prints the units without running them. One whose input is no file would fail.
fn dry_run(plan: &Plan, units: &[(usize, &Unit)]) -> Result<Exit, Failure> {
    let mut lost = 0;
    for (at, unit) in units {
        let mut record = blank(plan, unit, *at);
        record.status = Status::Planned;
        if let Some(failure) = missing(Path::new(&record.input)) {
            failure.report(false);
            record.status = Status::Failed;
            record.code = failure.exit as u8;
            record.error = serde_json::to_value(failure.body()).ok();
            lost += 1;
        }
        let line = Planned {
            record,
            output: plan.output(unit),
        };
        failure::print_json_line(&line)?;
    }
    Ok(match lost {
        0 => Exit::Done,
        all if all == units.len() => Exit::Input,
        _ => Exit::Partial,
    })
}

fn missing(input: &Path) -> Option<Failure> {
    let (path, named_by) = (input.to_owned(), None);
    match fs::metadata(input) {
        Ok(metadata) if !metadata.is_dir() => None,
        Ok(_) => Some(IoError::NotAFile { path, named_by }.into()),
        Err(_) => Some(IoError::FileMissing { path, named_by }.into()),
    }
}

#[derive(Serialize)]
struct Planned {
    #[serde(flatten)]
    record: Record,
    output: String,
}

/// The units of a shard that need not be run again.
fn complete(
    plan: &Plan,
    units: &[(usize, &Unit)],
    state: &State,
    marks: &Marks,
    outputs: &BTreeSet<String>,
) -> BTreeMap<usize, Record> {
    // Stages of a run that was killed lie beside outputs that nobody writes again.
    let folders: BTreeSet<&Path> = outputs
        .iter()
        .filter_map(|o| Path::new(o).parent())
        .collect();
    folders.into_iter().for_each(sweep);
    let complete = parallel::map(units.iter(), |(at, unit)| {
        let hash = plan.hash_of_settings(unit);
        let record = state.complete(&unit.id, &plan.output(unit), &hash, marks)?;
        Some((*at, record))
    });
    complete.into_iter().flatten().collect()
}

/// Processes, threads and memory of a run of so many units.
fn means(args: &BatchArgs, units: usize) -> Means {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = args.flags.jobs.map_or(cores, usize::from).min(units).max(1);
    let threads = args.threads.unwrap_or((cores / jobs).max(1) as u16);
    let shared = match MemoryBudget::of_process().limit() {
        u64::MAX => None,
        limit => Some(limit / jobs as u64),
    };
    Means {
        jobs,
        threads,
        memory: memory::given().or(shared),
    }
}

/// The tasks of units in order. Pictures of one input are one task, or as many as there are processes: each loads the input once.
fn jobs(plan: &Plan, units: &[(usize, &Unit)], means: Means) -> Vec<Job> {
    let picture = |unit: &Unit| match unit.part {
        UnitPart::Picture(number) => Some(number),
        _ => None,
    };
    let together = units.chunk_by(|(_, a), (_, b)| {
        a.item == b.item && picture(a).is_some() && picture(b).is_some()
    });
    let groups: Vec<&[(usize, &Unit)]> = together.collect();
    let parts = means.jobs.div_ceil(groups.len().max(1));
    let parts = groups
        .iter()
        .flat_map(|group| group.chunks(group.len().div_ceil(parts).max(1)));
    parts
        .map(|part| {
            let units: Vec<&Unit> = part.iter().map(|(_, unit)| *unit).collect();
            let numbers = part
                .iter()
                .map(|(at, unit)| (*at, picture(unit).unwrap_or_default()));
            Job {
                words: plan.words(&units, means.threads),
                units: numbers.collect(),
            }
        })
        .collect()
}

/// A record of a unit that has not run.
fn blank(plan: &Plan, unit: &Unit, at: usize) -> Record {
    Record {
        id: unit.id.clone(),
        index: at as u64,
        status: Status::Ok,
        code: 0,
        input: plan.item(unit).input.clone(),
        outputs: Vec::new(),
        pixel_hash: None,
        band: None,
        warnings: Vec::new(),
        error: None,
        ms: 0.0,
        peak_bytes: None,
        settings_hash: plan.hash_of_settings(unit),
        texmap: VERSION.to_owned(),
    }
}

/// A run under way.
struct Run<'a> {
    plan: &'a Plan,
    state: &'a State,
    lines: bool,
    progress: Progress,
    records: BTreeMap<u64, Record>,
    skipped: u64,
    done: u64,
    failures: Vec<Exit>,
    /// Exit codes of units that are written.
    codes: BTreeSet<u8>,
}

#[derive(Serialize)]
struct Line<'a> {
    #[serde(flatten)]
    record: &'a Record,
    /// Complete before this run.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    resumed: bool,
}

impl Run<'_> {
    /// Takes the end of a unit.
    fn ended(&mut self, at: usize, ended: Ended) -> Result<(), Failure> {
        let unit = &self.plan.units[at];
        let mut record = blank(self.plan, unit, at);
        let mut failed = None;
        match ended {
            Ended::Told(outcome) => {
                if let Some(failure) = self.told(unit, &mut record, outcome)? {
                    failed = Some(failure);
                }
            }
            Ended::Gone {
                code,
                what,
                outside,
            } => {
                record.code = code;
                record.status = if outside {
                    Status::Killed
                } else {
                    Status::Failed
                };
                let what = format!("{}: {what}", unit.id);
                let failure = match outside {
                    true => Failure::new(
                        Exit::Again,
                        "killed",
                        what,
                        "memory may have been short: run again with --resume, and with fewer --jobs or a smaller --memory-limit",
                    ),
                    false => Failure::internal(what),
                };
                record.error = serde_json::to_value(failure.body()).ok();
                failed = Some(failure);
            }
        }
        if let Some(failure) = &failed {
            self.state.unmark(&unit.id);
            failure.report(false);
            self.failures.push(failure.exit);
        } else {
            self.done += 1;
        }
        self.tell(record, false)
    }

    /// Fills the record of a unit whose process told its end, and marks it if it is complete.
    fn told(
        &self,
        unit: &Unit,
        record: &mut Record,
        outcome: Outcome,
    ) -> Result<Option<Failure>, Failure> {
        record.code = outcome.code;
        record.ms = outcome.ms;
        record.peak_bytes = outcome.peak_bytes;
        record.warnings = outcome.warnings;
        record.pixel_hash = outcome.pixel_hash;
        record.error = outcome.error;
        record.outputs = outcome.outputs;
        for output in &mut record.outputs {
            output.path = self.state.relative(Path::new(&output.path));
        }
        if let UnitPart::Band(part) = &unit.part {
            record.band = Some(BandMark {
                picture: self.picture(unit),
                index: part.index,
                count: part.count,
            });
        }
        let error = record.error.as_ref();
        let text = |field: &str| {
            let value = error.and_then(|e| e[field].as_str());
            value.unwrap_or_default().to_owned()
        };
        if error.is_some() {
            record.status = Status::Failed;
            let exit = exit_of(record.code);
            return Ok(Some(Failure::new(
                exit,
                &text("code"),
                text("what"),
                text("why"),
            )));
        }
        let output = self.plan.output(unit);
        self.state.mark(record, &output, outcome.inputs)?;
        Ok(None)
    }

    /// The picture of a band, named from the folder of the outputs.
    fn picture(&self, unit: &Unit) -> String {
        let output = Path::new(&self.plan.item(unit).output);
        let inside = output.strip_prefix(&self.plan.base).unwrap_or(output);
        inside.to_string_lossy().into_owned()
    }

    /// Prints the line of a unit and keeps its record.
    fn tell(&mut self, record: Record, resumed: bool) -> Result<(), Failure> {
        if self.lines {
            let record = &record;
            failure::print_json_line(&Line { record, resumed })?;
        }
        if record.status == Status::Ok {
            self.codes.insert(record.code);
        }
        self.records.insert(record.index, record);
        self.progress.count(self.records.len() as u64);
        Ok(())
    }

    /// Writes the report and prints the summary.
    fn finish(
        self,
        shard: &Shard,
        units: u64,
        means: Means,
        began: Instant,
    ) -> Result<Exit, Failure> {
        let header = Header {
            texmap: VERSION.to_owned(),
            schema: SCHEMA,
            verb: self.plan.verb.name().to_owned(),
            shard: match shard {
                Shard::Part(part) => part.to_string(),
                Shard::Ranges(ranges) => ranges.to_string(),
            },
            folder: self.plan.folder_of_report(),
            units: self.plan.units.len() as u64,
            units_hash: self.plan.units_hash.clone(),
            settings_hash: self.plan.settings_hash.clone(),
        };
        let report = self
            .state
            .report(&shard.name(), &header, self.records.values())?;
        let exit = self.exit(units);
        let count = |status| self.records.values().filter(|r| r.status == status).count() as u64;
        let summary = Summary {
            texmap: VERSION,
            shard: header.shard,
            units,
            done: self.done,
            skipped: self.skipped,
            failed: count(Status::Failed),
            killed: count(Status::Killed),
            waiting: units - self.records.len() as u64,
            ms: began.elapsed().as_micros() as f64 / 1e3,
            jobs: means.jobs,
            threads: means.threads,
            exit: exit as u8,
            report: Some(report.display().to_string()),
        };
        if self.lines {
            failure::print_json_line(&serde_json::json!({ "summary": summary }))?;
        }
        say(&format!(
            "{} of {units} done, {} complete before, {} failed, {} killed, {} not started, in {:.1} s; report: {}\n",
            summary.done,
            summary.skipped,
            summary.failed,
            summary.killed,
            summary.waiting,
            summary.ms / 1e3,
            report.display(),
        ));
        Ok(exit)
    }

    fn exit(&self, units: u64) -> Exit {
        let good = self.done + self.skipped;
        match self.failures.first() {
            Some(_) if self.failures.contains(&Exit::Again) => Exit::Again,
            Some(first) if good == 0 && self.failures.len() as u64 == units => match first {
                // Those of a batch mean that something is written.
                Exit::OverBudget | Exit::Differs | Exit::Partial => Exit::Input,
                first => *first,
            },
            Some(_) => Exit::Partial,
            None if self.codes.contains(&(Exit::OverBudget as u8)) => Exit::OverBudget,
            None if self.codes.contains(&(Exit::Differs as u8)) => Exit::Differs,
            None => Exit::Done,
        }
    }
}

/// The exit of a code that a verb ended with.
fn exit_of(code: u8) -> Exit {
    [
        Exit::Differs,
        Exit::Usage,
        Exit::Partial,
        Exit::Input,
        Exit::OverBudget,
    ]
    .into_iter()
    .find(|exit| *exit as u8 == code)
    .unwrap_or(Exit::Internal)
}
