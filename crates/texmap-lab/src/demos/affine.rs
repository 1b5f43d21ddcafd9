//! The cubes of the lecture: textured screen-linearly, correctly, and half-cured by subdivision.

use texmap_math::affine_error::max_error;
use texmap_math::glam::{DVec2, DVec3};
use texmap_raster::Interp;
use texmap_sample::Filter;
use texmap_scene::{Mesh, Scene};

use super::sheet::sheet;
use super::stage::{self, Shot};
use super::{Claim, DemoPicture, Panel, paint};
use crate::LabError;
use texmap_truth::picture::{Picture, Rgba};
use texmap_truth::strip::heat;

const DARK: Rgba = [44, 52, 74, 255];
const LIGHT: Rgba = [244, 238, 222, 255];

/// Pixels a side of the shots that figures are taken from, at least.
const MEASURED: u32 = 640;

/// Faces of the second cube are numbered from here.
const SECOND: u32 = 6;

pub(super) fn image(size: u32) -> Result<DemoPicture, LabError> {
    compare(
        "Affine against perspective: a photo on cubes",
        &paint::cow_photo(512),
        size,
    )
}

pub(super) fn checker(size: u32) -> Result<DemoPicture, LabError> {
    compare(
        "Affine against perspective: a checker on cubes",
        &paint::checker(512, 8, DARK, LIGHT),
        size,
    )
}

fn compare(title: &str, photo: &Picture, size: u32) -> Result<DemoPicture, LabError> {
    let affine = cubes(photo, [Interp::Affine; 2])?;
    let perspective = cubes(photo, [Interp::Perspective; 2])?;
    let (wrong, right) = (
        Shot::take(&affine, size.max(MEASURED))?,
        Shot::take(&perspective, size.max(MEASURED))?,
    );
    let all = |face: u32| face < 2 * SECOND;
    let mut claims = Vec::new();
    for (name, axis) in [("u", 0), ("v", 1)] {
        let measured = largest_error(&wrong, &right, axis, all);
        let expected = closed_form(&affine, axis, 1, all)?;
        claims.push(Claim::new(
            format!("largest affine error in {name}, of the texture, is |sqrt r - 1|/(sqrt r + 1) of the worst edge"),
            measured,
            expected,
            0.01 * expected,
        ));
    }
    claims.push(Claim::new(
        "largest error of the perspective image against rays, of the texture",
        against_rays(&perspective, &right)?,
        0.0,
        1e-6,
    ));
    let map = error_map(
        &Shot::take(&affine, size)?,
        &Shot::take(&perspective, size)?,
        size,
    );
    let panels = panels![
        stage::photograph(&affine, size)? =>
            "Affine",
            "u and v are linear on the screen in each triangle: straight lines break at the diagonal.";
        stage::photograph(&perspective, size)? =>
            "Perspective", "u/z, v/z and 1/z are linear on the screen; one divide a pixel gives u and v.";
        map =>
            "How far the texture slides",
            "Black: nothing. White: a quarter of the texture. It is worst along an edge.";
    ];
    Ok(sheet(title, panels, claims))
}

pub(super) fn subdivided(size: u32) -> Result<DemoPicture, LabError> {
    let photo = paint::checker(512, 8, DARK, LIGHT);
    let modes = [Interp::Affine, Interp::Subdivided(2), Interp::Perspective];
    let titles = ["Affine", "Subdivided", "Perspective"];
    let texts = [
        "Both cubes: each face is two triangles.",
        "Right cube: each face is cut into 8 triangles, affine in each. The artifact shrinks but stays.",
        "Right cube: one divide a pixel. Nothing is left to cut.",
    ];
    let second = |face: u32| face >= SECOND;
    let right = Shot::take(
        &cubes(&photo, [Interp::Perspective; 2])?,
        size.max(MEASURED),
    )?;
    let (mut panels, mut errors, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for ((mode, title), text) in modes.into_iter().zip(titles).zip(texts) {
        let scene = cubes(&photo, [Interp::Affine, mode])?;
        panels.push(Panel {
            picture: stage::photograph(&scene, size)?,
            title: title.into(),
            caption: text.into(),
        });
        errors.push(largest_error(
            &Shot::take(&scene, size.max(MEASURED))?,
            &right,
            0,
            second,
        ));
    }
    let scene = cubes(&photo, [Interp::Affine; 2])?;
    let (whole, cut) = (
        closed_form(&scene, 0, 1, second)?,
        closed_form(&scene, 0, 2, second)?,
    );
    claims.extend(claims![
        "right cube, 2 triangles a face: largest error in u" => errors[0], whole, 0.01 * whole;
        "right cube, 8 triangles a face: largest error in u" => errors[1], cut, 0.01 * cut;
        "8 triangles a face leave this part of the error (0.276 at a depth ratio of 1.5 to 0.338 at 4)" =>
            errors[1] / errors[0], cut / whole, 0.005;
        "right cube, perspective: largest error in u" => errors[2], 0.0, 0.0;
    ]);
    Ok(sheet(
        "Subdivision shrinks the error, it does not remove it",
        panels,
        claims,
    ))
}

/// Two cubes of which the left has the first and the right the second interpolation.
fn cubes(photo: &Picture, interp: [Interp; 2]) -> Result<Scene, LabError> {
    let mut scene = stage::scene(
        DVec3::new(0.0, 1.85, 3.35),
        DVec3::new(0.0, -0.25, 0.0),
        88.0,
    );
    let texture = stage::texture(&mut scene, photo)?;
    let places = [
        (DVec3::new(-1.52, 0.0, 0.0), 22.0),
        (DVec3::new(1.52, 0.0, 0.0), -38.0),
    ];
    for (index, (interp, (center, yaw))) in interp.into_iter().zip(places).enumerate() {
        let material = stage::decal(&mut scene, texture, Filter::Trilinear, interp);
        let mut mesh = stage::cube(center, yaw, material);
        mesh.faces
            .iter_mut()
            .for_each(|face| *face += SECOND * index as u32);
        scene.meshes.push(mesh);
    }
    Ok(scene)
}

/// The largest difference of u (axis 0) or v (axis 1) over the pixels of the faces that are asked for.
fn largest_error(wrong: &Shot, right: &Shot, axis: usize, of: impl Fn(u32) -> bool) -> f64 {
    let difference = |(x, y)| {
        right.face(x, y).filter(|&face| of(face))?;
        Some((wrong.uv(x, y)? - right.uv(x, y)?).abs()[axis])
    };
    right.pixels().filter_map(difference).fold(0.0, f64::max)
}

/// The largest error in closed form. Along a line of equal w the error of a triangle is linear, so its extreme
/// lies on an edge, and there it is `|du| |sqrt r - 1| / (sqrt r + 1)`. Taken over the edges of every face
/// that is turned to the eye, with each triangle cut into `parts` x `parts`.
fn closed_form(
    scene: &Scene,
    axis: usize,
    parts: u32,
    of: impl Fn(u32) -> bool,
) -> Result<f64, LabError> {
    let view = scene.camera.view()?;
    let mut most = 0.0f64;
    for mesh in &scene.meshes {
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let corners = triangle.map(|vertex| world(mesh, vertex));
            let out = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            if out.dot(scene.camera.eye - corners[0]) <= 0.0 || !of(mesh.face(index as u32)) {
                continue;
            }
            let uv = triangle.map(|vertex| coordinates(mesh, vertex)[axis]);
            let depth = corners.map(|p| -view.transform_point3(p).z);
            for (from, to) in edges(parts) {
                let at = |values: [f64; 3], b: DVec3| DVec3::from_array(values).dot(b);
                let ratio = at(depth, to) / at(depth, from);
                most = most.max((at(uv, to) - at(uv, from)).abs() * max_error(ratio));
            }
        }
    }
    Ok(most)
}

