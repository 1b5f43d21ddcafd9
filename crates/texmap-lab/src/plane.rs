//! The tilted plane: how near each filter comes to a supersampled truth.
//!
//! 256x256 pixels, eye (0, -3, 1) to (0.3, 0, 0.35), up +z, 60 degrees; the plane z = 0 with
//! x in [-10, 10], y in [-2.5, 20], uv = (x/4, y/4), a repeated 512x512 texture. The texture may lie turned and magnified.

use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_math::{Footprint, deterministic_f64};
use texmap_sample::{Alpha, ColorSpace, Image, Origin, SampleError, Sampler, TexelData, Texture2d};

const EYE: DVec3 = DVec3::new(0.0, -3.0, 1.0);
const LOOK: DVec3 = DVec3::new(0.3, 0.0, 0.35);
/// Lowest corner of the plane.
const LOW: [f64; 2] = [-10.0, -2.5];
const HIGH: [f64; 2] = [10.0, 20.0];

/// Distance of what is drawn: nothing that is seen is nearer.
const NEAR: f64 = 0.05;

/// Pixels a side of the picture.
pub const SIDE: usize = 256;
/// Texels a side of the textures.
pub const TEXELS: usize = 512;

/// Index of the texel at a point in texels, wrapped.
pub fn nearest([x, y]: [f64; 2]) -> usize {
    let wrap = |c: f64| (c.floor() as i64 & (TEXELS as i64 - 1)) as usize;
    wrap(y) * TEXELS + wrap(x)
}

/// The texture of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Squares of 16 texels.
    Checker,
    /// Two plane waves.
    Sines,
    /// Independent uniform texels.
    Noise,
}

/// Shape of the pixel that the truth averages over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// The pixel's square.
    Box,
    /// A Gaussian of half a pixel, over +-2 pixels.
    Gaussian,
}

/// Texture coordinates of a pixel, with their derivatives.
#[derive(Clone, Copy, Debug)]
struct Hit {
    uv: [f64; 2],
    d: [f64; 4],
}

impl Pattern {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Checker, Self::Sines, Self::Noise];

    /// Row by row, in codes of 0 to 255.
    pub fn bytes(self) -> Vec<u8> {
        let code = |t: f32| (t * 255.0 + 0.5).floor() as u8;
        self.texels().into_iter().map(code).collect()
    }

    /// The same, grey and opaque: four bytes a texel.
    pub fn rgba(self) -> Vec<u8> {
        let bytes = self.bytes().into_iter();
        bytes.flat_map(|c| [c, c, c, 255]).collect()
    }

    /// Row by row.
    pub fn texels(self) -> Vec<f32> {
        (0..TEXELS * TEXELS)
            .map(|i| {
                let (x, y) = (i % TEXELS, i / TEXELS);
                let (fx, fy) = (x as f64, y as f64);
                match self {
                    Self::Checker => ((x / 16 + y / 16) & 1) as f32,
                    Self::Sines => sines([fx, fy]) as f32,
                    Self::Noise => (hash(x as u32, y as u32) >> 8) as f32 / 16_777_216.0,
                }
            })
            .collect()
    }
}

/// The two plane waves of [`Pattern::Sines`] at a point in texels from the centre of the first.
pub fn sines([x, y]: [f64; 2]) -> f64 {
    let turn = core::f64::consts::TAU / 512.0;
    let a = deterministic_f64::sin(turn * (32.0 * x + 8.0 * y));
    let b = deterministic_f64::sin(turn * (5.0 * x - 40.0 * y));
    0.5 + 0.25 * a + 0.25 * b
}

/// Placement of the texture on the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Turned by this angle, radians.
    pub turn: f64,
    /// Factor by which the texture is larger.
    pub magnify: f64,
}

impl Default for View {
    fn default() -> Self {
        Self {
            turn: 0.0,
            magnify: 1.0,
        }
    }
}

impl View {
    fn uv(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = deterministic_f64::sin_cos(self.turn);
        [x * cos - y * sin, x * sin + y * cos].map(|c| c / (4.0 * self.magnify))
    }
}

