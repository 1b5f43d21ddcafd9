//! The speed of the sampler as ratios to the loop that computes coordinates and stores:
//! `cargo bench -p texmap-benches --bench sample_speed` writes `benches/results/sample_speed.{csv,md}`.
//!
//! One run times everything in turn, band by band (64 rows of a 1920x1080 floor in 64x64 tiles), and
//! keeps the least time of each band; the sum over the bands is the figure. Two forms: `lanes` are the
//! sixteen-lane functions inside the loop of the coordinates, as a renderer has them; `slice` are the
//! public batch calls on columns of 256 coordinates that the loop has stored.

#![allow(clippy::print_stdout, reason = "the figures are the output")]

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

use texmap_benches::floor::{Floor, HEIGHT, Places, TILE, WIDTH};
use texmap_benches::textures::{square_texels, squares};
use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*, u32x16};
use texmap_math::lanes::{GatherTable, floor_to_i32, gather};
use texmap_math::simd::{X16, encode_unorm8};
use texmap_sample::lanes::{BoundTexture, RGBA8_EXACT, float, packed};
use texmap_sample::{
    Alpha, ColorSpace, DirectionBatch, Filter, Image, Origin, Precision, Sampler, TexelData,
    Texture2d, TextureCube, cube_direction, sample_cube_soa, sample_rgba8_soa, sample_soa,
};

const BANDS: usize = HEIGHT.div_ceil(TILE);
const RUN: usize = 256;
const FILTERS: [(&str, Filter); 4] = [
    ("nearest", Filter::Nearest),
    ("bilinear", Filter::Bilinear),
    ("trilinear", Filter::Trilinear),
    ("anisotropic16", Filter::Anisotropic(16)),
];

/// The code that is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// Coordinates, one word stored.
    Base,
    /// The texel of each pixel at an index that is known, stored: what memory alone takes of `nearest`.
    Loads,
    /// Coordinates (and gradients, if asked) stored in runs, one word of each stored.
    Runs(bool),
    Lanes(usize, Precision),
    Slice(usize, Precision),
}

struct Case {
    level_name: &'static str,
    level: Level,
    floor: (&'static str, Floor),
    side: u32,
    form: Form,
    best: [f64; BANDS],
}

impl Case {
    /// `form/filter/precision/level/floor/side`.
    fn name(&self) -> String {
        let form = match self.form {
            Form::Base => "coordinates/-/-".to_owned(),
            Form::Loads => "loads/-/-".to_owned(),
            Form::Runs(grads) => format!("runs/{}/-", if grads { "gradients" } else { "-" }),
            Form::Lanes(f, p) => format!("lanes/{}/{p:?}", FILTERS[f].0),
            Form::Slice(f, p) => format!("slice/{}/{p:?}", FILTERS[f].0),
        };
        format!("{form}/{}/{}/{}", self.level_name, self.floor.0, self.side).to_lowercase()
    }

    fn ns(&self) -> f64 {
        self.best.iter().sum::<f64>() * 1e9 / (WIDTH * HEIGHT) as f64
    }
}

/// Levels with kernels of their own: SSE4.2 runs SSE2's.
fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_avx512().map(|t| ("avx512", Level::Avx512(t))));
        levels.extend(best.as_avx2().map(|t| ("avx2", Level::Avx2(t))));
        levels.extend(best.as_sse2().map(|t| ("sse2", Level::Sse2(t))));
    }
    if levels.is_empty() {
        levels.push(("best", best));
    }
    levels
}

struct Job<'a> {
    floor: &'a Floor,
    view: &'a BoundTexture<'a>,
    sampler: &'a Sampler,
    texture: &'a Texture2d<'a>,
    level: Level,
    rows: std::ops::Range<usize>,
    frame: &'a mut [u32],
    /// For [`Form::Loads`]: the indices of a band's texels, empty until they are known, and the texels.
    indices: &'a mut Vec<u32>,
    texels: &'a [u32],
    side: u32,
}

const BASE: u8 = 0;
const NEAREST: u8 = 1;
const BILINEAR: u8 = 2;
const TRILINEAR: u8 = 3;
const EXACT: u8 = 16;

