//! Anti-aliasing: one sample, supersampling, multisampling and filtered edges, against exact coverage in f64.

use texmap_light::PhongMaterial;
use texmap_math::color::{linear_to_srgb8, srgb_to_linear};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};
use texmap_raster::Interp;
use texmap_render::RenderSettings;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading};

use super::sheet::sheet;
use super::stage;
use super::{Claim, DemoPicture, Panel};
use crate::LabError;
use texmap_truth::picture::Picture;

/// Rays of the star, all from its middle: edges of every slope.
const RAYS: u32 = 17;
/// Texels of its picture.
const TEXELS: u32 = 1024;

/// The wedges of the star in the unit square, y down.
fn wedges() -> Vec<[DVec2; 3]> {
    let middle = DVec2::new(0.503, 0.498);
    let at = |turn: f64| {
        let (sin, cos) = deterministic_f64::sin_cos(turn * std::f64::consts::TAU);
        middle + DVec2::new(cos, sin) * 0.47
    };
    (0..RAYS)
        .map(|i| {
            let turn = (f64::from(i) + 0.37) / f64::from(RAYS);
            [middle, at(turn), at(turn + 0.5 / f64::from(RAYS))]
        })
        .collect()
}

/// Share of each of `size` x `size` pixels that the star covers: the exact area of each wedge cut by the pixel's square
/// (Sutherland and Hodgman 1974).
fn coverage(size: u32) -> Vec<f64> {
    let mut cover = vec![0.0; size as usize * size as usize];
    for wedge in wedges() {
        let corners = wedge.map(|p| p * f64::from(size));
        let low = corners
            .iter()
            .copied()
            .fold(DVec2::INFINITY, DVec2::min)
            .floor();
        let high = corners
            .iter()
            .copied()
            .fold(DVec2::NEG_INFINITY, DVec2::max)
            .ceil();
        for (x, y) in (low.y as u32..high.y as u32)
            .flat_map(|y| (low.x as u32..high.x as u32).map(move |x| (x, y)))
        {
            let corner = DVec2::new(x.into(), y.into());
            cover[(y * size + x) as usize] += area(&cut(corners.map(|p| p - corner).to_vec()));
        }
    }
    cover
}

/// A polygon within the unit square.
fn cut(mut polygon: Vec<DVec2>) -> Vec<DVec2> {
    let sides = [
        (DVec2::X, 0.0),
        (DVec2::NEG_X, -1.0),
        (DVec2::Y, 0.0),
        (DVec2::NEG_Y, -1.0),
    ];
    for (normal, least) in sides {
        let mut kept = Vec::new();
        for (i, b) in polygon.iter().enumerate() {
            let a = polygon[(i + polygon.len() - 1) % polygon.len()];
            let (da, db) = (normal.dot(a) - least, normal.dot(*b) - least);
            if (da < 0.0) != (db < 0.0) {
                kept.push(a + (*b - a) * (da / (da - db)));
            }
            if db >= 0.0 {
                kept.push(*b);
            }
        }
        polygon = kept;
    }
    polygon
}

fn area(polygon: &[DVec2]) -> f64 {
    let sum: f64 = (0..polygon.len())
        .map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()]))
        .sum();
    0.5 * sum.abs()
}

/// Linear coverage as grey.
fn grey(cover: &[f64], size: u32) -> Picture {
    Picture::from_fn(size, size, |x, y| {
        let code = linear_to_srgb8(cover[(y * size + x) as usize] as f32);
        [code, code, code, 255]
    })
}

/// A camera whose picture is exactly the unit square at z = 0, y down on the screen.
fn view() -> Scene {
    let mut scene = stage::scene(
        DVec3::new(0.5, -0.5, 1.0),
        DVec3::new(0.5, -0.5, 0.0),
        2.0 * 0.5f64.atan().to_degrees(),
    );
    scene.camera.fov_x = 2.0 * deterministic_f64::atan(0.5);
    (scene.background, scene.color) = ([0.0, 0.0, 0.0, 1.0], ColorMode::Srgb);
    scene
}

