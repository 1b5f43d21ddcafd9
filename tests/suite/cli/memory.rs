//! Memory that is missing: exit code 5 and a word on what to lower, never an abort.
#![cfg(target_os = "linux")]

use std::io::Write;
use std::process::Command;

use crate::program::{Desk, Run};

impl Desk {
    /// Runs the program with an address space of so many MiB.
    fn within(&self, mebibytes: u32, arguments: &str) -> Run {
        let limit = format!("ulimit -v {} && exec \"$0\" \"$@\"", mebibytes * 1024);
        let output = Command::new("sh")
            .args(["-c", &limit, env!("CARGO_BIN_EXE_texmap-tested")])
            .args(arguments.split_whitespace())
            .current_dir(self.path("."))
            .output()
            .unwrap();
        Run {
            code: output.status.code().unwrap_or(-1),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// The program ends with exit code 5, names what asked, and leaves nothing.
    #[track_caller]
    fn over_memory(&self, mebibytes: u32, arguments: &str, word: &str) {
        let before = self.names();
        let run = self.within(mebibytes, arguments);
        assert_eq!(run.code, 5, "{arguments}: {}", run.stderr);
        for word in ["over-memory-budget", word, "--memory-limit"] {
            assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
        }
        assert_eq!(self.names(), before, "{arguments}");
    }

    /// An array of zeros that takes no space on the disk.
    fn put_zeros(&self, name: &str, descr: &str, shape: &str, bytes: u64) {
        let mut header =
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
        while !(10 + header.len() + 1).is_multiple_of(64) {
            header.push(' ');
        }
        let mut file = std::fs::File::create(self.path(name)).unwrap();
        file.write_all(b"\x93NUMPY\x01\x00").unwrap();
        let length = header.len() as u16 + 1;
        file.write_all(&length.to_le_bytes()).unwrap();
        file.write_all(header.as_bytes()).unwrap();
        file.write_all(b"\n").unwrap();
        file.set_len(10 + u64::from(length) + bytes).unwrap();
    }
}

const QUAD: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

const TRIANGLE: &str = "eye 0 2 6\nlook 0 0 0\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\n";

/// More than the program itself takes, less than any of what is asked for.
const LITTLE: u32 = 400;

#[test]
fn frames_and_atlases_are_asked_for() {
    let desk = Desk::new();
    desk.put("plain.scene", format!("{TRIANGLE}f 0 2 1\n"));
    desk.put("t.obj", QUAD);
    let large = "render plain.scene -o o.png --resolution 16384x16384";
    let aovs = "--msaa 4 --aov depth,normal,position";
    desk.over_memory(
        LITTLE,
        &format!("{large} {aovs}"),
        "a frame of 16384 x 16384",
    );
    desk.over_memory(
        LITTLE,
        "render plain.scene -o o.png --resolution 8000x4000 --views front,back,top",
        "a sheet of 3 views",
    );
    desk.over_memory(
        LITTLE,
        "uv-raster t.obj -o a --size 16384",
        "an atlas of 16384",
    );
}

#[test]
fn shadow_maps_are_asked_for() {
    let desk = Desk::new();
    for (name, line, word) in [
        (
            "point.scene",
            "lp 1 1 1 0 3 0\nshadow 16384",
            "6 x 16384 x 16384",
        ),
        (
            "sun.scene",
            "ld 1 1 1 0 -1 0.1\nshadow 16384",
            "1 x 16384 x 16384",
        ),
        // A light far away sees the scene under a small angle: the automatic size is the largest.
        (
            "far.scene",
            "lp 1 1 1 0 30000 0\nshadow auto",
            "6 x 4096 x 4096",
        ),
    ] {
        desk.put(name, format!("{TRIANGLE}{line}\nf 0 2 1\n"));
        let draw = format!("render {name} -o o.png --resolution 64x64");
        desk.over_memory(LITTLE, &draw, word);
    }
}

#[test]
fn files_are_small_and_what_they_hold_is_large() {
    let desk = Desk::new();
    image::GrayImage::new(7000, 7000)
        .save(desk.path("big.png"))
        .unwrap();
    image::RgbImage::new(4000, 2000)
        .save(desk.path("sky.png"))
        .unwrap();
    desk.put_zeros("uv.npy", "<f4", "9000000, 2", 72_000_000);
    desk.put_zeros("grid.npy", "|u1", "300, 300, 300", 27_000_000);
    desk.put(
        "textured.scene",
        format!("{TRIANGLE}texture big.png\ntf 0 0 0 2 1 1 1 1 0\n"),
    );
    desk.put("plain.scene", format!("{TRIANGLE}f 0 2 1\n"));
    desk.put(
        "words.scene",
        format!(
            "{TRIANGLE}text \"{}\" 0 0 0 1 0 0 0 1 0\n",
            "A".repeat(3_000_000)
        ),
    );
    for (arguments, word) in [
        (
            "render textured.scene -o o.png",
            "textured.scene:6:1: no memory for ",
        ),
        ("render words.scene -o o.png", "a text of 3000000 letters"),
        ("hash big.png", "the 7000 x 7000 texels of big.png"),
        ("diff big.png big.png", "the 7000 x 7000 texels of big.png"),
        ("mip big.png -o m%d.png", "the mip levels of big.png"),
        ("mip big.png -o m%d.png --keep-coverage 0.5", "of big.png"),
        ("compress big.png -o b.dds", "the mip levels of big.png"),
        (
            "render plain.scene -o o.png --texture big.png",
            "the mip levels of big.png",
        ),
        ("warp big.png -o w.png", "big.png"),
        ("sample check.png --uv uv.npy -o s.npy", "9000000"),
        (
            "slice grid.npy -o s.png",
            "the grid of shape [300, 300, 300]",
        ),
        (
            "slice noise -o s.png --size 12000",
            "a picture of 12000 x 12000",
        ),
        (
            "env sky.png -o e.hdr --to cube",
            "the 4000 x 2000 texels of sky.png",
        ),
    ] {
        desk.over_memory(200, arguments, word);
    }
    // It needs no more than what the decoder makes.
    desk.over_memory(100, "info big.png", "the 7000 x 7000 texels of big.png");
}

/// The program ends by itself whatever the limit, also if only a little memory is missing.
#[test]
fn no_limit_ends_in_an_abort() {
    let desk = Desk::new();
    image::GrayImage::new(3000, 3000)
        .save(desk.path("big.png"))
        .unwrap();
    desk.put(
        "map.scene",
        format!("{TRIANGLE}texture big.png\ntf 0 0 0 2 1 1 1 1 0\n"),
    );
    desk.put(
        "sun.scene",
        format!("{TRIANGLE}ld 1 1 1 0 -1 0.1\nshadow 4096\nf 0 2 1\n"),
    );
    desk.put("t.obj", QUAD);
    let mut ends = [0; 2];
    for limit in (120..520).step_by(90) {
        for arguments in [
            "render map.scene -o o.png --resolution 800x600",
            "render sun.scene -o o.png --resolution 3000x2000 --aov depth",
            "uv-raster t.obj -o a --size 1500",
            "mip big.png -o m%d.png",
        ] {
            let run = desk.within(limit, arguments);
            assert!(
                [0, 5].contains(&run.code),
                "{limit}: {arguments}: {}",
                run.stderr
            );
            ends[usize::from(run.code == 5)] += 1;
        }
    }
    assert!(ends[0] > 2 && ends[1] > 2, "{ends:?}");
}

#[test]
fn the_limit_can_be_given() {
    let desk = Desk::new();
    let draw = "render room.scene -o o.png --resolution 3000x2000";
    desk.texmap(&format!("{draw} --memory-limit 1G")).ok();
    std::fs::remove_file(desk.path("o.png")).unwrap();
    desk.refused(
        &format!("{draw} --memory-limit 20M"),
        5,
        "a frame of 3000 x 2000",
    );
    desk.refused(&format!("{draw} --memory-limit much"), 2, "such as 2G");
    let json = desk.texmap(&format!("{draw} --json --memory-limit 20M"));
    assert_eq!(json.code, 5);
    assert_eq!(json.json()["error"]["code"], "over-memory-budget");
}
