//! The race: the benchmark scenes drawn by texmap and by Mesa's llvmpipe, interleaved in one run.
//!
//! `cargo run --release -p texmap-benches --features peers --bin peers -- [--only a:b]
//! [--threads 0,2] [--level NAME] [--peer-bits N] [--rounds N] [--frames N] [--budget-ms N] [--mode NAME] [--alone] [--out DIR]
//! [--csv FILE] [--table FILE]`
//!
//! One child process a thread count and colour mode, since Mesa reads LP_NUM_THREADS once and a context here has one format of
//! colours, and one more for the lit scenes: Mesa 22.3's anisotropic filter does not end in a process that has opened them.
//! `--level` holds both to vectors of one width: texmap's SIMD level, Mesa's LP_NATIVE_VECTOR_WIDTH;
//! `--peer-bits 256` serves where Mesa's 512 bits crash, as those of 22.3 with LLVM 15 do on some processors. 0 means that everything
//! runs in the calling thread (texmap: one thread); the process is then pinned to one core. In every
//! round each scene is drawn by both, one after the other; minima and medians pool the rounds. The
//! pictures are compared before any time is: a row whose pictures differ by more than 1 of 255 on
//! more than 1 % of the values is void. If filters differ by right (anisotropic ones, and normal maps of 8 bits, whose rounding
//! light shows twice over), a row is void if texmap's error against a better filter is above the peer's.

#![allow(clippy::print_stdout, reason = "the rows are the output")]

mod effects;
mod gl;
mod llvmpipe;
mod metallic;
mod texmap;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};
use texmap::{Mode, Texmap};
use texmap_benches::bench_scenes::BenchScene;
use texmap_math::Level;
use texmap_scene::ColorMode;

struct Options {
    only: Option<String>,
    threads: Vec<usize>,
    /// texmap's SIMD level.
    level: Level,
    /// Bits of Mesa's vectors, if not those of the level.
    peer_bits: Option<u32>,
    rounds: usize,
    frames: usize,
    budget: Duration,
    out: Option<PathBuf>,
    csv: Option<PathBuf>,
    /// Markdown.
    table: Option<PathBuf>,
    child: bool,
    /// A child's part: the lit scenes, or the others.
    lit: bool,
    /// A child's part: the sRGB rows, or the raw ones.
    srgb: bool,
    /// Without a peer.
    alone: bool,
    /// Only this of texmap's modes.
    mode: Option<String>,
}

fn main() -> ExitCode {
    let options = match parse(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(why) => {
            eprintln!(
                "peers: {why}\nusage: peers [--only a:b] [--threads 0,2] [--level NAME] [--peer-bits N] [--rounds N] [--frames N] [--budget-ms N] [--mode NAME] [--alone] [--out DIR] [--csv FILE] [--table FILE]"
            );
            return ExitCode::from(2);
        }
    };
    if options.child {
        race(&options);
        return ExitCode::SUCCESS;
    }
    let mut all = String::from(HEADER);
    let children = options
        .threads
        .iter()
        .flat_map(|t| [false, true].map(|srgb| (*t, srgb)))
        .flat_map(|(t, srgb)| [false, true].map(|lit| (t, srgb, lit)));
    for (threads, srgb, lit) in children {
        match run_child(
            options.peer_bits.unwrap_or(vector_bits(options.level)),
            threads,
            srgb,
            lit,
        ) {
            Ok(rows) => all.push_str(&rows),
            Err(why) => {
                eprintln!("peers: {why}");
                return ExitCode::from(6);
            }
        }
    }
    if let Some(path) = &options.table
        && let Err(why) = std::fs::write(path, table(&all))
    {
        eprintln!("peers: {} cannot be written: {why}", path.display());
        return ExitCode::from(4);
    }
    if let Some(path) = &options.csv
        && let Err(why) = std::fs::write(path, &all)
    {
        eprintln!("peers: {} cannot be written: {why}", path.display());
        return ExitCode::from(4);
    }
    ExitCode::SUCCESS
}

const HEADER: &str = "scene,filter,color,mode,threads,level,texmap_min_ms,texmap_median_ms,texmap_first_ms,peer,peer_min_ms,peer_median_ms,peer_first_ms,ratio,within_1_percent,valid\n";

