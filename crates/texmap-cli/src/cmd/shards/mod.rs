//! `texmap shards`: the tasks of a batch with their memory and time, ready to submit.

mod emit;
mod estimate;
mod textures;

use clap::{ArgMatches, Args, Command, FromArgMatches};
use serde::Serialize;

use crate::cmd::batch::BatchArgs;
use crate::cmd::batch::args::{BatchVerb, UnitName, verb_of};
use crate::cmd::batch::plan::Plan;
use crate::failure::{self, Exit, Failure};
use crate::memory;
use crate::values::Part;
use emit::Emit;
use estimate::Estimate;

#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Shards")]
pub(crate) struct ShardsFlags {
    /// The number of tasks
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// The form of the tasks
    #[arg(long, value_name = "FORM", default_value = "json")]
    emit: Emit,
}

/// A parsed command line.
#[derive(Clone, Debug)]
pub(crate) struct ShardsArgs {
    pub(crate) batch: BatchArgs,
    flags: ShardsFlags,
}

impl FromArgMatches for ShardsArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let (_, of_verb) = verb_of(matches)?;
        Ok(Self {
            batch: BatchArgs::from_arg_matches(matches)?,
            flags: ShardsFlags::from_arg_matches(of_verb)?,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for ShardsArgs {
    fn augment_args(command: Command) -> Command {
        let verbs = BatchVerb::ALL.map(|verb| ShardsFlags::augment_args(verb.command()));
        command.subcommand_required(true).subcommands(verbs)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// A task of the batch.
#[derive(Clone, Debug, Serialize)]
struct Task {
    shard: String,
    units: u64,
    /// First and last of its units.
    #[serde(skip_serializing_if = "Option::is_none")]
    ids: Option<[String; 2]>,
    /// Command line of the program.
    command: Vec<String>,
    #[serde(flatten)]
    estimate: Estimate,
}

/// All tasks of a batch.
#[derive(Clone, Debug, Serialize)]
struct Tasks {
    texmap: &'static str,
    verb: &'static str,
    units: u64,
    count: u32,
    /// Cores that a task takes.
    cores: u32,
    /// Means of the largest task.
    largest: Estimate,
    /// Seconds of one core for all tasks.
    core_seconds: f64,
    tasks: Vec<Task>,
    /// The command line but for the shard.
    #[serde(skip)]
    command: Vec<String>,
}

pub(crate) fn run(args: &ShardsArgs) -> Result<Exit, Failure> {
    let batch = &args.batch;
    if batch.flags.shard.is_some() || batch.flags.range.is_some() {
        return Err(Failure::usage(
            "--shard and --range belong to `texmap batch`",
            "`texmap shards` cuts the whole batch into --count tasks",
        ));
    }
    let plan = Plan::new(batch)?;
    let command = command(batch);
    let count = args.flags.count;
    let costs = estimate::of_units(&plan);
    let task = |index: u32| {
        let part = Part { index, count };
        let range = part.of(plan.units.len() as u64);
        let own = &plan.units[range.start as usize..range.end as usize];
        let ends = own.first().zip(own.last());
        Task {
            shard: part.to_string(),
            units: own.len() as u64,
            ids: ends.map(|(first, last)| [first.id.clone(), last.id.clone()]),
            command: [command.clone(), vec![format!("--shard={part}")]].concat(),
            estimate: Estimate::sum(
                &costs[range.start as usize..range.end as usize],
                jobs(batch),
                memory::given(),
            ),
        }
    };
    let tasks: Vec<Task> = (1..=count).map(task).collect();
    let tasks = Tasks {
        texmap: env!("CARGO_PKG_VERSION"),
        verb: plan.verb.name(),
        units: plan.units.len() as u64,
        count,
        cores: u32::from(jobs(batch)) * u32::from(threads(batch)),
        largest: Estimate::largest(tasks.iter().map(|task| task.estimate)),
        core_seconds: tasks.iter().map(|task| task.estimate.core_seconds).sum(),
        tasks,
        command,
    };
    match args.flags.emit {
        Emit::Json => failure::print_json(&tasks)?,
        form => failure::print(&emit::text(form, &tasks))?,
    }
    Ok(Exit::Done)
}

fn jobs(batch: &BatchArgs) -> u16 {
    batch.flags.jobs.unwrap_or(1)
}

fn threads(batch: &BatchArgs) -> u16 {
    batch.threads.unwrap_or(1)
}

/// The command line of the batch, which resumes and lacks its shard.
fn command(batch: &BatchArgs) -> Vec<String> {
    let mut words = vec![
        "texmap".to_owned(),
        "batch".to_owned(),
        batch.verb.name().to_owned(),
    ];
    let text = |path: &std::path::PathBuf| path.to_string_lossy().into_owned();
    words.extend(batch.inputs.iter().map(text));
    if let Some(output) = &batch.output {
        words.push(format!("--output={}", text(output)));
    }
    words.extend(batch.settings.words());
    let flags = &batch.flags;
    let unit = match flags.unit {
        UnitName::Item => None,
        UnitName::Frame => Some("frame"),
        UnitName::View => Some("view"),
        UnitName::Page => Some("page"),
    };
    let options = [
        ("unit", unit.map(str::to_owned)),
        ("bands", flags.bands.map(|n| n.to_string())),
        // An engine counts cores: without these a task would take all of its machine.
        ("jobs", Some(jobs(batch).to_string())),
        ("threads", Some(threads(batch).to_string())),
        ("memory-limit", memory::given().map(|n| n.to_string())),
        ("state", flags.state.as_ref().map(text)),
    ];
    for (name, value) in options {
        words.extend(value.map(|value| format!("--{name}={value}")));
    }
    words.push("--resume".to_owned());
    words
}
