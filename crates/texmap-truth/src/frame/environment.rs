//! Environments in f64: light by direction, bilinear on the levels that a footprint asks for.

use std::f64::consts::PI;

use texmap_light::{Environment, EnvironmentLayout, ReflectionBox};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};

use super::color::wide;

/// A direction and its change for one sample to the right and one down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Of any length.
    pub(super) direction: DVec3,
    pub(super) changes: [DVec3; 2],
}

impl Ray {
    /// The ray mirrored by a surface. `self` leads to the eye, `normal` has unit length; the vector that it is the direction of has this
    /// `length` and these changes, of which the part across it turns the normal (Igehy 1999, Tracing Ray Differentials):
    /// `R = 2 (N.V) N - V`, `dR = 2 ((dN.V + N.dV) N + (N.V) dN) - dV`.
    pub(super) fn mirrored(&self, normal: DVec3, length: f64, turns: [DVec3; 2]) -> Self {
        let (n, v) = (normal, self.direction);
        let change = |dv: DVec3, d: DVec3| {
            let dn = (d - n * n.dot(d)) / length;
            2.0 * (n * (dn.dot(v) + n.dot(dv)) + dn * n.dot(v)) - dv
        };
        let [dx, dy] = self.changes;
        Self {
            direction: 2.0 * n.dot(v) * n - v,
            changes: [change(dx, turns[0]), change(dy, turns[1])],
        }
    }
}

impl Ray {
    /// The ray from the middle of a capture to the wall that this ray meets from a position, `moves` its change; from outside of the box
    /// this ray itself.
    pub(super) fn led_to(&self, walls: &ReflectionBox, position: DVec3, moves: [DVec3; 2]) -> Self {
        let [low, high, center] =
            [walls.low, walls.high, walls.center].map(|c| DVec3::from(c.map(f64::from)));
        let beyond = (high - low) * f64::from(ReflectionBox::WALL);
        if position.cmplt(low - beyond).any() || position.cmpgt(high + beyond).any() {
            return *self;
        }
        let reach = |p: DVec3, r: DVec3, axis: usize| {
            let wall = if r[axis] > 0.0 { high[axis] } else { low[axis] };
            (wall - p[axis]) / r[axis]
        };
        let r = self.direction;
        let met = (0..3)
            .filter(|axis| r[*axis] != 0.0)
            .min_by(|a, b| reach(position, r, *a).total_cmp(&reach(position, r, *b)));
        let Some(axis) = met.filter(|axis| reach(position, r, *axis) > 0.0) else {
            return *self;
        };
        let t = reach(position, r, axis);
        let change = |dp: DVec3, dr: DVec3| {
            let moved = dp + t * dr;
            moved - r * (moved[axis] / r[axis])
        };
        Self {
            direction: position + t * r - center,
            changes: [
                change(moves[0], self.changes[0]),
                change(moves[1], self.changes[1]),
            ],
        }
    }
}

/// The faces of an environment, level after level, each with a border of one texel that belongs to its neighbours.
pub(super) struct EnvironmentMap {
    chart: EnvironmentLayout,
    levels: Vec<Level>,
}

struct Level {
    size: [usize; 2],
    /// Face by face.
    texels: Vec<DVec3>,
}

impl Level {
    /// A texel of a face; -1 and the size are the border.
    fn at(&self, face: usize, x: i64, y: i64) -> DVec3 {
        self.texels[self.index(face, x, y)]
    }

    fn index(&self, face: usize, x: i64, y: i64) -> usize {
        let [w, h] = self.size;
        (face * (h + 2) + (y + 1) as usize) * (w + 2) + (x + 1) as usize
    }

    /// Four texels around a point of a face.
    fn bilinear(&self, face: usize, uv: DVec2) -> DVec3 {
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        let at = (uv * size - 0.5).clamp(DVec2::splat(-1.0), size - 0.5);
        let (low, part) = (at.floor(), at - at.floor());
        let (x, y) = (low.x as i64, low.y as i64);
        let row = |y| self.at(face, x, y) * (1.0 - part.x) + self.at(face, x + 1, y) * part.x;
        row(y) * (1.0 - part.y) + row(y + 1) * part.y
    }

