//! The frame: passes over blocks of 64 x 64 pixels, one owner thread each.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rayon::prelude::*;
use texmap_math::parallel;
use texmap_math::progress::{Progress, Steps};
use texmap_raster::{BinnedDraws, DrawCall, SAMPLES_4, TILE, TargetSize};

use crate::frame_resources::FrameResources;
use crate::plan::Plan;
use crate::resolve::rows::{AovParts, blocks, split};
use crate::stopwatch::Stopwatch;
use crate::textures::Chains;
use crate::tile::job::{Block, Job, Scratch};
use crate::{
    Aov, AovData, EnvironmentShadows, Frame, HOLE_BITS, RenderError, RenderSettings, Stats,
};
use texmap_scene::Scene;

/// Draws a scene: [`Renderer::new`], then [`Renderer::draw`].
///
/// `progress` is called with (blocks done, blocks in all) from the worker threads, in any order, and ends the work by
/// [`ControlFlow::Break`](std::ops::ControlFlow::Break); [`no_progress`](crate::no_progress) is the callback that does nothing.
///
/// # Errors
/// Every fault of the scene or the settings, before the first pixel; [`RenderError::Cancelled`] after a break.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    progress: Progress<'_>,
) -> Result<Frame, RenderError> {
    settings.check()?;
    Renderer::new(scene, settings)?.draw(progress)
}

/// A scene made ready: checked, mip chains built, vertex values computed. Drawing it again costs none of that.
///
/// The same scene, size, supersampling and overrides give the same bytes on every machine, for any number of threads and
/// any SIMD level.
pub struct Renderer<'s> {
    scene: &'s Scene,
    settings: RenderSettings,
    plan: Plan<'s>,
    /// AOVs describe the pixel's centre, which lies on no sample if their number is even: then they have their own pass.
    centres: Option<Plan<'s>>,
    pool: Option<rayon::ThreadPool>,
    /// The positions of the four samples of a pixel, if it has four.
    samples: Option<[[i32; 2]; 4]>,
    /// Buffers of the threads that drew before.
    scratch: Mutex<Vec<Box<Scratch>>>,
    warnings: Vec<String>,
    plan_time: Duration,
}

impl fmt::Debug for Renderer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Renderer")
            .field("settings", &self.settings)
            .field("warnings", &self.warnings)
            .finish_non_exhaustive()
    }
}

