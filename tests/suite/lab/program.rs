//! `texmap diff` and `texmap hash` on pictures of one different value.
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use image::DynamicImage;
use tempfile::TempDir;
use texmap_tests::exr_files;

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
    // One colour value of 60 by 1/255: the root of the mean square is 0.000506.
    for (most, code) in [("0.0005", 1), ("0.00051", 0)] {
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

/// Floats that differ are found to differ, though both are clipped to one byte.
#[test]
fn floats_are_compared_and_hashed_as_floats() {
    let folder = Folder::new();
    for ending in ["hdr", "exr"] {
        let [a, b] = [3.0_f32, 200.0].map(|value| {
            let path = folder.path(&format!("{value}.{ending}"));
            let color = image::Rgba([value, value, value, 1.0]);
            let picture = image::Rgba32FImage::from_pixel(16, 12, color);
            match ending {
                "exr" => exr_files::write(&path, &picture).unwrap(),
                _ => DynamicImage::from(picture)
                    .into_rgb32f()
                    .save(&path)
                    .unwrap(),
            }
            path
        });
        let found = texmap(&["diff"], &[&a, &b]);
        let words = text(&found);
        assert_eq!(found.status.code(), Some(1), "{words}");
        assert!(words.contains("max   197 at"), "{words}");
        assert_eq!(
            texmap(&["diff", "--fail-max", "197"], &[&a, &b])
                .status
                .code(),
            Some(0)
        );
        assert_eq!(texmap(&["diff"], &[&a, &a]).status.code(), Some(0));
        let hashes = text(&texmap(&["hash"], &[&a, &b]));
        let hash: Vec<&str> = hashes
            .lines()
            .map(|l| l.split("  ").next().unwrap())
            .collect();
        assert_ne!(hash[0], hash[1]);
        let codes = folder.picture("codes.png", 100);
        assert_eq!(texmap(&["diff"], &[&a, &codes]).status.code(), Some(1));
    }
}

#[test]
fn sixteen_bits_are_compared_as_sixteen() {
    let folder = Folder::new();
    let [a, b] = [1000_u16, 1001].map(|value| {
        let path = folder.path(&format!("{value}.png"));
        let picture = image::ImageBuffer::from_pixel(4, 4, image::Luma([value]));
        picture.save(&path).unwrap();
        path
    });
    assert_eq!(texmap(&["diff"], &[&a, &b]).status.code(), Some(1));
}

/// Alpha has figures of its own, NaN is told, and figures have six digits.
#[test]
fn diff_tells_alpha_structure_and_holes_apart() {
    let folder = Folder::new();
    let picture = |name: &str, change: &dyn Fn(u32, u32) -> Option<[f32; 4]>| {
        let path = folder.path(name);
        let picture = image::Rgba32FImage::from_fn(24, 16, |x, y| {
            image::Rgba(change(x, y).unwrap_or([x as f32 / 24.0, y as f32 / 16.0, 0.5, 1.0]))
        });
        exr_files::write(&path, &picture).unwrap();
        path
    };
    let json = |a: &Path, b: &Path| -> serde_json::Value {
        serde_json::from_slice(&texmap(&["diff", "--json"], &[a, b]).stdout).unwrap()
    };
    let plain = picture("plain.exr", &|_, _| None);
    let clear = picture("clear.exr", &|x, y| {
        ((x, y) == (3, 5)).then_some([3.0 / 24.0, 5.0 / 16.0, 0.5, 0.25])
    });
    let report = json(&plain, &clear);
    assert_eq!(
        (&report["pass"], &report["max"]),
        (&false.into(), &0.0.into())
    );
    assert_eq!(report["alpha"]["max"], 0.75);
    assert_eq!(report["alpha"]["max_at"]["channel"], 3);
    assert_eq!(report["ssim"], 1.0);
    assert!(json(&plain, &plain)["alpha"].is_null());

    let holed = picture("holed.exr", &|x, y| {
        ((x, y) == (3, 5)).then_some([f32::NAN, 0.0, 0.5, 1.0])
    });
    let report = json(&holed, &holed);
    assert_eq!(
        (&report["pass"], &report["holes"]),
        (&true.into(), &1.into())
    );
    let report = json(&plain, &holed);
    assert_eq!(
        (&report["pass"], &report["non_finite"]),
        (&false.into(), &1.into())
    );
    let words = text(&texmap(&["diff"], &[&holed, &holed]));
    assert!(
        words.contains("NaN   1 values are not finite in both"),
        "{words}"
    );

    let turned = picture("turned.exr", &|x, y| {
        Some([1.0 - x as f32 / 24.0, y as f32 / 16.0, 0.5, 1.0])
    });
    let report = json(&plain, &turned);
    let ssim = report["ssim"].as_f64().unwrap();
    assert!(ssim < 0.9 && ssim > 0.0, "{ssim}");
    let words = text(&texmap(&["diff"], &[&plain, &turned]));
    let shown = words
        .lines()
        .find_map(|l| l.strip_prefix("SSIM  "))
        .unwrap();
    assert_eq!(shown.trim_start_matches("0.").len(), 6, "{words}");
    assert!((shown.parse::<f64>().unwrap() - ssim).abs() < 1e-6);
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
