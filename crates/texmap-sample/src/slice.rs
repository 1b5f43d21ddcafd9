use crate::{error::SampleError, sampler::Sampler, texture::Texture2d};
use texmap_math::{Level, footprint::Footprint};

/// Samples many places at once; dispatches to the SIMD level once. Results equal
/// [`Sampler::sample_grad`] (or [`Sampler::sample`] without gradients) bit for bit.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_slice(
    _level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    u: &[f32],
    v: &[f32],
    grads: Option<&[Footprint]>,
    out: &mut [[f32; 4]],
) -> Result<(), SampleError> {
    check("v", u.len(), v.len())?;
    check("out", u.len(), out.len())?;
    if let Some(grads) = grads {
        check("grads", u.len(), grads.len())?;
    }
    for (i, out) in out.iter_mut().enumerate() {
        let uv = [u[i], v[i]];
        *out = match grads {
            Some(grads) => sampler.sample_grad(t, uv, grads[i]),
            None => sampler.sample(t, uv),
        };
    }
    Ok(())
}

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
