//! The arguments of commands: kinds, allowed values, and notation in messages and the manual.

use Arg::{
    Corners, Either, File, Frame, Method, Name, Numbers, OneOf, Optional, Options, Text,
    TexturedCorners,
};

/// One argument of a command, or several that belong together.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Arg {
    /// Numbers of 64 bits: their names, separated by blanks, and their check.
    Numbers(&'static str, Check),
    /// As `Numbers`, rounded once to 32 bits.
    Floats(&'static str, Check),
    /// Origin, U and V of a texture frame.
    Frame,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// A word that another crate reads: its name, its allowed values, and the check of one.
    Method(&'static str, fn() -> String, fn(&str) -> bool),
    /// A name, and the check of one.
    Name(fn(&str) -> Option<&'static str>),
    /// The name of a file.
    File,
    /// Words, in quotes if there are several, and the check of them.
    Text(fn(&str) -> Option<&'static str>),
    /// Indices of at least three vertices.
    Corners,
    /// At least three vertices, each with u and v.
    TexturedCorners,
    /// Arguments that may be left out.
    Optional(&'static [Self]),
    /// Any of these, in any order; each begins with `OneOf`.
    Options(&'static [&'static [Self]]),
    /// One of these, by its first word, or else by the number of values.
    Either(&'static [&'static [Self]]),
}

/// The allowed values, in words, where value `i` of a group is not one of them.
pub(crate) type Check = fn(&[f64], usize) -> Option<&'static str>;

pub(crate) fn unless(valid: bool, allowed: &'static str) -> Option<&'static str> {
    (!valid).then_some(allowed)
}

pub(crate) fn any(_: &[f64], _: usize) -> Option<&'static str> {
    None
}

pub(crate) fn not_negative(v: &[f64], i: usize) -> Option<&'static str> {
    unless(v[i] >= 0.0, "0 or more")
}

pub(crate) fn unit(v: &[f64], i: usize) -> Option<&'static str> {
    unless((0.0..=1.0).contains(&v[i]), "0 to 1")
}

pub(crate) fn not_zero(v: &[f64], i: usize) -> Option<&'static str> {
    unless(v[i] != 0.0, "a number that is not 0")
}

pub(crate) fn length(v: &[f64], i: usize) -> Option<&'static str> {
    unless(v[i] > 0.0, "a length above 0")
}

pub(crate) fn direction(v: &[f64], i: usize) -> Option<&'static str> {
    unless(
        i > 0 || v.iter().any(|x| *x != 0.0),
        "a direction that is not zero",
    )
}

pub(crate) fn axis(v: &[f64], i: usize) -> Option<&'static str> {
    unless(
        i > 0 || v.iter().any(|x| *x != 0.0),
        "an axis that is not zero",
    )
}

/// A field of view, degrees.
pub(crate) fn field_of_view(v: &[f64], i: usize) -> Option<&'static str> {
    unless(
        v[i] > 0.0 && v[i] < 180.0,
        "more than 0 and less than 180 degrees",
    )
}

pub(crate) fn is_whole(x: f64, least: f64, most: f64) -> bool {
    x.fract() == 0.0 && (least..=most).contains(&x)
}

pub(crate) fn count(v: &[f64], i: usize) -> Option<&'static str> {
    let fits = is_whole(v[i], 1.0, f64::from(u32::MAX));
    unless(fits, "a whole number, 1 or more")
}

pub(crate) fn number_from_0(v: &[f64], i: usize) -> Option<&'static str> {
    let fits = is_whole(v[i], 0.0, f64::from(u32::MAX));
    unless(fits, "a whole number, 0 or more")
}

pub(crate) fn octaves(v: &[f64], i: usize) -> Option<&'static str> {
    unless(is_whole(v[i], 1.0, 16.0), "a whole number, 1 to 16")
}

pub(crate) fn texels(v: &[f64], i: usize) -> Option<&'static str> {
    let fits = is_whole(v[i], 1.0, 16_384.0);
    unless(fits, "a whole number of texels, 1 to 16384")
}

