//! The UV-space target: coverage of an atlas, its interpolated values, the conservative mode and gutters.
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use texmap_raster::{Atlas, AtlasMesh, AtlasOptions, Coverage, NO_PRIMITIVE, RasterError};

use crate::support::{Owned, Rng, jittered_grid, size};

/// A mesh whose uvs are a jittered grid over the inner part of the atlas and whose positions are a linear map of them.
struct Sheet {
    mesh: Owned,
    uvs: Vec<[f32; 2]>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Sheet {
    fn new(seed: u64, n: u32, span: f32) -> Self {
        let mesh = jittered_grid(&mut Rng::new(seed), n);
        let uvs: Vec<_> = mesh
            .positions
            .iter()
            .map(|p| [0.5 + p[0] * span, 0.5 + p[1] * span])
            .collect();
        let positions = uvs
            .iter()
            .map(|uv| [uv[0] * 3.0, uv[1] - 2.0 * uv[0], 7.0 * uv[1]])
            .collect();
        let normals = uvs.iter().map(|_| [0.0, 0.6, -0.8]).collect();
        Self {
            mesh,
            uvs,
            positions,
            normals,
        }
    }

    fn atlas_mesh(&self) -> AtlasMesh<'_> {
        AtlasMesh {
            uvs: &self.uvs,
            positions: &self.positions,
            normals: &self.normals,
            indices: &self.mesh.indices,
            bottom_up: false,
        }
    }
}

#[test]
fn texels_hold_their_face_and_its_interpolated_values() {
    let sheet = Sheet::new(1, 9, 0.4);
    let target = size(200, 150);
    let atlas = Atlas::new(target, &sheet.atlas_mesh(), AtlasOptions::default()).expect("valid");
    assert_eq!(atlas.lost, Vec::<u32>::new());
    let (mut covered, mut exact) = (0, 0);
    for y in 0..150_usize {
        for x in 0..200_usize {
            let at = y * 200 + x;
            let [u, v] = [(x as f32 + 0.5) / 200.0, (y as f32 + 0.5) / 150.0];
            let inside = (u - 0.5).abs() < 0.4 && (v - 0.5).abs() < 0.4;
            assert_eq!(atlas.face[at] != NO_PRIMITIVE, inside, "texel {x}, {y}");
            if inside {
                covered += 1;
                assert_eq!(atlas.coverage[at], Coverage::Centre);
                let expected = [u * 3.0, v - 2.0 * u, 7.0 * v];
                for k in 0..3 {
                    // Coverage is snapped: a centre may lie outside its face by 1/256 texel and takes the face's rim.
                    let error = (atlas.position[at][k] - expected[k]).abs();
                    assert!(error < 7.0 / 150.0 / 200.0, "texel {x}, {y}: {error}");
                    exact += usize::from(error < 1e-5);
                    assert!((atlas.normal[at][k] - [0.0, 0.6, -0.8][k]).abs() < 1e-6);
                }
                let b = atlas.barycentric[at];
                assert!((b[0] + b[1] + b[2] - 1.0).abs() < 1e-6);
            }
        }
    }
    assert_eq!(covered, 160 * 120);
    assert!(
        exact > covered * 3 * 99 / 100,
        "{exact} exact values of {covered} texels"
    );
}

#[test]
fn bottom_up_mirrors_the_rows() {
    let sheet = Sheet::new(2, 5, 0.45);
    let target = size(64, 64);
    let top = Atlas::new(target, &sheet.atlas_mesh(), AtlasOptions::default()).expect("valid");
    let mirrored: Vec<_> = sheet.uvs.iter().map(|uv| [uv[0], 1.0 - uv[1]]).collect();
    let mesh = AtlasMesh {
        uvs: &mirrored,
        bottom_up: true,
        ..sheet.atlas_mesh()
    };
    let bottom = Atlas::new(target, &mesh, AtlasOptions::default()).expect("valid");
    let same = top
        .face
        .iter()
        .zip(&bottom.face)
        .filter(|(a, b)| a == b)
        .count();
    assert!(same > 64 * 64 - 20, "{same} texels agree");
}

