//! The report as a table and as JSON.

use std::fmt::Write;
use std::path::Path;

use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use texmap_math::{MemoryBudget, OverBudget};
use texmap_uv::{Report, TJunction, TriangleReport};

use crate::digits::digits;
use crate::observe;

pub(super) fn text(path: &Path, r: &Report) -> String {
    let mut out = format!(
        "{}: {} faces, {} triangles\n",
        path.display(),
        r.faces,
        r.triangles.len()
    );
    let share = |n: usize| 100.0 * n as f64 / r.triangles.len().max(1) as f64;
    let mut row = |name: &str, value: String| {
        let _ = writeln!(out, "  {name:<22}{value}");
    };
    row(
        "stretch L2, Linf",
        format!(
            "{}, {}   (1 is best)",
            figure(r.stretch_l2),
            figure(r.stretch_linf)
        ),
    );
    row(
        "angle distortion",
        format!(
            "mean {}, most {}   (1 keeps angles)",
            figure(r.angle_mean),
            figure(r.angle_max)
        ),
    );
    row(
        "area distortion",
        format!(
            "mean {}, most {}   (1 keeps areas)",
            figure(r.area_mean),
            figure(r.area_max)
        ),
    );
    row(
        "texels per unit",
        format!(
            "{} to {}, mean {}",
            figure(r.density[0]),
            figure(r.density[2]),
            figure(r.density[1])
        ),
    );
    for (name, count) in [
        ("flipped", r.flipped),
        ("without area", r.collapsed),
        ("outside [0, 1]", r.outside),
        ("torn (du > 0.5)", r.wide),
    ] {
        row(
            name,
            format!("{count} triangles ({} %)", figure(share(count))),
        );
    }
    let least = if r.overlap_at_least { "at least " } else { "" };
    row(
        "overlapping",
        format!(
            "{least}{} triangles ({} %), {} pairs, area {}",
            r.overlapping,
            figure(share(r.overlapping)),
            r.overlap_pairs,
            figure(r.overlap_area)
        ),
    );
    row(
        "picture used",
        format!("{} %", figure(100.0 * r.picture_area)),
    );
    row("islands", r.islands.to_string());
    row(
        "seams",
        format!(
            "length {}, {} % of it seen from 14 sides",
            figure(r.seam_length),
            figure(100.0 * r.seam_seen)
        ),
    );
    row("rim", format!("length {}", figure(r.rim_length)));
    if r.non_manifold_edges > 0 {
        row("non-manifold edges", r.non_manifold_edges.to_string());
    }
    if r.t_junctions.count > 0 {
        let least = if r.t_junctions.at_least {
            "at least "
        } else {
            ""
        };
        row(
            "T-junctions",
            format!(
                "{least}{} vertices inside an edge of another face",
                r.t_junctions.count
            ),
        );
    }
    if r.degenerate > 0 {
        row("no area in space", format!("{} triangles", r.degenerate));
    }
    out
}

/// Six significant digits; `-` for a figure that there is not.
fn figure(x: f64) -> String {
    match x {
        _ if x.is_nan() => "-".into(),
        _ if x.is_infinite() => "infinite".into(),
        _ => digits(x),
    }
}

/// The report as JSON. Lists are written one entry at a time: as trees of values they would take ten times the memory.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    #[serde(flatten)]
    figures: Value,
    #[serde(serialize_with = "joints")]
    t_joints: &'a [TJunction],
    #[serde(
        skip_serializing_if = "Option::is_none",
        serialize_with = "each_triangle"
    )]
    per_triangle: Option<&'a [TriangleReport]>,
}

/// JSON knows no infinity: such a figure is null.
pub(super) fn json<'a>(
    path: &Path,
    r: &'a Report,
    around_axis: &[u32],
    per_triangle: bool,
) -> Document<'a> {
    let joints = &r.t_junctions;
    let figures = json!({
        "file": path.display().to_string(),
        "uv_origin": "bottom-left",
        "faces": r.faces,
        "triangles": r.triangles.len(),
        "stretch": { "l2": r.stretch_l2, "linf": r.stretch_linf },
        "angle_distortion": { "mean": r.angle_mean, "max": r.angle_max },
        "area_distortion": { "mean": r.area_mean, "max": r.area_max },
        "texels_per_unit": { "min": r.density[0], "mean": r.density[1], "max": r.density[2] },
        "flipped": r.flipped,
        "collapsed": r.collapsed,
        "outside": r.outside,
        "torn": r.wide,
        "overlap": { "triangles": r.overlapping, "pairs": r.overlap_pairs, "area": r.overlap_area, "lower_bound": r.overlap_at_least },
        "picture_area": r.picture_area,
        "surface_area": r.surface_area,
        "shells": r.islands,
        "seam": { "length": r.seam_length, "seen": r.seam_seen },
        "rim_length": r.rim_length,
        "non_manifold_edges": r.non_manifold_edges,
        "degenerate": r.degenerate,
        "t_joints_count": joints.count,
        "t_joints_lower_bound": joints.at_least || joints.count > joints.list.len(),
        "faces_around_axis": around_axis,
    });
    Document {
        figures,
        t_joints: &joints.list,
        per_triangle: per_triangle.then_some(&r.triangles[..]),
    }
}

