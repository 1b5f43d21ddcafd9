//! The frame: passes over blocks of 64 x 64 pixels, one owner thread each.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use texmap_raster::{Draw, Prepared, RasterError, TILE, TargetSize};

use crate::block::{Block, Job, Scratch};
use crate::plan::{Chains, Plan};
use crate::rows::{AovRows, split};
use crate::{Aov, AovData, Frame, HOLE_BITS, RenderError, Scene, Settings, Stats};

/// Draws a scene.
///
/// The same scene, size, supersampling and overrides give the same bytes on every machine, for any number of threads and
/// any SIMD level. `progress` is called with (blocks done, blocks in all) from the worker threads, in any order.
///
/// A scene in which nothing is visible gives a frame of background and a warning that says why.
///
/// # Errors
/// Every fault of the scene or the settings, before the first pixel; see [`RenderError`].
pub fn render(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Frame, RenderError> {
    render_ordered(scene, settings, progress, &|blocks| (0..blocks).collect())
}

/// [`render`] with the blocks handed out in another order (a permutation of `0..blocks`): for tests that show that the
/// order reaches no pixel.
#[doc(hidden)]
pub fn render_ordered(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) + Sync),
    order: &(dyn Fn(usize) -> Vec<usize> + Sync),
) -> Result<Frame, RenderError> {
    settings.check()?;
    let checked = scene.check()?;
    let draw = || draw(scene, settings, progress, order);
    let mut frame = match settings.threads {
        None => draw()?,
        Some(threads) => rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| RenderError::Threads {
                threads,
                reason: error.to_string(),
            })?
            .install(draw)?,
    };
    frame.warnings = scene
        .warnings
        .iter()
        .cloned()
        .chain(checked)
        .chain(frame.warnings)
        .collect();
    Ok(frame)
}

fn draw(
    scene: &Scene,
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) + Sync),
    order: &(dyn Fn(usize) -> Vec<usize> + Sync),
) -> Result<Frame, RenderError> {
    let start = Instant::now();
    let chains = Chains::new(scene, settings);
    let n = settings.supersample;
    // AOVs describe the pixel's centre, which lies on no sample if their number is even: then they have their own pass.
    let shared = n == 1;
    let color_aovs: &[Aov] = if shared { &settings.aovs } else { &[] };
    let samples = (settings.width * n, settings.height * n);
    let plan = Plan::new(scene, settings, &chains, samples, color_aovs)?;
    let second = match shared || settings.aovs.is_empty() {
        true => None,
        false => Some(Plan::new(
            scene,
            settings,
            &chains,
            (settings.width, settings.height),
            &settings.aovs,
        )?),
    };
    let mut frame = empty_frame(settings);
    frame.stats.times.plan = start.elapsed();

    let start = Instant::now();
    let draws = plan.draws(scene);
    let prepared = prepare(scene, samples, &draws)?;
    frame.stats.times.bin = start.elapsed();

    let start = Instant::now();
    let blocks = settings.width.div_ceil(TILE) as usize * settings.height.div_ceil(TILE) as usize;
    let counter = Counter {
        done: AtomicUsize::new(0),
        of: blocks * (1 + usize::from(second.is_some())),
        progress,
    };
    let Frame { rgba, aovs, .. } = &mut frame;
    let covered = if shared {
        let job = Job::new(scene, settings, &plan, &prepared);
        run(&job, settings, Some(rgba), aovs, &order(blocks), &counter)
    } else {
        let job = Job::new(scene, settings, &plan, &prepared);
        let covered = run(
            &job,
            settings,
            Some(rgba),
            &mut [],
            &order(blocks),
            &counter,
        );
        if let Some(plan) = &second {
            let draws = plan.draws(scene);
            let prepared = prepare(scene, (settings.width, settings.height), &draws)?;
            run(
                &Job::new(scene, settings, plan, &prepared),
                settings,
                None,
                aovs,
                &order(blocks),
                &counter,
            );
        }
        covered
    };
    frame.stats.times.draw = start.elapsed();
    count(&mut frame.stats, &prepared, covered);
    if covered == 0 {
        frame.warnings.push(nothing_drawn(&frame.stats, scene));
    }
    Ok(frame)
}

fn prepare<'p>(
    scene: &Scene,
    (width, height): (u32, u32),
    draws: &[Draw<'p>],
) -> Result<Prepared<'p>, RenderError> {
    let size = TargetSize::new(width, height).map_err(|error| raster_error(scene, error))?;
    Prepared::new(size, draws).map_err(|error| raster_error(scene, error))
}

