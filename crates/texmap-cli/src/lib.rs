//! The program `texmap` as a library: [`main`], and [`run_program`] for arguments of one's own.
//!
//! Conventions: data goes to standard output, words and progress to standard error. Every file
//! is written under a temporary name and renamed. Exit codes: 0 done, 1 a comparison or claim
//! failed, 2 usage, 3 some of several items failed, 4 bad input or output, 5 over a budget (of
//! memory too), 6 internal error, 75 not complete yet; 129, 130 and 143 after SIGHUP, SIGINT and SIGTERM.
#![forbid(unsafe_code)]

use std::ffi::OsString;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Verb};
use crate::failure::{Exit, Failure};

pub use allocator::Allocator;
pub use planned::{batch_units, merged_units};

mod allocator;
mod args;
mod cmd;
mod digits;
mod failure;
mod formats;
mod interrupt;
mod levels;
mod memory;
mod observe;
mod os_name;
mod output;
mod picture;
mod planned;
mod progress;
mod values;

/// Names the words that start this program again, for the processes of `texmap batch`; without them they are started from the executable
/// of this process. A Python package names its interpreter, `-m` and itself. Only the first call counts.
pub fn started_by(words: Vec<OsString>) {
    cmd::batch::started_by(words);
}

/// Runs the program on the arguments of this process and returns its exit code.
#[must_use]
pub fn main() -> ExitCode {
    allocator::start_within_limits();
    let arguments: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(run_program(&arguments))
}

/// Runs the program on `arguments`, the first of which is its name, and returns its exit code: for processes that hold it beside
/// something else. It takes over the signals and the panic hook of the process.
#[must_use]
pub fn run_program(arguments: &[OsString]) -> u8 {
    let exit = guarded(|| {
        interrupt::watch();
        run(arguments)
    });
    interrupt::stop_if_ending();
    exit as u8
}

fn run(arguments: &[OsString]) -> Exit {
    let arguments = &cmd::batch::with_verb(arguments.to_vec());
    let (json, result) = match Cli::try_parse_from(arguments) {
        Ok(cli) => {
            memory::set_budget(cli.memory_limit);
            failure::set_quiet(cli.quiet);
            (cli.verb.json(), dispatch(cli.verb))
        }
        Err(refusal) => {
            if !refusal.use_stderr() {
                // `--help` and `--version` are answers, not errors.
                let printed = failure::print(&refusal.render().to_string());
                (false, printed.map(|()| Exit::Done))
            } else {
                let json = arguments.iter().any(|a| a == "--json");
                (json, Err(Failure::from(refusal)))
            }
        }
    };
    result.unwrap_or_else(|failure| {
        failure.report(json);
        failure.exit
    })
}

/// Runs a verb.
pub(crate) fn dispatch(verb: Verb) -> Result<Exit, Failure> {
    match verb {
        Verb::Render(args) => cmd::render::run(&args),
        Verb::Info(args) => cmd::info::run(&args),
        Verb::Demo(args) => cmd::demo::run(&args),
        Verb::Diff(args) => cmd::diff::run(&args),
        Verb::Hash(args) => cmd::hash::run(&args),
        Verb::Uv(args) => cmd::uv::run(&args),
        Verb::UvRaster(args) => cmd::uv_raster::run(&args),
        Verb::Warp(args) => cmd::warp::run(&args),
        Verb::Sample(args) => cmd::sample::run(&args),
        Verb::Mip(args) => cmd::mip::run(&args),
        #[cfg(feature = "gpu-images")]
        Verb::Compress(args) => cmd::compress::run(&args),
        #[cfg(not(feature = "gpu-images"))]
        Verb::Compress(args) => cmd::left_out::run(&args),
        Verb::Stability(args) => cmd::stability::run(&args),
        Verb::Chart(args) => cmd::chart::run(&args),
        Verb::Env(args) => cmd::env::run(&args),
        Verb::Bake(args) => cmd::bake::run(&args),
        Verb::Depth(args) => cmd::depth::run(&args),
        Verb::Slice(args) => cmd::slice::run(&args),
        Verb::Batch(args) => cmd::batch::run(&args),
        Verb::Shards(args) => cmd::shards::run(&args),
        Verb::Merge(args) => cmd::merge::run(&args),
        Verb::BatchWorker(args) => cmd::batch::worker::run(&args),
        Verb::Play(args) => cmd::play::run(&args),
        Verb::Completions(args) => cmd::manual::completions(&args),
        Verb::Man(args) => cmd::manual::man(&args),
    }
}

/// Reports a panic as a bug of texmap, with its position; the program ends with exit code 6.
fn guarded(body: impl FnOnce() -> Exit) -> Exit {
    panic::set_hook(Box::new(|info| {
        let place = info
            .location()
            .map_or_else(String::new, |l| format!(" at {}:{}", l.file(), l.line()));
        let message = info
            .payload()
            .downcast_ref::<&str>()
            .map(|s| (*s).to_owned())
            .or_else(|| info.payload().downcast_ref::<String>().cloned())
            .unwrap_or_default();
        Failure::internal(format!("texmap stopped{place}: {message}")).report(false);
    }));
    panic::catch_unwind(AssertUnwindSafe(body)).unwrap_or(Exit::Internal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_with_the_internal_exit_code() {
        let exit = guarded(|| panic!("on purpose, to see exit code 6"));
        let _ = panic::take_hook();
        assert_eq!(exit as u8, 6);
    }

    #[test]
    fn usage_errors_end_with_two_and_help_with_zero() {
        let args = |list: &[&str]| list.iter().map(OsString::from).collect::<Vec<_>>();
        assert_eq!(run(&args(&["texmap", "paint"])) as u8, 2);
        assert_eq!(run(&args(&["texmap", "--version"])) as u8, 0);
    }
}
