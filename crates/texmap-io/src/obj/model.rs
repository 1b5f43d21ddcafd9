//! From the text of a model and its libraries to the parts of a scene.

use std::path::Path;

use super::materials::{check_names, decode_maps, libraries, material};
use super::parts::parts;
use super::pieces;
use super::read::Obj;
use super::{Model, Part};
use crate::IoError;
use crate::error::{shortened, shown};
use crate::files::is_called;
use crate::models::Request;
use crate::textures::Textures;

/// Reads a model, its libraries and their maps; gives the number of bytes of its text.
pub(crate) fn read(
    request: &Request<'_>,
    textures: &mut Textures,
) -> Result<(Model, usize), IoError> {
    let (path, missing) = (request.path, request.missing);
    let text = textures.text(path, request.named_by, "obj")?;
    let bytes = text.len();
    let quotes = is_called(path, "obj");
    let hidden = |error: IoError| match quotes {
        true => error,
        false => error.without_words(),
    };
    let pieces = pieces::read(path, &text, None).map_err(hidden)?;
    drop(text);
    let obj = pieces.join();
    if obj.faces.is_empty() {
        return Err(IoError::EmptyMesh {
            path: path.to_path_buf(),
            named_by: request.named_by.cloned(),
        });
    }
    let mut warnings = Vec::new();
    let mut descriptions = libraries(path, &obj, missing, textures, &mut warnings)?;
    let lenient = missing.is_lenient() || textures.tolerant;
    check_names(&obj, &descriptions, lenient, &mut warnings).map_err(hidden)?;
    let parts = parts(&obj, &descriptions, request.textured);
    report(path, &obj, &parts, &mut warnings);
    decode_maps(&mut descriptions, textures, &mut warnings);
    let mut materials = Vec::new();
    for description in descriptions {
        materials.push(material(description, missing, textures, &mut warnings)?);
    }
    let model = Model {
        parts,
        materials,
        colored: !obj.colors.is_empty(),
        warnings,
    };
    Ok((model, bytes))
}

fn report(path: &Path, obj: &Obj, parts: &[Part], warnings: &mut Vec<String>) {
    if obj.lines_and_points > 0 {
        warnings.push(format!(
            "{}: {} lines and points are not drawn",
            shown(path),
            obj.lines_and_points
        ));
    }
    if let Some((location, word)) = &obj.unknown {
        let word = match is_called(path, "obj") {
            true => word,
            false => "...",
        };
        warnings.push(format!(
            "{location}: `{}` is not known; lines like it are left out",
            shortened(word)
        ));
    }
    for part in parts {
        if let Some((count, line)) = part.projected {
            warnings.push(format!(
                "{}:{line}: mesh '{}': {count} faces without texture coordinates; box projection stands in",
                shown(path),
                shortened(&part.name)
            ));
        }
        if let Some((corners, line)) = part.uncut {
            warnings.push(format!("{}:{line}: {}", shown(path), drawn_as_fan(corners)));
        }
    }
}

/// The warning of [`Part::uncut`].
pub(crate) fn drawn_as_fan(corners: u32) -> String {
    format!(
        "a concave face of {corners} corners is drawn as a fan, beyond its outline; cut it into triangles"
    )
}

/// Four corners with coordinates.
#[cfg(test)]
pub(super) const SQUARE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// The model of this text.
#[cfg(test)]
pub(super) fn read_text(obj: &str) -> Model {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.obj");
    std::fs::write(&path, obj).unwrap();
    let request = Request {
        path: &path,
        named_by: None,
        missing: crate::scene_file::Missing::Error,
        textured: false,
    };
    read(&request, &mut Textures::default()).unwrap().0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_and_unknown_libraries() {
        let m = read_text(&format!(
            "{SQUARE}o left\nf 1 2 3\ng right side\nusemtl gold\nf 1 3 4\n"
        ));
        let names: Vec<_> = m.parts.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["left", "right side"]);
        assert!(m.parts[0].uvs.is_empty());
        assert!(
            m.warnings[0].contains("`gold` is not defined"),
            "{:?}",
            m.warnings
        );
    }
}
