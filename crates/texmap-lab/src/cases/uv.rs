//! U1 to U5 and B4: seams, poles, latitudes, box ties, collapsed triangles, tangents.

use texmap_math::Level;
use texmap_math::glam::DVec3;
use texmap_math::{deterministic_f32, deterministic_f64};
use texmap_uv::{
    Faces, Mapping, Mesh, Origin, Projection, ReportOptions, Shape, UvSet, project, report,
    sphere_uv_at, tangents,
};

use super::Measurement;
use crate::LabError;

/// A ball of 32 x 16 squares cut in triangles, without split vertices.
fn ball() -> (Vec<[f32; 3]>, Faces) {
    let (around, down) = (32u32, 16u32);
    let mut positions = vec![[0.0, 1.0, 0.0]];
    for j in 1..down {
        let (sin, cos) =
            deterministic_f64::sin_cos(f64::from(j) / f64::from(down) * std::f64::consts::PI);
        for i in 0..around {
            let (z, x) = deterministic_f64::sin_cos(
                f64::from(i) / f64::from(around) * std::f64::consts::TAU,
            );
            positions.push([sin * x, cos, -sin * z].map(|c| c as f32));
        }
    }
    positions.push([0.0, -1.0, 0.0]);
    let last = positions.len() as u32 - 1;
    let ring = |j: u32, i: u32| 1 + (j - 1) * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, ring(1, i), ring(1, i + 1)]);
        for j in 1..down - 1 {
            triangles.push([ring(j, i), ring(j + 1, i), ring(j + 1, i + 1)]);
            triangles.push([ring(j, i), ring(j + 1, i + 1), ring(j, i + 1)]);
        }
        triangles.push([ring(down - 1, i), last, ring(down - 1, i + 1)]);
    }
    (positions, Faces::from_triangles(&triangles))
}

fn corners(faces: &Faces, set: &UvSet, face: usize) -> [[f32; 2]; 3] {
    let start = faces.range(face).start;
    [0, 1, 2].map(|k| set.at(start + k))
}

/// Triangles whose u differs by more than half of the picture.
fn torn(faces: &Faces, uv: impl Fn(usize) -> [[f32; 2]; 3]) -> f64 {
    let wide = |t: [[f32; 2]; 3]| (0..3).any(|k| (t[k][0] - t[(k + 1) % 3][0]).abs() > 0.5);
    (0..faces.len()).filter(|f| wide(uv(*f))).count() as f64
}

fn sphere(mesh: &Mesh<'_>, fix_seams: bool) -> Result<UvSet, LabError> {
    Ok(Mapping {
        fix_seams,
        ..Mapping::new(Shape::Sphere)
    }
    .map(Level::new(), mesh, &[])?
    .set)
}

/// U1: triangles across the seam of longitude.
pub(super) fn u1() -> Result<Vec<Measurement>, LabError> {
    let (positions, faces) = ball();
    let mesh = Mesh::new(&positions, &faces)?;
    let measure = "triangles with a difference of u above 0.5";
    let count = |set: &UvSet| torn(&faces, |f| corners(&faces, set, f));
    Ok(measured![
        "unwrapped per face", measure => count(&sphere(&mesh, true)?);
        "u of each vertex", measure => count(&sphere(&mesh, false)?);
    ])
}

