//! A grid of voxels over the unit cube, in f64.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec3, DVec4};
use texmap_sample::{Filter, Sampler, Texture3d, Wrap};

/// The levels of a grid, and how it is read.
pub(super) struct Grid {
    levels: Vec<Level>,
    wraps: [Wrap; 3],
    border: DVec4,
    filter: Filter,
    pub(super) has_alpha_channel: bool,
}

struct Level {
    size: [i64; 3],
    voxels: Vec<DVec4>,
}

impl Grid {
    pub(super) fn new(grid: &Texture3d<'_>, sampler: &Sampler, wraps: [Wrap; 3]) -> Self {
        let level = |number: u32| {
            let size = grid.level_size(number).unwrap_or([1; 3]);
            let [w, h, d] = size;
            let places =
                (0..d).flat_map(|z| (0..h).flat_map(move |y| (0..w).map(move |x| [x, y, z])));
            let voxel =
                |at| DVec4::from_array(grid.texel(number, at).unwrap_or_default().map(f64::from));
            Level {
                size: size.map(i64::from),
                voxels: places.map(voxel).collect(),
            }
        };
        Self {
            levels: (0..grid.levels()).map(level).collect(),
            wraps,
            border: DVec4::from_array(sampler.border.map(f64::from)),
            filter: sampler.filter,
            has_alpha_channel: grid.has_alpha_channel(),
        }
    }

    /// Voxels along each side.
    pub(super) fn size(&self) -> DVec3 {
        DVec3::from_array(self.levels[0].size.map(|n| n as f64))
    }

    /// The voxel at a point of the unit cube, where a sample is as wide as these steps are: linear, premultiplied. Eight voxels a level
    /// between the two levels of that width, or the nearest voxel, as the filter says.
    pub(super) fn voxel(&self, at: DVec3, steps: [DVec3; 2]) -> DVec4 {
        match self.filter {
            Filter::Nearest | Filter::MipNearest => return self.nearest(at),
            Filter::Bilinear => return self.linear(0, at),
            _ => {}
        }
        let square = steps.map(|d| (d * self.size()).length_squared());
        let square = square[0].max(square[1]);
        let last = (self.levels.len() - 1) as f64;
        let lod = if square > 1.0 {
            0.5 * deterministic_f64::log2(square)
        } else {
            0.0
        }
        .min(last);
        let fine = lod.floor();
        let near = self.linear(fine as usize, at);
        if lod == fine {
            return near;
        }
        near * (1.0 - (lod - fine)) + self.linear(fine as usize + 1, at) * (lod - fine)
    }

    fn nearest(&self, at: DVec3) -> DVec4 {
        let level = &self.levels[0];
        let [x, y, z] = [0, 1, 2].map(|k| (at[k] * level.size[k] as f64).floor() as i64);
        self.fetch(level, [x, y, z])
    }

    fn linear(&self, level: usize, at: DVec3) -> DVec4 {
        let level = &self.levels[level];
        let place = DVec3::from_array(level.size.map(|n| n as f64)) * at - 0.5;
        let low = place.floor();
        let part = place - low;
        let mut sum = DVec4::ZERO;
        for corner in 0..8i64 {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f64 = (0..3)
                .map(|k| if side[k] == 1 { part[k] } else { 1.0 - part[k] })
                .product();
            let index = [0, 1, 2].map(|k| low[k] as i64 + side[k]);
            sum += self.fetch(level, index) * weight;
        }
        sum
    }

    fn fetch(&self, level: &Level, index: [i64; 3]) -> DVec4 {
        let mut at = [0; 3];
        for k in 0..3 {
            match wrapped(index[k], level.size[k], self.wraps[k]) {
                Some(i) => at[k] = i,
                None => return self.border,
            }
        }
        let [w, h, _] = level.size;
        level.voxels[((at[2] * h + at[1]) * w + at[0]) as usize]
    }
}

/// Vulkan 1.4, "Wrapping Operation".
fn wrapped(i: i64, n: i64, wrap: Wrap) -> Option<i64> {
    let mirror = |k: i64| if k >= 0 { k } else { -1 - k };
    match wrap {
        Wrap::Repeat => Some(i.rem_euclid(n)),
        Wrap::MirroredRepeat => Some(n - 1 - mirror(i.rem_euclid(2 * n) - n)),
        Wrap::ClampToEdge => Some(i.clamp(0, n - 1)),
        Wrap::ClampToBorder => (0..n).contains(&i).then_some(i),
        Wrap::MirrorClampToEdge => Some(mirror(i).clamp(0, n - 1)),
    }
}
