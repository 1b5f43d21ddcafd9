//! The tables of docs/SCENE_FORMAT.md against the parser: which words a command takes, and which value it has without its line.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use texmap_io::IoError;
use texmap_io::scene_file::{SECTIONS, Section, parse};

use crate::support::Files;

/// A row of a table of commands.
struct Row {
    command: &'static str,
    values: &'static str,
    default: Option<&'static str>,
    meaning: &'static str,
}

fn rows() -> Vec<Row> {
    let manual = include_str!("../../../docs/SCENE_FORMAT.md");
    let (mut rows, mut columns) = (Vec::new(), Vec::new());
    for line in manual.lines() {
        let Some(body) = line.strip_prefix('|') else {
            columns.clear();
            continue;
        };
        let cells = body.trim_end().trim_end_matches('|').split('|');
        let cells: Vec<&str> = cells.map(str::trim).collect();
        if columns.is_empty() {
            columns = cells;
            continue;
        }
        let cell = |name: &str| columns.iter().position(|c| *c == name).map(|i| cells[i]);
        if columns[0] == "command" && !cells[0].starts_with("---") {
            rows.push(Row {
                command: cells[0].trim_matches('`'),
                values: cell("values").expect("values"),
                default: cell("default"),
                meaning: cell("meaning").expect("a meaning"),
            });
        }
    }
    rows
}

/// The words between backquotes.
fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

/// A word without its parameter, and with one that is allowed.
fn bare(word: &str) -> &str {
    word.split([':', ' ', '[']).next().unwrap_or("")
}

/// `SCENE_FORMAT=write` puts the tables of the language into the manual.
#[test]
fn the_tables_are_those_of_the_language() {
    let manual = include_str!("../../../docs/SCENE_FORMAT.md");
    let mut sections = SECTIONS.iter().map(Section::manual);
    let (mut out, mut in_table) = (String::new(), false);
    for line in manual.split_inclusive('\n') {
        let begins = line.starts_with("| command |");
        in_table = begins || (in_table && line.starts_with('|'));
        if begins {
            out += &sections.next().expect("a section for each table");
        } else if !in_table {
            out += line;
        }
    }
    assert_eq!(sections.next(), None, "a table for each section");
    if std::env::var_os("SCENE_FORMAT").is_some_and(|how| how == "write") {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/SCENE_FORMAT.md");
        fs::write(path, &out).expect("the manual is written");
        return;
    }
    for (new, old) in out.lines().zip(manual.lines()) {
        assert_eq!(new, old, "write the tables by `.ci/pages write`");
    }
    assert_eq!(out, manual);
}

#[test]
fn the_manual_has_the_words_of_every_choice() {
    // True if the words stand in the column of meanings: `filter`, `wrap` and `interp` have too many for the column of values.
    let choices = [
        ("color", false),
        ("filter", true),
        ("wrap", true),
        ("interp", true),
        ("cull", false),
        ("alpha", false),
        ("gouraud", false),
        ("missing", false),
        ("shadowless", false),
        ("highlight", false),
        ("horizon", false),
    ];
    let rows = rows();
    for (command, in_meaning) in choices {
        let row = rows.iter().find(|r| r.command == command).expect(command);
        let Err(IoError::UnknownWord { allowed, .. }) =
            parse(Path::new("a"), &format!("{command} zzz"))
        else {
            panic!("{command} takes any word");
        };
        let known: BTreeSet<&str> = allowed.split(", ").map(bare).collect();
        let cell = if in_meaning { row.meaning } else { row.values };
        let listed: BTreeSet<&str> = quoted(cell).map(bare).collect();
        let missing: Vec<_> = known.difference(&listed).collect();
        assert!(
            missing.is_empty(),
            "{command}: the manual lacks {missing:?}"
        );
        for word in quoted(cell).filter(|word| !in_meaning || known.contains(bare(word))) {
            let word = word.split(" [").next().unwrap_or("");
            let word = word
                .replace(":N", ":2")
                .replace("TOLERANCE", "0.5")
                .replace("WIDTH", "0.75");
            let read = parse(Path::new("a"), &format!("{command} {word}"));
            assert!(read.is_ok(), "{command} {word}: {read:?}");
        }
        if !in_meaning {
            assert_eq!(listed, known, "{command}");
        }
    }
}

#[test]
fn a_line_with_the_default_of_the_manual_changes_nothing() {
    let files = Files::new().with_png("a.png", 4, 4, [9, 90, 190, 255]);
    let scene = |line: &str, textured: bool| {
        // A modulating texture looks whether there was any `surf` line: that one stands before faces without texture.
        let textured = if textured {
            "texture a.png\ntf 0 0 0 1 1 0 2 1 1\n"
        } else {
            ""
        };
        let faces = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 0 1 2\n";
        let text = format!("ld 1 1 1 0 -1 1\n{line}\n{faces}{textured}");
        fs::write(files.path("a.scene"), text).expect("a file");
        files.load("a.scene").map(|scene| format!("{scene:?}"))
    };
    let mut checked = Vec::new();
    for row in rows() {
        let default = row
            .default
            .and_then(|d| d.split([';', ',']).next())
            .unwrap_or("");
        let line = format!("{} {}", row.command, default.replace('`', ""));
        let textured = row.command != "surf";
        // Words such as "built in" and what is added by a line have none that can be written; `name none` is a name.
        // A default after FILE is that of the other values.
        let of_others = row.values.starts_with("FILE") && default != "none";
        if default.is_empty()
            || of_others
            || row.command == "name"
            || parse(Path::new("a"), &line).is_err()
        {
            continue;
        }
        let with = scene(&line, textured).unwrap_or_else(|e| panic!("{line}: {e}"));
        let without = scene("#", textured).expect("a scene");
        assert!(with == without, "`{line}` is not the default");
        checked.push(row.command);
    }
    for command in [
        "eye",
        "fov",
        "surf",
        "near",
        "far",
        "background",
        "filter",
        "wrap",
        "cull",
        "alpha",
        "bump",
        "cel",
    ] {
        assert!(checked.contains(&command), "{command}: {checked:?}");
    }
    assert!(checked.len() >= 30, "{checked:?}");
}

/// Every `FILE.rs` that the pages on the architecture name is a file of a crate. A name that is not one is found.
#[test]
fn files_that_the_architecture_names_exist() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let folders = fs::read_dir(crates).expect("the crates are there");
    let folders: Vec<_> = folders
        .map(|folder| folder.unwrap().path().join("src"))
        .collect();
    let exists = |file: &str| folders.iter().any(|folder| folder.join(file).is_file());
    let pages = [
        include_str!("../../../docs/ARCHITECTURE.md"),
        include_str!("../../../docs/OPTIMISATIONS.md"),
    ];
    let quoted = pages.iter().flat_map(|page| page.split('`'));
    let files: BTreeSet<&str> = quoted.filter(|word| word.ends_with(".rs")).collect();
    let lost: Vec<_> = files.iter().filter(|file| !exists(file)).collect();
    assert!(lost.is_empty(), "{lost:?}");
    assert!(files.len() > 30, "{files:?}");
    assert!(!exists("shade/direct.rs"));
}
