//! One input: load it, set the camera, draw its pictures, write them.

use crate::failure::Refusal;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;
use texmap_scene::SceneError;

use texmap_io::framing::{Bounds, View};
use texmap_io::npy::{self, Values};
use texmap_io::{CameraPath, FileSource, LoadOptions};
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_math::{Level, MemoryBudget};
use texmap_planner as planner;
use texmap_planner::Choices;
use texmap_render::{Aov, AovData, Frame, RenderSettings};
use texmap_scene::Scene;
use texmap_truth::picture::Picture;
use texmap_truth::verify::{Verified, verify, with_wrap};

use crate::cmd::render::RenderArgs;
use crate::cmd::render::budget::{PlanReport, SAMPLES, TruthReport};
use crate::cmd::render::plan::{Item, array_name, heat_name};
use crate::cmd::render::report::{
    AovReport, CameraReport, Counts, ItemReport, SceneReport, TimesReport, milliseconds,
};
use crate::cmd::render::sheet::sheet;
use crate::failure::{Exit, Failure, say};
use crate::output::{Destination, Stage};
use crate::progress::Progress;
use crate::values::AovArg;

/// Draws everything that one input gives: one picture, a contact sheet, or the frames of a walk.
pub(crate) fn item(
    args: &RenderArgs,
    item: &Item,
    level: Level,
    walk: Option<&CameraPath>,
    files: &FileSource,
) -> Result<Vec<ItemReport>, Failure> {
    let began = Instant::now();
    let size = args.resolution;
    let options = LoadOptions {
        aspect: f64::from(size.width) / f64::from(size.height),
        color: args.color,
        files: files.clone(),
        ..LoadOptions::default()
    };
    let mut scene = texmap_io::load(&item.input, &options)?;
    adjust(&mut scene, args);
    let load = milliseconds(began.elapsed());
    let context = Context {
        args,
        item,
        level,
        load,
        told: RefCell::default(),
    };
    let cameras = cameras(args, &scene, walk)?;
    // Everything is checked before the first pixel: the scene once, the camera of every picture.
    let warnings = scene.check().map_err(|e| context.refused(e))?;
    context.aovs(&scene)?;
    for (_, camera) in &cameras {
        camera
            .view()
            .map_err(|e| context.refused(SceneError::Camera(e)))?;
    }
    if args.dry_run {
        scene.warnings.extend(warnings);
    }
    if args.views.is_empty() {
        let pictures = cameras.iter().zip(0..).map(|((_, camera), number)| {
            scene.camera = *camera;
            let number = args.frames.map(|_| number);
            context.picture(&scene, number, cameras.len())
        });
        pictures.collect()
    } else {
        Ok(vec![context.views(&mut scene, &cameras)?])
    }
}

fn adjust(scene: &mut Scene, args: &RenderArgs) {
    if let Some(background) = args.background {
        scene.background = background.0;
    }
    let camera = &mut scene.camera;
    for (point, flag) in [
        (&mut camera.eye, args.camera_eye),
        (&mut camera.look, args.camera_look),
        (&mut camera.up, args.camera_up),
    ] {
        if let Some(value) = flag {
            *point = DVec3::from(value.0);
        }
    }
    if let Some(degrees) = args.fov {
        camera.fov_x = degrees.to_radians();
    }
}

/// The cameras of all pictures, named where they are views.
fn cameras(
    args: &RenderArgs,
    scene: &Scene,
    walk: Option<&CameraPath>,
) -> Result<Vec<(Option<View>, Camera)>, Failure> {
    if let (Some(walk), Some(frames)) = (walk, args.frames) {
        return Ok((0..frames)
            .map(|i| (None, walk.camera(&scene.camera, i, frames)))
            .collect());
    }
    if args.views.is_empty() {
        return Ok(vec![(None, scene.camera)]);
    }
    let bounds = Bounds::of(scene).ok_or_else(|| {
        Failure::new(
            Exit::Input,
            "empty-scene",
            "the scene has no vertices",
            "--views frames what is there",
        )
    })?;
    let aspect = f64::from(args.resolution.width) / f64::from(args.resolution.height);
    let fov = args
        .fov
        .map_or(texmap_io::framing::AUTO_FOV, f64::to_radians);
    Ok(args
        .views
        .iter()
        .map(|view| (Some(*view), bounds.camera(*view, fov, aspect)))
        .collect())
}

