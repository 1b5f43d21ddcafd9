//! Rebuilds every file under `assets/` byte for byte: `cargo run -p texmap-assets`.
//!
//! With `--check` nothing is written; the program names each file that differs and ends with exit code 1.
//! Everything is computed with integers and IEEE + - * / sqrt (the rest from `texmap_math::deterministic_f64`), so the bytes
//! are the same on every machine.
#![forbid(unsafe_code)]

mod cow;
mod dots;
mod effect_scenes;
mod gltf;
mod mesh;
mod picture;
mod polygons;
mod scenes;
mod shapes;
mod teapot;
mod textures;

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let check = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--check"] => true,
        _ => {
            eprintln!("usage: texmap-assets [--check]");
            return ExitCode::from(2);
        }
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = files();
    let mut differing = 0;
    for (name, bytes) in &files {
        let path = root.join(name);
        if std::fs::read(&path).is_ok_and(|found| found == *bytes) {
            continue;
        }
        differing += 1;
        if check {
            eprintln!("assets/{name} differs from what the generator makes");
        } else if let Err(error) = write(&path, bytes) {
            eprintln!("cannot write {}: {error}", path.display());
            return ExitCode::from(4);
        }
    }
    for stray in strays(root, &files) {
        differing += 1;
        eprintln!("assets/{stray} is not made by the generator");
    }
    let total: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    eprintln!(
        "{} files, {} kB, {differing} {}",
        files.len(),
        total / 1000,
        if check { "differ" } else { "changed" }
    );
    if check && differing > 0 {
        ExitCode::from(1)
    } else {
        ExitCode::SUCCESS
    }
}

const PLATE: &str = "newmtl plate\nKd 1 1 1\nKs 0.8 0.8 0.8\nNs 60\nillum 2\n\
    map_Kd ../textures/brick.png\nmap_Ks ../textures/checker.png\nmap_Ns ../textures/hills.png\nmap_Ka ../textures/hills.png\n";

