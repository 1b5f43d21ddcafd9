use crate::{
    filter::{axes, floor, gl_of, linear_axis},
    sampler::{Sampler, Texel},
    texture::Texture2d,
    wrap::OUTSIDE,
};

/// Which way a depth comparison goes.
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
        let [ax, ay] = axes(self, chain);
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
        if gl_of(self.filter).0 == Texel::Nearest {
            let x = ax.index(floor(ax.place(uv[0], level.width)), level.width);
            let y = ay.index(floor(ay.place(uv[1], level.height)), level.height);
            return pass(x, y);
        }
        let ([x0, x1], wx) = linear_axis(ax, uv[0], level.width);
        let ([y0, y1], wy) = linear_axis(ay, uv[1], level.height);
        let (a, b, c, d) = (pass(x0, y0), pass(x1, y0), pass(x0, y1), pass(x1, y1));
        let top = a + (b - a) * wx;
        let bottom = c + (d - c) * wx;
        top + (bottom - top) * wy
    }
}
