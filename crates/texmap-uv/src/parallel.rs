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
pub(crate) fn collect_chunks<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync + Send,
) -> Vec<T> {
    concat(map_chunks(count, work).into_iter())
}

/// Lists one after another; each is freed as soon as it is taken over.
pub(crate) fn concat<T>(lists: impl Iterator<Item = Vec<T>>) -> Vec<T> {
    let lists: Vec<Vec<T>> = lists.collect();
    let mut out = Vec::with_capacity(lists.iter().map(Vec::len).sum());
    lists.into_iter().for_each(|mut list| out.append(&mut list));
    out
}

/// Two pieces of work, side by side if there are threads.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    {
        rayon::join(a, b)
    }
    #[cfg(not(feature = "rayon"))]
    (a(), b())
}
