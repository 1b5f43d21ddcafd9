//! `texmap batch`, `merge` and `shards`: the same bytes as single runs, in shards, bands and after kills.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

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

#[test]
fn a_batch_writes_the_bytes_of_single_runs() {
    let desk = desk(3);
    let run = desk
        .texmap(&format!("batch room.scene 02.obj 00.obj -o out/ {SMALL}"))
        .ok();
    let (lines, summary) = lines(&run);
    let ids: Vec<&str> = lines
        .iter()
        .filter_map(|line| line["id"].as_str())
        .collect();
    assert_eq!(ids, ["00.obj", "02.obj", "room.scene"]);
    assert_eq!(summary["done"], 3);
    for (line, name) in lines.iter().zip(["00", "02", "room"]) {
        let input = line["input"].as_str().unwrap();
        let alone = desk
            .texmap(&format!("render {input} -o alone.png {SMALL} --json"))
            .ok();
        assert_eq!(
            desk.read("alone.png"),
            desk.read(&format!("out/{name}.png")),
            "{name}"
        );
        assert_eq!(line["pixel_hash"], alone.json()["items"][0]["pixel_hash"]);
        assert_eq!(line["status"], "ok");
        assert!(line["ms"].as_f64().unwrap() > 0.0);
    }
    assert!(lines[0]["pixel_hash"] != lines[1]["pixel_hash"]);
    // Jobs and threads reach no byte.
    for means in ["--jobs 1 --threads 3", "--jobs 3 --threads 1"] {
        desk.texmap(&format!(
            "batch room.scene 02.obj 00.obj -o again/ {SMALL} {means}"
        ))
        .ok();
        assert_eq!(outputs(&desk, "again"), outputs(&desk, "out"));
    }
}

#[test]
fn one_bad_item_stops_the_rest_only_if_asked() {
    let desk = desk(4);
    desk.put("01.obj", "v 0 0 zero\n");
    let run = desk.texmap(&format!("batch {} -o out/ {SMALL} --jobs 1", names(4)));
    assert_eq!(run.code, 3, "{}", run.stderr);
    let (all, summary) = lines(&run);
    assert_eq!(
        (&summary["done"], &summary["failed"]),
        (&3.into(), &1.into())
    );
    assert_eq!(
        (&all[1]["status"], &all[1]["code"]),
        (&"failed".into(), &4.into())
    );
    assert!(
        all[1]["error"]["what"]
            .as_str()
            .unwrap()
            .starts_with("01.obj:1")
    );
    assert_eq!(outputs(&desk, "out").len(), 3);
    let run = desk.texmap(&format!(
        "batch {} -o fast/ {SMALL} --jobs 1 --fail-fast",
        names(4)
    ));
    assert_eq!(run.code, 3);
    let (_, summary) = lines(&run);
    // One more may have been under way.
    assert!(summary["waiting"].as_u64().unwrap() >= 1, "{summary}");
    // Nothing but bad items: their own exit code.
    assert_eq!(desk.texmap("batch 01.obj -o out/").code, 4);
}

#[test]
fn resuming_skips_what_is_complete_and_nothing_else() {
    let desk = desk(3);
    let batch = format!("batch {} -o out/ {SMALL} --resume", names(3));
    let done = |more: &str| {
        let (_, summary) = lines(&desk.texmap(&format!("{batch} {more}")).ok());
        (
            summary["done"].as_u64().unwrap(),
            summary["skipped"].as_u64().unwrap(),
        )
    };
    assert_eq!(done(""), (3, 0));
    let first = outputs(&desk, "out");
    assert_eq!(done(""), (0, 3));
    assert_eq!(done("--force"), (3, 0));
    assert_eq!(done("--fov 35"), (3, 0));
    assert_eq!(done(""), (3, 0));
    // A material that only the model names.
    desk.put("01.mtl", "newmtl c\nKd 0 0 1\n");
    assert_eq!(done(""), (1, 2));
    std::fs::remove_file(desk.path("out/02.png")).unwrap();
    assert_eq!(done(""), (1, 2));
    let second = outputs(&desk, "out");
    assert!(first["01.png"] != second["01.png"] && first["02.png"] == second["02.png"]);
    // A file that was missing is looked for again.
    std::fs::remove_file(desk.path("00.mtl")).unwrap();
    assert_eq!(done(""), (1, 2));
    assert_eq!(done(""), (1, 2));
    // Markers of a failure are gone.
    desk.put("02.obj", "v 0 0 zero\n");
    assert_eq!(desk.texmap(&batch).code, 3);
    assert_eq!(desk.texmap(&batch).code, 3);
}

