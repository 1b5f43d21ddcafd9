//! The truth, the failure cases and the demos.
mod budget;
mod cases;
mod demos;
mod plans;
mod program;
mod projections;
mod reflections;
mod scenes;
mod shadows;
mod truth;
