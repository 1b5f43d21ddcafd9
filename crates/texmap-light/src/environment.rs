use alloc::vec::Vec;

use texmap_math::det;
use texmap_math::float::{floor_f32, sqrt};
use texmap_math::glam::{DVec2, DVec3};

use crate::Chart;
use crate::error::{LightError, same_length};

/// Light from every direction, stored in a [`Chart`]: texels with a border of one texel that continues over the edges
/// of each face, so that bilinear look-ups have no seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    chart: Chart,
    width: u32,
    height: u32,
    /// Faces one after the other, (width + 2) x (height + 2) texels each, linear light.
    texels: Vec<[f32; 3]>,
}

impl Environment {
    /// Longest side of a face.
    pub const MAX_SIDE: u32 = 8192;

    /// Texels that hold `light` of their centre's direction, borders too. `size` is the height of a face.
    ///
    /// # Errors
    /// [`LightError::ChartSize`] for a size of 0 or a side above [`Environment::MAX_SIDE`].
    pub fn from_fn(
        chart: Chart,
        size: u32,
        mut light: impl FnMut(DVec3) -> [f32; 3],
    ) -> Result<Self, LightError> {
        let (width, height) = (size.saturating_mul(chart.aspect()), size);
        if size == 0 || width > Self::MAX_SIDE {
            return Err(LightError::ChartSize {
                chart,
                width,
                height,
            });
        }
        let mut texels =
            Vec::with_capacity(chart.faces() * (width as usize + 2) * (height as usize + 2));
        for face in 0..chart.faces() {
            for y in 0..height + 2 {
                for x in 0..width + 2 {
                    let place = |i: u32, n: u32| (f64::from(i) - 0.5) / f64::from(n);
                    let uv = DVec2::new(place(x, width), place(y, height));
                    texels.push(light(chart.direction(face, uv)));
                }
            }
        }
        Ok(Self {
            chart,
            width,
            height,
            texels,
        })
    }

    /// From images of the faces, linear light, one after the other, rows top to bottom. Their borders are read from the
    /// neighbours.
    ///
    /// # Errors
    /// [`LightError::ChartSize`] unless each face has the chart's shape (2:1 for lat-long, else square) and a side in
    /// range; [`LightError::Length`] unless `texels` fills the faces; [`LightError::Texel`] for one that is not finite.
    pub fn from_texels(
        chart: Chart,
        (width, height): (u32, u32),
        texels: &[[f32; 3]],
    ) -> Result<Self, LightError> {
        if height == 0 || width > Self::MAX_SIDE || width != height.saturating_mul(chart.aspect()) {
            return Err(LightError::ChartSize {
                chart,
                width,
                height,
            });
        }
        same_length(
            "texels",
            texels.len(),
            chart.faces() * width as usize * height as usize,
        )?;
        if let Some(index) = texels.iter().position(|t| t.iter().any(|c| !c.is_finite())) {
            return Err(LightError::Texel { index });
        }
        let (w, h) = (width as usize, height as usize);
        let inner =
            |face: usize, x: usize, y: usize| texels[(face * h + y.min(h - 1)) * w + x.min(w - 1)];
        // Without borders yet: each face clamped at its own edge.
        let mut clamped = Vec::with_capacity(chart.faces() * (w + 2) * (h + 2));
        for face in 0..chart.faces() {
            for y in 0..h + 2 {
                clamped.extend(
                    (0..w + 2).map(|x| inner(face, x.saturating_sub(1), y.saturating_sub(1))),
                );
            }
        }
        let clamped = Self {
            chart,
            width,
            height,
            texels: clamped,
        };
        let mut bordered = clamped.clone();
        for face in 0..chart.faces() {
            for y in 0..height + 2 {
                for x in 0..width + 2 {
                    if x == 0 || y == 0 || x == width + 1 || y == height + 1 {
                        let place = |i: u32, n: u32| (f64::from(i) - 0.5) / f64::from(n);
                        let direction =
                            chart.direction(face, DVec2::new(place(x, width), place(y, height)));
                        let (at, uv) = chart.locate(direction);
                        let index = bordered.index(face, x as usize, y as usize);
                        bordered.texels[index] = clamped.bilinear(at, uv);
                    }
                }
            }
        }
        Ok(bordered)
    }