/// Ends, in barycentrics, of all edges of a triangle cut into `parts` x `parts` triangles.
fn edges(parts: u32) -> Vec<(DVec3, DVec3)> {
    let point = |i: u32, j: u32| {
        DVec3::new(f64::from(i), f64::from(j), f64::from(parts - i - j)) / f64::from(parts)
    };
    let mut edges = Vec::new();
    for i in 0..parts {
        for j in 0..parts - i {
            let (a, b, c) = (point(i, j), point(i + 1, j), point(i, j + 1));
            edges.extend([(a, b), (b, c), (c, a)]);
        }
    }
    edges
}

/// The largest distance of the coordinates of a shot from those that rays find.
fn against_rays(scene: &Scene, shot: &Shot) -> Result<f64, LabError> {
    let size = shot.size();
    let mut triangles = Vec::new();
    let mut uvs = Vec::new();
    for mesh in &scene.meshes {
        for triangle in &mesh.triangles {
            triangles.push(triangle.map(|vertex| world(mesh, vertex)));
            uvs.push(triangle.map(|vertex| coordinates(mesh, vertex)));
        }
    }
    let pinhole = texmap_truth::caster::Pinhole::of_camera(&scene.camera, size, size)?;
    let caster = texmap_truth::caster::Caster::new(pinhole, size, size, &triangles);
    let mut most = 0.0f64;
    for (x, y) in shot.pixels() {
        let hit = caster.nearest(f64::from(x) + 0.5, f64::from(y) + 0.5, false);
        let (Some(hit), Some(uv)) = (hit, shot.uv(x, y)) else {
            continue;
        };
        let at = uvs[hit.triangle as usize];
        let truth = DVec2::new(
            hit.attribute(at.map(|c| c.x)),
            hit.attribute(at.map(|c| c.y)),
        );
        // Snapped vertices may give a rim pixel to the neighbouring face: compare the faces' inside.
        if hit.weights.min_element() > 0.01 {
            most = most.max((uv - truth).abs().max_element());
        }
    }
    Ok(most)
}

fn world(mesh: &Mesh, vertex: u32) -> DVec3 {
    let [x, y, z] = mesh.positions[vertex as usize].map(f64::from);
    mesh.world_from_object.transform_point3(DVec3::new(x, y, z))
}

fn coordinates(mesh: &Mesh, vertex: u32) -> DVec2 {
    let [u, v] = mesh.uvs[vertex as usize].map(f64::from);
    DVec2::new(u, v)
}

/// Heat of the distance between two shots' coordinates, a quarter of the texture being white.
fn error_map(wrong: &Shot, right: &Shot, size: u32) -> Picture {
    let mut map = Picture::new(size, size, [70, 74, 82, 255]);
    for (x, y) in right.pixels() {
        if let (Some(a), Some(b)) = (wrong.uv(x, y), right.uv(x, y)) {
            map.set(i64::from(x), i64::from(y), heat((a - b).length() * 4.0));
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_triangle_has_its_edges() {
        assert_eq!(edges(1).len(), 3);
        assert_eq!(edges(2).len(), 9);
        assert!(
            edges(3)
                .iter()
                .all(|(a, b)| ((*a - *b).length() - 2f64.sqrt() / 3.0).abs() < 1e-15)
        );
    }
}
