//! Random scenes: samplers, alpha and shading in every combination that the tile's paths tell apart.

use texmap_light::{Light, PhongMaterial};
use texmap_raster::Cull;
use texmap_render::{Aov, RenderSettings};
use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d, UvTransform, Wrap};
use texmap_scene::{
    AlphaMode, ColorMode, Emission, Material, Mesh, Scene, Shading, TextureRole, TextureSlot, UvSet,
};

use crate::scenes::{empty, quad};

/// Xorshift.
#[derive(Debug)]
pub struct Random(u64);

impl Random {
    /// Different numbers for every seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
        (0..8).for_each(|_| _ = random.next());
        random
    }

    /// 32 bits.
    #[expect(clippy::should_implement_trait, reason = "it never ends")]
    pub fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.next().is_multiple_of(n)
    }

    /// Evenly between two numbers.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.next() >> 8) as f32 / (1 << 24) as f32
    }

    /// One of a few.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
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
        uv_set: UvSet::First,
    };
    let base_color = (!random.one_in(5)).then(|| slot(random));
    let opacity_map = random.one_in(6).then(|| slot(random));
    let emission = random.one_in(4).then(|| Emission {
        color: [0.1, random.range(0.0, 0.5), 1.5],
        map: (!random.one_in(3)).then(|| slot(random)),
    });
    Material {
        phong: PhongMaterial {
            color: [random.range(0.0, 1.0), random.range(0.0, 1.0), 1.0],
            ..PhongMaterial::default()
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

/// Textures, samplers, materials and triangles at random, lit by a point light.
#[must_use]
pub fn scene(seed: u64) -> Scene {
    let mut random = Random::new(seed);
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

/// Every AOV, with four samples a pixel or four pixels for one at times.
#[must_use]
pub fn settings(seed: u64) -> RenderSettings {
    RenderSettings {
        aovs: Aov::ALL.to_vec(),
        msaa: if seed % 4 == 1 { 4 } else { 1 },
        supersample: if seed % 4 == 3 { 2 } else { 1 },
        ..RenderSettings::new(90, 70)
    }
}
