//! Memory for all that look-ups in an image read beside its texels.

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

/// Asks for the memory of all that a filter reads of an image before it is made.
pub(crate) fn ask_to_prepare(
    texture: &Texture2d<'_>,
    filter: Filter,
    image: &Path,
) -> Result<(), Failure> {
    MemoryBudget::of_process().ask(
        texture.bytes_to_prepare(filter),
        format_args!("what the filter reads of {}", image.display()),
        "take a smaller image, or a filter that reads one level",
    )?;
    Ok(())
}
