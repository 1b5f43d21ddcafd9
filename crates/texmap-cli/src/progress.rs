//! A progress bar on standard error, only where that is a terminal.

use std::borrow::Cow;

use crate::failure::is_quiet;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar that counts tiles, with a word in front of it. Hidden unless standard error is a terminal.
#[derive(Debug)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn new(what: impl Into<Cow<'static, str>>) -> Self {
        let target = match is_quiet() {
            true => ProgressDrawTarget::hidden(),
            false => ProgressDrawTarget::stderr(),
        };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        if let Ok(style) =
            ProgressStyle::with_template("{prefix} [{bar:32}] {percent:>3} % {eta:>4}")
        {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_prefix(what);
        Self(bar)
    }

    /// A bar that counts items: "12 of 1000", and the time that is left.
    pub(crate) fn of_items(what: impl Into<Cow<'static, str>>, of: u64) -> Self {
        let bar = Self::new(what);
        bar.0.set_length(of);
        if let Ok(style) =
            ProgressStyle::with_template("{prefix} {pos} of {len} [{bar:32}] {eta:>4}")
        {
            bar.0.set_style(style.progress_chars("=> "));
        }
        bar
    }

    /// A bar that is not shown.
    pub(crate) fn hidden() -> Self {
        Self(ProgressBar::hidden())
    }

    /// So many items are finished.
    pub(crate) fn count(&self, done: u64) {
        self.0.set_position(done);
    }

    /// `done` of `of` tiles are finished; may be called from any thread, in any order.
    pub(crate) fn update(&self, done: usize, of: usize) {
        self.0.set_length(of as u64);
        self.0.set_position(done as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
