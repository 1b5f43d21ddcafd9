//! Shards, ranges and bands of a batch, and their merge.

use crate::program::Desk;

use super::{SMALL, desk, names, outputs};

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
    desk.refused("merge out -o x.jpg", 2, "joined to .png");
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
    // 16 bits a channel: 36 MB as a whole, which is read nowhere.
    desk.texmap(&format!(
        "batch room.scene -o deep/room.png {size} --bands 8 --bits 16"
    ))
    .ok();
    let run = desk.texmap("merge deep -o deep.png --memory-limit 16M --json");
    let hash = desk.texmap("hash deep.png --json").ok().json()[0]["pixel_hash"].take();
    assert_eq!(run.ok().json()["pictures"][0]["pixel_hash"], hash);
}
