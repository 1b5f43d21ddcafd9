use texmap_math::OverBudget;
use texmap_raster::RasterError;
use texmap_scene::{Scene, SceneError};

/// Reasons for which a scene is not drawn. Everything but cancelling is checked before the first pixel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A fault of the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture of no or too many pixels.
    #[error(
        "a picture of {width} x {height} pixels at {supersample} x {supersample} samples: each side times the samples must be 1..=16384"
    )]
    Size {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// Samples per pixel and axis.
        supersample: u32,
    },
    /// A band of no rows of tiles, or beyond the picture.
    #[error(
        "settings: tile_rows is {start}..{end}; the picture has {tiles} rows of tiles, and a band has at least one of them"
    )]
    TileRows {
        /// First row of tiles.
        start: u32,
        /// The row of tiles behind the last.
        end: u32,
        /// Rows of tiles of the picture.
        tiles: u32,
    },
    /// A number of samples per pixel that is not supported.
    #[error("settings: msaa is {samples}; give 1, or 4 without supersampling")]
    Samples {
        /// Samples of coverage and depth per pixel that were asked for.
        samples: u32,
    },
    /// No thread, or the system gave none.
    #[error("cannot run on {threads} threads: {reason}")]
    Threads {
        /// The number asked for.
        threads: usize,
        /// Reason of the system.
        reason: String,
    },
    /// The rasterizer refused a draw.
    #[error("mesh '{mesh}': {error}")]
    Raster {
        /// Mesh name, or a word for the whole frame.
        mesh: String,
        /// Error of the rasterizer.
        error: RasterError,
    },
    /// A buffer beyond the memory budget.
    #[error("{0}")]
    Memory(#[from] OverBudget),
    /// The progress callback ended the work.
    #[error("cancelled")]
    Cancelled,
}

impl RenderError {
    /// Names the mesh behind the rasterizer's number of a draw.
    pub(crate) fn of_raster(scene: &Scene, error: RasterError) -> Self {
        let draw = match error {
            RasterError::Memory(refused) => return Self::Memory(refused),
            RasterError::Cancelled => return Self::Cancelled,
            RasterError::IndexOutOfRange { draw, .. }
            | RasterError::AttributeLength { draw, .. }
            | RasterError::TooManyAttributes { draw, .. }
            | RasterError::Parts { draw, .. }
            | RasterError::ZeroSpan { draw }
            | RasterError::Tolerance { draw, .. } => Some(draw),
            _ => None,
        };
        let first = usize::from(scene.effects.background.is_some());
        let mesh = draw
            .and_then(|draw| draw.checked_sub(first))
            .and_then(|draw| scene.drawing_order().get(draw).copied())
            .and_then(|draw| scene.meshes.get(draw.mesh))
            .map_or_else(|| "(all)".to_owned(), |mesh| mesh.name.clone());
        Self::Raster { mesh, error }
    }

    /// A stable name for programs.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Scene(error) => error.code(),
            Self::Samples { .. } | Self::TileRows { .. } => "render-value",
            Self::Size { .. } => "render-size",
            Self::Threads { .. } => "render-threads",
            Self::Raster { .. } => "render-raster",
            Self::Memory(_) => "over-memory-budget",
            Self::Cancelled => "cancelled",
        }
    }
}
