//! B7 and G1 to G4: displaced, skinned and turned meshes.

use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::{Bone, MeshError, Skeleton, Skin, SkinBlend, rotation};
use texmap_render::{RenderSettings, render};
use texmap_sample::{Filter, Sampler, Texture2d};
use texmap_scene::{
    Billboard, Displacement, EdgeBudget, Facing, Material, Mesh, Scene, Shading, TextureSlot,
};

use super::Measurement;
use super::environment::Noise;
use crate::LabError;
use crate::plane::floats;
use crate::topology::open_edges;

/// Texels a side of the height map.
const MAP: u32 = 64;

/// Noise that fits nowhere: seams of coordinates have other heights on either side.
fn heights(width: u32, height: u32) -> Result<(Texture2d<'static>, Vec<f32>), LabError> {
    let mut noise = Noise::new(5);
    let values: Vec<f32> = (0..width * height).map(|_| noise.unit() as f32).collect();
    Ok((floats(width, 1, &values)?, values))
}

/// A cube of side 2 whose faces have normals and coordinates of their own: 24 vertices at 8 positions. The map repeats more often
/// on every next face.
fn cube() -> Vec<Mesh> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut faces = Vec::new();
    for (axis, side) in [0, 1, 2].into_iter().flat_map(|a| [(a, 1.0), (a, -1.0)]) {
        let out = axes[axis] * side;
        let (right, up) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3] * side);
        let repeat = 0.3 + 0.25 * faces.len() as f32;
        let mut mesh = Mesh {
            name: format!("face {}", faces.len()),
            ..Mesh::default()
        };
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions
                .push((out + right * x + up * y).as_vec3().to_array());
            mesh.normals.push(out.as_vec3().to_array());
            mesh.uvs.push([
                (0.5 + 0.5 * x as f32) * repeat,
                (0.5 + 0.5 * y as f32) * repeat,
            ]);
        }
        mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
        faces.push(mesh);
    }
    faces
}

fn slot() -> TextureSlot {
    TextureSlot {
        sampler: Sampler {
            filter: Filter::Bilinear,
            ..Sampler::default()
        },
        ..TextureSlot::new(0)
    }
}

fn scene(meshes: Vec<Mesh>, map: Texture2d<'static>, eye: DVec3, look: DVec3) -> Scene {
    let white = texmap_light::PhongMaterial {
        color: [1.0; 3],
        ..Default::default()
    };
    Scene {
        textures: vec![map],
        materials: vec![Material {
            phong: white,
            shading: Shading::Unlit,
            ..Material::default()
        }],
        meshes,
        ..Scene::new(texmap_math::Camera {
            eye,
            look,
            up: DVec3::new(0.1, 1.0, 0.05),
            fov_x: 1.7,
            near: 1e-3,
            far: f64::INFINITY,
        })
    }
}

/// Pixels from inside of a closed mesh, over two views, that show the background.
fn holes(meshes: &[Mesh]) -> Result<f64, LabError> {
    let mut count = 0;
    for look in [DVec3::new(1.0, 0.4, 0.3), DVec3::new(-0.7, -1.0, -0.9)] {
        let (map, _) = heights(MAP, MAP)?;
        let frame = render(
            &scene(meshes.to_vec(), map, DVec3::ZERO, look),
            &RenderSettings::new(384, 384),
            &texmap_render::no_progress,
        )?;
        count += frame.rgba.chunks_exact(4).filter(|p| p[0] == 0).count();
    }
    Ok(count as f64)
}

fn displaced(mut meshes: Vec<Mesh>, height: f32, texels: f32) -> Result<Scene, LabError> {
    let (map, _) = heights(MAP, MAP)?;
    for mesh in &mut meshes {
        let budget = EdgeBudget::Texels(texels);
        mesh.displacement = Some(Displacement {
            budget,
            ..Displacement::new(slot(), height)
        });
    }
    Ok(texmap_mesh::tessellate(scene(meshes, map, DVec3::ZERO, DVec3::X), 64)?.into_owned())
}