#[test]
fn shards_join_to_one_run() {
    let desk = desk(7);
    desk.texmap(&format!("batch {} -o whole/ {SMALL}", names(7)))
        .ok();
    let shard = |n: u32, more: &str| {
        desk.texmap(&format!(
            "batch {} -o out/ {SMALL} --shard {n}/3 {more}",
            names(7)
        ))
    };
    shard(1, "").ok();
    shard(3, "").ok();
    let before = outputs(&desk, "out");
    let early = desk.texmap("merge out -o all");
    assert_eq!(early.code, 75, "{}", early.stderr);
    assert!(early.stderr.contains("shard 2/3"), "{}", early.stderr);
    assert!(!desk.path("all").exists());
    shard(2, "").ok();
    assert!(before.len() < 7);
    // In place and elsewhere.
    desk.texmap("merge out -o out").ok();
    desk.texmap("merge out -o all").ok();
    assert_eq!(outputs(&desk, "out"), outputs(&desk, "whole"));
    assert_eq!(outputs(&desk, "all"), outputs(&desk, "whole"));
    let report = String::from_utf8(desk.read("all/.texmap/merged.jsonl")).unwrap();
    assert_eq!(report.lines().count(), 1 + 7);
    // The same report twice, another cut, another version, other settings, lost bytes.
    let one = "out/.texmap/report-1-of-3.jsonl";
    let refused = |arguments: &str, code: i32, words: [&str; 2]| {
        let run = desk.texmap(&format!("merge {arguments} -o no"));
        assert_eq!(run.code, code, "{}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{}", run.stderr);
        }
        assert!(!desk.path("no").exists());
    };
    refused(&format!("out {one}"), 4, ["double-shards", "shard 1/3"]);
    desk.texmap(&format!("batch {} -o cut/ {SMALL} --shard 1/2", names(7)))
        .ok();
    refused("out cut", 4, ["double-shards", "shard 1/2"]);
    let text = String::from_utf8(desk.read(one)).unwrap();
    let two = "out/.texmap/report-2-of-3.jsonl out/.texmap/report-3-of-3.jsonl";
    let old = text.replacen(env!("CARGO_PKG_VERSION"), "0.0.1", 1);
    desk.put("out/.texmap/old.jsonl", old);
    refused(
        &format!("out/.texmap/old.jsonl {two}"),
        4,
        ["mixed-shards", "0.0.1"],
    );
    desk.texmap(&format!(
        "batch {} -o other/ {SMALL} --fov 30 --shard 1/3",
        names(7)
    ))
    .ok();
    refused(&format!("other {two}"), 4, ["mixed-shards", "settings"]);
    desk.put("out/00.png", "half");
    refused("out", 4, ["shard-output", "00.png"]);
    // A unit that failed: the others are joined.
    desk.put("03.obj", "v 0 0 zero\n");
    assert_eq!(shard(2, "").code, 3);
    shard(1, "").ok();
    let run = desk.texmap("merge out -o most");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert_eq!(outputs(&desk, "most").len(), 6);
}

