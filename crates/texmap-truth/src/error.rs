use texmap_math::camera::CameraError;
use texmap_math::frame::FrameError;
use texmap_render::RenderError;
use thiserror::Error;

/// Reasons why a scene has no reference.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TruthError {
    /// The scene does not pass its own check.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The camera has no view.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A texture frame without area.
    #[error(transparent)]
    Frame(#[from] FrameError),
}
