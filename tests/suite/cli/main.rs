//! The program from outside: arguments in, files, text and exit codes out.

#[cfg(unix)]
mod attack;
mod batch;
mod cameras;
mod demos;
mod files;
#[cfg(unix)]
mod hostile;
mod info;
mod interruption;
mod lab;
mod light;
mod looks;
mod malformed;
mod memory;
mod model_light;
mod outputs;
mod program;
mod readme;
mod render;
mod report;
mod sampling;
mod systems;
