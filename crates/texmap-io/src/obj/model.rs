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
    let mut obj = pieces.join();
    obj.drop_broken_uvs();
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
    match obj.lines_and_points {
        0 => {}
        1 => warnings.push(format!("{}: a line or point is not drawn", shown(path))),
        count => warnings.push(format!(
            "{}: {count} lines and points are not drawn",
            shown(path)
        )),
    }
    warnings.extend(broken_normals(path, obj.not_finite.normals));
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

/// The warning of normals that are not finite.
pub(crate) fn broken_normals(path: &Path, count: usize) -> Option<String> {
    let what = match count {
        0 => return None,
        1 => "a normal that is not finite is".to_owned(),
        _ => format!("{count} normals that are not finite are"),
    };
    Some(format!("{}: {what} computed from faces", shown(path)))
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

    /// Vertices, normals and coordinates that are not finite matter where faces use them.
    #[test]
    fn numbers_that_are_not_finite() {
        let clean = read_text(&format!("{SQUARE}f 1/1 2/2 3/3\nf 1 3 4\n"));
        let mut broken = read_text(&format!(
            "{SQUARE}v nan inf 0\nvt 0 -nan(ind)\nvn 1.#QNAN 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/5/1 4/4/1\n"
        ));
        let (clean, part) = (&clean.parts[0], &broken.parts[0]);
        assert_eq!(clean.positions, part.positions);
        assert_eq!(clean.uvs, part.uvs);
        assert_eq!(clean.normals, part.normals);
        assert_eq!(part.projected, Some((1, 13)));
        assert!(part.uvs.as_flattened().iter().all(|x| x.is_finite()));
        assert!(
            broken
                .warnings
                .remove(0)
                .ends_with("a normal that is not finite is computed from faces")
        );
    }
}
