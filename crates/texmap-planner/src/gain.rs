//! Gain: the operations on texels before they are stored, which decide how much of a filter's error shows.

use texmap_light::{Light, PhongMaterial};

use super::IdleLight;
use super::lights::distance;
use super::textures::Textures;
use texmap_math::wide;
use texmap_scene::{Material, Mesh, ProjectorMode, Scene, Shading, TextureRole};

/// Strengths of light beyond white that are tried. Each is this many times the one before it, up to where nothing but white is left.
const STEP: f32 = std::f32::consts::SQRT_2;
const STEPS: usize = 24;
/// Values below this count as black.
const DARKEST: f32 = 1e-6;

/// Factor of a texel, per channel; then light is added, and values beyond white are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Gain {
    /// Always this, and nothing added.
    Exactly([f32; 3]),
    /// Of any strength up to this.
    UpTo { light: [f32; 3], added: [f32; 3] },
}

impl Gain {
    /// The most that two pixels can be stored apart in a channel. Given are the texels at the samples of each and the light that
    /// comes through each of them.
    ///
    /// Each sample is cut at white before their mean. If none is cut, the strength that shows most is the greatest: stored values
    /// rise ever slower, but x times their slope grows; and light that is added to both only brings them nearer. Beyond white
    /// there is no such rule (half a pixel of white and half of black, under twice the light, stays as it is, while its mean
    /// turns white), so that strengths are tried from the first that cuts anything.
    pub(super) fn apart(
        self,
        channel: usize,
        [a, b]: [&[[f32; 4]]; 2],
        through: [f32; 2],
        store: impl Fn(f32) -> f64,
    ) -> f64 {
        let off = |gain: f32, more: f32| {
            let stored = |texels: &[[f32; 4]], through: f32| {
                let cut = |texel: &[f32; 4]| f64::from((texel[channel] * gain + more).min(1.0));
                let mean = texels.iter().map(cut).sum::<f64>() / texels.len() as f64;
                store(mean as f32 + through)
            };
            (stored(a, through[0]) - stored(b, through[1])).abs()
        };
        let (most, added) = match self {
            Self::Exactly(gain) => return off(gain[channel], 0.0),
            Self::UpTo { light, added } => (light[channel], added[channel].min(1.0)),
        };
        let values = || a.iter().chain(b).map(|texel| texel[channel]);
        let brightest = values().fold(DARKEST, f32::max);
        if most * brightest + added <= 1.0 {
            return off(most, 0.0);
        }
        // The strength that lifts a mean just to white tells it most from samples that are cut.
        let mean = |pixel: &[[f32; 4]]| {
            let sum: f32 = pixel.iter().map(|texel| texel[channel]).sum();
            (sum / pixel.len() as f32).max(DARKEST)
        };
        let means = [mean(a), mean(b)];
        let white = (1.0 - most * means[0]).clamp(0.0, added);
        let mut worst = 0.0f64;
        for more in [0.0, 0.5 * added, added, white] {
            for mean in means {
                worst = worst.max(off(most.min((1.0 - more) / mean), more));
            }
            let mut gain = most.min((1.0 - more) / brightest);
            for _ in 0..STEPS {
                worst = worst.max(off(gain, more));
                if gain >= most {
                    break;
                }
                gain = (gain * STEP).min(most);
            }
            if added == 0.0 {
                break;
            }
        }
        worst
    }
}

/// The lights of a scene that reach anything.
pub(super) struct Lighting<'s> {
    scene: &'s Scene,
    idle: &'s [IdleLight],
    pub(super) textures: Textures<'s>,
}

impl<'s> Lighting<'s> {
    pub(super) fn new(scene: &'s Scene, idle: &'s [IdleLight]) -> Self {
        Self {
            scene,
            idle,
            textures: Textures::new(&scene.textures),
        }
    }

    /// Of a mesh's base colour: its surface colour, and without more the sum of all lights that reach anything, each as if it shone
    /// straight at the surface and into the eye.
    pub(super) fn gain(&self, mesh: &Mesh, material: &Material) -> Gain {
        if material.texture_role == TextureRole::Decal {
            return match covered_light(self.scene, material) {
                false => Gain::Exactly([1.0; 3]),
                true => self.projected(&material.phong),
            };
        }
        let color = material.phong.color;
        let lit = material.shading != Shading::Unlit;
        if !lit && mesh.colors.is_empty() && material.emission.is_none() {
            return Gain::Exactly(color);
        }
        let (light, mut added) = if lit {
            self.most(mesh, material)
        } else {
            ([1.0; 3], [0.0; 3])
        };
        if let Some(emission) = &material.emission {
            let map = emission.map.as_ref();
            let picture = map.map_or([1.0; 3], |slot| self.textures.brightest(slot.texture));
            added = [0, 1, 2].map(|k| added[k] + emission.color[k] * picture[k]);
        }
        let vertex = |k: usize| mesh.colors.iter().map(|c| c[k]).reduce(f32::max);
        Gain::UpTo {
            light: [0, 1, 2].map(|k| color[k] * light[k] * vertex(k).unwrap_or(1.0)),
            added,
        }
    }

