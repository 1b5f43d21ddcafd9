//! Every picture but the cow's hide.

mod cutout;
mod face;
mod maps;
mod room;

pub(crate) use cutout::{fence, leaf};
pub(crate) use face::face;
pub(crate) use maps::{
    baked, brick_heights, cloud, flames, heat, label, lamps, normals, offsets, sky, tones,
};
pub(crate) use room::{carpet, ceiling_tile, walls};

use crate::picture::{Picture, Rgba, blend, chance, clouds, mix, rgb, shade};

/// 8 x 8 squares of pure white and near black.
pub(crate) fn checker() -> Picture {
    Picture::from_fn(256, 256, |x, y| {
        if (x / 32 + y / 32) % 2 == 0 {
            rgb(0xFFFFFF)
        } else {
            rgb(0x202020)
        }
    })
}

/// 8 x 8 squares of different colours, each with its column letter and row digit; rows are counted from the top.
pub(crate) fn uv_grid() -> Picture {
    let ground = |column: u32, row: u32| -> Rgba {
        let (u, v) = (f64::from(column) / 7.0, f64::from(row) / 7.0);
        let c = blend(
            blend(rgb(0xE8503A), rgb(0x3A78E8), u),
            blend(rgb(0xF2D544), rgb(0x35B36B), u),
            v,
        );
        if (column + row).is_multiple_of(2) {
            c
        } else {
            shade(c, 72)
        }
    };
    let mut picture = Picture::from_fn(512, 512, |x, y| {
        if x % 64 == 0 || y % 64 == 0 || x == 511 || y == 511 {
            rgb(0xFFFFFF)
        } else {
            ground(x / 64, y / 64)
        }
    });
    for (column, row) in (0..64).map(|k| (k % 8, k / 8)) {
        let name = format!("{}{}", char::from(b'A' + column as u8), row + 1);
        picture.text(column * 64 + 9, row * 64 + 21, 3, rgb(0x101018), &name);
        picture.text(column * 64 + 8, row * 64 + 20, 3, rgb(0xFFFFFF), &name);
    }
    picture
}

/// Heights of rolling ground, black to white.
pub(crate) fn hills() -> Picture {
    Picture::from_fn(128, 128, |x, y| {
        let h = clouds(f64::from(x) / 32.0, f64::from(y) / 32.0, 4, 77);
        let code = (255.0 * h) as u32;
        rgb(code << 16 | code << 8 | code)
    })
}

/// Eight courses of bricks; repeats on both axes.
pub(crate) fn brick() -> Picture {
    const CLAY: [u32; 6] = [0xA8442E, 0x9C3E2B, 0xB5523A, 0x8E3626, 0xA94F38, 0xBE5E42];
    Picture::from_fn(256, 256, |x, y| {
        let course = y / 32;
        let along = (x + if course % 2 == 0 { 0 } else { 32 }) % 256;
        let (bx, by) = (along % 64, y % 32);
        let grain = clouds(f64::from(x) / 16.0, f64::from(y) / 16.0, 16, 5);
        let fine = chance(x as i32, y as i32, 9);
        if bx < 3 || by < 3 {
            return shade(rgb(0xBDB3A4), (84.0 + 14.0 * grain + 6.0 * fine) as u32);
        }
        let kind = (chance((along / 64) as i32, course as i32, 21) * 6.0) as usize;
        // Light from above: a bright upper and left rim, a dark lower and right one.
        let rim = if by < 5 || bx < 5 {
            12.0
        } else if by > 29 || bx > 61 {
            -14.0
        } else {
            0.0
        };
        shade(
            rgb(CLAY[kind]),
            (mix(80.0, 112.0, grain) + 8.0 * (fine - 0.5) + rim) as u32,
        )
    })
}
