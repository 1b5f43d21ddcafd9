//! Maps that stand for light and shape: skies, lamps, slopes, normals, ramps, a label, baked light.

use texmap_math::deterministic_f64;

use super::brick;
use crate::picture::{Picture, blend, clouds, mix, rgb, smooth_step};

/// A sky by longitude and latitude over a dark ground, for the chart `lat-long`.
pub(crate) fn sky() -> Picture {
    Picture::from_fn(128, 64, |x, y| {
        let v = (f64::from(y) + 0.5) / 64.0;
        let (angle, height) = (f64::from(x) / 128.0, 0.5 - v);
        if height < 0.0 {
            return blend(
                rgb(0x6A6456),
                rgb(0x2E3430),
                smooth_step(0.0, -0.35, height),
            );
        }
        let cloud = clouds(angle * 8.0, v * 8.0, 8, 31);
        let blue = blend(rgb(0xBFD8EA), rgb(0x2F5FA8), smooth_step(0.0, 0.45, height));
        let sky = blend(blue, rgb(0xF4F2EC), smooth_step(0.45, 0.75, cloud));
        // A sun.
        let (dx, dy) = ((angle - 0.63) * 2.0, height - 0.28);
        let sun = 1.0 - (dx * dx + dy * dy) / 0.004;
        blend(sky, rgb(0xFFF6D8), smooth_step(0.0, 0.5, sun))
    })
}

/// Two windows in a dark room by longitude and latitude: area lights.
pub(crate) fn lamps() -> Picture {
    Picture::from_fn(64, 32, |x, y| {
        let within = |from: [u32; 2], to: [u32; 2]| {
            (from[0]..to[0]).contains(&x) && (from[1]..to[1]).contains(&y)
        };
        if within([18, 7], [26, 13]) {
            rgb(0xFFF4DC)
        } else if within([36, 5], [40, 15]) {
            rgb(0x9CC4FF)
        } else {
            rgb(0x06070A)
        }
    })
}

/// Height of round studs, 0 to 1, and its slopes over the whole picture; it repeats.
fn studs(x: u32, y: u32) -> [f64; 2] {
    let turn = |c: u32| {
        deterministic_f64::sin_cos((f64::from(c) + 0.5) / 64.0 * 4.0 * core::f64::consts::TAU)
    };
    let ((sx, cx), (sy, cy)) = (turn(x), turn(y));
    // h = (1 - cos 4 tau u) (1 - cos 4 tau v) / 4
    let slope = core::f64::consts::TAU;
    [slope * sx * (1.0 - cy), slope * (1.0 - cx) * sy]
}

/// Slopes of studs as colours: red along u, green up the picture; half is level and 1 is 16 over the whole picture.
pub(crate) fn offsets() -> Picture {
    Picture::from_fn(64, 64, |x, y| {
        let [right, down] = studs(x, y);
        let code = |slope: f64| (255.0 * (0.5 + 0.5 * slope / 16.0) + 0.5) as u32;
        rgb(code(right) << 16 | code(-down) << 8 | 128)
    })
}

/// Normals of the studs, y up the picture.
pub(crate) fn normals() -> Picture {
    Picture::from_fn(64, 64, |x, y| {
        let [right, down] = studs(x, y).map(|slope| slope * 0.06);
        let length = (right * right + down * down + 1.0).sqrt();
        let code = |c: f64| (255.0 * (0.5 + 0.5 * c / length) + 0.5) as u32;
        rgb(code(-right) << 16 | code(down) << 8 | code(1.0))
    })
}

/// Heights of bricks over their mortar.
pub(crate) fn brick_heights() -> Picture {
    let bricks = brick();
    Picture::from_fn(128, 128, |x, y| {
        let [r, g, b, _] = bricks.get(2 * x, 2 * y);
        // Clay is redder than mortar.
        let clay = f64::from(r) - 0.5 * (f64::from(g) + f64::from(b));
        let code = (255.0 * smooth_step(20.0, 60.0, clay)) as u32;
        rgb(code << 16 | code << 8 | code)
    })
}

/// A row of colours from cold to hot.
pub(crate) fn heat() -> Picture {
    Picture::from_fn(32, 1, |x, _| {
        let t = f64::from(x) / 31.0;
        let cold = blend(rgb(0x10205A), rgb(0xC83C28), smooth_step(0.0, 0.6, t));
        blend(cold, rgb(0xFFF0A0), smooth_step(0.55, 1.0, t))
    })
}

/// The same, nearly clear at its cold end: a transfer function.
pub(crate) fn flames() -> Picture {
    let heat = heat();
    Picture::from_fn(32, 1, |x, _| {
        let [r, g, b, _] = heat.get(x, 0);
        [r, g, b, mix(8.0, 255.0, f64::from(x) / 31.0) as u8]
    })
}

/// Three tones for cel shading.
pub(crate) fn tones() -> Picture {
    Picture::from_fn(16, 1, |x, _| match x {
        0..4 => rgb(0x5A5A66),
        4..9 => rgb(0xB0B0B0),
        _ => rgb(0xFFFFFF),
    })
}

/// A round label with a soft rim on a clear ground.
pub(crate) fn label() -> Picture {
    let mut picture = Picture::from_fn(64, 64, |x, y| {
        let (dx, dy) = ((f64::from(x) - 31.5) / 28.0, (f64::from(y) - 31.5) / 28.0);
        let inside = 1.0 - (dx * dx + dy * dy).sqrt();
        let [r, g, b, _] = if inside > 0.14 {
            rgb(0xF2C53A)
        } else {
            rgb(0x7A1E2A)
        };
        [r, g, b, (255.0 * smooth_step(0.0, 0.1, inside)) as u8]
    });
    picture.text(17, 24, 2, rgb(0x20242C), "MAP");
    picture
}

/// Baked light for the cube whose faces lie in cells of 3 x 2: a lamp above and to its right.
pub(crate) fn baked() -> Picture {
    const FACES: [f64; 6] = [0.75, 0.16, 0.95, 0.06, 0.5, 0.2];
    Picture::from_fn(96, 64, |x, y| {
        let face = (x / 32 + 3 * (y / 32)) as usize;
        let (u, v) = (f64::from(x % 32) / 31.0, f64::from(y % 32) / 31.0);
        let light = FACES[face] * (0.55 + 0.45 * (1.0 - v)) * (0.75 + 0.25 * u);
        let code = (255.0 * light) as u32;
        rgb((code << 16) | (code << 8) | (code * 15 / 16))
    })
}

/// A cloud of 24 x 24 x 24 voxels as a NumPy array of bytes.
pub(crate) fn cloud() -> Vec<u8> {
    const SIDE: u32 = 24;
    let mut header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (24, 24, 24), }".to_vec();
    header.resize(117, b' ');
    header.push(b'\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header);
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
    for (z, y, x) in (0..SIDE * SIDE * SIDE).map(|i| (i / SIDE / SIDE, i / SIDE % SIDE, i % SIDE)) {
        let (px, py, pz) = (place(x), place(y), place(z));
        let ball = 1.0 - (px * px + py * py + pz * pz);
        let fold = clouds(px * 2.0 + 4.0 + pz, py * 2.0 + 4.0 - pz, 16, 57);
        let dense = smooth_step(0.0, 0.8, ball + 0.7 * (fold - 0.5));
        bytes.push((255.0 * dense) as u8);
    }
    bytes
}