/// The rows as Markdown: the ratio of the least times, and why a row does not count.
fn table(csv: &str) -> String {
    let mut out = String::from(TABLE);
    for row in csv.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let [
            scene,
            filter,
            color,
            mode,
            threads,
            level,
            ours,
            _,
            first,
            _,
            theirs,
            _,
            their_first,
            ratio,
            within,
            valid,
        ] = cells[..]
        else {
            continue;
        };
        let note = if valid == "true" { "" } else { " (void)" };
        let _ = writeln!(
            out,
            "| {scene} | {filter} | {color} | {mode} | {threads} | {level} | {ours} | {theirs} | **{ratio}**{note} | {within} | {first} | {their_first} |"
        );
    }
    out
}

const TABLE: &str = "\
# The race with llvmpipe

`cargo run --release -p texmap-benches --features peers --bin peers -- --threads 0,2 --csv benches/results/peers.csv --table benches/results/peers.md`

Least times of a frame in milliseconds, both renderers interleaved in one run; the ratio is llvmpipe's over texmap's. 0 threads: everything
on one thread, pinned. *fast* has 8-bit filter weights as llvmpipe has, *exact* f32 ones; *visible* shades only what is seen, the others every
layer; without a depth buffer llvmpipe drops hidden opaque layers itself, so that there is no other row. A row whose pictures differ by more than 1 of 255 on more than 1 % of the values is void; anisotropic rows are void if texmap's error
against supersampling is above the peer's, rows with normal maps if its error against f32 weights is. First frames include llvmpipe's compiler and texmap's mip chains
and buffers, not the making of meshes and images.

| scene | filter | color | mode | threads | level | texmap ms | llvmpipe ms | ratio | % within 1 | first texmap | first llvmpipe |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

