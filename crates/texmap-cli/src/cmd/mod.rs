//! The verbs, one module each: arguments and action.

use std::path::{Path, PathBuf};

use clap::Args;
use texmap_io::FileSource;

use crate::failure::Failure;

pub(crate) mod bake;
pub(crate) mod batch;
pub(crate) mod chart;
#[cfg(feature = "gpu-images")]
pub(crate) mod compress;
pub(crate) mod demo;
pub(crate) mod depth;
pub(crate) mod diff;
pub(crate) mod env;
pub(crate) mod hash;
pub(crate) mod info;
#[cfg(not(feature = "gpu-images"))]
pub(crate) mod left_out;
pub(crate) mod manual;
pub(crate) mod merge;
pub(crate) mod mip;
pub(crate) mod play;
pub(crate) mod render;
pub(crate) mod sample;
pub(crate) mod shards;
pub(crate) mod slice;
pub(crate) mod stability;
pub(crate) mod uv;
pub(crate) mod uv_raster;
pub(crate) mod warp;
pub(crate) mod written;

/// Folder that a verb which loads scenes is confined to.
#[derive(Args, Debug)]
pub(crate) struct Root {
    /// Read nothing outside of this folder, neither by `..` nor through links: for scenes of strangers. A model that `texmap render -` reads
    /// from standard input finds its files here
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
}

impl Root {
    pub(crate) fn folder(&self) -> Option<&Path> {
        self.root.as_deref()
    }

    /// Records what is read, for [`distinct`](crate::output::distinct): outputs must be none of it.
    pub(crate) fn files(&self) -> Result<FileSource, Failure> {
        let within = |folder: &PathBuf| FileSource::within(folder);
        let files = self.root.as_ref().map(within).transpose()?;
        Ok(files.unwrap_or_default().recording())
    }
}
