use super::*;
use crate::EnvironmentLayout;
use texmap_math::glam::DVec3;

fn wide(c: [f32; 3]) -> DVec3 {
    DVec3::from(c.map(f64::from))
}

/// A spiral of evenly spread directions.
fn spiral(n: usize) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |k| {
        let z = 1.0 - 2.0 * (k as f64 + 0.5) / n as f64;
        let (sin, cos) = deterministic_f64::sin_cos(k as f64 * 2.399_963_229_728_653);
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * cos, s * sin, z)
    })
}

fn narrow(d: DVec3) -> [f32; 3] {
    d.as_vec3().to_array()
}

/// A sky with a sun of some texels, a hundred thousand times as bright.
fn sunny() -> Environment {
    let sun = DVec3::new(0.4, 0.7, -0.3).normalize();
    Environment::from_fn(EnvironmentLayout::Cube, 128, |d| {
        let sky = 0.3 + 0.2 * d.y as f32;
        if d.dot(sun) > 0.9995 {
            [1e5; 3]
        } else {
            [sky, sky, 0.5]
        }
    })
    .unwrap()
}

/// Cosine-weighted mean of the environment's own texels over a hemisphere, by 4,096 rays or as many as texels.
fn irradiance(environment: &EnvironmentLight, normal: DVec3) -> f64 {
    let size = environment.size();
    let mut sum = 0.0;
    for face in 0..6 {
        for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
            let centre = |c: u32| (f64::from(c) + 0.5) / f64::from(size);
            let uv = texmap_math::glam::DVec2::new(centre(x), centre(y));
            let d = EnvironmentLayout::Cube.direction(face, uv);
            let c = d.dot(normal);
            if c > 0.0 {
                let angle = EnvironmentLayout::Cube.solid_angle(face, (x, y), (size, size));
                let light = environment.radiance(0.0, narrow(d))[0];
                sum += c * angle * f64::from(light);
            }
        }
    }
    sum / core::f64::consts::PI
}

/// The studio and a strong sun, which nine spherical harmonics miss by 6 % of its light.
#[test]
fn diffuse_light_is_within_two_percent_of_its_integral() {
    let studio = EnvironmentLight::studio();
    let sun = EnvironmentLight::new(&sunny(), 128).unwrap();
    for light in [studio, sun] {
        let source = &light;
        let most = spiral(24)
            .map(|n| irradiance(source, n))
            .fold(0.0, f64::max);
        for n in spiral(40) {
            let (got, right) = (
                f64::from(light.irradiance(narrow(n))[0]),
                irradiance(source, n),
            );
            assert!(
                (got - right).abs() < 0.02 * most,
                "{n}: {got} {right} of {most}"
            );
        }
    }
}

/// A sky of `1 + y` gives a diffuse surface 1 plus two thirds of its normal's y, and a quarter at grazing incidence.
#[test]
fn light_at_grazing_incidence_comes_from_beside_the_normal() {
    let sky = Environment::from_fn(EnvironmentLayout::Cube, 64, |d| [1.0 + d.y as f32; 3]);
    let light = EnvironmentLight::new(&sky.unwrap(), 64).unwrap();
    for n in spiral(30) {
        let (all, grazing) = (light.irradiance(narrow(n))[0], light.grazing(narrow(n))[0]);
        let off = |light: f32, part: f64| (f64::from(light) - (1.0 + part * n.y)).abs();
        assert!(
            off(all, 2.0 / 3.0) < 0.004 && off(grazing, 0.25) < 0.004,
            "{n}: {all} {grazing}"
        );
    }
}

/// The light that a lobe gathers of a sky with a closed form. A sky of `1 + y` gives 1 plus the mean cosine of the lobe.
#[test]
fn lobes_gather_more_of_the_sky_as_they_widen() {
    let sky = Environment::from_fn(EnvironmentLayout::Cube, 64, |d| [1.0 + d.y as f32; 3]);
    let light = EnvironmentLight::new(&sky.unwrap(), 64).unwrap();
    for roughness in [0.0f32, 0.1, 0.3, 0.55, 0.8, 1.0] {
        // The mean cosine of the lobe, by its density D(H) c.
        let a2 = f64::from(roughness.max(1e-3)).powi(4);
        let (mut mean, mut weights) = (0.0, 0.0);
        for k in 0..100_000 {
            let c = (f64::from(k) + 0.5) / 100_000.0;
            let q = (1.0 - c) + (1.0 + c) * a2;
            let weight = c / (q * q);
            mean += weight * c;
            weights += weight;
        }
        let mean = mean / weights;
        for d in spiral(30) {
            let got = f64::from(light.radiance(roughness, narrow(d))[0]);
            let right = 1.0 + mean * d.y;
            assert!((got - right).abs() < 0.01, "{roughness} {d}: {got} {right}");
        }
    }
}

