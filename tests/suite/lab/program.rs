//! `texmap diff` and `texmap hash` on pictures of one different value.
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A picture of 5 x 4 grey pixels, one of which has another green.
    fn picture(&self, name: &str, green: u8) -> PathBuf {
        let mut picture = image::RgbaImage::from_pixel(5, 4, image::Rgba([100, 100, 100, 255]));
        picture.put_pixel(3, 2, image::Rgba([100, green, 100, 255]));
        picture.save(self.path(name)).unwrap();
        self.path(name)
    }
}

fn texmap(arguments: &[&str], files: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
        .args(arguments)
        .args(files)
        .output()
        .unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn diff_names_the_value_that_differs_and_its_limit_decides() {
    let folder = Folder::new();
    let (a, b) = (folder.picture("a.png", 100), folder.picture("b.png", 101));
    let equal = texmap(&["diff"], &[&a, &a]);
    assert!(
        equal.status.code() == Some(0) && text(&equal).ends_with("PASS\n"),
        "{}",
        text(&equal)
    );
    let differs = texmap(&["diff"], &[&a, &b]);
    assert!(
        differs.status.code() == Some(1) && text(&differs).ends_with("FAIL\n"),
        "{}",
        text(&differs)
    );
    assert!(
        text(&differs).contains("at x 3, y 2, channel 1"),
        "{}",
        text(&differs)
    );
    let allowed = texmap(&["diff", "--fail-max", "0.004"], &[&a, &b]);
    assert_eq!(allowed.status.code(), Some(0), "{}", text(&allowed));
    let too_much = texmap(&["diff", "--fail-max", "0.0039"], &[&a, &b]);
    assert_eq!(too_much.status.code(), Some(1), "{}", text(&too_much));
    // One value of 80 by 1/255: the root of the mean square is 0.00044.
    for (most, code) in [("0.00043", 1), ("0.00045", 0)] {
        let found = texmap(&["diff", "--fail-rms", most], &[&a, &b]);
        assert_eq!(found.status.code(), Some(code), "{most}: {}", text(&found));
    }
}

#[test]
fn diff_writes_json_and_heat() {
    let folder = Folder::new();
    let (a, b) = (folder.picture("a.png", 100), folder.picture("b.png", 140));
    let heat = folder.path("heat.png");
    let output = texmap(
        &["diff", "--json", "--heat", heat.to_str().unwrap()],
        &[&a, &b],
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["pass"], false);
    assert_eq!(
        (
            &report["max_at"]["x"],
            &report["max_at"]["y"],
            &report["over_limit"]
        ),
        (&3.into(), &2.into(), &1.into())
    );
    let heat = image::open(heat).unwrap().to_rgba8();
    assert_eq!(
        (heat.get_pixel(3, 2).0, heat.get_pixel(2, 2).0),
        ([255; 4], [0, 0, 0, 255])
    );
}

#[test]
fn diff_tells_unlike_sizes_and_files_that_are_not_there() {
    let folder = Folder::new();
    let a = folder.picture("a.png", 100);
    let small = folder.path("small.png");
    image::RgbaImage::new(2, 2).save(&small).unwrap();
    let sizes = texmap(&["diff"], &[&a, &small]);
    let words = String::from_utf8_lossy(&sizes.stderr).into_owned();
    assert!(
        sizes.status.code() == Some(1) && words.contains("5 x 4") && words.contains("2 x 2"),
        "{words}"
    );
    assert_eq!(
        texmap(&["diff"], &[&a, &folder.path("none.png")])
            .status
            .code(),
        Some(4)
    );
    assert_eq!(
        texmap(&["diff", "--fail-max", "NaN"], &[&a, &a])
            .status
            .code(),
        Some(2)
    );
}

#[test]
fn hashes_are_of_pixels_and_lists_of_them_are_checked() {
    let folder = Folder::new();
    let (a, b) = (folder.picture("a.png", 100), folder.picture("b.png", 101));
    // The same pixels encoded without alpha.
    let rgb = folder.path("rgb.png");
    image::open(&a).unwrap().to_rgb8().save(&rgb).unwrap();
    let hashes = text(&texmap(&["hash"], &[&a, &rgb, &b]));
    let hash: Vec<&str> = hashes
        .lines()
        .map(|line| line.split("  ").next().unwrap())
        .collect();
    assert!(
        hash.len() == 3 && hash[0] == hash[1] && hash[0] != hash[2],
        "{hashes}"
    );
    let list = folder.path("hashes.txt");
    let check = |lines: String| {
        std::fs::write(&list, lines).unwrap();
        texmap(&["hash", "--check"], &[&list])
    };
    assert_eq!(
        check(format!("{}  a.png\n{}  b.png\n", hash[0], hash[2]))
            .status
            .code(),
        Some(0)
    );
    let wrong = check(format!("{}  a.png\n{}  b.png\n", hash[0], hash[0]));
    assert!(
        wrong.status.code() == Some(1) && text(&wrong).contains("FAIL"),
        "{}",
        text(&wrong)
    );
    assert_eq!(check("no hash here\n".into()).status.code(), Some(4));
    assert_eq!(check(String::new()).status.code(), Some(4));
}
