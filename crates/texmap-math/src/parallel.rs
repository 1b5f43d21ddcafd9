//! Work on all threads of the current rayon pool (feature `rayon`; on the thread that asks without it), the same results on any number.
//!
//! Iterators of rayon are compiled again, some 25 KB, for each closure that they get. Here only thin wrappers are: the pool sees one
//! function, and a piece of work is large enough that a call by pointer costs nothing.

use alloc::vec::Vec;

/// Elements that a thread takes at once.
pub const PIECE: usize = 1 << 12;

/// Calls `work` with each item. They are begun in order, each by the next thread that is free.
pub fn for_each<I: ExactSizeIterator + Send>(items: I, work: impl Fn(I::Item) + Sync) {
    #[cfg(feature = "rayon")]
    {
        use std::sync::{Mutex, PoisonError};

        let count = items.len();
        let items = Mutex::new(items);
        run(count, &|| {
            let next = items.lock().unwrap_or_else(PoisonError::into_inner).next();
            next.into_iter().for_each(&work);
        });
    }
    #[cfg(not(feature = "rayon"))]
    items.for_each(work);
}

/// The results of `work` for each item, in their order.
pub fn map<I: ExactSizeIterator + Send, R: Send>(
    items: I,
    work: impl Fn(I::Item) -> R + Sync,
) -> Vec<R> {
    let mut results = Vec::new();
    results.resize_with(items.len(), || None);
    for_each(items.zip(&mut results), |(item, result)| {
        *result = Some(work(item));
    });
    results.into_iter().flatten().collect()
}

/// Calls `work` with each item until one fails: the failure of the first item that does.
///
/// # Errors
/// Those of `work`.
pub fn try_for_each<I: ExactSizeIterator + Send, E: Send>(
    items: I,
    work: impl Fn(I::Item) -> Result<(), E> + Sync,
) -> Result<(), E> {
    #[cfg(feature = "rayon")]
    {
        use core::sync::atomic::{AtomicUsize, Ordering};

        // Those before an item that fails are done all the same: one of them may fail too.
        let failed = AtomicUsize::new(usize::MAX);
        let done = map(items.enumerate(), |(number, item)| {
            if number > failed.load(Ordering::Relaxed) {
                return Ok(());
            }
            work(item).inspect_err(|_| {
                failed.fetch_min(number, Ordering::Relaxed);
            })
        });
        done.into_iter().collect()
    }
    #[cfg(not(feature = "rayon"))]
    {
        let mut items = items;
        items.try_for_each(work)
    }
}

/// The list of `value(i)` for each `i` below `count`; `empty` is what it holds before.
pub fn list<T: Copy + Send>(count: usize, empty: T, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut all = alloc::vec![empty; count];
    for_each(all.chunks_mut(PIECE).enumerate(), |(number, piece)| {
        for (place, i) in piece.iter_mut().zip(number * PIECE..) {
            *place = value(i);
        }
    });
    all
}

/// The first number below `count` that passes a test.
pub fn first(count: usize, test: impl Fn(usize) -> bool + Sync) -> Option<usize> {
    #[cfg(feature = "rayon")]
    {
        use core::sync::atomic::{AtomicUsize, Ordering};

        let first = AtomicUsize::new(count);
        for_each(0..count.div_ceil(PIECE), |number| {
            let start = number * PIECE;
            let end = (start + PIECE).min(first.load(Ordering::Relaxed));
            if let Some(found) = (start..end).find(|i| test(*i)) {
                first.fetch_min(found, Ordering::Relaxed);
            }
        });
        Some(first.into_inner()).filter(|first| *first < count)
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).find(|i| test(*i))
}

/// The results of two pieces of work, done side by side if there are threads.
pub fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    {
        let (mut works, mut results) = ((Some(a), Some(b)), (None, None));
        both(
            &mut || results.0 = works.0.take().map(|work| work()),
            &mut || results.1 = works.1.take().map(|work| work()),
        );
        match results {
            (Some(a), Some(b)) => (a, b),
            _ => unreachable!("both were done"),
        }
    }
    #[cfg(not(feature = "rayon"))]
    (a(), b())
}

/// The result of `work`, done by a thread of the pool: each of its loops would wake and await the pool if it came from outside.
pub fn within<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    join(work, || ()).0
}

/// Number of threads that share the work.
pub fn threads() -> usize {
    #[cfg(feature = "rayon")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "rayon"))]
    1
}

/// Calls `work` so many times.
#[cfg(feature = "rayon")]
fn run(count: usize, work: &(dyn Fn() + Sync)) {
    match count {
        0 => {}
        1 => work(),
        _ => {
            let half = count / 2;
            rayon::join(|| run(count - half, work), || run(half, work));
        }
    }
}

#[cfg(feature = "rayon")]
fn both(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_order() {
        for count in [0, 1, 2, 77] {
            let names = (0..count).map(|i| i.to_string());
            let plain: Vec<_> = names.clone().map(|name| name + "!").collect();
            assert_eq!(map(names, |name| name + "!"), plain);
        }
        for count in [0, 1, PIECE, 3 * PIECE + 5] {
            let plain: Vec<_> = (0..count).map(|i| i * i).collect();
            assert_eq!(list(count, 0, |i| i * i), plain);
        }
        assert_eq!(join(|| within(|| 1), || "b"), (1, "b"));
    }

    #[test]
    fn the_first_failure_is_told() {
        for bad in [0, 1, 5, 60] {
            let work = |i: usize| if i < bad { Ok(()) } else { Err(i) };
            assert_eq!(try_for_each(0..60, work), work(bad.min(59)));
        }
    }

    #[test]
    fn the_first_of_many_is_found() {
        let count = 9 * PIECE + 1;
        for from in [0, 1, PIECE - 1, PIECE, 5 * PIECE + 3, count - 1] {
            assert_eq!(first(count, |i| i >= from), Some(from));
        }
        assert_eq!(first(count, |_| false), None);
        assert_eq!(first(0, |_| true), None);
    }
}
