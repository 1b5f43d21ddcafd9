//! The table of commands: word, arguments, default, help, and effect on the scene.

mod course;
mod light;
mod materials;
mod models;
mod settings;
mod shapes;

use std::fmt;

use super::build::Builder;
use crate::IoError;
use crate::scene_file::Line;
use crate::scene_file::grammar::{Arg, usage};

/// A row of the table: one command of the scene language.
pub struct Spec {
    /// The word that begins its lines.
    pub word: &'static str,
    /// Its default, as the manual writes it; empty where it has none.
    pub default: &'static str,
    /// Its meaning, as the manual writes it (Markdown).
    pub help: &'static str,
    pub(crate) args: &'static [Arg],
    set: Set,
}

/// The effect of a line on the scene; its values come in the order of the row's arguments.
#[derive(Clone, Copy)]
enum Set {
    Plain(fn(&mut Builder, &mut Line<'_>)),
    Fallible(fn(&mut Builder, &mut Line<'_>) -> Result<(), IoError>),
    /// It is found in the file before the builder passes through it.
    Nothing,
}

impl Spec {
    /// Applies a line of this command.
    pub(super) fn set(&self, builder: &mut Builder, line: &mut Line<'_>) -> Result<(), IoError> {
        match self.set {
            Set::Plain(set) => set(builder, line),
            Set::Fallible(set) => return set(builder, line),
            Set::Nothing => {}
        }
        Ok(())
    }

    /// Its arguments, as the manual writes them.
    pub fn values(&self) -> String {
        usage(self.args, "`")
    }
}

impl PartialEq for Spec {
    /// Words name rows.
    fn eq(&self, other: &Self) -> bool {
        self.word == other.word
    }
}

impl fmt::Debug for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Spec").field(&self.word).finish()
    }
}

/// A part of the table that the manual shows as one.
#[derive(Debug)]
pub struct Section {
    /// Its rows.
    pub specs: &'static [Spec],
}

impl Section {
    /// The section as a Markdown table.
    pub fn manual(&self) -> String {
        let row = |spec: &Spec| {
            let cells = [&spec.values(), spec.default, spec.help];
            let cells = cells.map(|cell| match cell {
                "" => " |".to_owned(),
                cell => format!(" {cell} |"),
            });
            format!("| `{}` |{}\n", spec.word, cells.concat())
        };
        let head = "| command | values | default | meaning |\n|---|---|---|---|\n";
        head.to_owned() + &self.specs.iter().map(row).collect::<String>()
    }
}

/// The table in the order of the manual.
pub static SECTIONS: [Section; 7] = [
    Section {
        specs: course::SPECS,
    },
    Section {
        specs: settings::PICTURE,
    },
    Section {
        specs: settings::SPECS,
    },
    Section {
        specs: models::SPECS,
    },
    Section {
        specs: light::SPECS,
    },
    Section {
        specs: shapes::SPECS,
    },
    Section {
        specs: materials::SPECS,
    },
];

/// All rows of the table.
pub fn commands() -> impl Iterator<Item = &'static Spec> {
    SECTIONS.iter().flat_map(|section| section.specs)
}

/// Words of earlier versions and the words that replace them. Files that were written with the former still load.
const EARLIER: [(&str, &str); 2] = [("carve", "procedural-bump"), ("round", "uv-projection")];

/// The row of the table for a word, also one of an earlier version.
pub(crate) fn command(word: &str) -> Option<&'static Spec> {
    let renamed = EARLIER.iter().find(|(earlier, _)| *earlier == word);
    let word = renamed.map_or(word, |(_, word)| word);
    commands().find(|spec| spec.word == word)
}

/// The command that a mistyped word stands for.
pub(crate) fn nearest(word: &str) -> Option<&'static str> {
    let written = word.to_lowercase();
    // A word may be as long as a file: no command looks like one that is.
    if written.len() >= 40 {
        return None;
    }
    let distances = commands().map(|spec| (strsim::levenshtein(&written, spec.word), spec.word));
    let (distance, nearest) = distances.min_by_key(|(distance, _)| *distance)?;
    // One mistyped character in a short word, two in a longer one.
    let allowed = if word.len() <= 4 { 1 } else { 2 };
    (distance <= allowed).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_pen_gets_a_suggestion() {
        assert_eq!(nearest("textrue"), Some("texture"));
        assert_eq!(nearest("Eye"), Some("eye"));
        assert_eq!(nearest("hello"), None);
        assert_eq!(nearest("translte"), Some("translate"));
    }

    #[test]
    fn words_of_earlier_versions_are_no_rows_of_their_own() {
        for (earlier, word) in EARLIER {
            assert_eq!(command(earlier).map(|spec| spec.word), Some(word));
            assert!(commands().all(|spec| spec.word != earlier), "{earlier}");
        }
        assert_eq!(command("carves"), None);
    }

    #[test]
    fn no_word_has_two_rows() {
        let mut words: Vec<_> = commands().map(|spec| spec.word).collect();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), commands().count());
    }
}
