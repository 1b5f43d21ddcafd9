//! The race with the registry's software renderers: a floor and a torus of 100,000 triangles, textured by the nearest texel, drawn by
//! texmap, euc 0.5.3 and retrofire 0.4.0 in turns on one pinned core.
//!
//! `cargo run --release -p texmap-benches --features rust-peers --bin rust-peers` writes `benches/results/rust_peers.md`.
//!
//! The pictures are compared with the f64 truth before any time counts. euc has no sampler and gets a look-up of four operations;
//! retrofire's is its `SamplerRepeatPot`. Neither has filters, mip maps or threads: texmap draws on one thread, and beside it with
//! trilinear filtering, which the others cannot.

#![allow(clippy::print_stdout, reason = "the rows are the output")]

use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use euc::Target as _;
use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use retrofire_core::geom::{Tri, Vertex, tri, vertex};
use retrofire_core::math::{Color4, ProjVec3, Vector, pt2, rgba, viewport};
use retrofire_core::render::tex::SamplerRepeatPot;
use retrofire_core::render::{Colorbuf, Context, Frag, Framebuf, TexCoord, Texture, shader, uv};
use retrofire_core::util::pixfmt::Rgba8888;
use retrofire_core::util::{Buf2, Dims};
use texmap_benches::textures::squares;
use texmap_lab::truth::rays::{RayObject, RayScene};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec3};
use texmap_render::{
    ColorMode, Frame, Material, Mesh, Renderer, Scene, Settings, Shading, TextureRole, TextureSlot,
};
use texmap_sample::{Filter, Precision, Sampler, Texture2d, UvTransform};

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
/// Texels a side.
const SIDE: u32 = 256;
const ROUNDS: usize = 7;
const BACKGROUND: [u8; 4] = [26, 51, 77, 255];

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    if let Some(core) = core_affinity::get_core_ids().and_then(|cores| cores.first().copied()) {
        core_affinity::set_for_current(core);
    }
    let mut out = String::from(HEADER);
    for (name, mesh) in [("floor", floor()), ("torus, 100k triangles", torus())] {
        let scene = scene(&mesh, Filter::Nearest)?;
        let truth = truth(&scene)?;
        let filtered = self::scene(&mesh, Filter::Trilinear)?;
        let mut racers: Vec<(&str, Box<dyn Racer>)> = vec![
            ("texmap", Box::new(Texmap::new(&scene)?)),
            ("texmap, trilinear", Box::new(Texmap::new(&filtered)?)),
            ("euc 0.5.3", Box::new(Euc::new(&scene)?)),
            ("retrofire 0.4.0", Box::new(Retrofire::new(&scene)?)),
        ];
        let mut least = vec![f64::MAX; racers.len()];
        for _ in 0..ROUNDS {
            for ((_, racer), least) in racers.iter_mut().zip(&mut least) {
                let start = Instant::now();
                racer.frame();
                *least = least.min(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        for ((who, racer), time) in racers.iter().zip(&least) {
            let picture = racer.picture();
            let off = picture.chunks_exact(4).zip(truth.iter());
            let off = off.filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 1));
            let off = 100.0 * off.count() as f64 / f64::from(WIDTH * HEIGHT);
            let off = if who.contains("trilinear") {
                "another filter".to_owned()
            } else {
                format!("{off:.3} %")
            };
            writeln!(
                out,
                "| {name} | {who} | {time:.2} | {:.2} | {off} |",
                time / least[0]
            )?;
        }
    }
    print!("{out}");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/rust_peers.md");
    std::fs::write(path, out)?;
    Ok(())
}

const HEADER: &str = "\
# The race with the registry's renderers

`cargo run --release -p texmap-benches --features rust-peers --bin rust-peers`

1920 x 1080, one thread, pinned, all in turns; least times. Pixels that are off differ by more than 1 of 255 from the f64 truth at the
pixel's centre.

| scene | renderer | ms | times texmap's | pixels off |
|---|---|---|---|---|
";

/// The texel that the f64 ray through each pixel's centre meets.
fn truth(scene: &Scene) -> Outcome<Vec<[u8; 4]>> {
    let rays = RayScene::new([RayObject::Mesh(&scene.meshes[0])]);
    let texture = &scene.textures[0];
    let mut picture = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = scene.camera.ray(WIDTH, HEIGHT, x, y)?;
        let hit = rays.nearest(scene.camera.eye, ray, (1e-6, f64::INFINITY));
        picture.push(hit.and_then(|hit| hit.uv).map_or(BACKGROUND, |uv| {
            let [x, y] = [uv.x, uv.y]
                .map(|c| (c * f64::from(SIDE)).floor().rem_euclid(f64::from(SIDE)) as u32);
            let texel = texture.texel(0, x, y).unwrap_or_default();
            texel.map(|c| (c * 255.0 + 0.5) as u8)
        }));
    }
    Ok(picture)
}