#[test]
fn even_light_stays_even_and_broken_texels_count_as_dark() {
    let sky = Environment::from_fn(EnvironmentLayout::LatLong, 32, |_| [0.25, 2.0, f32::NAN]);
    let light = EnvironmentLight::new(&sky.unwrap(), 32).unwrap();
    for d in spiral(20) {
        for roughness in [0.0, 0.07, 0.5, 1.0, f32::NAN, 7.0] {
            let got = light.radiance(roughness, narrow(d));
            assert!(
                (got[0] - 0.25).abs() < 1e-5 && (got[1] - 2.0).abs() < 1e-5,
                "{got:?}"
            );
            assert_eq!(got[2], 0.0);
        }
        assert!((light.irradiance(narrow(d))[1] - 2.0).abs() < 1e-5);
    }
    assert!(EnvironmentLight::new(&sunny(), 8).is_err());
    assert!(
        light
            .radiance(0.5, [f32::NAN; 3])
            .iter()
            .all(|c| c.is_finite())
    );
}

#[test]
fn turns_are_about_the_vertical() {
    let red = Environment::from_fn(EnvironmentLayout::Cube, 16, |d| {
        [
            if d.x > 0.5 { 1.0 } else { 0.0 },
            0.5 + 0.5 * d.y as f32,
            0.0,
        ]
    });
    let light = EnvironmentLight::new(&red.unwrap(), 16).unwrap();
    let turned = light.clone().turned(core::f64::consts::FRAC_PI_2);
    let at = |light: &EnvironmentLight, d| wide(light.radiance(0.0, d));
    assert_eq!(at(&light, [1.0, 0.0, 0.0]).x, 1.0);
    assert!(at(&turned, [1.0, 0.0, 0.0]).x < 1e-6);
    assert!(at(&turned, [0.0, 0.0, -1.0]).x > 0.999);
    assert_eq!(at(&turned, [0.0, 1.0, 0.0]), at(&light, [0.0, 1.0, 0.0]));
    for angle in [f64::NAN, f64::INFINITY] {
        assert_eq!(light.clone().turned(angle), light);
    }
    // However short a direction is.
    for length in [1e-45, 1e-39, 1e-30] {
        let short = light.radiance(0.3, [length, 0.0, 0.0]);
        assert_eq!(short, light.radiance(0.3, [1.0, 0.0, 0.0]));
    }
}

/// The window is seen 0.115 by 0.143 radians large, so that a blur of 0.04 leaves erf(1.02) erf(1.27) = 0.79 of its middle.
#[test]
fn the_studio_is_a_bright_room() {
    let studio = EnvironmentLight::studio();
    assert_eq!((studio.size(), studio.levels()), (64, 12));
    let window = studio.radiance(0.0, narrow(DVec3::new(-14.0, 6.5, 8.0)));
    assert!((58.0..=66.0).contains(&window[0]), "{window:?}");
    assert_eq!(window[0], window[1]);
    let mut mean = 0.0;
    for d in spiral(4096) {
        mean += f64::from(studio.radiance(0.0, narrow(d))[0]) / 4096.0;
    }
    assert!((0.8..1.1).contains(&mean), "{mean}");
    let up = studio.irradiance([0.0, 1.0, 0.0])[0];
    let down = studio.irradiance([0.0, -1.0, 0.0])[0];
    assert!(up > 3.0 * down && down > 0.1, "{up} {down}");
    assert_eq!(studio, EnvironmentLight::studio());
}

/// Levels that are made have the bits of all levels together; those that are not made read as others, not as darkness.
#[test]
fn some_levels_are_those_of_all() {
    let all = EnvironmentLight::studio();
    let mut studio = Prefilter::studio();
    let wanted = Roughnesses::between(0.62, 0.62);
    let some = studio.light(wanted).unwrap();
    assert_eq!(
        (some.roughnesses(), all.roughnesses()),
        (wanted, Roughnesses::ALL)
    );
    assert_eq!((some.size(), some.levels()), (all.size(), all.levels()));
    assert!(some.rough.texels() < all.rough.texels() / 3);
    for d in spiral(50).map(narrow) {
        for roughness in [0.0, 0.6, 0.62, 0.655, 0.7] {
            assert_eq!(some.radiance(roughness, d), all.radiance(roughness, d));
        }
        assert_eq!(some.irradiance(d), all.irradiance(d));
        assert_eq!(some.radiance(0.2, d), all.radiance(0.6, d));
        assert_eq!(some.radiance(0.95, d), all.radiance(0.7, d));
    }
    // The rest is made later, and what is there is not made again.
    assert_eq!(studio.light(Roughnesses::ALL).unwrap(), all);
    let none = studio.light(Roughnesses::NONE).unwrap();
    assert_eq!(none.radiance(0.0, [1.0; 3]), all.radiance(0.0, [1.0; 3]));
}

#[test]
fn levels_are_added_to_light_of_the_same_environment_alone() {
    let all = EnvironmentLight::studio();
    let none = Prefilter::studio().light(Roughnesses::NONE).unwrap();
    let turned = none.turned(0.4).upright_on_z();
    let whole = turned.with_levels_of(&all);
    assert_eq!(whole, Some(all.clone().turned(0.4).upright_on_z()));
    let other = EnvironmentLight::new(&sunny(), 64).unwrap();
    assert_eq!(turned.with_levels_of(&other), None);
}
