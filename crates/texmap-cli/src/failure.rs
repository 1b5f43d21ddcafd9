//! Failures, with position, reason and remedy; and the exit codes.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::CommandFactory;
use clap::error::ErrorKind;
use serde::Serialize;
use texmap_io::{IoError, plain, plain_json};
use texmap_lab::LabError;
use texmap_math::OverBudget;
use texmap_mesh::MeshError;
use texmap_raster::RasterError;
use texmap_render::RenderError;
use texmap_scene::SceneError;
use texmap_truth::TruthError;

use crate::args::Cli;
use crate::interrupt;
use crate::observe;
use crate::output::shown;

/// Exit codes of the program. The numbers are part of its interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Exit {
    /// Everything asked for was done.
    Done = 0,
    /// A comparison or a claim failed.
    Differs = 1,
    /// The command line is wrong.
    Usage = 2,
    /// Some of several items failed; the report says which.
    Partial = 3,
    /// An input or output is bad: the same call will fail again.
    Input = 4,
    /// Something is dearer or less accurate than it was allowed to be and was written all the same, or it takes more memory than
    /// the budget has and was not.
    OverBudget = 5,
    /// A bug of texmap.
    Internal = 6,
    /// Not complete yet: the same call may succeed later (`EX_TEMPFAIL` of sysexits.h).
    Again = 75,
}

/// One failure: two lines for people, one object for programs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failure {
    pub(crate) exit: Exit,
    /// Stable name, for programs.
    pub(crate) code: String,
    /// One line with the fault and its position (file, line, mesh, face, texel).
    pub(crate) what: String,
    /// One line with the reason and a remedy.
    pub(crate) why: String,
}

#[derive(Serialize)]
struct ErrorObject {
    error: ErrorBody,
}

/// The JSON form of a failure, alone or inside an item of a report.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ErrorBody {
    code: String,
    exit: u8,
    what: String,
    why: String,
}

impl Failure {
    pub(crate) fn new(
        exit: Exit,
        code: &str,
        what: impl Into<String>,
        why: impl Into<String>,
    ) -> Self {
        Self {
            exit,
            code: code.to_owned(),
            what: what.into(),
            why: why.into(),
        }
    }

    pub(crate) fn usage(what: impl Into<String>, why: impl Into<String>) -> Self {
        Self::new(Exit::Usage, "usage", what, why)
    }

    pub(crate) fn internal(what: impl Into<String>) -> Self {
        Self::new(
            Exit::Internal,
            "internal",
            what,
            "this is a bug in texmap: please report it with the command line and the input",
        )
    }

    /// A buffer beyond the memory budget; `what` is the whole first line.
    fn over_memory(refused: &OverBudget, what: String) -> Self {
        let why = match refused.limit {
            Some(_) => format!("{}, or raise --memory-limit", refused.lower),
            None => refused.lower.to_owned(),
        };
        Self::new(Exit::OverBudget, "over-memory-budget", what, why)
    }

    /// An error of a scene or of its drawing. `place` names the drawn thing, `why` is the second line unless memory is missing.
    pub(crate) fn of_render(error: impl Into<Refusal>, place: Option<&str>, why: &str) -> Self {
        let error = error.into();
        let what = match place {
            Some(place) => format!("{place}: {}", error.text),
            None => error.text,
        };
        match error.memory {
            Some(refused) => Self::over_memory(&refused, what),
            None => Self::new(Exit::Input, error.code, what, why),
        }
    }

    pub(crate) fn body(&self) -> ErrorBody {
        ErrorBody {
            code: self.code.clone(),
            exit: self.exit as u8,
            what: one_line(&self.what),
            why: one_line(&self.why),
        }
    }

    /// Two lines to standard error and, where the caller asked for JSON, the object to standard output.
    pub(crate) fn report(&self, json: bool) {
        interrupt::stop_if_ending();
        let mut text = format!("error[{}]: {}\n", self.code, one_line(&self.what));
        if !self.why.is_empty() {
            text.push_str(&format!("  {}\n", one_line(&self.why)));
        }
        say_always(&text);
        if json {
            // Standard error has the same message.
            let _ = print_json(&ErrorObject { error: self.body() });
        }
    }
}

/// Common part of the errors of scenes, meshes and pictures.
pub(crate) struct Refusal {
    code: &'static str,
    text: String,
    memory: Option<OverBudget>,
}

impl From<SceneError> for Refusal {
    fn from(error: SceneError) -> Self {
        Self {
            code: error.code(),
            text: error.to_string(),
            memory: None,
        }
    }
}

impl From<MeshError> for Refusal {
    fn from(error: MeshError) -> Self {
        Self {
            code: error.code(),
            text: error.to_string(),
            memory: match error {
                MeshError::Memory(refused) => Some(refused),
                _ => None,
            },
        }
    }
}

