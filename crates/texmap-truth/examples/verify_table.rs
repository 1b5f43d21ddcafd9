//! Holds the f64 reference and the renderer against each other: every scene of `assets/scenes`, the reference with 6 x 6 samples a pixel
//! against a frame of the renderer with 8 x 8. `cargo run --release -p texmap-truth --example verify_table > docs/generated/verify.md`; with `--size WxH`
//! and names of scenes it prints those alone, with `--heat FOLDER` it puts the frames, the references and the errors there.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "the table is the output"
)]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use texmap_render::{RenderSettings, render};
use texmap_truth::ASSUMPTIONS;
use texmap_truth::metrics::figure;
use texmap_truth::verify::verify;

/// Samples a side of a pixel in the reference, as `--verify` takes.
const SAMPLES: u32 = 6;
const SUPERSAMPLE: u32 = 8;
const MOST: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut size, mut names) = ((240, 180), Vec::new());
    let mut words = std::env::args().skip(1);
    let mut heat = None;
    while let Some(word) = words.next() {
        if word == "--size" {
            let text = words.next().unwrap_or_default();
            let (w, h) = text.split_once('x').ok_or("--size WxH")?;
            size = (w.parse()?, h.parse()?);
        } else if word == "--heat" {
            heat = words.next();
        } else {
            names.push(word);
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<Result<_, _>>()?;
    files.retain(|file| file.extension().is_some_and(|e| e == "scene"));
    files.sort();
    let name = |file: &Path| file.file_stem().unwrap_or_default().display().to_string();
    files.retain(|file| names.is_empty() || names.contains(&name(file)));
    println!(
        "# The reference against the renderer\n\n\
         Made by `cargo run --release -p texmap-truth --example verify_table > docs/generated/verify.md`: the f64 reference of `--verify`, with \
         {SAMPLES} x {SAMPLES} samples a pixel, against the renderer's own frame with {SUPERSAMPLE} x {SUPERSAMPLE}, {} x {} pixels. \
         Errors are of stored values, 0 to 1, outside of outlines and of the edges of shadows. The reference assumes {ASSUMPTIONS}.\n\n\
         | scene | RMSE | largest error | at | pixels judged | at outlines | at shadows' edges | RMSE there |\n\
         |---|---|---|---|---|---|---|---|",
        size.0, size.1
    );
    let mut over = Vec::new();
    for file in files {
        let scene = texmap_io::load_scene(&file, &Default::default())?;
        let scene = texmap_mesh::tessellate(scene, size.0)?;
        let settings = RenderSettings {
            supersample: SUPERSAMPLE,
            ..RenderSettings::new(size.0, size.1)
        };
        let frame = render(&scene, &settings, &texmap_render::no_progress)?;
        let began = Instant::now();
        let found = verify(&scene, &frame, SAMPLES)?;
        let name = name(&file);
        let (x, y) = found.max_at.unwrap_or_default();
        println!(
            "| `{name}` | {} | {} | {x}, {y} | {} | {} | {} | {} |",
            figure(found.rmse),
            figure(found.max),
            found.judged,
            found.outlines,
            found.shadow_edges,
            figure(found.shadow_rmse),
        );
        eprintln!("{name}: {:.1} s", began.elapsed().as_secs_f64());
        if let Some(folder) = &heat {
            let put = |what: &str, picture: &texmap_truth::picture::Picture| {
                let file = Path::new(folder).join(format!("{name}.{what}.png"));
                let (w, h) = (picture.width(), picture.height());
                texmap_io::image_io::write_png(&file, w, h, picture.rgba())
            };
            put("heat", &found.heat)?;
            let drawn = texmap_truth::picture::Picture::from_rgba(size.0, size.1, frame.rgba);
            put("frame", &drawn.ok_or("a frame of its size")?)?;
            put("truth", &found.truth)?;
        }
        if found.rmse > MOST {
            over.push(name);
        }
    }
    if over.is_empty() {
        Ok(())
    } else {
        Err(format!("RMSE above {MOST}: {}", over.join(", ")).into())
    }
}
