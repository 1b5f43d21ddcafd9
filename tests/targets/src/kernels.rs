//! Kernels that a program calls without a scene: layouts of environments, coordinates, warps, functions of angles.

use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::glam::{DMat3, DVec3};
use texmap_math::{Homography, Level, deterministic_f32};
use texmap_render::hash_pixels;
use texmap_sample::{ColorSpace, EdgeMode, Filter, Origin, Resample, Texture2d};
use texmap_uv::{Faces, Mapping, Mesh, ProjectionSource, Shape};

use crate::random::Random;

/// A name and the values that belong to it, as bits.
pub(crate) fn results(level: Level) -> Vec<(String, String)> {
    let mut results = Vec::new();
    let mut add = |name: &str, values: &mut dyn Iterator<Item = f32>| {
        results.push((name.to_owned(), hash_floats(values)));
    };
    let sky = Environment::from_fn(EnvironmentLayout::LatLong, 24, |d: DVec3| {
        [d.x, d.y, d.z].map(|c| (1.5 + c) as f32)
    });
    if let Ok(sky) = sky {
        for chart in EnvironmentLayout::ALL {
            if let Ok(to) = sky.convert(chart, 24) {
                add(&format!("convert-{}", chart.name()), &mut texels(&to));
            }
        }
        if let Ok(gloss) = sky.specular_map(EnvironmentLayout::Cube, 8, 20.0) {
            add("specular-map", &mut texels(&gloss));
        }
    }
    let mut random = Random::new(7);
    let mut numbers = |n: usize| -> Vec<f32> { (0..n).map(|_| random.range(-3.0, 3.0)).collect() };
    let points: Vec<[f32; 3]> = numbers(900)
        .chunks_exact(3)
        .map(|c| [c[0], c[1], c[2]])
        .collect();
    let mut faces = Faces::new();
    (0..100).for_each(|i| faces.push(&[3 * i, 3 * i + 1, 3 * i + 2]));
    if let Ok(mesh) = Mesh::new(&points, &faces) {
        for (name, shape) in [
            ("plane", Shape::Plane),
            ("box", Shape::Box),
            ("sphere", Shape::Sphere),
            ("cylinder", Shape::Cylinder),
        ] {
            let by = [
                ProjectionSource::Position,
                ProjectionSource::Normal,
                ProjectionSource::Centroid,
            ];
            let uvs = by.map(|by| {
                Mapping {
                    by,
                    ..Mapping::new(shape)
                }
                .map(level, &mesh, &[])
            });
            let corners = uvs.iter().flatten().flat_map(|m| m.set.per_corner());
            add(&format!("uv-{name}"), &mut corners.flatten());
        }
    }
    let texels = (0..20 * 15 * 4).map(|i| (i * 37 % 251) as u8).collect();
    let image = Texture2d::from_rgba8(20, 15, texels, ColorSpace::Srgb, Origin::TopLeft);
    let map = Homography::from_matrix(DMat3::from_cols_array(&[
        1.1, 0.2, 0.004, -0.3, 0.9, 0.002, 2.0, 3.0, 1.0,
    ]));
    if let (Ok(image), Ok(map)) = (image, map) {
        let image = image.with_mips().with_summed_area();
        for filter in [
            Filter::Trilinear,
            Filter::Anisotropic(8),
            Filter::ewa(4),
            Filter::SummedArea,
        ] {
            let mut out = vec![[0.0; 4]; 40 * 30];
            let warp = Resample::new(&image, filter, EdgeMode::Transparent, &map);
            if warp.rows(level, 40, 0, &mut out).is_ok() {
                add(&format!("warp-{filter:?}"), &mut out.into_iter().flatten());
            }
        }
    }
    let angles = numbers(500);
    type Function = (&'static str, fn(f32) -> f32);
    let functions: [Function; 4] = [
        ("sin", deterministic_f32::sin),
        ("cos", deterministic_f32::cos),
        ("exp2", deterministic_f32::exp2),
        ("asin", |x| deterministic_f32::asin(x / 3.0)),
    ];
    for (name, function) in functions {
        add(name, &mut angles.iter().map(|x| function(*x)));
    }
    results
}

fn texels(of: &Environment) -> impl Iterator<Item = f32> {
    let (width, face) = of.size();
    let places = (0..of.layout().faces())
        .flat_map(move |f| (0..face).flat_map(move |y| (0..width).map(move |x| (f, x, y))));
    places.filter_map(|(f, x, y)| of.texel(f, x, y)).flatten()
}

/// Hash of the bits of floats.
pub(crate) fn hash_floats(values: &mut dyn Iterator<Item = f32>) -> String {
    let bytes: Vec<u8> = values.flat_map(|v| v.to_bits().to_le_bytes()).collect();
    hash_pixels(bytes.len() as u32, 1, &bytes)
}
