//! Work over fixed chunks, in order; with the feature `rayon` on all cores. The chunk size never depends on
//! the number of threads, so sums have one order and results one set of bytes.

use alloc::vec::Vec;
use core::ops::Range;

use texmap_math::parallel;
pub(crate) use texmap_math::parallel::join;

/// Items per chunk.
const CHUNK: usize = 4096;

/// The results of `work` on each chunk of `0..count`, in order.
pub(crate) fn map_chunks<T: Send>(count: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let chunk = |k: usize| k * CHUNK..((k + 1) * CHUNK).min(count);
    parallel::map((0..count.div_ceil(CHUNK)).map(chunk), work)
}

/// As [`map_chunks`], the chunks' lists joined.
pub(crate) fn collect_chunks<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
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
