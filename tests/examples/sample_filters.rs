//! Every filter on a floor and on a magnified patch, with its error and its price:
//! `cargo run --release -p texmap-tests --example sample_filters` writes `docs/generated/filters.png` and
//! `docs/generated/filters.md` (figures from `benches/results/sample_accuracy.md` and `sample_speed.csv`).
//! `sample_filters ACCURACY.md FOLDER` reads other figures and writes there.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use texmap_io::image_io;
use texmap_math::{Footprint, Level, color};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, Wrap, sample_slice};
use texmap_truth::picture::Picture;

const FILTERS: [&str; 12] = [
    "nearest",
    "bilinear",
    "bicubic:catmull-rom",
    "bicubic:mitchell",
    "bicubic:b-spline",
    "mip-nearest",
    "bilinear-mip-nearest",
    "trilinear",
    "anisotropic:2",
    "anisotropic:16",
    "ewa:4",
    "ewa:16",
];
const FLOOR: [u32; 2] = [240, 120];
const PATCH: [u32; 2] = [120, 120];
const GAP: u32 = 6;

/// Squares of 32 texels, thin lines, and a disc in every square.
fn texture() -> Texture2d<'static> {
    let side = 256_u32;
    let texels = (0..side * side)
        .flat_map(|i| {
            let (x, y) = (i % side, i / side);
            let (a, b) = (x as i32 % 32 - 16, y as i32 % 32 - 16);
            let square = ((x / 32) ^ (y / 32)) & 1 == 1;
            let [r, g, b] = if a * a + b * b < 70 {
                [210, 60, 40]
            } else if x % 16 == 0 || y % 16 == 0 {
                [20, 20, 60]
            } else if square {
                [240, 235, 220]
            } else {
                [60, 110, 150]
            };
            [r, g, b, 255]
        })
        .collect();
    Texture2d::from_rgba8(side, side, texels, ColorSpace::Srgb, Origin::TopLeft)
        .expect("a good size")
        .with_mips()
}

/// uv and footprint of a pixel of the floor: w grows downward from the horizon above the picture.
fn floor(x: u32, y: u32) -> ([f32; 2], Footprint) {
    let [width, height] = FLOOR.map(f64::from);
    let w = (f64::from(y) + 0.5) / height * 1.2 + 0.04;
    let (dw, scale) = (1.2 / height, 0.35);
    let across = (f64::from(x) + 0.5 - 0.5 * width) / height;
    let (u, v) = (scale * across / w, scale / w);
    let d = Footprint::new(
        (scale / height / w) as f32,
        0.0,
        (-u * dw / w) as f32,
        (-v * dw / w) as f32,
    );
    ([u as f32, v as f32], d)
}

/// Fourteen texels across the patch.
fn patch(x: u32, y: u32) -> ([f32; 2], Footprint) {
    let step = 14.0 / 256.0 / PATCH[0] as f32;
    let at = |i: u32| 0.055 + (i as f32 + 0.5) * step;
    ([at(x), at(y)], Footprint::new(step, 0.0, 0.0, step))
}

