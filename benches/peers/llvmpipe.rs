//! Mesa's software OpenGL, headless: EGL "surfaceless" and GL 3.3 core, loaded at run time.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the unsafe functions share one contract, stated in Llvmpipe::open"
)]

use glow::HasContext as _;
use khronos_egl as egl;
use texmap_lab::bench_scenes::{
    BASE_SIZE, BenchMesh, BenchScene, CLEAR, Content, DEPTH_SIZE, FLAT, GlMatrix, HEIGHT, Lookup,
    SCENES, WIDTH, base, mip_chain,
};

use crate::effects::Effects;

const PLATFORM_SURFACELESS_MESA: egl::Enum = 0x31DD;
const TEXTURE_MAX_ANISOTROPY: u32 = 0x84FE;

const VERTEX: &str = "#version 330 core
uniform mat4 mvp; layout(location = 0) in vec3 position; layout(location = 1) in vec2 uv; out vec2 t;
void main() { gl_Position = mvp * vec4(position, 1.0); t = uv; }";
const TEXTURED: &str = "#version 330 core
uniform sampler2D image; in vec2 t; out vec4 colour;
void main() { colour = texture(image, t); }";
const HALF_TEXTURED: &str = "#version 330 core
uniform sampler2D image; in vec2 t; out vec4 colour;
void main() { colour = vec4(texture(image, t).rgb, 0.5); }";
const CONSTANT: &str = "#version 330 core
uniform vec4 constant; out vec4 colour;
void main() { colour = constant; }";
const NOTHING: &str = "#version 330 core
void main() {}";

pub(crate) struct Target {
    pub(crate) framebuffer: glow::Framebuffer,
    pub(crate) clears: u32,
    pub(crate) size: (u32, u32),
}

pub(crate) struct GpuMesh {
    pub(crate) array: glow::VertexArray,
    pub(crate) indices: i32,
}

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
    /// What the scenes under lighting effects need, if there are any.
    effects: Option<Effects>,
}

impl Llvmpipe {
    /// Opens Mesa and uploads the textures and the meshes of the selected scenes.
    /// `Err` says what is missing on this machine.
    pub(crate) fn open(scenes: &[BenchScene]) -> Result<Self, String> {
        let gl = context()?;
        // SAFETY: the context is current on this thread for the life of the process; every object
        // is made by it, and every upload passes slices whose length matches the stated size.
        unsafe { Self::set_up(gl, scenes) }
    }

