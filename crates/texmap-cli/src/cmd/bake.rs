//! `texmap bake`: the light on a mesh as a light map.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::PathBuf;

use clap::Args;
use texmap_bake::{BakeOptions, Baker};
use texmap_io::{LoadOptions, load};
use texmap_light::{Light, ShadowBias, ShadowMap};
use texmap_render::{RenderError, shadow_map_for};
use texmap_scene::{Mesh, Scene, shadow_bias, shadow_kind};

use crate::cmd::Root;
use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure, Refusal, say};
use crate::formats;
use crate::observe;
use crate::os_name;
use crate::output::{Destination, Stage, distinct};

/// Bake the direct light that reaches an object, with shadows, onto its light-map coordinates.
#[derive(Args, Debug)]
#[command(
    after_help = "One mesh:   texmap bake room.scene --light --object floor --size 512 -o floor.exr\n\
                  All meshes: texmap bake room.scene --light --object all --size 256 -o 'maps/{object}.png'"
)]
pub(crate) struct BakeArgs {
    /// The scene or OBJ model
    scene: PathBuf,
    /// The mesh to bake, by its name in the scene (`name` line) or model, or all; a wrong name lists them
    #[arg(long, value_name = "NAME|all")]
    object: String,
    /// Bake the light of a white matte surface (the one thing that can be baked so far)
    #[arg(long, required = true)]
    light: bool,
    /// Texels a side
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16_384))]
    size: u32,
    /// The file to write; its ending (.png, .jpg, .webp, .hdr, .exr) sets the format. Several meshes: a name with {object}
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Texels by which islands are dilated: 1 for bilinear look-ups, 2^L for mips down to level L
    #[arg(long, value_name = "TEXELS", default_value_t = GUTTER, value_parser = clap::value_parser!(u32).range(0..=64))]
    gutter: u32,
    /// Texels a side of the shadow map of each light (of each face, for point lights); 0 for no shadows
    #[arg(long, value_name = "N", default_value_t = SHADOW_SIZE, value_parser = clap::value_parser!(u32).range(0..=16_384))]
    shadow_size: u32,
    /// Comparisons a side of the shadow filter, odd. Its bias is that of a `shadow` line that names none
    #[arg(long, value_name = "K", default_value_t = PCF_SIZE, value_parser = taps)]
    shadow_taps: u32,
    /// Leave this light out, by its name or number: one that moves (`texmap render --light-path`). Several times for several
    #[arg(long, value_name = "LIGHT")]
    except: Vec<String>,
    /// One luminance instead of three colours
    #[arg(long)]
    luminance: bool,
    #[command(flatten)]
    root: Root,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Texels a side of a shadow map, comparisons a side of its filter and texels of dilation where none are asked for.
pub(crate) const SHADOW_SIZE: u32 = 1024;
pub(crate) const PCF_SIZE: u32 = 3;
pub(crate) const GUTTER: u32 = 2;

/// Placeholder of a mesh name in the name of an output.
const OBJECT: &str = "{object}";

fn taps(text: &str) -> Result<u32, String> {
    let number = text.parse::<u32>().ok();
    number
        .filter(|n| n % 2 == 1 && *n <= 15)
        .ok_or_else(|| "expected an odd number, 1 to 15".to_owned())
}

