//! R1 to R8: coverage, overflow, degenerate and huge triangles, T-junctions, depth.

use texmap_math::deterministic_f64;
use texmap_raster::{DrawCall, Interp};

use super::probe::{Mesh, Random, coverage, double_and_missing, place, vertex, visit};
use super::{Measurement, naive};
use crate::LabError;
use crate::scenes::UvScene;

const OVERDRAW: &str = "pixels hit twice";
const HOLES: &str = "pixels missed";
const EITHER: &str = "pixels hit twice or missed";

/// R1: a fan over the whole viewport whose rim lies 30 000 pixels outside.
pub(super) fn r1() -> Result<Vec<Measurement>, LabError> {
    let size = (1280, 960);
    let fan = fan(size, (613.37, 471.13), 30_000.0, 61);
    let (double, missing) = double_and_missing(&coverage(size, fan.draw())?);
    let counts = naive::coverage(
        (0, 0),
        size,
        &pixels_f32(size, &fan),
        naive::edge_f32,
        false,
    );
    let (naive_double, naive_missing) = double_and_missing(&counts);
    Ok(measured![
        "fixed point", OVERDRAW => double;
        "fixed point", HOLES => missing;
        "f32 edges", EITHER => naive_double + naive_missing;
    ])
}

/// R2: a mesh 4000 pixels away from the origin.
pub(super) fn r2() -> Result<Vec<Measurement>, LabError> {
    let size = (4640, 480);
    let fan = fan(size, (4310.61, 233.29), 9_000.0, 67);
    let window = (4000, 640);
    let in_window = |counts: &[u32]| -> Vec<u32> {
        counts
            .chunks(size.0 as usize)
            .flat_map(|row| row[window.0 as usize..].to_vec())
            .collect()
    };
    let (double, missing) = double_and_missing(&in_window(&coverage(size, fan.draw())?));
    let triangles = pixels_f32(size, &fan);
    let counts = naive::coverage(
        (window.0, 0),
        (window.1, size.1),
        &triangles,
        naive::edge_plane_f32,
        false,
    );
    let (naive_double, naive_missing) = double_and_missing(&counts);
    Ok(measured![
        "fixed point", OVERDRAW => double;
        "fixed point", HOLES => missing;
        "f32 planes Ax+By+C", EITHER => naive_double + naive_missing;
    ])
}

/// R3: edge products of triangles as large as the fixed-point range, against 128-bit integers.
pub(super) fn r3() -> Result<Vec<Measurement>, LabError> {
    let size = (192, 128);
    let mut random = Random(3);
    let (mut wrong, mut overflows) = (0u32, 0u32);
    for _ in 0..50 {
        let corners = [0; 3].map(|_| {
            [
                random.range(-32_000.0, 32_000.0),
                random.range(-32_000.0, 32_000.0),
            ]
        });
        let mesh = Mesh {
            positions: corners
                .iter()
                .map(|c| vertex(size, c[0], c[1], 1.0))
                .collect(),
            indices: vec![[0, 1, 2]],
            values: Vec::new(),
        };
        let counts = coverage(size, mesh.draw())?;
        let snapped = [0, 1, 2].map(|i| {
            let [x, y, _] = place(size, mesh.positions[i]);
            [(x * 256.0).round() as i128, (y * 256.0).round() as i128]
        });
        for (index, &count) in counts.iter().enumerate() {
            let p = [
                index as i128 % i128::from(size.0),
                index as i128 / i128::from(size.0),
            ]
            .map(|c| c * 256 + 128);
            let edges = [0, 1, 2].map(|i| {
                let (a, b) = (snapped[i], snapped[(i + 1) % 3]);
                let products = [(b[0] - a[0]) * (p[1] - a[1]), (b[1] - a[1]) * (p[0] - a[0])];
                overflows += u32::from(
                    products
                        .iter()
                        .any(|&product| i32::try_from(product).is_err()),
                );
                products[0] - products[1]
            });
            // A centre exactly on an edge is the fill rule's business, not this case's.
            let inside = edges.iter().all(|&e| e > 0) || edges.iter().all(|&e| e < 0);
            let on_edge = edges.contains(&0);
            wrong += u32::from(!on_edge && (count != 0) != inside);
        }
    }
    Ok(measured![
        "fixed point", "pixels that differ from 128-bit edges" => wrong.into();
        "i32 products", "edge products out of range" => overflows.into();
    ])
}

