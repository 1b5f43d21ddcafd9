use alloc::vec::Vec;

use texmap_math::det;
use texmap_math::float::{floor_f32, sqrt};
use texmap_math::glam::{DVec2, DVec3};

use crate::Chart;
use crate::error::{LightError, same_length};
use crate::packed;

/// Light from every direction, stored in a [`Chart`]: texels with a border of one texel that continues over the edges
/// of each face, so that bilinear look-ups have no seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    pub(crate) chart: Chart,
    /// Level after level, each its faces one after the other, (width + 2) x (height + 2) texels each, linear light.
    pub(crate) texels: Vec<[f32; 3]>,
    /// The texels in [`packed`](crate::packed) form, where [`light_across`](Self::light_across) reads that; else empty.
    pub(crate) packed: Vec<u32>,
    /// At least one.
    pub(crate) levels: Vec<Level>,
    /// Of the highlight that was gathered.
    pub(crate) exponent: Option<f32>,
}

/// One level of an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Level {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// First texel.
    pub(crate) start: usize,
}

impl Level {
    fn index(&self, face: usize, x: usize, y: usize) -> usize {
        let (w, h) = (self.width as usize + 2, self.height as usize + 2);
        self.start + (face * h + y) * w + x
    }
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
        Ok(Self::of(chart, (width, height), texels))
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
        Ok(Self::of(
            chart,
            (width, height),
            bordered(chart, (width, height), texels),
        ))
    }

    fn of(chart: Chart, (width, height): (u32, u32), texels: Vec<[f32; 3]>) -> Self {
        let start = 0;
        let levels = alloc::vec![Level {
            width,
            height,
            start
        }];
        Self {
            chart,
            texels,
            packed: Vec::new(),
            levels,
            exponent: None,
        }
    }

    /// With smaller and smaller levels down to a height of 1, each texel the mean of four above it, for look-ups that know their
    /// footprint ([`light_across`](Self::light_across)).
    ///
    /// Where all texels are whole multiples of 1/1020 from 0 to 1, as raw 8-bit values are, those look-ups read them in a packed
    /// form with that step: the smaller levels, and the borders, are off by up to 1/2040.
    #[must_use]
    pub fn with_mips(mut self) -> Self {
        self.levels.truncate(1);
        let (width, height) = self.size();
        self.texels
            .truncate(self.chart.faces() * (width as usize + 2) * (height as usize + 2));
        let exact = self.inner_texels().all(packed::holds);
        let mut above = self.levels[0];
        while above.height > 1 {
            let (width, height) = (above.width / 2, above.height / 2);
            let mut inner =
                Vec::with_capacity(self.chart.faces() * width as usize * height as usize);
            for face in 0..self.chart.faces() {
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    let at = |dx: usize, dy: usize| {
                        let (x, y) = (2 * x as usize + 1 + dx, 2 * y as usize + 1 + dy);
                        self.texels[above.index(face, x, y)]
                    };
                    let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
                    inner.push([0, 1, 2].map(|i| ((a[i] + b[i]) + (c[i] + d[i])) * 0.25));
                }
            }
            above = Level {
                width,
                height,
                start: self.texels.len(),
            };
            self.levels.push(above);
            self.texels
                .extend(bordered(self.chart, (width, height), &inner));
        }
        self.packed.clear();
        if exact {
            self.packed.extend(self.texels.iter().map(packed::pack));
        }
        self
    }

    /// The texels of level 0 without borders.
    fn inner_texels(&self) -> impl Iterator<Item = &[f32; 3]> {
        let (width, height) = self.size();
        let (w, h) = (width as usize + 2, height as usize + 2);
        let faces = self.texels.chunks_exact(w * h).take(self.chart.faces());
        let rows = faces.flat_map(move |face| face.chunks_exact(w).skip(1).take(h - 2));
        rows.flat_map(move |row| &row[1..w - 1])
    }

    /// The chart.
    #[must_use]
    pub fn chart(&self) -> Chart {
        self.chart
    }

    /// Width and height of a face in texels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.levels[0].width, self.levels[0].height)
    }

    /// How many levels there are: one without [`with_mips`](Self::with_mips).
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The exponent of the highlight whose light this map gathers, for one that [`blur`](Self::blur) made.
    #[must_use]
    pub fn exponent(&self) -> Option<f32> {
        self.exponent
    }

    /// A texel of a face; `None` outside.
    #[must_use]
    pub fn texel(&self, face: usize, x: u32, y: u32) -> Option<[f32; 3]> {
        let (width, height) = self.size();
        let inside = face < self.chart.faces() && x < width && y < height;
        inside.then(|| self.texels[self.levels[0].index(face, x as usize + 1, y as usize + 1)])
    }

    /// Light from a direction of any length, bilinear and without seams. Zero and non-finite directions read as +Z.
    #[must_use]
    pub fn light(&self, direction: [f32; 3]) -> [f32; 3] {
        let (face, uv) = self.locate(direction);
        self.bilinear(self.levels[0], face, uv)
    }

    pub(crate) fn locate(&self, direction: [f32; 3]) -> (usize, DVec2) {
        self.chart.locate(DVec3::from(direction.map(f64::from)))
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
        let (width, height) = self.size();
        let ratio = count(self.chart, width, height)
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
                    sum += DVec3::from(self.bilinear(self.levels[0], at, uv).map(f64::from));
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
        let map = Self::from_fn(chart, size, |r| {
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
        })?;
        Ok(Self {
            exponent: Some(exponent),
            ..map
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
        if count(self.chart, self.size().0, self.size().1) > count(Chart::Cube, gathered, gathered)
        {
            let gathered = self.convert(Chart::Cube, gathered)?;
            gathered.blur(chart, size, exponent)
        } else {
            self.blur(chart, size, exponent)
        }
    }

    /// All texels by patches of up to 8 x 8.
    fn patches(&self) -> Vec<Patch> {
        const SIDE: u32 = 8;
        let size @ (width, height) = self.size();
        let texel = |face: usize, x: u32, y: u32| {
            let centre = |c: u32, n: u32| (f64::from(c) + 0.5) / f64::from(n);
            let uv = DVec2::new(centre(x, width), centre(y, height));
            let at = self.levels[0].index(face, x as usize + 1, y as usize + 1);
            (
                self.chart.direction(face, uv),
                DVec3::from(self.texels[at].map(f64::from)),
                self.chart.solid_angle(face, (x, y), size),
            )
        };
        let mut patches = Vec::new();
        for face in 0..self.chart.faces() {
            for y0 in (0..height).step_by(SIDE as usize) {
                for x0 in (0..width).step_by(SIDE as usize) {
                    let columns = x0..width.min(x0 + SIDE);
                    let rows = y0..height.min(y0 + SIDE);
                    let places = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                    patches.push(Patch::new(places.map(|(x, y)| texel(face, x, y)).collect()));
                }
            }
        }
        patches
    }

    /// Four texels around a point of a face, the border among them.
    pub(crate) fn bilinear(&self, level: Level, face: usize, uv: DVec2) -> [f32; 3] {
        four(&self.texels, level, face, uv)
    }
}

/// Four texels around a point of a face of a level, the border among them.
fn four(texels: &[[f32; 3]], level: Level, face: usize, uv: DVec2) -> [f32; 3] {
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
fn bordered(chart: Chart, (width, height): (u32, u32), texels: &[[f32; 3]]) -> Vec<[f32; 3]> {
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
    if matches!(chart, Chart::Cube | Chart::TanCube) {
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
