//! The words of `filter`, `wrap`, `interp` and their like.
//!
//! The crates that own the methods read the words; this module writes them. The program's
//! flags use the same words.

use texmap_raster::Interp;
use texmap_sample::{Cubic, Filter, Wrap};

/// Allowed words of `filter`.
pub const FILTERS: &str = "nearest, bilinear, bicubic:catmull-rom|mitchell|b-spline, mip-nearest, \
     bilinear-mip-nearest, trilinear, anisotropic:2..16, ewa:1..16[:0.25..2], summed-area";
/// Allowed words of `wrap`.
pub const WRAPS: &str =
    "repeat, mirrored-repeat, clamp-to-edge, clamp-to-border, mirror-clamp-to-edge";
/// Allowed words of [`parse_interp`].
pub const INTERPS: &str = "perspective, affine, subdivided:N, span:N, within:TOLERANCE";

/// `None` for filters that the language has no word for (OpenGL's free combinations).
pub fn filter(filter: Filter) -> Option<String> {
    Some(match filter {
        Filter::Nearest => "nearest".into(),
        Filter::Bilinear => "bilinear".into(),
        Filter::Bicubic(Cubic::CatmullRom) => "bicubic:catmull-rom".into(),
        Filter::Bicubic(Cubic::Mitchell) => "bicubic:mitchell".into(),
        Filter::Bicubic(Cubic::BSpline) => "bicubic:b-spline".into(),
        Filter::MipNearest => "mip-nearest".into(),
        Filter::BilinearMipNearest => "bilinear-mip-nearest".into(),
        Filter::Trilinear => "trilinear".into(),
        Filter::SummedArea => "summed-area".into(),
        Filter::Anisotropic(n) => format!("anisotropic:{n}"),
        Filter::Ewa {
            ratio,
            percent: 100,
        } => format!("ewa:{ratio}"),
        Filter::Ewa { ratio, percent } => format!("ewa:{ratio}:{}", f32::from(percent) / 100.0),
        _ => return None,
    })
}

/// The word of a wrap mode.
pub fn wrap(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::MirroredRepeat => "mirrored-repeat",
        Wrap::ClampToEdge => "clamp-to-edge",
        Wrap::ClampToBorder => "clamp-to-border",
        Wrap::MirrorClampToEdge => "mirror-clamp-to-edge",
    }
}

/// The word of an interpolation and its parameter.
pub fn interp(interp: Interp) -> String {
    match interp {
        Interp::Perspective => "perspective".into(),
        Interp::Affine => "affine".into(),
        Interp::Subdivided(n) => format!("subdivided:{n}"),
        Interp::Span(n) => format!("span:{n}"),
        Interp::WithinError(tolerance) => format!("within:{tolerance:?}"),
    }
}

/// `None` for a word that names no method or for a parameter out of range.
pub fn parse_interp(text: &str) -> Option<Interp> {
    let (name, parameter) = text
        .split_once(':')
        .map_or((text, None), |(n, p)| (n, Some(p)));
    let whole = || parameter?.parse::<u32>().ok();
    match (name, parameter) {
        ("perspective", None) => Some(Interp::Perspective),
        ("affine", None) => Some(Interp::Affine),
        ("subdivided", _) => whole()
            .filter(|n| (1..=texmap_raster::MAX_SUBDIVISIONS).contains(n))
            .map(Interp::Subdivided),
        ("span", _) => whole().filter(|n| *n > 0).map(Interp::Span),
        ("within", Some(p)) => {
            let tolerance = p.parse::<f32>().ok().filter(|t| *t > 0.0 && t.is_finite());
            tolerance.map(Interp::WithinError)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_reads_back() {
        for text in [
            "nearest",
            "bilinear",
            "bicubic:catmull-rom",
            "bicubic:mitchell",
            "bicubic:b-spline",
            "mip-nearest",
            "bilinear-mip-nearest",
            "trilinear",
            "anisotropic:16",
            "ewa:8",
            "ewa:16:0.75",
            "ewa:4:1.2",
            "summed-area",
        ] {
            let read: Filter = text.parse().unwrap();
            assert_eq!(filter(read).as_deref(), Some(text));
        }
        for text in ["ewa:8:1", "ewa:8:1.00"] {
            assert_eq!(filter(text.parse().unwrap()).as_deref(), Some("ewa:8"));
        }
        for text in [
            "ewa:8:",
            "ewa::1",
            "ewa:8:0.24",
            "ewa:8:2.01",
            "ewa:8:0.755",
            "ewa:8:nan",
            "ewa:8:1:1",
            "anisotropic:8:1",
        ] {
            assert!(text.parse::<Filter>().is_err(), "{text}");
        }
        for text in WRAPS.split(", ") {
            assert_eq!(wrap(text.parse().unwrap()), text);
        }
        for text in [
            "perspective",
            "affine",
            "subdivided:4",
            "span:16",
            "within:0.5",
        ] {
            assert_eq!(interp(parse_interp(text).unwrap()), text);
        }
        for text in [
            "span",
            "span:0",
            "span:-1",
            "subdivided:0",
            "within:0",
            "within:nan",
            "within:inf",
            "affine:2",
        ] {
            assert_eq!(parse_interp(text), None, "{text}");
        }
    }
}
