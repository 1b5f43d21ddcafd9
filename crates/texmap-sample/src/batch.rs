//! Batches of look-ups: checked once, dispatched once.

use crate::{
    address::lod::TexelFootprint,
    bound_texture::{BoundTexture, RGBA8},
    error::SampleError,
    filter::{ByteKernel, CellKernel, FilterKernel, Input, LookUp, Run, Single, cell::RUN, run},
    rgba8,
    sampler::Sampler,
    texture::Texture2d,
};
use texmap_math::{
    Level, color, dispatch_simd,
    footprint::Footprint,
    simd::{ByteIsa, Isa, One, Scalar, prelude::*},
};

/// Samples at many coordinates at once; dispatches to the SIMD level once. Results equal
/// [`Sampler::sample_grad`] (or [`Sampler::sample`] without gradients) bit for bit.
///
/// ```
/// use texmap_math::{Footprint, Level};
/// use texmap_sample::{ColorSpace, Origin, Sampler, Texture2d, sample_slice};
///
/// let t = Texture2d::from_rgba8(2, 2, [40, 80, 120, 255].repeat(4), ColorSpace::Linear, Origin::TopLeft)?
///     .with_mips();
/// let (s, d) = (Sampler::default(), Footprint::new(0.3, 0.1, 0.0, 0.4));
/// let (u, v) = ([0.1, 0.5, 7.3], [0.9, 0.2, -4.0]);
/// let mut out = [[0.0; 4]; 3];
/// sample_slice(Level::new(), &s, &t, &u, &v, Some(&[d; 3]), &mut out)?;
/// assert_eq!(out[2], s.sample_grad(&t, [7.3, -4.0], d));
///
/// let short = sample_slice(Level::new(), &s, &t, &u, &v[..2], None, &mut out);
/// assert_eq!(short.unwrap_err().to_string(), "v holds 2 entries, the coordinates have 3");
/// # Ok::<(), texmap_sample::SampleError>(())
/// ```
///
/// # Errors
/// Slices of different lengths.
pub fn sample_slice(
    level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    u: &[f32],
    v: &[f32],
    grads: Option<&[Footprint]>,
    out: &mut [[f32; 4]],
) -> Result<(), SampleError> {
    check("out", u.len(), out.len())?;
    let mut colors = [[0.0; PART]; 4];
    in_parts(sampler, t, [u, v], grads, |first, batch| {
        let count = batch.at.u.len();
        batch.columns(level, colors.each_mut().map(|c| &mut c[..count]));
        for (k, out) in out[first..first + count].iter_mut().enumerate() {
            *out = colors.each_ref().map(|c| c[k]);
        }
    })
}

/// As [`sample_slice`] for [`Precision::Fast`](crate::Precision::Fast) on 8-bit textures. Textures
/// are linear, opaque or cut out; results are packed RGBA bytes, red lowest. Any other pair of
/// sampler and texture gives its colours rounded to bytes.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_rgba8_slice(
    level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    u: &[f32],
    v: &[f32],
    grads: Option<&[Footprint]>,
    out: &mut [u32],
) -> Result<(), SampleError> {
    check("out", u.len(), out.len())?;
    in_parts(sampler, t, [u, v], grads, |first, batch| {
        batch.words(level, &mut out[first..first + batch.at.u.len()]);
    })
}

/// Calls `run` with the first index and the batch of each part.
fn in_parts(
    sampler: &Sampler,
    t: &Texture2d<'_>,
    [u, v]: [&[f32]; 2],
    grads: Option<&[Footprint]>,
    mut run: impl FnMut(usize, &Batch<'_>),
) -> Result<(), SampleError> {
    check("v", u.len(), v.len())?;
    if let Some(grads) = grads {
        check("grads", u.len(), grads.len())?;
    }
    let Some(view) = BoundTexture::new(sampler, t) else {
        return Ok(());
    };
    let mut columns = [[0.0; PART]; 4];
    for (i, (u, v)) in u.chunks(PART).zip(v.chunks(PART)).enumerate() {
        let first = i * PART;
        for (k, d) in grads
            .iter()
            .flat_map(|g| g[first..][..u.len()].iter().enumerate())
        {
            let parts = [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy];
            columns.iter_mut().zip(parts).for_each(|(c, d)| c[k] = d);
        }
        let gradients = grads.map(|_| columns.each_ref().map(|c| &c[..u.len()]));
        let at = Places { u, v, gradients };
        run(first, &Batch::new(sampler, &view, at));
    }
    Ok(())
}

/// Coordinates to sample, each component in a slice of its own: the values that a rasterizer's planes give.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// Coordinates.
    pub u: &'a [f32],
    /// Coordinates.
    pub v: &'a [f32],
    /// du/dx, dv/dx, du/dy, dv/dy; without them filters that choose a level take level 0.
    pub gradients: Option<[&'a [f32]; 4]>,
}

impl<'a> Places<'a> {
    /// Those of a range.
    pub(crate) fn part(&self, range: core::ops::Range<usize>) -> Self {
        Self {
            u: &self.u[range.clone()],
            v: &self.v[range.clone()],
            gradients: self.gradients.map(|all| all.map(|c| &c[range.clone()])),
        }
    }

    pub(crate) fn check(&self, out: usize) -> Result<(), SampleError> {
        check("v", self.u.len(), self.v.len())?;
        check("out", self.u.len(), out)?;
        for column in self.gradients.iter().flatten() {
            check("gradients", self.u.len(), column.len())?;
        }
        Ok(())
    }
}

/// [`sample_slice`] over columns: red, green, blue and alpha each go to a slice of their own.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_soa(
    level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    at: &Places<'_>,
    out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    match BoundTexture::new(sampler, t) {
        Some(view) => sample_bound_soa(level, (sampler, &view), at, out),
        None => Ok(()),
    }
}

