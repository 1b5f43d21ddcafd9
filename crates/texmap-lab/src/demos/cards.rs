//! Billboards and terrain: cards that face the viewer, and ground from a picture.

use texmap_math::color::srgb_to_linear;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_raster::Interp;
use texmap_sample::{ColorSpace, Filter, Origin, Texture2d, Wrap};
use texmap_scene::{AlphaMode, Billboard, Facing, Mesh, Scene, TextureRole};

use super::lit::{Lit, matte};
use super::sheet::sheet;
use super::stage::{self, Shot};
use super::{DemoPicture, Panel};
use crate::LabError;
use texmap_truth::picture::Picture;

/// Texels of the tree.
const TREE: u32 = 128;

/// A fir: three cones over a trunk, holes beside them.
fn tree() -> Picture {
    let mut picture = Picture::new(TREE, TREE, [30, 70, 30, 0]);
    let n = f64::from(TREE);
    for (x, y) in (0..TREE).flat_map(|y| (0..TREE).map(move |x| (x, y))) {
        let (u, v) = ((f64::from(x) + 0.5) / n - 0.5, (f64::from(y) + 0.5) / n);
        let cone = [(0.02, 0.40, 0.24), (0.22, 0.62, 0.34), (0.42, 0.86, 0.44)]
            .iter()
            .find(|(top, bottom, half)| {
                v > *top && v < *bottom && u.abs() < half * (v - top) / (bottom - top)
            });
        let color = match cone {
            Some((top, bottom, _)) => {
                let shade = 0.55 + 0.45 * (1.0 - (v - top) / (bottom - top)) - 0.35 * u;
                [
                    (40.0 * shade) as u8,
                    (120.0 * shade) as u8,
                    (46.0 * shade) as u8,
                    255,
                ]
            }
            None if u.abs() < 0.05 && v > 0.8 => [96, 64, 36, 255],
            None => continue,
        };
        picture.set(i64::from(x), i64::from(y), color);
    }
    picture
}

/// Share of the picture that is not a hole.
fn solid(picture: &Picture) -> f64 {
    let kept = picture.rgba().chunks_exact(4).filter(|p| p[3] > 0).count();
    kept as f64 / (f64::from(TREE) * f64::from(TREE))
}

fn with_tree(mut scene: Scene, boards: Vec<Billboard>) -> Result<Scene, LabError> {
    let texture = stage::texture(&mut scene, &tree())?;
    let material = stage::decal(&mut scene, texture, Filter::Nearest, Interp::Perspective);
    stage::set_wrap(&mut scene, material, Wrap::ClampToEdge);
    stage::set_alpha(&mut scene, material, AlphaMode::Test(0.0));
    scene
        .meshes
        .push(texmap_mesh::billboards("trees", boards, material));
    Ok(scene)
}

/// One tree of 2 x 2 at the origin, seen from 6 units away under an elevation.
fn alone(degrees: f64, facing: Facing, size: u32) -> Result<Shot, LabError> {
    let (sin, cos) = deterministic_f64::sin_cos(degrees.to_radians());
    let mut scene = stage::scene(DVec3::new(0.0, 6.0 * sin, 6.0 * cos), DVec3::ZERO, 30.0);
    if degrees == 90.0 {
        (scene.camera.eye, scene.camera.up) = (DVec3::Y * 6.0, DVec3::NEG_Z);
    }
    let board = Billboard {
        position: DVec3::ZERO,
        size: [2.0; 2],
        facing,
    };
    Shot::take(&with_tree(scene, vec![board])?, size)
}

fn covered(shot: &Shot) -> f64 {
    shot.pixels()
        .filter(|(x, y)| shot.face(*x, *y).is_some())
        .count() as f64
}

