//! Texels of the pictures that a model, its material libraries or a scene names or holds, by the heads of their files.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde_json::Value;

/// Bytes that are read of a text, and of a glTF document.
const TEXT: u64 = 1 << 20;
/// Bytes that are read of the head of a picture: a JPEG may have a thumbnail and a profile before its size.
const HEAD: u64 = 1 << 18;
/// Texels of a byte of a picture whose head is not read.
const TEXELS_A_BYTE: u64 = 4;
const PICTURES: [&str; 14] = [
    "png", "jpg", "jpeg", "webp", "tga", "bmp", "gif", "tif", "tiff", "hdr", "exr", "dds", "ktx2",
    "qoi",
];

/// Texels of all pictures of an input, each once. What cannot be read has none: the batch tells of it.
pub(super) fn texels(input: &Path) -> u64 {
    let of_input = |file| match ending(input).as_str() {
        "glb" => of_glb(input, file),
        "gltf" => of_gltf(input, &head(file, 0, TEXT)?, None),
        "obj" | "scene" | "mtl" => Some(of_text(input, &head(file, 0, TEXT)?)),
        _ => None,
    };
    ordinary(input).and_then(of_input).unwrap_or(0)
}

/// Pipes and devices are not opened: they may wait without end.
fn ordinary(path: &Path) -> Option<File> {
    let metadata = path.metadata().ok()?;
    metadata.is_file().then(|| File::open(path).ok())?
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_ascii_lowercase()
}

/// Bytes of a file from one on.
fn head(mut file: File, from: u64, most: u64) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(from)).ok()?;
    file.take(most).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

fn of_picture(path: &Path) -> u64 {
    let texels = || {
        let file = ordinary(path)?;
        let length = file.metadata().ok()?.len();
        Some(size(&head(file, 0, HEAD)?).unwrap_or(length * TEXELS_A_BYTE))
    };
    texels().unwrap_or(0)
}

/// Lines that end with the name of a picture, after a word and options, and the libraries of a model.
fn of_text(path: &Path, text: &[u8]) -> u64 {
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = String::from_utf8_lossy(text);
    let mut libraries: BTreeSet<PathBuf> = BTreeSet::new();
    let mut pictures: BTreeSet<PathBuf> = BTreeSet::new();
    for line in text.lines() {
        let words = line.split_whitespace().skip(1);
        let named = words.map(|word| folder.join(word.replace('\\', "/")));
        for name in named {
            match ending(&name).as_str() {
                "mtl" if ending(path) == "obj" => drop(libraries.insert(name)),
                ending if PICTURES.contains(&ending) => drop(pictures.insert(name)),
                _ => {}
            }
        }
    }
    let of_libraries = libraries.iter().map(|library| texels(library));
    let of_pictures = pictures.iter().map(|picture| of_picture(picture));
    sum(of_libraries.chain(of_pictures))
}

/// Heads may state any size.
fn sum(texels: impl Iterator<Item = u64>) -> u64 {
    texels.fold(0, u64::saturating_add)
}

/// Header of 12 bytes, then chunks with their length and kind: the document, and the bytes of its pictures.
fn of_glb(path: &Path, mut file: File) -> Option<u64> {
    let mut start = [0; 20];
    file.read_exact(&mut start).ok()?;
    let [.., a, b, c, d, _, _, _, _] = start;
    let length = u64::from(u32::from_le_bytes([a, b, c, d]));
    let mut document = Vec::new();
    (&file)
        .take(length.min(64 * TEXT))
        .read_to_end(&mut document)
        .ok()?;
    of_gltf(path, &document, Some((file, 20 + length + 8)))
}

/// `binary` is the file with the first buffer, and its beginning.
fn of_gltf(path: &Path, document: &[u8], binary: Option<(File, u64)>) -> Option<u64> {
    let document: Value = serde_json::from_slice(document).ok()?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let held = |image: &Value| {
        let view = &document["bufferViews"][image["bufferView"].as_u64()? as usize];
        let (file, start) = binary.as_ref().filter(|_| view["buffer"] == 0)?;
        let from = start.saturating_add(view["byteOffset"].as_u64().unwrap_or(0));
        let length = view["byteLength"].as_u64()?;
        let bytes = head(file.try_clone().ok()?, from, length.min(HEAD))?;
        Some(size(&bytes).unwrap_or(length.saturating_mul(TEXELS_A_BYTE)))
    };
    let of_image = |image: &Value| match image["uri"].as_str() {
        // Three bytes in four letters.
        Some(data) if data.starts_with("data:") => data.len() as u64 * 3 / 4 * TEXELS_A_BYTE,
        Some(uri) => of_picture(&folder.join(uri.replace("%20", " "))),
        None => held(image).unwrap_or(0),
    };
    Some(sum(document["images"].as_array()?.iter().map(of_image)))
}

