//! The program from outside: arguments in, files, text and exit codes out.

#[cfg(unix)]
mod attack;
mod demos;
mod files;
#[cfg(unix)]
mod hostile;
mod info;
mod lab;
mod light;
mod malformed;
mod program;
mod readme;
mod render;
mod report;
mod sampling;