#[test]
fn ranges_join_too() {
    let desk = desk(5);
    for range in ["0-1,4", "2"] {
        desk.texmap(&format!(
            "batch {} -o out/ {SMALL} --range {range}",
            names(5)
        ))
        .ok();
    }
    let run = desk.texmap("merge out -o all");
    assert_eq!(run.code, 75);
    assert!(
        run.stderr.contains("1 of 5 units are missing: units 3"),
        "{}",
        run.stderr
    );
    desk.texmap(&format!("batch {} -o out/ {SMALL} --range 3", names(5)))
        .ok();
    desk.texmap("merge out -o all").ok();
    desk.refused(
        &format!("batch {} -o out/ --range 4-5", names(5)),
        2,
        "beyond the last unit",
    );
}

#[test]
fn the_engine_tells_the_shard() {
    let desk = desk(4);
    let run = |variables: &[(&str, &str)], more: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_texmap-tested"));
        command
            .args(
                format!("batch {} -o out/ {SMALL} --shard auto {more}", names(4))
                    .split_whitespace(),
            )
            .envs(variables.iter().copied())
            .current_dir(desk.path("."));
        let output = command.output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        (output.status.code().unwrap(), text, output.stdout)
    };
    for (variables, more, expected) in [
        (
            &[("JOB_COMPLETION_INDEX", "0")][..],
            "--shard-count 4",
            "00.obj",
        ),
        (&[("HQ_TASK_ID", "2")], "--shard-count 4", "01.obj"),
        (
            &[
                ("SLURM_ARRAY_TASK_ID", "9"),
                ("SLURM_ARRAY_TASK_MIN", "5"),
                ("SLURM_ARRAY_TASK_STEP", "2"),
                ("SLURM_ARRAY_TASK_COUNT", "4"),
            ],
            "",
            "02.obj",
        ),
    ] {
        let (code, words, stdout) = run(variables, more);
        assert_eq!(code, 0, "{words}");
        let line = String::from_utf8(stdout).unwrap();
        let line: Value = serde_json::from_str(line.lines().next().unwrap()).unwrap();
        assert_eq!(line["id"], expected);
    }
    for (variables, more, word) in [
        (&[][..], "--shard-count 4", "no engine"),
        (&[("HQ_TASK_ID", "2")], "", "--shard-count N"),
        (
            &[
                ("SLURM_ARRAY_TASK_ID", "3"),
                ("SLURM_ARRAY_TASK_COUNT", "1"),
                ("SLURM_ARRAY_TASK_MIN", "3"),
            ],
            "--shard-count 4",
            "Slurm says 1 shards",
        ),
    ] {
        let (code, words, _) = run(variables, more);
        assert_eq!(code, 2, "{words}");
        assert!(words.contains(word), "{words}");
    }
}

#[test]
fn bands_join_to_the_bytes_of_the_whole() {
    let desk = Desk::new();
    for more in ["", "--msaa 4", "--supersample 2", "--bits 16"] {
        let settings = format!("--resolution 150x400 {more}");
        desk.texmap(&format!("render room.scene -o whole.png {settings}"))
            .ok();
        let batch = format!("batch room.scene -o out/room.png {settings} --bands 3");
        for shard in 1..=2 {
            desk.texmap(&format!("{batch} --shard {shard}/2")).ok();
        }
        // Rows of tiles 0 to 1, 2 to 3, 4 to 6.
        let size = |name: &str| image::image_dimensions(desk.path(name)).unwrap();
        assert_eq!(size("out/room.band-1-of-3.png"), (150, 128));
        assert_eq!(size("out/room.band-3-of-3.png"), (150, 144));
        let run = desk.texmap("merge out -o joined.png --json").ok();
        assert_eq!(desk.read("joined.png"), desk.read("whole.png"), "{more}");
        let hash = desk.texmap("hash whole.png --json").ok().json()[0]["pixel_hash"].take();
        assert_eq!(run.json()["pictures"][0]["pixel_hash"], hash);
        assert!(desk.read("out/room.band-1-of-3.png") != desk.read("whole.png"));
    }
    for (more, word) in [
        ("-o x.png --bands 3 --aov depth", "--bands and --aov"),
        (
            "-o x.png --bands 3 --views front,top",
            "--bands and --views",
        ),
        ("-o x.jpg --bands 3", "joined to .png"),
        ("-o x.png --bands 200", "at most 12 bands"),
        (
            "-o x%d.png --bands 2 --unit frame --turntable 4",
            "have bands",
        ),
    ] {
        desk.refused(&format!("batch room.scene {more}"), 2, word);
    }
}

