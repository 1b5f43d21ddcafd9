//! Gouraud shading as wrong interpolation: the seam at a T-junction and the pop of a level-of-detail switch.

use texmap_math::glam::DVec3;
use texmap_math::interpolation;
use texmap_scene::{ColorMode, Mesh, Scene, VertexColorInterp};

use super::DemoPicture;
use super::sheet::sheet;
use super::stage::{self, Shot};
use crate::LabError;
use texmap_truth::picture::{Picture, Rgba};
use texmap_truth::strip::heat;

/// Colour at the near and at the far edge of the floor, raw values. Green runs over the whole range and is
/// the channel that figures are taken from.
const NEAR: [f32; 3] = [0.10, 0.0, 0.35];
const FAR: [f32; 3] = [1.0, 1.0, 0.45];
const GREEN: usize = 1;

const WIRE: Rgba = [255, 255, 255, 255];
const GRAY: Rgba = [70, 74, 82, 255];

/// Pixels a side of the shots that figures are taken from, at least.
const MEASURED: u32 = 640;

/// Half a code value of each of the two pixels compared, and half a row of the slope between them.
const TOLERANCE: f64 = 0.008;

pub(super) fn tjoint(size: u32) -> Result<DemoPicture, LabError> {
    let linear = floor(VertexColorInterp::ScreenLinear, [1, 2])?;
    let right = floor(VertexColorInterp::Perspective, [1, 2])?;
    let ratio = depth_ratio(&linear)?;
    let expected = ((1.0 - ratio) / (2.0 * (1.0 + ratio))).abs();
    let side = size.max(MEASURED) & !1;
    let seam = seam_at_joint(&linear, side)?;
    let cured = seam_at_joint(&right, side)?;
    let claims = claims![
        "step of colour across the T-joint is |(1 - r)/(2(1 + r))|, r the depth ratio" =>
            seam, expected, TOLERANCE;
        "the same step with colours linear on the surface" => cured, 0.0, TOLERANCE;
    ];
    let picture = stage::photograph(&linear, size)?;
    let mut mesh = picture.clone();
    outline(&mut mesh, &linear, size)?;
    let joint = project(&linear, joint(), size)?;
    let mut zoom = Picture::new(size, size, GRAY);
    let reach = i64::from(size / 16).max(4);
    let region = [joint.0 - reach, joint.1 - reach, 2 * reach, 2 * reach];
    zoom.blit_zoomed(
        0,
        0,
        &Shot::take(&linear, size)?.picture,
        region,
        size / (2 * reach as u32),
    );
    let panels = panels![
        mesh =>
            "The mesh",
            "Left one quad, right two: a vertex of the right lies in the middle of the left's edge.";
        picture =>
            "Screen-linear Gouraud",
            "The colours are one ramp on the floor, yet the left half is wrong: a seam.";
        zoom =>
            "At the joint", "The right quads have the true colour here, the left one that of another depth.";
        stage::photograph(&right, size)? =>
            "Perspective Gouraud", "Colours premultiplied by 1/w: the seam is gone.";
    ];
    Ok(sheet(
        "Gouraud shading: the seam at a T-joint",
        panels,
        claims,
    ))
}

pub(super) fn lod(size: u32) -> Result<DemoPicture, LabError> {
    let coarse = floor(VertexColorInterp::ScreenLinear, [1, 1])?;
    let fine = floor(VertexColorInterp::ScreenLinear, [4, 4])?;
    let side = size.max(MEASURED);
    let (a, b) = (Shot::take(&coarse, side)?, Shot::take(&fine, side)?);
    let (pa, pb) = (
        Shot::take(&floor(VertexColorInterp::Perspective, [1, 1])?, side)?,
        Shot::take(&floor(VertexColorInterp::Perspective, [4, 4])?, side)?,
    );
    // Colour depends on depth alone and a row of the picture has one depth, so the pop is that of a span:
    // two broken lines, farthest apart at a vertex of the fine mesh, where the fine colour is right.
    let ratio = depth_ratio(&coarse)?;
    let pop = (1..4)
        .map(|k| f64::from(k) / 4.0)
        .map(|s| (s - interpolation::screen_from_world_z(s, 1.0, ratio)).abs())
        .fold(0.0, f64::max);
    let claims = claims![
        "largest pop of the colour at the switch is max |s - t(s)| at the new vertices" =>
            largest_step(&a, &b), pop, TOLERANCE;
        "largest pop with colours linear on the surface" => largest_step(&pa, &pb), 0.0, 1.0 / 255.0;
    ];
    let (small_a, small_b) = (Shot::take(&coarse, size)?, Shot::take(&fine, size)?);
    let mut map = Picture::new(size, size, GRAY);
    for (x, y) in small_a
        .pixels()
        .filter(|&(x, y)| small_a.face(x, y).is_some())
    {
        map.set(
            i64::from(x),
            i64::from(y),
            heat(step(&small_a, &small_b, x, y) * 2.0),
        );
    }
    let with_wires = |scene: &Scene| -> Result<Picture, LabError> {
        let mut picture = stage::photograph(scene, size)?;
        outline(&mut picture, scene, size)?;
        Ok(picture)
    };
    let panels = panels![
        with_wires(&coarse)? => "Coarse level of detail", "One quad deep, colours linear on the screen.";
        with_wires(&fine)? =>
            "Fine level of detail", "Four quads deep, the same ramp: the whole floor changes its colour.";
        map => "What pops at the switch", "Black: nothing. White: half of the whole ramp.";
        stage::photograph(&floor(VertexColorInterp::Perspective, [1, 1])?, size)? =>
            "Perspective Gouraud", "Coarse and fine are the same picture: no pop.";
    ];
    Ok(sheet(
        "Gouraud shading: the pop of a level-of-detail switch",
        panels,
        claims,
    ))
}

