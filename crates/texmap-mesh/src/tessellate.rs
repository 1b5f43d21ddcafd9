//! From what a scene says about shapes to triangles: the step before a picture that depends on the camera.

use std::borrow::Cow;

use texmap_scene::{Mesh, Scene};

use crate::MeshError;
use crate::billboard::turn_to;
use crate::displace::displace;

/// The scene with displaced meshes as triangles and billboards turned to the camera. `width` is that of the picture, in
/// pixels.
///
/// A scene without such meshes comes back as it is; one that is handed over by value is changed in place, one by reference is
/// cloned if something in it changes. Renderers, shadow maps, the baker and the planner read meshes as they are: call this first.
/// Folds and points that cannot move are told in [`Scene::warnings`].
///
/// # Errors
/// Every fault that [`Scene::check`] finds, [`MeshError::TooManyTriangles`], and [`MeshError::Memory`] beyond the memory budget of the
/// process.
pub fn tessellate<'s>(
    scene: impl Into<Cow<'s, Scene>>,
    width: u32,
) -> Result<Cow<'s, Scene>, MeshError> {
    let scene = scene.into();
    if scene.meshes.iter().all(Mesh::is_tessellated) {
        return Ok(scene);
    }
    scene.check()?;
    let mut scene = scene.into_owned();
    let camera = scene.camera;
    for mesh in scene.meshes.iter_mut().filter(|m| !m.billboards.is_empty()) {
        turn_to(mesh, &camera);
    }
    displace(&mut scene, width)?;
    Ok(Cow::Owned(scene))
}