    /// The most that lights can multiply a base colour by, and the most that they add to it.
    fn most(&self, mesh: &Mesh, material: &Material) -> ([f32; 3], [f32; 3]) {
        let surface = &material.phong;
        if material.metallic_roughness.is_some() {
            // Roughness may gather any light; black stays black.
            return ([1e30; 3], [1.0; 3]);
        }
        if let Some(ramp) = &material.light_ramp {
            return (self.textures.brightest(ramp.texture), [0.0; 3]);
        }
        let (mut sum, mut added) = ([0.0f32; 3], [0.0f32; 3]);
        let lights = self.scene.lights.iter().enumerate();
        for (_, light) in lights.filter(|(i, _)| self.idle.iter().all(|l| l.light != *i)) {
            match light {
                Light::Ambient { color } if material.maps.ambient.is_some() => {
                    add(&mut added, surface.ka, *color);
                }
                Light::Ambient { color } => add(&mut sum, surface.ka, *color),
                Light::Directional { color, .. }
                | Light::Point { color, .. }
                | Light::Spot { color, .. } => {
                    add(&mut sum, surface.kd, *color);
                    add(&mut added, surface.ks, *color);
                }
                Light::Punctual {
                    intensity,
                    position,
                    ..
                } => {
                    let near = distance(mesh, wide(*position));
                    let share = 1.0 / (std::f64::consts::PI * (near * near).max(1e-12));
                    let color = intensity.map(|c| (f64::from(c) * share) as f32);
                    add(&mut sum, surface.kd, color);
                    add(&mut added, surface.ks, color);
                }
                _ => return ([f32::INFINITY; 3], [1.0; 3]),
            }
        }
        for color in self.projected_lights() {
            add(&mut sum, surface.kd, color);
            add(&mut added, surface.ks, color);
        }
        if let Some(map) = &material.light_map {
            let picture = self.textures.brightest(map.slot.texture);
            add(&mut sum, surface.kd * map.scale, picture);
        }
        if material.reflection.is_some() || material.specular_map.is_some() {
            added = [1.0; 3];
        }
        (sum, added)
    }

    /// Of texels that cover a surface of these numbers: themselves, and under the light of all projectors.
    fn projected(&self, surface: &PhongMaterial) -> Gain {
        let (mut light, mut added) = ([1.0; 3], [0.0; 3]);
        for color in self.projected_lights() {
            add(&mut light, surface.kd, color);
            add(&mut added, surface.ks, color);
        }
        Gain::UpTo { light, added }
    }

    /// The brightest light of each projector.
    fn projected_lights(&self) -> impl Iterator<Item = [f32; 3]> {
        let projectors = self.scene.effects.projectors.iter();
        projectors.filter_map(|projector| {
            let ProjectorMode::Light(color) = projector.mode else {
                return None;
            };
            let picture = self.textures.brightest(projector.texture);
            Some([0, 1, 2].map(|k| color[k] * picture[k]))
        })
    }
}

/// True if projectors light texels that cover a surface.
fn covered_light(scene: &Scene, material: &Material) -> bool {
    let mut projectors = scene.effects.projectors.iter();
    material.shading == Shading::PerPixel
        && projectors.any(|projector| projector.mode != ProjectorMode::Decal)
}

