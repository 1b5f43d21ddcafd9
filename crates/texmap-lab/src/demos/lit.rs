//! What the demos of light share: round meshes, pictures under effects, and counts of wrong pixels.

use texmap_light::Surface;
use texmap_math::det;
use texmap_math::glam::DVec3;
use texmap_render::{Aov, AovData, Settings};
use texmap_scene::{Material, Mesh, Scene, Shading};

use crate::LabError;
use crate::picture::Picture;

/// A matte surface of one linear colour, lit per pixel, with a highlight of strength `ks`.
pub(super) fn matte(color: [f32; 3], ks: f32) -> Material {
    Material {
        surface: Surface {
            color,
            ka: 1.0,
            kd: 1.0,
            ks,
            ns: 40.0,
        },
        shading: Shading::PerPixel,
        ..Material::default()
    }
}

/// A ball with smooth normals.
pub(super) fn ball(center: DVec3, radius: f64, material: usize) -> Mesh {
    let (around, down) = (96u32, 48u32);
    let mut mesh = Mesh {
        name: "ball".into(),
        material,
        ..Mesh::default()
    };
    for (i, j) in (0..=down).flat_map(|j| (0..=around).map(move |i| (i, j))) {
        let (u, v) = (
            f64::from(i) / f64::from(around),
            f64::from(j) / f64::from(down),
        );
        let ((sin, cos), (up, out)) = (det::sin_cos(u * std::f64::consts::TAU), {
            let (sin, cos) = det::sin_cos(v * std::f64::consts::PI);
            (cos, sin)
        });
        let n = DVec3::new(out * cos, up, -out * sin);
        mesh.positions
            .push((center + n * radius).as_vec3().to_array());
        mesh.normals.push(n.as_vec3().to_array());
        mesh.uvs.push([u as f32, v as f32]);
    }
    for (i, j) in (0..down).flat_map(|j| (0..around).map(move |i| (i, j))) {
        let a = j * (around + 1) + i;
        let b = a + around + 1;
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh
}

/// A horizontal square at y = 0, its front up.
pub(super) fn floor(half: f32, material: usize) -> Mesh {
    Mesh {
        name: "floor".into(),
        positions: vec![
            [-half, 0.0, -half],
            [half, 0.0, -half],
            [half, 0.0, half],
            [-half, 0.0, half],
        ],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        lightmap_uvs: vec![[0.05, 0.05], [0.95, 0.05], [0.95, 0.95], [0.05, 0.95]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        material,
        ..Mesh::default()
    }
}

/// A picture, with the position and the normal under each pixel (NaN where nothing is).
pub(super) struct Lit {
    pub(super) picture: Picture,
    pub(super) position: Vec<DVec3>,
    pub(super) normal: Vec<DVec3>,
}

impl Lit {
    pub(super) fn take(scene: &Scene, size: u32) -> Result<Self, LabError> {
        let settings = Settings {
            aovs: vec![Aov::Position, Aov::Normal],
            ..Settings::new(size, size)
        };
        let frame = texmap_render::render(scene, &settings, &|_, _| {})?;
        let triples = |wanted: Aov| match frame.aovs.iter().find(|(aov, ..)| *aov == wanted) {
            Some((_, _, AovData::F32(values))) => values
                .chunks_exact(3)
                .map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into()))
                .collect(),
            _ => Vec::new(),
        };
        Ok(Self {
            position: triples(Aov::Position),
            normal: triples(Aov::Normal),
            picture: Picture::from_rgba(size, size, frame.rgba)
                .unwrap_or_else(|| Picture::new(size, size, [0; 4])),
        })
    }
}

/// Largest difference of two pixels' codes.
pub(super) fn difference(a: &Picture, b: &Picture, index: usize) -> u8 {
    let at = |p: &Picture| [0, 1, 2].map(|k| p.rgba()[4 * index + k]);
    let (a, b) = (at(a), at(b));
    (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0)
}

/// Pixels on which a yes or no differs from the truth, away from the truth's own edges: none of the neighbours up to `reach` pixels
/// away is different in truth. `None` counts nowhere.
pub(super) fn wrong(truth: &[Option<bool>], found: &[bool], size: u32, reach: i64) -> u32 {
    let at = |x: i64, y: i64| {
        let inside = (0..i64::from(size)).contains(&x) && (0..i64::from(size)).contains(&y);
        inside
            .then(|| truth[(y * i64::from(size) + x) as usize])
            .flatten()
    };
    let mut count = 0;
    for (x, y) in (0..i64::from(size)).flat_map(|y| (0..i64::from(size)).map(move |x| (x, y))) {
        let Some(here) = at(x, y) else { continue };
        if found[(y * i64::from(size) + x) as usize] == here {
            continue;
        }
        let around = (-reach..=reach).flat_map(|j| (-reach..=reach).map(move |i| (i, j)));
        let steady = around
            .into_iter()
            .all(|(i, j)| at(x + i, y + j) == Some(here));
        count += u32::from(steady);
    }
    count
}
