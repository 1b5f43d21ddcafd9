//! Prints the list of hashes of this machine: `texmap-targets ASSETS DATA WORK`, three folders of which the last takes what is written.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use texmap_math::Level;
use texmap_targets::{Folders, hashes};

fn main() -> ExitCode {
    let folders: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let Ok([assets, data, work]) = <[PathBuf; 3]>::try_from(folders) else {
        eprintln!("texmap-targets ASSETS DATA WORK");
        return ExitCode::from(2);
    };
    let level = Level::new();
    eprintln!("level {level:?}");
    match hashes(&Folders { assets, data, work }, level) {
        Ok(list) if std::io::stdout().write_all(list.as_bytes()).is_ok() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(4),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(4)
        }
    }
}