/// [`sample_soa`] in a texture that was bound with this sampler.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_bound_soa(
    level: Level,
    (sampler, view): (&Sampler, &BoundTexture<'_>),
    at: &Places<'_>,
    out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    for column in &out {
        at.check(column.len())?;
    }
    Batch::new(sampler, view, *at).columns(level, out);
    Ok(())
}

/// [`sample_rgba8_slice`] over columns.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_rgba8_soa(
    level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    at: &Places<'_>,
    out: &mut [u32],
) -> Result<(), SampleError> {
    at.check(out.len())?;
    if let Some(view) = BoundTexture::new(sampler, t) {
        Batch::new(sampler, &view, *at).words(level, out);
    }
    Ok(())
}

/// True if [`sample_rgba8_soa`] gives the very colours of this sampler on this texture: 8-bit weights on 8-bit texels.
#[must_use]
pub fn is_exact_in_rgba8(sampler: &Sampler, t: &Texture2d<'_>) -> bool {
    rgba8::applies(sampler, &t.chain)
}

/// Look-ups that go through a buffer at a time.
pub(crate) const PART: usize = 256;

pub(crate) fn check(what: &'static str, expected: usize, got: usize) -> Result<(), SampleError> {
    if expected == got {
        Ok(())
    } else {
        Err(SampleError::Mismatch {
            what,
            expected,
            got,
        })
    }
}

/// Look-ups in one texture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Batch<'a> {
    sampler: &'a Sampler,
    view: &'a BoundTexture<'a>,
    at: Places<'a>,
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

    /// Colours as packed bytes.
    fn words(&self, level: Level, out: &mut [u32]) {
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

    fn cells<K: CellKernel>(self) {
        let Self { batch, level, out } = self;
        dispatch_simd!(level, i => cell_columns::<_, K>(i, batch, out));
    }

    fn bytes<K: ByteKernel>(self) {
        self.batch.columns(self.level, self.out);
    }
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

    fn cells<K: CellKernel>(self) {
        self.color::<K>();
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

/// See [`color_columns`].
#[inline(never)]
fn cell_columns<I: Isa, K: CellKernel>(i: I, batch: &Batch<'_>, out: [&mut [f32]; 4]) {
    if const { I::LANES == 1 } {
        return color_columns::<I, K>(i, batch, out);
    }
    batch.in_vectors::<I, _, 4>(out, |batch, mut out| {
        i.vectorize(
            #[inline(always)]
            || {
                let (view, count) = (batch.view, batch.at.u.len());
                let mut cells = [K::ZERO; RUN];
                let mut lod = batch.lod(i, 0, K::INPUT);
                for start in (0..count).step_by(RUN * I::LANES) {
                    let mut first = start;
                    for cells in &mut cells {
                        if first >= count {
                            break;
                        }
                        let next = vector_start::<I>(first + I::LANES, count);
                        let ahead = batch.lod(i, next, K::INPUT);
                        let at = batch.look_up(i, vector_start::<I>(first, count), K::INPUT);
                        K::find(i, view, &at, lod, cells);
                        (first, lod) = (first + I::LANES, ahead);
                    }
                    first = start;
                    for cells in &cells {
                        if first >= count {
                            break;
                        }
                        let from = vector_start::<I>(first, count);
                        let at = batch.look_up(i, from, K::INPUT);
                        store_columns(i, K::color_of(i, view, &at, cells), from, &mut out);
                        first += I::LANES;
                    }
                }
            },
        );
    });
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

/// The first look-up of a vector, `first` or what lies behind it: the last vector takes look-ups of the one before again rather than
/// be shorter. Stores of fewer values would be calls of a copy in the loop, before which a compiler sets all registers aside.
#[inline(always)]
pub(crate) fn vector_start<I: Isa>(first: usize, count: usize) -> usize {
    first.min(count - I::LANES)
}

/// Stores as many as there are lanes from `first` on.
#[inline(always)]
pub(crate) fn store_columns<I: Isa, const N: usize>(
    _: I,
    c: [I::F32; N],
    first: usize,
    out: &mut [&mut [f32]; N],
) {
    for (c, out) in c.iter().zip(out) {
        c.store(&mut out[first..][..I::LANES]);
    }
}

/// As many as there are lanes from `first` on.
#[inline(always)]
pub(crate) fn load<I: Isa>(i: I, values: &[f32], first: usize) -> I::F32 {
    i.load_f32(&values[first..][..I::LANES])
}

/// Runs `kernel` on columns of at least as many values as there are lanes: these, or if they are too short, copies in which the last
/// value stands several times. Columns of no values are left alone.
pub(crate) fn in_vectors<I: Isa, T: Copy + Default, const IN: usize, const OUT: usize>(
    columns: [&[f32]; IN],
    out: [&mut [T]; OUT],
    kernel: impl FnOnce([&[f32]; IN], [&mut [T]; OUT]),
) {
    let count = out[0].len();
    if count >= I::LANES {
        return kernel(columns, out);
    }
    if count == 0 {
        return;
    }
    let mut whole = [[0.0; 16]; IN];
    for (whole, values) in whole.iter_mut().zip(columns) {
        whole.fill(values[count - 1]);
        whole[..count].copy_from_slice(values);
    }
    let mut results = [[T::default(); 16]; OUT];
    let lanes = I::LANES;
    kernel(
        whole.each_ref().map(|c| &c[..lanes]),
        results.each_mut().map(|c| &mut c[..lanes]),
    );
    for (out, results) in out.into_iter().zip(results) {
        out.copy_from_slice(&results[..count]);
    }
}
