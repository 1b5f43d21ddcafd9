use texmap_math::camera::CameraError;
use texmap_math::texture_frame::FrameError;
use texmap_mesh::MeshError;
use texmap_render::RenderError;
use texmap_scene::SceneError;
use thiserror::Error;

/// Reasons why a scene has no reference.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TruthError {
    /// The scene does not pass its own check.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh cannot be tessellated.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The frame cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The camera has no view.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The scene has what the reference does not know.
    #[error("{place}: the f64 reference knows no {what}")]
    Unsupported {
        /// Material or effect.
        place: String,
        /// Its part that is not known.
        what: &'static str,
    },
    /// A texture frame without area.
    #[error(transparent)]
    Frame(#[from] FrameError),
}
