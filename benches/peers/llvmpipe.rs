//! llvmpipe's side of the race.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the unsafe functions share one contract, stated in Llvmpipe::open"
)]

use glow::HasContext as _;
use texmap_benches::bench_scenes::{
    BASE_SIZE, BenchScene, CLEAR, Content, DEPTH_SIZE, FLAT, GlMatrix, HEIGHT, Lookup, SCENES,
    WIDTH, base,
};

use texmap_math::color::srgb_to_linear;
use texmap_scene::ColorMode;

use crate::effects::Effects;
use crate::gl::{
    GpuMesh, TEXTURED, Target, VERTEX, color_mips, context, format, levels, program_of, sampler,
    target, target_texture, upload,
};

const HALF_TEXTURED: &str = "#version 330 core
uniform sampler2D image; in vec2 t; out vec4 colour;
void main() { colour = vec4(texture(image, t).rgb, 0.5); }";
const CONSTANT: &str = "#version 330 core
uniform vec4 constant; out vec4 colour;
void main() { colour = constant; }";
const NOTHING: &str = "#version 330 core
void main() {}";

/// One context with everything that the scenes need, uploaded once.
pub(crate) struct Llvmpipe {
    gl: glow::Context,
    pub(crate) renderer: String,
    pub(crate) version: String,
    samplers: [glow::Sampler; 4],
    textured: glow::Program,
    half: glow::Program,
    constant: glow::Program,
    depth_only: glow::Program,
    main: Target,
    no_depth: Target,
    multisampled: Target,
    shadow: Target,
    meshes: Vec<(Content, GpuMesh)>,
    /// Programs and textures of the scenes under lighting effects, if there are any.
    effects: Option<Effects>,
}

impl Llvmpipe {
    /// Opens Mesa and uploads the textures and the meshes of the selected scenes, whose colours are all of this mode.
    /// `Err` says what is missing on this machine.
    pub(crate) fn open(color: ColorMode, scenes: &[BenchScene]) -> Result<Self, String> {
        let gl = context()?;
        // SAFETY: the context is current on this thread for the life of the process; every object
        // is made by it, and every upload passes slices whose length matches the stated size.
        unsafe { Self::set_up(gl, color, scenes) }
    }

