//! One module per verb: its arguments and what it does.

pub(crate) mod bake;
pub(crate) mod chart;
pub(crate) mod demo;
pub(crate) mod diff;
pub(crate) mod env;
pub(crate) mod hash;
pub(crate) mod info;
pub(crate) mod mip;
pub(crate) mod render;
pub(crate) mod sample;
pub(crate) mod slice;
pub(crate) mod stability;
pub(crate) mod uv;
pub(crate) mod uv_raster;
pub(crate) mod warp;
