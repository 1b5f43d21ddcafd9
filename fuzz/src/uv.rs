//! Coordinates for meshes.

use texmap_math::Level;
use texmap_uv::{
    AtlasSize, Faces, Mapping, Mesh, Origin, Projection, ProjectionSource, ReportOptions,
    SeamEdges, Shape, UvSet, auto_planes, cut_seams, layout_svg, overlaps, pack, project, report,
    sew_seams, t_junctions, tangents,
};

use super::choices::Choices;

/// A mesh of any numbers: refused, or mapped, cut, sewn, packed and reported without a panic, and the same coordinates for each corner.
pub fn uv(bytes: &[u8]) {
    let mut c = Choices(bytes);
    let wild = c.byte() > 200;
    let positions: Vec<[f32; 3]> = (0..c.below(24))
        .map(|_| if wild { c.numbers() } else { c.tame() })
        .collect();
    let mut faces = Faces::new();
    for _ in 0..c.below(20) {
        let corners = [3, 3, 4, 5, 2][c.below(5)];
        let range = positions.len().max(1) + usize::from(c.byte() > 250);
        let face: Vec<u32> = (0..corners).map(|_| c.below(range) as u32).collect();
        faces.push(&face);
    }
    let mesh = match Mesh::new(&positions, &faces) {
        Ok(mesh) => mesh,
        Err(refusal) => return assert!(!refusal.to_string().is_empty()),
    };
    let origin = c.of(&[Origin::TopLeft, Origin::BottomLeft]);
    let projected = project(
        &positions,
        &[],
        c.of(&[Projection::Plane, Projection::Box]),
        origin,
    );
    assert_eq!(projected.len(), positions.len());
    assert!(t_junctions(&mesh).list.len() <= faces.corners().len() * positions.len());
    let mapping = Mapping {
        by: c.of(&[
            ProjectionSource::Position,
            ProjectionSource::Normal,
            ProjectionSource::Centroid,
        ]),
        repeat: [c.number().into(), c.number().into()],
        tile: (c.byte() > 220).then(|| [c.number().into(), c.number().into()]),
        fix_seams: c.byte() < 200,
        origin,
        ..Mapping::new(c.of(&[Shape::Plane, Shape::Box, Shape::Sphere, Shape::Cylinder]))
    };
    let atlas = AtlasSize {
        size: 1 + c.below(64) as u32,
        gutter: c.below(5) as u32,
    };
    for set in [
        mapping.map(Level::new(), &mesh, &[]).map(|m| m.set),
        auto_planes(&mesh, atlas, origin),
    ] {
        match set {
            Ok(set) => used(&mesh, &set, atlas, &mut c),
            Err(refusal) => assert!(!refusal.to_string().is_empty()),
        }
    }
}

fn used(mesh: &Mesh<'_>, set: &UvSet, atlas: AtlasSize, c: &mut Choices<'_>) {
    let corners = mesh.faces().corners();
    assert_eq!(set.per_corner().len(), corners.len());
    let options = ReportOptions {
        views: c.byte() > 128,
        ..ReportOptions::default()
    };
    if let Ok(report) = report(mesh, set, &options) {
        assert!(layout_svg(set, &report, Origin::TopLeft, 64).starts_with('<'));
    }
    let _ = overlaps(mesh, set);
    let normals = vec![[0.0, 1.0, 0.0]; corners.len()];
    if let Ok(tangents) = tangents(mesh, set, &normals) {
        assert_eq!(tangents.len(), corners.len());
    }
    let ends = [c.below(corners.len()), c.below(corners.len())].map(|k| corners[k]);
    let pairs = [ends];
    let angle = (c.byte() > 128).then(|| f64::from(c.number()));
    for changed in [
        cut_seams(
            mesh,
            set,
            &SeamEdges {
                pairs: &pairs,
                angle,
            },
        ),
        sew_seams(mesh, set, &pairs),
        pack(mesh, set, atlas),
    ]
    .into_iter()
    .flatten()
    {
        assert_eq!(changed.corners.len(), corners.len());
    }
}
