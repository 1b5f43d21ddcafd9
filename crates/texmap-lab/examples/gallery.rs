//! Writes the gallery of lighting effects and shapes: `cargo run --release -p texmap-lab --example gallery` fills `docs/generated/gallery`. Every count on the
//! page is measured while it is made, and the program fails when a claim does not hold.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use texmap_lab::demos;

const ROWS: [&str; 14] = [
    "slides",
    "shadows",
    "environments",
    "bumps",
    "light-maps",
    "displacement",
    "skin",
    "billboards",
    "terrain",
    "antialiasing",
    "solids",
    "volumes",
    "skies",
    "labels",
];

/// Scenes of `assets` with projectors, what they show, and how much of the picture is wrong without depth maps, %.
const SCENES: [(&str, &str, f64); 2] = [
    ("teapot_slides", "The teapot under two slides", 10.3),
    ("painted_cow", "A cow painted by a picture", 0.5),
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/generated/gallery");
    std::fs::create_dir_all(&folder)?;
    let mut page = String::from(
        "# Lighting effects: on, off, wrong and cured\n\n\
         Made by `cargo run --release -p texmap-lab --example gallery`; every figure was measured while the page was made, and\n\
         `texmap demo NAME -o OUT.png` makes and checks each sheet again.\n",
    );
    let mut failed = Vec::new();
    let mut row =
        |name: &str, shows: &str, demo: demos::DemoPicture| -> Result<(), Box<dyn Error>> {
            let file = format!("{name}.png");
            texmap_io::image_io::write_png(
                &folder.join(&file),
                demo.image.width(),
                demo.image.height(),
                demo.image.rgba(),
            )?;
            writeln!(page, "\n## {name}\n{shows}\n\n![{name}]({file})\n")?;
            writeln!(page, "| what is measured | figure |\n|---|---|")?;
            for claim in &demo.claims {
                writeln!(page, "| {} | {} |", claim.text, short(claim.measured))?;
                if !claim.holds() {
                    failed.push(format!("{name}: {claim}"));
                }
            }
            Ok(())
        };
    for name in ROWS {
        let shows = demos::list()
            .find(|(known, _)| *known == name)
            .map_or("", |(_, shows)| shows);
        row(name, shows, demos::demo(name, 320)?)?;
        for (scene, shows, spoiled) in SCENES.into_iter().filter(|_| name == "slides") {
            let file = folder.join(format!("../../../assets/scenes/{scene}.scene"));
            let loaded = texmap_io::load_scene(&file, &Default::default())?;
            row(
                scene,
                shows,
                demos::projections(shows, &loaded, 320, spoiled)?,
            )?;
        }
    }
    std::fs::write(folder.join("README.md"), page)?;
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("\n").into())
    }
}

fn short(x: f64) -> String {
    if x.fract() == 0.0 {
        format!("{x}")
    } else {
        format!("{x:.3}")
    }
}
