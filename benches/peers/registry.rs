//! euc 0.5.3 and retrofire 0.4.0, and texmap beside them, each with a scene of one mesh made ready.
//!
//! euc has no sampler and gets a look-up of four operations; retrofire's is its `SamplerRepeatPot`. Neither has filters, mip maps or
//! threads.

use std::error::Error;

use euc::Target as _;
use euc::buffer::Buffer2d;
use euc::rasterizer::{BackfaceCullingDisabled, Triangles};
use retrofire_core::geom::{Tri, Vertex, tri, vertex};
use retrofire_core::math::{Color4, ProjVec3, Vector, pt2, rgba, viewport};
use retrofire_core::render::tex::SamplerRepeatPot;
use retrofire_core::render::{Colorbuf, Context, Frag, Framebuf, TexCoord, Texture, shader, uv};
use retrofire_core::util::pixfmt::Rgba8888;
use retrofire_core::util::{Buf2, Dims};
use texmap_math::glam::DMat4;
use texmap_render::{Frame, RenderSettings, Renderer};
use texmap_scene::Scene;

pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;

/// A renderer with a scene made ready.
pub(crate) trait Racer {
    /// Clears and draws.
    fn frame(&mut self);
    /// RGBA, rows top to bottom.
    fn picture(&self) -> Vec<u8>;
}

pub(crate) struct Texmap<'s> {
    renderer: Renderer<'s>,
    frame: Frame,
}

impl<'s> Texmap<'s> {
    pub(crate) fn new(scene: &'s Scene, [width, height]: [u32; 2]) -> Outcome<Self> {
        let mut settings = RenderSettings::new(width, height);
        settings.threads = Some(1);
        let renderer = Renderer::new(scene, &settings)?;
        let frame = renderer.draw(&texmap_render::no_progress)?;
        Ok(Self { renderer, frame })
    }
}

impl Racer for Texmap<'_> {
    fn frame(&mut self) {
        let in_order = |blocks| (0..blocks).collect();
        self.renderer
            .draw_into(&mut self.frame, &texmap_render::no_progress, &in_order)
            .expect("what was drawn before is drawn again");
    }

    fn picture(&self) -> Vec<u8> {
        self.frame.rgba.clone()
    }
}

/// Input of both peers: positions that one matrix takes to clip space, and texels.
pub(crate) struct Given {
    pub(crate) size: [u32; 2],
    /// Of the texture: texels a side, a power of two.
    pub(crate) side: u32,
    /// Rows; z from -1 at the near plane to 1 at the far one.
    pub(crate) clip_from_object: [[f32; 4]; 4],
    pub(crate) vertices: Vec<([f32; 3], [f32; 2])>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) texels: Vec<[u8; 4]>,
}

impl Given {
    pub(crate) fn new(scene: &Scene, size: [u32; 2]) -> Outcome<Self> {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let projected = scene.camera.clip_from_world(aspect)?;
        // From 1 at the near plane and 0 at the far one to -1 and 1.
        let turned = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 1.0, 1.0,
        ]);
        let rows = (turned * projected).transpose().to_cols_array_2d();
        let mesh = &scene.meshes[0];
        let texture = scene.textures.first();
        let side = texture.map_or(1, |t| t.width());
        let texel = |i: u32| {
            let texel = texture.and_then(|t| t.texel(0, i % side, i / side));
            texel.unwrap_or_default()
        };
        Ok(Self {
            size,
            side,
            clip_from_object: rows.map(|row| row.map(|c| c as f32)),
            vertices: mesh
                .positions
                .iter()
                .copied()
                .zip(mesh.uvs.iter().copied())
                .collect(),
            triangles: mesh.triangles.clone(),
            texels: (0..side * side)
                .map(|i| texel(i).map(|c| (c * 255.0 + 0.5) as u8))
                .collect(),
        })
    }

    pub(crate) fn clip(&self, [x, y, z]: [f32; 3]) -> [f32; 4] {
        self.clip_from_object
            .map(|r| r[0] * x + r[1] * y + r[2] * z + r[3])
    }
}

pub(crate) struct Euc {
    given: Given,
    background: [u8; 4],
    color: Buffer2d<[u8; 4]>,
    depth: Buffer2d<f32>,
}

impl Euc {
    pub(crate) fn new(scene: &Scene, size: [u32; 2]) -> Outcome<Self> {
        let given = Given::new(scene, size)?;
        let (background, size) = (background(scene), size.map(|c| c as usize));
        Ok(Self {
            given,
            background,
            color: Buffer2d::new(size, background),
            depth: Buffer2d::new(size, 1.0),
        })
    }
}

