//! Laws and regressions of whole frames.

mod aov;
mod bench_scenes;
mod blend;
mod bytes;
mod classics;
mod color;
mod cutout;
mod degenerate;
mod effects;
mod errors;
mod floor;
mod gouraud;
mod light;
mod metallic;
mod packed;
mod parallel;
mod reliefs;
mod round;
mod samples;
mod scenes;
mod shapes;
mod spheres;
mod stages;
mod targets;
mod texture_frame;
mod views;
