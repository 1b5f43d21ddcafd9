//! The JSON report of `texmap render`. Its shape is versioned by `schema`.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use texmap_io::scene_file::words;
use texmap_math::Level;
use texmap_math::camera::Camera;
use texmap_math::glam::DMat4;
use texmap_render::Frame;
use texmap_sample::Origin;
use texmap_scene::{ColorMode, Scene};

use crate::cmd::render::RenderArgs;
use crate::cmd::render::budget::{PlanReport, TruthReport};
use crate::cmd::render::rays::RaysReport;
use crate::cmd::render::seen::PictureReport;
use crate::failure::{ErrorBody, Exit, Failure};
use crate::values;

/// Version of the report's shape; grows when a field changes its meaning or goes.
const SCHEMA: u32 = 1;

#[derive(Debug, Serialize)]
pub(crate) struct Report {
    texmap: &'static str,
    schema: u32,
    verb: &'static str,
    exit: u8,
    settings: SettingsReport,
    items: Vec<ItemReport>,
}

impl Report {
    pub(crate) fn new(args: &RenderArgs, level: Level, items: Vec<ItemReport>, exit: Exit) -> Self {
        Self {
            texmap: env!("CARGO_PKG_VERSION"),
            schema: SCHEMA,
            verb: "render",
            exit: exit as u8,
            settings: SettingsReport::new(args, level),
            items,
        }
    }
}

/// Settings of the command line; `null` where the scene decides.
#[derive(Debug, Serialize)]
struct SettingsReport {
    width: u32,
    height: u32,
    supersample: u32,
    /// `null`: 4 for models, 1 for scenes, unless there are other samples.
    msaa: Option<u32>,
    /// `null`: as many as the machine gives.
    threads: Option<u16>,
    level: &'static str,
    filter: Option<String>,
    wrap: Option<&'static str>,
    interp: Option<String>,
}

impl SettingsReport {
    fn new(args: &RenderArgs, level: Level) -> Self {
        Self {
            width: args.resolution.width,
            height: args.resolution.height,
            supersample: args.supersample.unwrap_or(1),
            msaa: args.msaa,
            threads: args.threads,
            level: values::level_name(level),
            filter: args.filter.and_then(words::filter),
            wrap: args.wrap.map(words::wrap),
            interp: args.interp.map(words::interp),
        }
    }
}

/// One picture, or one input that gave none.
#[derive(Debug, Default, Serialize)]
pub(crate) struct ItemReport {
    pub(crate) input: String,
    /// `ok`, `planned` (dry run) or `failed`.
    pub(crate) status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) output: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) frame: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) width: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) height: Option<u32>,
    /// Hash of the decoded pixels, `algorithm:digits`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) pixel_hash: Option<String>,
    /// One camera; one for each cell of a contact sheet.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) cameras: Vec<CameraReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) scene: Option<SceneReport>,
    /// Samples of coverage and depth a pixel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) msaa: Option<u32>,
    /// Contents of the pictures; one for each cell of a contact sheet and each frame of an animation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) pictures: Vec<PictureReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) counts: Option<Counts>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) times_ms: Option<TimesReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) aovs: Vec<AovReport>,
    /// Estimate of the largest memory in use while drawing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) memory_bytes: Option<u64>,
    /// Choices of the planner; one for each cell of a contact sheet.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) plans: Vec<PlanReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) truth: Option<TruthReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rays: Option<RaysReport>,
    pub(crate) warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<ErrorBody>,
}

impl ItemReport {
    pub(crate) fn failed(input: &Path, failure: &Failure) -> Self {
        Self {
            input: input.display().to_string(),
            status: "failed",
            error: Some(failure.body()),
            ..Self::default()
        }
    }
}

impl ItemReport {
    /// True if a plan could not keep its budget.
    pub(crate) fn over_budget(&self) -> bool {
        self.plans.iter().any(|plan| !plan.met)
    }

    /// True if the true error is over a budget that the plan promised to keep.
    pub(crate) fn breaks_budget(&self) -> bool {
        let truth = self.truth.as_ref();
        truth.is_some_and(|truth| self.plans.iter().any(|plan| truth.over(plan).is_some()))
    }

    /// Text of a dry run.
    pub(crate) fn plan(&self, args: &RenderArgs) -> String {
        let size = args.resolution;
        let scene = self
            .scene
            .as_ref()
            .map_or_else(String::new, SceneReport::words);
        let mut text = format!(
            "{} -> {}: {} x {} pixels, {} x {} samples, {scene}, about {:.1} MB\n",
            self.input,
            self.output.as_deref().unwrap_or("(no output named)"),
            size.width,
            size.height,
            args.supersample.unwrap_or(1),
            args.supersample.unwrap_or(1),
            self.memory_bytes.unwrap_or_default() as f64 / 1e6,
        );
        for warning in &self.warnings {
            text.push_str(&format!("  warning: {warning}\n"));
        }
        text
    }
}

