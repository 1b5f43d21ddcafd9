use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use texmap_math::{Level, MemoryBudget};
use texmap_raster::{Interp, TILE, TargetSize};
use texmap_sample::{Filter, Wrap};
use texmap_scene::{Scene, SceneError};

use crate::{EnvironmentShadows, RenderError};

/// Settings of a rendering. No setting but the size, `supersample`, `msaa` and the three overrides changes
/// a pixel; `tile_rows` leaves pixels out.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    /// Pixels, 1..=16384.
    pub width: u32,
    /// Pixels, 1..=16384.
    pub height: u32,
    /// Worker threads; `None` takes rayon's global pool.
    pub threads: Option<usize>,
    /// Samples per pixel and axis, from 1: `n x n` samples, averaged in linear light. Width and height
    /// times this must not exceed 16384.
    pub supersample: u32,
    /// Samples of coverage and depth per pixel: 1, or 4 at the standard sample positions of Vulkan 1.4. The colour of each triangle
    /// is computed once a pixel, at its centre; averaged in linear light. Not together with `supersample`.
    pub msaa: u32,
    /// Buffers that are returned beside the colour.
    pub aovs: Vec<Aov>,
    /// The band of the picture that is drawn: rows of tiles of 64 x 64 pixels, counted from the top, not empty and at most
    /// `height.div_ceil(64)`. The frame holds the rows of pixels of the band alone, the same bytes as in the whole picture. `None`: all.
    pub tile_rows: Option<Range<u32>>,
    /// SIMD level; the pixels do not depend on it.
    pub level: Level,
    /// Replaces the filter of every sampler.
    pub filter: Option<Filter>,
    /// Replaces both wrap modes of every sampler.
    pub wrap: Option<Wrap>,
    /// Replaces the interpolation of every material.
    pub interp: Option<Interp>,
    /// Asked for the frame, the shadow maps and the mip chains before they are allocated.
    pub memory: MemoryBudget,
    /// Shadow maps that an [earlier picture](crate::Renderer::environment_shadows) has of a scene that differs from this one by its camera
    /// alone, which are not drawn again. Those of another light or of other bounds are not read.
    pub environment_shadows: Option<EnvironmentShadows>,
}

impl RenderSettings {
    /// One sample a pixel, the best SIMD level of this machine, no AOV, nothing overridden, the memory budget of the process.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            threads: None,
            supersample: 1,
            msaa: 1,
            aovs: Vec::new(),
            tile_rows: None,
            level: Level::new(),
            filter: None,
            wrap: None,
            interp: None,
            memory: MemoryBudget::of_process(),
            environment_shadows: None,
        }
    }
}

impl RenderSettings {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let side_fits = |side: u32| {
            (1..=u64::from(TargetSize::MAX))
                .contains(&(u64::from(side) * u64::from(self.supersample)))
        };
        if !side_fits(self.width) || !side_fits(self.height) {
            let (width, height, supersample) = (self.width, self.height, self.supersample);
            return Err(RenderError::Size {
                width,
                height,
                supersample,
            });
        }
        if !(self.msaa == 1 || (self.msaa == 4 && self.supersample == 1)) {
            return Err(RenderError::Samples { samples: self.msaa });
        }
        let tiles = self.height.div_ceil(TILE);
        if let Some(rows) = &self.tile_rows
            && (rows.is_empty() || rows.end > tiles)
        {
            return Err(RenderError::TileRows {
                start: rows.start,
                end: rows.end,
                tiles,
            });
        }
        if self.threads == Some(0) {
            return Err(RenderError::Threads {
                threads: 0,
                reason: "give at least 1".to_owned(),
            });
        }
        Ok(())
    }

    /// The rows of tiles that are drawn.
    pub(crate) fn rows_of_tiles(&self) -> Range<u32> {
        let all = 0..self.height.div_ceil(TILE);
        self.tile_rows.clone().unwrap_or(all)
    }

    /// Height of the frame in pixels: that of the picture, or of its band.
    pub(crate) fn frame_height(&self) -> u32 {
        let rows = self.rows_of_tiles();
        self.height.min(rows.end * TILE) - rows.start * TILE
    }
}

