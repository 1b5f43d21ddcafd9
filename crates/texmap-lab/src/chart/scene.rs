//! The chart of a user's own scene: whole renders with every filter and interpolation.

use texmap_io::scene_file::words;
use texmap_raster::Interp;
use texmap_render::{Frame, RenderSettings, Renderer};
use texmap_sample::Filter;
use texmap_scene::{ColorMode, Scene};

use super::time::{Effort, timed};
use super::{Across, Error, Panel, Point, Report, SceneChart, Source};
use crate::LabError;
use texmap_truth::picture::Picture;
use texmap_truth::strip::difference;

const FILTERS: [Filter; 10] = [
    Filter::Nearest,
    Filter::Bilinear,
    Filter::MipNearest,
    Filter::BilinearMipNearest,
    Filter::Trilinear,
    Filter::Anisotropic(4),
    Filter::Anisotropic(16),
    Filter::ewa(8),
    Filter::SummedArea,
    Filter::Gl {
        mag: texmap_sample::TexelFilter::Nearest,
        min: texmap_sample::TexelFilter::Linear,
        mip: texmap_sample::Mip::Linear,
    },
];

const INTERPS: [Interp; 4] = [
    Interp::Affine,
    Interp::Subdivided(4),
    Interp::Span(16),
    Interp::WithinError(0.5),
];

/// Renders a scene with every filter, with every interpolation (trilinear), and as it is. Errors are against a
/// render with `effort.grid` / 4 x as many samples a side (8 at most) and 16 anisotropic probes in each.
///
/// # Errors
/// If the renderer refuses the scene.
pub fn panel(
    scene: &Scene,
    (width, height): (u32, u32),
    effort: Effort,
    report: Report<'_>,
) -> Result<Panel, LabError> {
    let base = RenderSettings {
        threads: Some(1),
        ..RenderSettings::new(width, height)
    };
    let samples = (effort.grid as u32 / 4).clamp(2, 8);
    let mut ways: Vec<(String, RenderSettings)> =
        vec![("as the scene says".to_owned(), base.clone())];
    for filter in FILTERS {
        if let Some(name) = words::filter(filter) {
            let settings = RenderSettings {
                filter: Some(filter),
                ..base.clone()
            };
            ways.push((name, settings));
        }
    }
    for interp in INTERPS {
        let settings = RenderSettings {
            filter: Some(Filter::Trilinear),
            interp: Some(interp),
            ..base.clone()
        };
        ways.push((format!("trilinear, {}", words::interp(interp)), settings));
    }
    // Only drawing is timed.
    let shaped = texmap_mesh::tessellate(scene, width)?;
    let scene = shaped.as_ref();
    let steps = ways.len() + 2;
    report(0, steps, "truth");
    let truth = render(
        scene,
        &RenderSettings {
            supersample: samples,
            filter: Some(Filter::Anisotropic(16)),
            threads: None,
            ..base.clone()
        },
    )?;
    let exact = light(scene, &truth);
    let mut points = Vec::new();
    let mut covered = 0;
    for (index, (name, settings)) in ways.iter().enumerate() {
        report(index + 1, steps, name);
        let frame = render(scene, settings)?;
        covered = covered.max(frame.stats.pixels_covered as usize);
        let found = light(scene, &frame);
        let pixels = found.chunks(3).zip(exact.chunks(3));
        let worst = |(f, e): (&[f64], &[f64])| {
            f.iter()
                .zip(e)
                .map(|(f, e)| (f - e).abs())
                .fold(0.0, f64::max)
        };
        points.push(Point {
            method: name.clone(),
            source: Source::Texmap,
            time: None,
            error: Error::of(pixels.map(worst)),
            bytes: None,
            failures: Vec::new(),
            picture: beside(&frame, &truth),
        });
    }
    report(steps - 1, steps, "times");
    let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
    for (_, settings) in &ways {
        let renderer = Renderer::new(scene, settings)?;
        runs.push(Box::new(move || {
            // Drawn once above without an error.
            std::hint::black_box(renderer.draw(&texmap_render::no_progress).ok());
        }));
    }
    timed(&mut points, effort, covered, &mut runs);
    report(steps, steps, "done");
    Ok(Panel {
        id: "scene",
        title: "Your scene",
        about: "Whole frames on one thread, without loading and preparation, by covered pixels. The error of a pixel is \
                that of its worst channel, in linear light.",
        charts: vec![SceneChart {
            id: "scene".to_owned(),
            title: format!("{width} x {height} pixels, {covered} of them covered"),
            truth: format!("{samples} x {samples} samples a pixel, 16 anisotropic probes each"),
            item: "covered pixel",
            unit: "of 1",
            across: Across::Time,
            points,
        }],
    })
}

fn render(scene: &Scene, settings: &RenderSettings) -> Result<Frame, LabError> {
    Ok(texmap_render::render(
        scene,
        settings,
        &texmap_render::no_progress,
    )?)
}

/// Red, green and blue of each pixel, linear and premultiplied.
fn light(scene: &Scene, frame: &Frame) -> Vec<f64> {
    let value = |code: u8| match scene.color {
        ColorMode::Srgb => f64::from(texmap_math::color::srgb8_to_linear(code)),
        ColorMode::Raw => f64::from(code) / 255.0,
    };
    let pixel = |p: &[u8]| [0, 1, 2].map(|k| value(p[k]) * f64::from(p[3]) / 255.0);
    frame.rgba.chunks(4).flat_map(pixel).collect()
}

/// The frame and how it differs from the truth, at most 256 pixels wide each.
fn beside(frame: &Frame, truth: &Frame) -> Option<Picture> {
    let picture = |f: &Frame| Picture::from_rgba(f.width, f.height, f.rgba.clone());
    let (found, exact) = (picture(frame)?, picture(truth)?);
    let off = difference(&exact, &found);
    let step = frame.width.div_ceil(256).max(1);
    let (width, height) = (frame.width / step, frame.height / step);
    let mut out = Picture::new(2 * width + 2, height, [255; 4]);
    for y in 0..i64::from(height) {
        for x in 0..i64::from(width) {
            let (sx, sy) = (x * i64::from(step), y * i64::from(step));
            out.set(x, y, found.get(sx, sy));
            out.set(x + i64::from(width) + 2, y, off.get(sx, sy));
        }
    }
    Some(out)
}
