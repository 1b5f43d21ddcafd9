//! MTL statements that are known and not drawn. Each is reported once for its library if it changes a picture.

use crate::SourceLocation;

/// Statements and their effects that are lost.
const STATEMENTS: [(&str, &str); 21] = [
    ("Ka", "ambient light takes the colour of `Kd`"),
    ("Tf", "light is not coloured on its way through"),
    ("Ni", "light is not refracted"),
    ("sharpness", "reflections keep their sharpness"),
    ("Pr", "roughness is that of `Ns`"),
    ("Pm", "metals are drawn as other surfaces"),
    ("Ps", "there is no sheen"),
    ("Pc", "there is no clear coat"),
    ("Pcr", "there is no clear coat"),
    ("aniso", "highlights are round"),
    ("anisor", "highlights are round"),
    ("map_Pr", "roughness is that of `Ns`"),
    ("map_Pm", "metals are drawn as other surfaces"),
    ("map_Ps", "there is no sheen"),
    ("map_RMA", "roughness, metalness and occlusion are not read"),
    ("map_ORM", "roughness, metalness and occlusion are not read"),
    (
        "map_refl",
        "nothing is mirrored; `env` in a scene does that",
    ),
    ("refl", "nothing is mirrored; `env` in a scene does that"),
    ("decal", "`decal` in a scene puts a label over a texture"),
    ("map_aat", "`--msaa 4` smooths edges"),
    ("map_Tr", "write the map as `map_d`, where 1 is opaque"),
];

/// Statements of one library that are not drawn.
#[derive(Debug, Default)]
pub(super) struct NotDrawn {
    /// Word, lost effect, first line and number of statements.
    told: Vec<(String, &'static str, SourceLocation, u32)>,
    /// Of the material that is read.
    kd: Option<Vec<f32>>,
    ka: Option<(SourceLocation, Vec<f32>)>,
    ni: Option<SourceLocation>,
    opacity: Option<f32>,
}

impl NotDrawn {
    pub(super) fn next_material(&mut self) {
        // An ambient colour that is black, white or the diffuse one changes nothing.
        if let Some((location, ka)) = self.ka.take() {
            let neutral = ka.iter().all(|c| *c == 0.0) || ka.iter().all(|c| *c == 1.0);
            if !neutral && self.kd.as_ref() != Some(&ka) {
                self.note(&location, "Ka");
            }
        }
        // Nothing shines through opaque surfaces.
        if let Some(location) = self.ni.take()
            && self.opacity.is_some_and(|d| d < 1.0)
        {
            self.note(&location, "Ni");
        }
        (self.kd, self.opacity) = (None, None);
    }

    pub(super) fn base_color(&mut self, rest: &str) {
        self.kd = Some(numbers(rest));
    }

    pub(super) fn opacity(&mut self, opacity: f32) {
        self.opacity = Some(opacity);
    }

    pub(super) fn model(&mut self, location: &SourceLocation, model: f32) {
        if model >= 3.0 {
            let why = "models 3 to 10 mirror or refract; the surface is drawn as model 2";
            self.tell(location, &format!("illum {}", model as u8), why);
        }
    }

    pub(super) fn statement(&mut self, location: &SourceLocation, word: &str, rest: &str) {
        let values = numbers(rest);
        match word {
            "Ka" => self.ka = Some((location.clone(), values)),
            "Ni" => self.ni = Some(location.clone()),
            // These values are those without the statement.
            "Tf" if !values.is_empty() && values.iter().all(|c| *c == 1.0) => {}
            "Pm" | "Ps" | "Pc" | "Pcr" | "aniso" | "anisor" if values == [0.0] => {}
            _ => self.note(location, word),
        }
    }

    fn note(&mut self, location: &SourceLocation, word: &str) {
        let known = STATEMENTS.iter().find(|(known, _)| *known == word);
        self.tell(
            location,
            word,
            known.map_or("it is not known", |(_, why)| why),
        );
    }

    fn tell(&mut self, location: &SourceLocation, word: &str, why: &'static str) {
        match self.told.iter_mut().find(|(told, ..)| told == word) {
            Some((.., count)) => *count += 1,
            None => {
                let word = word.chars().take(40).collect();
                self.told.push((word, why, location.clone(), 1));
            }
        }
    }

    /// One sentence for each word, in the order of their lines.
    pub(super) fn warnings(mut self) -> Vec<String> {
        self.next_material();
        self.told.sort_by_key(|(.., location, _)| location.line);
        let told = self.told.iter().map(|(word, why, location, count)| {
            let more = match count {
                1 => String::new(),
                2 => " (1 more line says so)".to_owned(),
                n => format!(" ({} more lines say so)", n - 1),
            };
            format!("{location}: `{word}` is not drawn: {why}{more}")
        });
        told.collect()
    }
}

/// The numbers of a statement, one for all three channels; none if it says something else.
fn numbers(rest: &str) -> Vec<f32> {
    let words = rest.split_whitespace().take_while(|w| !w.starts_with('#'));
    let numbers: Result<Vec<f32>, _> = words.map(str::parse).collect();
    numbers.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn told(statements: &[(&str, &str)]) -> Vec<String> {
        let mut all = NotDrawn::default();
        for (line, (word, rest)) in (1..).zip(statements) {
            let location = SourceLocation::new(Path::new("a.mtl"), line, 1);
            match *word {
                "newmtl" => all.next_material(),
                "Kd" => all.base_color(rest),
                "d" => all.opacity(rest.parse().unwrap()),
                "illum" => all.model(&location, rest.parse().unwrap()),
                word => all.statement(&location, word, rest),
            }
        }
        all.warnings()
    }

    #[test]
    fn each_word_is_told_once_with_its_first_line() {
        let told = told(&[
            ("newmtl", "a"),
            ("Pr", "0.4"),
            ("illum", "5"),
            ("newmtl", "b"),
            ("Pr", "0.5"),
            ("Kq", "1"),
            ("Pr", "0.5"),
            ("Ka", "0.2 0.1 0"),
        ]);
        assert_eq!(told.len(), 4, "{told:?}");
        assert!(told[0].starts_with("a.mtl:2:1: `Pr` is not drawn") && told[0].contains("2 more"));
        assert!(told[1].contains("`illum 5`") && told[2].contains("not known"));
        assert!(told[3].contains("a.mtl:8:1: `Ka`"), "{told:?}");
    }

    #[test]
    fn what_changes_nothing_is_not_told() {
        let lines = [
            ("newmtl", "a"),
            ("Ka", "1 1 1"),
            ("Ni", "1.45"),
            ("d", "1"),
            ("illum", "2"),
            ("Tf", "1 1 1"),
            ("Pm", "0"),
            ("newmtl", "b"),
            ("Ka", "0.3 0.2 0.1"),
            ("Kd", "0.3 0.2 0.1"),
        ];
        assert!(told(&lines).is_empty());
        let refracts = told(&[("newmtl", "a"), ("Ni", "1.45"), ("d", "0.5")]);
        assert!(refracts[0].contains("a.mtl:2:1: `Ni`"), "{refracts:?}");
    }
}
