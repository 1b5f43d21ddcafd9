//! Draws the contact sheet of docs/generated/uv-mappings.md and writes both, into docs or the folder that is given: every mapping on the
//! objects of SUSTech CS lecture 08, with the figures of the report.
//!
//! `cargo run --release -p texmap-lab --example uv_mappings [FOLDER]`

use std::error::Error;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use texmap_io::framing::View;
use texmap_io::image_io;
use texmap_lab::uv_pictures::{checker, layout};
use texmap_math::Level;
use texmap_math::glam::DVec3;
use texmap_truth::picture::Picture;
use texmap_uv::{
    AtlasSize, Faces, Mapping, Mesh, Origin, Placement, Report, ReportOptions, SeamEdges, Shape,
    UvSet, auto_planes, report, unwrap,
};

const OBJECTS: [&str; 6] = ["house", "twisted_box", "cylinder", "cone", "ball", "teapot"];
const MAPPINGS: [&str; 7] = [
    "plane", "cylinder", "cone", "sphere", "box", "auto", "unwrap",
];
/// Wide enough for the longest caption, "twisted box/cylinder".
const CELL: u32 = 176;
const TEXT: u32 = 60;
const ORIGIN: Origin = Origin::TopLeft;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = std::env::args_os().nth(1);
    let folder = folder.map_or_else(|| root.join("docs/generated"), PathBuf::from);
    let mut sheet = Picture::new(CELL * 7, (CELL + TEXT) * 6 + CELL * 2, [255; 4]);
    let mut table = String::new();
    let mut all: Vec<Vec<Report>> = Vec::new();
    for (row, name) in OBJECTS.iter().enumerate() {
        let (positions, faces) = read(&root.join(format!("assets/models/{name}.obj")))?;
        let mesh = Mesh::new(&positions, &faces)?;
        let mut reports = Vec::new();
        for (column, mapping) in MAPPINGS.iter().enumerate() {
            let set = map(&mesh, mapping)?;
            let r = report(
                &mesh,
                &set,
                &ReportOptions {
                    origin: ORIGIN,
                    ..ReportOptions::default()
                },
            )?;
            let (x, y) = (
                (column as u32 * CELL) as i64,
                (row as u32 * (CELL + TEXT)) as i64,
            );
            sheet.blit(x, y, &checker(&mesh, &set, ORIGIN, View::Iso, CELL)?);
            let share = |n: usize| 100.0 * n as f64 / r.triangles.len() as f64;
            let lines = [
                format!("{}/{mapping}", name.replace('_', " ")),
                format!("L2 {} angle {:.2}", figure(r.stretch_l2), r.angle_mean),
                format!("over {:.0}% shells {}", share(r.overlapping), r.islands),
            ];
            for (k, line) in lines.iter().enumerate() {
                sheet.text(
                    x + 4,
                    y + i64::from(CELL) + 4 + 18 * k as i64,
                    1,
                    [40, 40, 48, 255],
                    line,
                );
            }
            // The lecture's picture: the planar map of the twisty object unwrapped, overlaps in pink.
            if *name == "twisted_box" && ["plane", "sphere", "auto"].contains(mapping) {
                let place = ["plane", "sphere", "auto"]
                    .iter()
                    .position(|m| m == mapping)
                    .unwrap_or(0) as i64;
                let y = i64::from((CELL + TEXT) * 6);
                sheet.blit(
                    place * 2 * i64::from(CELL),
                    y,
                    &layout(&set, &r, ORIGIN, 2 * CELL),
                );
            }
            let _ = writeln!(
                table,
                "| {} | {mapping} | {} | {} | {:.2} | {:.2} | {:.0} % | {:.0} % | {} | {:.2} | {} |",
                name.replace('_', " "),
                figure(r.stretch_l2),
                figure(r.stretch_linf),
                r.angle_mean,
                r.area_mean,
                share(r.flipped),
                share(r.overlapping),
                r.wide,
                r.seam_length,
                r.islands
            );
            reports.push(r);
        }
        all.push(reports);
    }
    let claims = claims(&root, &all)?;
    image_io::write_png(
        &folder.join("uv-mappings.png"),
        sheet.width(),
        sheet.height(),
        sheet.rgba(),
    )?;
    let unwrappers = std::fs::read_to_string(root.join("benches/results/unwrappers.md"))?;
    let page = page(&table, &claims, &unwrappers);
    texmap_io::atomic::write(&folder.join("uv-mappings.md"), |out| {
        out.write_all(page.as_bytes())
    })?;
    Ok(())
}

