//! Shared parts of the demos of light: round meshes, pictures under effects, and counts of wrong pixels.

use texmap_light::PhongMaterial;
use texmap_math::color::linear_to_srgb8;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_render::Aov;
use texmap_scene::{Material, Mesh, Scene, Shading};

use super::stage;
use crate::LabError;
use texmap_truth::picture::Picture;

/// A matte surface of one linear colour, lit per pixel, with a highlight of strength `ks`.
pub(super) fn matte(color: [f32; 3], ks: f32) -> Material {
    Material {
        phong: PhongMaterial {
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
        let ((sin, cos), (up, out)) = (deterministic_f64::sin_cos(u * std::f64::consts::TAU), {
            let (sin, cos) = deterministic_f64::sin_cos(v * std::f64::consts::PI);
            (cos, sin)
        });
        let n = DVec3::new(out * cos, up, -out * sin);
        mesh.positions
            .push((center + n * radius).as_vec3().to_array());
        mesh.normals.push(n.as_vec3().to_array());
        mesh.uvs.push([u as f32, v as f32]);
    }
    mesh.triangles = grid(around, down);
    mesh
}

/// Triangles of a grid of `(across + 1) * (down + 1)` vertices, row by row.
pub(super) fn grid(across: u32, down: u32) -> Vec<[u32; 3]> {
    let cells = (0..down).flat_map(|j| (0..across).map(move |i| j * (across + 1) + i));
    cells
        .flat_map(|a| {
            let b = a + across + 1;
            [[a, b, b + 1], [a, b + 1, a + 1]]
        })
        .collect()
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
        let frame = stage::with_aovs(scene, size, vec![Aov::Position, Aov::Normal])?;
        let triples = |wanted: Aov| -> Vec<DVec3> {
            let values = stage::floats_of(&frame, wanted).chunks_exact(3);
            values
                .map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into()))
                .collect()
        };
        Ok(Self {
            position: triples(Aov::Position),
            normal: triples(Aov::Normal),
            picture: frame.into(),
        })
    }

    /// The picture with another linear colour wherever `color` gives one for a pixel and its position.
    pub(super) fn painted(
        &self,
        mut color: impl FnMut(usize, DVec3) -> Option<[f32; 3]>,
    ) -> Picture {
        let mut picture = self.picture.clone();
        let size = i64::from(picture.width());
        for (i, p) in self
            .position
            .iter()
            .enumerate()
            .filter(|(_, p)| p.is_finite())
        {
            if let Some([r, g, b]) = color(i, *p).map(|c| c.map(linear_to_srgb8)) {
                picture.set(i as i64 % size, i as i64 / size, [r, g, b, 255]);
            }
        }
        picture
    }

    /// Pixels whose codes differ from another picture's by more than `by`.
    pub(super) fn changed(&self, other: &Self, by: u8) -> Vec<bool> {
        (0..self.position.len())
            .map(|i| difference(&self.picture, &other.picture, i) > by)
            .collect()
    }

    /// Truth of each pixel whose normal is turned to `toward` by a cosine above `least`. `None` for all others.
    pub(super) fn facing(
        &self,
        least: f64,
        toward: impl Fn(DVec3) -> DVec3,
        truth: impl Fn(DVec3, DVec3) -> bool,
    ) -> Vec<Option<bool>> {
        let judged = |(p, n): (&DVec3, &DVec3)| {
            let turned = n.dot(toward(*p).normalize_or_zero()) > least;
            (p.is_finite() && turned).then(|| truth(*p, *n))
        };
        self.position.iter().zip(&self.normal).map(judged).collect()
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
