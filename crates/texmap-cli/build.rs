//! With feature `web`: the list of the files of the web lab, which `texmap play` serves, as constants of the program.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_WEB").is_none() {
        return;
    }
    println!("cargo::rerun-if-env-changed=TEXMAP_WEB");
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web/dist");
    let folder = std::env::var_os("TEXMAP_WEB").map_or(default, PathBuf::from);
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut files = Vec::new();
    if !folder.join("index.html").is_file() || list(&folder, "", &mut files).is_err() {
        println!(
            "cargo::error=feature web: {} holds no web lab: make it with web/build, or name its folder in TEXMAP_WEB",
            folder.display()
        );
        return;
    }
    files.sort();
    let mut text = String::from("&[\n");
    for name in &files {
        let path = folder.join(name).canonicalize().unwrap_or_default();
        let _ = writeln!(text, "({name:?}, include_bytes!({path:?}).as_slice()),");
    }
    text.push(']');
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default()).join("pages.rs");
    if let Err(error) = fs::write(&out, text) {
        println!("cargo::error={}: {error}", out.display());
    }
}

/// Names of all files of a folder and those below it, with `/` between their parts.
fn list(root: &Path, below: &str, files: &mut Vec<String>) -> std::io::Result<()> {
    for entry in fs::read_dir(root.join(below))? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let name = if below.is_empty() {
            name
        } else {
            format!("{below}/{name}")
        };
        match entry.file_type()?.is_dir() {
            true => list(root, &name, files)?,
            false => files.push(name),
        }
    }
    Ok(())
}