/// A break at any step of any stage ends the work there; without one nothing changes.
#[test]
fn a_break_of_progress_ends_an_atlas() {
    let sheet = Sheet::new(5, 14, 0.3);
    let options = AtlasOptions {
        conservative: true,
        gutter: 6,
        threads: 1,
        ..AtlasOptions::default()
    };
    let draw = |last: usize| {
        let calls = AtomicUsize::new(0);
        let progress = |done: usize, of: usize| {
            let call = calls.fetch_add(1, Ordering::Relaxed) + 1;
            assert_eq!((done, of), (call, 4 * 4 + 6));
            match call < last {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        };
        let atlas = Atlas::with_progress(size(100, 200), &sheet.atlas_mesh(), options, &progress);
        (atlas, calls.into_inner())
    };
    let whole = draw(usize::MAX);
    assert_eq!(
        whole,
        (
            Atlas::new(size(100, 200), &sheet.atlas_mesh(), options),
            4 * 4 + 6
        )
    );
    for last in 1..=whole.1 {
        assert_eq!(draw(last), (Err(RasterError::Cancelled), last));
    }
}

/// Far more faces than their texel centres catch: without the mode many are lost, with it none.
#[test]
fn conservative_loses_no_face() {
    for seed in 0..30 {
        // 20 x 20 cells over 24 x 24 texels: 800 faces for 576 texels lose some; 12 x 12 cells fit.
        let sheet = Sheet::new(seed, 14, 0.49);
        let target = size(26, 26);
        let plain =
            Atlas::new(target, &sheet.atlas_mesh(), AtlasOptions::default()).expect("valid");
        let options = AtlasOptions {
            conservative: true,
            ..AtlasOptions::default()
        };
        let full = Atlas::new(target, &sheet.atlas_mesh(), options).expect("valid");
        assert!(
            !plain.lost.is_empty(),
            "seed {seed}: nothing is lost without the mode"
        );
        assert_eq!(full.lost, Vec::<u32>::new(), "seed {seed}");
        let mut owners = full.face.clone();
        owners.sort_unstable();
        owners.dedup();
        let faces = owners.iter().filter(|&&f| f != NO_PRIMITIVE).count();
        assert_eq!(faces, sheet.mesh.indices.len(), "seed {seed}");
        for (at, &face) in full.face.iter().enumerate() {
            let b = full.barycentric[at];
            assert!(
                face == NO_PRIMITIVE || b.iter().all(|&w| (0.0..=1.0).contains(&w)),
                "seed {seed}: {b:?}"
            );
        }
    }
}

/// A face without area, a speck within one texel and a face outside the atlas.
#[test]
fn specks_are_kept_and_what_lies_outside_is_named() {
    let uvs = [
        [0.52, 0.52],
        [0.5201, 0.52],
        [0.52, 0.5201],
        [0.3, 0.3],
        [0.3, 0.3],
        [0.3, 0.3],
        [1.5, 0.2],
        [1.6, 0.2],
        [1.5, 0.3],
    ];
    let indices = [[0, 1, 2], [3, 4, 5], [6, 7, 8]];
    let mesh = AtlasMesh {
        uvs: &uvs,
        indices: &indices,
        ..AtlasMesh::default()
    };
    let options = AtlasOptions {
        conservative: true,
        ..AtlasOptions::default()
    };
    let atlas = Atlas::new(size(16, 16), &mesh, options).expect("valid");
    assert_eq!(atlas.lost, [2]);
    assert_eq!((atlas.face[8 * 16 + 8], atlas.face[4 * 16 + 4]), (0, 1));
    let plain = Atlas::new(size(16, 16), &mesh, AtlasOptions::default()).expect("valid");
    assert_eq!(plain.lost, [0, 1, 2]);
}

/// A speck whose corner is a texel's corner lies in one texel, whichever way it is wound and wherever it points.
#[test]
fn specks_at_texel_corners_are_kept() {
    let step = 1.0 / 16.0 / 200.0;
    for (dx, dy) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        let uvs = [[0.5, 0.5], [0.5 + dx * step, 0.5], [0.5, 0.5 + dy * step]];
        for indices in [[[0, 1, 2]], [[0, 2, 1]]] {
            let mesh = AtlasMesh {
                uvs: &uvs,
                indices: &indices,
                ..AtlasMesh::default()
            };
            let options = AtlasOptions {
                conservative: true,
                ..AtlasOptions::default()
            };
            let atlas = Atlas::new(size(16, 16), &mesh, options).expect("valid");
            let texel = |d: f32| if d > 0.0 { 8 } else { 7 };
            let owned: Vec<usize> = (0..256).filter(|&k| atlas.face[k] == 0).collect();
            assert_eq!(owned, [texel(dy) * 16 + texel(dx)], "{dx} {dy} {indices:?}");
        }
    }
}

#[test]
fn gutters_dilate_by_whole_texels() {
    let sheet = Sheet::new(5, 3, 0.25);
    let options = AtlasOptions {
        gutter: 4,
        ..AtlasOptions::default()
    };
    let atlas = Atlas::new(size(64, 64), &sheet.atlas_mesh(), options).expect("valid");
    for y in 0..64_i32 {
        for x in 0..64_i32 {
            // The chart covers 16..48; distance in whole texels, corners count as one.
            let away = |v: i32| {
                if v < 16 {
                    16 - v
                } else if v > 47 {
                    v - 47
                } else {
                    0
                }
            };
            let expected = match away(x).max(away(y)) {
                0 => Coverage::Centre,
                1..=4 => Coverage::Gutter,
                _ => Coverage::None,
            };
            assert_eq!(
                atlas.coverage[(y * 64 + x) as usize],
                expected,
                "texel {x}, {y}"
            );
        }
    }
}

