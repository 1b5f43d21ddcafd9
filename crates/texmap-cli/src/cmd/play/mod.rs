//! `texmap play`: the web lab, served to a browser on this machine.

mod pages;
mod server;

use std::io::Write;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;

use clap::Args;

use crate::cmd::play::pages::Pages;
use crate::failure::{Exit, Failure, deliver};

/// The port that is tried first.
const PORT: u16 = 8017;

/// Serve the web lab on 127.0.0.1 and print its address: every applet of the lectures, a page for scenes of your own, and Purple Cow Doom.
#[derive(Args, Debug)]
#[command(
    after_help = "The pages are those in the program (built with feature web), else those in web/dist, which web/build makes.\n\
                  Open the address in a browser; Ctrl-C ends the server."
)]
pub(crate) struct PlayArgs {
    /// The folder that web/build made [default: the pages in the program, else web/dist]
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// The port, 0 for any that is free [default: 8017, or any if that is taken]
    #[arg(long, value_name = "N")]
    port: Option<u16>,
}

pub(crate) fn run(args: &PlayArgs) -> Result<Exit, Failure> {
    let pages = Pages::find(args.folder.as_deref())?;
    let bind = |port: u16| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let listener = match args.port {
        Some(port) => bind(port),
        None => bind(PORT).or_else(|_| bind(0)),
    };
    let listener = listener.and_then(|l| Ok((l.local_addr()?, l)));
    let (address, listener) = listener.map_err(|e| {
        Failure::new(
            Exit::Input,
            "no-port",
            format!("no port of 127.0.0.1 can be served: {e}"),
            "give another one with --port, or 0 for any that is free",
        )
    })?;
    deliver(|out| {
        writeln!(out, "http://{address}/")?;
        out.flush()
    })?;
    server::serve(&listener, &pages)
}
