//! Material libraries: `Kd Ks Ke Ns d Tr illum` and `map_Kd map_d map_Ka map_Ks map_Ke map_Ns map_Bump bump disp norm` with the
//! options `-s -o -clamp -bm`, and for models that stand alone `Pr Pm Ps Pc Pcr` with their maps. Statements that are not drawn are
//! named in warnings.
//!
//! Source of the format: Wavefront, "MTL material format", version 4.2 (1995); of the letters with a P: Exocortex, "Extending the
//! Wavefront MTL format to support PBR" (2015).

mod values;

use std::path::Path;

use super::not_drawn::NotDrawn;
use crate::textures::Textures;
use crate::{IoError, SourceLocation};

pub(super) use values::Map;
use values::{color, count, in_range, map, one, rgb, share};

/// A material as its library describes it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Description {
    pub(super) name: String,
    /// sRGB, 0 to 1.
    pub(super) kd: Option<[f32; 3]>,
    /// The largest channel of Ks.
    pub(super) ks: f32,
    /// Ke: sRGB up to 1, a linear factor above.
    pub(super) ke: Option<[f32; 3]>,
    pub(super) ns: Option<f32>,
    /// 1 is opaque.
    pub(super) d: f32,
    /// In the order of [`NUMBERS`], 0 to 1.
    pub(super) numbers: [Option<f32>; NUMBERS.len()],
    /// In the order of [`MAPS`].
    pub(super) maps: [Option<Map>; MAPS.len()],
    /// Illumination models 0 and 1 have none.
    highlight: bool,
}

impl Description {
    fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            kd: None,
            ks: 0.0,
            ke: None,
            ns: None,
            d: 1.0,
            numbers: [None; NUMBERS.len()],
            maps: Default::default(),
            highlight: true,
        }
    }

    /// A white material with a map of its colour, which `location` names.
    pub(crate) fn of_texture(name: &str, location: SourceLocation, file: &str) -> Self {
        let mut material = Self::new(name);
        material.maps[0] = Some(Map {
            location,
            name: file.to_owned(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            clamp: false,
            height: None,
        });
        material
    }

    /// True if faces need coordinates.
    pub(super) fn has_map(&self) -> bool {
        self.maps.iter().any(Option::is_some)
    }
}

/// The kinds of map that are read; `bump` is another word for `map_Bump`. Those of [`NUMBERS`] come last.
pub(super) const MAPS: [&str; 14] = [
    "map_Kd", "map_d", "map_Ka", "map_Ks", "map_Ns", "map_Bump", "norm", "disp", "map_Ke",
    "map_Pr", "map_Pm", "map_Ps", "map_Pc", "map_Pcr",
];

/// The numbers of the metallic-roughness extension: roughness, metalness, sheen, clear coat and its roughness.
pub(super) const NUMBERS: [&str; 5] = ["Pr", "Pm", "Ps", "Pc", "Pcr"];

/// True for a word of the metallic-roughness extension.
fn is_extension(word: &str) -> bool {
    NUMBERS.contains(&word.strip_prefix("map_").unwrap_or(word))
}

