//! llvmpipe's side of the scenes under lighting effects: one shader a scene, everything per pixel.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the unsafe functions share one contract, stated in Llvmpipe::open"
)]

use std::cell::Cell;

use glow::HasContext as _;
use texmap_benches::bench_scenes::{
    BASE_SIZE, BenchScene, Content, DEPTH_SIZE, FACE_SIZE, GlMatrix, LIGHT, LIT_EYE, PROJECTOR,
    cube_face, light_matrix, lit_meshes, normal, slide, slide_matrix, turn,
};

use texmap_scene::ColorMode;

use crate::gl::{
    GpuMesh, Target, color_mips, format, levels, program_of, target, target_texture, upload,
};
use crate::metallic::Metallic;

/// Positions, normals and tangents in world space; the coordinates of map or projected picture.
pub(crate) const VERTEX: &str = "#version 330 core
uniform mat4 mvp, world, onto;
layout(location = 0) in vec3 position; layout(location = 1) in vec2 uv;
layout(location = 2) in vec3 normal; layout(location = 3) in vec3 tangent;
out vec3 P, N, T; out vec2 t; out vec4 C;
void main() {
  gl_Position = mvp * vec4(position, 1.0);
  vec4 p = world * vec4(position, 1.0);
  P = p.xyz; N = mat3(world) * normal; T = mat3(world) * tangent; t = uv; C = onto * p;
}";
const LIT: &str = "#version 330 core
uniform sampler2D base, bumps; uniform sampler2DShadow map; uniform vec3 light, eye;
in vec3 P, N, T; in vec2 t; in vec4 C; out vec4 colour;
void main() {
  vec3 n = normalize(N), a = normalize(T), b = cross(n, a);
  vec3 m = texture(bumps, t).xyz * 2.0 - 1.0;
  vec3 s = normalize(m.x * a + m.y * b + m.z * n);
  vec3 l = normalize(light - P), v = normalize(eye - P), h = normalize(l + v);
  float d = max(dot(s, l), 0.0);
  float p = max(dot(s, h), 0.0); p *= p; p *= p; p *= p; p *= p; p *= p;
  vec3 c = C.xyz / C.w; c.z -= 0.002;
  float sh = textureOffset(map, c, ivec2(-1, -1)) + textureOffset(map, c, ivec2(0, -1)) + textureOffset(map, c, ivec2(1, -1))
    + textureOffset(map, c, ivec2(-1, 0)) + texture(map, c) + textureOffset(map, c, ivec2(1, 0))
    + textureOffset(map, c, ivec2(-1, 1)) + textureOffset(map, c, ivec2(0, 1)) + textureOffset(map, c, ivec2(1, 1));
  sh *= 1.0 / 9.0;
  colour = vec4(texture(base, t).rgb * (0.15 + 0.85 * d * sh) + 0.4 * p * sh, 1.0);
}";
const MIRROR: &str = "#version 330 core
uniform samplerCube base; uniform vec3 eye;
in vec3 P, N; out vec4 colour;
void main() { colour = texture(base, reflect(normalize(P - eye), normalize(N))); }";
const PROJECTIVE: &str = "#version 330 core
uniform sampler2D base, bumps; uniform vec3 light;
in vec3 P, N; in vec2 t; in vec4 C; out vec4 colour;
void main() {
  vec3 p = texture(bumps, C.xy / C.w).rgb;
  float d = C.w > 0.0 ? max(dot(normalize(N), normalize(light - P)), 0.0) : 0.0;
  colour = vec4(texture(base, t).rgb * (0.3 + p * d), 1.0);
}";
const DEPTH: &str = "#version 330 core
void main() {}";

/// Programs, textures and meshes of these scenes.
pub(crate) struct Effects {
    lit: glow::Program,
    mirror: glow::Program,
    projective: glow::Program,
    depth: glow::Program,
    /// Base, normals, projected picture, cube, shadow map.
    textures: [glow::Texture; 5],
    /// Of projected picture and shadow map: clamped to the edge.
    clamped: glow::Sampler,
    compare: glow::Sampler,
    /// Of the cube: trilinear.
    cube: glow::Sampler,
    shadow: Target,
    /// The map has been drawn.
    has_map: Cell<bool>,
    meshes: [(GpuMesh, GlMatrix); 2],
    metallic: Metallic,
}

