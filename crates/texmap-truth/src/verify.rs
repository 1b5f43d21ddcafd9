//! The true error of a picture: a frame against the f64 reference of its scene.

use texmap_math::glam::DVec3;
use texmap_render::Frame;
use texmap_sample::{Filter, Precision, Sampler, Wrap};
use texmap_scene::{Background, Material, NormalDetail, Scene, SolidTextureSource};

use crate::TruthError;
use crate::frame::{Truth, frame};
use crate::picture::Picture;
use crate::strip::heat;

/// The true error of a picture, in stored values of 0 to 1, over red, green and blue.
#[derive(Clone, Debug)]
pub struct Verified {
    /// Root mean square over the judged pixels.
    pub rmse: f64,
    /// The same for the judged pixels of each mesh, by index; none where none is judged.
    pub meshes: Vec<Option<f64>>,
    /// Largest error of a channel.
    pub max: f64,
    /// Column and row of `max`.
    pub max_at: Option<(u32, u32)>,
    /// Pixels judged. Something is drawn there, they and their eight neighbours see the same meshes, and no shadow ends there.
    pub judged: usize,
    /// Pixels left out: at outlines, where one sample a pixel errs whatever the filter.
    pub outlines: usize,
    /// Pixels left out: at the edges of shadows, within the reach of their maps' texels and filters.
    pub shadow_edges: usize,
    /// Root mean square over those.
    pub shadow_rmse: f64,
    /// Black where the picture is right, white from an error of 0.25. Outlines are grey, edges of shadows blue-grey.
    pub heat: Picture,
    /// The reference itself.
    pub truth: Picture,
}

/// Judges a frame that was drawn of `scene` by any filter and interpolation. The truth is the f64 reference with
/// `samples` x `samples` samples a pixel, each read by anisotropic:16 over its own share of the pixel.
///
/// # Errors
/// If the scene does not pass its own check.
pub fn verify(scene: &Scene, frame: &Frame, samples: u32) -> Result<Verified, TruthError> {
    let truth = reference(scene, (frame.width, frame.height), samples)?;
    Ok(judge(scene, frame, &truth))
}

/// As [`verify`] for several frames of one size, with the reference drawn once. Empty for no frames.
///
/// # Errors
/// If the scene does not pass its own check.
///
/// # Panics
/// If the frames' sizes differ.
pub fn verify_all(
    scene: &Scene,
    frames: &[Frame],
    samples: u32,
) -> Result<Vec<Verified>, TruthError> {
    let Some(first) = frames.first() else {
        return Ok(Vec::new());
    };
    let size = (first.width, first.height);
    let truth = reference(scene, size, samples)?;
    let judged = frames.iter().map(|frame| {
        assert_eq!((frame.width, frame.height), size, "frames of one size");
        judge(scene, frame, &truth)
    });
    Ok(judged.collect())
}

/// The scene with one wrap mode in both directions for everything that lies on surfaces: what
/// [`Settings::wrap`](texmap_render::RenderSettings) draws.
#[must_use]
pub fn with_wrap(scene: &Scene, wrap: Wrap) -> Scene {
    let mut scene = scene.clone();
    let samplers = scene.materials.iter_mut().flat_map(surface_samplers);
    samplers.for_each(|sampler| (sampler.wrap_u, sampler.wrap_v) = (wrap, wrap));
    scene
}

fn reference(
    scene: &Scene,
    (width, height): (u32, u32),
    samples: u32,
) -> Result<Truth, TruthError> {
    let mut reference = scene.clone();
    for material in &mut reference.materials {
        if let Some(SolidTextureSource::Grid { sampler, .. }) =
            material.solid.as_mut().map(|solid| &mut solid.source)
        {
            sharpen(sampler);
        }
        surface_samplers(material).for_each(sharpen);
    }
    let effects = &mut reference.effects;
    if let Some(Background::Picture(slot)) = &mut effects.background {
        sharpen(&mut slot.sampler);
    }
    let projectors = effects.projectors.iter_mut().map(|p| &mut p.sampler);
    let volumes = effects.volumes.iter_mut().map(|v| &mut v.sampler);
    projectors.chain(volumes).for_each(sharpen);
    frame(&reference, width, height, samples)
}

