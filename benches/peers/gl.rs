//! Mesa's software OpenGL, headless: EGL "surfaceless" and GL 3.3 core, loaded at run time; what scenes are made of.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the unsafe functions share one contract: they are called with the one context, current on its thread"
)]

use glow::HasContext as _;
use khronos_egl as egl;
use texmap_benches::bench_scenes::{BenchMesh, Lookup, mip_chain, mip_chain_srgb};
use texmap_scene::ColorMode;

const PLATFORM_SURFACELESS_MESA: egl::Enum = 0x31DD;
const TEXTURE_MAX_ANISOTROPY: u32 = 0x84FE;

pub(crate) const VERTEX: &str = "#version 330 core
uniform mat4 mvp; layout(location = 0) in vec3 position; layout(location = 1) in vec2 uv; out vec2 t;
void main() { gl_Position = mvp * vec4(position, 1.0); t = uv; }";
pub(crate) const TEXTURED: &str = "#version 330 core
uniform sampler2D image; in vec2 t; out vec4 colour;
void main() { colour = texture(image, t); }";

pub(crate) struct Target {
    pub(crate) framebuffer: glow::Framebuffer,
    pub(crate) clears: u32,
    pub(crate) size: (u32, u32),
}

pub(crate) struct GpuMesh {
    pub(crate) array: glow::VertexArray,
    pub(crate) indices: i32,
}

/// Opens Mesa; `Err` says what is missing on this machine.
pub(crate) fn context() -> Result<glow::Context, String> {
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

/// Format of colours in textures and targets.
pub(crate) fn format(color: ColorMode) -> u32 {
    match color {
        ColorMode::Raw => glow::RGBA8,
        ColorMode::Srgb => glow::SRGB8_ALPHA8,
    }
}

/// The mip chain of a picture of colours.
pub(crate) fn color_mips(color: ColorMode, texels: Vec<u8>, size: u32) -> Vec<Vec<u8>> {
    match color {
        ColorMode::Raw => mip_chain(texels, size),
        ColorMode::Srgb => mip_chain_srgb(texels, size),
    }
}

/// Uploads the mip chain of a texture or of a face of a cube.
pub(crate) unsafe fn levels(
    gl: &glow::Context,
    (target, format): (u32, u32),
    chain: &[Vec<u8>],
    size: u32,
) {
    for (level, texels) in chain.iter().enumerate() {
        let size = (size as i32 >> level).max(1);
        unsafe {
            gl.tex_image_2d(
                target,
                level as i32,
                format as i32,
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

pub(crate) unsafe fn sampler(gl: &glow::Context, lookup: Lookup) -> Result<glow::Sampler, String> {
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
            let (layout, kind) = match format {
                glow::RGBA8 | glow::SRGB8_ALPHA8 => (glow::RGBA, glow::UNSIGNED_BYTE),
                glow::RGBA32F => (glow::RGBA, glow::FLOAT),
                _ => (glow::DEPTH_COMPONENT, glow::UNSIGNED_INT),
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