fn draw(
    filter: Filter,
    t: &Texture2d<'_>,
    [width, height]: [u32; 2],
    place: impl Fn(u32, u32) -> ([f32; 2], Footprint),
) -> Picture {
    let (mut u, mut v, mut grads) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..height {
        for x in 0..width {
            let (uv, d) = place(x, y);
            u.push(uv[0]);
            v.push(uv[1]);
            grads.push(d);
        }
    }
    let sampler = Sampler {
        filter,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        ..Sampler::default()
    };
    let mut colors = vec![[0.0; 4]; u.len()];
    sample_slice(Level::new(), &sampler, t, &u, &v, Some(&grads), &mut colors)
        .expect("slices of one length");
    let rgba = colors
        .iter()
        .flat_map(|c| {
            let [r, g, b] = [c[0], c[1], c[2]].map(color::linear_to_srgb8);
            [r, g, b, 255]
        })
        .collect();
    Picture::from_rgba(width, height, rgba).expect("four bytes a pixel")
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let mut given = std::env::args_os().skip(1).map(PathBuf::from);
    let figures = given.next();
    let figures = figures.unwrap_or_else(|| root.join("benches/results/sample_accuracy.md"));
    let folder = given.next().unwrap_or_else(|| root.join("docs/generated"));
    let t = texture();
    let cell = [FLOOR[0] + PATCH[0] + 3 * GAP, FLOOR[1] + 20 + GAP];
    let rows = FILTERS.len().div_ceil(2) as u32;
    let mut sheet = Picture::new(2 * cell[0], rows * cell[1] + GAP, [255; 4]);
    for (i, name) in FILTERS.into_iter().enumerate() {
        let filter: Filter = name.parse()?;
        let x = i64::from(cell[0]) * (i as i64 % 2) + i64::from(GAP);
        let y = i64::from(cell[1]) * (i as i64 / 2) + i64::from(GAP);
        sheet.text(x, y, 1, [0, 0, 0, 255], name);
        sheet.blit(x, y + 18, &draw(filter, &t, FLOOR, floor));
        let right = x + i64::from(FLOOR[0] + GAP);
        sheet.blit(right, y + 18, &draw(filter, &t, PATCH, patch));
    }
    image_io::write_png(
        &folder.join("filters.png"),
        sheet.width(),
        sheet.height(),
        sheet.rgba(),
    )?;
    let accuracy = fs::read_to_string(figures)?;
    let speed = fs::read_to_string(root.join("benches/results/sample_speed.csv"))?;
    fs::write(folder.join("filters.md"), page(&accuracy, &speed))?;
    Ok(())
}

/// The cells of the accuracy table in the row of a filter.
fn errors<'a>(table: &'a str, name: &str, precision: &str) -> Option<Vec<&'a str>> {
    table.lines().find_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        (cells.get(1) == Some(&name) && cells.get(2) == Some(&precision)).then_some(cells)
    })
}

/// Nanoseconds a pixel on the half-magnified floor at 1024 texels, and the ratio to its coordinates alone.
fn price<'a>(csv: &'a str, name: &str, precision: &str) -> Option<(&'a str, &'a str, &'a str)> {
    let name = name.replace("anisotropic:16", "anisotropic16");
    let precision = precision.to_lowercase();
    csv.lines().find_map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let [form, filter, p, level, floor, side, ns, ratio] = cells[..] else {
            return None;
        };
        let wanted = form == "lanes" && filter == name && p == precision;
        (wanted && floor == "far" && side == "1024").then_some((level, ns, ratio))
    })
}

fn page(accuracy: &str, speed: &str) -> String {
    let mut out = String::from(
        "# The filters\n\n\
         Written by `cargo run --release -p texmap-tests --example sample_filters`, with figures from\n\
         [sample_accuracy.md](../../benches/results/sample_accuracy.md) and\n\
         [sample_speed.md](../../benches/results/sample_speed.md).\n\n\
         ![Each filter on a floor and on fourteen magnified texels](filters.png)\n\n\
         Error: RMSE on the tilted plane (noise texture) against a box and a Gaussian pixel. Price: a pixel of a\n\
         half-magnified floor, 1024 x 1024 texels, one thread, and its ratio to computing and storing the coordinates\n\
         (- where it is not timed).\n\n\
         | filter | precision | box | Gaussian | ns a pixel | ratio |\n|---|---|---|---|---|---|\n",
    );
    for name in FILTERS {
        for precision in ["Exact", "Fast"] {
            let Some(row) = errors(accuracy, name, precision) else {
                continue;
            };
            let (ns, ratio) = price(speed, name, precision).map_or(("-", "-"), |p| (p.1, p.2));
            let _ = writeln!(
                out,
                "| {name} | {precision} | {} | {} | {ns} | {ratio} |",
                row.get(6).unwrap_or(&"-"),
                row.get(9).unwrap_or(&"-"),
            );
        }
    }
    out.push_str(
        "\nOn the floor, filters of level 0 alias; one level per pixel shows where it changes; trilinear blurs along the\n\
         view, which probes along the long axis and the ellipse do not. On the patch, nearest shows texels, bilinear its\n\
         diamonds; Catmull-Rom is sharp and overshoots, the B-spline is smooth and dull, Mitchell lies between.\n",
    );
    out
}
