//! Sums over lights.

mod slices;

pub use slices::{illuminate_slice, lighting_slice};

use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::lanes::Vector;
use crate::share::{
    LightContributionLanes, SpecularExponent, SpecularExponentLanes, evaluate_light,
};
use crate::vector::{dot, scale, splat, sub, unit};
use crate::{Light, Lighting, PhongMaterial, SpecularModel};

/// Light that reaches the eye from each point, split so that a texture can stand in for the colour:
/// `base colour * diffuse + highlight`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TermsLanes<I: Isa> {
    /// `sum ka La + sum kd max(0, N.L) Ll`: multiplies the base colour.
    pub diffuse: [I::F32; 3],
    /// `sum ks max(0, V.R)^ns Ll`: added in the light's colour.
    pub highlight: [I::F32; 3],
}

impl TermsLanes<Scalar> {
    /// The colour of a surface of this base colour, linear light, clipped at 1 per channel.
    #[must_use]
    pub fn color(&self, base: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| (base[k] * self.diffuse[k] + self.highlight[k]).below(1.0))
    }
}

impl<I: Isa> TermsLanes<I> {
    /// No light.
    #[inline(always)]
    pub fn dark(i: I) -> Self {
        let dark = splat(i, [0.0; 3]);
        Self {
            diffuse: dark,
            highlight: dark,
        }
    }

    /// Adds the contribution of a light in the lanes of `lit`, times its visibility `received`.
    #[inline(always)]
    pub fn add(&mut self, given: &LightContributionLanes<I>, lit: I::Mask, received: Vector<I>) {
        let (diffuse, highlight) = (&mut self.diffuse, &mut self.highlight);
        for k in 0..3 {
            let color = given.color[k] * received[k];
            diffuse[k] = lit.select(diffuse[k] + color * given.diffuse, diffuse[k]);
            highlight[k] = lit.select(highlight[k] + color * given.specular, highlight[k]);
        }
    }
}

/// The sum over all lights at the points of a block; `received` is asked for the lights that reach some of them, and in which lanes.
#[inline(always)]
fn sum_over_lights<I: Isa>(
    i: I,
    surface: &PhongMaterial,
    model: SpecularModel,
    lights: &[Light],
    point: Vector<I>,
    normal: Vector<I>,
    eye: [f32; 3],
    mut received: impl FnMut(usize, I::Mask) -> Vector<I>,
) -> TermsLanes<I> {
    let normal = unit(i, normal);
    let view = unit(i, sub(splat(i, eye), point));
    let power = SpecularExponentLanes::Same(SpecularExponent::new(surface.ns));
    let mut sum = TermsLanes::dark(i);
    for (index, light) in lights.iter().enumerate() {
        let given = evaluate_light(i, surface, power, model, light, point, normal, view);
        if given.lit.any_true() {
            let received = match light {
                Light::Ambient { .. } => splat(i, [1.0; 3]),
                _ => received(index, given.lit),
            };
            sum.add(&given, given.lit, received);
        }
    }
    sum
}

/// The two light terms at a point (the colour of `surface` is not read).
///
/// With N, L, V of unit length and `R = 2(N.L)N - L`:
/// `diffuse = sum_ambient ka La + sum kd max(0, N.L) Ll`, `highlight = sum ks max(0, V.R)^ns Ll`, where a
/// light behind the surface (`N.L <= 0`) gives neither. There is no attenuation. Source: MIT 6.837 (Fall
/// 2000), lecture 19, slides 20-22.
///
/// A zero or non-finite normal leaves the ambient light alone; a light or an eye that stands in the point
/// has no direction and gives nothing. Finite input of reasonable size (products within f32) gives finite
/// output; error against [`reference::lighting`](crate::reference::lighting) below 2e-5 for `ns <= 128` and
/// terms up to 1.
#[must_use]
pub fn lighting(
    surface: &PhongMaterial,
    lights: &[Light],
    point: [f32; 3],
    normal: [f32; 3],
    eye: [f32; 3],
) -> Lighting {
    shade_with_visibility(
        surface,
        SpecularModel::Phong,
        lights,
        point,
        normal,
        eye,
        |_| [1.0; 3],
    )
}

/// [`lighting`] with a choice of highlight and with the visibility of each light. `received(i)` is asked for light i (not for ambient
/// ones, nor for those behind the surface) and multiplies its colour, per channel: the fraction that a shadow leaves, the colour of a
/// projected picture. With ones everywhere the result has the bits of [`lighting`].
#[must_use]
pub fn shade_with_visibility(
    surface: &PhongMaterial,
    model: SpecularModel,
    lights: &[Light],
    point: [f32; 3],
    normal: [f32; 3],
    eye: [f32; 3],
    mut received: impl FnMut(usize) -> [f32; 3],
) -> Lighting {
    let received = |index, _| received(index);
    sum_over_lights(Scalar, surface, model, lights, point, normal, eye, received)
}

/// Colour of a surface at a point: [`lighting`] applied to its own colour, clipped at 1, linear light.
#[must_use]
pub fn illuminate(
    surface: &PhongMaterial,
    lights: &[Light],
    point: [f32; 3],
    normal: [f32; 3],
    eye: [f32; 3],
) -> [f32; 3] {
    lighting(surface, lights, point, normal, eye).color(surface.color)
}

