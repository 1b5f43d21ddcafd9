//! Panel 2: filters on the tilted plane.

use texmap_math::{Footprint, Level};
use texmap_sample::{
    ColorSpace, Cubic, Filter, Origin, Precision, Sampler, SummedArea, Texture2d,
    sample_rgba8_slice, sample_slice,
};

use super::time::{Effort, interleaved};
use super::{Across, Error, Panel, Point, SceneChart, Source};
use crate::LabError;
use crate::picture::Picture;
use crate::plane::{Pattern, TEXELS, TiltedPlane, Truth, View, nearest, sines};
use crate::strip::heat;

/// A way to a pixel's value.
#[derive(Clone, Debug, PartialEq)]
enum Method {
    Sampler(Filter, Precision),
    SummedArea,
    /// The mean of so many bilinear look-ups a side of the pixel's footprint.
    Supersampled(u32),
}

impl Method {
    fn name(&self) -> String {
        match self {
            Self::Sampler(filter, precision) => {
                let name = texmap_io::scene_file::words::filter(*filter);
                let name = name.unwrap_or_else(|| format!("{filter:?}"));
                match precision {
                    Precision::Exact => name,
                    Precision::Fast => format!("{name}, fast"),
                }
            }
            Self::SummedArea => "summed-area".to_owned(),
            Self::Supersampled(n) => format!("bilinear x{}", n * n),
        }
    }

    fn source(&self) -> Source {
        match self {
            Self::Supersampled(_) => Source::Lab,
            _ => Source::Texmap,
        }
    }
}

fn methods(magnified: bool) -> Vec<Method> {
    let mut out = Vec::new();
    for filter in [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::MipNearest,
        Filter::BilinearMipNearest,
        Filter::Trilinear,
        Filter::Anisotropic(2),
        Filter::Anisotropic(4),
        Filter::Anisotropic(8),
        Filter::Anisotropic(16),
    ] {
        out.push(Method::Sampler(filter, Precision::Exact));
        out.push(Method::Sampler(filter, Precision::Fast));
    }
    for filter in [Filter::Ewa(4), Filter::Ewa(16)] {
        out.push(Method::Sampler(filter, Precision::Exact));
    }
    if magnified {
        for cubic in [Cubic::CatmullRom, Cubic::Mitchell, Cubic::BSpline] {
            out.push(Method::Sampler(Filter::Bicubic(cubic), Precision::Exact));
        }
    }
    out.push(Method::SummedArea);
    out.extend([2, 4, 8].map(Method::Supersampled));
    out
}

/// What the others measured on the same scenes with a box truth (RMSE: checker, sines, noise); not timed here.
const EXTERNAL: &[(&str, [f64; 3])] = &[
    ("llvmpipe 22.3.6 bilinear", [0.222, 0.114, 0.138]),
    ("llvmpipe 22.3.6 trilinear", [0.083, 0.077, 0.067]),
    ("llvmpipe 22.3.6 anisotropic 16", [0.065, 0.031, 0.062]),
    ("OpenImageIO 3.2 trilinear", [0.078, 0.073, 0.063]),
    ("OpenImageIO 3.2 anisotropic 16", [0.055, 0.030, 0.026]),
];

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    let bytes = Pattern::ALL.map(Pattern::bytes);
    let value = |p: &[u8], at| f64::from(p[nearest(at)]) / 255.0;
    let plain = TiltedPlane::default();
    let [boxed, gaussian] = [Truth::Box, Truth::Gaussian].map(|truth| {
        plain.truth_by(truth, effort.grid, |at| {
            bytes.each_ref().map(|p| value(p, at))
        })
    });
    let grid = effort.grid;
    let told = format!("mean of {grid} x {grid} nearest look-ups over the pixel's square");
    let mut charts = Vec::new();
    let mut soft = Vec::new();
    for (k, (pattern, bytes)) in Pattern::ALL.into_iter().zip(&bytes).enumerate() {
        let name = format!("{pattern:?}").to_lowercase();
        let scene = Scene::new(&plain, bytes)?;
        let truth: Vec<f64> = boxed.iter().map(|t| t[k]).collect();
        let (mut points, values) = scene.measure(effort, &methods(false), &truth)?;
        let blurred: Vec<f64> = gaussian.iter().map(|t| t[k]).collect();
        soft.push(SceneChart {
            id: format!("filtering-{name}-gaussian"),
            title: format!("The tilted plane, {name}, truth: a Gaussian pixel"),
            truth: "Gaussian of 0.5 pixels over +-2 pixels; the times are those above".to_owned(),
            item: "pixel",
            unit: "of 1",
            across: Across::Time,
            points: points
                .iter()
                .zip(&values)
                .map(|(p, v)| Point {
                    error: error(v, &blurred),
                    picture: Some(picture(&plain, v, &blurred)),
                    ..p.clone()
                })
                .collect(),
        });
        points.extend(EXTERNAL.iter().map(|(method, rmse)| Point {
            method: (*method).to_owned(),
            source: Source::External,
            time: None,
            error: Error::rmse_only(rmse[k]),
            bytes: None,
            failures: Vec::new(),
            picture: None,
        }));
        charts.push(SceneChart {
            id: format!("filtering-{name}"),
            title: format!("The tilted plane, {name}, truth: the pixel's square"),
            truth: told.clone(),
            item: "pixel",
            unit: "of 1",
            across: Across::Time,
            points,
        });
    }
    charts.extend(soft);
    let turned = TiltedPlane::new(View {
        turn: 30f64.to_radians(),
        magnify: 1.0,
    });
    let truth = turned.truth_by(Truth::Box, grid, |at| [value(&bytes[1], at)]);
    charts.push(SceneChart {
        id: "filtering-turned".to_owned(),
        title: "The tilted plane, sines turned by 30 degrees".to_owned(),
        truth: told,
        item: "pixel",
        unit: "of 1",
        across: Across::Time,
        points: Scene::new(&turned, &bytes[1])?
            .measure(effort, &methods(false), truth.as_flattened())?
            .0,
    });
    let large = TiltedPlane::new(View {
        turn: 0.0,
        magnify: 8.0,
    });
    let truth = large.truth_by(Truth::Box, grid.min(16), |[x, y]| {
        [sines([x - 0.5, y - 0.5])]
    });
    charts.push(SceneChart {
        id: "filtering-magnified".to_owned(),
        title: "The tilted plane, sines magnified 8 times".to_owned(),
        truth: "mean of the continuous waves over the pixel's square".to_owned(),
        item: "pixel",
        unit: "of 1",
        across: Across::Time,
        points: Scene::new(&large, &bytes[1])?
            .measure(effort, &methods(true), truth.as_flattened())?
            .0,
    });
    Ok(Panel {
        id: "filtering",
        title: "Filtering",
        about: "42,037 pixels of a plane in perspective (fewer where it lies otherwise), a 512 x 512 texture of opaque \
                linear bytes, look-ups over slices with analytic footprints. `fast` is texmap's 8-bit precision. \
                Against a box truth Gaussian filters lose because they blur; against a Gaussian truth the order turns. \
                A filter is hollow when NaN, infinite or huge coordinates and footprints give a value that is not finite.",
        charts,
    })
}