    /// The chart.
    #[must_use]
    pub fn chart(&self) -> Chart {
        self.chart
    }

    /// Width and height of a face in texels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// A texel of a face; `None` outside.
    #[must_use]
    pub fn texel(&self, face: usize, x: u32, y: u32) -> Option<[f32; 3]> {
        let inside = face < self.chart.faces() && x < self.width && y < self.height;
        inside.then(|| self.texels[self.index(face, x as usize + 1, y as usize + 1)])
    }

    /// Light from a direction of any length, bilinear and without seams. Zero and non-finite directions read as +Z.
    #[must_use]
    pub fn light(&self, direction: [f32; 3]) -> [f32; 3] {
        let (face, uv) = self.chart.locate(DVec3::from(direction.map(f64::from)));
        self.bilinear(face, uv)
    }

    /// [`light`](Self::light) for every direction of a slice: the same bits, entry by entry.
    ///
    /// # Errors
    /// [`LightError::Length`] unless both slices have one length.
    pub fn light_slice(
        &self,
        directions: &[[f32; 3]],
        out: &mut [[f32; 3]],
    ) -> Result<(), LightError> {
        same_length("directions", directions.len(), out.len())?;
        for (out, direction) in out.iter_mut().zip(directions) {
            *out = self.light(*direction);
        }
        Ok(())
    }

    /// The same light in another chart, `size` the height of its faces. Each new texel is the mean over its area of the
    /// old light: at least one look-up per old texel that it covers.
    ///
    /// # Errors
    /// As [`Environment::from_fn`].
    pub fn convert(&self, chart: Chart, size: u32) -> Result<Self, LightError> {
        let count =
            |chart: Chart, w: u32, h: u32| chart.faces() as f64 * f64::from(w) * f64::from(h);
        let ratio = count(self.chart, self.width, self.height)
            / count(chart, size.max(1) * chart.aspect(), size.max(1));
        // Solid angles within a chart differ by up to 5.2, and lat-long's poles by more: two look-ups a texel and axis.
        let n = (2.0 * sqrt(ratio)) as u32 + 1;
        let n = if ratio <= 0.25 { 1 } else { n.min(64) };
        let (w, h) = (
            f64::from(size.max(1) * chart.aspect()),
            f64::from(size.max(1)),
        );
        let mut faces = FaceWalk::new(chart, size);
        Self::from_fn(chart, size, |_| {
            let (face, x, y) = faces.next();
            let mut sum = DVec3::ZERO;
            for j in 0..n {
                for i in 0..n {
                    let inside = |k: u32| (f64::from(k) + 0.5) / f64::from(n) - 0.5;
                    let uv = DVec2::new((x + inside(i)) / w, (y + inside(j)) / h);
                    let (at, uv) = self.chart.locate(chart.direction(face, uv));
                    sum += DVec3::from(self.bilinear(at, uv).map(f64::from));
                }
            }
            (sum / f64::from(n * n)).to_array().map(|c| c as f32)
        })
    }

