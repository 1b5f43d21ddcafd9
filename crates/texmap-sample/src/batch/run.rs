//! The look-ups of a batch, dispatched to the kernel of its filter.

use super::{PART, Places};
use crate::{
    address::lod::TexelFootprint,
    bound_texture::{BoundTexture, RGBA8, RGBA8_EXACT, RGBA16},
    filter::{ByteKernel, CellKernel, FilterKernel, Input, LookUp, Run, Single, cell::RUN, run},
    rgba8,
    sampler::Sampler,
    vectors::{in_vectors, load, store_columns, vector_start},
};
use texmap_math::{
    Level, color, dispatch_simd,
    footprint::Footprint,
    simd::{ByteIsa, Isa, One, Scalar, prelude::*},
};

/// Look-ups in one texture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Batch<'a> {
    sampler: &'a Sampler,
    view: &'a BoundTexture<'a>,
    pub(super) at: Places<'a>,
    /// The limited level of look-ups without gradients.
    flat: f32,
}

impl<'a> Batch<'a> {
    /// Of columns of one length.
    pub(crate) fn new(sampler: &'a Sampler, view: &'a BoundTexture<'a>, at: Places<'a>) -> Self {
        Self {
            sampler,
            view,
            at,
            flat: sampler.limit_lod(0.0),
        }
    }

    /// Colours into columns of the batch's length.
    pub(crate) fn columns(&self, level: Level, mut out: [&mut [f32]; 4]) {
        if self.view.format != RGBA8 {
            self.run(Columns {
                batch: self,
                level,
                out,
            });
            return;
        }
        let mut words = [0; PART];
        for first in (0..self.at.u.len()).step_by(PART) {
            let count = PART.min(self.at.u.len() - first);
            self.part(first, count).words(level, &mut words[..count]);
            let out = out.each_mut().map(|c| &mut c[first..first + count]);
            dispatch_simd!(level, i => unpack_columns(i, &words[..count], out));
        }
    }

    /// Colours of textures that share cells, the first of them that of the batch: columns of the batch's length for each.
    pub(super) fn joint_columns(
        &self,
        level: Level,
        views: &[BoundTexture<'_>],
        outs: &mut [[&mut [f32]; 4]],
    ) {
        self.run(JointColumns {
            batch: self,
            level,
            views,
            outs,
        });
    }

    /// Colours as packed bytes.
    pub(crate) fn words(&self, level: Level, out: &mut [u32]) {
        self.run(Words {
            batch: self,
            level,
            out,
        });
    }

    fn run<R: Run>(&self, kernel: R) -> R::Out {
        let BoundTexture { kind, format, .. } = *self.view;
        run(kind, format, self.at.gradients.is_some(), kernel)
    }

    /// `count` look-ups from `first` on.
    fn part(&self, first: usize, count: usize) -> Self {
        Self {
            at: self.at.part(first..first + count),
            ..*self
        }
    }

    /// Look-up `k`.
    fn single(&self, k: usize) -> Single<'_> {
        Single {
            sampler: self.sampler,
            chain: self.view.chain,
            uv: [self.at.u[k], self.at.v[k]],
            footprint: self.at.gradients.map(|d| Footprint {
                du_dx: d[0][k],
                dv_dx: d[1][k],
                du_dy: d[2][k],
                dv_dy: d[3][k],
            }),
            flat: self.flat,
        }
    }

    /// As many as there are lanes, from `first` on, as far as a filter reads them.
    #[inline(always)]
    fn look_up<I: Isa>(&self, i: I, first: usize, input: Input) -> LookUp<I> {
        LookUp {
            uv: [load(i, self.at.u, first), load(i, self.at.v, first)],
            footprint: match input {
                Input::Coordinates | Input::Level => None,
                Input::Footprint => self.footprint(i, first),
            },
            flat: self.flat,
        }
    }

    #[expect(
        clippy::manual_map,
        reason = "the closure of `map` is not always inlined, and would be compiled without vector instructions"
    )]
    #[inline(always)]
    fn footprint<I: Isa>(&self, i: I, first: usize) -> Option<TexelFootprint<I>> {
        match self.at.gradients {
            Some([ux, vx, uy, vy]) => Some(TexelFootprint::new(
                i,
                self.view,
                load(i, ux, first),
                load(i, vx, first),
                load(i, uy, first),
                load(i, vy, first),
            )),
            None => None,
        }
    }

    /// The level of detail of as many, if a filter reads it.
    #[inline(always)]
    fn lod<I: Isa>(&self, i: I, first: usize, input: Input) -> I::F32 {
        match input {
            Input::Level => self.look_up(i, first, Input::Footprint).lod(i, self.view),
            Input::Coordinates | Input::Footprint => i.f32(0.0),
        }
    }

    /// Runs `kernel` on a batch of at least as many look-ups as there are lanes: this one, or if it is too short, one in which the
    /// last look-up stands several times.
    fn in_vectors<I: Isa, T: Copy + Default, const OUT: usize>(
        &self,
        out: [&mut [T]; OUT],
        kernel: impl FnOnce(&Batch<'_>, [&mut [T]; OUT]),
    ) {
        let (with, at) = (self.at.gradients.is_some(), self.at);
        let [ux, vx, uy, vy] = at.gradients.unwrap_or([at.u; 4]);
        in_vectors::<I, T, 6, OUT>([at.u, at.v, ux, vx, uy, vy], out, |columns, out| {
            let [u, v, gradients @ ..] = columns;
            let gradients = with.then_some(gradients);
            let at = Places { u, v, gradients };
            kernel(&Batch { at, ..*self }, out);
        });
    }
}

