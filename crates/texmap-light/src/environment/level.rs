//! One level of an environment: faces whose borders continue over their edges, and the bilinear look-up of their texels.

use alloc::vec::Vec;

use texmap_math::float::floor_f32;
use texmap_math::glam::DVec2;

use crate::EnvironmentLayout;

/// One level of an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Level {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// First texel.
    pub(crate) start: usize,
}

impl Level {
    pub(crate) fn index(&self, face: usize, x: usize, y: usize) -> usize {
        let (w, h) = (self.width as usize + 2, self.height as usize + 2);
        self.start + (face * h + y) * w + x
    }
}

/// The levels of an environment as tables, for look-ups by level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LevelTable {
    /// First texel of each.
    pub(crate) start: [u32; 16],
    pub(crate) width: [u32; 16],
    pub(crate) height: [u32; 16],
}

impl LevelTable {
    pub(crate) fn new(levels: &[Level]) -> Self {
        let column = |of: fn(&Level) -> u32| {
            let mut column = [0; 16];
            for (out, level) in column.iter_mut().zip(levels) {
                *out = of(level);
            }
            column
        };
        Self {
            start: column(|level| level.start as u32),
            width: column(|level| level.width),
            height: column(|level| level.height),
        }
    }
}

/// Four texels around a point of a face of a level, the border among them.
pub(super) fn four(texels: &[[f32; 3]], level: Level, face: usize, uv: DVec2) -> [f32; 3] {
    let place = |c: f64, n: u32| {
        let c = (c * f64::from(n) + 0.5) as f32;
        let low = floor_f32(c);
        let low = if low > 0.0 { low } else { 0.0 };
        let low = if low < n as f32 { low } else { n as f32 };
        (low as usize, c - low)
    };
    let ((x, a), (y, b)) = (place(uv.x, level.width), place(uv.y, level.height));
    let row = |y: usize| {
        let at = level.index(face, x, y);
        let (p, q) = (texels[at], texels[at + 1]);
        [0, 1, 2].map(|i| p[i] * (1.0 - a) + q[i] * a)
    };
    let (p, q) = (row(y), row(y + 1));
    [0, 1, 2].map(|i| p[i] * (1.0 - b) + q[i] * b)
}

/// The texels of faces with their borders, read from the neighbours.
pub(super) fn bordered(
    chart: EnvironmentLayout,
    (width, height): (u32, u32),
    texels: &[[f32; 3]],
) -> Vec<[f32; 3]> {
    let (w, h) = (width as usize, height as usize);
    let level = Level {
        width,
        height,
        start: 0,
    };
    // Without borders yet: each face clamped at its own edge.
    let mut clamped = Vec::with_capacity(chart.faces() * (w + 2) * (h + 2));
    for face in 0..chart.faces() {
        for y in 0..h + 2 {
            let row = (face * h + y.saturating_sub(1).min(h - 1)) * w;
            clamped.extend((0..w + 2).map(|x| texels[row + x.saturating_sub(1).min(w - 1)]));
        }
    }
    let mut bordered = clamped.clone();
    for face in 0..chart.faces() {
        for y in 0..height + 2 {
            let edge = y == 0 || y == height + 1;
            let step = if edge { 1 } else { width as usize + 1 };
            for x in (0..width + 2).step_by(step) {
                let place = |i: u32, n: u32| (f64::from(i) - 0.5) / f64::from(n);
                let uv = DVec2::new(place(x, width), place(y, height));
                let (at, uv) = chart.locate(chart.direction(face, uv));
                bordered[level.index(face, x as usize, y as usize)] = four(&clamped, level, at, uv);
            }
        }
    }
    if matches!(chart, EnvironmentLayout::Cube | EnvironmentLayout::TanCube) {
        join_corners(level, &mut bordered);
    }
    bordered
}

/// Three faces meet at a cube's corner and none lies beyond it: there the border is the mean of their three texels (OpenGL 4.6 core,
/// section 8.14.1), so that all three faces have one value at the corner.
fn join_corners(level: Level, texels: &mut [[f32; 3]]) {
    let last = level.width as usize + 1;
    for face in 0..6 {
        for (x, y) in [(0, 0), (last, 0), (0, last), (last, last)] {
            let inner = |c: usize| if c == 0 { 1 } else { last - 1 };
            let [a, b, c] = [(inner(x), inner(y)), (x, inner(y)), (inner(x), y)]
                .map(|(x, y)| texels[level.index(face, x, y)]);
            texels[level.index(face, x, y)] = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        }
    }
}
