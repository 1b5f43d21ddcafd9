//! One picture of an input: draw it, judge it, write it, report it.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use texmap_bake::MovingLight;
use texmap_io::framing::Up;
use texmap_io::npy;
use texmap_math::Level;
use texmap_math::camera::Camera;
use texmap_mesh::wireframe;
use texmap_planner as planner;
use texmap_planner::Choices;
use texmap_raster::TILE;
use texmap_render::{Aov, AovData, EnvironmentShadows, Frame, RenderSettings, Renderer};
use texmap_scene::Scene;
use texmap_truth::picture::Picture;
use texmap_truth::verify::{Verified, verify, with_wrap};

use crate::cmd::render::RenderArgs;
use crate::cmd::render::budget::{PlanReport, SAMPLES, TruthReport};
use crate::cmd::render::camera::{Shot, single};
use crate::cmd::render::light::{add_ground, hold_ground};
use crate::cmd::render::plan::{Item, array_name, heat_name, rays_name};
use crate::cmd::render::report::{
    AovReport, CameraReport, ItemReport, SceneReport, TimesReport, milliseconds,
};
use crate::cmd::render::write::{Store, values};
use crate::failure::{Failure, Refusal, say};
use crate::output::{Destination, Stage};
use crate::progress::Progress;
use crate::values::AovArg;

pub(super) struct Context<'a> {
    pub(super) args: &'a RenderArgs,
    pub(super) item: &'a Item,
    pub(super) level: Level,
    /// Samples of coverage and depth a pixel.
    pub(super) msaa: u32,
    /// The camera of a model was placed by hand: an automatic one stands outside.
    pub(super) placed: bool,
    /// Milliseconds that loading took.
    pub(super) load: f64,
    /// The axis of the model that points up.
    pub(super) up: Up,
    /// The model at a time of its animation, dressed and lit.
    pub(super) posed: &'a dyn Fn(f64) -> Result<Scene, Failure>,
    /// The light that moves from picture to picture.
    pub(super) moving: Option<MovingLight>,
    /// Shadow maps of the environment light from the last picture, while only the camera differs.
    pub(super) environment_shadows: RefCell<Option<EnvironmentShadows>>,
    /// Warnings printed so far: the frames of a walk repeat them.
    pub(super) told: RefCell<BTreeSet<String>>,
}

