//! Solid textures: colour as a function of the place in space, carved by the surface (Perlin 1985; Peachey 1985).

use texmap_light::lanes::{V3, dot_lanes};
use texmap_math::fearless_simd::{Simd, prelude::*};
use texmap_math::glam::{DMat4, DVec3};
use texmap_math::lanes::above;
use texmap_math::simd::X16;
use texmap_math::{Level, on_wide_level};
use texmap_raster::{Column, RUN_ROOM};
use texmap_sample::{Pattern, Sampler, Texture3d, Wrap};

use crate::Effects;
use crate::canvas::{LANES, vector};

/// A texture that fills space. Its colour multiplies that of the surface; with a
/// [`color_ramp`](crate::Material::color_ramp) its first channel is looked up along that.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// What it is made of.
    pub source: SolidSource,
    /// Where its unit cube (of a grid) or its unit (of a pattern) stands in the world; may not be flat.
    pub world_from_solid: DMat4,
}

/// What a solid texture is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidSource {
    /// A grid over the unit cube.
    Grid {
        /// Index into [`Effects::grids`].
        grid: usize,
        /// Filter and the wrap along x and y.
        sampler: Sampler,
        /// The wrap along z.
        wrap_w: Wrap,
    },
    /// A formula; grey without a ramp.
    Pattern(Pattern),
}

/// A solid texture as the stages read it.
pub(crate) struct SolidStage<'s> {
    source: Source<'s>,
    /// Rows of solid space from world space.
    rows: [[f32; 4]; 3],
    /// First of the attributes that hold the world position.
    pub(crate) position: usize,
}

enum Source<'s> {
    Grid(&'s Texture3d<'static>, &'s Sampler, Wrap),
    Pattern(Pattern),
}

impl<'s> SolidStage<'s> {
    pub(crate) fn new(solid: &'s Solid, effects: &'s Effects, position: usize) -> Self {
        let m = solid.world_from_solid.inverse().transpose();
        let row = |r: texmap_math::glam::DVec4| r.to_array().map(|c| c as f32);
        Self {
            source: match &solid.source {
                SolidSource::Grid {
                    grid,
                    sampler,
                    wrap_w,
                } => Source::Grid(&effects.grids[*grid], sampler, *wrap_w),
                SolidSource::Pattern(pattern) => Source::Pattern(*pattern),
            },
            rows: [row(m.x_axis), row(m.y_axis), row(m.z_axis)],
            position,
        }
    }

    /// The values of a pattern at the world positions of a run, where it has lanes: each stands for all three channels.
    pub(crate) fn values(
        &self,
        level: Level,
        [x, y, z]: [&Column; 3],
        blocks: usize,
        out: &mut [f32; RUN_ROOM],
    ) -> bool {
        let Source::Pattern(pattern) = self.source else {
            return false;
        };
        on_wide_level!(
            level,
            s => {
                for i in 0..blocks {
                    let at = i * LANES..(i + 1) * LANES;
                    let value = [&x.value, &y.value, &z.value];
                    let mut place = self.along_lanes(s, value, i);
                    for (c, row) in place.iter_mut().zip(self.rows) {
                        *c += row[3];
                    }
                    let [dx, dy] = [
                        self.along_lanes(s, [&x.ddx, &y.ddx, &z.ddx], i),
                        self.along_lanes(s, [&x.ddy, &y.ddy, &z.ddy], i),
                    ];
                    let width = above(dot_lanes(dx, dx), dot_lanes(dy, dy)).sqrt();
                    pattern.value_lanes(X16(s), place, width).store_slice(&mut out[at]);
                }
                true
            },
            else false
        )
    }

    /// A vector of a block in solid space.
    #[inline(always)]
    fn along_lanes<S: Simd>(&self, s: S, columns: [&[f32; RUN_ROOM]; 3], i: usize) -> V3<S> {
        let v = vector(s, columns, i);
        let mut out = v;
        for (out, r) in out.iter_mut().zip(self.rows) {
            *out = v[0] * r[0] + v[1] * r[1] + v[2] * r[2];
        }
        out
    }

    /// The colour at a world position that moves by `dx` and `dy` from pixel to pixel: linear, premultiplied.
    pub(crate) fn color(&self, p: [f32; 3], dx: [f32; 3], dy: [f32; 3]) -> [f32; 4] {
        let along = |v: [f32; 3]| self.rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2]);
        let (at, dx, dy) = (along(p), along(dx), along(dy));
        let at = [0, 1, 2].map(|k| at[k] + self.rows[k][3]);
        match self.source {
            Source::Grid(grid, sampler, wrap_w) => {
                sampler.sample_3d(grid, at, wrap_w, grid.lod(dx, dy))
            }
            Source::Pattern(pattern) => {
                let squared = |d: [f32; 3]| d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let (x, y) = (squared(dx), squared(dy));
                let v = pattern.value(at, (if x > y { x } else { y }).sqrt());
                [v, v, v, 1.0]
            }
        }
    }
}

/// Whether a matrix can be turned round.
pub(crate) fn has_volume(matrix: &DMat4) -> bool {
    let determinant = matrix.determinant();
    let inverse = matrix.inverse();
    determinant != 0.0
        && determinant.is_finite()
        && inverse.is_finite()
        && inverse.transform_vector3(DVec3::ONE).as_vec3().is_finite()
}
