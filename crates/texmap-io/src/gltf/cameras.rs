//! The cameras of a document, and the one that is asked for.

use texmap_math::camera::{Camera, Lens};
use texmap_math::deterministic_f64::{atan, tan};
use texmap_math::glam::DVec3;

use super::json;
use super::model::Model;
use super::nodes::Tree;
use crate::{IoError, info::CameraInfo, shortened};

/// A camera that a node places.
#[derive(Debug)]
pub(super) struct Placed {
    name: String,
    /// Index of the camera and of its node.
    camera: usize,
    node: usize,
}

/// The cameras of the scene that is drawn, in the order of its nodes.
pub(super) fn cameras(model: &Model<'_>, tree: &Tree) -> Result<Vec<Placed>, IoError> {
    let nodes = &model.document.nodes;
    let placed = tree
        .drawn
        .iter()
        .filter_map(|n| Some((*n, nodes[*n].camera?)));
    let placed = placed.map(|(node, camera)| {
        let pointer = format!("/nodes/{node}/camera");
        let stated = model.item(&model.document.cameras, camera, &pointer, "camera")?;
        let name = match stated.name.as_str() {
            "" => nodes[node].name.clone(),
            name => name.to_owned(),
        };
        Ok(Placed { name, camera, node })
    });
    placed.collect()
}

/// The cameras for a report.
pub(super) fn report(model: &Model<'_>, placed: &[Placed]) -> Vec<CameraInfo> {
    let line = |p: &Placed| CameraInfo {
        name: shortened(&p.name).to_string(),
        orthographic: model.document.cameras[p.camera].orthographic.is_some(),
    };
    placed.iter().map(line).collect()
}

/// The camera of this name or number, for pictures of `aspect`.
pub(super) fn camera(
    model: &mut Model<'_>,
    tree: &Tree,
    placed: &[Placed],
    wanted: &str,
    aspect: f64,
) -> Result<Camera, IoError> {
    let names: Vec<&str> = placed.iter().map(|p| p.name.as_str()).collect();
    let Placed { camera, node, .. } = placed[model.chosen("camera", wanted, &names)?];
    let at = format!("/cameras/{camera}");
    let world = tree.world[node];
    let eye = world.w_axis.truncate();
    let forward = (-world.z_axis.truncate()).normalize_or_zero();
    let up = world.y_axis.truncate();
    let stated = &model.document.cameras[camera];
    let camera = match (&stated.perspective, &stated.orthographic) {
        (Some(perspective), _) => {
            let (fov_x, near, far) = lens(model, perspective, aspect, &at)?;
            Camera {
                eye,
                look: eye + forward,
                up,
                fov_x,
                near,
                far,
                lens: Lens::default(),
            }
        }
        (None, Some(parallel)) => {
            let width = 2.0 * parallel.xmag.abs().max(parallel.ymag.abs() * aspect);
            if !(width > 0.0) {
                return Err(model.broken(
                    &format!("{at}/orthographic"),
                    "shows nothing: xmag and ymag are 0",
                ));
            }
            // The depth buffer wants a near plane before the eye.
            let near = parallel.znear.max(1e-6 * parallel.zfar);
            if !(near > 0.0 && near < parallel.zfar) {
                return Err(model.broken(
                    &format!("{at}/orthographic"),
                    format!(
                        "znear {} and zfar {} leave no depth between them",
                        parallel.znear, parallel.zfar
                    ),
                ));
            }
            Camera {
                eye,
                look: eye + forward,
                up,
                far: parallel.zfar,
                near,
                lens: Lens {
                    parallel_width: Some(width),
                    ..Lens::default()
                },
                fov_x: 1.0,
            }
        }
        (None, None) => {
            return Err(model.broken(&at, "has neither `perspective` nor `orthographic`"));
        }
    };
    match camera.view() {
        Ok(_) => Ok(camera),
        Err(error) => Err(model.broken(
            &format!("/nodes/{node}"),
            format!("its camera cannot be used: {error}"),
        )),
    }
}

/// Horizontal angle, near and far: the whole view of the camera is in the picture, whatever its aspect.
fn lens(
    model: &Model<'_>,
    stated: &json::Perspective,
    aspect: f64,
    at: &str,
) -> Result<(f64, f64, f64), IoError> {
    let at = format!("{at}/perspective");
    if !(stated.yfov > 0.0 && stated.yfov < core::f64::consts::PI) {
        return Err(model.broken(
            &format!("{at}/yfov"),
            format!("{} is not within 0 to pi", stated.yfov),
        ));
    }
    let far = stated.zfar.unwrap_or(f64::INFINITY);
    if !(stated.znear > 0.0 && far > stated.znear) {
        return Err(model.broken(
            &at,
            format!("znear {} and zfar {far} enclose nothing", stated.znear),
        ));
    }
    let own = stated.aspect_ratio.filter(|own| *own > 0.0);
    let wide = own.map_or(aspect, |own| own.max(aspect));
    Ok((2.0 * atan(tan(0.5 * stated.yfov) * wide), stated.znear, far))
}

/// The direction along which a node looks or shines.
pub(super) fn forward(tree: &Tree, node: usize) -> DVec3 {
    (-tree.world[node].z_axis.truncate()).normalize_or_zero()
}
