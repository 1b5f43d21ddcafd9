//! Items and units of a batch, named and checked before anything runs.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use texmap_io::{FileSource, PictureFormat};

use crate::args::Verb;
use crate::cmd::bake;
use crate::cmd::batch::args::{BatchArgs, BatchVerb, UnitName};
use crate::cmd::batch::files::hash_of_parts;
use crate::cmd::batch::manifest::{Manifest, is_manifest};
use crate::cmd::batch::outputs::{Verbs, check, told_apart};
use crate::cmd::batch::settings::Settings;
use crate::cmd::render::inputs::listed;
use crate::failure::{Exit, Failure};
use crate::os_name;
use crate::values::{Part, Ranges};

/// An input with its output and settings.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub(crate) id: String,
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) settings: Settings,
    /// The manifest that names it, for messages.
    pub(crate) manifest: Option<Arc<str>>,
}

/// A part of an item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum UnitPart {
    Whole,
    /// A picture of a series, by its number from 0.
    Picture(u32),
    /// A band of the picture.
    Band(Part),
    /// An object, by its name.
    Page(String),
}

/// A part of the batch that is given out to a shard and a job.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    pub(crate) id: String,
    /// Index of its item.
    pub(crate) item: usize,
    pub(crate) part: UnitPart,
}

/// The folder of the state in that of the outputs.
pub(crate) const STATE: &str = ".texmap";

/// A batch, planned.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) verb: BatchVerb,
    pub(crate) items: Vec<Item>,
    /// Sorted by id.
    pub(crate) units: Vec<Unit>,
    /// The folder of all outputs.
    pub(crate) base: PathBuf,
    /// The folder of markers and reports.
    pub(crate) state: PathBuf,
    /// Hash of all ids.
    pub(crate) units_hash: String,
    /// Hash of all settings.
    pub(crate) settings_hash: String,
}

impl Plan {
    /// Reads lists and manifests, and names every unit.
    ///
    /// # Errors
    /// Everything that would fail for each item: settings, names that clash, units that the verb does not have.
    pub(crate) fn new(args: &BatchArgs) -> Result<Self, Failure> {
        let mut items = items(args)?;
        items.sort_by(|a, b| a.id.cmp(&b.id));
        if let Some(pair) = items.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(Failure::usage(
                format!("two items have the id `{}`", pair[0].id),
                "name each input once, or give the items of a manifest different ids",
            ));
        }
        told_apart(args.verb, &items)?;
        let mut units = units(args, &items)?;
        units.sort_by(|a, b| a.id.cmp(&b.id));
        let base = base(args, &items);
        for item in &items {
            for flag in OUTPUTS {
                let mut values = item.settings.values(flag);
                if let Some(outside) = values.find(|value| !lies_in(&base, Path::new(value))) {
                    return Err(Failure::usage(
                        format!(
                            "--{flag} {outside}: it lies outside of `{}`, the folder of the outputs",
                            base.display()
                        ),
                        "name a path that begins with this folder: shards are merged and resumed by it",
                    ));
                }
            }
        }
        let state = args.flags.state.clone();
        Ok(Self {
            verb: args.verb,
            units_hash: hash_of_parts(units.iter().map(|unit| unit.id.as_str())),
            settings_hash: hash_of_parts(items.iter().flat_map(|item| {
                let words = item.settings.words();
                [vec![item.id.clone()], words].concat()
            })),
            state: state.unwrap_or_else(|| base.join(STATE)),
            items,
            units,
            base,
        })
    }

    /// The folder of the outputs as a report names it: `..` where the state has its default place, so that both can be moved.
    pub(crate) fn folder_of_report(&self) -> String {
        if self.state == self.base.join(STATE) {
            return "..".to_owned();
        }
        let whole = std::path::absolute(&self.base).unwrap_or_else(|_| self.base.clone());
        whole.to_string_lossy().into_owned()
    }

    pub(crate) fn item(&self, unit: &Unit) -> &Item {
        &self.items[unit.item]
    }

    /// Hash of all that is asked of a unit but its input.
    pub(crate) fn hash_of_settings(&self, unit: &Unit) -> String {
        let mut words = vec![self.verb.name().to_owned()];
        words.extend(self.item(unit).settings.words());
        hash_of_parts(words)
    }

    /// The output of a unit, as far as it is known by name: pictures of a series are named by the verb.
    pub(crate) fn output(&self, unit: &Unit) -> String {
        let output = &self.item(unit).output;
        match &unit.part {
            UnitPart::Band(part) => {
                let path = Path::new(output);
                let digits = part.count.to_string().len();
                let ending = format!("band-{:0digits$}-of-{}.png", part.index, part.count);
                path.with_extension(ending).to_string_lossy().into_owned()
            }
            _ => output.clone(),
        }
    }

    /// The command line that runs units of one item: one unit, or several pictures.
    pub(crate) fn words(&self, units: &[&Unit], threads: u16) -> Vec<String> {
        let Some(first) = units.first() else {
            return Vec::new();
        };
        let item = self.item(first);
        let mut words = words(self.verb, item, &self.output(first));
        let pictures = units.iter().filter_map(|unit| match unit.part {
            UnitPart::Picture(number) => Some(u64::from(number)),
            _ => None,
        });
        let pictures = Ranges::of(pictures);
        let mut more = Vec::new();
        match &first.part {
            UnitPart::Whole => {}
            UnitPart::Picture(_) => more.push(format!("--only={pictures}")),
            UnitPart::Band(part) => more.push(format!("--band={part}")),
            UnitPart::Page(object) => {
                words.retain(|word| !word.starts_with("--object="));
                more.push(format!("--object={object}"));
            }
        }
        // A picture is drawn by the threads of the process.
        if self.verb != BatchVerb::Render && self.verb.has_threads() {
            more.push(format!("--threads={threads}"));
        }
        words.splice(2..2, more);
        words
    }
}

