//! The applets of the lectures as captioned pictures that assert the numbers they claim.
//!
//! MIT 6.837 (Fall 2001, lecture 18) let its students walk around cubes and see the affine warp, the cure and
//! the half-cure by subdivision, the seams of Gouraud shading, tiling and transparency; Brackeen (2003,
//! chapter 7) compares forward with inverse mapping and builds the O-U-V frame. [`demo`] draws each of them
//! with the renderer's own named methods, measures what the picture shows and holds it against the closed
//! form.

/// A table of claims: `text => measured, expected, tolerance;` a row.
macro_rules! claims {
    ($($text:expr => $measured:expr, $expected:expr, $tolerance:expr;)*) => {
        vec![$($crate::demos::Claim::new($text, $measured, $expected, $tolerance)),*]
    };
}

/// A table of panels: `picture => title, caption;` a row.
macro_rules! panels {
    ($($picture:expr => $title:expr, $caption:expr;)*) => {
        vec![$($crate::demos::Panel::new($picture, $title, $caption)),*]
    };
}

mod affine;
mod antialiasing;
mod best_chart;
mod bump_maps;
mod cards;
mod classics;
mod displacement;
mod environments;
mod frame;
mod gouraud;
mod lit;
mod mapping;
mod moving_spot;
mod paint;
mod parallax;
mod planar_mirror;
mod procedural_bump;
mod projections;
mod rectification;
mod shadows;
mod sheet;
mod skin;
mod space;
mod specular_maps;
mod stage;
mod tiling;
mod transparency;
mod uv_mappings;

use std::ops::RangeInclusive;

pub use moving_spot::MovingSpot;
pub use projections::projections;

use crate::LabError;
use texmap_truth::picture::Picture;

/// Pixels a side that a panel may have.
pub const SIZES: RangeInclusive<u32> = 128..=1024;

/// Edge of a panel in pixels when the caller has no wish.
pub const DEFAULT_SIZE: u32 = 384;

type Draw = fn(u32) -> Result<DemoPicture, LabError>;

const DEMOS: [(&str, &str, Draw); 29] = [
    (
        "affine-image",
        "a photo on cubes, screen-linear against perspective",
        affine::image,
    ),
    (
        "affine-checker",
        "a checker on cubes, screen-linear against perspective",
        affine::checker,
    ),
    (
        "subdivided",
        "cubes with 2 and with 8 affine triangles a face",
        affine::subdivided,
    ),
    (
        "gouraud-tjoint",
        "the seam of Gouraud colours at a T-junction",
        gouraud::tjoint,
    ),
    (
        "gouraud-lod",
        "the pop of Gouraud colours at a level-of-detail switch",
        gouraud::lod,
    ),
    (
        "tiling",
        "the five wrap modes, and truncation instead of floor",
        tiling::tiling,
    ),
    (
        "transparency",
        "holes by alpha test, and holes that write depth",
        transparency::transparency,
    ),
    (
        "forward-inverse",
        "texel to pixel with its overdraw, against pixel to texel",
        mapping::forward_inverse,
    ),
    (
        "frame",
        "the O-U-V frame turned, shifted and out of the plane",
        frame::frame,
    ),
    (
        "slides",
        "a projected picture as light and as paint, with and without its shadow map",
        shadows::slides,
    ),
    (
        "shadows",
        "shadow maps: no bias, a constant, the default, filtered; the map itself",
        shadows::shadows,
    ),
    (
        "environments",
        "environment maps against ray-traced reflections; clamped cube faces",
        environments::environments,
    ),
    (
        "parallax",
        "a mirror away from the point of capture: infinitely far, led to the walls of a box, by rays",
        parallax::parallax,
    ),
    (
        "planar-mirror",
        "a checkered floor as a planar mirror, by mirror rays and by an environment around its middle",
        planar_mirror::planar_mirror,
    ),
    (
        "best-chart",
        "the sphere of directions unfolded in six layouts, and the solid angles of their texels",
        best_chart::best_chart,
    ),
    (
        "specular-maps",
        "highlights of area lights gathered by an exponent, against 1 - cos^(n + 1) and Phong's",
        specular_maps::specular_maps,
    ),
    (
        "rectification",
        "a photo of a plane as its texture, by a homography of four points and by weights of the corners",
        rectification::rectification,
    ),
    (
        "uv-mapping",
        "a checker by plane, cylinder, sphere and box, and its stretch against closed forms",
        uv_mappings::uv_mappings,
    ),
    (
        "bumps",
        "bump, offset and normal maps against the surface they stand for; green flipped; procedural waves, words",
        bump_maps::bumps,
    ),
    (
        "light-maps",
        "baked light against light per pixel; islands without gutters; a moving spotlight (--frames N)",
        bump_maps::light_maps,
    ),
    (
        "displacement",
        "a displaced ball against its bump map and the f64 truth: outline, shadow, shading",
        displacement::displacement,
    ),
    (
        "skin",
        "an arm of two bones from 0 to 120 degrees: the volume that blending loses; rigid parts",
        skin::skin,
    ),
    (
        "billboards",
        "cards that face the screen or turn about an axis, level and from above",
        cards::billboards,
    ),
    (
        "terrain",
        "ground from a picture of heights, with its texture, shadows and trees",
        cards::terrain,
    ),
    (
        "antialiasing",
        "edges by one sample, by more, by multisampling and by a filter, against exact coverage",
        antialiasing::antialiasing,
    ),
    (
        "solids",
        "marble, wood and noise as solid textures, against pictures wrapped around",
        space::solids,
    ),
    (
        "volumes",
        "fog by its closed form, a grid with a transfer function, the eye inside",
        space::volumes,
    ),
    (
        "skies",
        "a stretched backdrop and an environment sky behind a tiled wall",
        classics::skies,
    ),
    (
        "labels",
        "letters by coverage, a decal over base, ramps of light and of heat",
        classics::labels,
    ),
];