struct Scene<'p> {
    plane: &'p TiltedPlane,
    texture: Texture2d<'static>,
    table: SummedArea,
    u: Vec<f32>,
    v: Vec<f32>,
    footprints: Vec<Footprint>,
}

/// Where look-ups go: floats, or bytes for the fast precision.
struct Out {
    floats: Vec<[f32; 4]>,
    words: Vec<u32>,
}

impl<'p> Scene<'p> {
    fn new(plane: &'p TiltedPlane, bytes: &[u8]) -> Result<Self, LabError> {
        let side = TEXELS as u32;
        let rgba = bytes.iter().flat_map(|&b| [b, b, b, 255]).collect();
        let texture = Texture2d::from_rgba8(side, side, rgba, ColorSpace::Linear, Origin::TopLeft)?
            .with_mips();
        Ok(Self {
            table: SummedArea::new(&texture),
            texture,
            u: plane.places().map(|p| p.2[0] as f32).collect(),
            v: plane.places().map(|p| p.2[1] as f32).collect(),
            footprints: plane.footprints().collect(),
            plane,
        })
    }

    /// Every method's point, and the values that it gave.
    fn measure(
        &self,
        effort: Effort,
        methods: &[Method],
        truth: &[f64],
    ) -> Result<(Vec<Point>, Vec<Vec<f64>>), LabError> {
        let new = || Out {
            floats: vec![[0.0; 4]; self.u.len()],
            words: vec![0; self.u.len()],
        };
        let mut points = Vec::new();
        let mut all = Vec::new();
        for method in methods {
            let mut out = new();
            self.run(method, &mut out)?;
            let values: Vec<f64> = if matches!(method, Method::Sampler(_, Precision::Fast)) {
                out.words
                    .iter()
                    .map(|w| f64::from(w & 255) / 255.0)
                    .collect()
            } else {
                out.floats.iter().map(|c| f64::from(c[0])).collect()
            };
            points.push(Point {
                method: method.name(),
                source: method.source(),
                time: None,
                error: error(&values, truth),
                bytes: None,
                failures: self.failures(method),
                picture: Some(picture(self.plane, &values, truth)),
            });
            all.push(values);
        }
        let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
        for method in methods {
            let mut out = new();
            runs.push(Box::new(move || {
                // Slices of one length were accepted above.
                let _ = self.run(method, &mut out);
                std::hint::black_box((&out.floats, &out.words));
            }));
        }
        let times = interleaved(effort, self.u.len(), &mut runs);
        for (point, time) in points.iter_mut().zip(times) {
            point.time = Some(time);
        }
        Ok((points, all))
    }

