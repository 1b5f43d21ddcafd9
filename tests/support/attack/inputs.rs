//! Bad inputs that replace a good one: spoilt content, special files, and files that are too much.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::Command;

use texmap_io::scene_file::commands;

use super::rng::Rng;

const NUMBERS: [&str; 24] = [
    "0",
    "1",
    "-1",
    "2",
    "3",
    "0.5",
    "-0.5",
    "90",
    "1e-3",
    "1e9",
    "-1e9",
    "3.4e38",
    "-3.4e38",
    "1e39",
    "1e400",
    "1e-45",
    "-0",
    "nan",
    "inf",
    "-inf",
    "4294967296",
    "99999999999999999999",
    "0x10",
    "1e",
];

/// Words of the languages of models, libraries, walks and flags.
const WORDS: [&str; 40] = [
    "none",
    "auto",
    "taps",
    "repeat",
    "check.png",
    "m.obj",
    "grid.npy",
    "sky.hdr",
    "part.scene",
    "secret.txt",
    "all.scene",
    "none.png",
    "v",
    "vt",
    "vn",
    "f",
    "l",
    "g",
    "o",
    "s",
    "usemtl",
    "mtllib",
    "m.mtl",
    "newmtl",
    "Kd",
    "Ks",
    "Ns",
    "d",
    "map_Kd",
    "map_Bump",
    "-bm",
    "-s",
    "1/1/1",
    "-1//-1",
    "2/",
    "lat-long",
    "light",
    "\"",
    "\\",
    "#",
];

/// Content that is wrong in one of many ways, by the kind of file.
pub(super) fn spoilt(name: &str, good: &[u8], rng: &mut Rng) -> Vec<u8> {
    let text = !matches!(
        Path::new(name).extension().and_then(|e| e.to_str()),
        Some("png" | "gif" | "jpg" | "hdr" | "exr" | "npy" | "glb" | "stl" | "bin")
    );
    match rng.below(if text { 22 } else { 10 }) {
        0 => Vec::new(),
        1 => (0..rng.below(5000)).map(|_| rng.next() as u8).collect(),
        2 => good[..rng.below(good.len())].to_vec(),
        3..=5 => {
            let mut bytes = good.to_vec();
            for _ in 0..1 + rng.below(12) {
                let at = rng.below(bytes.len());
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = [rng.next() as u8, 0, 255, *byte ^ 1][rng.below(4)];
                }
            }
            bytes
        }
        6 => {
            let (from, to) = (rng.below(good.len()), rng.below(good.len()));
            [&good[..from.max(to)], &good[from.min(to)..]].concat()
        }
        7 => [good, &vec![rng.next() as u8; rng.below(100_000)]].concat(),
        8 => [&b"\xef\xbb\xbf"[..], good].concat(),
        9 => header(good, rng),
        10 => good
            .iter()
            .flat_map(|b| if *b == b'\n' { vec![13, 10] } else { vec![*b] })
            .collect(),
        11 => [good, b"\x1b[31m\x07\x9b2J \x1b]0;title\x07 1 2 3\n"].concat(),
        12 => {
            let word = if rng.chance(2) { "Q" } else { "9" };
            let line = format!(
                "{} {}\n",
                rng.pick(&["v", "f", "o", "texture", "Q", "usemtl", "newmtl"]),
                word.repeat(200_000)
            );
            [good, line.as_bytes()].concat()
        }
        13..=15 => words(good, rng),
        _ => numbers(good, rng),
    }
}

