//! llvmpipe's side of the chart's scenes.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "as in gl.rs: called with the one context, current on this thread"
)]

use glow::HasContext as _;
use texmap_benches::bench_scenes::{BenchMesh, Lookup, mip_chain};
use texmap_lab::scenes::UvImage;
use texmap_math::glam::DVec2;
use texmap_scene::Scene;

use crate::gl::{
    GpuMesh, TEXTURED, Target, VERTEX, context, levels, program_of, sampler, target,
    target_texture, upload,
};
use crate::registry::{Given, Outcome, Racer};

/// Coordinates as colours; alpha says that the pixel is covered.
const COORDINATES: &str = "#version 330 core
in vec2 t; out vec4 colour;
void main() { colour = vec4(t, 0.0, 1.0); }";

/// A context with targets of one size.
pub(crate) struct Peer {
    gl: glow::Context,
    /// `llvmpipe` and Mesa's version.
    pub(crate) name: String,
    textured: glow::Program,
    coordinates: glow::Program,
    bytes: Target,
    floats: Target,
    size: [u32; 2],
}

/// A scene of one mesh made ready.
pub(crate) struct Drawn<'p> {
    peer: &'p Peer,
    mesh: GpuMesh,
    matrix: [f32; 16],
    texture: glow::Texture,
    sampler: glow::Sampler,
}

impl Peer {
    pub(crate) fn open(size: [u32; 2]) -> Result<Self, String> {
        let gl = context()?;
        let [w, h] = size;
        let clears = glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT;
        unsafe {
            let renderer = gl.get_parameter_string(glow::RENDERER);
            let version = gl.get_parameter_string(glow::VERSION);
            if !renderer.contains("llvmpipe") {
                return Err(format!("this is {renderer}, not llvmpipe"));
            }
            // "4.5 (Core Profile) Mesa 22.3.6".
            let mut words = version.split_whitespace();
            let mesa = words.by_ref().any(|word| word == "Mesa");
            let number = words.next().filter(|_| mesa);
            let number = number.ok_or_else(|| format!("no version of Mesa in `{version}`"))?;
            let of = |format| {
                let color = target_texture(&gl, format, w, h, 1)?;
                let depth = target_texture(&gl, glow::DEPTH_COMPONENT24, w, h, 1)?;
                target(&gl, Some(color), Some(depth), 1, clears, (w, h))
            };
            Ok(Self {
                name: format!("llvmpipe {number}"),
                textured: program_of(&gl, VERTEX, TEXTURED)?,
                coordinates: program_of(&gl, VERTEX, COORDINATES)?,
                bytes: of(glow::RGBA8)?,
                floats: of(glow::RGBA32F)?,
                size,
                gl,
            })
        }
    }

    /// The scene's first mesh with its first texture, if it has any.
    pub(crate) fn scene(&self, scene: &Scene, lookup: Lookup) -> Outcome<Drawn<'_>> {
        let given = Given::new(scene, self.size)?;
        let rows = given.clip_from_object;
        let count = given.vertices.len();
        let mesh = BenchMesh {
            positions: given.vertices.iter().map(|v| v.0).collect(),
            uvs: given.vertices.iter().map(|v| v.1).collect(),
            normals: vec![[0.0; 3]; count],
            tangents: vec![[0.0; 3]; count],
            triangles: given.triangles,
        };
        unsafe {
            self.gl.active_texture(glow::TEXTURE0);
            let texture = self.gl.create_texture()?;
            self.gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            let chain = mip_chain(given.texels.into_flattened(), given.side);
            levels(
                &self.gl,
                (glow::TEXTURE_2D, glow::RGBA8),
                &chain,
                given.side,
            );
            Ok(Drawn {
                peer: self,
                mesh: upload(&self.gl, &mesh)?,
                // Column by column.
                matrix: core::array::from_fn(|i| rows[i % 4][i / 4]),
                texture,
                sampler: sampler(&self.gl, lookup)?,
            })
        }
    }
}

impl Drawn<'_> {
    unsafe fn draw(&self, program: glow::Program, target: &Target) {
        let gl = &self.peer.gl;
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(target.framebuffer));
            gl.viewport(0, 0, target.size.0 as i32, target.size.1 as i32);
            gl.enable(glow::DEPTH_TEST);
            gl.clear_color(0.0, 0.0, 0.0, 0.0);
            gl.clear(target.clears);
            gl.use_program(Some(program));
            let at = gl.get_uniform_location(program, "mvp");
            gl.uniform_matrix_4_f32_slice(at.as_ref(), false, &self.matrix);
            gl.bind_texture(glow::TEXTURE_2D, Some(self.texture));
            gl.bind_sampler(0, Some(self.sampler));
            gl.bind_vertex_array(Some(self.mesh.array));
            gl.draw_elements(glow::TRIANGLES, self.mesh.indices, glow::UNSIGNED_INT, 0);
            gl.finish();
        }
    }

    /// `bytes` of each pixel of the target that was drawn last, rows top to bottom.
    unsafe fn read(&self, target: &Target, kind: u32, bytes: usize) -> Vec<u8> {
        let (w, h) = target.size;
        let mut raw = vec![0; w as usize * h as usize * bytes];
        unsafe {
            let gl = &self.peer.gl;
            gl.bind_framebuffer(glow::READ_FRAMEBUFFER, Some(target.framebuffer));
            let into = glow::PixelPackData::Slice(Some(&mut raw));
            gl.read_pixels(0, 0, w as i32, h as i32, glow::RGBA, kind, into);
        }
        let rows = raw.chunks_exact(w as usize * bytes).rev();
        rows.flatten().copied().collect()
    }

    pub(crate) fn coordinates(&self) -> UvImage {
        let target = &self.peer.floats;
        let raw = unsafe {
            self.draw(self.peer.coordinates, target);
            self.read(target, glow::FLOAT, 16)
        };
        let pixels = raw.as_chunks::<4>().0.chunks_exact(4);
        pixels
            .map(|p| {
                let [u, v, _, alpha] = [0, 1, 2, 3].map(|k| f64::from(f32::from_ne_bytes(p[k])));
                (alpha > 0.5).then_some(DVec2::new(u, v))
            })
            .collect()
    }
}

impl Racer for Drawn<'_> {
    fn frame(&mut self) {
        unsafe { self.draw(self.peer.textured, &self.peer.bytes) }
    }

    fn picture(&self) -> Vec<u8> {
        unsafe { self.read(&self.peer.bytes, glow::UNSIGNED_BYTE, 4) }
    }
}
