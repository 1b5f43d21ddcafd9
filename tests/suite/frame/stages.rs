//! Random scenes: every path through the tile gives the same bytes, on every level, any number of threads and in any order.

use texmap_light::{Light, Surface};
use texmap_raster::Cull;
use texmap_render::{
    AlphaMode, Aov, ColorMode, Emission, Frame, Material, Mesh, Renderer, Scene, Settings, Shading,
    TextureRole, TextureSlot, pixel_hash, render, render_ordered,
};
use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d, UvTransform, Wrap};
use texmap_tests::levels::levels;

use crate::scenes::{bits, empty, quad, unlit, values};

/// Xorshift.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    fn one_in(&mut self, n: u32) -> bool {
        self.next().is_multiple_of(n)
    }

    fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.next() >> 8) as f32 / (1 << 24) as f32
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.next() as usize % of.len()]
    }
}

fn texture(random: &mut Random) -> Texture2d<'static> {
    let (width, height) = (random.pick(&[1, 8, 13, 64]), random.pick(&[1, 16, 9, 32]));
    let opaque = random.one_in(2);
    let texels = (0..width * height * 4)
        .map(|i| match i % 4 == 3 && opaque {
            true => 255,
            false => random.next() as u8,
        })
        .collect();
    let space = random.pick(&[ColorSpace::Linear, ColorSpace::Srgb]);
    let origin = random.pick(&[Origin::TopLeft, Origin::BottomLeft]);
    Texture2d::from_rgba8(width, height, texels, space, origin).expect("well formed")
}

fn material(random: &mut Random) -> Material {
    let filters = [
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Trilinear,
        Filter::Anisotropic(8),
        Filter::MipNearest,
    ];
    let wraps = [
        Wrap::Repeat,
        Wrap::MirroredRepeat,
        Wrap::ClampToEdge,
        Wrap::ClampToBorder,
    ];
    let slot = |random: &mut Random| TextureSlot {
        texture: random.next() as usize % 3,
        sampler: Sampler {
            filter: random.pick(&filters),
            wrap_u: random.pick(&wraps),
            wrap_v: random.pick(&wraps),
            precision: random.pick(&[Precision::Exact, Precision::Fast]),
            border: [0.2, 0.4, 0.1, random.pick(&[0.5, 1.0])],
            ..Sampler::default()
        },
        transform: match random.next() % 3 {
            0 => UvTransform {
                offset: [0.3, -0.2],
                scale: [2.0, 3.0],
                rotation: 0.4,
            },
            _ => UvTransform::default(),
        },
    };
    let base_color = (!random.one_in(5)).then(|| slot(random));
    let opacity_map = random.one_in(6).then(|| slot(random));
    let emission = random.one_in(4).then(|| Emission {
        color: [0.1, random.range(0.0, 0.5), 1.5],
        map: (!random.one_in(3)).then(|| slot(random)),
    });
    Material {
        surface: Surface {
            color: [random.range(0.0, 1.0), random.range(0.0, 1.0), 1.0],
            ..Surface::default()
        },
        opacity: random.pick(&[1.0, 1.0, 0.6]),
        base_color,
        opacity_map,
        emission,
        texture_role: random.pick(&[TextureRole::Decal, TextureRole::Modulate]),
        shading: random.pick(&[
            Shading::Unlit,
            Shading::Unlit,
            Shading::PerVertex,
            Shading::PerPixel,
        ]),
        alpha: random.pick(&[
            AlphaMode::Opaque,
            AlphaMode::Opaque,
            AlphaMode::Blend,
            AlphaMode::Test(0.0),
            AlphaMode::Test(0.4),
        ]),
        cull: random.pick(&[Cull::None, Cull::Back]),
        ..Material::default()
    }
}