#[inline(always)]
fn bytes<S: Simd>(s: S, [r, g, b, a]: float::Color<X16<S>>) -> u32x16<S> {
    encode_unorm8(X16(s), r)
        | (encode_unorm8(X16(s), g) << 8)
        | (encode_unorm8(X16(s), b) << 16)
        | (encode_unorm8(X16(s), a) << 24)
}

#[inline(always)]
fn shade<S: Simd, const KERNEL: u8>(s: S, job: &Job<'_>, p: &Places<S>) -> u32x16<S> {
    let view = job.view;
    let d = || {
        let [ux, vx, uy, vy] = job.floor.slopes(p);
        packed::FootprintLanes::new(X16(s), view, ux, vx, uy, vy)
    };
    if KERNEL == BASE {
        let (a, b): (u32x16<S>, u32x16<S>) = (p.u.bitcast(), p.v.bitcast());
        return a ^ b;
    }
    if KERNEL & EXACT == 0 {
        return match KERNEL {
            NEAREST => packed::nearest_lanes(X16(s), view, p.u, p.v),
            BILINEAR => packed::bilinear_lanes(X16(s), view, p.u, p.v),
            TRILINEAR => {
                let lod = packed::lod_lanes(X16(s), view, &d());
                packed::trilinear_lanes(X16(s), view, p.u, p.v, lod)
            }
            _ => packed::anisotropic_lanes(X16(s), view, p.u, p.v, &d()),
        };
    }
    let c = match KERNEL & !EXACT {
        // Whole texels have no weights: their view is that of the bytes.
        NEAREST => packed::unpack_lanes(X16(s), packed::nearest_lanes(X16(s), view, p.u, p.v)),
        BILINEAR => float::bilinear_lanes::<_, RGBA8_EXACT>(X16(s), view, p.u, p.v),
        TRILINEAR => {
            let lod = float::lod_lanes(X16(s), view, &d());
            float::trilinear_lanes::<_, RGBA8_EXACT>(X16(s), view, p.u, p.v, lod)
        }
        _ => float::anisotropic_lanes::<_, RGBA8_EXACT>(X16(s), view, p.u, p.v, &d()),
    };
    bytes(s, c)
}

#[inline(never)]
fn fused<S: Simd, const KERNEL: u8>(s: S, job: &mut Job<'_>) {
    s.vectorize(
        #[inline(always)]
        || {
            for x0 in (0..WIDTH).step_by(TILE) {
                for y in job.rows.clone() {
                    for x in (x0..x0 + TILE).step_by(16) {
                        let p = job.floor.places(s, x, y);
                        let c = shade::<S, KERNEL>(s, job, &p);
                        let at = y * WIDTH + x;
                        if let Some(out) = job.frame[at..].first_chunk_mut::<16>() {
                            c.store_slice(out);
                        }
                    }
                }
            }
        },
    );
}

/// Loads and stores at known indices; the first call finds them.
#[inline(never)]
fn loads<S: Simd>(s: S, job: &mut Job<'_>) {
    let words = GatherTable::new(job.texels).expect("a texture is not empty");
    let (side, scale) = (job.side, job.side as f32);
    s.vectorize(
        #[inline(always)]
        || {
            let known = !job.indices.is_empty();
            let mut i = 0;
            for x0 in (0..WIDTH).step_by(TILE) {
                for y in job.rows.clone() {
                    for x in (x0..x0 + TILE).step_by(16) {
                        if !known {
                            let p = job.floor.places(s, x, y);
                            let texel = |c: f32x16<S>| -> u32x16<S> {
                                let texel: u32x16<S> = floor_to_i32(s, c * scale).bitcast();
                                texel & (side - 1)
                            };
                            let index = texel(p.v) * side + texel(p.u);
                            job.indices.extend(index.as_slice());
                        }
                        let index = u32x16::from_slice(s, &job.indices[i..i + 16]);
                        let at = y * WIDTH + x;
                        if let Some(out) = job.frame[at..].first_chunk_mut::<16>() {
                            gather(s, words, index).store_slice(out);
                        }
                        i += 16;
                    }
                }
            }
        },
    );
}

