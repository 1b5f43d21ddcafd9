use texmap_math::camera::CameraError;

/// Error of a scene that is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The camera has no view.
    #[error(transparent)]
    Camera(CameraError),
    /// A parallel projection of what is looked up along rays from one eye.
    #[error(
        "{what} is seen along rays from the eye, which a parallel projection does not have: use a central one"
    )]
    ParallelRays {
        /// The part of the scene.
        what: String,
    },
    /// A number of the scene that must be finite (or in a range) is not.
    #[error("{place}: {what} is {value}; {expected}")]
    Value {
        /// The mesh, material, light or setting at fault.
        place: String,
        /// Name of the number.
        what: String,
        /// The offending value, printed.
        value: String,
        /// The values that are allowed.
        expected: &'static str,
    },
    /// An index without a target.
    #[error("{place}: {what} {index} does not exist; there are {count}")]
    Index {
        /// The mesh or material at fault.
        place: String,
        /// Kind of the thing that the index names.
        what: &'static str,
        /// The offending index.
        index: u64,
        /// Number of such things: indices are below it.
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
        /// Kind of the values.
        what: &'static str,
        /// Number of values found.
        found: usize,
        /// Kind of the things that the values belong to.
        of: &'static str,
        /// Number of these things.
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
    /// A light map, or a texture that reads the second set of coordinates, on a mesh without that set.
    #[error(
        "mesh '{mesh}' has no second uv set but its material '{material}' has a light map or a texture that reads it: give it Mesh::lightmap_uvs (`lightmapuv` in a scene)"
    )]
    MissingLightMapUv {
        /// Mesh name.
        mesh: String,
        /// Material name.
        material: String,
    },
    /// A mesh that is still a description: its displacement or its billboards are not triangles yet.
    #[error(
        "mesh '{mesh}': its displacement or its billboards are not triangles yet: call texmap_mesh::tessellate first"
    )]
    NotTessellated {
        /// Mesh name.
        mesh: String,
    },
}

impl SceneError {
    /// A stable name for programs.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Camera(_) => "render-camera",
            Self::ParallelRays { .. } => "render-parallel",
            Self::Value { .. } => "render-value",
            Self::Index { .. } => "render-index",
            Self::UnknownLight { .. } => "render-unknown-light",
            Self::Count { .. } => "render-count",
            Self::MissingUv { .. } => "render-missing-uv",
            Self::MissingLightMapUv { .. } => "render-missing-light-map-uv",
            Self::NotTessellated { .. } => "render-value",
        }
    }
}
