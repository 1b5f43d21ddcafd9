//! `texmap uv`: texture coordinates for a mesh, and a report on its present ones.

mod check;
mod pictures;
pub(super) mod source;
mod table;

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use texmap_io::{FileSource, npy};
use texmap_math::glam::DVec3;
use texmap_math::{Level, MemoryBudget};
use texmap_uv::{
    AtlasSize, Mapping, Mesh, Origin, Placement, ProjectionSource, ReportOptions, SeamEdges, Shape,
    UvError, UvSet, auto_planes, cut_seams, pack, report, sew_seams, unmapped, unwrap,
};

use self::check::check;
use self::source::Source;
use crate::digits::digits;
use crate::failure::{Exit, Failure, print, print_json, say};
use crate::output::{Destination, Stage, distinct};
use crate::values::Triple;

/// Give a mesh texture coordinates, or report on the ones it has.
///
/// Without --map the coordinates of the file are cut, sewn, packed or reported as they are. Only `vt` lines and the
/// corners of `f` lines change, and `mtllib` names where the output lies in another folder; everything else in the file is kept.
/// A PLY or STL becomes an OBJ: equal positions are one vertex, materials are left out.
#[derive(Args, Debug)]
pub(crate) struct UvArgs {
    /// An OBJ, PLY or STL file
    mesh: PathBuf,
    /// The OBJ to write, with the new coordinates
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Method that computes new coordinates
    #[arg(long)]
    map: Option<Map>,
    /// Vectors that the shape maps
    #[arg(long, default_value = "position")]
    by: By,
    /// Position of the eye, for --by reflection
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    eye: Option<Triple>,
    /// Frame of the shape: position, yaw, pitch and roll in degrees, size; fitted to the mesh by default (a plane turns to
    /// a flat surface, else it looks along z, or along y or x where that sees the surface more than twice as squarely)
    #[arg(long, value_name = "PX,PY,PZ,YAW,PITCH,ROLL,SX,SY,SZ", value_parser = list::<9>, allow_hyphen_values = true)]
    frame: Option<List<9>>,
    /// Repetitions of the picture on each part of the shape
    #[arg(long, value_name = "U,V", value_parser = list::<2>, allow_hyphen_values = true)]
    repeat: Option<List<2>>,
    /// Size of one picture in object units, for --map plane by position
    #[arg(long, value_name = "W,H", value_parser = list::<2>)]
    tile: Option<List<2>>,
    /// Map the faces above and below onto the side of the cylinder or cone as well
    #[arg(long)]
    no_caps: bool,
    /// Unwrap faces across the seam of a cylinder, cone or sphere and fan the poles
    #[arg(long)]
    fix_seams: bool,
    /// Cut along edges: a file with two vertex numbers of the OBJ (from 1) a line
    #[arg(long, value_name = "FILE")]
    cut: Option<PathBuf>,
    /// Cut where faces meet at more than this many degrees
    #[arg(long, value_name = "DEGREES")]
    cut_angle: Option<f64>,
    /// Sew islands together along edges: a file as for --cut, in order
    #[arg(long, value_name = "FILE")]
    sew: Option<PathBuf>,
    /// Pack the islands into an atlas of this many texels a side, at one density (auto and unwrap always pack: 1024)
    #[arg(long, value_name = "SIZE", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pack: Option<u32>,
    /// Texels between packed islands, 4 by default
    #[arg(long, value_name = "TEXELS", value_parser = clap::value_parser!(u32).range(0..=4_096))]
    gutter: Option<u32>,
    /// Write the tangent of every corner (x, y, z, sign) as .npy
    #[arg(long, value_name = "FILE.npy")]
    tangents: Option<PathBuf>,
    /// Print stretch, overlaps, seams and more as a table
    #[arg(long)]
    report: bool,
    /// Draw checker, heat map and layout into this folder
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Edge of the texture in texels, for the density in the report, 1024 by default
    #[arg(long, value_name = "SIZE", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    texture_size: Option<u32>,
    /// With --json: the figures of every triangle too
    #[arg(long, requires = "json")]
    per_triangle: bool,
    /// Print the report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

impl UvArgs {
    /// True if figures are asked for that go to standard output.
    pub(crate) fn prints(&self) -> bool {
        self.report || self.per_triangle
    }
}

/// Methods that compute coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Map {
    Plane,
    Cylinder,
    Cone,
    Sphere,
    Box,
    /// Six planes, by the direction of each face, packed
    Auto,
    /// Islands of low distortion, packed; spirals take time in the square of their faces (a helicoid of 4,000 quads: 95 s) unless --cut parts turns
    Unwrap,
}

