//! Some of a mesh's own pixels, on which filters are tried.

use texmap_math::glam::{DMat3, DVec2, DVec3};
use texmap_math::{Footprint, color};
use texmap_sample::{Filter, Lod, Precision, Sampler, Texture2d};

use super::View;
use crate::TextureSlot;

/// Positions a side of the grid over the mesh's part of the picture.
const GRID: u32 = 24;
/// Pixels below which nothing is said.
const FEWEST: usize = 24;
/// Samples a side of a pixel, for its mean.
const SAMPLES: u32 = 6;
/// Standard errors of the mean by which a prediction is raised.
const MARGIN: f64 = 3.0;

/// Pixels with the mean of the texture over each.
pub(super) struct Pilot {
    places: Vec<([f32; 2], Footprint)>,
    means: Vec<[f32; 4]>,
}

/// A pixel of a triangle: its centre, and the planes of u/w, v/w and 1/w over the picture.
#[derive(Clone, Copy)]
struct Place {
    centre: DVec2,
    planes: [DVec3; 3],
}

impl Place {
    /// Coordinates and their change per pixel at a place beside the centre; `None` beyond the horizon.
    fn at(&self, offset: DVec2) -> Option<([f32; 2], Footprint)> {
        let p = (self.centre + offset).extend(1.0);
        let [u, v, w] = self.planes;
        let inv_w = w.dot(p);
        let uv = [u, v].map(|plane| plane.dot(p) / inv_w);
        let step = |plane: DVec3, value: f64| {
            [
                (plane.x - value * w.x) / inv_w,
                (plane.y - value * w.y) / inv_w,
            ]
        };
        let ([ux, uy], [vx, vy]) = (step(u, uv[0]), step(v, uv[1]));
        let [ux, vx, uy, vy] = [ux, vx, uy, vy].map(|d| d as f32);
        (inv_w > 0.0).then(|| (uv.map(|c| c as f32), Footprint::new(ux, vx, uy, vy)))
    }
}

