//! The README promises two commands; `.ci/run` runs both.

use std::fs;

use crate::program::root;

const COMMANDS: [&str; 2] = [
    "cargo run --release -- render assets/scenes/purple_cow.scene -o cow.png",
    "cargo test --workspace",
];

#[test]
fn the_two_commands_stand_in_the_readme_and_in_the_checks() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let checks = fs::read_to_string(root().join(".ci/run")).unwrap();
    let mut places = Vec::new();
    for command in COMMANDS {
        places.push(
            readme
                .find(command)
                .unwrap_or_else(|| panic!("{command}: not in the README")),
        );
        let without_output = command.split(" -o ").next().unwrap();
        assert!(checks.contains(without_output), "{command}: not in .ci/run");
    }
    assert!(places[0] < places[1], "the main job comes first");
}

#[test]
fn every_link_into_the_repository_leads_somewhere() {
    for page in [
        "README.md",
        "CHANGELOG.md",
        "docs/ARCHITECTURE.md",
        "docs/CONTRIBUTING.md",
        "docs/GLTF.md",
        "docs/batch.md",
        "docs/deploy/README.md",
    ] {
        let path = root().join(page);
        let text = fs::read_to_string(&path).unwrap();
        for target in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            let file = target.split('#').next().unwrap();
            if !file.is_empty() && !target.starts_with("http") {
                assert!(
                    path.parent().unwrap().join(file).exists(),
                    "{page} links to {target}"
                );
            }
        }
    }
}
