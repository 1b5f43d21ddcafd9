//! Some of a mesh's own pixels, on which filters are tried.

pub(super) mod pixel_grid;

use std::collections::HashSet;

use texmap_math::glam::{DVec2, DVec3};
use texmap_math::{Footprint, color};
use texmap_uv::PerPixelProjection;

use super::gain::Gain;
use super::look::{Look, Read, Spot};

/// Pixels that a first look takes.
const FIRST: usize = 576;
/// Pixels below which nothing is said.
const FEWEST: usize = 24;
/// Samples a side of a pixel, for its mean.
const SAMPLES: u32 = 6;
/// Part of itself by which a prediction is raised, for the error of such a mean: at a first look, and at a second one if the
/// first left something undecided.
const ROUGH: [f64; 2] = [0.02, 0.005];
/// Standard errors of the mean that a prediction's margin is.
const MARGIN: f64 = 3.0;

/// Pixels with the true colours in each.
pub(super) struct Pilot {
    /// Each pixel's samples, one pixel after the other.
    places: Vec<Spot>,
    /// Colours in each pixel, one pixel after the other.
    truth: Vec<[f32; 4]>,
    /// Index of the end of each pixel's colours in `truth`.
    ends: Vec<usize>,
    /// Part of the mesh's pixels that these are.
    share: f64,
    /// Factor of every colour.
    gain: Gain,
    /// True if something shows through by alpha.
    blended: bool,
    /// Part of itself by which a prediction is raised.
    rough: f64,
}

/// Pixels in which a mesh is seen.
pub(super) struct PixelSamples {
    pub(super) list: Vec<PixelSample>,
    source: Source,
    /// Part of the pixels in its outline's box that were looked at.
    share: f64,
}

impl PixelSamples {
    /// Keeps the pixels without an outline beside them, if all pixels are known: at an outline one sample errs whatever the
    /// filter. A mesh that is hardly more than its outline keeps all.
    pub(super) fn leave_outlines_out(&mut self, size: DVec2) {
        if self.share < 1.0 {
            return;
        }
        let pixel = |p: DVec2| [p.x as i64, p.y as i64];
        let own: HashSet<[i64; 2]> = self.list.iter().map(|p| pixel(p.centre)).collect();
        let [wide, tall] = pixel(size);
        let same = |x: i64, y: i64| {
            !((0..wide).contains(&x) && (0..tall).contains(&y)) || own.contains(&[x, y])
        };
        let inner = self.list.iter().copied().filter(|place| {
            let [x, y] = pixel(place.centre);
            (-1..=1).all(|dy| (-1..=1).all(|dx| same(x + dx, y + dy)))
        });
        let inner: Vec<PixelSample> = inner.collect();
        if inner.len() >= FEWEST {
            self.list = inner;
        }
    }
}

/// An error of a sampler over some pixels, in stored values.
#[derive(Clone, Copy)]
pub(super) struct Predicted {
    /// Root mean square less its margin: the more pixels are known, the smaller.
    pub(super) low: f64,
    /// The same with its margin.
    pub(super) bound: f64,
}

/// Source of a mesh's coordinates: its vertices, a texture frame, or a projection at every pixel.
enum Source {
    Vertices,
    /// The planes of A.W, B.W and C.W over the picture.
    Frame([DVec3; 3]),
    Round(PerPixelProjection),
}

/// A pixel of a triangle: its centre, and the planes over the picture of what its vertices hold, by w.
#[derive(Clone, Copy)]
pub(super) struct PixelSample {
    pub(super) centre: DVec2,
    uv: [DVec3; 2],
    /// The position in the world.
    world: [DVec3; 3],
    /// The plane of 1/w.
    pub(super) inv_w: DVec3,
}

impl PixelSample {
    /// The surface at a point beside the centre, as one of `samples` x `samples` samples of the pixel. `None` beyond the horizon.
    fn spot(&self, source: &Source, offset: DVec2, samples: u32) -> Option<Spot> {
        let p = (self.centre + offset).extend(1.0);
        if !(self.inv_w.dot(p) > 0.0) {
            return None;
        }
        // Value and change to the right and down.
        let of = |plane: DVec3, w: DVec3| {
            let by_w = w.dot(p);
            let value = plane.dot(p) / by_w;
            let step =
                |plane: f64, w: f64| ((plane - value * w) / by_w / f64::from(samples)) as f32;
            (value as f32, step(plane.x, w.x), step(plane.y, w.y))
        };
        let [x, y, z] = self.world.map(|plane| of(plane, self.inv_w));
        let position = [x.0, y.0, z.0];
        let moves = [[x.1, y.1, z.1], [x.2, y.2, z.2]];
        let (uv, footprint) = match source {
            Source::Round(map) => map.uv_at(position, moves[0], moves[1]),
            Source::Frame([a, b, w]) if w.dot(p) != 0.0 => placed(of(*a, *w), of(*b, *w)),
            Source::Frame(_) => return None,
            Source::Vertices => placed(of(self.uv[0], self.inv_w), of(self.uv[1], self.inv_w)),
        };
        Some(Spot {
            uv,
            footprint,
            position,
            moves,
        })
    }
}

fn placed(u: (f32, f32, f32), v: (f32, f32, f32)) -> ([f32; 2], Footprint) {
    ([u.0, v.0], Footprint::new(u.1, v.1, u.2, v.2))
}

