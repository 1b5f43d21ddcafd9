//! Rays through volumes against closed forms: the law of Beer and Lambert, ramps of matter, transfer functions, rays that miss.

use crate::support::bilinear_clamped;
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, MAX_STEPS, OPAQUE, Origin, RayRadiance, SampleError, Sampler,
    TexelData, Texture2d, Texture3d, VolumeIntegrator,
};

fn grid(size: [u32; 3], values: &[f32]) -> Texture3d<'static> {
    let image = Image {
        width: size[0],
        height: size[1],
        channels: 1,
        texels: TexelData::F32(values),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    };
    Texture3d::new(size[2], &image).unwrap()
}

#[test]
fn homogeneous_matter_is_the_law_of_beer_and_lambert_for_every_step() {
    let (one, s) = (grid([1, 1, 1], &[1.0]), bilinear_clamped());
    for density in [0.0f32, 0.1, 1.0, 5.0] {
        for step in [1e-3f32, 0.01, 0.3, 1.0, 50.0] {
            let volume = VolumeIntegrator::new(&one, &s, None, density, step).unwrap();
            for (origin, direction, length) in [
                ([-2.0, 0.5, 0.5], [1.0, 0.0, 0.0], 1.0),
                ([0.5, 0.5, 3.0], [0.0, 0.0, -1.0], 1.0),
                ([0.25, 0.5, 0.5], [1.0, 0.0, 0.0], 0.75),
                (
                    [-1.0, -1.0, 0.5],
                    [0.5f64.sqrt(), 0.5f64.sqrt(), 0.0],
                    2f64.sqrt(),
                ),
                ([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0),
            ] {
                let [r, _, _, a] = volume
                    .integrate(origin, direction, (0.0, f64::INFINITY))
                    .color;
                let exact = 1.0 - (-f64::from(density) * length).exp();
                assert!(
                    (f64::from(a) - exact).abs() < 3e-5,
                    "{density} {step}: {a} {exact}"
                );
                assert!((r - a).abs() < 3e-5);
            }
        }
    }
}

#[test]
fn the_middle_of_a_step_is_exact_for_a_ramp_of_matter() {
    // Densities 0 to 1 over the middle of two voxels: the mean is a half.
    let (two, s) = (grid([2, 1, 1], &[0.0, 1.0]), bilinear_clamped());
    let volume = VolumeIntegrator::new(&two, &s, None, 3.0, 0.125).unwrap();
    let a = volume
        .integrate([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, 9.0))
        .color[3];
    assert!((f64::from(a) - (1.0 - (-1.5f64).exp())).abs() < 1e-5, "{a}");
    // Only what the span leaves.
    let a = volume
        .integrate([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, 1.25))
        .color[3];
    assert_eq!(a, 0.0);
}

#[test]
fn rays_that_miss_or_are_no_rays_see_nothing() {
    let (one, s) = (grid([1, 1, 1], &[1.0]), bilinear_clamped());
    let volume = VolumeIntegrator::new(&one, &s, None, 1.0, 0.1).unwrap();
    for (origin, direction) in [
        ([-1.0, 1.5, 0.5], [1.0, 0.0, 0.0]),
        ([-1.0, 0.5, -1e-9], [1.0, 0.0, 0.0]),
        ([2.0, 0.5, 0.5], [1.0, 0.0, 0.0]),
        ([0.5, 0.5, 0.5], [0.0, 0.0, 0.0]),
        ([f64::NAN, 0.5, 0.5], [1.0, 0.0, 0.0]),
        ([0.5, 0.5, 0.5], [f64::INFINITY, 0.0, 0.0]),
        ([1e30, 1e30, 1e30], [1e-30, 0.0, 0.0]),
    ] {
        let span = if direction == [0.0; 3] {
            (0.0, f64::INFINITY)
        } else {
            (0.0, 1e9)
        };
        assert_eq!(
            volume.integrate(origin, direction, span),
            RayRadiance::default(),
            "{origin:?} {direction:?}"
        );
    }
}

#[test]
fn a_dense_ray_ends_early_and_a_step_of_nothing_is_refused() {
    let (one, s) = (grid([1, 1, 1], &[1.0]), bilinear_clamped());
    let thick = VolumeIntegrator::new(&one, &s, None, 1000.0, 1e-3).unwrap();
    let seen = thick.integrate([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, 9.0));
    assert!(seen.steps < 12 && seen.color[3] > 1.0 - OPAQUE, "{seen:?}");
    let fine = VolumeIntegrator::new(&one, &s, None, 0.0, f32::MIN_POSITIVE).unwrap();
    assert_eq!(
        fine.integrate([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, 9.0))
            .steps,
        MAX_STEPS
    );
    for (density, step) in [
        (1.0, 0.0),
        (1.0, -1.0),
        (1.0, f32::NAN),
        (f32::NAN, 1.0),
        (-1.0, 1.0),
        (1.0, f32::INFINITY),
    ] {
        assert!(matches!(
            VolumeIntegrator::new(&one, &s, None, density, step),
            Err(SampleError::March { .. })
        ));
    }
}

#[test]
fn the_transfer_function_gives_colour_and_density() {
    let values: Vec<f32> = (0..8).map(|i| (i as f32 + 0.5) / 8.0).collect();
    let (row, s) = (grid([8, 1, 1], &values), bilinear_clamped());
    // Clear below a half, red above.
    let ramp = Texture2d::from_rgba8(
        2,
        1,
        [0, 0, 0, 0, 255, 0, 0, 255].to_vec(),
        ColorSpace::Linear,
        Origin::TopLeft,
    )
    .unwrap();
    let along = Sampler {
        filter: Filter::Nearest,
        ..bilinear_clamped()
    };
    let volume = VolumeIntegrator::new(&row, &s, Some((&ramp, &along)), 2.0, 1.0 / 64.0).unwrap();
    let [r, g, b, a] = volume
        .integrate([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], (0.0, 9.0))
        .color;
    assert!((f64::from(a) - (1.0 - (-1.0f64).exp())).abs() < 1e-5, "{a}");
    assert!((r - a).abs() < 1e-6 && g == 0.0 && b == 0.0);
}
