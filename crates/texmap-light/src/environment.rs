//! Environments: light from every direction, stored in a layout, and its bilinear look-ups.

mod convert;
pub(crate) mod level;
mod mips;
mod specular;

use alloc::vec;
use alloc::vec::Vec;

use texmap_math::glam::{DVec2, DVec3};
use texmap_math::parallel;
use texmap_math::progress::{Progress, Steps};
use texmap_sample::TEXEL_LIMIT;

use crate::EnvironmentLayout;
use crate::error::{LightError, same_length};
pub(crate) use level::{Level, LevelTable};
use level::{bordered, four};

/// Light from every direction, stored in a [`EnvironmentLayout`]: texels with a border of one texel that continues over the edges
/// of each face, so that bilinear look-ups have no seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    pub(crate) layout: EnvironmentLayout,
    /// Level after level, each its faces one after the other, (width + 2) x (height + 2) texels each, linear light.
    pub(crate) texels: Vec<[f32; 3]>,
    /// The texels in [`packed`](crate::packed) form, where [`radiance_filtered`](Self::radiance_filtered) reads that; else empty.
    pub(crate) packed: Vec<u32>,
    /// Mip levels, at least one.
    pub(crate) levels: Vec<Level>,
    /// The levels as tables, for look-ups by level.
    pub(crate) table: LevelTable,
    /// Exponent of the highlight that was gathered.
    pub(crate) exponent: Option<f32>,
}

impl Environment {
    /// Longest side of a face.
    pub const MAX_SIDE: u32 = 8192;

    /// An environment whose texels hold the `light` of their centres' directions, borders too. `size` is the height of a face. Light
    /// that is not finite or beyond 2^120 stays as it is, and look-ups around it may be NaN.
    ///
    /// # Errors
    /// [`LightError::LayoutSize`] for a size of 0 or a side above [`Environment::MAX_SIDE`].
    pub fn from_fn(
        chart: EnvironmentLayout,
        size: u32,
        mut light: impl FnMut(DVec3) -> [f32; 3],
    ) -> Result<Self, LightError> {
        let places = Places::new(chart, size)?;
        let texels = (0..places.count()).map(|i| {
            let (face, centre) = places.at(i);
            light(chart.direction(face, centre / places.sides()))
        });
        let texels = texels.collect();
        Ok(Self::with_borders(chart, places.size, texels))
    }

    /// An environment whose texels, borders too, are made by `light`. Its arguments are a face, a texel's centre and the face's sides,
    /// both in texels. With the feature `rayon` by every thread of the current pool, in no particular order. `progress` hears of each row
    /// that was begun.
    ///
    /// # Errors
    /// As [`Environment::from_fn`]; [`LightError::Cancelled`] after a break of `progress`.
    pub(crate) fn from_directions(
        chart: EnvironmentLayout,
        size: u32,
        progress: Progress<'_>,
        light: impl Fn(usize, DVec2, DVec2) -> [f32; 3] + Sync,
    ) -> Result<Self, LightError> {
        Self::from_groups(chart, size, progress, |[(face, centre)], sides| {
            [light(face, centre, sides)]
        })
    }

    /// As [`from_directions`](Self::from_directions), `N` texels at once, side by side but for the ends of rows. `light` has their faces
    /// and centres, and the sides of a face. A last group repeats the last texel.
    ///
    /// # Errors
    /// As [`Environment::from_directions`].
    pub(crate) fn from_groups<const N: usize>(
        chart: EnvironmentLayout,
        size: u32,
        progress: Progress<'_>,
        light: impl Fn([(usize, DVec2); N], DVec2) -> [[f32; 3]; N] + Sync,
    ) -> Result<Self, LightError> {
        let places = Places::new(chart, size)?;
        let (row, count) = (places.size.0 as usize + 2, places.count());
        let steps = Steps::new(progress, count / row);
        let group = |number: usize| {
            let first = number * N;
            let begun = (first..count.min(first + N)).filter(|at| at % row == 0);
            begun.for_each(|_| steps.step());
            if steps.is_cancelled() {
                return [[0.0; 3]; N];
            }
            let texels = core::array::from_fn(|k| places.at((first + k).min(count - 1)));
            light(texels, places.sides())
        };
        let mut texels = vec![[[0.0; 3]; N]; count.div_ceil(N)];
        // A row at a time: its texels may each gather light from thousands.
        let piece = row.div_ceil(N);
        parallel::for_each(texels.chunks_mut(piece).enumerate(), |(number, groups)| {
            for (texels, at) in groups.iter_mut().zip(number * piece..) {
                *texels = group(at);
            }
        });
        let mut texels = texels.into_flattened();
        texels.truncate(count);
        match steps.is_cancelled() {
            true => Err(LightError::Cancelled),
            false => Ok(Self::with_borders(chart, places.size, texels)),
        }
    }

