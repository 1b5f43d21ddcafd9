//! Attacks the program and prints what came of it, a table at the end.
//!
//! `cargo run -p texmap-tests --example attack -- [CASES] [SEED] [PROGRAM]`; one case again: `attack NUMBER.. SEED PROGRAM` with
//! two dots after its number.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a table is what it makes"
)]

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(unix)]
    return run();
    #[cfg(not(unix))]
    ExitCode::SUCCESS
}

#[cfg(unix)]
fn run() -> ExitCode {
    use std::path::PathBuf;
    use std::time::Duration;

    use texmap_tests::attack::{Finding, attack};

    let mut arguments = std::env::args().skip(1);
    let cases = arguments.next().unwrap_or_else(|| "3000".into());
    let seed = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(1);
    // The program of the test package stands beside the folder of the examples.
    let beside = std::env::current_exe()
        .ok()
        .and_then(|example| Some(example.parent()?.parent()?.join("texmap-tested")));
    let Some(program) = arguments.next().map(PathBuf::from).or(beside) else {
        eprintln!("no program: name it as the third argument");
        return ExitCode::FAILURE;
    };
    let number = |text: &str| text.parse::<u64>().ok();
    let range = match cases.strip_suffix("..").and_then(number) {
        Some(one) => one..one + 1,
        None => 0..number(&cases).unwrap_or(3000),
    };
    let told = |finding: &Finding| println!("{finding}");
    match attack(&program, seed, range, Duration::from_secs(10), told) {
        Ok(summary) => {
            print!("{summary}");
            if summary.findings.is_empty() {
                ExitCode::SUCCESS
            } else {
                ExitCode::FAILURE
            }
        }
        Err(error) => {
            eprintln!("{}: {error}", program.display());
            ExitCode::FAILURE
        }
    }
}
