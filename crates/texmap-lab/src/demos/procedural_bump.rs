//! Bumps that no height map brings: two slopes a texel, waves in cylindrical space, embossed words.

use texmap_light::{Heights, NormalMapGreen, Slope, encode_offsets};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};
use texmap_sample::{Filter, Wrap};
use texmap_scene::{Mesh, NormalDetail, ProceduralHeight, Scene};

use super::lit::{Lit, difference, floor, matte};
use super::{Claim, Panel, stage};
use crate::LabError;

/// Waves around the pot, and their length along it.
const AROUND: u16 = 12;
const RISE: f64 = 0.35;
/// Height of the waves; the pot's radius is 0.8.
const HEIGHT: f64 = 0.05;

/// The result of one method: a panel and its claims.
pub(super) struct Shown {
    pub(super) panel: Panel,
    pub(super) claims: Vec<Claim>,
}

/// An offset map of a height field on the floor of `scene`, against the truth there.
pub(super) fn offset_map(
    mut scene: Scene,
    heights: &Heights<'_>,
    height: f64,
    size: u32,
    wrong: &dyn Fn(&Lit) -> f64,
    allowed: f64,
) -> Result<Shown, LabError> {
    let (offsets, slope) = heights
        .offsets(Slope::Central, height as f32, NormalMapGreen::Up)
        .map_err(|e| LabError::Cases(e.to_string()))?;
    let texels: Vec<f32> = offsets
        .iter()
        .flat_map(|o| {
            let [r, g] = encode_offsets(*o);
            [r, g, 0.0]
        })
        .collect();
    scene
        .textures
        .push(crate::plane::floats(heights.width, 3, &texels)?.with_mips());
    scene.materials[0].normal_detail = Some(NormalDetail::Offsets {
        slot: stage::slot(scene.textures.len() - 1, Filter::Trilinear, Wrap::Repeat),
        slope,
        green: NormalMapGreen::Up,
    });
    let shot = Lit::take(&scene, size)?;
    let count = wrong(&shot);
    Ok(Shown {
        panel: Panel::new(
            shot.picture,
            "Offset map",
            "Its two slopes a texel, as Blinn's other form stores them.",
        ),
        claims: claims![
            "wrong pixels under the offset map" => count, 0.0, allowed;
        ],
    })
}

/// A pot under waves in cylindrical space, against the normals of the displaced cylinder.
pub(super) fn pot(size: u32) -> Result<Shown, LabError> {
    let mut scene = stage::scene(DVec3::new(0.3, 2.0, 3.6), DVec3::new(0.0, 0.65, 0.0), 40.0);
    scene.lights = stage::daylight(0.1, [0.9; 3], [1.0, -0.8, -0.9]);
    let clay = stage::add(&mut scene, matte([0.6, 0.4, 0.3], 0.3));
    let ground = stage::add(&mut scene, matte([0.55, 0.55, 0.5], 0.0));
    scene.meshes = vec![pipe(0.8, 1.4, clay), floor(2.0, ground)];
    let smooth = Lit::take(&scene, size)?;
    scene.materials[clay].normal_detail = Some(NormalDetail::Procedural {
        heights: ProceduralHeight::Waves {
            around: AROUND,
            fold: 0.0,
        },
        world_from_solid: DMat4::from_scale(DVec3::new(1.0, RISE, 1.0)),
        height: HEIGHT as f32,
    });
    let waved = Lit::take(&scene, size)?;
    let surface = scene.materials[clay].phong;
    let mut on_pot = Vec::new();
    let truth = smooth.painted(|i, p| {
        let (normal, eye) = (smooth.normal[i], scene.camera.eye);
        // At the outline pixels are wide and the waves fade to their mean, as they should.
        if p.y < 1e-6 || normal.dot((eye - p).normalize_or_zero()) < 0.5 {
            return None;
        }
        on_pot.push(i);
        let n = displaced(p, normal);
        let lit = texmap_light::reference::illuminate(&surface, &scene.lights, p, n, eye);
        Some(lit.as_vec3().to_array())
    });
    let off = |shot: &Lit| {
        let wrong = on_pot
            .iter()
            .filter(|i| difference(&shot.picture, &truth, **i) > 6);
        100.0 * wrong.count() as f64 / on_pot.len().max(1) as f64
    };
    let (wrong, before) = (off(&waved), off(&smooth));
    Ok(Shown {
        panel: Panel::new(
            waved.picture,
            "Carved waves",
            "A formula in cylindrical space: no map, no seam.",
        ),
        claims: claims![
            "wrong pixels of the pot under waves in cylindrical space, %" => wrong, 0.0, 1.0;
            "wrong without them, % of the pot" => before, 73.0, 10.0;
        ],
    })
}

