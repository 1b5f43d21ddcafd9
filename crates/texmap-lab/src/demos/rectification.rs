//! "Can't do this!": a photo of a plane as its texture, by a homography of four points.

use texmap_math::color::linear_to_srgb8;
use texmap_math::glam::DVec2;
use texmap_math::{Homography, Level};
use texmap_sample::{ColorSpace, EdgeMode, Filter, Origin, Resample, Texture2d};
use texmap_truth::picture::Picture;

use super::sheet::sheet;
use super::{DemoPicture, paint};
use crate::LabError;

/// The corners of the plane in the photo, parts of its side, from the upper left clockwise.
const QUAD: [[f64; 2]; 4] = [[0.12, 0.2], [0.9, 0.06], [0.84, 0.78], [0.2, 0.94]];

/// Brightness that rises evenly to the right and downwards, linear light: filters keep it.
fn even(size: u32) -> Picture {
    Picture::from_fn(size, size, |x, y| {
        let part = |c: u32| (c as f32 + 0.5) / size as f32;
        let code = |c: f32| linear_to_srgb8(0.15 + 0.7 * c);
        [
            code(part(x)),
            code(part(y)),
            code(0.5 * (part(x) + part(y))),
            255,
        ]
    })
}

/// A picture drawn through a homography, a size of its own.
fn warped(picture: &Picture, map: &Homography, filter: Filter) -> Result<Picture, LabError> {
    let size = picture.width();
    let texels = picture.rgba().to_vec();
    let texture = Texture2d::from_rgba8(size, size, texels, ColorSpace::Srgb, Origin::TopLeft)?;
    let texture = texture.with_mips();
    let resample = Resample::new(
        &texture,
        filter,
        EdgeMode::Border([0.05, 0.06, 0.08, 1.0]),
        map,
    );
    let mut colors = vec![[0.0; 4]; (size * size) as usize];
    resample.rows(Level::new(), size, 0, &mut colors)?;
    Ok(Picture::from_fn(size, size, |x, y| {
        let [r, g, b, _] = colors[(y * size + x) as usize];
        [
            linear_to_srgb8(r),
            linear_to_srgb8(g),
            linear_to_srgb8(b),
            255,
        ]
    }))
}

/// The same with the four corners weighted by s and t alone, as one that does not know of homographies would do it.
fn bilinear(photo: &Picture, quad: [DVec2; 4]) -> Picture {
    let size = photo.width();
    Picture::from_fn(size, size, |x, y| {
        let p = mixed(quad, DVec2::new(x.into(), y.into()) + 0.5, f64::from(size));
        photo.get(p.x as i64, p.y as i64)
    })
}

fn mixed(quad: [DVec2; 4], p: DVec2, size: f64) -> DVec2 {
    let (s, t) = (p.x / size, p.y / size);
    let row = |a: DVec2, b: DVec2| a * (1.0 - s) + b * s;
    row(quad[0], quad[1]) * (1.0 - t) + row(quad[3], quad[2]) * t
}

/// The point where two lines through two points each meet.
fn crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> DVec2 {
    let (u, v) = (b - a, d - c);
    a + u * ((c - a).perp_dot(v) / u.perp_dot(v))
}

pub(super) fn rectification(size: u32) -> Result<DemoPicture, LabError> {
    let side = f64::from(size);
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|p| DVec2::from(p) * side);
    let quad = QUAD.map(|p| DVec2::from(p) * side);
    let photograph = Homography::from_quads(square, quad)?;
    let rectify = Homography::from_quads(quad, square)?;
    let facade = paint::letters(size);
    let photo = warped(&facade, &photograph, Filter::Anisotropic(16))?;
    let cured = warped(&photo, &rectify, Filter::Anisotropic(16))?;
    let naive = bilinear(&photo, quad);

    let grid = (0..=20)
        .flat_map(|j| (0..=20).map(move |i| DVec2::new(i.into(), j.into()) * (side / 20.0)));
    let there = |p: DVec2| photograph.apply(p).unwrap_or(DVec2::INFINITY);
    let back = |p: DVec2| rectify.apply(there(p)).unwrap_or(DVec2::INFINITY);
    let round_trip = grid.map(|p| (back(p) - p).length()).fold(0.0, f64::max);
    // A homography keeps lines: the middle of the square lies where the diagonals of the quad cross. Weights of the corners put it
    // into their mean.
    let middle = crossing([quad[0], quad[2]], [quad[1], quad[3]]);
    let centre = DVec2::splat(0.5 * side);
    let mean = (quad[0] + quad[1] + quad[2] + quad[3]) / 4.0;
    let gradient = even(size);
    let again = warped(
        &warped(&gradient, &photograph, Filter::Anisotropic(16))?,
        &rectify,
        Filter::Anisotropic(16),
    )?;
    let inner = (size / 8)..(size - size / 8);
    let off = inner
        .clone()
        .flat_map(|y| inner.clone().map(move |x| (i64::from(x), i64::from(y))));
    let worst = off
        .flat_map(|(x, y)| {
            let (a, b) = (gradient.get(x, y), again.get(x, y));
            [0, 1, 2].map(|k| a[k].abs_diff(b[k]))
        })
        .max();
    let claims = claims! {
        "there and back by four points: largest error, pixels" => round_trip, 0.0, 1e-9;
        "the middle of the plane, from the crossing of the diagonals, pixels" =>
            (there(centre) - middle).length(), 0.0, 1e-9;
        "weights of the corners instead: the same, pixels" =>
            (mixed(quad, centre, side) - middle).length(), (mean - middle).length(), 1e-9;
        // Three pictures of 8 bits, half a code each, and the mean of codes that are half a code off.
        "light that rises evenly, photographed and rectified: largest difference inside, /255" =>
            f64::from(worst.unwrap_or(255)), 0.0, 2.0;
    };
    let panels = panels! {
        facade => "The plane", "As a camera in front of it sees it.";
        photo => "A photo of it", "No texture: its distances are those of a perspective.";
        naive => "Weights of the four corners", "Cells that are equal come out unequal: the far ones are too small.";
        cured => "A homography of the four points", "The plane again; the far side has lost detail, which no map gives back.";
    };
    Ok(sheet(
        "Rectification: a photo of a plane as its texture",
        panels,
        claims,
    ))
}
