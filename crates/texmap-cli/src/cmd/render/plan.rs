//! Which input becomes which file; everything that can be refused before a file is read.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use texmap_scene::Scene;

use crate::cmd::render::RenderArgs;
use crate::failure::Failure;
use crate::formats;
use crate::os_name;
use crate::output::{Destination, Stage, distinct};

/// One input and the name of its picture; none in a dry run without `-o`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    pub(crate) input: PathBuf,
    pub(crate) output: Option<PathBuf>,
}

impl Item {
    /// The name of frame `number` of a walk, or of the only picture.
    pub(crate) fn frame_output(&self, number: Option<u32>) -> Option<PathBuf> {
        let output = self.output.as_ref()?;
        match number {
            Some(n) => numbered(output, n),
            None => Some(output.clone()),
        }
    }
}

/// The name of frame `n`, if the name has a place for it: `%04d`.
pub(crate) fn numbered(output: &Path, n: u32) -> Option<PathBuf> {
    let name = os_name::bytes(output.as_os_str());
    let place = find_counter(&name)?;
    let number = format!("{n:0width$}", width = place.width);
    let parts = [&name[..place.start], number.as_bytes(), &name[place.end..]];
    Some(os_name::of_bytes(parts.concat()).into())
}

/// Names all outputs and checks them: endings, numbers, twins, and that each can be written.
pub(crate) fn items(args: &RenderArgs) -> Result<Vec<Item>, Failure> {
    let items = name(&args.inputs, args.output.as_deref())?;
    let mut outputs = Vec::new();
    let mut owner: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    for item in &items {
        let Some(output) = &item.output else { continue };
        check_name(args, output)?;
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
    distinct(outputs, args.inputs.iter().chain(&args.path))?;
    Ok(items)
}

/// Every file that an input will give, checked.
fn destinations(args: &RenderArgs, item: &Item) -> Result<Vec<(PathBuf, Destination)>, Failure> {
    let numbers = args
        .frames
        .map_or(vec![None], |n| (0..n).map(Some).collect());
    let mut all = Vec::new();
    for picture in numbers.into_iter().filter_map(|n| item.frame_output(n)) {
        let arrays = args.aov.iter().map(|aov| array_name(&picture, &aov.name));
        let heat = args.verify.then(|| heat_name(&picture));
        let beside: Vec<PathBuf> = arrays.chain(heat).collect();
        for path in [picture].into_iter().chain(beside) {
            let destination = Destination::new(&path)?;
            all.push((path, destination));
        }
    }
    Ok(all)
}

/// `room.png` and `uv` give `room.uv.npy`.
pub(crate) fn array_name(picture: &Path, aov: &str) -> PathBuf {
    picture.with_extension(format!("{aov}.npy"))
}

/// `room.png` gives `room.heat.png`: where its errors are.
pub(crate) fn heat_name(picture: &Path) -> PathBuf {
    picture.with_extension("heat.png")
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
    let pixels = u64::from(args.resolution.width) * u64::from(args.resolution.height);
    let arrays: usize = args.aov.iter().map(|a| 4 * a.channels()).sum();
    let pictures = args.views.len().max(1) as u64;
    let triangles: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
    PROGRAM
        + meshes.sum::<u64>()
        + triangles as u64 * TRIANGLE
        + textures.sum::<u64>()
        + pixels * (8 * pictures + arrays as u64)
}

/// Where the name of an input stands in the name of an output.
const MODEL: &str = "{model}";

fn name(inputs: &[PathBuf], output: Option<&Path>) -> Result<Vec<Item>, Failure> {
    let Some(output) = output else {
        return Ok(inputs
            .iter()
            .map(|i| Item {
                input: i.clone(),
                output: None,
            })
            .collect());
    };
    let folder = os_name::bytes(output.as_os_str()).ends_with(b"/") || output.is_dir();
    let template = match folder {
        true => output.join("{model}.png"),
        false => output.to_owned(),
    };
    let holds_model = os_name::bytes(template.as_os_str())
        .windows(MODEL.len())
        .any(|part| part == MODEL.as_bytes());
    if inputs.len() > 1 && !holds_model {
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
            let model = input.file_stem().unwrap_or_default();
            let output = os_name::replaced(template.as_os_str(), MODEL, model);
            Item {
                input: input.clone(),
                output: Some(output.into()),
            }
        })
        .collect())
}

fn check_name(args: &RenderArgs, output: &Path) -> Result<(), Failure> {
    let text = output.to_string_lossy();
    if output == Path::new("-") {
        let clash = if args.json {
            Some("--json")
        } else if !args.aov.is_empty() {
            Some("--aov")
        } else {
            args.frames.map(|_| "--frames")
        };
        return clash.map_or(Ok(()), |flag| {
            Err(Failure::usage(
                format!("-o - and {flag} do not go together"),
                "name a file",
            ))
        });
    }
    match (args.frames, find_counter(text.as_bytes())) {
        (Some(_), None) => Err(Failure::usage(
            format!("{text}: --frames needs a place for the number"),
            "write %04d into the name: -o walk%04d.png",
        )),
        (None, Some(_)) => Err(Failure::usage(
            format!("{text}: a numbered name without --frames"),
            "add --path CAMERA.json --frames N",
        )),
        _ => Ok(()),
    }?;
    formats::png("-o", output)
}

/// Where `%d` or `%04d` stands in a name and how many digits it asks for.
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
        assert!(names(&["x.obj", "y.obj"], "o.png").is_err());
    }

    #[test]
    fn frames_are_numbered_where_the_name_says() {
        let item = |o: &str| Item {
            input: "a.scene".into(),
            output: Some(o.into()),
        };
        assert_eq!(
            item("w%04d.png").frame_output(Some(7)),
            Some("w0007.png".into())
        );
        assert_eq!(
            item("w%d.png").frame_output(Some(12)),
            Some("w12.png".into())
        );
        assert_eq!(
            item("w%02d.png").frame_output(Some(123)),
            Some("w123.png".into())
        );
        assert_eq!(item("w.png").frame_output(None), Some("w.png".into()));
        for bad in ["w.png", "w%s.png", "w%4d.png", "w%0004d.png"] {
            assert!(find_counter(bad.as_bytes()).is_none(), "{bad} was taken");
        }
    }
}
