//! The O-U-V frame of Brackeen (2003, chapter 8): one point and two vectors that put a texture on a polygon.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::texture_frame::TextureFrame;
use texmap_raster::Interp;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{Mesh, Scene};

use super::sheet::sheet;
use super::stage::{self, Shot};
use super::{DemoPicture, Panel, paint};
use crate::LabError;
use texmap_truth::picture::{Picture, Rgba};

/// Turn of the second panel and tilt of the fourth out of the plane, in degrees.
const TURN: f64 = 30.0;
const TILT: f64 = 25.0;
/// Shift of O in the third panel, in units of U and V.
const SHIFT: DVec2 = DVec2::new(0.5, 0.25);

/// Length of U and V.
const REACH: f64 = 1.7;

/// Corners of the polygon, all in one plane.
const POLYGON: [(f64, f64); 6] = [
    (-1.6, -1.15),
    (1.2, -1.35),
    (1.75, 0.1),
    (1.1, 1.3),
    (-0.6, 1.45),
    (-1.75, 0.5),
];

/// Pixels a side of the shots that figures are taken from, at least.
const MEASURED: u32 = 512;

pub(super) fn frame(size: u32) -> Result<DemoPicture, LabError> {
    let (right, down, out) = plane();
    let o = -right - down;
    let (right, down, out) = (right * REACH, down * REACH, out * REACH);
    let (sin, cos) = deterministic_f64::sin_cos(TURN.to_radians());
    let (sin_tilt, cos_tilt) = deterministic_f64::sin_cos(TILT.to_radians());
    let along = TextureFrame::new(o, right, down)?;
    let turned = TextureFrame::new(o, right * cos + down * sin, down * cos - right * sin)?;
    let shifted = TextureFrame::new(along.point(SHIFT), right, down)?;
    let tilted = TextureFrame::new(o, right, down * cos_tilt + out * sin_tilt)?;

    let side = size.max(MEASURED);
    let shot = |frame: TextureFrame| Shot::take(&scene(Some(frame))?, side);
    let (straight, round, moved, leaning) =
        (shot(along)?, shot(turned)?, shot(shifted)?, shot(tilted)?);
    let by_vertices = Shot::take(&scene(None)?, side)?;
    let largest = |a: &Shot, b: &dyn Fn(u32, u32) -> Option<DVec2>| {
        let distance = |(x, y)| Some((a.uv(x, y)? - b(x, y)?).abs().max_element());
        a.pixels().filter_map(distance).fold(0.0, f64::max)
    };
    // In the turned frame a point has its coordinates turned back.
    let turn_back = |uv: DVec2| DVec2::new(uv.x * cos + uv.y * sin, uv.y * cos - uv.x * sin);
    let scene_tilted = scene(Some(tilted))?;
    let camera = scene_tilted.camera;
    let on_frame_plane = |x: u32, y: u32| {
        let ray = camera
            .ray(side, side, f64::from(x) + 0.5, f64::from(y) + 0.5)
            .ok()?;
        let t = (tilted.o - camera.eye).dot(tilted.normal()) / ray.dot(tilted.normal());
        Some(tilted.uv(camera.eye + ray * t))
    };
    let tilt = scene_tilted.meshes[0]
        .frame_tilt()
        .map_or(f64::NAN, f64::to_degrees);
    let claims = claims![
        "aligned: A.W/C.W and B.W/C.W against uv interpolated from the vertices" =>
            largest(&straight, &|x, y| by_vertices.uv(x, y)), 0.0, 1e-6;
        "turned: coordinates against the aligned ones turned back" =>
            largest(&round, &|x, y| straight.uv(x, y).map(turn_back)), 0.0, 1e-6;
        "shifted: coordinates against the aligned ones less (0.5, 0.25)" =>
            largest(&moved, &|x, y| straight.uv(x, y).map(|uv| uv - SHIFT)), 0.0, 1e-6;
        "out of plane: coordinates against those where the ray meets the frame's own plane" =>
            largest(&leaning, &on_frame_plane), 0.0, 1e-5;
        "out of plane: angle of the frame to the polygon that the warning names, in degrees" =>
            tilt, TILT, 1e-3;
    ];
    let mut panels = Vec::new();
    for (frame, title, caption) in [
        (
            along,
            "Along the polygon",
            "O is the white dot, U the red and V the blue arrow; one texture each.",
        ),
        (
            turned,
            "Turned by 30 degrees",
            "U and V turn in the plane: the texture turns about O.",
        ),
        (
            shifted,
            "Shifted",
            "O moves by U/2 + V/4 and takes the texture along.",
        ),
        (
            tilted,
            "V out of the plane by 25 degrees",
            "The texture lies in another plane: it is seen at an angle and swims as the eye moves.",
        ),
    ] {
        let scene = scene(Some(frame))?;
        let mut picture = stage::photograph(&scene, size)?;
        arrows(&mut picture, &scene, &frame, size)?;
        panels.push(Panel::new(picture, title, caption));
    }
    Ok(sheet(
        "The O-U-V frame: a texture placed by a point and two vectors",
        panels,
        claims,
    ))
}

