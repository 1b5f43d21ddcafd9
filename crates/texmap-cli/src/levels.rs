//! Memory for the mip levels of images.

use std::path::Path;

use texmap_math::MemoryBudget;
use texmap_sample::{Filter, Texture2d};

use crate::failure::Failure;

/// Asks for the memory of the mip levels of an image before they are made.
pub(crate) fn ask_for_levels(texture: &Texture2d<'_>, image: &Path) -> Result<(), Failure> {
    MemoryBudget::of_process().ask(
        texture.bytes_to_prepare(Filter::Trilinear),
        format_args!("the mip levels of {}", image.display()),
        "take a smaller image",
    )?;
    Ok(())
}
