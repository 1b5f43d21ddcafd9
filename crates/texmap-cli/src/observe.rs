//! Observation of a verb that runs as a task of a batch: its report, warnings and files are kept instead of printed.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use serde_json::Value;

/// Traces of a verb.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    /// The report that `--json` prints.
    pub(crate) report: Option<Value>,
    /// Warnings that were said.
    pub(crate) warnings: Vec<String>,
    /// Files that were read, as far as scenes name them.
    pub(crate) read: BTreeSet<PathBuf>,
    /// Files that were written, in order.
    pub(crate) written: Vec<PathBuf>,
}

/// Called with the report of each picture of a series, and the traces since the picture before.
type EachPicture = Box<dyn FnMut(Value, Seen) + Send>;

struct Observer {
    seen: Seen,
    each: EachPicture,
}

static OBSERVER: Mutex<Option<Observer>> = Mutex::new(None);
static ON: AtomicBool = AtomicBool::new(false);

/// Runs a verb under observation. `each` is called when a picture of a series is written.
pub(crate) fn during<R>(
    each: impl FnMut(Value, Seen) + Send + 'static,
    verb: impl FnOnce() -> R,
) -> (R, Seen) {
    *observer() = Some(Observer {
        seen: Seen::default(),
        each: Box::new(each),
    });
    ON.store(true, Ordering::SeqCst);
    let result = verb();
    ON.store(false, Ordering::SeqCst);
    let seen = observer().take().map(|observer| observer.seen);
    (result, seen.unwrap_or_default())
}

/// True while a verb is observed: then reports are wanted, and nothing is printed.
pub(crate) fn is_on() -> bool {
    ON.load(Ordering::SeqCst)
}

/// Keeps a report; false if nobody observes, and it is to be printed.
pub(crate) fn report(value: &impl Serialize) -> bool {
    with(|observer| observer.seen.report = serde_json::to_value(value).ok())
}

/// Keeps the warning of a line of words, if it is one.
pub(crate) fn said(text: &str) {
    if let Some(warning) = text.strip_prefix("warning: ") {
        with(|observer| observer.seen.warnings.push(warning.trim().to_owned()));
    }
}

/// Keeps the names of files that were read.
pub(crate) fn read(files: impl IntoIterator<Item = PathBuf>) {
    with(|observer| observer.seen.read.extend(files));
}

/// Keeps the name of a file that was written.
pub(crate) fn written(file: PathBuf) {
    with(|observer| observer.seen.written.push(file));
}

/// Tells of a picture of a series that was written.
pub(crate) fn picture(report: &impl Serialize) {
    with(|observer| {
        let Ok(report) = serde_json::to_value(report) else {
            return;
        };
        let seen = observer.seen.clone();
        observer.seen.written.clear();
        observer.seen.warnings.clear();
        (observer.each)(report, seen);
    });
}

fn with(act: impl FnOnce(&mut Observer)) -> bool {
    is_on() && observer().as_mut().map(act).is_some()
}

fn observer() -> MutexGuard<'static, Option<Observer>> {
    OBSERVER.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn traces_are_kept_for_each_picture_and_for_the_whole() {
        let pictures = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&pictures);
        assert!(!report(&1));
        let ((), seen) = during(
            move |report, seen| kept.lock().unwrap().push((report, seen)),
            || {
                read(["a.mtl".into()]);
                for n in 0..2 {
                    written(format!("{n}.png").into());
                    said("warning: dark\n");
                    said("0.png: 4 x 4 pixels\n");
                    picture(&n);
                }
                written("last".into());
                assert!(report(&7));
            },
        );
        assert!(!is_on());
        assert_eq!(seen.report, Some(7.into()));
        assert_eq!(seen.written, [PathBuf::from("last")]);
        let pictures = pictures.lock().unwrap();
        assert_eq!(pictures.len(), 2);
        for (n, (report, seen)) in pictures.iter().enumerate() {
            assert_eq!(*report, n);
            assert_eq!(seen.written, [PathBuf::from(format!("{n}.png"))]);
            assert_eq!(seen.warnings, ["dark"]);
            assert!(seen.read.contains(&PathBuf::from("a.mtl")));
        }
    }
}
