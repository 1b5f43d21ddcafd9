//! Look-ups in volumes sixteen at a time, with the bits of [`Sampler::sample_3d`].

use super::Texture3d;
use crate::{
    error::SampleError,
    filter::gl_of,
    lanes::{
        ANY, At, Kind, View, exact_format,
        float::{Color, fetch_two, limit_lanes, mix, mix_four, scaled, tap},
        gl::Reads,
        index, place,
    },
    sampler::{Mip, Sampler, Texel},
    slice::{check, on_lanes},
    wrap::{Axis, Wrap},
};
use texmap_math::{
    Level,
    fearless_simd::{f32x16, i32x16, prelude::*},
    lanes::{floor_to_i32, is_wide, load_tail, store_tail},
};

/// Points of the unit cube that repeats or ends as the wraps say, each coordinate in a slice of its own.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// Along columns.
    pub u: &'a [f32],
    /// Along rows.
    pub v: &'a [f32],
    /// Along slices.
    pub w: &'a [f32],
    /// Levels of detail; without them every look-up has level 0.
    pub lod: Option<&'a [f32]>,
}

/// [`Sampler::sample_3d`] over columns, dispatched once: the same bits, entry by entry.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_3d_columns(
    level: Level,
    sampler: &Sampler,
    t: &Texture3d<'_>,
    wrap_w: Wrap,
    at: &Points<'_>,
    mut out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    check("v", at.u.len(), at.v.len())?;
    check("w", at.u.len(), at.w.len())?;
    if let Some(lod) = at.lod {
        check("lod", at.u.len(), lod.len())?;
    }
    for column in &out {
        check("out", at.u.len(), column.len())?;
    }
    let lanes =
        VolumeView::new(sampler, t, wrap_w).is_some_and(|view| view.columns(level, at, &mut out));
    if !lanes {
        for i in 0..at.u.len() {
            let lod = at.lod.map_or(0.0, |lod| lod[i]);
            let c = sampler.sample_3d(t, [at.u[i], at.v[i], at.w[i]], wrap_w, lod);
            for (out, c) in out.iter_mut().zip(c) {
                out[i] = c;
            }
        }
    }
    Ok(())
}

/// A volume and a sampler prepared for look-ups in lanes.
#[derive(Clone, Debug)]
pub(crate) struct VolumeView<'a> {
    view: View<'a>,
    gl: (Texel, Texel, Mip),
    along_w: Axis,
    depth: i32,
}

impl<'a> VolumeView<'a> {
    /// `None` only for a volume without a texel.
    pub(crate) fn new(sampler: &Sampler, t: &'a Texture3d<'_>, wrap_w: Wrap) -> Option<Self> {
        let format = exact_format(&t.chain);
        let depth = t.chain.levels.first()?.depth;
        let view = View::prepared(sampler, &t.chain, Kind::Trilinear, format)?;
        Some(Self {
            view: if wrap_w == Wrap::ClampToBorder {
                view.with_border()
            } else {
                view
            },
            gl: gl_of(sampler.filter),
            along_w: Axis::new(wrap_w, depth),
            depth,
        })
    }

    /// False where there is no vector unit, with nothing done. The columns have one length.
    pub(crate) fn columns(&self, level: Level, at: &Points<'_>, out: &mut [&mut [f32]; 4]) -> bool {
        on_lanes!(level, s => self.on(s, at, out))
    }

    fn on<S: Simd>(&self, s: S, at: &Points<'_>, out: &mut [&mut [f32]; 4]) {
        s.vectorize(
            #[inline(always)]
            || {
                let flat = f32x16::splat(s, 0.0);
                for first in (0..at.u.len()).step_by(16) {
                    let uvw = [
                        load_tail(s, &at.u[first..]),
                        load_tail(s, &at.v[first..]),
                        load_tail(s, &at.w[first..]),
                    ];
                    let lod = at.lod.map_or(flat, |lod| load_tail(s, &lod[first..]));
                    let c = self.look(s, uvw, lod);
                    let end = at.u.len().min(first + 16);
                    for (k, out) in out.iter_mut().enumerate() {
                        store_tail(c[k], &mut out[first..end]);
                    }
                }
            },
        );
    }