    /// An environment from images of the faces, linear light, one after the other, rows top to bottom. The borders of the faces are
    /// read from the neighbours.
    ///
    /// # Errors
    /// [`LightError::LayoutSize`] unless each face has the layout's shape (2:1 for lat-long, else square) and a side in
    /// range; [`LightError::Length`] unless `texels` fills the faces; [`LightError::Texel`] for one that is not finite
    /// or beyond 2^120.
    pub fn from_texels(
        chart: EnvironmentLayout,
        (width, height): (u32, u32),
        texels: &[[f32; 3]],
    ) -> Result<Self, LightError> {
        if height == 0 || width > Self::MAX_SIDE || width != height.saturating_mul(chart.aspect()) {
            return Err(LightError::LayoutSize {
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
        check(texels)?;
        Ok(Self::with_borders(
            chart,
            (width, height),
            bordered(chart, (width, height), texels),
        ))
    }

    /// Of the texels of all faces, each face with its borders.
    pub(crate) fn with_borders(
        chart: EnvironmentLayout,
        (width, height): (u32, u32),
        texels: Vec<[f32; 3]>,
    ) -> Self {
        let start = 0;
        let levels = alloc::vec![Level {
            width,
            height,
            start
        }];
        Self {
            layout: chart,
            texels,
            packed: Vec::new(),
            table: LevelTable::new(&levels),
            levels,
            exponent: None,
        }
    }

    /// The texels of level 0.
    pub(crate) fn first_level(&self) -> &[[f32; 3]] {
        let (width, height) = self.size();
        let count = self.layout.faces() * (width as usize + 2) * (height as usize + 2);
        &self.texels[..count]
    }

    /// The layout.
    #[must_use]
    pub fn layout(&self) -> EnvironmentLayout {
        self.layout
    }

    /// Width and height of a face in texels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.levels[0].width, self.levels[0].height)
    }

    /// Number of levels: one without [`with_mips`](Self::with_mips).
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
        let inside = face < self.layout.faces() && x < width && y < height;
        inside.then(|| self.texels[self.levels[0].index(face, x as usize + 1, y as usize + 1)])
    }

    /// Light from a direction of any length, bilinear and without seams. Zero and non-finite directions read as +Z.
    #[must_use]
    pub fn radiance(&self, direction: [f32; 3]) -> [f32; 3] {
        let (face, uv) = self.locate(direction);
        self.bilinear(self.levels[0], face, uv)
    }

    pub(crate) fn locate(&self, direction: [f32; 3]) -> (usize, DVec2) {
        self.layout.locate(DVec3::from(direction.map(f64::from)))
    }

    /// [`radiance`](Self::radiance) for every direction of a slice: the same bits, entry by entry.
    ///
    /// # Errors
    /// [`LightError::Length`] unless both slices have one length.
    pub fn radiance_slice(
        &self,
        directions: &[[f32; 3]],
        out: &mut [[f32; 3]],
    ) -> Result<(), LightError> {
        same_length("directions", directions.len(), out.len())?;
        for (out, direction) in out.iter_mut().zip(directions) {
            *out = self.radiance(*direction);
        }
        Ok(())
    }

    /// Four texels around a point of a face, the border among them.
    pub(crate) fn bilinear(&self, level: Level, face: usize, uv: DVec2) -> [f32; 3] {
        four(&self.texels, level, face, uv)
    }
}

/// # Errors
/// [`LightError::Texel`] for the first texel beyond [`TEXEL_LIMIT`].
fn check(texels: &[[f32; 3]]) -> Result<(), LightError> {
    let beyond = |c: &f32| c.is_nan() || c.abs() > TEXEL_LIMIT;
    match texels.iter().position(|texel| texel.iter().any(beyond)) {
        Some(index) => Err(LightError::Texel { index }),
        None => Ok(()),
    }
}

/// The texels of a layout with their borders, face by face, row by row.
struct Places {
    faces: usize,
    size: (u32, u32),
}

impl Places {
    fn new(chart: EnvironmentLayout, size: u32) -> Result<Self, LightError> {
        let (width, height) = (size.saturating_mul(chart.aspect()), size);
        if size == 0 || width > Environment::MAX_SIDE {
            return Err(LightError::LayoutSize {
                chart,
                width,
                height,
            });
        }
        Ok(Self {
            faces: chart.faces(),
            size: (width, height),
        })
    }

