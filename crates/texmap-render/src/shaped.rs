//! From what a scene says about shapes to triangles: the step before a picture that depends on the camera.

use std::borrow::Cow;

use crate::displace::displace;
use crate::{EdgeBudget, Mesh, RenderError, Scene};

impl Scene {
    /// The scene with its displaced meshes as triangles and its billboards turned, for a picture of `width` pixels from its camera. Without such meshes
    /// it is the scene itself.
    ///
    /// [`render`](crate::render) does this first. Call it yourself where meshes are read as they are: before
    /// [`Renderer::new`](crate::Renderer::new) (which refuses an unshaped scene), [`shadow_map`](crate::shadow_map),
    /// [`bake`](crate::bake) or
    /// [`planner::choose`](crate::planner::choose).
    /// What folds or cannot move is told in [`Scene::warnings`].
    ///
    /// # Errors
    /// Every fault that [`Scene::check`] finds, [`RenderError::TooManyTriangles`], and [`RenderError::Memory`] beyond the memory budget of the process.
    pub fn shaped(&self, width: u32) -> Result<Cow<'_, Self>, RenderError> {
        if !self.meshes.iter().any(Mesh::is_unshaped) {
            return Ok(Cow::Borrowed(self));
        }
        self.check()?;
        let mut scene = self.clone();
        let camera = scene.camera;
        for mesh in scene.meshes.iter_mut().filter(|m| !m.billboards.is_empty()) {
            mesh.turn_to(&camera);
            mesh.billboards.clear();
        }
        displace(&mut scene, width)?;
        Ok(Cow::Owned(scene))
    }
}

impl Mesh {
    /// Whether [`Scene::shaped`] has something to do.
    pub(crate) fn is_unshaped(&self) -> bool {
        self.displacement.is_some() || !self.billboards.is_empty()
    }

    pub(crate) fn check_shape(&self) -> Result<(), RenderError> {
        let value = |what: &str, value: String, expected| {
            Err(RenderError::Value {
                place: format!("mesh '{}'", self.name),
                what: what.to_owned(),
                value,
                expected,
            })
        };
        self.check_billboards()?;
        let Some(displacement) = &self.displacement else {
            return Ok(());
        };
        let (height, middle) = (displacement.height, displacement.middle);
        if !(height.is_finite() && middle.is_finite()) {
            return value(
                "height of the displacement",
                format!("{height} about {middle}"),
                "it must be finite",
            );
        }
        let (EdgeBudget::Texels(edge) | EdgeBudget::Pixels(edge)) = displacement.budget;
        if !(edge > 0.0 && edge.is_finite()) {
            return value(
                "longest edge of the displacement",
                edge.to_string(),
                "it must be finite and above 0",
            );
        }
        if self.uvs.is_empty() && !self.triangles.is_empty() {
            return value(
                "displacement",
                "without texture coordinates".to_owned(),
                "give the mesh uvs per vertex (`tf` faces or `vt` lines; Mesh::project_uvs)",
            );
        }
        Ok(())
    }
}