/// Coordinates of a run, four rows of a tile, as columns.
struct Run {
    u: [f32; RUN],
    v: [f32; RUN],
    slopes: [[f32; RUN]; 4],
}

#[inline(never)]
fn fill<S: Simd>(s: S, floor: &Floor, x0: usize, y0: usize, slopes: bool, run: &mut Run) {
    s.vectorize(
        #[inline(always)]
        || {
            for i in (0..RUN).step_by(16) {
                let p = floor.places(s, x0 + i % TILE, y0 + i / TILE);
                p.u.store_slice(&mut run.u[i..i + 16]);
                p.v.store_slice(&mut run.v[i..i + 16]);
                if slopes {
                    let [ux, vx, uy, vy] = floor.slopes(&p);
                    ux.store_slice(&mut run.slopes[0][i..i + 16]);
                    vx.store_slice(&mut run.slopes[1][i..i + 16]);
                    uy.store_slice(&mut run.slopes[2][i..i + 16]);
                    vy.store_slice(&mut run.slopes[3][i..i + 16]);
                }
            }
        },
    );
}

/// Makes a run's coordinates, and samples at them if `form` says so.
fn runs<S: Simd>(s: S, job: &mut Job<'_>, form: Form, run: &mut Run) {
    let mut words = [0; RUN];
    let mut colors = [[0.0; RUN]; 4];
    let slopes = match form {
        Form::Runs(slopes) => slopes,
        Form::Slice(filter, _) => filter >= 2,
        _ => false,
    };
    for x0 in (0..WIDTH).step_by(TILE) {
        for y0 in job.rows.clone().step_by(RUN / TILE) {
            fill(s, job.floor, x0, y0, slopes, run);
            let at = texmap_sample::Places {
                u: &run.u,
                v: &run.v,
                gradients: slopes.then(|| run.slopes.each_ref().map(|c| &c[..])),
            };
            let done = match form {
                Form::Slice(_, Precision::Fast) => {
                    sample_rgba8_soa(job.level, job.sampler, job.texture, &at, &mut words)
                }
                Form::Slice(_, Precision::Exact) => {
                    let out = colors.each_mut().map(|c| &mut c[..]);
                    sample_soa(job.level, job.sampler, job.texture, &at, out)
                }
                _ => Ok(()),
            };
            assert!(done.is_ok(), "runs are of one length");
            black_box((&mut colors, &mut *run));
            for (i, part) in words.chunks(TILE).enumerate() {
                let at = (y0 + i) * WIDTH + x0;
                if y0 + i < HEIGHT {
                    job.frame[at..at + TILE].copy_from_slice(part);
                }
            }
        }
    }
}

fn draw<S: Simd>(s: S, job: &mut Job<'_>, form: Form, run: &mut Run) {
    let kernel = match form {
        Form::Runs(_) | Form::Slice(..) => return runs(s, job, form, run),
        Form::Loads => return loads(s, job),
        Form::Base => BASE,
        Form::Lanes(filter, Precision::Fast) => filter as u8 + 1,
        Form::Lanes(filter, Precision::Exact) => (filter as u8 + 1) | EXACT,
    };
    match kernel {
        0 => fused::<S, 0>(s, job),
        1 => fused::<S, 1>(s, job),
        2 => fused::<S, 2>(s, job),
        3 => fused::<S, 3>(s, job),
        4 => fused::<S, 4>(s, job),
        17 => fused::<S, 17>(s, job),
        18 => fused::<S, 18>(s, job),
        19 => fused::<S, 19>(s, job),
        _ => fused::<S, 20>(s, job),
    }
}

fn dispatch(level: Level, job: &mut Job<'_>, form: Form, run: &mut Run) {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(s) => draw(s, job, form, run),
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(s) => draw(s, job, form, run),
        #[cfg(target_arch = "x86_64")]
        Level::Sse2(s) => draw(s, job, form, run),
        #[cfg(target_arch = "aarch64")]
        Level::Neon(s) => draw(s, job, form, run),
        _ => {}
    }
}

