//! The fuzz targets on stable: their corpus, and seeded mutations of it. `fuzz/README.md` says how to go on from here.

use std::path::Path;

#[path = "../../../fuzz/src/lib.rs"]
#[expect(
    unreachable_pub,
    reason = "the same file is a crate of its own for cargo-fuzz"
)]
mod targets;

/// The seeds of a target, in the order of their names.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fuzz/corpus")
        .join(target);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .expect("a folder of seeds")
        .map(|e| e.expect("a seed").path())
        .collect();
    files.sort();
    assert!(files.len() >= 6, "{} has seeds", folder.display());
    files
        .iter()
        .map(|f| std::fs::read(f).expect("a seed"))
        .collect()
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Rng(u64);

impl Rng {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// One to four changes: a bit, a byte, a piece cut out, doubled or taken from another seed, a word.
fn mutated(seeds: &[Vec<u8>], words: &[&str], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = seeds[rng.below(seeds.len())].clone();
    for _ in 0..1 + rng.below(4) {
        let at = rng.below(bytes.len() + 1);
        let piece = |from: &[u8], rng: &mut Rng| {
            let start = rng.below(from.len() + 1);
            let end = start + rng.below((from.len() - start).min(40) + 1);
            from[start..end].to_vec()
        };
        match rng.below(6) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.below(8),
            1 if at < bytes.len() => bytes[at] = rng.below(256) as u8,
            2 => {
                let end = (at + rng.below(12)).min(bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                let double = piece(&bytes, rng);
                bytes.splice(at..at, double);
            }
            4 => {
                let other = piece(&seeds[rng.below(seeds.len())], rng);
                bytes.splice(at..at, other);
            }
            _ if !words.is_empty() => {
                let word = words[rng.below(words.len())];
                let end = (at + rng.below(4)).min(bytes.len());
                bytes.splice(at..end, word.bytes());
            }
            _ => {}
        }
    }
    bytes
}

/// Runs the seeds and `count` mutations; a failure names the input.
fn smoke(target: &str, words: &[&str], count: usize, run: fn(&[u8])) {
    let seeds = corpus(target);
    let mut rng = Rng(1);
    let mutations = (0..count).map(|_| mutated(&seeds, words, &mut rng));
    for (n, bytes) in seeds
        .iter()
        .cloned()
        .chain(mutations.collect::<Vec<_>>())
        .enumerate()
    {
        let caught = std::panic::catch_unwind(|| run(&bytes));
        assert!(
            caught.is_ok(),
            "{target}, input {n}: {:?}",
            String::from_utf8_lossy(&bytes)
        );
    }
}

#[test]
fn draw_calls() {
    smoke("draw", &[], 4000, targets::draw);
}

#[test]
fn scene_files() {
    let words = [
        "nan",
        "1e39",
        "-1",
        "0",
        "1e-46",
        "v",
        "f",
        "tf",
        "ff",
        "frame",
        "push",
        "pop",
        "\"",
        "#",
        "\n",
        "include fuzz.scene\n",
        "obj fuzz.scene\n",
        "texture none\n",
        "eye 0 0 0\n",
        "fov 180\n",
        "scale 0\n",
        "near 1e38\n",
        "999999999999",
        "\\",
        "\u{e9}",
        "\0",
        "interp span:0\n",
    ];
    smoke("scene", &words, 1500, targets::scene);
}

#[test]
fn models() {
    let words = [
        "nan",
        "inf",
        "1e39",
        "-1",
        "0",
        "/",
        "//",
        "1/1/1",
        "f ",
        "v ",
        "vt ",
        "vn ",
        "\\\n",
        "\r",
        "\n",
        "usemtl x\n",
        "mtllib fuzz.obj\n",
        "99999999999999999999",
        "-9223372036854775808",
        "#",
        "\0",
        "\u{fffd}",
        "g",
        "o",
        "s off\n",
        "l 1 2\n",
    ];
    smoke("obj", &words, 1500, targets::obj);
}

/// The harness sees a panic: a target that refuses long inputs fails.
#[test]
fn a_panic_is_a_finding() {
    let found = std::panic::catch_unwind(|| {
        smoke("obj", &["f 1 2 3"], 50, |bytes| assert!(bytes.len() < 30));
    });
    assert!(found.is_err());
}