impl<'s> Renderer<'s> {
    /// Checks everything and makes it ready.
    ///
    /// # Errors
    /// Every fault of the scene or the settings; see [`RenderError`].
    pub fn new(scene: &'s Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        let start = Stopwatch::start();
        settings.check()?;
        ask_for_frame(settings)?;
        let checked = scene.check()?;
        ask_for_geometry(scene, settings)?;
        scene.check_tessellated()?;
        let pool = settings.threads.map(|threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|error| RenderError::Threads {
                    threads,
                    reason: error.to_string(),
                })
        });
        let pool = pool.transpose()?;
        let n = settings.supersample;
        let shared = n == 1 && settings.msaa == 1;
        let centres = !shared && settings.aovs.iter().any(|aov| *aov != Aov::Color);
        let plans = || {
            let chains = Chains::new(scene, settings)?;
            let ready = Arc::new(FrameResources::new(scene, settings)?);
            let plan = |side: u32, aovs: &[Aov]| {
                let samples = (settings.width * side, settings.height * side);
                Plan::new(scene, settings, &chains, &ready, samples, aovs)
            };
            let first = plan(n, if shared { &settings.aovs } else { &[] })?;
            let centres = centres.then(|| plan(1, &settings.aovs)).transpose()?;
            Ok::<_, RenderError>((first, centres))
        };
        let (plan, centres) = on_pool(pool.as_ref(), plans)?;
        Ok(Self {
            plan,
            centres,
            pool,
            samples: (settings.msaa > 1).then_some(SAMPLES_4),
            scratch: Mutex::default(),
            warnings: scene.warnings.iter().cloned().chain(checked).collect(),
            plan_time: start.elapsed(),
            settings: settings.clone(),
            scene,
        })
    }

    /// Draws the frame. A scene in which nothing is visible gives a frame of background and a warning that says why.
    ///
    /// # Errors
    /// More triangles after clipping than ids; [`RenderError::Memory`]; [`RenderError::Cancelled`] after a break of `progress`.
    pub fn draw(&self, progress: Progress<'_>) -> Result<Frame, RenderError> {
        ask_for_frame(&self.settings)?;
        let mut frame = empty_frame(&self.settings);
        self.draw_into(&mut frame, progress, &|blocks| (0..blocks).collect())?;
        Ok(frame)
    }

    /// The shadow maps of the environment light, for a [further picture](RenderSettings::environment_shadows) by another camera.
    #[must_use]
    pub fn environment_shadows(&self) -> EnvironmentShadows {
        self.plan.ready.environment_shadows.clone()
    }

    /// Draws the shadow maps again: the part of [`new`](Self::new) that moving lights and casters need.
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing is shadowed after that.
    #[doc(hidden)]
    pub fn redraw_shadows(&mut self) -> Result<(), RenderError> {
        let (scene, settings) = (self.scene, &self.settings);
        let buffers = Arc::get_mut(&mut self.plan.ready).map(FrameResources::take_buffers);
        let buffers = buffers.unwrap_or_default();
        let draw = || FrameResources::with_buffers(scene, settings, buffers).map(Arc::new);
        let ready = on_pool(self.pool.as_ref(), draw)?;
        for plan in self.centres.iter_mut().chain([&mut self.plan]) {
            plan.ready = Arc::clone(&ready);
        }
        Ok(())
    }

    /// Turns the sample positions of each pixel over, as in OpenGL, whose rows count from below.
    #[doc(hidden)]
    #[must_use]
    pub fn turned_over(mut self) -> Self {
        let places = self.samples.iter_mut().flatten();
        places.for_each(|[_, y]| *y = -*y);
        self
    }

    /// Without the fast stage of plain texels: tests hold its bits against the general stages.
    #[doc(hidden)]
    #[must_use]
    pub fn staged(mut self) -> Self {
        for plan in self.centres.iter_mut().chain([&mut self.plan]) {
            plan.surfaces.iter_mut().for_each(|s| s.unlit = None);
        }
        self
    }

    /// [`draw`](Self::draw) over the buffers of an earlier frame of this renderer, with the blocks handed out in another
    /// order (a permutation of `0..blocks`), which reaches no pixel. After an error the frame's contents have no meaning.
    #[doc(hidden)]
    pub fn draw_into(
        &self,
        frame: &mut Frame,
        progress: Progress<'_>,
        order: &(dyn Fn(usize) -> Vec<usize> + Sync),
    ) -> Result<(), RenderError> {
        on_pool(self.pool.as_ref(), || {
            self.draw_here(frame, progress, order)
        })
    }

    fn draw_here(
        &self,
        frame: &mut Frame,
        progress: Progress<'_>,
        order: &(dyn Fn(usize) -> Vec<usize> + Sync),
    ) -> Result<(), RenderError> {
        let (scene, settings) = (self.scene, &self.settings);
        let size = (settings.width, settings.height);
        let n = settings.supersample;
        frame.stats = Stats::default();
        frame.stats.times.plan = self.plan_time;
        frame.warnings.clone_from(&self.warnings);

        let start = Stopwatch::start();
        let draws = self.plan.draws(scene);
        let prepared = self.prepare((size.0 * n, size.1 * n), &draws, self.samples.is_some())?;
        frame.stats.times.bin = start.elapsed();

        let start = Stopwatch::start();
        let blocks = size.0.div_ceil(TILE) as usize * settings.rows_of_tiles().len();
        let counter = Steps::new(progress, blocks * (1 + usize::from(self.centres.is_some())));
        let order = order(blocks);
        let Frame { rgba, aovs, .. } = frame;
        for (_, _, data) in aovs.iter_mut() {
            match data {
                AovData::F32(values) => values.fill(f32::from_bits(HOLE_BITS)),
                AovData::U32(values) => values.fill(u32::MAX),
            }
        }
        let (with_color, of_centres): (Vec<_>, Vec<_>) = aovs
            .iter_mut()
            .partition(|(aov, ..)| self.centres.is_none() || *aov == Aov::Color);
        let job = Job::new(scene, settings, &self.plan, &prepared, self.samples);
        let covered = self.run(&job, Some(rgba), with_color, &order, &counter);
        if let Some(plan) = &self.centres {
            let draws = plan.draws(scene);
            let prepared = self.prepare(size, &draws, false)?;
            let job = Job::new(scene, settings, plan, &prepared, None);
            self.run(&job, None, of_centres, &order, &counter);
        }
        if counter.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        frame.stats.times.draw = start.elapsed();
        count(&mut frame.stats, &prepared, covered);
        // A band of background is no fault.
        if covered == 0 && settings.tile_rows.is_none() {
            frame.warnings.push(nothing_drawn(&frame.stats, scene));
        }
        Ok(())
    }

    fn prepare<'p>(
        &self,
        (width, height): (u32, u32),
        draws: &[DrawCall<'p>],
        multisampled: bool,
    ) -> Result<BinnedDraws<'p>, RenderError> {
        let level = self.settings.level;
        let threads = parallel::threads();
        let prepared = TargetSize::new(width, height).and_then(|size| {
            if multisampled {
                BinnedDraws::with_samples(size, draws, level, threads)
            } else {
                BinnedDraws::with_level(size, draws, level, threads)
            }
        });
        prepared.map_err(|error| RenderError::of_raster(self.scene, error))
    }

    /// Runs the blocks of one pass over the thread pool and returns the number of covered pixels.
    fn run(
        &self,
        job: &Job<'_>,
        rgba: Option<&mut Vec<u8>>,
        aovs: Vec<&mut (Aov, usize, AovData)>,
        order: &[usize],
        counter: &Steps<'_>,
    ) -> u64 {
        let (width, height) = (self.settings.width, self.settings.frame_height());
        let mut rgba = rgba.map_or(Vec::new(), |rgba| split(rgba, 4, width, height));
        let mut aovs: Vec<_> = aovs
            .into_iter()
            .map(|(aov, channels, data)| (*aov, AovParts::new(data, *channels, width, height)))
            .collect();
        let mut all: Vec<_> = Block::all(width, self.settings.rows_of_tiles())
            .map(Some)
            .collect();
        for (block, rows) in all
            .iter_mut()
            .flatten()
            .zip(blocks(&mut rgba, width, height))
        {
            block.rgba = rows;
        }
        for (aov, rows) in &mut aovs {
            for (block, rows) in all.iter_mut().flatten().zip(rows.blocks(width, height)) {
                block.aovs.push((*aov, rows));
            }
        }
        let blocks: Vec<Block<'_, '_>> = order.iter().filter_map(|i| all[*i].take()).collect();
        let covered = AtomicU64::new(0);
        // Some blocks take many times as long as others, and lie side by side.
        blocks.into_par_iter().with_max_len(8).for_each_init(
            || ScratchGuard::new(&self.scratch),
            |scratch, block| {
                if counter.is_cancelled() {
                    return;
                }
                covered.fetch_add(job.draw(block, scratch.get()), Ordering::Relaxed);
                counter.step();
            },
        );
        covered.into_inner()
    }
}