/// One thread count in a process of its own; returns its CSV rows and passes on what it says.
fn run_child(bits: u32, threads: usize, srgb: bool, lit: bool) -> Result<String, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let output = Command::new(program)
        .args(std::env::args().skip(1))
        .args(["--child", &threads.to_string()])
        .args(lit.then_some("--lit"))
        .args(srgb.then_some("--srgb"))
        .env("LP_NATIVE_VECTOR_WIDTH", bits.to_string())
        .env("LP_NUM_THREADS", threads.to_string())
        .env("LIBGL_ALWAYS_SOFTWARE", "1")
        .env("MESA_SHADER_CACHE_DISABLE", "1")
        .stderr(std::process::Stdio::inherit())
        .output()
        .map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(format!(
            "the run with {threads} threads failed: {}",
            output.status
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Times of one renderer on one scene, in milliseconds.
#[derive(Default)]
struct Times {
    first: f64,
    all: Vec<f64>,
}

impl Times {
    fn min(&self) -> f64 {
        self.all.iter().copied().fold(f64::MAX, f64::min)
    }

    fn median(&self) -> f64 {
        let mut sorted = self.all.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }

    fn measure(&mut self, options: &Options, mut frame: impl FnMut()) {
        let mut time = || {
            let start = Instant::now();
            frame();
            start.elapsed().as_secs_f64() * 1e3
        };
        if self.all.is_empty() && self.first == 0.0 {
            self.first = time();
        }
        time();
        let start = Instant::now();
        for n in 0..options.frames {
            if n >= 3 && start.elapsed() > options.budget {
                break;
            }
            self.all.push(time());
        }
    }
}

fn race(options: &Options) {
    let threads = options.threads[0];
    if threads <= 1
        && let Some(cores) = core_affinity::get_core_ids()
        && let Some(core) = cores.first()
    {
        core_affinity::set_for_current(*core);
    }
    let mut scenes = llvmpipe::scenes(options.only.as_deref());
    let color = if options.srgb {
        ColorMode::Srgb
    } else {
        ColorMode::Raw
    };
    scenes.retain(|scene| {
        scene.color == color && effects::Effects::draws(scene.content) == options.lit
    });
    if scenes.is_empty() {
        return;
    }
    let peer = if options.alone {
        Err("not asked for".to_owned())
    } else {
        llvmpipe::Llvmpipe::open(color, &scenes)
    };
    match &peer {
        Ok(peer) => eprintln!("# {}, {}, {threads} threads", peer.renderer, peer.version),
        Err(why) => eprintln!("# no llvmpipe here ({why}); texmap runs alone"),
    }
    let mut runs: Vec<Run> = scenes
        .iter()
        .flat_map(|scene| {
            Mode::of(scene)
                .into_iter()
                .filter(|mode| options.mode.as_ref().is_none_or(|name| name == mode.name()))
                .map(|mode| Run::new(*scene, mode, options.level, threads))
        })
        .collect();
    for _ in 0..options.rounds {
        for run in &mut runs {
            if let Ok(peer) = &peer {
                run.theirs.measure(options, || peer.frame(&run.scene));
            }
            if let Some(texmap) = &mut run.texmap {
                run.ours.measure(options, || texmap.frame());
            }
        }
    }
    for run in &runs {
        let Some(texmap) = &run.texmap else { continue };
        let picture = texmap.picture();
        let mut match_ = Match::default();
        if let Ok(peer) = &peer {
            peer.frame(&run.scene);
            let other = peer.picture(&run.scene);
            match_ = Match::new(&run.scene, &picture, &other);
            save(options, &run.scene, "llvmpipe", &other);
        }
        save(
            options,
            &run.scene,
            &format!("texmap-{}", run.mode.name()),
            &picture,
        );
        println!("{}", row(run, options, peer.is_ok(), &match_));
    }
}

/// A scene in one of texmap's modes, and what it took.
struct Run {
    scene: BenchScene,
    mode: Mode,
    texmap: Option<Texmap>,
    ours: Times,
    theirs: Times,
}

impl Run {
    fn new(scene: BenchScene, mode: Mode, level: Level, threads: usize) -> Self {
        let (texmap, first) = Texmap::new(&scene, mode, level, threads.max(1)).unzip();
        let ours = Times {
            first: first.map_or(0.0, |first| first.as_secs_f64() * 1e3),
            all: Vec::new(),
        };
        Self {
            scene,
            mode,
            texmap,
            ours,
            theirs: Times::default(),
        }
    }
}

/// Comparison of two pictures of a scene.
#[derive(Default)]
struct Match {
    /// Percentage of values that differ by at most 1.
    within: f64,
    /// If filters may differ by right: root mean square errors against a better one, of 255, texmap's and the peer's.
    errors: Option<[f64; 2]>,
}

impl Match {
    fn new(scene: &BenchScene, ours: &[u8], theirs: &[u8]) -> Self {
        let truth = texmap::truth(scene);
        Self {
            within: agreement(ours, theirs),
            errors: truth.map(|truth| [ours, theirs].map(|picture| rms(picture, &truth))),
        }
    }

    /// True if the times may be compared.
    fn is_valid(&self) -> bool {
        match self.errors {
            Some([ours, theirs]) => ours <= theirs,
            None => self.within >= 99.0,
        }
    }

    fn words(&self) -> String {
        match self.errors {
            Some([ours, theirs]) => format!(
                "RMSE {ours:.3} against {theirs:.3} of 255, {:.2} % within 1",
                self.within
            ),
            None => format!("{:.2} % within 1", self.within),
        }
    }
}

fn rms(a: &[u8], b: &[u8]) -> f64 {
    let squares = a
        .iter()
        .zip(b)
        .map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

fn row(run: &Run, options: &Options, raced: bool, match_: &Match) -> String {
    let Run {
        scene,
        mode,
        ours,
        theirs,
        ..
    } = run;
    let mode = mode.name();
    let mut out = format!(
        "{},{mode},{},{},{:.3},{:.3},{:.1},",
        scene.key(),
        options.threads[0],
        level_name(options.level),
        ours.min(),
        ours.median(),
        ours.first
    );
    if !raced {
        out.push_str(",,,,,,");
        eprintln!("{:<36} {mode:<13} {:>8.2} ms", scene.key(), ours.min());
        return out;
    }
    let ratio = theirs.min() / ours.min();
    let (within, valid) = (match_.within, match_.is_valid());
    let _ = write!(
        out,
        "llvmpipe,{:.3},{:.3},{:.1},{ratio:.2},{within:.2},{valid}",
        theirs.min(),
        theirs.median(),
        theirs.first
    );
    eprintln!(
        "{:<36} {mode:<13} {:>8.2} ms  llvmpipe {:>8.2} ms  ratio {ratio:>5.2}  {}{}",
        scene.key(),
        ours.min(),
        theirs.min(),
        match_.words(),
        if valid { "" } else { "  VOID" }
    );
    out
}

/// Percentage of values that differ by at most 1.
fn agreement(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len(), "pictures of one scene have one size");
    let close = a
        .iter()
        .zip(b)
        .filter(|(a, b)| a.abs_diff(**b) <= 1)
        .count();
    100.0 * close as f64 / a.len() as f64
}

fn save(options: &Options, scene: &BenchScene, who: &str, picture: &[u8]) {
    let Some(dir) = &options.out else { return };
    let (w, h) = scene.size();
    let path = dir.join(format!("{}_{who}.png", scene.key().replace(',', "_")));
    let kind = if picture.len() == (w * h * 3) as usize {
        image::ExtendedColorType::Rgb8
    } else {
        image::ExtendedColorType::L16
    };
    let native: Vec<u8> = if kind == image::ExtendedColorType::L16 {
        picture
            .chunks_exact(2)
            .flat_map(|p| u16::from_be_bytes([p[0], p[1]]).to_ne_bytes())
            .collect()
    } else {
        picture.to_vec()
    };
    let result = std::fs::create_dir_all(dir)
        .map_err(image::ImageError::IoError)
        .and_then(|()| image::save_buffer(&path, &native, w, h, kind));
    if let Err(why) = result {
        eprintln!("peers: {} cannot be written: {why}", path.display());
    }
}

/// The level of a name, if the CPU has it.
fn level(name: &str) -> Result<Level, String> {
    let best = Level::new();
    let found = match name {
        "avx512" => best.as_avx512().map(Level::Avx512),
        "avx2" => best.as_avx2().map(Level::Avx2),
        "sse2" => best.as_sse2().map(Level::Sse2),
        _ => return Err(format!("no level {name}: avx512, avx2, sse2")),
    };
    found.ok_or_else(|| format!("this CPU has no {name}"))
}

fn level_name(level: Level) -> &'static str {
    match vector_bits(level) {
        512 => "avx512",
        256 => "avx2",
        _ => "sse2",
    }
}

/// Bits of a vector of the level: what Mesa is held to.
fn vector_bits(level: Level) -> u32 {
    match level {
        Level::Avx512(_) => 512,
        Level::Avx2(_) => 256,
        _ => 128,
    }
}

fn parse(mut args: impl Iterator<Item = String>) -> Result<Options, String> {
    let mut options = Options {
        only: None,
        threads: vec![0],
        peer_bits: None,
        rounds: 3,
        frames: 30,
        budget: Duration::from_millis(1000),
        out: None,
        csv: None,
        table: None,
        child: false,
        lit: false,
        srgb: false,
        level: Level::new(),
        alone: false,
        mode: None,
    };
    while let Some(flag) = args.next() {
        let mut value = || args.next().ok_or_else(|| format!("{flag} wants a value"));
        let number = |text: String| {
            text.parse::<usize>()
                .map_err(|_| format!("`{text}` is not a number"))
        };
        match flag.as_str() {
            "--only" => options.only = Some(value()?),
            "--threads" => {
                options.threads = value()?
                    .split(',')
                    .map(|t| number(t.to_owned()))
                    .collect::<Result<_, _>>()?;
            }
            "--rounds" => options.rounds = number(value()?)?.max(1),
            "--frames" => options.frames = number(value()?)?.max(1),
            "--budget-ms" => options.budget = Duration::from_millis(number(value()?)? as u64),
            "--mode" => options.mode = Some(value()?),
            "--alone" => options.alone = true,
            "--lit" => options.lit = true,
            "--srgb" => options.srgb = true,
            "--level" => options.level = level(&value()?)?,
            "--peer-bits" => options.peer_bits = Some(number(value()?)? as u32),
            "--out" => options.out = Some(value()?.into()),
            "--table" => options.table = Some(value()?.into()),
            "--csv" => options.csv = Some(value()?.into()),
            "--child" => {
                options.child = true;
                options.threads = vec![number(value()?)?];
            }
            other => return Err(format!("unknown flag {other}")),
        }
    }
    Ok(options)
}
