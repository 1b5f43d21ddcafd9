use crate::{address::wrap::OUTSIDE, sampler::Sampler, texel_data::scaled, texture::Texture2d};
use texmap_math::{float, footprint::Footprint};

impl Sampler {
    /// The bilinear surface at a level: value and its exact derivatives by u and by v.
    ///
    /// The nearest level to `lod` is taken, so that value and slope belong to one surface.
    pub fn sample_with_gradient(&self, t: &Texture2d<'_>, uv: [f32; 2], lod: f32) -> [[f32; 4]; 3] {
        let chain = &t.chain;
        let last = (chain.levels.len() - 1) as f32;
        let lod = self.limit_lod(lod);
        let lod = if lod > last { last } else { lod };
        let number = if lod > 0.0 {
            float::ceil_f32(lod + 0.5) as usize - 1
        } else {
            0
        };
        let level = &chain.levels[number];
        let [ax, ay] = self.axes(chain);
        let ([x0, x1], wx) = ax.around(uv[0], level.width);
        let ([y0, y1], wy) = ay.around(uv[1], level.height);
        let scale = chain.format.scale();
        let tap = |x: i32, y: i32| {
            if x == OUTSIDE || y == OUTSIDE {
                self.border_in(1.0)
            } else {
                scaled(chain.fetch(level, x, y, 0), scale)
            }
        };
        let (a, b, c, d) = (tap(x0, y0), tap(x1, y0), tap(x0, y1), tap(x1, y1));
        let (w, h) = (level.width as f32, level.height as f32);
        let [mut value, mut du, mut dv] = [[0.0; 4]; 3];
        for k in 0..4 {
            let (top, bottom) = (a[k] + (b[k] - a[k]) * wx, c[k] + (d[k] - c[k]) * wx);
            value[k] = top + (bottom - top) * wy;
            let (left, right) = (a[k] + (c[k] - a[k]) * wy, b[k] + (d[k] - b[k]) * wy);
            du[k] = (right - left) * w;
            dv[k] = (bottom - top) * h;
        }
        [value, du, dv]
    }

    /// A dependent look-up: the first two channels of `first` at `uv` are the coordinates in `second`.
    ///
    /// The footprint of the second look-up is that of the first through the slope of the first
    /// texture's surface (the chain rule), at the level that the first look-up asks for.
    pub fn sample_through_ramp(
        &self,
        first: &Texture2d<'_>,
        uv: [f32; 2],
        d: Footprint,
        sampler: &Self,
        second: &Texture2d<'_>,
    ) -> [f32; 4] {
        let [value, du, dv] = self.sample_with_gradient(first, uv, self.lod(first, d));
        let inner = Footprint {
            du_dx: du[0] * d.du_dx + dv[0] * d.dv_dx,
            dv_dx: du[1] * d.du_dx + dv[1] * d.dv_dx,
            du_dy: du[0] * d.du_dy + dv[0] * d.dv_dy,
            dv_dy: du[1] * d.du_dy + dv[1] * d.dv_dy,
        };
        sampler.sample_grad(second, [value[0], value[1]], inner)
    }
}
