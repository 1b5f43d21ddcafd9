//! Other programs on the scenes of the chart's panels: llvmpipe, euc and retrofire beside texmap.
//!
//! `cargo run --release -p texmap-benches --features peers,rust-peers --bin chart-peers -- [--csv FILE] [--chart FILE.html] [--out DIR]`
//!
//! `--csv` writes the errors of the others against the panels' own truths: the table that `texmap chart` reads
//! (`crates/texmap-lab/src/chart/external.csv`). `--chart` draws the patterns of the filtering panel as whole frames, all programs in
//! turns on one pinned core, and makes a page of their times and errors. `--out` writes the pictures.

#![allow(clippy::print_stdout, reason = "the rows are the output")]

mod coordinates;
mod gl;
mod plane;
mod registry;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use plane::Peer;
use registry::{Euc, Outcome, Racer, Retrofire, Texmap};
use texmap_benches::bench_scenes::Lookup;
use texmap_lab::chart::time::{Effort, interleaved};
use texmap_lab::chart::{
    self, Across, ExternalPoint, Machine, Panel, PlaneScene, Point, QuadScene, SceneChart, Source,
};
use texmap_lab::plane::SIDE;
use texmap_lab::scenes::UvImage;
use texmap_raster::Interp;
use texmap_sample::{Filter, Precision, Sampler};
use texmap_scene::Scene;

const SIZE: [u32; 2] = [SIDE as u32; 2];

/// The filters that both know, by texmap's names.
const LOOKUPS: [(&str, Lookup, Filter); 4] = [
    ("nearest", Lookup::Nearest, Filter::Nearest),
    ("bilinear", Lookup::Bilinear, Filter::Bilinear),
    ("trilinear", Lookup::Trilinear, Filter::Trilinear),
    ("anisotropic:16", Lookup::Aniso16, Filter::Anisotropic(16)),
];

#[derive(Default)]
struct Options {
    csv: Option<PathBuf>,
    chart: Option<PathBuf>,
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    let done = match parse(std::env::args().skip(1)) {
        // Mesa reads it once: 0 draws in the calling thread.
        Ok(_) if std::env::var_os("LP_NUM_THREADS").is_none() => again(),
        Ok(options) => measure(&options).map(|()| ExitCode::SUCCESS),
        Err(why) => {
            eprintln!(
                "chart-peers: {why}\nusage: chart-peers [--csv FILE] [--chart FILE.html] [--out DIR]"
            );
            return ExitCode::from(2);
        }
    };
    done.unwrap_or_else(|why| {
        eprintln!("chart-peers: {why}");
        ExitCode::FAILURE
    })
}

fn parse(mut args: impl Iterator<Item = String>) -> Result<Options, String> {
    let mut options = Options::default();
    while let Some(flag) = args.next() {
        let place = match flag.as_str() {
            "--csv" => &mut options.csv,
            "--chart" => &mut options.chart,
            "--out" => &mut options.out,
            other => return Err(format!("unknown flag {other}")),
        };
        *place = Some(
            args.next()
                .ok_or_else(|| format!("{flag} wants a value"))?
                .into(),
        );
    }
    Ok(options)
}

/// Runs this program once more, with Mesa's settings.
fn again() -> Outcome<ExitCode> {
    let status = Command::new(std::env::current_exe()?)
        .args(std::env::args().skip(1))
        .envs([
            ("LP_NUM_THREADS", "0"),
            ("LIBGL_ALWAYS_SOFTWARE", "1"),
            ("MESA_SHADER_CACHE_DISABLE", "1"),
        ])
        .status()?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn measure(options: &Options) -> Outcome<()> {
    if let Some(core) = core_affinity::get_core_ids().and_then(|cores| cores.first().copied()) {
        core_affinity::set_for_current(core);
    }
    let peer = Peer::open(SIZE)?;
    let planes = PlaneScene::all(Effort::FULL.grid);
    let mut points = Vec::new();
    for scene in &planes {
        for (method, mut racer) in others(&peer, &scene.scene(Sampler::default())?)? {
            racer.frame();
            let picture = racer.picture();
            save(options, &scene.id, &method, &picture)?;
            points.push(ExternalPoint {
                chart: scene.id.clone(),
                error: scene.error(&scene.values(&picture)),
                method,
                failures: Vec::new(),
            });
        }
    }
    for scene in QuadScene::all() {
        for (method, image) in coordinates(&peer, &scene)? {
            let (error, failures) = scene.judge(&image)?;
            points.push(ExternalPoint {
                chart: scene.id.clone(),
                method,
                error,
                failures,
            });
        }
    }
    let table = chart::external_csv(&points);
    print!("{table}");
    if let Some(path) = &options.csv {
        std::fs::write(path, table)?;
    }
    if let Some(path) = &options.chart {
        write_page(path, &race(&peer, &planes)?)?;
    }
    Ok(())
}

type Named<'r> = (String, Box<dyn Racer + 'r>);