    unsafe fn set_up(gl: glow::Context, scenes: &[BenchScene]) -> Result<Self, String> {
        unsafe {
            let renderer = gl.get_parameter_string(glow::RENDERER);
            let version = gl.get_parameter_string(glow::VERSION);
            gl.active_texture(glow::TEXTURE0);
            let texture = gl.create_texture()?;
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            levels(
                &gl,
                glow::TEXTURE_2D,
                &mip_chain(base(), BASE_SIZE),
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
            let colour = target_texture(&gl, glow::RGBA8, WIDTH, HEIGHT, 1)?;
            let depth = target_texture(&gl, glow::DEPTH_COMPONENT24, WIDTH, HEIGHT, 1)?;
            let colour4 = target_texture(&gl, glow::RGBA8, WIDTH, HEIGHT, 4)?;
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
            peer.gl.clear_color(CLEAR[0], CLEAR[1], CLEAR[2], CLEAR[3]);
            let under_effects = |scene: &BenchScene| Effects::draws(scene.content);
            if scenes.iter().any(under_effects) {
                peer.effects = Some(Effects::new(&peer.gl, texture)?);
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

/// Every scene has a place in the table; used by `--list`.
pub(crate) fn scenes(only: Option<&str>) -> Vec<BenchScene> {
    let wanted = |key: &str| only.is_none_or(|o| o.split(':').any(|part| key.contains(part)));
    SCENES
        .iter()
        .copied()
        .filter(|s| wanted(&s.key()))
        .collect()
}

fn context() -> Result<glow::Context, String> {
    // SAFETY: loading libEGL runs its initialisers only; the symbols have EGL's documented types.
    let egl = unsafe { egl::DynamicInstance::<egl::EGL1_5>::load_required() }
        .map_err(|e| format!("libEGL 1.5 cannot be loaded ({e}); install Mesa's EGL"))?;
    // The instance must outlive the context: it holds the library open.
    let egl: &'static _ = Box::leak(Box::new(egl));
    // SAFETY: the surfaceless platform takes the default display and no attributes.
    let display = unsafe {
        egl.get_platform_display(
            PLATFORM_SURFACELESS_MESA,
            egl::DEFAULT_DISPLAY,
            &[egl::ATTRIB_NONE],
        )
    }
    .map_err(|e| format!("EGL has no surfaceless platform ({e})"))?;
    let why = |what: &'static str| move |e: egl::Error| format!("{what} failed: {e}");
    egl.initialize(display).map_err(why("eglInitialize"))?;
    egl.bind_api(egl::OPENGL_API).map_err(why("eglBindAPI"))?;
    let attributes = [
        egl::CONTEXT_MAJOR_VERSION,
        3,
        egl::CONTEXT_MINOR_VERSION,
        3,
        egl::CONTEXT_OPENGL_PROFILE_MASK,
        egl::CONTEXT_OPENGL_CORE_PROFILE_BIT,
        egl::NONE,
    ];
    // SAFETY: a null config is EGL_NO_CONFIG_KHR, which Mesa accepts without a surface.
    let none = unsafe { egl::Config::from_ptr(core::ptr::null_mut()) };
    let context = egl
        .create_context(display, none, None, &attributes)
        .map_err(why("a GL 3.3 core context"))?;
    egl.make_current(display, None, None, Some(context))
        .map_err(why("eglMakeCurrent"))?;
    // SAFETY: the loader answers with GL entry points of the current context.
    Ok(unsafe {
        glow::Context::from_loader_function(|name| {
            egl.get_proc_address(name)
                .map_or(core::ptr::null(), |f| f as *const core::ffi::c_void)
        })
    })
}

unsafe fn program(gl: &glow::Context, fragment: &str) -> Result<glow::Program, String> {
    unsafe { program_of(gl, VERTEX, fragment) }
}

pub(crate) unsafe fn program_of(
    gl: &glow::Context,
    vertex: &str,
    fragment: &str,
) -> Result<glow::Program, String> {
    unsafe {
        let program = gl.create_program()?;
        for (kind, source) in [
            (glow::VERTEX_SHADER, vertex),
            (glow::FRAGMENT_SHADER, fragment),
        ] {
            let shader = gl.create_shader(kind)?;
            gl.shader_source(shader, source);
            gl.compile_shader(shader);
            if !gl.get_shader_compile_status(shader) {
                return Err(gl.get_shader_info_log(shader));
            }
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        if gl.get_program_link_status(program) {
            Ok(program)
        } else {
            Err(gl.get_program_info_log(program))
        }
    }
}

/// Uploads the mip chain of a texture or of a face of a cube.
pub(crate) unsafe fn levels(gl: &glow::Context, target: u32, chain: &[Vec<u8>], size: u32) {
    for (level, texels) in chain.iter().enumerate() {
        let size = (size as i32 >> level).max(1);
        unsafe {
            gl.tex_image_2d(
                target,
                level as i32,
                glow::RGBA8 as i32,
                size,
                size,
                0,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                glow::PixelUnpackData::Slice(Some(texels)),
            );
        }
    }
}

unsafe fn sampler(gl: &glow::Context, lookup: Lookup) -> Result<glow::Sampler, String> {
    let (mag, min) = match lookup {
        Lookup::Bilinear => (glow::LINEAR, glow::LINEAR),
        Lookup::Trilinear | Lookup::Aniso16 => (glow::LINEAR, glow::LINEAR_MIPMAP_LINEAR),
        _ => (glow::NEAREST, glow::NEAREST),
    };
    unsafe {
        let sampler = gl.create_sampler()?;
        gl.sampler_parameter_i32(sampler, glow::TEXTURE_MAG_FILTER, mag as i32);
        gl.sampler_parameter_i32(sampler, glow::TEXTURE_MIN_FILTER, min as i32);
        gl.sampler_parameter_i32(sampler, glow::TEXTURE_WRAP_S, glow::REPEAT as i32);
        gl.sampler_parameter_i32(sampler, glow::TEXTURE_WRAP_T, glow::REPEAT as i32);
        if lookup == Lookup::Aniso16 {
            gl.sampler_parameter_f32(sampler, TEXTURE_MAX_ANISOTROPY, 16.0);
        }
        Ok(sampler)
    }
}

pub(crate) unsafe fn target_texture(
    gl: &glow::Context,
    format: u32,
    width: u32,
    height: u32,
    samples: i32,
) -> Result<glow::Texture, String> {
    let (w, h) = (width as i32, height as i32);
    unsafe {
        let texture = gl.create_texture()?;
        if samples > 1 {
            gl.bind_texture(glow::TEXTURE_2D_MULTISAMPLE, Some(texture));
            gl.tex_image_2d_multisample(
                glow::TEXTURE_2D_MULTISAMPLE,
                samples,
                format as i32,
                w,
                h,
                true,
            );
        } else {
            let (layout, kind) = if format == glow::RGBA8 {
                (glow::RGBA, glow::UNSIGNED_BYTE)
            } else {
                (glow::DEPTH_COMPONENT, glow::UNSIGNED_INT)
            };
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            let none = glow::PixelUnpackData::Slice(None);
            gl.tex_image_2d(
                glow::TEXTURE_2D,
                0,
                format as i32,
                w,
                h,
                0,
                layout,
                kind,
                none,
            );
            gl.tex_parameter_i32(glow::TEXTURE_2D, glow::TEXTURE_MAX_LEVEL, 0);
        }
        Ok(texture)
    }
}

pub(crate) unsafe fn target(
    gl: &glow::Context,
    colour: Option<glow::Texture>,
    depth: Option<glow::Texture>,
    samples: i32,
    clears: u32,
    size: (u32, u32),
) -> Result<Target, String> {
    let kind = if samples > 1 {
        glow::TEXTURE_2D_MULTISAMPLE
    } else {
        glow::TEXTURE_2D
    };
    unsafe {
        let framebuffer = gl.create_framebuffer()?;
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer));
        for (texture, place) in [
            (colour, glow::COLOR_ATTACHMENT0),
            (depth, glow::DEPTH_ATTACHMENT),
        ] {
            if texture.is_some() {
                gl.framebuffer_texture_2d(glow::FRAMEBUFFER, place, kind, texture, 0);
            }
        }
        if colour.is_none() {
            gl.draw_buffer(glow::NONE);
            gl.read_buffer(glow::NONE);
        }
        if gl.check_framebuffer_status(glow::FRAMEBUFFER) == glow::FRAMEBUFFER_COMPLETE {
            Ok(Target {
                framebuffer,
                clears,
                size,
            })
        } else {
            Err("a framebuffer of this format is not supported".to_owned())
        }
    }
}

pub(crate) unsafe fn upload(gl: &glow::Context, mesh: &BenchMesh) -> Result<GpuMesh, String> {
    // 44 bytes a vertex, as in the table: position, normal, uv, tangent.
    let mut bytes = Vec::with_capacity(mesh.positions.len() * 44);
    for i in 0..mesh.positions.len() {
        let parts: [&[f32]; 4] = [
            &mesh.positions[i],
            &mesh.normals[i],
            &mesh.uvs[i],
            &mesh.tangents[i],
        ];
        bytes.extend(parts.into_iter().flatten().flat_map(|f| f.to_ne_bytes()));
    }
    let indices: Vec<u8> = mesh
        .triangles
        .iter()
        .flatten()
        .flat_map(|i| i.to_ne_bytes())
        .collect();
    unsafe {
        let array = gl.create_vertex_array()?;
        gl.bind_vertex_array(Some(array));
        gl.bind_buffer(glow::ARRAY_BUFFER, Some(gl.create_buffer()?));
        gl.buffer_data_u8_slice(glow::ARRAY_BUFFER, &bytes, glow::STATIC_DRAW);
        gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(gl.create_buffer()?));
        gl.buffer_data_u8_slice(glow::ELEMENT_ARRAY_BUFFER, &indices, glow::STATIC_DRAW);
        gl.vertex_attrib_pointer_f32(0, 3, glow::FLOAT, false, 44, 0);
        gl.enable_vertex_attrib_array(0);
        gl.vertex_attrib_pointer_f32(1, 2, glow::FLOAT, false, 44, 24);
        gl.enable_vertex_attrib_array(1);
        gl.vertex_attrib_pointer_f32(2, 3, glow::FLOAT, false, 44, 12);
        gl.enable_vertex_attrib_array(2);
        gl.vertex_attrib_pointer_f32(3, 3, glow::FLOAT, false, 44, 32);
        gl.enable_vertex_attrib_array(3);
        Ok(GpuMesh {
            array,
            indices: mesh.triangles.len() as i32 * 3,
        })
    }
}