/// Texels of a PNG or JPEG by its head.
fn size(bytes: &[u8]) -> Option<u64> {
    if bytes.starts_with(b"\x89PNG") {
        let side = |at: usize| {
            let four = bytes.get(at..)?.first_chunk()?;
            Some(u64::from(u32::from_be_bytes(*four)))
        };
        return side(16)?.checked_mul(side(20)?);
    }
    let mut rest = bytes.strip_prefix(b"\xff\xd8")?;
    while let [0xff, marker, high, low, after @ ..] = rest {
        let length = usize::from(u16::from_be_bytes([*high, *low]));
        // Frames but for C4, C8 and CC, which are tables and extensions.
        if (0xc0..=0xcf).contains(marker) && ![0xc4, 0xc8, 0xcc].contains(marker) {
            let [_, y, z, w, x, ..] = after else {
                return None;
            };
            let side = |high: &u8, low: &u8| u64::from(u16::from_be_bytes([*high, *low]));
            return Some(side(y, z) * side(w, x));
        }
        rest = rest.get(2 + length..)?;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The head of a PNG of 300 x 200 texels.
    fn png() -> Vec<u8> {
        let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
        bytes.extend([0, 0, 1, 44, 0, 0, 0, 200]);
        bytes
    }

    #[test]
    fn sizes_are_read_from_heads() {
        assert_eq!(size(&png()), Some(60_000));
        let jpeg = b"\xff\xd8\xff\xe0\0\x04ab\xff\xc4\0\x02\xff\xc2\0\x0b\x08\0\xc8\x01\x2c\x03";
        assert_eq!(size(jpeg), Some(60_000));
        for bad in [
            &b""[..],
            b"\xff\xd8",
            b"\xff\xd8\xff\xe0\0\0\0",
            b"\x89PNG",
            b"RIFF",
        ] {
            assert_eq!(size(bad), None, "{bad:?}");
        }
    }

    #[test]
    fn pictures_of_models_count_once() {
        let dir = tempfile::tempdir().unwrap();
        let put = |name: &str, bytes: &[u8]| {
            let path = dir.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        put("a.png", &png());
        put("b.webp", &[0; 100]);
        #[cfg(unix)]
        {
            // Opening a pipe that nothing writes would wait for ever.
            let pipe = std::process::Command::new("mkfifo")
                .arg(dir.path().join("pipe.png"))
                .status();
            assert!(pipe.unwrap().success());
        }
        put(
            "m.mtl",
            b"newmtl x\nmap_Kd -s 2 2 1 a.png\nmap_Ks a.png\nbump b.webp\nmap_d lost.png\nmap_Ke pipe.png\n",
        );
        let model = put("m.obj", b"mtllib m.mtl\nv 0 0 0\n");
        assert_eq!(texels(&model), 60_000 + 400);
        let scene = put("s.scene", b"texture a.png\nobj m.obj\n");
        assert_eq!(texels(&scene), 60_000);
        let document = |images: &str| {
            format!(
                r#"{{"images":[{images}],"bufferViews":[{{"buffer":0,"byteOffset":8,"byteLength":24}}]}}"#
            )
        };
        let gltf = put("m.gltf", document(r#"{"uri":"a.png"}"#).as_bytes());
        assert_eq!(texels(&gltf), 60_000);
        let json = document(r#"{"bufferView":0},{"uri":"a.png"},{"bufferView":7}"#);
        let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        glb.extend((json.len() as u32).to_le_bytes());
        glb.extend(b"JSON");
        glb.extend(json.as_bytes());
        glb.extend([&[0; 16][..], &png()].concat());
        assert_eq!(texels(&put("m.glb", &glb)), 120_000);
        assert_eq!(texels(&put("bad.glb", b"glTF")), 0);
        assert_eq!(texels(&dir.path().join("none.obj")), 0);
    }
}
