//! Two bones bend an arm: what linear blending loses of its volume, and rigid parts beside it.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::{Bone, Skeleton, SkinBlend, rotation};
use texmap_scene::{Mesh, Scene};

use super::lit::matte;
use super::sheet::sheet;
use super::stage;
use super::{Claim, DemoPicture, Panel, paint};
use crate::LabError;

/// The arm: half its length, half its thickness, and the width of the band in which weights change.
const REACH: f64 = 2.0;
const HALF: f64 = 0.4;
const BAND: f64 = 1.6;
const ANGLES: [f64; 5] = [0.0, 30.0, 60.0, 90.0, 120.0];

fn skeleton() -> Skeleton {
    let bone = |from: f64, to: f64, parent| Bone {
        head: DVec3::X * from,
        tail: DVec3::X * to,
        parent,
    };
    Skeleton {
        bones: vec![bone(-REACH, 0.0, None), bone(0.0, REACH, Some(0))],
    }
}

/// A closed square rod along x, in `parts` slices.
fn rod(from: f64, to: f64, parts: u32, material: usize) -> Mesh {
    let mut mesh = Mesh {
        name: "arm".into(),
        material,
        ..Mesh::default()
    };
    let corners = [(-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF)];
    for side in 0..4 {
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        let out = DVec3::new(0.0, a.0 + b.0, a.1 + b.1).normalize();
        let first = mesh.positions.len() as u32;
        for i in 0..=parts {
            let x = from + (to - from) * f64::from(i) / f64::from(parts);
            for (k, (y, z)) in [a, b].into_iter().enumerate() {
                mesh.positions
                    .push(DVec3::new(x, y, z).as_vec3().to_array());
                mesh.normals.push(out.as_vec3().to_array());
                mesh.uvs.push([(x / (2.0 * HALF)) as f32, k as f32]);
            }
        }
        for i in 0..parts {
            let a = first + 2 * i;
            mesh.triangles
                .extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
        }
    }
    for (x, out) in [(from, -1.0), (to, 1.0)] {
        let first = mesh.positions.len() as u32;
        for (y, z) in corners {
            mesh.positions
                .push(DVec3::new(x, y, z).as_vec3().to_array());
            mesh.normals.push([out as f32, 0.0, 0.0]);
            mesh.uvs.push([
                (y / (2.0 * HALF) + 0.5) as f32,
                (z / (2.0 * HALF) + 0.5) as f32,
            ]);
        }
        let fan = [[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| first + i));
        mesh.triangles.extend(if out > 0.0 {
            fan
        } else {
            fan.map(|[a, b, c]| [a, c, b])
        });
    }
    mesh
}

/// Six times the signed volume of a closed mesh is the sum of the triple products of its corners.
fn volume(mesh: &Mesh) -> f64 {
    let at = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    let triple = |t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles.iter().map(triple).sum()
}

fn bent(meshes: &[Mesh], blend: SkinBlend, degrees: f64) -> Result<Vec<Mesh>, LabError> {
    let pose = skeleton().pose(&[DMat4::IDENTITY, rotation(DVec3::Z, degrees.to_radians())])?;
    let bend = |mesh: &Mesh| skeleton().skin(&mesh.positions, blend).bend(mesh, &pose);
    Ok(meshes.iter().map(bend).collect::<Result<_, _>>()?)
}

/// The rigid parts' common volume, by points of a fine grid across the section.
fn overlap(degrees: f64) -> f64 {
    let (sin, cos) = deterministic_f64::sin_cos(degrees.to_radians());
    let n = 1200;
    let inside = |x: f64, y: f64| y.abs() <= HALF && x >= 0.0;
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
    let hits = (0..n * n)
        .filter(|i| {
            let (x, y) = (at(i % n), at(i / n));
            inside(-x, y) && inside(x * cos + y * sin, y * cos - x * sin)
        })
        .count();
    hits as f64 * (2.0 / f64::from(n)) * (2.0 / f64::from(n)) * 2.0 * HALF
}

fn scene() -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 1.0, 7.6), DVec3::new(0.0, 0.4, 0.0), 36.0);
    scene.lights = stage::daylight(0.3, [0.8; 3], [-0.4, -0.8, -0.9]);
    let texture = stage::texture(
        &mut scene,
        &paint::checker(256, 4, [176, 92, 60, 255], [236, 214, 180, 255]),
    )?;
    let mut skin = matte([1.0; 3], 0.0);
    skin.base_color = Some(texmap_scene::TextureSlot::new(texture));
    stage::add(&mut scene, skin);
    Ok(scene)
}

pub(super) fn skin(size: u32) -> Result<DemoPicture, LabError> {
    let whole = [rod(-REACH, REACH, 400, 0)];
    // Apart by a hair, so that the ends at the joint have a nearest bone each.
    let parts = [rod(-REACH, -1e-4, 1, 0), rod(1e-4, REACH, 1, 0)];
    let rest = volume(&whole[0]);
    let mut scene = scene()?;
    let mut shot = |meshes: Vec<Mesh>| {
        scene.meshes = meshes;
        stage::photograph(&scene, size)
    };
    let mut claims = Vec::new();
    for degrees in ANGLES {
        let lost = rest - volume(&bent(&whole, SkinBlend::Smooth(BAND), degrees)?[0]);
        let section = 4.0 * HALF * HALF;
        let expected = section * BAND * (1.0 - deterministic_f64::cos(degrees.to_radians())) / 6.0;
        claims.push(Claim::new(
            format!("volume lost at {degrees} degrees, % of the arm"),
            100.0 * lost / rest,
            100.0 * expected / rest,
            0.01,
        ));
    }
    let rigid = bent(&parts, SkinBlend::Rigid, 120.0)?;
    let kept: f64 = rigid.iter().map(volume).sum();
    let before: f64 = parts.iter().map(volume).sum();
    claims.push(Claim::new(
        "volume lost by rigid parts at 120 degrees, %",
        100.0 * (before - kept) / before,
        0.0,
        1e-4,
    ));
    let wedge = HALF * HALF * deterministic_f64::tan(60_f64.to_radians()) * 2.0 * HALF;
    claims.push(Claim::new(
        "but inside each other, % of the arm",
        100.0 * overlap(120.0) / rest,
        100.0 * wedge / rest,
        0.1,
    ));
    let mut panels = Vec::new();
    for degrees in [0.0, 60.0, 120.0] {
        let caption = match degrees as u32 {
            0 => "Two bones; weights change over 1.6 of the arm's 4 units.",
            60 => "The arm bends smoothly.",
            _ => "Blended matrices shrink: the elbow collapses.",
        };
        panels.push(Panel {
            picture: shot(bent(&whole, SkinBlend::Smooth(BAND), degrees)?)?,
            title: format!("Linear blend, {degrees} degrees"),
            caption: caption.into(),
        });
    }
    panels.push(Panel {
        picture: shot(rigid)?,
        title: "Rigid parts, 120 degrees".into(),
        caption: "No volume is lost, but the elbow is open outside and doubled inside.".into(),
    });
    Ok(sheet("Skinning: an arm of two bones", panels, claims))
}
