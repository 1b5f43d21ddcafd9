//! Engines: the shard by their variables, and tasks in their forms.

use std::process::Command;

use serde_json::Value;

use super::{SMALL, desk, names, outputs};
use crate::program::Desk;

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
    // A limit is that of the tasks, too, and of their estimates.
    let limited = format!("{shards} --resolution 9000x9000 --memory-limit 300M");
    let limited = limited.replacen(SMALL, "", 1);
    let json = desk.texmap(&limited).ok().json();
    assert_eq!(json["tasks"][0]["memory_bytes"], 316 << 20);
    let run = desk.texmap(&format!("{limited} --emit slurm")).ok();
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(text.contains(" --memory-limit=314572800 "), "{text}");
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

/// The heads of textures count, and the maps of `--env-shadows`.
#[test]
fn textures_and_shadow_maps_are_estimated() {
    let desk = Desk::new();
    let memory = |flags: &str| {
        let run = desk.texmap(&format!("shards m.obj -o out/ {SMALL} --count 1 {flags}"));
        run.ok().json()["tasks"][0]["memory_bytes"]
            .as_u64()
            .unwrap()
    };
    let small = memory("");
    assert_eq!(memory("--env-shadows 100") - small, 125 << 20);
    let large = image::GrayImage::new(4000, 4000);
    large.save(desk.path("check.png")).unwrap();
    assert!(memory("") - small > 330 << 20);
}
