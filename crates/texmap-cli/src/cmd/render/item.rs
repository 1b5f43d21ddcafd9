//! One input: load it, set the cameras, draw all of its pictures.

use std::cell::RefCell;
use std::path::Path;
use std::time::Instant;

use texmap_bake::MovingLight;
use texmap_io::scene_file::Missing;
use texmap_io::{AnimationFormat, FileSource, LoadOptions, PictureFormat};
use texmap_math::Level;
use texmap_scene::{Scene, SceneError};

use crate::cmd::bake::{GUTTER, PCF_SIZE, SHADOW_SIZE};
use crate::cmd::render::RenderArgs;
use crate::cmd::render::camera::{CameraFiles, is_animated, is_scene, moving, shots};
use crate::cmd::render::draw::Context;
use crate::cmd::render::light::Lit;
use crate::cmd::render::plan::{Item, Kind};
use crate::cmd::render::report::{ItemReport, milliseconds};
use crate::failure::Failure;
use crate::observe;
use crate::output::distinct;
use crate::values::Background;

/// Draws all pictures of one input: a picture, a contact sheet, a series or an animation. The input is read from `file`.
pub(crate) fn item(
    args: &RenderArgs,
    item: &Item,
    file: &Path,
    level: Level,
    cameras: &CameraFiles,
    files: &FileSource,
) -> Result<Vec<ItemReport>, Failure> {
    let began = Instant::now();
    let scene_file = is_scene(file);
    // The files of this input alone.
    let files = &files.clone().recording();
    let options = options(args, file, files);
    let rootless = file != item.input && args.root.folder().is_none();
    let floats = item.pictures().into_iter().any(|path| {
        matches!(
            PictureFormat::of(path),
            Some(PictureFormat::Hdr | PictureFormat::Exr)
        )
    });
    let up = options.framing.up;
    let lit = Lit {
        scene_file,
        floats,
        behind: args.background == Some(Background::Env),
        up,
    };
    if args.camera.times(0.0).is_some() && !is_animated(file) {
        return Err(Failure::usage(
            format!("--frames: {} has no animation", item.input.display()),
            "give the pictures a --path or a --light-path, or --turntable N instead of --frames",
        ));
    }
    let prepared = |options: &LoadOptions| prepared(args, file, rootless, options, &lit);
    let mut scene = prepared(&options)?;
    // No picture replaces what it is made of.
    distinct(item.files(args).into_iter().flatten(), files.recorded())?;
    observe::read(files.recorded());
    let load = milliseconds(began.elapsed());
    let posed = |time| {
        prepared(&LoadOptions {
            time: Some(time),
            ..options.clone()
        })
    };
    let sampled = args.supersample.is_some() || args.budget().is_some();
    let context = Context {
        args,
        item,
        level,
        msaa: match args.msaa {
            Some(samples) => samples,
            None if scene_file || sampled => 1,
            None => 4,
        },
        placed: !scene_file && args.camera.is_placed(),
        load,
        up,
        posed: &posed,
        moving: match args.camera.light_path {
            Some(_) => {
                let light = moving(&args.camera, &scene)?;
                let baked = MovingLight::new(&scene, light, SHADOW_SIZE, PCF_SIZE, GUTTER);
                Some(baked.map_err(refused_map)?)
            }
            None => None,
        },
        environment_shadows: RefCell::default(),
        told: RefCell::default(),
    };
    let mut shots = shots(args, file, &scene, cameras, posed)?;
    context.ground(&mut scene)?;
    for shot in &mut shots {
        shot.camera = context.holding_ground(&scene, shot.camera);
    }
    // Everything is checked before the first pixel: the scene once, the camera of every picture.
    let warnings = scene.check().map_err(|e| context.refused(e))?;
    context.aovs(&scene)?;
    for shot in &shots {
        let view = shot.camera.view();
        view.map_err(|e| context.refused(SceneError::Camera(e)))?;
    }
    if item.kind == Kind::Animation(AnimationFormat::Gif) && args.camera.rate > 50.0 {
        let rate = args.camera.rate;
        scene.warnings.push(format!(
            "--rate {rate}: viewers show a GIF at 50 pictures a second at most, with which it is written; end the name with .apng"
        ));
    }
    if args.dry_run || args.strict {
        let mut all = scene.warnings.clone();
        all.extend(warnings.clone());
        context.strict(&all)?;
    }
    if args.dry_run {
        scene.warnings.extend(warnings);
    }
    match &item.kind {
        Kind::Sheet => Ok(vec![context.sheet(&mut scene, &shots)?]),
        Kind::Animation(format) => Ok(vec![context.animation(&mut scene, &shots, *format)?]),
        Kind::Single => {
            if let Some(shot) = shots.first() {
                scene.camera = shot.camera;
            }
            Ok(vec![context.picture(&scene, item.output.clone(), None)?])
        }
        Kind::Series(names) => {
            let all = shots.iter().zip(names).zip(0..);
            let wanted = all.filter(|(_, number)| match &args.only {
                None => true,
                Some(only) => only.contains(u64::from(*number)),
            });
            let pictures = wanted.map(|((shot, name), number)| {
                context.set(&mut scene, shot)?;
                let place = Some((number, shots.len(), shot));
                let report = context.picture(&scene, name.clone(), place)?;
                if args.only.is_some() {
                    observe::picture(&report);
                }
                Ok(report)
            });
            pictures.collect()
        }
    }
}

