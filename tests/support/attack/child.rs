//! One run of the program under watch: time, memory, signals.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Destination of standard output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stdout {
    Kept,
    /// A device without space.
    Full,
    /// A pipe that nobody reads.
    Closed,
}

/// A signal and the milliseconds after which it is sent, from when the program is ready for it: nothing of it runs before.
pub(super) type Interrupt = (&'static str, u64);

/// Outcome of a run.
#[derive(Debug)]
pub(super) struct Ending {
    pub(super) status: Option<ExitStatus>,
    /// Linux: it was seen to be ready for the signal.
    pub(super) ready: bool,
    /// The run did not end within the time; then it was killed.
    pub(super) hung: bool,
    /// The run took more memory than allowed; then it was killed.
    pub(super) large: bool,
    pub(super) stdout: Vec<u8>,
    pub(super) stderr: Vec<u8>,
    pub(super) took: Duration,
}

/// Most bytes of memory.
const MOST: u64 = 3 << 30;

/// `longest`: of the processor where the system tells it, for busy machines, and of the clock where the program rests; six times as
/// much whatever the machine does.
pub(super) fn run(
    program: &Path,
    folder: &Path,
    arguments: &[OsString],
    (stdin, stdout): (Option<&Path>, Stdout),
    interrupt: Option<Interrupt>,
    longest: Duration,
) -> io::Result<Ending> {
    let logs = tempfile::tempdir()?;
    let (out, err) = (logs.path().join("out"), logs.path().join("err"));
    let mut command = Command::new(program);
    command
        .args(arguments)
        .current_dir(folder)
        // Leftovers among temporary files are seen, too.
        .env("TMPDIR", folder)
        .stdin(match stdin {
            Some(path) => File::open(path)?.into(),
            None => Stdio::null(),
        });
    command.stderr(File::create(&err)?);
    match stdout {
        Stdout::Kept => command.stdout(File::create(&out)?),
        Stdout::Full => command.stdout(File::options().write(true).open("/dev/full")?),
        Stdout::Closed => command.stdout(Stdio::piped()),
    };
    let began = Instant::now();
    let mut child = command.spawn()?;
    drop(child.stdout.take());
    let (mut hung, mut large) = (false, false);
    let mut interrupt = interrupt;
    let (mut ready, mut caught) = (None, false);
    // Processor time when it last moved, and when that was.
    let mut moved = (Duration::ZERO, began);
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status);
        }
        let now = began.elapsed();
        if let Some((signal, after)) = interrupt {
            // One that never is ready gets it all the same.
            caught |= catches(child.id(), signal);
            if ready.is_none() && (caught || now > Duration::from_secs(2)) {
                ready = Some(now);
            }
            if ready.is_some_and(|ready| now >= ready + Duration::from_millis(after)) {
                send(&child, signal)?;
                interrupt = None;
            }
        }
        if let Some(used) = processor_time(child.id())
            && used > moved.0
        {
            moved = (used, Instant::now());
        }
        let rests = moved.1.elapsed() > longest;
        hung = moved.0 > longest || rests || now > 6 * longest;
        large = memory(child.id()).is_some_and(|bytes| bytes > MOST);
        if hung || large {
            child.kill()?;
            child.wait()?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(if now.as_millis() < 100 {
            1
        } else {
            5
        }));
    };
    Ok(Ending {
        status,
        ready: caught,
        hung,
        large,
        stdout: fs::read(out).unwrap_or_default(),
        stderr: fs::read(err)?,
        took: began.elapsed(),
    })
}

/// The shell's `kill`: the standard library sends no signal but the last one.
fn send(child: &Child, signal: &str) -> io::Result<()> {
    let command = format!("kill -{signal} {} 2>/dev/null || true", child.id());
    Command::new("sh").arg("-c").arg(command).status().map(drop)
}

/// Linux: whether the process has said what to do with the signal.
fn catches(id: u32, signal: &str) -> bool {
    let number = match signal {
        "HUP" => 1,
        "INT" => 2,
        _ => 15,
    };
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    // A signal that was ignored when the attack started (`nohup`, a job in the background) is to stay ignored.
    ["SigCgt:", "SigIgn:"].iter().any(|mask| {
        let mask = status
            .lines()
            .find_map(|line| line.strip_prefix(mask))
            .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        mask.is_some_and(|mask| mask >> (number - 1) & 1 == 1)
    })
}

/// Linux: what the process has used of its processors, in ticks of a hundredth of a second.
fn processor_time(id: u32) -> Option<Duration> {
    let text = fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The name of the program stands in brackets and may hold blanks.
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let ticks = fields.next()?.parse::<u64>().ok()? + fields.next()?.parse::<u64>().ok()?;
    Some(Duration::from_millis(10 * ticks))
}

/// Linux: bytes in memory, in pages of 4 KiB.
fn memory(id: u32) -> Option<u64> {
    let text = fs::read_to_string(format!("/proc/{id}/statm")).ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(4096 * pages)
}