/// Vectors that a shape maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum By {
    Position,
    Normal,
    Centroid,
    Reflection,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct List<const N: usize>([f64; N]);

fn list<const N: usize>(text: &str) -> Result<List<N>, String> {
    let values: Option<Vec<f64>> = text
        .split(',')
        .map(|s| s.trim().parse::<f64>().ok().filter(|v| v.is_finite()))
        .collect();
    values
        .and_then(|v| <[f64; N]>::try_from(v).ok())
        .map(List)
        .ok_or_else(|| format!("expected {N} numbers separated by commas"))
}

pub(crate) fn run(args: &UvArgs) -> Result<Exit, Failure> {
    check(args)?;
    let folder = args.pictures.iter();
    let pictures = folder.flat_map(|folder| pictures::NAMES.map(|name| folder.join(name)));
    let outputs = args.output.iter().chain(&args.tangents).cloned();
    let outputs: Vec<PathBuf> = outputs.chain(pictures).collect();
    let inputs = [&args.mesh].into_iter().chain(&args.cut).chain(&args.sew);
    distinct(&outputs, inputs)?;
    let source = Source::read(&args.mesh)?;
    let mesh = source.mesh()?;
    let pairs = |path: &Option<PathBuf>| {
        path.as_deref()
            .map_or(Ok(Vec::new()), |p| read_pairs(p, mesh.positions().len()))
    };
    let (cuts, seams) = (pairs(&args.cut)?, pairs(&args.sew)?);
    let cuts = SeamEdges {
        pairs: &cuts,
        angle: args.cut_angle.map(f64::to_radians),
    };
    let (set, around) =
        coordinates(args, &source, &mesh, &cuts, &seams).map_err(|e| source.fault(&e))?;
    source.finite(&mesh, &set)?;

    let mut written = Vec::new();
    let found = match args.report || args.json || args.pictures.is_some() {
        false => None,
        true => {
            let usual = ReportOptions::default();
            let options = ReportOptions {
                origin: Origin::BottomLeft,
                texture_size: args.texture_size.unwrap_or(usual.texture_size),
                ..usual
            };
            Some(report(&mesh, &set, &options).map_err(|e| source.fault(&e))?)
        }
    };
    if let Some(found) = found.as_ref().filter(|_| args.json) {
        table::ask_for_json(found, args.per_triangle, MemoryBudget::of_process())?;
    }
    let main = outputs.first().map(|path| Destination::new(path));
    if let Some(main) = main.transpose()? {
        let mut stage = Stage::new(&main)?;
        for path in outputs.iter().skip(1) {
            stage.prove(&Destination::new(path)?)?;
        }
        if let Some(path) = &args.output {
            let place = stage.add(Destination::new(path)?, "obj");
            let text = source.text(&set, path);
            fs::write(&place, text).map_err(|e| write_failed(path, &e))?;
            written.push(format!(
                "{}: {} coordinates for {} corners",
                path.display(),
                set.uvs.len(),
                set.corners.len()
            ));
        }
        if let Some(path) = &args.tangents {
            let place = stage.add(Destination::new(path)?, "npy");
            let found = source.tangents(&mesh, &set).map_err(|e| source.fault(&e))?;
            npy::write(
                &place,
                &[found.len(), 4],
                npy::Values::F32(found.as_flattened()),
            )?;
            written.push(format!("{}: {} tangents", path.display(), found.len()));
        }
        if let (Some(found), Some(folder)) = (&found, &args.pictures) {
            written.extend(pictures::draw(&mut stage, folder, &mesh, &set, found)?);
        }
        stage.commit()?;
    }
    if let Some(found) = &found {
        if args.report && !args.json {
            print(&table::text(&args.mesh, found))?;
        }
        if args.json {
            print_json(&table::json(&args.mesh, found, &around, args.per_triangle))?;
        }
    }
    let lost = unmapped(&mesh, &set).map_err(|e| source.fault(&e))?;
    if lost.fraction > 0.01 {
        let first = lost.face.map(|face| source.location(face as usize));
        say(&format!(
            "warning: {} % of the surface has no area in the picture ({} triangles, the first in {}): nothing can be drawn or baked there; give another --map, or a --frame that looks at it\n",
            digits(100.0 * lost.fraction),
            lost.triangles,
            first.unwrap_or_default(),
        ));
    }
    if !around.is_empty() {
        let faces: Vec<usize> = around.iter().map(|face| *face as usize).collect();
        say(&format!(
            "warning: {} faces enclose the axis of the shape and cannot be mapped right by their vertices ({}); divide them at the axis\n",
            around.len(),
            source.locations(&faces),
        ));
    }
    for line in written {
        say(&(line + "\n"));
    }
    Ok(Exit::Done)
}