pub(super) fn b7() -> Result<Vec<Measurement>, LabError> {
    const OPEN: &str = "edges that are not shared by two triangles";
    const HOLES: &str = "pixels of background from inside of the cube, of 294912";
    let mut all = Vec::new();
    let mut both = |name: &str, meshes: &[Mesh]| -> Result<(), LabError> {
        all.extend(measured![
            name, OPEN => open_edges(meshes) as f64;
            name, HOLES => holes(meshes)?;
        ]);
        Ok(())
    };
    for (height, name) in [
        (0.2, "points moved once"),
        (0.9, "points moved once, five times the edge length"),
    ] {
        both(name, &displaced(cube(), height, 4.0)?.meshes)?;
    }
    // Cut alike, but each corner moved by its own height along its own normal.
    let mut torn = displaced(cube(), 0.0, 4.0)?.meshes;
    let (map, _) = heights(MAP, MAP)?;
    for mesh in &mut torn {
        for ((p, n), uv) in mesh.positions.iter_mut().zip(&mesh.normals).zip(&mesh.uvs) {
            let [h, ..] = slot().sampler.sample(&map, *uv);
            *p = [0, 1, 2].map(|i| p[i] + 0.2 * h * n[i]);
        }
    }
    both("every corner along its own normal", &torn)?;
    // Moved alike, but each face cut as fine as it alone needs.
    let mut apart = Vec::new();
    for face in cube() {
        apart.extend(displaced(vec![face], 0.0, 4.0)?.meshes);
    }
    // A resting mesh at the edge of a moved one.
    let mut lid = cube();
    let (map, _) = heights(MAP, MAP)?;
    for mesh in &mut lid[..3] {
        let budget = EdgeBudget::Texels(4.0);
        mesh.displacement = Some(Displacement {
            budget,
            ..Displacement::new(slot(), 0.4)
        });
    }
    let meshes = texmap_mesh::tessellate(scene(lid, map, DVec3::ZERO, DVec3::X), 64)?
        .into_owned()
        .meshes;
    both("three faces moved, three at rest", &meshes)?;
    all.push(Measurement::new(
        "every face cut for itself",
        OPEN,
        open_edges(&apart) as f64,
    ));
    Ok(all)
}

pub(super) fn g1() -> Result<Vec<Measurement>, LabError> {
    const LOST: &str = "numbers of the mesh that are not finite";
    const TOLD: &str = "inputs that are told, of 4";
    let not_finite = |mesh: &Mesh| {
        let values = mesh
            .positions
            .as_flattened()
            .iter()
            .chain(mesh.normals.as_flattened());
        values.filter(|x| !x.is_finite()).count() as f64
    };
    let with = |change: fn(&mut Mesh),
                height: f32,
                limit: u32,
                map: u32|
     -> Result<Result<Scene, MeshError>, LabError> {
        let mut meshes = cube();
        let (map, _) = heights(map, map)?;
        for mesh in &mut meshes {
            change(mesh);
            let budget = EdgeBudget::Texels(2.0);
            let displacement = Displacement {
                budget,
                max_triangles: limit,
                ..Displacement::new(slot(), height)
            };
            mesh.displacement = Some(displacement);
        }
        Ok(
            texmap_mesh::tessellate(scene(meshes, map, DVec3::ZERO, DVec3::X), 64)
                .map(std::borrow::Cow::into_owned),
        )
    };
    const MANY: u32 = Displacement::MAX_TRIANGLES;
    let nothing: fn(&mut Mesh) = |_| ();
    let no_normals: fn(&mut Mesh) = |m| m.normals.fill([0.0; 3]);
    let still = with(no_normals, 0.5, MANY, MAP)??;
    let folded = with(nothing, -1.9, MANY, MAP)??;
    let mut told = f64::from(u8::from(
        still
            .warnings
            .iter()
            .any(|w| w.contains("stay where they are")),
    ));
    told += f64::from(u8::from(
        folded.warnings.iter().any(|w| w.contains("turn over")),
    ));
    told += f64::from(u8::from(matches!(
        with(nothing, 0.5, 1_000, MAP)?,
        Err(MeshError::TooManyTriangles { .. })
    )));
    told += f64::from(u8::from(with(nothing, f32::NAN, MANY, MAP)?.is_err()));
    let one = with(nothing, 0.5, MANY, 1)??;
    let empty = with(|m| *m = Mesh::default(), 0.5, MANY, MAP)??;
    let all: f64 = [&still, &folded, &one, &empty]
        .iter()
        .flat_map(|s| &s.meshes)
        .map(not_finite)
        .sum();
    // P + h N / |N| without a look at |N|.
    let mut naive = displaced(cube(), 0.0, 4.0)?.meshes;
    for p in naive.iter_mut().flat_map(|m| &mut m.positions) {
        let zero = DVec3::ZERO;
        let n = zero / zero.length();
        *p = (DVec3::from(p.map(f64::from)) + n * 0.5)
            .as_vec3()
            .to_array();
    }
    Ok(measured![
        "texmap", TOLD => told;
        "texmap", LOST => all;
        "normals divided by their length", LOST => naive.iter().map(not_finite).sum();
    ])
}

