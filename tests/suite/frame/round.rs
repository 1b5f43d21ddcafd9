//! Texture coordinates of a sphere or cylinder at every pixel, where vertices cannot carry them.

use texmap_math::glam::{DMat4, DVec3};
use texmap_math::{Level, deterministic_f64};
use texmap_render::{Aov, Frame};
use texmap_sample::Filter;
use texmap_scene::Scene;
use texmap_uv::{CurvedShape, Faces, Mapping, PerPixelProjection, ProjectionSource, Shape};

use crate::scenes::{draw_aovs, of, pixel, quad, slot, texture, unlit, values};

const SIZE: u32 = 120;

fn shape() -> texmap_uv::Placement {
    texmap_uv::Placement {
        yaw: 0.3,
        pitch: 0.2,
        ..texmap_uv::Placement::upright(DVec3::new(0.1, 0.0, -2.0), DVec3::new(2.0, 1.6, 2.0))
    }
}

/// A floor of two triangles through a shape, around its axis and across its seam.
fn floor(round: CurvedShape) -> Scene {
    let mut material = unlit([1.0; 3]);
    material.base_color = slot(0, Filter::Trilinear);
    let mut mesh = quad([
        [-2.0, -0.5, -0.2],
        [2.0, -0.5, -0.2],
        [2.0, -0.4, -5.0],
        [-2.0, -0.4, -5.0],
    ]);
    mesh.uvs.clear();
    mesh.uv_projection = Some(
        PerPixelProjection::new(round, &shape(), [4.0, 1.0], texmap_uv::Origin::TopLeft)
            .expect("a shape"),
    );
    let checker = texture(64, 64, |x, y| match (x / 8 + y / 8) % 2 {
        0 => [255; 4],
        _ => [0, 40, 90, 255],
    });
    Scene {
        textures: vec![checker],
        ..of(material, mesh)
    }
}

/// Every covered pixel.
fn covered(frame: &Frame) -> impl Iterator<Item = (u32, u32)> {
    (0..SIZE)
        .flat_map(|y| (0..SIZE).map(move |x| (x, y)))
        .filter(|&(x, y)| !values(frame, Aov::Uv, x, y)[0].is_nan())
}

/// uv by the f64 formula at a pixel's position, the longitude times 4; `None` near the axis.
fn formula(round: CurvedShape, p: &[f32]) -> Option<[f64; 2]> {
    let s = shape();
    let (sin, cos) = deterministic_f64::sin_cos(s.yaw);
    let yaw = DMat4::from_cols_array(&[
        cos, 0.0, -sin, 0.0, 0.0, 1.0, 0.0, 0.0, sin, 0.0, cos, 0.0, 0.0, 0.0, 0.0, 1.0,
    ]);
    let (sin, cos) = deterministic_f64::sin_cos(s.pitch);
    let pitch = DMat4::from_cols_array(&[
        1.0, 0.0, 0.0, 0.0, 0.0, cos, sin, 0.0, 0.0, -sin, cos, 0.0, 0.0, 0.0, 0.0, 1.0,
    ]);
    let from_middle = DVec3::new(p[0].into(), p[1].into(), p[2].into()) - s.position;
    let q = (yaw * pitch).transpose().transform_vector3(from_middle) / s.scale;
    if q.x * q.x + q.z * q.z < 0.06 {
        return None;
    }
    let (_, [u, v]) = Shape::Sphere.uv(q, texmap_uv::Origin::TopLeft);
    Some(match round {
        CurvedShape::Sphere => [4.0 * u, v],
        CurvedShape::Cylinder => [4.0 * u, 0.5 - q.y],
    })
}

#[test]
fn every_pixel_has_the_formulas_coordinates() {
    for round in [CurvedShape::Sphere, CurvedShape::Cylinder] {
        let frame = draw_aovs(&floor(round), SIZE, SIZE, &[Aov::Uv, Aov::Position]);
        let mut count = 0;
        for (x, y) in covered(&frame) {
            let uv = values(&frame, Aov::Uv, x, y);
            if let Some(exact) = formula(round, &values(&frame, Aov::Position, x, y)) {
                let turns = (f64::from(uv[0]) - exact[0]) / 4.0;
                let turns = turns - turns.round();
                assert!(turns.abs() < 2e-6, "{round:?} {x} {y}: {uv:?} {exact:?}");
                assert!(
                    (f64::from(uv[1]) - exact[1]).abs() < 2e-6,
                    "{round:?} {x} {y}: {uv:?} {exact:?}"
                );
                count += 1;
            }
        }
        assert!(count > 3_000, "{count}");
    }
}