/// A batch into columns.
struct Columns<'a> {
    batch: &'a Batch<'a>,
    level: Level,
    out: [&'a mut [f32]; 4],
}

impl Run for Columns<'_> {
    type Out = ();

    fn color<K: FilterKernel>(self) {
        let Self { batch, level, out } = self;
        dispatch_simd!(level, i => color_columns::<_, K>(i, batch, out));
    }

    fn cells<F: FilterKernel, K: CellKernel>(self) {
        let Self { batch, level, out } = self;
        dispatch_simd!(level, i => cell_columns::<_, F, K>(i, batch, out));
    }

    fn bytes<K: ByteKernel>(self) {
        self.batch.columns(self.level, self.out);
    }
}

/// A batch into columns of several textures that share cells.
struct JointColumns<'a, 'o> {
    batch: &'a Batch<'a>,
    level: Level,
    views: &'a [BoundTexture<'a>],
    outs: &'a mut [[&'o mut [f32]; 4]],
}

impl Run for JointColumns<'_, '_> {
    type Out = ();

    fn color<K: FilterKernel>(self) {
        self.apart();
    }

    fn cells<F: FilterKernel, K: CellKernel>(self) {
        let (batch, views, outs) = (self.batch, self.views, &mut *self.outs);
        if !dispatch_simd!(self.level, i => joint_cells::<_, K>(i, batch, views, outs)) {
            self.apart();
        }
    }

    fn bytes<K: ByteKernel>(self) {
        self.apart();
    }
}

impl JointColumns<'_, '_> {
    /// One texture after the other.
    fn apart(self) {
        for (view, out) in self.views.iter().zip(self.outs) {
            let batch = Batch {
                view,
                ..*self.batch
            };
            batch.columns(self.level, out.each_mut().map(|column| &mut **column));
        }
    }
}

/// False, with nothing done, where a level has no cells or the batch is shorter than a vector.
#[inline(always)]
fn joint_cells<I: Isa, K: CellKernel>(
    i: I,
    batch: &Batch<'_>,
    views: &[BoundTexture<'_>],
    outs: &mut [[&mut [f32]; 4]],
) -> bool {
    let some = I::LANES > 1 && batch.at.u.len() >= I::LANES;
    if some {
        cell_vectors::<I, K>(i, batch, views, outs);
    }
    some
}

/// A batch into packed bytes.
struct Words<'a> {
    batch: &'a Batch<'a>,
    level: Level,
    out: &'a mut [u32],
}

impl Run for Words<'_> {
    type Out = ();

    fn color<K: FilterKernel>(self) {
        let mut colors = [[0.0; PART]; 4];
        for (i, out) in self.out.chunks_mut(PART).enumerate() {
            let count = out.len();
            let part = self.batch.part(i * PART, count);
            part.columns(self.level, colors.each_mut().map(|c| &mut c[..count]));
            for (k, out) in out.iter_mut().enumerate() {
                let c = colors.each_ref().map(|c| color::unit_to_u8(c[k]));
                *out = u32::from_le_bytes(c);
            }
        }
    }

    fn cells<F: FilterKernel, K: CellKernel>(self) {
        self.color::<F>();
    }

    fn bytes<K: ByteKernel>(self) {
        let Self { batch, level, out } = self;
        if K::WIDE {
            dispatch_simd!(level, wide i => byte_words::<_, K>(i, batch, out));
        } else {
            dispatch_simd!(level, i => byte_words::<_, K>(i, batch, out));
        }
    }
}

/// A function of its own for each filter, so that they compile side by side.
#[inline(never)]
fn color_columns<I: Isa, K: FilterKernel>(i: I, batch: &Batch<'_>, mut out: [&mut [f32]; 4]) {
    if const { I::LANES == 1 } {
        for k in 0..batch.at.u.len() {
            let c = batch.single(k).color::<K>();
            out.iter_mut().zip(c).for_each(|(out, c)| out[k] = c);
        }
        return;
    }
    batch.in_vectors::<I, _, 4>(out, |batch, mut out| {
        i.vectorize(
            #[inline(always)]
            || {
                let (view, count) = (batch.view, batch.at.u.len());
                let mut lod = batch.lod(i, 0, K::INPUT);
                for first in (0..count).step_by(I::LANES) {
                    let next = vector_start::<I>(first + I::LANES, count);
                    let ahead = batch.lod(i, next, K::INPUT);
                    let first = vector_start::<I>(first, count);
                    let at = batch.look_up(i, first, K::INPUT);
                    store_columns(i, K::color(i, view, &at, lod), first, &mut out);
                    lod = ahead;
                }
            },
        );
    });
}

