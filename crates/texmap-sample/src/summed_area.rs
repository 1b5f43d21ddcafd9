use crate::{address::wrap::Wrap, sampler::Sampler, texture::Texture2d};
use alloc::{vec, vec::Vec};
use texmap_math::{float::floor, footprint::Footprint};

/// A summed-area table (Crow 1984): the exact mean over any axis-aligned rectangle in four look-ups.
///
/// 32 bytes a texel. Footprints are replaced by their bounding rectangles, so that turned ones blur.
#[derive(Clone, Debug)]
pub struct SummedArea {
    width: usize,
    height: usize,
    /// Sums over `[0, x) x [0, y)`, one more column and row than the texture.
    sums: Vec<[f64; 4]>,
}

impl SummedArea {
    /// Sums level 0 of a texture; rows count from its origin.
    pub fn new(t: &Texture2d<'_>) -> Self {
        let (width, height) = (t.width() as usize, t.height() as usize);
        let mut sums = vec![[0.0; 4]; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut line = [0.0_f64; 4];
            for x in 0..width {
                let c = t.texel(0, x as u32, y as u32).unwrap_or_default();
                let above = sums[y * (width + 1) + x + 1];
                for k in 0..4 {
                    line[k] += f64::from(c[k]);
                    sums[(y + 1) * (width + 1) + x + 1][k] = above[k] + line[k];
                }
            }
        }
        Self {
            width,
            height,
            sums,
        }
    }

    /// The mean over the bounding rectangle of a pixel's footprint, at least one texel wide. The
    /// sampler gives the wraps: repeat repeats, every other mode clamps to the edge.
    pub fn sample_grad(&self, s: &Sampler, uv: [f32; 2], d: Footprint) -> [f32; 4] {
        let span = |a: f32, b: f32, n: usize| {
            let l = f64::from(a.abs() + b.abs()) * n as f64;
            if l > 1.0 {
                if l < 1e6 { l } else { 1e6 }
            } else {
                1.0
            }
        };
        let (w, h) = (
            span(d.du_dx, d.du_dy, self.width),
            span(d.dv_dx, d.dv_dy, self.height),
        );
        let centre = |u: f32, wrap: Wrap, n: usize| {
            let u = f64::from(u);
            let u = if wrap == Wrap::Repeat {
                u - floor(u)
            } else {
                u.clamp(-1e6, 1e6)
            };
            if u.is_finite() { u * n as f64 } else { 0.0 }
        };
        let x = centre(uv[0], s.wrap_u, self.width);
        let y = centre(uv[1], s.wrap_v, self.height);
        let (x0, x1) = Self::side(x, w, s.wrap_u, self.width);
        let (y0, y1) = Self::side(y, h, s.wrap_v, self.height);
        let area = (x1 - x0) * (y1 - y0);
        let corners = [
            self.sum(x1, y1),
            self.sum(x0, y1),
            self.sum(x1, y0),
            self.sum(x0, y0),
        ];
        [0, 1, 2, 3].map(|k| {
            ((corners[0][k] - corners[1][k] - corners[2][k] + corners[3][k]) / area) as f32
        })
    }

    /// Ends of an interval; where the axis clamps, moved inside the image.
    fn side(x: f64, length: f64, wrap: Wrap, n: usize) -> (f64, f64) {
        let (low, high) = (x - 0.5 * length, x + 0.5 * length);
        if wrap == Wrap::Repeat {
            return (low, high);
        }
        let n = n as f64;
        let low = low.clamp(0.0, n - 1.0);
        (low, high.clamp(low + 1.0, n))
    }

    /// The integral of the repeated texture over `[0, x) x [0, y)`.
    fn sum(&self, x: f64, y: f64) -> [f64; 4] {
        let (w, h) = (self.width as f64, self.height as f64);
        let (kx, ky) = (floor(x / w), floor(y / h));
        let (fx, fy) = ((x - kx * w).clamp(0.0, w), (y - ky * h).clamp(0.0, h));
        let (whole, columns) = (self.inside(w, h), self.inside(w, fy));
        let (rows, part) = (self.inside(fx, h), self.inside(fx, fy));
        [0, 1, 2, 3].map(|k| kx * ky * whole[k] + kx * columns[k] + ky * rows[k] + part[k])
    }

    /// Bilinear between the sums, which is exact for constant texels.
    fn inside(&self, x: f64, y: f64) -> [f64; 4] {
        let (i, j) = (
            (x as usize).min(self.width - 1),
            (y as usize).min(self.height - 1),
        );
        let (fx, fy) = (x - i as f64, y - j as f64);
        let at = |i: usize, j: usize| self.sums[j * (self.width + 1) + i];
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
        [0, 1, 2, 3].map(|k| {
            let top = a[k] + (b[k] - a[k]) * fx;
            top + (c[k] + (d[k] - c[k]) * fx - top) * fy
        })
    }
}
