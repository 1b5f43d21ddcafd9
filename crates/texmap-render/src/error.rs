use texmap_math::OverBudget;
use texmap_math::camera::CameraError;
use texmap_raster::RasterError;

use crate::Scene;

/// Why a scene was not drawn. Everything is checked before the first pixel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
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
    /// No thread, or the system gave none.
    #[error("cannot run on {threads} threads: {reason}")]
    Threads {
        /// The number asked for.
        threads: usize,
        /// What stood in the way.
        reason: String,
    },
    /// The camera has no view.
    #[error("camera: {0}")]
    Camera(CameraError),
    /// A number of the scene that must be finite (or in a range) is not.
    #[error("{place}: {what} is {value}; {expected}")]
    Value {
        /// Which mesh, material, light or setting.
        place: String,
        /// Which of its numbers.
        what: String,
        /// The offending value, printed.
        value: String,
        /// What would do.
        expected: &'static str,
    },
    /// An index without a target.
    #[error("{place}: {what} {index} does not exist; there are {count}")]
    Index {
        /// Which mesh or material.
        place: String,
        /// What is named by the index.
        what: &'static str,
        /// The offending index.
        index: u64,
        /// How many there are: indices are below it.
        count: usize,
    },
    /// A name that no light has.
    #[error("no light is called '{name}'; there {known}")]
    UnknownLight {
        /// The name that was asked for.
        name: String,
        /// The lights that have names, in words.
        known: String,
    },
    /// Per-vertex or per-triangle values that do not match in number.
    #[error("mesh '{mesh}': {found} {what} for {expected} {of}; give one each or none")]
    Count {
        /// Mesh name.
        mesh: String,
        /// Which values.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// What they belong to.
        of: &'static str,
        /// How many of these there are.
        expected: usize,
    },
    /// A textured material on a mesh without coordinates.
    #[error(
        "mesh '{mesh}' has no texture coordinates but its material '{material}' has a texture: give it uvs, or project them (Mesh::project_uvs)"
    )]
    MissingUv {
        /// Mesh name.
        mesh: String,
        /// Material name.
        material: String,
    },
    /// A light map on a mesh without the coordinates for it.
    #[error(
        "mesh '{mesh}' has no second uv set but its material '{material}' has a light map: give it Mesh::lightmap_uvs (`lightmapuv` in a scene)"
    )]
    MissingLightMapUv {
        /// Mesh name.
        mesh: String,
        /// Material name.
        material: String,
    },
    /// A displaced mesh that would become too fine.
    #[error(
        "mesh '{mesh}': its displacement needs more than {limit} triangles ({triangles} and counting): allow longer edges (texels or pixels), take a smaller map, or raise the limit"
    )]
    TooManyTriangles {
        /// The first displaced mesh.
        mesh: String,
        /// When it was given up.
        triangles: u64,
        /// The number allowed.
        limit: u32,
    },
    /// The rasterizer refused a draw.
    #[error("mesh '{mesh}': {error}")]
    Raster {
        /// Mesh name, or a word for the whole frame.
        mesh: String,
        /// What it said.
        error: RasterError,
    },
    /// A buffer beyond the memory budget.
    #[error("{0}")]
    Memory(#[from] OverBudget),
}

impl RenderError {
    /// Names the mesh behind the rasterizer's number of a draw.
    pub(crate) fn of_raster(scene: &Scene, error: RasterError) -> Self {
        let draw = match error {
            RasterError::Memory(refused) => return Self::Memory(refused),
            RasterError::IndexOutOfRange { draw, .. }
            | RasterError::AttributeLength { draw, .. }
            | RasterError::TooManyAttributes { draw, .. }
            | RasterError::Parts { draw, .. }
            | RasterError::ZeroSpan { draw }
            | RasterError::Tolerance { draw, .. } => Some(draw),
            _ => None,
        };
        let first = usize::from(scene.effects.backdrop.is_some());
        let mesh = draw
            .and_then(|draw| draw.checked_sub(first))
            .and_then(|draw| scene.meshes.get(draw))
            .map_or_else(|| "(all)".to_owned(), |mesh| mesh.name.clone());
        Self::Raster { mesh, error }
    }

    /// A stable name for programs.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Size { .. } => "render-size",
            Self::Threads { .. } => "render-threads",
            Self::Camera(_) => "render-camera",
            Self::Value { .. } => "render-value",
            Self::Index { .. } => "render-index",
            Self::UnknownLight { .. } => "render-unknown-light",
            Self::Count { .. } => "render-count",
            Self::MissingUv { .. } => "render-missing-uv",
            Self::MissingLightMapUv { .. } => "render-missing-light-map-uv",
            Self::TooManyTriangles { .. } => "render-too-many-triangles",
            Self::Raster { .. } => "render-raster",
            Self::Memory(_) => "over-memory-budget",
        }
    }
}