    /// From the texels of the faces without borders.
    fn new(
        chart: EnvironmentLayout,
        size: [usize; 2],
        texel: impl Fn(usize, usize, usize) -> DVec3,
    ) -> Self {
        let [w, h] = size;
        let (iw, ih) = (w as i64, h as i64);
        let clamped = |face: usize, x: i64, y: i64| {
            texel(
                face,
                x.clamp(0, iw - 1) as usize,
                y.clamp(0, ih - 1) as usize,
            )
        };
        let mut texels = Vec::with_capacity(chart.faces() * (w + 2) * (h + 2));
        for face in 0..chart.faces() {
            for y in -1..=ih {
                texels.extend((-1..=iw).map(|x| clamped(face, x, y)));
            }
        }
        let inner = Self { size, texels };
        let mut texels = inner.texels.clone();
        for face in 0..chart.faces() {
            for (x, y) in (-1..=ih).flat_map(|y| (-1..=iw).map(move |x| (x, y))) {
                if (0..iw).contains(&x) && (0..ih).contains(&y) {
                    continue;
                }
                // Beyond the edge lies what the neighbour shows in that direction.
                let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let direction = chart.direction(face, centre / DVec2::new(w as f64, h as f64));
                let (neighbour, uv) = chart.locate(direction);
                texels[inner.index(face, x, y)] = inner.bilinear(neighbour, uv);
            }
        }
        let mut level = Self { size, texels };
        if matches!(chart, EnvironmentLayout::Cube | EnvironmentLayout::TanCube) {
            level.join_corners();
        }
        level
    }

    /// At a corner of a cube three faces meet: their mean stands there (OpenGL 4.6 core, section 8.14.1).
    fn join_corners(&mut self) {
        let (w, h) = (self.size[0] as i64, self.size[1] as i64);
        for face in 0..6 {
            for (x, y) in [(-1, -1), (w, -1), (-1, h), (w, h)] {
                let (ix, iy) = (x.clamp(0, w - 1), y.clamp(0, h - 1));
                let three = [(ix, iy), (x, iy), (ix, y)].map(|(x, y)| self.at(face, x, y));
                let index = self.index(face, x, y);
                self.texels[index] = (three[0] + three[1] + three[2]) / 3.0;
            }
        }
    }
}

impl EnvironmentMap {
    /// With as many levels as the environment has; each texel is the mean of four of the level before it.
    pub(super) fn new(environment: &Environment) -> Self {
        let chart = environment.layout();
        let (width, height) = environment.size();
        let size = [width as usize, height as usize];
        let texel = |face, x: usize, y: usize| {
            wide(
                environment
                    .texel(face, x as u32, y as u32)
                    .unwrap_or_default(),
            )
        };
        let mut levels = vec![Level::new(chart, size, texel)];
        while levels.len() < environment.levels() {
            let above = &levels[levels.len() - 1];
            let size = above.size.map(|n| (n / 2).max(1));
            let mean = |face, x: usize, y: usize| {
                let (x, y) = (2 * x as i64, 2 * y as i64);
                let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
                four.iter()
                    .map(|(x, y)| above.at(face, *x, *y))
                    .sum::<DVec3>()
                    / 4.0
            };
            let next = Level::new(chart, size, mean);
            levels.push(next);
        }
        Self { chart, levels }
    }