/// The polygon's plane: to the right, down, and out of it. It is turned away from the eye.
fn plane() -> (DVec3, DVec3, DVec3) {
    let (sin, cos) = deterministic_f64::sin_cos((-24f64).to_radians());
    let right = DVec3::new(cos, 0.0, -sin);
    let (rise, run) = deterministic_f64::sin_cos(14f64.to_radians());
    let down = (DVec3::NEG_Y * run + DVec3::new(sin, 0.0, cos) * rise).normalize();
    (right, down, down.cross(right))
}

fn scene(frame: Option<TextureFrame>) -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.2, 0.0, 3.3), DVec3::new(0.2, 0.0, 0.0), 64.0);
    let texture = stage::texture(&mut scene, &paint::letters(512))?;
    let material = stage::decal(
        &mut scene,
        texture,
        Filter::Anisotropic(16),
        Interp::Perspective,
    );
    stage::set_wrap(&mut scene, material, Wrap::Repeat);
    let (right, down, _) = plane();
    let mut mesh = Mesh {
        material,
        texture_frame: frame,
        ..Mesh::default()
    };
    for (x, y) in POLYGON {
        mesh.positions
            .push((right * x - down * y).as_vec3().to_array());
        mesh.uvs
            .push([(x + 1.0) / REACH, (1.0 - y) / REACH].map(|c| c as f32));
    }
    mesh.triangles = (1..5).map(|i| [0, i, i + 1]).collect();
    mesh.faces = vec![0; 4];
    scene.meshes.push(mesh);
    Ok(scene)
}

/// Draws O, and U and V as arrows from it.
fn arrows(
    picture: &mut Picture,
    scene: &Scene,
    frame: &TextureFrame,
    size: u32,
) -> Result<(), LabError> {
    let matrix = scene.camera.clip_from_world(1.0)?;
    let half = 0.5 * f64::from(size);
    let project = |p: DVec3| {
        let clip = matrix * p.extend(1.0);
        DVec2::new(
            half * (1.0 + clip.x / clip.w),
            half * (1.0 - clip.y / clip.w),
        )
    };
    let thick = i64::from(size / 192).max(1);
    let o = project(frame.o);
    for (end, color) in [
        (frame.o + frame.u, [220, 30, 40, 255]),
        (frame.o + frame.v, [30, 60, 220, 255]),
    ] {
        let tip = project(end);
        let back = (o - tip).normalize_or_zero() * f64::from(size) / 28.0;
        stroke(picture, o, tip, thick + 1, [255, 255, 255, 255]);
        for side in [-1.0, 1.0] {
            let barb = tip + back + back.perp() * 0.5 * side;
            stroke(picture, tip, barb, thick + 1, [255, 255, 255, 255]);
            stroke(picture, tip, barb, thick, color);
        }
        stroke(picture, o, tip, thick, color);
    }
    let at = |c: f64, reach: i64| c.floor() as i64 - reach;
    for (reach, color) in [
        (thick + 4, [20, 20, 24, 255]),
        (thick + 2, [255, 255, 255, 255]),
    ] {
        picture.fill(
            at(o.x, reach),
            at(o.y, reach),
            2 * reach as u32 + 1,
            2 * reach as u32 + 1,
            color,
        );
    }
    Ok(())
}

/// A line of the given half-thickness.
fn stroke(picture: &mut Picture, from: DVec2, to: DVec2, thick: i64, color: Rgba) {
    let cell = |p: DVec2| (p.x.floor() as i64, p.y.floor() as i64);
    let ((x0, y0), (x1, y1)) = (cell(from), cell(to));
    for dy in -thick..=thick {
        for dx in (-thick..=thick).filter(|dx| dx * dx + dy * dy <= thick * thick) {
            picture.line((x0 + dx, y0 + dy), (x1 + dx, y1 + dy), color);
        }
    }
}
