//! Signals: nothing is left behind, and the exit code says which it was.
#![cfg(target_os = "linux")]

use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::program::Desk;

/// Longer than anything here takes on the slowest machine.
const PATIENCE: Duration = Duration::from_secs(300);

fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < PATIENCE, "{what} did not happen");
        sleep(Duration::from_millis(5));
    }
}

impl Desk {
    fn stages(&self) -> Vec<String> {
        let mut names = self.names();
        names.retain(|name| name.starts_with(".texmap-"));
        names
    }

    /// A run that would write a thousand pictures, with the first of them in its stage.
    fn long_run(&self) -> Child {
        let old = self.stages();
        let child = Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
            .args("demo light-maps -o spot%04d.png --frames 1000".split(' '))
            .current_dir(self.path("."))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_for("the first picture", || {
            let mut new = self.stages().into_iter().filter(|s| !old.contains(s));
            new.any(|stage| {
                std::fs::read_dir(self.path(&stage)).is_ok_and(|files| {
                    files
                        .flatten()
                        .any(|f| f.path().extension().is_some_and(|e| e == "png"))
                })
            })
        });
        child
    }
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill")
        .args(["-s", signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// Exit code and output of a run that has ended.
fn end(mut child: Child) -> (Option<i32>, String) {
    wait_for("the end", || child.try_wait().unwrap().is_some());
    let out = child.wait_with_output().unwrap();
    (out.status.code(), String::from_utf8(out.stderr).unwrap())
}

/// Signals that this process ignores are ignored by its children: the test cannot send them (`nohup`, jobs in the background).
fn is_ignored(number: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let mask = status
        .lines()
        .find_map(|l| l.strip_prefix("SigIgn:"))
        .unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() >> (number - 1) & 1 == 1
}

/// Standard input is held in memory; the folder of the unfinished picture goes.
#[test]
fn a_signal_leaves_nothing_of_standard_input() {
    let desk = Desk::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
        .args("render - -o turn.gif --turntable 3000 --resolution 120x90".split(' '))
        .current_dir(desk.path("."))
        .env("TMPDIR", desk.path("."))
        .stdin(std::fs::File::open(desk.path("m.obj")).unwrap())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for("the unfinished picture", || {
        assert!(child.try_wait().unwrap().is_none());
        !desk.stages().is_empty()
    });
    send(&child, "TERM");
    let (code, said) = end(child);
    assert_eq!(code, Some(143), "{said}");
    assert!(desk.stages().is_empty(), "{:?}", desk.stages());
}

#[test]
fn signals_leave_nothing() {
    for (signal, number) in [("TERM", 15), ("HUP", 1), ("INT", 2)] {
        if is_ignored(number) {
            continue;
        }
        let desk = Desk::new();
        let before = desk.names();
        let child = desk.long_run();
        send(&child, signal);
        let (code, words) = end(child);
        assert_eq!(code, Some(128 + number as i32), "{signal}: {words}");
        assert_eq!(desk.names(), before, "{signal}");
        assert!(!words.contains("error"), "{signal}: {words}");
    }
}

#[test]
fn a_second_signal_ends_at_once() {
    let desk = Desk::new();
    let child = desk.long_run();
    send(&child, "TERM");
    // The process may be gone already.
    let _ = Command::new("kill")
        .args(["-s", "TERM", &child.id().to_string()])
        .stderr(Stdio::null())
        .status();
    assert_eq!(end(child).0, Some(143));
}

#[test]
fn the_next_run_removes_what_a_killed_one_left() {
    let desk = Desk::new();
    let child = desk.long_run();
    send(&child, "KILL");
    assert_eq!(end(child).0, None);
    assert_eq!(desk.stages().len(), 1, "{:?}", desk.names());
    // One that is alive meanwhile is left alone.
    let living = desk.long_run();
    let stages = desk.stages();
    assert_eq!(stages.len(), 1, "{stages:?}");
    desk.texmap("render room.scene --resolution 16x16 -o o.png")
        .ok();
    assert_eq!(desk.stages(), stages);
    send(&living, "TERM");
    assert_eq!(end(living).0, Some(143));
    assert_eq!(desk.stages(), Vec::<String>::new());
}

#[test]
fn ignored_signals_stay_ignored() {
    let desk = Desk::new();
    let child = Command::new("sh")
        .args([
            "-c",
            "trap '' HUP; exec \"$0\" \"$@\"",
            env!("CARGO_BIN_EXE_texmap-tested"),
        ])
        .args("demo light-maps -o spot%04d.png --frames 2".split(' '))
        .current_dir(desk.path("."))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for("the stage", || !desk.stages().is_empty());
    send(&child, "HUP");
    let (code, words) = end(child);
    assert_eq!(code, Some(0), "{words}");
    assert!(desk.path("spot0001.png").is_file());
}

#[test]
fn a_file_over_the_size_limit_is_an_error_like_any_other() {
    let desk = Desk::new();
    desk.put("o.png", "old");
    let before = desk.names();
    let out = Command::new("sh")
        .args([
            "-c",
            "ulimit -f 16; exec \"$0\" \"$@\"",
            env!("CARGO_BIN_EXE_texmap-tested"),
        ])
        .args("render room.scene --resolution 400x300 -o o.png --aov position".split(' '))
        .current_dir(desk.path("."))
        .output()
        .unwrap();
    let words = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(4), "{words}");
    assert!(words.contains("error[write-failed]"), "{words}");
    assert!(words.contains("cannot be written"), "{words}");
    assert!(
        !words.contains(".texmap-"),
        "the message names the output: {words}"
    );
    assert_eq!(desk.names(), before);
    assert_eq!(desk.read("o.png"), b"old");
}
