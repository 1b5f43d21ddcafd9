//! Panel 4: shadow maps.

use texmap_light::{ShadowBias, ShadowKind, ShadowMap};
use texmap_math::camera::Camera;
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_uv::Shape;

use super::time::{Effort, timed};
use super::{Across, Error, Panel, Point, SceneChart, Source};
use crate::LabError;
use texmap_truth::picture::Picture;
use texmap_truth::rays::{RayObject, RayScene};
use texmap_truth::strip::heat;

/// Half the side of the map, world units; the scene is of size 1 on a floor of 6.
const HALF: f64 = 2.6;
/// Texels around a true edge that are not judged: 1.5 and the radius of the widest filter.
const BAND: f64 = 3.5;

/// A ball, a thin wall and a post on a floor, and the points that a camera sees.
pub(super) struct Stage {
    rays: RayScene,
    side: u32,
    /// Pixel, point and unit normal towards the eye.
    seen: Vec<(u32, DVec3, DVec3)>,
}

impl Stage {
    pub(super) fn new(side: u32) -> Result<Self, LabError> {
        let place = |size: DVec3, at: DVec3| DMat4::from_translation(at) * DMat4::from_scale(size);
        let rays = RayScene::new([
            RayObject::Solid(Shape::Plane, place(DVec3::new(6.0, 6.0, 1.0), DVec3::ZERO)),
            RayObject::Solid(
                Shape::Sphere,
                place(DVec3::splat(0.7), DVec3::new(0.1, -0.2, 0.5)),
            ),
            RayObject::Solid(
                Shape::Box,
                place(DVec3::new(0.9, 0.04, 0.6), DVec3::new(-0.3, 0.5, 0.3)),
            ),
            RayObject::Solid(
                Shape::Box,
                place(DVec3::new(0.06, 0.06, 1.0), DVec3::new(0.75, 0.15, 0.5)),
            ),
        ]);
        let camera = Camera {
            eye: DVec3::new(1.6, -2.2, 1.2),
            look: DVec3::new(0.0, 0.0, 0.3),
            up: DVec3::Z,
            fov_x: 50f64.to_radians(),
            near: 1e-3,
            far: f64::INFINITY,
        };
        let mut seen = Vec::new();
        for i in 0..side * side {
            let (x, y) = (f64::from(i % side) + 0.5, f64::from(i / side) + 0.5);
            let d = camera.ray(side, side, x, y)?;
            if let Some(hit) = rays.nearest(camera.eye, d, (0.0, f64::INFINITY)) {
                let normal = if hit.normal.dot(d) > 0.0 {
                    -hit.normal
                } else {
                    hit.normal
                };
                seen.push((i, hit.point, normal));
            }
        }
        Ok(Self { rays, side, seen })
    }

    fn lit(&self, point: DVec3, normal: DVec3, to_light: DVec3) -> bool {
        !self
            .rays
            .meets(point + normal * 1e-4, to_light, (0.0, 100.0))
    }
}

/// Parallel light from an elevation, and what it does to a stage.
pub(super) struct Sun<'s> {
    stage: &'s Stage,
    to_light: DVec3,
    kind: ShadowKind,
    /// Points that face the light: pixel, point, normal, lit.
    points: Vec<(u32, DVec3, DVec3, bool)>,
}

impl<'s> Sun<'s> {
    pub(super) fn new(stage: &'s Stage, elevation: f64) -> Self {
        let (sin, cos) = deterministic_f64::sin_cos(elevation.to_radians());
        let to_light = DVec3::new(0.8 * cos, -0.6 * cos, sin);
        let kind = ShadowKind::Directional {
            light_from_world: looking_from(to_light),
            half: HALF,
        };
        let facing = stage.seen.iter().filter(|s| s.2.dot(to_light) > 0.02);
        let points = facing
            .map(|&(i, p, n)| (i, p, n, stage.lit(p, n, to_light)))
            .collect();
        Self {
            stage,
            to_light,
            kind,
            points,
        }
    }