/// A rod of points along x and its two bones.
fn rod() -> (Mesh, Skeleton) {
    let positions = (0..=40)
        .map(|i| [f32::from(i as i8) * 0.1 - 2.0, 0.3, 0.1])
        .collect();
    let mesh = Mesh {
        name: "rod".into(),
        positions,
        ..Mesh::default()
    };
    let bone = |from: f64, to: f64, parent| Bone {
        head: DVec3::X * from,
        tail: DVec3::X * to,
        parent,
    };
    (
        mesh,
        Skeleton {
            bones: vec![bone(-2.0, 0.0, None), bone(0.0, 2.0, Some(0))],
        },
    )
}

pub(super) fn g2() -> Result<Vec<Measurement>, LabError> {
    const TOLD: &str = "bad weights that are told with their vertex, of 5";
    const OFF: &str = "distance of a vertex from where its bones put it, weights of sum 0.9";
    let (mesh, skeleton) = rod();
    let pose = skeleton.pose(&[
        DMat4::from_translation(DVec3::Y * 3.0),
        rotation(DVec3::Z, 1.0),
    ])?;
    let good = skeleton.skin(&mesh.positions, SkinBlend::Smooth(1.0));
    let with = |weights: [f32; 4], bones: [u16; 4]| {
        let mut skin = good.clone();
        (skin.weights[7], skin.bones[7]) = (weights, bones);
        skin
    };
    let bad = [
        with([0.5, 0.4, 0.0, 0.0], [0, 1, 0, 0]),
        with([0.0; 4], [0; 4]),
        with([f32::NAN, 1.0, 0.0, 0.0], [0; 4]),
        with([-0.5, 1.5, 0.0, 0.0], [0, 1, 0, 0]),
        with([0.5, 0.5, 0.0, 0.0], [0, 9, 0, 0]),
    ];
    let names = |skin: &Skin| {
        skin.bend(&mesh, &pose)
            .is_err_and(|e| e.to_string().contains("'rod' vertex 7"))
    };
    let told = bad.iter().filter(|skin| names(skin)).count();
    let expected = pose[0].transform_point3(DVec3::from(mesh.positions[7].map(f64::from)));
    let at = |skin: Skin| -> Result<f64, LabError> {
        let p = skin.bend(&mesh, &pose)?.positions[7];
        Ok((DVec3::from(p.map(f64::from)) - expected).length())
    };
    let normalized = at(with([0.9, 0.0, 0.0, 0.0], [0; 4]).normalized())?;
    // The sum of w M P as it is written, whatever the weights sum to.
    let p = DVec3::from(mesh.positions[7].map(f64::from));
    let naive = ((pose[0].transform_point3(p)) * 0.9 - expected).length();
    Ok(measured![
        "texmap", TOLD => told as f64;
        "weights divided by their sum", OFF => normalized;
        "weights as they are", OFF => naive;
    ])
}

