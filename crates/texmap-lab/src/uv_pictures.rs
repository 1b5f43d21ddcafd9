//! Pictures of a mapping: a checker on the model, a heat map of its distortion, and the unwrapped layout.

use texmap_io::framing::{AUTO_FOV, Bounds, View, auto_lights};
use texmap_light::PhongMaterial;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_render::{RenderSettings, render};
use texmap_sample::{ColorSpace, Sampler, Texture2d};
use texmap_scene::{Material, Scene, Shading, TextureSlot};
use texmap_uv::{Mesh, Report, UvSet};

use crate::LabError;
use texmap_truth::picture::{Picture, Rgba};

const PAPER: Rgba = [240, 241, 243, 255];
const INK: Rgba = [48, 48, 56, 255];

/// The model with a checker of 16 x 16 squares over [0, 1], lettered by colour. Red grows with u, green with v.
///
/// # Errors
/// If the renderer refuses the mesh.
pub fn checker(
    mesh: &Mesh<'_>,
    set: &UvSet,
    origin: texmap_uv::Origin,
    view: View,
    size: u32,
) -> Result<Picture, LabError> {
    let texels: Vec<u8> = (0..256 * 256u32)
        .flat_map(|k| {
            let (x, y) = (k % 256 / 16, k / 256 / 16);
            let (r, g) = ((60 + 12 * x) as u8, (60 + 12 * (15 - y)) as u8);
            if (x + y) % 2 == 0 {
                [r, g, 190, 255]
            } else {
                [250, 250, 246, 255]
            }
        })
        .collect();
    let origin = match origin {
        texmap_uv::Origin::TopLeft => texmap_sample::Origin::TopLeft,
        texmap_uv::Origin::BottomLeft => texmap_sample::Origin::BottomLeft,
    };
    let texture = Texture2d::from_rgba8(
        256,
        256,
        texels,
        ColorSpace::Srgb,
        texmap_sample::Origin::TopLeft,
    )?
    .with_mips();
    let mut model = model(mesh);
    model.uvs = corner_order(mesh).map(|k| set.at(k)).collect();
    model.uv_origin = origin;
    let material = Material {
        phong: matte(),
        base_color: Some(TextureSlot {
            sampler: Sampler::default(),
            ..TextureSlot::new(0)
        }),
        ..Material::default()
    };
    shot(model, material, vec![texture], view, size)
}

/// The model coloured by [`distortion_color`] of each triangle.
///
/// # Errors
/// If the renderer refuses the mesh.
pub fn heat(mesh: &Mesh<'_>, report: &Report, view: View, size: u32) -> Result<Picture, LabError> {
    let mut model = model(mesh);
    let color = |t: &texmap_uv::TriangleReport| {
        let c = distortion_color(t);
        [c[0], c[1], c[2]].map(texmap_math::color::srgb8_to_linear)
    };
    model.colors = report
        .triangles
        .iter()
        .flat_map(|t| [color(t); 3])
        .collect();
    let material = Material {
        phong: PhongMaterial {
            color: [1.0; 3],
            ..matte()
        },
        shading: Shading::Unlit,
        ..Material::default()
    };
    shot(model, material, Vec::new(), view, size)
}

/// Blue where a triangle keeps angles and areas, green at a distortion of 1.25, yellow at 1.5, red from 2 on; the
/// larger of its two distortions counts. Pink for a triangle without area in the picture.
#[must_use]
pub fn distortion_color(t: &texmap_uv::TriangleReport) -> Rgba {
    const STOPS: [(f32, [f32; 3]); 4] = [
        (1.0, [58.0, 98.0, 200.0]),
        (1.25, [66.0, 176.0, 96.0]),
        (1.5, [240.0, 206.0, 60.0]),
        (2.0, [214.0, 52.0, 44.0]),
    ];
    let worst = if t.angle > t.area { t.angle } else { t.area };
    if !worst.is_finite() {
        return [255, 106, 180, 255];
    }
    let after = STOPS
        .iter()
        .position(|(at, _)| worst < *at)
        .unwrap_or(STOPS.len())
        .clamp(1, 3);
    let ((low, a), (high, b)) = (STOPS[after - 1], STOPS[after]);
    let share = ((worst - low) / (high - low)).clamp(0.0, 1.0);
    let mix = |i: usize| (a[i] * (1.0 - share) + b[i] * share + 0.5) as u8;
    [mix(0), mix(1), mix(2), 255]
}

