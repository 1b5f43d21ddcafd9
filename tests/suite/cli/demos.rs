//! `texmap demo`: every demo draws, and its claims hold.

use crate::program::Desk;

#[test]
fn every_listed_demo_draws_and_keeps_its_claims() {
    let desk = Desk::new();
    let list = desk.texmap("demo --list --json").ok().json();
    let names: Vec<&str> = list
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["name"].as_str().unwrap())
        .collect();
    assert!(names.len() >= 9, "{names:?}");
    let words = String::from_utf8(desk.texmap("demo --list").ok().stdout).unwrap();
    assert_eq!(words.lines().count(), names.len());
    for name in names {
        let run = desk.texmap(&format!("demo {name} -o {name}.png --json"));
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        let report = run.json();
        let claims = report["claims"].as_array().unwrap();
        assert!(!claims.is_empty(), "{name} claims nothing");
        assert!(
            claims.iter().all(|c| c["holds"] == true),
            "{name}: {}",
            run.stderr
        );
        let picture = image::load_from_memory(&desk.read(&format!("{name}.png"))).unwrap();
        assert!(picture.width() >= 384 && picture.height() >= 384, "{name}");
    }
}

/// The moving spotlight as numbered frames, each within a code of a fresh bake.
#[test]
fn a_demo_that_moves_is_written_as_numbered_frames() {
    let desk = Desk::new();
    let run = desk
        .texmap("demo light-maps --frames 3 -o spot%02d.png --json")
        .ok();
    let claims = run.json()["claims"].as_array().unwrap().clone();
    assert_eq!(claims.len(), 3);
    assert!(claims.iter().all(|c| c["holds"] == true), "{claims:?}");
    let frames = [0, 1, 2].map(|n| desk.read(&format!("spot0{n}.png")));
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
    desk.refused("demo light-maps --frames 3 -o spot.png", 2, "%02d");
    desk.refused("demo shadows --frames 3 -o s%02d.png", 2, "light-maps");
}

#[test]
fn an_unknown_demo_is_refused_with_the_list() {
    let desk = Desk::new();
    let run = desk.texmap("demo nothing -o out.png");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("forward-inverse"), "{}", run.stderr);
    assert!(!desk.path("out.png").exists());
    assert_eq!(desk.texmap("demo tiling -o room.scene/out.png").code, 4);
}