    #[inline(always)]
    fn look<S: Simd>(&self, s: S, uvw: [f32x16<S>; 3], lod: f32x16<S>) -> Color<S> {
        let view = &self.view;
        // NaN reads as 0, as it does for one.
        let lod = lod.simd_eq(lod).select(lod, f32x16::splat(s, 0.0));
        let mut reads = Reads::new(s, view, self.gl, limit_lanes(s, view, lod));
        let mut color = [f32x16::splat(s, 0.0); 4];
        loop {
            if reads.lanes.any_true() {
                let read = match reads.texel {
                    Texel::Nearest => self.nearest(s, reads.level, uvw),
                    Texel::Linear => self.eight(s, reads.level, uvw),
                };
                color = reads.onto(view, color, read);
            }
            if !reads.step() {
                return scaled(color, view);
            }
        }
    }

    /// Slices of a level.
    #[inline(always)]
    fn depth<S: Simd>(&self, s: S, level: i32x16<S>) -> i32x16<S> {
        let one = i32x16::splat(s, 1);
        let depth = i32x16::splat(s, self.depth) >> level;
        depth.simd_gt(one).select(depth, one)
    }

    #[inline(always)]
    fn nearest<S: Simd>(&self, s: S, level: i32x16<S>, [u, v, w]: [f32x16<S>; 3]) -> Color<S> {
        let view = &self.view;
        let (at, depth) = (At::of(s, view, level), self.depth(s, level));
        let (x, y) = at.place(s, view, u, v);
        let z = place(s, view, self.along_w, w, depth.to_float());
        let (x, y) = at.wrapped(s, view, floor_to_i32(s, x), floor_to_i32(s, y));
        let z = index(s, self.along_w, floor_to_i32(s, z), depth);
        tap::<S, ANY>(s, view, at.in_slice::<ANY>(view, [x, y, z]))
    }

    /// Eight texels, weighted.
    #[inline(always)]
    fn eight<S: Simd>(&self, s: S, level: i32x16<S>, [u, v, w]: [f32x16<S>; 3]) -> Color<S> {
        let view = &self.view;
        let (at, depth) = (At::of(s, view, level), self.depth(s, level));
        let (x, y) = at.place(s, view, u, v);
        let z = place(s, view, self.along_w, w, depth.to_float());
        let (x, y, z) = (x - 0.5, y - 0.5, z - 0.5);
        let (i, j, k) = (floor_to_i32(s, x), floor_to_i32(s, y), floor_to_i32(s, z));
        let wx = x - i.to_float::<f32x16<S>>();
        let wy = y - j.to_float::<f32x16<S>>();
        let wz = z - k.to_float::<f32x16<S>>();
        let (x0, y0) = at.wrapped(s, view, i, j);
        let (x1, y1) = at.wrapped(s, view, i + 1, j + 1);
        let z = [
            index(s, self.along_w, k, depth),
            index(s, self.along_w, k + 1, depth),
        ];
        let pairs = is_wide(s) && !view.is_bordered() && (x1 - x0).simd_eq(1).all_true();
        let mut slices = [[f32x16::splat(s, 0.0); 4]; 2];
        for (slice, z) in slices.iter_mut().zip(&z) {
            let left = [
                at.in_slice::<ANY>(view, [x0, y0, *z]),
                at.in_slice::<ANY>(view, [x0, y1, *z]),
            ];
            let [top, bottom] = if pairs {
                [
                    fetch_two::<S, ANY>(s, view, left[0].word),
                    fetch_two::<S, ANY>(s, view, left[1].word),
                ]
            } else {
                let right = [
                    at.in_slice::<ANY>(view, [x1, y0, *z]),
                    at.in_slice::<ANY>(view, [x1, y1, *z]),
                ];
                [
                    [
                        tap::<S, ANY>(s, view, left[0]),
                        tap::<S, ANY>(s, view, right[0]),
                    ],
                    [
                        tap::<S, ANY>(s, view, left[1]),
                        tap::<S, ANY>(s, view, right[1]),
                    ],
                ]
            };
            *slice = mix_four(view, top, bottom, wx, wy);
        }
        let [near, far] = slices;
        mix(view, near, far, wz)
    }
}
