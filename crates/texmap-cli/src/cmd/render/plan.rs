//! Inputs and their output files; checks of everything that can be refused before a scene is read.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use texmap_io::{AnimationFormat, PictureFormat};
use texmap_raster::TILE;
use texmap_scene::Scene;

use crate::cmd::render::RenderArgs;
use crate::failure::Failure;
use crate::formats::{self, Output};
use crate::os_name;
use crate::output::{Destination, Stage, distinct};

/// One input and its outputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    pub(crate) input: PathBuf,
    /// None in a dry run without `-o`.
    pub(crate) output: Option<PathBuf>,
    pub(crate) kind: Kind,
}

/// Files of the pictures of an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One picture.
    Single,
    /// All on one captioned sheet.
    Sheet,
    /// One file each: their names, none in a dry run without `-o`.
    Series(Vec<Option<PathBuf>>),
    /// All in one file.
    Animation(AnimationFormat),
}

impl Item {
    /// The files of its pictures.
    pub(super) fn pictures(&self) -> Vec<&Path> {
        match &self.kind {
            Kind::Series(names) => names.iter().flatten().map(PathBuf::as_path).collect(),
            _ => self.output.iter().map(PathBuf::as_path).collect(),
        }
    }

    /// Its files by picture: the picture, and what lies beside it.
    pub(crate) fn files(&self, args: &RenderArgs) -> Vec<Vec<PathBuf>> {
        let pictures = self.pictures().into_iter();
        pictures.map(|picture| files(args, picture)).collect()
    }
}

/// The name of frame `n`, if the name has a number field such as `%04d`.
pub(crate) fn numbered(output: &Path, n: u32) -> Option<PathBuf> {
    let name = os_name::bytes(output.as_os_str());
    let place = find_counter(&name)?;
    let number = format!("{n:0width$}", width = place.width);
    let parts = [&name[..place.start], number.as_bytes(), &name[place.end..]];
    Some(os_name::of_bytes(parts.concat()).into())
}

/// Names all outputs and checks them: endings, numbers, duplicates, and that each can be written. `shots` are the names of the pictures of
/// each input, if there are several; `read` are lists that were read.
pub(crate) fn items(
    args: &RenderArgs,
    inputs: &[PathBuf],
    read: &[PathBuf],
    shots: Option<&[Option<String>]>,
) -> Result<Vec<Item>, Failure> {
    let mut items = name(inputs, args.output.as_deref())?;
    for item in &mut items {
        item.kind = kind(args, item.output.as_deref(), shots)?;
    }
    let mut outputs = Vec::new();
    let mut owner: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    for item in &items {
        let Some(output) = &item.output else { continue };
        check_stdout(args, &item.kind, output)?;
        if let Some(other) = owner.insert(output.clone(), item.input.clone()) {
            return Err(Failure::usage(
                format!(
                    "{} and {} would both write {}",
                    other.display(),
                    item.input.display(),
                    output.display()
                ),
                "put {model} into the name, or render inputs of one name separately",
            ));
        }
        let mine = destinations(args, item)?;
        if let Some((_, destination)) = mine.first() {
            Stage::new(destination)?;
        }
        outputs.extend(mine.into_iter().map(|(path, _)| path));
    }
    let read = inputs.iter().chain(read).chain(&args.camera.path);
    let read = read.chain(&args.camera.light_path);
    let read = read.chain(&args.camera.cameras).chain(&args.look.texture);
    let read = read.map(PathBuf::as_path).chain(args.light.picture());
    distinct(outputs, read)?;
    Ok(items)
}

/// Every file that an input will give, checked.
fn destinations(args: &RenderArgs, item: &Item) -> Result<Vec<(PathBuf, Destination)>, Failure> {
    let all = item.files(args).into_iter().flatten();
    all.map(|path| {
        let destination = Destination::new(&path)?;
        Ok((path, destination))
    })
    .collect()
}

/// A picture and what lies beside it.
fn files(args: &RenderArgs, picture: &Path) -> Vec<PathBuf> {
    let layers = PictureFormat::of(picture) == Some(PictureFormat::Exr);
    let beside = args.aov.iter().filter(|_| !layers);
    let arrays = beside.map(|aov| array_name(picture, &aov.name));
    let heat = args.verify.then(|| heat_name(picture));
    let rays = args.compare.map(|_| rays_name(picture));
    let all = [picture.to_owned()].into_iter().chain(arrays);
    all.chain(heat).chain(rays).collect()
}

/// `room.png` and `uv` give `room.uv.npy`.
pub(crate) fn array_name(picture: &Path, aov: &str) -> PathBuf {
    picture.with_extension(format!("{aov}.npy"))
}

/// `room.png` gives `room.heat.png`, the map of its errors.
pub(crate) fn heat_name(picture: &Path) -> PathBuf {
    picture.with_extension("heat.png")
}

/// `room.png` gives `room.rays.png`, the picture by mirror rays.
pub(crate) fn rays_name(picture: &Path) -> PathBuf {
    picture.with_extension("rays.png")
}

