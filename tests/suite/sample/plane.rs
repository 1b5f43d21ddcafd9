//! The tilted plane: error against a supersampled truth.

use texmap_lab::plane::{Pattern, TiltedPlane, Truth};
use texmap_sample::{Filter, Precision, Sampler};

fn errors(
    scene: &TiltedPlane,
    truth: &[[f64; 3]],
    filter: Filter,
    precision: Precision,
) -> [f64; 3] {
    let s = Sampler {
        filter,
        precision,
        ..Sampler::default()
    };
    Pattern::ALL.map(|pattern| scene.rmse(&s, &TiltedPlane::texture(pattern), truth, pattern))
}

fn assert_within(errors: [f64; 3], limits: [f64; 3]) {
    assert!(
        errors.iter().zip(limits).all(|(e, l)| *e <= l),
        "{errors:?} {limits:?}"
    );
}

#[test]
fn filters_reach_their_accuracy_on_the_tilted_plane() {
    let scene = TiltedPlane::default();
    assert_eq!(scene.len(), 42_037);
    let truth = scene.truth(Truth::Box, 48);
    let exact = |filter| errors(&scene, &truth, filter, Precision::Exact);

    assert_within(exact(Filter::Anisotropic(16)), [0.013, 0.014, 0.026]);
    // One rounded level a pixel costs some of it.
    let fast = errors(&scene, &truth, Filter::Anisotropic(16), Precision::Fast);
    assert_within(fast, [0.020, 0.016, 0.030]);
    // The integer logarithm lies up to 0.043 levels low, which this truth likes.
    let trilinear = errors(&scene, &truth, Filter::Trilinear, Precision::Fast);
    assert_within(trilinear, [0.0835, 0.0775, 0.0675]);
    assert_within(exact(Filter::Trilinear), [0.086, 0.079, 0.069]);
    // And a filter that ignores the footprint fails by far.
    assert!(exact(Filter::Bilinear)[0] > 0.2);

    let s = Sampler {
        filter: Filter::Anisotropic(16),
        ..Sampler::default()
    };
    let t = TiltedPlane::texture(Pattern::Noise);
    let probes: u32 = scene.footprints().map(|d| s.probes(&t, d)).sum();
    assert!(f64::from(probes) / scene.len() as f64 <= 5.0);
}

/// Against the Gaussian truth the order turns: EWA wins over box probes.
#[test]
fn ewa_wins_under_a_gaussian_pixel() {
    let scene = TiltedPlane::default();
    let truth = scene.truth(Truth::Gaussian, 48);
    let ewa = errors(&scene, &truth, Filter::ewa(16), Precision::Exact);
    let probes = errors(&scene, &truth, Filter::Anisotropic(16), Precision::Exact);
    assert_within(ewa, [0.036, 0.017, 0.018]);
    assert!(ewa.iter().zip(probes).all(|(e, p)| *e < p));
}
