//! `native FOLDER < requests.json`: answers the requests of the pages on this machine and prints the hashes of their pictures, in JSON.
//! FOLDER holds the files that they name. The input is an object of requests by name, the output one of lists of hashes.

use std::collections::BTreeMap;
use std::io::{Read, stdin};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde_json::Value;
use texmap_web::{Files, Room, answer, play};

fn main() -> ExitCode {
    match run() {
        Ok(hashes) => {
            println!("{hashes}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("native: {error}");
            ExitCode::from(1)
        }
    }
}

fn run() -> Result<String, String> {
    let folder = std::env::args()
        .nth(1)
        .ok_or("usage: native FOLDER < requests.json")?;
    let mut held = Vec::new();
    read_all(Path::new(&folder), Path::new(""), &mut held)?;
    let mut files = Files::new();
    files.add(held);
    let mut text = String::new();
    stdin()
        .read_to_string(&mut text)
        .map_err(|e| e.to_string())?;
    let requests: BTreeMap<String, Value> =
        serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let mut hashes = BTreeMap::new();
    for (name, request) in requests {
        let answer = answer(&files, &request.to_string()).map_err(|e| format!("{name}: {e}"))?;
        hashes.insert(
            name,
            answer.panels.iter().map(|p| p.hash()).collect::<Vec<_>>(),
        );
    }
    for size @ [width, height] in [[640, 400], [1280, 720]] {
        let mut room = Room::new(&files)?;
        let last = play(&mut room, size, 0, false)?;
        let walk = format!("doom {width}x{height}");
        hashes.insert(walk, vec![texmap_render::pixel_hash(last)]);
    }
    serde_json::to_string_pretty(&hashes).map_err(|e| e.to_string())
}

/// Files of a folder and those below it, by their names from the folder on.
fn read_all(root: &Path, below: &Path, held: &mut Vec<(PathBuf, Vec<u8>)>) -> Result<(), String> {
    let folder = root.join(below);
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in std::fs::read_dir(&folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = below.join(entry.file_name());
        if entry.file_type().map_err(failed)?.is_dir() {
            read_all(root, &name, held)?;
        } else {
            held.push((name, std::fs::read(entry.path()).map_err(failed)?));
        }
    }
    Ok(())
}
