//! Files of the repository: the README's commands and the committed scenes.

use crate::program::{Desk, root, run};

#[test]
fn the_readme_draws_what_it_says() {
    let desk = Desk::new();
    let out = desk.path("cow.png");
    let run = run(
        &root(),
        &[
            "render",
            "assets/scenes/purple_cow.scene",
            "-o",
            out.to_str().unwrap(),
        ],
    )
    .ok();
    assert!(run.stderr.contains("cow.png"), "{}", run.stderr);
    assert!(out.is_file());
}

#[test]
fn every_committed_scene_and_model_loads_without_a_warning() {
    let mut seen = 0;
    for folder in ["assets/scenes", "assets/models"] {
        let Ok(entries) = std::fs::read_dir(root().join(folder)) else {
            continue;
        };
        for entry in entries {
            let path = entry.unwrap().path();
            if !path.extension().is_some_and(|e| e == "scene" || e == "obj") {
                continue;
            }
            seen += 1;
            let mut args = vec!["render", path.to_str().unwrap(), "--dry-run"];
            // Its maps of the ambient colour and the exponent are those of the classic model.
            if path.ends_with("plate.obj") {
                args.push("--shading=classic");
            }
            let run = run(&root(), &args).ok();
            let text = String::from_utf8(run.stdout).unwrap();
            assert!(!text.contains("warning"), "{}: {text}", path.display());
        }
    }
    assert!(seen >= 3, "{seen} files");
}
