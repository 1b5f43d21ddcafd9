//! `texmap bake`: the light on a mesh as a light map.

use crate::failure::Refusal;
use std::path::PathBuf;

use clap::Args;
use texmap_bake::{BakeOptions, LightMap, bake};
use texmap_io::{LoadOptions, load};
use texmap_light::Light;
use texmap_render::{RenderError, shadow_map_for};
use texmap_scene::{Scene, shadow_bias, shadow_kind};

use crate::cmd::Root;
use crate::failure::{Exit, Failure, say};
use crate::formats;
use crate::output::{Destination, Stage, distinct};

/// Bake the direct light that reaches an object, with shadows, onto its light-map coordinates.
#[derive(Args, Debug)]
pub(crate) struct BakeArgs {
    /// The scene or OBJ model
    scene: PathBuf,
    /// The mesh to bake; a wrong name lists them
    #[arg(long, value_name = "NAME")]
    object: String,
    /// Bake the light of a white matte surface (the one thing that can be baked so far)
    #[arg(long, required = true)]
    light: bool,
    /// Texels a side
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16_384))]
    size: u32,
    /// The file to write; its ending (.png, .hdr, .exr) says what it becomes
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Texels by which charts are dilated: 1 for bilinear look-ups, 2^L for mips down to level L
    #[arg(long, value_name = "TEXELS", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=64))]
    gutter: u32,
    /// Texels a side of the shadow map of each light (of each face, for point lights); 0 for no shadows
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(0..=16_384))]
    shadow_size: u32,
    /// Comparisons a side of the shadow filter, odd. Its bias is that of a `shadow` line that names none
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=15))]
    shadow_taps: u32,
    /// One luminance in place of three colours
    #[arg(long)]
    luminance: bool,
    #[command(flatten)]
    root: Root,
}

pub(crate) fn run(args: &BakeArgs) -> Result<Exit, Failure> {
    distinct([&args.output], [&args.scene])?;
    let destination = Destination::new(&args.output)?;
    let format = formats::picture(&args.output)?;
    let scene = load(
        &args.scene,
        &LoadOptions {
            files: args.root.files()?,
            ..LoadOptions::default()
        },
    )?;
    fn refused(error: impl Into<Refusal>) -> Failure {
        Failure::of_render(error, None, "mend the scene, or bake another object")
    }
    // Edges in pixels are measured by the light map's own size.
    let scene = texmap_mesh::tessellate(&scene, args.size).map_err(refused)?;
    let mesh = find(&scene, &args.object)?;
    for warning in &scene.warnings {
        say(&format!("warning: {warning}\n"));
    }
    if scene.meshes[mesh].lightmap_uvs.is_empty() {
        say(&format!(
            "warning: `{}` has no second uv set (a `lightmapuv` line): its texture coordinates are baked onto; where they overlap the first face wins\n",
            args.object
        ));
    }
    let map = baked(args, &scene, mesh).map_err(refused)?;
    let texels = if args.luminance {
        map.luminance().into_iter().map(|l| [l; 3]).collect()
    } else {
        map.texels
    };
    let mut stage = Stage::new(&destination)?;
    let path = stage.add(destination, format.ending());
    let lost = texmap_io::write_light(&path, map.size, map.size, &texels)?;
    stage.commit()?;
    let used = map
        .coverage
        .iter()
        .filter(|c| !matches!(c, texmap_raster::Coverage::None))
        .count();
    say(&format!(
        "{}: {} x {} texels, {used} in use, {} of {} faces without a texel\n",
        args.output.display(),
        map.size,
        map.size,
        map.lost.len(),
        scene.meshes[mesh].triangles.len(),
    ));
    formats::warn(&args.output, format, lost);
    Ok(Exit::Done)
}

fn find(scene: &Scene, name: &str) -> Result<usize, Failure> {
    let all: Vec<usize> = (0..scene.meshes.len())
        .filter(|i| scene.meshes[*i].name == name)
        .collect();
    match all[..] {
        [one] => Ok(one),
        [] => {
            let mut names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
            names.dedup();
            Err(Failure::usage(
                format!("--object {name}: no mesh of this name"),
                format!("choose from {}", names.join(", ")),
            ))
        }
        _ => Err(Failure::usage(
            format!("--object {name}: {} meshes have this name", all.len()),
            "give the objects of the model different names (`o` lines), or other materials their own",
        )),
    }
}

fn baked(args: &BakeArgs, scene: &Scene, mesh: usize) -> Result<LightMap, RenderError> {
    let mut shadows = Vec::new();
    for (index, light) in scene.lights.iter().enumerate() {
        if args.shadow_size > 0 && !matches!(light, Light::Ambient { .. }) {
            let kind = shadow_kind(scene, index, None)?;
            let (bias, taps) = (shadow_bias(scene), args.shadow_taps);
            let map = shadow_map_for(scene, &kind, args.shadow_size, bias, taps, usize::MAX)?;
            shadows.push((index, map, bias, taps));
        }
    }
    let options = BakeOptions {
        size: args.size,
        gutter: args.gutter,
        shadows: &shadows,
        lights: None,
    };
    bake(scene, mesh, &options)
}