/// A buffer beside the colour. Each but [`Color`](Self::Color) describes the nearest opaque or cut-out surface at the centre of the
/// pixel, whatever the samples of the picture; blended surfaces are left out. If there is no surface, or the surface
/// lacks the value, every channel is the f32 with bits 0x7fc00000 (NaN), or `u32::MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Aov {
    /// The depth buffer: 1 at the near plane, falling to 0 at the far plane or infinity. 1 channel, f32.
    Depth,
    /// 1 / clip w, which is 1 / distance along the view axis. 1 channel, f32.
    InvW,
    /// Texture coordinates as interpolated: the file's own values, neither transformed nor wrapped.
    /// 2 channels, f32.
    Uv,
    /// Level of detail of the base colour's look-up after bias and clamp. 1 channel, f32.
    Lod,
    /// Source face, [`Mesh::face`](texmap_scene::Mesh::face). 1 channel, u32.
    Face,
    /// Index of the mesh in [`Scene::meshes`]. 1 channel, u32.
    Mesh,
    /// Unit normal in world space, on the side that is seen. 3 channels, f32.
    Normal,
    /// Position in world space. 3 channels, f32.
    Position,
    /// Visibility of a light (its number in the scene, 0 to 15) by its shadows, 0..=1. A hole where the light has no shadow or the
    /// surface is not lit per pixel. 1 channel, f32.
    Shadow(u8),
    /// The picture itself before it is encoded: red, green, blue and alpha as linear light (raw values under
    /// [`ColorMode::Raw`](texmap_scene::ColorMode::Raw)), premultiplied, blended surfaces and background in it, the mean of a pixel's samples. Light above 1 is clipped unless the tone mapping
    /// is [`ToneMap::Unclipped`](texmap_light::ToneMap::Unclipped). No holes. 4 channels, f32.
    Color,
}

/// Names of [`Aov::Shadow`].
const SHADOWS: [&str; 16] = [
    "shadow:0",
    "shadow:1",
    "shadow:2",
    "shadow:3",
    "shadow:4",
    "shadow:5",
    "shadow:6",
    "shadow:7",
    "shadow:8",
    "shadow:9",
    "shadow:10",
    "shadow:11",
    "shadow:12",
    "shadow:13",
    "shadow:14",
    "shadow:15",
];

impl Aov {
    /// The values of a surface: all but the shadows, which belong to lights, the ids of meshes, and the picture itself.
    pub const ALL: [Self; 7] = [
        Self::Depth,
        Self::InvW,
        Self::Uv,
        Self::Lod,
        Self::Face,
        Self::Normal,
        Self::Position,
    ];

    /// The buffer of the shadow of a light, by the light's name.
    ///
    /// # Errors
    /// [`SceneError::UnknownLight`] lists the names that there are; [`SceneError::Index`] for a light beyond number 255.
    pub fn shadow_of(scene: &Scene, light: &str) -> Result<Self, SceneError> {
        let index = scene.light_named(light)?;
        u8::try_from(index)
            .map(Self::Shadow)
            .map_err(|_| SceneError::Index {
                place: format!("light '{light}'"),
                what: "shadow AOV",
                index: index as u64,
                count: 256,
            })
    }

    /// The name in files and flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::InvW => "inv_w",
            Self::Uv => "uv",
            Self::Lod => "lod",
            Self::Face => "face",
            Self::Mesh => "mesh",
            Self::Color => "color",
            Self::Normal => "normal",
            Self::Position => "position",
            Self::Shadow(light) => SHADOWS.get(usize::from(light)).copied().unwrap_or("shadow"),
        }
    }

    /// Values per pixel.
    #[must_use]
    pub fn channels(self) -> usize {
        match self {
            Self::Depth | Self::InvW | Self::Lod | Self::Face | Self::Mesh | Self::Shadow(_) => 1,
            Self::Uv => 2,
            Self::Normal | Self::Position => 3,
            Self::Color => 4,
        }
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Aov {
    type Err = UnknownAov;

    fn from_str(s: &str) -> Result<Self, UnknownAov> {
        Self::ALL
            .into_iter()
            .chain([Self::Mesh, Self::Color])
            .chain((0..16).map(Self::Shadow))
            .find(|aov| aov.name() == s)
            .ok_or_else(|| UnknownAov(s.to_owned()))
    }
}

/// A name that is not an AOV's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown AOV '{0}': choose from depth, inv_w, uv, lod, face, mesh, normal, position, color, shadow:LIGHT (its number from 0, or its name)"
)]
pub struct UnknownAov(pub String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        let others = [Aov::Mesh, Aov::Color]
            .into_iter()
            .chain((0..16).map(Aov::Shadow));
        for aov in Aov::ALL.into_iter().chain(others) {
            assert_eq!(aov.name().parse(), Ok(aov));
        }
        assert_eq!("uvw".parse::<Aov>(), Err(UnknownAov("uvw".into())));
    }
}