#[test]
fn a_merge_with_little_memory_has_the_same_pixels() {
    let desk = Desk::new();
    let size = "--resolution 3000x1500";
    desk.texmap(&format!(
        "batch room.scene -o out/room.png {size} --bands 4"
    ))
    .ok();
    desk.texmap("merge out -o rich.png").ok();
    desk.texmap("merge out -o poor.png --memory-limit 60M").ok();
    assert!(
        desk.read("rich.png") != desk.read("poor.png"),
        "the limit has no effect"
    );
    let hashes = desk.texmap("hash rich.png poor.png --json").ok().json();
    assert_eq!(hashes[0]["pixel_hash"], hashes[1]["pixel_hash"]);
}

#[test]
fn frames_and_views_are_given_out_one_by_one() {
    let desk = Desk::new();
    let turn = "m.obj --resolution 40x30 --turntable 11";
    desk.texmap(&format!("render {turn} -o whole/t%02d.png"))
        .ok();
    for shard in 1..=3 {
        let run = desk
            .texmap(&format!(
                "batch {turn} -o out/t%02d.png --unit frame --shard {shard}/3"
            ))
            .ok();
        let (all, _) = lines(&run);
        assert!(
            all.iter()
                .all(|line| line["id"].as_str().unwrap().starts_with("m.obj#"))
        );
    }
    desk.texmap("merge out -o out").ok();
    assert_eq!(outputs(&desk, "out"), outputs(&desk, "whole"));
    // A frame that is lost is drawn alone.
    std::fs::remove_file(desk.path("out/t05.png")).unwrap();
    let again = desk
        .texmap(&format!(
            "batch {turn} -o out/t%02d.png --unit frame --resume"
        ))
        .ok();
    assert_eq!(lines(&again).1["done"], 1);
    assert_eq!(outputs(&desk, "out"), outputs(&desk, "whole"));
    let views = "m.obj --resolution 40x30 --views front,top,left";
    desk.texmap(&format!(
        "batch {views} -o v/{{view}}.png --unit view --shard 2/3"
    ))
    .ok();
    assert_eq!(outputs(&desk, "v").len(), 1);
    desk.refused(
        "batch m.obj -o x.png --unit frame",
        2,
        "there is one picture",
    );
    desk.refused(
        "batch m.obj -o x.png --unit view --views front,top",
        2,
        "in one file",
    );
}

