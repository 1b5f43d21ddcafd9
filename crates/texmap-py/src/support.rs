//! Errors, threads, SIMD levels and interruption, as every function of the module has them.

use std::collections::HashMap;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::Duration;

use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::exceptions::{
    PyFileNotFoundError, PyImportError, PyOSError, PyOverflowError, PyRuntimeError, PyValueError,
};
use pyo3::prelude::*;
use texmap_io::IoError;
use texmap_math::Level;

/// Looks up all of NumPy's functions that arrays are read by. The crate `numpy` does so at the first use of each and panics where an
/// exception comes, as that of Ctrl-C may: Python raises it in the main thread alone, so another thread does the work.
pub(crate) fn numpy_api(py: Python<'_>) -> PyResult<()> {
    for module in ["numpy", "numpy.lib", "numpy.version"] {
        py.import(module)?;
    }
    let ready = py.detach(|| {
        let work = || {
            Python::attach(|py| -> PyResult<()> {
                let array = PyArray1::<f32>::zeros(py, 1, false).into_any();
                drop(array.extract::<PyReadwriteArray1<'_, f32>>()?);
                drop(array.extract::<PyReadonlyArray1<'_, f32>>()?);
                Ok(())
            })
        };
        thread::scope(|scope| scope.spawn(work).join())
    });
    ready.unwrap_or_else(|_| {
        Err(PyImportError::new_err(
            "texmap: NumPy's functions cannot be looked up",
        ))
    })
}

/// A `ValueError` with the text of an error.
pub(crate) fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A `FileNotFoundError` or `OSError` where the operating system refused, else a `ValueError`, with both lines of the program.
pub(crate) fn io(error: IoError) -> PyErr {
    let text = format!("{error}\n{}", error.help());
    match error {
        IoError::FileMissing { .. } => PyFileNotFoundError::new_err(text),
        IoError::NotAFile { .. }
        | IoError::Read { .. }
        | IoError::Write { .. }
        | IoError::OutsideRoot { .. } => PyOSError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// An entry of a slice, or an error that names the array.
pub(crate) fn expect_length(name: &str, found: usize, expected: usize) -> PyResult<()> {
    match found == expected {
        true => Ok(()),
        false => Err(value(format!(
            "{name} holds {found} values, expected {expected}"
        ))),
    }
}

/// A word of a `FromStr` type; `name` is the argument.
pub(crate) fn word<T: std::str::FromStr>(name: &str, text: &str) -> PyResult<T>
where
    T::Err: Display,
{
    text.parse()
        .map_err(|e| value(format!("{name}={text:?}: {e}")))
}

/// The SIMD level of a name; `None` and `auto` are the best one of this machine. No result depends on it.
pub(crate) fn level(name: Option<&str>) -> PyResult<Level> {
    let best = Level::new();
    let found = match name.unwrap_or("auto") {
        "auto" => Some(best),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "avx512" => best.as_avx512().map(Level::Avx512),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "avx2" => best.as_avx2().map(Level::Avx2),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "sse4.2" => best.as_sse4_2().map(Level::Sse4_2),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "sse2" => best.as_sse2().map(Level::Sse2),
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        "avx512" | "avx2" | "sse4.2" | "sse2" => None,
        other => {
            return Err(value(format!(
                "level={other:?}: know auto, avx512, avx2, sse4.2, sse2"
            )));
        }
    };
    found.ok_or_else(|| {
        value(format!(
            "this CPU does not support level={:?}; \"auto\" gives the same values",
            name.unwrap_or("auto")
        ))
    })
}

/// The number of threads that a call asks for, 1 to 1024.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Threads(usize);

impl Threads {
    pub(crate) const ONE: Self = Self(1);
}

impl<'py> FromPyObject<'_, 'py> for Threads {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let refused =
            |count: &dyn Display| value(format!("cannot run on {count} threads: give 1 to 1024"));
        match given.extract::<i64>() {
            Ok(count @ 1..=1024) => Ok(Self(count as usize)),
            Ok(count) => Err(refused(&count)),
            Err(error) if error.is_instance_of::<PyOverflowError>(given.py()) => {
                Err(refused(&given.to_string()))
            }
            Err(error) => Err(error),
        }
    }
}

/// The pool of this many threads, `None`: as many as the machine gives. Pools are kept, and made again in a forked process, which
/// has none of its parent's threads: work that may share itself out runs in one of them, never in the global pool.
fn pool(threads: Option<Threads>) -> PyResult<Arc<rayon::ThreadPool>> {
    type Pools = HashMap<(u32, usize), Arc<rayon::ThreadPool>>;
    static POOLS: OnceLock<Mutex<Pools>> = OnceLock::new();
    let count = match threads {
        Some(Threads(count)) => count,
        None => thread::available_parallelism().map_or(1, usize::from),
    };
    let broken = |_| PyRuntimeError::new_err("texmap: a thread pool could not be made");
    let mut pools = POOLS.get_or_init(Mutex::default).lock().map_err(broken)?;
    let key = (std::process::id(), count);
    if let Some(pool) = pools.get(&key) {
        return Ok(Arc::clone(pool));
    }
    let made = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    let made = made.map_err(|e| value(format!("cannot run on {count} threads: {e}")))?;
    let made = Arc::new(made);
    pools.insert(key, Arc::clone(&made));
    Ok(made)
}

/// Runs short work without the interpreter lock on a pool of `threads`.
pub(crate) fn unlocked<T: Send>(
    py: Python<'_>,
    threads: Option<Threads>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let pool = pool(threads)?;
    Ok(py.detach(|| pool.install(work)))
}

/// Progress that ends the work once the flag is set.
pub(crate) fn go_on(stop: &AtomicBool) -> impl Fn(usize, usize) -> ControlFlow<()> + Sync {
    |_, _| match stop.load(Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

/// Runs long work as [`unlocked`] does while the calling thread looks for signals: Ctrl-C sets the flag that the work is given,
/// and is raised once the work has ended.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    threads: Option<Threads>,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let pool = pool(threads)?;
    let stop = AtomicBool::new(false);
    py.detach(|| {
        thread::scope(|scope| {
            let (send, receive) = mpsc::channel();
            let (pool, stop) = (&pool, &stop);
            scope.spawn(move || {
                // The receiver waits until the sender is gone.
                let _ = send.send(pool.install(|| work(stop)));
            });
            loop {
                match receive.recv_timeout(Duration::from_millis(50)) {
                    Ok(result) => return Ok(result),
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("texmap: the work stopped: a bug"));
                    }
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(raised) = Python::attach(|py| py.check_signals()) {
                            stop.store(true, Ordering::Relaxed);
                            let _ = receive.recv();
                            return Err(raised);
                        }
                    }
                }
            }
        })
    })
}
