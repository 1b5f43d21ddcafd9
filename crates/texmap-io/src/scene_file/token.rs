//! Words of one line, with their columns.

/// A word: a run without blanks, or a quoted path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    /// From 1, in characters.
    pub(super) column: u32,
    pub(super) quoted: bool,
}

impl Token<'_> {
    /// Words that begin like a number are numbers or errors, never commands.
    pub(super) fn begins_number(&self) -> bool {
        !self.quoted
            && self
                .text
                .starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
    }
}

/// Cuts a line into words; `#` outside of quotes begins a comment.
///
/// `Err` holds the column of a quote that does not end or stands inside a word.
pub(super) fn words(line: &str) -> Result<Vec<Token<'_>>, u32> {
    let mut tokens = Vec::new();
    let mut at = 0;
    let mut column = 1;
    while let Some(c) = line[at..].chars().next() {
        if c.is_whitespace() {
            at += c.len_utf8();
            column += 1;
            continue;
        }
        if c == '#' {
            break;
        }
        let rest = &line[at..];
        let (text, length, quoted) = if let Some(inside) = rest.strip_prefix('"') {
            let end = inside.find('"').ok_or(column)?;
            if !inside[end + 1..]
                .chars()
                .next()
                .is_none_or(|c| c.is_whitespace() || c == '#')
            {
                return Err(column + rest[..end + 1].chars().count() as u32);
            }
            (&inside[..end], end + 2, true)
        } else {
            let end = rest
                .find(|c: char| c.is_whitespace() || c == '#')
                .unwrap_or(rest.len());
            if let Some(quote) = rest[..end].find('"') {
                return Err(column + rest[..quote].chars().count() as u32);
            }
            (&rest[..end], end, false)
        };
        tokens.push(Token {
            text,
            column,
            quoted,
        });
        column += rest[..length].chars().count() as u32;
        at += length;
    }
    Ok(tokens)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_comments_quotes_and_columns() {
        let tokens = words("\ttexture  \"my é.png\" tex/wall_1.gif#end").unwrap();
        let seen: Vec<_> = tokens
            .iter()
            .map(|t| (t.text, t.column, t.quoted))
            .collect();
        assert_eq!(
            seen,
            [
                ("texture", 2, false),
                ("my é.png", 11, true),
                ("tex/wall_1.gif", 22, false)
            ]
        );
        assert!(words("  # only a comment \"").unwrap().is_empty());
        assert_eq!(words("texture \"open"), Err(9));
        assert_eq!(words("texture a\"b\""), Err(10));
        assert_eq!(words("texture \"a\"b"), Err(11));
    }

    #[test]
    fn numbers_begin_with_a_digit_a_sign_or_a_point() {
        for (text, number) in [
            ("1e-3", true),
            ("-.5", true),
            ("+2", true),
            ("tf", false),
            ("nan", false),
        ] {
            assert_eq!(words(text).unwrap()[0].begins_number(), number, "{text}");
        }
    }
}
