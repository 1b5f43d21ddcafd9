//! Attacks on the program from outside: spoilt and endless inputs, special files, wrong flags, full devices, signals. A seed
//! repeats every one of them.

mod child;
mod desk;
mod inputs;
mod lines;
mod rng;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::{self, Write as _};
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use child::{Ending, Interrupt, Stdout};
use desk::{Desk, OLD, SECRET};
use lines::{LINES, Line, not_unicode, odd_name};
use rng::Rng;

/// Change to a good command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// An input has wrong content.
    Content,
    /// An input is no ordinary file.
    Special,
    /// An input has an odd name.
    Name,
    /// Flags and values are wrong.
    Flags,
    /// An output has an odd name, or standard output is full or closed.
    Output,
    /// An input holds very much.
    Huge,
    /// A signal comes in the middle.
    Signal,
}

impl Kind {
    /// All of them; content counts three times, there are the most ways for it to be wrong.
    const TURNS: [Self; 9] = [
        Self::Special,
        Self::Content,
        Self::Flags,
        Self::Output,
        Self::Content,
        Self::Name,
        Self::Signal,
        Self::Content,
        Self::Huge,
    ];
}

/// Forbidden outcome of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// A panic, or exit code 6.
    Panic,
    /// Longer than allowed.
    Hang,
    /// More than 3 GiB.
    Memory,
    /// Death by a signal, sent or not; a run that would not notice one.
    Signal,
    /// An exit code that is not documented.
    ExitCode,
    /// An older file is lost, or a new one is missing after success.
    Output,
    /// Files that nobody asked for.
    Litter,
    /// No message, a raw control character, a very long word, or words of a stranger's file.
    Message,
}

impl Fault {
    const ALL: [Self; 8] = [
        Self::Panic,
        Self::Hang,
        Self::Memory,
        Self::Signal,
        Self::ExitCode,
        Self::Output,
        Self::Litter,
        Self::Message,
    ];
}

/// One case that went wrong.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Number of the case: with the seed it repeats the case.
    pub number: u64,
    /// The change to the command line.
    pub kind: Kind,
    /// The forbidden outcome.
    pub fault: Fault,
    /// The command line, what was changed, and how the run ended.
    pub text: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            number,
            kind,
            fault,
            text,
        } = self;
        write!(f, "case {number} ({kind:?}): {fault:?}: {text}")
    }
}

/// Counts of all cases, and their findings.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Cases by kind.
    pub cases: BTreeMap<Kind, u64>,
    /// Exit codes and how often each was seen.
    pub codes: BTreeMap<i32, u64>,
    /// Everything that went wrong.
    pub findings: Vec<Finding>,
    /// The longest run in milliseconds, and its case.
    pub longest: (u128, u64),
}

impl Summary {
    /// Number of findings of a fault.
    #[must_use]
    pub fn count(&self, fault: Fault) -> usize {
        self.findings.iter().filter(|f| f.fault == fault).count()
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| cases |")?;
        for fault in Fault::ALL {
            write!(f, " {fault:?} |")?;
        }
        write!(f, "\n|---|{}\n| ", "---|".repeat(Fault::ALL.len()))?;
        write!(f, "{} |", self.cases.values().sum::<u64>())?;
        for fault in Fault::ALL {
            write!(f, " {} |", self.count(fault))?;
        }
        writeln!(f, "\ncases: {:?}", self.cases)?;
        writeln!(f, "exit codes: {:?}", self.codes)?;
        writeln!(
            f,
            "longest run: {} ms (case {})",
            self.longest.0, self.longest.1
        )
    }
}

/// Runs the cases of these numbers, each for no more than `longest` of the processor. `told` hears what goes wrong at once.
///
/// # Errors
/// If a working folder cannot be made or the program not be started.
pub fn attack(
    program: &Path,
    seed: u64,
    numbers: impl Iterator<Item = u64>,
    longest: Duration,
    mut told: impl FnMut(&Finding),
) -> io::Result<Summary> {
    let mut summary = Summary::default();
    for number in numbers {
        let known = summary.findings.len();
        Case::new(seed, number)?.run(program, number, longest, &mut summary)?;
        summary.findings[known..].iter().for_each(&mut told);
    }
    Ok(summary)
}

