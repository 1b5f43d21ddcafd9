//! Procedural textures of the benchmark scenes, in integer arithmetic.
//!
//! Every generator gives straight RGBA8 rows with alpha 255; row 0 is texture coordinate t = 0.

use texmap_math::color::{linear_to_srgb8, srgb8_to_linear, unit_to_u8};

/// Side of the base and the normal texture in texels.
pub const BASE_SIZE: u32 = 1024;
/// Side of a cube face and of the projector's picture in texels.
pub const FACE_SIZE: u32 = 512;

/// A well-mixed hash of two integers (multiply-xorshift).
#[must_use]
pub fn hash(x: u32, y: u32) -> u32 {
    let mut h = x
        .wrapping_mul(0x9E37_79B1)
        .wrapping_add(y.wrapping_mul(0x85EB_CA77));
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297A_2D39);
    h ^ (h >> 15)
}

/// 1024 x 1024: a checker of 64 texels with a gradient and noise of +-16.
#[must_use]
pub fn base() -> Vec<u8> {
    let last = BASE_SIZE as i32 - 1;
    texels(BASE_SIZE, |x, y| {
        let light = ((x >> 6) ^ (y >> 6)) & 1 != 0;
        let noise = (hash(x as u32, y as u32) & 31) as i32 - 16;
        let pick = |a: i32, b: i32| if light { a } else { b };
        [
            pick(200, 60) + x * 40 / last + noise,
            pick(180, 80) + y * 40 / last + noise,
            pick(150, 110) + (x + y) * 20 / last + noise,
        ]
    })
}

/// 1024 x 1024: the normal map of pyramids of period 128 with noise; tiles.
#[must_use]
pub fn normal() -> Vec<u8> {
    fn height(x: i32, y: i32) -> i32 {
        ((x & 127) - 64).abs() * ((y & 127) - 64).abs() / 16
            + (hash((x & 1023) as u32, (y & 1023) as u32) & 7) as i32
    }
    texels(BASE_SIZE, |x, y| {
        let nx = f64::from(height(x - 1, y) - height(x + 1, y)) / 32.0;
        let ny = f64::from(height(x, y - 1) - height(x, y + 1)) / 32.0;
        let scale = 1.0 / (nx * nx + ny * ny + 1.0).sqrt();
        [nx * scale, ny * scale, scale].map(|c| (127.5 + 127.5 * c + 0.5).floor() as i32)
    })
}

/// One 512 x 512 face (0..6: +X -X +Y -Y +Z -Z) of the environment cube.
#[must_use]
pub fn cube_face(face: u32) -> Vec<u8> {
    const TINTS: [[i32; 3]; 6] = [
        [200, 80, 80],
        [80, 200, 80],
        [80, 80, 200],
        [200, 200, 80],
        [200, 80, 200],
        [80, 200, 200],
    ];
    let tint = TINTS[face as usize % 6];
    let last = FACE_SIZE as i32 - 1;
    texels(FACE_SIZE, |x, y| {
        let strength = if ((x >> 5) ^ (y >> 5)) & 1 != 0 { 4 } else { 2 };
        let noise = (hash(x as u32 + FACE_SIZE * face, y as u32) & 15) as i32 - 8;
        let ramp = [x, y, x + y];
        core::array::from_fn(|i| tint[i] * strength / 4 + ramp[i] * 50 / last + noise)
    })
}

/// 512 x 512: coloured rings with a black border of four texels, the projector's picture.
#[must_use]
pub fn slide() -> Vec<u8> {
    let last = FACE_SIZE as i32 - 1;
    texels(FACE_SIZE, |x, y| {
        if x < 4 || y < 4 || x > last - 4 || y > last - 4 {
            return [0; 3];
        }
        let (dx, dy) = (2 * x - last, 2 * y - last);
        let ring = ((dx * dx + dy * dy) / 1024 / 24) & 3;
        core::array::from_fn(|i| match ring {
            3 => 220,
            r if r == i as i32 => 255,
            _ => 40,
        })
    })
}

/// The mip chain of a square power-of-two texture: 2x2 box, `(a + b + c + d + 2) >> 2` a channel,
/// each level from the one above, down to 1x1. Level 0 comes first.
#[must_use]
pub fn mip_chain(level0: Vec<u8>, size: u32) -> Vec<Vec<u8>> {
    halved(level0, size, |four| {
        ((four.map(u32::from).iter().sum::<u32>() + 2) >> 2) as u8
    })
}

/// [`mip_chain`] of sRGB texels: means of the light of level 0, each level encoded once.
#[must_use]
pub fn mip_chain_srgb(level0: Vec<u8>, size: u32) -> Vec<Vec<u8>> {
    let light = level0
        .iter()
        .enumerate()
        .map(|(i, c)| match i % 4 {
            3 => f32::from(*c) / 255.0,
            _ => srgb8_to_linear(*c),
        })
        .collect();
    let chain = halved(light, size, |four| four.iter().sum::<f32>() * 0.25);
    let encode = |(i, c): (usize, &f32)| match i % 4 {
        3 => unit_to_u8(*c),
        _ => linear_to_srgb8(*c),
    };
    chain
        .iter()
        .map(|level| level.iter().enumerate().map(encode).collect())
        .collect()
}

/// The levels of a square power-of-two texture of four channels, each of the means of four of the level above.
fn halved<T: Copy>(level0: Vec<T>, size: u32, mean: impl Fn([T; 4]) -> T) -> Vec<Vec<T>> {
    let mut levels = vec![level0];
    let mut n = size as usize;
    while n > 1 {
        let above = &levels[levels.len() - 1];
        let m = n / 2;
        let next = (0..m * m * 4)
            .map(|i| {
                let (x, y, c) = (i / 4 % m, i / 4 / m, i % 4);
                let at = |dx, dy| above[((2 * y + dy) * n + 2 * x + dx) * 4 + c];
                mean([at(0, 0), at(1, 0), at(0, 1), at(1, 1)])
            })
            .collect();
        levels.push(next);
        n = m;
    }
    levels
}

fn texels(size: u32, texel: impl Fn(i32, i32) -> [i32; 3]) -> Vec<u8> {
    let mut out = Vec::with_capacity((size * size * 4) as usize);
    for y in 0..size as i32 {
        for x in 0..size as i32 {
            out.extend(texel(x, y).map(|c| c.clamp(0, 255) as u8));
            out.push(255);
        }
    }
    out
}
