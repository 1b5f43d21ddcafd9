//! Progress of long work: steps that a callback hears of, and may end.

use core::fmt;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A callback that hears (steps done, steps in all) from the threads that work, in any order, and ends the work by [`ControlFlow::Break`].
pub type Progress<'a> = &'a (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// The progress callback that neither shows nor ends anything.
pub fn no_progress(_done: usize, _of: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Counts the steps of one work for its callback, from any number of threads.
pub struct Steps<'a> {
    done: AtomicUsize,
    cancelled: AtomicBool,
    of: usize,
    progress: Progress<'a>,
}

impl<'a> Steps<'a> {
    /// For work of `of` steps.
    pub fn new(progress: Progress<'a>, of: usize) -> Self {
        Self {
            done: AtomicUsize::new(0),
            cancelled: AtomicBool::new(false),
            of,
            progress,
        }
    }

    /// One more step is done. Nothing is told once the work was ended.
    pub fn step(&self) {
        if self.is_cancelled() {
            return;
        }
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if (self.progress)(done, self.of).is_break() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// True once the callback ended the work: steps that have not begun are left out.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl fmt::Debug for Steps<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Steps")
            .field("done", &self.done)
            .field("of", &self.of)
            .field("cancelled", &self.cancelled)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_break_is_the_last_call() {
        let calls = AtomicUsize::new(0);
        let progress = |done: usize, of: usize| {
            calls.fetch_add(1, Ordering::Relaxed);
            assert_eq!(of, 9);
            match done == 4 {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let steps = Steps::new(&progress, 9);
        for k in 0..9 {
            assert_eq!(steps.is_cancelled(), k >= 4);
            steps.step();
        }
        assert_eq!(calls.into_inner(), 4);
    }
}
