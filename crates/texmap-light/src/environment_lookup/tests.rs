use super::*;
use crate::vector::{columns, load};
use alloc::vec::Vec;

/// Directions are of any length, down to the least number that is not 0, and so are their changes.
#[test]
fn short_directions_are_directions() {
    for chart in EnvironmentLayout::ALL {
        let sky = Environment::from_fn(chart, 64, |d| d.to_array().map(|c| c as f32 + 1.0));
        let sky = sky.unwrap().with_mips();
        let seen = |direction: [f32; 3], dx: f32| {
            sky.radiance_filtered(&Ray {
                direction,
                dx: [0.0, dx, 0.0],
                dy: [0.0; 3],
            })
        };
        for d in [
            [1.0, 0.0, 1.0],
            [1.0; 3],
            [0.0, 0.0, -1.0],
            [-1.0, 0.5, 0.25],
        ] {
            for change in [0.0, 0.5] {
                let want = seen(d, change);
                for length in [1e12, 1e-12, 1e-18, 1e-25, 1e-38, 1e-40] {
                    let got = seen(d.map(|c| c * length), change * length);
                    for (a, b) in got.into_iter().zip(want) {
                        assert!(
                            (a - b).abs() < 1e-3,
                            "{chart:?} {d:?} {length} {change}: {got:?} {want:?}"
                        );
                    }
                }
            }
        }
        assert!(seen([1e-45; 3], 0.0).iter().all(|c| c.is_finite()));
    }
}

/// Footprints choose the level. A stripe pattern fades to its mean as pixels grow, on every layout, and not without levels.
#[test]
fn wide_footprints_read_the_mean() {
    for chart in EnvironmentLayout::ALL {
        let mut bright = false;
        let stripes = Environment::from_fn(chart, 64, |_| {
            bright = !bright;
            [if bright { 1.0 } else { 0.0 }; 3]
        });
        let sharp = stripes.unwrap();
        let soft = sharp.clone().with_mips();
        let contrast = |environment: &Environment, step: f32| {
            let look = |i: u16| {
                let x = f32::from(i) * 0.003;
                let ray = Ray {
                    direction: [0.3 + x, 0.1, 1.0],
                    dx: [step, 0.0, 0.0],
                    dy: [0.0, step, 0.0],
                };
                (environment.radiance_filtered(&ray)[0] - 0.5).abs()
            };
            (0..100).map(look).fold(0.0, f32::max)
        };
        let (near, far) = (contrast(&soft, 1e-4), contrast(&soft, 0.3));
        assert!((near - contrast(&sharp, 1e-4)).abs() < 1e-6, "{chart:?}");
        assert!(near > 0.2 && far < 0.1, "{chart:?}: {near} {far}");
        assert!(contrast(&sharp, 0.3) > 0.2, "{chart:?}");
    }
}

/// Packed texels and floats give the same light, but for half a step on the smaller levels.
#[test]
fn packed_texels_are_off_by_half_a_step_at_most() {
    let packed = noise(EnvironmentLayout::Cube, 64).with_mips();
    assert!(!packed.packed.is_empty());
    let floats = Environment {
        packed: Vec::new(),
        ..packed.clone()
    };
    let mut largest = 0.0f32;
    for i in 0..2_000u16 {
        let x = f32::from(i);
        let step = 0.2 * (x * 0.37).sin().abs();
        let ray = Ray {
            direction: [(x * 0.7).sin(), (x * 1.3).cos(), (x * 0.31).sin()],
            dx: [step, 0.0, 0.3 * step],
            dy: [0.0, step, 0.0],
        };
        let (a, b) = (
            packed.radiance_filtered(&ray),
            floats.radiance_filtered(&ray),
        );
        for (a, b) in a.iter().zip(b) {
            largest = largest.max((a - b).abs());
        }
    }
    assert!(largest > 1e-5 && largest < 0.5 * UNIT + 1e-6, "{largest}");
}

fn noise(chart: EnvironmentLayout, size: u32) -> Environment {
    let mut seed = 3u32;
    let noise = Environment::from_fn(chart, size, |_| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        [8, 16, 24].map(|shift| f32::from((seed >> shift) as u8) / 255.0)
    });
    noise.unwrap()
}