struct Case {
    kind: Kind,
    desk: Desk,
    line: Line,
    /// The change, in words.
    change: String,
    stdout: Stdout,
    interrupt: Option<Interrupt>,
}

impl Case {
    fn new(seed: u64, number: u64) -> io::Result<Self> {
        let mut rng = Rng::new(seed.wrapping_mul(0x1_0000_0001) ^ number);
        let (number, turns) = (number as usize, Kind::TURNS.len());
        let kind = Kind::TURNS[number % turns];
        let mut line = Line::new(LINES[(number / turns + 7 * (number % turns)) % LINES.len()]);
        let desk = Desk::new(rng.below(280))?;
        let (mut stdout, mut interrupt) = (Stdout::Kept, None);
        let change = match kind {
            Kind::Content => {
                let name = match &line.stdin {
                    Some(name) if rng.chance(2) => name.clone(),
                    _ => victim(&line, &mut rng),
                };
                let good = std::fs::read(desk.path(&name))?;
                let spoilt = inputs::spoilt(&name.to_string_lossy(), &good, &mut rng);
                std::fs::write(desk.path(&name), spoilt)?;
                format!("{} is spoilt", name.display())
            }
            Kind::Special => {
                let name = victim(&line, &mut rng);
                let what = inputs::special(&desk.path(&name), &mut rng)?;
                format!("{} is: {what}", name.display())
            }
            Kind::Name => {
                let at = line.inputs[rng.below(line.inputs.len())];
                if rng.chance(3) {
                    let name = line.file(at);
                    let ending = Path::new(&name).extension();
                    let ending = ending.map(|e| e.to_string_lossy().into_owned());
                    let name = format!("ab.{}", ending.unwrap_or_default()).into_bytes();
                    let name = not_unicode(&[&[0xff, 0xfe][..], &name].concat());
                    std::fs::rename(desk.path(line.file(at)), desk.path(&name))?;
                    line.words[at] = name;
                } else {
                    line.words[at] = odd_name(&mut rng);
                }
                "an odd name".into()
            }
            Kind::Flags => {
                if rng.chance(6) {
                    line = Line::wrong(&mut rng);
                } else {
                    for _ in 0..1 + rng.below(3) {
                        if line.words.len() > 1 {
                            line.spoil(&mut rng);
                        }
                    }
                }
                "wrong flags".into()
            }
            Kind::Output => {
                match line.outputs.first() {
                    Some(&at) if !rng.chance(3) => line.words[at] = odd_name(&mut rng),
                    _ => stdout = [Stdout::Full, Stdout::Closed][rng.below(2)],
                }
                format!("standard output: {stdout:?}")
            }
            Kind::Huge => inputs::huge(desk.root(), &mut rng)?.into(),
            Kind::Signal => {
                let signal = ["INT", "TERM", "HUP"][rng.below(3)];
                let after = [3, 10, 30, 60, 120, 240][rng.below(6)];
                line = Line::new(
                    [
                        "render @all.scene -o >out.png --resolution 800x600 --supersample 2 --aov uv,position",
                        "uv-raster @m.obj -o >out --size 2048",
                        "env @sky.hdr -o >out.exr --to cube --size 1024",
                        "render @all.scene --path @walk.json --frames 30 -o >out%d.png --resolution 400x300",
                        "warp @check.png -o >out.png --size 3000x3000",
                        "bake @m.obj --object panel --light --size 1024 -o >out.exr",
                        "render @bent.glb -o >out.gif --turntable 200 --resolution 300x200",
                        "render - <cube.stl --texture @check.png -o >out.apng --turntable 300 --resolution 300x200",
                        "render @m.obj -o >out.exr --aov depth,normal --resolution 1600x1200",
                        "render @cube.stl -o >made/{n}.jpg --turntable 100 --resolution 200x150",
                        "render @@models.txt -o >made/{model}.webp --resolution 1600x1200",
                    ][rng.below(11)],
                );
                interrupt = Some((signal, after));
                format!("{signal} after {after} ms")
            }
        };
        // Half of the outputs exist before.
        if rng.chance(2) {
            for &at in &line.outputs {
                let path = desk.path(&line.words[at]);
                if !path.exists() && path.parent() == Some(desk.root()) {
                    // Names that are too long have no older file.
                    let _ = std::fs::write(path, OLD);
                }
            }
        }
        Ok(Self {
            kind,
            desk,
            line,
            change,
            stdout,
            interrupt,
        })
    }