/// A linear texture of floats without mips, `width` texels wide, rows top to bottom.
pub(crate) fn floats(
    width: u32,
    channels: u32,
    texels: &[f32],
) -> Result<Texture2d<'static>, SampleError> {
    Texture2d::new(&Image {
        width,
        height: texels.len() as u32 / width / channels,
        channels,
        texels: TexelData::F32(texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
}

/// The hash of the benchmark scenes' textures.
fn hash(x: u32, y: u32) -> u32 {
    let mut h = x
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add(y.wrapping_mul(0x85eb_ca77));
    h ^= h >> 15;
    h = h.wrapping_mul(0x2c1b_3c6d);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297a_2d39);
    h ^ h >> 15
}

/// The scene with the pixels that count: they and their diagonal neighbours see the plane.
#[derive(Debug)]
pub struct TiltedPlane {
    view: View,
    hits: Vec<(usize, usize, Hit)>,
}

/// Ray through a picture position (y down) and its change per pixel.
fn ray(x: f64, y: f64) -> ([f64; 3], [f64; 3], [f64; 3]) {
    let forward = normalize([0.3, 3.0, -0.65]);
    let right = normalize(cross(forward, [0.0, 0.0, 1.0]));
    let up = cross(right, forward);
    let half = (core::f64::consts::PI / 6.0).tan();
    let step = 2.0 * half / SIDE as f64;
    let (sx, sy) = (x * step - half, half - y * step);
    let d = core::array::from_fn(|k| forward[k] + right[k] * sx + up[k] * sy);
    (d, right.map(|c| c * step), up.map(|c| -c * step))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn normalize(a: [f64; 3]) -> [f64; 3] {
    let l = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|c| c / l)
}

fn hit(view: View, x: f64, y: f64) -> Option<Hit> {
    let (d, dx, dy) = ray(x, y);
    if d[2] >= 0.0 {
        return None;
    }
    let t = -1.0 / d[2];
    let p = [t * d[0], -3.0 + t * d[1]];
    if (0..2).any(|k| !(LOW[k]..=HIGH[k]).contains(&p[k])) {
        return None;
    }
    let slope = |step: [f64; 3]| {
        let dt = step[2] / (d[2] * d[2]);
        view.uv([t * step[0] + dt * d[0], t * step[1] + dt * d[1]])
    };
    let ([ux, vx], [uy, vy]) = (slope(dx), slope(dy));
    Some(Hit {
        uv: view.uv(p),
        d: [ux, vx, uy, vy],
    })
}

impl Default for TiltedPlane {
    fn default() -> Self {
        Self::new(View::default())
    }
}

impl TiltedPlane {
    /// The plane with its texture lying so.
    pub fn new(view: View) -> Self {
        let centre = |x: usize, y: usize| hit(view, x as f64 + 0.5, y as f64 + 0.5);
        let seen = |x: i64, y: i64| hit(view, x as f64 + 0.5, y as f64 + 0.5).is_some();
        let mut hits = Vec::new();
        for y in 0..SIDE {
            for x in 0..SIDE {
                let (i, j) = (x as i64, y as i64);
                let inside = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
                    .iter()
                    .all(|(dx, dy)| seen(i + dx, j + dy));
                if let (true, Some(h)) = (inside, centre(x, y)) {
                    hits.push((x, y, h));
                }
            }
        }
        Self { view, hits }
    }

    /// The camera, for programs that draw the plane.
    pub fn camera() -> Camera {
        Camera {
            eye: EYE,
            look: LOOK,
            up: DVec3::Z,
            fov_x: core::f64::consts::FRAC_PI_3,
            near: NEAR,
            far: 100.0,
        }
    }

    /// Corners and coordinates of the part of the plane before the eye, a convex polygon, for programs that draw it: not all of
    /// them clip.
    pub fn polygon(&self) -> Vec<(DVec3, [f64; 2])> {
        let corners = [
            [LOW[0], LOW[1]],
            [HIGH[0], LOW[1]],
            [HIGH[0], HIGH[1]],
            [LOW[0], HIGH[1]],
        ]
        .map(|[x, y]| DVec3::new(x, y, 0.0));
        let ahead = |p: DVec3| (p - EYE).dot((LOOK - EYE).normalize()) - NEAR;
        let mut out = Vec::new();
        for (a, b) in corners.into_iter().zip(corners.into_iter().cycle().skip(1)) {
            let (before, after) = (ahead(a), ahead(b));
            if before > 0.0 {
                out.push(a);
            }
            if (before > 0.0) != (after > 0.0) {
                out.push(a + (b - a) * (before / (before - after)));
            }
        }
        out.into_iter()
            .map(|p| (p, self.view.uv([p.x, p.y])))
            .collect()
    }

    /// Column, row and coordinates of each counted pixel.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize, [f64; 2])> + '_ {
        self.hits.iter().map(|(x, y, h)| (*x, *y, h.uv))
    }

    /// Pixels that count.
    pub fn len(&self) -> usize {
        self.hits.len()
    }

    /// Never.
    pub fn is_empty(&self) -> bool {
        self.hits.is_empty()
    }

    /// The texture with its mip chain.
    pub fn texture(pattern: Pattern) -> Texture2d<'static> {
        floats(TEXELS as u32, 1, &pattern.texels())
            .expect("the size is in range")
            .with_mips()
    }

    /// `grid` x `grid` nearest look-ups a counted pixel, for each pattern.
    pub fn truth(&self, truth: Truth, grid: usize) -> Vec<[f64; 3]> {
        let patterns = Pattern::ALL.map(Pattern::texels);
        self.truth_by(truth, grid, |at| {
            let index = nearest(at);
            patterns.each_ref().map(|p| f64::from(p[index]))
        })
    }

    /// The mean of `grid` x `grid` values a counted pixel. `value` takes a point in texels from the corner of the
    /// first, not yet wrapped.
    pub fn truth_by<const N: usize>(
        &self,
        truth: Truth,
        grid: usize,
        value: impl Fn([f64; 2]) -> [f64; N],
    ) -> Vec<[f64; N]> {
        let (reach, sigma2) = match truth {
            Truth::Box => (0.5, None),
            Truth::Gaussian => (2.0, Some(0.25)),
        };
        let places: Vec<(f64, f64)> = (0..grid)
            .map(|i| {
                let at = ((i as f64 + 0.5) / grid as f64 - 0.5) * 2.0 * reach;
                (
                    at,
                    sigma2.map_or(1.0, |s: f64| (-at * at / (2.0 * s)).exp()),
                )
            })
            .collect();
        let mut out = Vec::with_capacity(self.hits.len());
        for &(x, y, _) in &self.hits {
            let (mut sum, mut total) = ([0.0; N], 0.0);
            for &(dy, wy) in &places {
                for &(dx, wx) in &places {
                    let (d, ..) = ray(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy);
                    if d[2] >= 0.0 {
                        continue;
                    }
                    let t = -1.0 / d[2];
                    let uv = self.view.uv([t * d[0], t * d[1] - 3.0]);
                    let values = value(uv.map(|c| c * TEXELS as f64));
                    for (s, v) in sum.iter_mut().zip(values) {
                        *s += wx * wy * v;
                    }
                    total += wx * wy;
                }
            }
            out.push(sum.map(|s| s / total));
        }
        out
    }

    /// Root mean square error of a sampler on one pattern.
    pub fn rmse(
        &self,
        sampler: &Sampler,
        t: &Texture2d<'_>,
        truth: &[[f64; 3]],
        pattern: Pattern,
    ) -> f64 {
        let mut sum = 0.0;
        for ((_, _, h), truth) in self.hits.iter().zip(truth) {
            let [ux, vx, uy, vy] = h.d.map(|d| d as f32);
            let got =
                sampler.sample_grad(t, h.uv.map(|c| c as f32), Footprint::new(ux, vx, uy, vy));
            let e = f64::from(got[0]) - truth[pattern as usize];
            sum += e * e;
        }
        (sum / self.hits.len() as f64).sqrt()
    }

    /// Footprints of the counted pixels.
    pub fn footprints(&self) -> impl Iterator<Item = Footprint> + '_ {
        self.hits.iter().map(|(_, _, h)| {
            let [ux, vx, uy, vy] = h.d.map(|d| d as f32);
            Footprint::new(ux, vx, uy, vy)
        })
    }
}