/// Numbers that a format allows and few expect.
fn numbers(good: &[u8], rng: &mut Rng) -> Vec<u8> {
    let text = String::from_utf8_lossy(good).into_owned();
    const ENDS: [char; 8] = [' ', '\n', ',', '[', ']', ':', '{', '}'];
    let mut words: Vec<&str> = text.split_inclusive(ENDS).collect();
    let is_number = |word: &&str| word.trim_end_matches(ENDS).parse::<f64>().is_ok();
    let places: Vec<usize> = (0..words.len()).filter(|&i| is_number(&words[i])).collect();
    let extremes = [
        "0",
        "-0",
        "1",
        "-1",
        "0.5",
        "1e-3",
        "1e-38",
        "1e-45",
        "1e9",
        "-1e9",
        "1e30",
        "3.4e38",
        "-3.4e38",
        "2",
        "90",
        "180",
        "360",
        "16384",
        "1000000",
        "4294967295",
    ];
    let mut fresh = Vec::new();
    for _ in 0..1 + rng.below(6) {
        if places.is_empty() {
            break;
        }
        let at = places[rng.below(places.len())];
        let end = words[at].trim_start_matches(|c: char| !ENDS.contains(&c));
        fresh.push((at, format!("{}{end}", rng.pick(&extremes))));
    }
    for (at, word) in &fresh {
        words[*at] = word;
    }
    words.concat().into_bytes()
}

/// Sizes in the header of a picture or an array.
fn header(good: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = good.to_vec();
    if bytes.starts_with(b"\x93NUMPY") {
        let text = String::from_utf8_lossy(&good[10..]).into_owned();
        let shape = [
            "(0,)",
            "(1<<60,)",
            "(4294967295,4294967295,2,)",
            "(-1,)",
            "(2,2,2,9,)",
            "()",
            "(1000000000,4,)",
        ];
        let open = text.find('(').unwrap_or(0);
        let close = text.find(')').map_or(text.len(), |at| at + 1);
        let text = format!("{}{}{}", &text[..open], rng.pick(&shape), &text[close..]);
        return [&good[..10], text.as_bytes()].concat();
    }
    for byte in bytes
        .iter_mut()
        .skip(4 + rng.below(16))
        .take(1 + rng.below(8))
    {
        *byte = [0, 255, 127, 128][rng.below(4)];
    }
    bytes
}

/// Words of a text changed, dropped, repeated, and lines added.
fn words(good: &[u8], rng: &mut Rng) -> Vec<u8> {
    let text = String::from_utf8_lossy(good).into_owned();
    let mut lines: Vec<Vec<String>> = text
        .lines()
        .map(|line| line.split(' ').map(str::to_owned).collect())
        .collect();
    for _ in 0..1 + rng.below(4) {
        if rng.chance(3) {
            let words: Vec<_> = commands().map(|spec| spec.word).collect();
            let mut line = vec![rng.pick(&words).to_owned()];
            line.extend((0..rng.below(14)).map(|_| word(rng)));
            lines.insert(rng.below(lines.len() + 1), line);
            continue;
        }
        let at = rng.below(lines.len());
        let Some(line) = lines.get_mut(at) else { break };
        let within = rng.below(line.len());
        match rng.below(6) {
            0 => line.truncate(within + 1),
            1 => line.insert(within, word(rng)),
            2 => {
                let again = line[within].clone();
                line.extend(std::iter::repeat_n(again, 1 + rng.below(1000)));
            }
            3 => {
                let line = line.clone();
                lines.push(line);
            }
            _ => line[within] = word(rng),
        }
    }
    let lines: Vec<String> = lines.iter().map(|words| words.join(" ")).collect();
    (lines.join("\n") + "\n").into_bytes()
}

fn word(rng: &mut Rng) -> String {
    let from = if rng.chance(3) {
        &WORDS[..]
    } else {
        &NUMBERS[..]
    };
    rng.pick(from).to_owned()
}

/// Puts something that is no ordinary file, or no file, at `path`; its name for the log.
pub(super) fn special(path: &Path, rng: &mut Rng) -> io::Result<&'static str> {
    let _ = fs::remove_file(path);
    let kinds = [
        "missing",
        "folder",
        "pipe",
        "/dev/zero",
        "/dev/full",
        "/dev/null",
        "/dev/stdin",
        "loop of links",
        "dangling link",
        "secret",
        "hole",
        "empty",
        "/proc/self/mem",
    ];
    let kind = kinds[rng.below(kinds.len())];
    match kind {
        "missing" => {}
        "folder" => fs::create_dir(path)?,
        "pipe" => {
            Command::new("mkfifo").arg(path).status()?;
        }
        "loop of links" => link(path, path)?,
        "dangling link" => link(Path::new("nowhere"), path)?,
        "secret" => link(Path::new("secret.txt"), path)?,
        "hole" => File::create(path)?.set_len(5 << 30)?,
        "empty" => drop(File::create(path)?),
        device => link(Path::new(device), path)?,
    }
    Ok(kind)
}

