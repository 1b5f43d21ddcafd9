//! Specular maps (MIT 6.837, Fall 2001, lecture 18, slide 30): highlights of area lights, gathered into an environment by an exponent.

use texmap_light::{Environment, EnvironmentLayout, Light};
use texmap_math::deterministic_f64::{pow, sin_cos};
use texmap_math::glam::DVec3;
use texmap_scene::{ColorMode, Reflection, Scene};

use super::lit::{Lit, ball, difference, matte};
use super::sheet::sheet;
use super::{Claim, DemoPicture, stage};
use crate::LabError;

/// Texels a side of the faces of an environment before it is gathered.
const TEXELS: u32 = 512;
/// Exponents of the panels and claims.
const EXPONENTS: [f32; 3] = [5.0, 20.0, 100.0];
/// Half the angle under which the round area light is seen, in degrees.
const AREA_LIGHT: f64 = 30.0;
/// That of the area light which stands for a point, and the exponent of its highlight.
const POINT: f64 = 3.0;
const SHARP: f32 = 20.0;
/// Light of the even sky: a whole code value, 153.
const EVEN: f32 = 0.6;

/// Unit direction to the round area light: above, to the right, on the viewer's side.
fn area_light() -> DVec3 {
    DVec3::new(0.5, 0.55, 0.67).normalize()
}

/// White within `degrees` of the area light's middle.
fn disc(degrees: f64, light: f32) -> impl Fn(DVec3) -> [f32; 3] + Sync {
    let (_, least) = sin_cos(degrees.to_radians());
    move |d| {
        [if d.normalize().dot(area_light()) >= least {
            light
        } else {
            0.0
        }; 3]
    }
}

/// The area lights of the panels: a round one, a window of four panes, a strip, a dim sky.
fn studio(d: DVec3) -> [f32; 3] {
    let [r, ..] = disc(18.0, 1.0)(d);
    let across = DVec3::new(-0.8, 0.35, 0.5).normalize();
    let (right, up) = (
        across.cross(DVec3::Y).normalize(),
        across.cross(DVec3::Y).normalize().cross(across),
    );
    let (along, x, y) = (d.dot(across), d.dot(right), d.dot(up));
    let pane = |c: f64| (0.04..0.34).contains(&(c / along).abs());
    if r > 0.0 {
        [1.0, 0.97, 0.9]
    } else if along > 0.0 && pane(x) && pane(y) {
        [0.55, 0.75, 1.0]
    } else if d.z > 0.0 && (d.y / d.z + 0.75).abs() < 0.08 && (d.x / d.z).abs() < 0.9 {
        [1.0, 0.6, 0.25]
    } else {
        [0.03, 0.035, 0.045]
    }
}

fn environment(light: impl Fn(DVec3) -> [f32; 3] + Sync) -> Result<Environment, LabError> {
    Ok(Environment::from_fn(
        EnvironmentLayout::Cube,
        TEXELS,
        light,
    )?)
}

/// The specular map of an environment, as `specmap` makes it.
fn gathered(environment: &Environment, exponent: f32) -> Result<Environment, LabError> {
    let size = Environment::blurred_size(exponent);
    Ok(environment.specular_map(EnvironmentLayout::Cube, size, exponent)?)
}

/// A dark ball in raw colours under an environment: mirrored, or as a specular map.
fn scene(environment: Environment, mirrors: bool) -> Scene {
    let mut scene = stage::scene(DVec3::new(0.0, 0.3, 4.2), DVec3::ZERO, 32.0);
    scene.color = ColorMode::Raw;
    let mut material = matte([0.0; 3], 1.0);
    match mirrors {
        true => {
            material.reflection = Some(Reflection {
                environment: 0,
                reflectivity: 1.0,
                within: None,
            });
        }
        false => material.specular_map = Some(0),
    }
    material.phong.ns = SHARP;
    let material = stage::add(&mut scene, material);
    scene.effects.environments.push(environment);
    scene.meshes.push(ball(DVec3::ZERO, 1.0, material));
    scene
}

/// The same ball in sRGB with a base colour and some light, for the panels.
fn shown(environment: Environment, mirrors: bool) -> Scene {
    let mut scene = scene(environment, mirrors);
    scene.color = ColorMode::Srgb;
    scene.background = [0.12, 0.13, 0.15, 1.0];
    scene.lights = stage::daylight(0.15, [0.25; 3], (-area_light()).as_vec3().to_array());
    scene.materials[0].phong.color = [0.25, 0.08, 0.07];
    // The highlights are those of the map alone.
    scene.materials[0].phong.ns = 1e6;
    scene
}

