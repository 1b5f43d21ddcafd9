//! What went wrong, where, why and what to try; and the exit codes.

use std::io::{self, Write};

use clap::CommandFactory;
use clap::error::ErrorKind;
use serde::Serialize;
use texmap_io::{plain, plain_json};

use crate::args::Cli;

/// How the program ends. The numbers are part of its interface.
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
    /// Something is dearer or less accurate than it was allowed to be; the output is written all the same.
    OverBudget = 5,
    /// A bug of texmap.
    Internal = 6,
}

/// One failure: two lines for people, one object for programs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failure {
    pub(crate) exit: Exit,
    /// Stable name, for programs.
    pub(crate) code: String,
    /// One line: what and where (file, line, mesh, face, texel).
    pub(crate) what: String,
    /// One line: why, and what to try.
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
        let mut text = format!("error[{}]: {}\n", self.code, one_line(&self.what));
        if !self.why.is_empty() {
            text.push_str(&format!("  {}\n", one_line(&self.why)));
        }
        say(&text);
        if json {
            print_json(&ErrorObject { error: self.body() });
        }
    }
}

impl From<texmap_io::IoError> for Failure {
    fn from(error: texmap_io::IoError) -> Self {
        Self::new(Exit::Input, error.code(), error.to_string(), error.help())
    }
}

impl From<clap::Error> for Failure {
    /// clap's text is kept: first line what, the rest (tip and usage) why.
    fn from(refusal: clap::Error) -> Self {
        if refusal.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            let command = Cli::command();
            let verbs: Vec<&str> = command
                .get_subcommands()
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

/// Words, to standard error, without control characters but line feeds. A closed pipe is not a failure.
pub(crate) fn say(text: &str) {
    let _ = io::stderr().lock().write_all(plain(text).as_bytes());
}

/// Text, to standard output, without control characters but line feeds. A closed pipe is not a failure.
pub(crate) fn print(text: &str) {
    write_out(&plain(text));
}

fn write_out(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// One JSON document and a newline, to standard output.
pub(crate) fn print_json(value: &impl Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => write_out(&plain_json(&(text + "\n"))),
        Err(e) => say(&format!(
            "error[internal]: the report could not be written as JSON: {e}\n"
        )),
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
