//! `texmap uv-raster`: a mesh drawn into its own texture space, for bakes and transfers.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use texmap_io::{image_io, npy};
use texmap_math::MemoryBudget;
use texmap_raster::{
    Atlas, AtlasMesh, AtlasOptions, Coverage, NO_PRIMITIVE, RasterError, TargetSize,
};

use super::uv::source::Source;
use crate::failure::{Exit, Failure, print_json, say};
use crate::observe;
use crate::output::{Destination, Stage, distinct};

/// Draw a mesh into its texture space: face, barycentric weights, position and normal of every texel.
///
/// Writes PREFIX.face.npy (number of the face in the file, from 0), PREFIX.triangle.npy (row of PREFIX.triangles.npy,
/// which lists face and three vertices), PREFIX.barycentric.npy (weights of these vertices), PREFIX.position.npy,
/// PREFIX.normal.npy and PREFIX.coverage.npy (0 free, 1 centre covered, 2 touched, 3 gutter), and each of them as PNG.
/// Rows run from the top, so v = 1 is row 0. Free texels have face 4294967295. The first of overlapping faces wins.
#[derive(Args, Debug)]
#[command(
    after_help = "Needs texture coordinates: `texmap uv MESH -o OUT.obj --map unwrap` makes some."
)]
pub(crate) struct UvRasterArgs {
    /// An OBJ or PLY file with texture coordinates
    mesh: PathBuf,
    /// Prefix of the names of the files to write
    #[arg(short, long, value_name = "PREFIX")]
    output: PathBuf,
    /// Edge of the atlas in texels; memory is about 70 bytes a texel
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=i64::from(TargetSize::MAX)))]
    size: u32,
    /// Also texels that a face only touches: no face inside the atlas is lost, however small
    #[arg(long)]
    conservative: bool,
    /// Texels by which islands are dilated
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=4_096))]
    gutter: u32,
    /// Write no PNG, only the arrays
    #[arg(long)]
    no_pictures: bool,
    /// Worker threads; default: as many as the machine gives. No byte depends on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print figures as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Endings of the arrays.
const ARRAYS: [&str; 7] = [
    "face.npy",
    "triangle.npy",
    "triangles.npy",
    "barycentric.npy",
    "position.npy",
    "normal.npy",
    "coverage.npy",
];

/// Endings of the pictures.
const PICTURES: [&str; 5] = [
    "face.png",
    "barycentric.png",
    "position.png",
    "normal.png",
    "coverage.png",
];

pub(crate) fn run(args: &UvRasterArgs) -> Result<Exit, Failure> {
    let outputs = ARRAYS.iter().chain(&PICTURES);
    distinct(
        outputs.map(|ending| named(&args.output, ending)),
        [&args.mesh],
    )?;
    let main = Destination::new(&named(&args.output, "face.npy"))?;
    let source = Source::read(&args.mesh)?;
    let mesh = source.mesh()?;
    let set = source.set(&mesh).map_err(|e| source.fault(&e))?;
    let (uvs, normals) = (set.per_corner(), source.corner_normals(&mesh));
    let corners = mesh.faces().corners();
    let positions: Vec<[f32; 3]> = corners
        .iter()
        .map(|&i| mesh.positions()[i as usize])
        .collect();
    let (faces, indices): (Vec<usize>, Vec<[u32; 3]>) = mesh
        .faces()
        .triangles()
        .map(|(face, corners)| (face, corners.map(|k| k as u32)))
        .unzip();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(
            args.threads
                .map_or_else(rayon::current_num_threads, usize::from),
        )
        .build()
        .map_err(|e| Failure::internal(format!("no threads: {e}")))?;
    let options = AtlasOptions {
        conservative: args.conservative,
        gutter: args.gutter,
        threads: pool.current_num_threads(),
        ..AtlasOptions::default()
    };
    let atlas_mesh = AtlasMesh {
        uvs: &uvs,
        positions: &positions,
        normals: &normals,
        indices: &indices,
        bottom_up: true,
    };
    let refused = |e| match e {
        RasterError::Memory(refused) => Failure::from(refused),
        e => Failure::internal(format!("the atlas refused a checked mesh: {e}")),
    };
    let size = TargetSize::new(args.size, args.size).map_err(refused)?;
    let atlas = pool
        .install(|| Atlas::new(size, &atlas_mesh, options))
        .map_err(refused)?;
    let triangles: Vec<u32> = faces
        .iter()
        .zip(&indices)
        .flat_map(|(&face, t)| {
            let [a, b, c] = t.map(|k| corners[k as usize]);
            [face as u32, a, b, c]
        })
        .collect();

    let mut stage = Stage::new(&main)?;
    let names = write(args, &atlas, &triangles, &mut stage)?;
    stage.commit()?;
    report(args, &source, &atlas, &faces, &names)?;
    Ok(Exit::Done)
}

/// `PREFIX.ending`.
fn named(prefix: &Path, ending: &str) -> PathBuf {
    let mut name = prefix.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    name.into()
}

