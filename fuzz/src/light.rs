//! Light.

use texmap_light::{
    Environment, EnvironmentLayout, Light, LightCone, PhongMaterial, ShadowBias, ShadowKind,
    ShadowMap, illuminate, illuminate_slice, perturb,
};
use texmap_math::glam::{DMat4, DVec3};

use super::choices::Choices;

/// Surfaces under lights, environments and shadow maps of any numbers: nothing panics, slices are what points are, and what is made
/// of finite numbers stays finite.
pub fn light(bytes: &[u8]) {
    let mut c = Choices(bytes);
    let surface = PhongMaterial {
        color: c.tame(),
        ka: c.number(),
        kd: c.number(),
        ks: c.number(),
        ns: c.number(),
    };
    let lights: Vec<Light> = (0..c.below(5)).map(|_| light_of(&mut c)).collect();
    let points: Vec<[f32; 3]> = (0..c.below(9)).map(|_| c.numbers()).collect();
    let normals: Vec<[f32; 3]> = points.iter().map(|_| c.numbers()).collect();
    let eye = c.numbers();
    let mut out = vec![[0.0; 3]; points.len()];
    illuminate_slice(&surface, &lights, &points, &normals, eye, &mut out).expect("one length");
    for (i, out) in out.iter().enumerate() {
        let one = illuminate(&surface, &lights, points[i], normals[i], eye);
        assert_eq!(out.map(f32::to_bits), one.map(f32::to_bits));
        let map = c.numbers();
        let turned = perturb(normals[i], c.numbers(), map);
        assert!(
            turned.iter().all(|c| c.is_nan() || c.abs() <= 1.001),
            "{turned:?}"
        );
    }
    environment(&mut c);
    shadow(&mut c);
}

fn light_of(c: &mut Choices<'_>) -> Light {
    let color = c.tame();
    match c.below(5) {
        0 => Light::Ambient { color },
        1 => Light::Directional {
            color,
            direction: c.numbers(),
        },
        2 => Light::Point {
            color,
            position: c.numbers(),
        },
        3 => Light::Punctual {
            intensity: color,
            position: c.numbers(),
            range: c.number(),
            cone: (c.byte() > 99).then(|| LightCone {
                direction: c.numbers(),
                cos_inner: c.number(),
                cos_outer: c.number(),
            }),
        },
        _ => Light::spot(color, c.numbers(), c.numbers(), c.number(), c.number()),
    }
}

fn environment(c: &mut Choices<'_>) {
    let chart = c.of(&EnvironmentLayout::ALL);
    let height = c.below(6) as u32;
    let width = height * chart.aspect() + u32::from(c.byte() > 250);
    let count = (width * height) as usize * chart.faces();
    let texels: Vec<[f32; 3]> = (0..count).map(|_| c.tame()).collect();
    let sky = match Environment::from_texels(chart, (width, height), &texels) {
        Ok(sky) => sky,
        Err(refusal) => return assert!(!refusal.to_string().is_empty()),
    };
    let bound = texels.iter().flatten().fold(0.0f32, |m, c| m.max(c.abs()));
    let to = c.of(&EnvironmentLayout::ALL);
    let converted = sky
        .convert(to, 1 + c.below(5) as u32)
        .expect("a size in range");
    let gathered = sky
        .specular_map(to, 2, 1.0 + f32::from(c.byte()))
        .expect("an exponent in range");
    for sky in [sky.with_mips(), converted, gathered] {
        for _ in 0..4 {
            let direction = c.numbers();
            let light = sky.radiance(direction);
            assert!(
                light.iter().all(|c| c.abs() <= bound * 1.001),
                "{direction:?} {light:?}"
            );
        }
    }
}

fn shadow(c: &mut Choices<'_>) {
    let half = f64::from(c.number());
    let light_from_world = match c.byte() {
        0..128 => DMat4::IDENTITY,
        _ => DMat4::from_cols_array(&[0.0; 16].map(|_: f64| f64::from(c.number()))),
    };
    let kind = match c.below(3) {
        0 => ShadowKind::Directional {
            light_from_world,
            half,
        },
        1 => ShadowKind::Spot {
            light_from_world,
            tan_half: half,
        },
        _ => ShadowKind::Point {
            position: DVec3::from(c.numbers::<3>().map(f64::from)),
        },
    };
    let size = 1 + c.below(5) as u32;
    let faces = if matches!(kind, ShadowKind::Point { .. }) {
        6
    } else {
        1
    };
    let depths = (0..faces * size * size).map(|_| c.number()).collect();
    let Ok(map) = ShadowMap::new(kind, size, depths) else {
        return;
    };
    let bias = match c.below(3) {
        0 => ShadowBias::Constant(c.number().into()),
        1 => ShadowBias::Slope(c.number().into()),
        _ => ShadowBias::NormalOffset(c.number().into()),
    };
    for _ in 0..4 {
        let [point, normal] = [0, 1].map(|_| DVec3::from(c.numbers::<3>().map(f64::from)));
        let share = map.visibility(point, normal, bias, c.of(&[1, 3, 5]));
        assert!((0.0..=1.0).contains(&share), "{share}");
    }
}
