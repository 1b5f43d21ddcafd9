use crate::{
    address::wrap::OUTSIDE,
    filter::gl_of,
    sampler::{Sampler, TexelFilter},
    texture::Texture2d,
};

/// Direction of a depth comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Compare {
    /// Passes where the reference is at most the texel.
    #[default]
    LessEqual,
    /// Passes where the reference is at least the texel (reversed depth).
    GreaterEqual,
}

impl Sampler {
    /// Shadow look-up: compares `reference` with the first channel of each texel, then filters the
    /// answers; 1 passes, 0 fails. Linear filters weigh four comparisons of level 0 (percentage-closer
    /// filtering, Reeves, Salesin and Cook 1987), others take one. A NaN reference fails.
    pub fn sample_compare(
        &self,
        t: &Texture2d<'_>,
        uv: [f32; 2],
        reference: f32,
        compare: Compare,
    ) -> f32 {
        let chain = &t.chain;
        let level = &chain.levels[0];
        let scale = chain.format.scale();
        let [ax, ay] = self.axes(chain);
        let pass = |x: i32, y: i32| {
            let texel = if x == OUTSIDE || y == OUTSIDE {
                self.border_in(1.0)[0]
            } else {
                chain.fetch(level, x, y, 0)[0] * scale
            };
            let passed = match compare {
                Compare::LessEqual => reference <= texel,
                Compare::GreaterEqual => reference >= texel,
            };
            f32::from(u8::from(passed))
        };
        if gl_of(self.filter).0 == TexelFilter::Nearest {
            return pass(
                ax.nearest(uv[0], level.width),
                ay.nearest(uv[1], level.height),
            );
        }
        let ([x0, x1], wx) = ax.around(uv[0], level.width);
        let ([y0, y1], wy) = ay.around(uv[1], level.height);
        let (a, b, c, d) = (pass(x0, y0), pass(x1, y0), pass(x0, y1), pass(x1, y1));
        let top = a + (b - a) * wx;
        let bottom = c + (d - c) * wx;
        top + (bottom - top) * wy
    }
}
