//! Batches of look-ups: checked once, dispatched once.

use crate::{
    bound_texture::BoundTexture, error::SampleError, rgba8, sampler::Sampler, texture::Texture2d,
};
use texmap_math::{Level, footprint::Footprint};

mod joint;
mod run;

pub use joint::JointTextures;
pub(crate) use run::Batch;

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
