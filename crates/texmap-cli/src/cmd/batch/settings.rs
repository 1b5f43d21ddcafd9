//! The settings of an item: flags of its verb with their values.

use std::collections::BTreeMap;

use clap::{Arg, ArgAction, ArgMatches};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::cmd::batch::args::BatchVerb;

/// Flags without dashes, each with its occurrences and their values.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Settings(BTreeMap<String, Vec<Vec<String>>>);

impl Settings {
    /// Takes the occurrences of a flag from the command line.
    pub(crate) fn take(&mut self, arg: &Arg, matches: &ArgMatches) {
        let Some(name) = arg.get_long() else { return };
        let flag = matches!(arg.get_action(), ArgAction::SetTrue);
        let occurrences = match flag {
            true => vec![Vec::new()],
            false => {
                let all = matches.get_raw_occurrences(arg.get_id().as_str());
                let all = all.into_iter().flatten();
                all.map(|values| {
                    let values = values.map(|v| v.to_string_lossy().into_owned()).collect();
                    joined(arg, values)
                })
                .collect()
            }
        };
        self.0.insert(name.to_owned(), occurrences);
    }

    /// The settings of a JSON object: `true` is a flag alone, `false` is none, an array has several values.
    pub(crate) fn of_json(
        verb: BatchVerb,
        object: &BTreeMap<String, Value>,
    ) -> Result<Self, String> {
        let mut settings = Self::default();
        for (name, value) in object {
            let known = verb.settings().find(|arg| arg.get_long() == Some(name));
            let Some(arg) = known else {
                return Err(unknown(verb, name));
            };
            let bare = matches!(arg.get_action(), ArgAction::SetTrue);
            let occurrences = match value {
                Value::Bool(true) if bare => vec![Vec::new()],
                Value::Bool(false) if bare => continue,
                Value::Bool(_) | Value::Null if !bare => return Err(no_value(name)),
                Value::Array(all) => {
                    let words: Option<Vec<String>> = all.iter().map(word).collect();
                    let words = words.ok_or_else(|| not_plain(name))?;
                    vec![joined(&arg, words)]
                }
                plain => vec![vec![word(plain).ok_or_else(|| not_plain(name))?]],
            };
            settings.0.insert(name.clone(), occurrences);
        }
        Ok(settings)
    }

    /// These settings, and those of `over` in place of the ones of their names.
    pub(crate) fn with(&self, over: &Self) -> Self {
        let mut all = self.0.clone();
        all.extend(over.0.clone());
        Self(all)
    }

    /// The single values of a flag.
    pub(crate) fn values(&self, flag: &str) -> impl Iterator<Item = &str> {
        let all = self.0.get(flag).into_iter().flatten().flatten();
        all.map(String::as_str)
    }

    /// The settings with other values of some flags.
    ///
    /// # Errors
    /// Those of `with`.
    pub(crate) fn replaced<E>(
        mut self,
        flags: &[&str],
        with: impl Fn(&str) -> Result<String, E>,
    ) -> Result<Self, E> {
        for (flag, occurrences) in &mut self.0 {
            if flags.contains(&flag.as_str()) {
                for value in occurrences.iter_mut().flatten() {
                    *value = with(value)?;
                }
            }
        }
        Ok(self)
    }

    /// Words of a command line.
    pub(crate) fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        for (name, occurrences) in &self.0 {
            for values in occurrences {
                match &values[..] {
                    [] => words.push(format!("--{name}")),
                    [one] => words.push(format!("--{name}={one}")),
                    several => {
                        words.push(format!("--{name}"));
                        words.extend(several.iter().cloned());
                    }
                }
            }
        }
        words
    }
}

/// Values that a delimiter separates are one word.
fn joined(arg: &Arg, values: Vec<String>) -> Vec<String> {
    match arg.get_value_delimiter() {
        Some(delimiter) => vec![values.join(&delimiter.to_string())],
        None if arg.get_num_args().is_some_and(|n| n.max_values() > 1) => values,
        None => vec![values.join(",")],
    }
}

fn word(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

fn not_plain(name: &str) -> String {
    format!("`{name}`: expected true, false, a number, a string, or an array of numbers or strings")
}

fn no_value(name: &str) -> String {
    format!("`{name}`: expected a number, a string, or an array of numbers or strings")
}

fn unknown(verb: BatchVerb, name: &str) -> String {
    let names: Vec<String> = verb
        .settings()
        .filter_map(|arg| arg.get_long().map(str::to_owned))
        .collect();
    format!(
        "`{name}` is no setting of `{}`: they are its flags without dashes, {}",
        verb.name(),
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Vec<String>, String> {
        let object = serde_json::from_str(text).unwrap();
        Settings::of_json(BatchVerb::Render, &object).map(|s| s.words())
    }

    #[test]
    fn objects_become_flags() {
        assert_eq!(
            of(
                r#"{"resolution":"64x32","strict":true,"explain":false,"views":["front","top"],"fov":30.5,"camera-eye":[1,2,-3]}"#
            ),
            Ok(vec![
                "--camera-eye=1,2,-3".into(),
                "--fov=30.5".into(),
                "--resolution=64x32".into(),
                "--strict".into(),
                "--views=front,top".into(),
            ])
        );
        for (bad, word) in [
            (r#"{"resolutoin":"64x32"}"#, "resolutoin"),
            (r#"{"output":"a.png"}"#, "output"),
            (r#"{"threads":2}"#, "threads"),
            (r#"{"fov":{"x":1}}"#, "fov"),
            (r#"{"fov":true}"#, "expected a number"),
            (r#"{"strict":null}"#, "expected true"),
        ] {
            assert!(of(bad).unwrap_err().contains(word), "{bad}");
        }
    }

    #[test]
    fn later_settings_replace_those_of_their_names() {
        let settings = |text: &str| {
            let object = serde_json::from_str(text).unwrap();
            Settings::of_json(BatchVerb::Render, &object).unwrap()
        };
        let all = settings(r#"{"fov":30,"strict":true}"#).with(&settings(r#"{"fov":40}"#));
        assert_eq!(all.words(), ["--fov=40", "--strict"]);
    }
}