    fn run(
        self,
        program: &Path,
        number: u64,
        longest: Duration,
        summary: &mut Summary,
    ) -> io::Result<()> {
        let before = self.desk.state()?;
        let words = &self.line.words;
        let ending = child::run(
            program,
            self.desk.root(),
            words,
            (
                self.line
                    .stdin
                    .as_ref()
                    .map(|name| self.desk.path(name))
                    .as_deref(),
                self.stdout,
            ),
            self.interrupt,
            longest,
        )?;
        let after = self.desk.state()?;
        *summary.cases.entry(self.kind).or_default() += 1;
        if let Some(code) = ending.status.and_then(|s| s.code()) {
            *summary.codes.entry(code).or_default() += 1;
        }
        summary.longest = summary.longest.max((ending.took.as_millis(), number));
        for (fault, what) in self.faults(&ending, &before, &after) {
            let stderr = String::from_utf8_lossy(&ending.stderr);
            let said: String = stderr.chars().take(300).collect();
            summary.findings.push(Finding {
                number,
                kind: self.kind,
                fault,
                text: format!(
                    "{what}; texmap {}; {}; {:?}; {said:?}",
                    self.line.text().chars().take(200).collect::<String>(),
                    self.change,
                    ending.status,
                ),
            });
        }
        Ok(())
    }

    /// True if files that were finished before a signal came, or before the report could not be written, stay.
    fn may_leave(&self) -> bool {
        self.interrupt.is_some() || matches!(self.stdout, Stdout::Full)
    }

    fn faults(&self, ending: &Ending, before: &State, after: &State) -> Vec<(Fault, String)> {
        let mut faults = Vec::new();
        let mut fault = |fault, what: String| faults.push((fault, what));
        let code = ending.status.and_then(|status| status.code());
        if code == Some(6) || text_of(&ending.stderr).contains("panicked at") {
            fault(Fault::Panic, "internal error".into());
        }
        if ending.hung {
            fault(Fault::Hang, "did not end".into());
        }
        if ending.large {
            fault(Fault::Memory, "more than 3 GiB".into());
        }
        if let Some(signal) = ending.status.and_then(|status| status.signal()) {
            fault(Fault::Signal, format!("died of signal {signal}"));
        }
        // A run that refuses its input may be over before it can be looked at.
        let refused = matches!(code, Some(2 | 4));
        if cfg!(target_os = "linux") && self.interrupt.is_some() && !ending.ready && !refused {
            fault(Fault::Signal, "is not ready for signals".into());
        }
        let interrupted = match self.interrupt.map(|(signal, _)| signal) {
            Some("INT") => Some(130),
            Some("TERM") => Some(143),
            Some(_) => Some(129),
            None => None,
        };
        if let Some(code) = code
            && !(0..=6).contains(&code)
            && Some(code) != interrupted
        {
            fault(Fault::ExitCode, format!("exit code {code}"));
        }
        for what in self.lost(code, before, after) {
            fault(Fault::Output, what);
        }
        for what in litter(code, self.may_leave(), before, after) {
            fault(Fault::Litter, what);
        }
        for what in self.messages(code, ending) {
            fault(Fault::Message, what);
        }
        faults
    }