#[test]
fn manifests_name_items_with_settings() {
    let desk = desk(2);
    desk.put(
        "all.json",
        r#"{"version":1,"verb":"render","settings":{"resolution":"60x50"},
           "items":[{"id":"b","input":"00.obj","output":"out/x.png"},
                    {"id":"a","input":"01.obj","output":"out/y.png","settings":{"views":["front","top"],"resolution":"30x20"}}]}"#,
    );
    let (all, _) = lines(&desk.texmap("batch all.json").ok());
    assert_eq!((&all[0]["id"], &all[1]["id"]), (&"a".into(), &"b".into()));
    desk.texmap("render 00.obj -o alone.png --resolution 60x50")
        .ok();
    assert_eq!(desk.read("alone.png"), desk.read("out/x.png"));
    desk.texmap("render 01.obj -o alone.png --views front,top --resolution 30x20")
        .ok();
    assert_eq!(desk.read("alone.png"), desk.read("out/y.png"));
    assert!(desk.path("out/.texmap/report.jsonl").is_file());
    // The command line is over the manifest.
    desk.texmap("batch all.json --resolution 20x10").ok();
    assert_eq!(
        image::image_dimensions(desk.path("out/x.png")).unwrap(),
        (20, 10)
    );
    for (items, code, word) in [
        (r#"{"input":"00.obj"}"#, 2, "no output"),
        (
            r#"{"input":"00.obj","output":"a.png"},{"input":"00.obj","output":"b.png"}"#,
            2,
            "the id `00.obj`",
        ),
        (
            r#"{"id":"x","input":"00.obj","output":"a.png"},{"id":"y","input":"01.obj","output":"a.png"}"#,
            2,
            "both write",
        ),
        (
            r#"{"input":"00.obj","output":"a.png","settings":{"fov":999}}"#,
            2,
            "00.obj",
        ),
        (
            r#"{"input":"00.obj","output":"a.png","setings":{}}"#,
            4,
            "setings",
        ),
    ] {
        desk.put("bad.json", format!("{{\"version\":1,\"items\":[{items}]}}"));
        desk.refused("batch bad.json", code, word);
    }
    desk.refused("batch 00.obj 01.obj -o out.png", 2, "both write");
    desk.refused("batch 00.obj -o 00.obj", 2, "input");
    desk.refused("batch 00.obj -o -", 2, "files");
}

#[test]
fn every_verb_runs_as_a_batch() {
    let desk = Desk::new();
    let sky = image::RgbImage::from_fn(16, 8, |x, y| image::Rgb([x as u8 * 16, y as u8 * 30, 99]));
    sky.save(desk.path("sky.png")).unwrap();
    desk.put("q.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    for (batch, alone, made) in [
        (
            "batch uv q.obj -o u/ --map sphere",
            "uv q.obj -o alone.obj --map sphere",
            ("u/q.obj", "alone.obj"),
        ),
        (
            "batch uv-raster q.obj -o r/ --size 16",
            "uv-raster q.obj -o alone --size 16",
            ("r/q.position.npy", "alone.position.npy"),
        ),
        (
            "batch warp check.png -o w/ --to 0,0 7,1 8,8 0,8",
            "warp check.png -o alone.png --to 0,0 7,1 8,8 0,8",
            ("w/check.png", "alone.png"),
        ),
        (
            "batch env sky.png -o e/{model}.exr --to cube --size 8",
            "env sky.png -o alone.exr --to cube --size 8",
            ("e/sky.exr", "alone.exr"),
        ),
    ] {
        let (all, _) = lines(&desk.texmap(batch).ok());
        assert!(!all[0]["outputs"].as_array().unwrap().is_empty(), "{batch}");
        desk.texmap(alone).ok();
        assert_eq!(desk.read(made.0), desk.read(made.1), "{batch}");
        let (_, again) = lines(&desk.texmap(&format!("{batch} --resume")).ok());
        assert_eq!(again["skipped"], 1, "{batch}");
    }
    // The pages of an atlas.
    desk.put(
        "two.obj",
        "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\no a\nf 1/1 2/2 3/3\no b\nf 1/1 3/3 4/2\n",
    );
    let bake = "two.obj --light --object all --size 16";
    desk.texmap(&format!("bake {bake} -o whole/{{object}}.png"))
        .ok();
    for shard in 1..=2 {
        desk.texmap(&format!(
            "batch bake {bake} -o maps/{{object}}.png --unit page --shard {shard}/2"
        ))
        .ok();
    }
    desk.texmap("merge maps -o atlas").ok();
    assert_eq!(outputs(&desk, "atlas"), outputs(&desk, "whole"));
    assert_eq!(outputs(&desk, "atlas").len(), 2);
}