/// Name below `assets/` and content of every generated file.
fn files() -> Vec<(String, Vec<u8>)> {
    let (cow, hide) = cow::cow();
    let pictures = [
        ("checker.png", textures::checker().png()),
        ("uv_grid.png", textures::uv_grid().png()),
        ("brick.png", textures::brick().png()),
        ("hills.png", textures::hills().png()),
        ("face.png", textures::face().png()),
        ("fence.png", textures::fence().png()),
        ("leaf.png", textures::leaf(false).png()),
        ("leaf.gif", textures::leaf(true).gif()),
        ("carpet.gif", textures::carpet().gif()),
        ("ceilingtile.gif", textures::ceiling_tile().gif()),
        ("walls.gif", textures::walls().gif()),
        ("cow.png", hide.png()),
        ("sky.png", textures::sky().png()),
        ("lamps.png", textures::lamps().png()),
        ("offsets.png", textures::offsets().png()),
        ("normals.png", textures::normals().png()),
        ("brick_heights.png", textures::brick_heights().png()),
        ("heat.png", textures::heat().png()),
        ("flames.png", textures::flames().png()),
        ("tones.png", textures::tones().png()),
        ("label.png", textures::label().png()),
        ("baked.png", textures::baked().png()),
        ("cloud.npy", textures::cloud()),
    ];
    let models = [
        ("cow", "A purple cow", cow, "cow.png"),
        (
            "teapot",
            "The Utah teapot (Martin Newell, 1975), 32 Bezier patches of 10 x 10 squares",
            teapot::teapot(10),
            "uv_grid.png",
        ),
        (
            "cube",
            "The unit cube, the whole picture on each face",
            shapes::cube(),
            "uv_grid.png",
        ),
        (
            "head",
            "A head for a label texture",
            shapes::head(),
            "face.png",
        ),
        (
            "house",
            "A house with a gable roof",
            shapes::house(),
            "uv_grid.png",
        ),
        (
            "twisted_box",
            "A box of 1 x 3 x 1, twisted by 270 degrees",
            shapes::twisted_box(),
            "uv_grid.png",
        ),
        (
            "cylinder",
            "The unit cylinder",
            shapes::turned("cylinder", &shapes::cylinder_profile()),
            "uv_grid.png",
        ),
        (
            "cone",
            "The unit cone",
            shapes::turned("cone", &shapes::cone_profile()),
            "uv_grid.png",
        ),
        (
            "ball",
            "The unit ball",
            shapes::turned("ball", &shapes::ball_profile()),
            "uv_grid.png",
        ),
    ];
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    files.extend(pictures.map(|(name, bytes)| (format!("textures/{name}"), bytes)));
    for (name, heading, mesh, texture) in models {
        let text = mesh.obj(
            &format!("{heading}. Made by texmap-assets."),
            &format!("{name}.mtl"),
            name,
        );
        files.push((format!("models/{name}.obj"), text.into_bytes()));
        files.push((
            format!("models/{name}.mtl"),
            mesh::mtl(name, texture).into_bytes(),
        ));
    }
    let white = "teapot_white";
    let heading = "The Utah teapot (Martin Newell, 1975), 32 Bezier patches of 6 x 6 squares, without a map. Made by texmap-assets.";
    let text = teapot::teapot(6).obj(heading, "teapot_white.mtl", white);
    files.push((format!("models/{white}.obj"), text.into_bytes()));
    let text = format!("newmtl {white}\nKd 0.95 0.93 0.9\nKs 0.2 0.2 0.2\nNs 40\nillum 2\n");
    files.push((format!("models/{white}.mtl"), text.into_bytes()));
    let heading = "The unit cube, each face in a cell of its own: coordinates for baked light. Made by texmap-assets.";
    let text = shapes::unfolded_cube().obj(heading, "cube.mtl", "cube");
    files.push(("models/cube_unfolded.obj".to_owned(), text.into_bytes()));
    let plain = [
        (
            "ball_plain",
            "The unit ball, coarser and without a material",
            shapes::coarse_ball(),
        ),
        (
            "cube_plain",
            "The unit cube without a material",
            shapes::cube(),
        ),
    ];
    for (name, heading, mesh) in plain {
        let text = mesh.obj(
            &format!("{heading}. Made by texmap-assets."),
            "none.mtl",
            "none",
        );
        let lines = text
            .lines()
            .filter(|line| !line.starts_with("mtllib") && !line.starts_with("usemtl"));
        let text: String = lines.flat_map(|line| [line, "\n"]).collect();
        files.push((format!("models/{name}.obj"), text.into_bytes()));
    }
    let heading = "A plate with maps for its highlight. Made by texmap-assets.";
    let text = shapes::plate().obj(heading, "plate.mtl", "plate");
    files.push(("models/plate.obj".to_owned(), text.into_bytes()));
    files.push(("models/plate.mtl".to_owned(), PLATE.as_bytes().to_vec()));
    let heading = "A house with a gable roof. Made by texmap-assets.";
    let house = shapes::house().ply(heading, "../textures/uv_grid.png");
    files.push(("models/house.ply".to_owned(), house));
    let cube = shapes::cube().stl("The unit cube. Made by texmap-assets.");
    files.push(("models/cube.stl".to_owned(), cube));
    files.extend(
        scenes::SCENES
            .into_iter()
            .chain(effect_scenes::SCENES)
            .map(|(name, text)| (format!("scenes/{name}"), text.as_bytes().to_vec())),
    );
    files.extend(
        gltf::files()
            .into_iter()
            .map(|(name, bytes)| (format!("gltf/{name}"), bytes)),
    );
    files
}

fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, bytes)
}

/// Files in the generated folders that the generator does not make.
fn strays(root: &Path, files: &[(String, Vec<u8>)]) -> Vec<String> {
    let mut strays = Vec::new();
    for folder in ["gltf", "models", "scenes", "textures"] {
        for entry in std::fs::read_dir(root.join(folder))
            .into_iter()
            .flatten()
            .flatten()
        {
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if !files.iter().any(|(known, _)| *known == name) {
                strays.push(name);
            }
        }
    }
    strays.sort();
    strays
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_on_disk_is_what_the_generator_makes() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let files = files();
        for (name, bytes) in &files {
            let found = std::fs::read(root.join(name)).unwrap_or_default();
            assert!(
                found == *bytes,
                "assets/{name} differs: run `cargo run -p texmap-assets`"
            );
        }
        assert_eq!(strays(root, &files), Vec::<String>::new());
        let total: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
        assert!(total < 3_000_000, "{total} bytes of assets");
    }
}
