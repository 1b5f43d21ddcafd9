//! Memory and time of units before they run, from the planner's prices and the sizes of the input files.
//!
//! Nothing is loaded but the heads of textures. docs/batch.md says how well this predicts.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Serialize;
use texmap_planner::prices;
use texmap_sample::Filter;
use texmap_scene::shadow_fit::ENVIRONMENT_SHADOW_SIZE;

use super::textures::texels;
use crate::cmd::batch::plan::{Plan, Unit, UnitPart};

/// Seconds of one core for a byte of an input: parsing, vertices, set-up.
const SECONDS_A_BYTE: f64 = 25e-9;
/// Seconds of one core for a pixel but for its texture look-ups: light, encoding, hashing.
const SECONDS_A_PIXEL: f64 = 60e-9;
/// Seconds for each input: opening, environment light, files.
const SECONDS_AN_INPUT: f64 = 10e-3;
/// Bytes of memory for a byte of an input: a parser and its meshes take eleven times the bytes of an OBJ.
const BYTES_A_BYTE: u64 = 12;
/// Bytes of memory for a pixel: the frame, and the encoder, which takes twice as much.
const BYTES_A_PIXEL: u64 = 12;
/// Bytes of memory for a texel: 11 of its levels, and as many while it is decoded.
const BYTES_A_TEXEL: u64 = 22;
/// Seconds of one core for a texel: decoding, levels.
const SECONDS_A_TEXEL: f64 = 50e-9;
/// Bytes of the shadow map of a direction of `--env-shadows`, and a quarter more of its bounds.
const BYTES_A_SHADOW: u64 = 5 * (ENVIRONMENT_SHADOW_SIZE as u64).pow(2);
/// Seconds of one core for a shadow map but for its model.
const SECONDS_A_SHADOW: f64 = 4e-3;
/// Seconds of one core for a pixel's look-up in a shadow map.
const SECONDS_A_SHADOWED_PIXEL: f64 = 3e-9;
/// Bytes of the program with its tables.
const BYTES: u64 = 48 << 20;
/// Bytes of the batch itself beside its processes.
const BATCH_BYTES: u64 = 16 << 20;
/// Seconds of each process of a task: its start, and the light of the neutral studio, which it gathers once.
const SECONDS_A_TASK: f64 = 0.1;

/// Means that a task takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Estimate {
    /// The largest memory at a time, of all jobs.
    pub(super) memory_bytes: u64,
    /// Time on one core.
    pub(super) core_seconds: f64,
}

impl Estimate {
    /// A task of these units, so many at a time, whose processes have a limit of memory.
    pub(super) fn sum(units: &[Self], jobs: u16, limit: Option<u64>) -> Self {
        let largest = units.iter().map(|u| u.memory_bytes).max().unwrap_or(BYTES);
        let largest = largest.min(limit.unwrap_or(u64::MAX).max(BYTES));
        Self {
            memory_bytes: BATCH_BYTES + largest * u64::from(jobs),
            core_seconds: SECONDS_A_TASK * f64::from(jobs)
                + units.iter().map(|u| u.core_seconds).sum::<f64>(),
        }
    }

    pub(super) fn largest(tasks: impl Iterator<Item = Self>) -> Self {
        tasks.fold(Self::default(), |a, b| Self {
            memory_bytes: a.memory_bytes.max(b.memory_bytes),
            core_seconds: a.core_seconds.max(b.core_seconds),
        })
    }
}

/// The means of each unit of a plan, in order.
pub(super) fn of_units(plan: &Plan) -> Vec<Estimate> {
    let mut sizes: BTreeMap<usize, Size> = BTreeMap::new();
    let mut last = None;
    let of = |unit: &Unit| {
        let item = plan.item(unit);
        let size = *sizes.entry(unit.item).or_insert_with(|| Size {
            bytes: fs::metadata(&item.input).map_or(0, |m| m.len()),
            texels: texels(Path::new(&item.input)),
        });
        let words = item.settings.words();
        // Pictures of one series load their input once.
        let loads = last != Some(unit.item) || !matches!(unit.part, UnitPart::Picture(_));
        last = Some(unit.item);
        one(unit, &words, size, loads)
    };
    plan.units.iter().map(of).collect()
}

/// The size of an input.
#[derive(Clone, Copy, Debug)]
struct Size {
    bytes: u64,
    /// Of its textures.
    texels: u64,
}

