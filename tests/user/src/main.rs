//! A program of somebody else, without any profile of its own: `.ci/unoptimised` builds it at opt-level 0, where kernels that are
//! inlined into one function have frames of megabytes. `user CASE [KIB]` runs a case on a thread of that many KiB (2048, what Rust
//! gives a thread), `user` lists the cases.

use texmap_light::{EnvironmentLayout, Environment, Light, PhongMaterial, illuminate_slice};
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_math::{Camera, Footprint, Homography, Level};
use texmap_render::{Aov, RenderSettings, pixel_hash, render, shadow_map};
use texmap_bake::{BakeOptions, bake};
use texmap_scene::{ProceduralHeight, Displacement, Material, Mesh, Reflection, NormalDetail, Scene, Shading, Shadow, SolidTexture, SolidTextureSource, TextureRole, TextureSlot, shadow_bias, shadow_kind};
use texmap_sample::{
    ColorSpace, Filter, Origin, EdgeMode, Pattern, Precision, Resample, Sampler, Texture2d,
    sample_rgba8_slice, sample_slice,
};

type Case = (&'static str, fn());

const CASES: [Case; 14] = [
    ("cube", || draw(&scene(), 1)),
    ("cube-msaa", || draw(&scene(), 4)),
    ("cube-vertex", || draw(&with(|m| m.shading = Shading::PerVertex), 1)),
    ("cube-texel", || draw(&with(|m| (m.shading, m.texture_role) = (Shading::Unlit, TextureRole::Decal)), 1)),
    ("shadow", || draw(&shadowed(), 1)),
    ("environment", || draw(&mirrored(), 1)),
    ("reliefs", reliefs),
    ("displaced", displaced),
    ("shadow-map", || {
        let (scene, kind) = (shadowed(), shadow_kind(&shadowed(), 1, None).expect("a light"));
        shadow_map(&scene, &kind, 256, 2).expect("a map");
    }),
    ("bake", baked),
    ("sample", samples),
    ("uv", mapped),
    ("warp", warped),
    ("light", lit),
];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let Some(name) = arguments.next() else {
        CASES.iter().for_each(|(name, _)| println!("{name}"));
        return;
    };
    let kib: usize = arguments.next().map_or(2048, |kib| kib.parse().expect("KiB"));
    let (_, case) = CASES.iter().find(|(known, _)| *known == name).expect("a case");
    let thread = std::thread::Builder::new().stack_size(kib << 10).spawn(case);
    thread.expect("a thread").join().expect("no panic");
}

fn checker() -> Texture2d<'static> {
    let texels = (0..16 * 16).flat_map(|i| [(i * 7 % 256) as u8, (i / 16 * 13) as u8, 90, 255]);
    Texture2d::from_rgba8(16, 16, texels.collect(), ColorSpace::Srgb, Origin::TopLeft).expect("a texture").with_mips()
}

fn slot(filter: Filter) -> TextureSlot {
    TextureSlot {
        sampler: Sampler { filter, ..Sampler::default() },
        ..TextureSlot::new(0)
    }
}

