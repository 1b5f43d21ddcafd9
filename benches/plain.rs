//! `plain/...`: a surface that is nothing but its texel, by the renderer with every crate linked, and by the rasterizer and
//! the sampler alone. Stages that the scene does not use must cost nothing. Both pictures must be the same, byte for byte.
//!
//! `cargo bench -p texmap-benches --bench plain` prints the ratio of minima first.

#![allow(clippy::print_stdout, reason = "the ratio is the output")]

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec3};
use texmap_math::{Footprint, Level};
use texmap_raster::{
    AttributePlanes, BATCH_PIXELS, BinnedDraws, DrawCall, FragmentBlock, NoAlphaTest, TargetSize,
    TileVisibility, Varyings,
};
use texmap_render::{RenderSettings, Renderer};
use texmap_sample::{
    ColorSpace, Filter, Origin, Precision, Sampler, Texture2d, sample_rgba8_slice,
};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot};

const SIDE: u32 = 1024;

/// The tilted plane of the chart, opaque and unlit.
fn scene(filter: Filter) -> Scene {
    let texels = (0..512 * 512u32).flat_map(|i| {
        let h = i.wrapping_mul(0x9e37_79b1) ^ (i >> 7);
        [(h >> 8) as u8, (h >> 16) as u8, (h >> 24) as u8, 255]
    });
    let texture = Texture2d::from_rgba8(
        512,
        512,
        texels.collect(),
        ColorSpace::Linear,
        Origin::TopLeft,
    )
    .expect("a texture");
    let corners = [[-10.0, -2.5], [10.0, -2.5], [10.0, 20.0], [-10.0, 20.0]];
    Scene {
        background: [0.0; 4],
        color: ColorMode::Raw,
        textures: vec![texture.with_mips()],
        materials: vec![Material {
            base_color: Some(TextureSlot {
                sampler: Sampler {
                    filter,
                    precision: Precision::Fast,
                    ..Sampler::default()
                },
                ..TextureSlot::new(0)
            }),
            texture_role: TextureRole::Decal,
            shading: Shading::Unlit,
            ..Material::default()
        }],
        meshes: vec![Mesh {
            positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
            uvs: corners.map(|c| c.map(|c: f32| c / 4.0)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, -3.0, 1.0),
            look: DVec3::new(0.3, 0.0, 0.35),
            up: DVec3::Z,
            fov_x: 60f64.to_radians(),
            near: 1e-3,
            far: f64::INFINITY,
        })
    }
}

/// State of a program that has the two crates and no renderer.
struct Alone<'s> {
    scene: &'s Scene,
    clip_from_world: DMat4,
    blocks: TileVisibility,
    planes: AttributePlanes,
    values: Varyings,
    run: Vec<FragmentBlock>,
    footprints: Vec<Footprint>,
    out: Vec<u32>,
    picture: Vec<u32>,
}

impl<'s> Alone<'s> {
    fn new(scene: &'s Scene) -> Self {
        Self {
            scene,
            clip_from_world: scene.camera.clip_from_world(1.0).expect("a camera"),
            blocks: TileVisibility::new(),
            planes: AttributePlanes::new(),
            values: Varyings::default(),
            run: Vec::new(),
            footprints: vec![Footprint::new(0.0, 0.0, 0.0, 0.0); BATCH_PIXELS],
            out: vec![0; BATCH_PIXELS],
            picture: vec![0; (SIDE * SIDE) as usize],
        }
    }

