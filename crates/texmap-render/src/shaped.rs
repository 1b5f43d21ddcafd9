//! From what a scene says about shapes to triangles: the step before a picture that depends on the camera.

use std::borrow::Cow;

use crate::displace::displace;
use crate::{Mesh, RenderError, Scene};

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
