//! The command line of a batch: the settings of its verb and those of the batch.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::Resettable;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, Id};

use crate::cmd;
use crate::cmd::batch::settings::Settings;
use crate::values::{Part, Ranges};

/// A verb that can run as a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BatchVerb {
    Render,
    Uv,
    UvRaster,
    Bake,
    Warp,
    Env,
}

impl BatchVerb {
    pub(crate) const ALL: [Self; 6] = [
        Self::Render,
        Self::Uv,
        Self::UvRaster,
        Self::Bake,
        Self::Warp,
        Self::Env,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Render => "render",
            Self::Uv => "uv",
            Self::UvRaster => "uv-raster",
            Self::Bake => "bake",
            Self::Warp => "warp",
            Self::Env => "env",
        }
    }

    pub(crate) fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|verb| verb.name() == name)
    }

    /// Name of an output in a folder, without the folder.
    pub(crate) fn template(self) -> &'static str {
        match self {
            Self::Uv => "{model}.obj",
            Self::UvRaster => "{model}",
            _ => "{model}.png",
        }
    }

    /// The verb's own arguments.
    fn bare(self) -> Command {
        let command = Command::new(self.name());
        match self {
            Self::Render => cmd::render::RenderArgs::augment_args(command),
            Self::Uv => cmd::uv::UvArgs::augment_args(command),
            Self::UvRaster => cmd::uv_raster::UvRasterArgs::augment_args(command),
            Self::Bake => cmd::bake::BakeArgs::augment_args(command),
            Self::Warp => cmd::warp::WarpArgs::augment_args(command),
            Self::Env => cmd::env::EnvArgs::augment_args(command),
        }
    }

    /// The arguments that are settings of an item.
    pub(crate) fn settings(self) -> impl Iterator<Item = Arg> {
        let all: Vec<Arg> = self.bare().get_arguments().cloned().collect();
        all.into_iter()
            .filter(|arg| !arg.is_positional() && !NO_SETTINGS.contains(&arg.get_id().as_str()))
    }

    /// True if the verb takes a number of threads.
    pub(crate) fn has_threads(self) -> bool {
        self.bare()
            .get_arguments()
            .any(|arg| arg.get_id() == THREADS)
    }

    /// The command of a batch of this verb. An item is checked as a whole by the verb itself: the settings may come from a manifest.
    pub(crate) fn command(self) -> Command {
        let bare = self.bare();
        let has = |id: &str| bare.get_arguments().any(|arg| arg.get_id() == id);
        let (threads, dry_run) = (has(THREADS), has(DRY_RUN));
        let mut command = bare.after_help("").mut_args(|arg| {
            let arg = arg
                .required(false)
                .required_unless_present(Resettable::<Id>::Reset)
                .conflicts_with(Resettable::<Id>::Reset)
                .requires(Resettable::<Id>::Reset);
            match arg.get_id().as_str() {
                "output" => output(),
                "json" => arg.help("Print lines of JSON also where standard output is a terminal"),
                "threads" => arg.help("Threads of a job [default: the cores divided by --jobs]"),
                _ if arg.is_positional() => items(arg),
                _ => arg,
            }
        });
        if !threads {
            let words = "Threads of a job [default: the cores divided by --jobs]";
            let arg = Arg::new(THREADS).long(THREADS).value_name("N").help(words);
            command = command.arg(arg.value_parser(clap::value_parser!(u16).range(1..=1024)));
        }
        if !dry_run {
            let words = "Check everything and print the plan; write nothing";
            let arg = Arg::new(DRY_RUN).long("dry-run").action(ArgAction::SetTrue);
            command = command.arg(arg.help(words));
        }
        BatchFlags::augment_args(command)
            .about(format!("The items of a batch of `{}`", self.name()))
    }
}

const THREADS: &str = "threads";
const DRY_RUN: &str = "dry_run";

/// Arguments that the batch itself reads.
const NO_SETTINGS: [&str; 8] = [
    "output", "json", THREADS, DRY_RUN, "help", "version", "only", "band",
];

fn output() -> Arg {
    Arg::new("output")
        .short('o')
        .long("output")
        .value_name("OUT")
        .help("The output of each item: a folder, or a name with {model} or {dir}, the input's name and folder, or {id}, the item's; not \
               for manifests that name outputs")
}

/// The positional argument of a verb, for many inputs.
fn items(arg: Arg) -> Arg {
    arg.num_args(1..)
        .action(ArgAction::Append)
        .required(true)
        .value_name("ITEMS")
        .value_parser(clap::value_parser!(PathBuf))
        .help("Files, @LIST for a file that names one a line, or a manifest (.json; docs/batch.md has its schema)")
}

/// Shard of this task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShardArg {
    Part(Part),
    /// The engine tells.
    Auto,
}

impl FromStr for ShardArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => text
                .parse()
                .map(Self::Part)
                .map_err(|e| format!("{e}, or auto")),
        }
    }
}

/// Things that are given out to shards and jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum UnitName {
    /// All pictures of an input
    Item,
    /// Each picture of --turntable, --frames or --cameras
    Frame,
    /// Each picture of --views
    View,
    /// Each object of `bake --object all`
    Page,
}