    /// The light from a direction, over its changes if there are levels.
    pub(super) fn light(&self, ray: &Ray) -> DVec3 {
        let usable = ray.direction.is_finite() && ray.direction != DVec3::ZERO;
        let direction = if usable { ray.direction } else { DVec3::Z };
        let (face, uv) = self.chart.locate(direction);
        let last = (self.levels.len() - 1) as f64;
        if last == 0.0 {
            return self.levels[0].bilinear(face, uv);
        }
        let texels = match self.chart {
            EnvironmentLayout::Cube => self.on_face(direction, ray),
            _ => self.by_angle(direction, ray),
        };
        let lod = if texels > 1.0 {
            deterministic_f64::log2(texels).min(last)
        } else {
            0.0
        };
        let fine = lod.floor();
        let near = self.levels[fine as usize].bilinear(face, uv);
        if lod == fine {
            return near;
        }
        let far = self.levels[fine as usize + 1].bilinear(face, uv);
        near * (1.0 - (lod - fine)) + far * (lod - fine)
    }

    /// Radians that a texel is wide in the mean.
    pub(super) fn texel_angle(&self) -> f64 {
        let [w, h] = self.levels[0].size.map(|n| n as f64);
        (4.0 * PI / (w * h * self.chart.faces() as f64)).sqrt()
    }

    /// Texels that a pixel moves by on the plane of a cube's face (Vulkan 1.4, Cube Map Derivative Transformation).
    fn on_face(&self, direction: DVec3, ray: &Ray) -> f64 {
        let a = direction.abs();
        let axis = match () {
            () if a.z >= a.x && a.z >= a.y => 2,
            () if a.y >= a.x => 1,
            () => 0,
        };
        let major = direction[axis];
        let steps = ray.changes.map(|d| {
            // The two other components over the major one; the third is 1 and rests.
            let mut step = (d - direction * (d[axis] / major)) / major;
            step[axis] = 0.0;
            step.length()
        });
        steps[0].max(steps[1]) * 0.5 * self.levels[0].size[0] as f64
    }

    /// Texels that a pixel turns by, of their mean width.
    fn by_angle(&self, direction: DVec3, ray: &Ray) -> f64 {
        let unit = direction.normalize();
        let turns = ray
            .changes
            .map(|d| (d - unit * unit.dot(d)).length() / direction.length());
        turns[0].max(turns[1]) / self.texel_angle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_light::Ray as LibraryRay;

    /// The library's f32 look-ups are these, on every chart, with levels and without.
    #[test]
    fn light_is_that_of_the_library() {
        for chart in EnvironmentLayout::ALL {
            let light = |d: DVec3| {
                let wave = |k: f64| (0.5 + 0.5 * (k * d.x + 3.0 * d.y * d.z).sin()) as f32;
                [wave(5.0), wave(9.0), wave(2.0)]
            };
            let plain = Environment::from_fn(chart, 32, light).unwrap();
            let texels: Vec<[f32; 3]> = (0..chart.faces())
                .flat_map(|f| {
                    (0..32).flat_map(move |y| (0..32 * chart.aspect()).map(move |x| (f, x, y)))
                })
                .map(|(f, x, y)| plain.texel(f, x, y).unwrap())
                .collect();
            let read = Environment::from_texels(chart, (32 * chart.aspect(), 32), &texels).unwrap();
            for environment in [read.clone(), read.with_mips()] {
                let sphere = EnvironmentMap::new(&environment);
                let mut worst = 0.0f64;
                for i in 0..3_000u32 {
                    let c = |k: f64| (f64::from(i) * k).sin();
                    let direction = DVec3::new(c(0.37), c(0.71), c(1.13));
                    let step = 0.2 * f64::from(i % 7);
                    let changes = [DVec3::new(c(0.2), c(0.9), c(0.5)) * step, DVec3::X * step];
                    let found = sphere.light(&Ray { direction, changes });
                    let narrow = |v: DVec3| v.to_array().map(|c| c as f32);
                    let [dx, dy] = changes.map(narrow);
                    let wanted = environment.radiance_filtered(&LibraryRay {
                        direction: narrow(direction),
                        dx,
                        dy,
                    });
                    worst = worst.max((wide(wanted) - found).abs().max_element());
                }
                // The library's levels of detail are off by .005.
                assert!(
                    worst < 4e-3,
                    "{chart:?}, {} levels: {worst}",
                    environment.levels()
                );
            }
        }
    }
}