/// Negative twin: the best that vertices can do on the same floor is off by half a picture somewhere.
#[test]
fn vertices_cannot_do_it() {
    let mut scene = floor(CurvedShape::Sphere);
    let exact = draw_aovs(&scene, SIZE, SIZE, &[Aov::Uv]);
    let mesh = &mut scene.meshes[0];
    mesh.uv_projection = None;
    let faces = Faces::from_triangles(&mesh.triangles);
    let whole = texmap_uv::Mesh::new(&mesh.positions, &faces).expect("a sound mesh");
    let mapping = Mapping {
        by: ProjectionSource::Position,
        frame: Some(shape()),
        repeat: [4.0, 1.0],
        ..Mapping::new(Shape::Sphere)
    };
    let mapped = mapping.map(Level::new(), &whole, &[]).expect("a mapping");
    assert_eq!(
        mapped.around_axis.len(),
        1,
        "one of the triangles encloses the axis"
    );
    let corners = mapped.set.per_corner();
    mesh.positions = faces
        .corners()
        .iter()
        .map(|&i| mesh.positions[i as usize])
        .collect();
    mesh.triangles = vec![[0, 1, 2], [3, 4, 5]];
    mesh.uvs = corners;
    let by_vertices = draw_aovs(&scene, SIZE, SIZE, &[Aov::Uv]);
    let far = covered(&exact)
        .filter(|&(x, y)| {
            let (a, b) = (
                values(&exact, Aov::Uv, x, y),
                values(&by_vertices, Aov::Uv, x, y),
            );
            (a[1] - b[1]).abs() > 0.1
        })
        .count();
    assert!(far > 500, "{far} pixels");
}

/// The level of detail has no step at the seam, where u jumps by 4.
#[test]
fn the_seam_is_not_seen() {
    for round in [CurvedShape::Sphere, CurvedShape::Cylinder] {
        let frame = draw_aovs(
            &floor(round),
            SIZE,
            SIZE,
            &[Aov::Uv, Aov::Lod, Aov::Position],
        );
        let mut leaps = 0;
        let inner = covered(&frame).filter(|(x, y)| x + 1 < SIZE && y + 1 < SIZE);
        for (x, y) in inner {
            let off_axis = formula(round, &values(&frame, Aov::Position, x, y)).is_some();
            for (nx, ny) in [(x + 1, y), (x, y + 1)] {
                let [here, next] =
                    [(x, y), (nx, ny)].map(|(x, y)| values(&frame, Aov::Uv, x, y)[0]);
                if off_axis && (here - next).abs() > 2.0 {
                    leaps += 1;
                    let lods = [(x, y), (nx, ny)].map(|(x, y)| values(&frame, Aov::Lod, x, y)[0]);
                    assert!(
                        (lods[0] - lods[1]).abs() < 0.6,
                        "{round:?} {x} {y}: {lods:?}"
                    );
                    // Against a level at the top of the chain, which differences of u would give.
                    assert!(lods[0] < 4.5, "{round:?} {x} {y}: {lods:?}");
                }
            }
        }
        assert!(leaps > 10, "{leaps}");
    }
}

/// The same bytes on any number of threads and with samples. A moved object takes its shape along in world space.
#[test]
fn bytes_do_not_depend_on_threads() {
    let scene = floor(CurvedShape::Sphere);
    let of = |threads| {
        let settings = texmap_render::RenderSettings {
            threads: Some(threads),
            ..texmap_render::RenderSettings::new(SIZE, SIZE)
        };
        texmap_render::render(&scene, &settings, &texmap_render::no_progress).expect("a frame")
    };
    let one = of(1);
    assert_ne!(pixel(&one, 60, 100), [0, 0, 0, 255]);
    for threads in [2, 3, 8] {
        assert!(of(threads).rgba == one.rgba, "{threads}");
    }
}
