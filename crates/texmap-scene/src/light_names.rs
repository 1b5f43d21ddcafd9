//! Names of lights, by which their shadows are asked for.

use crate::{Scene, SceneError};

/// True if a light may have this name: letters, digits, `-` and `_`, not digits alone (those are its number).
#[must_use]
pub fn is_light_name(name: &str) -> bool {
    let known = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    !name.is_empty() && name.chars().all(known) && !name.chars().all(|c| c.is_ascii_digit())
}

impl Scene {
    /// The index of the light of this name.
    ///
    /// # Errors
    /// [`SceneError::UnknownLight`] lists the names that there are.
    pub fn light_named(&self, light: &str) -> Result<usize, SceneError> {
        let names = &self.effects.light_names;
        names
            .iter()
            .position(|known| known == light)
            .ok_or_else(|| {
                let named = names
                    .iter()
                    .enumerate()
                    .filter(|(_, name)| !name.is_empty());
                let list: Vec<_> = named
                    .map(|(number, name)| format!("'{name}' (light {number})"))
                    .collect();
                SceneError::UnknownLight {
                    name: light.to_owned(),
                    known: match list.len() {
                        0 => "are no names: a `name` line below a light gives it one".to_owned(),
                        1 => format!("is {}", list[0]),
                        _ => format!("are {}", list.join(", ")),
                    },
                }
            })
    }

    /// Names belong to lights, say who is meant, and are each other's only.
    pub(crate) fn check_light_names(&self) -> Result<(), SceneError> {
        let names = &self.effects.light_names;
        for (number, name) in names.iter().enumerate() {
            let twice = names[..number].contains(name);
            let lost = number >= self.lights.len();
            if !name.is_empty() && (!is_light_name(name) || twice || lost) {
                return Err(SceneError::Value {
                    place: format!("light {number}"),
                    what: "name".to_owned(),
                    value: format!("'{name}'"),
                    expected: "each name belongs to one light of the scene, and is of letters, digits, - and _, not digits alone",
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_words() {
        for name in ["sun", "lamp-2", "left_eye", "2nd", "Lampe", "\u{fc}"] {
            assert!(is_light_name(name), "{name}");
        }
        for name in ["", "2", "007", "a b", "a/b", "a:b", "a.b", "\u{2026}"] {
            assert!(!is_light_name(name), "{name}");
        }
    }
}
