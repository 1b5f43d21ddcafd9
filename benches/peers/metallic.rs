//! llvmpipe's side of `pbr`: metallic-roughness under an environment gathered by lobes and two lights, by texmap's formulas.
//!
//! The sources of the formulas stand in `texmap-light`. The shader reads texmap's own sums of the environment (three levels of roughness,
//! two of diffuse surfaces), its table of the split sum and its lobes, so that only look-ups and arithmetic differ.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the unsafe functions share one contract, stated in Llvmpipe::open"
)]

use glow::HasContext as _;
use texmap_benches::bench_scenes::{
    METALLIC, METALLIC_LIGHT, METALLIC_LIGHTS, METALLIC_SUN, ROUGHNESS, metallic_environment,
};
use texmap_light::reference::metallic_roughness::{GRAZING_MEAN, GRAZING_VARIANCE};
use texmap_light::{EnvironmentLayout, EnvironmentLight, ReflectionLobes, split_sum};
use texmap_math::glam::DVec2;
use texmap_scene::ColorMode;

use crate::effects::{VERTEX, bind, vector};
use crate::gl::program_of;

const FRAGMENT: &str = "#version 330 core
uniform sampler2D base, sums, lobes; uniform samplerCube diffuse, grazing, low, middle, high;
uniform vec3 light, sun, eye, color; uniform vec2 mean, slope, surface;
in vec3 P, N; in vec2 t; out vec4 colour;
float metal, rough, alpha, lost;
vec2 albedo(float c) { return texture(sums, (vec2(sqrt(c), rough) * 63.0 + 0.5) / 64.0).rg; }
float share(float f) { float a = f + (1.0 - f) / 21.0; return a * a * (1.0 - lost) / max(1.0 - a * lost, 0.01); }
vec3 n, v, f0, again, body; float nv, more, left;
vec3 lit(vec3 l) {
  float nl = dot(n, l);
  if (nl <= 0.0) return vec3(0.0);
  vec3 h = normalize(l + v), x = cross(n, h);
  float nh = dot(n, h), a2 = alpha * alpha;
  float f = clamp(1.0 - dot(v, h), 0.0, 1.0), f2 = f * f;
  float k = alpha / (dot(x, x) + nh * nh * a2);
  float lobe = 0.5 * k * k * nl / (nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2));
  vec2 q = albedo(min(nl, 1.0));
  float missing = 1.0 - q.x - q.y;
  vec3 c = (f0 + (1.0 - f0) * (f2 * f2 * f)) * lobe + again / max(lost, 0.01) * missing * nl;
  return c + body / left * ((1.0 - (0.04 * q.x + q.y + more * missing)) * nl);
}
void main() {
  metal = surface.x; rough = surface.y; alpha = rough * rough; lost = 1.0 - mean.x - mean.y;
  n = normalize(N); v = normalize(eye - P); nv = clamp(dot(n, v), 1e-4, 1.0);
  vec3 b = texture(base, t).rgb;
  vec2 s = albedo(nv);
  float missing = 1.0 - s.x - s.y;
  more = share(0.04);
  left = max(1.0 - (0.04 * mean.x + mean.y + more * lost), 0.01);
  body = b * (1.0 - metal) * (1.0 - (0.04 * s.x + s.y + more * missing));
  f0 = mix(vec3(0.04), b, metal);
  again = mix(vec3(more), vec3(share(b.r), share(b.g), share(b.b)), metal) * missing;
  vec3 even = textureLod(diffuse, n, 0.0).rgb, mirrored = reflect(-v, n), glossy = vec3(0.0);
  float whole = 1.0;
  for (int k = 0; k < 4; k++) {
    vec3 lobe = textureLod(lobes, vec2((sqrt(nv) * 63.0 + 0.5) / 64.0, (float(k) + 0.5) / 64.0), 0.0).rgb;
    vec3 way = mirrored + (n - mirrored) * lobe.x, near = textureLod(middle, way, 0.0).rgb;
    float level = lobe.y;
    vec3 light = level < 1.0 ? mix(textureLod(low, way, 0.0).rgb, near, level) : mix(near, textureLod(high, way, 0.0).rgb, level - 1.0);
    glossy += light * lobe.z;
    whole -= lobe.z;
  }
  glossy += even * whole;
  float rise = 0.04 * slope.x + slope.y - more * (slope.x + slope.y);
  vec3 under = even - (textureLod(grazing, n, 0.0).rgb - even) * (rise / left);
  vec3 c = under * body + even * again + glossy * (f0 * s.x + s.y);
  colour = vec4(c + color * (lit(normalize(light - P)) + lit(sun)), 1.0);
}";