fn one(unit: &Unit, words: &[String], size_of: Size, loads: bool) -> Estimate {
    let Size { bytes, texels } = size_of;
    let value = |flag: &str| {
        let value = words
            .iter()
            .find_map(|w| w.strip_prefix("--")?.strip_prefix(flag)?.strip_prefix('='));
        value.map(str::to_owned)
    };
    let number = |flag: &str| value(flag).and_then(|v| v.parse::<f64>().ok());
    let size = value("resolution").or_else(|| value("size"));
    let (width, height) = size.map_or((1024.0, 768.0), |size| sides(&size));
    // Pictures of an item that is one unit.
    let whole = match unit.part {
        UnitPart::Whole => number("turntable")
            .or_else(|| number("frames"))
            .or_else(|| value("views").map(|views| views.split(',').count() as f64)),
        _ => None,
    };
    let share = match &unit.part {
        UnitPart::Band(part) => 1.0 / f64::from(part.count),
        _ => whole.unwrap_or(1.0),
    };
    let pixels = width * height * share;
    let samples = number("supersample").map_or(1.0, |n| n * n);
    let filter = value("filter").and_then(|name| name.parse::<Filter>().ok());
    let look_up = prices()
        .iter()
        .find(|price| price.filter == filter.unwrap_or(Filter::Trilinear))
        .map_or(10.0, |price| price.ns);
    let drawing = pixels * (SECONDS_A_PIXEL + samples * look_up * 1e-9);
    let shadows = number("env-shadows").unwrap_or(0.0).clamp(0.0, 256.0);
    // Each map draws the model once.
    let shading = shadows
        * (SECONDS_A_SHADOW
            + bytes as f64 * SECONDS_A_BYTE / 8.0
            + pixels * SECONDS_A_SHADOWED_PIXEL);
    let loading = if loads {
        SECONDS_AN_INPUT + bytes as f64 * SECONDS_A_BYTE + texels as f64 * SECONDS_A_TEXEL
    } else {
        0.0
    };
    let at_a_time = width * height * share.min(1.0);
    Estimate {
        memory_bytes: BYTES
            + bytes * BYTES_A_BYTE
            + texels.saturating_mul(BYTES_A_TEXEL).min(1 << 50)
            + shadows as u64 * BYTES_A_SHADOW
            + at_a_time as u64 * BYTES_A_PIXEL,
        core_seconds: loading + drawing + shading,
    }
}

/// `WxH`, or one side of a square.
fn sides(text: &str) -> (f64, f64) {
    let (width, height) = text.split_once(['x', ',']).unwrap_or((text, text));
    let side = |text: &str| text.trim().parse().unwrap_or(1024.0);
    (side(width), side(height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Part;

    #[test]
    fn more_pixels_and_bytes_take_more() {
        let unit = |part| Unit {
            id: "a".into(),
            item: 0,
            part,
        };
        let of = |words: &[&str], bytes, part| {
            let words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
            one(&unit(part), &words, Size { bytes, texels: 0 }, true)
        };
        let small = of(&["--resolution=100x100"], 0, UnitPart::Whole);
        let large = of(&["--resolution=16384x16384"], 0, UnitPart::Whole);
        assert!(large.core_seconds > 100.0 * small.core_seconds);
        assert!(large.memory_bytes > 3 << 30);
        let part = Part { index: 1, count: 8 };
        let band = of(&["--resolution=16384x16384"], 0, UnitPart::Band(part));
        assert!(band.memory_bytes < large.memory_bytes / 4);
        let model = of(&["--resolution=100x100"], 1 << 30, UnitPart::Whole);
        assert!(model.core_seconds > 10.0 && model.memory_bytes > 10 << 30);
        let shadowed = of(
            &["--resolution=100x100", "--env-shadows=256"],
            0,
            UnitPart::Whole,
        );
        assert_eq!(shadowed.memory_bytes - small.memory_bytes, 320 << 20);
        assert!(shadowed.core_seconds > small.core_seconds);
        let size = Size {
            bytes: 0,
            texels: 4096 * 4096,
        };
        let words = ["--resolution=100x100".to_owned()];
        let textured = one(&unit(UnitPart::Whole), &words, size, true);
        assert!(textured.memory_bytes - small.memory_bytes > 350 << 20);
        let frames = of(
            &["--resolution=100x100", "--turntable=10"],
            0,
            UnitPart::Whole,
        );
        assert_eq!(frames.memory_bytes, small.memory_bytes);
        assert!(frames.core_seconds > small.core_seconds);
        // A limit bounds each process, but for the program itself.
        let task = |limit| Estimate::sum(&[large], 2, limit).memory_bytes;
        assert_eq!(task(Some(300 << 20)), BATCH_BYTES + (600 << 20));
        assert_eq!(task(Some(1)), BATCH_BYTES + 2 * BYTES);
        assert_eq!(task(None), BATCH_BYTES + 2 * large.memory_bytes);
    }
}
