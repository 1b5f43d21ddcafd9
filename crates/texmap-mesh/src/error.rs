use texmap_math::OverBudget;
use texmap_scene::SceneError;

/// Error of a mesh that was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A fault of the scene, or of a mesh, a skin or a map of heights.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A displaced mesh or a terrain that would have too many triangles.
    #[error(
        "mesh '{mesh}': its displacement needs more than {limit} triangles ({triangles} and counting): allow longer edges (texels or pixels), take a smaller map, or raise the limit"
    )]
    TooManyTriangles {
        /// The terrain or the first displaced mesh.
        mesh: String,
        /// Number of triangles at which the work was given up.
        triangles: u64,
        /// The number allowed.
        limit: u32,
    },
    /// A buffer beyond the memory budget.
    #[error("{0}")]
    Memory(#[from] OverBudget),
}

impl MeshError {
    /// A stable name for programs.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Scene(error) => error.code(),
            Self::TooManyTriangles { .. } => "render-too-many-triangles",
            Self::Memory(_) => "over-memory-budget",
        }
    }
}