/// Texels a side of the cubes.
const SIDE: usize = 128;
/// Steps of roughness and of the cosine's square root in the table of the split sum.
const STEPS: usize = 64;

/// The program and its textures: the sums of diffuse surfaces, those of three levels, the table of the split sum, the lobes.
pub(crate) struct Metallic {
    program: glow::Program,
    textures: [glow::Texture; 7],
}

impl Metallic {
    pub(crate) unsafe fn new(gl: &glow::Context, color: ColorMode) -> Result<Self, String> {
        let light = metallic_environment(color).ok_or("there is no environment")?;
        // The least roughness of a lobe is half of the surface's.
        let first = EnvironmentLight::level_of_roughness(0.5 * ROUGHNESS).floor();
        let level = |k: usize| EnvironmentLight::roughness_of_level(first as usize + k);
        unsafe {
            let program = program_of(gl, VERTEX, FRAGMENT)?;
            let cube = |radiance: &dyn Fn([f32; 3]) -> [f32; 3]| {
                let texture = gl.create_texture()?;
                gl.bind_texture(glow::TEXTURE_CUBE_MAP, Some(texture));
                for face in 0..6 {
                    let texels: Vec<f32> = (0..SIDE * SIDE)
                        .flat_map(|k| radiance(direction(face, k % SIDE, k / SIDE)))
                        .collect();
                    let target = glow::TEXTURE_CUBE_MAP_POSITIVE_X + face;
                    floats(gl, (target, glow::RGB16F, glow::RGB), SIDE, &texels);
                }
                gl.tex_parameter_i32(glow::TEXTURE_CUBE_MAP, glow::TEXTURE_MAX_LEVEL, 0);
                Ok::<_, String>(texture)
            };
            let textures = [
                cube(&|normal| light.irradiance(normal))?,
                cube(&|normal| light.grazing(normal))?,
                cube(&|way| light.radiance(level(0), way))?,
                cube(&|way| light.radiance(level(1), way))?,
                cube(&|way| light.radiance(level(2), way))?,
                gl.create_texture()?,
                gl.create_texture()?,
            ];
            gl.bind_texture(glow::TEXTURE_2D, Some(textures[5]));
            let at = |k: usize| k as f32 / (STEPS - 1) as f32;
            let table: Vec<f32> = (0..STEPS * STEPS)
                .flat_map(|k| split_sum(at(k / STEPS), at(k % STEPS).powi(2)))
                .collect();
            floats(gl, (glow::TEXTURE_2D, glow::RG16, glow::RG), STEPS, &table);
            gl.tex_parameter_i32(glow::TEXTURE_2D, glow::TEXTURE_MAX_LEVEL, 0);
            gl.bind_texture(glow::TEXTURE_2D, Some(textures[6]));
            let lobes: Vec<f32> = (0..STEPS * STEPS)
                .flat_map(|k| {
                    let seen = ReflectionLobes::new(ROUGHNESS, at(k % STEPS).powi(2));
                    let lobe = seen.lobes[(k / STEPS).min(3)];
                    let level = EnvironmentLight::level_of_roughness(lobe.roughness);
                    [lobe.lean, level - first, lobe.weight]
                })
                .collect();
            floats(
                gl,
                (glow::TEXTURE_2D, glow::RGB32F, glow::RGB),
                STEPS,
                &lobes,
            );
            gl.tex_parameter_i32(glow::TEXTURE_2D, glow::TEXTURE_MAX_LEVEL, 0);
            gl.use_program(Some(program));
            let pair = |name: &str, [x, y]: [f32; 2]| {
                let at = gl.get_uniform_location(program, name);
                gl.uniform_2_f32(at.as_ref(), x, y);
            };
            let [mean, slope] = hemisphere();
            pair("mean", mean);
            pair("slope", slope);
            pair("surface", [METALLIC, ROUGHNESS]);
            vector(gl, program, "light", METALLIC_LIGHT);
            vector(gl, program, "sun", METALLIC_SUN);
            vector(gl, program, "color", METALLIC_LIGHTS.map(f64::from));
            Ok(Self { program, textures })
        }
    }

