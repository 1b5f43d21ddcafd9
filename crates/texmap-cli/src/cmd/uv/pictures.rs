//! The report as pictures in a folder.

use std::path::Path;

use texmap_io::framing::View;
use texmap_io::image_io;
use texmap_lab::LabError;
use texmap_lab::uv_pictures::{checker, heat, layout};
use texmap_truth::picture::Picture;
use texmap_uv::{Mesh, Origin, Report, UvSet, layout_svg};

use crate::failure::Failure;
use crate::output::{Destination, Stage};

/// Names of the pictures in their folder.
pub(super) const NAMES: [&str; 4] = ["checker.png", "heat.png", "layout.png", "layout.svg"];

/// Edge of each picture.
const SIZE: u32 = 512;

/// Adds `checker.png`, `heat.png`, `layout.png` and `layout.svg` to the outputs; gives a line for each.
pub(super) fn draw(
    stage: &mut Stage,
    folder: &Path,
    mesh: &Mesh<'_>,
    set: &UvSet,
    report: &Report,
) -> Result<Vec<String>, Failure> {
    let both = |one: &dyn Fn(View) -> Result<Picture, LabError>| -> Result<Picture, Failure> {
        let mut sheet = Picture::new(2 * SIZE, SIZE, [255; 4]);
        for (x, view) in [(0, View::Iso), (i64::from(SIZE), View::Back)] {
            let picture = one(view)?;
            sheet.blit(x, 0, &picture);
        }
        Ok(sheet)
    };
    let pictures = [
        (
            "checker.png",
            both(&|view| checker(mesh, set, Origin::BottomLeft, view, SIZE))?,
            "checker on the model, from the front and from behind",
        ),
        (
            "heat.png",
            both(&|view| heat(mesh, report, view, SIZE))?,
            "distortion: blue 1, green 1.25, yellow 1.5, red 2 and more",
        ),
        (
            "layout.png",
            layout(set, report, Origin::BottomLeft, 2 * SIZE),
            "the unwrapped picture: overlaps pink, flipped blue",
        ),
    ];
    let mut lines = Vec::new();
    for (name, picture, what) in pictures {
        let path = folder.join(name);
        let place = stage.add(Destination::new(&path)?, "png");
        image_io::write_png(&place, picture.width(), picture.height(), picture.rgba())?;
        lines.push(format!("{}: {what}", path.display()));
    }
    let path = folder.join("layout.svg");
    let svg = layout_svg(set, report, Origin::BottomLeft, 2 * SIZE);
    let place = stage.add(Destination::new(&path)?, "svg");
    texmap_io::atomic::write(&place, |out| out.write_all(svg.as_bytes()))?;
    lines.push(format!("{}: the same as SVG", path.display()));
    Ok(lines)
}
