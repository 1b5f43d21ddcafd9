//! Walls, floor and ceiling of the Doom room, in few colours so that a GIF holds them exactly.

use crate::picture::{Picture, Rgba, chance, clouds, hash, rgb, shade};

/// One of eight levels of `color`, from noise in [0, 1).
fn grained(color: u32, noise: f64, low: u32, high: u32) -> Rgba {
    shade(
        rgb(color),
        low + (noise * 8.0).floor() as u32 * (high - low) / 7,
    )
}

/// A woven carpet with a diamond border every 128 texels.
pub(crate) fn carpet() -> Picture {
    Picture::from_fn(128, 128, |x, y| {
        let (dx, dy) = (
            (x as i32 - 64).unsigned_abs(),
            (y as i32 - 64).unsigned_abs(),
        );
        let diamond = dx + dy;
        let color = match diamond {
            0..=9 => 0xE0B050,
            10..=13 => 0x2C1A4A,
            30..=33 => 0xE0B050,
            34..=50 => 0x7A1E3C,
            51..=54 => 0xE0B050,
            114.. => 0xE0B050,
            _ => 0x4A2466,
        };
        let weave = if (x / 2 + y / 2) % 2 == 0 { 0.0 } else { 0.5 };
        grained(
            color,
            weave + 0.5 * chance((x / 2) as i32, (y / 2) as i32, 3),
            78,
            106,
        )
    })
}

/// An acoustic tile in its metal frame.
pub(crate) fn ceiling_tile() -> Picture {
    Picture::from_fn(128, 128, |x, y| {
        let rim = x.min(y).min(127 - x).min(127 - y);
        match rim {
            0..=2 => grained(0x8A8E96, 0.5, 80, 100),
            3 => rgb(0x5A5E66),
            _ => {
                let (cx, cy) = (x / 8, y / 8);
                let h = hash(cx as i32, cy as i32, 31);
                let (hx, hy) = (1 + h % 5, 1 + (h >> 8) % 5);
                let hole = (x % 8).abs_diff(hx) + (y % 8).abs_diff(hy) <= (h >> 16) % 2;
                if hole {
                    rgb(0x77756C)
                } else {
                    grained(
                        0xE4E0D2,
                        clouds(f64::from(x) / 16.0, f64::from(y) / 16.0, 8, 40),
                        90,
                        104,
                    )
                }
            }
        }
    })
}

/// Four bands, one above the other, each for a wall of four times its height: stone with windows, panels with
/// a door, brick with torches, stone with pictures.
pub(crate) fn walls() -> Picture {
    Picture::from_fn(1024, 1024, |x, y| {
        let (band, y) = (y / 256, y % 256);
        match band {
            0 => windows(x, y),
            1 => panels(x, y),
            2 => torches(x, y),
            _ => pictures(x, y),
        }
    })
}

fn stone(x: u32, y: u32) -> Rgba {
    let course = y / 32;
    let along = x + course % 2 * 32;
    let (bx, by) = (along % 64, y % 32);
    if bx < 2 || by < 2 {
        return rgb(0x4E4A50);
    }
    let tint = chance((along / 64 % 16) as i32, course as i32, 51);
    let base = [0x8C8890, 0x827E88, 0x96909A, 0x787480][(tint * 4.0) as usize];
    let rim = if by < 4 || bx < 4 {
        0.18
    } else if by > 29 || bx > 61 {
        -0.2
    } else {
        0.0
    };
    let noise = 0.75 * clouds(f64::from(x) / 16.0, f64::from(y) / 16.0, 64, 60)
        + 0.25 * chance(x as i32, y as i32, 61)
        + rim;
    grained(base, noise.clamp(0.0, 0.999), 76, 112)
}

/// Stone with three arched windows that show sky, hills and grass; the last tenth stays plain for the pillar.
fn windows(x: u32, y: u32) -> Rgba {
    for centre in [160, 460, 760] {
        let (dx, top) = ((x as i32 - centre) as f64, 90.0);
        let arch = |half: f64| {
            let dy = (f64::from(y) - top).min(0.0);
            dx * dx + dy * dy < half * half && y < 200
        };
        if arch(50.0) {
            if dx.abs() < 2.5 || (f64::from(y) - 120.0).abs() < 2.5 {
                return rgb(0x5A3C28);
            }
            return view(x, y);
        }
        if arch(62.0) || ((200..212).contains(&y) && dx.abs() < 68.0) {
            return grained(
                0xB4A890,
                chance((x / 2) as i32, (y / 2) as i32, 70),
                88,
                104,
            );
        }
    }
    stone(x, y)
}

