//! Batches: check once, dispatch once, sixteen at a time.

use crate::{
    error::SampleError,
    filter,
    lanes::{
        Kind, RGBA16, RGBX8, View, float,
        packed::{self, FootprintLanes},
    },
    sampler::Sampler,
    texture::Texture2d,
};
use texmap_math::{
    Level, color,
    fearless_simd::{f32x16, i32x16, prelude::*},
    footprint::Footprint,
    lanes::load_tail,
};

/// Samples many places at once; dispatches to the SIMD level once. Results equal
/// [`Sampler::sample_grad`] (or [`Sampler::sample`] without gradients) bit for bit.
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
    check("v", u.len(), v.len())?;
    check("out", u.len(), out.len())?;
    if let Some(grads) = grads {
        check("grads", u.len(), grads.len())?;
    }
    let lanes = View::new(sampler, t).is_some_and(|view| {
        Batch {
            sampler,
            view: &view,
            packed: packed::applies(sampler, &t.chain),
            u,
            v,
            grads,
        }
        .run(level, Out::Float(out))
    });
    if lanes {
        return Ok(());
    }
    for (i, out) in out.iter_mut().enumerate() {
        let uv = [u[i], v[i]];
        *out = match grads {
            Some(grads) => filter::sample_grad(sampler, &t.chain, uv, grads[i]),
            None => sampler.sample(t, uv),
        };
    }
    Ok(())
}

/// As [`sample_slice`] for [`Precision::Fast`](crate::Precision::Fast) on 8-bit textures (linear,
/// opaque or cut out), whose results are bytes: packed RGBA, red lowest. Any other pair of sampler
/// and texture gives its colours rounded to bytes.
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
    check("v", u.len(), v.len())?;
    check("out", u.len(), out.len())?;
    if let Some(grads) = grads {
        check("grads", u.len(), grads.len())?;
    }
    let packed = packed::applies(sampler, &t.chain);
    let lanes = packed
        && View::new(sampler, t).is_some_and(|view| {
            Batch {
                sampler,
                view: &view,
                packed,
                u,
                v,
                grads,
            }
            .run(level, Out::Rgba8(out))
        });
    if !lanes {
        for (i, out) in out.iter_mut().enumerate() {
            let uv = [u[i], v[i]];
            let c = match grads {
                Some(grads) => sampler.sample_grad(t, uv, grads[i]),
                None => sampler.sample(t, uv),
            };
            *out = u32::from_le_bytes(c.map(color::unit_to_u8));
        }
    }
    Ok(())
}