impl Arg {
    /// The least and the largest number of values.
    pub(super) fn range(&self) -> (usize, usize) {
        match self {
            Numbers(names, _) | Self::Floats(names, _) => {
                let count = names.split(' ').count();
                (count, count)
            }
            Frame => (9, 9),
            OneOf(_) | Method(..) | Name(_) | File | Text(_) => (1, 1),
            // The readers of faces count their own values.
            Corners | TexturedCorners => (0, usize::MAX),
            Optional(args) => (0, range(args).1),
            Options(_) => (0, usize::MAX),
            Either(alternatives) => {
                let ranges = alternatives.iter().map(|args| range(args));
                ranges.fold((usize::MAX, 0), |(a, b), (c, d)| (a.min(c), b.max(d)))
            }
        }
    }

    /// Adds the words that a line may have here.
    fn words(&self, out: &mut Vec<&'static str>) {
        match self {
            OneOf(words) => out.extend(*words),
            Optional(args) => args.iter().for_each(|arg| arg.words(out)),
            Options(lists) | Either(lists) => {
                lists
                    .iter()
                    .flat_map(|args| args.iter())
                    .for_each(|arg| arg.words(out));
            }
            _ => {}
        }
    }

    /// The arguments of which a line has one here.
    fn leaves(&self, quote: &str) -> Vec<String> {
        match self {
            OneOf(words) => words
                .iter()
                .map(|word| format!("{quote}{word}{quote}"))
                .collect(),
            Either(lists) if lists.iter().all(|args| args.len() == 1) => {
                let args = lists.iter().flat_map(|args| args.iter());
                args.flat_map(|arg| arg.leaves(quote)).collect()
            }
            _ => vec![self.usage(quote)],
        }
    }

    /// The argument in words; `quote` stands around what is written as it is.
    fn usage(&self, quote: &str) -> String {
        let list = |args: &&[Self]| usage(args, quote);
        match self {
            Numbers(names, _) | Self::Floats(names, _) => (*names).to_owned(),
            Frame => "Ox Oy Oz Ux Uy Uz Vx Vy Vz".to_owned(),
            OneOf(_) => alternatives(self.leaves(quote)),
            Method(name, ..) => (*name).to_owned(),
            Name(_) => "NAME".to_owned(),
            File => "FILE".to_owned(),
            Text(_) => "WORDS".to_owned(),
            Corners => "i1 i2 ... in".to_owned(),
            TexturedCorners => "(i u v) n times".to_owned(),
            Optional(args) => format!("[{}]", list(args)),
            Options(options) => {
                let options: Vec<_> = options
                    .iter()
                    .map(|args| format!("[{}]", list(args)))
                    .collect();
                options.join(" ")
            }
            Either(lists) if lists.iter().all(|args| args.len() == 1) => {
                alternatives(self.leaves(quote))
            }
            Either(lists) => lists.iter().map(list).collect::<Vec<_>>().join(", or "),
        }
    }
}

/// The least and the largest number of values of a list of arguments.
pub(super) fn range(args: &[Arg]) -> (usize, usize) {
    args.iter().fold((0, 0), |(least, most), arg| {
        let (a, b) = arg.range();
        (least + a, most.saturating_add(b))
    })
}

/// The words that a line of these arguments may have.
pub(super) fn words(args: &[Arg]) -> Vec<&'static str> {
    let mut out = Vec::new();
    args.iter().for_each(|arg| arg.words(&mut out));
    out
}

/// A list of arguments in words; `quote` stands around what is written as it is.
pub(crate) fn usage(args: &[Arg], quote: &str) -> String {
    let alone = args.len() == 1;
    let args: Vec<_> = args
        .iter()
        .map(|arg| match arg {
            OneOf(_) | Either(_) if !alone && arg.leaves(quote).len() > 1 => {
                format!("({})", arg.usage(quote))
            }
            _ => arg.usage(quote),
        })
        .collect();
    args.join(" ")
}

/// `a, b or c`.
fn alternatives(mut list: Vec<String>) -> String {
    let last = list.pop().unwrap_or_default();
    match list.is_empty() {
        true => last,
        false => format!("{} or {last}", list.join(", ")),
    }
}
