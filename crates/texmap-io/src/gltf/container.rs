//! The two forms of a glTF file: JSON, or a GLB that holds JSON and bytes.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;

use super::json::{Document, Material};
use super::pointer::pointer_at;
use crate::{FileSource, IoError};

/// The parts of a file.
#[derive(Debug)]
pub(super) struct Container {
    pub(super) json: Range<usize>,
    /// The binary chunk of a GLB.
    pub(super) binary: Option<Range<usize>>,
}

const JSON: u32 = 0x4E4F_534A;
const BINARY: u32 = 0x004E_4942;

/// Finds the parts of a file by its content, whatever its name.
pub(super) fn split(path: &Path, bytes: &[u8]) -> Result<Container, IoError> {
    let broken = |problem: String| broken(path, "", problem);
    if !bytes.starts_with(b"glTF") {
        let mark: &[u8] = "\u{feff}".as_bytes();
        let start = if bytes.starts_with(mark) {
            mark.len()
        } else {
            0
        };
        return Ok(Container {
            json: start..bytes.len(),
            binary: None,
        });
    }
    let word = |at: usize| -> Option<u32> {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(broken("the file ends within the header of its GLB".into()));
    };
    match version {
        1 => return Err(first_version(path)),
        2 => {}
        other => {
            return Err(broken(format!(
                "GLB of version {other}; texmap reads version 2"
            )));
        }
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(broken(format!(
            "the GLB should have {length} bytes, the file ends after {}",
            bytes.len()
        )));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while let (Some(size), Some(kind)) = (word(at), word(at + 4)) {
        if at >= length {
            break;
        }
        let data = at + 8..(at + 8).saturating_add(size as usize);
        if data.end > length {
            return Err(broken(format!(
                "the chunk at byte {at} should have {size} bytes, the GLB ends before"
            )));
        }
        at = data.end;
        match kind {
            JSON if json.is_none() => json = Some(data),
            BINARY if binary.is_none() => binary = Some(data),
            _ => {}
        }
    }
    match json {
        Some(json) => Ok(Container { json, binary }),
        None => Err(broken("the GLB has no JSON chunk".into())),
    }
}

/// The document of a JSON text.
pub(super) fn parse(path: &Path, json: &[u8], files: &FileSource) -> Result<Document, IoError> {
    // Every object of the text becomes at most a structure of the largest kind.
    let objects = json.iter().filter(|byte| **byte == b'{').count() as u64;
    let memory = objects * size_of::<Material>() as u64 + 4 * json.len() as u64;
    let what = format_args!("what the JSON of {} says", path.display());
    files.ask(memory, what, "split the file", None)?;
    match serde_json::from_slice(json) {
        Ok(document) => check_version(path, document),
        Err(_) if states_first_version(json) => Err(first_version(path)),
        Err(error) => {
            let pointer = pointer_at(json, error.line(), error.column());
            Err(broken(path, &pointer, error.to_string()))
        }
    }
}

fn check_version(path: &Path, document: Document) -> Result<Document, IoError> {
    let needed = document.asset.min_version.as_ref();
    let version = needed.unwrap_or(&document.asset.version);
    let pointer = match needed {
        Some(_) => "/asset/minVersion",
        None => "/asset/version",
    };
    match version.as_str() {
        "2.0" => Ok(document),
        later if later.starts_with("2.") && needed.is_none() => Ok(document),
        "" => Err(broken(
            path,
            "/asset/version",
            "is missing: this is no glTF".into(),
        )),
        early if early.starts_with("1.") || early.starts_with("0.") => Err(first_version(path)),
        other => Err(IoError::UnsupportedGltf {
            path: path.to_path_buf(),
            pointer: pointer.to_owned(),
            feature: format!("glTF {other}"),
            instead: "texmap reads glTF 2.0; export the model in that version".into(),
        }),
    }
}

/// True if a text that is no glTF 2.0 states version 1, whose lists are objects.
fn states_first_version(json: &[u8]) -> bool {
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Stated {
        asset: Version,
    }
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Version {
        version: String,
    }
    serde_json::from_slice::<Stated>(json).is_ok_and(|s| s.asset.version.starts_with("1."))
}

fn first_version(path: &Path) -> IoError {
    IoError::UnsupportedGltf {
        path: path.to_path_buf(),
        pointer: "/asset/version".into(),
        feature: "glTF 1.0".into(),
        instead: "convert it to glTF 2.0 with `npx gltf-pipeline -i IN.gltf -o OUT.glb`".into(),
    }
}

pub(super) fn broken(path: &Path, pointer: &str, problem: String) -> IoError {
    IoError::BrokenGltf {
        path: path.to_path_buf(),
        pointer: pointer.to_owned(),
        problem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(u32, &[u8])]) -> Vec<u8> {
        let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, data) in chunks {
            bytes.extend((data.len() as u32).to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(*data);
        }
        let length = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        bytes
    }

    fn parsed(json: &str) -> Result<Document, IoError> {
        parse(
            Path::new("a.gltf"),
            json.as_bytes(),
            &FileSource::anywhere(),
        )
    }

    #[test]
    fn chunks_are_found_and_cut_files_are_refused_at_every_byte() {
        let path = Path::new("a.glb");
        let whole = glb(&[(JSON, b"{}  "), (7, b"????"), (BINARY, b"12345678")]);
        let parts = split(path, &whole).unwrap();
        assert_eq!(
            (&whole[parts.json], &whole[parts.binary.unwrap()]),
            (&b"{}  "[..], &b"12345678"[..])
        );
        for cut in 4..whole.len() {
            let error = split(path, &whole[..cut]).unwrap_err();
            assert_eq!(error.code(), "broken-gltf", "cut at {cut}");
        }
        assert!(split(path, &glb(&[(BINARY, b"1234")])).is_err());
        let mut first = whole;
        first[4] = 1;
        assert_eq!(split(path, &first).unwrap_err().code(), "unsupported-gltf");
    }

    #[test]
    fn faults_of_the_text_have_their_pointer() {
        let error = parsed(
            r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":"x"}}]}]}"#,
        );
        let error = error.unwrap_err().to_string();
        assert!(
            error.starts_with("a.gltf: /meshes/0/primitives/0/attributes/POSITION: invalid type"),
            "{error}"
        );
        assert!(parsed("{\"asset\":{\"version\":\"2.0\"}} x").is_err());
        assert!(
            parsed("{\"asset\":")
                .unwrap_err()
                .to_string()
                .contains("line 1")
        );
    }

    #[test]
    fn versions() {
        let code = |json: &str| parsed(json).map_or_else(|e| e.code(), |_| "read");
        assert_eq!(code(r#"{"asset":{"version":"2.0"}}"#), "read");
        assert_eq!(code(r#"{"asset":{"version":"2.1"}}"#), "read");
        assert_eq!(
            code(r#"{"asset":{"version":"2.1","minVersion":"2.1"}}"#),
            "unsupported-gltf"
        );
        assert_eq!(code(r#"{"asset":{"version":"1.0"}}"#), "unsupported-gltf");
        assert_eq!(
            code(r#"{"asset":{"version":"1.0"},"accessors":{"a":{}}}"#),
            "unsupported-gltf"
        );
        assert_eq!(code("{}"), "broken-gltf");
    }
}
