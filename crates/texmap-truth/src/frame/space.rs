//! Solid textures: colour as a function of the position in space (Perlin 1985; Peachey 1985).

use texmap_math::glam::{DMat4, DVec3, DVec4};
use texmap_sample::Pattern;
use texmap_scene::{Effects, SolidTexture, SolidTextureSource};

use super::grid::Grid;
use super::pattern;

/// A solid texture.
pub(super) struct SampledSolid {
    source: Source,
    solid_from_world: DMat4,
}

enum Source {
    Grid(Grid),
    Pattern(Pattern),
}

impl SampledSolid {
    pub(super) fn new(solid: &SolidTexture, effects: &Effects) -> Self {
        let source = match &solid.source {
            SolidTextureSource::Grid {
                grid,
                sampler,
                wrap_w,
            } => {
                let wraps = [sampler.wrap_u, sampler.wrap_v, *wrap_w];
                Source::Grid(Grid::new(&effects.grids[*grid], sampler, wraps))
            }
            SolidTextureSource::Pattern(pattern) => Source::Pattern(*pattern),
        };
        Self {
            source,
            solid_from_world: solid.world_from_solid.inverse(),
        }
    }

    /// The colour at a point of the world that moves so from sample to sample: linear, premultiplied. Grey for a pattern.
    pub(super) fn color(&self, point: DVec3, moves: [DVec3; 2]) -> DVec4 {
        let at = self.solid_from_world.transform_point3(point);
        let steps = moves.map(|d| self.solid_from_world.transform_vector3(d));
        match &self.source {
            Source::Grid(grid) => grid.voxel(at, steps),
            Source::Pattern(pattern) => {
                let width = steps[0].length().max(steps[1].length());
                DVec3::splat(pattern::value(*pattern, at, width)).extend(1.0)
            }
        }
    }
}