/// Matrices are lists of rows and multiply column vectors.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CameraReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    view: Option<String>,
    eye: [f64; 3],
    look: [f64; 3],
    up: [f64; 3],
    fov_x_degrees: f64,
    /// `null`: a central projection.
    orthographic_width: Option<f64>,
    /// From the middle of the picture to the right and up, in halves of its width and height.
    principal_point: [f64; 2],
    near: f64,
    /// `null`: infinite.
    far: Option<f64>,
    view_from_world: [[f64; 4]; 4],
    clip_from_view: [[f64; 4]; 4],
    clip_from_world: [[f64; 4]; 4],
}

impl CameraReport {
    /// None for a camera that the renderer refuses.
    pub(crate) fn new(
        view: Option<String>,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Option<Self> {
        let aspect = f64::from(width) / f64::from(height);
        Some(Self {
            view,
            eye: camera.eye.to_array(),
            look: camera.look.to_array(),
            up: camera.up.to_array(),
            fov_x_degrees: camera.fov_x.to_degrees(),
            orthographic_width: camera.lens.parallel_width,
            principal_point: camera.lens.center,
            near: camera.near,
            far: camera.far.is_finite().then_some(camera.far),
            view_from_world: rows(camera.view().ok()?),
            clip_from_view: rows(camera.projection(aspect)),
            clip_from_world: rows(camera.clip_from_world(aspect).ok()?),
        })
    }
}

fn rows(m: DMat4) -> [[f64; 4]; 4] {
    m.transpose().to_cols_array_2d()
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneReport {
    meshes: usize,
    vertices: usize,
    triangles: usize,
    materials: usize,
    textures: usize,
    lights: usize,
    color: &'static str,
    background: [f32; 4],
    /// Origin (v = 0) of the meshes' coordinates and the `uv` array: `top-left`, `bottom-left` or `mixed`.
    uv_origin: &'static str,
}

impl SceneReport {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut origins = scene.meshes.iter().map(|m| m.uv_origin);
        let first = origins.next();
        Self {
            meshes: scene.meshes.len(),
            vertices: scene.meshes.iter().map(|m| m.positions.len()).sum(),
            triangles: scene.meshes.iter().map(|m| m.triangles.len()).sum(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            lights: scene.lights.len(),
            color: match scene.color {
                ColorMode::Srgb => "srgb",
                ColorMode::Raw => "raw",
            },
            background: scene.background,
            uv_origin: match first {
                Some(one) if origins.all(|o| o == one) => origin_name(one),
                Some(_) => "mixed",
                None => origin_name(Origin::TopLeft),
            },
        }
    }
}

impl SceneReport {
    /// The same in words.
    pub(crate) fn words(&self) -> String {
        let count =
            |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        format!(
            "{} in {}, {}",
            count(self.triangles, "triangle", "triangles"),
            count(self.meshes, "mesh", "meshes"),
            count(self.textures, "texture", "textures"),
        )
    }
}

pub(crate) fn origin_name(origin: Origin) -> &'static str {
    match origin {
        Origin::TopLeft => "top-left",
        Origin::BottomLeft => "bottom-left",
    }
}

/// Sums over the cells of a contact sheet.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Counts {
    triangles_submitted: u64,
    triangles_drawn: u64,
    triangles_culled: u64,
    triangles_clipped: u64,
    triangles_degenerate: u64,
    triangles_non_finite: u64,
    pixels_covered: u64,
}

impl Counts {
    pub(crate) fn add(&mut self, frame: &Frame) {
        let s = &frame.stats;
        self.triangles_submitted += s.triangles_submitted;
        self.triangles_drawn += s.triangles_drawn;
        self.triangles_culled += s.triangles_culled;
        self.triangles_clipped += s.triangles_clipped;
        self.triangles_degenerate += s.triangles_degenerate;
        self.triangles_non_finite += s.triangles_non_finite;
        self.pixels_covered += s.pixels_covered;
    }
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct TimesReport {
    load: f64,
    plan: f64,
    bin: f64,
    draw: f64,
    pub(crate) write: f64,
}

impl TimesReport {
    /// Loading took this many milliseconds, the rest nothing yet.
    pub(crate) fn new(load: f64) -> Self {
        Self {
            load,
            ..Self::default()
        }
    }

    pub(crate) fn add(&mut self, frame: &Frame) {
        let t = &frame.stats.times;
        self.plan += milliseconds(t.plan);
        self.bin += milliseconds(t.bin);
        self.draw += milliseconds(t.draw);
    }

    pub(crate) fn total(&self) -> f64 {
        self.load + self.plan + self.bin + self.draw + self.write
    }
}

pub(crate) fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// An array beside the picture, C order, rows top to bottom.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AovReport {
    pub(crate) name: String,
    pub(crate) path: String,
    /// Height, width, channels.
    pub(crate) shape: [usize; 3],
    pub(crate) dtype: &'static str,
    /// Value of pixels without a surface.
    pub(crate) hole: &'static str,
}