#[cfg(unix)]
fn link(to: &Path, at: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(to, at)
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> io::Result<()> {
    Ok(())
}

/// Puts too much of something into `all.scene` or `m.obj`; its name for the log.
pub(super) fn huge(folder: &Path, rng: &mut Rng) -> io::Result<&'static str> {
    let (scene, model) = (folder.join("all.scene"), folder.join("m.obj"));
    let mut text = fs::read_to_string(&scene)?;
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let kind = rng.below(26);
    let mut lines = |n: usize, line: &dyn Fn(usize) -> String| {
        for i in 0..n {
            let _ = writeln!(text, "{}", line(i));
        }
    };
    let name = match kind {
        0 => {
            lines(200_000, &|_| "push".into());
            "200,000 times push"
        }
        1 => {
            lines(200_000, &|i| format!("v {i} 0 0"));
            "200,000 vertices"
        }
        2 => {
            fs::write(folder.join("part.scene"), "v 1 2 3\n".repeat(20_000))?;
            lines(4_000, &|_| "include part.scene".into());
            "4,000 includes of 20,000 vertices"
        }
        3 => {
            for i in 0..20 {
                let below = format!("include i{}.scene\ninclude i{}.scene\n", i + 1, i + 1);
                fs::write(folder.join(format!("i{i}.scene")), below)?;
            }
            fs::write(folder.join("i20.scene"), "v 0 0 0\n")?;
            lines(1, &|_| "include i0.scene".into());
            "2^20 includes"
        }
        4 => {
            lines(1, &|_| "Q".repeat(2_000_000));
            "a word of 2 MB"
        }
        5 => {
            let corners: String = (0..20_000).map(|i| format!(" {}", i % 4)).collect();
            lines(1, &|_| format!("f{corners}"));
            "a face of 20,000 corners"
        }
        6 => {
            lines(20_000, &|i| format!("surf 0.1 0.2 0.3 1 1 0 {i}\nf 0 1 2"));
            "20,000 materials"
        }
        7 => {
            lines(1, &|_| {
                format!("text \"{}\" 0 1 0 0.1 0 0 0 0.2 0", "A".repeat(20_000))
            });
            "20,000 letters"
        }
        8 => {
            lines(2_000, &|i| format!("lp 1 1 1 {i} 1 1"));
            "2,000 lights"
        }
        9 => {
            lines(400, &|_| "lp 1 1 1 0 5 0\nshadow 16384".into());
            "400 shadow maps of 16384"
        }
        10 => {
            lines(1, &|_| {
                "displace check.png 1 texels 0.5 triangles 4000000000\nobj m.obj".into()
            });
            "a displacement without a limit"
        }
        11 => {
            fs::write(&model, format!("{quad}{}", "f 1 2 3\n".repeat(20_000)))?;
            lines(100, &|_| "obj m.obj".into());
            "100 times a model of 20,000 faces"
        }
        12 => {
            let groups: String = (0..20_000)
                .map(|i| format!("o n{i}\nusemtl u{i}\nf 1 2 3\n"))
                .collect();
            fs::write(&model, format!("{quad}{groups}"))?;
            "20,000 groups"
        }
        13 => {
            fs::write(&model, format!("{quad}o {}\nf 1 2 3\n", "Q".repeat(70_000)))?;
            "a name of 70,000 characters"
        }
        14 => {
            fs::write(&model, "v 0 0 3e38\nv 1 0 3e38\nv 0 1 3e38\nf 1 2 3\n")?;
            "a model at 3e38"
        }
        15 => {
            let corners: String = (1..=10_000).map(|i| format!(" {i}")).collect();
            let ring: String = (0..10_000)
                .map(|i| {
                    let (x, y) = (f64::from(i) * 0.001, f64::from(i % 7) * 1e-4);
                    format!(
                        "v {x} {y} {}\nvt {x} {y}\n",
                        f64::from(i) * f64::from(10_000 - i) * 1e-7
                    )
                })
                .collect();
            fs::write(&model, format!("{ring}f{corners}\n"))?;
            "a polygon of 10,000 corners"
        }
        16 => {
            let far: String = (0..1_000)
                .map(|i| format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\n"))
                .collect();
            let faces: String = (0..1_000)
                .map(|i| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3))
                .collect();
            fs::write(
                &model,
                format!("{far}v 1e6 0 0\nv 1e6 1 0\nv 1e6 0 1\n{faces}f -1 -2 -3\n"),
            )?;
            "1,000 triangles and a far one"
        }
        17 => {
            lines(4_000, &|i| {
                format!(
                    "surf 0.1 0.2 0.3 1 1 0 {i}\nv -2 0 -{i}\nv 2 0 -{i}\nv 0 2 -{i}\nf {} {} {}",
                    4 + 3 * i,
                    5 + 3 * i,
                    6 + 3 * i
                )
            });
            "4,000 materials in a pile"
        }
        18 => {
            let counts = "4294967295";
            let text = fs::read_to_string(folder.join("p.ply"))?;
            fs::write(
                folder.join("p.ply"),
                text.replace("vertex 4", &format!("vertex {counts}"))
                    .replace("face 2", &format!("face {counts}")),
            )?;
            "a PLY of 4,294,967,295 vertices"
        }
        19 => {
            let mut bytes = fs::read(folder.join("cube.stl"))?;
            bytes[80..84].fill(255);
            fs::write(folder.join("cube.stl"), bytes)?;
            "an STL of 4,294,967,295 triangles"
        }
        20 => {
            let text = fs::read_to_string(folder.join("plates.gltf"))?;
            let text = text.replace("\"count\":4", "\"count\":4000000000");
            fs::write(folder.join("plates.gltf"), text)?;
            "a glTF of 4,000,000,000 vertices"
        }
        21 => {
            let camera = r#"{"eye":[0,1,6],"look":[0,1,0]}"#;
            let all = vec![camera; 3_000].join(",");
            fs::write(folder.join("cams.json"), format!("[{all}]"))?;
            fs::write(folder.join("walk.json"), format!("[{all}]"))?;
            "3,000 cameras"
        }
        22 => {
            fs::write(folder.join("models.txt"), "none.obj\n".repeat(2_000))?;
            fs::write(folder.join("cams.json"), "[".repeat(100_000))?;
            "a list of one missing file and 100,000 brackets"
        }
        23 => {
            let nodes: Vec<String> = (0..20_000)
                .map(|i| format!("{{\"children\":[{}],\"mesh\":0}}", i + 1))
                .chain(["{\"mesh\":0}".to_owned()])
                .collect();
            let text = fs::read_to_string(folder.join("plates.gltf"))?;
            let begin = text.find("\"nodes\":[").map_or(0, |at| at + 9);
            let end = text[begin..].find("}]").map_or(begin, |at| begin + at + 1);
            let text = format!("{}{}{}", &text[..begin], nodes.join(","), &text[end..]);
            fs::write(folder.join("plates.gltf"), text)?;
            "a chain of 20,000 nodes"
        }
        24 => {
            let faces: String = (0..100_000)
                .map(|i| format!("3 0 {} 2\n", 1 + i % 3))
                .collect();
            let text = fs::read_to_string(folder.join("p.ply"))?;
            let text = text.replace("face 2", "face 100002");
            fs::write(folder.join("p.ply"), text + &faces)?;
            "a PLY of 100,002 faces"
        }
        _ => {
            fs::write(
                folder.join("list.txt"),
                "sha256:00  check.png\n".repeat(2_000),
            )?;
            fs::write(folder.join("uv.csv"), "0.5,0.5\n".repeat(500_000))?;
            "long lists"
        }
    };
    fs::write(&scene, text)?;
    Ok(name)
}
