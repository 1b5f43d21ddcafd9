//! The report as a table and as JSON.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};
use texmap_uv::Report;

use crate::digits::digits;

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

/// JSON knows no infinity: such a figure is null.
pub(super) fn json(path: &Path, r: &Report, around_axis: &[u32]) -> Value {
    json!({
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
        "t_joints": r.t_junctions.list.iter().map(|j| json!({ "vertex": j.vertex, "face": j.face, "edge": j.edge })).collect::<Vec<_>>(),
        "t_joints_count": r.t_junctions.count,
        "t_joints_lower_bound": r.t_junctions.at_least || r.t_junctions.count > r.t_junctions.list.len(),
        "faces_around_axis": around_axis,
    })
}

/// One object for each triangle of the faces' fans, in order; an infinite figure is null.
pub(super) fn per_triangle(r: &Report) -> Value {
    let triangle = |t: &texmap_uv::TriangleReport| {
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
    r.triangles.iter().map(triangle).collect()
}
