//! The files that items will write, as far as their names are known before anything runs.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

use clap::Parser;
use texmap_io::FileSource;

use crate::args::{Cli, Verb};
use crate::cmd::batch::args::BatchVerb;
use crate::cmd::batch::plan::{Item, OUTPUTS, Plan, Unit, UnitPart, words};
use crate::cmd::batch::settings::Settings;
use crate::cmd::render::plan::{self as render, Kind};
use crate::failure::Failure;

/// Refuses items of which two would write one file.
///
/// # Errors
/// Also those of settings and names that the verb refuses.
pub(super) fn told_apart(verb: BatchVerb, items: &[Item]) -> Result<(), Failure> {
    let mut verbs = Verbs::new(verb);
    let mut owner: BTreeMap<Cow<'_, Path>, &str> = BTreeMap::new();
    for item in items {
        let further = OUTPUTS.iter().flat_map(|flag| item.settings.values(flag));
        let further = further.map(|name| Cow::Borrowed(Path::new(name)));
        let main = Path::new(&item.output);
        let files = verbs.of(item)?.files(item)?;
        // A name that stands in the item already takes no memory again: lists have millions.
        let files = files.into_iter().flatten().map(|file| match file == main {
            true => Cow::Borrowed(main),
            false => Cow::Owned(file),
        });
        for file in further.chain(files) {
            if let Some(other) = owner.get(&file) {
                let both = match *other == item.id {
                    true => format!("{other} would write {} twice", file.display()),
                    false => format!(
                        "{other} and {} would both write {}",
                        item.id,
                        file.display()
                    ),
                };
                return Err(Failure::usage(
                    both,
                    "put {model}, {dir} or {id} into the name, with a character between it and a number ({model}-%03d.png), or name other outputs",
                ));
            }
            owner.insert(file, &item.id);
        }
    }
    Ok(())
}

impl Plan {
    /// The files of units in their order, as far as they are known by name: names of objects are left out.
    pub(super) fn files(&self, units: &[(usize, &Unit)]) -> Result<Vec<PathBuf>, Failure> {
        let mut verbs = Verbs::new(self.verb);
        let mut all = Vec::new();
        for units in units.chunk_by(|(_, a), (_, b)| a.item == b.item) {
            let Some((_, first)) = units.first() else {
                continue;
            };
            let item = self.item(first);
            let mut pictures = verbs.of(item)?.files(item)?;
            for (_, unit) in units {
                match unit.part {
                    UnitPart::Picture(number) => {
                        let files = pictures.get_mut(number as usize);
                        all.extend(files.map(std::mem::take).unwrap_or_default());
                    }
                    UnitPart::Band(_) => all.push(self.output(unit).into()),
                    UnitPart::Whole | UnitPart::Page(_) => {
                        all.extend(pictures.iter().flatten().cloned());
                    }
                }
            }
        }
        all.retain(|file| self.verb == BatchVerb::Render || !file.to_string_lossy().contains('{'));
        Ok(all)
    }
}

/// The verb as it reads the settings of an item.
#[derive(Debug)]
pub(super) struct Checked {
    pub(super) verb: Verb,
    /// Names of the pictures of a series.
    shots: Option<Vec<Option<String>>>,
}

impl Checked {
    fn new(verb: BatchVerb, item: &Item) -> Result<Self, Failure> {
        let verb = check(verb, item)?;
        let shots = match &verb {
            Verb::Render(args) => {
                let camera = args.camera();
                camera.names(&camera.list(&FileSource::anywhere())?)
            }
            _ => None,
        };
        Ok(Self { verb, shots })
    }

    fn kind(&self, item: &Item) -> Result<Kind, Failure> {
        match &self.verb {
            Verb::Render(args) => {
                render::kind(args, Some(Path::new(&item.output)), self.shots.as_deref())
            }
            _ => Ok(Kind::Single),
        }
    }

    /// The files of an item, by picture. Of verbs other than `render` they are the output as it is named.
    fn files(&self, item: &Item) -> Result<Vec<Vec<PathBuf>>, Failure> {
        let Verb::Render(args) = &self.verb else {
            return Ok(vec![vec![item.output.clone().into()]]);
        };
        let of_verb = render::Item {
            input: item.input.clone().into(),
            output: Some(item.output.clone().into()),
            kind: self.kind(item)?,
        };
        Ok(of_verb.files(args))
    }

    /// Pictures of an item that has one file for each.
    pub(super) fn pictures(&self, item: &Item) -> Result<usize, Failure> {
        let one = |what: &str| {
            Failure::usage(
                format!("{}: {what}", item.id),
                "--unit frame and view are of several pictures with a file each: add --turntable, --frames, --cameras or --views, and a place \
                 for the number or {view} in the name",
            )
        };
        match self.kind(item)? {
            Kind::Series(names) => Ok(names.len()),
            Kind::Single if matches!(self.verb, Verb::Render(_)) => {
                Err(one("there is one picture"))
            }
            Kind::Single => Err(one("this verb makes one picture")),
            Kind::Sheet | Kind::Animation(_) => Err(one("all pictures are in one file")),
        }
    }
}

/// The verbs of items, read once for those of equal settings.
pub(super) struct Verbs<'a> {
    verb: BatchVerb,
    read: BTreeMap<&'a Settings, Checked>,
}

impl<'a> Verbs<'a> {
    /// Settings that are kept: a manifest may have others for each of a million items.
    const KEPT: usize = 1024;

    pub(super) fn new(verb: BatchVerb) -> Self {
        Self {
            verb,
            read: BTreeMap::new(),
        }
    }

    pub(super) fn of(&mut self, item: &'a Item) -> Result<&Checked, Failure> {
        if self.read.len() >= Self::KEPT && !self.read.contains_key(&item.settings) {
            self.read.clear();
        }
        match self.read.entry(&item.settings) {
            Entry::Occupied(read) => Ok(read.into_mut()),
            Entry::Vacant(free) => Ok(free.insert(Checked::new(self.verb, item)?)),
        }
    }
}

/// The verb as it reads the command line of an item.
pub(super) fn check(verb: BatchVerb, item: &Item) -> Result<Verb, Failure> {
    let words = words(verb, item, &item.output);
    match Cli::try_parse_from(&words) {
        Ok(cli) => match cli.verb {
            Verb::Uv(uv) if uv.prints() => Err(Failure::usage(
                format!(
                    "{}: --report and --per-triangle print what a batch does not keep",
                    item.id
                ),
                "run `texmap uv IN --json --report` for each, or leave them out",
            )),
            verb => Ok(verb),
        },
        Err(refusal) => {
            let mut failure = Failure::from(refusal);
            failure.what = match &item.manifest {
                Some(manifest) => format!("{manifest}: item {}: {}", item.id, failure.what),
                None => format!("{}: {}", item.id, failure.what),
            };
            Err(failure)
        }
    }
}
