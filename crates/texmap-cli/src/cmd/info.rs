//! `texmap info`: the contents of a scene or model, and missing files.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use texmap_io::{FileInfo, LoadOptions, MeshInfo, NamedFile, shown};

use crate::cmd::Root;
use crate::digits::digits;
use crate::failure::{self, Exit, Failure, say_always};

/// Show meshes, materials, cameras, animations, maps, uv ranges and missing files of a scene, model or image.
#[derive(Args, Debug)]
#[command(after_help = "Exit code 3 when a file that it names is missing or broken.")]
pub(crate) struct InfoArgs {
    /// A .scene, .obj, .gltf, .glb, .ply, .stl or image file
    file: PathBuf,
    #[command(flatten)]
    root: Root,
    /// Print the same as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &InfoArgs) -> Result<Exit, Failure> {
    let options = LoadOptions {
        files: args.root.files()?,
        ..LoadOptions::default()
    };
    let info = texmap_io::info_with(&args.file, &options)?;
    if args.json {
        failure::print_json(&info)?;
    } else {
        failure::print(&words(&info))?;
    }
    let problems: Vec<&NamedFile> = info.problems().collect();
    for file in &problems {
        let problem = file.problem.as_deref().unwrap_or_default();
        say_always(&format!("error[named-file]: {problem}\n"));
    }
    Ok(if problems.is_empty() {
        Exit::Done
    } else {
        Exit::Partial
    })
}

fn words(info: &FileInfo) -> String {
    let mut text = format!("{} ({})\n", shown(&info.file), info.kind);
    if !info.meshes.is_empty() {
        let triangles: usize = info.meshes.iter().map(|m| m.triangles).sum();
        let _ = writeln!(
            text,
            "{} meshes, {triangles} triangles, {} lights",
            info.meshes.len(),
            info.lights
        );
    }
    if let Some(([x, y, z], radius)) = info.sphere {
        let _ = writeln!(
            text,
            "sphere of radius {} around {} {} {}",
            digits(radius),
            digits(x),
            digits(y),
            digits(z)
        );
    }
    if info.t_joints > 0 {
        let _ = writeln!(
            text,
            "{}{} T-junctions: vertices inside an edge of another face, where pixels may be missing",
            if info.t_joints_at_least {
                "at least "
            } else {
                ""
            },
            info.t_joints
        );
    }
    let mut rows = Vec::new();
    if !info.meshes.is_empty() {
        rows.push(
            [
                "mesh",
                "vertices",
                "faces",
                "triangles",
                "u",
                "v",
                "material",
            ]
            .map(str::to_owned),
        );
        rows.extend(info.meshes.iter().map(mesh_row));
        text.push_str(&table(&rows));
    }
    if !info.files.is_empty() {
        let mut rows = vec![["file", "size", "bits", "named by"].map(str::to_owned)];
        rows.extend(info.files.iter().map(file_row));
        text.push_str(&table(&rows));
    }
    text.push_str(&choices(info));
    for warning in &info.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}

/// Cameras and animations that `render` can choose, and the extensions of the file.
fn choices(info: &FileInfo) -> String {
    let mut text = String::new();
    let named = |number: usize, name: &str| match name {
        "" => number.to_string(),
        name => format!("{number} '{name}'"),
    };
    let lines = info.cameras.iter().enumerate().map(|(i, camera)| {
        let kind = if camera.orthographic {
            "parallel"
        } else {
            "perspective"
        };
        format!("camera {}: {kind}", named(i, &camera.name))
    });
    let lines = lines.chain(info.animations.iter().enumerate().map(|(i, animation)| {
        let name = named(i, &animation.name);
        format!(
            "animation {name}: {} s, {} channels",
            digits(animation.seconds),
            animation.channels
        )
    }));
    let lines = lines.chain(info.extensions.iter().map(|extension| {
        let required = if extension.required {
            " (required)"
        } else {
            ""
        };
        format!(
            "extension {}{required}: {}",
            extension.name, extension.support
        )
    }));
    for line in lines {
        text.push_str(&line);
        text.push('\n');
    }
    match text.is_empty() {
        true => text,
        false => format!("\n{text}"),
    }
}

fn mesh_row(mesh: &MeshInfo) -> [String; 7] {
    let range = |axis: usize| {
        mesh.uv.map_or_else(
            || "-".to_owned(),
            |[low, high]| {
                let [low, high] = [low, high].map(|end| digits(f64::from(end[axis])));
                format!("{low}..{high}")
            },
        )
    };
    [
        mesh.name.clone(),
        mesh.vertices.to_string(),
        mesh.faces.to_string(),
        mesh.triangles.to_string(),
        range(0),
        range(1),
        mesh.material.clone(),
    ]
}

fn file_row(file: &NamedFile) -> [String; 4] {
    let size = match (file.size, &file.problem) {
        (Some([width, height]), _) => format!("{width} x {height}"),
        (None, Some(_)) => "unusable".to_owned(),
        (None, None) => "-".to_owned(),
    };
    let bits = file.bits.map_or_else(|| "-".to_owned(), |b| b.to_string());
    [
        shown(&file.path).to_string(),
        size,
        bits,
        file.named_by.clone(),
    ]
}

/// Columns as wide as their widest entry, two spaces apart; an empty line above.
fn table<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| {
        rows.iter()
            .map(|row| row[column].chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::from("\n");
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .zip(widths)
            .map(|(cell, width)| cell.clone() + &" ".repeat(width - cell.chars().count()))
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_align_by_characters() {
        let row = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
        assert_eq!(table(&[row("é", "b"), row("abc", "")]), "\né    b\nabc\n");
        // Wider than a format width may be.
        let wide = "w".repeat(70_000);
        let text = table(&[row(&wide, "b"), row("a", "c")]);
        assert_eq!(text.lines().nth(2).map(str::len), Some(70_003));
    }
}