/// Reads a library; statements that cannot be used are reported in `warnings`.
pub(super) fn read(
    path: &Path,
    named_by: &SourceLocation,
    textures: &mut Textures,
    warnings: &mut Vec<String>,
) -> Result<Vec<Description>, IoError> {
    let text = textures.text(path, Some(named_by), "mtllib")?;
    let mut out: Vec<Description> = Vec::new();
    let mut not_drawn = NotDrawn::default();
    for (content, line) in text.lines().zip(1..) {
        let content = content.trim_end();
        let start = content.len() - content.trim_start().len();
        let (word, rest) = content[start..]
            .split_once(char::is_whitespace)
            .unwrap_or((&content[start..], ""));
        let rest = rest.trim();
        if word.is_empty() || word.starts_with('#') {
            continue;
        }
        let location = SourceLocation::new(path, line, content[..start].chars().count() as u32 + 1);
        if word == "newmtl" {
            if rest.is_empty() {
                return Err(count(location, "newmtl", "1 name"));
            }
            out.push(Description::new(rest));
            not_drawn.next_material();
            continue;
        }
        let Some(material) = out.last_mut() else {
            let command = KNOWN
                .iter()
                .copied()
                .find(|k| *k == word)
                .unwrap_or("a material statement");
            return Err(IoError::NeedsAbove {
                location,
                command,
                needs: "a `newmtl` line",
            });
        };
        match word {
            "Kd" => {
                not_drawn.base_color(rest);
                let kd = color(location, "Kd", rest, warnings)?;
                material.kd = kd.or(material.kd);
            }
            "Ks" => {
                if let Some(ks) = color(location, "Ks", rest, warnings)? {
                    material.ks = ks.into_iter().fold(0.0, f32::max);
                }
            }
            "Ke" => material.ke = rgb(&location, "Ke", rest, warnings)?,
            "Ns" => {
                let ns = one(location.clone(), "Ns", rest)?;
                in_range(ns >= 0.0, location, "Ns", rest, "0 or more")?;
                material.ns = Some(ns);
            }
            "d" | "Tr" => {
                let (command, number) = match (word, rest.strip_prefix("-halo")) {
                    ("Tr", _) => ("Tr", rest),
                    (_, Some(number)) => ("d", number.trim()),
                    _ => ("d", rest),
                };
                let x = one(location.clone(), command, number)?;
                in_range(
                    (0.0..=1.0).contains(&x),
                    location,
                    command,
                    number,
                    "0 to 1",
                )?;
                let opacity = if command == "d" { x } else { 1.0 - x };
                not_drawn.opacity(opacity);
                material.d = opacity;
            }
            "illum" => {
                let model = one(location.clone(), "illum", rest)?;
                not_drawn.model(&location, model);
                in_range(
                    (0.0..=10.0).contains(&model),
                    location,
                    "illum",
                    rest,
                    "0 to 10",
                )?;
                material.highlight = !matches!(model as u8, 0 | 1);
            }
            word if textures.classic && is_extension(word) => {
                not_drawn.statement(&location, word, rest);
            }
            "bump" | "map_bump" => {
                material.maps[5] = Some(map(location, "map_Bump", rest, warnings)?);
            }
            _ => {
                let place = |known: &[&str]| known.iter().position(|known| *known == word);
                match (place(&MAPS), place(&NUMBERS)) {
                    (Some(i), _) => {
                        material.maps[i] = Some(map(location, MAPS[i], rest, warnings)?);
                    }
                    (_, Some(i)) => {
                        let number = share(location, NUMBERS[i], rest, warnings)?;
                        material.numbers[i] = Some(number);
                    }
                    _ => not_drawn.statement(&location, word, rest),
                }
            }
        }
    }
    warnings.extend(not_drawn.warnings());
    for material in &mut out {
        if !material.highlight {
            material.ks = 0.0;
        }
    }
    Ok(out)
}