/// U2: vertices on the pole, and a vertex at the centre.
pub(super) fn u2() -> Result<Vec<Measurement>, LabError> {
    let (positions, faces) = ball();
    let mesh = Mesh::new(&positions, &faces)?;
    // Distance of u at the pole from the mean of the other two.
    let off = |set: &UvSet| {
        let last = positions.len() as u32 - 1;
        let distance = |f: usize| {
            let uv = corners(&faces, set, f);
            let pole = faces.face(f).iter().position(|i| *i == 0 || *i == last)?;
            let mean = (uv[(pole + 1) % 3][0] + uv[(pole + 2) % 3][0]) / 2.0;
            Some(f64::from((uv[pole][0] - mean).abs()))
        };
        (0..faces.len()).filter_map(distance).fold(0.0, f64::max)
    };
    let centre = [[0.0; 3], [1.0, 0.5, 0.0], [0.0, -1.0, 1.0]];
    let one = Faces::from_triangles(&[[0, 1, 2]]);
    let through = Mesh::new(&centre, &one)?;
    let with_centre = Mapping {
        frame: Some(texmap_uv::Placement::upright(DVec3::ZERO, DVec3::ONE)),
        ..Mapping::new(Shape::Sphere)
    }
    .map(Level::new(), &through, &[])?
    .set;
    let bad = |set: &UvSet| {
        set.uvs
            .as_flattened()
            .iter()
            .filter(|c| !c.is_finite())
            .count() as f64
    };
    let measure = "u of a pole less the mean of the other two corners";
    Ok(measured![
        "fan", measure => off(&sphere(&mesh, true)?);
        "u = 0.5 at the pole", measure => off(&sphere(&mesh, false)?);
        "fan", "values that are not finite, a vertex at the centre" => bad(&with_centre);
    ])
}

/// U3: latitudes near the pole in f32.
pub(super) fn u3() -> Result<Vec<Measurement>, LabError> {
    let (mut own, mut arc) = (0.0f64, 0.0f64);
    for k in 1..4000u32 {
        let angle = f64::from(k) * 1e-6;
        let (sin, cos) = deterministic_f64::sin_cos(angle);
        let p = [sin as f32, cos as f32, 0.0];
        let exact = deterministic_f64::atan2(f64::from(p[0]), f64::from(p[1]));
        let [_, v] = sphere_uv_at(p, Origin::TopLeft);
        own = own.max((f64::from(v) * std::f64::consts::PI - exact).abs());
        arc = arc.max((f64::from(deterministic_f32::acos(p[1].min(1.0))) - exact).abs());
    }
    let measure = "error of the angle from the pole, radians";
    Ok(measured![
        "atan2 of hypot", measure => own;
        "arc cosine", measure => arc;
    ])
}

/// U4: a box around a ball: every triangle on one side, ties included.
pub(super) fn u4() -> Result<Vec<Measurement>, LabError> {
    let (positions, faces) = ball();
    let mesh = Mesh::new(&positions, &faces)?;
    let set = Mapping::new(Shape::Box).map(Level::new(), &mesh, &[])?.set;
    let per_vertex = project(&positions, &positions, Projection::Box, Origin::TopLeft);
    // A triangle of 1/32 turn cannot span a fifth of a side unless its corners lie on different ones.
    let mixed = |uv: &dyn Fn(usize) -> [[f32; 2]; 3]| {
        let spans = |t: [[f32; 2]; 3]| {
            (0..3).any(|k| (0..2).any(|i| (t[k][i] - t[(k + 1) % 3][i]).abs() > 0.2))
        };
        (0..faces.len()).filter(|f| spans(uv(*f))).count() as f64
    };
    let measure = "triangles of mixed sides";
    Ok(measured![
        "one side per face", measure => mixed(&|f| corners(&faces, &set, f));
        "one side per vertex", measure =>
            mixed(&|f| { let face = faces.face(f); [0, 1, 2].map(|k| per_vertex[face[k] as usize]) });
    ])
}

