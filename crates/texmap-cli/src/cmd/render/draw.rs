//! One input: load it, set the cameras, draw its pictures, write them.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use texmap_io::scene_file::Missing;
use texmap_io::{Animation, AnimationFormat, FileSource, LoadOptions, PictureFormat};
use texmap_io::{npy, write_animation};
use texmap_math::camera::Camera;
use texmap_math::{Level, MemoryBudget};
use texmap_planner as planner;
use texmap_planner::Choices;
use texmap_render::{Aov, AovData, Frame, RenderSettings};
use texmap_scene::{Scene, SceneError};
use texmap_truth::picture::Picture;
use texmap_truth::verify::{Verified, verify, with_wrap};

use crate::cmd::render::RenderArgs;
use crate::cmd::render::budget::{PlanReport, SAMPLES, TruthReport};
use crate::cmd::render::camera::{CameraFiles, Shot, is_scene, shots};
use crate::cmd::render::plan::{Item, Kind, array_name, heat_name};
use crate::cmd::render::report::{
    AovReport, CameraReport, Counts, ItemReport, SceneReport, TimesReport, milliseconds,
};
use crate::cmd::render::seen::{self, PictureReport};
use crate::cmd::render::sheet::sheet;
use crate::cmd::render::wire;
use crate::cmd::render::write::{Store, values};
use crate::failure::{Exit, Failure, Refusal, say};
use crate::output::{Destination, Stage};
use crate::progress::Progress;
use crate::values::AovArg;

/// Draws everything that one input gives: a picture, a contact sheet, a series or an animation. `file` is what the input is read from.
pub(crate) fn item(
    args: &RenderArgs,
    item: &Item,
    file: &Path,
    level: Level,
    cameras: &CameraFiles,
    files: &FileSource,
) -> Result<Vec<ItemReport>, Failure> {
    let began = Instant::now();
    let size = args.resolution;
    let scene_file = is_scene(file);
    let options = LoadOptions {
        aspect: f64::from(size.width) / f64::from(size.height),
        framing: args.camera.framing(file),
        missing: args
            .look
            .missing
            .or((!scene_file).then_some(Missing::Checker)),
        color: args.color,
        // Standard input names no files of this machine.
        files: match file == item.input {
            true => files.clone(),
            false => FileSource::within(file.parent().unwrap_or(Path::new(".")))?,
        },
        camera: args.camera.named.clone(),
        time: args.time,
        animation: args.animation.clone(),
    };
    let mut scene = load(file, &item.input, &options)?;
    if let Some(background) = args.background {
        scene.background = background.0;
    }
    args.look.dress(&mut scene)?;
    let load = milliseconds(began.elapsed());
    let sampled = args.supersample.is_some() || args.budget().is_some();
    let context = Context {
        args,
        item,
        level,
        msaa: match args.msaa {
            Some(samples) => samples,
            None if scene_file || sampled => 1,
            None => 4,
        },
        placed: !scene_file && args.camera.is_placed(),
        load,
        told: RefCell::default(),
    };
    let shots = shots(args, file, &scene, cameras)?;
    // Everything is checked before the first pixel: the scene once, the camera of every picture.
    let warnings = scene.check().map_err(|e| context.refused(e))?;
    context.aovs(&scene)?;
    for shot in &shots {
        let view = shot.camera.view();
        view.map_err(|e| context.refused(SceneError::Camera(e)))?;
    }
    if args.dry_run || args.strict {
        let mut all = scene.warnings.clone();
        all.extend(warnings.clone());
        context.strict(&all)?;
    }
    if args.dry_run {
        scene.warnings.extend(warnings);
    }
    match &item.kind {
        Kind::Sheet => Ok(vec![context.sheet(&mut scene, &shots)?]),
        Kind::Animation(format) => Ok(vec![context.animation(&mut scene, &shots, *format)?]),
        Kind::Single => {
            if let Some(shot) = shots.first() {
                scene.camera = shot.camera;
            }
            Ok(vec![context.picture(&scene, item.output.clone(), None)?])
        }
        Kind::Series(names) => {
            let all = shots.iter().zip(names).zip(0..);
            let pictures = all.map(|((shot, name), number)| {
                scene.camera = shot.camera;
                context.picture(&scene, name.clone(), Some((number, shots.len(), shot)))
            });
            pictures.collect()
        }
    }
}

/// Loads a file. Standard input is named as such in warnings and errors.
fn load(file: &Path, input: &Path, options: &LoadOptions) -> Result<Scene, Failure> {
    let folder = file.parent().filter(|_| file != input);
    let folder = folder.map(|folder| format!("{}/", folder.display()));
    let told = |text: &str| match &folder {
        Some(folder) => text.replace(folder.as_str(), ""),
        None => text.to_owned(),
    };
    let mut scene = texmap_io::load(file, options).map_err(|error| {
        let failure = Failure::from(error);
        Failure {
            what: told(&failure.what),
            why: told(&failure.why),
            ..failure
        }
    })?;
    for warning in &mut scene.warnings {
        *warning = told(warning);
    }
    Ok(scene)
}