impl Pilot {
    /// `None` when the mesh is seen in too few positions.
    pub(super) fn new(
        view: &View<'_>,
        slot: &TextureSlot,
        texture: &Texture2d<'_>,
    ) -> Option<Self> {
        let pixels = places(view);
        if pixels.len() < FEWEST {
            return None;
        }
        let read = |(uv, d): ([f32; 2], Footprint)| {
            (slot.transform.apply(uv), slot.transform.apply_footprint(d))
        };
        let reference = Sampler {
            filter: Filter::Anisotropic(16),
            precision: Precision::Exact,
            lod: Lod::default(),
            ..slot.sampler.clone()
        };
        let (mut places, mut means) = (Vec::new(), Vec::new());
        for pixel in &pixels {
            if let Some(centre) = pixel.at(DVec2::ZERO) {
                places.push(read(centre));
                means.push(mean(&reference, texture, |offset| {
                    pixel.at(offset).map(read)
                }));
            }
        }
        Some(Self { places, means })
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// Upper bound of the root mean square error of a sampler over the pixels, in stored values.
    pub(super) fn error(&self, sampler: &Sampler, texture: &Texture2d<'_>, srgb: bool) -> f64 {
        let store = |c: f32| {
            let c = c.clamp(0.0, 1.0);
            f64::from(if srgb { color::linear_to_srgb(c) } else { c })
        };
        let squares: Vec<f64> = self
            .places
            .iter()
            .zip(&self.means)
            .map(|((uv, d), mean)| {
                let found = sampler.sample_grad(texture, *uv, *d);
                let off = |k: usize| (store(found[k]) - store(mean[k])).powi(2);
                let alpha = f64::from(found[3] - mean[3]).powi(2);
                ((off(0) + off(1) + off(2)) / 3.0).max(alpha)
            })
            .collect();
        let n = squares.len() as f64;
        let mean = squares.iter().sum::<f64>() / n;
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n;
        // The last term is the rounding to bytes.
        (mean + MARGIN * (variance / n).sqrt() + (1.0 / 255.0f64).powi(2) / 12.0).sqrt()
    }
}

/// The mean over the pixel's square: samples that each cover their own share of it, in true perspective.
fn mean(
    sampler: &Sampler,
    texture: &Texture2d<'_>,
    at: impl Fn(DVec2) -> Option<([f32; 2], Footprint)>,
) -> [f32; 4] {
    let part = 1.0 / SAMPLES as f32;
    let (mut sum, mut count) = ([0.0f64; 4], 0.0);
    for i in 0..SAMPLES * SAMPLES {
        let offset = |c: u32| (f64::from(c) + 0.5) / f64::from(SAMPLES) - 0.5;
        let Some((uv, d)) = at(DVec2::new(offset(i % SAMPLES), offset(i / SAMPLES))) else {
            continue;
        };
        let share = Footprint::new(
            d.du_dx * part,
            d.dv_dx * part,
            d.du_dy * part,
            d.dv_dy * part,
        );
        let c = sampler.sample_grad(texture, uv, share);
        for k in 0..4 {
            sum[k] += f64::from(c[k]);
        }
        count += 1.0;
    }
    sum.map(|s| (s / count) as f32)
}

/// Pixels where the mesh is nearest, over a jittered grid on its part of the picture.
fn places(view: &View<'_>) -> Vec<Place> {
    let Some((low, high)) = bounds(view) else {
        return Vec::new();
    };
    let cells = GRID * GRID;
    let positions: Vec<DVec2> = (0..cells)
        .map(|i| {
            let jitter = DVec2::new(hash(2 * i), hash(2 * i + 1));
            let cell = DVec2::new(f64::from(i % GRID), f64::from(i / GRID));
            let at = low + (high - low) * (cell + jitter) / f64::from(GRID);
            // Pixel centres: the renderer sees no other places.
            at.floor() + 0.5
        })
        .collect();
    let mut nearest: Vec<Option<(f64, Place)>> = vec![None; cells as usize];
    for triangle in &view.mesh.triangles {
        let corners = triangle.map(|i| view.positions[i as usize]);
        let uv = triangle.map(|i| view.mesh.uvs.get(i as usize).copied().unwrap_or_default());
        let [a, b, c] = corners.map(|p| DVec3::new(p.x, p.y, p.w));
        let m = DMat3::from_cols(a, b, c);
        if m.determinant() == 0.0 || !m.is_finite() {
            continue;
        }
        let weights = m.inverse();
        // Rows of the inverse are the planes of the corners' weights over w.
        let plane = |values: [f64; 3]| weights.transpose() * DVec3::from(values);
        let planes = [
            plane(uv.map(|c| f64::from(c[0]))),
            plane(uv.map(|c| f64::from(c[1]))),
            plane([1.0; 3]),
        ];
        let Some((from, to)) = cell_range(&corners.map(|p| DVec3::new(p.x, p.y, p.w)), low, high)
        else {
            continue;
        };
        for j in from.1..=to.1 {
            for i in from.0..=to.0 {
                let index = (j * GRID + i) as usize;
                let p = positions[index];
                let e = weights * DVec3::new(p.x, p.y, 1.0);
                let inv_w = e.x + e.y + e.z;
                if !(e.min_element() >= 0.0 && inv_w > 0.0)
                    || nearest[index].is_some_and(|(w, _)| w >= inv_w)
                {
                    continue;
                }
                nearest[index] = Some((inv_w, Place { centre: p, planes }));
            }
        }
    }
    nearest
        .into_iter()
        .flatten()
        .map(|(_, place)| place)
        .collect()
}

/// The mesh's part of the picture in pixels; the whole picture where it crosses the eye's plane.
fn bounds(view: &View<'_>) -> Option<(DVec2, DVec2)> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in view
        .mesh
        .triangles
        .iter()
        .flatten()
        .map(|i| view.positions[*i as usize])
    {
        if !(p.w > 1e-9) {
            return Some((DVec2::ZERO, view.size));
        }
        let at = DVec2::new(p.x, p.y) / p.w;
        (low, high) = (low.min(at), high.max(at));
    }
    let (low, high) = (low.max(DVec2::ZERO), high.min(view.size));
    (low.cmplt(high).all()).then_some((low, high))
}

/// The grid's cells that a triangle may touch, both ends included.
fn cell_range(corners: &[DVec3; 3], low: DVec2, high: DVec2) -> Option<((u32, u32), (u32, u32))> {
    let last = GRID - 1;
    if corners.iter().any(|p| !(p.z > 1e-9)) {
        return Some(((0, 0), (last, last)));
    }
    let (mut from, mut to) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in corners {
        let cell = (DVec2::new(p.x, p.y) / p.z - low) / (high - low) * f64::from(GRID);
        (from, to) = (from.min(cell), to.max(cell));
    }
    // A position may lie a pixel away from its cell.
    let reach = DVec2::splat(f64::from(GRID)) / (high - low) + 1.0;
    let (from, to) = ((from - reach).floor(), (to + reach).ceil());
    let end = f64::from(last);
    if to.min_element() < 0.0 || from.max_element() > end {
        return None;
    }
    let index = |c: f64| c.clamp(0.0, end) as u32;
    Some(((index(from.x), index(from.y)), (index(to.x), index(to.y))))
}

/// A number in 0..1 for each index, the same everywhere.
fn hash(index: u32) -> f64 {
    let mut h = index.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    h ^= h >> 16;
    h = h.wrapping_mul(0x21f0_aaad);
    h ^= h >> 15;
    h = h.wrapping_mul(0x735a_2d97);
    f64::from(h ^ (h >> 15)) / 4_294_967_296.0
}
