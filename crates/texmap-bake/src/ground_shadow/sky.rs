//! The light above the ground as directions: equal shares of the light from all around, and of each sun.

use texmap_light::Light;
use texmap_math::color::luminance_f64;
use texmap_math::glam::DVec3;
use texmap_math::{deterministic_f64, hilbert};
use texmap_scene::Scene;

use super::{Place, across};

/// Directions to the sky, each for one share of its light.
const DIRECTIONS: u32 = 128;
/// Cells a side of the sky, whose light is told apart.
const CELLS: u32 = 64;
/// Roughness whose lobe is about as wide as a cell; the skirts of a wider one take light from windows.
pub(super) const LOBE: f32 = 0.1;
/// Places a side of a cell for the directions inside.
const INSIDE: u32 = 16;

/// Directions to the light in the directions of the axes, and what the ground receives from each.
pub(super) fn sky(scene: &Scene, place: &Place) -> Vec<(DVec3, f64)> {
    let luminance = |c: [f32; 3]| luminance_f64(c.map(f64::from));
    let ambient = scene.lights.iter().filter_map(|light| match light {
        Light::Ambient { color } => Some(luminance(*color)),
        _ => None,
    });
    let ambient: f64 = ambient.sum();
    let suns = scene.lights.iter().filter_map(|light| match light {
        Light::Directional { color, direction } => {
            let d = -DVec3::from(direction.map(f64::from));
            let d = DVec3::from(place.axes.map(|axis| axis.dot(d))).try_normalize()?;
            (d.z > 0.02).then(|| (d, luminance(*color) * d.z))
        }
        _ => None,
    });
    let suns: Vec<(DVec3, f64)> = suns.collect();
    let environment = scene.effects.environment_light.as_ref();
    let even = match suns.is_empty() && ambient == 0.0 {
        true => 1.0,
        false => ambient,
    };
    let radiance = |d: DVec3| match environment {
        Some(light) => {
            let world = place.world(d).to_array().map(|x| x as f32);
            luminance(light.radiance(LOBE, world)) + ambient
        }
        None => even,
    };
    let mut sky = shares(radiance);
    // A sun of five degrees, so that its shadow has soft edges.
    const POINTS: u32 = 9;
    for (toward, weight) in suns {
        let right = across(toward, DVec3::Y);
        let back = right.cross(toward);
        for k in 0..POINTS {
            let p = spread(k, POINTS, 0.002);
            let d = right * p.x + back * p.y + toward * p.z;
            if d.z > 0.02 {
                sky.push((d, weight / f64::from(POINTS)));
            }
        }
    }
    sky
}

/// Directions above the ground that stand for equal shares of the cosine-weighted light, and those shares. They follow a Hilbert curve
/// through the cells of the sky, so that the parts of the sky of equal light are compact: bright ones have many directions.
fn shares(radiance: impl Fn(DVec3) -> f64) -> Vec<(DVec3, f64)> {
    let cells: Vec<f64> = (0..CELLS * CELLS)
        .map(|cell| radiance(curve(cell * INSIDE * INSIDE, INSIDE)))
        .collect();
    let all: f64 = cells.iter().sum();
    let mut sky = Vec::new();
    // The light before a cell. The next direction lies somewhere in its share: middles of all would be a grid, whose lines fall together with
    // outlines.
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let mut before = 0.0;
    for (cell, light) in (0..).zip(cells) {
        loop {
            let number = sky.len() as f64;
            let place = 0.5 + number * GOLDEN;
            let place = place - place.floor();
            let wanted = (number + place) / f64::from(DIRECTIONS) * all;
            let part = (wanted - before) / light;
            // Also where there is no light, and after the last.
            if !(part < 1.0) || sky.len() == DIRECTIONS as usize {
                break;
            }
            let places = INSIDE * INSIDE;
            let inside = ((part * f64::from(places)) as u32).min(places - 1);
            let share = all / f64::from(CELLS * CELLS * DIRECTIONS);
            sky.push((curve(cell * places + inside, 1), share));
        }
        before += light;
    }
    sky
}

/// The direction to the middle of a square of `side` places around place `at` of a Hilbert curve through the square over the disk of
/// directions (Shirley and Chiu 1997), as the ground receives them: equal areas are equal shares of an even sky.
fn curve(at: u32, side: u32) -> DVec3 {
    let (x, y) = hilbert::cell(at, CELLS * INSIDE);
    let middle = |c: u32| {
        let c = f64::from(c / side * side) + 0.5 * f64::from(side);
        2.0 * c / f64::from(CELLS * INSIDE) - 1.0
    };
    let (a, b) = (middle(x), middle(y));
    let quarter = core::f64::consts::FRAC_PI_4;
    let (radius, angle) = match a.abs() > b.abs() {
        true => (a, quarter * b / a),
        false if b == 0.0 => (0.0, 0.0),
        false => (b, 2.0 * quarter - quarter * a / b),
    };
    let (sin, cos) = deterministic_f64::sin_cos(angle);
    DVec3::new(radius * cos, radius * sin, (1.0 - radius * radius).sqrt())
}

/// Direction `k` of `n` about +Z, spread by the cosine over squared sines up to `most`, along a spiral of the golden angle.
fn spread(k: u32, n: u32, most: f64) -> DVec3 {
    const GOLDEN: f64 = 2.399_963_229_728_653;
    let square = (f64::from(k) + 0.5) / f64::from(n) * most;
    let (sin, cos) = deterministic_f64::sin_cos(f64::from(k) * GOLDEN);
    let radius = square.sqrt();
    DVec3::new(radius * cos, radius * sin, (1.0 - square).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_has_the_same_share_of_the_light() {
        let light = |d: DVec3| if d.x > 0.6 { 50.0 } else { 0.1 };
        let sky = shares(light);
        assert_eq!(sky.len(), DIRECTIONS as usize);
        assert!(sky.iter().all(|(d, share)| d.z > 0.0 && *share == sky[0].1));
        // Of the disk x > 0.6 is this part.
        let part = (0.6_f64.acos() - 0.6 * 0.8) / std::f64::consts::PI;
        let (bright, dim) = (part * 50.0, (1.0 - part) * 0.1);
        let all: f64 = sky.iter().map(|(_, share)| share).sum();
        assert!((all / (bright + dim) - 1.0).abs() < 0.02, "{all}");
        let seen = sky.iter().filter(|(d, _)| d.x > 0.6).count() as f64;
        let expected = bright / (bright + dim) * f64::from(DIRECTIONS);
        // One in twelve cells of the bright part lies across its edge, and may have its directions on the other side.
        assert!((seen - expected).abs() < 6.0, "{seen} {expected}");
        assert!(shares(|_| 0.0).is_empty());
    }
}
