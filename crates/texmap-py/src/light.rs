//! Light maps and environments.

use std::sync::atomic::Ordering;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use texmap_bake::{BakeOptions, Baker};
use texmap_io::framing::{Up, auto_lights, light_dark_surfaces};
use texmap_light::{Environment, EnvironmentLayout, EnvironmentLight, Light, LightError, ToneMap};
use texmap_math::MemoryBudget;
use texmap_render::{RenderError, shadow_map_for};
use texmap_scene::{Background, shadow_bias, shadow_kind};

use crate::scene::Scene;
use crate::support::{Threads, go_on, interruptible, value, word};

/// The direct light on a mesh: flat texels (three floats each) and their coverage.
#[pyfunction]
#[pyo3(signature = (scene, mesh, size, gutter, shadow_size, shadow_taps, threads))]
pub(crate) fn bake<'py>(
    py: Python<'py>,
    scene: &Scene,
    mesh: usize,
    size: u32,
    gutter: u32,
    shadow_size: u32,
    shadow_taps: u32,
    threads: Option<Threads>,
) -> PyResult<(Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<u8>>)> {
    let scene = scene.copy()?.scene;
    let baked = interruptible(py, threads, |stop| {
        let baker = Baker::new(&scene)?;
        let mut shadows = Vec::new();
        for (index, light) in scene.lights.iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                return Err(RenderError::Cancelled);
            }
            if shadow_size > 0 && !matches!(light, Light::Ambient { .. }) {
                let kind = shadow_kind(&scene, index, None)?;
                let bias = shadow_bias(&scene);
                let map =
                    shadow_map_for(&scene, &kind, shadow_size, bias, shadow_taps, usize::MAX)?;
                shadows.push((index, map, bias, shadow_taps));
            }
        }
        let options = BakeOptions {
            size,
            gutter,
            shadows: &shadows,
            lights: None,
        };
        baker.bake_with_progress(mesh, &options, &go_on(stop))
    })?;
    let map = baked.map_err(|e: RenderError| value(e))?;
    let coverage = map.coverage.iter().map(|c| *c as u8).collect();
    Ok((
        PyArray1::from_slice(py, map.texels.as_flattened()),
        PyArray1::from_vec(py, coverage),
    ))
}

fn environment(
    texels: &PyReadonlyArray1<'_, f32>,
    layout: &str,
    width: u32,
) -> PyResult<Environment> {
    let layout: EnvironmentLayout = word("layout", layout)?;
    let texels = texels.as_slice()?.as_chunks::<3>().0;
    let asked = MemoryBudget::of_process().ask(
        2 * size_of_val(texels) as u64,
        format_args!("an environment of {} texels", texels.len()),
        "give a smaller picture",
    );
    asked.map_err(value)?;
    Environment::from_texels(layout, (width, width / layout.aspect().max(1)), texels).map_err(value)
}

/// An environment in another layout, blurred to a specular map where `blur` is its exponent: width, height of a face, faces and flat
/// texels.
#[pyfunction]
#[pyo3(signature = (texels, width, layout, to, size, blur, threads))]
pub(crate) fn env<'py>(
    py: Python<'py>,
    texels: PyReadonlyArray1<'py, f32>,
    width: u32,
    layout: &str,
    to: &str,
    size: u32,
    blur: Option<f32>,
    threads: Option<Threads>,
) -> PyResult<(u32, u32, usize, Bound<'py, PyArray1<f32>>)> {
    let source = environment(&texels, layout, width)?;
    let to: EnvironmentLayout = word("to", to)?;
    // Faces have borders of one texel; the result stands beside them.
    let [width, height] = [size.saturating_mul(to.aspect()), size].map(|side| u64::from(side) + 2);
    let asked = MemoryBudget::of_process().ask(
        (24 * to.faces() as u64 * width).saturating_mul(height),
        format_args!("an environment of {size} texels a side"),
        "lower size",
    );
    asked.map_err(value)?;
    let made = interruptible(py, threads, |stop| match blur {
        // Another format is no other picture.
        None if source.layout() == to && source.size().1 == size => Ok(source),
        None => source.convert_with_progress(to, size, &go_on(stop)),
        Some(exponent) => source.specular_map_with_progress(to, size, exponent, &go_on(stop)),
    })?
    .map_err(value)?;
    let ((width, height), faces) = (made.size(), to.faces());
    let mut out = Vec::with_capacity(faces * width as usize * height as usize * 3);
    for face in 0..faces {
        for y in 0..height {
            for x in 0..width {
                out.extend(made.texel(face, x, y).unwrap_or_default());
            }
        }
    }
    Ok((width, height, faces, PyArray1::from_vec(py, out)))
}

/// Lights the scene from all around by a lat-long picture, or by nothing (`None`): `behind` shows it as the background.
#[pyfunction]
#[pyo3(signature = (scene, texels, width, rotate, exposure, tone_map, behind))]
pub(crate) fn set_environment(
    py: Python<'_>,
    scene: &Scene,
    texels: Option<PyReadonlyArray1<'_, f32>>,
    width: u32,
    rotate: f64,
    exposure: f32,
    tone_map: Option<&str>,
    behind: bool,
) -> PyResult<()> {
    let light = match &texels {
        None => None,
        Some(texels) => {
            let picture = environment(texels, "lat-long", width)?;
            // As many texels around as the picture has.
            let size = (picture.size().0 / 4).clamp(16, 1024);
            let made = interruptible(py, None, |stop| {
                let cube = EnvironmentLayout::Cube;
                let cube = picture.convert_with_progress(cube, size, &go_on(stop))?;
                Ok(EnvironmentLight::new(&cube, size)?.turned(rotate))
            })?;
            Some(made.map_err(|e: LightError| value(e))?)
        }
    };
    let map = match tone_map {
        Some(name) => word::<ToneMap>("tone_map", name)?,
        None if light.is_some() => ToneMap::PbrNeutral,
        None => ToneMap::None,
    };
    let mut inner = scene.inner.write().map_err(value)?;
    let (up, model, lit) = (inner.up, inner.model, inner.lit);
    let scene = &mut inner.scene;
    let turned = light.map(|light| match up {
        Up::Y => light,
        Up::Z => light.upright_on_z(),
    });
    if turned.is_some() && model && scene.lights == auto_lights(up) {
        scene.lights.clear();
    }
    if behind && turned.is_some() {
        scene.effects.background = Some(Background::EnvironmentLight);
    }
    scene.effects.environment_light = turned;
    scene.effects.tone_mapping.exposure = exposure;
    scene.effects.tone_mapping.map = map;
    // Loading took the lights away that stand in for light from all around.
    if lit {
        light_dark_surfaces(scene, up);
    }
    Ok(())
}