#[test]
fn tasks_are_printed_for_engines() {
    let desk = desk(5);
    let shards = format!("shards {} -o out/ {SMALL} --count 3", names(5));
    let json = desk.texmap(&shards).ok().json();
    let tasks = json["tasks"].as_array().unwrap();
    assert_eq!(tasks.len(), 3);
    let units: u64 = tasks.iter().filter_map(|task| task["units"].as_u64()).sum();
    assert_eq!(units, 5);
    assert!(
        tasks
            .iter()
            .all(|task| task["memory_bytes"].as_u64().unwrap() > 1 << 20)
    );
    let commands = desk.texmap(&format!("{shards} --emit commands")).ok();
    let commands = String::from_utf8(commands.stdout).unwrap();
    for command in commands.lines() {
        desk.texmap(command.strip_prefix("texmap ").unwrap()).ok();
    }
    desk.texmap("merge out -o out").ok();
    assert_eq!(outputs(&desk, "out").len(), 5);
    for (form, words) in [
        ("slurm", ["--array=1-3", "--shard=auto --shard-count=3"]),
        (
            "hyperqueue",
            ["--array 1-3", "--shard=auto --shard-count=3"],
        ),
        ("kubernetes", ["completions: 3", "\"--shard-count=3\""]),
        ("aws-batch", ["\"size\": 3", "\"--shard-count=3\""]),
    ] {
        let run = desk.texmap(&format!("{shards} --emit {form}")).ok();
        let text = String::from_utf8(run.stdout).unwrap();
        for word in words {
            assert!(text.contains(word), "{form}: {text}");
        }
    }
}

#[cfg(target_os = "linux")]
mod kills {
    use super::*;
    use std::process::Child;
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    const COUNT: usize = 12;

    fn start(desk: &Desk, more: &str) -> Child {
        Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
            .args(
                format!(
                    "batch {} -o out/ --resolution 300x200 --resume --jobs 2 {more}",
                    names(COUNT)
                )
                .split_whitespace(),
            )
            .current_dir(desk.path("."))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    fn send(pid: u32, signal: &str) {
        let _ = Command::new("kill")
            .args(["-s", signal, &pid.to_string()])
            .stderr(Stdio::null())
            .status();
    }

    /// Processes that a process started.
    fn children(pid: u32) -> Vec<u32> {
        let tasks = std::fs::read_dir(format!("/proc/{pid}/task"))
            .into_iter()
            .flatten()
            .flatten();
        let lists =
            tasks.filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok());
        lists
            .flat_map(|list| {
                list.split_whitespace()
                    .filter_map(|pid| pid.parse().ok())
                    .collect::<Vec<u32>>()
            })
            .collect()
    }

    fn whole(desk: &Desk) -> BTreeMap<String, Vec<u8>> {
        desk.texmap(&format!(
            "batch {} -o whole/ --resolution 300x200",
            names(COUNT)
        ))
        .ok();
        outputs(desk, "whole")
    }

    /// The moments of kills: `TEXMAP_KILLS` of them, a few if it is not set.
    #[test]
    fn a_batch_that_is_killed_at_any_moment_ends_with_the_same_files() {
        let kills = std::env::var("TEXMAP_KILLS")
            .ok()
            .and_then(|n| n.parse().ok())
            .unwrap_or(4);
        let desk = desk(COUNT);
        let whole = whole(&desk);
        let mut moment = 1_u64;
        for round in 0..kills {
            let _ = std::fs::remove_dir_all(desk.path("out"));
            let mut killed = 0;
            loop {
                let mut child = start(&desk, "");
                moment = moment
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                // Within the time of a whole run, and often before its end.
                let end = Instant::now() + Duration::from_millis((moment >> 33) % 900);
                let mut status = None;
                while status.is_none() && Instant::now() < end {
                    status = child.try_wait().unwrap();
                    sleep(Duration::from_millis(2));
                }
                if let Some(status) = status {
                    assert_eq!(status.code(), Some(0), "round {round}");
                    break;
                }
                let mut all = children(child.id());
                all.insert(0, child.id());
                // The processes of tasks at the same time, as an engine kills a task.
                if moment & (1 << 20) == 0 {
                    all.truncate(1);
                }
                all.iter().for_each(|pid| send(*pid, "KILL"));
                child.wait().unwrap();
                killed += 1;
                for (name, bytes) in finished(&desk) {
                    assert!(
                        whole[&name] == bytes,
                        "round {round}: {name} is half written"
                    );
                }
                if killed == 3 {
                    assert!(start(&desk, "").wait().unwrap().success());
                    break;
                }
            }
            // Processes whose batch was killed have removed what they had begun.
            let end = Instant::now() + Duration::from_secs(20);
            while finished(&desk).len() != count(&desk) && Instant::now() < end {
                sleep(Duration::from_millis(10));
            }
            let again = start(&desk, "").wait().unwrap();
            assert!(again.success());
            assert!(outputs(&desk, "out") == whole, "round {round}");
        }
    }

