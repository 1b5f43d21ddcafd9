//! Skies: a picture stretched over the frame, or an environment seen by direction.

use texmap_light::EnvironmentLight;
use texmap_math::glam::{DVec2, DVec3, DVec4};
use texmap_scene::{Background, Scene};

use super::color::{background, over, straight};
use super::environment::{EnvironmentMap, Ray};
use super::slot::{Place, Slot, Textures};
use super::world::display;
use crate::caster::Pinhole;

/// The most directions a side at which a sample looks an environment up.
const MOST: f64 = 8.0;

/// The background of a scene.
pub(super) struct SampledBackground<'s> {
    scene: &'s Scene,
    color: DVec4,
    /// The upper end of display light.
    limit: DVec3,
    sky: Option<Sky<'s>>,
}

enum Sky<'s> {
    Picture(Slot<'s>, DVec2),
    Environment(usize),
    Light(&'s EnvironmentLight),
}

impl<'s> SampledBackground<'s> {
    /// `size` is that of the frame in samples.
    pub(super) fn new(scene: &'s Scene, size: DVec2, textures: &mut Textures<'s>) -> Self {
        let sky = scene.effects.background.as_ref();
        let sky = sky.and_then(|sky| match sky {
            Background::Picture(slot) => {
                let slot = textures.slot(slot, texmap_sample::Origin::TopLeft);
                Some(Sky::Picture(slot, size))
            }
            Background::Environment(index) => Some(Sky::Environment(*index)),
            Background::EnvironmentLight => {
                scene.effects.environment_light.as_ref().map(Sky::Light)
            }
        });
        Self {
            scene,
            color: background(scene),
            limit: DVec3::splat(f64::from(scene.effects.tone_mapping.map.limit())),
            sky,
        }
    }

    /// True if the background is more than one colour.
    pub(super) fn has_sky(&self) -> bool {
        self.sky.is_some()
    }

    /// The colour behind a sample at (x, y) of the frame.
    pub(super) fn color(
        &self,
        environments: &[Option<EnvironmentMap>],
        pinhole: &Pinhole,
        x: f64,
        y: f64,
    ) -> DVec4 {
        match &self.sky {
            None => self.color,
            Some(Sky::Picture(slot, size)) => {
                let texel = slot.texel(Place {
                    uv: DVec2::new(x, y) / *size,
                    dx: DVec2::new(1.0 / size.x, 0.0),
                    dy: DVec2::new(0.0, 1.0 / size.y),
                });
                let color = straight(texel).min(self.limit) * texel.w;
                over(color.extend(texel.w), self.color)
            }
            Some(Sky::Environment(index)) => match &environments[*index] {
                Some(sphere) => {
                    let light = |direction| {
                        sphere.light(&Ray {
                            direction,
                            changes: [DVec3::ZERO; 2],
                        })
                    };
                    let seen = seen(light, sphere.texel_angle(), pinhole, x, y);
                    display(self.scene, seen).extend(1.0)
                }
                None => self.color,
            },
            Some(Sky::Light(sphere)) => {
                let light = |direction: DVec3| {
                    let narrow = direction.to_array().map(|x| x as f32);
                    DVec3::from(sphere.radiance(0.0, narrow).map(f64::from))
                };
                let side = f64::from(sphere.size());
                let texel = (4.0 * std::f64::consts::PI / (6.0 * side * side)).sqrt();
                let seen = seen(light, texel, pinhole, x, y);
                display(self.scene, seen).extend(1.0)
            }
        }
    }
}

/// The mean light over a sample: one look-up, or as many as it sees texels.
fn seen(light: impl Fn(DVec3) -> DVec3, texel: f64, pinhole: &Pinhole, x: f64, y: f64) -> DVec3 {
    let along = pinhole.direction(x, y).length();
    let step = pinhole.right.length().max(pinhole.down.length()) / along;
    let side = (step / texel).ceil().clamp(1.0, MOST);
    let offset = |k: u32| (f64::from(k) + 0.5) / side - 0.5;
    let side = side as u32;
    let of = |i: u32| light(pinhole.direction(x + offset(i % side), y + offset(i / side)));
    (0..side * side).map(of).sum::<DVec3>() / f64::from(side * side)
}
