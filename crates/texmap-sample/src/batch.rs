//! Batches: check once, dispatch once, sixteen at a time.

use crate::{
    error::SampleError,
    filter::{self, cubic, ewa, gl_of},
    lanes::{
        APART, Kind, RGBA8, RGBA8_EXACT, RGBA16, View, float, gl,
        packed::{self, FootprintLanes},
    },
    sampler::Sampler,
    texture::Texture2d,
};
use texmap_math::{
    Level, color,
    fearless_simd::{f32x4, f32x16, i32x16, prelude::*},
    footprint::Footprint,
    lanes::{load_tail, store_tail},
};

/// Samples many places at once; dispatches to the SIMD level once. Results equal
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
    check("v", u.len(), v.len())?;
    check("out", u.len(), out.len())?;
    if let Some(grads) = grads {
        check("grads", u.len(), grads.len())?;
    }
    let lanes = View::new(sampler, t).is_some_and(|view| {
        Batch {
            sampler,
            view: &view,
            u,
            v,
            grads: grads.map_or(Grads::None, Grads::Each),
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
    let lanes = View::new(sampler, t).is_some_and(|view| {
        Batch {
            sampler,
            view: &view,
            u,
            v,
            grads: grads.map_or(Grads::None, Grads::Each),
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

/// Places to sample, each value in a slice of its own: what a rasterizer's planes give.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// Coordinates.
    pub u: &'a [f32],
    /// Coordinates.
    pub v: &'a [f32],
    /// du/dx, dv/dx, du/dy, dv/dy; without them filters that choose a level take level 0.
    pub gradients: Option<[&'a [f32]; 4]>,
}

impl Places<'_> {
    fn check(&self, out: usize) -> Result<(), SampleError> {
        check("v", self.u.len(), self.v.len())?;
        check("out", self.u.len(), out)?;
        for column in self.gradients.iter().flatten() {
            check("gradients", self.u.len(), column.len())?;
        }
        Ok(())
    }

    fn sample(&self, sampler: &Sampler, t: &Texture2d<'_>, i: usize) -> [f32; 4] {
        let uv = [self.u[i], self.v[i]];
        match self.gradients {
            Some([ux, vx, uy, vy]) => {
                let d = Footprint {
                    du_dx: ux[i],
                    dv_dx: vx[i],
                    du_dy: uy[i],
                    dv_dy: vy[i],
                };
                sampler.sample_grad(t, uv, d)
            }
            None => sampler.sample(t, uv),
        }
    }

    fn batch<'b>(&'b self, sampler: &'b Sampler, view: &'b View<'b>) -> Batch<'b> {
        Batch {
            sampler,
            view,
            u: self.u,
            v: self.v,
            grads: self.gradients.map_or(Grads::None, Grads::Columns),
        }
    }
}

/// [`sample_slice`] over columns: red, green, blue and alpha each go to a slice of their own.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_columns(
    level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    at: &Places<'_>,
    mut out: [&mut [f32]; 4],
) -> Result<(), SampleError> {
    for column in &out {
        at.check(column.len())?;
    }
    let lanes = View::new(sampler, t).is_some_and(|view| {
        let out = out.each_mut().map(|c| &mut **c);
        at.batch(sampler, &view).run(level, Out::Columns(out))
    });
    if !lanes {
        for i in 0..at.u.len() {
            for (out, c) in out.iter_mut().zip(at.sample(sampler, t, i)) {
                out[i] = c;
            }
        }
    }
    Ok(())
}

/// [`sample_rgba8_slice`] over columns.
///
/// # Errors
/// Slices of different lengths.
pub fn sample_rgba8_columns(
    level: Level,
    sampler: &Sampler,
    t: &Texture2d<'_>,
    at: &Places<'_>,
    out: &mut [u32],
) -> Result<(), SampleError> {
    at.check(out.len())?;
    let lanes = View::new(sampler, t)
        .is_some_and(|view| at.batch(sampler, &view).run(level, Out::Rgba8(out)));
    if !lanes {
        for (i, out) in out.iter_mut().enumerate() {
            *out = u32::from_le_bytes(at.sample(sampler, t, i).map(color::unit_to_u8));
        }
    }
    Ok(())
}

/// Whether [`sample_rgba8_columns`] gives the very colours of this sampler on this texture: 8-bit weights on 8-bit texels.
#[must_use]
pub fn gives_bytes(sampler: &Sampler, t: &Texture2d<'_>) -> bool {
    packed::applies(sampler, &t.chain)
}

/// Places that go through a buffer at a time.
const PART: usize = 256;

/// Where a batch goes.
pub(crate) enum Out<'a> {
    Float(&'a mut [[f32; 4]]),
    Columns([&'a mut [f32]; 4]),
    Rgba8(&'a mut [u32]),
}

/// Derivatives of a batch.
#[derive(Clone, Copy)]
pub(crate) enum Grads<'a> {
    None,
    Each(&'a [Footprint]),
    Columns([&'a [f32]; 4]),
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

/// Runs `$run` with the vector unit of a level as `$s`; false where there is none (or no optimisation), and the scalar twin
/// stands in with the same bits.
/// SSE4.2 runs the SSE2 build, which is as fast (see `benches/results/sample_speed.md`).
macro_rules! on_lanes {
    ($level:expr, $s:ident => $run:expr) => {
        'lanes: {
            if !texmap_math::LANES {
                break 'lanes false;
            }
            match $level {
                #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
                Level::Avx512($s) => $run,
                #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
                Level::Avx2($s) => $run,
                #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
                level @ (Level::Sse4_2(_) | Level::Sse2(_)) => match level.as_sse2() {
                    Some($s) => $run,
                    None => break 'lanes false,
                },
                #[cfg(target_arch = "aarch64")]
                Level::Neon($s) => $run,
                #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
                Level::WasmSimd128($s) => $run,
                _ => break 'lanes false,
            }
            true
        }
    };
}
pub(crate) use on_lanes;

#[derive(Clone, Copy)]
pub(crate) struct Batch<'a> {
    pub(crate) sampler: &'a Sampler,
    pub(crate) view: &'a View<'a>,
    pub(crate) u: &'a [f32],
    pub(crate) v: &'a [f32],
    pub(crate) grads: Grads<'a>,
}

impl Batch<'_> {
    /// False where there is no vector unit.
    pub(crate) fn run(&self, level: Level, out: Out<'_>) -> bool {
        on_lanes!(level, s => self.on(s, out))
    }

    fn on<S: Simd>(&self, s: S, out: Out<'_>) {
        let packed = self.view.format == RGBA8;
        match out {
            Out::Rgba8(out) if packed => self.packed_of::<S>(s, out),
            Out::Rgba8(out) => {
                self.colors_of(s, out, |c| u32::from_le_bytes(c.map(color::unit_to_u8)));
            }
            Out::Float(out) if packed => {
                let mut words = [0; PART];
                for (i, out) in out.chunks_mut(PART).enumerate() {
                    self.part(i * PART, out.len())
                        .packed_of::<S>(s, &mut words[..out.len()]);
                    for (out, word) in out.iter_mut().zip(words) {
                        *out = packed::unpack(word);
                    }
                }
            }
            Out::Float(out) => self.colors_of(s, out, |c| c),
            Out::Columns(mut out) if packed => {
                let mut words = [0; PART];
                for start in (0..self.u.len()).step_by(PART) {
                    let count = PART.min(self.u.len() - start);
                    self.part(start, count)
                        .packed_of::<S>(s, &mut words[..count]);
                    packed::unpack_columns(
                        s,
                        &words[..count],
                        out.each_mut().map(|c| &mut c[start..start + count]),
                    );
                }
            }
            Out::Columns(out) => self.float_of(s, out),
        }
    }

    /// The colours of kernels with f32 weights, one `put` after the other.
    fn colors_of<S: Simd, T>(&self, s: S, out: &mut [T], put: impl Fn([f32; 4]) -> T) {
        let mut columns = [[0.0; PART]; 4];
        for (i, out) in out.chunks_mut(PART).enumerate() {
            let part = self.part(i * PART, out.len());
            part.float_of(s, columns.each_mut().map(|c| &mut c[..out.len()]));
            let [r, g, b, a] = &columns;
            for (i, out) in out.iter_mut().enumerate() {
                *out = put([r[i], g[i], b[i], a[i]]);
            }
        }
    }

    /// `count` places from `start` on.
    fn part(&self, start: usize, count: usize) -> Self {
        let range = start..start + count;
        Self {
            u: &self.u[range.clone()],
            v: &self.v[range.clone()],
            grads: match self.grads {
                Grads::None => Grads::None,
                Grads::Each(each) => Grads::Each(&each[range]),
                Grads::Columns(columns) => Grads::Columns(columns.map(|c| &c[range.clone()])),
            },
            ..*self
        }
    }

    fn float_of<S: Simd>(&self, s: S, out: [&mut [f32]; 4]) {
        let rare = !self.view.kind.is_plain() && self.view.kind != Kind::Anisotropic;
        match self.view.format {
            RGBA8_EXACT if !rare => self.float_format::<S, RGBA8_EXACT>(s, out),
            RGBA16 if !rare => self.float_format::<S, RGBA16>(s, out),
            _ => self.any_format(s, out),
        }
    }

    #[inline(always)]
    fn uv<S: Simd>(&self, s: S, i: usize) -> (f32x16<S>, f32x16<S>) {
        (load_tail(s, &self.u[i..]), load_tail(s, &self.v[i..]))
    }

    #[inline(always)]
    fn footprint<S: Simd>(&self, s: S, i: usize) -> Option<FootprintLanes<S>> {
        let [ux, vx, uy, vy] = match self.grads {
            Grads::None => return None,
            Grads::Columns([a, b, c, d]) => [
                load_tail(s, &a[i..]),
                load_tail(s, &b[i..]),
                load_tail(s, &c[i..]),
                load_tail(s, &d[i..]),
            ],
            Grads::Each(each) => sixteen_footprints(s, &each[i..]),
        };
        Some(FootprintLanes::new(s, self.view, ux, vx, uy, vy))
    }

    /// The limited level of look-ups without gradients.
    fn flat_lod(&self) -> f32 {
        self.sampler.limit_lod(0.0)
    }

    fn float_format<S: Simd, const FORMAT: u8>(&self, s: S, mut out: [&mut [f32]; 4]) {
        s.vectorize(
            #[inline(always)]
            || {
                let view = self.view;
                let flat = f32x16::splat(s, self.flat_lod());
                for i in 0..self.u.len().div_ceil(16) {
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
                    store_columns(c, i, &mut out);
                }
            },
        );
    }

    /// Filters and texels that are rare: in one form for all texels, which takes half as long to compile.
    fn any_format<S: Simd>(&self, s: S, mut out: [&mut [f32]; 4]) {
        s.vectorize(
            #[inline(always)]
            || {
                let view = self.view;
                let flat = f32x16::splat(s, self.flat_lod());
                for i in 0..self.u.len().div_ceil(16) {
                    let (u, v) = self.uv(s, 16 * i);
                    let d = self.footprint(s, 16 * i);
                    let c = match (view.kind, d) {
                        (Kind::Bicubic(kernel), _) => cubic::lanes(s, view, kernel, u, v),
                        (Kind::Anisotropic, Some(d)) => {
                            float::anisotropic_lanes::<S, APART>(s, view, u, v, &d)
                        }
                        (Kind::Ewa, Some(d)) => ewa::lanes(s, view, [u, v], &d),
                        (_, d) => {
                            let lod = match d {
                                Some(d) => float::lod_lanes(s, view, &d),
                                None => flat,
                            };
                            gl::float_lanes(s, view, gl_of(self.sampler.filter), [u, v], lod)
                        }
                    };
                    store_columns(c, i, &mut out);
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
                        (kind, d) => {
                            let lod = match d {
                                Some(d) => packed::lod_lanes(s, view, &d),
                                None => flat,
                            };
                            if kind == Kind::Gl {
                                gl::byte_lanes(s, view, gl_of(self.sampler.filter), [u, v], lod)
                            } else {
                                packed::trilinear_lanes::<S>(s, view, u, v, lod)
                            }
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

/// Puts the `i`th sixteen down, or as many as there are.
#[inline(always)]
fn store_columns<S: Simd>(c: float::Color<S>, i: usize, out: &mut [&mut [f32]; 4]) {
    for (k, out) in out.iter_mut().enumerate() {
        let end = out.len().min(16 * i + 16);
        store_tail(c[k], &mut out[16 * i..end]);
    }
}

/// Components of sixteen footprints, or of those there are.
#[inline(always)]
fn sixteen_footprints<S: Simd>(s: S, grads: &[Footprint]) -> [f32x16<S>; 4] {
    let mut tail = [Footprint::default(); 16];
    let grads = match grads.first_chunk::<16>() {
        Some(grads) => grads,
        None => {
            tail[..grads.len()].copy_from_slice(grads);
            &tail
        }
    };
    let parts = [
        four_footprints(s, grads, 0),
        four_footprints(s, grads, 4),
        four_footprints(s, grads, 8),
        four_footprints(s, grads, 12),
    ];
    [
        joined(s, &parts, 0),
        joined(s, &parts, 1),
        joined(s, &parts, 2),
        joined(s, &parts, 3),
    ]
}

/// Components of four footprints from the `i`th on.
#[inline(always)]
fn four_footprints<S: Simd>(s: S, grads: &[Footprint; 16], i: usize) -> [f32x4<S>; 4] {
    let mut flat = [0.0; 16];
    for (flat, d) in flat.as_chunks_mut::<4>().0.iter_mut().zip(&grads[i..]) {
        *flat = [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy];
    }
    s.load_four_interleaved_f32x4(&flat)
}

/// Component `k` of four times four.
#[inline(always)]
fn joined<S: Simd>(s: S, parts: &[[f32x4<S>; 4]; 4], k: usize) -> f32x16<S> {
    let [a, b, c, d] = parts;
    s.combine_f32x8(s.combine_f32x4(a[k], b[k]), s.combine_f32x4(c[k], d[k]))
}