/// R4: grids turned in 32 steps; both windings, random w in [0.1, 4], part of them outside.
pub(super) fn r4() -> Result<Vec<Measurement>, LabError> {
    let size = (128, 128);
    let (mut overdraw, mut holes, mut inclusive) = (0.0, 0.0, 0.0);
    let mut random = Random(4);
    for step in 0..32 {
        let (sin, cos) = deterministic_f64::sin_cos(f64::from(step) * std::f64::consts::TAU / 32.0);
        for (reversed, projected, half) in [
            (false, false, 0.15),
            (true, false, 0.15),
            (false, true, 0.15),
            (false, false, 1.5),
            (true, true, 1.5),
            (false, true, 4.0),
        ] {
            // Half the side of the grid of 4 x 4 quads in pixels; 1.5 and more cover the whole viewport.
            let reach = half * 64.0 * if half < 1.0 { 4.0 } else { 1.0 };
            let mut mesh = Mesh::default();
            for row in 0..5 {
                for column in 0..5 {
                    let (x, y) = (
                        reach * (f64::from(column) / 2.0 - 1.0),
                        reach * (f64::from(row) / 2.0 - 1.0),
                    );
                    let w = if projected {
                        random.range(0.1, 4.0)
                    } else {
                        1.0
                    };
                    mesh.positions.push(vertex(
                        size,
                        64.0 + x * cos - y * sin,
                        64.0 + x * sin + y * cos,
                        w,
                    ));
                }
            }
            for quad in 0..16u32 {
                let a = quad / 4 * 5 + quad % 4;
                let triangles = [[a, a + 1, a + 6], [a, a + 6, a + 5]];
                mesh.indices
                    .extend(triangles.map(|t| if reversed { [t[0], t[2], t[1]] } else { t }));
            }
            let (double, missing) = double_and_missing(&coverage(size, mesh.draw())?);
            overdraw += double;
            if half > 1.0 {
                holes += missing;
            }
            if !reversed && half < 1.0 {
                let counts = naive::coverage(
                    (0, 0),
                    size,
                    &pixels_f32(size, &mesh),
                    naive::edge_f32,
                    true,
                );
                inclusive += double_and_missing(&counts).0;
            }
        }
    }
    Ok(measured![
        "top-left rule", OVERDRAW => overdraw;
        "top-left rule", HOLES => holes;
        "inclusive edges", OVERDRAW => inclusive;
    ])
}

