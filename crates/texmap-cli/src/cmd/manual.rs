//! `texmap completions` and `texmap man`: shell completions and manual pages, made from the arguments.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::args::Cli;
use crate::failure::{Exit, Failure, deliver, say};
use crate::output::{Destination, Stage, distinct};

/// Print the completions of a shell.
#[derive(Args, Debug)]
#[command(
    after_help = "bash: texmap completions bash > ~/.local/share/bash-completion/completions/texmap\n\
                  zsh:  texmap completions zsh > ~/.zfunc/_texmap\n\
                  fish: texmap completions fish > ~/.config/fish/completions/texmap.fish"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Print the manual page of the program, or write those of all commands into a folder.
#[derive(Args, Debug)]
#[command(
    after_help = "Read it:    texmap man | man -l -\nInstall it: texmap man -o ~/.local/share/man/man1"
)]
pub(crate) struct ManArgs {
    /// A folder for texmap.1 and a page of each command: texmap-render.1, texmap-batch-render.1 and so on
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

pub(crate) fn completions(args: &CompletionsArgs) -> Result<Exit, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "texmap", &mut text);
    deliver(|out| std::io::Write::write_all(out, &text))?;
    Ok(Exit::Done)
}

pub(crate) fn man(args: &ManArgs) -> Result<Exit, Failure> {
    let mut command = Cli::command();
    command.build();
    let Some(folder) = &args.output else {
        let text = page(command)?;
        deliver(|out| std::io::Write::write_all(out, &text))?;
        return Ok(Exit::Done);
    };
    let mut pages = Vec::new();
    add_pages(&command, "texmap", &mut pages)?;
    let names: Vec<PathBuf> = pages.iter().map(|(name, _)| folder.join(name)).collect();
    distinct(&names, [] as [&PathBuf; 0])?;
    let mut stage: Option<Stage> = None;
    for (path, (_, text)) in names.iter().zip(&pages) {
        let destination = Destination::new(path)?;
        let stage = match &mut stage {
            Some(stage) => stage,
            None => stage.insert(Stage::new(&destination)?),
        };
        let place = stage.add(destination, "1");
        std::fs::write(&place, text).map_err(|e| {
            let what = format!("{}: cannot be written: {e}", path.display());
            Failure::new(Exit::Input, "write-failed", what, "check the free space")
        })?;
    }
    if let Some(stage) = stage {
        stage.commit()?;
    }
    say(&format!("{}: {} pages\n", folder.display(), pages.len()));
    Ok(Exit::Done)
}

/// The page of a command and those of the commands below it: texmap.1, texmap-batch.1, texmap-batch-render.1.
fn add_pages(
    command: &clap::Command,
    name: &str,
    pages: &mut Vec<(String, Vec<u8>)>,
) -> Result<(), Failure> {
    pages.push((format!("{name}.1"), page(command.clone())?));
    for verb in command
        .get_subcommands()
        .filter(|c| c.get_name() != "help" && !c.is_hide_set())
    {
        add_pages(verb, &format!("{name}-{}", verb.get_name()), pages)?;
    }
    Ok(())
}

fn page(command: clap::Command) -> Result<Vec<u8>, Failure> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command)
        .render(&mut text)
        .map_err(|e| Failure::internal(format!("the manual page could not be made: {e}")))?;
    Ok(text)
}
