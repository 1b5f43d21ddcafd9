//! `texmap hash`: hashes of decoded pixels, to be committed and checked.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use texmap_io::FileSource;
use texmap_truth::buffer::Buffer;

use crate::failure::{self, Exit, Failure};

/// Print the pixel hash of images or .npy arrays, or check a list of them.
#[derive(Args, Debug)]
#[command(
    after_help = "The hash is of the decoded values, not of the file: two PNGs of the same pixels have one hash. HDR and EXR are hashed as floats. A line of a name with line breaks begins with `\\`, and has \\n, \\r and \\\\ in it, as of sha256sum. Exit code 1 when a check fails."
)]
pub(crate) struct HashArgs {
    /// The files
    #[arg(required_unless_present = "check")]
    files: Vec<PathBuf>,
    /// Check a list in the form that this command prints; its names are relative to the list
    #[arg(long, value_name = "LIST", conflicts_with = "files")]
    check: Option<PathBuf>,
    /// Print JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Serialize)]
struct Hashed {
    file: String,
    /// None for a file of a list that cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pixel_hash: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pass: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

pub(crate) fn run(args: &HashArgs) -> Result<Exit, Failure> {
    let results = match &args.check {
        Some(list) => check(list)?,
        None => args
            .files
            .iter()
            .map(|file| hashed(file, None))
            .collect::<Result<_, _>>()?,
    };
    if args.json {
        failure::print_json(&results)?;
    } else {
        for result in &results {
            let (mark, file) = escaped(&result.file);
            let hash = result.pixel_hash.as_deref().unwrap_or_default();
            failure::print(&match (result.pass, &result.error) {
                (None, _) => format!("{mark}{hash}  {file}\n"),
                (Some(true), _) => format!("PASS  {file}\n"),
                (Some(false), None) => format!("FAIL  {file}: it is {hash}\n"),
                // The words begin with the name.
                (Some(false), Some(error)) => format!("FAIL  {error}\n"),
            })?;
        }
    }
    let failed = results.iter().any(|result| result.pass == Some(false));
    Ok(if failed { Exit::Differs } else { Exit::Done })
}

fn hashed(file: &Path, expected: Option<&str>) -> Result<Hashed, Failure> {
    let pixel_hash = Buffer::read(file)?.hash();
    let pass = expected.map(|hash| hash == pixel_hash);
    Ok(Hashed {
        file: file.display().to_string(),
        pixel_hash: Some(pixel_hash),
        pass,
        error: None,
    })
}

/// A file of a list: one that cannot be read fails alone.
fn checked(file: &Path, expected: &str) -> Hashed {
    hashed(file, Some(expected)).unwrap_or_else(|failure| Hashed {
        file: file.display().to_string(),
        pixel_hash: None,
        pass: Some(false),
        error: Some(failure.what),
    })
}

fn check(list: &Path) -> Result<Vec<Hashed>, Failure> {
    let text = FileSource::anywhere().read_text(list, FileSource::MAX_LIST)?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let results = lines.map(|(number, line)| match line.split_once("  ") {
        Some((hash, name)) if hash.contains(':') => Ok(match hash.strip_prefix('\\') {
            Some(hash) => checked(&folder.join(unescaped(name)), hash),
            None => checked(&folder.join(name), hash),
        }),
        _ => Err(Failure::new(
            Exit::Input,
            "list",
            format!("{}:{}: no hash and name", list.display(), number + 1),
            "each line is a hash, two blanks and a file name",
        )),
    });
    let results: Vec<Hashed> = results.collect::<Result<_, _>>()?;
    if results.is_empty() {
        let what = format!("{}: the list is empty", list.display());
        return Err(Failure::new(
            Exit::Input,
            "list",
            what,
            "print one with `texmap hash FILE...`",
        ));
    }
    Ok(results)
}

/// A name on one line, and the mark before a line whose name is escaped. Names of other systems keep their backslashes.
fn escaped(name: &str) -> (&'static str, Cow<'_, str>) {
    match name.contains(['\n', '\r']) {
        true => {
            let name = name.replace('\\', "\\\\").replace('\n', "\\n");
            ("\\", name.replace('\r', "\\r").into())
        }
        false => ("", name.into()),
    }
}

fn unescaped(name: &str) -> String {
    let mut plain = String::with_capacity(name.len());
    let mut rest = name.chars();
    while let Some(c) = rest.next() {
        plain.push(match c {
            '\\' => match rest.next() {
                Some('n') => '\n',
                Some('r') => '\r',
                Some(other) => other,
                None => '\\',
            },
            other => other,
        });
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_names_come_back() {
        for name in ["a\nb\\n.png", "\r", "\\\n\\"] {
            let (mark, line) = escaped(name);
            assert_eq!(mark, "\\");
            assert!(!line.contains(['\n', '\r']), "{line}");
            assert_eq!(unescaped(&line), name);
        }
        assert_eq!(escaped("a\\n.png"), ("", "a\\n.png".into()));
        assert_eq!(unescaped("a\\"), "a\\");
    }
}
