//! Solid textures evaluated: colour as a function of the position in space (Perlin 1985; Peachey 1985).

use texmap_light::lanes::{affine, dot};
use texmap_math::glam::DVec4;
use texmap_math::simd::Number;
use texmap_sample::{Pattern, Sampler, Texture3d, Wrap};

use crate::{Effects, SolidTexture, SolidTextureSource};

/// A [`SolidTexture`] with its grid, ready for look-ups at world positions.
#[derive(Clone, Copy, Debug)]
pub struct SolidField<'s> {
    source: Source<'s>,
    rows: [[f32; 4]; 3],
}

#[derive(Clone, Copy, Debug)]
enum Source<'s> {
    Grid(&'s Texture3d<'static>, &'s Sampler, Wrap),
    Pattern(Pattern),
}

impl<'s> SolidField<'s> {
    /// Looks the grid of `solid` up in `effects`.
    ///
    /// # Panics
    /// On a grid that does not exist; [`Scene::check`](crate::Scene::check) refuses such a scene.
    #[must_use]
    pub fn new(solid: &'s SolidTexture, effects: &'s Effects) -> Self {
        let m = solid.world_from_solid.inverse().transpose();
        let row = |r: DVec4| r.to_array().map(|c| c as f32);
        Self {
            source: match &solid.source {
                SolidTextureSource::Grid {
                    grid,
                    sampler,
                    wrap_w,
                } => Source::Grid(&effects.grids[*grid], sampler, *wrap_w),
                SolidTextureSource::Pattern(pattern) => Source::Pattern(*pattern),
            },
            rows: [row(m.x_axis), row(m.y_axis), row(m.z_axis)],
        }
    }

    /// The pattern, if it is one and no grid.
    #[must_use]
    pub fn pattern(&self) -> Option<Pattern> {
        match self.source {
            Source::Grid(..) => None,
            Source::Pattern(pattern) => Some(pattern),
        }
    }

    /// The grid, the sampler that reads it and the wrap of its slices, if it is one and no pattern.
    #[must_use]
    pub fn grid(&self) -> Option<(&'s Texture3d<'static>, &'s Sampler, Wrap)> {
        match self.source {
            Source::Grid(grid, sampler, wrap_w) => Some((grid, sampler, wrap_w)),
            Source::Pattern(_) => None,
        }
    }

    /// Points in the space of the texture, and their changes, of world positions that move by `dx` and `dy` from pixel to pixel.
    #[doc(hidden)]
    #[inline(always)]
    #[must_use]
    pub fn place_lanes<T: Number<f32>>(&self, p: [T; 3], dx: [T; 3], dy: [T; 3]) -> [[T; 3]; 3] {
        [
            affine(&self.rows, p),
            linear(&self.rows, dx),
            linear(&self.rows, dy),
        ]
    }

    /// The colour at a world position that moves by `dx` and `dy` from pixel to pixel: linear light, premultiplied. A pattern is grey.
    #[must_use]
    pub fn color(&self, p: [f32; 3], dx: [f32; 3], dy: [f32; 3]) -> [f32; 4] {
        let [at, dx, dy] = self.place_lanes(p, dx, dy);
        match self.source {
            Source::Grid(grid, sampler, wrap_w) => {
                sampler.sample_3d(grid, at, wrap_w, grid.lod(dx, dy))
            }
            Source::Pattern(pattern) => {
                let (x, y) = (dot(dx, dx), dot(dy, dy));
                let v = pattern.value(at, (if x > y { x } else { y }).sqrt());
                [v, v, v, 1.0]
            }
        }
    }
}

/// A vector under the linear part of an affine map.
#[inline(always)]
fn linear<T: Number<f32>>(rows: &[[f32; 4]; 3], v: [T; 3]) -> [T; 3] {
    let mut out = v;
    for (out, [a, b, c, _]) in out.iter_mut().zip(rows) {
        *out = v[0] * *a + v[1] * *b + v[2] * *c;
    }
    out
}
