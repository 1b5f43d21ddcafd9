//! Panel 5: normals from heights.

use texmap_light::{Heights, NormalMapGreen, Slope, decode_normal, encode_normal};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

use super::time::{Effort, timed};
use super::{Across, Error, Panel, Point, SceneChart, Source};
use crate::LabError;
use texmap_truth::picture::Picture;
use texmap_truth::strip::heat;

const SIDE: u32 = 128;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    Forward,
    Central,
    Sobel,
    /// Central differences of heights in 8 bits.
    Central8,
    /// A stored normal in so many bits a channel.
    Map(u32),
    /// A stored x and y in 8 bits, z rebuilt.
    Rebuilt,
}

impl Method {
    const ALL: [Self; 7] = [
        Self::Forward,
        Self::Central,
        Self::Sobel,
        Self::Central8,
        Self::Map(8),
        Self::Map(16),
        Self::Rebuilt,
    ];

    fn name(self) -> String {
        match self {
            Self::Forward => "forward difference".to_owned(),
            Self::Central => "central difference".to_owned(),
            Self::Sobel => "sobel".to_owned(),
            Self::Central8 => "central, 8-bit heights".to_owned(),
            Self::Map(bits) => format!("normal map, {bits} bits"),
            Self::Rebuilt => "normal map, 8 bits, z rebuilt".to_owned(),
        }
    }
}

/// A sine of `n` samples a period along x whose steepest slope is 1, in texels.
struct Field {
    heights: Vec<f32>,
    coarse: Vec<f32>,
    /// Exact normals.
    truth: Vec<DVec3>,
    maps: Vec<(u32, Vec<[f32; 3]>)>,
}

impl Field {
    fn new(n: f64) -> Self {
        let step = std::f64::consts::TAU / n;
        let columns = (0..SIDE * SIDE).map(|i| f64::from(i % SIDE));
        let exact: Vec<f64> = columns
            .clone()
            .map(|x| deterministic_f64::sin(step * x) / step)
            .collect();
        let truth: Vec<DVec3> = columns
            .map(|x| DVec3::new(-deterministic_f64::cos(step * x), 0.0, 1.0).normalize())
            .collect();
        // The whole range of heights in 255 steps.
        let range = 2.0 / step;
        let coarse = exact
            .iter()
            .map(|h| (((h / range + 0.5) * 255.0).round() / 255.0 - 0.5) * range);
        let maps = [8, 16].map(|bits: u32| {
            let most = ((1u32 << bits) - 1) as f32;
            let code = |c: f32| (c * most).round() / most;
            let texel =
                |n: &DVec3| encode_normal(n.as_vec3().to_array(), NormalMapGreen::Up).map(code);
            (bits, truth.iter().map(texel).collect())
        });
        Self {
            coarse: coarse.map(|h| h as f32).collect(),
            heights: exact.iter().map(|&h| h as f32).collect(),
            maps: maps.into(),
            truth,
        }
    }

    fn normals(&self, method: Method, out: &mut [[f32; 3]]) {
        let from = |values: &[f32], slope: Slope, out: &mut [[f32; 3]]| {
            // The field fills its rows.
            let heights = Heights {
                width: SIDE,
                values,
            };
            if let Ok(normals) = heights.normals(slope, 1.0, NormalMapGreen::Up) {
                out.copy_from_slice(&normals);
            }
        };
        match method {
            Method::Central => from(&self.heights, Slope::Central, out),
            Method::Sobel => from(&self.heights, Slope::Sobel, out),
            Method::Central8 => from(&self.coarse, Slope::Central, out),
            Method::Forward => {
                let side = SIDE as usize;
                for (i, out) in out.iter_mut().enumerate() {
                    let (x, y) = (i % side, i / side);
                    let h = |x: usize, y: usize| self.heights[y % side * side + x % side];
                    let (dx, dy) = (h(x + 1, y) - h(x, y), h(x, y + 1) - h(x, y));
                    let scale = 1.0 / (dx * dx + dy * dy + 1.0).sqrt();
                    *out = [-dx * scale, dy * scale, scale];
                }
            }
            Method::Map(bits) => {
                let maps = self.maps.iter().filter(|(b, _)| *b == bits);
                for (texel, out) in maps.flat_map(|(_, m)| m).zip(out) {
                    *out = decode_normal(*texel, NormalMapGreen::Up, false);
                }
            }
            Method::Rebuilt => {
                for (texel, out) in self.maps[0].1.iter().zip(out) {
                    *out = decode_normal(*texel, NormalMapGreen::Up, true);
                }
            }
        }
    }