/// Where a batch goes.
enum Out<'a> {
    Float(&'a mut [[f32; 4]]),
    Rgba8(&'a mut [u32]),
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

#[derive(Clone, Copy)]
struct Batch<'a> {
    sampler: &'a Sampler,
    view: &'a View<'a>,
    packed: bool,
    u: &'a [f32],
    v: &'a [f32],
    grads: Option<&'a [Footprint]>,
}

impl Batch<'_> {
    /// False where the vector unit has no gather worth the name (SSE) or is missing: there the scalar
    /// twin stands in, with the same bits. (Sixteen lanes in four registers, or none, would also more
    /// than double the time to compile this crate.)
    fn run(&self, level: Level, out: Out<'_>) -> bool {
        match level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(s) => self.on(s, out),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(s) => self.on(s, out),
            #[cfg(target_arch = "aarch64")]
            Level::Neon(s) => self.on(s, out),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Level::WasmSimd128(s) => self.on(s, out),
            _ => return false,
        }
        true
    }

    fn on<S: Simd>(&self, s: S, out: Out<'_>) {
        match (out, self.packed, self.view.format) {
            (Out::Rgba8(out), ..) => self.packed_of::<S>(s, out),
            (Out::Float(out), true, _) => {
                // Through bytes, 256 at a time.
                let mut words = [0; 256];
                for (i, out) in out.chunks_mut(256).enumerate() {
                    let from = 256 * i;
                    let to = from + out.len();
                    let part = Self {
                        u: &self.u[from..to],
                        v: &self.v[from..to],
                        grads: self.grads.map(|g| &g[from..to]),
                        ..*self
                    };
                    part.packed_of::<S>(s, &mut words[..out.len()]);
                    for (out, word) in out.iter_mut().zip(words) {
                        *out = packed::unpack(word);
                    }
                }
            }
            (Out::Float(out), false, RGBX8) => self.float_of::<S, RGBX8>(s, out),
            (Out::Float(out), ..) => self.float_of::<S, RGBA16>(s, out),
        }
    }

    #[inline(always)]
    fn uv<S: Simd>(&self, s: S, i: usize) -> (f32x16<S>, f32x16<S>) {
        (load_tail(s, &self.u[i..]), load_tail(s, &self.v[i..]))
    }

    #[inline(always)]
    fn footprint<S: Simd>(&self, s: S, i: usize) -> Option<FootprintLanes<S>> {
        let grads = &self.grads?[i..];
        let mut columns = [[0.0; 16]; 4];
        for (k, d) in grads.iter().take(16).enumerate() {
            columns[0][k] = d.du_dx;
            columns[1][k] = d.dv_dx;
            columns[2][k] = d.du_dy;
            columns[3][k] = d.dv_dy;
        }
        let [ux, vx, uy, vy] = columns;
        Some(FootprintLanes::new(
            s,
            self.view,
            f32x16::from_slice(s, &ux),
            f32x16::from_slice(s, &vx),
            f32x16::from_slice(s, &uy),
            f32x16::from_slice(s, &vy),
        ))
    }

    /// The limited level of look-ups without gradients.
    fn flat_lod(&self) -> f32 {
        self.sampler.limit_lod(0.0)
    }

    fn float_of<S: Simd, const FORMAT: u8>(&self, s: S, out: &mut [[f32; 4]]) {
        s.vectorize(
            #[inline(always)]
            || {
                let view = self.view;
                let flat = f32x16::splat(s, self.flat_lod());
                for (i, out) in out.chunks_mut(16).enumerate() {
                    let (u, v) = self.uv(s, 16 * i);
                    let d = self.footprint(s, 16 * i);
                    let c = match (view.kind, d) {
                        (Kind::Nearest, _) => float::nearest_lanes::<S, FORMAT>(s, view, u, v),
                        (Kind::Bilinear, _) => float::bilinear_lanes::<S, FORMAT>(s, view, u, v),
                        (Kind::Anisotropic, Some(d)) => {
                            float::anisotropic_lanes::<S, FORMAT>(s, view, u, v, &d)
                        }
                        (_, d) => {
                            let lod = match d {
                                Some(d) => float::lod_lanes(s, view, &d),
                                None => flat,
                            };
                            float::trilinear_lanes::<S, FORMAT>(s, view, u, v, lod)
                        }
                    };
                    store(c, out);
                }
            },
        );
    }

    fn packed_of<S: Simd>(&self, s: S, out: &mut [u32]) {
        s.vectorize(
            #[inline(always)]
            || {
                let view = self.view;
                let flat = i32x16::splat(s, packed::fixed_lod(self.flat_lod()));
                for (i, out) in out.chunks_mut(16).enumerate() {
                    let (u, v) = self.uv(s, 16 * i);
                    let d = self.footprint(s, 16 * i);
                    let c = match (view.kind, d) {
                        (Kind::Nearest, _) => packed::nearest_lanes::<S>(s, view, u, v),
                        (Kind::Bilinear, _) => packed::bilinear_lanes::<S>(s, view, u, v),
                        (Kind::Anisotropic, Some(d)) => {
                            packed::anisotropic_lanes::<S>(s, view, u, v, &d)
                        }
                        (_, d) => {
                            let lod = match d {
                                Some(d) => packed::lod_lanes(s, view, &d),
                                None => flat,
                            };
                            packed::trilinear_lanes::<S>(s, view, u, v, lod)
                        }
                    };
                    if let Some(full) = out.first_chunk_mut::<16>() {
                        c.store_slice(full);
                    } else {
                        let mut words = [0; 16];
                        c.store_slice(&mut words);
                        out.copy_from_slice(&words[..out.len()]);
                    }
                }
            },
        );
    }
}

#[inline(always)]
fn store<S: Simd>(c: float::Color<S>, out: &mut [[f32; 4]]) {
    let mut lanes = [[0.0; 16]; 4];
    for (c, lanes) in c.into_iter().zip(&mut lanes) {
        c.store_slice(lanes);
    }
    let [r, g, b, a] = lanes;
    for (i, out) in out.iter_mut().take(16).enumerate() {
        *out = [r[i], g[i], b[i], a[i]];
    }
}