/// A renderer with a scene made ready.
trait Racer {
    /// Clears and draws.
    fn frame(&mut self);
    /// RGBA, rows top to bottom.
    fn picture(&self) -> Vec<u8>;
}

struct Texmap<'s> {
    renderer: Renderer<'s>,
    frame: Frame,
}

impl<'s> Texmap<'s> {
    fn new(scene: &'s Scene) -> Outcome<Self> {
        let mut settings = Settings::new(WIDTH, HEIGHT);
        settings.threads = Some(1);
        let renderer = Renderer::new(scene, &settings)?;
        let frame = renderer.draw(&|_, _| {})?;
        Ok(Self { renderer, frame })
    }
}

impl Racer for Texmap<'_> {
    fn frame(&mut self) {
        let in_order = |blocks| (0..blocks).collect();
        self.renderer
            .draw_into(&mut self.frame, &|_, _| {}, &in_order)
            .expect("what was drawn before is drawn again");
    }

    fn picture(&self) -> Vec<u8> {
        self.frame.rgba.clone()
    }
}

/// What both peers get: positions that one matrix takes to clip space, and texels.
struct Given {
    clip_from_object: [[f32; 4]; 4],
    vertices: Vec<([f32; 3], [f32; 2])>,
    triangles: Vec<[u32; 3]>,
    texels: Vec<[u8; 4]>,
}

impl Given {
    fn new(scene: &Scene) -> Outcome<Self> {
        let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
        let projected = scene.camera.clip_from_world(aspect)?;
        // From 1 at the near plane and 0 at the far one to -1 and 1.
        let turned = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 1.0, 1.0,
        ]);
        let rows = (turned * projected).transpose().to_cols_array_2d();
        let mesh = &scene.meshes[0];
        let texture = &scene.textures[0];
        let texel = |i: u32| texture.texel(0, i % SIDE, i / SIDE).unwrap_or_default();
        Ok(Self {
            clip_from_object: rows.map(|row| row.map(|c| c as f32)),
            vertices: mesh
                .positions
                .iter()
                .copied()
                .zip(mesh.uvs.iter().copied())
                .collect(),
            triangles: mesh.triangles.clone(),
            texels: (0..SIDE * SIDE)
                .map(|i| texel(i).map(|c| (c * 255.0 + 0.5) as u8))
                .collect(),
        })
    }

    fn clip(&self, [x, y, z]: [f32; 3]) -> [f32; 4] {
        self.clip_from_object
            .map(|r| r[0] * x + r[1] * y + r[2] * z + r[3])
    }
}

struct Euc {
    given: Given,
    corners: Vec<u32>,
    color: Buffer2d<[u8; 4]>,
    depth: Buffer2d<f32>,
}

impl Euc {
    fn new(scene: &Scene) -> Outcome<Self> {
        let given = Given::new(scene)?;
        let size = [WIDTH as usize, HEIGHT as usize];
        Ok(Self {
            corners: given.triangles.as_flattened().to_vec(),
            given,
            color: Buffer2d::new(size, BACKGROUND),
            depth: Buffer2d::new(size, 1.0),
        })
    }
}

struct Shaders<'g>(&'g Given);

/// Coordinates in texels.
#[derive(Clone, Copy)]
struct Place([f32; 2]);

impl euc::Interpolate for Place {
    #[inline(always)]
    fn lerp2(a: Self, b: Self, x: f32, y: f32) -> Self {
        Self([0, 1].map(|k| a.0[k] * x + b.0[k] * y))
    }

    #[inline(always)]
    fn lerp3(a: Self, b: Self, c: Self, x: f32, y: f32, z: f32) -> Self {
        Self([0, 1].map(|k| a.0[k] * x + b.0[k] * y + c.0[k] * z))
    }
}

impl euc::Pipeline for Shaders<'_> {
    type Vertex = u32;
    type VsOut = Place;
    type Pixel = [u8; 4];

    #[inline(always)]
    fn vert(&self, vertex: &u32) -> ([f32; 4], Place) {
        let (position, uv) = self.0.vertices[*vertex as usize];
        (self.0.clip(position), Place(uv.map(|c| c * SIDE as f32)))
    }

    #[inline(always)]
    fn frag(&self, Place([u, v]): &Place) -> [u8; 4] {
        let [x, y] = [u, v].map(|c| c.floor() as i32 as u32 & (SIDE - 1));
        self.0.texels[(y * SIDE + x) as usize]
    }
}

impl Racer for Euc {
    fn frame(&mut self) {
        self.color.clear(BACKGROUND);
        self.depth.clear(1.0);
        euc::Pipeline::draw::<Triangles<'_, _, BackfaceCullingDisabled>, _>(
            &Shaders(&self.given),
            &self.corners,
            &mut self.color,
            Some(&mut self.depth),
        );
    }

    fn picture(&self) -> Vec<u8> {
        self.color.as_ref().as_flattened().to_vec()
    }
}