/// The scene or model of a file as it is drawn: dressed and lit.
fn prepared(
    args: &RenderArgs,
    file: &Path,
    rootless: bool,
    options: &LoadOptions,
    lit: &Lit,
) -> Result<Scene, Failure> {
    let kept = lit.scene_file || args.budget().is_some();
    let mut scene = load(file, rootless, options)?;
    if let Some(Background::Color(color)) = args.background {
        scene.background = color;
    }
    args.light.shade(&mut scene, kept);
    args.look.dress(&mut scene)?;
    args.light.light(&mut scene, lit)?;
    Ok(scene)
}

fn refused_map(error: texmap_render::RenderError) -> Failure {
    let why = "bake the light maps without the light that moves: texmap bake --except LIGHT";
    Failure::of_render(error, None, why)
}

/// The options that an input is loaded with.
fn options(args: &RenderArgs, file: &Path, files: &FileSource) -> LoadOptions {
    let size = args.resolution;
    let checker = (!is_scene(file)).then_some(Missing::Checker);
    LoadOptions {
        aspect: f64::from(size.width) / f64::from(size.height),
        framing: args.camera.framing(file),
        missing: args.look.missing.or(checker),
        color: args.color,
        files: files.clone(),
        camera: args.camera.named.clone(),
        time: args.time,
        animation: args.animation.clone(),
    }
}

/// Refuses pictures of one input that others are made of, before the first is written. An input that cannot be loaded is
/// not drawn either, and says so later.
pub(super) fn keep_apart(
    args: &RenderArgs,
    items: &[(&Item, (&Path, &FileSource))],
) -> Result<(), Failure> {
    let mut outputs = Vec::new();
    for (item, _) in items {
        outputs.extend(item.files(args).into_iter().flatten());
    }
    // Outputs that do not exist yet are read by none.
    outputs.retain(|output| output.is_file());
    if items.len() < 2 || outputs.is_empty() {
        return Ok(());
    }
    let mut read = Vec::new();
    for (_, (file, files)) in items {
        let files = (*files).clone().recording();
        let _ = load(file, false, &options(args, file, &files));
        read.extend(files.recorded());
    }
    distinct(outputs, read)
}

/// Loads a file. If one from standard input names others, and no folder for them is given, a warning or the error says how to give it.
fn load(file: &Path, rootless: bool, options: &LoadOptions) -> Result<Scene, Failure> {
    let hint = "standard input has no folder; the files that it names are looked for in that of --root DIR";
    let mut scene = texmap_io::load(file, options).map_err(|error| {
        let failure = Failure::from(error);
        match rootless && failure.code == "file-missing" {
            true => Failure {
                why: hint.into(),
                ..failure
            },
            false => failure,
        }
    })?;
    let lost = |warning: &String| warning.contains("no such file");
    if rootless && scene.warnings.iter().any(lost) {
        scene.warnings.push(hint.into());
    }
    Ok(scene)
}
