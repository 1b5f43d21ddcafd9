//! Unwrappers held against one another on three meshes, by the report of `texmap-uv`.
//!
//! `cargo run --release -p texmap-benches --features unwrappers --bin unwrappers` writes
//! `benches/results/unwrappers.md`, which docs/generated/uv-mappings.md takes over. With arguments `-- MESH UNWRAPPER` (a part of
//! each name, such as `knot uvgen`) only those rows are measured, and the file's others stay.

#![allow(clippy::print_stdout, reason = "the figures are the output")]

use std::error::Error;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use texmap_benches::meshes::{self, knot};
use texmap_io::{LoadOptions, load_model};
use texmap_uv::{
    AtlasSize, Faces, Mesh, Origin, ReportOptions, SeamEdges, UvSet, auto_planes, report, unwrap,
};

const PAGE: AtlasSize = AtlasSize {
    size: 1024,
    gutter: 4,
};

/// A way to unwrap.
struct Candidate {
    name: &'static str,
    run: fn(&Mesh<'_>) -> Result<UvSet, Box<dyn Error>>,
}

const CANDIDATES: [Candidate; 5] = [
    Candidate {
        name: "uvunwrap 0.3, as `--map unwrap` uses it",
        run: |mesh| {
            Ok(unwrap(
                mesh,
                &SeamEdges::default(),
                PAGE,
                Origin::BottomLeft,
                &|_, _| ControlFlow::Continue(()),
            )?)
        },
    },
    Candidate {
        name: "uvunwrap 0.3, charts within 40 degrees",
        run: |mesh| {
            uvunwrap(
                mesh,
                uvunwrap::Options {
                    max_chart_angle: 40.0,
                    packing: uvunwrap::Packing::Fast,
                    ..uvunwrap::Options::default()
                },
            )
        },
    },
    Candidate {
        name: "uvunwrap 0.3, packed by shape",
        run: |mesh| uvunwrap(mesh, uvunwrap::Options::default()),
    },
    Candidate {
        name: "uvgen 0.5 (six planes)",
        run: uvgen,
    },
    Candidate {
        name: "texmap `--map auto` (six planes)",
        run: |mesh| Ok(auto_planes(mesh, PAGE, Origin::BottomLeft)?),
    },
];

const HEAD: &str = "| mesh | triangles | unwrapper | stretch L2 | Linf | flipped | overlapping | seam | shells | picture used | seconds |\n\
                    |---|---|---|---|---|---|---|---|---|---|---|\n";

/// A candidate is stopped after this.
const LIMIT: Duration = Duration::from_secs(900);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let model = |name: &str| read(&root.join(format!("../assets/models/{name}.obj")));
    let inputs = [
        ("teapot", model("teapot")?),
        ("cow", model("cow")?),
        ("knot", knot(100_000)),
    ];
    if let [one, mesh, candidate] = &arguments[..]
        && one == "--one"
    {
        let (_, (positions, faces)) = &inputs[mesh.parse::<usize>()?];
        println!(
            "{}",
            figures(positions, faces, &CANDIDATES[candidate.parse::<usize>()?])?
        );
        return Ok(());
    }
    let part = |k: usize| arguments.get(k).map_or("", String::as_str);
    let path = root.join("results/unwrappers.md");
    let before = std::fs::read_to_string(&path).unwrap_or_default();
    let mut table = String::from(HEAD);
    for (i, (name, (_, faces))) in inputs.iter().enumerate() {
        for (k, candidate) in CANDIDATES.iter().enumerate() {
            let row = format!("| {name} | {} | {} |", faces.len(), candidate.name);
            let known = before.lines().find(|l| l.starts_with(&row));
            let wanted = name.contains(part(0)) && candidate.name.contains(part(1));
            let line = match known {
                Some(line) if !wanted => line.to_owned(),
                _ if !wanted => continue,
                _ => format!("{row} {} |", apart(i, k)?),
            };
            println!("{line}");
            let _ = writeln!(table, "{line}");
        }
    }
    std::fs::write(path, table)?;
    Ok(())
}

