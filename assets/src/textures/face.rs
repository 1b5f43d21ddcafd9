//! A face as a label texture: shading and features are in the picture, the head below it is plain.

use crate::picture::{Picture, Rgba, blend, noise, rgb, smooth_step};

/// The face looks out of the middle of the picture; the sides and the top are hair, the bottom is the neck.
pub(crate) fn face() -> Picture {
    let mut picture = Picture::from_fn(512, 512, |x, y| {
        let (u, v) = (
            (f64::from(x) + 0.5) / 256.0 - 1.0,
            (f64::from(y) + 0.5) / 256.0 - 1.0,
        );
        texel(u, v)
    });
    // The seam is in the hair at the back: make its two columns meet.
    for y in 0..picture.height {
        let (left, right) = (picture.get(0, y), picture.get(511, y));
        let middle = blend(left, right, 0.5);
        picture.set(0, y, middle);
        picture.set(511, y, middle);
    }
    picture
}

fn texel(u: f64, v: f64) -> Rgba {
    let side = u.abs();
    let skin = blend(
        rgb(0xF0C09A),
        rgb(0xC88A64),
        smooth_step(0.05, 0.45, side) * 0.8 + smooth_step(0.25, 0.75, v) * 0.2,
    );
    let mut c = skin;
    let mut put = |top: u32, coverage: f64| c = blend(c, rgb(top), coverage);
    // Cheeks, eye sockets, shadow under the chin.
    put(
        0xE08878,
        0.45 * round(side - 0.21, v - 0.16, 0.10, 0.08, 0.9),
    );
    put(
        0xA87050,
        0.40 * round(side - 0.14, v + 0.10, 0.11, 0.08, 0.8),
    );
    put(0xA06848, 0.55 * smooth_step(0.52, 0.62, v));
    // Nose: a bright ridge, a shaded side, nostrils.
    put(0xFFDCC0, 0.6 * round(u, v + 0.02, 0.025, 0.14, 0.8));
    put(0xB87C5C, 0.45 * round(u - 0.05, v - 0.02, 0.025, 0.12, 0.9));
    put(0xD89C7C, 0.6 * round(u, v - 0.13, 0.075, 0.05, 0.6));
    put(
        0x6A3828,
        0.8 * round(side - 0.035, v - 0.165, 0.017, 0.011, 0.5),
    );
    // Mouth: lips that thin out toward its corners.
    let lip = v - 0.31 + 0.9 * u * u;
    let full = (1.0 - side * side / 0.024).max(0.0);
    put(
        0xC05858,
        smooth_step(0.158, 0.150, side)
            * smooth_step(0.030 * full + 0.004, 0.030 * full - 0.004, lip.abs()),
    );
    put(
        0x702830,
        smooth_step(0.155, 0.14, side) * smooth_step(0.008, 0.003, lip.abs()),
    );
    put(0xE89890, 0.6 * round(u - 0.02, v - 0.345, 0.05, 0.012, 0.9));
    // Eyes.
    let lid = v + 0.10;
    put(0x5A3424, round(side - 0.14, lid, 0.083, 0.043, 0.1));
    put(0xFAF8F4, round(side - 0.14, lid - 0.004, 0.076, 0.034, 0.1));
    let open = round(side - 0.14, lid - 0.004, 0.076, 0.036, 0.1);
    put(0x3C6E8C, open * round(side - 0.14, lid, 0.034, 0.034, 0.15));
    put(0x10141C, open * round(side - 0.14, lid, 0.016, 0.016, 0.2));
    put(0xFFFFFF, round(u - 0.15, lid + 0.012, 0.008, 0.008, 0.4));
    put(0xFFFFFF, round(u + 0.13, lid + 0.012, 0.008, 0.008, 0.4));
    // Brows.
    let brow = v + 0.20 + 0.10 * side - 1.2 * (side - 0.10) * (side - 0.10);
    let hairs = 0.016 - 0.05 * (side - 0.08).max(0.0);
    put(
        0x3A2418,
        smooth_step(hairs + 0.004, hairs - 0.004, brow.abs())
            * smooth_step(0.055, 0.07, side)
            * smooth_step(0.245, 0.225, side),
    );
    // Ears and hair: strands run down from the crown.
    put(0xD09070, round(side - 0.475, v - 0.02, 0.05, 0.10, 0.2));
    put(0x9A5C44, round(side - 0.48, v - 0.02, 0.025, 0.06, 0.5));
    let strand = noise(u * 48.0 + 96.0, v * 5.0 + 10.0, 96, 14);
    let hair = blend(rgb(0x2E1C14), rgb(0x6E4426), strand);
    let line = smooth_step(
        -0.34,
        -0.40,
        v + 0.05 * noise(u * 12.0 + 24.0, 1.0, 24, 15) - 0.30 * u * u,
    );
    let back =
        smooth_step(0.52, 0.55, side + 0.03 * strand) * smooth_step(0.62, 0.56, v + 0.05 * strand);
    blend(c, hair, if line > back { line } else { back })
}

/// 1 within an ellipse around (0, 0), falling to 0 over the outer share `soft` of its radius.
fn round(x: f64, y: f64, rx: f64, ry: f64, soft: f64) -> f64 {
    let (x, y) = (x / rx, y / ry);
    smooth_step(1.0, 1.0 - soft, (x * x + y * y).sqrt())
}