fn map(mesh: &Mesh<'_>, name: &str) -> Result<UvSet, Box<dyn Error>> {
    let shape = |shape| Mapping {
        origin: ORIGIN,
        ..Mapping::new(shape)
    };
    let mapping = match name {
        "auto" => return Ok(auto_planes(mesh, AtlasSize::default(), ORIGIN)?),
        "unwrap" => {
            return Ok(unwrap(
                mesh,
                &SeamEdges::default(),
                AtlasSize::default(),
                ORIGIN,
                &|_, _| ControlFlow::Continue(()),
            )?);
        }
        // A square picture: filling the bounding box would add a stretch of its own.
        "plane" => Mapping {
            frame: Some(square(mesh)),
            ..shape(Shape::Plane)
        },
        "cylinder" => shape(Shape::Cylinder),
        "cone" => shape(Shape::Cone),
        "sphere" => shape(Shape::Sphere),
        _ => shape(Shape::Box),
    };
    Ok(mapping.map(Level::new(), mesh, &[])?.set)
}

/// An upright frame as wide as it is high around the mesh.
fn square(mesh: &Mesh<'_>) -> Placement {
    let used = || {
        mesh.faces()
            .corners()
            .iter()
            .map(|i| DVec3::from(mesh.positions()[*i as usize].map(f64::from)))
    };
    let (low, high) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
        (l.min(p), h.max(p))
    });
    Placement::upright((low + high) * 0.5, DVec3::splat((high - low).max_element()))
}

/// Positions and faces of a model.
type Model = (Vec<[f32; 3]>, Faces);

/// Positions and triangles of an OBJ, its materials joined.
/// The vertices and polygons of an OBJ of the assets, as `texmap uv` reads them: triangles, or vertices that are split where
/// normals differ, would give other charts.
fn read(path: &Path) -> Result<Model, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let (mut positions, mut faces) = (Vec::new(), Faces::new());
    for line in text.lines() {
        let (word, values) = line.split_once(' ').unwrap_or((line, ""));
        let mut values = values.split_whitespace();
        match word {
            "v" => {
                let mut number = || values.next().unwrap_or("").parse::<f32>();
                positions.push([number()?, number()?, number()?]);
            }
            "f" => {
                let vertex = |corner: &str| corner.split('/').next().unwrap_or("").parse::<u32>();
                let corners: Result<Vec<u32>, _> = values.map(vertex).collect();
                let corners: Vec<u32> = corners?.into_iter().map(|k| k.wrapping_sub(1)).collect();
                faces.push(&corners);
            }
            _ => {}
        }
    }
    Ok((positions, faces))
}