/// U5: a collapsed, a mirrored and a straight triangle.
pub(super) fn u5() -> Result<Vec<Measurement>, LabError> {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let faces = Faces::from_triangles(&[[0, 1, 2]; 3]);
    let mesh = Mesh::new(&positions, &faces)?;
    let uvs = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.25, 0.25]];
    let set = UvSet {
        uvs,
        corners: vec![0, 1, 2, 0, 2, 1, 0, 4, 3],
    };
    let r = report(
        &mesh,
        &set,
        &ReportOptions {
            origin: Origin::BottomLeft,
            ..ReportOptions::default()
        },
    )?;
    let figures = [
        r.stretch_l2,
        r.stretch_linf,
        r.angle_mean,
        r.angle_max,
        r.area_mean,
        r.area_max,
        r.density[0],
        r.seam_seen,
    ];
    let per_triangle = r
        .triangles
        .iter()
        .flat_map(|t| [t.l2, t.linf, t.angle, t.area])
        .filter(|v| v.is_nan())
        .count();
    let collapsed = &r.triangles[2];
    // Dividing by the area without a test: 0/0 on the collapsed triangle.
    let naive = [[0.0f64, 1.0], [0.0, 0.0]]
        .iter()
        .filter(|[space, picture]| (space / picture).is_nan())
        .count();
    Ok(measured![
        "report", "figures that are NaN" =>
            (figures.iter().filter(|f| f.is_nan()).count() + per_triangle) as f64;
        "division by the area", "figures that are NaN" => naive as f64;
        "report", "triangles flagged as mirrored" => r.flipped as f64;
        "report", "triangles flagged as collapsed" => r.collapsed as f64;
        "report", "stretch of the collapsed triangle is infinite" =>
            f64::from(u8::from(collapsed.l2.is_infinite()));
    ])
}

/// B4: tangents of collapsed, mirrored and parallel coordinates.
pub(super) fn b4() -> Result<Vec<Measurement>, LabError> {
    let (positions, faces) = ball();
    let mesh = Mesh::new(&positions, &faces)?;
    let normals: Vec<[f32; 3]> = faces
        .corners()
        .iter()
        .map(|&i| positions[i as usize])
        .collect();
    let mut collapsed = sphere(&mesh, true)?;
    collapsed
        .uvs
        .iter_mut()
        .step_by(3)
        .for_each(|uv| *uv = [0.5, 0.5]);
    let mut parallel = sphere(&mesh, true)?;
    parallel.uvs.iter_mut().for_each(|uv| uv[1] = uv[0]);
    let mut mirrored = sphere(&mesh, true)?;
    mirrored.uvs.iter_mut().for_each(|uv| uv[0] = -uv[0]);
    let (mut bad, mut slanted, mut raw) = (0usize, 0.0f64, 0usize);
    for set in [&collapsed, &parallel, &mirrored] {
        for (t, n) in tangents(&mesh, set, &normals)?.iter().zip(&normals) {
            bad += t.iter().filter(|c| !c.is_finite()).count();
            let (t, n) = (
                DVec3::new(t[0].into(), t[1].into(), t[2].into()),
                DVec3::from(n.map(f64::from)),
            );
            slanted = slanted.max(t.dot(n).abs()).max((t.length() - 1.0).abs());
        }
        // The textbook formula, divided by the determinant and normalised without a test.
        for face in 0..faces.len() {
            let uv = corners(&faces, set, face);
            let p = [0, 1, 2]
                .map(|k| DVec3::from(positions[faces.face(face)[k] as usize].map(f64::from)));
            let [a, b] = [1, 2].map(|k| {
                [
                    f64::from(uv[k][0] - uv[0][0]),
                    f64::from(uv[k][1] - uv[0][1]),
                ]
            });
            let t = ((p[1] - p[0]) * b[1] - (p[2] - p[0]) * a[1]) / (a[0] * b[1] - b[0] * a[1]);
            raw += usize::from(!(t / t.length()).is_finite());
        }
    }
    let signs = |set: &UvSet| -> Result<f64, LabError> {
        let (a, b) = (
            tangents(&mesh, set, &normals)?,
            tangents(&mesh, &sphere(&mesh, true)?, &normals)?,
        );
        Ok(a.iter().zip(&b).filter(|(a, b)| a[3] == b[3]).count() as f64)
    };
    let measure = "values that are not finite";
    Ok(measured![
        "MikkTSpace", measure => bad as f64;
        "MikkTSpace", "slant of a tangent, or its length less 1" => slanted;
        "MikkTSpace", "corners whose sign ignores the mirror" => signs(&mirrored)?;
        "dP/du over the determinant", measure => raw as f64;
    ])
}
