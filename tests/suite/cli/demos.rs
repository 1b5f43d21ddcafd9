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

#[test]
fn an_unknown_demo_is_refused_with_the_list() {
    let desk = Desk::new();
    let run = desk.texmap("demo nothing -o out.png");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("forward-inverse"), "{}", run.stderr);
    assert!(!desk.path("out.png").exists());
    assert_eq!(desk.texmap("demo tiling -o no/such/out.png").code, 4);
}
