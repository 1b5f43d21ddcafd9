//! The fuzz targets on stable: their corpus, and seeded mutations of it. `fuzz/README.md` says how to go on from here.

use std::path::Path;
use std::time::Instant;

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

/// Runs the seeds and `count` mutations, or mutations for `TEXMAP_FUZZ_SECONDS`. A failure names the input.
fn smoke(target: &str, words: &[&str], count: usize, run: fn(&[u8])) {
    let seeds = corpus(target);
    let seconds: Option<u64> = std::env::var("TEXMAP_FUZZ_SECONDS")
        .ok()
        .map(|s| s.parse().expect("seconds"));
    let begin = Instant::now();
    let goes_on = |n: usize| match seconds {
        Some(seconds) => begin.elapsed().as_secs() < seconds,
        None => n < seeds.len() + count,
    };
    // A long run has inputs of its own.
    let mut rng = Rng(seconds.map_or(1, |_| std::process::id().into()));
    let mut n = 0;
    while goes_on(n) {
        let bytes = seeds
            .get(n)
            .cloned()
            .unwrap_or_else(|| mutated(&seeds, words, &mut rng));
        let caught = std::panic::catch_unwind(|| run(&bytes));
        if caught.is_err() && seconds.is_some() {
            let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{target}-{n}"));
            std::fs::write(&file, &bytes).expect("the input");
            panic!("{target}, input {n}: {}", file.display());
        }
        assert!(
            caught.is_ok(),
            "{target}, input {n}: {:?}",
            String::from_utf8_lossy(&bytes)
        );
        n += 1;
    }
    if seconds.is_some() {
        eprintln!("{target}: {n} inputs");
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

#[test]
fn polygon_files() {
    let words = [
        "nan",
        "1e39",
        "-1",
        "0",
        "3",
        "255",
        "4294967295",
        "element face 1\n",
        "element vertex 0\n",
        "property list uchar int vertex_indices\n",
        "property float s\nproperty float t\n",
        "property list uchar float texcoord\n",
        "property int texnumber\n",
        "comment TextureFile a.png\n",
        "end_header\n",
        "\r\n",
        "double",
        "binary_big_endian",
        "ascii",
        "\0",
        "\u{fffd}",
    ];
    smoke("ply", &words, 6000, targets::ply);
}

#[test]
fn stereolithography_files() {
    let words = [
        "solid",
        "facet\n",
        "vertex 0 0 0\n",
        "endfacet\n",
        "nan",
        "1e39",
        "\n",
        "\0",
        "\u{fffd}",
    ];
    smoke("stl", &words, 4000, targets::stl);
}

#[test]
fn material_libraries() {
    let words = [
        "nan",
        "1e39",
        "-1",
        "0",
        "newmtl a\n",
        "newmtl b\n",
        "map_Kd a.png\n",
        "map_Ke absent.png\n",
        "-clamp on ",
        "-bm 1e30 ",
        "-s 0 0 0 ",
        "Kd ",
        "Ke ",
        "d ",
        "Tr ",
        "illum ",
        "norm a.png\n",
        "disp a.png\n",
        "bump a.png\n",
        "\\\n",
        "\r",
        "\0",
        "\u{e9}",
        "#",
        "map_d fuzz.mtl\n",
    ];
    smoke("mtl", &words, 1000, targets::mtl);
}

#[test]
fn pictures() {
    smoke("image", &[], 1500, targets::image);
}

#[test]
fn gltf_models() {
    let words = [
        "-1",
        "4294967295",
        "1e308",
        "null",
        "[]",
        "{}",
        "\"count\":9",
        "\"mode\":5",
        "\"byteStride\":255",
        "\"sparse\"",
        "\"children\":[0]",
        "5126",
    ];
    smoke("gltf", &words, 1500, targets::gltf);
}

#[test]
fn arrays() {
    let words = [
        "(0,)",
        "()",
        "(1, 0, 2)",
        "(99999999999,)",
        "'<f8'",
        "'|u1'",
        "'>f4'",
        "True",
        "\n",
        "'descr'",
        "-1",
        ",",
    ];
    smoke("npy", &words, 1500, targets::npy);
}

#[test]
fn camera_paths() {
    let words = [
        "1e309",
        "-0",
        "null",
        "[",
        "]",
        "{}",
        ",",
        "\"up\": [0, 0, 0]",
        "\"fov\": 0",
        "\\u0000",
        "\n",
        "true",
    ];
    smoke("path", &words, 1500, targets::path);
}

#[test]
fn camera_lists() {
    let words = [
        "1e309",
        "1e308",
        "-0",
        "null",
        "[",
        "]",
        "{}",
        ",",
        "\"fov\":180",
        "\"eye\":[0,0,0]",
        "\"look\":[1e308,0,0]",
        "\"axes\":\"opencv\"",
        "\"orthographic_width\":-1",
        "\"width\":0",
        "\\u0000",
        "\n",
        "true",
    ];
    smoke("cameras", &words, 4000, targets::cameras);
}

#[test]
fn images_for_gpus() {
    smoke("gpu_image", &[], 4000, targets::gpu_image);
}

#[test]
fn light_paths() {
    let words = [
        "1e309",
        "1e308",
        "-0",
        "null",
        "[",
        "]",
        "{}",
        ",",
        "\"position\":[0,0,0]",
        "\"look\":[0,0,0]",
        "\"direction\":[0,0,0]",
        "\"color\":[1e-320,0,0]",
        "\n",
        "true",
    ];
    smoke("light_path", &words, 4000, targets::light_path);
}

#[test]
fn manifests_of_batches() {
    let words = [
        "1",
        "-1",
        "null",
        "true",
        "[",
        "]",
        "{}",
        ",",
        "\"-\"",
        "\"settings\":{\"turntable\":3}",
        "\"settings\":{\"output\":\"x\"}",
        "\"frames\":4294967295",
        "\"turntable\":99999999999",
        "\"views\":[]",
        "\"to\":[\"0,0\",\"--json\"]",
        "\"id\":\"\"",
        "\"output\":\"{id}.png\"",
        "{dir}",
        "%d",
        "../",
        "\\u0000",
        "\n",
    ];
    smoke("manifest", &words, 400, targets::manifest);
}

#[test]
fn reports_of_shards() {
    let words = [
        "18446744073709551615",
        "4294967295/4294967295",
        "0/0",
        "0-18446744073709551615",
        "-1",
        "null",
        "\"killed\"",
        "\"planned\"",
        "\n",
        "{}",
        "..",
    ];
    smoke("report", &words, 4000, targets::report);
}

#[test]
fn plans() {
    let words = [
        "nan",
        "1e39",
        "0",
        "-1",
        "interp affine\n",
        "shade modulate vertex\n",
        "fov 180\n",
        "near 1e38\n",
        "scale 0\n",
        "f 0 1 2\n",
    ];
    smoke("planner", &words, 400, targets::planner);
}

#[test]
fn coordinates() {
    smoke("uv", &[], 2000, targets::uv);
}

#[test]
fn look_ups() {
    smoke("sample", &[], 4000, targets::sample);
}

#[test]
fn light() {
    smoke("light", &[], 2000, targets::light);
}

/// The harness sees a panic: a target that refuses long inputs fails.
#[test]
fn a_panic_is_a_finding() {
    let found = std::panic::catch_unwind(|| {
        smoke("obj", &["f 1 2 3"], 50, |bytes| assert!(bytes.len() < 30));
    });
    assert!(found.is_err());
}