impl Effects {
    pub(crate) fn draws(content: Content) -> bool {
        matches!(
            content,
            Content::Lit { .. } | Content::Mirror | Content::Projective | Content::Metallic
        )
    }

    pub(crate) unsafe fn new(
        gl: &glow::Context,
        color: ColorMode,
        base: glow::Texture,
    ) -> Result<Self, String> {
        unsafe {
            let two = |color: ColorMode, texels: Vec<u8>, size: u32| {
                let texture = gl.create_texture()?;
                gl.bind_texture(glow::TEXTURE_2D, Some(texture));
                let chain = color_mips(color, texels, size);
                levels(gl, (glow::TEXTURE_2D, format(color)), &chain, size);
                Ok::<_, String>(texture)
            };
            let (normals, picture) = (
                two(ColorMode::Raw, normal(), BASE_SIZE)?,
                two(color, slide(), FACE_SIZE)?,
            );
            let cube = gl.create_texture()?;
            gl.bind_texture(glow::TEXTURE_CUBE_MAP, Some(cube));
            for face in 0..6 {
                let target = glow::TEXTURE_CUBE_MAP_POSITIVE_X + face;
                levels(
                    gl,
                    (target, format(color)),
                    &color_mips(color, cube_face(face), FACE_SIZE),
                    FACE_SIZE,
                );
            }
            gl.enable(glow::TEXTURE_CUBE_MAP_SEAMLESS);
            let map = target_texture(gl, glow::DEPTH_COMPONENT24, DEPTH_SIZE, DEPTH_SIZE, 1)?;
            let size = (DEPTH_SIZE, DEPTH_SIZE);
            let shadow = target(gl, None, Some(map), 1, glow::DEPTH_BUFFER_BIT, size)?;
            let sampler = |min: u32, mag: u32| {
                let sampler = gl.create_sampler()?;
                for (name, value) in [
                    (glow::TEXTURE_MIN_FILTER, min),
                    (glow::TEXTURE_MAG_FILTER, mag),
                    (glow::TEXTURE_WRAP_S, glow::CLAMP_TO_EDGE),
                    (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
                ] {
                    gl.sampler_parameter_i32(sampler, name, value as i32);
                }
                Ok::<_, String>(sampler)
            };
            let compare = sampler(glow::NEAREST, glow::NEAREST)?;
            let mode = glow::COMPARE_REF_TO_TEXTURE as i32;
            gl.sampler_parameter_i32(compare, glow::TEXTURE_COMPARE_MODE, mode);
            let less = glow::LEQUAL as i32;
            gl.sampler_parameter_i32(compare, glow::TEXTURE_COMPARE_FUNC, less);
            let [(ball, at), (ground, still)] = lit_meshes();
            Ok(Self {
                lit: program_of(gl, VERTEX, LIT)?,
                mirror: program_of(gl, VERTEX, MIRROR)?,
                projective: program_of(gl, VERTEX, PROJECTIVE)?,
                depth: program_of(gl, VERTEX, DEPTH)?,
                textures: [base, normals, picture, cube, map],
                clamped: sampler(glow::LINEAR, glow::LINEAR)?,
                compare,
                cube: sampler(glow::LINEAR_MIPMAP_LINEAR, glow::LINEAR)?,
                shadow,
                has_map: Cell::new(false),
                meshes: [(upload(gl, &ball)?, at), (upload(gl, &ground)?, still)],
                metallic: Metallic::new(gl, color)?,
            })
        }
    }

    /// Draws into `main`, which is bound and cleared.
    pub(crate) unsafe fn draw(
        &self,
        gl: &glow::Context,
        scene: &BenchScene,
        samplers: &[glow::Sampler; 4],
        main: &Target,
    ) {
        let [base, normals, picture, cube, map] = self.textures;
        let trilinear = samplers[2];
        let two = glow::TEXTURE_2D;
        unsafe {
            match scene.content {
                Content::Mirror => {
                    gl.use_program(Some(self.mirror));
                    bind(
                        gl,
                        self.mirror,
                        0,
                        "base",
                        (glow::TEXTURE_CUBE_MAP, cube),
                        self.cube,
                    );
                    vector(gl, self.mirror, "eye", [0.0, 0.0, 1.7344]);
                    let world = turn();
                    self.mesh(gl, self.mirror, scene.matrix(), &self.meshes[0].0, world);
                }
                Content::Metallic => {
                    let clamped = self.clamped;
                    let program = self.metallic.bind(gl, (base, trilinear), clamped);
                    vector(gl, program, "eye", [0.0, 0.0, 1.7344]);
                    self.mesh(gl, program, scene.matrix(), &self.meshes[0].0, turn());
                }
                Content::Projective => {
                    let program = self.projective;
                    gl.use_program(Some(program));
                    bind(gl, program, 0, "base", (two, base), trilinear);
                    bind(gl, program, 1, "bumps", (two, picture), self.clamped);
                    vector(gl, program, "light", PROJECTOR);
                    matrix(gl, program, "onto", slide_matrix());
                    for (mesh, world) in &self.meshes {
                        self.mesh(gl, program, scene.matrix().then_after(world), mesh, *world);
                    }
                }
                _ => {
                    // The first frame draws the map in any case.
                    if scene.content == (Content::Lit { shadow_pass: true })
                        || !self.has_map.replace(true)
                    {
                        self.draw_map(gl);
                        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(main.framebuffer));
                        gl.viewport(0, 0, main.size.0 as i32, main.size.1 as i32);
                    }
                    let program = self.lit;
                    gl.use_program(Some(program));
                    bind(gl, program, 0, "base", (two, base), trilinear);
                    bind(gl, program, 1, "bumps", (two, normals), trilinear);
                    bind(gl, program, 2, "map", (two, map), self.compare);
                    vector(gl, program, "light", LIGHT);
                    vector(gl, program, "eye", LIT_EYE);
                    matrix(
                        gl,
                        program,
                        "onto",
                        GlMatrix::bias().then_after(&light_matrix()),
                    );
                    for (mesh, world) in &self.meshes {
                        self.mesh(gl, program, scene.matrix().then_after(world), mesh, *world);
                    }
                }
            }
            gl.active_texture(glow::TEXTURE0);
            gl.bind_texture(two, Some(base));
        }
    }
    unsafe fn draw_map(&self, gl: &glow::Context) {
        let (ball, world) = &self.meshes[0];
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.shadow.framebuffer));
            gl.viewport(0, 0, DEPTH_SIZE as i32, DEPTH_SIZE as i32);
            gl.clear(self.shadow.clears);
            gl.use_program(Some(self.depth));
            let clip = light_matrix().then_after(world);
            self.mesh(gl, self.depth, clip, ball, *world);
        }
    }

    unsafe fn mesh(
        &self,
        gl: &glow::Context,
        program: glow::Program,
        clip: GlMatrix,
        mesh: &GpuMesh,
        world: GlMatrix,
    ) {
        unsafe {
            matrix(gl, program, "mvp", clip);
            matrix(gl, program, "world", world);
            gl.bind_vertex_array(Some(mesh.array));
            gl.draw_elements(glow::TRIANGLES, mesh.indices, glow::UNSIGNED_INT, 0);
        }
    }
}

pub(crate) unsafe fn bind(
    gl: &glow::Context,
    program: glow::Program,
    unit: u32,
    name: &str,
    (target, texture): (u32, glow::Texture),
    sampler: glow::Sampler,
) {
    unsafe {
        gl.active_texture(glow::TEXTURE0 + unit);
        gl.bind_texture(target, Some(texture));
        gl.bind_sampler(unit, Some(sampler));
        let at = gl.get_uniform_location(program, name);
        gl.uniform_1_i32(at.as_ref(), unit as i32);
    }
}

unsafe fn matrix(gl: &glow::Context, program: glow::Program, name: &str, GlMatrix(m): GlMatrix) {
    unsafe {
        let at = gl.get_uniform_location(program, name);
        gl.uniform_matrix_4_f32_slice(at.as_ref(), false, &m);
    }
}

pub(crate) unsafe fn vector(gl: &glow::Context, program: glow::Program, name: &str, v: [f64; 3]) {
    let [x, y, z] = v.map(|c| c as f32);
    unsafe {
        let at = gl.get_uniform_location(program, name);
        gl.uniform_3_f32(at.as_ref(), x, y, z);
    }
}