/// The new coordinates, or those of the file; and the faces around the axis of a round shape.
fn coordinates(
    args: &UvArgs,
    source: &Source<'_>,
    mesh: &Mesh<'_>,
    cuts: &SeamEdges<'_>,
    seams: &[[u32; 2]],
) -> Result<(UvSet, Vec<u32>), UvError> {
    let usual = AtlasSize::default();
    let atlas = AtlasSize {
        size: args.pack.unwrap_or(usual.size),
        gutter: args.gutter.unwrap_or(usual.gutter),
    };
    let (mut set, mut around) = match args.map {
        Some(Map::Auto) => (auto_planes(mesh, atlas, Origin::BottomLeft)?, Vec::new()),
        Some(Map::Unwrap) => (
            unwrap(mesh, cuts, atlas, Origin::BottomLeft, &|_, _| {
                ControlFlow::Continue(())
            })?,
            Vec::new(),
        ),
        Some(map) => {
            let mapped =
                mapping(args, map).map(Level::new(), mesh, &source.obj.vertex_normals())?;
            (mapped.set, mapped.around_axis)
        }
        None => (source.set(mesh)?, Vec::new()),
    };
    let cutting = !cuts.pairs.is_empty() || cuts.angle.is_some();
    if cutting && args.map != Some(Map::Unwrap) {
        set = cut_seams(mesh, &set, cuts)?;
    }
    if !seams.is_empty() {
        set = sew_seams(mesh, &set, seams)?;
    }
    if args.pack.is_some()
        && (cutting || !seams.is_empty() || !matches!(args.map, Some(Map::Auto | Map::Unwrap)))
    {
        set = pack(mesh, &set, atlas)?;
    }
    if !args.fix_seams {
        around.clear();
    }
    Ok((set, around))
}

fn mapping(args: &UvArgs, map: Map) -> Mapping {
    let shape = match map {
        Map::Cylinder => Shape::Cylinder,
        Map::Cone => Shape::Cone,
        Map::Sphere => Shape::Sphere,
        Map::Box => Shape::Box,
        Map::Plane | Map::Auto | Map::Unwrap => Shape::Plane,
    };
    let by = match args.by {
        By::Position => ProjectionSource::Position,
        By::Normal => ProjectionSource::Normal,
        By::Centroid => ProjectionSource::Centroid,
        By::Reflection => ProjectionSource::Reflection {
            eye: DVec3::from(args.eye.map_or([0.0; 3], |t| t.0)),
        },
    };
    let frame = args.frame.map(
        |List([px, py, pz, yaw, pitch, roll, sx, sy, sz])| Placement {
            position: DVec3::new(px, py, pz),
            yaw: yaw.to_radians(),
            pitch: pitch.to_radians(),
            roll: roll.to_radians(),
            scale: DVec3::new(sx, sy, sz),
        },
    );
    Mapping {
        by,
        frame,
        tile: args.tile.map(|l| l.0),
        repeat: args.repeat.map_or([1.0; 2], |l| l.0),
        fix_seams: args.fix_seams,
        caps: !args.no_caps,
        origin: Origin::BottomLeft,
        ..Mapping::new(shape)
    }
}

/// Pairs of vertex numbers, from 1 in the file, from 0 here.
fn read_pairs(path: &Path, vertices: usize) -> Result<Vec<[u32; 2]>, Failure> {
    let text = FileSource::anywhere().read_text(path, FileSource::MAX_LIST)?;
    let mut pairs = Vec::new();
    for (line, content) in text.lines().enumerate() {
        let body = content.split('#').next().unwrap_or("").trim();
        if body.is_empty() {
            continue;
        }
        let numbers: Option<Vec<u32>> = body
            .split_whitespace()
            .map(|w| {
                w.parse()
                    .ok()
                    .filter(|n| (1..=vertices).contains(&(*n as usize)))
            })
            .collect();
        match numbers.as_deref() {
            Some([a, b]) => pairs.push([a - 1, b - 1]),
            _ => {
                // Nothing is quoted: the file may be anything.
                let what = format!("{}:{}: no pair of vertices", path.display(), line + 1);
                return Err(Failure::new(
                    Exit::Input,
                    "bad-pair",
                    what,
                    format!("write two numbers from 1 to {vertices}"),
                ));
            }
        }
    }
    Ok(pairs)
}

fn write_failed(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(
        Exit::Input,
        "write-failed",
        format!("{}: cannot be written: {error}", path.display()),
        "check the permissions and the free space",
    )
}
