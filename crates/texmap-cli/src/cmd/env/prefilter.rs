//! A prefiltered environment as files: its levels by roughness, its irradiance and the table of the split sum.

use clap::ValueEnum;
use texmap_light::{Environment, EnvironmentLayout, LightError, Prefilter, split_sum};

use super::faces::{Faces, Picture};

/// `--prefilter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Lobe {
    /// GGX as seen head on, with the split sum of Karis 2013
    Ggx,
}

/// Texels a side of the table.
const TABLE: u32 = 128;
/// Texels a side of the irradiance, at most.
const IRRADIANCE: u32 = 32;
/// Texels a side of the last level where the number of levels is not asked for.
const LAST: u32 = 4;

/// Levels of a chain of this size down to four texels.
pub(super) fn levels(size: u32) -> u32 {
    (size / LAST).max(1).ilog2() + 1
}

/// The pictures by the middles of their names: `level0` to the last, whose sizes are halves and whose roughnesses rise evenly from 0 to 1;
/// `irradiance`, over pi; `brdf`, the factors of the reflectance head on (red) and at grazing incidence (green) by the cosine to the eye
/// (left to right) and roughness (top to bottom), both at the middles of texels.
pub(super) fn chain(
    source: &Environment,
    layout: EnvironmentLayout,
    (size, levels): (u32, u32),
    faces: Faces,
) -> Result<Vec<(String, Vec<Picture>)>, LightError> {
    let mut prefilter = Prefilter::new(source, size.max(16))?;
    let mut all = Vec::new();
    for level in 0..levels {
        let roughness = level as f32 / (levels - 1).max(1) as f32;
        let gathered = prefilter.ggx(layout, (size >> level).max(1), roughness)?;
        all.push((format!("level{level}"), faces.pictures(&gathered)));
    }
    let diffuse = prefilter.irradiance(layout, size.min(IRRADIANCE))?;
    all.push(("irradiance".to_owned(), faces.pictures(&diffuse)));
    let middle = |i: u32| (i as f32 + 0.5) / TABLE as f32;
    let places = (0..TABLE).flat_map(|y| (0..TABLE).map(move |x| (x, y)));
    let table = places.map(|(x, y)| {
        let [scale, bias] = split_sum(middle(y), middle(x));
        [scale, bias, 0.0]
    });
    let table = Picture {
        suffix: None,
        width: TABLE,
        height: TABLE,
        texels: table.collect(),
    };
    all.push(("brdf".to_owned(), vec![table]));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_light_stays_even_and_sizes_are_halves() {
        let layout = EnvironmentLayout::LatLong;
        let even = Environment::from_fn(layout, 32, |_| [0.25, 0.5, 1.0]).unwrap();
        let size = (16, levels(16));
        let all = chain(&even, EnvironmentLayout::Cube, size, Faces::Cross).unwrap();
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["level0", "level1", "level2", "irradiance", "brdf"]);
        for (pictures, side) in all.iter().map(|(_, p)| p).zip([16, 8, 4, 16]) {
            assert_eq!(
                (pictures[0].width, pictures[0].height),
                (4 * side, 3 * side)
            );
            let lit = pictures[0].texels.iter().filter(|t| t[2] > 0.0);
            let off = |t: &[f32; 3]| (t[0] - 0.25).abs().max((t[1] - 0.5).abs());
            assert!(lit.clone().count() as u32 == 6 * side * side);
            assert!(lit.map(off).fold(0.0, f32::max) < 1e-4);
        }
        // A mirror returns what comes, whatever its reflectance; a rough surface less than all.
        let table = &all[4].1[0];
        let at = |x: u32, y: u32| table.texels[(y * TABLE + x) as usize];
        let [scale, bias, _] = at(127, 0);
        assert!((scale + bias - 1.0).abs() < 0.01 && bias < 0.01);
        let [scale, bias, _] = at(100, 127);
        assert!(scale + bias < 0.9 && scale > 0.3);
        assert_eq!((levels(4), levels(256), levels(1)), (1, 7, 1));
    }

    /// The levels of a bright window lose its outline one after the other, and keep its light where a lobe is narrow.
    #[test]
    fn rougher_levels_are_softer() {
        let layout = EnvironmentLayout::Cube;
        let window = |d: texmap_math::glam::DVec3| [if d.x > 0.9 { 50.0 } else { 0.1 }; 3];
        let window = Environment::from_fn(layout, 64, window).unwrap();
        let all = chain(&window, layout, (64, 5), Faces::Strip).unwrap();
        let most = |k: usize| all[k].1[0].texels.iter().fold(0.0f32, |m, t| m.max(t[0]));
        assert!((most(0) - 50.0).abs() < 1.0);
        for k in 1..5 {
            assert!(most(k) < most(k - 1), "{k}");
        }
        assert!(most(4) > 1.0 && most(5) < most(0));
    }
}