/// Without levels the light is that of f64 coordinates within the error of f32 ones.
#[test]
fn light_across_is_light_where_there_are_no_levels() {
    for chart in EnvironmentLayout::ALL {
        let noise = noise(chart, 64);
        let mut largest = 0.0f32;
        for i in 0..3_000u16 {
            let x = f32::from(i);
            let direction = [(x * 0.7).sin(), (x * 1.3).cos(), (x * 0.31).sin()];
            let ray = Ray {
                direction,
                dx: [0.3; 3],
                dy: [0.0; 3],
            };
            let (a, b) = (noise.radiance_filtered(&ray), noise.radiance(direction));
            for (a, b) in a.iter().zip(b) {
                largest = largest.max((a - b).abs());
            }
        }
        // 4e-7 of 64 texels (128 of a lat-long layout), each up to 1 from the next, in two directions.
        assert!(largest > 0.0 && largest < 1.1e-4, "{chart:?}: {largest}");
    }
}

/// Every width gives the bits of one ray in every layout. Rays see one level or each its own, in packed texels and
/// floats, without levels, at edges of faces, and along directions that are none.
#[test]
fn widths_agree() {
    for chart in EnvironmentLayout::ALL {
        let packed = noise(chart, 32).with_mips();
        let floats = Environment {
            packed: Vec::new(),
            ..packed.clone()
        };
        let odd = noise(chart, 21).with_mips();
        let flat = noise(chart, 9);
        assert!(!packed.packed.is_empty() && flat.packed.is_empty());
        for environment in [&packed, &floats, &odd, &flat] {
            check_widths(environment);
        }
    }
}

fn check_widths(environment: &Environment) {
    for steps in [[0.0; 2], [0.02, 0.0], [0.15, 0.0], [9.0, 0.0], [0.01, 0.4]] {
        for turn in 0..9u8 {
            let mut rays: [Ray; 16] = core::array::from_fn(|i| {
                let x = i as f32 + 0.7 * f32::from(turn);
                let step = steps[0] + steps[1] * x * 0.1;
                let edge = if i % 3 == 0 { 1.0 } else { (x * 0.37).sin() };
                Ray {
                    direction: [edge, 1.0 - 1.9 * (x * 0.9).sin().abs(), (x * 1.3).cos()],
                    dx: [step, 0.0, 0.3 * step],
                    dy: [0.0, step, 0.0],
                }
            });
            if turn == 8 {
                rays[2].direction = [0.0; 3];
                rays[5].direction = [f32::NAN, 1.0, 0.0];
                rays[9].direction = [0.0, f32::NEG_INFINITY, 0.0];
                rays[11].direction = [0.0, -0.0, -1.0];
                rays[12].dx = [f32::INFINITY; 3];
            }
            every_width!(i => check_rays(i, environment, &rays));
        }
    }
}

fn check_rays<I: Isa>(i: I, environment: &Environment, rays: &[Ray; 16]) {
    for first in (0..16).step_by(I::LANES) {
        let all = RayLanes {
            direction: load(i, &rays.map(|ray| ray.direction), first),
            dx: load(i, &rays.map(|ray| ray.dx), first),
            dy: load(i, &rays.map(|ray| ray.dy), first),
        };
        let got = columns(i, environment.radiance_lanes(i, &all));
        for (lane, ray) in rays[first..].iter().take(I::LANES).enumerate() {
            let one = environment.radiance_filtered(ray);
            assert!(one.iter().all(|c| c.is_finite()), "{ray:?}");
            assert_eq!(
                got.map(|c| c[lane].to_bits()),
                one.map(f32::to_bits),
                "{:?} {ray:?}",
                environment.layout
            );
        }
    }
}

/// Directions that are zero or not finite give light of the map.
#[test]
fn bad_rays_read_something_finite() {
    let sky = Environment::from_fn(EnvironmentLayout::Cube, 16, |_| [0.5; 3]).unwrap();
    let sky = sky.with_mips();
    for bad in [0.0, f32::NAN, f32::INFINITY, 1e30] {
        let ray = Ray {
            direction: [bad; 3],
            dx: [bad, 0.0, -bad],
            dy: [bad; 3],
        };
        let light = sky.radiance_filtered(&ray);
        assert!(
            light.iter().all(|c| (c - 0.5).abs() < 1e-6),
            "{bad}: {light:?}"
        );
    }
}
