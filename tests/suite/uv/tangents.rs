//! Tangents, corner by corner, against the reference's port in Rust.

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_uv::{
    AtlasSize, Faces, Mapping, Mesh, Origin, SeamEdges, Shape, UvSet, auto_planes, tangents, unwrap,
};

use crate::meshes::ball;

struct Exact;

impl Ops for Exact {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        deterministic_f64::acos(f64::from(x)) as f32
    }
}

/// Input and output of the reference; faces of three or four corners.
struct Reference<'a> {
    positions: &'a [[f32; 3]],
    faces: &'a Faces,
    set: &'a UvSet,
    normals: &'a [[f32; 3]],
    out: Vec<Option<[f32; 4]>>,
}

impl Geometry<Exact> for Reference<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, face: usize) -> usize {
        self.faces.face(face).len()
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.positions[self.faces.face(face)[vert] as usize]
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.normals[self.faces.range(face).start + vert]
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.set.at(self.faces.range(face).start + vert)
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, vert: usize) {
        self.out[self.faces.range(face).start + vert] = tangent.map(|t| t.tangent_encoded());
    }
}

fn reference(
    positions: &[[f32; 3]],
    faces: &Faces,
    set: &UvSet,
    normals: &[[f32; 3]],
) -> Vec<Option<[f32; 4]>> {
    let mut work = Reference {
        positions,
        faces,
        set,
        normals,
        out: vec![None; faces.corners().len()],
    };
    generate_tangents(&mut work).unwrap();
    work.out
}

fn at_corners(mesh: &Mesh<'_>) -> Vec<[f32; 3]> {
    let smooth = mesh.smooth_normals();
    let corners = mesh.faces().corners().iter();
    corners.map(|&i| smooth[i as usize]).collect()
}

/// Compares each tangent with the reference's, made square to the normal: within a hundredth of a degree, and of one sign.
/// Returns the number of corners that the reference leaves at its default, x and -1.
fn compare(positions: &[[f32; 3]], faces: &Faces, set: &UvSet, normals: &[[f32; 3]]) -> usize {
    let mesh = Mesh::new(positions, faces).unwrap();
    let ours = tangents(&mesh, set, normals).unwrap();
    let theirs = reference(positions, faces, set, normals);
    let mut without = 0;
    for (k, (t, r)) in ours.iter().zip(&theirs).enumerate() {
        let n = DVec3::from(normals[k].map(f64::from)).normalize();
        let flat = |t: &[f32; 4]| {
            let v = DVec3::new(t[0].into(), t[1].into(), t[2].into());
            v - n * n.dot(v)
        };
        without += usize::from(r.is_none());
        let r = r.unwrap_or([1.0, 0.0, 0.0, -1.0]);
        let (a, b) = (flat(t), flat(&r));
        // If all cancelled to nothing, or the default lies along the normal, there is no direction to compare.
        if b.length() > 1e-3 {
            let angle = a.cross(b).length().atan2(a.dot(b)).to_degrees();
            assert!(angle < 0.01 && t[3] == r[3], "corner {k}: {t:?}, not {r:?}");
        }
    }
    without
}

/// A ball with ridges, as if modelled by hand: triangles, or quads in every other cell. Every seventh face is followed by one
/// without area: two corners at one point, or three in a row.
fn sculpture(quads: bool) -> (Vec<[f32; 3]>, Faces) {
    let (mut positions, round) = ball(48, 24, 1.0);
    for p in &mut positions {
        let [x, y, z] = p.map(f64::from);
        let height = 1.0
            + 0.2 * deterministic_f64::sin(5.0 * x + 2.0 * y) * deterministic_f64::sin(4.0 * z - y);
        *p = [x, y, z].map(|c| (c * height) as f32);
    }
    let mut faces = Faces::new();
    let mut f = 0;
    while f < round.len() {
        let (a, b) = (round.face(f), round.face((f + 1).min(round.len() - 1)));
        if quads && f % 4 == 1 && a[0] == b[0] && a[2] == b[1] {
            faces.push(&[a[0], a[1], a[2], b[2]]);
            f += 1;
        } else {
            faces.push(a);
        }
        if f % 7 == 0 {
            let middle = positions.len() as u32;
            let [p, q] = [a[0], a[1]].map(|i| positions[i as usize]);
            positions.push(std::array::from_fn(|k| (p[k] + q[k]) * 0.5));
            faces.push(&if f % 2 == 0 {
                [a[0], a[0], a[2]]
            } else {
                [a[0], a[1], middle]
            });
        }
        f += 1;
    }
    (positions, faces)
}