/// The lecture's claims about its objects, held against the figures.
fn claims(root: &Path, all: &[Vec<Report>]) -> Result<Vec<String>, Box<dyn Error>> {
    let at = |object: &str, mapping: &str| {
        let row = OBJECTS.iter().position(|o| *o == object).unwrap_or(0);
        &all[row][MAPPINGS.iter().position(|m| *m == mapping).unwrap_or(0)]
    };
    let path: PathBuf = root.join("assets/models/twisted_box.obj");
    let (positions, faces) = read(&path)?;
    let mesh = Mesh::new(&positions, &faces)?;
    let plane = at("twisted_box", "plane");
    // Triangles that face the projection (within 30 degrees), and all of them.
    let normal = |t: &texmap_uv::TriangleReport| {
        let [a, b, c] = t
            .corners
            .map(|k| positions[mesh.faces().corners()[k as usize] as usize].map(f64::from));
        let (e, f) = (
            [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
            [c[0] - a[0], c[1] - a[1], c[2] - a[2]],
        );
        let n = [
            e[1] * f[2] - e[2] * f[1],
            e[2] * f[0] - e[0] * f[2],
            e[0] * f[1] - e[1] * f[0],
        ];
        n[2].abs() / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
    };
    let facing: Vec<f64> = plane
        .triangles
        .iter()
        .filter(|t| normal(t) > 0.866)
        .map(|t| f64::from(t.angle))
        .collect();
    let facing_mean = facing.iter().sum::<f64>() / facing.len() as f64;
    let overlapping = 100.0 * plane.overlapping as f64 / plane.triangles.len() as f64;
    let twisted = ["sphere", "cylinder", "auto", "unwrap"].map(|m| at("twisted_box", m));
    let (house_sphere, house_box) = (at("house", "sphere"), at("house", "box"));
    let verdict = |holds: bool| if holds { "confirmed" } else { "refuted" };
    Ok(vec![
        format!(
            "*Planar is okay when viewed from one axis, but the map overlaps itself and two axes are ignored* (twisty object): {}. \
             Triangles within 30 degrees of the axis have a mean angle distortion of {facing_mean:.2}, all together {:.2}; {overlapping:.0} % of the triangles overlap.",
            verdict(facing_mean < 1.2 && plane.angle_mean > 1.5 && overlapping > 50.0),
            plane.angle_mean
        ),
        format!(
            "*Spherical and cylindrical have a lot of distortion on the twisty object*: {}. Mean angle distortion {:.2} and {:.2} (1 is none), stretch L2 {} and {}.",
            verdict(twisted[0].angle_mean > 1.5 && twisted[1].angle_mean > 1.3),
            twisted[0].angle_mean,
            twisted[1].angle_mean,
            figure(twisted[0].stretch_l2),
            figure(twisted[1].stretch_l2)
        ),
        format!(
            "*Automatic has a lot of distortion on the twisty object*: {}. Six planes give a mean angle distortion of {:.2} and no overlap; the price is {} shells and a seam of length {:.1} \
             (unwrapping: {:.2}, {} shells, {:.1}).",
            verdict(twisted[2].angle_mean > 1.3),
            twisted[2].angle_mean,
            twisted[2].islands,
            twisted[2].seam_length,
            twisted[3].angle_mean,
            twisted[3].islands,
            twisted[3].seam_length
        ),
        format!(
            "*A sphere map cures the house* (the picture breaks at its edges when every face is mapped by itself): {}. The length of interrupted edges falls from {:.1} (box) to {:.1}, \
             the seam and the spokes of the poles; the mean angle distortion rises from {:.2} to {:.2}.",
            verdict(house_sphere.seam_length < 0.5 * house_box.seam_length),
            house_box.seam_length,
            house_sphere.seam_length,
            house_box.angle_mean,
            house_sphere.angle_mean
        ),
    ])
}

fn page(table: &str, claims: &[String], unwrappers: &str) -> String {
    format!(
        "# Every mapping on the lecture's objects\n\n\
         Made by `cargo run --release -p texmap-lab --example uv_mappings`; nothing on this page is written by hand.\n\
         The objects are those of SUSTech CS lecture 08 (`assets/models`): a house, a twisty object (a box turned by 270 degrees),\n\
         the unit solids, and a teapot. Shapes are fitted to the bounding box (the plane is a square around it) and map positions; seams are repaired.\n\n\
         ![contact sheet](uv-mappings.png)\n\n\
         The last row is the unwrapped picture of the twisty object by plane, sphere and several planes: overlaps are pink, flipped triangles blue.\n\n\
         ## The lecture's claims\n\n{}\n\n\
         ## Figures\n\n\
         Stretch after Sander et al. (2001), 1 is best, infinite where a triangle has no area in the picture. Angle and area distortion are area-weighted means, 1 is none.\n\
         Torn triangles span more than half of the picture; after the repair those left enclose the axis of the shape. The seam is the length of edges at which the picture is interrupted.\n\n\
         | object | mapping | L2 | Linf | angle | area | flipped | overlapping | torn | seam | shells |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n{table}\n\
         {AXIS}\n\
         ## The choice of an unwrapper\n\n\
         Candidates are the pure-Rust crates that are kept up; texmap's own six planes stand beside them. Pages of 1024 texels, 4 texels between charts.\n\
         The knot is a closed tube with lumps, of about 100,000 triangles by formula. Lengths are in object units. The seconds were taken on two cores\n\
         that other work shared: read them as orders of magnitude. Made by\n\
         `cargo run --release -p texmap-benches --features unwrappers --bin unwrappers`.\n\n{unwrappers}\n\
         `--map unwrap` is uvunwrap: nothing flipped, nothing overlapping and an L2 stretch within 0.002 of 1 in every row measured, and the same bytes on every machine by its own tests.\n\
         Six planes are far quicker, at a longer seam and more shells.\n\n\
         ## Speed\n\n\
         `cargo run --release -p texmap-benches --bin uv-scaling` writes [uv_scaling.csv](../../benches/results/uv_scaling.csv) and this chart.\n\
         Overlaps and T-joints are found in trees, with n log n steps on any mesh; every other step visits each triangle a fixed number of times, and what grows with the mesh is the price of memory. Of the report on 4 million triangles\n\
         more than a quarter of the time is the system handing out cleared pages (`perf record`), and rows of the mesh leave the caches next to the cores.\n\n\
         ![time over triangles](../../benches/results/uv_scaling.svg)\n",
        claims
            .iter()
            .map(|c| format!("- {c}"))
            .collect::<Vec<_>>()
            .join("\n")
    )
}

/// Limits of texture coordinates at vertices.
const AXIS: &str = "## Faces that enclose the axis\n\n\
    A face around the axis of a cylinder, cone or sphere meets all longitudes: whatever u its corners get, the picture between them is wrong.\n\
    texmap names such faces (a warning with their lines, `faces_around_axis` in the JSON) and leaves their corners at the formula. Two cures:\n\
    divide the face at the axis, so that each part has a pole vertex of its own (the repair fans it); or evaluate the mapping at every pixel\n\
    (`round` in a scene, `PerPixelProjection` of texmap-uv: uv and footprint by the chain rule, no jump of the footprint at the seam or within the face).\n";

fn figure(x: f64) -> String {
    if x.is_finite() {
        if x < 100.0 {
            format!("{x:.2}")
        } else {
            format!("{x:.0}")
        }
    } else {
        "inf".into()
    }
}
