//! Prints the list of hashes of this machine: `texmap-targets ASSETS DATA WORK [STEP]`, three folders of which the last takes what is written; with a
//! step only each so many-th of the random scenes of effects is drawn.

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use texmap_math::Level;
use texmap_targets::{Folders, hashes};

fn main() -> ExitCode {
    let mut arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let step = match arguments.len() {
        4 => arguments.pop().and_then(|step| step.to_str()?.parse().ok()),
        _ => Some(NonZeroUsize::MIN),
    };
    let (Ok([assets, data, work]), Some(step)) = (<[PathBuf; 3]>::try_from(arguments), step) else {
        eprintln!("texmap-targets ASSETS DATA WORK [STEP]");
        return ExitCode::from(2);
    };
    let level = Level::new();
    eprintln!("level {level:?}");
    match hashes(&Folders { assets, data, work }, level, step) {
        Ok(list) if std::io::stdout().write_all(list.as_bytes()).is_ok() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(4),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(4)
        }
    }
}