/// The demos' names, each with what it shows in one line.
pub fn list() -> impl Iterator<Item = (&'static str, &'static str)> {
    DEMOS.iter().map(|&(name, what, _)| (name, what))
}

pub(crate) fn names() -> String {
    list().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
}

/// Draws a demo with panels of `size` by `size` pixels (see [`SIZES`] and [`DEFAULT_SIZE`]).
///
/// A claim that fails is no error: it is drawn in red, and [`Claim::holds`] tells.
///
/// # Errors
/// If the name is unknown or the size out of range.
pub fn demo(name: &str, size: u32) -> Result<DemoPicture, LabError> {
    let (_, _, draw) = DEMOS
        .iter()
        .find(|(known, ..)| *known == name)
        .ok_or_else(|| LabError::UnknownDemo(name.to_owned()))?;
    if !SIZES.contains(&size) {
        return Err(LabError::PanelSize(size));
    }
    draw(size)
}

/// A figure that a demo measures on its own pictures and what theory says it must be.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The claim in words.
    pub text: String,
    /// The figure measured.
    pub measured: f64,
    /// The figure that theory gives.
    pub expected: f64,
    /// Largest difference of the two that still supports the claim.
    pub tolerance: f64,
}

impl Claim {
    fn new(text: impl Into<String>, measured: f64, expected: f64, tolerance: f64) -> Self {
        Self {
            text: text.into(),
            measured,
            expected,
            tolerance,
        }
    }

    /// True if the measured figure supports the claim; a NaN never does.
    pub fn holds(&self) -> bool {
        (self.measured - self.expected).abs() <= self.tolerance
    }
}

impl std::fmt::Display for Claim {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verdict = if self.holds() { "holds" } else { "FAILS" };
        let (measured, expected) = (figure(self.measured, 4), figure(self.expected, 4));
        write!(
            f,
            "{verdict}: {}: measured {measured}, expected {expected}",
            self.text
        )?;
        if self.tolerance > 0.0 {
            write!(f, " +- {}", figure(self.tolerance, 2))?;
        }
        Ok(())
    }
}

/// A value with some significant digits, or a whole number as it is.
fn figure(value: f64, digits: i32) -> String {
    let size = value.abs();
    match size {
        _ if !value.is_finite() || value.fract() == 0.0 && size < 1e7 => format!("{value}"),
        _ if !(1e-4..1e5).contains(&size) => format!("{value:.1e}"),
        _ => format!(
            "{value:.*}",
            (digits - 1 - size.log10().floor() as i32).max(0) as usize
        ),
    }
}

/// The result of [`demo`].
#[derive(Clone, Debug)]
pub struct DemoPicture {
    /// Title, panels with captions, and the claims with their verdicts.
    pub image: Picture,
    /// The panels' captions, left to right.
    pub captions: Vec<String>,
    /// The claims with their measured figures.
    pub claims: Vec<Claim>,
}

/// One picture of a sheet with its words.
#[derive(Debug)]
struct Panel {
    picture: Picture,
    title: String,
    caption: String,
}

impl Panel {
    fn new(picture: Picture, title: impl Into<String>, caption: impl Into<String>) -> Self {
        Self {
            picture,
            title: title.into(),
            caption: caption.into(),
        }
    }
}