    fn run(&self, method: &Method, out: &mut Out) -> Result<(), LabError> {
        let (level, grads) = (Level::new(), Some(&self.footprints[..]));
        match *method {
            Method::Sampler(filter, precision) => {
                let sampler = Sampler {
                    filter,
                    precision,
                    ..Sampler::default()
                };
                let (u, v, t) = (&self.u, &self.v, &self.texture);
                match precision {
                    Precision::Exact => {
                        sample_slice(level, &sampler, t, u, v, grads, &mut out.floats)?;
                    }
                    Precision::Fast => {
                        sample_rgba8_slice(level, &sampler, t, u, v, grads, &mut out.words)?;
                    }
                }
            }
            Method::SummedArea => {
                let sampler = Sampler::default();
                for (i, out) in out.floats.iter_mut().enumerate() {
                    let uv = [self.u[i], self.v[i]];
                    *out = self.table.sample_grad(&sampler, uv, self.footprints[i]);
                }
            }
            Method::Supersampled(n) => self.supersample(n, &mut out.floats)?,
        }
        Ok(())
    }

    fn supersample(&self, n: u32, out: &mut [[f32; 4]]) -> Result<(), LabError> {
        const RUN: usize = 256;
        let sampler = Sampler {
            filter: Filter::Bilinear,
            ..Sampler::default()
        };
        let share = 1.0 / (n * n) as f32;
        for (index, out) in out.chunks_mut(RUN).enumerate() {
            let (first, count) = (index * RUN, out.len());
            let mut part = [[0.0f32; 4]; RUN];
            out.fill([0.0; 4]);
            for k in 0..n * n {
                let offset = |c: u32| (c as f32 + 0.5) / n as f32 - 0.5;
                let (x, y) = (offset(k % n), offset(k / n));
                let (mut u, mut v) = ([0.0f32; RUN], [0.0f32; RUN]);
                for i in 0..count {
                    let d = &self.footprints[first + i];
                    u[i] = self.u[first + i] + x * d.du_dx + y * d.du_dy;
                    v[i] = self.v[first + i] + x * d.dv_dx + y * d.dv_dy;
                }
                let (u, v, part) = (&u[..count], &v[..count], &mut part[..count]);
                sample_slice(Level::new(), &sampler, &self.texture, u, v, None, part)?;
                for (out, part) in out.iter_mut().zip(part) {
                    for c in 0..4 {
                        out[c] += part[c] * share;
                    }
                }
            }
        }
        Ok(())
    }

    /// Look-ups at senseless places and footprints that give no number.
    fn failures(&self, method: &Method) -> Vec<String> {
        let senseless = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            1e30,
            -1e30,
            f32::MAX,
        ];
        let mut bad = 0u32;
        for a in senseless {
            for b in senseless.into_iter().chain([0.0, 0.3]) {
                let d = Footprint::new(b, 0.0, a, b);
                for uv in [[a, b], [b, a], [0.3, 0.4]] {
                    let color = match *method {
                        Method::Sampler(filter, precision) => Sampler {
                            filter,
                            precision,
                            ..Sampler::default()
                        }
                        .sample_grad(&self.texture, uv, d),
                        Method::SummedArea => self.table.sample_grad(&Sampler::default(), uv, d),
                        Method::Supersampled(_) => Sampler {
                            filter: Filter::Bilinear,
                            ..Sampler::default()
                        }
                        .sample(&self.texture, [uv[0] + b * 0.25, uv[1] + a * 0.25]),
                    };
                    bad += u32::from(!color.iter().all(|c| c.is_finite()));
                }
            }
        }
        if bad == 0 {
            Vec::new()
        } else {
            vec![format!("{bad} senseless look-ups without a number")]
        }
    }
}

fn error(values: &[f64], truth: &[f64]) -> Error {
    Error::of(values.iter().zip(truth).map(|(v, t)| v - t))
}

/// 128 x 128 pixels from the far edge of the plane and, beside them, their error: white from 0.25.
fn picture(plane: &TiltedPlane, values: &[f64], truth: &[f64]) -> Picture {
    const SIDE: i64 = 128;
    let top = plane.places().map(|p| p.1).min().unwrap_or(0) as i64;
    let mut picture = Picture::new(2 * SIDE as u32 + 2, SIDE as u32, [255; 4]);
    picture.fill(0, 0, 2 * SIDE as u32 + 2, SIDE as u32, [96, 96, 128, 255]);
    for (((x, y, _), value), truth) in plane.places().zip(values).zip(truth) {
        let (x, y) = (x as i64 - 64, y as i64 - top);
        if (0..SIDE).contains(&x) && (0..SIDE).contains(&y) {
            // 16 greys are enough to see by, and compress.
            let c = ((value.clamp(0.0, 1.0) * 15.0).round() * 17.0) as u8;
            picture.set(x, y, [c, c, c, 255]);
            let off = ((value - truth).abs() * 4.0 * 12.0).round() / 12.0;
            picture.set(x + SIDE + 2, y, heat(off));
        }
    }
    picture
}