/// `work` on a thread of the pool, of the present one without any: each of its parallel loops, of which every mesh has some, would
/// wake and await the pool if it came from outside.
fn on_pool<R: Send>(pool: Option<&rayon::ThreadPool>, work: impl FnOnce() -> R + Send) -> R {
    match pool {
        None => parallel::within(work),
        Some(pool) => pool.install(work),
    }
}

/// [`render`] with the blocks handed out in another order: for tests that show that the order reaches no pixel.
#[doc(hidden)]
pub fn render_ordered(
    scene: &Scene,
    settings: &RenderSettings,
    progress: Progress<'_>,
    order: &(dyn Fn(usize) -> Vec<usize> + Sync),
) -> Result<Frame, RenderError> {
    let renderer = Renderer::new(scene, settings)?;
    let mut frame = empty_frame(settings);
    renderer.draw_into(&mut frame, progress, order)?;
    Ok(frame)
}

/// Buffers of a thread, taken from those that lie ready and given back in the end.
struct ScratchGuard<'a> {
    scratch: Option<Box<Scratch>>,
    ready: &'a Mutex<Vec<Box<Scratch>>>,
}

impl<'a> ScratchGuard<'a> {
    fn new(ready: &'a Mutex<Vec<Box<Scratch>>>) -> Self {
        let scratch = ready.lock().ok().and_then(|mut ready| ready.pop());
        Self { scratch, ready }
    }

