//! `texmap depth`: the depths that a light sees, as a picture and as an array.

use std::path::PathBuf;

use clap::Args;
use texmap_io::{LoadOptions, PixelCode, load, npy, write_pixels};
use texmap_light::{Light, ShadowKind, ShadowMap};
use texmap_render::shadow_map;
use texmap_sample::ColorSpace;
use texmap_scene::{Scene, shadow_kind};

use crate::cmd::Root;
use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure, Refusal, say};
use crate::formats;
use crate::output::{Destination, Stage, distinct};

/// Draw the depth map of a light: near surfaces light, far ones dark, and white where the light sees nothing
///
/// Depths are distances along the axis of a directional or spot light and distances from a point light, which has six faces +X -X +Y -Y +Z -Z
/// below each other. An array (.npy) holds them in units of the scene, infinity where the light sees nothing.
#[derive(Args, Debug)]
#[command(
    after_help = "A picture:  texmap depth room.scene --light lamp -o lamp.png\n\
                  An array:   texmap depth room.scene --light 1 --size 2048 -o lamp.npy"
)]
pub(crate) struct DepthArgs {
    /// The scene or model
    scene: PathBuf,
    /// The light, by its name or number from 0
    #[arg(long, value_name = "NAME|N")]
    light: String,
    /// Texels a side of a face
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=16_384))]
    size: u32,
    /// The file to write: .png, or .npy for an array
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    root: Root,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &DepthArgs) -> Result<Exit, Failure> {
    one_stdout(args.json, &args.output)?;
    distinct([&args.output], [&args.scene])?;
    let ending = formats::ending("-o", &args.output, &["png", "npy"])?;
    let files = args.root.files()?;
    let options = LoadOptions {
        files: files.clone(),
        ..LoadOptions::default()
    };
    let scene = load(&args.scene, &options)?;
    distinct([&args.output], files.recorded())?;
    let scene = texmap_mesh::tessellate(&scene, args.size).map_err(refused)?;
    let light = light(&scene, &args.light)?;
    let kind = shadow_kind(&scene, light, None).map_err(refused)?;
    let map = shadow_map(&scene, &kind, args.size, usize::MAX).map_err(refused)?;
    let mut written = Written::new("depth");
    for warning in &scene.warnings {
        written.say_warning(warning.clone());
    }
    let faces = match kind {
        ShadowKind::Point { .. } => 6,
        _ => 1,
    };
    let rows = faces * args.size;
    let depths: Vec<f32> = depths(&map, faces).collect();
    let destination = Destination::new(&args.output)?;
    let mut stage = Stage::new(&destination)?;
    let path = stage.add(destination, ending);
    let (near, far) = range(&depths);
    match ending {
        "npy" => {
            let shape = [rows as usize, args.size as usize];
            npy::write(&path, &shape, npy::Values::F32(&depths))?;
            written.array(&args.output, &shape);
        }
        _ => {
            let code = PixelCode::Png8(ColorSpace::Linear);
            write_pixels(&path, code, (args.size, rows), |out| {
                let row: Vec<u8> = depths
                    .iter()
                    .flat_map(|depth| {
                        let c = shade(*depth, near, far);
                        [c, c, c, 255]
                    })
                    .collect();
                out.write_all(&row)
            })?;
            written.picture(&args.output, (args.size, rows));
        }
    }
    stage.commit()?;
    let seen = depths.iter().filter(|d| d.is_finite()).count();
    say(&format!(
        "{}: {} x {rows} texels, {seen} on surfaces, depths {near} to {far}\n",
        args.output.display(),
        args.size,
    ));
    written.tell(args.json)
}

/// The depths of all faces, row by row.
fn depths(map: &ShadowMap, faces: u32) -> impl Iterator<Item = f32> {
    let size = map.size();
    let texels = (0..faces)
        .flat_map(move |f| (0..size).flat_map(move |y| (0..size).map(move |x| (f as usize, x, y))));
    texels.map(|(face, x, y)| map.depth_at(face, x, y).unwrap_or(f32::INFINITY))
}

/// The least and the greatest depth of a surface; 0 and 0 where there is none.
fn range(depths: &[f32]) -> (f32, f32) {
    let finite = || depths.iter().copied().filter(|d| d.is_finite());
    let near = finite().fold(f32::INFINITY, f32::min);
    let far = finite().fold(f32::NEG_INFINITY, f32::max);
    match near <= far {
        true => (near, far),
        false => (0.0, 0.0),
    }
}

/// Codes of the nearest and the farthest surface. White is left to the background.
const NEAREST: f32 = 232.0;
const FARTHEST: f32 = 24.0;

/// The code of a depth: evenly from light to dark, 255 where there is nothing.
fn shade(depth: f32, near: f32, far: f32) -> u8 {
    if !depth.is_finite() {
        return 255;
    }
    let part = if far > near {
        (depth - near) / (far - near)
    } else {
        0.0
    };
    (NEAREST + (FARTHEST - NEAREST) * part + 0.5) as u8
}

/// The index of a light that has a depth map.
fn light(scene: &Scene, text: &str) -> Result<usize, Failure> {
    let why = "name a light that has a place or a direction (`ld`, `lp`, `ls`), by a `name` line or its number from 0";
    let refused = |what: String| Failure::usage(what, why);
    let index = match text.parse::<usize>() {
        Ok(number) => number,
        Err(_) => scene
            .light_named(text)
            .map_err(|e| refused(format!("--light {text}: {e}")))?,
    };
    match scene.lights.get(index) {
        None => Err(refused(format!(
            "--light {text}: the scene has {} lights",
            scene.lights.len()
        ))),
        Some(Light::Ambient { .. }) => Err(refused(format!(
            "--light {text}: ambient light comes from nowhere and has no depth map"
        ))),
        Some(_) => Ok(index),
    }
}

fn refused(error: impl Into<Refusal>) -> Failure {
    Failure::of_render(error, None, "correct the scene, or choose another light")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_light_far_is_dark_and_nothing_is_white() {
        let depths = [2.0, 4.0, f32::INFINITY, 3.0];
        let (near, far) = range(&depths);
        assert_eq!((near, far), (2.0, 4.0));
        let codes = depths.map(|d| shade(d, near, far));
        assert_eq!(codes, [232, 24, 255, 128]);
        assert_eq!(range(&[f32::INFINITY]), (0.0, 0.0));
        assert_eq!(shade(5.0, 5.0, 5.0), 232);
    }
}
