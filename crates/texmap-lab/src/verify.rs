//! What a picture is really off by: a frame against the f64 reference of its scene.

use texmap_math::glam::DVec4;
use texmap_render::{Frame, Scene};
use texmap_sample::{Filter, Precision};

use crate::LabError;
use crate::picture::Picture;
use crate::strip::heat;
use crate::truth::{self, Truth};

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
    /// Pixels judged: they and their eight neighbours see one mesh.
    pub judged: usize,
    /// Pixels left out: at outlines, where one sample a pixel errs whatever the filter.
    pub outlines: usize,
    /// Black where the picture is right, white from an error of 0.25; outlines are grey.
    pub heat: Picture,
}

/// Judges a frame that was drawn of `scene` by any filter and interpolation. The truth is the f64 reference with
/// `samples` x `samples` samples a pixel, each read trilinearly.
///
/// # Errors
/// When the scene does not pass its own check.
pub fn verify(scene: &Scene, frame: &Frame, samples: u32) -> Result<Verified, LabError> {
    let mut reference = scene.clone();
    for material in &mut reference.materials {
        for slot in material
            .base_color
            .iter_mut()
            .chain(&mut material.opacity_map)
        {
            slot.sampler.filter = Filter::Trilinear;
            slot.sampler.precision = Precision::Exact;
        }
    }
    let truth = truth::frame(&reference, frame.width, frame.height, samples)?;
    Ok(judge(scene, frame, &truth))
}

fn judge(scene: &Scene, frame: &Frame, truth: &Truth) -> Verified {
    let (width, height) = (frame.width, frame.height);
    let codes = truth.codes();
    let seen = |x: i64, y: i64| {
        let inside = (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y);
        let index = y * i64::from(width) + x;
        inside.then(|| truth.seen[index as usize].map(|(mesh, _)| mesh))
    };
    let mut sums = vec![(0.0, 0usize); scene.meshes.len()];
    let mut out = Verified {
        rmse: 0.0,
        meshes: Vec::new(),
        max: 0.0,
        max_at: None,
        judged: 0,
        outlines: 0,
        heat: Picture::new(width, height, [0, 0, 0, 255]),
    };
    for y in 0..height {
        for x in 0..width {
            let (i, j) = (i64::from(x), i64::from(y));
            let Some(Some(mesh)) = seen(i, j) else {
                continue;
            };
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let inner = around
                .filter_map(|(dx, dy)| seen(i + dx, j + dy))
                .all(|other| other == Some(mesh));
            if !inner {
                out.outlines += 1;
                out.heat.set(i, j, [96, 96, 96, 255]);
                continue;
            }
            let first = 4 * (y as usize * width as usize + x as usize);
            let off = DVec4::from_array(
                [0, 1, 2, 3]
                    .map(|k| (f64::from(frame.rgba[first + k]) - codes[first + k]).abs() / 255.0),
            );
            let color = off.truncate();
            sums[mesh].0 += color.length_squared() / 3.0;
            sums[mesh].1 += 1;
            out.judged += 1;
            if color.max_element() > out.max {
                (out.max, out.max_at) = (color.max_element(), Some((x, y)));
            }
            out.heat.set(i, j, heat(color.max_element() * 4.0));
        }
    }
    let total: f64 = sums.iter().map(|s| s.0).sum();
    out.rmse = (total / out.judged.max(1) as f64).sqrt();
    let mean = |&(sum, n): &(f64, usize)| (n > 0).then(|| (sum / n as f64).sqrt());
    out.meshes = sums.iter().map(mean).collect();
    out
}
