//! Items of a batch: their bytes, faults, resumption, manifests and verbs.

use crate::program::Desk;

use super::{SMALL, desk, lines, names, outputs};

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
    assert_eq!(summary["waiting"], 2, "{summary}");
    // A dry run tells of inputs that are not there.
    let run = desk.texmap("batch 00.obj gone.obj -o dry/ --dry-run");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stderr.contains("gone.obj: no such file"),
        "{}",
        run.stderr
    );
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(
        text.contains("\"planned\"") && text.contains("\"failed\""),
        "{text}"
    );
    assert_eq!(desk.texmap("batch gone.obj -o dry/ --dry-run").code, 4);
    // Nothing but bad items.
    assert_eq!(desk.texmap("batch 01.obj -o out/").code, 4);
    let run = desk.texmap("batch 00.obj -o none/ --resolution 4000x4000 --memory-limit 1M");
    let (all, summary) = lines(&run);
    assert_eq!((&all[0]["code"], &summary["exit"]), (&5.into(), &4.into()));
    assert_eq!(run.code, 4, "{}", run.stderr);
    assert!(outputs(&desk, "none").is_empty());
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

/// Numbered pictures and what lies beside pictures are told apart as `render` does, before anything is drawn.
#[test]
fn pictures_and_files_beside_them_are_told_apart() {
    let desk = desk(1);
    for name in ["car", "car1", "car.heat", "car.uv"] {
        desk.put(&format!("{name}.obj"), desk.read("00.obj"));
    }
    let turn = "car.obj car1.obj -o cl/{model}%d.png --turntable 12 --resolution 8x8";
    for verb in ["render", "batch", "batch --unit frame", "batch --dry-run"] {
        desk.refused(&turn.replacen("car", &format!("{verb} car"), 1), 2, "0.png");
    }
    let run = desk.texmap(&format!("batch {turn}"));
    assert!(
        run.stderr
            .contains("car.obj and car1.obj would both write cl/car10.png"),
        "{}",
        run.stderr
    );
    for (items, flags) in [
        ("car.obj car.heat.obj", "--verify"),
        ("car.uv.obj car.obj", "--aov uv"),
    ] {
        let batch = format!("batch {items} -o b/{{model}}.png --resolution 8x8 {flags}");
        match flags {
            "--verify" => desk.refused(&batch, 2, "both write b/car.heat.png"),
            // The array is no picture.
            _ => drop(desk.texmap(&batch).ok()),
        }
    }
    // A manifest names both files of each item.
    desk.put(
        "m.json",
        r#"{"version":1,"settings":{"turntable":2,"resolution":"8x8"},"items":[
           {"input":"car.obj","output":"o/a%d.png"},{"input":"car1.obj","output":"o/a{n}.png"}]}"#,
    );
    desk.refused("batch m.json", 2, "both write o/a0.png");
    // The input of an item among the pictures of another.
    desk.put("t1.png", desk.read("check.png"));
    desk.put(
        "m.json",
        r#"{"version":1,"items":[{"input":"car.obj","output":"t%d.png","settings":{"turntable":2}},
           {"input":"t1.png","output":"o/a.png"}]}"#,
    );
    desk.refused("batch m.json", 2, "the output is the input");
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
            "bad.json: item 00.obj: ",
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
    // It would wait for ever: the standard input of a process of the batch has its tasks.
    desk.put(
        "bad.json",
        r#"{"version":1,"items":[{"id":"x","input":"-","output":"a.png"}]}"#,
    );
    for flags in ["", "--dry-run"] {
        desk.refused(
            &format!("batch bad.json {flags}"),
            2,
            "x: a batch does not read standard input",
        );
    }
    desk.refused("batch - -o a.png", 2, "does not read standard input");
    desk.refused("batch 00.obj 01.obj -o out.png", 2, "both write");
    desk.refused("batch 00.obj -o 00.obj", 2, "cannot be written as .obj");
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

/// Outputs that flags name beside `-o` have the words of their item, and lie in the folder that shards are merged from.
#[test]
fn further_outputs_are_told_apart() {
    let desk = Desk::new();
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
    desk.put("a.obj", quad);
    desk.put("b.obj", format!("{quad}f 4 3 2\n"));
    let batch = "batch uv a.obj b.obj -o u/{model}.obj --map box";
    let (all, _) = lines(
        &desk
            .texmap(&format!(
                "{batch} --tangents u/{{model}}.npy --pictures u/{{model}}"
            ))
            .ok(),
    );
    for (line, name) in all.iter().zip(["a", "b"]) {
        let outputs = line["outputs"].as_array().unwrap();
        let paths: Vec<&str> = outputs
            .iter()
            .map(|o| o["path"].as_str().unwrap())
            .collect();
        assert_eq!(paths.len(), 6, "{paths:?}");
        assert!(paths.iter().all(|path| path.starts_with(name)), "{paths:?}");
        desk.texmap(&format!(
            "uv {name}.obj -o {name}.out.obj --map box --tangents {name}.npy"
        ))
        .ok();
        assert_eq!(
            desk.read(&format!("u/{name}.npy")),
            desk.read(&format!("{name}.npy"))
        );
    }
    desk.texmap("merge u -o merged").ok();
    assert_eq!(desk.read("merged/a.npy"), desk.read("u/a.npy"));
    for (flags, word) in [
        ("--tangents u/t.npy", "both write u/t.npy"),
        ("--pictures u/p", "both write u/p"),
        ("--tangents {model}.npy", "outside of `u/`"),
        ("--tangents u/../{model}.npy", "outside of `u/`"),
        ("--report", "--report"),
    ] {
        desk.refused(&format!("{batch} {flags}"), 2, word);
    }
    // Objects whose names are one file name.
    desk.put(
        "twins.obj",
        "v 0 0 0\nv 1 0 0\nv 1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\no wall:1\nf 1/1 2/2 3/3\no wall 1\nf 1/1 3/3 2/2\n",
    );
    let bake = "bake twins.obj --light --object all --size 8 -o m/{object}.png";
    desk.texmap(bake).ok();
    desk.refused(
        &format!("batch {bake} --unit page"),
        2,
        "the file of another object",
    );
}