/// Flags of verbs that name outputs beside `--output`.
pub(super) const OUTPUTS: [&str; 2] = ["tangents", "pictures"];

/// True if a path leads into a folder, by its words.
fn lies_in(folder: &Path, path: &Path) -> bool {
    let plain = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
    match folder.as_os_str().is_empty() {
        true => path.components().all(plain),
        false => path
            .strip_prefix(folder)
            .is_ok_and(|rest| rest.components().all(plain)),
    }
}

/// The command line of an item.
pub(super) fn words(verb: BatchVerb, item: &Item, output: &str) -> Vec<String> {
    let mut words = vec!["texmap".to_owned(), verb.name().to_owned()];
    words.extend(item.settings.words());
    words.push(format!("--output={output}"));
    words.push("--".to_owned());
    words.push(item.input.clone());
    words
}

/// A unit's place in its item, with as many digits as the last one has.
fn numbered(item: &str, number: u32, of: usize) -> String {
    let digits = of.saturating_sub(1).max(1).to_string().len();
    format!("{item}#{number:0digits$}")
}

fn items(args: &BatchArgs) -> Result<Vec<Item>, Failure> {
    let mut items = Vec::new();
    for input in &args.inputs {
        if is_manifest(input) {
            let manifest = Manifest::read(input, args.verb)?;
            let common = manifest.settings.with(&args.settings);
            let name: Arc<str> = input.to_string_lossy().into();
            for entry in manifest.items {
                // The command line comes last: it is the nearest.
                let settings = manifest.settings.with(&entry.settings).with(&args.settings);
                let settings = match entry.settings == Settings::default() {
                    true => common.clone(),
                    false => settings,
                };
                let item = item(args, entry.id, &entry.input, entry.output, settings)?;
                items.push(Item {
                    manifest: Some(Arc::clone(&name)),
                    ..item
                });
            }
            continue;
        }
        let bytes = os_name::bytes(input.as_os_str());
        let names = match bytes.strip_prefix(b"@") {
            Some(list) if !input.exists() => {
                let list = PathBuf::from(os_name::of_bytes(list.to_vec()));
                listed(&list, &FileSource::anywhere())?
            }
            _ => vec![input.clone()],
        };
        for name in names {
            items.push(item(args, None, &name, None, args.settings.clone())?);
        }
    }
    Ok(items)
}

fn item(
    args: &BatchArgs,
    id: Option<String>,
    input: &Path,
    output: Option<PathBuf>,
    settings: Settings,
) -> Result<Item, Failure> {
    let text = |path: &Path| {
        path.to_str().map(str::to_owned).ok_or_else(|| {
            Failure::usage(
                format!("{}: a name that is no Unicode", path.display()),
                "rename the file: reports and markers are JSON",
            )
        })
    };
    let id = id.map_or_else(|| text(input), Ok)?;
    // The standard input of a process of the batch has its tasks.
    if input == Path::new("-") {
        return Err(Failure::usage(
            format!("{id}: a batch does not read standard input"),
            "name files, @LIST or a manifest of files; a file of this name is ./-",
        ));
    }
    let output = match (output, &args.output) {
        (Some(output), _) => output,
        (None, Some(template)) => named(args.verb, template, &id, input),
        (None, None) => {
            return Err(Failure::usage(
                format!("{id}: no output is named"),
                "add -o 'out/{model}.png', or `output` to the item of the manifest",
            ));
        }
    };
    if output == Path::new("-") {
        return Err(Failure::usage(
            "-o -: the outputs of a batch are files",
            "name a folder, or a name with {model}",
        ));
    }
    let of_item = |value: &str| {
        let name = filled(value.into(), &id, input);
        text(Path::new(&name))
    };
    Ok(Item {
        input: text(input)?,
        output: text(&output)?,
        settings: settings.replaced(&OUTPUTS, of_item)?,
        id,
        manifest: None,
    })
}

