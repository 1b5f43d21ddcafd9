//! Meshes that no one models. Each is answered, rightly where it is small, and with a bound where it is not.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};
use texmap_uv::{
    AtlasSize, Faces, Mesh, Origin, ReportOptions, SeamEdges, TJunction, UvSet, auto_planes,
    cut_seams, overlaps, pack, report, sew_seams, t_junctions, tangents,
};

/// A number in [0, 1) from a counter.
fn random(k: u32) -> f64 {
    let x = (u64::from(k) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
}

/// Triangles that share no vertex.
const KINDS: [&str; 9] = [
    "random", "huge", "equal", "far", "slivers", "line", "mixed", "spread", "text",
];

fn soup(kind: &str, count: u32) -> Vec<[DVec3; 3]> {
    let v = DVec3::new;
    let any = |k: u32| v(random(3 * k), random(3 * k + 1), random(3 * k + 2));
    let small = |p: DVec3, s: f64| [p, p + DVec3::X * s, p + DVec3::Y * s];
    let one = |i: u32| match kind {
        "random" => [any(3 * i), any(3 * i + 1), any(3 * i + 2)],
        // One that dwarfs all others, and whose edges they touch.
        "huge" if i == 0 => [DVec3::ZERO, v(1e6, 0.0, 0.0), v(0.0, 1e6, 1.0)],
        "huge" => small(v(random(i), 0.0, 0.0), 0.01),
        "equal" => [DVec3::ONE; 3],
        "far" => [
            v(f64::from(i), 0.0, 3e38),
            v(1.0, 0.0, 3e38),
            v(0.0, f64::from(i), 3e38),
        ],
        "slivers" => {
            let y = f64::from(i) * 1e-6;
            [v(0.0, y, 0.0), v(1.0, y, 0.0), v(1.0, y + 1e-12, 0.0)]
        }
        // Edges that lie on one another, each with many vertices inside.
        "line" => [
            v(random(2 * i), 0.0, 0.0),
            v(random(2 * i + 1), 0.0, 0.0),
            v(0.5, 1.0 + random(i), 0.0),
        ],
        "mixed" if i.is_multiple_of(50) => [any(3 * i), any(3 * i + 1), any(3 * i + 2)],
        "mixed" => small(any(i), 1e-4),
        "spread" => {
            let (_, low) = deterministic_f64::sin_cos(f64::from(i));
            small(
                any(i) * 2f64.powf(20.0 * low),
                2f64.powf(20.0 * random(i) - 20.0),
            )
        }
        // Squares in a row, a step apart.
        _ => small(v(f64::from(i), 0.0, 0.0), 0.9),
    };
    (0..count).map(one).collect()
}

fn mesh_of(soup: &[[DVec3; 3]]) -> (Vec<[f32; 3]>, Faces, UvSet) {
    let positions: Vec<[f32; 3]> = soup
        .iter()
        .flatten()
        .map(|p| p.to_array().map(|c| c as f32))
        .collect();
    let count = positions.len() as u32;
    let faces: Vec<[u32; 3]> = (0..count / 3)
        .map(|f| [3 * f, 3 * f + 1, 3 * f + 2])
        .collect();
    let set = UvSet {
        uvs: positions.iter().map(|p| [p[0], p[1]]).collect(),
        corners: (0..count).collect(),
    };
    (positions, Faces::from_triangles(&faces), set)
}

/// Every edge of these meshes is the rim, but for edges of equal ends.
fn t_joints_by_hand(positions: &[[f32; 3]], faces: &Faces) -> Vec<TJunction> {
    let at = |i: u32| DVec3::from(positions[i as usize].map(f64::from));
    let first = |i: u32| (0..=i).find(|&j| at(j) == at(i)).unwrap();
    let mut out = Vec::new();
    let mut vertices: Vec<u32> = (0..positions.len() as u32).map(first).collect();
    vertices.sort_unstable();
    vertices.dedup();
    for (face, c) in (0..faces.len()).map(|f| (f, faces.face(f))) {
        for edge in [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]].map(|e| e.map(first)) {
            let [a, b] = edge.map(at);
            let whole = (b - a).length();
            let tolerance = whole * 1e-6 + a.abs().max(b.abs()).max_element() * 2e-7;
            for &vertex in vertices.iter().filter(|v| !edge.contains(v)) {
                let from = at(vertex) - a;
                let t = from.dot(b - a) / whole;
                let off = (from - (b - a) * (t / whole)).length();
                if off <= tolerance && t > tolerance && t < whole - tolerance {
                    let face = face as u32;
                    out.push(TJunction { vertex, face, edge });
                }
            }
        }
    }
    out
}

