//! The processes that run the tasks of a batch, one thread of the batch for each.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

use crate::cmd::batch::worker::{Answer, Outcome, Task};
use crate::failure::Failure;
use crate::interrupt;

/// A command line, and the units that it runs.
#[derive(Debug)]
pub(crate) struct Job {
    /// Positions of the units in the plan; several are pictures of one series, with their numbers.
    pub(crate) units: Vec<(usize, u32)>,
    pub(crate) words: Vec<String>,
}

/// The end of a unit.
#[derive(Debug)]
pub(crate) enum Ended {
    Told(Outcome),
    /// The process is gone.
    Gone {
        code: u8,
        what: String,
        outside: bool,
    },
}

impl Ended {
    fn failed(&self) -> bool {
        match self {
            Self::Told(outcome) => outcome.error.is_some(),
            Self::Gone { .. } => true,
        }
    }
}

/// Processes and their means.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Means {
    pub(crate) jobs: usize,
    pub(crate) threads: u16,
    /// Bytes of memory of each process.
    pub(crate) memory: Option<u64>,
}

/// Runs all jobs. `each` is called with every unit that ends, in the order of ends. No further job starts once it fails, or, with
/// `fail_fast`, a unit.
pub(crate) fn run(
    jobs: Vec<Job>,
    means: Means,
    fail_fast: bool,
    mut each: impl FnMut(usize, Ended) -> Result<(), Failure>,
) -> Result<(), Failure> {
    interrupt::at_end(close_all);
    let queue = Mutex::new(VecDeque::from(jobs));
    let stopped = AtomicBool::new(false);
    thread::scope(|scope| {
        let (send, ended) = mpsc::channel();
        for _ in 0..means.jobs {
            let (send, queue, stopped) = (send.clone(), &queue, &stopped);
            scope.spawn(move || {
                let mut worker = None;
                while !stopped.load(Ordering::Relaxed) {
                    let Some(job) = locked(queue).pop_front() else {
                        break;
                    };
                    let tell = |unit, end: Ended| {
                        // Here, as the next job may start before the end is received.
                        if fail_fast && end.failed() {
                            stopped.store(true, Ordering::Relaxed);
                        }
                        let _ = send.send(Ok((unit, end)));
                    };
                    if let Err(failure) = serve(&mut worker, &job, means, &tell) {
                        let _ = send.send(Err(failure));
                        stopped.store(true, Ordering::Relaxed);
                    }
                }
                if let Some(worker) = worker {
                    let _ = worker.end();
                }
            });
        }
        drop(send);
        let mut result = Ok(());
        for news in ended {
            let done = match news {
                _ if result.is_err() => Ok(()),
                Ok((unit, end)) => each(unit, end),
                Err(failure) => Err(failure),
            };
            if let Err(failure) = done {
                stopped.store(true, Ordering::Relaxed);
                result = Err(failure);
            }
        }
        result
    })
}

/// Runs one job and tells the end of each of its units.
fn serve(
    worker: &mut Option<Worker>,
    job: &Job,
    means: Means,
    tell: &dyn Fn(usize, Ended),
) -> Result<(), Failure> {
    let mut left = job.units.clone();
    let running = match worker {
        Some(running) => running,
        None => worker.insert(Worker::new(means)?),
    };
    let task = Task {
        words: job.words.clone(),
    };
    let mut last = None;
    if running.send(&task).is_ok() {
        while let Some(answer) = running.receive() {
            match answer {
                Answer::Picture(number, outcome) => {
                    let Some(at) = left.iter().position(|(_, n)| *n == number) else {
                        continue;
                    };
                    tell(left.remove(at).0, Ended::Told(outcome));
                }
                Answer::End(outcome) => {
                    last = Some(outcome);
                    break;
                }
            }
        }
    }
    match last {
        Some(outcome) => {
            for (unit, _) in left {
                tell(unit, Ended::Told(outcome.clone()));
            }
        }
        None => {
            interrupt::stop_if_ending();
            let status = worker.take().and_then(Worker::end);
            let (code, what, outside) = fate(status);
            for (unit, _) in left {
                let what = what.clone();
                tell(
                    unit,
                    Ended::Gone {
                        code,
                        what,
                        outside,
                    },
                );
            }
        }
    }
    Ok(())
}