pub(super) fn billboards(size: u32) -> Result<DemoPicture, LabError> {
    let upright = Facing::Axis(DVec3::Y);
    let level = alone(0.0, Facing::Screen, size)?;
    let high_screen = alone(60.0, Facing::Screen, size)?;
    let high_axis = alone(60.0, upright, size)?;
    let top_screen = alone(90.0, Facing::Screen, size)?;
    let top_axis = alone(90.0, upright, size)?;
    // A card parallel to the picture at distance 6 is 2 / (2 * 6 tan 15) of its width.
    let side = f64::from(size) / (6.0 * deterministic_f64::tan(15_f64.to_radians()));
    let area = side * side * solid(&tree());
    let percent = |shot: &Shot| 100.0 * covered(shot) / area;
    let claims = claims![
        "screen-aligned, level: % of the tree's area" => percent(&level), 100.0, 2.0;
        "screen-aligned, 60 degrees above: %" => percent(&high_screen), 100.0, 2.0;
        "axis-aligned, 60 degrees above: % (cosine)" => percent(&high_axis), 50.0, 3.0;
        "screen-aligned, from right above: %" => percent(&top_screen), 100.0, 2.0;
        "axis-aligned, from right above (edge-on): pixels" => covered(&top_axis), 0.0, 0.0;
    ];
    let panel = |shot: Shot, title: &str, caption: &str| Panel::new(shot.picture, title, caption);
    let panels = vec![
        panel(
            level,
            "Level",
            "Both kinds face the eye; alpha cuts the tree out.",
        ),
        panel(
            high_screen,
            "Screen, from 60 degrees",
            "Parallel to the picture: as if it leaned back.",
        ),
        panel(
            high_axis,
            "Axis, from 60 degrees",
            "It stands upright and looks shorter.",
        ),
        panel(
            top_axis,
            "Axis, from above",
            "Edge-on it is a line: nothing is drawn.",
        ),
    ];
    Ok(sheet("Billboards", panels, claims))
}

/// Texels a side of the ground, its side and its height.
const POSTS: u32 = 129;
const SIDE: f64 = 12.0;
const RISE: f64 = 2.2;

/// Height of the ground over its middle, 0..=1, and its picture's colour there.
fn ground(x: f64, z: f64) -> f64 {
    let waves = [
        (0.9, 0.4, 0.0, 0.5),
        (-0.5, 1.1, 1.3, 0.3),
        (2.1, 1.7, 0.4, 0.14),
        (3.9, -3.1, 2.0, 0.06),
    ];
    let sum: f64 = waves
        .iter()
        .map(|(a, b, c, w)| w * deterministic_f64::sin(a * x + b * z + c))
        .sum();
    (0.5 + 0.5 * sum).clamp(0.0, 1.0)
}

/// Coordinate of the centre of texel `i`.
fn post(i: u32) -> f64 {
    SIDE * (f64::from(i) / f64::from(POSTS - 1) - 0.5)
}

fn maps() -> Result<[Texture2d<'static>; 2], LabError> {
    let heights: Vec<f32> = (0..POSTS * POSTS)
        .map(|i| ground(post(i % POSTS), post(i / POSTS)) as f32)
        .collect();
    let bands = [
        (0.30, [70, 110, 160]),
        (0.36, [200, 184, 130]),
        (0.68, [88, 132, 62]),
        (0.84, [120, 104, 88]),
        (2.0, [240, 242, 246]),
    ];
    let color = |h: &f32| {
        let band = bands.iter().find(|(top, _)| f64::from(*h) < *top);
        let [r, g, b] = band.map_or([0; 3], |(_, c)| *c);
        [r, g, b, 255]
    };
    let texels: Vec<u8> = heights.iter().flat_map(color).collect();
    let picture = Texture2d::from_rgba8(POSTS, POSTS, texels, ColorSpace::Srgb, Origin::TopLeft)?;
    Ok([
        crate::plane::floats(POSTS, 1, &heights)?,
        picture.with_mips(),
    ])
}

