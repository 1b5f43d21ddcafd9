//! Columns of any length in whole vectors.

use texmap_math::simd::{Isa, prelude::*};

/// The start of the vector at `first`: the last one of a batch starts earlier and takes look-ups of the one before again rather than be
/// shorter. Stores of fewer values would be calls of a copy in the loop, before which a compiler sets all registers aside.
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