pub(crate) fn draw_euc<P: euc::Pipeline<Vertex = u32>>(
    pipeline: &P,
    given: &Given,
    color: &mut Buffer2d<P::Pixel>,
    depth: &mut Buffer2d<f32>,
) {
    let corners = given.triangles.as_flattened();
    pipeline.draw::<Triangles<'_, _, BackfaceCullingDisabled>, _>(corners, color, Some(depth));
}

fn background(scene: &Scene) -> [u8; 4] {
    scene.background.map(|c| (c * 255.0 + 0.5) as u8)
}

struct Shaders<'g>(&'g Given);

/// Coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Place(pub(crate) [f32; 2]);

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
        (
            self.0.clip(position),
            Place(uv.map(|c| c * self.0.side as f32)),
        )
    }

    #[inline(always)]
    fn frag(&self, Place([u, v]): &Place) -> [u8; 4] {
        let side = self.0.side;
        let [x, y] = [u, v].map(|c| c.floor() as i32 as u32 & (side - 1));
        self.0.texels[(y * side + x) as usize]
    }
}

impl Racer for Euc {
    fn frame(&mut self) {
        self.color.clear(self.background);
        self.depth.clear(1.0);
        let given = &self.given;
        draw_euc(&Shaders(given), given, &mut self.color, &mut self.depth);
    }

    fn picture(&self) -> Vec<u8> {
        self.color.as_ref().as_flattened().to_vec()
    }
}

pub(crate) type RetrofireTarget = Framebuf<Colorbuf<Buf2<[u8; 4]>, Rgba8888>, Buf2<f32>>;

/// A mesh as retrofire takes it.
pub(crate) struct RetrofireMesh {
    given: Given,
    vertices: Vec<Vertex<[f32; 3], TexCoord>>,
    triangles: Vec<Tri<usize>>,
}

impl RetrofireMesh {
    pub(crate) fn new(given: Given) -> Self {
        let vertices = given.vertices.iter();
        let triangles = given.triangles.iter();
        Self {
            vertices: vertices
                .map(|(position, [u, v])| vertex(*position, uv(*u, *v)))
                .collect(),
            triangles: triangles
                .map(|t| tri(t[0] as usize, t[1] as usize, t[2] as usize))
                .collect(),
            given,
        }
    }

    /// A target of its picture's size. Depths are reciprocals of w: far away is 0.
    pub(crate) fn target(&self) -> RetrofireTarget {
        let [width, height] = self.given.size;
        Framebuf {
            color_buf: Colorbuf::new(Buf2::new(Dims(width, height))),
            depth_buf: Buf2::new(Dims(width, height)),
        }
    }

    pub(crate) fn draw(
        &self,
        target: &mut RetrofireTarget,
        fragment: impl Fn(Frag<TexCoord>) -> Color4,
    ) {
        let given = &self.given;
        let shader = shader::new(
            |v: Vertex<[f32; 3], TexCoord>, (): ()| {
                let clip: ProjVec3 = Vector::new(given.clip(v.pos));
                vertex(clip, v.attrib)
            },
            |frag: Frag<TexCoord>, (): ()| fragment(frag),
        );
        retrofire_core::render::render(
            &self.triangles,
            &self.vertices,
            &shader,
            (),
            viewport(pt2(0, given.size[1])..pt2(given.size[0], 0)),
            target,
            &Context {
                face_cull: None,
                ..Context::default()
            },
        );
    }
}

pub(crate) struct Retrofire {
    made: RetrofireMesh,
    background: [u8; 4],
    texture: Texture<Buf2<Color4>>,
    sampler: SamplerRepeatPot,
    target: RetrofireTarget,
}

impl Retrofire {
    pub(crate) fn new(scene: &Scene, size: [u32; 2]) -> Outcome<Self> {
        let given = Given::new(scene, size)?;
        let texels = given.texels.iter().map(|[r, g, b, a]| rgba(*r, *g, *b, *a));
        let texture = Texture::from(Buf2::new_from(Dims(given.side, given.side), texels));
        let made = RetrofireMesh::new(given);
        Ok(Self {
            sampler: SamplerRepeatPot::new(&texture),
            texture,
            background: background(scene),
            target: made.target(),
            made,
        })
    }
}

impl Racer for Retrofire {
    fn frame(&mut self) {
        self.target.color_buf.buf.fill(self.background);
        self.target.depth_buf.fill(0.0);
        let (sampler, texture) = (&self.sampler, &self.texture);
        self.made
            .draw(&mut self.target, |frag| sampler.sample(texture, frag.var));
    }

    fn picture(&self) -> Vec<u8> {
        self.target.color_buf.buf.data().as_flattened().to_vec()
    }
}