    unsafe fn set_up(
        gl: glow::Context,
        color: ColorMode,
        scenes: &[BenchScene],
    ) -> Result<Self, String> {
        unsafe {
            let renderer = gl.get_parameter_string(glow::RENDERER);
            let version = gl.get_parameter_string(glow::VERSION);
            gl.active_texture(glow::TEXTURE0);
            let texture = gl.create_texture()?;
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            levels(
                &gl,
                (glow::TEXTURE_2D, format(color)),
                &color_mips(color, base(), BASE_SIZE),
                BASE_SIZE,
            );
            let samplers = [
                Lookup::Nearest,
                Lookup::Bilinear,
                Lookup::Trilinear,
                Lookup::Aniso16,
            ]
            .map(|lookup| sampler(&gl, lookup));
            let [s0, s1, s2, s3] = samplers;
            let colour = target_texture(&gl, format(color), WIDTH, HEIGHT, 1)?;
            let depth = target_texture(&gl, glow::DEPTH_COMPONENT24, WIDTH, HEIGHT, 1)?;
            let colour4 = target_texture(&gl, format(color), WIDTH, HEIGHT, 4)?;
            let depth4 = target_texture(&gl, glow::DEPTH_COMPONENT24, WIDTH, HEIGHT, 4)?;
            let map = target_texture(&gl, glow::DEPTH_COMPONENT24, DEPTH_SIZE, DEPTH_SIZE, 1)?;
            let (both, size) = (
                glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT,
                (WIDTH, HEIGHT),
            );
            let mut peer = Self {
                renderer,
                version,
                samplers: [s0?, s1?, s2?, s3?],
                textured: program(&gl, TEXTURED)?,
                half: program(&gl, HALF_TEXTURED)?,
                constant: program(&gl, CONSTANT)?,
                depth_only: program(&gl, NOTHING)?,
                main: target(&gl, Some(colour), Some(depth), 1, both, size)?,
                no_depth: target(&gl, Some(colour), None, 1, glow::COLOR_BUFFER_BIT, size)?,
                multisampled: target(&gl, Some(colour4), Some(depth4), 4, both, size)?,
                shadow: target(
                    &gl,
                    None,
                    Some(map),
                    1,
                    glow::DEPTH_BUFFER_BIT,
                    (DEPTH_SIZE, DEPTH_SIZE),
                )?,
                meshes: Vec::new(),
                effects: None,
                gl,
            };
            peer.gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            let mut clear = CLEAR;
            if color == ColorMode::Srgb {
                peer.gl.enable(glow::FRAMEBUFFER_SRGB);
                // GL encodes it, texmap's background is encoded.
                let [r, g, b, a] = CLEAR;
                clear = [srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), a];
            }
            peer.gl.clear_color(clear[0], clear[1], clear[2], clear[3]);
            let under_effects = |scene: &BenchScene| Effects::draws(scene.content);
            if scenes.iter().any(under_effects) {
                peer.effects = Some(Effects::new(&peer.gl, color, texture)?);
            }
            for scene in scenes {
                let own = scene.content != Content::Clear && !under_effects(scene);
                if own && peer.mesh(scene).is_none() {
                    let mesh = upload(&peer.gl, &scene.mesh())?;
                    peer.meshes.push((scene.content, mesh));
                }
            }
            Ok(peer)
        }
    }

    /// Draws one frame and waits for its end.
    pub(crate) fn frame(&self, scene: &BenchScene) {
        // SAFETY: as in `open`.
        unsafe { self.draw(scene) }
    }

    unsafe fn draw(&self, scene: &BenchScene) {
        let gl = &self.gl;
        let target = self.target(scene);
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(target.framebuffer));
            gl.viewport(0, 0, target.size.0 as i32, target.size.1 as i32);
            gl.disable(glow::BLEND);
            gl.enable(glow::DEPTH_TEST);
            gl.depth_func(glow::LESS);
            gl.depth_mask(true);
            gl.disable(glow::CULL_FACE);
            gl.clear(target.clears);
            if let (Some(effects), true) = (&self.effects, Effects::draws(scene.content)) {
                gl.enable(glow::CULL_FACE);
                gl.cull_face(glow::BACK);
                gl.front_face(glow::CCW);
                effects.draw(gl, scene, &self.samplers, &self.main);
            }
            if let Some(mesh) = self.mesh(scene) {
                let mut program = self.textured;
                match scene.content {
                    Content::Layers { blend, depth } => {
                        if !depth {
                            gl.disable(glow::DEPTH_TEST);
                        }
                        if blend {
                            program = self.half;
                            gl.enable(glow::BLEND);
                            gl.blend_func(glow::SRC_ALPHA, glow::ONE_MINUS_SRC_ALPHA);
                        }
                    }
                    Content::Depth { .. } => program = self.depth_only,
                    _ => {}
                }
                if scene.lookup == Lookup::Flat {
                    program = self.constant;
                }
                if scene.culls_back_faces() {
                    gl.enable(glow::CULL_FACE);
                    gl.cull_face(glow::BACK);
                    gl.front_face(glow::CCW);
                }
                gl.use_program(Some(program));
                let GlMatrix(mvp) = scene.matrix();
                let mvp_at = gl.get_uniform_location(program, "mvp");
                gl.uniform_matrix_4_f32_slice(mvp_at.as_ref(), false, &mvp);
                let constant_at = gl.get_uniform_location(program, "constant");
                gl.uniform_4_f32_slice(constant_at.as_ref(), &FLAT);
                let sampler = match scene.lookup {
                    Lookup::None | Lookup::Flat | Lookup::Nearest => 0,
                    Lookup::Bilinear => 1,
                    Lookup::Trilinear => 2,
                    Lookup::Aniso16 => 3,
                };
                gl.bind_sampler(0, Some(self.samplers[sampler]));
                gl.bind_vertex_array(Some(mesh.array));
                gl.draw_elements(glow::TRIANGLES, mesh.indices, glow::UNSIGNED_INT, 0);
            }
            if matches!(scene.content, Content::Sphere { samples: 4, .. }) {
                let (w, h) = (WIDTH as i32, HEIGHT as i32);
                gl.bind_framebuffer(glow::DRAW_FRAMEBUFFER, Some(self.main.framebuffer));
                gl.blit_framebuffer(
                    0,
                    0,
                    w,
                    h,
                    0,
                    0,
                    w,
                    h,
                    glow::COLOR_BUFFER_BIT,
                    glow::NEAREST,
                );
            }
            gl.finish();
        }
    }

    /// The picture of the last frame of `scene`: RGB rows, top row first; for the depth scenes
    /// `round(depth * 65535)` as two bytes, high byte first, one pixel after another.
    pub(crate) fn picture(&self, scene: &BenchScene) -> Vec<u8> {
        let (w, h) = scene.size();
        let depth = matches!(scene.content, Content::Depth { .. });
        let framebuffer = if depth {
            self.shadow.framebuffer
        } else {
            self.main.framebuffer
        };
        let framebuffer = match scene.content {
            Content::Layers { depth: false, .. } => self.no_depth.framebuffer,
            _ => framebuffer,
        };
        let mut raw = vec![0; (w * h * if depth { 4 } else { 3 }) as usize];
        let (format, kind) = if depth {
            (glow::DEPTH_COMPONENT, glow::FLOAT)
        } else {
            (glow::RGB, glow::UNSIGNED_BYTE)
        };
        // SAFETY: `raw` holds width x height pixels of the stated format; rows are packed.
        unsafe {
            self.gl
                .bind_framebuffer(glow::READ_FRAMEBUFFER, Some(framebuffer));
            self.gl.pixel_store_i32(glow::PACK_ALIGNMENT, 1);
            let into = glow::PixelPackData::Slice(Some(&mut raw));
            self.gl
                .read_pixels(0, 0, w as i32, h as i32, format, kind, into);
        }
        let pixel = if depth { 4 } else { 3 };
        let rows = raw.chunks_exact(w as usize * pixel).rev();
        if !depth {
            return rows.flatten().copied().collect();
        }
        rows.flat_map(|row| row.chunks_exact(4))
            .flat_map(|d| {
                let d = f32::from_ne_bytes([d[0], d[1], d[2], d[3]]);
                ((d * 65535.0 + 0.5) as u16).to_be_bytes()
            })
            .collect()
    }

    fn mesh(&self, scene: &BenchScene) -> Option<&GpuMesh> {
        let same = |a: Content, b: Content| match (a, b) {
            (Content::Layers { .. }, Content::Layers { .. }) => true,
            (
                Content::Sphere { thousands: a, .. } | Content::Depth { thousands: a },
                Content::Sphere { thousands: b, .. } | Content::Depth { thousands: b },
            ) => a == b,
            (a, b) => a == b,
        };
        self.meshes
            .iter()
            .find(|(content, _)| same(*content, scene.content))
            .map(|(_, m)| m)
    }

    fn target(&self, scene: &BenchScene) -> &Target {
        match scene.content {
            Content::Depth { .. } => &self.shadow,
            Content::Sphere { samples: 4, .. } => &self.multisampled,
            Content::Layers { depth: false, .. } => &self.no_depth,
            _ => &self.main,
        }
    }
}

/// Every scene has a row in the table; used by `--list`.
pub(crate) fn scenes(only: Option<&str>) -> Vec<BenchScene> {
    let wanted = |key: &str| only.is_none_or(|o| o.split(':').any(|part| key.contains(part)));
    SCENES
        .iter()
        .copied()
        .filter(|s| wanted(&s.key()))
        .collect()
}

unsafe fn program(gl: &glow::Context, fragment: &str) -> Result<glow::Program, String> {
    unsafe { program_of(gl, VERTEX, fragment) }
}