/// The star as triangles, white on black.
fn as_triangles() -> Scene {
    let mut scene = view();
    let white = PhongMaterial {
        color: [1.0; 3],
        ..PhongMaterial::default()
    };
    let material = stage::add(
        &mut scene,
        Material {
            phong: white,
            shading: Shading::Unlit,
            ..Material::default()
        },
    );
    let mut mesh = Mesh {
        name: "star".into(),
        material,
        ..Mesh::default()
    };
    for wedge in wedges() {
        let first = mesh.positions.len() as u32;
        mesh.positions
            .extend(wedge.map(|p| [p.x as f32, -p.y as f32, 0.0]));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    scene.meshes.push(mesh);
    scene
}

/// The star as a picture on a square.
fn as_texture(filter: Filter) -> Result<Scene, LabError> {
    let mut scene = view();
    let texture = stage::texture(&mut scene, &grey(&coverage(TEXELS), TEXELS))?;
    let material = stage::decal(&mut scene, texture, filter, Interp::Perspective);
    stage::set_wrap(&mut scene, material, Wrap::ClampToEdge);
    let corners =
        [(0.0, 0.0), (1.0, 0.0), (1.0, -1.0), (0.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    scene
        .meshes
        .push(stage::quad(corners, stage::UNIT_UV, material));
    Ok(scene)
}

fn draw(scene: &Scene, size: u32, supersample: u32, msaa: u32) -> Result<Picture, LabError> {
    let settings = RenderSettings {
        supersample,
        msaa,
        ..RenderSettings::new(size, size)
    };
    Ok(texmap_render::render(scene, &settings, &texmap_render::no_progress)?.into())
}

/// RMS difference from the exact coverage over the pixels that an edge cuts, % of full light.
fn edge_error(picture: &Picture, cover: &[f64]) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (pixel, exact) in picture.rgba().chunks_exact(4).zip(cover) {
        if *exact > 1e-9 && *exact < 1.0 - 1e-9 {
            let found = f64::from(srgb_to_linear(f32::from(pixel[1]) / 255.0));
            sum += (found - exact) * (found - exact);
            count += 1;
        }
    }
    100.0 * (sum / f64::from(count.max(1))).sqrt()
}

pub(super) fn antialiasing(size: u32) -> Result<DemoPicture, LabError> {
    let cover = coverage(size);
    let star = as_triangles();
    let shots = [
        (
            "Nearest: one sample",
            "A pixel is the star or it is not.",
            draw(&star, size, 1, 1)?,
            25.0,
            4.0,
        ),
        (
            "Multisampled, 4",
            "Four places of coverage, one colour a triangle (--msaa 4).",
            draw(&star, size, 1, 4)?,
            9.5,
            2.0,
        ),
        (
            "Supersampled, 2 x 2",
            "Everything four times, on a grid.",
            draw(&star, size, 2, 1)?,
            9.0,
            2.0,
        ),
        (
            "Supersampled, 4 x 4",
            "Sixteen times the work.",
            draw(&star, size, 4, 1)?,
            3.2,
            1.5,
        ),
        (
            "Filtered, EWA",
            "The same star as a texture: the filter smooths its edges.",
            draw(&as_texture(Filter::ewa(16))?, size, 1, 1)?,
            13.0,
            4.0,
        ),
    ];
    let mut claims: Vec<Claim> = shots
        .iter()
        .map(|(title, _, picture, expected, tolerance)| {
            let text = format!("{title}: RMS error of edge pixels, % of full light");
            Claim::new(text, edge_error(picture, &cover), *expected, *tolerance)
        })
        .collect();
    let truth = grey(&cover, size);
    claims.push(Claim::new(
        "exact coverage in 8 bits, %",
        edge_error(&truth, &cover),
        0.0,
        0.5,
    ));
    let mut panels: Vec<Panel> = Vec::new();
    for (title, caption, picture, ..) in shots {
        panels.push(Panel::new(magnified(&picture, size), title, caption));
    }
    let caption = "The exact area of the star in each pixel, in f64.";
    panels.push(Panel::new(magnified(&truth, size), "Truth", caption));
    Ok(sheet("Anti-aliasing of edges", panels, claims))
}

/// The picture with a part of its middle four times as large in a corner.
fn magnified(picture: &Picture, size: u32) -> Picture {
    let mut out = picture.clone();
    let side = i64::from(size) / 10;
    let from = i64::from(size) / 2 - side / 2;
    out.blit_zoomed(0, 0, picture, [from, from, side, side], 4);
    out.frame(
        -1,
        -1,
        4 * side as u32 + 2,
        4 * side as u32 + 2,
        [200, 60, 40, 255],
    );
    out
}
