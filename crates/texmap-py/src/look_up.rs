//! Look-ups in textures, many at a time.

use std::sync::atomic::{AtomicBool, Ordering};

use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use texmap_math::{Footprint, Level};
use texmap_sample::{Filter, Lod, Sampler, Wrap, sample_slice};

use crate::support::{Threads, expect_length, interruptible, level, unlocked, value, word};
use crate::texture::Texture;

/// Look-ups that one task does.
const TASK: usize = 1 << 13;

/// Look-ups at flat coordinates (two each) with flat derivatives (du/dx, du/dy, dv/dx, dv/dy each) into `out`.
#[pyfunction]
#[pyo3(signature = (texture, uv, duv, out, filter, wrap, border, lod, threads, simd))]
pub(crate) fn sample(
    py: Python<'_>,
    texture: &Texture,
    uv: PyReadonlyArray1<'_, f32>,
    duv: Option<PyReadonlyArray1<'_, f32>>,
    mut out: PyReadwriteArray1<'_, f32>,
    filter: &str,
    wrap: (&str, &str),
    border: [f32; 4],
    lod: [f32; 3],
    threads: Option<Threads>,
    simd: Option<&str>,
) -> PyResult<()> {
    let sampler = Sampler {
        filter: word::<Filter>("filter", filter)?,
        wrap_u: word::<Wrap>("wrap", wrap.0)?,
        wrap_v: word::<Wrap>("wrap", wrap.1)?,
        border,
        lod: Lod {
            bias: lod[0],
            min: lod[1],
            max: lod[2],
        },
        ..Sampler::default()
    };
    let uv = uv.as_slice()?;
    let duv = duv.as_ref().map(|d| d.as_slice()).transpose()?;
    let footprints = move |range: std::ops::Range<usize>, into: &mut Vec<Footprint>| {
        if let Some(duv) = duv {
            let given = duv.as_chunks::<4>().0[range].iter();
            into.extend(given.map(|&[ux, uy, vx, vy]| Footprint::new(ux, vx, uy, vy)));
        }
    };
    if let Some(duv) = duv {
        expect_length("duv", duv.len(), uv.len() * 2)?;
    }
    let (out, level) = (out.as_slice_mut()?, level(simd)?);
    let has_footprints = duv.is_some();
    let texture = py.detach(|| texture.prepared_for(sampler.filter));
    interruptible_look_ups(py, texture, uv, out, threads, |first, uv, out| {
        look_up(
            &sampler,
            level,
            texture,
            uv,
            out,
            has_footprints,
            |range, into| {
                footprints(first + range.start..first + range.end, into);
            },
        )
    })
}

/// Look-ups of one task; `footprints` appends those of a range of the task.
pub(crate) fn look_up(
    sampler: &Sampler,
    level: Level,
    texture: &Texture,
    uv: &[f32],
    out: &mut [f32],
    has_footprints: bool,
    footprints: impl Fn(std::ops::Range<usize>, &mut Vec<Footprint>),
) -> PyResult<()> {
    const PART: usize = 1024;
    let (mut u, mut v) = ([0.0; PART], [0.0; PART]);
    let mut colors = [[0.0; 4]; PART];
    let mut grads = Vec::with_capacity(PART);
    let channels = texture.channels;
    let pairs = uv.as_chunks::<2>().0;
    for (part, (pairs, out)) in pairs
        .chunks(PART)
        .zip(out.chunks_mut(PART * channels))
        .enumerate()
    {
        let count = pairs.len();
        for ((&[a, b], u), v) in pairs.iter().zip(&mut u).zip(&mut v) {
            (*u, *v) = (a, b);
        }
        grads.clear();
        footprints(part * PART..part * PART + count, &mut grads);
        let grads = has_footprints.then_some(&grads[..]);
        let (u, v) = (&u[..count], &v[..count]);
        if channels == 4 {
            let (out, _) = out.as_chunks_mut::<4>();
            sample_slice(level, sampler, &texture.groups[0], u, v, grads, out).map_err(value)?;
            continue;
        }
        for (g, group) in texture.groups.iter().enumerate() {
            let colors = &mut colors[..count];
            sample_slice(level, sampler, group, u, v, grads, colors).map_err(value)?;
            let (first, last) = (4 * g, channels.min(4 * g + 4));
            for (texel, color) in out.chunks_exact_mut(channels).zip(colors) {
                texel[first..last].copy_from_slice(&texture.shown(*color)[..last - first]);
            }
        }
    }
    Ok(())
}

/// Runs `work` (first look-up, coordinates, output) over all look-ups, many at a time; long ones can be interrupted.
pub(crate) fn interruptible_look_ups(
    py: Python<'_>,
    texture: &Texture,
    uv: &[f32],
    out: &mut [f32],
    threads: Option<Threads>,
    work: impl Fn(usize, &[f32], &mut [f32]) -> PyResult<()> + Sync + Send,
) -> PyResult<()> {
    let channels = texture.channels;
    expect_length("out", out.len(), uv.len() / 2 * channels)?;
    let mut tasks = |stop: Option<&AtomicBool>| {
        if threads == Some(Threads::ONE) || uv.len() <= 2 * TASK {
            for (k, (uv, out)) in uv
                .chunks(2 * TASK)
                .zip(out.chunks_mut(TASK * channels))
                .enumerate()
            {
                if !stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                    work(k * TASK, uv, out)?;
                }
            }
            return Ok(());
        }
        uv.par_chunks(2 * TASK)
            .zip(out.par_chunks_mut(TASK * channels))
            .enumerate()
            .try_for_each(|(k, (uv, out))| match stop {
                Some(stop) if stop.load(Ordering::Relaxed) => Ok(()),
                _ => work(k * TASK, uv, out),
            })
    };
    // A second's work at most goes without a look for signals, which costs the start of a thread.
    if uv.len() > 1 << 24 {
        return interruptible(py, threads, |stop| tasks(Some(stop)))?;
    }
    if threads == Some(Threads::ONE) || uv.len() <= 2 * TASK {
        return py.detach(|| tasks(None));
    }
    unlocked(py, threads, || tasks(None))?
}
