//! `shapes/...`: tessellation and displacement (time for a triangle that comes out), skinning and height fields. Each asserts its result.
//!
//! `cargo bench -p texmap-benches --bench shapes`

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use texmap_lab::topology::open_edges;
use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::{Bone, Skeleton, SkinBlend, rotation};
use texmap_sample::{ColorSpace, Origin, Texture2d};
use texmap_scene::{Displacement, EdgeBudget, Material, Mesh, Scene, TextureSlot};

/// A cube of side 2 with a height map on every face.
fn cube(texels: f32) -> Scene {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut mesh = Mesh::default();
    for (axis, side) in [0, 1, 2].into_iter().flat_map(|a| [(a, 1.0), (a, -1.0)]) {
        let out = axes[axis] * side;
        let (right, up) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3] * side);
        let first = mesh.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions
                .push((out + right * x + up * y).as_vec3().to_array());
            mesh.normals.push(out.as_vec3().to_array());
            mesh.uvs.push([0.5 + 0.5 * x as f32, 0.5 + 0.5 * y as f32]);
        }
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| first + i)));
    }
    let slot = TextureSlot::new(0);
    mesh.displacement = Some(Displacement {
        budget: EdgeBudget::Texels(texels),
        ..Displacement::new(slot, 0.1)
    });
    Scene {
        background: [0.0; 4],
        textures: vec![noise(512)],
        materials: vec![Material::default()],
        meshes: vec![mesh],
        ..Scene::new(texmap_math::Camera {
            eye: DVec3::new(3.0, 2.0, 4.0),
            look: DVec3::ZERO,
            up: DVec3::Y,
            fov_x: 0.8,
            near: 1e-3,
            far: f64::INFINITY,
            lens: Default::default(),
        })
    }
}

fn noise(side: u32) -> Texture2d<'static> {
    let texels = (0..side * side * 4)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    Texture2d::from_rgba8(side, side, texels, ColorSpace::Linear, Origin::TopLeft)
        .expect("a texture")
        .with_mips()
}

fn displace(c: &mut Criterion) {
    let mut group = c.benchmark_group("shapes/displace");
    group.sample_size(10);
    for texels in [8.0, 4.0, 2.0] {
        let scene = cube(texels);
        let shaped = texmap_mesh::tessellate(&scene, 512).expect("a good scene");
        let triangles = shaped.meshes[0].triangles.len();
        assert_eq!(open_edges(&shaped.meshes), 0);
        group.throughput(Throughput::Elements(triangles as u64));
        group.bench_with_input(BenchmarkId::new("texels", triangles), &scene, |b, scene| {
            b.iter(|| {
                texmap_mesh::tessellate(black_box(scene), 512)
                    .expect("a good scene")
                    .meshes
                    .len()
            });
        });
    }
    group.finish();
}

fn vertices(c: &mut Criterion) {
    let mut group = c.benchmark_group("shapes/vertices");
    group.sample_size(10);
    let positions: Vec<[f32; 3]> = (0..250_000)
        .map(|i| {
            [
                (i % 1000) as f32 * 0.004 - 2.0,
                (i / 1000) as f32 * 0.002,
                0.0,
            ]
        })
        .collect();
    let mesh = Mesh {
        normals: vec![[0.0, 0.0, 1.0]; positions.len()],
        positions,
        ..Mesh::default()
    };
    let bone = |from: f64, to: f64, parent| Bone {
        head: DVec3::X * from,
        tail: DVec3::X * to,
        parent,
    };
    let skeleton = Skeleton {
        bones: vec![bone(-2.0, 0.0, None), bone(0.0, 2.0, Some(0))],
    };
    let pose = skeleton
        .pose(&[DMat4::IDENTITY, rotation(DVec3::Y, 1.0)])
        .expect("a pose");
    let skin = skeleton.skin(&mesh.positions, SkinBlend::Smooth(1.0));
    assert!(
        skin.bend(&mesh, &pose)
            .is_ok_and(|m| m.positions.len() == 250_000)
    );
    group.throughput(Throughput::Elements(250_000));
    group.bench_function("identity", |b| {
        b.iter(|| texmap_mesh::map_vertices(&mesh, |_, v| v));
    });
    group.bench_function("skin", |b| b.iter(|| skin.bend(&mesh, &pose)));
    let heights = noise(512);
    let field = || texmap_mesh::height_field("land", &heights, [1.0, 0.1, 1.0], 1);
    assert!(field().is_ok_and(|m| m.triangles.len() == 2 * 511 * 511));
    group.throughput(Throughput::Elements(2 * 511 * 511));
    group.bench_function("height-field", |b| b.iter(field));
    group.finish();
}

criterion_group!(benches, displace, vertices);
criterion_main!(benches);