    fn angles(&self, normals: &[[f32; 3]]) -> Vec<f64> {
        let angle = |(n, t): (&[f32; 3], &DVec3)| {
            let n = DVec3::from(n.map(f64::from));
            deterministic_f64::atan2(n.cross(*t).length(), n.dot(*t)).to_degrees()
        };
        normals.iter().zip(&self.truth).map(angle).collect()
    }
}

/// Texels and heights without a direction that give no unit normal.
fn failures(method: Method) -> Vec<String> {
    let mut field = Field::new(8.0);
    field.heights.fill(0.0);
    field.coarse.fill(0.0);
    for (_, map) in &mut field.maps {
        let odd = [
            [0.5; 3],
            [0.0; 3],
            [1.0; 3],
            [0.0, 1.0, 0.5],
            [1.0, 0.0, 0.0],
        ];
        for (texel, odd) in map.iter_mut().zip(odd.iter().cycle()) {
            *texel = *odd;
        }
    }
    let mut out = vec![[0.0; 3]; (SIDE * SIDE) as usize];
    field.normals(method, &mut out);
    let unit = |n: &[f32; 3]| {
        let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
        (length - 1.0).abs() < 1e-3
    };
    match out.iter().filter(|n| !unit(n)).count() {
        0 => Vec::new(),
        n => vec![format!("{n} texels without a unit normal")],
    }
}

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    let count = (SIDE * SIDE) as usize;
    let mut charts = Vec::new();
    for n in [4.0, 8.0, 16.0, 64.0] {
        let field = Field::new(n);
        let mut points = Vec::new();
        for method in Method::ALL {
            let mut out = vec![[0.0; 3]; count];
            field.normals(method, &mut out);
            let angles = field.angles(&out);
            points.push(Point {
                method: method.name(),
                source: Source::of_lab(method == Method::Forward),
                time: None,
                picture: Some(picture(&out, &angles)),
                error: Error::of(angles),
                bytes: Some(match method {
                    Method::Central8 => count as u64,
                    Method::Map(bits) => u64::from(bits / 8 * 3) * count as u64,
                    Method::Rebuilt => 2 * count as u64,
                    _ => 4 * count as u64,
                }),
                failures: failures(method),
            });
        }
        let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
        for method in Method::ALL {
            let field = &field;
            let mut out = vec![[0.0; 3]; count];
            runs.push(Box::new(move || {
                field.normals(method, &mut out);
                std::hint::black_box(&out);
            }));
        }
        timed(&mut points, effort, count, &mut runs);
        charts.push(SceneChart {
            id: format!("bump-{n}"),
            title: format!("A sine of {n} samples a period, steepest slope 1"),
            truth: format!("the sine's own normals at {count} texels"),
            item: "texel",
            unit: "degrees",
            across: Across::Time,
            points,
        });
    }
    Ok(Panel {
        id: "bump",
        title: "Bump and normal maps",
        about: "Tangent-space normals of a height field. Differences err by a known amount, 1 - sin(wh)/(wh) of the \
                slope; stored normals only by their rounding, which costs memory. A method is hollow when flat heights \
                or texels without a direction give no unit normal.",
        charts,
    })
}

/// The normals lit from the left and, beside them, their error: white from 10 degrees.
fn picture(normals: &[[f32; 3]], angles: &[f64]) -> Picture {
    const SHOWN: u32 = 64;
    let mut picture = Picture::new(4 * SHOWN + 2, 2 * SHOWN, [255; 4]);
    for y in 0..2 * SHOWN {
        for x in 0..2 * SHOWN {
            // Two pixels a texel.
            let i = (y / 2 * SIDE + x / 2) as usize;
            let n = normals[i];
            let shade = (-0.6 * n[0] + 0.8 * n[2]).clamp(0.0, 1.0);
            let c = (shade * 15.0).round() as u8 * 17;
            picture.set(x.into(), y.into(), [c, c, c, 255]);
            let place = i64::from(x + 2 * SHOWN + 2);
            picture.set(place, y.into(), heat((angles[i] * 1.2).round() / 12.0));
        }
    }
    picture
}
