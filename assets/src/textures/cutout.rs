//! Pictures with holes: a picket fence and a maple leaf.

use crate::picture::{Picture, blend, clouds, noise, rgb, shade, smooth_step};

/// Four pickets and two rails of painted wood; repeats sideways. The edges of the wood have partial alpha.
pub(crate) fn fence() -> Picture {
    Picture::from_fn(256, 256, |x, y| {
        // Coverage from 4 x 4 points per texel.
        let inside = |f: &dyn Fn(f64, f64) -> bool| {
            (0..16)
                .filter(|k| {
                    f(
                        f64::from(x) + (f64::from(k % 4) + 0.5) / 4.0,
                        f64::from(y) + (f64::from(k / 4) + 0.5) / 4.0,
                    )
                })
                .count()
        };
        let picket = |x: f64, y: f64| {
            let from_middle = (x % 64.0 - 32.0).abs();
            from_middle < 20.0 && y > 12.0 + from_middle * 1.4
        };
        let rail = |_: f64, y: f64| (80.0..104.0).contains(&y) || (188.0..212.0).contains(&y);
        let (pickets, all) = (inside(&picket), inside(&|x, y| picket(x, y) || rail(x, y)));
        let grain = 88.0 + 14.0 * clouds(f64::from(x) / 8.0, f64::from(y) / 64.0, 32, 7);
        let (px, rail_y) = (x % 64, y % 108);
        let nail = (px as i32 - 32).pow(2)
            + ((rail_y as i32) - 92 + if y > 140 { 12 } else { 0 }).pow(2)
            < 8;
        let color = if pickets < 8 {
            shade(rgb(0xCFC9BC), grain as u32 - 10)
        } else if nail {
            rgb(0x6A6660)
        } else if px < 15 {
            shade(rgb(0xFFFFFF), grain as u32)
        } else {
            shade(rgb(if px > 49 { 0xD8D4CC } else { 0xF2EFE8 }), grain as u32)
        };
        [color[0], color[1], color[2], (all * 255 / 16) as u8]
    })
}

/// A maple leaf; `hard` makes alpha 0 or 255 and few colours, as a GIF needs.
pub(crate) fn leaf(hard: bool) -> Picture {
    let size = if hard { 128 } else { 256 };
    Picture::from_fn(size, size, |x, y| {
        let (mut hits, mut vein) = (0u32, 0.0);
        for k in 0..16 {
            let at = |c: u32, k: u32| (f64::from(c) + (f64::from(k) + 0.5) / 4.0) / f64::from(size);
            let (u, v) = (at(x, k % 4) * 2.0 - 1.0, 1.0 - at(y, k / 4) * 2.0);
            hits += u32::from(leaf_holds(u, v));
            vein += veins(u, v) / 16.0;
        }
        let (u, v) = (
            f64::from(x) / f64::from(size),
            f64::from(y) / f64::from(size),
        );
        let autumn = noise(u * 5.0, v * 5.0, 5, 12) * 0.7 + v * 0.3;
        let steps = if hard { 6.0 } else { 64.0 };
        let body = blend(
            rgb(0xE8A028),
            rgb(0xC03818),
            (autumn * steps).floor() / steps,
        );
        let vein = if hard {
            f64::from(u8::from(vein > 0.5))
        } else {
            vein
        };
        let color = blend(body, rgb(0x7A2410), vein);
        let alpha = if hard {
            u8::from(hits >= 8) * 255
        } else {
            (hits * 255 / 16) as u8
        };
        [color[0], color[1], color[2], alpha]
    })
}

/// The five lobes as spikes around the leaf's heart, and the stalk.
const LOBES: [([f64; 2], f64); 5] = [
    ([0.0, 0.92], 0.30),
    ([0.86, 0.42], 0.26),
    ([-0.86, 0.42], 0.26),
    ([0.56, -0.52], 0.20),
    ([-0.56, -0.52], 0.20),
];
const HEART: [f64; 2] = [0.0, -0.28];

fn leaf_holds(u: f64, v: f64) -> bool {
    if u.abs() < 0.022 && (-0.95..HEART[1]).contains(&v) {
        return true;
    }
    LOBES.iter().any(|(tip, half)| {
        let (along, across) = (axis(tip), [u - HEART[0], v - HEART[1]]);
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let t = (across[0] * along[0] + across[1] * along[1]) / (length * length);
        let off = ((across[0] * along[1] - across[1] * along[0]) / length).abs();
        // Wide in the middle, two teeth on each side, a point at the tip.
        let tooth = |from: f64, to: f64| {
            if (from..to).contains(&t) {
                (to - t) / (to - from)
            } else {
                0.0
            }
        };
        let width = half
            * (smooth_step(-0.15, 0.3, t) * (1.0 - t) * 0.9
                + 0.55 * tooth(0.30, 0.62)
                + 0.42 * tooth(0.62, 0.86));
        (-0.1..1.0).contains(&t) && off < width
    })
}

fn veins(u: f64, v: f64) -> f64 {
    let nearest = LOBES
        .iter()
        .map(|(tip, _)| {
            let (along, from) = (axis(tip), [u - HEART[0], v - HEART[1]]);
            let squared = along[0] * along[0] + along[1] * along[1];
            let t = ((from[0] * along[0] + from[1] * along[1]) / squared).clamp(0.0, 0.9);
            let d = [from[0] - along[0] * t, from[1] - along[1] * t];
            (d[0] * d[0] + d[1] * d[1]).sqrt() - 0.016 * (1.0 - t)
        })
        .fold(f64::INFINITY, f64::min);
    smooth_step(0.006, -0.002, nearest).max(f64::from(u8::from(u.abs() < 0.03 && v < HEART[1])))
}

fn axis(tip: &[f64; 2]) -> [f64; 2] {
    [tip[0] - HEART[0], tip[1] - HEART[1]]
}