    /// A map whose depths are those of rays.
    pub(super) fn map(&self, size: u32) -> Result<ShadowMap, LabError> {
        const BACK: f64 = 20.0;
        let depth = |i: u32| {
            let (o, d) = ShadowMap::ray(&self.kind, size, 0, i % size, i / size);
            let hit = self.stage.rays.nearest(o - d * BACK, d, (0.0, 100.0));
            hit.map_or(f32::INFINITY, |hit| (hit.t - BACK) as f32)
        };
        let depths = (0..size * size).map(depth).collect();
        Ok(ShadowMap::new(self.kind, size, depths)?)
    }

    /// True for points that lie within `reach` (world units on the light's plane) of a true edge.
    fn near_edge(&self, reach: f64) -> Vec<bool> {
        let (right, up) = self.to_light.any_orthonormal_pair();
        let near = |&(_, p, n, lit): &(u32, DVec3, DVec3, bool)| {
            (0..9).filter(|k| *k != 4).any(|k| {
                let (i, j) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
                let step = right * (i * reach) + up * (j * reach);
                // Along the light onto the receiver's plane.
                let there = p + step - self.to_light * (n.dot(step) / n.dot(self.to_light));
                self.stage.lit(there, n, self.to_light) != lit
            })
        };
        self.points.iter().map(near).collect()
    }

    pub(super) fn judge(&self, values: &[f32], judged: &[bool]) -> Judgement {
        let mut counts = Judgement::default();
        for ((point, value), judged) in self.points.iter().zip(values).zip(judged) {
            if *judged {
                let truth = f64::from(u8::from(point.3));
                let off = f64::from(*value) - truth;
                counts.errors.push(off);
                counts.shadow += usize::from(off < -0.5);
                counts.light += usize::from(off > 0.5);
                counts.bad += usize::from(!value.is_finite());
            }
        }
        counts
    }

    pub(super) fn run(&self, method: Method, map: &ShadowMap, texel: f64, out: &mut [f32]) {
        for ((_, p, n, _), out) in self.points.iter().zip(out) {
            *out = match method.bias(texel) {
                Some((bias, pcf_size)) => map.visibility(*p, *n, bias, pcf_size),
                None => f32::from(u8::from(self.stage.lit(*p, *n, self.to_light))),
            };
        }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }
}

/// World to light space of a light in this direction: its z towards the light, the world's z up.
fn looking_from(to_light: DVec3) -> DMat4 {
    let right = DVec3::Z.cross(to_light).normalize();
    let up = to_light.cross(right);
    DMat4::from_mat3(DMat3::from_cols(right, up, to_light).transpose())
}

/// Errors outside the band.
#[derive(Default)]
pub(super) struct Judgement {
    pub(super) errors: Vec<f64>,
    shadow: usize,
    light: usize,
    bad: usize,
}

impl Judgement {
    /// More than one judged point in a thousand is a failure, not an error.
    fn failures(&self) -> Vec<String> {
        let share = |n: usize| 100.0 * n as f64 / self.errors.len().max(1) as f64;
        let mut out = Vec::new();
        if share(self.shadow) > 0.1 {
            out.push(format!("acne: {:.2} % false shadow", share(self.shadow)));
        }
        if share(self.light) > 0.1 {
            out.push(format!("leak: {:.2} % false light", share(self.light)));
        }
        if self.bad > 0 {
            out.push(format!("{} values that are not finite", self.bad));
        }
        out
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    NoBias,
    Constant,
    Slope(u32),
    NormalOffset(u32),
    Ray,
}

impl Method {
    const ALL: [Self; 7] = [
        Self::NoBias,
        Self::Constant,
        Self::Slope(1),
        Self::Slope(3),
        Self::Slope(5),
        Self::NormalOffset(1),
        Self::NormalOffset(3),
    ];

    fn name(self, size: u32) -> String {
        let comparisons = |n: u32| {
            if n > 1 {
                format!(", {n} x {n}")
            } else {
                String::new()
            }
        };
        match self {
            Self::NoBias => format!("{size}: no bias"),
            Self::Constant => format!("{size}: constant bias"),
            Self::Slope(n) => format!("{size}: slope bias{}", comparisons(n)),
            Self::NormalOffset(n) => format!("{size}: normal offset{}", comparisons(n)),
            Self::Ray => "shadow ray".to_owned(),
        }
    }