    fn frame(&mut self, level: Level) {
        let (mesh, material) = (&self.scene.meshes[0], &self.scene.materials[0]);
        let slot = material.base_color.as_ref().expect("a texture");
        let texture = &self.scene.textures[slot.texture];
        let draw = DrawCall {
            positions: &mesh.positions,
            indices: &mesh.triangles,
            attributes: mesh.uvs.as_flattened(),
            attribute_count: 2,
            clip_from_object: self.clip_from_world,
            ..DrawCall::default()
        };
        let size = TargetSize::new(SIDE, SIDE).expect("a size");
        let prepared = BinnedDraws::with_level(size, &[draw], level, 1).expect("valid");
        self.picture.fill(0);
        for tile in 0..prepared.tiles() {
            if prepared.is_empty(tile) {
                continue;
            }
            prepared.visible_blocks(tile, &NoAlphaTest, &mut self.blocks);
            prepared.planes(tile, &mut self.planes);
            self.run.clear();
            for block in 0..self.blocks.masks.len() {
                let mask = self.blocks.masks[block];
                if mask != 0 {
                    self.run.push(FragmentBlock {
                        block: block as u16,
                        mask,
                        slot: texmap_raster::NO_PRIMITIVE,
                    });
                }
                if self.run.len() == BATCH_PIXELS / 16 || block + 1 == self.blocks.masks.len() {
                    let corner = prepared.tile(tile);
                    self.shade(level, texture, &slot.sampler, (corner.x0, corner.y0));
                    self.run.clear();
                }
            }
        }
    }

    fn shade(&mut self, level: Level, texture: &Texture2d<'_>, sampler: &Sampler, at: (u32, u32)) {
        let count = self.run.len() * 16;
        self.planes.values(
            level,
            &self.blocks,
            &self.run,
            &[0, 1],
            true,
            &mut self.values,
        );
        let [u, v] = &self.values.varyings[..2] else {
            return;
        };
        for (i, d) in self.footprints[..count].iter_mut().enumerate() {
            *d = Footprint::new(u.ddx[i], v.ddx[i], u.ddy[i], v.ddy[i]);
        }
        let (grads, out) = (Some(&self.footprints[..count]), &mut self.out[..count]);
        sample_rgba8_slice(
            level,
            sampler,
            texture,
            &u.value[..count],
            &v.value[..count],
            grads,
            out,
        )
        .expect("slices of one length");
        for (block, colors) in self.run.iter().zip(self.out.chunks(16)) {
            let (x, y) = (
                u32::from(block.block % 16) * 4,
                u32::from(block.block / 16) * 4,
            );
            for (i, color) in (0..16).zip(colors) {
                if block.mask >> i & 1 == 1 {
                    let (x, y) = (at.0 + x + i % 4, at.1 + y + i / 4);
                    self.picture[(y * SIDE + x) as usize] = *color;
                }
            }
        }
    }
}

fn plain(c: &mut Criterion) {
    for (name, filter) in [
        ("bilinear", Filter::Bilinear),
        ("trilinear", Filter::Trilinear),
    ] {
        let scene = scene(filter);
        let settings = RenderSettings {
            threads: Some(1),
            ..RenderSettings::new(SIDE, SIDE)
        };
        let renderer = Renderer::new(&scene, &settings).expect("a sound scene");
        let mut alone = Alone::new(&scene);
        let level = Level::new();
        alone.frame(level);
        let frame = renderer.draw(&texmap_render::no_progress).expect("a frame");
        let bytes: Vec<u8> = alone.picture.iter().flat_map(|w| w.to_le_bytes()).collect();
        assert!(bytes == frame.rgba, "{name}: another picture");
        let mut best = [f64::INFINITY; 2];
        for _ in 0..15 {
            let start = Instant::now();
            alone.frame(level);
            black_box(&mut alone.picture);
            best[0] = best[0].min(start.elapsed().as_secs_f64());
            let start = Instant::now();
            black_box(renderer.draw(&texmap_render::no_progress)).ok();
            best[1] = best[1].min(start.elapsed().as_secs_f64());
        }
        println!(
            "plain/{name}: rasterizer and sampler alone {:.2} ms, the renderer with everything linked {:.2} ms: {:.2}",
            best[0] * 1e3,
            best[1] * 1e3,
            best[1] / best[0]
        );
        let mut group = c.benchmark_group(format!("plain/{name}"));
        group.sample_size(10);
        group.bench_function("alone", |b| b.iter(|| alone.frame(level)));
        group.bench_function("renderer", |b| {
            b.iter(|| black_box(renderer.draw(&texmap_render::no_progress)));
        });
        group.finish();
    }
}

criterion_group!(benches, plain);
criterion_main!(benches);