    /// A specular map: the light that a highlight of this exponent gathers around each direction R, the mean of L(d) with
    /// weight `max(0, R.d)^exponent` over all texels by their solid angle (MIT 6.837, lecture 18, slide 30: area
    /// lights in an environment map in place of the highlight's formula). Directions whose weight is below a millionth are
    /// left out by patches of texels. The work is texels of the result times texels of this map inside of the lobe:
    /// [`convert`](Self::convert) to a small one first.
    ///
    /// # Errors
    /// [`LightError::Exponent`] unless the exponent is finite and at least 0; else as [`Environment::from_fn`].
    pub fn blur(&self, chart: Chart, size: u32, exponent: f32) -> Result<Self, LightError> {
        if !(exponent.is_finite() && exponent >= 0.0) {
            return Err(LightError::Exponent { exponent });
        }
        let lobe = Lobe::new(f64::from(exponent));
        let patches = self.patches();
        Self::from_fn(chart, size, |r| {
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for patch in &patches {
                if lobe.misses(r, patch) {
                    continue;
                }
                for (d, light, angle) in &patch.texels {
                    let weight = angle * lobe.at(r.dot(*d));
                    if weight > 0.0 {
                        sum += *light * weight;
                        weights += weight;
                    }
                }
            }
            // A lobe narrower than a texel meets none.
            if weights > 0.0 {
                (sum / weights).to_array().map(|c| c as f32)
            } else {
                self.light(r.to_array().map(|c| c as f32))
            }
        })
    }

    /// Texels a side of a cube's faces at which a map blurred by this exponent is read off by no more than a hundredth of
    /// its range: bilinear look-ups are off by h^2 / 8 times the second derivatives, which at the peak of cos^n are n
    /// each, for texels of h = 2 / side radians. At least 8; at most 256, from an exponent of 650 on.
    #[must_use]
    pub fn blurred_size(exponent: f32) -> u32 {
        let side = 10.0 * sqrt(f64::from(exponent));
        // NaN counts as 0.
        let side = if side > 8.0 { side } else { 8.0 };
        let side = if side < 256.0 { side } else { 256.0 };
        texmap_math::float::ceil(side) as u32
    }

    /// [`blur`](Self::blur) from no more texels than the lobe needs: of a larger map, from a cube of half as many texels again a
    /// side as [`blurred_size`](Self::blurred_size).
    ///
    /// # Errors
    /// As [`Environment::blur`].
    pub fn specular_map(&self, chart: Chart, size: u32, exponent: f32) -> Result<Self, LightError> {
        let gathered = Self::blurred_size(exponent) * 3 / 2;
        let count = |chart: Chart, width: u32, height: u32| {
            chart.faces() as u64 * u64::from(width) * u64::from(height)
        };
        if count(self.chart, self.width, self.height) > count(Chart::Cube, gathered, gathered) {
            let gathered = self.convert(Chart::Cube, gathered)?;
            gathered.blur(chart, size, exponent)
        } else {
            self.blur(chart, size, exponent)
        }
    }

    /// All texels by patches of up to 8 x 8.
    fn patches(&self) -> Vec<Patch> {
        const SIDE: u32 = 8;
        let size = (self.width, self.height);
        let mut patches = Vec::new();
        for face in 0..self.chart.faces() {
            for y0 in (0..self.height).step_by(SIDE as usize) {
                for x0 in (0..self.width).step_by(SIDE as usize) {
                    let mut texels = Vec::new();
                    for y in y0..self.height.min(y0 + SIDE) {
                        for x in x0..self.width.min(x0 + SIDE) {
                            let uv = DVec2::new(
                                (f64::from(x) + 0.5) / f64::from(self.width),
                                (f64::from(y) + 0.5) / f64::from(self.height),
                            );
                            let light =
                                self.texels[self.index(face, x as usize + 1, y as usize + 1)];
                            texels.push((
                                self.chart.direction(face, uv),
                                DVec3::from(light.map(f64::from)),
                                self.chart.solid_angle(face, (x, y), size),
                            ));
                        }
                    }
                    patches.push(Patch::new(texels));
                }
            }
        }
        patches
    }

    fn index(&self, face: usize, x: usize, y: usize) -> usize {
        let (w, h) = (self.width as usize + 2, self.height as usize + 2);
        (face * h + y) * w + x
    }

