//! The words that begin lines: which there are, and which one a slip of the pen meant.

use std::path::Path;

use super::Command;
use super::token::Token;
use crate::{IoError, SourceLocation};

/// The word of every command.
pub const COMMANDS: [&str; 65] = [
    "eye",
    "look",
    "up",
    "fov",
    "near",
    "far",
    "background",
    "color",
    "la",
    "ld",
    "lp",
    "surf",
    "v",
    "f",
    "texture",
    "tf",
    "frame",
    "ff",
    "round",
    "filter",
    "wrap",
    "border",
    "interp",
    "cull",
    "alpha",
    "shade",
    "gouraud",
    "translate",
    "rotate",
    "scale",
    "push",
    "pop",
    "missing",
    "obj",
    "include",
    "ls",
    "name",
    "shadow",
    "shadowless",
    "projector",
    "highlight",
    "env",
    "specmap",
    "lightmap",
    "lightmapuv",
    "emission",
    "bump",
    "offsetmap",
    "carve",
    "emboss",
    "normalmap",
    "horizon",
    "solid",
    "ramp",
    "cel",
    "decal",
    "font",
    "text",
    "sky",
    "volume",
    "displace",
    "terrain",
    "billboard",
    "bone",
    "skin",
];

pub(super) fn known_word(
    file: &Path,
    line: u32,
    token: Token<'_>,
) -> Result<&'static str, IoError> {
    if let Some(word) = COMMANDS.iter().find(|w| **w == token.text && !token.quoted) {
        return Ok(word);
    }
    // A word may be as long as a file: no command looks like one that is.
    let written = token.text.to_lowercase();
    let short = written.len() < 40;
    let distance = |word: &&str| edit_distance(&written, word);
    let nearest = COMMANDS.iter().copied().filter(|_| short);
    let nearest = nearest.min_by_key(distance);
    // One slip in a short word, two in a longer one.
    let allowed = if token.text.len() <= 4 { 1 } else { 2 };
    Err(IoError::UnknownCommand {
        location: SourceLocation::new(file, line, token.column),
        word: token.text.chars().take(40).collect(),
        nearest: nearest.filter(|word| distance(word) <= allowed),
    })
}

/// Insertions, deletions and replacements that make `a` from `b` (Levenshtein).
fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, y) in b.bytes().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

impl Command {
    /// The word that begins its line.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Eye(_) => "eye",
            Self::Look(_) => "look",
            Self::Up(_) => "up",
            Self::Fov(_) => "fov",
            Self::Near(_) => "near",
            Self::Far(_) => "far",
            Self::Background(_) => "background",
            Self::Color(_) => "color",
            Self::AmbientLight(_) => "la",
            Self::DirectionalLight { .. } => "ld",
            Self::PointLight { .. } => "lp",
            Self::Surf(_) => "surf",
            Self::Vertex(_) => "v",
            Self::Face(_) => "f",
            Self::Texture(_) => "texture",
            Self::TexturedFace(_) => "tf",
            Self::Frame { .. } => "frame",
            Self::Round(_) => "round",
            Self::FramedFace(_) => "ff",
            Self::Filter(_) => "filter",
            Self::Wrap(..) => "wrap",
            Self::Border(_) => "border",
            Self::Interp(_) => "interp",
            Self::Cull(_) => "cull",
            Self::Alpha(_) => "alpha",
            Self::Shade(_) => "shade",
            Self::Gouraud(_) => "gouraud",
            Self::Translate(_) => "translate",
            Self::Rotate { .. } => "rotate",
            Self::Scale(_) => "scale",
            Self::Push => "push",
            Self::Pop => "pop",
            Self::Missing(_) => "missing",
            Self::Obj(_) => "obj",
            Self::Include(_) => "include",
            Self::Effect(effect) => effect.word(),
            Self::Classic(classic) => classic.word(),
            Self::Shape(shape) => shape.word(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    #[test]
    fn a_slip_of_the_pen_gets_a_suggestion() {
        let nearest = |text| match parse(Path::new("a.scene"), text).unwrap_err() {
            IoError::UnknownCommand { nearest, .. } => nearest,
            other => panic!("{other}"),
        };
        assert_eq!(nearest("textrue a.png"), Some("texture"));
        assert_eq!(nearest("Eye 0 0 0"), Some("eye"));
        assert_eq!(nearest("hello"), None);
        assert_eq!(nearest("translte 1 2 3"), Some("translate"));
    }
}