fn mesh(random: &mut Random, material: usize) -> Mesh {
    let mut at = |spread: f32| {
        [
            random.range(-spread, spread),
            random.range(-spread, spread),
            -random.range(0.3, 4.0),
        ]
    };
    let mut mesh = quad([at(2.0), at(2.0), at(2.0), at(2.0)]);
    // Small triangles: several to a block.
    for _ in 0..40 {
        let centre = at(1.5);
        let first = mesh.positions.len() as u32;
        for corner in [[0.0, 0.0], [0.15, 0.02], [0.03, 0.12]] {
            mesh.positions
                .push([centre[0] + corner[0], centre[1] + corner[1], centre[2]]);
            mesh.uvs
                .push([centre[0] + corner[0] * 7.0, corner[1] * 5.0]);
        }
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    if random.one_in(4) {
        mesh.colors = (0..mesh.positions.len())
            .map(|i| [1.0, (i % 3) as f32 / 2.0, 0.5])
            .collect();
    }
    Mesh { material, ..mesh }
}

fn scene(seed: u64) -> Scene {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
    (0..8).for_each(|_| _ = random.next());
    let textures = (0..3).map(|_| texture(&mut random)).collect();
    let materials = (0..4).map(|_| material(&mut random)).collect();
    let meshes = (0..4).map(|i| mesh(&mut random, i)).collect();
    Scene {
        background: [0.2, 0.3, 0.4, random.pick(&[1.0, 0.5])],
        color: random.pick(&[ColorMode::Raw, ColorMode::Srgb]),
        lights: vec![
            Light::Ambient { color: [0.3; 3] },
            Light::Point {
                color: [0.7; 3],
                position: [0.5, 1.0, 0.5],
            },
        ],
        textures,
        materials,
        meshes,
        ..empty()
    }
}

fn settings(seed: u64) -> Settings {
    Settings {
        aovs: Aov::ALL.to_vec(),
        msaa: if seed % 4 == 1 { 4 } else { 1 },
        supersample: if seed % 4 == 3 { 2 } else { 1 },
        ..Settings::new(90, 70)
    }
}

fn assert_same(frame: &Frame, expected: &Frame, what: &str) {
    assert_eq!(pixel_hash(frame), pixel_hash(expected), "{what}");
    assert_eq!(bits(frame), bits(expected), "{what}");
    let covered = [frame, expected].map(|f| f.stats.pixels_covered);
    assert_eq!(covered[0], covered[1], "{what}");
}

#[test]
fn random_scenes_have_one_picture() {
    let mut colours = std::collections::BTreeSet::new();
    for seed in 0..200 {
        let (scene, settings) = (scene(seed), settings(seed));
        let expected = render(&scene, &settings, &|_, _| ()).expect("a good scene");
        colours.extend(expected.rgba.chunks_exact(4).map(<[u8]>::to_vec));
        let general = Renderer::new(&scene, &settings)
            .expect("a good scene")
            .staged();
        let general = general.draw(&|_, _| ()).expect("a good scene");
        assert_same(&general, &expected, &format!("seed {seed}, all stages"));
        for (name, level) in levels() {
            let settings = Settings {
                level,
                ..settings.clone()
            };
            let frame = render(&scene, &settings, &|_, _| ()).expect("a good scene");
            assert_same(&frame, &expected, &format!("seed {seed}, {name}"));
        }
        for threads in [1, 2, 3, 8] {
            let settings = Settings {
                threads: Some(threads),
                ..settings.clone()
            };
            let backwards = |n: usize| (0..n).rev().collect();
            let frame = render_ordered(&scene, &settings, &|_, _| (), &backwards);
            let frame = frame.expect("a good scene");
            assert_same(
                &frame,
                &expected,
                &format!("seed {seed}, {threads} threads"),
            );
        }
    }
    // The comparison is not one of empty pictures.
    assert!(colours.len() > 50_000, "{} colours", colours.len());
}

/// Four samples a pixel see a quarter of an edge pixel: the mean of the covered samples, in linear light, and nothing within.
#[test]
fn four_samples_smooth_edges_and_nothing_else() {
    let white = Scene {
        color: ColorMode::Srgb,
        materials: vec![unlit([1.0; 3])],
        meshes: vec![quad([
            [-0.5, -0.6, -1.0],
            [0.5, -0.4, -1.0],
            [0.4, 0.6, -1.0],
            [-0.6, 0.4, -1.0],
        ])],
        ..empty()
    };
    let four = Settings {
        msaa: 4,
        ..Settings::new(64, 64)
    };
    let frame = render(&white, &four, &|_, _| ()).expect("a good scene");
    let mut seen: Vec<_> = frame.rgba.chunks_exact(4).map(|p| p[0]).collect();
    seen.sort_unstable();
    seen.dedup();
    // 0, 1/4, 1/2, 3/4 and 1 of white light as sRGB bytes.
    assert_eq!(seen, [0, 137, 188, 225, 255]);
    let one = render(&white, &Settings::new(64, 64), &|_, _| ()).expect("a good scene");
    let mut edges = 0;
    for (a, b) in frame.rgba.chunks_exact(4).zip(one.rgba.chunks_exact(4)) {
        if a != b {
            assert!(![0, 255].contains(&a[0]), "{a:?} {b:?}");
            edges += 1;
        }
    }
    assert!((60..300).contains(&edges), "{edges}");
}

/// Both sides of an edge that two triangles share: with four samples nothing of the background shows through.
#[test]
fn four_samples_leave_no_seam() {
    let scene = Scene {
        background: [1.0, 0.0, 0.0, 1.0],
        materials: vec![unlit([0.0, 1.0, 0.0])],
        meshes: vec![quad([
            [-3.0, -3.0, -1.0],
            [3.0, -3.1, -1.3],
            [3.0, 3.0, -1.0],
            [-3.2, 3.0, -1.1],
        ])],
        ..empty()
    };
    let four = Settings {
        msaa: 4,
        aovs: vec![Aov::Depth],
        ..Settings::new(70, 66)
    };
    let frame = render(&scene, &four, &|_, _| ()).expect("a good scene");
    assert!(frame.rgba.chunks_exact(4).all(|p| p == [0, 255, 0, 255]));
    assert!(values(&frame, Aov::Depth, 35, 33)[0] > 0.0);
}

#[test]
fn samples_other_than_one_or_four_are_refused() {
    let scene = scene(1);
    for (msaa, supersample) in [(0, 1), (2, 1), (8, 1), (4, 2)] {
        let settings = Settings {
            msaa,
            supersample,
            ..Settings::new(8, 8)
        };
        let error = render(&scene, &settings, &|_, _| ()).expect_err("refused");
        assert!(error.to_string().contains("msaa"), "{error}");
    }
}