impl Context<'_> {
    /// Puts the camera, the light that moves and the model where they stand in a picture.
    pub(super) fn set(&self, scene: &mut Scene, shot: &Shot) -> Result<(), Failure> {
        if let Some(time) = shot.time {
            *scene = (self.posed)(time)?;
            self.environment_shadows.take();
            self.ground(scene)?;
            if self.args.camera.named.is_some() {
                let file = &self.item.input;
                scene.camera = single(self.args, file, scene, scene.camera)?;
                return Ok(());
            }
        }
        scene.camera = shot.camera;
        if shot.time.is_some() {
            scene.camera = self.holding_ground(scene, shot.camera);
        }
        match (&self.moving, shot.light) {
            (Some(moving), Some(light)) => moving.place(scene, light).map_err(|e| self.refused(e)),
            _ => Ok(()),
        }
    }

    /// Adds the shadow on the ground, if it is asked for and something is drawn.
    pub(super) fn ground(&self, scene: &mut Scene) -> Result<(), Failure> {
        match self.args.light.ground_shadow && !self.args.dry_run {
            true => add_ground(scene, self.up).map_err(|e| self.refused(e)),
            false => Ok(()),
        }
    }

    /// A camera that shows all of the shadow on the ground, if there is one. Cameras of files keep their planes.
    pub(super) fn holding_ground(&self, scene: &Scene, mut camera: Camera) -> Camera {
        if self.args.light.ground_shadow && self.args.camera.named.is_none() {
            hold_ground(scene, &mut camera);
        }
        camera
    }

    /// The frame, and the planner's choice for it if there is a budget.
    /// `light` asks for the colours before they are encoded.
    pub(super) fn draw(
        &self,
        scene: &Scene,
        label: String,
        light: bool,
    ) -> Result<(Frame, Option<Choices>), Failure> {
        let progress = Progress::new(label);
        let size = self.args.resolution;
        let shaped = texmap_mesh::tessellate(scene, size.width).map_err(|e| self.refused(e))?;
        let mirrored = self.mirrored(shaped.as_ref())?;
        let scene = mirrored.as_ref().unwrap_or(shaped.as_ref());
        let choices = match self.args.budget() {
            None => None,
            Some(budget) => {
                // Samples that the command line sets are not the planner's choice.
                let samples = match (self.args.supersample, self.args.msaa) {
                    (Some(n), _) => &[n][..],
                    (None, None | Some(1)) => &[1, 2, 4],
                    (None, _) => &[1],
                };
                let (width, height) = (size.width, size.height);
                let mut choices = planner::choose_sampled(scene, width, height, budget, samples)
                    .map_err(|e| self.refused(e))?;
                // Shadows that are written out are those of the scene's own lights.
                if self.args.aov.iter().any(AovArg::is_shadow) {
                    choices.idle_lights.clear();
                }
                Some(choices)
            }
        };
        let planned = choices.as_ref().map(|choices| {
            let mut planned = scene.clone();
            choices.apply(&mut planned);
            planned
        });
        let report = |done, of| {
            progress.update(done, of);
            ControlFlow::Continue(())
        };
        let scene = planned.as_ref().unwrap_or(scene);
        let mut aovs = self.aovs(scene)?;
        // Those of the user come first: they are written.
        let further = [
            (light, Aov::Color),
            (self.args.json || self.args.compare.is_some(), Aov::Mesh),
            (self.args.compare.is_some(), Aov::Position),
            (self.args.look.wireframe, Aov::Depth),
        ];
        for (wanted, aov) in further {
            if wanted && !aovs.contains(&aov) {
                aovs.push(aov);
            }
        }
        let mut settings = self.settings(aovs);
        if let Some(choices) = &choices {
            settings.supersample = choices.supersample;
        }
        // Tessellation and mirrors follow the camera.
        let shared = mirrored.is_none() && matches!(shaped, Cow::Borrowed(_));
        if shared {
            settings.environment_shadows = self.environment_shadows.take();
        }
        let renderer = Renderer::new(scene, &settings).map_err(|e| self.refused(e))?;
        let mut frame = renderer.draw(&report).map_err(|e| self.refused(e))?;
        if shared {
            let made = renderer.environment_shadows();
            self.environment_shadows.replace(Some(made));
        }
        if self.args.look.wireframe {
            draw_edges(scene, &mut frame);
        }
        Ok((frame, choices))
    }

    pub(super) fn verify(&self, scene: &Scene, frame: &Frame) -> Result<Verified, Failure> {
        say("verify: drawing the f64 reference, which is slow\n");
        let rewrapped = self.args.wrap.map(|wrap| with_wrap(scene, wrap));
        let scene = rewrapped.as_ref().unwrap_or(scene);
        verify(scene, frame, SAMPLES).map_err(Failure::from)
    }

    /// Puts the plan and the truth into the report and, where asked, into words.
    pub(super) fn plan(
        &self,
        report: &mut ItemReport,
        scene: &Scene,
        choices: Option<&Choices>,
        truth: Option<&Verified>,
    ) {
        if let Some(choices) = choices {
            let plan = PlanReport::new(scene, choices, truth);
            if self.args.explain {
                say(&plan.table());
            }
            if !plan.met {
                report.warnings.push("budget not met".to_owned());
            }
            report.plans.push(plan);
        } else if self.args.explain {
            say("no budget: interpolation and filters are the scene's\n");
        }
        if let Some(truth) = truth {
            let truth = TruthReport::new(truth, None);
            say(&truth.words());
            let over = report.plans.iter().find_map(|plan| truth.over(plan));
            report.warnings.extend(over);
            report.truth = Some(truth);
        }
    }

    /// The buffers that are asked for, as this scene names them.
    pub(super) fn aovs(&self, scene: &Scene) -> Result<Vec<Aov>, Failure> {
        let aovs = self.args.aov.iter().map(|aov| aov.of(scene));
        aovs.map(|aov| aov.map_err(|e| self.refused(e))).collect()
    }

    fn settings(&self, aovs: Vec<Aov>) -> RenderSettings {
        let args = self.args;
        RenderSettings {
            threads: args.threads.map(usize::from),
            supersample: args.supersample.unwrap_or(1),
            msaa: self.msaa,
            aovs,
            level: self.level,
            filter: args.filter,
            wrap: args.wrap,
            interp: args.interp,
            tile_rows: args.band.map(|band| {
                let tiles = u64::from(args.resolution.height.div_ceil(TILE));
                let rows = band.of(tiles);
                rows.start as u32..rows.end as u32
            }),
            ..RenderSettings::new(args.resolution.width, args.resolution.height)
        }
    }

    /// Writes the picture and its arrays, all or none, and says so.
    pub(super) fn write(
        &self,
        report: &mut ItemReport,
        output: &Path,
        frame: &Frame,
        store: Store,
        heat: Option<&Picture>,
        rays: Option<&Picture>,
        mut times: TimesReport,
    ) -> Result<(), Failure> {
        let began = Instant::now();
        let main = Destination::new(output)?;
        let mut stage = Stage::new(&main)?;
        let names: Vec<&str> = self.args.aov.iter().map(|aov| aov.name.as_str()).collect();
        let picture = stage.add(main, store.format.ending());
        // The hash takes as long as the compression of a picture: reports alone hold it.
        let wanted = self.args.reports();
        let beside = wanted && self.args.threads != Some(1);
        let (lost, hash) = std::thread::scope(|scope| {
            let hash = || texmap_render::pixel_hash(frame);
            let thread = beside.then(|| scope.spawn(hash));
            let lost = store.write(&picture, frame, &names);
            let hashed = thread.and_then(|thread| thread.join().ok());
            (lost, hashed.or_else(|| wanted.then(hash)))
        });
        let lost = lost?;
        for (name, (_, channels, data)) in names.iter().zip(&frame.aovs) {
            let shape = [frame.height as usize, frame.width as usize, *channels];
            let path = match store.holds_arrays() {
                true => output.to_owned(),
                false => {
                    let path = array_name(output, name);
                    npy::write(
                        &stage.add(Destination::new(&path)?, "npy"),
                        &shape,
                        values(data),
                    )?;
                    path
                }
            };
            let (dtype, hole) = match data {
                AovData::F32(_) => ("float32", "NaN"),
                AovData::U32(_) => ("uint32", "4294967295"),
            };
            report.aovs.push(AovReport {
                name: (*name).to_owned(),
                path: path.display().to_string(),
                shape,
                dtype,
                hole,
            });
        }
        if let Some(heat) = heat {
            let path = heat_name(output);
            let place = stage.add(Destination::new(&path)?, "png");
            texmap_io::image_io::write_png(&place, heat.width(), heat.height(), heat.rgba())?;
            if let Some(truth) = &mut report.truth {
                truth.heat = Some(path.display().to_string());
            }
        }
        if let Some(rays) = rays {
            let path = rays_name(output);
            let place = stage.add(Destination::new(&path)?, "png");
            texmap_io::image_io::write_png(&place, rays.width(), rays.height(), rays.rgba())?;
            if let Some(report) = &mut report.rays {
                report.picture = Some(path.display().to_string());
            }
        }
        stage.commit()?;
        times.write = milliseconds(began.elapsed());
        if lost.transparent > 0 {
            report.warnings.push(format!(
                "{} pixels are not opaque, and {} has no alpha: they stand over black; write .png, .webp or .exr",
                lost.transparent,
                store.format.ending().to_uppercase()
            ));
        }
        self.finish(report, (frame.width, frame.height), hash, times);
        Ok(())
    }

    /// Completes the report of a file that was written.
    pub(super) fn finish(
        &self,
        report: &mut ItemReport,
        (width, height): (u32, u32),
        hash: Option<String>,
        times: TimesReport,
    ) {
        report.status = "ok";
        report.width = Some(width);
        report.height = Some(height);
        report.msaa = Some(self.msaa);
        report.pixel_hash = hash;
        self.tell(report, &times);
        report.times_ms = Some(times);
    }

    /// The line with the drawn picture and its time, and the warnings.
    fn tell(&self, report: &ItemReport, times: &TimesReport) {
        for warning in &report.warnings {
            if !self.told.borrow_mut().insert(warning.clone()) {
                continue;
            }
            say(&format!("warning: {}\n", self.named(warning)));
        }
        let scene = report
            .scene
            .as_ref()
            .map_or_else(String::new, SceneReport::words);
        say(&format!(
            "{}: {} x {} pixels, {scene}, in {:.3} s\n",
            report.output.as_deref().unwrap_or_default(),
            report.width.unwrap_or_default(),
            report.height.unwrap_or_default(),
            times.total() / 1e3,
        ));
    }

    pub(super) fn report(&self, scene: &Scene) -> ItemReport {
        ItemReport {
            input: self.item.input.display().to_string(),
            status: "planned",
            scene: Some(SceneReport::new(scene)),
            memory_bytes: Some(crate::cmd::render::plan::memory(self.args, scene)),
            warnings: scene.warnings.clone(),
            ..ItemReport::default()
        }
    }

    pub(super) fn camera(&self, name: Option<String>, camera: &Camera) -> Option<CameraReport> {
        CameraReport::new(
            name,
            camera,
            self.args.resolution.width,
            self.args.resolution.height,
        )
    }

    /// The output, unless this is a dry run, which prints its plan instead.
    pub(super) fn to_draw<'o>(
        &self,
        report: &mut ItemReport,
        output: Option<&'o Path>,
    ) -> Result<Option<&'o Path>, Failure> {
        let output = output.filter(|_| !self.args.dry_run);
        if output.is_none() && !self.args.json {
            crate::failure::print(&report.plan(self.args))?;
        }
        Ok(output)
    }

    pub(super) fn label(&self) -> String {
        self.item
            .input
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    }

    pub(super) fn refused(&self, error: impl Into<Refusal>) -> Failure {
        Failure::of_render(
            error,
            Some(&self.item.input.display().to_string()),
            "nothing was drawn; an older picture of this name was left as it was",
        )
    }
}

/// The lines of `--wireframe`, over the bytes and the linear colours of a frame with [`Aov::Depth`].
fn draw_edges(scene: &Scene, frame: &mut Frame) {
    let (mut depth, mut colors) = (None, None);
    for (aov, _, data) in &mut frame.aovs {
        match (aov, data) {
            (Aov::Depth, AovData::F32(values)) => depth = Some(&*values),
            (Aov::Color, AovData::F32(values)) => colors = Some(values.as_mut_slice()),
            _ => {}
        }
    }
    if let Some(depth) = depth {
        let size = [frame.width, frame.height];
        wireframe(scene, size, depth, &mut frame.rgba, colors);
    }
}