pub(crate) fn run(args: &BakeArgs) -> Result<Exit, Failure> {
    one_stdout(args.json, &args.output)?;
    distinct([&args.output], [&args.scene])?;
    let format = formats::picture("-o", &args.output)?;
    let files = args.root.files()?;
    let options = LoadOptions {
        files: files.clone(),
        ..LoadOptions::default()
    };
    let scene = load(&args.scene, &options)?;
    observe::read(files.recorded());
    // Edges in pixels are measured by the light map's own size.
    let scene = texmap_mesh::tessellate(&scene, args.size).map_err(refused)?;
    let meshes = find(&scene, &args.object)?;
    let outputs = outputs(args, &scene, &meshes)?;
    distinct(&outputs, files.recorded())?;
    let mut written = Written::new("bake");
    let bare = |mesh: &&Mesh| args.object == "all" && !has_coordinates(mesh);
    for mesh in scene.meshes.iter().filter(bare) {
        written.say_warning(format!(
            "`{}` has no texture coordinates and is left out",
            mesh.name
        ));
    }
    for warning in &scene.warnings {
        written.say_warning(warning.clone());
    }
    let destinations = outputs.iter().map(|output| Destination::new(output));
    let destinations: Vec<Destination> = destinations.collect::<Result<_, _>>()?;
    let Some(first) = destinations.first() else {
        return Err(Failure::internal("no mesh to bake"));
    };
    let mut stage = Stage::new(first)?;
    let lights = lights(args, &scene)?;
    if lights.is_empty() {
        written.say_warning(
            "no light is baked, so that all is black: give the scene lights (`la`, `ld`, `lp`, `ls`), or leave out fewer".to_owned(),
        );
    }
    let shadows = shadows(args, &scene, &lights).map_err(refused)?;
    let baker = Baker::new(&scene).map_err(refused)?;
    let mut words = Vec::new();
    for ((mesh, output), destination) in meshes.iter().zip(&outputs).zip(destinations) {
        let name = &scene.meshes[*mesh].name;
        if scene.meshes[*mesh].lightmap_uvs.is_empty() {
            written.say_warning(format!(
                "`{name}` has no second uv set (a `lightmapuv` line): its texture coordinates are baked onto; where they overlap the first face wins"
            ));
        }
        let options = BakeOptions {
            size: args.size,
            gutter: args.gutter,
            shadows: &shadows,
            lights: Some(&lights),
        };
        let map = baker.bake(*mesh, &options).map_err(refused)?;
        let texels = if args.luminance {
            map.luminance().into_iter().map(|l| [l; 3]).collect()
        } else {
            map.texels
        };
        let path = stage.add(destination, format.ending());
        let lost = texmap_io::write_light(&path, map.size, map.size, &texels)?;
        let used = map
            .coverage
            .iter()
            .filter(|c| !matches!(c, texmap_raster::Coverage::None))
            .count();
        written.picture(output, (map.size, map.size));
        words.push((
            output,
            lost,
            format!(
                "{}: {} x {} texels, {used} in use, {} of {} faces without a texel\n",
                output.display(),
                map.size,
                map.size,
                map.lost.len(),
                scene.meshes[*mesh].triangles.len(),
            ),
        ));
    }
    stage.commit()?;
    for (output, lost, words) in words {
        say(&words);
        written.warn(formats::warn(output, format, lost));
    }
    written.tell(args.json)
}

fn refused(error: impl Into<Refusal>) -> Failure {
    Failure::of_render(error, None, "correct the scene, or bake another object")
}

/// Names of the objects that are baked.
pub(crate) fn objects(args: &BakeArgs) -> Result<Vec<String>, Failure> {
    let options = LoadOptions {
        files: args.root.files()?,
        ..LoadOptions::default()
    };
    let scene = load(&args.scene, &options)?;
    let scene = texmap_mesh::tessellate(&scene, args.size).map_err(refused)?;
    let meshes = find(&scene, &args.object)?;
    // Pages are told apart by the names of their files, each of which is named alone.
    let mut files = BTreeSet::new();
    outputs(args, &scene, &meshes)?;
    for mesh in &meshes {
        if !files.insert(outputs(args, &scene, &[*mesh])?) {
            let name = &scene.meshes[*mesh].name;
            return Err(Failure::usage(
                format!("the page of `{name}` would have the file of another object"),
                "give the objects names that differ in letters and digits (`name` lines of a scene, `o` lines of a model), or bake without --unit page",
            ));
        }
    }
    Ok(meshes
        .iter()
        .map(|mesh| scene.meshes[*mesh].name.clone())
        .collect())
}

const NO_COORDINATES: &str = "light maps lie on coordinates: give the faces some (`tf`, `lightmapuv`), or the model (`texmap uv`)";

/// True if the mesh has coordinates for a light map.
fn has_coordinates(mesh: &Mesh) -> bool {
    !(mesh.uvs.is_empty() && mesh.lightmap_uvs.is_empty())
}

/// The meshes of a name, or all that have triangles and coordinates.
fn find(scene: &Scene, name: &str) -> Result<Vec<usize>, Failure> {
    let meshes = scene.meshes.iter().enumerate();
    let named = |wanted: &dyn Fn(&Mesh) -> bool| -> Vec<usize> {
        meshes
            .clone()
            .filter(|(_, m)| wanted(m))
            .map(|(i, _)| i)
            .collect()
    };
    let exact = named(&|mesh| mesh.name == name);
    let all = exact.is_empty() && name == "all";
    let found = match all {
        true => named(&|mesh| !mesh.triangles.is_empty() && has_coordinates(mesh)),
        false => exact,
    };
    match found[..] {
        [mesh] if !has_coordinates(&scene.meshes[mesh]) => Err(Failure::new(
            Exit::Input,
            "render-missing-uv",
            format!("--object {name}: the mesh has no texture coordinates"),
            NO_COORDINATES,
        )),
        [_] => Ok(found),
        [] if all => Err(Failure::new(
            Exit::Input,
            "render-missing-uv",
            "--object all: no mesh has texture coordinates",
            NO_COORDINATES,
        )),
        [] => {
            let mut names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
            names.dedup();
            Err(Failure::usage(
                format!("--object {name}: no mesh of this name"),
                format!("choose from {}, or all", names.join(", ")),
            ))
        }
        _ if all => Ok(found),
        _ => Err(Failure::usage(
            format!("--object {name}: {} meshes have this name", found.len()),
            "give the objects different names (`name` lines of a scene, `o` lines of a model), or other materials their own",
        )),
    }
}

