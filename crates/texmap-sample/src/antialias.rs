//! Alpha as an outline: the coverage of a pixel where the edge of a magnified alpha mask crosses it.

use texmap_math::Footprint;
use texmap_math::float::sqrt_f32;

use crate::{Sampler, Texture2d};

impl Sampler {
    /// Coverage (0..=1) of a pixel by the part of the texture where alpha is a half or more: alpha over its change from pixel to pixel
    /// (Green 2007). `alpha` is the filtered value; where a pixel sees several texels it is the coverage already and comes back unchanged.
    #[must_use]
    pub fn antialiased_alpha(
        &self,
        texture: &Texture2d<'_>,
        uv: [f32; 2],
        d: Footprint,
        alpha: f32,
    ) -> f32 {
        let lod = self.lod(texture, d);
        if lod > 0.0 {
            return alpha;
        }
        let [value, du, dv] = self.sample_with_gradient(texture, uv, 0.0);
        let dx = du[3] * d.du_dx + dv[3] * d.dv_dx;
        let dy = du[3] * d.du_dy + dv[3] * d.dv_dy;
        let change = sqrt_f32(dx * dx + dy * dy);
        let change = if change < 1.0 { change } else { 1.0 };
        let inside = value[3] - 0.5;
        if inside >= 0.5 * change {
            1.0
        } else if inside <= -0.5 * change {
            0.0
        } else {
            inside / change + 0.5
        }
    }
}
