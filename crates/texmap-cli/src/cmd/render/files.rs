//! The files of an input: one picture, a contact sheet, or an animation.

use std::path::{Path, PathBuf};
use std::time::Instant;

use texmap_io::{Animation, AnimationFormat, PictureFormat, write_animation};
use texmap_math::MemoryBudget;
use texmap_render::Frame;
use texmap_scene::Scene;
use texmap_truth::picture::Picture;

use crate::cmd::render::camera::Shot;
use crate::cmd::render::draw::Context;
use crate::cmd::render::rays::{Compare, compare};
use crate::cmd::render::report::{Counts, ItemReport, TimesReport, milliseconds};
use crate::cmd::render::seen::{self, PictureReport};
use crate::cmd::render::sheet::sheet;
use crate::cmd::render::write::Store;
use crate::failure::{Exit, Failure, say};
use crate::output::{Destination, Stage};

impl Context<'_> {
    /// One picture, alone or as a number of a series of a given length.
    pub(super) fn picture(
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
        let rays = match self.args.compare {
            Some(Compare::Rays) => {
                say("compare: tracing mirror rays, which is slow\n");
                let shaped = texmap_mesh::tessellate(scene, self.args.resolution.width);
                let shaped = shaped.map_err(|e| self.refused(e))?;
                let (picture, rays) = compare(&shaped, &frame)?;
                say(&rays.words());
                report.rays = Some(rays);
                Some(picture)
            }
            None => None,
        };
        let (heat, rays) = (heat.as_ref(), rays.as_ref());
        self.write(&mut report, output, &frame, store, heat, rays, times)?;
        Ok(report)
    }

    /// All views on one sheet.
    pub(super) fn sheet(&self, scene: &mut Scene, shots: &[Shot]) -> Result<ItemReport, Failure> {
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
        self.write(&mut report, output, &frame, store, None, None, times)?;
        Ok(report)
    }

    /// All pictures as one animation.
    pub(super) fn animation(
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
        if !self.args.aov.is_empty() || self.args.verify || self.args.compare.is_some() {
            return Err(Failure::usage(
                "an animation has no arrays and no other pictures",
                "leave out --aov, --verify and --compare, or write %04d into a name that ends with .png",
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
            self.set(scene, shot)?;
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
        let whole = self.args.reports().then(|| {
            let height = size.height * shots.len() as u32;
            texmap_render::hash_pixels(size.width, height, &frames.concat())
        });
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

    /// Reports the contents of a picture, and warns if it shows little.
    fn look_at(&self, report: &mut ItemReport, scene: &Scene, frame: &Frame) {
        if self.args.json {
            report.pictures.push(PictureReport::new(scene, frame));
        }
        let inside = self.placed.then(|| seen::inside(scene)).flatten();
        // A band of one colour is no fault.
        let alike = seen::warning(frame).filter(|_| self.args.band.is_none());
        for warning in alike.into_iter().chain(inside) {
            if !report.warnings.contains(&warning) {
                report.warnings.push(warning);
            }
        }
    }

    /// Under `--strict` the first warning is an error.
    pub(super) fn strict(&self, warnings: &[String]) -> Result<(), Failure> {
        match warnings.first().filter(|_| self.args.strict) {
            None => Ok(()),
            Some(warning) => Err(Failure::new(
                Exit::Input,
                "strict",
                self.named(warning),
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

    /// A warning with the input that it is about, which those about its lines name themselves.
    pub(super) fn named(&self, warning: &str) -> String {
        let input = self.item.input.display().to_string();
        let rest = warning.strip_prefix(&input);
        match rest.is_some_and(|rest| rest.starts_with(':')) {
            true => warning.to_owned(),
            false => format!("{input}: {warning}"),
        }
    }

    /// Storage of a picture, by its name.
    fn store(&self, output: &Path, scene: &Scene) -> Store {
        Store {
            format: PictureFormat::of(output).unwrap_or(PictureFormat::Png),
            bits: self.args.bits,
            color: scene.color,
        }
    }
}