pub(super) fn g3() -> Result<Vec<Measurement>, LabError> {
    const LOST: &str = "coordinates that are not finite, 1000 eyes on and near the axis";
    const AREA: &str = "error of the area of a card seen from anywhere, %";
    let board = |facing| {
        vec![Billboard {
            position: DVec3::ZERO,
            size: [2.0, 3.0],
            facing,
        }]
    };
    let (map, _) = heights(MAP, MAP)?;
    let (mut lost, mut naive, mut worst, mut fixed) = (0u32, 0u32, 0.0f64, 0.0f64);
    let mut noise = Noise::new(3);
    for i in 0..1_000 {
        let mut off = || {
            if i % 3 == 0 {
                0.0
            } else {
                (noise.unit() - 0.5) * deterministic_f64::pow(10.0, -f64::from(i % 40) * 8.0)
            }
        };
        let eye = DVec3::new(off(), 4.0, off());
        let mut seen = scene(
            vec![texmap_mesh::billboards(
                "card",
                board(Facing::Axis(DVec3::Y)),
                0,
            )],
            map.clone(),
            eye,
            DVec3::ZERO,
        );
        seen.camera.up = DVec3::Z;
        let turned = texmap_mesh::tessellate(&seen, 64)?.into_owned();
        lost += turned.meshes[0]
            .positions
            .as_flattened()
            .iter()
            .filter(|x| !x.is_finite())
            .count() as u32;
        let across = DVec3::Y.cross(eye);
        naive += u32::from(!(across / across.length()).is_finite());
    }
    for _ in 0..200 {
        let mut next = || 2.0 * noise.unit() - 1.0;
        let eye = DVec3::new(next(), next(), next()) * 7.0;
        let seen = scene(
            vec![texmap_mesh::billboards("card", board(Facing::Screen), 0)],
            map.clone(),
            eye,
            DVec3::ZERO,
        );
        let turned = texmap_mesh::tessellate(&seen, 64)?.into_owned();
        let p: Vec<DVec3> = turned.meshes[0]
            .positions
            .iter()
            .map(|p| DVec3::from(p.map(f64::from)))
            .collect();
        let area = (p[1] - p[0]).cross(p[3] - p[0]).dot(eye.normalize());
        worst = worst.max((area / 6.0 - 1.0).abs());
        fixed = fixed.max((eye.normalize().z - 1.0).abs());
    }
    Ok(measured![
        "texmap", LOST => lost.into();
        "across divided by its length", LOST => naive.into();
        "screen-aligned", AREA => 100.0 * worst;
        "a card that does not turn", AREA => 100.0 * fixed;
    ])
}

pub(super) fn g4() -> Result<Vec<Measurement>, LabError> {
    const OFF: &str = "largest distance of a post from its texel, side 1";
    const REFUSED: &str = "maps and sizes without an area that are refused, of 5";
    let (width, height) = (17u32, 9u32);
    let (map, values) = heights(width, height)?;
    let land = texmap_mesh::height_field("land", &map, [1.0, 1.0, 1.0], 1)?;
    let (mut off, mut naive) = (0.0f64, 0.0f64);
    for (i, p) in land.positions.iter().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let place = |i: u32, n: u32| f64::from(i) / f64::from(n - 1) - 0.5;
        let d = DVec3::from(p.map(f64::from))
            - DVec3::new(place(x, width), values[i].into(), place(y, height));
        off = off.max(d.abs().max_element());
        // i / N: the last post lies a cell short of the border.
        naive = naive.max((f64::from(x) / f64::from(width) - 0.5 - place(x, width)).abs());
    }
    let (line, _) = heights(1, 9)?;
    let bad = [
        texmap_mesh::height_field("a", &line, [1.0; 3], 1),
        texmap_mesh::height_field("a", &map, [0.0, 1.0, 1.0], 1),
        texmap_mesh::height_field("a", &map, [1.0, f32::NAN, 1.0], 1),
        texmap_mesh::height_field("a", &map, [1.0; 3], 0),
        texmap_mesh::height_field("a", &heights(2048, 2048)?.0, [1.0; 3], 1),
    ];
    Ok(measured![
        "texmap", OFF => off;
        "texel i at i / N", OFF => naive;
        "texmap", REFUSED => bad.iter().filter(|m| m.is_err()).count() as f64;
    ])
}