impl Pilot {
    /// Of some of the pixels, or with `all` of all of them, for pixels of `samples` x `samples` samples. `None` when there are
    /// too few.
    pub(super) fn new(
        places: &PixelSamples,
        all: bool,
        samples: u32,
        look: &Look<'_>,
        (gain, blended): (Gain, bool),
    ) -> Option<Self> {
        if places.list.len() < FEWEST {
            return None;
        }
        let reference = look.reference();
        let step = if all {
            1
        } else {
            places.list.len().div_ceil(FIRST)
        };
        let mut pilot = Self {
            places: Vec::new(),
            truth: Vec::new(),
            ends: Vec::new(),
            share: places.share / step as f64,
            gain,
            blended,
            rough: ROUGH[usize::from(all)],
        };
        for pixel in places.list.iter().step_by(step) {
            let known = pilot.places.len();
            let own =
                parts(samples).map_while(|offset| pixel.spot(&places.source, offset, samples));
            pilot.places.extend(own);
            if pilot.places.len() < known + (samples * samples) as usize {
                pilot.places.truncate(known);
            } else {
                let parts =
                    parts(SAMPLES).filter_map(|offset| pixel.spot(&places.source, offset, SAMPLES));
                pilot
                    .truth
                    .extend(parts.map(|at| look.color(&reference, &at)));
                pilot.ends.push(pilot.truth.len());
            }
        }
        Some(pilot)
    }

    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The error of a sampler over the mesh's pixels. Blended colours are tried before black and before white: the worse of both.
    pub(super) fn error(&self, look: &Look<'_>, read: &Read, srgb: bool) -> Predicted {
        let samples = self.places.len() / self.ends.len().max(1);
        let places = self.places.chunks_exact(samples.max(1));
        let found: Vec<Vec<[f32; 4]>> = places
            .map(|places| places.iter().map(|at| look.color(read, at)).collect())
            .collect();
        let black = self.error_before(0.0, &found, srgb);
        if !self.blended {
            return black;
        }
        let white = self.error_before(1.0, &found, srgb);
        if white.bound > black.bound {
            white
        } else {
            black
        }
    }

    /// The error of what was found, with this light behind it.
    fn error_before(&self, behind: f32, found: &[Vec<[f32; 4]>], srgb: bool) -> Predicted {
        let store = |c: f32| {
            let c = c.clamp(0.0, 1.0);
            f64::from(if srgb { color::linear_to_srgb(c) } else { c })
        };
        let mut start = 0;
        let squares: Vec<f64> = found
            .iter()
            .zip(&self.ends)
            .map(|(found, end)| {
                let truth = &self.truth[start..*end];
                start = *end;
                let opacities = [alpha(found), alpha(truth)];
                let through = opacities.map(|alpha| behind * (1.0 - alpha) as f32);
                let off = |k: usize| {
                    let apart = self.gain.apart(k, [found, truth], through, store);
                    apart.powi(2)
                };
                let alpha = (opacities[0] - opacities[1]).powi(2);
                ((off(0) + off(1) + off(2)) / 3.0).max(alpha)
            })
            .collect();
        let n = squares.len() as f64;
        let mean = squares.iter().sum::<f64>() / n;
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n;
        // Of a finite number of pixels those that were tried are known (Cochran 1977, section 2.6).
        let unknown = (1.0 - self.share).clamp(0.0, 1.0).sqrt();
        // The last term is the rounding to bytes.
        let root = |square: f64| (square.max(0.0) + (1.0 / 255.0f64).powi(2) / 12.0).sqrt();
        let margin = MARGIN * unknown * (variance / n).sqrt();
        Predicted {
            low: root(mean - margin) * (1.0 - self.rough),
            bound: root(mean + margin) * (1.0 + self.rough),
        }
    }
}

/// The centres of `samples` x `samples` parts of a pixel, from its own centre.
fn parts(samples: u32) -> impl Iterator<Item = DVec2> {
    let offset = move |c: u32| (f64::from(c) + 0.5) / f64::from(samples) - 0.5;
    (0..samples * samples).map(move |i| DVec2::new(offset(i % samples), offset(i / samples)))
}

/// The mean opacity.
fn alpha(texels: &[[f32; 4]]) -> f64 {
    texels.iter().map(|texel| f64::from(texel[3])).sum::<f64>() / texels.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of pixels of a rectangle that stay, in a picture of 40 x 40.
    fn stay(from: [u32; 2], size: [u32; 2], share: f64) -> usize {
        let pixels = (0..size[0] * size[1]).map(|i| [from[0] + i % size[0], from[1] + i / size[0]]);
        let place = |[x, y]: [u32; 2]| PixelSample {
            centre: DVec2::new(f64::from(x), f64::from(y)) + 0.5,
            uv: [DVec3::Z; 2],
            world: [DVec3::Z; 3],
            inv_w: DVec3::Z,
        };
        let mut places = PixelSamples {
            list: pixels.map(place).collect(),
            source: Source::Vertices,
            share,
        };
        places.leave_outlines_out(DVec2::splat(40.0));
        places.list.len()
    }

    #[test]
    fn outlines_are_left_out_and_edges_of_the_picture_are_none() {
        assert_eq!(stay([3, 5], [20, 30], 1.0), 18 * 28);
        assert_eq!(stay([0, 0], [40, 40], 1.0), 40 * 40);
        assert_eq!(stay([0, 5], [20, 30], 1.0), 19 * 28);
        // Neighbours are not known, or nothing would be left to say.
        assert_eq!(stay([3, 5], [20, 30], 0.9), 20 * 30);
        assert_eq!(stay([3, 5], [3, 20], 1.0), 3 * 20);
    }
}
