//! The command line. Each verb's arguments stand in its module under `cmd`.

use clap::{Parser, Subcommand};

use crate::{cmd, memory};

/// Textured scenes to pictures on the CPU, the same bytes on every machine.
#[derive(Debug, Parser)]
#[command(
    name = "texmap",
    version,
    propagate_version = true,
    max_term_width = 100
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    /// Memory for pictures, maps and meshes, such as 2G; default: three quarters of what the system grants; exit code 5 beyond it
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory::parse_size)]
    pub(crate) memory_limit: Option<u64>,
    /// Say nothing but errors on standard error
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Render(Box<cmd::render::RenderArgs>),
    Info(cmd::info::InfoArgs),
    Demo(cmd::demo::DemoArgs),
    Diff(cmd::diff::DiffArgs),
    Hash(cmd::hash::HashArgs),
    Uv(Box<cmd::uv::UvArgs>),
    UvRaster(cmd::uv_raster::UvRasterArgs),
    Warp(Box<cmd::warp::WarpArgs>),
    Sample(cmd::sample::SampleArgs),
    Mip(cmd::mip::MipArgs),
    Stability(cmd::stability::StabilityArgs),
    Chart(cmd::chart::ChartArgs),
    Env(cmd::env::EnvArgs),
    Bake(Box<cmd::bake::BakeArgs>),
    Slice(cmd::slice::SliceArgs),
    Play(cmd::play::PlayArgs),
    Completions(cmd::manual::CompletionsArgs),
    Man(cmd::manual::ManArgs),
}

impl Verb {
    /// True if the caller asked for JSON on standard output.
    pub(crate) fn json(&self) -> bool {
        match self {
            Self::Render(a) => a.json,
            Self::Info(a) => a.json,
            Self::Demo(a) => a.json,
            Self::Diff(a) => a.json,
            Self::Hash(a) => a.json,
            Self::Uv(a) => a.json,
            Self::UvRaster(a) => a.json,
            Self::Stability(a) => a.json,
            Self::Warp(a) => a.json,
            Self::Sample(a) => a.json,
            Self::Mip(a) => a.json,
            Self::Chart(a) => a.json,
            Self::Env(a) => a.json,
            Self::Bake(a) => a.json,
            Self::Slice(a) => a.json,
            Self::Play(_) | Self::Completions(_) | Self::Man(_) => false,
        }
    }
}