/// The figures of one candidate on one mesh, from a process of its own: some never come to an end.
fn apart(mesh: usize, candidate: usize) -> Result<String, Box<dyn Error>> {
    let start = Instant::now();
    let mut child = Command::new(std::env::current_exe()?)
        .args(["--one", &mesh.to_string(), &candidate.to_string()])
        .stdout(Stdio::piped())
        .spawn()?;
    while child.try_wait()?.is_none() {
        if start.elapsed() > LIMIT {
            child.kill()?;
            child.wait()?;
            return Ok(format!("stopped | | | | | | | > {}", LIMIT.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output()?;
    let text = String::from_utf8(output.stdout)?;
    Ok(if output.status.success() {
        text.trim().to_owned()
    } else {
        format!(
            "{} | | | | | | | {:.2}",
            output.status,
            start.elapsed().as_secs_f64()
        )
    })
}

fn figures(
    positions: &[[f32; 3]],
    faces: &Faces,
    candidate: &Candidate,
) -> Result<String, Box<dyn Error>> {
    let mesh = Mesh::new(positions, faces)?;
    let start = Instant::now();
    let set = (candidate.run)(&mesh);
    let seconds = start.elapsed().as_secs_f64();
    let options = ReportOptions {
        origin: Origin::BottomLeft,
        views: false,
        ..ReportOptions::default()
    };
    Ok(
        match set.and_then(|set| Ok(report(&mesh, &set, &options)?)) {
            Ok(r) => format!(
                "{:.3} | {:.2} | {} | {} | {:.1} | {} | {:.0} % | {seconds:.2}",
                r.stretch_l2,
                r.stretch_linf,
                r.flipped,
                r.overlapping,
                r.seam_length,
                r.islands,
                100.0 * r.picture_area
            ),
            Err(e) => format!("{e} | | | | | | | {seconds:.2}"),
        },
    )
}

fn uvunwrap(mesh: &Mesh<'_>, options: uvunwrap::Options) -> Result<UvSet, Box<dyn Error>> {
    let corners = mesh.faces().corners();
    let options = uvunwrap::Options {
        density: uvunwrap::Density::Auto {
            page_size: PAGE.size,
        },
        padding: PAGE.gutter / 2,
        ..options
    };
    let atlas = uvunwrap::generate(
        &[uvunwrap::MeshInput::new(mesh.positions(), corners)],
        &options,
    )?;
    let out = &atlas.meshes[0];
    // The atlas is cropped; made square again, it keeps its texels.
    let part = [atlas.width, atlas.height].map(|s| s as f32 / PAGE.size as f32);
    let uv = |i: &u32| {
        let [u, v] = out.vertices[*i as usize].uv;
        [u * part[0], v * part[1]]
    };
    Ok(UvSet {
        uvs: out.indices.iter().map(uv).collect(),
        corners: (0..corners.len() as u32).collect(),
    })
}

fn uvgen(mesh: &Mesh<'_>) -> Result<UvSet, Box<dyn Error>> {
    let positions = mesh.positions().iter().map(|p| Vector3::from(*p));
    let (triangles, _) = mesh.faces().corners().as_chunks::<3>();
    let spacing = PAGE.gutter as f32 / PAGE.size as f32 / 2.0;
    let patch =
        uvgen::generate_uvs(positions, triangles.iter().copied(), spacing).ok_or("it gives up")?;
    let uvs = patch.second_tex_coords.iter().map(|uv| [uv.x, uv.y]);
    Ok(UvSet {
        uvs: uvs.collect(),
        corners: patch.triangles.concat(),
    })
}

/// Positions and triangles of an OBJ, its materials joined.
fn read(path: &Path) -> Result<meshes::Mesh, Box<dyn Error>> {
    let scene = load_model(path, &LoadOptions::default())?;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let base = positions.len() as u32;
        positions.extend(&mesh.positions);
        triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + base)));
    }
    Ok((positions, Faces::from_triangles(&triangles)))
}