#[test]
fn few_triangles_have_the_t_joints_of_a_comparison_of_all() {
    for kind in KINDS {
        let (positions, faces, _) = mesh_of(&soup(kind, 150));
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let found = t_junctions(&mesh);
        // Equal edges of two faces are no rim.
        let expected = t_joints_by_hand(&positions, &faces);
        if !matches!(kind, "far") {
            assert_eq!(found.list, expected, "{kind}");
        }
        assert!(!found.at_least, "{kind}");
    }
}

#[test]
fn few_triangles_have_the_overlaps_of_a_comparison_of_all() {
    for kind in ["random", "huge", "mixed", "spread", "text"] {
        let (positions, faces, set) = mesh_of(&soup(kind, 200));
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let found = overlaps(&mesh, &set).unwrap();
        // Two triangles share area when no edge of either parts them; those that an edge all but parts may be told or not.
        let of = |f: usize| -> [DVec2; 3] {
            std::array::from_fn(|k| DVec2::from(set.at(3 * f + k).map(f64::from)))
        };
        let parted = |a: &[DVec2; 3], b: &[DVec2; 3], margin: f64| {
            (0..3).any(|k| {
                let edge = a[(k + 1) % 3] - a[k];
                let turn = edge.perp_dot(a[(k + 2) % 3] - a[k]);
                let depth = |p: DVec2| edge.perp_dot(p - a[k]) / turn;
                b.iter().all(|p| depth(*p) <= margin)
            })
        };
        // As without area as rounding of f32 makes them.
        let flat = |t: &[DVec2; 3]| {
            let (e, f) = (t[1] - t[0], t[2] - t[0]);
            e.perp_dot(f).abs() <= 1e-9 * e.length_squared().max(f.length_squared())
        };
        let (mut sure, mut possible) = (0, 0);
        for (i, j) in (0..200).flat_map(|i| (i + 1..200).map(move |j| (i, j))) {
            let (a, b) = (of(i), of(j));
            if flat(&a) || flat(&b) {
                continue;
            }
            let apart = |margin: f64| parted(&a, &b, margin) || parted(&b, &a, margin);
            sure += u64::from(!apart(1e-3));
            possible += u64::from(!apart(0.0));
        }
        assert!(!found.at_least);
        assert!(
            (sure..=possible).contains(&found.pairs),
            "{kind}: {} pairs, {sure} to {possible} by edges",
            found.pairs
        );
    }
}

/// Each of these took minutes, or never ended.
#[test]
fn many_triangles_are_answered() {
    for kind in KINDS {
        let (positions, faces, set) = mesh_of(&soup(kind, 10_000));
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let found = report(&mesh, &set, &ReportOptions::default()).unwrap();
        assert_eq!(found.faces, 10_000, "{kind}");
        assert_eq!(found.t_junctions, t_junctions(&mesh), "{kind}");
        let far = |p: &[f32; 3]| p.iter().any(|c| c.abs() > 1e30);
        if !positions.iter().any(far) {
            let atlas = AtlasSize {
                size: 4096,
                gutter: 1,
            };
            let auto = auto_planes(&mesh, atlas, Origin::TopLeft).unwrap();
            assert!(
                auto.uvs
                    .as_flattened()
                    .iter()
                    .all(|c| (0.0..=1.0).contains(c)),
                "{kind}"
            );
            pack(&mesh, &set, atlas).unwrap();
        }
        let normals = vec![[0.0, 0.0, 1.0]; faces.corners().len()];
        let found = tangents(&mesh, &set, &normals).unwrap();
        assert!(found.as_flattened().iter().all(|c| c.is_finite()), "{kind}");
    }
}

