//! The applets of the lectures as captioned pictures that assert the numbers they claim.
//!
//! MIT 6.837 (Fall 2001, lecture 18) let its students walk around cubes and see the affine warp, the cure and
//! the half-cure by subdivision, the seams of Gouraud shading, tiling and transparency; Brackeen (2003,
//! chapter 7) compares forward with inverse mapping and builds the O-U-V frame. [`demo`] draws each of them
//! with the renderer's own named methods, measures what the picture shows and holds it against the closed
//! form.

mod paint;
mod sheet;

use crate::picture::Picture;

/// Edge of a panel in pixels when the caller has no wish.
pub const DEFAULT_SIZE: u32 = 384;

/// A figure that a demo measures on its own pictures and what theory says it must be.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// What is claimed, in words.
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
        Self { text: text.into(), measured, expected, tolerance }
    }

    /// Whether the measured figure supports the claim; a NaN never does.
    pub fn holds(&self) -> bool {
        (self.measured - self.expected).abs() <= self.tolerance
    }
}

impl std::fmt::Display for Claim {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verdict = if self.holds() { "holds" } else { "FAILS" };
        let (measured, expected) = (figure(self.measured), figure(self.expected));
        write!(f, "{verdict}: {}: measured {measured}, expected {expected}", self.text)?;
        if self.tolerance > 0.0 {
            write!(f, " +- {}", figure(self.tolerance))?;
        }
        Ok(())
    }
}

/// Four significant digits, or a whole number as it is.
fn figure(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if !value.is_finite() || value.fract() == 0.0 && size < 1e7 => format!("{value}"),
        _ if !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        _ => format!("{value:.*}", (3 - size.log10().floor() as i32).clamp(0, 6) as usize),
    }
}

/// What [`demo`] gives back.
#[derive(Clone, Debug)]
pub struct DemoPicture {
    /// Title, panels with captions, and the claims with their verdicts.
    pub image: Picture,
    /// The panels' captions, left to right.
    pub captions: Vec<String>,
    /// What was measured.
    pub claims: Vec<Claim>,
}

/// One picture of a sheet with its words.
#[derive(Debug)]
struct Panel {
    picture: Picture,
    title: String,
    caption: String,
}

#[cfg(test)]
mod scratch {
    #[test]
    fn look() {
        use super::*;
        let panel = |t: &str, p: Picture| Panel { picture: p, title: t.into(), caption: "A caption that is long enough to need more than one line of the panel.".into() };
        let s = sheet::sheet("The textures of the demos", vec![
            panel("Checker", paint::checker(384, 8, [40,50,70,255],[240,235,220,255])),
            panel("Letters", paint::letters(384)), panel("Bricks", paint::bricks(384)), panel("Lattice", paint::lattice(384)), panel("Cow", paint::cow_photo(384))],
            vec![Claim::new("largest error of the affine image against the closed form, of the range", 0.1712, 0.17157, 0.0017), Claim::new("bad", 1.0, 2.0, 0.0)]);
        image::save_buffer("/tmp/texmap/lab_look.png", s.image.rgba(), s.image.width(), s.image.height(), image::ExtendedColorType::Rgba8).unwrap();
    }
}