/// Estimate of the bytes in use while one picture is drawn: program, scene, frame and its file, arrays.
pub(crate) fn memory(args: &RenderArgs, scene: &Scene) -> u64 {
    const PROGRAM: u64 = 10_000_000;
    // Clip positions, planes and bins.
    const TRIANGLE: u64 = 1000;
    let size = |len: usize, each: usize| (len * each) as u64;
    let meshes = scene.meshes.iter().map(|m| {
        size(
            m.positions.len() + m.normals.len() + m.colors.len() + m.triangles.len(),
            12,
        ) + size(m.uvs.len(), 8)
            + size(m.faces.len(), 4)
    });
    // Four bytes a texel and a third more for the mip chain.
    let textures = scene
        .textures
        .iter()
        .map(|t| u64::from(t.width()) * u64::from(t.height()) * 16 / 3);
    let height = u64::from(args.resolution.height);
    let height = args.band.map_or(height, |band| {
        let rows = band.of(height.div_ceil(u64::from(TILE)));
        (rows.end - rows.start) * u64::from(TILE)
    });
    let pixels = u64::from(args.resolution.width) * height;
    let arrays: usize = args.aov.iter().map(|a| 4 * a.channels()).sum();
    let pictures = args.camera.views.len().max(1) as u64;
    let triangles: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
    PROGRAM
        + meshes.sum::<u64>()
        + triangles as u64 * TRIANGLE
        + textures.sum::<u64>()
        + pixels * (8 * pictures + arrays as u64)
}

/// Placeholders in the name of an output: name of the input, its folder, number and name of a picture.
const MODEL: &str = "{model}";
const DIR: &str = "{dir}";
const NUMBER: &str = "{n}";
const VIEW: &str = "{view}";

pub(crate) fn name(inputs: &[PathBuf], output: Option<&Path>) -> Result<Vec<Item>, Failure> {
    let Some(output) = output else {
        return Ok(inputs
            .iter()
            .map(|i| Item {
                input: i.clone(),
                output: None,
                kind: Kind::Single,
            })
            .collect());
    };
    let folder = os_name::bytes(output.as_os_str()).ends_with(b"/") || output.is_dir();
    let template = match folder {
        true => output.join("{model}.png"),
        false => output.to_owned(),
    };
    let tells_apart = holds(&template, MODEL) || holds(&template, DIR);
    if inputs.len() > 1 && !tells_apart {
        return Err(Failure::usage(
            format!(
                "{} inputs and one output {}",
                inputs.len(),
                output.display()
            ),
            "name a folder, or put {model} into the name: -o 'out/{model}.png'",
        ));
    }
    Ok(inputs
        .iter()
        .map(|input| {
            let model = match input.as_os_str() == "-" {
                true => OsStr::new("stdin"),
                false => input.file_stem().unwrap_or_default(),
            };
            let parent = input.parent().filter(|p| !p.as_os_str().is_empty());
            let parent = parent.unwrap_or(Path::new("."));
            let output = os_name::replaced(template.as_os_str(), MODEL, model);
            let output = os_name::replaced(&output, DIR, parent.as_os_str());
            Item {
                input: input.clone(),
                output: Some(output.into()),
                kind: Kind::Single,
            }
        })
        .collect())
}

fn holds(name: &Path, word: &str) -> bool {
    let bytes = os_name::bytes(name.as_os_str());
    bytes
        .windows(word.len())
        .any(|part| part == word.as_bytes())
}

/// Files of the pictures of an input, by the name of its output.
pub(crate) fn kind(
    args: &RenderArgs,
    output: Option<&Path>,
    shots: Option<&[Option<String>]>,
) -> Result<Kind, Failure> {
    let views = !args.camera.views.is_empty();
    let Some(output) = output else {
        return Ok(match shots {
            Some(_) if views => Kind::Sheet,
            Some(shots) => Kind::Series(vec![None; shots.len()]),
            None => Kind::Single,
        });
    };
    let text = output.to_string_lossy();
    let counter = find_counter(text.as_bytes()).is_some();
    let placed = counter || holds(output, NUMBER) || holds(output, VIEW);
    let format = match output == Path::new("-") {
        true => Output::Pictures(PictureFormat::Png),
        false => formats::output(output, shots.is_some())?,
    };
    match (shots, format) {
        (Some(_), Output::Animation(format)) if !placed => Ok(Kind::Animation(format)),
        (Some(_), Output::Animation(_)) => Err(Failure::usage(
            format!("{text}: an animation is one file, and the name has a place for a number"),
            "leave the number out, or end the name with .png",
        )),
        (Some(shots), _) if placed => {
            let names = shots.iter().zip(0..).map(|(name, number)| {
                picture_name(output, number, shots.len(), name.as_deref()).map(Some)
            });
            names.collect::<Result<_, _>>().map(Kind::Series)
        }
        (Some(_), _) if views => Ok(Kind::Sheet),
        (Some([_]), _) if args.camera.cameras.is_some() => {
            Ok(Kind::Series(vec![Some(output.to_owned())]))
        }
        (Some(_), _) => Err(Failure::usage(
            format!("{text}: --frames, --turntable and --cameras need a place for the number"),
            "write %04d or {n} into the name, as in -o walk%04d.png; a list of cameras may have {view}; or end the name with .gif or .apng",
        )),
        (None, _) if placed => Err(Failure::usage(
            format!("{text}: a numbered name without --frames, --turntable, --cameras or --views"),
            "add --turntable N, --path CAMERA.json --frames N, or --frames N for the animation of a glTF model",
        )),
        (None, _) => Ok(Kind::Single),
    }
}

