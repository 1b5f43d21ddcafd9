//! The gradient of look-ups with respect to texels: the weights of a look-up, scattered.

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use texmap_math::deterministic_f64;
use texmap_sample::{Filter, Wrap};

use crate::by_levels::{ByLevels, footprint_length};
use crate::support::{expect_length, value};

/// Gradient with respect to the texels of one image from that with respect to the look-ups of `sample_levels`. Summed in f64 in the
/// order of the look-ups, on one thread; that of a coarser level goes to the texels that it is the mean of.
#[pyfunction]
#[pyo3(signature = (uv, uv_da, bias, grad, size, channels, filter, boundary, max_level, out))]
pub(crate) fn texture_gradient(
    py: Python<'_>,
    uv: PyReadonlyArray1<'_, f32>,
    uv_da: Option<PyReadonlyArray1<'_, f32>>,
    bias: Option<PyReadonlyArray1<'_, f32>>,
    grad: PyReadonlyArray1<'_, f32>,
    size: (usize, usize),
    channels: usize,
    filter: &str,
    boundary: &str,
    max_level: usize,
    mut out: PyReadwriteArray1<'_, f32>,
) -> PyResult<()> {
    let uv = uv.as_slice()?.as_chunks::<2>().0;
    let last = max_level as f32;
    let by_levels = ByLevels::new(filter, boundary, last, (&uv_da, 4), &bias, uv.len())?;
    let ByLevels { sampler, da, bias } = by_levels;
    let (grad, out) = (grad.as_slice()?, out.as_slice_mut()?);
    expect_length("grad", grad.len(), uv.len() * channels)?;
    expect_length("out", out.len(), size.0 * size.1 * channels)?;
    if out.is_empty() {
        return Err(value("a texture without texels has no gradient"));
    }
    py.detach(|| {
        let mut levels = Levels::new(size, channels, max_level);
        let texels = [size.0 as f32, size.1 as f32];
        for (k, uv) in uv.iter().enumerate() {
            let grad = &grad[k * channels..(k + 1) * channels];
            let length = da.map_or(1.0, |da| footprint_length(&da[4 * k..4 * k + 4], texels));
            let lod =
                deterministic_f64::log2(f64::from(length)) + bias.map_or(0.0, |b| f64::from(b[k]));
            levels.scatter(sampler.filter, sampler.wrap_u, uv.map(f64::from), lod, grad);
        }
        levels.gather(out);
    });
    Ok(())
}

/// Sums for each texel of each level.
struct Levels {
    channels: usize,
    all: Vec<((usize, usize), Vec<f64>)>,
}

impl Levels {
    fn new(mut size: (usize, usize), channels: usize, max_level: usize) -> Self {
        let mut all = Vec::new();
        loop {
            all.push((size, vec![0.0; size.0 * size.1 * channels]));
            let odd = |n: usize| n > 1 && n % 2 == 1;
            if all.len() > max_level || size == (1, 1) || odd(size.0) || odd(size.1) {
                return Self { channels, all };
            }
            size = ((size.0 / 2).max(1), (size.1 / 2).max(1));
        }
    }

    fn scatter(&mut self, filter: Filter, wrap: Wrap, uv: [f64; 2], lod: f64, grad: &[f32]) {
        let last = (self.all.len() - 1) as f64;
        // NaN, of a footprint without length, gives the finest level.
        let lod = if lod > 0.0 { lod } else { 0.0 };
        let lod = if lod < last { lod } else { last };
        match filter {
            Filter::Nearest => self.add_nearest(wrap, uv, grad),
            Filter::Bilinear => self.add(0, 1.0, wrap, uv, grad),
            Filter::BilinearMipNearest => {
                let nearest = (lod + 0.5).ceil() - 1.0;
                self.add(nearest.max(0.0) as usize, 1.0, wrap, uv, grad);
            }
            _ => {
                let (level, part) = (lod.floor(), lod - lod.floor());
                self.add(level as usize, 1.0 - part, wrap, uv, grad);
                if part > 0.0 {
                    self.add(level as usize + 1, part, wrap, uv, grad);
                }
            }
        }
    }

    fn add_nearest(&mut self, wrap: Wrap, [u, v]: [f64; 2], grad: &[f32]) {
        let (width, height) = self.all[0].0;
        let (x, y) = ((u * width as f64).floor(), (v * height as f64).floor());
        self.add_texel(0, 1.0, wrap, [x, y], grad);
    }

    fn add(&mut self, level: usize, weight: f64, wrap: Wrap, [u, v]: [f64; 2], grad: &[f32]) {
        let (width, height) = self.all[level].0;
        let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        for (dx, dy, part) in [
            (0.0, 0.0, (1.0 - fx) * (1.0 - fy)),
            (1.0, 0.0, fx * (1.0 - fy)),
            (0.0, 1.0, (1.0 - fx) * fy),
            (1.0, 1.0, fx * fy),
        ] {
            self.add_texel(level, weight * part, wrap, [left + dx, top + dy], grad);
        }
    }

    fn add_texel(&mut self, level: usize, weight: f64, wrap: Wrap, at: [f64; 2], grad: &[f32]) {
        let ((width, height), sums) = &mut self.all[level];
        let place = |at: f64, count: usize| {
            let n = count as f64;
            match wrap {
                _ if !at.is_finite() => None,
                Wrap::Repeat => Some((at - (at / n).floor() * n) as usize % count),
                Wrap::ClampToEdge => Some(at.clamp(0.0, n - 1.0) as usize),
                // Texels outside of the image are zero.
                _ => (0.0..n).contains(&at).then_some(at as usize),
            }
        };
        if let (Some(x), Some(y)) = (place(at[0], *width), place(at[1], *height)) {
            let first = (y * *width + x) * self.channels;
            for (sum, grad) in sums[first..first + self.channels].iter_mut().zip(grad) {
                *sum += weight * f64::from(*grad);
            }
        }
    }

    /// Hands the sums of each level to the finer one, each texel's share to those that it is the mean of.
    fn gather(mut self, out: &mut [f32]) {
        let channels = self.channels;
        while let Some(((width, height), coarse)) = self.all.pop() {
            let Some(((fine_width, fine_height), fine)) = self.all.last_mut() else {
                for (out, sum) in out.iter_mut().zip(&coarse) {
                    *out = *sum as f32;
                }
                return;
            };
            let (across, down) = (*fine_width / width, *fine_height / height);
            let share = 1.0 / (across * down) as f64;
            for y in 0..*fine_height {
                for x in 0..*fine_width {
                    let from = ((y / down) * width + x / across) * channels;
                    let to = (y * *fine_width + x) * channels;
                    for c in 0..channels {
                        fine[to + c] += share * coarse[from + c];
                    }
                }
            }
        }
    }
}