fn main() {
    let mut cases = Vec::new();
    let floors = [
        ("far", Floor::far(), 256),
        ("far", Floor::far(), 1024),
        ("far1", Floor::far1(), 1024),
    ];
    for (level_name, level) in levels() {
        for (name, floor, side) in floors {
            let mut push = |form| {
                cases.push(Case {
                    level_name,
                    level,
                    floor: (name, floor),
                    side,
                    form,
                    best: [f64::INFINITY; BANDS],
                });
            };
            push(Form::Base);
            push(Form::Loads);
            push(Form::Runs(false));
            push(Form::Runs(true));
            for filter in 0..FILTERS.len() {
                for precision in [Precision::Fast, Precision::Exact] {
                    push(Form::Lanes(filter, precision));
                    push(Form::Slice(filter, precision));
                }
            }
        }
    }
    let textures = [256, 1024].map(|side| (side, squares(side)));
    let texels: [Vec<u32>; 2] = [256, 1024].map(|side| (0..side * side).collect());
    let mut indices = Vec::new();
    let mut frame = vec![0; WIDTH * HEIGHT];
    let mut run = Box::new(Run {
        u: [0.0; RUN],
        v: [0.0; RUN],
        slopes: [[0.0; RUN]; 4],
    });
    let all = cases.len();
    // Arguments: a number of rounds, and words that a case's name must hold.
    let mut rounds = 7;
    for argument in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match argument.parse() {
            Ok(n) => rounds = n,
            Err(_) => cases.retain(|c| c.name().contains(&argument)),
        }
    }
    for _ in 0..rounds {
        for band in 0..BANDS {
            for case in &mut cases {
                let (filter, precision) = match case.form {
                    Form::Lanes(f, p) | Form::Slice(f, p) => (FILTERS[f].1, p),
                    _ => (Filter::Nearest, Precision::Fast),
                };
                let sampler = Sampler {
                    filter,
                    precision,
                    ..Sampler::default()
                };
                let large = usize::from(case.side == 1024);
                let texture = &textures[large].1;
                indices.clear();
                let view =
                    BoundTexture::new(&sampler, texture).expect("a power of two that repeats");
                let mut job = Job {
                    floor: &case.floor.1,
                    view: &view,
                    sampler: &sampler,
                    texture,
                    level: case.level,
                    rows: band * TILE..HEIGHT.min((band + 1) * TILE),
                    frame: &mut frame,
                    indices: &mut indices,
                    texels: &texels[large],
                    side: case.side,
                };
                // Once for the caches: the case before has left its own texture there.
                dispatch(case.level, &mut job, case.form, &mut run);
                let start = Instant::now();
                dispatch(case.level, &mut job, case.form, &mut run);
                let time = start.elapsed().as_secs_f64();
                black_box(&mut frame);
                if time < case.best[band] {
                    case.best[band] = time;
                }
            }
        }
    }
    let cube = Cube::measure(rounds);
    for case in &cases {
        println!("{:44} {:.3}", case.name(), case.ns());
    }
    println!("{cube:?}");
    if cases.len() == all {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/results");
        std::fs::write(format!("{folder}/sample_speed.csv"), csv(&cases))
            .expect("results/ is writable");
        std::fs::write(format!("{folder}/sample_speed.md"), markdown(&cases, &cube))
            .expect("results/ is writable");
    }
}

/// Bilinear look-ups over a sweep of all directions, ns each: a plain texture and a seamless cube, one at a time and by batches.
#[derive(Debug)]
struct Cube {
    plane: f64,
    cube: f64,
    plane_batch: f64,
    cube_batch: f64,
}

impl Cube {
    const CHUNKS: usize = 64;
    const CHUNK: usize = 4096;

