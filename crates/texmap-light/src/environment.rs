//! Environments: light from every direction, stored in a chart, and its bilinear look-ups.

mod convert;
mod level;
mod mips;
mod specular;

use alloc::vec::Vec;

use texmap_math::glam::{DVec2, DVec3};

use crate::Chart;
use crate::error::{LightError, same_length};
pub(crate) use level::Level;
use level::{bordered, four};

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

    /// Four texels around a point of a face, the border among them.
    pub(crate) fn bilinear(&self, level: Level, face: usize, uv: DVec2) -> [f32; 3] {
        four(&self.texels, level, face, uv)
    }
}