/// R5: triangles without area, slivers, and vertices that are no numbers.
pub(super) fn r5() -> Result<Vec<Measurement>, LabError> {
    let size = (2048, 64);
    let mut positions = Vec::new();
    let mut add = |corners: [(f64, f64, f64); 3]| {
        positions.extend(corners.map(|(x, y, w)| vertex(size, x, y, w)));
    };
    add([(10.0, 10.0, 1.0), (20.0, 20.0, 1.0), (30.0, 30.0, 1.0)]);
    add([(50.0, 10.0, 1.0), (50.0, 10.0, 1.0), (60.0, 40.0, 1.0)]);
    add([(80.0, 20.0, 1.0); 3]);
    add([
        (20.0, 30.495, 1.0),
        (2020.0, 30.5, 1.0),
        (20.0, 30.505, 1.0),
    ]);
    add([(20.0, 40.3, 1.0), (2020.0, 40.5, 5.0), (20.0, 41.0, 0.2)]);
    add([(f64::NAN, 10.0, 1.0), (20.0, 20.0, 1.0), (30.0, 10.0, 1.0)]);
    add([
        (f64::INFINITY, 10.0, 1.0),
        (20.0, 20.0, 1.0),
        (30.0, 10.0, 1.0),
    ]);
    add([(100.0, 10.0, 0.0), (120.0, 50.0, 0.0), (140.0, 10.0, 0.0)]);
    add([(1e30, -1e30, 1.0), (-1e30, 1e30, 1.0), (1e30, 1e30, 1e-20)]);
    let values: Vec<f32> = (0..positions.len())
        .map(|i| [0.0, 1.0, 0.25][i % 3])
        .collect();
    let indices: Vec<[u32; 3]> = (0..positions.len() as u32 / 3)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect();
    let mesh = Mesh {
        positions,
        indices,
        values,
    };
    let (mut bad, mut outside) = (0u32, 0.0f64);
    visit(size, &[mesh.draw()], |_, _, fragment| {
        let numbers = fragment
            .values
            .iter()
            .chain(&fragment.ddx)
            .chain(&fragment.ddy);
        let finite = numbers
            .chain([&fragment.inv_w, &fragment.depth])
            .all(|v| v.is_finite());
        bad += u32::from(!finite);
        let value = f64::from(fragment.values[0]);
        outside = outside.max(value - 1.0).max(-value);
    })?;
    let mut divided = 0u32;
    for t in &mesh.indices {
        let [a, b, c] = t.map(|i| place(size, mesh.positions[i as usize]).map(|v| v as f32));
        let area = naive::edge_f32([a[0], a[1]], [b[0], b[1]], [c[0], c[1]]);
        let weight = naive::edge_f32([a[0], a[1]], [b[0], b[1]], [a[0], a[1]]) / area;
        divided += u32::from(!weight.is_finite());
    }
    Ok(measured![
        "fixed point", "fragments with a value that is not finite" => bad.into();
        "fixed point", "attribute outside the hull, of the range" => outside;
        "barycentrics over the area", "triangles whose weights are not finite" => divided.into();
    ])
}

/// R6: a ground plane of half-size 1e4 and 1e6 with the eye above it, the hull far outside any viewport.
pub(super) fn r6() -> Result<Vec<Measurement>, LabError> {
    let mut out = Vec::new();
    for (half, name) in [(1e4, "1e4"), (1e6, "1e6")] {
        let plane = UvScene::ground(half);
        let found = plane.by_raster(Interp::Perspective)?;
        let error = plane.error(&found)?;
        out.extend(measured![
            "perspective", format!("half-size {name}: pixels on one side only") => error.mismatches;
            "perspective", format!("half-size {name}: error, of what is allowed") => error.of_allowed;
        ]);
        let naive = plane.error(&plane.by_f32_homogeneous()?)?;
        out.push(Measurement::new(
            "f32 homogeneous planes",
            format!("half-size {name}: error, of what is allowed"),
            naive.of_allowed,
        ));
    }
    Ok(out)
}

/// R7: a mesh without T-junctions stays without cracks when subdivided; a T-junction cracks.
pub(super) fn r7() -> Result<Vec<Measurement>, LabError> {
    let size = (256, 256);
    let mut random = Random(7);
    let mut cracks = 0.0;
    for _ in 0..20 {
        let corners = [(-9.0, -7.0), (270.0, -11.0), (263.0, 266.0), (-5.0, 271.0)];
        let mut mesh = Mesh::default();
        for (x, y) in corners
            .into_iter()
            .chain([(random.range(40.0, 210.0), random.range(40.0, 210.0))])
        {
            let w = random.range(0.5, 3.0);
            mesh.positions.push(vertex(size, x, y, w));
        }
        mesh.indices = (0..4).map(|i| [i, (i + 1) % 4, 4]).collect();
        let (double, missing) = double_and_missing(&coverage(
            size,
            DrawCall {
                interp: Interp::Subdivided(4),
                ..mesh.draw()
            },
        )?);
        cracks += double + missing;
    }
    // The right half has a vertex in the middle of the left half's edge.
    let mut torn = 0.0;
    for _ in 0..200 {
        let (top, bottom) = (random.range(90.0, 170.0), random.range(90.0, 170.0));
        let at = |x, y| vertex(size, x, y, 1.0);
        let middle = random.range(0.3, 0.7);
        let joint = at(top + (bottom - top) * middle, -10.0 + 276.0 * middle);
        let mesh = Mesh {
            positions: vec![
                at(top, -10.0),
                at(bottom, 266.0),
                at(-900.0, 128.0),
                joint,
                at(900.0, 128.0),
                at(-40.0, -10.0),
                at(-40.0, 266.0),
                at(300.0, -10.0),
                at(300.0, 266.0),
            ],
            indices: vec![[0, 5, 6], [0, 6, 1], [0, 3, 7], [3, 8, 7], [3, 1, 8]],
            values: Vec::new(),
        };
        let (double, missing) = double_and_missing(&coverage(size, mesh.draw())?);
        torn += double + missing;
    }
    Ok(measured![
        "subdivided:4", "cracks and double hits of 20 meshes" => cracks;
        "a T-joint", "cracks and double hits of 200 meshes" => torn;
    ])
}