/// The files of the meshes.
fn outputs(args: &BakeArgs, scene: &Scene, meshes: &[usize]) -> Result<Vec<PathBuf>, Failure> {
    let template = args.output.as_os_str();
    let text = args.output.to_string_lossy();
    if meshes.len() > 1 && !text.contains(OBJECT) {
        return Err(Failure::usage(
            format!("{} meshes and one output {text}", meshes.len()),
            "put {object} into the name: -o 'maps/{object}.png'",
        ));
    }
    let named = meshes.iter().map(|m| (*m, scene.meshes[*m].name.as_str()));
    let objects = file_parts(named);
    let name = |object: &String| os_name::replaced(template, OBJECT, OsStr::new(object)).into();
    Ok(objects.iter().map(name).collect())
}

/// Replacements of `{object}` in the names of the files of meshes, given by number and name: no two are equal.
fn file_parts<'a>(meshes: impl Iterator<Item = (usize, &'a str)>) -> Vec<String> {
    // Names of faces without a `name` line hold paths and colons.
    let letter = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '_'
        }
    };
    let mut used = BTreeSet::new();
    let parts = meshes.map(|(mesh, name)| {
        let plain: String = name.chars().map(letter).collect();
        let mut part = plain.clone();
        // A mesh may be called as another would be numbered.
        let mut numbers = mesh..;
        while !used.insert(part.clone()) {
            part = format!("{plain}-{}", numbers.next().unwrap_or(mesh));
        }
        part
    });
    parts.collect()
}

/// The lights that are baked.
fn lights(args: &BakeArgs, scene: &Scene) -> Result<Vec<usize>, Failure> {
    let count = scene.lights.len();
    let mut left_out = Vec::new();
    for name in &args.except {
        let index = match name.parse::<usize>() {
            Ok(number) if number < count => number,
            Ok(_) => {
                return Err(Failure::usage(
                    format!("--except {name}: the scene has {count} lights"),
                    "lights are numbered from 0",
                ));
            }
            Err(_) => scene.light_named(name).map_err(|e| {
                Failure::usage(
                    format!("--except {name}: {e}"),
                    "give a light a name by a `name` line, or its number from 0",
                )
            })?,
        };
        left_out.push(index);
    }
    Ok((0..count).filter(|i| !left_out.contains(i)).collect())
}

/// A shadow map with the index of its light, its bias and its comparisons a side.
type LightShadow = (usize, ShadowMap, ShadowBias, u32);

/// A shadow map for each light that may have one.
fn shadows(
    args: &BakeArgs,
    scene: &Scene,
    lights: &[usize],
) -> Result<Vec<LightShadow>, RenderError> {
    let mut shadows = Vec::new();
    for index in lights.iter().copied() {
        let light = &scene.lights[index];
        if args.shadow_size > 0 && !matches!(light, Light::Ambient { .. }) {
            let kind = shadow_kind(scene, index, None)?;
            let (bias, taps) = (shadow_bias(scene), args.shadow_taps);
            let map = shadow_map_for(scene, &kind, args.shadow_size, bias, taps, usize::MAX)?;
            shadows.push((index, map, bias, taps));
        }
    }
    Ok(shadows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_have_files_of_their_own() {
        let parts = |names: &[&str]| file_parts(names.iter().copied().enumerate());
        assert_eq!(parts(&["a", "b"]), ["a", "b"]);
        assert_eq!(parts(&["a b", "a:b", "a/b"]), ["a_b", "a_b-1", "a_b-2"]);
        assert_eq!(parts(&["a-2", "a", "a"]), ["a-2", "a", "a-3"]);
        assert_eq!(parts(&["a", "a", "a-1"]), ["a", "a-1", "a-1-2"]);
    }
}