    fn bias(self, texel: f64) -> Option<(ShadowBias, u32)> {
        match self {
            Self::NoBias => Some((ShadowBias::Constant(0.0), 1)),
            Self::Constant => Some((ShadowBias::Constant(texel), 1)),
            Self::Slope(n) => Some((ShadowBias::Slope(1e-4), n)),
            Self::NormalOffset(n) => Some((ShadowBias::NormalOffset(1.5), n)),
            Self::Ray => None,
        }
    }
}

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    let full = effort == Effort::FULL;
    let stage = Stage::new(if full { 256 } else { 128 })?;
    let sizes: &[u32] = if full {
        &[512, 1024, 2048]
    } else {
        &[512, 1024]
    };
    let mut charts = Vec::new();
    for elevation in [60.0, 25.0, 10.0] {
        let sun = Sun::new(&stage, elevation);
        let mut points = Vec::new();
        let mut candidates = Vec::new();
        for &size in sizes {
            let texel = 2.0 * HALF / f64::from(size);
            let map = sun.map(size)?;
            let judged: Vec<bool> = sun.near_edge(BAND * texel).iter().map(|n| !n).collect();
            for method in Method::ALL {
                candidates.push((method, size, texel, map.clone(), judged.clone()));
            }
        }
        if let Some((_, size, texel, map, judged)) = candidates.first().cloned() {
            candidates.push((Method::Ray, size, texel, map, judged));
        }
        for (method, size, texel, map, judged) in &candidates {
            let mut out = vec![0.0f32; sun.len()];
            sun.run(*method, map, *texel, &mut out);
            let judgement = sun.judge(&out, judged);
            points.push(Point {
                method: method.name(*size),
                source: Source::of_lab(*method == Method::Ray),
                time: None,
                error: Error::of(judgement.errors.iter().copied()),
                bytes: Some(4 * u64::from(*size) * u64::from(*size)),
                failures: judgement.failures(),
                picture: Some(picture(&sun, &out)),
            });
        }
        let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
        for (method, _, texel, map, _) in &candidates {
            let sun = &sun;
            let mut out = vec![0.0f32; sun.len()];
            runs.push(Box::new(move || {
                sun.run(*method, map, *texel, &mut out);
                std::hint::black_box(&out);
            }));
        }
        timed(&mut points, effort, sun.len(), &mut runs);
        charts.push(SceneChart {
            id: format!("shadows-{elevation}"),
            title: format!("Parallel light at an elevation of {elevation} degrees"),
            truth: format!(
                "a shadow ray from each of {} points, lifted 1e-4; outside {BAND} texels around true edges",
                sun.len()
            ),
            item: "look-up",
            unit: "of full light",
            across: Across::Time,
            points,
        });
    }
    Ok(Panel {
        id: "shadows",
        title: "Shadow maps",
        about: "A ball, a thin wall and a post on a floor; the map covers 5.2 x 5.2 units with its side in texels. False \
                shadow (acne) or false light (a leak) in more than a thousandth of the points outside the band makes a \
                method hollow.",
        charts,
    })
}

/// A picture of the light and, beside it, of its error: the band too.
fn picture(sun: &Sun<'_>, values: &[f32]) -> Picture {
    let side = sun.stage.side;
    let step = side / 128;
    let mut picture = Picture::new(258, 128, [96, 96, 128, 255]);
    for ((i, _, n, lit), value) in sun.points.iter().zip(values) {
        let (x, y) = (i % side, i / side);
        if x % step == 0 && y % step == 0 {
            let (x, y) = (i64::from(x / step), i64::from(y / step));
            let shade = (0.15 + 0.85 * f64::from(*value) * n.dot(sun.to_light)) * 15.0;
            let c = shade.round() as u8 * 17;
            picture.set(x, y, [c, c, c, 255]);
            let off = (f64::from(*value) - f64::from(u8::from(*lit))).abs();
            picture.set(x + 130, y, heat(off));
        }
    }
    picture
}
