//! The web lab: texmap's applets and the walk through the room of the lecture, as one WebAssembly module for a Worker.
//!
//! A page sends a [`Request`] as JSON and gets an [`Answer`]: pictures, figures and warnings. The same requests run natively
//! (`cargo run --release --bin native`), which is how the hashes beside the pictures are made and tested.
//!
//! The module draws on the thread that calls it, with lanes of four where it was built for `simd128`.

mod answer;
mod aov;
mod baked_room;
mod camera;
mod charts;
mod compare;
mod draw;
mod edge;
mod footprint;
mod forward;
mod light_map;
mod load;
mod mapping;
mod module;
mod plot;
mod rectify;
mod request;
mod room;
mod shadow_map;
mod walk;

pub use answer::{Answer, Figure, Panel};
pub use load::Files;
pub use module::{Lab, RoomWalk};
pub use request::{Request, answer};
pub use room::{Input, Room};
pub use walk::{RECORDED, play};