/// Settings of a batch.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Batch")]
pub(crate) struct BatchFlags {
    /// Run shard I of N alone, of the units sorted by id; auto takes the number from the engine that started this task: Slurm,
    /// HyperQueue, Kubernetes, AWS Batch, PBS, SGE, LSF or GNU parallel
    #[arg(long, value_name = "I/N|auto", conflicts_with = "range")]
    pub(crate) shard: Option<ShardArg>,
    /// The number of shards, where the engine does not tell it
    #[arg(long, value_name = "N", requires = "shard", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) shard_count: Option<u32>,
    /// Run these units alone, by their number in the order of ids, from 0: 0-99,200
    #[arg(long, value_name = "LIST")]
    pub(crate) range: Option<Ranges>,
    /// Things that are given out to shards and jobs
    #[arg(long, value_name = "NAME", default_value = "item")]
    pub(crate) unit: UnitName,
    /// Give out bands of each picture: N of them, rows of tiles, which `texmap merge` joins to the bytes of a single run. Pictures
    /// are .png
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub(crate) bands: Option<u32>,
    /// Skip units that are complete: drawn by this version with these settings from inputs of the same bytes
    #[arg(long)]
    pub(crate) resume: bool,
    /// Run everything, whatever --resume says
    #[arg(long)]
    pub(crate) force: bool,
    /// Start nothing more once a unit has failed
    #[arg(long)]
    pub(crate) fail_fast: bool,
    /// Tasks at a time, each in a process of its own [default: a task for each core, fewer if there are fewer tasks]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// The folder of markers and reports [default: .texmap in the folder of the outputs]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
}

/// A parsed command line.
#[derive(Clone, Debug)]
pub(crate) struct BatchArgs {
    pub(crate) verb: BatchVerb,
    pub(crate) inputs: Vec<PathBuf>,
    pub(crate) output: Option<PathBuf>,
    pub(crate) settings: Settings,
    pub(crate) threads: Option<u16>,
    pub(crate) json: bool,
    pub(crate) dry_run: bool,
    pub(crate) flags: BatchFlags,
}

/// The verb of a command line, and its arguments.
pub(crate) fn verb_of(matches: &ArgMatches) -> Result<(BatchVerb, &ArgMatches), clap::Error> {
    let missing = || clap::Error::new(clap::error::ErrorKind::MissingSubcommand);
    let (name, matches) = matches.subcommand().ok_or_else(missing)?;
    Ok((BatchVerb::of(name).ok_or_else(missing)?, matches))
}

impl FromArgMatches for BatchArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let (verb, matches) = verb_of(matches)?;
        let bare = verb.bare();
        let positional = bare.get_positionals().next().map(Arg::get_id);
        let inputs = positional.and_then(|id| matches.get_many::<PathBuf>(id.as_str()));
        let mut settings = Settings::default();
        for arg in verb.settings() {
            let id = arg.get_id().as_str();
            if matches.value_source(id) == Some(ValueSource::CommandLine) {
                settings.take(&arg, matches);
            }
        }
        Ok(Self {
            verb,
            inputs: inputs.into_iter().flatten().cloned().collect(),
            output: matches.get_one::<String>("output").map(PathBuf::from),
            settings,
            threads: matches.get_one::<u16>(THREADS).copied(),
            json: matches.get_flag("json"),
            dry_run: matches.get_flag(DRY_RUN),
            flags: BatchFlags::from_arg_matches(matches)?,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for BatchArgs {
    fn augment_args(command: Command) -> Command {
        command
            .subcommand_required(true)
            .subcommands(BatchVerb::ALL.map(BatchVerb::command))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    use crate::args::{Cli, Verb};

    fn parsed(line: &str) -> BatchArgs {
        let cli = Cli::try_parse_from(line.split_whitespace()).unwrap();
        match cli.verb {
            Verb::Batch(args) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn settings_of_the_verb_are_kept_in_the_order_of_their_names() {
        let args = parsed(
            "texmap batch render a.obj b.obj -o out/ --views front,top --strict --camera-eye -1,2,3 --shard 2/3 --threads 4",
        );
        assert_eq!(args.inputs.len(), 2);
        assert_eq!(args.threads, Some(4));
        assert_eq!(
            args.flags.shard,
            Some(ShardArg::Part(Part { index: 2, count: 3 }))
        );
        assert_eq!(
            args.settings.words(),
            ["--camera-eye=-1,2,3", "--strict", "--views=front,top"]
        );
    }

    #[test]
    fn values_of_several_words_stay_together() {
        let args = parsed("texmap batch warp a.png -o out/ --to 0,0 9,0 9,9 0,9 --filter nearest");
        assert_eq!(
            args.settings.words(),
            ["--filter=nearest", "--to", "0,0", "9,0", "9,9", "0,9"]
        );
    }

    #[test]
    fn every_verb_makes_a_command() {
        for verb in BatchVerb::ALL {
            assert_eq!(BatchVerb::of(verb.name()), Some(verb));
            verb.command().debug_assert();
        }
        assert!(Cli::try_parse_from(["texmap", "batch", "info", "a"]).is_err());
    }
}
