//! The program from outside: arguments in, files, text and exit codes out.

mod demos;
mod files;
mod info;
mod lab;
mod light;
mod malformed;
mod program;
mod readme;
mod render;
mod report;
mod sampling;