#[inline(always)]
fn cell_columns<I: Isa, F: FilterKernel, K: CellKernel>(
    i: I,
    batch: &Batch<'_>,
    out: [&mut [f32]; 4],
) {
    if const { I::LANES == 1 } {
        return color_columns::<I, F>(i, batch, out);
    }
    batch.in_vectors::<I, _, 4>(out, |batch, out| {
        cell_vectors::<I, K>(i, batch, core::slice::from_ref(batch.view), &mut [out]);
    });
}

/// Looks a batch of at least as many coordinates as there are lanes up in textures that share cells, which are found in the first. See
/// [`color_columns`].
#[inline(never)]
fn cell_vectors<I: Isa, K: CellKernel>(
    i: I,
    batch: &Batch<'_>,
    views: &[BoundTexture<'_>],
    outs: &mut [[&mut [f32]; 4]],
) {
    i.vectorize(
        #[inline(always)]
        || {
            let Some(first_view) = views.first() else {
                return;
            };
            let count = batch.at.u.len();
            let mut cells = [K::ZERO; RUN];
            let mut lods = [[0.0; 16]; RUN];
            for start in (0..count).step_by(RUN * I::LANES) {
                // Levels of detail first: a logarithm is a long chain of operations, and those of a run are independent of each other.
                if K::INPUT == Input::Level {
                    for (k, lod) in lods.iter_mut().enumerate() {
                        let first = start + k * I::LANES;
                        if first >= count {
                            break;
                        }
                        let first = vector_start::<I>(first, count);
                        batch.lod(i, first, K::INPUT).store(lod);
                    }
                }
                for (k, (cells, lod)) in cells.iter_mut().zip(&lods).enumerate() {
                    let first = start + k * I::LANES;
                    if first >= count {
                        break;
                    }
                    let at = batch.look_up(i, vector_start::<I>(first, count), K::INPUT);
                    cells.find(i, first_view, &at, i.load_f32(lod));
                }
                let mut format = first_view.format;
                for (view, out) in views.iter().zip(&mut *outs) {
                    if view.format != format {
                        format = view.format;
                        for cells in &mut cells {
                            cells.readdress(i, format);
                        }
                    }
                    if format == RGBA16 {
                        run_colors::<I, K, RGBA16>(i, view, (start, &cells), out);
                    } else {
                        run_colors::<I, K, RGBA8_EXACT>(i, view, (start, &cells), out);
                    }
                }
            }
        },
    );
}

/// The colours of a run's cells, which begin with look-up `start`.
#[inline(always)]
fn run_colors<I: Isa, K: CellKernel, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    (start, cells): (usize, &[K; RUN]),
    out: &mut [&mut [f32]; 4],
) {
    let (count, mut first) = (out[0].len(), start);
    for cells in cells {
        if first >= count {
            break;
        }
        let c = cells.color::<I, FORMAT>(i, view);
        store_columns(i, c, vector_start::<I>(first, count), out);
        first += I::LANES;
    }
}

/// See [`color_columns`].
#[inline(never)]
fn byte_words<I: ByteIsa, K: ByteKernel>(i: I, batch: &Batch<'_>, out: &mut [u32]) {
    if const { I::LANES == 1 } {
        for (k, out) in out.iter_mut().enumerate() {
            *out = batch.single(k).word::<K>();
        }
        return;
    }
    batch.in_vectors::<I, _, 1>([out], |batch, [out]| {
        i.vectorize(
            #[inline(always)]
            || {
                let count = out.len();
                for first in (0..count).step_by(I::LANES) {
                    let first = vector_start::<I>(first, count);
                    let at = batch.look_up(i, first, Input::Footprint);
                    K::word(i, batch.view, &at).store(&mut out[first..][..I::LANES]);
                }
            },
        );
    });
}

#[inline(always)]
fn unpack_columns<I: Isa>(i: I, words: &[u32], mut out: [&mut [f32]; 4]) {
    if words.len() < I::LANES {
        for (k, word) in words.iter().enumerate() {
            let c = rgba8::unpack(Scalar, One(*word));
            out.iter_mut().zip(c).for_each(|(out, c)| out[k] = c);
        }
        return;
    }
    for first in (0..words.len()).step_by(I::LANES) {
        let first = vector_start::<I>(first, words.len());
        let words = i.load_u32(&words[first..]);
        store_columns(i, rgba8::unpack(i, words), first, &mut out);
    }
}