    fn get(&mut self) -> &mut Scratch {
        self.scratch.get_or_insert_with(Scratch::boxed)
    }
}

impl Drop for ScratchGuard<'_> {
    fn drop(&mut self) {
        if let (Some(scratch), Ok(mut ready)) = (self.scratch.take(), self.ready.lock()) {
            ready.push(scratch);
        }
    }
}

/// Asks for the frame's buffers, and for the slices of them that blocks hold while they are drawn.
fn ask_for_frame(settings: &RenderSettings) -> Result<(), RenderError> {
    let (width, height) = (settings.width, settings.frame_height());
    let pixels = u64::from(width) * u64::from(height);
    let channels: usize = 1 + settings
        .aovs
        .iter()
        .map(|aov| aov.channels())
        .sum::<usize>();
    let slices = u64::from(width.div_ceil(TILE)) * u64::from(height);
    let buffers = 1 + settings.aovs.len() as u64;
    let bytes = pixels * 4 * channels as u64 + buffers * slices * 2 * size_of::<&[u8]>() as u64;
    settings.memory.ask(
        bytes,
        format_args!(
            "a frame of {width} x {height} pixels of {} bytes",
            4 * channels
        ),
        "take a smaller resolution or fewer arrays",
    )?;
    Ok(())
}

/// Asks for the memory of vertices and triangles before the first tile. These are snapped positions, attributes, normals and
/// positions in world space, lists of triangles.
fn ask_for_geometry(scene: &Scene, settings: &RenderSettings) -> Result<(), RenderError> {
    const VERTEX: u64 = 64;
    const TRIANGLE: u64 = 16;
    let draws = scene.drawing_order();
    let meshes = draws.iter().map(|draw| &scene.meshes[draw.mesh]);
    let (vertices, triangles) = meshes.fold((0, 0), |(vertices, triangles), mesh| {
        (
            vertices + mesh.positions.len(),
            triangles + mesh.triangles.len(),
        )
    });
    settings.memory.ask(
        vertices as u64 * VERTEX + triangles as u64 * TRIANGLE,
        format_args!("the geometry of {triangles} triangles and {vertices} vertices"),
        "draw fewer triangles",
    )?;
    Ok(())
}

/// Buffers of the right sizes; drawing fills them.
fn empty_frame(settings: &RenderSettings) -> Frame {
    let (width, height) = (settings.width, settings.frame_height());
    let pixels = width as usize * height as usize;
    let buffer = |aov: &Aov| match aov {
        Aov::Face | Aov::Mesh => AovData::U32(vec![0; pixels]),
        aov => AovData::F32(vec![0.0; pixels * aov.channels()]),
    };
    Frame {
        width,
        height,
        rgba: vec![0; pixels * 4],
        aovs: settings
            .aovs
            .iter()
            .map(|aov| (*aov, aov.channels(), buffer(aov)))
            .collect(),
        stats: Stats::default(),
        warnings: Vec::new(),
    }
}

fn count(stats: &mut Stats, prepared: &BinnedDraws<'_>, covered: u64) {
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
            "all {submitted} triangles lie behind the eye, outside of the view or between pixel centres, or face away and are culled"
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