/// The ways to give it coordinates: one island, many, mirrored halves, one index for each corner, and islands of which some
/// have no area in the picture.
fn sets(mesh: &Mesh<'_>) -> Vec<(&'static str, UvSet)> {
    let atlas = AtlasSize::default();
    let origin = Origin::BottomLeft;
    let sphere = |fix_seams| {
        let mapping = Mapping {
            fix_seams,
            ..Mapping::new(Shape::Sphere)
        };
        mapping
            .map(texmap_math::Level::new(), mesh, &[])
            .unwrap()
            .set
    };
    let auto = auto_planes(mesh, atlas, origin).unwrap();
    let corners = mesh.faces().corners().len();
    let apart = UvSet {
        uvs: auto.per_corner(),
        corners: (0..corners as u32).collect(),
    };
    let mirrored = |uv: [f32; 2]| [(uv[0] - 0.5).abs(), uv[1]];
    let halves = UvSet {
        uvs: sphere(true).uvs.into_iter().map(mirrored).collect(),
        ..sphere(true)
    };
    // Every eleventh face by itself, in one point, on one line, or so small that its area vanishes in f32.
    let mut islands = apart.clone();
    for face in (0..mesh.faces().len()).step_by(11) {
        for (i, k) in mesh.faces().range(face).enumerate() {
            let step = i as f32 * 1e-3;
            islands.uvs[k] = match face % 3 {
                0 => [0.25, 0.75],
                1 => [step, 0.125 + 2.0 * step],
                _ => [
                    f32::MIN_POSITIVE * i as f32,
                    f32::MIN_POSITIVE * (i * i) as f32,
                ],
            };
        }
    }
    vec![
        ("sphere", sphere(true)),
        ("sphere, torn", sphere(false)),
        ("auto", auto),
        (
            "unwrap",
            unwrap(mesh, &SeamEdges::default(), atlas, origin, &|_, _| {
                std::ops::ControlFlow::Continue(())
            })
            .unwrap(),
        ),
        ("halves", halves),
        ("apart", apart),
        ("islands", islands),
    ]
}

#[test]
fn every_corner_of_a_sculpture_has_the_references_tangent() {
    for quads in [false, true] {
        let (positions, faces) = sculpture(quads);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let smooth = at_corners(&mesh);
        // As a file of four digits has them.
        let rounded: Vec<[f32; 3]> = smooth
            .iter()
            .map(|n| n.map(|c| (c * 1e4).round() * 1e-4))
            .collect();
        for (name, set) in sets(&mesh) {
            for normals in [&smooth, &rounded] {
                let without = compare(&positions, &faces, &set, normals);
                assert!(name != "islands" || without > 300, "{without}");
            }
        }
    }
}

/// The rule's own programs need a time that grows with the square of these, and stack for each triangle of a fan.
#[test]
fn fans_and_triangles_without_area_take_no_more_than_others() {
    let around = 100_000u32;
    let mut positions = vec![[0.0, 0.5, 0.0]];
    for i in 0..around {
        let (s, c) =
            deterministic_f64::sin_cos(f64::from(i) / f64::from(around) * std::f64::consts::TAU);
        positions.push([c as f32, 0.0, s as f32]);
    }
    let mut triangles: Vec<[u32; 3]> = (0..around)
        .map(|i| [0, 1 + (i + 1) % around, 1 + i])
        .collect();
    triangles.extend((0..around).map(|i| [1 + i, 1 + i, 0]));
    let faces = Faces::from_triangles(&triangles);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = UvSet {
        uvs: positions.iter().map(|p| [p[0], p[2]]).collect(),
        corners: faces.corners().to_vec(),
    };
    let found = tangents(&mesh, &set, &vec![[0.0, 1.0, 0.0]; faces.corners().len()]).unwrap();
    let along = |t: &[f32; 4]| t[0] > 0.999 && t[3] == -1.0;
    assert!(
        found.iter().all(along),
        "{:?}",
        found.iter().find(|t| !along(t))
    );
}
