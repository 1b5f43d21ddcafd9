//! `texmap batch`, `merge` and `shards`: the same bytes as single runs, in shards, bands and after kills.

mod engines;
mod items;
#[cfg(target_os = "linux")]
mod kills;
mod shards;

use std::collections::BTreeMap;

use serde_json::Value;

use crate::program::{Desk, Run};

/// The lines of a batch and its summary.
fn lines(run: &Run) -> (Vec<Value>, Value) {
    let text = String::from_utf8(run.stdout.clone()).unwrap();
    let mut all: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}")))
        .collect();
    let summary = all.pop().expect("a summary")["summary"].take();
    all.sort_by_key(|line| line["index"].as_u64());
    (all, summary)
}

/// A desk with `count` models of different colours and a scene.
fn desk(count: usize) -> Desk {
    let desk = Desk::new();
    for n in 0..count {
        let red = 0.1 + 0.8 * n as f64 / count as f64;
        desk.put(
            &format!("{n:02}.mtl"),
            format!("newmtl c\nKd {red} 0.5 0.2\n"),
        );
        desk.put(
            &format!("{n:02}.obj"),
            format!("mtllib {n:02}.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0.{n}\nusemtl c\nf 1 2 3\n"),
        );
    }
    desk
}

/// Outputs of a folder by their names: no state, no stages.
fn outputs(desk: &Desk, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(desk.path(folder)).unwrap();
    let mut all = BTreeMap::new();
    for entry in entries {
        let entry = entry.unwrap();
        let name = entry.file_name().to_string_lossy().into_owned();
        if name != ".texmap" {
            assert!(
                entry.file_type().unwrap().is_file(),
                "{name} is left in {folder}"
            );
            all.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    all
}

const SMALL: &str = "--resolution 60x50";

fn names(count: usize) -> String {
    (0..count).map(|n| format!("{n:02}.obj ")).collect()
}
