//! Any scene under its projectors: on, off, seen from beside, without depth maps, and the number of wrong pixels without the
//! maps.

use texmap_light::Light;
use texmap_math::glam::DVec3;
use texmap_sample::{ColorSpace, Origin, Texture2d};
use texmap_scene::{ProjectorLight, ProjectorMode, Scene, Shading};

use super::lit::{Lit, matte, wrong};
use super::sheet::sheet;
use super::{DemoPicture, stage};
use crate::LabError;
use texmap_truth::rays::{RayObject, RayScene};

/// The sheet of a scene with projectors, `size` pixels a panel. `spoiled` is the share of the picture, in percent, that is expected to
/// be wrong without their depth maps.
///
/// The count is taken with white pictures on white matte surfaces, so that it is that of points and not of colours, against hard
/// shadow rays.
///
/// # Errors
/// A size out of [`SIZES`](super::SIZES); a scene without projectors or that cannot be drawn.
pub fn projections(
    title: &str,
    scene: &Scene,
    size: u32,
    spoiled: f64,
) -> Result<DemoPicture, LabError> {
    if !super::SIZES.contains(&size) {
        return Err(LabError::PanelSize(size));
    }
    let Some(first) = scene.effects.projectors.first() else {
        return Err(LabError::Cases("the scene has no `projector`".to_owned()));
    };
    let mut dark = scene.clone();
    dark.effects.projectors.clear();
    let mut through = scene.clone();
    for projector in &mut through.effects.projectors {
        projector.shadow = None;
    }
    let mut beside = scene.clone();
    beside.camera.eye = first.position;
    let panels = panels![
        stage::photograph(&dark, size)? => "Off", "The scene without its projectors.";
        stage::photograph(scene, size)? => "On", "Beside the projector: what it does not see stays as it was.";
        stage::photograph(&beside, size)? =>
            "From the projector", "Its own eye sees the picture whole, and no shadow.";
        stage::photograph(&through, size)? => "No depth map (wrong)", "It shines through to the far side.";
    ];
    let pixels = f64::from(size * size);
    let rays = RayScene::new(scene.meshes.iter().map(RayObject::Mesh));
    let (mut with, mut without) = (0u32, 0u32);
    for projector in &scene.effects.projectors {
        with += spoils(scene, projector, projector.shadow, &rays, size)?;
        without += spoils(scene, projector, None, &rays, size)?;
    }
    let claims = claims![
        "wrong pixels, with depth maps" => f64::from(with), 0.0, 5e-4 * pixels;
        "wrong without them, % of the picture" => 100.0 * f64::from(without) / pixels, spoiled, 0.25 * spoiled;
    ];
    Ok(sheet(title, panels, claims))
}

/// Pixels that one projector lights or leaves out against the truth of rays.
fn spoils(
    scene: &Scene,
    projector: &ProjectorLight,
    shadow: Option<u32>,
    rays: &RayScene,
    size: u32,
) -> Result<u32, LabError> {
    let mut bare = scene.clone();
    bare.lights = vec![Light::Ambient { color: [0.1; 3] }];
    for material in &mut bare.materials {
        *material = texmap_scene::Material {
            shading: Shading::PerPixel,
            ..matte([0.8; 3], 0.0)
        };
    }
    let white = Texture2d::from_rgba8(1, 1, vec![255; 4], ColorSpace::Linear, Origin::TopLeft)?;
    bare.textures.push(white);
    bare.effects = Default::default();
    let off = Lit::take(&bare, size)?;
    bare.effects.projectors = vec![ProjectorLight {
        texture: bare.textures.len() - 1,
        mode: ProjectorMode::Light([1.0; 3]),
        shadow,
        ..projector.clone()
    }];
    let on = Lit::take(&bare, size)?;
    let truth = off.facing(
        0.15,
        |p| projector.position - p,
        |p, n| shone_on(projector, rays, p, n),
    );
    let lit = on.changed(&off, 1);
    Ok(wrong(&truth, &lit, size, i64::from(size / 100).max(1)))
}

fn shone_on(projector: &ProjectorLight, rays: &RayScene, p: DVec3, n: DVec3) -> bool {
    let inside = projector
        .projector
        .uv(p)
        .is_some_and(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0);
    // Above the facets, which the smooth normal may lean over.
    let scale = 1e-3 * (projector.position - p).length();
    inside && !rays.blocked(p + n * scale, projector.position)
}