/// llvmpipe with each of its filters, euc and retrofire with the nearest texel.
fn others<'r>(peer: &'r Peer, scene: &Scene) -> Outcome<Vec<Named<'r>>> {
    let mut racers: Vec<Named<'r>> = Vec::new();
    for (filter, lookup, _) in LOOKUPS {
        let name = format!("{} {filter}", peer.name);
        racers.push((name, Box::new(peer.scene(scene, lookup)?)));
    }
    racers.push((
        "euc 0.5.3 nearest".to_owned(),
        Box::new(Euc::new(scene, SIZE)?),
    ));
    racers.push((
        "retrofire 0.4.0 nearest".to_owned(),
        Box::new(Retrofire::new(scene, SIZE)?),
    ));
    Ok(racers)
}

/// euc has no clipper: it is left out where the quad runs through the eye's plane.
fn coordinates(peer: &Peer, of: &QuadScene) -> Outcome<Vec<(String, UvImage)>> {
    let scene = of.quad.scene(Interp::Perspective);
    let mut images = vec![
        (
            peer.name.clone(),
            peer.scene(&scene, Lookup::Nearest)?.coordinates(),
        ),
        (
            "retrofire 0.4.0".to_owned(),
            coordinates::by_retrofire(&scene, SIZE)?,
        ),
    ];
    let forward = of.quad.camera.look - of.quad.camera.eye;
    if of
        .quad
        .corners
        .iter()
        .all(|c| (*c - of.quad.camera.eye).dot(forward) > 0.0)
    {
        images.push(("euc 0.5.3".to_owned(), coordinates::by_euc(&scene, SIZE)?));
    }
    Ok(images)
}

/// The patterns as whole frames, everything timed in turns.
fn race(peer: &Peer, planes: &[PlaneScene]) -> Outcome<Panel> {
    let mut charts = Vec::new();
    for plane in planes.iter().take(3) {
        let mut scenes = Vec::new();
        for precision in [Precision::Fast, Precision::Exact] {
            for (name, _, filter) in LOOKUPS {
                let sampler = Sampler {
                    filter,
                    precision,
                    ..Sampler::default()
                };
                let fast = if precision == Precision::Fast {
                    ", fast"
                } else {
                    ""
                };
                scenes.push((format!("{name}{fast}"), plane.scene(sampler)?));
            }
        }
        let mut racers: Vec<(Source, Named<'_>)> = Vec::new();
        for (name, scene) in &scenes {
            racers.push((
                Source::Texmap,
                (name.clone(), Box::new(Texmap::new(scene, SIZE)?)),
            ));
        }
        let rest = others(peer, &scenes[0].1)?;
        racers.extend(rest.into_iter().map(|racer| (Source::External, racer)));
        let mut points = Vec::new();
        for (source, (method, racer)) in &mut racers {
            racer.frame();
            let values = plane.values(&racer.picture());
            points.push(Point {
                method: method.clone(),
                source: *source,
                time: None,
                error: plane.error(&values),
                bytes: None,
                failures: Vec::new(),
                picture: Some(plane.picture(&values)),
            });
        }
        let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
        for (_, (_, racer)) in &mut racers {
            runs.push(Box::new(|| racer.frame()));
        }
        let times = interleaved(Effort::FULL, plane.plane.len(), &mut runs);
        for (point, time) in points.iter_mut().zip(times) {
            point.time = Some(time);
        }
        charts.push(SceneChart {
            id: format!("frames-{}", plane.id),
            title: plane.title.clone(),
            truth: plane.told.clone(),
            item: "pixel",
            unit: "of 1",
            across: Across::Time,
            points,
        });
    }
    Ok(Panel {
        id: "frames",
        title: "Whole frames of the tilted plane",
        about: "256 x 256 pixels, cleared and drawn from one polygon on one pinned core, by the pixels that count.",
        charts,
    })
}

fn write_page(path: &Path, panel: &Panel) -> Outcome<()> {
    let how = format!(
        "Each program drew {} times, in turns, at least {} microseconds each.",
        Effort::FULL.rounds,
        Effort::FULL.run.as_micros()
    );
    let page = chart::page(std::slice::from_ref(panel), &[], &Machine::here(), &how)?;
    Ok(std::fs::write(path, page)?)
}

fn save(options: &Options, scene: &str, method: &str, rgba: &[u8]) -> Outcome<()> {
    let Some(folder) = &options.out else {
        return Ok(());
    };
    std::fs::create_dir_all(folder)?;
    let path = folder.join(format!("{scene}_{}.png", method.replace([' ', ':'], "-")));
    let kind = image::ExtendedColorType::Rgba8;
    Ok(image::save_buffer(path, rgba, SIZE[0], SIZE[1], kind)?)
}