/// The name of picture `number` of `of`.
fn picture_name(
    output: &Path,
    number: u32,
    of: usize,
    view: Option<&str>,
) -> Result<PathBuf, Failure> {
    let digits = of.saturating_sub(1).max(1).ilog10() as usize + 1;
    let plain = format!("{number:0digits$}");
    let name = numbered(output, number).unwrap_or_else(|| output.to_owned());
    let name = os_name::replaced(name.as_os_str(), NUMBER, OsStr::new(&plain));
    // A name from a file leads into no other folder.
    let view = view.unwrap_or(&plain);
    if view.contains(['/', '\\']) || view == ".." {
        return Err(Failure::usage(
            format!("camera {number} is called `{view}`, which is no part of a file's name"),
            "give it another name, or write {n} in place of {view}",
        ));
    }
    Ok(os_name::replaced(&name, VIEW, OsStr::new(view)).into())
}

/// Refuses outputs that standard output cannot take beside or instead of one picture.
fn check_stdout(args: &RenderArgs, kind: &Kind, output: &Path) -> Result<(), Failure> {
    if output != Path::new("-") {
        return Ok(());
    }
    let clash = if args.json {
        Some("--json")
    } else if !args.aov.is_empty() {
        Some("--aov")
    } else if matches!(kind, Kind::Series(_)) {
        Some("several pictures")
    } else {
        None
    };
    clash.map_or(Ok(()), |flag| {
        Err(Failure::usage(
            format!("-o - and {flag} do not go together"),
            "name a file",
        ))
    })
}

/// Position of `%d` or `%04d` in a name and its number of digits.
struct Counter {
    start: usize,
    end: usize,
    width: usize,
}

fn find_counter(name: &[u8]) -> Option<Counter> {
    let start = name.iter().rposition(|b| *b == b'%')?;
    let after = &name[start + 1..];
    let digits = after.iter().take_while(|b| b.is_ascii_digit()).count();
    let width = match &after[..digits] {
        [] => 1,
        [b'0'] => 0,
        [b'0', digit] => usize::from(digit - b'0'),
        _ => return None,
    };
    (after.get(digits) == Some(&b'd')).then_some(Counter {
        start,
        end: start + 1 + digits + 1,
        width,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(inputs: &[&str], output: &str) -> Result<Vec<String>, Failure> {
        let inputs: Vec<PathBuf> = inputs.iter().map(PathBuf::from).collect();
        let items = name(&inputs, Some(Path::new(output)))?;
        Ok(items
            .into_iter()
            .filter_map(|i| Some(i.output?.to_string_lossy().into_owned()))
            .collect())
    }

    #[test]
    fn several_inputs_need_a_folder_or_a_template() {
        assert_eq!(names(&["a/x.obj"], "o.png").unwrap(), ["o.png"]);
        assert_eq!(
            names(&["a/x.obj", "y.scene"], "out/").unwrap(),
            ["out/x.png", "out/y.png"]
        );
        assert_eq!(
            names(&["a/x.obj", "y.scene"], "p_{model}.png").unwrap(),
            ["p_x.png", "p_y.png"]
        );
        assert_eq!(
            names(&["a/x.obj", "y.scene"], "{dir}/{model}.jpg").unwrap(),
            ["a/x.jpg", "./y.jpg"]
        );
        assert!(names(&["x.obj", "y.obj"], "o.png").is_err());
    }

    #[test]
    fn pictures_are_numbered_and_named_where_the_name_says() {
        let name = |output: &str, number, of, view| {
            let name = picture_name(Path::new(output), number, of, view);
            name.map(|n| n.to_string_lossy().into_owned())
        };
        for (output, number, of, view, expected) in [
            ("w%04d.png", 7, 10, None, "w0007.png"),
            ("w%d.png", 12, 20, None, "w12.png"),
            ("w%02d.png", 123, 200, None, "w123.png"),
            ("w{n}.png", 7, 100, None, "w07.png"),
            ("w{n}.png", 7, 101, None, "w007.png"),
            ("{view}.png", 1, 2, Some("left"), "left.png"),
            ("{view}-{n}.png", 1, 2, None, "1-1.png"),
        ] {
            assert_eq!(name(output, number, of, view).unwrap(), expected);
        }
        for bad in ["../up", "a/b", ".."] {
            assert!(name("{view}.png", 0, 1, Some(bad)).is_err(), "{bad}");
        }
        for bad in ["w.png", "w%s.png", "w%4d.png", "w%0004d.png"] {
            assert!(find_counter(bad.as_bytes()).is_none(), "{bad} was taken");
        }
    }
}