struct Retrofire {
    given: Given,
    vertices: Vec<Vertex<[f32; 3], TexCoord>>,
    triangles: Vec<Tri<usize>>,
    texture: Texture<Buf2<Color4>>,
    sampler: SamplerRepeatPot,
    target: Framebuf<Colorbuf<Buf2<[u8; 4]>, Rgba8888>, Buf2<f32>>,
}

impl Retrofire {
    fn new(scene: &Scene) -> Outcome<Self> {
        let given = Given::new(scene)?;
        let texels = given.texels.iter().map(|[r, g, b, a]| rgba(*r, *g, *b, *a));
        let texture = Texture::from(Buf2::new_from(Dims(SIDE, SIDE), texels));
        let size = Dims(WIDTH, HEIGHT);
        Ok(Self {
            vertices: given
                .vertices
                .iter()
                .map(|(position, [u, v])| vertex(*position, uv(*u, *v)))
                .collect(),
            triangles: given
                .triangles
                .iter()
                .map(|t| tri(t[0] as usize, t[1] as usize, t[2] as usize))
                .collect(),
            sampler: SamplerRepeatPot::new(&texture),
            texture,
            given,
            target: Framebuf {
                color_buf: Colorbuf::new(Buf2::new(size)),
                depth_buf: Buf2::new(size),
            },
        })
    }
}

impl Racer for Retrofire {
    fn frame(&mut self) {
        self.target.color_buf.buf.fill(BACKGROUND);
        // Reciprocals of w: far away is 0.
        self.target.depth_buf.fill(0.0);
        let (given, sampler, texture) = (&self.given, &self.sampler, &self.texture);
        let shader = shader::new(
            |v: Vertex<[f32; 3], TexCoord>, (): ()| {
                let clip: ProjVec3 = Vector::new(given.clip(v.pos));
                vertex(clip, v.attrib)
            },
            |frag: Frag<TexCoord>, (): ()| sampler.sample(texture, frag.var),
        );
        retrofire_core::render::render(
            &self.triangles,
            &self.vertices,
            &shader,
            (),
            viewport(pt2(0, HEIGHT)..pt2(WIDTH, 0)),
            &mut self.target,
            &Context {
                face_cull: None,
                ..Context::default()
            },
        );
    }

    fn picture(&self) -> Vec<u8> {
        self.target.color_buf.buf.data().as_flattened().to_vec()
    }
}

/// A plane to the horizon, all of it before the eye: euc does not clip.
fn floor() -> Mesh {
    Mesh {
        positions: [[-400.0, -100.0], [400.0, -100.0], [4.0, -1.0], [-4.0, -1.0]]
            .map(|[x, z]| [x, -1.0, z])
            .to_vec(),
        uvs: vec![[-100.0, 25.0], [100.0, 25.0], [1.0, 0.25], [-1.0, 0.25]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    }
}

/// 500 around, 100 about the tube.
fn torus() -> Mesh {
    let (around, about) = (500u32, 100u32);
    let mut mesh = Mesh::default();
    for j in 0..=around {
        for i in 0..=about {
            let turn = |k: u32, n: u32| {
                texmap_math::det::sin_cos(std::f64::consts::TAU * f64::from(k) / f64::from(n))
            };
            let ((s, c), (t, d)) = (turn(j, around), turn(i, about));
            let out = 1.5 + 0.6 * d;
            let p = DVec3::new(out * c, 0.6 * t + 0.15 * s, out * s - 4.0);
            mesh.positions.push(p.as_vec3().to_array());
            mesh.uvs.push([
                16.0 * j as f32 / around as f32,
                4.0 * i as f32 / about as f32,
            ]);
        }
    }
    let row = about + 1;
    for (j, i) in (0..around).flat_map(|j| (0..about).map(move |i| (j, i))) {
        let a = j * row + i;
        mesh.triangles.push([a, a + 1, a + row]);
        mesh.triangles.push([a + 1, a + row + 1, a + row]);
    }
    mesh
}

fn scene(mesh: &Mesh, filter: Filter) -> Outcome<Scene> {
    let texture: Texture2d<'static> = squares(SIDE);
    let sampler = Sampler {
        filter,
        precision: Precision::Fast,
        ..Sampler::default()
    };
    Ok(Scene {
        camera: Camera {
            eye: DVec3::new(0.0, 0.6, 0.0),
            look: DVec3::new(0.0, -0.3, -4.0),
            up: DVec3::Y,
            fov_x: 80f64.to_radians(),
            near: 0.1,
            far: 1000.0,
        },
        background: BACKGROUND.map(|c| f32::from(c) / 255.0),
        color: ColorMode::Raw,
        depth_test: Default::default(),
        lights: Vec::new(),
        textures: vec![texture.with_mips()],
        materials: vec![Material {
            base_color: Some(TextureSlot {
                texture: 0,
                sampler,
                transform: UvTransform::default(),
            }),
            shading: Shading::Unlit,
            texture_role: TextureRole::Decal,
            ..Material::default()
        }],
        meshes: vec![mesh.clone()],
        effects: Default::default(),
        warnings: Vec::new(),
    })
}