    /// Pictures that have their names.
    fn finished(desk: &Desk) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(desk.path("out"))
            .into_iter()
            .flatten()
            .flatten();
        entries
            .filter(|entry| entry.path().extension().is_some_and(|e| e == "png"))
            .map(|entry| {
                (
                    entry.file_name().to_string_lossy().into_owned(),
                    std::fs::read(entry.path()).unwrap(),
                )
            })
            .collect()
    }

    /// Everything in the folder but the state.
    fn count(desk: &Desk) -> usize {
        let entries = std::fs::read_dir(desk.path("out"))
            .into_iter()
            .flatten()
            .flatten();
        entries
            .filter(|entry| entry.file_name() != ".texmap")
            .count()
    }

    #[test]
    fn two_tasks_with_one_shard_do_no_damage() {
        let desk = desk(COUNT);
        let whole = whole(&desk);
        let mut twins = [start(&desk, "--force"), start(&desk, "--force")];
        for twin in &mut twins {
            assert!(twin.wait().unwrap().success());
        }
        assert!(outputs(&desk, "out") == whole);
        desk.texmap("merge out -o out").ok();
    }

    #[test]
    fn a_process_that_is_killed_is_one_unit_to_run_again() {
        let desk = desk(2);
        let child = Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
            .args(
                "batch room.scene 00.obj -o out/ --resolution 3000x2000 --supersample 4 --jobs 1"
                    .split(' '),
            )
            .current_dir(desk.path("."))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let end = Instant::now() + Duration::from_secs(60);
        let victim = loop {
            if let Some(pid) = children(child.id()).first() {
                break *pid;
            }
            assert!(Instant::now() < end);
            sleep(Duration::from_millis(5));
        };
        sleep(Duration::from_millis(100));
        send(victim, "KILL");
        let output = child.wait_with_output().unwrap();
        let run = Run {
            code: output.status.code().unwrap(),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        assert_eq!(run.code, 75, "{}", run.stderr);
        let (all, summary) = lines(&run);
        assert_eq!(
            (&summary["killed"], &summary["done"]),
            (&1.into(), &1.into())
        );
        let killed = all.iter().find(|line| line["status"] == "killed").unwrap();
        assert_eq!(killed["code"], 137);
        assert_eq!(desk.texmap("merge out -o all").code, 75);
    }

    #[test]
    fn a_signal_ends_the_batch_and_its_processes() {
        let desk = desk(COUNT);
        let mut child = start(&desk, "--supersample 4");
        let end = Instant::now() + Duration::from_secs(60);
        while children(child.id()).len() < 2 && Instant::now() < end {
            sleep(Duration::from_millis(5));
        }
        let workers = children(child.id());
        assert!(!workers.is_empty());
        send(child.id(), "TERM");
        assert_eq!(child.wait().unwrap().code(), Some(143));
        for pid in workers {
            let path = std::path::PathBuf::from(format!("/proc/{pid}"));
            while path.exists() && Instant::now() < end {
                sleep(Duration::from_millis(5));
            }
            assert!(!path.exists(), "{pid} lives on");
        }
        if desk.path("out").exists() {
            assert_eq!(finished(&desk).len(), count(&desk), "a stage is left");
        }
    }
}