    fn count(&self) -> usize {
        let (width, height) = self.size;
        self.faces * (width as usize + 2) * (height as usize + 2)
    }

    fn sides(&self) -> DVec2 {
        DVec2::new(self.size.0.into(), self.size.1.into())
    }

    /// Face and centre of a texel, in texels; borders lie outside of the face.
    fn at(&self, index: usize) -> (usize, DVec2) {
        let (columns, rows) = (self.size.0 as usize + 2, self.size.1 as usize + 2);
        let (x, y) = (index % columns, index / columns % rows);
        let face = index / columns / rows;
        (face, DVec2::new(x as f64, y as f64) - 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::progress::no_progress;

    #[test]
    fn places_lie_where_one_walk_through_the_faces_finds_them() {
        for chart in EnvironmentLayout::ALL {
            let light = |d: DVec3| d.to_array().map(|c| c as f32);
            let one_by_one = Environment::from_fn(chart, 13, light);
            let in_any_order =
                Environment::from_directions(chart, 13, &no_progress, |face, centre, sides| {
                    light(chart.direction(face, centre / sides))
                });
            assert_eq!(one_by_one, in_any_order, "{chart:?}");
            // Seven do not divide the texels.
            let in_groups =
                Environment::from_groups::<7>(chart, 13, &no_progress, |places, sides| {
                    places.map(|(face, centre)| light(chart.direction(face, centre / sides)))
                });
            assert_eq!(one_by_one, in_groups, "{chart:?}");
            // A face's first texel, after the border's row and one border texel of its own row.
            let texel = one_by_one.unwrap().texel(0, 0, 0);
            let (w, h) = (13 * chart.aspect(), 13);
            let uv = DVec2::new(0.5 / f64::from(w), 0.5 / f64::from(h));
            assert_eq!(texel, Some(light(chart.direction(0, uv))), "{chart:?}");
        }
    }

    /// Neighbours of the greatest and least number differ by an infinity, and look-ups between them were NaN.
    #[test]
    fn light_beyond_the_limit_is_refused_and_light_at_the_limit_is_read() {
        let size = (2, 2);
        for chart in [EnvironmentLayout::Cube, EnvironmentLayout::TanCube] {
            let mut texels = alloc::vec![[TEXEL_LIMIT, -TEXEL_LIMIT, 1.0]; chart.faces() * 4];
            texels[1] = [-TEXEL_LIMIT, TEXEL_LIMIT, 1.0];
            let sky = Environment::from_texels(chart, size, &texels).unwrap();
            let blurred = sky.specular_map(chart, 2, 8.0).unwrap();
            for sky in [sky.with_mips(), blurred] {
                for d in [[0.0, 0.1, 1.0], [0.3, -1.0, 0.2], [-1.0, 1.0, 1.0]] {
                    let light = sky.radiance(d);
                    assert!(
                        light.iter().all(|c| c.abs() <= TEXEL_LIMIT * 1.001),
                        "{light:?}"
                    );
                }
            }
            for beyond in [f32::MAX, f32::MIN, f32::INFINITY, f32::NAN] {
                texels[3][2] = beyond;
                let refused = Environment::from_texels(chart, size, &texels);
                assert_eq!(refused, Err(LightError::Texel { index: 3 }));
            }
        }
    }

    #[test]
    fn a_break_of_progress_ends_every_work() {
        use core::ops::ControlFlow;
        use core::sync::atomic::{AtomicUsize, Ordering};

        let to = EnvironmentLayout::Octahedron;
        let sky = Environment::from_fn(EnvironmentLayout::Cube, 32, |d| [1.0 + d.x as f32; 3]);
        let sky = sky.unwrap();
        let work = |most: usize| {
            let calls = AtomicUsize::new(0);
            let progress = |done: usize, _: usize| {
                calls.fetch_add(1, Ordering::Relaxed);
                match done < most {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(()),
                }
            };
            let made = [
                sky.convert_with_progress(to, 64, &progress),
                sky.specular_map_with_progress(to, 64, 20.0, &progress),
            ];
            (made, calls.into_inner())
        };
        let (made, calls) = work(usize::MAX);
        assert_eq!(made[0], sky.convert(to, 64));
        assert_eq!(made[1], sky.specular_map(to, 64, 20.0));
        let (cancelled, early) = work(3);
        assert!(
            cancelled
                .iter()
                .all(|made| *made == Err(LightError::Cancelled))
        );
        // A thread that has begun a row may still tell it.
        assert!(calls >= 2 * 66 && early < calls / 2, "{calls}, {early}");
    }
}
