//! Mutants of real files: refused with a message or read, never a panic.

use std::collections::BTreeMap;
use std::path::Path;

use texmap_io::{FileSource, LoadOptions, load};
use texmap_math::MemoryBudget;

use super::asset;
use super::compressed::data;

const SEEDS: [&str; 9] = [
    "box.glb",
    "plates.gltf",
    "mirrored.glb",
    "tangents.glb",
    "bent.glb",
    "sparse.gltf",
    "quantized.glb",
    "two_uv.glb",
    "instances.glb",
];

const COMPRESSED_SEEDS: [&str; 3] = [
    "bent.meshopt.glb",
    "instances.meshopt.glb",
    "materials.meshopt.glb",
];

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

/// A digit, a number, a byte or a word of the text is another; or bytes anywhere; or the end is missing.
fn mutate(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let text = match bytes.starts_with(b"glTF") {
        true => 20..bytes.len().min(2500),
        false => 0..bytes.len().min(4000),
    };
    if text.len() < 2 {
        return bytes.push(b'{');
    }
    let digits: Vec<usize> = text
        .clone()
        .filter(|i| bytes[*i].is_ascii_digit())
        .collect();
    let at = text.start + rng.below(text.len());
    match rng.below(8) {
        0..=3 if !digits.is_empty() => {
            bytes[digits[rng.below(digits.len())]] = b'0' + rng.below(10) as u8;
        }
        4 if !digits.is_empty() => {
            const NUMBERS: [&str; 8] = [
                "-1",
                "4294967295",
                "1e308",
                "18446744073709551615",
                "0.5",
                "null",
                "[]",
                "1e-320",
            ];
            let digit = digits[rng.below(digits.len())];
            bytes.splice(digit..=digit, NUMBERS[rng.below(8)].bytes());
        }
        5 => bytes[at] = rng.below(256) as u8,
        6 => {
            let anywhere = rng.below(bytes.len());
            bytes[anywhere] ^= 1 << rng.below(8);
        }
        7 if rng.below(4) == 0 => bytes.truncate(rng.below(bytes.len())),
        _ => {
            let other = text.start + rng.below(text.len());
            bytes.swap(at, other);
        }
    }
}

#[test]
fn ten_thousand_mutants_are_read_or_refused() {
    let files = SEEDS.map(asset).into_iter();
    let files = files.chain(COMPRESSED_SEEDS.map(data));
    let seeds: Vec<Vec<u8>> = files
        .map(|file| std::fs::read(file).expect("a seed"))
        .collect();
    let buffer = std::fs::read(asset("plates.bin")).expect("an asset");
    let picture = std::fs::read(asset("leaf card.png")).expect("an asset");
    let mut rng = Rng(1);
    let mut outcomes: BTreeMap<&str, usize> = BTreeMap::new();
    for n in 0..10_000 {
        let mut bytes = seeds[n % seeds.len()].clone();
        for _ in 0..1 + rng.below(3) {
            mutate(&mut bytes, &mut rng);
        }
        let files = FileSource::in_memory([
            ("a.gltf".into(), bytes),
            ("plates.bin".into(), buffer.clone()),
            ("leaf card.png".into(), picture.clone()),
        ]);
        let options = LoadOptions {
            files: files.with_memory(MemoryBudget::new(64 << 20)),
            time: (n % 3 == 0).then_some(0.7),
            camera: (n % 5 == 0).then(|| "0".to_owned()),
            ..LoadOptions::default()
        };
        let outcome = match load(Path::new("a.gltf"), &options) {
            Ok(scene) => {
                // A scene that was read can be checked, which looks at every vertex and index.
                let _ = scene.check();
                "read"
            }
            Err(error) => {
                let message = error.to_string();
                assert!(!message.contains('\n') && message.len() < 2000, "{message}");
                assert!(
                    (message.contains("a.gltf") || error.code() == "over-memory-budget")
                        && !error.help().is_empty(),
                    "{message}"
                );
                error.code()
            }
        };
        *outcomes.entry(outcome).or_default() += 1;
    }
    // The mutants reach all parts of the reader: some are read, most are refused for different reasons.
    assert!(
        outcomes["read"] > 500 && outcomes["broken-gltf"] > 1000,
        "{outcomes:?}"
    );
    assert!(
        outcomes.contains_key("broken-image") && outcomes.contains_key("file-missing"),
        "{outcomes:?}"
    );
}