/// The unwrapped picture: grey triangles with their edges, flipped ones blue, overlapping ones pink and on top. The
/// frame is [0, 1]; the view grows to hold coordinates outside of it, up to 4 pictures each way.
#[must_use]
pub fn layout(set: &UvSet, report: &Report, origin: texmap_uv::Origin, size: u32) -> Picture {
    let mut picture = Picture::new(size, size, PAPER);
    let (mut low, mut high) = ([0.0f64; 2], [1.0f64; 2]);
    for uv in &set.uvs {
        for i in 0..2 {
            let c = f64::from(uv[i]).clamp(-4.0, 5.0);
            (low[i], high[i]) = (low[i].min(c), high[i].max(c));
        }
    }
    let scale = f64::from(size) / ((high[0] - low[0]).max(high[1] - low[1]) * 1.06);
    let margin = f64::from(size) * 0.03;
    let at = |uv: [f64; 2]| {
        let down = if origin == texmap_uv::Origin::TopLeft {
            uv[1] - low[1]
        } else {
            high[1] - uv[1]
        };
        [(uv[0] - low[0]) * scale + margin, down * scale + margin]
    };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(at);
    for pass in 0..2 {
        for t in report
            .triangles
            .iter()
            .filter(|t| t.overlapping == (pass == 1))
        {
            let corners = t.corners.map(|k| at(set.at(k as usize).map(f64::from)));
            let color = if t.overlapping {
                [255, 106, 180, 255]
            } else if t.flipped {
                [106, 143, 224, 255]
            } else {
                [170, 178, 190, 255]
            };
            fill(&mut picture, corners, color);
            for k in 0..3 {
                outline(
                    &mut picture,
                    corners[k],
                    corners[(k + 1) % 3],
                    [90, 94, 106, 255],
                );
            }
        }
    }
    for k in 0..4 {
        outline(&mut picture, square[k], square[(k + 1) % 4], INK);
    }
    picture
}

/// Pixels whose centre lies inside or on the edge.
fn fill(picture: &mut Picture, t: [[f64; 2]; 3], color: Rgba) {
    let size = f64::from(picture.width());
    let range = |i: usize| {
        let (low, high) = (
            t[0][i].min(t[1][i]).min(t[2][i]),
            t[0][i].max(t[1][i]).max(t[2][i]),
        );
        ((low - 0.5).max(0.0).ceil() as i64)..=((high - 0.5).min(size - 1.0).floor() as i64)
    };
    for y in range(1) {
        for x in range(0) {
            let p = [x as f64 + 0.5, y as f64 + 0.5];
            let side = |k: usize| {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
            };
            let sides = [side(0), side(1), side(2)];
            if sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0) {
                picture.set(x, y, color);
            }
        }
    }
}

/// A line, unless it leaves the picture by far.
fn outline(picture: &mut Picture, a: [f64; 2], b: [f64; 2], color: Rgba) {
    let limit = 2.0 * f64::from(picture.width());
    if [a, b].as_flattened().iter().all(|c| c.abs() < limit) {
        let cell = |p: [f64; 2]| (p[0].floor() as i64, p[1].floor() as i64);
        picture.line(cell(a), cell(b), color);
    }
}

/// Indices of the corners of the fan triangles, in order.
fn corner_order<'a>(mesh: &Mesh<'a>) -> impl Iterator<Item = usize> + 'a {
    mesh.faces().triangles().flat_map(|(_, corners)| corners)
}

/// The model with three vertices of its own per triangle, so that colours and coordinates may jump.
fn model(mesh: &Mesh<'_>) -> texmap_scene::Mesh {
    let smooth = mesh.smooth_normals();
    let vertex = |k: usize| mesh.faces().corners()[k] as usize;
    let count = mesh.faces().triangles().count() as u32;
    texmap_scene::Mesh {
        name: "model".into(),
        positions: corner_order(mesh)
            .map(|k| mesh.positions()[vertex(k)])
            .collect(),
        normals: corner_order(mesh).map(|k| smooth[vertex(k)]).collect(),
        triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..texmap_scene::Mesh::default()
    }
}

fn matte() -> PhongMaterial {
    PhongMaterial {
        color: [1.0; 3],
        ka: 1.0,
        kd: 1.0,
        ks: 0.0,
        ns: 1.0,
    }
}

fn shot(
    model: texmap_scene::Mesh,
    material: Material,
    textures: Vec<Texture2d<'static>>,
    view: View,
    size: u32,
) -> Result<Picture, LabError> {
    let mut scene = Scene {
        background: [0.94, 0.945, 0.953, 1.0],
        lights: auto_lights(),
        textures,
        materials: vec![material],
        meshes: vec![model],
        ..Scene::new(Camera {
            eye: DVec3::Z,
            look: DVec3::ZERO,
            up: DVec3::Y,
            fov_x: AUTO_FOV,
            near: 1e-3,
            far: f64::INFINITY,
        })
    };
    if let Some(bounds) = Bounds::of(&scene) {
        scene.camera = bounds.camera(view, AUTO_FOV, 1.0);
    }
    let mut settings = RenderSettings::new(size, size);
    settings.supersample = 2;
    Ok(render(&scene, &settings, &texmap_render::no_progress)?.into())
}