    /// Four texels around a point of a face, the border among them.
    fn bilinear(&self, face: usize, uv: DVec2) -> [f32; 3] {
        let place = |c: f64, n: u32| {
            let c = (c * f64::from(n) + 0.5) as f32;
            let low = floor_f32(c);
            let low = if low > 0.0 { low } else { 0.0 };
            let low = if low < n as f32 { low } else { n as f32 };
            (low as usize, c - low)
        };
        let ((x, a), (y, b)) = (place(uv.x, self.width), place(uv.y, self.height));
        let row = |y: usize| {
            let at = self.index(face, x, y);
            let (p, q) = (self.texels[at], self.texels[at + 1]);
            [0, 1, 2].map(|i| p[i] * (1.0 - a) + q[i] * a)
        };
        let (p, q) = (row(y), row(y + 1));
        [0, 1, 2].map(|i| p[i] * (1.0 - b) + q[i] * b)
    }
}

/// The mirrored view: `R = 2(N.V)N - V` for the direction V to the eye and a unit normal N. R has the length of V.
#[must_use]
pub fn reflect(view: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    let k = 2.0 * crate::vector::dot(normal, view);
    [0, 1, 2].map(|i| k * normal[i] - view[i])
}

/// Neighbouring texels: direction, light and solid angle of each, inside of a cone.
struct Patch {
    texels: Vec<(DVec3, DVec3, f64)>,
    axis: DVec3,
    /// Radians from the axis to the farthest of the directions.
    radius: f64,
}

impl Patch {
    fn new(texels: Vec<(DVec3, DVec3, f64)>) -> Self {
        let sum: DVec3 = texels.iter().map(|t| t.0).sum();
        let axis = sum.normalize_or_zero();
        let least = texels.iter().map(|t| t.0.dot(axis)).fold(1.0, f64::min);
        Self {
            texels,
            axis,
            radius: det::acos(least),
        }
    }
}

/// `x^exponent` for 0..=1 from a table of even steps; off by at most (exponent / 4096)^2 / 8.
struct Lobe {
    powers: Vec<f64>,
    /// Radians beyond which the power is below a millionth.
    reach: f64,
}

impl Lobe {
    const STEPS: usize = 4096;

    fn new(exponent: f64) -> Self {
        let power = |i: usize| det::pow(1.0 - i as f64 / Self::STEPS as f64, exponent);
        let least = if exponent > 0.0 {
            det::pow(1e-6, 1.0 / exponent)
        } else {
            0.0
        };
        Self {
            powers: (0..=Self::STEPS).map(power).collect(),
            reach: det::acos(least),
        }
    }

    /// Whether a patch is out of reach from a direction of unit length.
    fn misses(&self, r: DVec3, patch: &Patch) -> bool {
        let angle = self.reach + patch.radius;
        angle < core::f64::consts::PI && r.dot(patch.axis) < det::cos(angle)
    }

    fn at(&self, x: f64) -> f64 {
        if x.is_nan() || x <= 0.0 {
            return 0.0;
        }
        let t = (1.0 - if x < 1.0 { x } else { 1.0 }) * Self::STEPS as f64;
        let i = (t as usize).min(Self::STEPS - 1);
        let k = t - i as f64;
        self.powers[i] * (1.0 - k) + self.powers[i + 1] * k
    }
}

/// Counts through the texels of a chart with their borders, in the order of [`Environment::from_fn`].
struct FaceWalk {
    size: (u32, u32),
    next: (usize, u32, u32),
}

impl FaceWalk {
    fn new(chart: Chart, size: u32) -> Self {
        Self {
            size: (size.saturating_mul(chart.aspect()), size),
            next: (0, 0, 0),
        }
    }

    /// Face and the texel's centre in texels.
    fn next(&mut self) -> (usize, f64, f64) {
        let (face, x, y) = self.next;
        let (width, height) = self.size;
        self.next = match (x == width + 1, y == height + 1) {
            (false, _) => (face, x + 1, y),
            (true, false) => (face, 0, y + 1),
            (true, true) => (face + 1, 0, 0),
        };
        (face, f64::from(x) - 0.5, f64::from(y) - 0.5)
    }
}