const KNOWN: [&str; 26] = [
    "Kd", "Ks", "Ke", "Ns", "d", "Tr", "illum", "map_Kd", "map_d", "map_Ka", "map_Ks", "map_Ke",
    "map_Ns", "map_Bump", "norm", "disp", "Pr", "Pm", "Ps", "Pc", "Pcr", "map_Pr", "map_Pm",
    "map_Ps", "map_Pc", "map_Pcr",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> (Result<Vec<Description>, IoError>, Vec<String>) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.mtl");
        std::fs::write(&path, text).unwrap();
        let mut warnings = Vec::new();
        let location = SourceLocation::new(Path::new("a.obj"), 1, 1);
        (
            read(&path, &location, &mut Textures::default(), &mut warnings),
            warnings,
        )
    }

    #[test]
    fn statements_and_map_options() {
        let (materials, warnings) = read_text(
            "# library\nnewmtl two words\n  Kd 0.5\n\tKs 0.1 0.3 0.2\nNs 20\nTr 0.25\nillum 2\n\
             map_Kd -s 2 3 1 -o 0.5 -clamp on my wall.png\n\
             newmtl flat\nKd 1 2 0\nKs 1 1 1\nillum 1\nmap_d -imfchan m leaf_3.png\nKe 1 3 0\n\
             map_Ke glow.png\n",
        );
        let materials = materials.unwrap();
        assert_eq!(materials[0].name, "two words");
        assert_eq!((materials[0].kd, materials[0].ks), (Some([0.5; 3]), 0.3));
        assert_eq!((materials[0].ns, materials[0].d), (Some(20.0), 0.75));
        let map = materials[0].maps[0].as_ref().unwrap();
        assert_eq!(
            (map.name.as_str(), map.scale, map.offset, map.clamp),
            ("my wall.png", [2.0, 3.0], [0.5, 0.0], true)
        );
        assert_eq!(
            (materials[1].kd, materials[1].ks),
            (Some([1.0, 1.0, 0.0]), 0.0)
        );
        assert_eq!(materials[1].maps[1].as_ref().unwrap().name, "leaf_3.png");
        assert_eq!(
            (materials[0].ke, materials[1].ke),
            (None, Some([1.0, 3.0, 0.0]))
        );
        assert_eq!(materials[1].maps[8].as_ref().unwrap().name, "glow.png");
        assert_eq!(warnings.len(), 2, "{warnings:?}");
    }

    #[test]
    fn maps_of_light_and_relief_are_read() {
        let (materials, warnings) = read_text(
            "newmtl a\nmap_Ka a.png\nmap_Ks s.png\nmap_Ns n.png\nbump -bm 0.5 b.png\nnorm t.png\n\
             newmtl b\ndisp -s 2 2 d.png\nnewmtl c\nmap_bump x.png\n",
        );
        let materials = materials.unwrap();
        let name = |m: usize, map: usize| materials[m].maps[map].as_ref().unwrap().name.clone();
        assert_eq!(
            [2, 3, 4, 5, 6].map(|i| name(0, i)),
            ["a.png", "s.png", "n.png", "b.png", "t.png"]
        );
        assert_eq!(materials[0].maps[5].as_ref().unwrap().height, Some(0.5));
        assert_eq!((name(1, 7), name(2, 5)), ("d.png".into(), "x.png".into()));
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn the_metallic_roughness_extension_is_read_for_models_alone() {
        let text = "newmtl a\nPr 0.25\nPm 1.5\nmap_Ps cloth.png\nmap_Pr -s 2 2 r.png\nnewmtl b\nKd 1 1 1\n";
        let (materials, warnings) = read_text(text);
        let materials = materials.unwrap();
        let [roughness, metalness, others @ ..] = materials[0].numbers;
        assert_eq!((roughness, metalness), (Some(0.25), Some(1.0)));
        assert_eq!(others, [None; 3]);
        assert!(warnings.len() == 1 && warnings[0].contains("`Pm 1.5` is above 1"));
        let map = |i: usize| {
            materials[0].maps[i]
                .as_ref()
                .map(|m| (m.name.as_str(), m.scale[0]))
        };
        assert_eq!(map(9), Some(("r.png", 2.0)));
        assert_eq!((map(10), map(11)), (None, Some(("cloth.png", 1.0))));
        assert_eq!(materials[1].numbers, [None; 5]);
        // In a scene nothing of it is drawn, nor is it a fault there.
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.mtl");
        std::fs::write(&path, text.replace("0.25", "x")).unwrap();
        let mut textures = Textures::new(crate::FileSource::default(), false, false);
        textures.classic = true;
        let (location, mut warnings) = (SourceLocation::new(Path::new("a.obj"), 1, 1), Vec::new());
        let materials = read(&path, &location, &mut textures, &mut warnings).unwrap();
        assert_eq!((materials[0].numbers, warnings.len()), ([None; 5], 4));
    }

    #[test]
    fn faults_have_their_lines() {
        for (text, code, line) in [
            ("Kd 1 1 1", "needs-line-above", 1),
            ("newmtl", "argument-count", 1),
            ("newmtl a\nKd 1 1", "argument-count", 2),
            ("newmtl a\nKd", "argument-count", 2),
            ("newmtl a\nKd 1 nan 1", "not-finite", 2),
            ("newmtl a\nKe 1 nan 1", "not-finite", 2),
            ("newmtl a\nKe 1 -1 1", "out-of-range", 2),
            ("newmtl a\nKe", "argument-count", 2),
            ("newmtl a\nKd -1 0 0", "out-of-range", 2),
            ("newmtl a\nd 2", "out-of-range", 2),
            ("newmtl a\nNs x", "not-a-number", 2),
            ("newmtl a\nPr x", "not-a-number", 2),
            ("newmtl a\nPm -1", "out-of-range", 2),
            ("newmtl a\nPc", "argument-count", 2),
            ("newmtl a\nmap_Pm", "argument-count", 2),
            ("newmtl a\nmap_Kd -s 2 2", "argument-count", 2),
            ("newmtl a\nmap_Kd -s 0 1 a.png", "out-of-range", 2),
            ("newmtl a\nmap_Kd -clamp a.png", "out-of-range", 2),
            ("newmtl a\nmap_Kd", "argument-count", 2),
        ] {
            let error = read_text(text).0.unwrap_err();
            assert_eq!(
                (error.code(), error.location().unwrap().line),
                (code, line),
                "{text}"
            );
        }
    }
}
