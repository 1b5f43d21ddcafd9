use texmap_light::LightError;
use texmap_math::camera::CameraError;
use texmap_math::homography::HomographyError;
use texmap_math::texture_frame::FrameError;
use texmap_mesh::MeshError;
use texmap_raster::RasterError;
use texmap_render::RenderError;
use texmap_sample::SampleError;
use texmap_scene::SceneError;
use texmap_uv::UvError;
use thiserror::Error;

/// Error of a demo, a case or a chart.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LabError {
    /// No demo has this name.
    #[error("unknown demo '{0}': choose from {names}", names = crate::demos::names())]
    UnknownDemo(String),
    /// A panel that is too small to show anything, or too large.
    #[error("a demo panel of {0} pixels: choose {low} to {high}", low = crate::demos::SIZES.start(), high = crate::demos::SIZES.end())]
    PanelSize(u32),
    /// No case has this id.
    #[error("no runner for the case '{0}'")]
    UnknownCase(String),
    /// The file of cases does not fit the schema.
    #[error("cases: {0}")]
    Cases(String),
    /// A scene with a fault.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh that could not be made.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The renderer refused a scene.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The rasterizer refused a draw.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The sampler refused a texture.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// The camera has no view.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// Four points that are no quad.
    #[error(transparent)]
    Homography(#[from] HomographyError),
    /// A texture frame without area.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The uv mapper refused a mesh.
    #[error(transparent)]
    Uv(#[from] UvError),
    /// A look-up of light refused its tables.
    #[error(transparent)]
    Light(#[from] LightError),
    /// A chart could not be drawn or a picture not encoded.
    #[error("chart: {0}")]
    Chart(String),
}
