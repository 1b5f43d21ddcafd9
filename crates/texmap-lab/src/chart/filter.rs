//! Panel 2: filters on the tilted plane.

use texmap_math::{Footprint, Level};
use texmap_sample::{
    ColorSpace, Cubic, Filter, Origin, Precision, Sampler, Texture2d, sample_rgba8_slice,
    sample_slice,
};

use super::time::{Effort, timed};
use super::{Across, Panel, PlaneScene, Point, SceneChart, Source};
use crate::LabError;
use crate::cases::SENSELESS;
use crate::plane::{Pattern, TEXELS};

/// A way to a pixel's value.
#[derive(Clone, Debug, PartialEq)]
enum Method {
    Sampler(Filter, Precision),
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
    for filter in [Filter::ewa(4), Filter::ewa(16), Filter::SummedArea] {
        out.push(Method::Sampler(filter, Precision::Exact));
    }
    if magnified {
        for cubic in [Cubic::CatmullRom, Cubic::Mitchell, Cubic::BSpline] {
            out.push(Method::Sampler(Filter::Bicubic(cubic), Precision::Exact));
        }
    }
    out.extend([2, 4, 8].map(Method::Supersampled));
    out
}

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    let mut charts: Vec<SceneChart> = Vec::new();
    // Results of the methods on the patterns, which a Gaussian pixel judges again.
    let mut given: Vec<(Pattern, Vec<Vec<f64>>)> = Vec::new();
    for scene in PlaneScene::all(effort.grid) {
        let again = given
            .iter()
            .position(|g| g.0 == scene.pattern && scene.id.ends_with("gaussian"));
        let points = if let Some(first) = again {
            let of = |(point, values): (&Point, &Vec<f64>)| Point {
                error: scene.error(values),
                picture: Some(scene.picture(values)),
                ..point.clone()
            };
            charts[first]
                .points
                .iter()
                .zip(&given[first].1)
                .map(of)
                .collect()
        } else {
            let methods = methods(scene.id.ends_with("magnified"));
            let (points, values) = Scene::new(&scene)?.measure(effort, &methods)?;
            given.push((scene.pattern, values));
            points
        };
        charts.push(SceneChart {
            id: scene.id,
            title: scene.title,
            truth: scene.told,
            item: "pixel",
            unit: "of 1",
            across: Across::Time,
            points,
        });
    }
    Ok(Panel {
        id: "filtering",
        title: "Filtering",
        about: "42,037 pixels of a plane in perspective (fewer where it lies otherwise), a 512 x 512 texture of opaque \
                linear bytes, look-ups over slices with analytic footprints. `fast` is texmap's 8-bit precision. \
                Against a box truth Gaussian filters lose because they blur; against a Gaussian truth the order turns. \
                A filter is hollow when NaN, infinite or huge coordinates and footprints give a value that is not finite. \
                Other programs draw the plane as a polygon into bytes.",
        charts,
    })
}

struct Scene<'p> {
    of: &'p PlaneScene,
    texture: Texture2d<'static>,
    u: Vec<f32>,
    v: Vec<f32>,
    footprints: Vec<Footprint>,
}

/// Output of the look-ups: floats, or bytes for the fast precision.
struct Out {
    floats: Vec<[f32; 4]>,
    words: Vec<u32>,
}

impl<'p> Scene<'p> {
    fn new(of: &'p PlaneScene) -> Result<Self, LabError> {
        let side = TEXELS as u32;
        let rgba = of.pattern.rgba();
        let plane = &of.plane;
        let texture = Texture2d::from_rgba8(side, side, rgba, ColorSpace::Linear, Origin::TopLeft)?
            .with_mips()
            .with_summed_area();
        Ok(Self {
            texture,
            u: plane.places().map(|p| p.2[0] as f32).collect(),
            v: plane.places().map(|p| p.2[1] as f32).collect(),
            footprints: plane.footprints().collect(),
            of,
        })
    }

    /// Every method's point, and the values that it gave.
    fn measure(
        &self,
        effort: Effort,
        methods: &[Method],
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
                error: self.of.error(&values),
                bytes: None,
                failures: self.failures(method),
                picture: Some(self.of.picture(&values)),
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
        timed(&mut points, effort, self.u.len(), &mut runs);
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

    /// Look-ups at senseless coordinates and footprints that give no number.
    fn failures(&self, method: &Method) -> Vec<String> {
        let mut bad = 0u32;
        for a in SENSELESS {
            for b in SENSELESS.into_iter().chain([0.0, 0.3]) {
                let d = Footprint::new(b, 0.0, a, b);
                for uv in [[a, b], [b, a], [0.3, 0.4]] {
                    let color = match *method {
                        Method::Sampler(filter, precision) => Sampler {
                            filter,
                            precision,
                            ..Sampler::default()
                        }
                        .sample_grad(&self.texture, uv, d),
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