/// Normal of the pot's waves at a point of its wall, first order in their height.
fn displaced(p: DVec3, normal: DVec3) -> DVec3 {
    let angle = deterministic_f64::atan2(p.z, p.x);
    let (sin, cos) = deterministic_f64::sin_cos(angle);
    let out = DVec3::new(cos, 0.0, sin);
    let side = if out.dot(normal) < 0.0 { -1.0 } else { 1.0 };
    let (around, rise) = (f64::from(AROUND), std::f64::consts::TAU / RISE);
    let (wave_a, wave_y) = (
        deterministic_f64::sin_cos(around * angle),
        deterministic_f64::sin_cos(rise * p.y),
    );
    let by_angle = -0.5 * HEIGHT * around * wave_a.0 * wave_y.1;
    let by_y = -0.5 * HEIGHT * rise * wave_a.1 * wave_y.0;
    let turn = DVec3::new(-sin, 0.0, cos) / 0.8;
    // Inside, the waves of the outside are seen from behind.
    side * (out - (turn * by_angle + DVec3::Y * by_y)).normalize()
}

/// Words engraved into the floor: light changes at the edges of the letters and nowhere else.
pub(super) fn words(mut scene: Scene, size: u32) -> Result<Shown, LabError> {
    // The floor alone, seen from above.
    scene.meshes.truncate(1);
    scene.camera.eye = DVec3::new(0.0, 4.6, 1.2);
    let flat = Lit::take(&scene, size)?;
    let broken = |e: texmap_sample::SampleError| LabError::Cases(e.to_string());
    let (atlas, font) = texmap_io::built_in_font().map_err(broken)?;
    let map = font.heights("texmap\nbumped", &atlas).map_err(broken)?;
    let (wide, high) = (map.width(), map.height());
    let ink = |x: i64, y: i64| {
        let inside = (0..i64::from(wide)).contains(&x) && (0..i64::from(high)).contains(&y);
        inside
            && map
                .texel(0, x as u32, y as u32)
                .is_some_and(|texel| texel[0] > 0.0)
    };
    scene.textures.push(map.clone());
    let mut words = stage::slot(scene.textures.len() - 1, Filter::Trilinear, Wrap::Repeat);
    words.sampler.filter = Filter::Bilinear;
    scene.materials[0].normal_detail = Some(NormalDetail::Bump {
        slot: words,
        height: -0.05,
    });
    let shot = Lit::take(&scene, size)?;
    let (mut far, mut edges, mut beyond, mut turned) = (0u32, 0u32, 0u32, 0u32);
    for (i, p) in flat.position.iter().enumerate() {
        if !p.is_finite() || p.y.abs() > 1e-6 {
            continue;
        }
        let (u, v) = (0.5 + p.x / 4.0, 0.5 + p.z / 4.0);
        let at = |c: f64, n: u32| (c * f64::from(n)).floor() as i64;
        let (x, y) = (at(u, wide), at(v, high));
        // The differences reach two texels.
        let around = (-2..=2).flat_map(|j| (-2..=2).map(move |i| ink(x + i, y + j)));
        let changed = difference(&shot.picture, &flat.picture, i) > 2;
        let count = around.filter(|inked| *inked).count();
        match count {
            0 => {
                far += 1;
                beyond += u32::from(changed);
            }
            25 => {}
            _ => {
                edges += 1;
                turned += u32::from(changed);
            }
        }
    }
    let share = |part: u32, of: u32| 100.0 * f64::from(part) / f64::from(of.max(1));
    Ok(Shown {
        panel: Panel::new(shot.picture, "Engraved words", "Letters as a height field."),
        claims: claims![
            "pixels that words change beyond their letters, %" => share(beyond, far), 0.0, 0.0;
            "pixels that they change at the letters' edges, %" => share(turned, edges), 70.0, 15.0;
        ],
    })
}

/// A pipe about the y axis on the floor, with smooth normals.
fn pipe(radius: f64, height: f64, material: usize) -> Mesh {
    let around = 256u32;
    let mut mesh = Mesh {
        name: "pot".into(),
        material,
        ..Mesh::default()
    };
    for i in 0..=around {
        let turn = f64::from(i % around) / f64::from(around) * std::f64::consts::TAU;
        let (sin, cos) = deterministic_f64::sin_cos(turn);
        for y in [0.0, height] {
            let out = DVec3::new(cos, 0.0, sin);
            let p = out * radius + DVec3::Y * y;
            mesh.positions.push(p.as_vec3().to_array());
            mesh.normals.push(out.as_vec3().to_array());
        }
    }
    for i in 0..around {
        let a = 2 * i;
        mesh.triangles
            .extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
    }
    mesh
}
