//! Interruption: INT, TERM and HUP remove half-written outputs and end the program with 128 + the signal's number.
//!
//! A thread waits for the first signal, removes the temporary folders of all [stages](crate::output::Stage) and exits. A second
//! signal ends the program at once, in its handler. A signal that was ignored when the program started (`nohup`, a job in
//! the background) stays ignored. SIGXFSZ only gets a handler that does nothing: the write that is too large then fails with an
//! error like any other.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Temporary folders that exist now. Locked while outputs are renamed: they appear together or not at all.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// True once the first signal is handled; nothing is reported from then on.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Act before the program ends by a signal.
static AT_END: Mutex<Option<fn()>> = Mutex::new(None);

/// Calls `act` before the program ends by a signal.
pub(crate) fn at_end(act: fn()) {
    *AT_END.lock().unwrap_or_else(PoisonError::into_inner) = Some(act);
}

/// Starts to watch for signals. If that fails, signals end the program without a clean-up.
#[cfg(unix)]
pub(crate) fn watch() {
    use std::sync::Arc;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;

    let _ = flag::register(SIGXFSZ, Arc::default());
    let ignored = ignored();
    let watched: Vec<i32> = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| ignored >> (signal - 1) & 1 == 0)
        .collect();
    let Ok(mut signals) = Signals::new(&watched) else {
        return;
    };
    // The second of any two signals finds the flag set and ends the program at once.
    let second = Arc::new(AtomicBool::new(false));
    for &signal in &watched {
        let _ = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&second));
        let _ = flag::register(signal, Arc::clone(&second));
    }
    // Without a thread the first signal would only set the flag: the second one still ends the program.
    let _ = thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || {
            if let Some(signal) = signals.forever().next() {
                end(128 + signal);
            }
        });
}

/// Other systems end the program themselves.
#[cfg(not(unix))]
pub(crate) fn watch() {}

/// Signals that were ignored when the program started, a bit each from signal 1 on. Linux tells; elsewhere none is known.
#[cfg(unix)]
fn ignored() -> u64 {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| {
            let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"))?;
            u64::from_str_radix(mask.trim(), 16).ok()
        })
        .unwrap_or(0)
}

/// Removes the temporary folders and ends the program.
pub(crate) fn end(code: i32) -> ! {
    ENDING.store(true, Ordering::SeqCst);
    let act = *AT_END.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(act) = act {
        act();
    }
    // Held to the end: no output is renamed any more.
    let folders = folders();
    // Threads that still write may put a file into a folder that is being removed.
    for _ in 0..100 {
        let left = folders.iter().filter(|folder| {
            let _ = std::fs::remove_dir_all(folder);
            folder.symlink_metadata().is_ok()
        });
        if left.count() == 0 {
            break;
        }
        thread::sleep(Duration::from_millis(10));
    }
    std::process::exit(code)
}

/// Stops this thread for good if the program is ending: its errors are only the removed files.
pub(crate) fn stop_if_ending() {
    while ENDING.load(Ordering::SeqCst) {
        thread::sleep(Duration::from_secs(1));
    }
}

/// Locks the list of temporary folders; until it is unlocked no signal ends the program.
pub(crate) fn folders() -> MutexGuard<'static, Vec<PathBuf>> {
    FOLDERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes a folder off the list.
pub(crate) fn forget(folder: &Path) {
    folders().retain(|known| known != folder);
}