/// Asks for the memory of [`json`] and its text.
pub(super) fn ask_for_json(
    r: &Report,
    per_triangle: bool,
    budget: MemoryBudget,
) -> Result<(), OverBudget> {
    // Three copies of the text of an entry; a batch makes a tree of values of it.
    let [joint, triangle] = if observe::is_on() {
        [2000, 4000]
    } else {
        [400, 1200]
    };
    let joints = r.t_junctions.list.len();
    let triangles = if per_triangle { r.triangles.len() } else { 0 };
    budget.ask(
        (joints * joint + triangles * triangle) as u64,
        format_args!("the JSON of {joints} T-junctions and {triangles} triangles"),
        "leave out --per-triangle, or ask for --report instead of --json",
    )
}

fn joints<S: Serializer>(list: &[TJunction], to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Joint {
        edge: [u32; 2],
        face: u32,
        vertex: u32,
    }
    to.collect_seq(list.iter().map(|j| Joint {
        edge: j.edge,
        face: j.face,
        vertex: j.vertex,
    }))
}

/// One object for each triangle of the faces' fans, in order; an infinite figure is null.
fn each_triangle<S: Serializer>(
    triangles: &Option<&[TriangleReport]>,
    to: S,
) -> Result<S::Ok, S::Error> {
    let triangle = |t: &TriangleReport| {
        json!({
            "face": t.face,
            "stretch": { "l2": t.l2, "linf": t.linf },
            "angle_distortion": t.angle,
            "area_distortion": t.area,
            "texels_per_unit": t.density,
            "flipped": t.flipped,
            "collapsed": t.collapsed,
            "overlapping": t.overlapping,
            "outside": t.outside,
        })
    };
    to.collect_seq(triangles.iter().copied().flatten().map(triangle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_uv::{Faces, Mesh, ReportOptions, UvSet, report};

    /// A grid of squares that is its own picture, and a triangle with vertices of them inside its edges.
    fn grid(side: u32) -> Report {
        let positions: Vec<[f32; 3]> = (0..=side)
            .flat_map(|y| (0..=side).map(move |x| [x as f32, y as f32, 0.0]))
            .collect();
        let mut faces = Faces::new();
        let row = side + 1;
        for k in (1..=side).flat_map(|y| (1..=side).map(move |x| y * row + x)) {
            faces.push(&[k - row - 1, k - row, k, k - 1]);
        }
        faces.push(&[2, 0, row * side]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let set = UvSet {
            uvs: positions.iter().map(|p| [p[0], p[1]]).collect(),
            corners: faces.corners().to_vec(),
        };
        report(&mesh, &set, &ReportOptions::default()).unwrap()
    }

    #[test]
    fn lists_stand_in_the_document_if_they_are_asked_for() {
        let found = grid(3);
        let text = |per_triangle| {
            let document = json(Path::new("a.obj"), &found, &[7], per_triangle);
            serde_json::to_value(document).unwrap()
        };
        let (short, long) = (text(false), text(true));
        let joints = &found.t_junctions;
        assert!(joints.count > 0);
        assert_eq!(short["t_joints"].as_array().unwrap().len(), joints.count);
        assert_eq!(short["t_joints_count"], joints.count);
        assert_eq!(short["t_joints"][0]["vertex"], joints.list[0].vertex);
        assert_eq!(short["t_joints_lower_bound"], false);
        assert_eq!(
            (&short["faces"], &short["faces_around_axis"][0]),
            (&json!(10), &json!(7))
        );
        assert!(short.get("per_triangle").is_none());
        assert_eq!(long["per_triangle"].as_array().unwrap().len(), 19);
        assert_eq!(long["per_triangle"][18]["face"], 9);
    }

    #[test]
    fn the_memory_of_lists_is_asked_for() {
        let found = grid(140);
        let budget = MemoryBudget::new(20 << 20);
        assert_eq!(ask_for_json(&found, false, budget), Ok(()));
        let refused = ask_for_json(&found, true, budget).unwrap_err();
        assert!(refused.to_string().contains("39201 triangles"), "{refused}");
        assert!(refused.lower.contains("--per-triangle"));
        // The memory asked for holds the text three times.
        let text = serde_json::to_string_pretty(&json(Path::new("a.obj"), &found, &[], true));
        let text = text.unwrap().len() as u64;
        assert!(3 * text <= refused.bytes, "{text} of {}", refused.bytes);
    }
}
