//! The manifest of a batch: items with ids, outputs and settings of their own, as JSON.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use texmap_io::{FileSource, shortened};

use crate::cmd::batch::args::BatchVerb;
use crate::cmd::batch::settings::Settings;
use crate::failure::{Exit, Failure};

/// Version of the schema.
const VERSION: u32 = 1;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File1 {
    version: u32,
    verb: Option<String>,
    #[serde(default)]
    settings: Given,
    items: Vec<Object<Entry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    id: Option<String>,
    input: String,
    output: Option<String>,
    #[serde(default)]
    settings: Given,
}

/// An object by its names: the values of a structure may stand in an array, too, for serde.
#[derive(Debug)]
struct Object<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(ObjectVisitor(PhantomData))
    }
}

struct ObjectVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for ObjectVisitor<T> {
    type Value = Object<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Object)
    }
}

/// Settings as they are given, each once.
#[derive(Debug, Default)]
struct Given(BTreeMap<String, Value>);

impl<'de> Deserialize<'de> for Given {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(GivenVisitor)
    }
}

struct GivenVisitor;

impl<'de> Visitor<'de> for GivenVisitor {
    type Value = Given;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of settings")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut all = BTreeMap::new();
        while let Some((name, value)) = map.next_entry::<String, Value>()? {
            if all.contains_key(&name) {
                return Err(A::Error::custom(format_args!(
                    "the setting `{name}` is given twice"
                )));
            }
            all.insert(name, value);
        }
        Ok(Given(all))
    }
}

/// An item as a manifest names it.
#[derive(Debug)]
pub(crate) struct ManifestItem {
    pub(crate) id: Option<String>,
    pub(crate) input: PathBuf,
    pub(crate) output: Option<PathBuf>,
    pub(crate) settings: Settings,
}

/// A manifest: items, and the settings of all of them.
#[derive(Debug)]
pub(crate) struct Manifest {
    pub(crate) settings: Settings,
    pub(crate) items: Vec<ManifestItem>,
}

/// True if an input is a manifest by its name.
pub(crate) fn is_manifest(input: &Path) -> bool {
    let ending = input.extension().and_then(|e| e.to_str());
    ending.is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

impl Manifest {
    /// Reads a manifest. Its inputs and outputs are named from its folder.
    ///
    /// # Errors
    /// Files that are missing or no manifest, with line and column; another version or verb; unknown settings.
    pub(crate) fn read(path: &Path, verb: BatchVerb) -> Result<Self, Failure> {
        let refused = |what: String, why: &str| {
            let what = format!("{}: {what}", path.display());
            Failure::new(Exit::Input, "manifest", what, why)
        };
        let why = "docs/batch.md has the schema of manifests";
        let text = FileSource::anywhere().read_text(path, FileSource::MAX_LIST)?;
        let Object(file): Object<File1> = serde_json::from_str(&text)
            .map_err(|e| refused(shortened(&e.to_string()).to_string(), why))?;
        if file.version != VERSION {
            let what = format!(
                "a manifest of version {}; this program reads {VERSION}",
                file.version
            );
            return Err(refused(what, why));
        }
        if let Some(name) = file.verb.filter(|name| name != verb.name()) {
            return Err(refused(
                format!(
                    "a manifest of `{name}`, and the batch is of `{}`",
                    verb.name()
                ),
                &format!("run `texmap batch {name} {}`", path.display()),
            ));
        }
        if file.items.is_empty() {
            return Err(refused("the manifest has no items".to_owned(), why));
        }
        let settings = Settings::of_json(verb, &file.settings.0)
            .map_err(|what| refused(format!("settings of all items: {what}"), why))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let items = file
            .items
            .into_iter()
            .zip(0..)
            .map(|(Object(entry), number)| {
                let own = Settings::of_json(verb, &entry.settings.0).map_err(|what| {
                    let name = entry.id.clone().unwrap_or_else(|| format!("{number}"));
                    refused(format!("item {name}: {what}"), why)
                })?;
                Ok(ManifestItem {
                    id: entry.id.or_else(|| Some(entry.input.clone())),
                    input: folder.join(&entry.input),
                    output: entry.output.map(|output| folder.join(output)),
                    settings: own,
                })
            });
        Ok(Self {
            items: items.collect::<Result<_, Failure>>()?,
            settings,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Manifest, Failure> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("all.json");
        std::fs::write(&path, text).unwrap();
        let mut manifest = Manifest::read(&path, BatchVerb::Render)?;
        for item in &mut manifest.items {
            item.input = item.input.strip_prefix(dir.path()).unwrap().to_owned();
        }
        Ok(manifest)
    }

    #[test]
    fn items_have_ids_and_settings() {
        let manifest = read(
            r#"{"version":1,"settings":{"fov":30},"items":[{"input":"a.obj"},{"id":"b","input":"x/b.obj","settings":{"fov":40}}]}"#,
        )
        .unwrap();
        assert_eq!(manifest.settings.words(), ["--fov=30"]);
        let [a, b] = &manifest.items[..] else {
            panic!()
        };
        assert_eq!(
            (a.id.as_deref(), b.id.as_deref()),
            (Some("a.obj"), Some("b"))
        );
        assert_eq!(b.input, Path::new("x/b.obj"));
        assert_eq!(b.settings.words(), ["--fov=40"]);
    }

    #[test]
    fn faults_are_named_with_their_place() {
        for (bad, word) in [
            (r#"{"version":2,"items":[{"input":"a"}]}"#, "version 2"),
            (r#"{"version":1,"items":[]}"#, "no items"),
            (
                r#"{"version":1,"verb":"bake","items":[{"input":"a"}]}"#,
                "`bake`",
            ),
            (
                r#"{"version":1,"items":[{"id":"b","input":"a","settings":{"x":1}}]}"#,
                "item b: `x`",
            ),
            ("{\"version\":1,\n\"itens\":[]}", "line 2"),
            (r#"[1,"render",{},[{"input":"a"}]]"#, "expected an object"),
            (
                r#"{"version":1,"items":[["b","a",null,{}]]}"#,
                "expected an object",
            ),
            (
                "{\"version\":1,\"items\":[{\"input\":\"a\",\"settings\":{\"fov\":1,\n\"fov\":2}}]}",
                "`fov` is given twice at line 2",
            ),
            (
                r#"{"version":1,"settings":{"resolution":null},"items":[{"input":"a"}]}"#,
                "settings of all items: `resolution`: expected a number",
            ),
            (
                r#"{"version":1,"items":[{"input":"a","settings":{"resolution":false}}]}"#,
                "item 0: `resolution`: expected a number",
            ),
            (
                r#"{"version":1,"items":[{"input":1}]}"#,
                "expected a string",
            ),
        ] {
            let failure = read(bad).unwrap_err();
            assert!(failure.what.contains(word), "{}", failure.what);
        }
    }
}