/// The samplers of everything that is filtered over the surface. Ramps are tables, and are read as they say.
fn surface_samplers(material: &mut Material) -> impl Iterator<Item = &mut Sampler> {
    let maps = &mut material.maps;
    let normal_detail = material
        .normal_detail
        .as_mut()
        .and_then(|detail| match detail {
            NormalDetail::Bump { slot, .. }
            | NormalDetail::Offsets { slot, .. }
            | NormalDetail::NormalMap { slot, .. } => Some(slot),
            NormalDetail::Procedural { .. } => None,
        });
    let metallic = material.metallic_roughness.iter_mut();
    material
        .base_color
        .iter_mut()
        .chain(metallic.flat_map(|model| model.slots_mut()))
        .chain(&mut material.opacity_map)
        .chain(&mut material.decal)
        .chain(&mut maps.ambient)
        .chain(&mut maps.specular)
        .chain(&mut maps.exponent)
        .chain(&mut maps.reflectivity)
        .chain(normal_detail)
        .chain(material.emission.as_mut().and_then(|e| e.map.as_mut()))
        .chain(material.light_map.as_mut().map(|map| &mut map.slot))
        .map(|slot| &mut slot.sampler)
}

fn sharpen(sampler: &mut Sampler) {
    sampler.filter = Filter::Anisotropic(16);
    sampler.precision = Precision::Exact;
}

fn judge(scene: &Scene, frame: &Frame, truth: &Truth) -> Verified {
    let (width, height) = (frame.width, frame.height);
    let codes = truth.codes();
    let index = |x: i64, y: i64| {
        let inside = (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y);
        inside.then(|| (y * i64::from(width) + x) as usize)
    };
    let mut meshes = vec![Sum::default(); scene.meshes.len()];
    let (mut judged, mut edges) = (Sum::default(), Sum::default());
    let mut out = Verified {
        rmse: 0.0,
        meshes: Vec::new(),
        max: 0.0,
        max_at: None,
        judged: 0,
        outlines: 0,
        shadow_edges: 0,
        shadow_rmse: 0.0,
        heat: Picture::new(width, height, [0, 0, 0, 255]),
        truth: truth.picture(),
    };
    for y in 0..height {
        for x in 0..width {
            let (i, j) = (i64::from(x), i64::from(y));
            let here = y as usize * width as usize + x as usize;
            if !truth.drawn[here] {
                continue;
            }
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let inner = around
                .filter_map(|(dx, dy)| index(i + dx, j + dy))
                .all(|other| truth.layers[other] == truth.layers[here]);
            if !inner {
                out.outlines += 1;
                out.heat.set(i, j, [96, 96, 96, 255]);
                continue;
            }
            let off = |k: usize| f64::from(frame.rgba[4 * here + k]) - codes[4 * here + k];
            let color = DVec3::new(off(0), off(1), off(2)).abs() / 255.0;
            if truth.shadow_edges[here] {
                edges.add(color);
                out.heat.set(i, j, [64, 64, 128, 255]);
                continue;
            }
            judged.add(color);
            // Blended ones count where nothing solid is behind them.
            let solid = truth.seen[here].map(|(mesh, _)| mesh);
            if let Some(mesh) = solid.or(truth.top[here]) {
                meshes[mesh].add(color);
            }
            if color.max_element() > out.max {
                (out.max, out.max_at) = (color.max_element(), Some((x, y)));
            }
            out.heat.set(i, j, heat(color.max_element() * 4.0));
        }
    }
    (out.rmse, out.judged) = (judged.root(), judged.count);
    (out.shadow_rmse, out.shadow_edges) = (edges.root(), edges.count);
    let mean = |sum: &Sum| (sum.count > 0).then(|| sum.root());
    out.meshes = meshes.iter().map(mean).collect();
    out
}

/// Squares of errors.
#[derive(Clone, Copy, Default)]
struct Sum {
    squares: f64,
    count: usize,
}

impl Sum {
    fn add(&mut self, off: DVec3) {
        self.squares += off.length_squared() / 3.0;
        self.count += 1;
    }

    /// Root mean of the squares; 0 of none.
    fn root(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}
