//! Look-ups in volumes.

use super::Texture3d;
use crate::{
    address::{
        texel::LaneLevel,
        wrap::{Axis, Wrap},
    },
    batch::check,
    bound_texture::{ANY, BoundTexture, exact_format},
    error::SampleError,
    fetch::{Color, fetch_two, mix, mix_four, scaled, tap},
    filter::{Kernel, bilinear::cell, gl::Reads},
    sampler::{Sampler, TexelFilter},
    vectors::{in_vectors, load, store_columns, vector_start},
};
use texmap_math::{
    Level, dispatch_simd,
    simd::{Isa, prelude::*},
};

/// Points of the unit cube that repeats or ends as the wraps say, each coordinate in a slice of its own.
#[derive(Clone, Copy, Debug)]
pub struct UvwBatch<'a> {
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
pub fn sample_3d_soa(
    level: Level,
    sampler: &Sampler,
    t: &Texture3d<'_>,
    wrap_w: Wrap,
    at: &UvwBatch<'_>,
    out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    check("v", at.u.len(), at.v.len())?;
    check("w", at.u.len(), at.w.len())?;
    if let Some(lod) = at.lod {
        check("lod", at.u.len(), lod.len())?;
    }
    for column in &out {
        check("out", at.u.len(), column.len())?;
    }
    if let Some(view) = VolumeView::new(sampler, t, wrap_w) {
        view.columns(level, at, out);
    }
    Ok(())
}

/// A volume and a sampler prepared for look-ups.
#[derive(Clone, Debug)]
pub(crate) struct VolumeView<'a> {
    view: BoundTexture<'a>,
    along_w: Axis,
    depth: i32,
}

impl<'a> VolumeView<'a> {
    /// `None` only for a volume without a texel.
    pub(crate) fn new(sampler: &Sampler, t: &'a Texture3d<'_>, wrap_w: Wrap) -> Option<Self> {
        let format = exact_format(&t.chain);
        let view = BoundTexture::of_chain(sampler, &t.chain, Kernel::Gl, format)?;
        Some(Self::of(view, sampler, wrap_w, t.depth()))
    }

    #[inline(always)]
    pub(super) fn of(view: BoundTexture<'a>, sampler: &Sampler, wrap_w: Wrap, depth: i32) -> Self {
        Self {
            view: if wrap_w == Wrap::ClampToBorder {
                view.with_border(sampler)
            } else {
                view
            },
            along_w: Axis::new(wrap_w, depth),
            depth,
        }
    }

    /// The columns have one length.
    pub(crate) fn columns(&self, level: Level, at: &UvwBatch<'_>, out: [&mut [f32]; 4]) {
        dispatch_simd!(level, i => self.columns_on(i, at, out));
    }

    #[inline(never)]
    fn columns_on<I: Isa>(&self, i: I, at: &UvwBatch<'_>, out: [&mut [f32]; 4]) {
        let lod = at.lod.unwrap_or(at.u);
        in_vectors::<I, _, 4, 4>([at.u, at.v, at.w, lod], out, |columns, mut out| {
            let ([u, v, w, lod], has_lod) = (columns, at.lod.is_some());
            i.vectorize(
                #[inline(always)]
                || {
                    for first in (0..u.len()).step_by(I::LANES) {
                        let first = vector_start::<I>(first, u.len());
                        let uvw = [load(i, u, first), load(i, v, first), load(i, w, first)];
                        let lod = if has_lod {
                            load(i, lod, first)
                        } else {
                            i.f32(0.0)
                        };
                        store_columns(i, self.look(i, uvw, lod), first, &mut out);
                    }
                },
            );
        });
    }

    #[inline(always)]
    pub(super) fn look<I: Isa>(&self, i: I, uvw: [I::F32; 3], lod: I::F32) -> Color<I> {
        let view = &self.view;
        let lod = lod.simd_eq(lod).select(lod, i.f32(0.0));
        let mut reads = Reads::new(i, view, view.lod_range.limit(i, lod));
        let mut color = [i.f32(0.0); 4];
        loop {
            if reads.lanes.any_true() {
                let read = match reads.texel {
                    TexelFilter::Nearest => self.nearest(i, reads.level, uvw),
                    TexelFilter::Linear => self.eight(i, reads.level, uvw),
                };
                color = reads.onto(view, color, read);
            }
            if !reads.step() {
                return scaled::<I>(color, view);
            }
        }
    }

    /// Slices of a level.
    #[inline(always)]
    fn depth<I: Isa>(&self, i: I, level: I::I32) -> I::I32 {
        (i.i32(self.depth) >> level).max(i.i32(1))
    }

    #[inline(always)]
    fn nearest<I: Isa>(&self, i: I, level: I::I32, [u, v, w]: [I::F32; 3]) -> Color<I> {
        let view = &self.view;
        let (at, depth) = (LaneLevel::of(i, view, level), self.depth(i, level));
        let xy = at.nearest(i, view, [u, v], 0);
        let z = self.along_w.texel(i, w, depth.to_f32(), (0, view.reach));
        let [x, y] = at.wrapped(i, view, xy);
        let z = self.along_w.index(i, z, depth);
        tap::<I, ANY>(i, view, at.in_slice::<ANY>(view, [x, y, z]))
    }

    /// Eight texels, weighted.
    #[inline(always)]
    fn eight<I: Isa>(&self, i: I, level: I::I32, [u, v, w]: [I::F32; 3]) -> Color<I> {
        let view = &self.view;
        let (at, depth) = (LaneLevel::of(i, view, level), self.depth(i, level));
        let [x, y] = at.scale(i, view, [u, v]);
        let z = self.along_w.scale(i, w, depth.to_f32(), view.reach) - 0.5;
        let ([x, y], weights) = cell::<I>([x - 0.5, y - 0.5]);
        let k = z.floor_to_i32();
        let wz = z - k.to_f32();
        let [x0, y0] = at.wrapped(i, view, [x, y]);
        let [x1, y1] = at.wrapped(i, view, [x + 1, y + 1]);
        let z = [
            self.along_w.index(i, k, depth),
            self.along_w.index(i, k + 1, depth),
        ];
        let pairs = i.is_wide() && !view.bordered && (x1 - x0).simd_eq(1).all_true();
        let mut slices = [[i.f32(0.0); 4]; 2];
        for (slice, z) in slices.iter_mut().zip(&z) {
            let mut rows = [[[i.f32(0.0); 4]; 2]; 2];
            for (row, y) in rows.iter_mut().zip([y0, y1]) {
                let left = at.in_slice::<ANY>(view, [x0, y, *z]);
                *row = if pairs {
                    fetch_two::<I, ANY>(i, view, left.word)
                } else {
                    let right = at.in_slice::<ANY>(view, [x1, y, *z]);
                    [tap::<I, ANY>(i, view, left), tap::<I, ANY>(i, view, right)]
                };
            }
            *slice = mix_four::<I>(view, rows, weights);
        }
        let [near, far] = slices;
        mix::<I>(view, near, far, wz)
    }
}