/// Exit code and words for a process that is gone, and true if it was ended from outside.
fn fate(status: Option<ExitStatus>) -> (u8, String, bool) {
    #[cfg(unix)]
    if let Some(signal) = status.and_then(|s| std::os::unix::process::ExitStatusExt::signal(&s)) {
        // SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV: the program's own faults.
        let outside = ![4, 6, 7, 8, 11].contains(&signal);
        return (
            128 + signal as u8,
            format!("its process was ended by signal {signal}"),
            outside,
        );
    }
    let code = status.and_then(|s| s.code()).unwrap_or(6) as u8;
    let outside = [129, 130, 143].contains(&code);
    (
        code,
        format!("its process ended with exit code {code}"),
        outside,
    )
}

/// A process with its standard input, which [`close_all`] closes too.
#[derive(Debug)]
struct Held {
    child: Child,
    stdin: Option<ChildStdin>,
}

type Shared = Arc<Mutex<Held>>;

/// The words that start this program, if it is no executable of its own.
static STARTED_BY: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the words that start this program.
pub(crate) fn started_by(words: Vec<OsString>) {
    let _ = STARTED_BY.set(words);
}

static WORKERS: Mutex<Vec<Shared>> = Mutex::new(Vec::new());

#[derive(Debug)]
struct Worker {
    held: Shared,
    answers: BufReader<ChildStdout>,
}

impl Worker {
    fn new(means: Means) -> Result<Self, Failure> {
        let failed = |e: io::Error| {
            Failure::internal(format!("a process of the batch could not be started: {e}"))
        };
        let mut command = match STARTED_BY.get().map(Vec::as_slice) {
            Some([program, words @ ..]) => {
                let mut command = Command::new(program);
                command.args(words);
                command
            }
            _ => Command::new(std::env::current_exe().map_err(failed)?),
        };
        command.args([
            "batch-worker",
            "--quiet",
            "--threads",
            &means.threads.to_string(),
        ]);
        if let Some(bytes) = means.memory {
            command.arg(format!("--memory-limit={bytes}"));
        }
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let stdin = child.stdin.take();
        let Some(stdout) = child.stdout.take() else {
            return Err(failed(io::ErrorKind::BrokenPipe.into()));
        };
        let held = Arc::new(Mutex::new(Held { child, stdin }));
        locked(&WORKERS).push(Arc::clone(&held));
        Ok(Self {
            held,
            answers: BufReader::new(stdout),
        })
    }

    fn send(&self, task: &Task) -> io::Result<()> {
        let mut text = serde_json::to_string(task)?;
        text.push('\n');
        match &mut locked(&self.held).stdin {
            Some(stdin) => stdin
                .write_all(text.as_bytes())
                .and_then(|()| stdin.flush()),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    /// `None` once the process is gone.
    fn receive(&mut self) -> Option<Answer> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(bytes) if bytes > 0 => serde_json::from_str(&line).ok(),
            _ => None,
        }
    }

    /// Closes its input and waits for its end.
    fn end(self) -> Option<ExitStatus> {
        locked(&WORKERS).retain(|other| !Arc::ptr_eq(other, &self.held));
        let mut held = locked(&self.held);
        held.stdin = None;
        held.child.wait().ok()
    }
}

/// Closes the inputs of all processes, which end by themselves then, and waits a moment for them.
fn close_all() {
    let workers = std::mem::take(&mut *locked(&WORKERS));
    for worker in &workers {
        if let Ok(mut held) = worker.try_lock() {
            held.stdin = None;
        }
    }
    for _ in 0..200 {
        let gone = |worker: &Shared| {
            let Ok(mut held) = worker.try_lock() else {
                return false;
            };
            held.child.try_wait().is_ok_and(|status| status.is_some())
        };
        if workers.iter().all(gone) {
            return;
        }
        thread::sleep(Duration::from_millis(10));
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