/// R8: depth of one plane drawn twice, cut along either diagonal.
pub(super) fn r8() -> Result<Vec<Measurement>, LabError> {
    let size = (256, 192);
    let plane = UvScene::ground(20.0);
    let positions: Vec<[f32; 3]> = plane.corners.map(|p| p.as_vec3().to_array()).to_vec();
    let matrix = plane
        .camera
        .clip_from_world(f64::from(size.0) / f64::from(size.1))?;
    let depths = |indices: &[[u32; 3]]| -> Result<Vec<Option<f32>>, LabError> {
        let draw = DrawCall {
            positions: &positions,
            indices,
            clip_from_object: matrix,
            ..DrawCall::default()
        };
        let mut out = vec![None; size.0 as usize * size.1 as usize];
        visit(size, &[draw], |x, y, fragment| {
            out[(y * size.0 + x) as usize] = Some(fragment.depth);
        })?;
        Ok(out)
    };
    let one = depths(&[[0, 1, 2], [0, 2, 3]])?;
    let same = depths(&[[0, 1, 2], [0, 2, 3]])?;
    let other = depths(&[[0, 1, 3], [1, 2, 3]])?;
    let bits = one
        .iter()
        .zip(&same)
        .filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits))
        .count();
    let distance = |(a, b): (&Option<f32>, &Option<f32>)| match (a, b) {
        (Some(a), Some(b)) => (f64::from(*a) - f64::from(*b)).abs(),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    };
    Ok(measured![
        "screen-linear depth", "same triangles: pixels with other bits" => bits as f64;
        "screen-linear depth", "other diagonal: largest difference" =>
            one.iter().zip(&other).map(distance).fold(0.0, f64::max);
    ])
}

/// A fan about `centre` whose rim is a polygon of radius `reach`, all in pixels.
fn fan(size: (u32, u32), centre: (f64, f64), reach: f64, parts: u32) -> Mesh {
    let mut mesh = Mesh {
        positions: vec![vertex(size, centre.0, centre.1, 1.0)],
        ..Mesh::default()
    };
    for i in 0..parts {
        let (sin, cos) = deterministic_f64::sin_cos(
            f64::from(i) * std::f64::consts::TAU / f64::from(parts) + 0.1234,
        );
        mesh.positions.push(vertex(
            size,
            centre.0 + reach * cos,
            centre.1 + reach * sin,
            1.0,
        ));
        mesh.indices.push([0, i + 1, (i + 1) % parts + 1]);
    }
    mesh
}

/// The triangles in f32 pixel positions, as the naive methods take them.
fn pixels_f32(size: (u32, u32), mesh: &Mesh) -> Vec<[[f32; 2]; 3]> {
    let at = |i: u32| {
        let [x, y, _] = place(size, mesh.positions[i as usize]);
        [x as f32, y as f32]
    };
    mesh.indices.iter().map(|t| t.map(at)).collect()
}