    fn measure(rounds: usize) -> Self {
        let plane = squares(256);
        let texels = square_texels(256);
        let face = Image {
            width: 256,
            height: 256,
            channels: 4,
            texels: TexelData::U8(&texels),
            color: ColorSpace::Linear,
            alpha: Alpha::Straight,
            origin: Origin::TopLeft,
        };
        let cube = TextureCube::new(&[face; 6]).expect("six square faces");
        let sampler = Sampler {
            filter: Filter::Bilinear,
            ..Sampler::default()
        };
        let level = Level::new();
        let mut best = vec![[f64::INFINITY; 4]; Self::CHUNKS];
        let mut colors = [(); 4].map(|()| vec![0.0; Self::CHUNK]);
        for (chunk, best) in best.iter_mut().enumerate() {
            let columns = Self::columns(chunk);
            let [u, v, x, y, z] = &columns;
            for _ in 0..rounds * 3 {
                let mut time = |form: usize, run: &mut dyn FnMut(&mut [Vec<f32>; 4])| {
                    let start = Instant::now();
                    run(&mut colors);
                    let time = start.elapsed().as_secs_f64();
                    best[form] = best[form].min(time);
                };
                time(0, &mut |_| {
                    for (u, v) in u.iter().zip(v) {
                        black_box(sampler.sample(&plane, black_box([*u, *v])));
                    }
                });
                time(1, &mut |_| {
                    for ((x, y), z) in x.iter().zip(y).zip(z) {
                        black_box(sampler.sample_cube(&cube, black_box([*x, *y, *z]), 0.0));
                    }
                });
                time(2, &mut |colors| {
                    let at = texmap_sample::Places {
                        u,
                        v,
                        gradients: None,
                    };
                    let out = colors.each_mut().map(|c| &mut c[..]);
                    let done = sample_soa(level, &sampler, &plane, black_box(&at), out);
                    done.expect("columns of one length");
                });
                time(3, &mut |colors| {
                    let at = DirectionBatch { x, y, z, lod: None };
                    let out = colors.each_mut().map(|c| &mut c[..]);
                    let done = sample_cube_soa(level, &sampler, &cube, black_box(&at), out);
                    done.expect("columns of one length");
                });
                black_box(&mut colors);
            }
        }
        let look_ups = (Self::CHUNKS * Self::CHUNK) as f64;
        let [plane, cube, plane_batch, cube_batch] =
            [0, 1, 2, 3].map(|form| best.iter().map(|b| b[form]).sum::<f64>() * 1e9 / look_ups);
        Self {
            plane,
            cube,
            plane_batch,
            cube_batch,
        }
    }

    /// u, v and x, y, z of a walk over a band of one face and the next.
    fn columns(chunk: usize) -> [Vec<f32>; 5] {
        let mut columns = [const { Vec::new() }; 5];
        for i in 0..Self::CHUNK {
            let along = i as f64 / Self::CHUNK as f64;
            let across = chunk as f64 / Self::CHUNKS as f64;
            let face = (chunk + usize::from(along >= 0.5)) % 6;
            let uv @ [u, v] = [(2.0 * along) % 1.0, across];
            let [x, y, z] = cube_direction(face, uv);
            for (column, c) in columns.iter_mut().zip([u, v, x, y, z]) {
                column.push(c as f32);
            }
        }
        columns
    }
}

fn find(cases: &[Case], name: &str) -> f64 {
    cases
        .iter()
        .find(|c| c.name() == name)
        .map_or(f64::NAN, Case::ns)
}

fn base(cases: &[Case], case: &Case) -> f64 {
    let name = format!(
        "coordinates/-/-/{}/{}/{}",
        case.level_name, case.floor.0, case.side
    );
    find(cases, &name)
}

fn csv(cases: &[Case]) -> String {
    let mut out = String::from("form,filter,precision,level,floor,side,ns_per_pixel,ratio\n");
    for case in cases {
        let _ = writeln!(
            out,
            "{},{:.4},{:.3}",
            case.name().replace('/', ","),
            case.ns(),
            case.ns() / base(cases, case)
        );
    }
    out
}

