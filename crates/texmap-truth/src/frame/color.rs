//! Colours of the truth: transfer curves, premultiplication, luminance.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec3, DVec4};
use texmap_scene::{ColorMode, Scene};

/// sRGB to linear light (IEC 61966-2-1).
pub(super) fn decode(c: f64) -> f64 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        deterministic_f64::pow((c + 0.055) / 1.055, 2.4)
    }
}

/// Linear light to sRGB.
pub(super) fn encode(c: f64) -> f64 {
    if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * deterministic_f64::pow(c, 1.0 / 2.4) - 0.055
    }
}

/// The scene's background, linear light, premultiplied.
pub(super) fn background(scene: &Scene) -> DVec4 {
    let [r, g, b, a] = scene.background.map(f64::from);
    let light = |c: f64| match scene.color {
        ColorMode::Srgb => decode(c),
        ColorMode::Raw => c,
    };
    DVec4::new(light(r) * a, light(g) * a, light(b) * a, a)
}

/// A premultiplied colour without its alpha; black where nothing is left of it.
pub(super) fn straight(color: DVec4) -> DVec3 {
    if color.w > 0.0 {
        color.truncate() / color.w
    } else {
        DVec3::ZERO
    }
}

/// One premultiplied colour over another.
pub(super) fn over(top: DVec4, below: DVec4) -> DVec4 {
    top + below * (1.0 - top.w)
}

/// Luminance of linear light (Rec. ITU-R BT.709).
pub(super) fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// A stored vector in f64.
pub(crate) fn wide(a: [f32; 3]) -> DVec3 {
    DVec3::from_array(a.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_curves_invert_each_other() {
        for i in 0..=100 {
            let c = f64::from(i) / 100.0;
            assert!((encode(decode(c)) - c).abs() < 1e-7, "{c}");
        }
        assert!((decode(0.5) - 0.214_041_140_482_232_55).abs() < 1e-12);
    }
}
