//! Batches of look-ups: checked once, dispatched once.

use crate::{
    address::lod::TexelFootprint,
    bound_texture::{BoundTexture, RGBA8},
    error::SampleError,
    filter::{ByteKernel, FilterKernel, LookUp, Run, Single, run},
    rgba8,
    sampler::Sampler,
    texture::Texture2d,
};
use texmap_math::{
    Level, color, dispatch_simd,
    footprint::Footprint,
    simd::{ByteIsa, Isa, prelude::*},
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

    /// As many as there are lanes, from `first` on.
    #[expect(
        clippy::manual_map,
        reason = "the closure of `map` is not always inlined, and would be compiled without vector instructions"
    )]
    #[inline(always)]
    fn look_up<I: Isa>(&self, i: I, first: usize) -> LookUp<I> {
        LookUp {
            uv: [
                load_tail(i, &self.at.u[first..]),
                load_tail(i, &self.at.v[first..]),
            ],
            footprint: match self.at.gradients {
                Some([ux, vx, uy, vy]) => Some(TexelFootprint::new(
                    i,
                    self.view,
                    load_tail(i, &ux[first..]),
                    load_tail(i, &vx[first..]),
                    load_tail(i, &uy[first..]),
                    load_tail(i, &vy[first..]),
                )),
                None => None,
            },
            flat: self.flat,
        }
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
    i.vectorize(
        #[inline(always)]
        || {
            for first in (0..batch.at.u.len()).step_by(I::LANES) {
                let at = batch.look_up(i, first);
                store_columns(i, K::color(i, batch.view, &at), first, &mut out);
            }
        },
    );
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
    i.vectorize(
        #[inline(always)]
        || {
            for (k, out) in out.chunks_mut(I::LANES).enumerate() {
                let at = batch.look_up(i, k * I::LANES);
                let c = K::word(i, batch.view, &at);
                if out.len() == I::LANES {
                    c.store(out);
                } else {
                    let mut words = [0; 16];
                    c.store(&mut words);
                    out.copy_from_slice(&words[..out.len()]);
                }
            }
        },
    );
}

#[inline(always)]
fn unpack_columns<I: Isa>(i: I, words: &[u32], mut out: [&mut [f32]; 4]) {
    let mut last = [0; 16];
    for (k, words) in words.chunks(I::LANES).enumerate() {
        last[..words.len()].copy_from_slice(words);
        let c = rgba8::unpack(i, i.load_u32(&last));
        store_columns(i, c, k * I::LANES, &mut out);
    }
}

/// Stores as many as there are lanes from `first` on, or as many as there are.
#[inline(always)]
pub(crate) fn store_columns<I: Isa, const N: usize>(
    _: I,
    c: [I::F32; N],
    first: usize,
    out: &mut [&mut [f32]; N],
) {
    for (c, out) in c.iter().zip(out) {
        let out = &mut out[first..];
        if out.len() >= I::LANES {
            c.store(out);
        } else {
            let mut lanes = [0.0; 16];
            c.store(&mut lanes);
            out.copy_from_slice(&lanes[..out.len()]);
        }
    }
}

/// The first values, or what there is of them, the rest filled with the last.
#[inline(always)]
pub(crate) fn load_tail<I: Isa>(i: I, values: &[f32]) -> I::F32 {
    if values.len() >= I::LANES {
        return i.load_f32(values);
    }
    let mut lanes = [values.last().copied().unwrap_or(0.0); 16];
    lanes[..values.len()].copy_from_slice(values);
    i.load_f32(&lanes)
}