/// As [`illuminate`], but the side that the eye sees is lit: a normal that points away from the eye is
/// turned round first. For flat faces; on smooth meshes turn the normal by the facing of the triangle, as
/// a vertex normal may point away although its triangle is seen.
#[must_use]
pub fn illuminate_two_sided(
    surface: &PhongMaterial,
    lights: &[Light],
    point: [f32; 3],
    normal: [f32; 3],
    eye: [f32; 3],
) -> [f32; 3] {
    let away = dot(normal, sub(eye, point)) < 0.0;
    illuminate(
        surface,
        lights,
        point,
        if away { scale(normal, -1.0) } else { normal },
        eye,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;
    use alloc::vec::Vec;
    use texmap_math::glam::DVec3;

    pub(super) const SURFACE: PhongMaterial = PhongMaterial {
        color: [0.5, 0.25, 0.75],
        ka: 0.5,
        kd: 0.6,
        ks: 0.4,
        ns: 20.0,
    };

    /// Deterministic numbers in -1..1.
    fn noise(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / 8_388_608.0 - 1.0
    }

    pub(super) fn vector(seed: &mut u32) -> [f32; 3] {
        [noise(seed), noise(seed), noise(seed)]
    }

    fn wide(a: [f32; 3]) -> DVec3 {
        DVec3::from(a.map(f64::from))
    }

    #[test]
    fn scalar_is_within_its_bound_of_the_reference() {
        let mut seed = 1;
        let mut worst = 0.0f64;
        for _ in 0..20_000 {
            let lights = [
                Light::Ambient {
                    color: [0.2, 0.1, 0.3],
                },
                Light::Directional {
                    color: [0.3, 0.4, 0.2],
                    direction: vector(&mut seed),
                },
                Light::Point {
                    color: [0.3, 0.2, 0.4],
                    position: vector(&mut seed).map(|x| x * 3.0),
                },
            ];
            let surface = PhongMaterial {
                ns: 64.0 + 64.0 * noise(&mut seed),
                ..SURFACE
            };
            let (point, normal) = (vector(&mut seed), vector(&mut seed));
            let eye = vector(&mut seed).map(|x| x * 5.0);
            let got = lighting(&surface, &lights, point, normal, eye);
            let (diffuse, highlight) =
                reference::lighting(&surface, &lights, wide(point), wide(normal), wide(eye));
            let error = (wide(got.diffuse) - diffuse)
                .abs()
                .max((wide(got.highlight) - highlight).abs());
            worst = worst.max(error.max_element());
        }
        assert!(worst < 2e-5, "{worst:e}");
        assert!(worst > 1e-9, "the comparison compares nothing");
    }

    #[test]
    fn the_highlight_takes_the_colour_of_the_light() {
        let light = [Light::Directional {
            color: [1.0, 0.5, 0.0],
            direction: [0.0, 0.0, -1.0],
        }];
        let t = lighting(&SURFACE, &light, [0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 9.0]);
        assert_eq!(t.highlight, [0.4, 0.2, 0.0]);
        assert_eq!(t.diffuse, [0.6, 0.3, 0.0]);
        // Twice as far: a point light is not attenuated.
        let near = [Light::Point {
            color: [1.0; 3],
            position: [0.0, 0.0, 2.0],
        }];
        let far = [Light::Point {
            color: [1.0; 3],
            position: [0.0, 0.0, 4.0],
        }];
        let shade = |lights: &[Light]| {
            illuminate(&SURFACE, lights, [0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 9.0])
        };
        assert_eq!(shade(&near), shade(&far));
    }

    #[test]
    fn spots_end_at_their_cones() {
        let spot = [Light::spot(
            [1.0; 3],
            [0.0, 0.0, 2.0],
            [0.0, 0.0, -3.0],
            0.3,
            0.6,
        )];
        let at = |x: f64| {
            let point = [x as f32, 0.0, 0.0];
            let got = lighting(&SURFACE, &spot, point, [0.0, 0.0, 1.0], [0.0, 0.0, 5.0]);
            let wide = |a: [f32; 3]| DVec3::from(a.map(f64::from));
            let (expected, _) = reference::lighting(
                &SURFACE,
                &spot,
                wide(point),
                DVec3::Z,
                DVec3::new(0.0, 0.0, 5.0),
            );
            assert!((wide(got.diffuse) - expected).length() < 2e-5, "{x}");
            f64::from(got.diffuse[0])
        };
        assert!((at(0.0) - 0.6).abs() < 1e-6 && at(2.0 * 0.61f64.tan()) == 0.0);
        // Inside of the inner cone a point light; between the cones less and less.
        let point = |angle: f64| 0.6 * angle.cos();
        assert!((at(2.0 * 0.29f64.tan()) - point(0.29)).abs() < 1e-6);
        let mut last = at(2.0 * 0.3f64.tan());
        for i in 1..=30 {
            let next = at(2.0 * (0.3 + 0.01 * f64::from(i)).tan());
            assert!(next < last || next == 0.0);
            last = next;
        }
        assert!(!Light::spot([1.0; 3], [0.0; 3], [0.0; 3], 0.1, 0.2).is_valid());
        assert!(!Light::spot([1.0; 3], [0.0; 3], [1.0; 3], 0.3, 0.2).is_valid());
        assert!(spot[0].is_valid());
    }

    /// Blinn's highlight with four times the exponent is Phong's near its middle, and it stays round at grazing angles.
    #[test]
    fn blinn_and_phong_agree_near_the_middle() {
        let light = [Light::Directional {
            color: [1.0; 3],
            direction: [0.0, 0.0, -1.0],
        }];
        let one = |model, ns, eye: [f32; 3]| {
            let surface = PhongMaterial { ns, ..SURFACE };
            let all = |_| [1.0; 3];
            shade_with_visibility(&surface, model, &light, [0.0; 3], [0.0, 0.0, 1.0], eye, all)
                .highlight[0]
        };
        for x in [0.0f32, 0.02, 0.05, 0.1] {
            let eye = [x, 0.0, 1.0];
            let (phong, blinn) = (
                one(SpecularModel::Phong, 20.0, eye),
                one(SpecularModel::Blinn, 80.0, eye),
            );
            assert!((phong - blinn).abs() < 2e-3, "{x}: {phong} {blinn}");
        }
        let grazing = [3.0, 0.0, 0.1];
        assert!(
            one(SpecularModel::Blinn, 4.0, grazing) > 2.0 * one(SpecularModel::Phong, 4.0, grazing)
        );
    }

    /// `received` is asked for each light alone, and ones change no bit.
    #[test]
    fn each_light_is_asked_what_reaches_the_point() {
        let lights = [
            Light::Ambient { color: [0.1; 3] },
            Light::Point {
                color: [1.0, 0.5, 0.25],
                position: [1.0, 2.0, 3.0],
            },
            Light::Point {
                color: [1.0; 3],
                position: [0.0, 0.0, -3.0],
            },
        ];
        let (normal, eye) = ([0.1, 0.2, 1.0], [0.0, 1.0, 4.0]);
        let mut asked = Vec::new();
        let half = shade_with_visibility(
            &SURFACE,
            SpecularModel::Phong,
            &lights,
            [0.0; 3],
            normal,
            eye,
            |i| {
                asked.push(i);
                [1.0, 0.0, 0.5]
            },
        );
        assert_eq!(asked, [1]);
        let whole = lighting(&SURFACE, &lights, [0.0; 3], normal, eye);
        let ambient = 0.1 * SURFACE.ka;
        assert_eq!(
            (half.diffuse[0], half.diffuse[1]),
            (whole.diffuse[0], ambient)
        );
        assert!((half.highlight[2] - 0.5 * whole.highlight[2]).abs() < 1e-7);
    }

    #[test]
    fn light_from_behind_gives_nothing_and_colours_clip_at_one() {
        let behind = [Light::Directional {
            color: [9.0; 3],
            direction: [0.0, 0.0, 1.0],
        }];
        let at =
            |lights: &[Light], eye| illuminate(&SURFACE, lights, [0.0; 3], [0.0, 0.0, 1.0], eye);
        assert_eq!(at(&behind, [0.0, 0.0, 5.0]), [0.0; 3]);
        let bright = [Light::Directional {
            color: [9.0; 3],
            direction: [0.0, 0.0, -1.0],
        }];
        assert_eq!(at(&bright, [0.0, 0.0, 5.0]), [1.0; 3]);
    }

    #[test]
    fn two_sided_lights_the_side_that_is_seen() {
        let light = [Light::Directional {
            color: [1.0; 3],
            direction: [0.0, 0.0, 1.0],
        }];
        let (normal, eye) = ([0.0, 0.0, 1.0], [1.0, 0.0, -5.0]);
        assert_eq!(
            illuminate(&SURFACE, &light, [0.0; 3], normal, eye),
            [0.0; 3]
        );
        let seen = illuminate_two_sided(&SURFACE, &light, [0.0; 3], normal, eye);
        assert_eq!(
            seen,
            illuminate(&SURFACE, &light, [0.0; 3], [0.0, 0.0, -1.0], eye)
        );
        assert!(seen[0] > 0.3);
    }

    #[test]
    fn degenerate_directions_are_not_nan() {
        let lights = [
            Light::Ambient { color: [0.5; 3] },
            Light::Point {
                color: [1.0; 3],
                position: [0.0; 3],
            },
            Light::Directional {
                color: [1.0; 3],
                direction: [0.0; 3],
            },
        ];
        let ambient = [0.125, 0.0625, 0.1875];
        let up = [0.0, 0.0, 1.0];
        assert_eq!(
            illuminate(&SURFACE, &lights, [0.0; 3], up, [0.0; 3]),
            ambient,
            "light and eye in the point"
        );
        for normal in [[0.0; 3], [f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(
                illuminate(&SURFACE, &lights, [1.0; 3], normal, [0.0; 3]),
                ambient,
                "{normal:?}"
            );
        }
    }
}
