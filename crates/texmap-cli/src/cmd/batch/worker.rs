//! A process that runs tasks of a batch: a line of JSON in for each, lines of JSON out.
//!
//! Each task is a command line of a verb, run by the verb's own code. If a task breaks, the process goes and the batch stays.

use std::collections::BTreeSet;
use std::io::{self, BufRead, Write};
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Instant;

use clap::{Args, Parser};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use texmap_io::PictureFormat;
use texmap_truth::buffer::Buffer;

use crate::args::Cli;
use crate::cmd::batch::files::{FileMark, Marks};
use crate::failure::{Exit, Failure};
use crate::observe::Seen;
use crate::{dispatch, interrupt, memory, observe};

/// The process of a job of `texmap batch`.
#[derive(Args, Debug)]
pub(crate) struct WorkerArgs {
    #[arg(long)]
    threads: usize,
}

/// A line to a worker.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Task {
    pub(crate) words: Vec<String>,
}

/// A line from a worker.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Answer {
    /// A picture of a series is written.
    Picture(u32, Outcome),
    /// The task has ended.
    End(Outcome),
}

/// The outcome of a task, or of a picture of it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Outcome {
    /// Exit code of the verb.
    pub(crate) code: u8,
    pub(crate) error: Option<Value>,
    pub(crate) outputs: Vec<FileMark>,
    pub(crate) inputs: Vec<FileMark>,
    pub(crate) pixel_hash: Option<String>,
    pub(crate) warnings: Vec<String>,
    pub(crate) ms: f64,
    pub(crate) peak_bytes: Option<u64>,
}

/// True while a task runs.
static BUSY: AtomicBool = AtomicBool::new(false);
/// True once standard input has ended.
static ENDED: AtomicBool = AtomicBool::new(false);

pub(crate) fn run(args: &WorkerArgs) -> Result<Exit, Failure> {
    let _ = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.max(1))
        .build_global();
    let (send, tasks) = mpsc::channel();
    thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if send.send(line).is_err() {
                break;
            }
        }
        ENDED.store(true, Ordering::SeqCst);
        // The batch is gone: nobody waits for the task.
        if BUSY.load(Ordering::SeqCst) {
            interrupt::end(143);
        }
    });
    let marks = Arc::new(Marks::default());
    for line in tasks {
        BUSY.store(true, Ordering::SeqCst);
        if ENDED.load(Ordering::SeqCst) {
            break;
        }
        let task: Task = serde_json::from_str(&line)
            .map_err(|e| Failure::internal(format!("a task that cannot be read: {e}")))?;
        let outcome = perform(&task, &marks);
        BUSY.store(false, Ordering::SeqCst);
        answer(&Answer::End(outcome));
    }
    Ok(Exit::Done)
}

/// Writes an answer; a batch that is gone gets none.
fn answer(answer: &Answer) {
    if let Ok(text) = serde_json::to_string(answer) {
        let mut out = io::stdout().lock();
        let _ = writeln!(out, "{text}").and_then(|()| out.flush());
    }
}

/// Time and memory since the last look.
struct Meter {
    began: Instant,
}

impl Meter {
    fn new() -> Self {
        memory::forget_peak();
        Self {
            began: Instant::now(),
        }
    }

    fn read(&mut self, outcome: &mut Outcome) {
        outcome.ms = self.began.elapsed().as_micros() as f64 / 1e3;
        outcome.peak_bytes = memory::peak();
        *self = Self::new();
    }
}

fn perform(task: &Task, marks: &Arc<Marks>) -> Outcome {
    let mut meter = Meter::new();
    let mut each_meter = Meter::new();
    let (words, kept) = (task.words.clone(), Arc::clone(marks));
    let each = move |report: Value, seen: Seen| {
        let mut outcome = outcome(&words, &kept, std::slice::from_ref(&report), seen);
        each_meter.read(&mut outcome);
        let number = report["frame"].as_u64().unwrap_or_default();
        answer(&Answer::Picture(number as u32, outcome));
    };
    let verb = || match Cli::try_parse_from(&task.words) {
        Ok(cli) => dispatch(cli.verb),
        Err(refusal) => Err(Failure::from(refusal)),
    };
    let (result, seen) = observe::during(each, || panic::catch_unwind(AssertUnwindSafe(verb)));
    let result = result.unwrap_or_else(|_| Err(Failure::internal("the task stopped")));
    let report = seen.report.clone().unwrap_or_default();
    let items = report["items"].as_array().cloned();
    let reports = items.unwrap_or_else(|| vec![report]);
    let mut outcome = outcome(&task.words, marks, &reports, seen);
    match result {
        Ok(exit) => outcome.code = exit as u8,
        Err(failure) => {
            outcome.code = failure.exit as u8;
            outcome.error = serde_json::to_value(failure.body()).ok();
        }
    }
    meter.read(&mut outcome);
    outcome
}

/// The outcome by the traces of a verb; `reports` are those of its pictures.
fn outcome(words: &[String], marks: &Marks, reports: &[Value], seen: Seen) -> Outcome {
    let mut outputs = Vec::new();
    for path in &seen.written {
        let Ok(mut mark) = FileMark::of(path) else {
            continue;
        };
        mark.pixel_hash = pixel_hash(path, reports);
        outputs.push(mark);
    }
    let mut warnings: Vec<String> = Vec::new();
    let reported = reports
        .iter()
        .filter_map(|report| report["warnings"].as_array());
    let reported: Vec<&Value> = reported.flatten().collect();
    let told = reported
        .iter()
        .filter_map(|w| w.as_str().map(str::to_owned));
    // Verbs without a list in their report say theirs.
    let said = seen.warnings.into_iter().filter(|_| reported.is_empty());
    for warning in told.chain(said) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    let pictures: Vec<&String> = outputs
        .iter()
        .filter_map(|o| o.pixel_hash.as_ref())
        .collect();
    Outcome {
        pixel_hash: match pictures[..] {
            [one] => Some(one.clone()),
            _ => None,
        },
        inputs: inputs(words, seen.read)
            .iter()
            .filter_map(|path| marks.of(path))
            .collect(),
        outputs,
        warnings,
        ..Outcome::default()
    }
}

/// Files that were read, and those that the command line names.
fn inputs(words: &[String], mut read: BTreeSet<PathBuf>) -> BTreeSet<PathBuf> {
    for word in words.iter().skip(2) {
        let value = match word
            .strip_prefix("--")
            .and_then(|flag| flag.split_once('='))
        {
            Some(("output", _)) => continue,
            Some((_, value)) => value,
            None => word,
        };
        if Path::new(value).is_file() {
            read.insert(value.into());
        }
    }
    read
}

/// Hash of the decoded pixels of an output: the renderer tells it, other pictures are read again.
fn pixel_hash(path: &Path, reports: &[Value]) -> Option<String> {
    PictureFormat::of(path)?;
    let same = |report: &&Value| {
        let output = report["output"].as_str().unwrap_or_default();
        std::fs::canonicalize(output).ok() == std::fs::canonicalize(path).ok()
    };
    let told = reports.iter().find(same);
    match told.and_then(|report| report["pixel_hash"].as_str()) {
        Some(hash) => Some(hash.to_owned()),
        None => Buffer::read(path).ok().map(|buffer| buffer.hash()),
    }
}
