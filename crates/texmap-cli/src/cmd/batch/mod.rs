//! `texmap batch`: a verb over many items, in shards, jobs and bands, and again from where it ended.
//!
//! Each task is the command line of one item, run in a process beside this one by the verb's own code. `docs/batch.md` is the page for users.

pub(crate) mod args;
pub(crate) mod files;
mod manifest;
mod outputs;
pub(crate) mod plan;
mod pool;
pub(crate) mod record;
mod run;
pub(crate) mod settings;
pub(crate) mod shard;
pub(crate) mod state;
pub(crate) mod worker;

use crate::cmd::batch::args::BatchVerb;

pub(crate) use args::BatchArgs;
pub(crate) use pool::started_by;
pub(crate) use run::run;

/// The arguments of a process with the verb that `texmap batch` runs if none is named: `render`.
pub(crate) fn with_verb(mut arguments: Vec<std::ffi::OsString>) -> Vec<std::ffi::OsString> {
    let mut at = 1;
    while let Some(word) = arguments.get(at).and_then(|word| word.to_str()) {
        match word {
            "batch" | "shards" => break,
            "--memory-limit" => at += 2,
            word if word.starts_with('-') => at += 1,
            _ => return arguments,
        }
    }
    let plain = arguments.get(at + 1).and_then(|word| word.to_str());
    let help =
        plain.is_some_and(|word| ["help", "-h", "--help", "-V", "--version"].contains(&word));
    let named = plain.is_some_and(|word| BatchVerb::of(word).is_some());
    if arguments.len() > at + 1 && !help && !named {
        arguments.insert(at + 1, BatchVerb::Render.name().into());
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::with_verb;

    #[test]
    fn render_is_the_verb_that_is_not_named() {
        let of = |line: &str| {
            let words = line.split(' ').map(Into::into).collect();
            let words: Vec<String> = with_verb(words)
                .into_iter()
                .map(|w| w.into_string().unwrap())
                .collect();
            words.join(" ")
        };
        for (line, expected) in [
            (
                "texmap batch a.obj -o x/",
                "texmap batch render a.obj -o x/",
            ),
            (
                "texmap -q --memory-limit 1G batch --resume a.obj",
                "texmap -q --memory-limit 1G batch render --resume a.obj",
            ),
            ("texmap batch uv a.obj", "texmap batch uv a.obj"),
            ("texmap batch --help", "texmap batch --help"),
            ("texmap batch", "texmap batch"),
            ("texmap render batch a.obj", "texmap render batch a.obj"),
            (
                "texmap shards a.obj --count 8",
                "texmap shards render a.obj --count 8",
            ),
        ] {
            assert_eq!(of(line), expected);
        }
    }
}
