//! Pictures that are computed, not painted: a grid of RGBA8 texels, tileable noise and the two encoders.

use image::{
    ExtendedColorType, ImageEncoder, codecs::gif::GifEncoder, codecs::png,
    codecs::webp::WebPEncoder,
};

/// Red, green, blue and alpha of one texel, sRGB with straight alpha.
pub(crate) type Rgba = [u8; 4];

/// A picture with its rows from top to bottom.
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) texels: Vec<Rgba>,
}

impl Picture {
    pub(crate) fn from_fn(width: u32, height: u32, texel: impl Fn(u32, u32) -> Rgba) -> Self {
        let texels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| texel(x, y))
            .collect();
        Self {
            width,
            height,
            texels,
        }
    }

    pub(crate) fn get(&self, x: u32, y: u32) -> Rgba {
        self.texels[(y * self.width + x) as usize]
    }

    pub(crate) fn set(&mut self, x: u32, y: u32, texel: Rgba) {
        self.texels[(y * self.width + x) as usize] = texel;
    }

    /// Writes `text` with its upper left corner at (x, y), each dot `size` texels wide; what falls outside is cut.
    pub(crate) fn text(&mut self, x: u32, y: u32, size: u32, color: Rgba, text: &str) {
        for (i, c) in text.chars().enumerate() {
            let glyph = crate::dots::dots(c).unwrap_or_default();
            for (row, bits) in glyph.iter().enumerate() {
                for column in (0..8).filter(|column| bits >> column & 1 == 1) {
                    let (left, top) = (x + (i as u32 * 8 + column) * size, y + row as u32 * size);
                    for (dx, dy) in (0..size * size).map(|k| (k % size, k / size)) {
                        if left + dx < self.width && top + dy < self.height {
                            self.set(left + dx, top + dy, color);
                        }
                    }
                }
            }
        }
    }

    /// PNG, without the alpha channel when every texel is opaque.
    pub(crate) fn png(&self) -> Vec<u8> {
        let opaque = self.texels.iter().all(|t| t[3] == 255);
        let (bytes, color): (Vec<u8>, _) = if opaque {
            (
                self.texels
                    .iter()
                    .flat_map(|t| [t[0], t[1], t[2]])
                    .collect(),
                ExtendedColorType::Rgb8,
            )
        } else {
            (self.texels.concat(), ExtendedColorType::Rgba8)
        };
        let mut out = Vec::new();
        png::PngEncoder::new_with_quality(
            &mut out,
            png::CompressionType::Best,
            png::FilterType::Adaptive,
        )
        .write_image(&bytes, self.width, self.height, color)
        .expect("the texels fill the picture");
        out
    }

    /// Lossless WebP.
    pub(crate) fn webp(&self) -> Vec<u8> {
        let mut out = Vec::new();
        WebPEncoder::new_lossless(&mut out)
            .write_image(
                &self.texels.concat(),
                self.width,
                self.height,
                ExtendedColorType::Rgba8,
            )
            .expect("the texels fill the picture");
        out
    }

    /// GIF; exact, because at most 256 colours are used and alpha is 0 or 255 (asserted).
    pub(crate) fn gif(&self) -> Vec<u8> {
        let mut colors = self.texels.clone();
        colors.sort_unstable();
        colors.dedup();
        assert!(
            colors.len() <= 256,
            "{} colours do not fit a GIF palette",
            colors.len()
        );
        assert!(
            colors.iter().all(|c| c[3] == 0 || c[3] == 255),
            "GIF has one transparent index, no partial alpha"
        );
        let mut out = Vec::new();
        GifEncoder::new(&mut out)
            .encode(
                &self.texels.concat(),
                self.width,
                self.height,
                ExtendedColorType::Rgba8,
            )
            .expect("the texels fill the picture");
        out
    }
}

/// A well-mixed integer for a lattice point (the finaliser of Wellons's lowbias32).
pub(crate) fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1)
        ^ (y as u32).wrapping_mul(0x85EB_CA77)
        ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
    h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

/// [`hash`] as a fraction in [0, 1).
pub(crate) fn chance(x: i32, y: i32, seed: u32) -> f64 {
    f64::from(hash(x, y, seed)) / 4_294_967_296.0
}

/// Value noise in [0, 1) that repeats after `period` cells on both axes.
pub(crate) fn noise(x: f64, y: f64, period: i32, seed: u32) -> f64 {
    let (ix, iy) = (x.floor(), y.floor());
    let (fx, fy) = (fade(x - ix), fade(y - iy));
    let (ix, iy) = (ix as i32, iy as i32);
    let at = |dx: i32, dy: i32| {
        chance(
            (ix + dx).rem_euclid(period),
            (iy + dy).rem_euclid(period),
            seed,
        )
    };
    mix(mix(at(0, 0), at(1, 0), fx), mix(at(0, 1), at(1, 1), fx), fy)
}

/// Four octaves of [`noise`], in [0, 1).
pub(crate) fn clouds(x: f64, y: f64, period: i32, seed: u32) -> f64 {
    (0..4)
        .map(|o| {
            noise(
                x * f64::from(1 << o),
                y * f64::from(1 << o),
                period << o,
                seed + o,
            ) / f64::from(2 << o)
        })
        .sum::<f64>()
        / 0.9375
}

fn fade(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

pub(crate) fn mix(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(crate) fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    let t = (x - low) / (high - low);
    if t <= 0.0 {
        0.0
    } else if t >= 1.0 {
        1.0
    } else {
        fade(t)
    }
}

/// A colour from a number like 0xRRGGBB.
pub(crate) fn rgb(hex: u32) -> Rgba {
    [(hex >> 16) as u8, (hex >> 8) as u8, hex as u8, 255]
}

/// `color` times `percent` / 100, rounded down, per channel.
pub(crate) fn shade(color: Rgba, percent: u32) -> Rgba {
    let channel = |c: u8| (u32::from(c) * percent / 100).min(255) as u8;
    [
        channel(color[0]),
        channel(color[1]),
        channel(color[2]),
        color[3],
    ]
}

/// The colour `t` of the way from `a` to `b`.
pub(crate) fn blend(a: Rgba, b: Rgba, t: f64) -> Rgba {
    core::array::from_fn(|i| (mix(f64::from(a[i]), f64::from(b[i]), t) + 0.5).floor() as u8)
}