/// Runs the blocks of one pass over the thread pool and returns how many pixels are covered.
fn run(
    job: &Job<'_>,
    settings: &Settings,
    rgba: Option<&mut Vec<u8>>,
    aovs: &mut [(Aov, usize, AovData)],
    order: &[usize],
    counter: &Counter<'_>,
) -> u64 {
    let (width, height) = (settings.width, settings.height);
    let mut blocks: Vec<_> = Block::all(width, height).map(Some).collect();
    if let Some(rgba) = rgba {
        for (block, rows) in blocks
            .iter_mut()
            .flatten()
            .zip(split(rgba, 4, width, height))
        {
            block.rgba = rows;
        }
    }
    for (aov, channels, data) in aovs {
        let rows: Vec<AovRows<'_>> = match data {
            AovData::F32(values) => split(values, *channels, width, height)
                .into_iter()
                .map(AovRows::F32)
                .collect(),
            AovData::U32(values) => split(values, *channels, width, height)
                .into_iter()
                .map(AovRows::U32)
                .collect(),
        };
        for (block, rows) in blocks.iter_mut().flatten().zip(rows) {
            block.aovs.push((*aov, rows));
        }
    }
    let blocks: Vec<Block<'_>> = order.iter().filter_map(|i| blocks[*i].take()).collect();
    let covered = AtomicU64::new(0);
    blocks
        .into_par_iter()
        .for_each_init(Scratch::new, |scratch, block| {
            covered.fetch_add(job.draw(block, scratch), Ordering::Relaxed);
            counter.step();
        });
    covered.into_inner()
}

struct Counter<'a> {
    done: AtomicUsize,
    of: usize,
    progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl Counter<'_> {
    fn step(&self) {
        (self.progress)(self.done.fetch_add(1, Ordering::Relaxed) + 1, self.of);
    }
}

fn empty_frame(settings: &Settings) -> Frame {
    let (width, height) = (settings.width, settings.height);
    let pixels = width as usize * height as usize;
    let hole = |aov: &Aov| match aov {
        Aov::Face => AovData::U32(vec![u32::MAX; pixels]),
        aov => AovData::F32(vec![f32::from_bits(HOLE_BITS); pixels * aov.channels()]),
    };
    Frame {
        width,
        height,
        rgba: vec![0; pixels * 4],
        aovs: settings
            .aovs
            .iter()
            .map(|aov| (*aov, aov.channels(), hole(aov)))
            .collect(),
        stats: Stats::default(),
        warnings: Vec::new(),
    }
}

fn count(stats: &mut Stats, prepared: &Prepared<'_>, covered: u64) {
    let raster = prepared.stats();
    stats.triangles_submitted = raster.submitted as u64;
    stats.triangles_drawn = raster.binned as u64;
    stats.triangles_culled = (raster.culled + raster.outside) as u64;
    stats.triangles_clipped = raster.clipped as u64;
    stats.triangles_degenerate = raster.degenerate as u64;
    stats.triangles_non_finite = raster.non_finite as u64;
    stats.pixels_covered = covered;
}

fn nothing_drawn(stats: &Stats, scene: &Scene) -> String {
    let submitted = stats.triangles_submitted;
    let why = if scene.meshes.is_empty() {
        "the scene has no meshes".to_owned()
    } else if submitted == 0 {
        "no mesh has a triangle".to_owned()
    } else if stats.triangles_culled == submitted {
        format!(
            "all {submitted} triangles lie behind the eye, outside of the view, or face away and are culled"
        )
    } else if stats.triangles_non_finite == submitted {
        format!("all {submitted} triangles overflow in their transform")
    } else if stats.triangles_drawn == 0 {
        format!(
            "of {submitted} triangles {} are out of view or culled, {} have no area on the screen, {} overflow",
            stats.triangles_culled, stats.triangles_degenerate, stats.triangles_non_finite
        )
    } else {
        format!(
            "{} triangles reach the picture, but none holds a pixel centre that its alpha keeps",
            stats.triangles_drawn
        )
    };
    format!("nothing was drawn: {why}")
}

/// Names the mesh behind the rasterizer's number of a draw.
fn raster_error(scene: &Scene, error: RasterError) -> RenderError {
    let draw = match error {
        RasterError::IndexOutOfRange { draw, .. }
        | RasterError::AttributeLength { draw, .. }
        | RasterError::TooManyAttributes { draw, .. }
        | RasterError::Parts { draw, .. }
        | RasterError::ZeroSpan { draw }
        | RasterError::Tolerance { draw, .. } => Some(draw),
        _ => None,
    };
    let mesh = draw
        .and_then(|draw| scene.meshes.get(draw))
        .map_or_else(|| "(all)".to_owned(), |mesh| mesh.name.clone());
    RenderError::Raster { mesh, error }
}
