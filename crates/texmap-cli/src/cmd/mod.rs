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

/// The ending that says in what format light is written.
fn ending(output: &std::path::Path) -> Result<&'static str, crate::failure::Failure> {
    let given = output.extension().and_then(|e| e.to_str()).unwrap_or("");
    ["png", "hdr", "exr"]
        .into_iter()
        .find(|known| given.eq_ignore_ascii_case(known))
        .ok_or_else(|| {
            crate::failure::Failure::usage(
                format!("-o {}: no format of light", output.display()),
                "name a .png, .hdr or .exr file",
            )
        })
}