#[test]
fn wrong_meshes_are_refused_by_name() {
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let mesh = AtlasMesh {
        uvs: &uvs,
        indices: &[[0, 1, 3]],
        ..AtlasMesh::default()
    };
    assert_eq!(
        Atlas::new(size(8, 8), &mesh, AtlasOptions::default()),
        Err(RasterError::IndexOutOfRange {
            draw: 0,
            triangle: 0,
            index: 3,
            vertices: 3
        })
    );
    let mesh = AtlasMesh {
        uvs: &uvs,
        positions: &[[0.0; 3]],
        indices: &[[0, 1, 2]],
        ..AtlasMesh::default()
    };
    assert_eq!(
        Atlas::new(size(8, 8), &mesh, AtlasOptions::default()),
        Err(RasterError::AttributeLength {
            draw: 0,
            expected: 3,
            found: 1
        })
    );
}

/// Faces over one another, on both sides of tile borders, touched texels and gutters: one set of bytes.
#[test]
fn no_texel_depends_on_the_number_of_threads() {
    let sheet = Sheet::new(11, 40, 0.47);
    let mut mesh = sheet.mesh.clone();
    mesh.indices
        .extend([[0, 7, 900], [30, 800, 1600], [3, 3, 5]]);
    let atlas_mesh = AtlasMesh {
        indices: &mesh.indices,
        ..sheet.atlas_mesh()
    };
    let of = |threads| {
        let options = AtlasOptions {
            conservative: true,
            gutter: 6,
            threads,
            ..AtlasOptions::default()
        };
        Atlas::new(size(300, 210), &atlas_mesh, options).expect("valid")
    };
    let one = of(1);
    assert!(one.coverage.contains(&Coverage::Touched) && one.coverage.contains(&Coverage::Gutter));
    for threads in [2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        assert!(pool.install(|| of(threads)) == one, "{threads} threads");
    }
}

/// The conservative mode held against areas: a texel that no face owns overlaps no face, and the owner of a touched one does.
#[test]
fn touched_texels_overlap_their_face_and_free_ones_none() {
    let sheet = Sheet::new(4, 6, 0.31);
    let target = size(33, 47);
    let options = AtlasOptions {
        conservative: true,
        ..AtlasOptions::default()
    };
    let atlas = Atlas::new(target, &sheet.atlas_mesh(), options).expect("valid");
    // True if a triangle and a texel share more than a snapping step: clipped by the texel's four sides.
    let overlap = |face: usize, x: usize, y: usize| {
        let corners = sheet.mesh.indices[face].map(|i| sheet.uvs[i as usize]);
        let mut polygon: Vec<[f64; 2]> = corners
            .iter()
            .map(|uv| {
                [
                    f64::from(uv[0]) * 33.0 - x as f64,
                    f64::from(uv[1]) * 47.0 - y as f64,
                ]
            })
            .collect();
        for (axis, side, sign) in [(0, 0.0, 1.0), (0, 1.0, -1.0), (1, 0.0, 1.0), (1, 1.0, -1.0)] {
            let depth = |p: [f64; 2]| (p[axis] - side) * sign;
            let mut cut = Vec::new();
            for (i, &p) in polygon.iter().enumerate() {
                let q = polygon[(i + 1) % polygon.len()];
                if depth(p) >= 0.0 {
                    cut.push(p);
                }
                if (depth(p) >= 0.0) != (depth(q) >= 0.0) {
                    let t = depth(p) / (depth(p) - depth(q));
                    cut.push([p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t]);
                }
            }
            polygon = cut;
        }
        let area: f64 = (0..polygon.len())
            .map(|i| {
                let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                p[0] * q[1] - p[1] * q[0]
            })
            .sum();
        area.abs() * 0.5
    };
    let mut touched = 0;
    for (at, &face) in atlas.face.iter().enumerate() {
        let (x, y) = (at % 33, at / 33);
        if face == NO_PRIMITIVE {
            let most = (0..sheet.mesh.indices.len())
                .map(|f| overlap(f, x, y))
                .fold(0.0, f64::max);
            assert!(most < 0.01, "free texel {x}, {y} shares {most} with a face");
        } else if atlas.coverage[at] == Coverage::Touched {
            touched += 1;
            // Coverage is snapped to 1/256 texel.
            assert!(overlap(face as usize, x, y) > 0.0 || near(&sheet, face, x, y));
        }
    }
    assert!(touched > 40, "{touched}");
}

/// True if a face comes within a snapping step of a texel's square.
fn near(sheet: &Sheet, face: u32, x: usize, y: usize) -> bool {
    let corners = sheet.mesh.indices[face as usize].map(|i| sheet.uvs[i as usize]);
    let close = |v: f64, from: usize| (from as f64 - 0.01..from as f64 + 1.01).contains(&v);
    corners
        .iter()
        .any(|uv| close(f64::from(uv[0]) * 33.0, x) && close(f64::from(uv[1]) * 47.0, y))
}
