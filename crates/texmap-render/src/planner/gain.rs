//! What a texel is multiplied by before it is stored: how much of a filter's error shows.

use texmap_light::Light;
use texmap_sample::Texture2d;

use super::IdleLight;
use crate::effects::SlideRole;
use crate::{Material, Mesh, Scene, Shading, TextureRole};

/// What multiplies texels, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Gain {
    /// Always this.
    Exactly([f32; 3]),
    /// Light of any strength up to this.
    UpTo([f32; 3]),
}

impl Gain {
    /// Of a mesh's base colour: its surface colour, and without more the sum of all lights that reach anything, each as if it shone
    /// straight at the surface.
    pub(super) fn of(scene: &Scene, mesh: &Mesh, material: &Material, idle: &[IdleLight]) -> Self {
        if material.texture_role == TextureRole::Decal {
            return Self::Exactly([1.0; 3]);
        }
        let color = material.surface.color;
        if material.shading == Shading::Unlit && mesh.colors.is_empty() {
            return Self::Exactly(color);
        }
        let light = if material.shading == Shading::Unlit {
            [1.0; 3]
        } else {
            light(scene, material, idle)
        };
        let vertex = |k: usize| mesh.colors.iter().map(|c| c[k]).reduce(f32::max);
        Self::UpTo([0, 1, 2].map(|k| color[k] * light[k] * vertex(k).unwrap_or(1.0)))
    }

    /// The factor under which two values of a channel, clamped to 1 after it, are stored farthest apart. With a strength of their
    /// own choice that is where the greater reaches 1: stored values rise ever slower, but x times their slope grows, so that up to
    /// there more light shows more and beyond it less. What is added to both, as highlights are, only brings them nearer.
    /// That holds for one sample a pixel: of several under light beyond white each is cut at 1 before their mean.
    pub(super) fn at(self, channel: usize, a: f32, b: f32) -> f32 {
        match self {
            Self::Exactly(gain) => gain[channel],
            Self::UpTo(gain) => gain[channel].min(1.0 / a.max(b).max(f32::MIN_POSITIVE)),
        }
    }
}

/// The most that lights can multiply a base colour by.
fn light(scene: &Scene, material: &Material, idle: &[IdleLight]) -> [f32; 3] {
    let surface = &material.surface;
    if let Some(ramp) = &material.light_ramp {
        return brightest(&scene.textures[ramp.texture]);
    }
    let mut sum = [0.0f32; 3];
    let mut add = |share: f32, color: [f32; 3]| {
        for (sum, c) in sum.iter_mut().zip(color) {
            *sum += (share * c).max(0.0);
        }
    };
    for (index, light) in scene.lights.iter().enumerate() {
        if idle.iter().any(|l| l.light == index) {
            continue;
        }
        match light {
            Light::Ambient { color } => add(surface.ka, *color),
            Light::Directional { color, .. }
            | Light::Point { color, .. }
            | Light::Spot { color, .. } => add(surface.kd, *color),
            _ => return [f32::INFINITY; 3],
        }
    }
    for slide in &scene.effects.projectors {
        if let SlideRole::Light(color) = slide.role {
            let picture = brightest(&scene.textures[slide.texture]);
            add(surface.kd, [0, 1, 2].map(|k| color[k] * picture[k]));
        }
    }
    if let Some(map) = &material.light_map {
        add(
            surface.kd * map.scale,
            brightest(&scene.textures[map.slot.texture]),
        );
    }
    sum
}

/// The greatest value of each channel in the picture itself.
fn brightest(texture: &Texture2d<'_>) -> [f32; 3] {
    let mut most = [0.0f32; 3];
    for (x, y) in (0..texture.height()).flat_map(|y| (0..texture.width()).map(move |x| (x, y))) {
        let texel = texture.texel(0, x, y).unwrap_or_default();
        most = [0, 1, 2].map(|k| most[k].max(texel[k]));
    }
    most
}

#[cfg(test)]
mod tests {
    use texmap_math::color::linear_to_srgb;

    use super::super::tests::scene;
    use super::*;

    #[test]
    fn no_light_up_to_the_gain_shows_more() {
        let stored = |c: f32, srgb: bool| {
            let c = c.clamp(0.0, 1.0);
            if srgb { linear_to_srgb(c) } else { c }
        };
        let values = [0.0, 1e-4, 0.003, 0.02, 0.2, 0.5, 0.9, 1.0];
        for (i, a) in values.into_iter().enumerate() {
            let gains = [0.3, 1.0, 2.5, 40.0];
            for (most, srgb) in gains.into_iter().flat_map(|m| [(m, false), (m, true)]) {
                for b in &values[..i] {
                    let apart = |gain: f32, more: f32| {
                        stored(a * gain + more, srgb) - stored(b * gain + more, srgb)
                    };
                    let worst = apart(Gain::UpTo([most; 3]).at(0, a, *b), 0.0);
                    for step in 0..=200u8 {
                        let gain = most * f32::from(step) / 200.0;
                        for more in [0.0, 0.01, 0.3] {
                            assert!(apart(gain, more) <= worst + 2e-6, "{a} {b} {gain} {more}");
                        }
                    }
                    // It is reached, and where light is strong it is more than without light.
                    if most == 40.0 && a < 0.5 {
                        assert!(worst > apart(1.0, 0.0), "{a} {b}");
                    }
                }
            }
        }
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
        material.surface.color = [0.5; 3];
        (material.surface.ka, material.surface.kd) = (0.2, 1.0);
        let of = |scene: &Scene, idle: &[IdleLight]| {
            Gain::of(scene, &scene.meshes[0], &scene.materials[0], idle)
        };
        let near = |gain: Gain, expected: [f32; 3]| match gain {
            Gain::UpTo(g) => g.iter().zip(expected).all(|(g, e)| (g - e).abs() < 1e-6),
            Gain::Exactly(_) => false,
        };
        assert!(near(of(&scene, &[]), [2.1, 4.1, 0.1]));
        let idle = IdleLight { light: 2, why: "" };
        assert!(near(of(&scene, &[idle]), [0.6, 1.1, 0.1]));
        scene.meshes[0].colors = vec![[0.5; 3], [2.0, 1.0, 0.0]];
        assert!(near(of(&scene, &[idle]), [1.2, 1.1, 0.05]));
        scene.meshes[0].colors.clear();
        scene.materials[0].shading = Shading::Unlit;
        assert_eq!(of(&scene, &[]), Gain::Exactly([0.5; 3]));
        scene.materials[0].texture_role = TextureRole::Decal;
        assert_eq!(of(&scene, &[]), Gain::Exactly([1.0; 3]));
    }
}