    /// Makes program and textures current; the program.
    pub(crate) unsafe fn bind(
        &self,
        gl: &glow::Context,
        (base, trilinear): (glow::Texture, glow::Sampler),
        clamped: glow::Sampler,
    ) -> glow::Program {
        let (program, cube, two) = (self.program, glow::TEXTURE_CUBE_MAP, glow::TEXTURE_2D);
        let [diffuse, grazing, low, middle, high, sums, lobes] = self.textures;
        unsafe {
            gl.use_program(Some(program));
            bind(gl, program, 0, "base", (two, base), trilinear);
            bind(gl, program, 1, "sums", (two, sums), clamped);
            bind(gl, program, 2, "diffuse", (cube, diffuse), clamped);
            bind(gl, program, 3, "low", (cube, low), clamped);
            bind(gl, program, 4, "middle", (cube, middle), clamped);
            bind(gl, program, 5, "high", (cube, high), clamped);
            bind(gl, program, 6, "lobes", (two, lobes), clamped);
            bind(gl, program, 7, "grazing", (cube, grazing), clamped);
        }
        program
    }
}

/// The cosine-weighted mean of the split sum over a hemisphere, as [`split_sum`] has it for one cosine, and its slope by `(1 - c)^5`, times the
/// mean of that.
fn hemisphere() -> [[f32; 2]; 2] {
    const COUNT: u32 = 4096;
    let cosine = |k: u32| (f64::from(k) + 0.5) / f64::from(COUNT);
    let (mut mean, mut slope) = ([0.0; 2], [0.0; 2]);
    for c in (0..COUNT).map(cosine) {
        let off = ((1.0 - c).powi(5) - GRAZING_MEAN) / GRAZING_VARIANCE * GRAZING_MEAN;
        for (k, share) in split_sum(ROUGHNESS, c as f32).into_iter().enumerate() {
            let share = 2.0 * c * f64::from(share) / f64::from(COUNT);
            mean[k] += share;
            slope[k] += share * off;
        }
    }
    [mean, slope].map(|pair| pair.map(|s| s as f32))
}

/// The direction of the centre of a texel of a cube's face.
fn direction(face: u32, x: usize, y: usize) -> [f32; 3] {
    let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / SIDE as f64;
    let direction = EnvironmentLayout::Cube.direction(face as usize, at);
    direction.as_vec3().to_array()
}

/// Uploads a square of floats, packed texel by texel.
unsafe fn floats(
    gl: &glow::Context,
    (target, stored, layout): (u32, u32, u32),
    side: usize,
    texels: &[f32],
) {
    let bytes: Vec<u8> = texels.iter().flat_map(|f| f.to_ne_bytes()).collect();
    let (stored, side) = (stored as i32, side as i32);
    let data = glow::PixelUnpackData::Slice(Some(&bytes));
    unsafe {
        gl.tex_image_2d(target, 0, stored, side, side, 0, layout, glow::FLOAT, data);
    }
}
