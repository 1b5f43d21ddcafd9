//! "What's the best chart?": the sphere of directions unfolded in seven ways, and how unevenly each spends its texels.

use texmap_light::EnvironmentLayout;
use texmap_math::color::linear_to_srgb8;
use texmap_math::glam::{DVec2, DVec3};
use texmap_truth::picture::Picture;

use super::environments::{room, seen, wall};
use super::sheet::sheet;
use super::{Claim, DemoPicture};
use crate::LabError;

const BACK: [u8; 4] = [24, 26, 30, 255];

/// The faces of a layout in a square picture, as they stand in a grid.
fn unfolded(layout: EnvironmentLayout, size: u32, color: impl Fn(DVec3) -> [f32; 3]) -> Picture {
    let faces = layout.faces() as u32;
    let columns = match faces {
        1 => 1,
        2 => 2,
        _ => 3,
    };
    let cell = size / columns;
    let height = cell / layout.aspect();
    let rows = faces.div_ceil(columns);
    let above = (size - rows * height) / 2;
    let mut picture = Picture::new(size, size, BACK);
    for face in 0..faces {
        let (left, top) = (face % columns * cell, above + face / columns * height);
        for (x, y) in (0..height).flat_map(|y| (0..cell).map(move |x| (x, y))) {
            let uv = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
                / DVec2::new(cell.into(), height.into());
            let [r, g, b] = color(layout.direction(face as usize, uv)).map(linear_to_srgb8);
            picture.set(i64::from(left + x), i64::from(top + y), [r, g, b, 255]);
        }
    }
    picture
}

/// Solid angle of an infinitely small texel of a face, in units of the face.
fn density(layout: EnvironmentLayout, uv: DVec2) -> f64 {
    let step = 1e-5;
    let at = |du: f64, dv: f64| layout.direction(0, uv + DVec2::new(du, dv)).normalize();
    let across = at(step, 0.0) - at(-step, 0.0);
    let down = at(0.0, step) - at(0.0, -step);
    across.cross(down).length() / (4.0 * step * step)
}

/// Largest over smallest solid angle of a texel: the middle of a face against its corner or edge, and its form.
fn ratios() -> Vec<Claim> {
    use EnvironmentLayout as L;
    let middle = DVec2::splat(0.5);
    let corner = DVec2::splat(1e-4);
    // Away from the axes, on which the fold of an octahedron has its ridges.
    let inside = DVec2::new(0.62, 0.71);
    let edge = DVec2::new(0.5, 1e-4);
    let rows = [
        // (1 + a^2 + b^2)^(3/2) at a = b = 1.
        (
            L::Cube,
            middle,
            corner,
            27f64.sqrt(),
            "cube: middle of a face over its corner",
        ),
        // That times (1 + a^2)(1 + b^2) of the tangents.
        (
            L::TanCube,
            middle,
            corner,
            27f64.sqrt() / 4.0,
            "tan-cube: the same",
        ),
        (
            L::EqualAreaOctahedron,
            inside,
            DVec2::new(0.13, 0.34),
            1.0,
            "equal-area octahedron: anywhere over anywhere",
        ),
        // (1 + r^2)^2 at r = 1.
        (
            L::DualParaboloid,
            middle,
            edge,
            4.0,
            "paraboloid: middle over rim",
        ),
        (
            L::SphereMap,
            inside,
            DVec2::new(0.4, 0.3),
            1.0,
            "sphere map: anywhere over anywhere (its rim is one direction all the same)",
        ),
        // Circles of latitude shrink with the cosine.
        (
            L::LatLong,
            middle,
            DVec2::new(0.5, 1.0 / 6.0),
            2.0,
            "lat-long: equator over 60 degrees north",
        ),
    ];
    let claim = |(layout, a, b, form, text): (L, DVec2, DVec2, f64, &str)| {
        // Differences over 1e-5 of a face are off by its square, points at 1e-4 from a corner by 1e-4 of the slope.
        Claim::new(
            text,
            density(layout, a) / density(layout, b),
            form,
            2e-3 * form,
        )
    };
    rows.into_iter().map(claim).collect()
}

pub(super) fn best_chart(size: u32) -> Result<DemoPicture, LabError> {
    let room = room();
    let light = |d: DVec3| seen(&room, DVec3::ZERO, d).map_or([0.0; 3], wall);
    let panel = |layout| unfolded(layout, size, light);
    use EnvironmentLayout as L;
    let panels = panels! {
        panel(L::LatLong) => "lat-long", "Files exchange it; its poles are one direction in a row of texels.";
        panel(L::Cube) => "cube", "Six cameras of 90 degrees; corners have a fifth of the solid angle of the middle.";
        panel(L::TanCube) => "tan-cube", "The same faces, evenly in angle: the smallest error for its bytes.";
        panel(L::Octahedron) => "octahedron", "One square; -Z lies in its four corners.";
        panel(L::DualParaboloid) => "dual paraboloid", "Two pictures; the corners outside of the circles are wasted.";
        panel(L::SphereMap) => "sphere map", "The mirror ball: the whole rim is the direction away from the eye.";
    };
    Ok(sheet(
        "What's the best chart? Six of seven layouts of one room",
        panels,
        ratios(),
    ))
}