/// The light that the highlight of a round area light gathers in its middle: one less cos^(n + 1) of half its angle.
fn in_the_middle(exponent: f32) -> Result<Claim, LabError> {
    let n = f64::from(exponent);
    let map = gathered(&environment(disc(AREA_LIGHT, 1.0))?, exponent)?;
    let [found, ..] = map.radiance(area_light().as_vec3().to_array());
    let (sin, cos) = sin_cos(AREA_LIGHT.to_radians());
    // Weights of the lobe at the rim, and their slope.
    let scale = (n + 1.0) / std::f64::consts::TAU;
    let (weight, slope) = (scale * pow(cos, n), scale * n * pow(cos, n - 1.0) * sin);
    // Texels of the rim in the environment are in or out: each may be half of its area off. In the smaller cube that is gathered
    // they are means, spread by half a texel at most.
    let coarse = 2.0 / f64::from(Environment::blurred_size(exponent) * 3 / 2);
    let fine = 2.0 / f64::from(TEXELS);
    let rim = std::f64::consts::PI * sin * (fine * weight + 0.5 * coarse * coarse * slope);
    Ok(Claim::new(
        format!(
            "middle of an area light of {AREA_LIGHT} degrees, exponent {exponent}: 1 - cos^(n + 1)"
        ),
        f64::from(found),
        1.0 - pow(cos, n + 1.0),
        // The look-up is off by a hundredth of the range.
        0.01 + rim,
    ))
}

/// Largest difference of the codes of two shots on the ball.
fn worst(a: &Lit, b: &Lit) -> f64 {
    let on_ball = (0..a.position.len()).filter(|&i| a.position[i].is_finite());
    let largest = on_ball.map(|i| difference(&a.picture, &b.picture, i)).max();
    f64::from(largest.unwrap_or(255))
}

pub(super) fn specular_maps(size: u32) -> Result<DemoPicture, LabError> {
    let mut claims = Vec::new();
    for exponent in EXPONENTS {
        claims.push(in_the_middle(exponent)?);
    }
    let even = gathered(&environment(|_| [EVEN; 3])?, SHARP)?;
    let even = Lit::take(&scene(even, false), size)?;
    let off_even = |i: usize| even.picture.rgba()[4 * i].abs_diff((EVEN * 255.0) as u8);
    let on_ball = (0..even.position.len()).filter(|&i| even.position[i].is_finite());

    // An area light so small that it is a point, as bright in its middle as the highlight of a light.
    let small = environment(disc(POINT, 1.0))?;
    let peak = gathered(&small, SHARP)?;
    let [peak, ..] = peak.radiance(area_light().as_vec3().to_array());
    let small = environment(disc(POINT, 1.0 / peak))?;
    let map = gathered(&small, SHARP)?;
    let point = Lit::take(&scene(map, false), size)?;
    let mirrored = Lit::take(&scene(small.clone(), true), size)?;
    let mut phong = scene(small, false);
    phong.materials[0].specular_map = None;
    phong.lights = vec![Light::Directional {
        color: [1.0; 3],
        direction: (-area_light()).as_vec3().to_array(),
    }];
    let phong = Lit::take(&phong, size)?;
    // The mean of cos^n over a disc of radius a is off by n a^2 / 4 at most (its second derivatives are n each, the variance of a disc
    // a^2 / 4 an axis); a hundredth of the range by the look-up; one code by rounding.
    let radius = POINT.to_radians();
    let bound = 1.0 + 255.0 * (0.01 + f64::from(SHARP) * radius * radius / 4.0);
    claims.extend(claims! {
        "under an even sky: largest difference to its light on the ball, /255" =>
            f64::from(on_ball.map(off_even).max().unwrap_or(255)), 0.0, 0.0;
        format!("an area light of {POINT} degrees against Phong's highlight, exponent {SHARP}: largest difference, /255") =>
            worst(&point, &phong), 0.0, bound;
        "the area light mirrored, not gathered: the same, at least" => worst(&mirrored, &phong).min(100.0), 100.0, 0.0;
    });

    let sky = environment(studio)?;
    let mut panels = panels! {
        stage::photograph(&shown(sky.clone(), true), size)? =>
            "Mirrored", "The area lights in the environment as a mirror shows them.";
    };
    for exponent in EXPONENTS.iter().rev() {
        let map = gathered(&sky, *exponent)?;
        let (texels, _) = map.size();
        panels.extend(panels! {
            stage::photograph(&shown(map, false), size)? =>
                format!("Specular map, exponent {exponent}"),
                format!("Every direction gathers what its highlight sees: {texels} texels a side suffice.");
        });
    }
    Ok(sheet(
        "Specular maps: the highlights of area lights, one look-up each",
        panels,
        claims,
    ))
}