struct Context<'a> {
    args: &'a RenderArgs,
    item: &'a Item,
    level: Level,
    /// Milliseconds that loading took.
    load: f64,
    /// Warnings said so far: the frames of a walk repeat them.
    told: RefCell<BTreeSet<String>>,
}

impl Context<'_> {
    /// One picture, alone or as frame `number` of `of`.
    fn picture(
        &self,
        scene: &Scene,
        number: Option<u32>,
        of: usize,
    ) -> Result<ItemReport, Failure> {
        let output = self.item.frame_output(number);
        let mut report = self.report(scene);
        report.frame = number;
        report.cameras.extend(self.camera(None, &scene.camera));
        report.output = output.as_ref().map(|p| p.display().to_string());
        let Some(output) = self.to_draw(&mut report, output.as_deref())? else {
            return Ok(report);
        };
        let label = number.map_or_else(
            || self.label(),
            |n| format!("{} {}/{of}", self.label(), n + 1),
        );
        let (frame, choices) = self.draw(scene, label)?;
        let mut times = TimesReport::new(self.load);
        times.add(&frame);
        let mut counts = Counts::default();
        counts.add(&frame);
        report.warnings.clone_from(&frame.warnings);
        report.counts = Some(counts);
        let truth = match self.args.verify {
            true => Some(self.verify(scene, &frame)?),
            false => None,
        };
        self.plan(&mut report, scene, choices.as_ref(), truth.as_ref());
        let heat = truth.map(|t| t.heat);
        self.write(&mut report, output, &frame, heat.as_ref(), times)?;
        Ok(report)
    }

    /// All views on one sheet.
    fn views(
        &self,
        scene: &mut Scene,
        cameras: &[(Option<View>, Camera)],
    ) -> Result<ItemReport, Failure> {
        let output = self.item.output.as_deref();
        let mut report = self.report(scene);
        report.output = output.map(|p| p.display().to_string());
        for (view, camera) in cameras {
            report.cameras.extend(self.camera(*view, camera));
        }
        let Some(output) = self.to_draw(&mut report, output)? else {
            return Ok(report);
        };
        let size = self.args.resolution;
        // The views, the sheet, and its copy while it is written.
        MemoryBudget::of_process().ask(
            u64::from(size.width) * u64::from(size.height) * 12 * cameras.len() as u64,
            format_args!("a sheet of {} views", cameras.len()),
            "lower --resolution, or name fewer views",
        )?;
        let mut times = TimesReport::new(self.load);
        let mut counts = Counts::default();
        let mut cells = Vec::new();
        for (view, camera) in cameras {
            scene.camera = *camera;
            let name = view.map_or("", View::name);
            let (frame, choices) = self.draw(scene, format!("{} {name}", self.label()))?;
            self.plan(&mut report, scene, choices.as_ref(), None);
            times.add(&frame);
            counts.add(&frame);
            for warning in frame.warnings {
                if !report.warnings.contains(&warning) {
                    report.warnings.push(warning);
                }
            }
            let eye = camera.eye;
            let caption = format!("{name}  eye {:.3} {:.3} {:.3}", eye.x, eye.y, eye.z);
            let picture = Picture::from_rgba(frame.width, frame.height, frame.rgba)
                .ok_or_else(|| Failure::internal("a frame of the wrong size"))?;
            cells.push((caption, picture));
        }
        report.counts = Some(counts);
        let sheet = sheet(&cells);
        let frame = Frame {
            width: sheet.width(),
            height: sheet.height(),
            rgba: sheet.rgba().to_vec(),
            aovs: Vec::new(),
            stats: Default::default(),
            warnings: Vec::new(),
        };
        self.write(&mut report, output, &frame, None, times)?;
        Ok(report)
    }

    /// The frame, and what the planner chose for it if there is a budget.
    fn draw(&self, scene: &Scene, label: String) -> Result<(Frame, Option<Choices>), Failure> {
        let progress = Progress::new(label);
        let size = self.args.resolution;
        let shaped = texmap_mesh::tessellate(scene, size.width).map_err(|e| self.refused(e))?;
        let scene = shaped.as_ref();
        let choices = match self.args.budget() {
            None => None,
            Some(budget) => {
                // What the command line says of samples is not the planner's choice.
                let samples = match (self.args.supersample, self.args.msaa) {
                    (Some(n), _) => &[n][..],
                    (None, 1) => &[1, 2, 4],
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
        let mut settings = self.settings(self.aovs(scene)?);
        if let Some(choices) = &choices {
            settings.supersample = choices.supersample;
        }
        let frame =
            texmap_render::render(scene, &settings, &report).map_err(|e| self.refused(e))?;
        Ok((frame, choices))
    }

    fn verify(&self, scene: &Scene, frame: &Frame) -> Result<Verified, Failure> {
        say("verify: drawing the f64 reference, which is slow\n");
        let rewrapped = self.args.wrap.map(|wrap| with_wrap(scene, wrap));
        let scene = rewrapped.as_ref().unwrap_or(scene);
        verify(scene, frame, SAMPLES).map_err(Failure::from)
    }

    /// Puts the plan and the truth into the report and, where asked, into words.
    fn plan(
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
    fn aovs(&self, scene: &Scene) -> Result<Vec<Aov>, Failure> {
        let aovs = self.args.aov.iter().map(|aov| aov.of(scene));
        aovs.map(|aov| aov.map_err(|e| self.refused(e))).collect()
    }

    fn settings(&self, aovs: Vec<Aov>) -> RenderSettings {
        let args = self.args;
        RenderSettings {
            threads: args.threads.map(usize::from),
            supersample: args.supersample.unwrap_or(1),
            msaa: args.msaa,
            aovs,
            level: self.level,
            filter: args.filter,
            wrap: args.wrap,
            interp: args.interp,
            ..RenderSettings::new(args.resolution.width, args.resolution.height)
        }
    }

    /// Writes the picture and its arrays, all or none, and says so.
    fn write(
        &self,
        report: &mut ItemReport,
        output: &Path,
        frame: &Frame,
        heat: Option<&Picture>,
        mut times: TimesReport,
    ) -> Result<(), Failure> {
        let began = Instant::now();
        let main = Destination::new(output)?;
        let mut stage = Stage::new(&main)?;
        texmap_io::image_io::write_png(
            &stage.add(main, "png"),
            frame.width,
            frame.height,
            &frame.rgba,
        )?;
        for (arg, (_, channels, data)) in self.args.aov.iter().zip(&frame.aovs) {
            let path = array_name(output, &arg.name);
            let shape = [frame.height as usize, frame.width as usize, *channels];
            let (values, dtype, hole) = match data {
                AovData::F32(v) => (Values::F32(v), "float32", "NaN"),
                AovData::U32(v) => (Values::U32(v), "uint32", "4294967295"),
            };
            npy::write(&stage.add(Destination::new(&path)?, "npy"), &shape, values)?;
            let path = path.display().to_string();
            report.aovs.push(AovReport {
                name: arg.name.clone(),
                path,
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
        stage.commit()?;
        times.write = milliseconds(began.elapsed());
        report.status = "ok";
        report.width = Some(frame.width);
        report.height = Some(frame.height);
        report.pixel_hash = Some(texmap_render::pixel_hash(frame));
        self.tell(report, &times);
        report.times_ms = Some(times);
        Ok(())
    }

    /// The line that says what was drawn and how long it took, and the warnings.
    fn tell(&self, report: &ItemReport, times: &TimesReport) {
        for warning in &report.warnings {
            if !self.told.borrow_mut().insert(warning.clone()) {
                continue;
            }
            say(&format!(
                "warning: {}: {warning}\n",
                self.item.input.display()
            ));
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

    fn report(&self, scene: &Scene) -> ItemReport {
        ItemReport {
            input: self.item.input.display().to_string(),
            status: "planned",
            scene: Some(SceneReport::new(scene)),
            memory_bytes: Some(crate::cmd::render::plan::memory(self.args, scene)),
            warnings: scene.warnings.clone(),
            ..ItemReport::default()
        }
    }

    fn camera(&self, view: Option<View>, camera: &Camera) -> Option<CameraReport> {
        CameraReport::new(
            view.map(View::name),
            camera,
            self.args.resolution.width,
            self.args.resolution.height,
        )
    }

    /// The output, unless this is a dry run, which says what would be drawn instead.
    fn to_draw<'o>(
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

    fn label(&self) -> String {
        self.item
            .input
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    }

    fn refused(&self, error: impl Into<Refusal>) -> Failure {
        Failure::of_render(
            error,
            Some(&self.item.input.display().to_string()),
            "nothing was drawn; an older picture of this name was left as it was",
        )
    }
}