/// The ground with a vertex for every `step` texels, under a sun, with trees on its grass.
fn landscape(step: u32, trees: bool) -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.5, 4.6, 9.5), DVec3::new(0.0, 0.9, 0.0), 55.0);
    scene.lights = stage::daylight(0.22, [0.9, 0.87, 0.8], [-0.8, -0.6, -0.25]);
    scene.effects.shadows = vec![stage::shadow(1, 1024)];
    let [heights, picture] = maps()?;
    scene.textures.push(picture);
    let mut grass = matte([srgb_to_linear(1.0); 3], 0.0);
    grass.texture_role = TextureRole::Modulate;
    grass.base_color = Some(stage::slot(0, Filter::Trilinear, Wrap::ClampToEdge));
    let material = stage::add(&mut scene, grass);
    let size = [SIDE as f32, RISE as f32, SIDE as f32];
    let land = texmap_mesh::height_field("land", &heights, size, step)?;
    scene.meshes.push(Mesh { material, ..land });
    if !trees {
        return Ok(scene);
    }
    let mut boards = Vec::new();
    for (i, j) in (0..24).flat_map(|j| (0..24).map(move |i| (i, j))) {
        let jitter = |a: i32, b: i32| 0.18 * deterministic_f64::sin(f64::from(a * 7 + b * 13));
        let (x, z) = (
            f64::from(i) * 0.5 - 5.8 + jitter(i, j),
            f64::from(j) * 0.5 - 5.8 + jitter(j, i + 5),
        );
        let h = ground(x, z);
        if (0.45..0.66).contains(&h) {
            let position = DVec3::new(x, RISE * h + 0.26, z);
            boards.push(Billboard {
                position,
                size: [0.5, 0.6],
                facing: Facing::Axis(DVec3::Y),
            });
        }
    }
    with_tree(scene, boards)
}

/// The largest distance of seen ground from its formula, and of its coordinates from its position.
fn errors(scene: &Scene, size: u32) -> Result<(f64, f64), LabError> {
    let (lit, shot) = (Lit::take(scene, size)?, Shot::take(scene, size)?);
    let (mut height, mut place) = (0.0f64, 0.0f64);
    for ((x, y), p) in shot.pixels().zip(&lit.position) {
        let Some(uv) = shot.uv(x, y).filter(|_| p.is_finite()) else {
            continue;
        };
        height = height.max((p.y - RISE * ground(p.x, p.z)).abs());
        let texel = |c: f64| (c / SIDE + 0.5) * f64::from(POSTS - 1);
        let n = f64::from(POSTS);
        place = place
            .max((uv.x * n - 0.5 - texel(p.x)).abs())
            .max((uv.y * n - 0.5 - texel(p.z)).abs());
    }
    Ok((height, place))
}

pub(super) fn terrain(size: u32) -> Result<DemoPicture, LabError> {
    let full = errors(&landscape(1, false)?, size)?;
    let coarse = errors(&landscape(8, false)?, size)?;
    let claims = claims![
        "largest error of the height, a vertex a texel, % of the rise" => 100.0 * full.0 / RISE, 0.0, 0.25;
        "with a vertex for 8 texels, %" => 100.0 * coarse.0 / RISE, 9.3, 2.0;
        "largest error of the picture's place on the ground, texels" => full.1.max(coarse.1), 0.0, 0.01;
    ];
    let triangles =
        |step| -> Result<usize, LabError> { Ok(landscape(step, false)?.meshes[0].triangles.len()) };
    let at = |c: u32| post((c * POSTS / size).min(POSTS - 1));
    let map = Picture::from_fn(size, size, |x, y| {
        let h = (ground(at(x), at(y)) * 255.0) as u8;
        [h, h, h, 255]
    });
    let panels = panels![
        map => "Heights", format!("A picture of {POSTS} x {POSTS} heights.");
        stage::photograph(&landscape(1, true)?, size)? =>
            "Terrain", format!("{} triangles with their picture, shadows, and trees on cards.", triangles(1)?);
        stage::photograph(&landscape(8, false)?, size)? =>
            "Every 8th texel",
            format!("{} triangles: hills lose their detail and their outline.", triangles(8)?);
    ];
    Ok(sheet("Terrain from a height field", panels, claims))
}
