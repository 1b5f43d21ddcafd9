//! The tilted plane: error against a supersampled truth.

use std::sync::OnceLock;

use texmap_lab::plane::{Pattern, TiltedPlane, Truth, View};
use texmap_math::Footprint;
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

/// The default plane under a box pixel, which takes seconds: made once for all tests.
fn boxed() -> &'static (TiltedPlane, Vec<[f64; 3]>) {
    static BOXED: OnceLock<(TiltedPlane, Vec<[f64; 3]>)> = OnceLock::new();
    BOXED.get_or_init(|| {
        let scene = TiltedPlane::default();
        let truth = scene.truth(Truth::Box, 48);
        (scene, truth)
    })
}

fn assert_within(errors: [f64; 3], limits: [f64; 3]) {
    assert!(
        errors.iter().zip(limits).all(|(e, l)| *e <= l),
        "{errors:?} {limits:?}"
    );
}

#[test]
fn filters_reach_their_accuracy_on_the_tilted_plane() {
    let (scene, truth) = boxed();
    assert_eq!(scene.len(), 42_037);
    let exact = |filter| errors(scene, truth, filter, Precision::Exact);

    assert_within(exact(Filter::Anisotropic(16)), [0.0115, 0.0092, 0.0197]);
    // One rounded level a pixel costs some of it.
    let fast = errors(scene, truth, Filter::Anisotropic(16), Precision::Fast);
    assert_within(fast, [0.0144, 0.0102, 0.0232]);
    // The integer logarithm lies up to 0.043 levels low, which this truth likes.
    let trilinear = errors(scene, truth, Filter::Trilinear, Precision::Fast);
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

/// Probes are a texel apart if the short axis is below a texel, and leave room for the blur of bilinear filtering.
#[test]
fn probes_are_no_closer_than_a_texel() {
    let t = TiltedPlane::texture(Pattern::Noise);
    let s = Sampler {
        filter: Filter::Anisotropic(16),
        ..Sampler::default()
    };
    let texels = |major: f32, minor: f32| Footprint::new(major / 512.0, 0.0, 0.0, minor / 512.0);
    for (major, minor, want) in [
        (0.9, 0.01, 1),
        (2.9, 0.01, 3),
        (2.9, 1.0, 3),
        (2.9, 1.5, 3),
        (2.9, 1.6, 2),
        (40.0, 0.0, 16),
    ] {
        assert_eq!(s.probes(&t, texels(major, minor)), want, "{major} {minor}");
    }
    let near = TiltedPlane::new(View {
        turn: 0.3,
        magnify: 3.0,
    });
    let truth = near.truth(Truth::Box, 32);
    assert_within(
        errors(&near, &truth, Filter::Anisotropic(16), Precision::Exact),
        [0.0407, 0.0131, 0.0645],
    );
    let probes: u32 = near.footprints().map(|d| s.probes(&t, d)).sum();
    assert!(f64::from(probes) / near.len() as f64 <= 9.9);
}

/// A narrower Gaussian is nearer to a box pixel, on all patterns; at half the width it is that of a footprint half as large.
#[test]
fn the_width_of_an_ellipse_is_a_choice() {
    let (scene, truth) = boxed();
    let ewa = |percent| {
        let filter = Filter::Ewa { ratio: 16, percent };
        errors(scene, truth, filter, Precision::Exact)
    };
    let (wide, narrow) = (ewa(100), ewa(75));
    assert!(
        wide.iter().zip(narrow).all(|(w, n)| n < 0.7 * w),
        "{wide:?} {narrow:?}"
    );
    let t = TiltedPlane::texture(Pattern::Noise);
    let sampler = |percent| Sampler {
        filter: Filter::Ewa { ratio: 8, percent },
        ..Sampler::default()
    };
    let (uv, d) = ([0.3, 0.8], [0.011, 0.002, -0.003, 0.004]);
    let at = |percent, scale: f32| {
        let [a, b, c, e] = d.map(|d| d * scale);
        sampler(percent).sample_grad(&t, uv, Footprint::new(a, b, c, e))
    };
    assert_eq!(at(50, 1.0), at(100, 0.5));
    assert_eq!(at(200, 1.0), at(100, 2.0));
    assert_eq!(at(0, 1.0), at(25, 1.0));
    assert_ne!(at(75, 1.0), at(100, 1.0));
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