struct Context<'a> {
    args: &'a RenderArgs,
    item: &'a Item,
    level: Level,
    /// Samples of coverage and depth a pixel.
    msaa: u32,
    /// The camera of a model was placed by hand: an automatic one stands outside.
    placed: bool,
    /// Milliseconds that loading took.
    load: f64,
    /// Warnings said so far: the frames of a walk repeat them.
    told: RefCell<BTreeSet<String>>,
}

impl Context<'_> {
    /// One picture, alone or as number, of how many, of a series.
    fn picture(
        &self,
        scene: &Scene,
        output: Option<PathBuf>,
        place: Option<(u32, usize, &Shot)>,
    ) -> Result<ItemReport, Failure> {
        let mut report = self.report(scene);
        report.frame = place.map(|(number, ..)| number);
        let name = place.and_then(|(.., shot)| shot.name.clone());
        report.cameras.extend(self.camera(name, &scene.camera));
        report.output = output.as_ref().map(|p| p.display().to_string());
        let Some(output) = self.to_draw(&mut report, output.as_deref())? else {
            return Ok(report);
        };
        let label = place.map_or_else(
            || self.label(),
            |(n, of, _)| format!("{} {}/{of}", self.label(), n + 1),
        );
        let store = self.store(output, scene);
        let (frame, choices) = self.draw(scene, label, store.reads_light())?;
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
        self.look_at(&mut report, scene, &frame);
        self.strict(&report.warnings)?;
        let heat = truth.map(|t| t.heat);
        self.write(&mut report, output, &frame, store, heat.as_ref(), times)?;
        Ok(report)
    }

    /// All views on one sheet.
    fn sheet(&self, scene: &mut Scene, shots: &[Shot]) -> Result<ItemReport, Failure> {
        let output = self.item.output.as_deref();
        let mut report = self.report(scene);
        report.output = output.map(|p| p.display().to_string());
        for shot in shots {
            report
                .cameras
                .extend(self.camera(shot.name.clone(), &shot.camera));
        }
        let Some(output) = self.to_draw(&mut report, output)? else {
            return Ok(report);
        };
        let size = self.args.resolution;
        // The views, the sheet, and its copy while it is written.
        MemoryBudget::of_process().ask(
            u64::from(size.width) * u64::from(size.height) * 12 * shots.len() as u64,
            format_args!("a sheet of {} views", shots.len()),
            "lower --resolution, or name fewer views",
        )?;
        let mut times = TimesReport::new(self.load);
        let mut cells = Vec::new();
        for shot in shots {
            scene.camera = shot.camera;
            let name = shot.name.clone().unwrap_or_default();
            let frame = self.cell(
                &mut report,
                &mut times,
                scene,
                format!("{} {name}", self.label()),
            )?;
            let eye = shot.camera.eye;
            let caption = format!("{name}  eye {:.3} {:.3} {:.3}", eye.x, eye.y, eye.z);
            let picture = Picture::from_rgba(frame.width, frame.height, frame.rgba)
                .ok_or_else(|| Failure::internal("a frame of the wrong size"))?;
            cells.push((caption, picture));
        }
        self.strict(&report.warnings)?;
        let sheet = sheet(&cells);
        let frame = Frame {
            width: sheet.width(),
            height: sheet.height(),
            rgba: sheet.rgba().to_vec(),
            aovs: Vec::new(),
            stats: Default::default(),
            warnings: Vec::new(),
        };
        // Sheets are made of bytes.
        let store = self.store(output, scene);
        if store.reads_light() {
            return Err(Failure::usage(
                format!(
                    "-o {}: a contact sheet has 8 bits a channel",
                    output.display()
                ),
                "end the name with .png, .jpg or .webp, or write {view} into it for a picture each",
            ));
        }
        self.write(&mut report, output, &frame, store, None, times)?;
        Ok(report)
    }

    /// All pictures as one animation.
    fn animation(
        &self,
        scene: &mut Scene,
        shots: &[Shot],
        format: AnimationFormat,
    ) -> Result<ItemReport, Failure> {
        let output = self.item.output.as_deref();
        let mut report = self.report(scene);
        report.output = output.map(|p| p.display().to_string());
        for shot in shots {
            report
                .cameras
                .extend(self.camera(shot.name.clone(), &shot.camera));
        }
        if !self.args.aov.is_empty() || self.args.verify {
            return Err(Failure::usage(
                "an animation has no arrays and no heat picture",
                "leave out --aov and --verify, or write %04d into a name that ends with .png",
            ));
        }
        let Some(output) = self.to_draw(&mut report, output)? else {
            return Ok(report);
        };
        let size = self.args.resolution;
        MemoryBudget::of_process().ask(
            u64::from(size.width) * u64::from(size.height) * 8 * (shots.len() as u64 + 1),
            format_args!("an animation of {} pictures", shots.len()),
            "lower --resolution or the number of pictures, or write %04d into a name that ends with .png",
        )?;
        let mut times = TimesReport::new(self.load);
        let mut frames = Vec::with_capacity(shots.len());
        for (shot, number) in shots.iter().zip(1..) {
            scene.camera = shot.camera;
            let label = format!("{} {number}/{}", self.label(), shots.len());
            frames.push(self.cell(&mut report, &mut times, scene, label)?.rgba);
        }
        self.strict(&report.warnings)?;
        let began = Instant::now();
        let main = Destination::new(output)?;
        let mut stage = Stage::new(&main)?;
        let animation = Animation {
            width: size.width,
            height: size.height,
            frames: &frames,
            rate: self.args.camera.rate,
        };
        write_animation(&stage.add(main, format.ending()), format, &animation)?;
        stage.commit()?;
        times.write = milliseconds(began.elapsed());
        let whole = texmap_render::hash_pixels(
            size.width,
            size.height * shots.len() as u32,
            &frames.concat(),
        );
        self.finish(&mut report, (size.width, size.height), whole, times);
        Ok(report)
    }

    /// One of several pictures that one file holds.
    fn cell(
        &self,
        report: &mut ItemReport,
        times: &mut TimesReport,
        scene: &Scene,
        label: String,
    ) -> Result<Frame, Failure> {
        let (frame, choices) = self.draw(scene, label, false)?;
        self.plan(report, scene, choices.as_ref(), None);
        times.add(&frame);
        report.counts.get_or_insert_default().add(&frame);
        self.look_at(report, scene, &frame);
        for warning in &frame.warnings {
            if !report.warnings.contains(warning) {
                report.warnings.push(warning.clone());
            }
        }
        Ok(frame)
    }

    /// Says what a picture shows, and warns where that is hardly meant.
    fn look_at(&self, report: &mut ItemReport, scene: &Scene, frame: &Frame) {
        if self.args.json {
            report.pictures.push(PictureReport::new(scene, frame));
        }
        let inside = self.placed.then(|| seen::inside(scene)).flatten();
        for warning in seen::warning(frame).into_iter().chain(inside) {
            if !report.warnings.contains(&warning) {
                report.warnings.push(warning);
            }
        }
    }

    /// Under `--strict` the first warning is an error.
    fn strict(&self, warnings: &[String]) -> Result<(), Failure> {
        match warnings.first().filter(|_| self.args.strict) {
            None => Ok(()),
            Some(warning) => Err(Failure::new(
                Exit::Input,
                "strict",
                format!("{}: {warning}", self.item.input.display()),
                format!(
                    "{} in all; without --strict warnings stop nothing",
                    match warnings.len() {
                        1 => "1 warning".to_owned(),
                        n => format!("{n} warnings"),
                    }
                ),
            )),
        }
    }

    /// How a picture is stored, by its name.
    fn store(&self, output: &Path, scene: &Scene) -> Store {
        Store {
            format: PictureFormat::of(output).unwrap_or(PictureFormat::Png),
            bits: self.args.bits,
            color: scene.color,
        }
    }

    /// The frame, and what the planner chose for it if there is a budget.
    /// `light` asks for the colours before they are encoded.
    fn draw(
        &self,
        scene: &Scene,
        label: String,
        light: bool,
    ) -> Result<(Frame, Option<Choices>), Failure> {
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
            (self.args.json, Aov::Mesh),
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
        let mut frame =
            texmap_render::render(scene, &settings, &report).map_err(|e| self.refused(e))?;
        if self.args.look.wireframe {
            wire::draw(scene, &mut frame);
        }
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
            msaa: self.msaa,
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
        store: Store,
        heat: Option<&Picture>,
        mut times: TimesReport,
    ) -> Result<(), Failure> {
        let began = Instant::now();
        let main = Destination::new(output)?;
        let mut stage = Stage::new(&main)?;
        let names: Vec<&str> = self.args.aov.iter().map(|aov| aov.name.as_str()).collect();
        let picture = stage.add(main, store.format.ending());
        let lost = store.write(&picture, frame, &names)?;
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
        stage.commit()?;
        times.write = milliseconds(began.elapsed());
        if lost.transparent > 0 {
            report.warnings.push(format!(
                "{} pixels are not opaque, and {} has no alpha: they stand over black; write .png, .webp or .exr",
                lost.transparent,
                store.format.ending().to_uppercase()
            ));
        }
        let hash = texmap_render::pixel_hash(frame);
        self.finish(report, (frame.width, frame.height), hash, times);
        Ok(())
    }

    /// Completes the report of a file that was written.
    fn finish(
        &self,
        report: &mut ItemReport,
        (width, height): (u32, u32),
        hash: String,
        times: TimesReport,
    ) {
        report.status = "ok";
        report.width = Some(width);
        report.height = Some(height);
        report.msaa = Some(self.msaa);
        report.pixel_hash = Some(hash);
        self.tell(report, &times);
        report.times_ms = Some(times);
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

    fn camera(&self, name: Option<String>, camera: &Camera) -> Option<CameraReport> {
        CameraReport::new(
            name,
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