/// The output of an input by a template.
fn named(verb: BatchVerb, output: &Path, id: &str, input: &Path) -> PathBuf {
    let bytes = os_name::bytes(output.as_os_str());
    let template = match bytes.ends_with(b"/") || output.is_dir() {
        true => output.join(verb.template()),
        false => output.to_owned(),
    };
    filled(template.into_os_string(), id, input).into()
}

/// A template with the words of an input.
fn filled(mut name: OsString, id: &str, input: &Path) -> OsString {
    let folder = input.parent().filter(|p| !p.as_os_str().is_empty());
    let model = input.file_stem().unwrap_or_default();
    for (word, by) in [
        ("{model}", model),
        ("{dir}", folder.unwrap_or(Path::new(".")).as_os_str()),
        ("{id}", OsStr::new(id)),
    ] {
        name = os_name::replaced(&name, word, by);
    }
    name
}

/// The folder that holds all outputs: the template up to its first placeholder, or the folder around those that a manifest names.
fn base(args: &BatchArgs, items: &[Item]) -> PathBuf {
    let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
    let plain = match &args.output {
        Some(output) if output.is_dir() || output.to_string_lossy().ends_with('/') => {
            output.clone()
        }
        Some(output) => {
            let text = output.to_string_lossy();
            let end = text.find(['{', '%']).unwrap_or(text.len());
            let end = text[..end].rfind('/').map_or(0, |slash| slash + 1);
            PathBuf::from(&text[..end])
        }
        None => {
            let mut outputs = items.iter().map(|item| folder(Path::new(&item.output)));
            let first = outputs.next().unwrap_or_default();
            outputs.fold(first, |common, next| {
                let pairs = common.components().zip(next.components());
                let same = pairs.take_while(|(a, b)| a == b);
                same.map(|(part, _)| part).collect()
            })
        }
    };
    match plain.as_os_str().is_empty() {
        true => PathBuf::from("."),
        false => plain,
    }
}

fn units(args: &BatchArgs, items: &[Item]) -> Result<Vec<Unit>, Failure> {
    let mut units = Vec::with_capacity(items.len());
    let mut verbs = Verbs::new(args.verb);
    for (item, index) in items.iter().zip(0..) {
        let unit = |id: String, part: UnitPart| Unit {
            id,
            item: index,
            part,
        };
        let checked = verbs.of(item)?;
        if let Some(count) = args.flags.bands {
            bands_fit(args, item, &checked.verb)?;
            let digits = count.to_string().len();
            units.extend((1..=count).map(|index| {
                let id = format!("{}#band-{index:0digits$}-of-{count}", item.id);
                unit(id, UnitPart::Band(Part { index, count }))
            }));
            continue;
        }
        match args.flags.unit {
            UnitName::Item => units.push(unit(item.id.clone(), UnitPart::Whole)),
            UnitName::Frame | UnitName::View => {
                let of = checked.pictures(item)?;
                units.extend((0..of as u32).map(|number| {
                    let id = numbered(&item.id, number, of);
                    unit(id, UnitPart::Picture(number))
                }));
            }
            UnitName::Page => {
                let Verb::Bake(bake) = check(args.verb, item)? else {
                    return Err(Failure::usage(
                        format!("--unit page: `{}` has no pages", args.verb.name()),
                        "pages are the objects of `texmap batch bake --object all`",
                    ));
                };
                let objects = bake::objects(&bake)?;
                units.extend(objects.into_iter().map(|object| {
                    let id = format!("{}#{object}", item.id);
                    unit(id, UnitPart::Page(object))
                }));
            }
        }
    }
    if let Some(twin) = twin(&units) {
        return Err(Failure::usage(
            format!("two units have the id `{twin}`"),
            "objects need names of their own (`name` lines of a scene, `o` lines of a model)",
        ));
    }
    Ok(units)
}

fn twin(units: &[Unit]) -> Option<&str> {
    let mut seen = BTreeSet::new();
    let twin = units.iter().find(|unit| !seen.insert(unit.id.as_str()));
    twin.map(|unit| unit.id.as_str())
}

fn bands_fit(args: &BatchArgs, item: &Item, verb: &Verb) -> Result<(), Failure> {
    if args.flags.unit != UnitName::Item || args.verb != BatchVerb::Render {
        return Err(Failure::usage(
            "--bands: only whole pictures of `texmap batch render` have bands",
            "leave --unit and --bands apart, or name the verb render",
        ));
    }
    if PictureFormat::of(Path::new(&item.output)) != Some(PictureFormat::Png) {
        return Err(Failure::new(
            Exit::Usage,
            "usage",
            format!("{}: bands are joined to .png", item.output),
            "end the name of the output with .png",
        ));
    }
    match verb {
        Verb::Render(render) => render.check_bands(args.flags.bands.unwrap_or(1)),
        _ => Ok(()),
    }
}
