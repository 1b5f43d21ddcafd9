//! Seven by seven spheres, from dielectric to metal and from smooth to rough, in the studio: against an integral over every texel of it
//! in f64.

use texmap_light::reference::metallic_roughness::Reflectance;
use texmap_light::{EnvironmentLayout, EnvironmentLight, MetallicRoughnessSurface, PhongMaterial};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_render::Aov;
use texmap_scene::{Effects, Material, Mesh, MetallicRoughness, Scene, ToneMapping};

use crate::scenes::{draw_aovs, pixel, values};

const COLOR: [f32; 3] = [0.9, 0.5, 0.2];
/// Pixels of a sphere's square.
const SIDE: u32 = 14;
/// Keeps most light below white.
const EXPOSURE: f32 = 0.5;

fn step(k: u32) -> f32 {
    k as f32 / 6.0
}

fn scene() -> Scene {
    let sphere = Mesh::sphere(96, 64);
    let (mut materials, mut meshes) = (Vec::new(), Vec::new());
    for k in 0..49 {
        materials.push(Material {
            phong: PhongMaterial {
                color: COLOR,
                ..PhongMaterial::default()
            },
            metallic_roughness: Some(MetallicRoughness {
                metallic: step(k / 7),
                roughness: step(k % 7),
                ..MetallicRoughness::default()
            }),
            ..Material::default()
        });
        let place = DVec3::new(f64::from(k % 7) - 3.0, 3.0 - f64::from(k / 7), 0.0);
        meshes.push(Mesh {
            world_from_object: DMat4::from_translation(place)
                * DMat4::from_scale(DVec3::splat(0.48)),
            material: k as usize,
            ..sphere.clone()
        });
    }
    Scene {
        materials,
        meshes,
        effects: Effects {
            environment_light: Some(EnvironmentLight::studio()),
            tone_mapping: ToneMapping {
                exposure: EXPOSURE,
                ..ToneMapping::default()
            },
            ..Effects::default()
        },
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, 0.0, 100.0),
            look: DVec3::ZERO,
            up: DVec3::Y,
            fov_x: 0.07,
            near: 1.0,
            far: 1000.0,
            lens: Default::default(),
        })
    }
}

/// Directions, radiances and solid angles of the studio.
fn texels(light: &EnvironmentLight) -> Vec<(DVec3, f64, f64)> {
    let size = light.size();
    let mut out = Vec::new();
    for face in 0..6 {
        for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
            let centre = |c: u32| (f64::from(c) + 0.5) / f64::from(size);
            let d = EnvironmentLayout::Cube.direction(face, DVec2::new(centre(x), centre(y)));
            let radiance = light.radiance(0.0, d.as_vec3().to_array())[0];
            let angle = EnvironmentLayout::Cube.solid_angle(face, (x, y), (size, size));
            out.push((d, f64::from(radiance), angle));
        }
    }
    out
}

/// Light of a byte of sRGB.
fn linear(byte: u8) -> f64 {
    f64::from(texmap_math::color::srgb_to_linear(f32::from(byte) / 255.0))
}

/// Root mean square errors of display light by row (metalness) and column (roughness), from some pixels of each sphere.
fn errors() -> Vec<[f64; 7]> {
    let scene = scene();
    let side = 7 * SIDE;
    let frame = draw_aovs(&scene, side, side, &[Aov::Normal, Aov::Position]);
    let light = scene.effects.environment_light.as_ref().unwrap();
    let texels = texels(light);
    let mut out = vec![[0.0; 7]; 7];
    for (k, error) in (0..49).map(|k| (k, ())) {
        let () = error;
        let (metallic, roughness) = (step(k / 7), step(k % 7));
        let surface =
            MetallicRoughnessSurface::new(texmap_math::simd::Scalar, COLOR, metallic, roughness);
        let reflectance = Reflectance::new(&surface);
        let (mut sum, mut count) = (0.0, 0);
        for (x, y) in (1..SIDE)
            .step_by(2)
            .flat_map(|x| (1..SIDE).step_by(2).map(move |y| (x, y)))
        {
            let (x, y) = (k % 7 * SIDE + x, k / 7 * SIDE + y);
            let vector = |aov| {
                let v = values(&frame, aov, x, y);
                DVec3::new(v[0].into(), v[1].into(), v[2].into())
            };
            if !vector(Aov::Position).is_finite() {
                continue;
            }
            let n = vector(Aov::Normal).normalize();
            let view = (scene.camera.eye - vector(Aov::Position)).normalize();
            let mut exact = DVec3::ZERO;
            for (d, radiance, angle) in &texels {
                let c = n.dot(*d);
                if c > 0.0 {
                    exact += reflectance.brdf(n, n, view, *d) * (radiance * angle * c);
                }
            }
            let got = pixel(&frame, x, y);
            for c in 0..3 {
                let exact = (exact[c] * f64::from(EXPOSURE)).min(1.0);
                sum += (linear(got[c]) - exact).powi(2);
                count += 1;
            }
        }
        assert!(count >= 90, "sphere {k}: {count} values");
        out[k as usize / 7][k as usize % 7] = (sum / f64::from(count)).sqrt();
    }
    out
}

/// Up to four lobes stand for that of a surface: they are off by most where it is as wide as the studio's windows. The two smoothest columns are
/// left out, whose lobes are narrower than the texels of the integral, and brighter than white.
#[test]
fn spheres_in_the_studio_are_near_the_integral() {
    let errors = errors();
    for (metallic, row) in errors.iter().enumerate() {
        for (roughness, limit) in [(2, 0.034), (3, 0.019), (4, 0.013), (5, 0.008), (6, 0.007)] {
            let error = row[roughness];
            assert!(
                error < limit,
                "{metallic} {roughness}: {error:.4}; all: {errors:.4?}"
            );
        }
    }
}
