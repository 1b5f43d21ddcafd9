//! Times of change of the files that a picture is made of.

use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

/// Files and the times of their last change.
#[derive(Debug)]
pub(crate) struct Watch {
    files: Vec<(PathBuf, Option<SystemTime>)>,
    looked: Instant,
}

/// Files are looked at so often.
const EVERY: Duration = Duration::from_millis(300);

impl Watch {
    pub(crate) fn new(files: Vec<PathBuf>) -> Self {
        let timed = files.into_iter().map(|file| {
            let time = changed_at(&file);
            (file, time)
        });
        Self {
            files: timed.collect(),
            looked: Instant::now(),
        }
    }

    /// True once after a change.
    pub(crate) fn changed(&mut self) -> bool {
        if self.looked.elapsed() < EVERY {
            return false;
        }
        self.looked = Instant::now();
        let mut changed = false;
        for (file, time) in &mut self.files {
            let now = changed_at(file);
            // A file that is being replaced is missing for a moment.
            if now.is_some() && now != *time {
                *time = now;
                changed = true;
            }
        }
        changed
    }
}

fn changed_at(file: &PathBuf) -> Option<SystemTime> {
    std::fs::metadata(file).and_then(|m| m.modified()).ok()
}
