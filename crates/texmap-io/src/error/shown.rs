//! Text from files and names of files as messages show them. Messages have one line of limited length, without characters that command
//! a terminal.

use std::fmt::{self, Write};
use std::path::Path;

/// The longest piece of a file that a message shows, in characters.
const LONGEST: usize = 200;

/// The longest message of another library, in characters.
const MESSAGE: usize = 1000;

/// A word of a file for a message: control characters escaped, at most 200 characters and then an ellipsis.
pub fn shortened(text: &str) -> impl fmt::Display {
    cut(text, LONGEST)
}

/// The message of a library, which may quote a file.
pub(crate) fn one_message(text: &str) -> impl fmt::Display {
    cut(text, MESSAGE)
}

/// Lines of output as they may go to a terminal: control characters escaped but for line feeds, every line at most 8000
/// characters.
pub fn plain(text: &str) -> String {
    const LINE: usize = 8000;
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let (content, end) = match line.strip_suffix('\n') {
            Some(content) => (content, "\n"),
            None => (line, ""),
        };
        out += &cut(content, LINE);
        out += end;
    }
    out
}

/// A JSON document in which strings hold no character that commands a terminal: those that JSON itself does not demand to be
/// escaped are escaped too, which changes no value.
pub fn plain_json(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        // Line feeds and blanks stand between values; all others of that kind lie in the Basic Multilingual Plane.
        if c != '\n' && commands(c) {
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out
}

/// The name of a file for a message, whole and with its control characters escaped. Bytes that are no Unicode become U+FFFD. A name
/// longer than those of files is a word of the file that holds it, and is cut like one.
pub fn shown(path: &Path) -> impl fmt::Display {
    const LONGEST_PATH: usize = 4096;
    let text = path.to_string_lossy();
    let long = text.len() > LONGEST_PATH || path.iter().any(|name| name.len() > 255);
    cut(&text, if long { LONGEST } else { usize::MAX })
}

fn cut(text: &str, longest: usize) -> String {
    let mut out = String::new();
    for (i, c) in text.chars().enumerate() {
        if i == longest {
            out.push('\u{2026}');
            break;
        }
        if commands(c) {
            // Writing to a String cannot fail.
            let _ = write!(out, "{}", c.escape_unicode());
        } else {
            out.push(c);
        }
    }
    out
}

/// Characters that a terminal may take as commands (C0, DEL, C1), that end a line, or that change the order in which text is
/// shown (Unicode's bidirectional controls).
fn commands(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{2028}' | '\u{2029}' | '\u{200e}' | '\u{200f}' | '\u{061c}'
        )
        || ('\u{202a}'..='\u{202e}').contains(&c)
        || ('\u{2066}'..='\u{2069}').contains(&c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_escaped_and_long_words_cut() {
        let red = "a\u{1b}[31mb\nc\u{9b}2Jd\u{202e}e";
        let escaped = "a\\u{1b}[31mb\\u{a}c\\u{9b}2Jd\\u{202e}e";
        assert_eq!(shortened(red).to_string(), escaped);
        assert_eq!(shown(Path::new(red)).to_string(), escaped);
        let long = "\u{e9}".repeat(201);
        let short = shortened(&long).to_string();
        assert_eq!(short.chars().count(), 201);
        assert!(short.ends_with('\u{2026}'));
        assert_eq!(shortened(&long[..400]).to_string(), long[..400]);
        let deep = format!("{0}/{0}/{0}", &long[..254]);
        assert_eq!(shown(Path::new(&deep)).to_string(), deep);
        assert_eq!(shown(Path::new(&long.repeat(9))).to_string(), short);
        assert_eq!(
            plain_json("{\n\"\u{9b}\u{202e}é\"}"),
            "{\n\"\\u009b\\u202eé\"}"
        );
        assert_eq!(plain("a\u{1b}\n\nb\r"), "a\\u{1b}\n\nb\\u{d}");
    }
}