/// A textured cube on a floor, lit.
fn scene() -> Scene {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5);
    let mut cube = Mesh::default();
    for side in [[1, 3, 7, 5], [4, 6, 2, 0], [2, 6, 7, 3], [0, 1, 5, 4], [4, 5, 7, 6], [1, 0, 2, 3]] {
        let first = cube.positions.len() as u32;
        cube.positions.extend(side.map(corner));
        cube.uvs.extend([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        cube.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let floor = Mesh {
        positions: [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]].map(|[x, z]| [x, -0.5, z]).to_vec(),
        uvs: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    };
    Scene {
        background: [0.1, 0.2, 0.3, 1.0],
        lights: vec![
            Light::Ambient { color: [0.2; 3] },
            Light::Directional { color: [0.8; 3], direction: [-0.5, -1.0, -0.3] },
        ],
        textures: vec![checker()],
        materials: vec![Material { base_color: Some(slot(Filter::Trilinear)), ..Material::default() }],
        meshes: vec![cube, floor],
..Scene::new(Camera {
            eye: DVec3::new(1.5, 1.4, 2.6),
            look: DVec3::ZERO,
            up: DVec3::Y,
            fov_x: 1.0,
            near: 1e-4,
            far: f64::INFINITY,
            lens: Default::default(),
        })
}
}

fn with(change: impl Fn(&mut Material)) -> Scene {
    let mut scene = scene();
    change(&mut scene.materials[0]);
    scene
}

fn shadowed() -> Scene {
    let mut scene = scene();
    scene.effects.shadows.push(Shadow { light: 1, size: Some(256), bias: None, pcf_size: 3, area: None });
    scene
}

fn mirrored() -> Scene {
    let mut scene = scene();
    let sky = Environment::from_fn(EnvironmentLayout::LatLong, 32, |d| [0.5 + 0.5 * d.y as f32, 0.4, 0.6]).expect("a sky");
    let gloss = sky.specular_map(EnvironmentLayout::Cube, 8, 9.0).expect("a specular map");
    let cube = sky.convert(EnvironmentLayout::Cube, 16).expect("a cube");
    scene.effects.environments = vec![cube.with_mips(), gloss];
    scene.materials[0].reflection = Some(Reflection { environment: 0, reflectivity: 0.5, within: None });
    scene.materials[0].specular_map = Some(1);
    scene
}

fn draw(scene: &Scene, msaa: u32) {
    let settings = RenderSettings { msaa, aovs: Aov::ALL.to_vec(), ..RenderSettings::new(96, 64) };
    let frame = render(scene, &settings, &texmap_render::no_progress).expect("a picture");
    let alone = RenderSettings { threads: Some(1), ..settings };
    let again = render(scene, &alone, &texmap_render::no_progress).expect("a picture");
    assert_eq!(pixel_hash(&frame), pixel_hash(&again));
    assert!(frame.stats.pixels_covered > 1000);
}

fn reliefs() {
    let pattern = Pattern::Marble { octaves: 4, turbulence: 1.0 };
    let world_from_solid = DMat4::from_scale(DVec3::splat(0.5));
    draw(&with(|m| m.normal_detail = Some(NormalDetail::Bump { slot: slot(Filter::Trilinear), height: 0.05 })), 1);
    let carved = |heights| NormalDetail::Procedural { heights, world_from_solid, height: 0.05 };
    draw(&with(|m| m.normal_detail = Some(carved(ProceduralHeight::Pattern(pattern)))), 1);
    draw(&with(|m| m.normal_detail = Some(carved(ProceduralHeight::Waves { around: 5, fold: 0.2 }))), 1);
    draw(&with(|m| m.solid = Some(SolidTexture { source: SolidTextureSource::Pattern(pattern), world_from_solid })), 1);
}

fn displaced() {
    let mut scene = shadowed();
    scene.meshes[1].displacement = Some(Displacement::new(slot(Filter::Trilinear), 0.1));
    draw(&texmap_mesh::tessellate(scene, 96).expect("triangles"), 1);
}

fn baked() {
    let scene = shadowed();
    let kind = shadow_kind(&scene, 1, None).expect("a light");
    let map = shadow_map(&scene, &kind, 128, 1).expect("a map");
    let shadows = [(1, map, shadow_bias(&scene), 3)];
    bake(&scene, 1, &BakeOptions { size: 32, gutter: 2, shadows: &shadows, lights: None }).expect("a light map");
}

fn samples() {
    let texture = checker();
    let u: Vec<f32> = (0..300).map(|i| i as f32 / 77.0).collect();
    let grads = vec![Footprint::new(0.06, 0.01, 0.02, 0.3); 300];
    let (mut out, mut bytes) = (vec![[0.0; 4]; 300], vec![0; 300]);
    for filter in ["nearest", "bilinear", "bicubic:mitchell", "mip-nearest", "trilinear", "anisotropic:16", "ewa:8"] {
        let filter = filter.parse().expect("a filter");
        for precision in [Precision::Exact, Precision::Fast] {
            let sampler = Sampler { filter, precision, ..Sampler::default() };
            for grads in [None, Some(&grads[..])] {
                sample_slice(Level::new(), &sampler, &texture, &u, &u, grads, &mut out).expect("samples");
                sample_rgba8_slice(Level::new(), &sampler, &texture, &u, &u, grads, &mut bytes).expect("samples");
            }
        }
    }
}

fn mapped() {
    use texmap_uv::{ProjectionSource, Faces, Mapping, Mesh, Report, ReportOptions, Shape, report, tangents};
    let scene = scene();
    let cube = &scene.meshes[0];
    let mut faces = Faces::new();
    cube.triangles.iter().for_each(|t| faces.push(t));
    let mesh = Mesh::new(&cube.positions, &faces).expect("a mesh");
    for shape in [Shape::Plane, Shape::Box, Shape::Sphere, Shape::Cylinder] {
        for by in [ProjectionSource::Position, ProjectionSource::Normal, ProjectionSource::Centroid] {
            let mapping = Mapping { by, ..Mapping::new(shape) };
            let mapped = mapping.map(Level::new(), &mesh, &[]).expect("coordinates");
            let _: Report = report(&mesh, &mapped.set, &ReportOptions::default()).expect("a report");
        }
    }
    let _ = tangents;
}

fn warped() {
    let texture = checker();
    let to = [[3.0, 2.0], [50.0, 8.0], [44.0, 40.0], [6.0, 36.0]].map(|[x, y]| DVec2::new(x, y));
    let from = [[0.0, 0.0], [16.0, 0.0], [16.0, 16.0], [0.0, 16.0]].map(|[x, y]| DVec2::new(x, y));
    let map = Homography::from_quads(from, to).expect("a map");
    let mut out = vec![[0.0; 4]; 64 * 48];
    let resample = Resample::new(&texture, Filter::Anisotropic(8), EdgeMode::Transparent, &map);
    resample.rows(Level::new(), 64, 0, &mut out).expect("rows");
}

fn lit() {
    let normals = vec![[0.0, 0.6, 0.8]; 50];
    let mut out = vec![[0.0; 3]; 50];
    illuminate_slice(&PhongMaterial::default(), &scene().lights, &normals, &normals, [1.0, 2.0, 3.0], &mut out)
        .expect("light");
    let sky = Environment::from_fn(EnvironmentLayout::LatLong, 16, |d| [d.y as f32 + 1.0; 3]).expect("a sky");
    sky.convert(EnvironmentLayout::Octahedron, 16).expect("a chart").radiance_slice(&normals, &mut out).expect("light");
    sky.blur(EnvironmentLayout::DualParaboloid, 8, 5.0).expect("a blur");
}