    /// Files that were there and are not, or changed though the run failed. Outputs that are missing after success.
    fn lost(&self, code: Option<i32>, before: &State, after: &State) -> Vec<String> {
        let content = |state: &State, name: &Path| {
            let found = state.iter().find(|(known, _)| known == name);
            found.map(|(_, content)| content.clone())
        };
        let is_output = |name: &Path| {
            self.line
                .outputs
                .iter()
                .any(|&at| *self.line.words[at] == *name)
        };
        // Of several inputs some may have been drawn, and a budget or a comparison fails after writing.
        let writes = matches!(code, Some(0 | 1 | 3 | 5));
        let mut lost = Vec::new();
        let reads = self.line.reads();
        for (name, content_before) in before {
            let unknown = self.kind == Kind::Flags || self.kind == Kind::Output;
            let unknown = unknown && !reads.iter().any(|read| **read == **name);
            match content(after, name) {
                None => lost.push(format!("{} is gone", name.display())),
                // A signal comes before or after an output is whole.
                Some(Some(now)) if self.may_leave() && is_output(name) && whole(&now) => {}
                Some(now)
                    if now != *content_before && !(writes && (unknown || is_output(name))) =>
                {
                    lost.push(format!("{} changed", name.display()));
                }
                Some(_) => {}
            }
        }
        if code == Some(0) && self.kind != Kind::Flags && self.kind != Kind::Output {
            for &at in &self.line.outputs {
                let name = Path::new(&self.line.words[at]);
                // Prefixes and templates name other files.
                let plain =
                    name.extension().is_some() && !name.to_string_lossy().contains(['%', '{']);
                let now = content(after, name);
                if plain && now.is_none_or(|now| now.as_deref() == Some(OLD)) {
                    lost.push(format!("{} was not written", name.display()));
                }
            }
        }
        lost
    }

    fn messages(&self, code: Option<i32>, ending: &Ending) -> Vec<String> {
        let mut wrong = Vec::new();
        let stderr = text_of(&ending.stderr);
        if matches!(code, Some(2 | 4 | 5 | 6)) && !stderr.contains("error[") && code != Some(5) {
            wrong.push("no message".into());
        }
        if let Some(c) = stderr.chars().find(|c| c.is_control() && *c != '\n') {
            wrong.push(format!("a raw {c:?}"));
        }
        if stderr.contains(&"Q".repeat(400)) && !self.line.text().contains(&"Q".repeat(300)) {
            wrong.push("a long word of a file".into());
        }
        if stderr.contains(SECRET) || text_of(&ending.stdout).contains(SECRET) {
            wrong.push("words of a stranger's file".into());
        }
        wrong
    }
}

type State = Vec<(PathBuf, Option<Vec<u8>>)>;

/// An input of the line, or a file that its scene or model names.
fn victim(line: &Line, rng: &mut Rng) -> OsString {
    let mut names: Vec<OsString> = line.inputs.iter().map(|&at| line.file(at)).collect();
    if names.iter().any(|name| name == "all.scene") && rng.chance(2) {
        names = [
            "part.scene",
            "check.png",
            "m.obj",
            "m.mtl",
            "sky.hdr",
            "grid.npy",
        ]
        .map(OsString::from)
        .into();
    }
    names.swap_remove(rng.below(names.len()))
}

/// New files after a failure, and temporary ones after anything.
fn litter(code: Option<i32>, interrupted: bool, before: &State, after: &State) -> Vec<String> {
    // Files that were finished before a signal came, stay.
    let writes = matches!(code, Some(0 | 1 | 3 | 5)) || interrupted;
    let is_new = |name: &PathBuf| before.iter().all(|(known, _)| known != name);
    let mut litter = Vec::new();
    for (name, _) in after.iter().filter(|(name, _)| is_new(name)) {
        let text = name.to_string_lossy();
        if !writes || text.contains(".texmap-") || text.ends_with(".part") {
            let mut what = String::new();
            let _ = write!(what, "{text} was left");
            litter.push(what);
        }
    }
    litter
}

/// True if a picture ends as it should, as far as its kind says so.
fn whole(bytes: &[u8]) -> bool {
    let kinds: [(&[u8], &[u8]); 3] = [
        (b"\x89PNG", b"IEND\xaeB\x60\x82"),
        (b"GIF8", b"\x3b"),
        (b"\xff\xd8", b"\xff\xd9"),
    ];
    let known = kinds.iter().find(|(first, _)| bytes.starts_with(first));
    bytes == OLD || known.is_none_or(|(_, last)| bytes.ends_with(last))
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