fn view(x: u32, y: u32) -> Rgba {
    let hill = 150.0 + 26.0 * (clouds(f64::from(x) / 60.0, 3.5, 64, 80) - 0.5) * 2.0;
    let y = f64::from(y);
    if y > hill + 24.0 {
        grained(0x58A03C, chance(x as i32, y as i32, 81), 84, 108)
    } else if y > hill {
        grained(0x3C7C4C, chance(x as i32 / 2, y as i32 / 2, 82), 90, 104)
    } else if clouds(f64::from(x) / 40.0, y / 24.0, 64, 83) > 0.58 {
        rgb(0xF4F8FC)
    } else {
        grained(0x7CB8F0, ((y - 40.0) / 130.0).clamp(0.0, 0.999), 92, 108)
    }
}

/// Wooden panels with a door in the middle.
fn panels(x: u32, y: u32) -> Rgba {
    let grain = |x: u32, y: u32, color: u32| {
        let rings = clouds(f64::from(x) / 6.0, f64::from(y) / 90.0, 256, 90);
        grained(color, rings, 78, 108)
    };
    let dx = (x as i32 - 512).unsigned_abs();
    if dx < 72 && y > 40 {
        if dx > 62 || y < 50 {
            return grain(y, x, 0x5C3820);
        }
        let knob = (i64::from(x) - 560).pow(2) + (i64::from(y) - 160).pow(2);
        if knob < 40 {
            return rgb(if knob < 12 { 0xFFE090 } else { 0xC89A34 });
        }
        let inset = dx > 8 && dx < 54 && (y % 66 > 12) && y > 62;
        return grain(x, y, if inset { 0x9A5C30 } else { 0x7A4826 });
    }
    if !(22..=240).contains(&y) || (132..142).contains(&y) {
        return grain(y, x, 0x5C3820);
    }
    let (px, rim) = (x % 128, x % 128 < 6 || y % 140 < 4);
    grain(
        x + px / 64,
        y,
        if rim {
            0x6A4024
        } else if (20..108).contains(&px) {
            0xA4703E
        } else {
            0x8A5A30
        },
    )
}

/// Red brick with torches.
fn torches(x: u32, y: u32) -> Rgba {
    let (tx, ty) = (f64::from(x % 256) - 128.0, f64::from(y) - 110.0);
    let flame = tx * tx / 160.0 + (ty + 26.0) * (ty + 26.0) / 620.0;
    if ty < 4.0 && flame < 1.0 {
        return rgb(if flame < 0.25 {
            0xFFF6C0
        } else if flame < 0.6 {
            0xFFC83C
        } else {
            0xF07A1C
        });
    }
    if tx.abs() < 6.0 && (0.0..50.0).contains(&ty) || tx.abs() < 14.0 && (0.0..9.0).contains(&ty) {
        return rgb(if tx < -2.0 { 0x6A6058 } else { 0x46403C });
    }
    let course = y / 16;
    let along = x + course % 2 * 16;
    if along % 32 < 2 || y % 16 < 2 {
        return rgb(0x8E8478);
    }
    // Warmer and brighter near a flame.
    let glow = (1.0 - (tx * tx + (ty + 20.0) * (ty + 20.0)) / 12000.0).max(0.0);
    let noise = 0.6 * chance((along / 32 % 32) as i32, course as i32, 95)
        + 0.2 * chance(x as i32, y as i32, 96)
        + 0.2 * glow;
    grained(
        if glow > 0.35 { 0xC05A34 } else { 0x9A4230 },
        noise.min(0.999),
        80,
        108,
    )
}

/// Stone with framed pictures of plain shapes.
fn pictures(x: u32, y: u32) -> Rgba {
    let (px, py) = ((x % 256) as i32 - 128, y as i32 - 116);
    let edge = (px.abs() - 70).max(py.abs() - 54);
    match edge {
        i32::MIN..=-1 => {
            let which = x / 256;
            let (u, v) = (f64::from(px) / 70.0, f64::from(py) / 54.0);
            match which % 4 {
                0 if u * u + v * v < 0.45 => rgb(0xF0C838),
                0 => rgb(0x2C5C9A),
                1 if v > 0.3 - 0.6 * (1.0 - u.abs()) => rgb(0x3E7A50),
                1 => rgb(0xF4C89A),
                2 => rgb(if ((u * 4.0).floor() + (v * 3.0).floor()) as i32 % 2 == 0 {
                    0xD8D0C0
                } else {
                    0xB03A48
                }),
                _ if (v - 0.5 * u * u).abs() < 0.2 => rgb(0xE06A9C),
                _ => rgb(0x5B2A86),
            }
        }
        0..=7 => grained(0xD0A040, f64::from(edge) / 8.0, 76, 108),
        8..=10 => rgb(0x3E3A40),
        _ => stone(x, y),
    }
}