/// A vertex inside of each of very many edges: n^2 pairs, of which a part is given, and that is said.
#[test]
fn what_is_too_much_is_a_lower_bound() {
    let (positions, faces, set) = mesh_of(&soup("line", 30_000));
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let found = t_junctions(&mesh);
    assert!(found.at_least && found.list.len() > 30_000);
    // As long as they are few they are all there.
    let (positions, faces, _) = mesh_of(&soup("line", 300));
    let found = t_junctions(&Mesh::new(&positions, &faces).unwrap());
    assert!(!found.at_least && found.list.len() > 10_000);
    assert!(overlaps(&mesh, &set).unwrap().at_least);
}

/// Two polygons of very many corners, back to back and torn all around; cut and sewn again.
#[test]
fn polygons_of_many_corners_are_cut_and_sewn() {
    let count = 50_000u32;
    let positions: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            let (s, c) =
                deterministic_f64::sin_cos(f64::from(i) / f64::from(count) * std::f64::consts::TAU);
            [c as f32, s as f32, 0.0]
        })
        .collect();
    let around: Vec<u32> = (0..count).collect();
    let back: Vec<u32> = (0..count).rev().collect();
    let mut faces = Faces::new();
    faces.push(&around);
    faces.push(&back);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = UvSet {
        uvs: positions.iter().map(|p| [p[0], p[1]]).collect(),
        corners: faces.corners().to_vec(),
    };
    let islands = |set: &UvSet| {
        let found = report(&mesh, set, &ReportOptions::default()).unwrap();
        (found.islands, found.seam_length > 6.0)
    };
    assert_eq!(islands(&set), (1, false));
    let sharp = SeamEdges {
        angle: Some(1.0),
        ..SeamEdges::default()
    };
    let parted = cut_seams(&mesh, &set, &sharp).unwrap();
    assert_eq!(parted.uvs.len(), 2 * count as usize);
    let pairs: Vec<[u32; 2]> = (0..count).map(|i| [i, (i + 1) % count]).collect();
    let sewn = sew_seams(&mesh, &parted, &pairs).unwrap();
    assert_eq!(sewn.uvs.len(), count as usize);
    let auto = auto_planes(&mesh, AtlasSize::default(), Origin::TopLeft).unwrap();
    assert_eq!(islands(&auto), (2, true));
}

/// A staircase of three hundred turns over one another: each turn is a chart.
#[test]
fn a_long_spiral_is_divided() {
    let (mut positions, mut faces) = (Vec::new(), Faces::new());
    for k in 0..=2400u32 {
        let (s, c) = deterministic_f64::sin_cos(f64::from(k) * 0.785);
        let y = 0.001 * k as f32;
        positions.extend([[c as f32, y, s as f32], [2.0 * c as f32, y, 2.0 * s as f32]]);
        if k > 0 {
            let b = 2 * k;
            faces.push(&[b - 2, b, b + 1, b - 1]);
        }
    }
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let atlas = AtlasSize {
        size: 8192,
        gutter: 1,
    };
    let set = auto_planes(&mesh, atlas, Origin::TopLeft).unwrap();
    let found = report(&mesh, &set, &ReportOptions::default()).unwrap();
    assert_eq!((found.overlapping, found.collapsed), (0, 0));
    assert!((250..700).contains(&found.islands), "{}", found.islands);
}