fn add(to: &mut [f32; 3], share: f32, color: [f32; 3]) {
    for (to, c) in to.iter_mut().zip(color) {
        *to += (share * c).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use texmap_math::color::linear_to_srgb;

    use super::super::tests::scene;
    use super::*;

    fn stored(c: f32, srgb: bool) -> f64 {
        let c = c.clamp(0.0, 1.0);
        f64::from(if srgb { linear_to_srgb(c) } else { c })
    }

    /// Far apart by every light of a fine grid up to the greatest.
    fn searched(most: f32, added: f32, a: &[f32], b: &[f32], srgb: bool) -> f64 {
        let pixel = |texels: &[f32], gain: f32, more: f32| {
            let sum: f32 = texels.iter().map(|t| (t * gain + more).min(1.0)).sum();
            stored(sum / texels.len() as f32, srgb)
        };
        let mut worst = 0.0f64;
        for step in 0..=400u16 {
            let gain = most * (f32::from(step) / 400.0).powi(2);
            for more in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|part| part * added) {
                worst = worst.max((pixel(a, gain, more) - pixel(b, gain, more)).abs());
            }
        }
        worst
    }

    fn apart(most: f32, added: f32, a: &[f32], b: &[f32], srgb: bool) -> f64 {
        let [a, b] = [a, b].map(|pixel| pixel.iter().map(|t| [*t; 4]).collect::<Vec<_>>());
        let gain = Gain::UpTo {
            light: [most; 3],
            added: [added; 3],
        };
        gain.apart(0, [&a, &b], [0.0; 2], |c| stored(c, srgb))
    }

    const VALUES: [f32; 7] = [0.0, 1e-4, 0.003, 0.05, 0.3, 0.7, 1.0];
    const MOST: [f32; 4] = [0.3, 1.0, 2.5, 40.0];

    #[test]
    fn no_light_up_to_the_gain_shows_more() {
        for (a, b) in VALUES
            .iter()
            .flat_map(|a| VALUES.iter().map(move |b| (*a, *b)))
        {
            for (most, srgb) in MOST.into_iter().flat_map(|m| [(m, false), (m, true)]) {
                let worst = apart(most, 0.0, &[a], &[b], srgb);
                for added in [0.0, 0.01, 0.3] {
                    let found = searched(most, added, &[a], &[b], srgb);
                    assert!(found <= worst + 2e-6, "{a} {b} {most} {added}");
                }
                // The worst difference is reached, and in strong light it is more than without light.
                let plain = (stored(a, srgb) - stored(b, srgb)).abs();
                if most == 40.0 && a.max(b) == 0.3 && a != b {
                    assert!(worst > plain, "{a} {b}");
                }
            }
        }
    }

    /// A pixel's samples cut one by one are not the cut of their mean.
    #[test]
    fn beyond_white_contrast_within_a_pixel_shows() {
        let mut least = 1.0f64;
        for (a, b) in VALUES
            .iter()
            .flat_map(|a| VALUES.iter().map(move |b| (*a, *b)))
        {
            let mean = (a + b) * 0.5;
            for (most, srgb) in MOST.into_iter().flat_map(|m| [(m, false), (m, true)]) {
                for added in [0.0f32, 0.1, 0.5, 2.0] {
                    for (x, y) in [([a, b], [mean; 2]), ([a, b], [a; 2]), ([a, b], [mean, a])] {
                        let found = searched(most, added.min(1.0), &x, &y, srgb);
                        let worst = apart(most, added, &x, &y, srgb);
                        if found > 1e-3 {
                            least = least.min(worst / found);
                        }
                    }
                }
            }
        }
        assert!(
            least > 0.85,
            "a light that was tried shows {least} of the most"
        );
        // Under twice the light a pixel half black and half white stays grey, its mean turns white.
        assert_eq!(apart(2.0, 0.0, &[0.0, 1.0], &[0.5, 0.5], false), 0.5);
        // Negative twin: under plain light they are one.
        assert_eq!(apart(1.0, 0.0, &[0.0, 1.0], &[0.5, 0.5], false), 0.0);
        // Highlights alone do it too.
        assert_eq!(apart(1.0, 0.5, &[0.0, 1.0], &[0.5, 0.5], false), 0.25);
        // Black stays black under any light.
        assert_eq!(apart(f32::INFINITY, 1.0, &[0.0], &[0.0], true), 0.0);
    }

    #[test]
    fn lights_add_up_and_what_ignores_them_does_not() {
        let mut scene = scene();
        let sun = |c: f32| Light::Directional {
            color: [c, 2.0 * c, 0.0],
            direction: [0.0, 0.0, -1.0],
        };
        scene.lights = vec![Light::Ambient { color: [1.0; 3] }, sun(1.0), sun(3.0)];
        let material = &mut scene.materials[0];
        material.phong.color = [0.5; 3];
        (material.phong.ka, material.phong.kd) = (0.2, 1.0);
        material.phong.ks = 0.25;
        let of = |scene: &Scene, idle: &[IdleLight]| {
            Lighting::new(scene, idle).gain(&scene.meshes[0], &scene.materials[0])
        };
        let near = |gain: Gain, expected: [[f32; 3]; 2]| match gain {
            Gain::UpTo { light, added } => {
                let off = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
                off(light, expected[0]) && off(added, expected[1])
            }
            Gain::Exactly(_) => false,
        };
        let [all, sun] = [[1.0, 2.0, 0.0], [0.25, 0.5, 0.0]];
        assert!(near(of(&scene, &[]), [[2.1, 4.1, 0.1], all]));
        let idle = IdleLight { light: 2, why: "" };
        assert!(near(of(&scene, &[idle]), [[0.6, 1.1, 0.1], sun]));
        scene.meshes[0].colors = vec![[0.5; 3], [2.0, 1.0, 0.0]];
        assert!(near(of(&scene, &[idle]), [[1.2, 1.1, 0.05], sun]));
        scene.materials[0].specular_map = Some(0);
        assert!(near(of(&scene, &[idle]), [[1.2, 1.1, 0.05], [1.0; 3]]));
        scene.meshes[0].colors.clear();
        scene.materials[0].shading = Shading::Unlit;
        assert_eq!(of(&scene, &[]), Gain::Exactly([0.5; 3]));
        scene.materials[0].emission = Some(texmap_scene::Emission {
            color: [0.25, 0.0, 3.0],
            map: None,
        });
        assert!(near(of(&scene, &[]), [[0.5; 3], [0.25, 0.0, 3.0]]));
        scene.materials[0].texture_role = TextureRole::Decal;
        assert_eq!(of(&scene, &[]), Gain::Exactly([1.0; 3]));
    }
}
