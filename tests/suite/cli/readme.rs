//! The README promises two commands, which `.ci/run` runs, and commands on files of `assets`.

use std::fs;

use crate::program::{Desk, root};

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

/// The lines of the shell blocks below "The program".
fn commands() -> Vec<String> {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let section = readme
        .split("\n## ")
        .find(|s| s.starts_with("The program\n"));
    let blocks = section.expect("the section").split("```sh\n").skip(1);
    let lines = blocks.flat_map(|block| block.split("```").next().unwrap_or("").lines());
    lines.map(str::to_owned).collect()
}

/// Each in the order of the README in one folder, pictures smaller than there. Left out: the chart and the failure cases, which `.ci/run`
/// makes, and the lab, which serves until it is stopped.
#[cfg(unix)]
#[test]
fn the_readmes_commands_run_as_they_stand() {
    use std::os::unix::fs::symlink;
    use std::process::{Command, Stdio};

    let desk = Desk::new();
    fs::create_dir(desk.path("bin")).unwrap();
    symlink(env!("CARGO_BIN_EXE_texmap-tested"), desk.path("bin/texmap")).unwrap();
    symlink(root().join("assets"), desk.path("assets")).unwrap();
    let path = format!(
        "{}:{}",
        desk.path("bin").display(),
        std::env::var("PATH").unwrap()
    );
    let run = |line: &str| {
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).env("PATH", &path);
        shell.current_dir(desk.path(".")).stdin(Stdio::null());
        let output = shell.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), error)
    };
    let left_out = ["chart", "stability", "play"].map(|verb| format!("texmap {verb}"));
    let mut count = 0;
    for line in commands() {
        if left_out.iter().any(|verb| line.starts_with(verb)) {
            continue;
        }
        let small = match line.strip_prefix("texmap render ") {
            Some(rest) if !rest.contains("--resolution") => {
                format!("texmap render --resolution 96x72 {rest}")
            }
            _ => line.clone(),
        };
        let small = small.replace("--resolution 320x240", "--resolution 64x48");
        let (code, error) = run(&small);
        assert_eq!(code, Some(0), "{line}\n{error}");
        count += 1;
    }
    assert!(count >= 28, "{count} commands");
    assert_eq!(
        run("texmap render assets/models/none.obj -o none.png").0,
        Some(4)
    );
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