/// Writes the arrays and the pictures into the stage; their names.
fn write(
    args: &UvRasterArgs,
    atlas: &Atlas,
    triangles: &[u32],
    stage: &mut Stage,
) -> Result<Vec<PathBuf>, Failure> {
    let side = args.size as usize;
    // The file's faces and the coverage as numbers, then one picture at a time.
    MemoryBudget::of_process().ask(
        atlas.face.len() as u64 * (4 + 1 + 4),
        format_args!("the arrays of an atlas of {side} x {side} texels"),
        "give a smaller --size",
    )?;
    let face: Vec<u32> = atlas
        .face
        .iter()
        .map(|&t| match t {
            NO_PRIMITIVE => NO_PRIMITIVE,
            t => triangles[4 * t as usize],
        })
        .collect();
    let coverage: Vec<u8> = atlas.coverage.iter().map(|c| *c as u8).collect();
    let three = [side, side, 3];
    let arrays: [(&str, &[usize], npy::Values<'_>); 7] = [
        ("face", &three[..2], npy::Values::U32(&face)),
        ("triangle", &three[..2], npy::Values::U32(&atlas.face)),
        (
            "triangles",
            &[triangles.len() / 4, 4],
            npy::Values::U32(triangles),
        ),
        ("barycentric", &three, f32s(&atlas.barycentric)),
        ("position", &three, f32s(&atlas.position)),
        ("normal", &three, f32s(&atlas.normal)),
        ("coverage", &three[..2], npy::Values::U8(&coverage)),
    ];
    let mut names = Vec::new();
    let mut place = |name: &str, ending: &str, stage: &mut Stage| -> Result<PathBuf, Failure> {
        let path = named(&args.output, &format!("{name}.{ending}"));
        let at = stage.add(Destination::new(&path)?, ending);
        names.push(path);
        Ok(at)
    };
    for (name, shape, values) in arrays {
        npy::write(&place(name, "npy", stage)?, shape, values)?;
    }
    if !args.no_pictures {
        for (name, texel) in pictures(atlas, &face) {
            let free = |at: usize| atlas.face[at] == NO_PRIMITIVE;
            let rgba: Vec<[u8; 4]> = (0..face.len())
                .map(|at| match free(at) {
                    true => [0; 4],
                    false => {
                        let [r, g, b] = texel(at);
                        [r, g, b, 255]
                    }
                })
                .collect();
            let rgba = rgba.as_flattened();
            image_io::write_png(&place(name, "png", stage)?, args.size, args.size, rgba)?;
        }
    }
    Ok(names)
}

fn f32s(values: &[[f32; 3]]) -> npy::Values<'_> {
    npy::Values::F32(values.as_flattened())
}

/// The colour of a texel.
type Paint<'a> = Box<dyn Fn(usize) -> [u8; 3] + 'a>;

/// The values that each picture shows at a texel that has a face.
fn pictures<'a>(atlas: &'a Atlas, face: &'a [u32]) -> Vec<(&'static str, Paint<'a>)> {
    let byte = |x: f32| texmap_math::color::unit_to_u8(x);
    let taken = atlas.position.iter().zip(&atlas.face);
    let (low, high) = taken.filter(|(_, f)| **f != NO_PRIMITIVE).fold(
        ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
        |(low, high): ([f32; 3], [f32; 3]), (p, _)| {
            (
                [0, 1, 2].map(|k| low[k].min(p[k])),
                [0, 1, 2].map(|k| high[k].max(p[k])),
            )
        },
    );
    let extent = (0..3)
        .map(|k| high[k] - low[k])
        .fold(f32::MIN_POSITIVE, f32::max);
    vec![
        // Neighbouring numbers get colours far apart (the golden ratio of 2^32, Knuth 1973).
        (
            "face",
            Box::new(move |at| {
                let mixed = (face[at] + 1).wrapping_mul(2_654_435_769);
                [mixed >> 24, mixed >> 16, mixed >> 8].map(|c| 48 + (c as u8) / 5 * 4)
            }),
        ),
        (
            "barycentric",
            Box::new(move |at| atlas.barycentric[at].map(byte)),
        ),
        // The longest side of the object's box is 0 to 255.
        (
            "position",
            Box::new(move |at| [0, 1, 2].map(|k| byte((atlas.position[at][k] - low[k]) / extent))),
        ),
        (
            "normal",
            Box::new(move |at| atlas.normal[at].map(|c| byte(c * 0.5 + 0.5))),
        ),
        (
            "coverage",
            Box::new(move |at| match atlas.coverage[at] {
                Coverage::None => [0; 3],
                Coverage::Centre => [255; 3],
                Coverage::Touched => [255, 160, 0],
                Coverage::Gutter => [64, 96, 160],
            }),
        ),
    ]
}

fn report(
    args: &UvRasterArgs,
    source: &Source<'_>,
    atlas: &Atlas,
    faces: &[usize],
    names: &[PathBuf],
) -> Result<(), Failure> {
    let count = |kind| atlas.coverage.iter().filter(|c| **c == kind).count();
    let [free, centre, touched, gutter] = [
        Coverage::None,
        Coverage::Centre,
        Coverage::Touched,
        Coverage::Gutter,
    ]
    .map(count);
    if args.json || observe::is_on() {
        print_json(&json!({
            "file": args.mesh.display().to_string(),
            "size": [args.size, args.size],
            "faces": source.obj.faces().len(),
            "triangles": faces.len(),
            "conservative": args.conservative,
            "gutter": args.gutter,
            "texels": { "centre": centre, "touched": touched, "gutter": gutter, "free": free },
            "lost_triangles": atlas.lost,
            "files": names.iter().map(|n| n.display().to_string()).collect::<Vec<_>>(),
        }))?;
    }
    if !atlas.lost.is_empty() {
        let lost: Vec<usize> = atlas.lost.iter().map(|t| faces[*t as usize]).collect();
        let advice = if args.conservative {
            "they lie outside of [0, 1] or under others; a larger --size may hold more"
        } else {
            "they lie outside of [0, 1], under others, or between texel centres; try --conservative or a larger --size"
        };
        say(&format!(
            "warning: {} of {} triangles own no texel ({}): {advice}\n",
            atlas.lost.len(),
            faces.len(),
            source.locations(&lost),
        ));
    }
    say(&format!(
        "{}.*: {} files; {centre} texels by their centre, {touched} touched, {gutter} of gutters, {free} free\n",
        args.output.display(),
        names.len(),
    ));
    Ok(())
}