impl From<RenderError> for Refusal {
    fn from(error: RenderError) -> Self {
        Self {
            code: error.code(),
            text: error.to_string(),
            memory: match error {
                RenderError::Memory(refused) => Some(refused),
                _ => None,
            },
        }
    }
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        match &error {
            IoError::Memory { refused, .. } => Self::over_memory(refused, error.to_string()),
            IoError::Write { path, source } => {
                let what = format!("{}: cannot be written: {source}", shown(path).display());
                Self::new(Exit::Input, error.code(), what, error.help())
            }
            _ => Self::new(Exit::Input, error.code(), error.to_string(), error.help()),
        }
    }
}

impl From<OverBudget> for Failure {
    fn from(refused: OverBudget) -> Self {
        let what = refused.to_string();
        Self::over_memory(&refused, what)
    }
}

impl From<LabError> for Failure {
    /// The lab's own scenes are right: only memory may be missing.
    fn from(error: LabError) -> Self {
        match &error {
            LabError::Render(RenderError::Memory(refused))
            | LabError::Mesh(MeshError::Memory(refused))
            | LabError::Raster(RasterError::Memory(refused)) => {
                Self::over_memory(refused, error.to_string())
            }
            _ => Self::internal(error.to_string()),
        }
    }
}

impl From<TruthError> for Failure {
    /// A scene that was drawn has a reference, if it is of a kind that the reference knows.
    fn from(error: TruthError) -> Self {
        match &error {
            TruthError::Render(RenderError::Memory(refused)) => {
                Self::over_memory(refused, error.to_string())
            }
            TruthError::Unsupported { .. } => Self::usage(
                error.to_string(),
                "draw it without --verify, or with --tone-map none --exposure 1",
            ),
            _ => Self::internal(error.to_string()),
        }
    }
}

impl From<clap::Error> for Failure {
    /// The failure of a wrong command line, with clap's text. The first line is `what`, tip and usage are `why`.
    fn from(refusal: clap::Error) -> Self {
        if refusal.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            let command = Cli::command();
            let verbs: Vec<&str> = command
                .get_subcommands()
                .filter(|verb| !verb.is_hide_set())
                .map(clap::Command::get_name)
                .collect();
            return Self::usage(
                "no command given",
                format!(
                    "Usage: texmap COMMAND, one of {}; `texmap --help` says more",
                    verbs.join(", ")
                ),
            );
        }
        let text = refusal.render().to_string();
        let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
        let what = lines
            .next()
            .unwrap_or("no command given")
            .trim_start_matches("error: ")
            .to_owned();
        let rest: Vec<&str> = lines
            .filter(|l| !l.starts_with("For more information"))
            .collect();
        Self::usage(
            what,
            format!("{}; `--help` lists everything", rest.join(" "))
                .trim_start_matches("; ")
                .to_owned(),
        )
    }
}

/// Set by `--quiet`.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From here on nothing but failures is said.
pub(crate) fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Words that are no failure, to standard error; none after `--quiet`.
pub(crate) fn say(text: &str) {
    observe::said(text);
    if !is_quiet() && !observe::is_on() {
        say_always(text);
    }
}

/// Words, to standard error, without control characters but line feeds. A closed pipe is not a failure.
pub(crate) fn say_always(text: &str) {
    let _ = io::stderr().lock().write_all(plain(text).as_bytes());
}

/// Text, to standard output, without control characters but line feeds. A full device is a failure; a closed pipe is not, since
/// its reader has seen enough.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    deliver(|out| out.write_all(plain(text).as_bytes()))
}

/// One JSON document on a line of its own, to standard output.
pub(crate) fn print_json_line(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value)
        .map_err(|e| Failure::internal(format!("a line could not be written as JSON: {e}")))?;
    deliver(|out| out.write_all(plain_json(&(text + "\n")).as_bytes()))
}

/// One JSON document and a newline, to standard output; the report of a task of a batch goes to its observer.
pub(crate) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    if observe::report(value) {
        return Ok(());
    }
    let text = serde_json::to_string_pretty(value)
        .map_err(|e| Failure::internal(format!("the report could not be written as JSON: {e}")))?;
    deliver(|out| out.write_all(plain_json(&(text + "\n")).as_bytes()))
}

/// Lets `write` write to standard output, and flushes it: errors come when bytes leave. Words of a task of a batch are left out.
pub(crate) fn deliver(
    write: impl FnOnce(&mut io::StdoutLock<'_>) -> io::Result<()>,
) -> Result<(), Failure> {
    if observe::is_on() {
        return Ok(());
    }
    let mut out = io::stdout().lock();
    match write(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Failure::new(
            Exit::Input,
            "write-failed",
            format!("standard output: cannot be written: {e}"),
            "check the free space where it is redirected to",
        )),
        _ => Ok(()),
    }
}

fn one_line(text: &str) -> String {
    plain(&text.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_one_line_however_it_was_written() {
        let f = Failure::usage("two\nlines", "and\r\n\tmore");
        let body = f.body();
        assert_eq!(
            (body.what.as_str(), body.why.as_str(), body.exit),
            ("two lines", "and more", 2)
        );
    }
}
