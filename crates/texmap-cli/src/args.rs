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

const BATCH: &str = "\
A folder of models:  texmap batch models/*.obj -o 'out/{model}.png' --resolution 512x512
Again after a stop:  texmap batch models/*.obj -o 'out/{model}.png' --resolution 512x512 --resume
One of eight tasks:  texmap batch @all.txt -o out/ --shard 3/8
A task of an array:  texmap batch @all.txt -o out/ --shard auto --shard-count 8
A picture in bands:  texmap batch big.scene -o out/big.png --resolution 16384x16384 --bands 8, then texmap merge out -o out
The verb is render if none is named. docs/batch.md tells of manifests, engines and exit codes.";

const SHARDS: &str = "\
Slurm:        texmap shards @all.txt -o 'out/{model}.png' --count 8 --emit slurm > job.sh && sbatch job.sh
HyperQueue:   texmap shards @all.txt -o out/ --count 8 --emit hyperqueue | sh
GNU parallel: texmap shards @all.txt -o out/ --count 8 --emit commands | parallel --joblog log --resume-failed
Then:         texmap merge out -o out";

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
    #[cfg(feature = "gpu-images")]
    Compress(cmd::compress::CompressArgs),
    #[cfg(not(feature = "gpu-images"))]
    #[command(hide = true)]
    Compress(cmd::left_out::CompressArgs),
    Stability(cmd::stability::StabilityArgs),
    Chart(cmd::chart::ChartArgs),
    Env(cmd::env::EnvArgs),
    Bake(Box<cmd::bake::BakeArgs>),
    Depth(cmd::depth::DepthArgs),
    Slice(cmd::slice::SliceArgs),
    /// Run a verb over many items: on all cores, in shards on many machines, and again from where it ended
    #[command(after_help = BATCH)]
    Batch(cmd::batch::BatchArgs),
    Merge(cmd::merge::MergeArgs),
    /// Cut a batch into tasks, with their memory and time, and print them for an engine to submit
    #[command(after_help = SHARDS)]
    Shards(cmd::shards::ShardsArgs),
    #[command(hide = true)]
    BatchWorker(cmd::batch::worker::WorkerArgs),
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
            #[cfg(feature = "gpu-images")]
            Self::Compress(a) => a.json,
            #[cfg(not(feature = "gpu-images"))]
            Self::Compress(_) => false,
            Self::Chart(a) => a.json,
            Self::Env(a) => a.json,
            Self::Bake(a) => a.json,
            Self::Depth(a) => a.json,
            Self::Slice(a) => a.json,
            Self::Batch(a) => a.json,
            Self::Merge(a) => a.json,
            Self::Shards(a) => a.batch.json,
            Self::BatchWorker(_) | Self::Play(_) | Self::Completions(_) | Self::Man(_) => false,
        }
    }
}
