//! The scene language: text to statements and back.
//!
//! The language of the MIT 6.837 (Fall 2001) course, lecture 18, and texmap's extensions in the
//! same style: one command a line, a word and its values; a line that begins with a number
//! continues the command above; `#` begins a comment.
//!
//! One table has a row for each command: its word, its arguments, its default, its help, and the effect of a line on the scene.
//! Reading, printing, suggestions, error texts and the tables of `docs/SCENE_FORMAT.md` ([`Section::manual`]) come from it.
//!
//! [`parse`] checks everything that one file can show by itself (words, counts, ranges, indices);
//! [`crate::load_scene`] then reads the files it names and makes the scene.

mod args;
pub(crate) mod grammar;
mod parse;
mod token;
mod value;
pub mod words;

pub use crate::scene::{SECTIONS, Section, Spec, commands};
pub use parse::parse;
pub use value::{Command, Value};

#[cfg(test)]
pub(crate) use parse::{assert_faults, assert_reads_back};
pub(crate) use value::Line;

/// The statements of one file in their order.
#[derive(Debug, Clone, Default)]
pub struct SceneFile {
    /// Commands and their positions.
    pub statements: Vec<Statement>,
}

impl SceneFile {
    /// The commands without their locations; two files with equal commands are the same scene.
    pub fn commands(&self) -> impl Iterator<Item = &Command> {
        self.statements.iter().map(|s| &s.command)
    }
}

impl FromIterator<Command> for SceneFile {
    /// A file with each command on its own line.
    fn from_iter<I: IntoIterator<Item = Command>>(commands: I) -> Self {
        let statements = commands
            .into_iter()
            .zip(1..)
            .map(|(command, line)| Statement {
                command,
                line,
                column: 1,
            })
            .collect();
        Self { statements }
    }
}

/// A command and the location of its word.
#[derive(Debug, Clone)]
pub struct Statement {
    /// Its word and values.
    pub command: Command,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// The file as text, one command a line. Comments and spacing are gone; `print(parse(x))` is a fixed point, and its
/// commands are those of `x`, number for number.
pub fn print(file: &SceneFile) -> String {
    file.commands()
        .map(|command| format!("{command}\n"))
        .collect()
}

/// Treatment of a missing map or material library.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Missing {
    /// An error.
    #[default]
    Error,
    /// A warning; a magenta and black checker stands in for the map, and grey for a library's materials.
    Checker,
    /// A warning; grey stands in for the map, and for a library's materials. Heights and normals are flat.
    Grey,
}

impl Missing {
    /// Every treatment and its word.
    pub const ALL: [(&'static str, Self); 3] = [
        ("error", Self::Error),
        ("checker", Self::Checker),
        ("grey", Self::Grey),
    ];

    /// True if a substitute replaces missing files.
    #[must_use]
    pub fn is_lenient(self) -> bool {
        self != Self::Error
    }
}

impl std::str::FromStr for Missing {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.iter().find(|(name, _)| *name == word);
        found
            .map(|(_, missing)| *missing)
            .ok_or("know error, checker, grey")
    }
}
