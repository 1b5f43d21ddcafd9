//! Work over fixed chunks, in order; with the feature `rayon` on all cores. The chunk size never depends on
//! the number of threads, so sums have one order and results one set of bytes.

use alloc::vec::Vec;
use core::ops::Range;

/// Items per chunk.
const CHUNK: usize = 4096;

fn chunks(count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count.div_ceil(CHUNK)).map(move |k| k * CHUNK..((k + 1) * CHUNK).min(count))
}

/// The results of `work` on each chunk of `0..count`, in order.
pub(crate) fn map_chunks<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> T + Sync + Send,
) -> Vec<T> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        chunks(count)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(work)
            .collect()
    }
    #[cfg(not(feature = "rayon"))]
    chunks(count).map(work).collect()
}

/// As [`map_chunks`], the chunks' lists joined.
pub(crate) fn collect_chunks<T: Send + Clone>(
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync + Send,
) -> Vec<T> {
    map_chunks(count, work).concat()
}