const LEFT: f64 = -1.35;
const NEAR_Z: f64 = -1.6;
const FAR_Z: f64 = -7.0;

/// A floor from the near to the far edge whose left and right halves have `parts` quads in depth (and, when
/// both have the same number, as many across).
fn floor(gouraud: VertexColorInterp, parts: [u32; 2]) -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 2.1, 0.0), DVec3::new(0.0, 0.1, -3.2), 62.0);
    scene.color = ColorMode::Raw;
    let material = stage::vertex_colors(&mut scene, gouraud);
    for (half, parts) in parts.into_iter().enumerate() {
        let (left, right) = if half == 0 { (LEFT, 0.0) } else { (0.0, -LEFT) };
        let across = if parts > 2 { parts / 2 } else { 1 };
        let mut mesh = Mesh {
            material,
            ..Mesh::default()
        };
        for row in 0..=parts {
            let s = f64::from(row) / f64::from(parts);
            for column in 0..=across {
                let x = left + (right - left) * f64::from(column) / f64::from(across);
                let z = NEAR_Z * (1.0 - s) + FAR_Z * s;
                mesh.positions
                    .push(DVec3::new(x, 0.0, z).as_vec3().to_array());
                mesh.colors
                    .push([0, 1, 2].map(|c| NEAR[c] * (1.0 - s as f32) + FAR[c] * s as f32));
            }
        }
        for row in 0..parts {
            for column in 0..across {
                let a = row * (across + 1) + column;
                let far = a + across + 1;
                mesh.triangles
                    .extend([[a, a + 1, far + 1], [a, far + 1, far]]);
                mesh.faces.extend([row * across + column; 2]);
            }
        }
        scene.meshes.push(mesh);
    }
    Ok(scene)
}

/// Position of the right half's vertex on the edge of the left.
fn joint() -> DVec3 {
    DVec3::new(0.0, 0.0, 0.5 * (NEAR_Z + FAR_Z))
}

/// Distance of the far edge over that of the near edge, along the line of sight.
fn depth_ratio(scene: &Scene) -> Result<f64, LabError> {
    let view = scene.camera.view()?;
    let depth = |z: f64| -view.transform_point3(DVec3::new(0.0, 0.0, z)).z;
    Ok(depth(FAR_Z) / depth(NEAR_Z))
}

/// Difference of the green of the two pixels left and right of the joint. `size` is even, so that the seam
/// runs between two columns.
fn seam_at_joint(scene: &Scene, size: u32) -> Result<f64, LabError> {
    let picture = Shot::take(scene, size)?.picture;
    let (column, row) = (i64::from(size / 2), project(scene, joint(), size)?.1);
    let green = |x: i64| f64::from(picture.get(x, row)[GREEN]) / 255.0;
    Ok((green(column - 1) - green(column)).abs())
}

fn step(a: &Shot, b: &Shot, x: u32, y: u32) -> f64 {
    let green =
        |shot: &Shot| f64::from(shot.picture.get(i64::from(x), i64::from(y))[GREEN]) / 255.0;
    (green(a) - green(b)).abs()
}

fn largest_step(a: &Shot, b: &Shot) -> f64 {
    a.pixels()
        .map(|(x, y)| step(a, b, x, y))
        .fold(0.0, f64::max)
}

/// The pixel that shows a point in front of the eye.
fn project(scene: &Scene, point: DVec3, size: u32) -> Result<(i64, i64), LabError> {
    let clip = scene.camera.clip_from_world(1.0)? * point.extend(1.0);
    let half = 0.5 * f64::from(size);
    Ok((
        (half * (1.0 + clip.x / clip.w)).floor() as i64,
        (half * (1.0 - clip.y / clip.w)).floor() as i64,
    ))
}

/// Draws the edges of all quads.
fn outline(picture: &mut Picture, scene: &Scene, size: u32) -> Result<(), LabError> {
    for mesh in &scene.meshes {
        let corner = |vertex: u32| {
            let [x, y, z] = mesh.positions[vertex as usize].map(f64::from);
            project(scene, DVec3::new(x, y, z), size)
        };
        for quad in mesh.triangles.chunks(2) {
            let ring = [quad[0][0], quad[0][1], quad[0][2], quad[1][2]];
            for side in 0..4 {
                picture.line(corner(ring[side])?, corner(ring[(side + 1) % 4])?, WIRE);
            }
        }
    }
    Ok(())
}
