//! The list of hashes that other machines are held against, on every level of this one.

use std::num::NonZeroUsize;
use std::path::Path;

use texmap_targets::{EFFECT_SCENES, Folders, effects, hashes};
use texmap_tests::levels::levels;

fn folders(work: &Path) -> Folders {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Folders {
        assets: root.join("../assets"),
        data: root.join("targets/data"),
        work: work.to_owned(),
    }
}

#[test]
fn every_level_has_the_hashes_of_the_list() {
    let pinned = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/targets.txt");
    let work = tempfile::tempdir().expect("a folder");
    for (name, level) in levels() {
        let list = hashes(&folders(work.path()), level, NonZeroUsize::MIN).expect("good scenes");
        if std::env::var_os("TEXMAP_BLESS").is_some() && name == levels()[0].0 {
            std::fs::write(&pinned, &list).expect("the list");
        }
        let expected = std::fs::read_to_string(&pinned).expect("tests/golden/targets.txt");
        let differ: Vec<_> = list
            .lines()
            .zip(expected.lines())
            .filter(|(a, b)| a != b)
            .collect();
        assert!(differ.is_empty(), "{name}, found and expected: {differ:#?}");
        assert_eq!(list.lines().count(), expected.lines().count(), "{name}");
    }
}

/// Each word of the language stands in at least two of the random scenes, so that no effect goes unseen.
#[test]
fn the_random_scenes_say_every_word() {
    let work = tempfile::tempdir().expect("a folder");
    let texts: Vec<String> = (0..EFFECT_SCENES)
        .map(|seed| effects::text(seed, &folders(work.path())))
        .collect();
    let words = "eye look up fov near far background color la ld lp surf v f texture tf frame ff round filter wrap border interp \
                 cull alpha shade gouraud translate rotate scale push pop missing obj include ls name shadow shadowless projector \
                 highlight env specmap lightmap lightmapuv bump offsetmap carve emboss normalmap horizon solid ramp cel decal text \
                 sky volume displace terrain billboard bone skin emission";
    for word in words.split_whitespace() {
        let says = |text: &&String| {
            text.lines()
                .any(|line| line.split(' ').next() == Some(word))
        };
        let count = texts.iter().filter(says).count();
        assert!(count >= 2, "'{word}' stands in {count} scenes");
    }
}
