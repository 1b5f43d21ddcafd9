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
#[inline(always)]
pub(crate) fn in_vectors<I: Isa, T: Copy + Default, const IN: usize, const OUT: usize>(
    columns: [&[f32]; IN],
    mut out: [&mut [T]; OUT],
    kernel: impl FnOnce([&[f32]; IN], [&mut [T]; OUT]),
) {
    let count = out[0].len();
    if count == 0 {
        return;
    }
    let short = count < I::LANES;
    let mut whole = [[0.0; 16]; IN];
    let mut results = [[T::default(); 16]; OUT];
    // One call, so that the kernel's code stands once.
    let (given, to) = if short {
        repeat_last(columns, &mut whole);
        (
            whole.each_ref().map(|c| &c[..I::LANES]),
            results.each_mut().map(|c| &mut c[..I::LANES]),
        )
    } else {
        (columns, out.each_mut().map(|c| &mut **c))
    };
    kernel(given, to);
    if short {
        for (out, results) in out.into_iter().zip(results) {
            out.copy_from_slice(&results[..count]);
        }
    }
}

/// Copies of short columns, filled up with their last values.
#[inline(never)]
fn repeat_last<const IN: usize>(columns: [&[f32]; IN], whole: &mut [[f32; 16]; IN]) {
    for (whole, values) in whole.iter_mut().zip(columns) {
        if let Some(last) = values.last() {
            whole.fill(*last);
            whole[..values.len()].copy_from_slice(values);
        }
    }
}
