//! Batches that are killed: outputs are complete or not there, and a resumed batch ends with the bytes of one run.

use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::program::{Desk, Run};

use super::{desk, lines, names, outputs};

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
    let lists = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok());
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
