//! Transparency by alpha test: a lattice before a wall, and why its holes must not write depth.

use texmap_math::glam::DVec3;
use texmap_raster::Interp;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{AlphaMode, Scene};

use super::sheet::sheet;
use super::stage::{self, Shot};
use super::{Claim, DemoPicture, Panel, paint};
use crate::LabError;
use crate::picture::Picture;

/// Texels a side of the lattice's texture.
const TEXELS: u32 = 256;

/// What stands in the scene, in the order of submission.
#[derive(Clone, Copy, PartialEq)]
enum Order {
    FenceFirst,
    FenceLast,
    FenceAlone,
    NoFence,
}

pub(super) fn transparency(size: u32) -> Result<DemoPicture, LabError> {
    let test = AlphaMode::Test(0.0);
    let shot = |order, alpha, filter| Shot::take(&scene(order, alpha, filter)?, size);
    let opaque = shot(Order::FenceFirst, AlphaMode::Opaque, Filter::Nearest)?;
    let tested = shot(Order::FenceFirst, test, Filter::Nearest)?;
    let slats = shot(Order::FenceAlone, test, Filter::Nearest)?;
    let board = shot(Order::FenceAlone, AlphaMode::Opaque, Filter::Nearest)?;
    let behind = shot(Order::NoFence, test, Filter::Nearest)?;

    // The fault: the hole shows nothing of its own, but its depth keeps all that is drawn later away.
    let sky = Shot::take(&stage::scene(DVec3::Z, DVec3::ZERO, 60.0), size)?.picture;
    let mut blocked = tested.picture.clone();
    let (mut wrong_depth, mut holes, mut fence) = (0u32, 0u32, 0u32);
    for (x, y) in tested
        .pixels()
        .filter(|&(x, y)| board.depth(x, y).is_some())
    {
        fence += 1;
        let hole = slats.depth(x, y).is_none();
        if hole {
            holes += 1;
            let (column, row) = (i64::from(x), i64::from(y));
            blocked.set(column, row, sky.get(column, row));
        }
        let expected = if hole {
            behind.depth(x, y)
        } else {
            slats.depth(x, y)
        };
        wrong_depth += u32::from(tested.depth(x, y) != expected);
    }
    let last = shot(Order::FenceLast, test, Filter::Nearest)?;
    let unlike = tested
        .pixels()
        .filter(|&(x, y)| at(&last.picture, x, y) != at(&tested.picture, x, y))
        .count();
    let blend = scene(Order::FenceLast, AlphaMode::Blend, Filter::Trilinear)?;
    let blended = Shot::take(&blend, size)?;
    // Wood, brick, checker and sky have less green than red or blue: green above both is a fringe.
    let green = |p: [u8; 4]| p[1] > p[0].max(p[2]).saturating_add(4);
    let fringe = blended
        .pixels()
        .filter(|&(x, y)| green(at(&blended.picture, x, y)))
        .count();
    let texture = paint::lattice(TEXELS);
    let clear =
        texture.rgba().chunks(4).filter(|p| p[3] == 0).count() as f64 / f64::from(TEXELS * TEXELS);
    let claims = vec![
        Claim::new(
            "alpha test: pixels of the fence with another depth than the slat's or, in a hole, what stands behind",
            wrong_depth.into(),
            0.0,
            0.0,
        ),
        Claim::new(
            "alpha test: pixels that change when the fence is drawn last instead of first",
            unlike as f64,
            0.0,
            0.0,
        ),
        Claim::new(
            "part of the fence that is hole, against the texture's",
            f64::from(holes) / f64::from(fence.max(1)),
            clear,
            0.01,
        ),
        Claim::new(
            "blended: pixels that show the green hidden under alpha 0",
            fringe as f64,
            0.0,
            0.0,
        ),
    ];
    let panels = vec![
        Panel::new(
            opaque.picture,
            "No test",
            "Alpha is ignored: the holes are solid.",
        ),
        Panel::new(
            tested.picture,
            "Alpha test",
            "alpha > 0 is drawn; a hole writes neither colour nor depth.",
        ),
        Panel::new(
            blocked,
            "Holes that write depth (wrong)",
            "The fence is drawn first: the holes hide what comes later.",
        ),
        Panel::new(
            stage::photograph(&blend, size)?,
            "Blended, filtered alpha",
            "Texels are premultiplied before they are filtered: smooth edges, no fringe of the hidden colour.",
        ),
    ];
    Ok(sheet(
        "Transparency: texels with alpha 0 are holes",
        panels,
        claims,
    ))
}

fn at(picture: &Picture, x: u32, y: u32) -> [u8; 4] {
    picture.get(i64::from(x), i64::from(y))
}

fn scene(order: Order, alpha: AlphaMode, filter: Filter) -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 0.5, 4.4), DVec3::new(0.0, 0.35, 0.0), 60.0);
    let lattice = stage::texture(&mut scene, &paint::lattice(TEXELS))?;
    let bricks = stage::texture(&mut scene, &paint::bricks(256))?;
    let photo = stage::texture(
        &mut scene,
        &paint::checker(256, 8, [70, 50, 120, 255], [232, 214, 236, 255]),
    )?;
    let fence = stage::decal(&mut scene, lattice, filter, Interp::Perspective);
    stage::set_alpha(&mut scene, fence, alpha);
    let wall = stage::decal(&mut scene, bricks, Filter::Trilinear, Interp::Perspective);
    stage::set_wrap(&mut scene, wall, Wrap::Repeat);
    let box_side = stage::decal(&mut scene, photo, Filter::Trilinear, Interp::Perspective);
    let upright = |left: f64, right: f64, top: f64, bottom: f64, z: f64| {
        [(left, top), (right, top), (right, bottom), (left, bottom)]
            .map(|(x, y)| DVec3::new(x, y, z))
    };
    let fence = stage::quad(upright(-1.7, 1.7, 1.7, -1.7, 1.6), stage::UNIT_UV, fence);
    let wall_uv = [[0.0, 0.0], [2.5, 0.0], [2.5, 1.5], [0.0, 1.5]];
    let others = [
        stage::quad(upright(-5.0, 5.0, 2.2, -3.8, -3.0), wall_uv, wall),
        stage::cube(DVec3::new(0.35, -0.35, -0.6), 32.0, box_side),
    ];
    if matches!(order, Order::FenceFirst | Order::FenceAlone) {
        scene.meshes.push(fence.clone());
    }
    if order != Order::FenceAlone {
        scene.meshes.extend(others);
    }
    if order == Order::FenceLast {
        scene.meshes.push(fence);
    }
    Ok(scene)
}
