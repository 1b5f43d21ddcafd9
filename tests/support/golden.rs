//! Pinned pictures: the hash of every one in `tests/golden/hashes.toml`, and for some a small PNG beside it.
//!
//! `TEXMAP_BLESS=1 cargo test --workspace` writes the hashes (and the PNGs that exist) again; look at the
//! pictures before committing them. A picture that differs from its PNG leaves `expected | difference |
//! actual` in `target/golden/NAME.png`.
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use texmap_render::hash_pixels;
use texmap_truth::picture::Picture;
use texmap_truth::strip::strip;

static FILE: Mutex<()> = Mutex::new(());

/// Compares a picture with the pinned one of this name.
///
/// # Panics
/// If the pixels differ, or nothing is pinned and `TEXMAP_BLESS` is not set.
pub fn check(name: &str, picture: &Picture) {
    let hash = hash_pixels(picture.width(), picture.height(), picture.rgba());
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    let png = folder.join(format!("{name}.png"));
    if std::env::var_os("TEXMAP_BLESS").is_some() {
        bless(&folder.join("hashes.toml"), name, &hash);
        if png.exists() {
            save(&png, picture);
        }
        return;
    }
    let pinned = table(&folder.join("hashes.toml"))
        .get(name)
        .and_then(|value| value.as_str().map(str::to_owned));
    if pinned.as_deref() == Some(hash.as_str()) {
        return;
    }
    let shown = match load(&png) {
        Some(expected) => {
            let out = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../target/golden")
                .join(format!("{name}.png"));
            save(&out, &strip(&expected, picture));
            format!("; expected | difference | actual: {}", out.display())
        }
        None => String::new(),
    };
    match pinned {
        Some(pinned) => panic!("'{name}' has the pixel hash {hash}, pinned is {pinned}{shown}"),
        None => panic!(
            "no hash is pinned for '{name}' (it is {hash}): look at it, then run with TEXMAP_BLESS=1"
        ),
    }
}

fn bless(file: &Path, name: &str, hash: &str) {
    let _guard = FILE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut pinned = table(file);
    pinned.insert(name.to_owned(), toml::Value::String(hash.to_owned()));
    let lines: String = pinned
        .iter()
        .map(|(name, hash)| format!("{name} = {hash}\n"))
        .collect();
    let head = "# Hashes of decoded pixels. Written by TEXMAP_BLESS=1 cargo test --workspace.\n";
    std::fs::create_dir_all(file.parent().unwrap_or(file)).unwrap();
    std::fs::write(file, format!("{head}{lines}")).unwrap();
}

fn table(file: &Path) -> toml::Table {
    std::fs::read_to_string(file).map_or_else(|_| toml::Table::new(), |text| text.parse().unwrap())
}

fn load(png: &PathBuf) -> Option<Picture> {
    let image = image::open(png).ok()?.to_rgba8();
    Picture::from_rgba(image.width(), image.height(), image.into_raw())
}

fn save(png: &Path, picture: &Picture) {
    std::fs::create_dir_all(png.parent().unwrap_or(png)).unwrap();
    let kind = image::ExtendedColorType::Rgba8;
    image::save_buffer(png, picture.rgba(), picture.width(), picture.height(), kind).unwrap();
}