fn markdown(cases: &[Case], cube: &Cube) -> String {
    let mut out = String::from(
        "# Speed of the sampler\n\n\
         `cargo bench -p texmap-benches --bench sample_speed` (one run, everything interleaved, the least time of each\n\
         band of 64 rows, one thread; ratios count, nanoseconds are this machine's). The floor fills 1920 x 1080: *far* has half\n\
         its pixels magnified at 1024 texels and reaches level 8, *far1* repeats four times as often. The base is the loop that\n\
         computes the coordinates (planes, one exact division a pixel) and stores a word. *Lanes* are the sixteen-lane functions\n\
         in that loop, *slice* the public batch calls on columns of 256 stored places (their storing included).\n\n",
    );
    let best = cases[0].level_name;
    let lanes = |filter: &str, precision: &str, level: &str, floor: &str, side: u32| {
        let tail = format!("{level}/{floor}/{side}");
        find(cases, &format!("lanes/{filter}/{precision}/{tail}"))
            / find(cases, &format!("coordinates/-/-/{tail}"))
    };
    let loads = |side: u32| {
        let tail = format!("{best}/far/{side}");
        find(cases, &format!("loads/-/-/{tail}")) / find(cases, &format!("coordinates/-/-/{tail}"))
    };
    let _ = writeln!(out, "## Ratios to the base on {best} (lanes, far)\n");
    out.push_str("| filter | asked | 256 texels | 1024 texels |\n|---|---|---|---|\n");
    for (filter, precision, asked) in [
        ("nearest", "fast", "2.2"),
        ("bilinear", "fast", "7"),
        ("trilinear", "fast", "11"),
        ("anisotropic16", "fast", "22"),
        ("bilinear", "exact", "9"),
        ("trilinear", "exact", "-"),
        ("anisotropic16", "exact", "-"),
    ] {
        let _ = writeln!(
            out,
            "| {filter} {precision} | {asked} | {:.2} | {:.2} |",
            lanes(filter, precision, best, "far", 256),
            lanes(filter, precision, best, "far", 1024),
        );
    }
    let _ = writeln!(
        out,
        "\nThe bound of memory: loads of `nearest`'s texels at indices that are known, and their stores, take {:.2} of the base\n\
         at 256 texels and {:.2} at 1024 (a texture of 4 MiB), before anything is computed.\n\n\
         Seamless cube over a plain 2D texture, bilinear *exact* (asked: 1.3): {:.2} / {:.2} ns = {:.2} by batches,\n\
         {:.1} / {:.1} ns = {:.2} one at a time.\n",
        loads(256),
        loads(1024),
        cube.cube_batch,
        cube.plane_batch,
        cube.cube_batch / cube.plane_batch,
        cube.cube,
        cube.plane,
        cube.cube / cube.plane
    );
    out.push_str("## Other levels over the first, same kernel (lanes; asked: AVX2 1.5, SSE2 3)\n\n| kernel |");
    let names: Vec<&str> = levels().iter().map(|l| l.0).collect();
    for name in &names[1..] {
        let _ = write!(out, " {name} |");
    }
    out.push_str("\n|---|");
    out.push_str(&"---|".repeat(names.len() - 1));
    out.push('\n');
    for (filter, _) in FILTERS {
        for precision in ["fast", "exact"] {
            let _ = write!(out, "| {filter} {precision} |");
            let ns = |level: &str| {
                find(
                    cases,
                    &format!("lanes/{filter}/{precision}/{level}/far/256"),
                )
            };
            for name in &names[1..] {
                let _ = write!(out, " {:.2} |", ns(name) / ns(best));
            }
            out.push('\n');
        }
    }
    out.push_str("\n## Nanoseconds a pixel\n\n| form | filter | precision |");
    let places = [("far", 256), ("far", 1024), ("far1", 1024)];
    for name in &names {
        for (floor, side) in places {
            let _ = write!(out, " {name} {floor} {side} |");
        }
    }
    out.push_str("\n|---|---|---|");
    out.push_str(&"---|".repeat(names.len() * places.len()));
    out.push('\n');
    let count = cases.len() / (names.len() * places.len());
    for k in 0..count {
        let name = cases[k].name();
        let parts: Vec<&str> = name.split('/').collect();
        let _ = write!(out, "| {} | {} | {} |", parts[0], parts[1], parts[2]);
        for group in cases.chunks(count) {
            let _ = write!(out, " {:.2} |", group[k].ns());
        }
        out.push('\n');
    }
    out
}
