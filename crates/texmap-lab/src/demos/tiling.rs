//! Tiling: the five wrap modes, and what truncation does to the texel at zero.

use texmap_math::glam::DVec3;
use texmap_raster::Interp;
use texmap_sample::{Filter, Wrap};
use texmap_scene::Scene;

use super::sheet::sheet;
use super::stage::{self, Shot};
use super::{Claim, DemoPicture, Panel, paint};
use crate::LabError;
use crate::picture::{Picture, Rgba};

/// The wall shows u and v from here to here, so that the texture itself is the middle third.
const FROM: f32 = -1.0;
const TO: f32 = 2.0;
const UNITS: u32 = 3;

/// Texels a side of the coarse texture that truncation is shown with.
const TEXELS: u32 = 4;

const MARK: Rgba = [255, 255, 255, 255];

pub(super) fn tiling(size: u32) -> Result<DemoPicture, LabError> {
    let letters = paint::letters(384);
    let modes = [
        (
            Wrap::Repeat,
            "Repeat",
            "The texture starts again: u modulo 1, with a true modulo for negative u.",
        ),
        (
            Wrap::MirroredRepeat,
            "Mirrored repeat",
            "Every other tile is reflected: no jump at the joints.",
        ),
        (
            Wrap::ClampToEdge,
            "Clamp to edge",
            "The last texel is smeared outward.",
        ),
        (
            Wrap::ClampToBorder,
            "Clamp to border",
            "One colour outside; the lecture's slide projector wants this.",
        ),
        (
            Wrap::MirrorClampToEdge,
            "Mirror once, then clamp",
            "Reflected about 0, then smeared.",
        ),
    ];
    let mut panels = Vec::new();
    for (wrap, title, caption) in modes {
        let mut picture = stage::photograph(&wall(&letters, wrap, Filter::Trilinear)?, size)?;
        mark(&mut picture);
        panels.push(Panel {
            picture,
            title: title.into(),
            caption: caption.into(),
        });
    }
    let coarse = coarse();
    let side = size.next_multiple_of(UNITS * TEXELS);
    let floor = Shot::take(&wall(&coarse, Wrap::Repeat, Filter::Nearest)?, side)?;
    let mut truncated = truncate(
        &Shot::take(&wall(&coarse, Wrap::Repeat, Filter::Nearest)?, size)?,
        &coarse,
    );
    mark(&mut truncated);
    panels.push(Panel {
        picture: truncated,
        title: "Truncation (wrong)".into(),
        caption: "(int)u with 4 x 4 texels: column A and row 1 are twice as wide at 0, all before is shifted.".into(),
    });

    let mirrored = Shot::take(&wall(&coarse, Wrap::MirroredRepeat, Filter::Nearest)?, side)?;
    let period = i64::from(side / UNITS);
    let texel = f64::from(side / UNITS / TEXELS);
    let row = i64::from(side / 2 + 1);
    let unlike = |picture: &Picture, partner: &dyn Fn(i64) -> i64| {
        let columns = (0..i64::from(side)).filter(|&x| (0..i64::from(side)).contains(&partner(x)));
        columns
            .filter(|&x| picture.get(x, row) != picture.get(partner(x), row))
            .count() as f64
    };
    let claims = vec![
        Claim::new(
            "repeat: pixels of a row that differ from the pixel one tile on",
            unlike(&floor.picture, &|x| x + period),
            0.0,
            0.0,
        ),
        Claim::new(
            "mirrored repeat: pixels of a row that differ from their reflection about u = 0",
            unlike(&mirrored.picture, &|x| 2 * period - 1 - x),
            0.0,
            0.0,
        ),
        Claim::new(
            "width of the texel at u = 0 by floor, in texels",
            run_at(&floor.picture, period, row) / texel,
            1.0,
            0.0,
        ),
        Claim::new(
            "width of the texel at u = 0 by truncation, in texels",
            run_at(&truncate(&floor, &coarse), period, row) / texel,
            2.0,
            0.0,
        ),
    ];
    Ok(sheet(
        "Tiling: the wrap modes (the frame marks the texture itself)",
        panels,
        claims,
    ))
}

/// A wall that fills the picture, seen head on.
fn wall(photo: &Picture, wrap: Wrap, filter: Filter) -> Result<Scene, LabError> {
    // At 90 degrees a wall at distance 1 has the half-width 1.
    let mut scene = stage::scene(DVec3::Z, DVec3::ZERO, 90.0);
    let texture = stage::texture(&mut scene, photo)?;
    let material = stage::decal(&mut scene, texture, filter, Interp::Perspective);
    stage::set_wrap(&mut scene, material, wrap);
    if let Some(slot) = &mut scene.materials[material].base_color {
        slot.sampler.border = [0.03, 0.035, 0.05, 1.0];
    }
    let corners =
        [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    scene.meshes.push(stage::quad(
        corners,
        [[FROM, FROM], [TO, FROM], [TO, TO], [FROM, TO]],
        material,
    ));
    Ok(scene)
}

/// The lettered grid with one texel a field.
fn coarse() -> Picture {
    let mut coarse = Picture::new(TEXELS, TEXELS, [0; 4]);
    for y in 0..TEXELS {
        for x in 0..TEXELS {
            coarse.set(x.into(), y.into(), paint::field(x, y));
        }
    }
    coarse
}

/// The lecture's `tile((int) u, size)`: truncate, then add the size until the texel is in range.
fn truncate(shot: &Shot, texels: &Picture) -> Picture {
    let mut out = Picture::new(shot.size(), shot.size(), [0; 4]);
    for (x, y) in shot.pixels() {
        if let Some(uv) = shot.uv(x, y) {
            let texel = |c: f64| ((c * f64::from(TEXELS)) as i64).rem_euclid(i64::from(TEXELS));
            out.set(
                i64::from(x),
                i64::from(y),
                texels.get(texel(uv.x), texel(uv.y)),
            );
        }
    }
    out
}

/// Length of the run of one colour that holds the pixel (x, y), along the row.
fn run_at(picture: &Picture, x: i64, y: i64) -> f64 {
    let color = picture.get(x, y);
    let right = (x..).take_while(|&x| picture.get(x, y) == color).count();
    let left = (0..x)
        .rev()
        .take_while(|&x| picture.get(x, y) == color)
        .count();
    (left + right) as f64
}

fn mark(picture: &mut Picture) {
    let third = picture.width() / UNITS;
    for inset in 0..2 {
        let (at, side) = (i64::from(third + inset), third - 2 * inset);
        picture.frame(at, at, side, side, MARK);
    }
}
